/* SPDX-License-Identifier: MIT */
/*
 * Clients of wires on TCP ports that go, or have to go, in virtual time: for how long each of them
 * still has its connection. The rig's end of it is in this process, too, and is counted. And what is
 * said of wires that others than this machine reach.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include <cmocka.h>

#include "descriptors.h"
#include "memory_file.h"
#include "stderr_heard.h"
#include "timer.h"
#include "virtual_rig.h"

#define COUPLER "[encoder e]\nmodel = ocd-ib-k3\nwire = modbus:127.0.0.1:0\n"
#define PORT "[encoder e]\nmodel = s3684-rs485\nwire = rs485:tcp:127.0.0.1:0\n"
#define PIECE 4096u
#define PIECES 16u /* 65536 bytes */

/* Read 4 input words, but by another protocol than Modbus: bytes 2 and 3 (Modbus/TCP, 3.1.3). */
static const uint8_t no_modbus[] = {0, 1, 0, 1, 0, 6, 0, 3, 0, 0, 0, 4};

struct bench {
    struct virtual_rig rig;
    uint8_t heard[64];
    size_t count;
};

static void keep_heard_bytes(void *ctx, const uint8_t *bytes, size_t n)
{
    struct bench *self = ctx;
    assert_true(self->count + n <= sizeof self->heard);
    memcpy(self->heard + self->count, bytes, n);
    self->count += n;
}

static struct bench *open_wire(const char *text)
{
    struct bench *self = calloc(1, sizeof *self);
    assert_non_null(self);
    self->rig.heard = keep_heard_bytes;
    self->rig.ctx = self;
    virtual_rig_open(&self->rig, memory_file_write((const uint8_t *)text, strlen(text)), NULL);
    virtual_rig_connect(&self->rig);
    return self;
}

static void close_wire(struct bench *self)
{
    virtual_rig_close(&self->rig);
    free(self);
}

/* The connection is there up to this moment from now on, and not any more then. */
static void stays_for(struct bench *self, dg_ns span)
{
    const unsigned open = descriptors_open();
    virtual_rig_pass(&self->rig, span - 1u);
    assert_int_equal(descriptors_open(), open);
    virtual_rig_pass(&self->rig, 1);
    assert_int_equal(descriptors_open(), open - 1u);
}

/* It hears that it is over, and has two seconds to go. */
static void who_is_sent_away_has_two_seconds(void **state)
{
    struct bench *self = open_wire(COUPLER);
    char byte = 0;
    (void)state;
    virtual_rig_say(&self->rig, no_modbus, sizeof no_modbus);
    assert_int_equal(recv(self->rig.line, &byte, 1, MSG_DONTWAIT), 0);
    stays_for(self, DG_S(2));
    assert_int_equal(self->count, 0);
    close_wire(self);
}

/* What it says meanwhile is thrown away, so that it hears of the end; but not without end. */
static void who_is_sent_away_may_finish_what_it_says(void **state)
{
    static const uint8_t flood[PIECE] = {0};
    struct bench *self = open_wire(COUPLER);
    (void)state;
    virtual_rig_say(&self->rig, no_modbus, sizeof no_modbus);
    const unsigned open = descriptors_open();
    for (unsigned i = 0; i < PIECES; i++) {
        virtual_rig_say(&self->rig, flood, sizeof flood);
    }
    assert_int_equal(descriptors_open(), open);
    virtual_rig_say(&self->rig, flood, 1);
    assert_int_equal(descriptors_open(), open - 1u);
    close_wire(self);
}

/* Who goes by itself is gone at once. */
static void who_goes_while_it_is_sent_away_is_gone(void **state)
{
    struct bench *self = open_wire(COUPLER);
    (void)state;
    virtual_rig_say(&self->rig, no_modbus, sizeof no_modbus);
    const unsigned open = descriptors_open();
    assert_int_equal(shutdown(self->rig.line, SHUT_WR), 0);
    virtual_rig_serve(&self->rig);
    assert_int_equal(descriptors_open(), open - 1u);
    close_wire(self);
}

/* A program that has sent its last request still hears the answer (README.md, 'Serial wires'). */
static void who_says_no_more_hears_for_two_seconds(void **state)
{
    static const uint8_t position[] = {0x40, 0x42, 0x02};
    struct bench *self = open_wire(PORT);
    (void)state;
    virtual_rig_pass(&self->rig, DG_S(1));
    virtual_rig_say(&self->rig, position, sizeof position);
    assert_int_equal(shutdown(self->rig.line, SHUT_WR), 0);
    virtual_rig_serve(&self->rig);
    stays_for(self, DG_S(2));
    assert_int_equal(self->count, 7);
    assert_memory_equal(self->heard, "\x40\x42", 2);
    close_wire(self);
}

/* --- who may come --- */

/* What is said while the rig is opened, without the numbers of ports. */
static void open_aloud(const char *rig, char *said, size_t size)
{
    static const struct lx_say loud = {.quiet = false};
    static const char any[] = "0.0.0.0:";
    struct lx_error error = {.right = ""};
    struct stderr_heard heard;
    struct dg_plan plan = {.file = NULL};
    struct lx_rig *opened = NULL;
    sd_event *event = NULL;
    const char *file = memory_file_write((const uint8_t *)rig, strlen(rig));
    assert_int_equal(lx_plan_read(&plan, file, &error), 0);
    assert_true(sd_event_new(&event) >= 0);
    const struct lx_rig_setup setup = {.event = event, .say = &loud, .plan = &plan};
    stderr_hear(&heard);
    const int result = lx_rig_open(&opened, &setup, lx_now(), &error);
    stderr_heard(&heard, said, size);
    assert_int_equal(result, LX_RIG_OK);
    assert_int_equal(lx_rig_close(opened, &error), 0);
    lx_plan_free(&plan);
    (void)sd_event_unref(event);
    char *port = strstr(said, any);
    if (port != NULL) {
        port += strlen(any);
        const size_t digits = strspn(port, "0123456789");
        memmove(port, port + digits, strlen(port + digits) + 1u);
    }
}

/* A rig runs without a control plane that nobody has asked for, and says so. */
static void wires_beyond_loopback_are_told(void **state)
{
    static const char alone[] =
        "drehgeber: no control plane: /dev/null/drehgeber: cannot make the folder: Not a "
        "directory; expected control = unix:PATH\n";
    static const struct {
        const char *rig;
        const char *says;
    } rows[] = {
        {COUPLER, ""},
        {"[encoder e]\nmodel = f3668\nwire = slcan:tcp:0.0.0.0:0,open\n",
         "drehgeber: slcan:0.0.0.0:: beyond loopback; every machine that reaches it is on this wire\n"},
        {"[encoder e]\nmodel = f3668\nwire = socketcand:0.0.0.0:0,can0,open\n",
         "drehgeber: socketcand:0.0.0.0:,can0: beyond loopback; every machine that reaches it is on this "
         "wire\n"},
        {"[encoder e]\nmodel = s3684-rs485\nwire = rs485:rfc2217:0.0.0.0:0,open\n",
         "drehgeber: rs485:rfc2217:0.0.0.0:: beyond loopback; every machine that reaches it is on this wire\n"},
        {"[encoder e]\nmodel = s3684-rs485\nwire = rs485:tcp:0.0.0.0:0,open\n",
         "drehgeber: rs485:tcp:0.0.0.0:: beyond loopback; every machine that reaches it is on this wire\n"},
        {"[encoder e]\nmodel = ocd-ib-k3\nwire = modbus:0.0.0.0:0,open\n",
         "drehgeber: modbus:0.0.0.0:: beyond loopback; every machine that reaches it writes to this ring, as "
         "with the real coupler\n"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        char said[512];
        char wanted[512];
        (void)snprintf(wanted, sizeof wanted, "%s%s", rows[i].says, alone);
        open_aloud(rows[i].rig, said, sizeof said);
        assert_string_equal(said, wanted);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_is_sent_away_has_two_seconds),
        cmocka_unit_test(who_is_sent_away_may_finish_what_it_says),
        cmocka_unit_test(who_goes_while_it_is_sent_away_is_gone),
        cmocka_unit_test(who_says_no_more_hears_for_two_seconds),
        cmocka_unit_test(wires_beyond_loopback_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

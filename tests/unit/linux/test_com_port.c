/* SPDX-License-Identifier: MIT */
/*
 * An RS485 encoder behind a TCP port, as its master sees it, in virtual time: each command of the
 * COM port (RFC 2217, chapter 3; telnet's are those of RFC 854), what a setting does to characters,
 * and when characters come.
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
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "hf_rig.h"
#include "memory_file.h"
#include "timer.h"
#include "virtual_rig.h"

/* 44 bits at 9600 Bd behind a request, and the reaction time (manual of the S36, 5.1.1.1). */
#define ANSWER (4583334u + DG_MS(1))
/* Longer than a request, its answer and all that could come behind it. */
#define REST DG_MS(100)
#define LINGER DG_S(2)

/* 42h at 7/16 of 65536 steps. */
#define REQUEST "40 42 02"
#define REPLY "40 42 00 00 70 00 72"

struct bench {
    struct virtual_rig rig;
    uint8_t heard[1024];
    size_t heard_count;
};

static void on_heard(void *ctx, const uint8_t *bytes, size_t n)
{
    struct bench *self = ctx;
    assert_true(self->heard_count + n <= sizeof self->heard);
    memcpy(self->heard + self->heard_count, bytes, n);
    self->heard_count += n;
}

static void open_port(struct bench *self, const char *prefix, const char *key)
{
    char text[512];
    const int n = snprintf(text, sizeof text,
                           "[bus line]\nwire = rs485\naddress = %s:127.0.0.1:0\n"
                           "[shaft main]\nmotion = 157.5DEG\n"
                           "[encoder a]\nmodel = s3684-rs485\nbus = line\nshaft = main\n%s\n",
                           prefix, key);
    assert_in_range(n, 1, sizeof text - 1);
    self->rig = (struct virtual_rig){.heard = on_heard, .ctx = self};
    virtual_rig_open(&self->rig, memory_file_write((const uint8_t *)text, (size_t)n), NULL);
    virtual_rig_connect(&self->rig);
    virtual_rig_pass(&self->rig, 2u * REST);
}

static int make_bench(void **state)
{
    *state = calloc(1, sizeof(struct bench));
    return *state == NULL ? -1 : 0;
}

static int end_bench(void **state)
{
    struct bench *self = *state;
    virtual_rig_close(&self->rig);
    free(self);
    return 0;
}

static void say_hex(struct bench *self, const char *hex)
{
    uint8_t bytes[64];
    virtual_rig_say(&self->rig, bytes, hf_rig_hex(hex, bytes, sizeof bytes));
}

/* This was heard since the last time, and nothing else. */
static void expect_heard(struct bench *self, const char *said, const char *hex)
{
    uint8_t right[256];
    const size_t n = hf_rig_hex(hex, right, sizeof right);
    if (n != self->heard_count || memcmp(self->heard, right, n) != 0) {
        fail_msg("%s: %zu bytes, %02X %02X %02X %02X, for %s", said, self->heard_count,
                 self->heard[0], self->heard[1], self->heard[2], self->heard[3], hex);
    }
    self->heard_count = 0;
}

/* A command of the COM port and its answer, both without FF FA 2C before and FF F0 behind. */
static void expect_answer(struct bench *self, const char *command, const char *answer)
{
    char said[128];
    char heard[128] = "";
    (void)snprintf(said, sizeof said, "FFFA2C %s FFF0", command);
    if (answer != NULL) {
        (void)snprintf(heard, sizeof heard, "FFFA2C %s FFF0", answer);
    }
    say_hex(self, said);
    expect_heard(self, command, heard);
}

/* A request, and all that comes. */
static void expect_reply(struct bench *self, const char *setting, const char *hex)
{
    say_hex(self, REQUEST);
    virtual_rig_pass(&self->rig, REST);
    expect_heard(self, setting, hex);
}

/* --- commands --- */

static void each_command_is_answered(void **state)
{
    static const char *const rows[][2] = {
        {"00", "64 64 72 65 68 67 65 62 65 72"},
        /* data rate: 50..4000000 */
        {"01 0000 0000", "65 0000 2580"},
        {"01 0000 0031", "65 0000 2580"},
        {"01 0000 0032", "65 0000 0032"},
        {"01 003D 0901", "65 0000 0032"},
        {"01 003D 0900", "65 003D 0900"},
        {"01 0000 0000", "65 003D 0900"},
        {"01 0000 25", NULL},
        /* data bits, parity, stop bits */
        {"02 00", "66 08"},
        {"02 04", "66 08"},
        {"02 05", "66 05"},
        {"02 09", "66 05"},
        {"02 08", "66 08"},
        {"03 00", "67 03"},
        {"03 06", "67 03"},
        {"03 01", "67 01"},
        {"03 05", "67 05"},
        {"03 04", "67 04"},
        {"03 02", "67 02"},
        {"03 03", "67 03"},
        {"04 00", "68 01"},
        {"04 04", "68 01"},
        {"04 02", "68 02"},
        {"04 03", "68 03"},
        {"04 01", "68 01"},
        /* line and modem, their masks, what is thrown away */
        {"06", "6A 60"},
        {"07", "6B B0"},
        {"0A 0C", "6E 0C"},
        {"0B FFFF", "6F FFFF"},
        {"0C 03", "70 03"},
        {"0D 00", NULL},
        {"64 00", NULL},
        /* longer than it should be, as long as is looked at, longer than that */
        {"04 02 07", "68 02"},
        {"04 01 00000000 00000000 00000000 00", "68 01"},
        {"04 03 00000000 00000000 00000000 0000", NULL},
        {"04 00", "68 01"},
    };
    struct bench *self = *state;
    open_port(self, "rfc2217", "");
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        expect_answer(self, rows[i][0], rows[i][1]);
    }
}

/* Outbound flow control, break, DTR, RTS, inbound flow control: what each group asks with, what was
   found, and its other values. */
static void each_control_is_remembered(void **state)
{
    static const struct {
        uint8_t asks;
        uint8_t found;
        uint8_t values[5];
        size_t count;
    } groups[] = {
        {0, 1, {1, 2, 3, 17, 19}, 5},  {4, 6, {6}, 1}, {7, 8, {8, 9}, 2}, {10, 11, {11, 12}, 2},
        {13, 14, {14, 15, 16, 18}, 4},
    };
    struct bench *self = *state;
    char said[8];
    char answer[8];
    open_port(self, "rfc2217", "");
    for (size_t i = 0; i < DG_COUNT(groups); i++) {
        (void)snprintf(said, sizeof said, "05 %02X", groups[i].asks);
        (void)snprintf(answer, sizeof answer, "69 %02X", groups[i].found);
        expect_answer(self, said, answer);
    }
    for (size_t i = 0; i < DG_COUNT(groups); i++) {
        for (size_t k = 0; k < groups[i].count; k++) {
            (void)snprintf(answer, sizeof answer, "69 %02X", groups[i].values[k]);
            (void)snprintf(said, sizeof said, "05 %02X", groups[i].values[k]);
            expect_answer(self, said, answer);
            (void)snprintf(said, sizeof said, "05 %02X", groups[i].asks);
            expect_answer(self, said, answer);
        }
    }
    expect_answer(self, "05 14", "69 13"); /* 20 is none: what is in force is told */
    expect_answer(self, "05 05", "69 05");
    virtual_rig_pass(&self->rig, REST);
    expect_answer(self, "05 04", "69 05");
}

/* One that is far too long is none, and what comes behind it is understood. */
static void what_is_far_too_long_is_nothing(void **state)
{
    struct bench *self = *state;
    open_port(self, "rfc2217", "");
    for (size_t length = 250; length < 280; length++) {
        uint8_t bytes[300] = {0xFF, 0xFA, 0x2C, 0x04, 0x02};
        bytes[length] = 0xFF;
        bytes[length + 1u] = 0xF0;
        virtual_rig_say(&self->rig, bytes, length + 2u);
        expect_heard(self, "long", "");
    }
    expect_answer(self, "04 00", "68 01");
}

/* --- characters --- */

/* An encoder hears what is sent as it listens; who has said nothing is heard by everybody. */
static void an_encoder_hears_its_own_setting(void **state)
{
    static const struct {
        const char *command;
        const char *answer;
        bool hears;
    } rows[] = {
        {"01 0000 2580", "65 0000 2580", true},
        {"01 0000 4B00", "65 0000 4B00", false},
        {"01 0000 2580", "65 0000 2580", true},
        {"03 02", "67 02", false},
        {"03 01", "67 01", false},
        {"03 03", "67 03", true},
        {"02 07", "66 07", false},
        {"02 08", "66 08", true},
        {"04 02", "68 02", true},
    };
    struct bench *self = *state;
    open_port(self, "rfc2217", "");
    expect_reply(self, "as it came", REPLY);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        expect_answer(self, rows[i].command, rows[i].answer);
        expect_reply(self, rows[i].command, rows[i].hears ? REPLY : "");
    }
    /* a break is a damaged character, and no command is one */
    say_hex(self, "40 42 FFF3 02");
    virtual_rig_pass(&self->rig, REST);
    expect_heard(self, "a break", "40 50 0A 1A");
    say_hex(self, "40 FFF1 42 FFF6 02");
    virtual_rig_pass(&self->rig, REST);
    expect_heard(self, "commands", REPLY);
}

/* What is heard at another setting than it is sent at. The change is between request and reply. */
static void a_master_hears_at_its_own_setting(void **state)
{
    static const struct {
        const char *command;
        const char *answer;
        const char *heard;
        const char *back;
    } rows[] = {
        {"01 0000 4B00", "65 0000 4B00", "00 00 00 00 00 00 00", "01 0000 2580"},
        {"03 02", "67 02", REPLY, "03 03"},
        {"02 06", "66 06", "00 02 00 00 30 00 32", "02 08"},
        {"02 05", "66 05", "00 02 00 00 10 00 12", "02 08"},
    };
    static const char *const told[] = {
        "FFFA2C6A08FFF0 00 FFFA2C6A08FFF0 00 FFFA2C6A08FFF0 00 FFFA2C6A08FFF0 00 "
        "FFFA2C6A08FFF0 00 FFFA2C6A08FFF0 00 FFFA2C6A08FFF0 00",
        "FFFA2C6A04FFF0 40 FFFA2C6A04FFF0 42 FFFA2C6A04FFF0 00 FFFA2C6A04FFF0 00 "
        "FFFA2C6A04FFF0 70 FFFA2C6A04FFF0 00 FFFA2C6A04FFF0 72",
    };
    struct bench *self = *state;
    open_port(self, "rfc2217", "");
    expect_answer(self, "01 0000 2580", "65 0000 2580");
    expect_answer(self, "03 03", "67 03");
    for (size_t round = 0; round < 2; round++) { /* then it wants to know what was wrong */
        for (size_t i = 0; i < (round == 0 ? DG_COUNT(rows) : DG_COUNT(told)); i++) {
            say_hex(self, REQUEST);
            virtual_rig_pass(&self->rig, DG_MS(4));
            expect_answer(self, rows[i].command, rows[i].answer);
            virtual_rig_pass(&self->rig, REST);
            expect_heard(self, rows[i].command, round == 0 ? rows[i].heard : told[i]);
            char back[64];
            (void)snprintf(back, sizeof back, "FFFA2C %s FFF0", rows[i].back);
            say_hex(self, back);
            self->heard_count = 0;
        }
        expect_answer(self, "0A 0C", "6E 0C");
    }
}

/* FFh is data; to telnet it is a command unless it stands there twice. */
static void a_character_of_ones_is_doubled(void **state)
{
    struct bench *self = *state;
    open_port(self, "rfc2217", "");
    virtual_rig_order(&self->rig, "SHAF:POS 359.995DEG"); /* 65535.09 steps: 00 00 FF FF */
    expect_reply(self, "359.995", "40 42 00 00 FFFF FFFF 02");
}

/* Without telnet a byte is a byte, and nothing asks for a data rate. */
static void bytes_are_characters(void **state)
{
    struct bench *self = *state;
    open_port(self, "tcp", "");
    virtual_rig_order(&self->rig, "SHAF:POS 359.995DEG");
    expect_reply(self, "tcp", "40 42 00 00 FF FF 02");
}

/* --- moments --- */

static void at_its_own_pace_or_at_once(void **state)
{
    struct bench *self = *state;
    open_port(self, "tcp", "pace = 0");
    say_hex(self, REQUEST);
    virtual_rig_pass(&self->rig, ANSWER - 1u);
    expect_heard(self, "pace=0", "");
    virtual_rig_pass(&self->rig, 1);
    expect_heard(self, "pace=0", REPLY);
}

static void any_setting_is_right(void **state)
{
    struct bench *self = *state;
    open_port(self, "rfc2217", "line = any");
    expect_answer(self, "01 0000 4B00", "65 0000 4B00");
    expect_answer(self, "03 02", "67 02");
    expect_reply(self, "any", REPLY);
}

/* Who has said its last word still hears the answer, for two seconds. */
static void who_is_done_lingers(void **state)
{
    struct bench *self = *state;
    open_port(self, "tcp", "");
    const unsigned open = descriptors_open();
    say_hex(self, REQUEST);
    assert_int_equal(shutdown(self->rig.line, SHUT_WR), 0);
    virtual_rig_serve(&self->rig);
    const dg_ns begin = lx_now();
    virtual_rig_pass(&self->rig, REST);
    expect_heard(self, "linger", REPLY);
    virtual_rig_pass_to(&self->rig, begin + LINGER - 1u);
    assert_int_equal(descriptors_open(), open);
    virtual_rig_pass(&self->rig, 1);
    assert_int_equal(descriptors_open(), open - 1u);
}

/* --- counters --- */

static void expect_counters(struct bench *self, const char *text)
{
    virtual_rig_ask(&self->rig, "STAT?");
    if (strstr(self->rig.answer, text) == NULL) {
        fail_msg("%s: no %s", self->rig.answer, text);
    }
}

static void what_nobody_hears_is_lost(void **state)
{
    struct bench *self = *state;
    open_port(self, "tcp", "");
    expect_reply(self, "once", REPLY);
    expect_counters(self, "wire_up=1,wire_late=0,wire_collided=0,wire_lost=0,wire_baud=9600,"
                          "wire_overrun=0");
    say_hex(self, REQUEST);
    (void)close(self->rig.line);
    self->rig.line = -1;
    virtual_rig_pass(&self->rig, REST);
    expect_counters(self, "wire_lost=6,"); /* the first one finds out that nobody is there */
}

/* --- */

/* The file in memory that rigs are read from stays. */
static int note(void **state)
{
    (void)memory_file_write((const uint8_t *)"", 0);
    return descriptors_note(state);
}

#define WITH_BENCH(test) cmocka_unit_test_setup_teardown(test, make_bench, end_bench)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_BENCH(each_command_is_answered),
        WITH_BENCH(each_control_is_remembered),
        WITH_BENCH(what_is_far_too_long_is_nothing),
        WITH_BENCH(an_encoder_hears_its_own_setting),
        WITH_BENCH(a_master_hears_at_its_own_setting),
        WITH_BENCH(a_character_of_ones_is_doubled),
        WITH_BENCH(bytes_are_characters),
        WITH_BENCH(at_its_own_pace_or_at_once),
        WITH_BENCH(any_setting_is_right),
        WITH_BENCH(who_is_done_lingers),
        WITH_BENCH(what_nobody_hears_is_lost),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests_name("an encoder behind a TCP port", tests, note, NULL);
}

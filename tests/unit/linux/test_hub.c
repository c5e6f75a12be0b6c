/* SPDX-License-Identifier: MIT */
/*
 * Two CANopen encoders behind a TCP port, as adapters see them, in virtual time: what is answered
 * at which data rate, when a frame comes on a wire that takes its time, how much of it is used.
 *
 * Lines are those of SLCAN (CAN232 manual), messages those of socketcand (doc/protocol.md), frames
 * those of CiA 301: 1018h:0 is 4, the number of entries.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "descriptors.h"
#include "memory_file.h"
#include "timer.h"
#include "virtual_rig.h"

#define ASK_1 "t60184018100000000000\r"
#define ANSWER_1 "t58184F18100004000000\r"
#define ASK_2 "t60284018100000000000\r"
#define ANSWER_2 "t58284F18100004000000\r"
#define TAKEN "z\r"
/* 8 bytes at 250 kBd: 135 bits with all stuff bits that there can be. */
#define FRAME DG_US(540)

struct bench {
    struct virtual_rig rig;
    char heard[32768];
    size_t heard_count;
};

static void on_heard(void *ctx, const uint8_t *bytes, size_t n)
{
    struct bench *self = ctx;
    assert_true(self->heard_count + n < sizeof self->heard);
    memcpy(self->heard + self->heard_count, bytes, n);
    self->heard_count += n;
    self->heard[self->heard_count] = '\0';
}

static void open_hub(struct bench *self, const char *wire, const char *key)
{
    char text[512];
    const int n = snprintf(text, sizeof text,
                           "[bus hub]\n%s\n%s\n"
                           "[encoder a]\nmodel = f3668\nbus = hub\nnode = 1\n"
                           "[encoder b]\nmodel = f3658\nbus = hub\nnode = 2\n",
                           wire, key);
    assert_in_range(n, 1, sizeof text - 1);
    self->rig = (struct virtual_rig){.heard = on_heard, .ctx = self};
    virtual_rig_open(&self->rig, memory_file_write((const uint8_t *)text, (size_t)n), NULL);
    virtual_rig_connect(&self->rig);
}

#define SLCAN "wire = slcan\naddress = tcp:127.0.0.1:0"
#define SOCKETCAND "wire = socketcand\naddress = 127.0.0.1:0,can0"

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

static void say_text(struct bench *self, const char *text)
{
    virtual_rig_say(&self->rig, (const uint8_t *)text, strlen(text));
}

/* This was heard since the last time, and nothing else. */
static void expect_heard(struct bench *self, const char *text)
{
    self->heard[self->heard_count] = '\0';
    assert_string_equal(self->heard, text);
    self->heard_count = 0;
}

static void expect(struct bench *self, const char *text, const char *answer)
{
    say_text(self, text);
    expect_heard(self, answer);
}

/* An adapter at 250 kBd, the encoders' rate; whatever they say to that is left out. */
static void open_channel(struct bench *self)
{
    say_text(self, "S5\rO\r");
    virtual_rig_pass(&self->rig, DG_S(1));
    self->heard_count = 0;
}

static void expect_counters(struct bench *self, const char *text)
{
    virtual_rig_ask(&self->rig, "STAT?");
    if (strstr(self->rig.answer, text) == NULL) {
        fail_msg("%s: no %s", self->rig.answer, text);
    }
}

/* --- data rates --- */

static void who_is_at_another_rate_is_not_heard(void **state)
{
    struct bench *self = *state;
    open_hub(self, SLCAN, "");
    expect(self, "S6\rO\r", "\r\r");
    virtual_rig_pass(&self->rig, DG_S(1));
    expect_heard(self, "");
    expect(self, ASK_1, TAKEN);
    expect(self, "C\r", "\r");
    expect(self, "S5\rO\r", "\r\r");
    virtual_rig_pass(&self->rig, DG_S(1));
    self->heard_count = 0;
    expect(self, ASK_1, TAKEN ANSWER_1);
}

/* --- moments --- */

static void without_a_pace_all_comes_at_once(void **state)
{
    struct bench *self = *state;
    open_hub(self, SLCAN, "");
    open_channel(self);
    expect(self, ASK_1 ASK_2 ASK_1, TAKEN ANSWER_1 TAKEN ANSWER_2 TAKEN ANSWER_1);
}

/* The first answer at once; the second request and it are on the wire then, one behind the other,
   and what is left waits for them. */
static void on_a_paced_wire_a_frame_waits_for_its_turn(void **state)
{
    struct bench *self = *state;
    open_hub(self, SLCAN, "pace = 1");
    open_channel(self);
    expect(self, ASK_1 ASK_2 ASK_1, TAKEN ANSWER_1 TAKEN TAKEN);
    virtual_rig_pass(&self->rig, 2 * FRAME - 1);
    expect_heard(self, "");
    virtual_rig_pass(&self->rig, 1);
    expect_heard(self, ANSWER_2);
    virtual_rig_pass(&self->rig, FRAME - 1);
    expect_heard(self, "");
    virtual_rig_pass(&self->rig, 1);
    expect_heard(self, ANSWER_1);
    virtual_rig_pass(&self->rig, DG_S(1));
    expect_heard(self, "");
}

/* The fault wire_delay: what the node sends comes 50 ms late. Its frames keep their order: one that
   is not late itself waits for those that are. */
static void frames_keep_their_order(void **state)
{
    struct bench *self = *state;
    open_hub(self, SLCAN, "");
    open_channel(self);
    virtual_rig_order(&self->rig, "INST:SEL a");
    virtual_rig_order(&self->rig, "FAUL:SET wire_delay,COUN,2");
    expect(self, ASK_1, TAKEN);
    virtual_rig_pass(&self->rig, DG_MS(10));
    expect(self, ASK_1 ASK_1 ASK_2, TAKEN TAKEN TAKEN ANSWER_2);
    virtual_rig_pass(&self->rig, DG_MS(40) - 1);
    expect_heard(self, "");
    virtual_rig_pass(&self->rig, 1);
    expect_heard(self, ANSWER_1);
    virtual_rig_pass(&self->rig, DG_MS(10) - 1);
    expect(self, ASK_1, TAKEN);
    virtual_rig_pass(&self->rig, 1);
    expect_heard(self, ANSWER_1 ANSWER_1 ANSWER_1);
    expect(self, ASK_1, TAKEN ANSWER_1);
}

/* The controller of one node is off the bus, or hears nothing; its neighbour is not. */
static void faults_of_a_controller_are_its_own(void **state)
{
    struct bench *self = *state;
    open_hub(self, SLCAN, "");
    open_channel(self);
    virtual_rig_order(&self->rig, "INST:SEL a");
    virtual_rig_order(&self->rig, "FAUL:SET wire_drop,COUN,1");
    expect(self, ASK_1 ASK_1 ASK_2, TAKEN TAKEN ANSWER_1 TAKEN ANSWER_2);
    virtual_rig_order(&self->rig, "FAUL:SET wire_deaf,COUN,1");
    expect(self, ASK_1 ASK_1 ASK_2, TAKEN TAKEN ANSWER_1 TAKEN ANSWER_2);
    virtual_rig_order(&self->rig, "FAUL:SET wire_duplicate,COUN,1");
    expect(self, ASK_1 ASK_1, TAKEN ANSWER_1 ANSWER_1 TAKEN ANSWER_1);
    virtual_rig_order(&self->rig, "FAUL:SET wire_duplicate,COUN,1;:FAUL:SET wire_delay,COUN,1");
    expect(self, ASK_1, TAKEN);
    virtual_rig_pass(&self->rig, DG_MS(50));
    expect_heard(self, ANSWER_1 ANSWER_1);
}

/* Late frames (wire_delay) wait for 50 ms, in which a wire at 1 MBd carries 370 with 8 bytes. */
static void what_is_late_is_not_lost(void **state)
{
    static const unsigned asked = 400;
    struct bench *self = *state;
    open_hub(self, SLCAN, "");
    open_channel(self);
    virtual_rig_order(&self->rig, "FAUL:SET wire_delay");
    for (unsigned i = 0; i < asked; i++) {
        say_text(self, ASK_1);
    }
    self->heard_count = 0;
    virtual_rig_pass(&self->rig, DG_MS(60));
    assert_int_equal(self->heard_count, asked * strlen(ANSWER_1));
    expect_counters(self, "wire_stalls=0,wire_lost=0,");
}

/* --- load --- */

/* Most bits that frames of 0 and 8 bytes take, of 250000 in a second: 55 and 135, with identifiers
   of 29 bits 80 and 160. */
static void load_is_what_was_on_the_wire(void **state)
{
    static const struct {
        const char *line;
        unsigned count;
        unsigned permille;
    } rows[] = {
        {ASK_1, 100, 108},         /* and its answer: 27000 bits */
        {"t1230\r", 100, 22},      /* 5500 */
        {"r1238\r", 100, 22},      /* no data in it */
        {"T1ABCDE010\r", 100, 32}, /* 8000 */
        {"T1ABCDE0180000000000000000\r", 100, 64},
    };
    struct bench *self = *state;
    open_hub(self, SLCAN, "");
    open_channel(self);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        virtual_rig_pass(&self->rig, DG_MS(1500)); /* into the middle of a second */
        for (unsigned k = 0; k < rows[i].count; k++) {
            say_text(self, rows[i].line);
        }
        char text[96];
        (void)snprintf(text, sizeof text, "wire_kbaud=250,wire_load_permille=%u,",
                       rows[i].permille);
        virtual_rig_pass(&self->rig, DG_S(1));
        expect_counters(self, text);
        self->heard_count = 0;
    }
    expect_counters(self, "wire_up=1,wire_late=0,wire_stalls=0,wire_lost=");
}

/* --- socketcand --- */

static void who_has_subscribed_hears(void **state)
{
    char right[128];
    struct bench *self = *state;
    open_hub(self, SOCKETCAND, "");
    virtual_rig_pass(&self->rig, DG_S(1) + DG_US(1));
    expect(self, "< open can0 >", "< hi >< ok >");
    virtual_rig_pass(&self->rig, DG_S(1));
    expect_heard(self, "");
    expect(self, "< subscribe 0 0 582 >", "");
    expect(self, "< send 601 8 40 18 10 0 0 0 0 0 >", "");
    say_text(self, "< send 602 8 40 18 10 0 0 0 0 0 >");
    const dg_ns now = lx_now();
    (void)snprintf(right, sizeof right, "< frame 582 %llu.%06llu 4F18100004000000 >",
                   (unsigned long long)(now / DG_S(1)),
                   (unsigned long long)(now % DG_S(1) / DG_US(1)));
    expect_heard(self, right);
    expect(self, "< unsubscribe 582 >< send 602 8 40 18 10 0 0 0 0 0 >", "");
    expect(self, "< send 602 8 40 18 10 0 0 0 0 >", "< error syntax error in send command >");
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
        WITH_BENCH(who_is_at_another_rate_is_not_heard),
        WITH_BENCH(without_a_pace_all_comes_at_once),
        WITH_BENCH(on_a_paced_wire_a_frame_waits_for_its_turn),
        WITH_BENCH(frames_keep_their_order),
        WITH_BENCH(faults_of_a_controller_are_its_own),
        WITH_BENCH(what_is_late_is_not_lost),
        WITH_BENCH(load_is_what_was_on_the_wire),
        WITH_BENCH(who_has_subscribed_hears),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests_name("encoders behind a CAN adapter", tests, note, NULL);
}

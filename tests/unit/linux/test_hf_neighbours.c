/* SPDX-License-Identifier: MIT */
/*
 * Three RS485 encoders on one line, in virtual time: who hears what, and when, to the nanosecond. A
 * whole rig with its master at a TCP port, so what is judged is what anybody could see.
 *
 * Moments (manual of the S36, 5.1.1.1; page of the encoder, "Timings"), at 9600 Bd, 8E1:
 *
 *   |40---|42---|02---|   silence   | reaction |40---|42---|...
 *    11 bits each       44 bits       1 ms      11 bits each
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "hf_rig.h"
#include "memory_file.h"
#include "slow_disk.h"
#include "timer.h"
#include "virtual_rig.h"

#define BAUD 9600u
#define BITS 11u
/* Of a master: each character begins when the one before is over, in whole nanoseconds. */
#define CHARACTER 1145834u
#define SILENCE 4583334u
#define REACTION DG_MS(1)
/* From the end of a request to the start bit of its reply. */
#define ANSWER (SILENCE + REACTION)
/* Longer than everything that could still come. */
#define REST DG_MS(100)
#define INITIALISATION DG_MS(100)
/* The fault wire_delay: longer than the longest reaction time. */
#define DELAY DG_MS(300)
#define PATIENCE DG_S(10)
#define TOLD_MAX 1024u

/* 42h, at 7/16, 11/16 and 13/16 of 65536 steps. */
#define REPLY_A "40 42 00 00 70 00"
#define REPLY_B "41 42 00 00 B0 00"
#define REPLY_C "42 42 00 00 D0 00"
/* At the same time: the AND of these, with their check sums 72, B3 and D0. */
#define REPLY_ABC "40 42 00 00 10 00 10"
#define REPLY_AC "40 42 00 00 50 00 50"
#define REPLY_BC "40 42 00 00 90 00 90"

static const char rig_text[] = "[bus line]\nwire = rs485\naddress = tcp:127.0.0.1:0\n"
                               "[shaft east]\nmotion = 157.5DEG\n"
                               "[shaft west]\nmotion = 247.5DEG\n"
                               "[shaft south]\nmotion = 292.5DEG\n"
                               "[encoder a]\nmodel = s3684-rs485\nbus = line\nshaft = east\n%s\n"
                               "[encoder b]\nmodel = s3674-rs485\nbus = line\nshaft = west\n"
                               "address = 0x41\n"
                               "[encoder c]\nmodel = s3684-rs485\nbus = line\nshaft = south\n"
                               "address = 0x42\n%s\n";

/* A character as the line carried it, at the end of its stop bit. */
struct told {
    dg_ns at;
    uint8_t byte;
    bool ours;
    bool damaged;
};

struct line {
    struct virtual_rig rig;
    struct lx_tap_listener listener;
    struct told told[TOLD_MAX];
    size_t count;
    size_t judged;
    uint8_t heard[TOLD_MAX]; /* by the master */
    size_t heard_count;
    char folder[SLOW_DISK_FOLDER]; /* of an EEPROM file; empty: there is none */
};

/* --- the line and its master --- */

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct line *self = ctx;
    assert_int_equal(event->kind, DG_TAP_CHARACTER);
    assert_true(self->count < TOLD_MAX);
    self->told[self->count++] =
        (struct told){event->at, event->character.byte, event->ours, event->character.damaged};
}

static void on_heard(void *ctx, const uint8_t *bytes, size_t n)
{
    struct line *self = ctx;
    assert_true(self->heard_count + n <= TOLD_MAX);
    memcpy(self->heard + self->heard_count, bytes, n);
    self->heard_count += n;
}

/* Keys for the first encoder, and for the last. */
static void open_line(struct line *self, const char *first, const char *last)
{
    char text[sizeof rig_text + 256];
    self->rig = (struct virtual_rig){.heard = on_heard, .ctx = self};
    self->listener = (struct lx_tap_listener){.event = on_event, .ctx = self};
    const int n = snprintf(text, sizeof text, rig_text, first, last);
    assert_in_range(n, 1, sizeof text - 1);
    virtual_rig_open(&self->rig, memory_file_write((const uint8_t *)text, (size_t)n),
                     &self->listener);
    virtual_rig_connect(&self->rig);
    virtual_rig_pass(&self->rig, INITIALISATION + REST);
}

/* These characters, from now on. @return when the last one is over, if the line was idle */
static dg_ns say_characters(struct line *self, const char *hex)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    const size_t n = hf_rig_hex(hex, bytes, sizeof bytes);
    virtual_rig_say(&self->rig, bytes, n);
    return lx_now() + n * CHARACTER;
}

/* The same with the check sum behind them. */
static dg_ns request(struct line *self, const char *hex)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    size_t n = hf_rig_hex(hex, bytes, sizeof bytes - 1);
    bytes[n] = hf_rig_xor(bytes, n);
    virtual_rig_say(&self->rig, bytes, ++n);
    return lx_now() + n * CHARACTER;
}

static const struct told *next_told(struct line *self)
{
    assert_true(self->judged < self->count);
    return &self->told[self->judged++];
}

/* The master said this, from `begin` on. */
static void expect_said(struct line *self, dg_ns begin, const char *hex)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    const size_t n = hf_rig_hex(hex, bytes, sizeof bytes);
    for (size_t i = 0; i < n; i++) {
        const struct told *one = next_told(self);
        assert_false(one->ours);
        assert_int_equal(one->byte, bytes[i]);
        assert_int_equal(one->at - begin, (i + 1) * CHARACTER);
    }
}

/* The end of character `index` of a reply that began at 0: bits at the data rate, rounded up. */
static dg_ns end_of(size_t index)
{
    return ((index + 1) * BITS * DG_S(1) + BAUD - 1) / BAUD;
}

/* Characters of a reply from the one with index `from` on, if its start bit was at `begin`. */
static void expect_part(struct line *self, dg_ns begin, size_t from, bool damaged, const char *hex)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    const size_t n = hf_rig_hex(hex, bytes, sizeof bytes);
    for (size_t i = 0; i < n; i++) {
        const struct told *one = next_told(self);
        assert_true(one->ours);
        assert_int_equal(one->byte, bytes[i]);
        assert_int_equal(one->damaged, damaged);
        assert_int_equal(one->at - begin, end_of(from + i));
    }
}

/* A whole one; the check sum is added. @return when it is over */
static dg_ns expect_reply(struct line *self, dg_ns begin, const char *hex)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    char sum[3];
    const size_t n = hf_rig_hex(hex, bytes, sizeof bytes);
    (void)snprintf(sum, sizeof sum, "%02X", hf_rig_xor(bytes, n));
    expect_part(self, begin, 0, false, hex);
    expect_part(self, begin, n, false, sum);
    return begin + end_of(n);
}

/* Nothing else has come, and nothing else comes; what was on the line the master has heard. */
static void expect_rest(struct line *self)
{
    uint8_t ours[TOLD_MAX];
    size_t n = 0;
    virtual_rig_pass(&self->rig, REST);
    assert_int_equal(self->count, self->judged);
    for (size_t i = 0; i < self->count; i++) {
        ours[n] = self->told[i].byte;
        n += self->told[i].ours;
    }
    const dg_ns end = lx_real_now() + PATIENCE;
    while (self->heard_count < n && lx_real_now() < end) {
        virtual_rig_serve(&self->rig);
    }
    assert_int_equal(self->heard_count, n);
    assert_memory_equal(self->heard, ours, n);
    self->count = 0;
    self->judged = 0;
    self->heard_count = 0;
}

/* A request, and silence; a request, and the reply, exactly then. */
static void expect_silence(struct line *self, const char *hex)
{
    (void)request(self, hex);
    virtual_rig_pass(&self->rig, REST);
    while (self->judged < self->count) {
        assert_false(next_told(self)->ours);
    }
    expect_rest(self);
}

static void expect_answer(struct line *self, const char *hex, const char *reply)
{
    const dg_ns begin = lx_now();
    const dg_ns end = request(self, hex);
    virtual_rig_pass(&self->rig, REST);
    expect_said(self, begin, hex);
    (void)next_told(self); /* its check sum */
    (void)expect_reply(self, end + ANSWER, reply);
    expect_rest(self);
}

static void expect_all_answer(struct line *self)
{
    expect_answer(self, "40 42", REPLY_A);
    expect_answer(self, "41 42", REPLY_B);
    expect_answer(self, "42 42", REPLY_C);
}

/* What STATe? counts of an encoder, by its name with '='. */
static uint64_t counter(struct line *self, const char *encoder, const char *name)
{
    virtual_rig_order(&self->rig, "INST:SEL %s", encoder);
    virtual_rig_ask(&self->rig, "STAT?");
    const char *at = strstr(self->rig.answer, name);
    assert_non_null(at);
    return strtoull(at + strlen(name), NULL, 10);
}

/* --- requests --- */

static void each_answers_for_itself(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    expect_all_answer(line);
    expect_silence(line, "43 42");
}

/* Frames are told apart by silence only (5.1.1.1): a character that begins a nanosecond before the
   silence is over belongs to the frame. */
static void a_pause_in_a_request(void **state)
{
    static const struct {
        const char *first;
        const char *rest;
        const char *whole;
        const char *two;
    } rows[] = {
        {"40 42", "02", REPLY_A, "40 50 0A"},
        {"41 42", "03", REPLY_B, "41 50 0A"},
        {"42 42", "00", REPLY_C, "42 50 0C"}, /* its check sum is right (no. 16) */
    };
    struct line *line = *state;
    open_line(line, "", "");
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        dg_ns end = say_characters(line, rows[i].first);
        virtual_rig_pass_to(&line->rig, end + SILENCE - 1);
        const dg_ns again = lx_now();
        const dg_ns begin = end - 2u * CHARACTER;
        end = say_characters(line, rows[i].rest);
        virtual_rig_pass(&line->rig, REST);
        expect_said(line, begin, rows[i].first);
        expect_said(line, again, rows[i].rest);
        (void)expect_reply(line, end + ANSWER, rows[i].whole);
        expect_rest(line);
        end = say_characters(line, rows[i].first);
        virtual_rig_pass_to(&line->rig, end + SILENCE);
        (void)say_characters(line, rows[i].rest);
        virtual_rig_pass(&line->rig, REST);
        expect_said(line, end - 2u * CHARACTER, rows[i].first);
        const struct told *late = next_told(line);
        assert_false(late->ours);
        (void)expect_reply(line, end + ANSWER, rows[i].two);
        expect_rest(line);
    }
}

/* --- a request behind a reply --- */

static const char *const requests[] = {"40 42", "41 42", "42 42"};
static const char *const replies[] = {REPLY_A, REPLY_B, REPLY_C};

/* So long behind the end of a reply of `first` begins a request to `second`: is it answered? */
static void follow_up(struct line *self, size_t first, size_t second, int64_t behind, bool answered)
{
    const dg_ns begin = lx_now();
    dg_ns end = request(self, requests[first]);
    const dg_ns over = end + ANSWER + end_of(6);
    virtual_rig_pass_to(&self->rig, (dg_ns)((int64_t)over + behind));
    const dg_ns again = lx_now();
    end = request(self, requests[second]);
    virtual_rig_pass(&self->rig, REST);
    expect_said(self, begin, requests[first]);
    (void)next_told(self);
    assert_int_equal(expect_reply(self, begin + 3u * CHARACTER + ANSWER, replies[first]), over);
    expect_said(self, again, requests[second]);
    (void)next_told(self);
    if (answered) {
        (void)expect_reply(self, end + ANSWER, replies[second]);
    }
    expect_rest(self);
}

/* Who has heard a reply waits for a silence, as the manual asks of masters (5.1.1.1); who has
   replied has heard none (no. 20). */
static void a_request_behind_a_reply(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    for (size_t first = 0; first < 3; first++) {
        for (size_t second = 0; second < 3; second++) {
            follow_up(line, first, second, 0, first == second);
            follow_up(line, first, second, SILENCE - 1, first == second);
            follow_up(line, first, second, SILENCE, true);
        }
    }
}

/* It begins in the middle of the last character. */
static void a_request_that_begins_while_a_reply_ends(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    for (size_t first = 0; first < 3; first++) {
        for (size_t second = 0; second < 3; second++) {
            if (first != second) {
                follow_up(line, first, second, -(int64_t)(CHARACTER / 2u), false);
            }
        }
    }
    expect_all_answer(line);
}

/* 56h has 40 characters: serial number, version, date. */
static void a_request_into_a_reply(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    const dg_ns begin = request(line, "40 56") + ANSWER;
    virtual_rig_pass_to(&line->rig, begin + end_of(9));
    (void)request(line, "41 42");
    virtual_rig_pass(&line->rig, REST);
    assert_int_equal(counter(line, "b", "wire_collided="), 3);
    assert_int_equal(counter(line, "a", "damaged="), 0); /* who sends does not hear */
    assert_int_equal(counter(line, "b", "damaged="), 3);
    assert_int_equal(counter(line, "c", "damaged="), 3);
    size_t ours = 0;
    uint8_t sum = 0;
    while (line->judged < line->count) {
        const struct told *one = next_told(line);
        assert_false(one->damaged);
        if (one->ours) {
            assert_int_equal(one->at - begin, end_of(ours++));
            sum ^= one->byte;
        }
    }
    assert_int_equal(ours, 40);
    assert_int_equal(sum, 0);
    expect_rest(line);
    expect_all_answer(line);
}

/* --- replies at the same time --- */

static void switch_power(struct line *self, const char *name, const char *to)
{
    virtual_rig_order(&self->rig, "INST:SEL %s", name);
    virtual_rig_order(&self->rig, "POW %s", to);
}

/* All that have power answer, each with its own address (R12). */
static void expect_collision(struct line *self, const char *hex)
{
    const dg_ns begin = lx_now();
    const dg_ns end = request(self, "FF 42");
    virtual_rig_pass(&self->rig, REST);
    expect_said(self, begin, "FF 42 BD");
    expect_part(self, end + ANSWER, 0, true, hex);
    expect_rest(self);
}

static void all_answer_a_broadcast(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    expect_collision(line, REPLY_ABC);
    switch_power(line, "b", "OFF");
    expect_collision(line, REPLY_AC);
    switch_power(line, "a", "OFF");
    expect_answer(line, "FF 42", REPLY_C);
    switch_power(line, "a", "ON");
    switch_power(line, "b", "ON");
    expect_collision(line, REPLY_ABC);
    expect_all_answer(line);
}

/* The last one answers 3.5 characters later: two characters at the same time are over with the
   first of them. The rest of the later reply is its own, and who has heard that waits for a
   silence. */
static void a_later_reply_meets_an_earlier_one(void **state)
{
    struct line *line = *state;
    open_line(line, "", "reaction_us = 5010");
    switch_power(line, "b", "OFF");
    for (size_t i = 0; i < 3; i += 2) {
        const dg_ns said = lx_now();
        const dg_ns begin = request(line, "FF 42") + ANSWER;
        const dg_ns later = begin + DG_US(4010);
        virtual_rig_pass_to(&line->rig, later + end_of(6));
        const dg_ns end = request(line, requests[i]);
        virtual_rig_pass(&line->rig, REST);
        expect_said(line, said, "FF 42 BD");
        expect_part(line, begin, 0, false, "40 42 00");
        expect_part(line, begin, 3, true, "00 40 00 00"); /* 00&42 70&42 00&00 72&00 */
        expect_part(line, later, 4, false, "D0 00 D0");
        expect_said(line, later + end_of(6), requests[i]);
        (void)next_told(line);
        if (i == 2) {
            (void)expect_reply(line, end + DG_US(4010) + ANSWER, replies[i]);
        }
        expect_rest(line);
    }
}

/* --- power --- */

static void power_of_one_goes_in_its_reply(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    const dg_ns said = lx_now();
    const dg_ns begin = request(line, "41 42") + ANSWER;
    virtual_rig_pass_to(&line->rig, begin + end_of(3));
    switch_power(line, "b", "OFF");
    virtual_rig_pass(&line->rig, REST);
    expect_said(line, said, "41 42 03");
    expect_part(line, begin, 0, false, "41 42 00 00");
    expect_rest(line);
    expect_silence(line, "41 42");
    expect_answer(line, "40 42", REPLY_A);
    expect_answer(line, "42 42", REPLY_C);
    switch_power(line, "b", "ON");
    expect_all_answer(line);
}

/* With power it listens at once (R28), also into a request: what is left of that is no frame for
   it, and the others have had it whole. */
static void power_of_one_comes_in_a_request(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    switch_power(line, "b", "OFF");
    const dg_ns said = lx_now();
    const dg_ns end = request(line, "42 42");
    virtual_rig_pass(&line->rig, CHARACTER);
    switch_power(line, "b", "ON");
    virtual_rig_pass(&line->rig, REST);
    expect_said(line, said, "42 42 00");
    (void)expect_reply(line, end + ANSWER, REPLY_C);
    expect_rest(line);
    expect_all_answer(line);
}

/* --- faults --- */

/* Counted are requests for this encoder, also those for all, by their first character: 40h inside
   of one for another encoder is none. */
static void a_deaf_one_misses_what_is_for_it(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    virtual_rig_order(&line->rig, "INST:SEL a");
    virtual_rig_order(&line->rig, "FAUL:SET wire_deaf,COUN,1");
    expect_answer(line, "41 44 40", "41 50 0D");
    expect_silence(line, "40 42");
    expect_all_answer(line);
    virtual_rig_order(&line->rig, "FAUL:SET wire_deaf,COUN,1");
    expect_collision(line, REPLY_BC);
    expect_collision(line, REPLY_ABC);
}

/* While a reply waits for its time the line is idle: the others are asked, and answer. */
static void a_late_one_holds_up_nobody(void **state)
{
    struct line *line = *state;
    open_line(line, "", "");
    virtual_rig_order(&line->rig, "INST:SEL b");
    virtual_rig_order(&line->rig, "FAUL:SET wire_delay,COUN,1");
    const dg_ns begin = lx_now();
    const dg_ns end = request(line, "41 42");
    virtual_rig_pass(&line->rig, REST);
    expect_said(line, begin, "41 42 03");
    for (size_t i = 0; i < 3; i += 2) {
        const dg_ns again = lx_now();
        const dg_ns over = request(line, requests[i]);
        virtual_rig_pass(&line->rig, REST / 2u);
        expect_said(line, again, requests[i]);
        (void)next_told(line);
        (void)expect_reply(line, over + ANSWER, replies[i]);
    }
    virtual_rig_pass(&line->rig, DELAY);
    (void)expect_reply(line, end + ANSWER + DELAY, REPLY_B);
    expect_rest(line);
    assert_int_equal(counter(line, "b", "wire_collided="), 0);
    expect_all_answer(line);
}

/* --- a slow disk --- */

/* The first one stores what it counts. */
static void open_storing_line(struct line *self)
{
    char key[SLOW_DISK_KEY];
    slow_disk_make_folder(self->folder, key);
    open_line(self, key, "");
}

/* Until there is a reply to what was kept from it, while time goes on. @return its start bit */
static dg_ns await_reply(struct line *self)
{
    const dg_ns end = lx_real_now() + PATIENCE;
    const struct timespec nap = {.tv_nsec = (long)DG_US(100)};
    while (self->count == self->judged && lx_real_now() < end) {
        (void)nanosleep(&nap, NULL);
        virtual_rig_pass(&self->rig, CHARACTER);
    }
    assert_true(self->count > self->judged);
    virtual_rig_pass(&self->rig, REST);
    return self->told[self->judged].at - end_of(0);
}

/* 47h, whose reply is kept. */
static void count_without_reply(struct line *self)
{
    slow_disk_take();
    expect_silence(self, "40 47");
}

/* What it acknowledges is on the disk first (page of the port, "what is kept back meanwhile"). The
   others go on; it hears nothing. */
static void a_kept_reply_is_said_once(void **state)
{
    struct line *line = *state;
    open_storing_line(line);
    for (int i = 1; i <= 2; i++) {
        char counted[] = "40 46 00 00 0n";
        count_without_reply(line);
        expect_answer(line, "41 42", REPLY_B);
        expect_answer(line, "42 42", REPLY_C);
        expect_silence(line, "40 42");
        const dg_ns given = lx_now();
        slow_disk_give();
        const dg_ns begin = await_reply(line);
        assert_true(begin >= given);
        (void)expect_reply(line, begin, "40 47");
        expect_rest(line);
        expect_all_answer(line);
        counted[sizeof counted - 2] = (char)('0' + i);
        expect_answer(line, "40 46", counted);
    }
}

/* Whether it is on again before the disk is through, and keeps the next reply, or after that. */
static void a_kept_reply_goes_with_the_power(void **state)
{
    struct line *line = *state;
    open_storing_line(line);
    count_without_reply(line);
    switch_power(line, "a", "OFF");
    switch_power(line, "a", "ON");
    expect_silence(line, "40 42");
    slow_disk_give();
    (void)expect_reply(line, await_reply(line), REPLY_A);
    expect_rest(line);
    count_without_reply(line);
    switch_power(line, "a", "OFF");
    slow_disk_give();
    expect_silence(line, "40 42");
    switch_power(line, "a", "ON");
    expect_answer(line, "41 42", REPLY_B);
    (void)request(line, "40 46");
    virtual_rig_pass(&line->rig, 3u * CHARACTER);
    expect_said(line, lx_now() - 3u * CHARACTER, "40 46 06");
    (void)expect_reply(line, await_reply(line), "40 46 00 00 02");
    expect_rest(line);
}

/* --- */

static int make_line(void **state)
{
    *state = calloc(1, sizeof(struct line));
    return *state == NULL ? -1 : 0;
}

static int end_line(void **state)
{
    struct line *self = *state;
    slow_disk_give();
    virtual_rig_close(&self->rig);
    slow_disk_remove_folder(self->folder);
    free(self);
    return 0;
}

#define WITH_LINE(test) cmocka_unit_test_setup_teardown(test, make_line, end_line)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_LINE(each_answers_for_itself),
        WITH_LINE(a_pause_in_a_request),
        WITH_LINE(a_request_behind_a_reply),
        WITH_LINE(a_request_that_begins_while_a_reply_ends),
        WITH_LINE(a_request_into_a_reply),
        WITH_LINE(all_answer_a_broadcast),
        WITH_LINE(a_later_reply_meets_an_earlier_one),
        WITH_LINE(power_of_one_goes_in_its_reply),
        WITH_LINE(power_of_one_comes_in_a_request),
        WITH_LINE(a_deaf_one_misses_what_is_for_it),
        WITH_LINE(a_late_one_holds_up_nobody),
        WITH_LINE(a_kept_reply_is_said_once),
        WITH_LINE(a_kept_reply_goes_with_the_power),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

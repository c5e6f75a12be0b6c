/* SPDX-License-Identifier: MIT */
/*
 * The simulated wire of a clocked line with a protocol that is nothing like BiSS: what the wire,
 * its master and its traces do may depend on none; and how a plan makes a line.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "clocked_rig.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instrument.h"
#include "drehgeber/tenbit.h"
#include "host_rig.h"
#include "sim_rig.h"
#include "stacks.h"

#define BEGIN CLOCKED_RIG_BEGIN

/* What the master makes of a frame. */
static struct {
    enum dg_master_verdict verdict;
    bool error;
    bool warning;
} made;

static unsigned take_word(struct dg_bus_master *master)
{
    unsigned bits = 0;
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        bits = bits << 1 | dg_bus_master_bit(master);
    }
    return bits;
}

static void read_word(struct dg_bus_master *self)
{
    self->bits[0] = take_word(self);
    dg_bus_master_pause(self, self->now + DG_TENBIT_MONOFLOP + DG_US(1));
}

static enum dg_master_verdict judge(const struct dg_bus_master *self, size_t encoder)
{
    (void)self;
    (void)encoder;
    return made.verdict;
}

static void word(const struct dg_bus_master *self, size_t encoder, struct dg_master_word *out)
{
    *out = (struct dg_master_word){.bits = self->bits[encoder],
                                   .count = DG_TENBIT_BITS,
                                   .error = made.error,
                                   .warning = made.warning};
}

static void note(const struct dg_bus_master *self, size_t encoder, struct dg_text *to)
{
    dg_master_say(to, "word ", self->bits[encoder]);
}

static const struct dg_master_protocol reads = {
    .read = read_word,
    .judge = judge,
    .word = word,
    .note = note,
};

static const struct lx_clocked_protocol protocol = {
    .clock = "CLOCK",
    .data = "DATA",
    .master = &reads,
};

/* --- a master, and somebody who listens --- */

struct heard {
    struct lx_tap_listener listener;
    unsigned rises;
    bool clock;
    char note[64];
    enum dg_severity severity;
};

static struct host_rig_place place;
static struct dg_encoder control;
static struct lx_clocked *line;
static struct lx_tap tap;
static struct dg_bus_master master;
static struct heard heard;

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct heard *self = ctx;
    if (event->kind == DG_TAP_NOTE) {
        (void)snprintf(self->note, sizeof self->note, "%s", event->note);
        self->severity = event->severity;
        return;
    }
    self->rises += event->levels.clock && !self->clock;
    self->clock = event->levels.clock;
}

static void begin(const struct dg_plan_timing *timing)
{
    struct dg_host *host =
        dg_host_init_on_bus(place.bytes, sizeof place.bytes, &dg_tenbit_low, &dg_tenbit_side);
    control = (struct dg_encoder){.name = "a", .instrument = &dg_tenbit_instrument};
    assert_int_equal(dg_host_power(host, BEGIN, true), DG_OK);
    lx_clocked_close(line);
    line = lx_clocked_new(&protocol);
    assert_non_null(line);
    tap = (struct lx_tap){.first = NULL};
    heard = (struct heard){.listener = {.event = on_event, .ctx = &heard}, .clock = true};
    lx_tap_add(&tap, &heard.listener);
    made.verdict = DG_MASTER_GOOD;
    made.error = made.warning = false;
    clocked_rig_begin(&master, line, host, &control, timing, &tap);
}

static void begin_usual(void)
{
    begin(&(struct dg_plan_timing){.clock_hz = DG_PLAN_CLOCK_HZ});
}

static void turn_to(unsigned position)
{
    dg_host_shaft(dg_bus_encoder(line->bus, 0), 0, (int64_t)position * (DG_TURN >> DG_TENBIT_BITS),
                  0);
}

static unsigned word_of(unsigned position)
{
    turn_to(position);
    dg_bus_master_read(&master);
    return (unsigned)master.bits[0];
}

static void words_come_over_the_wire(void **state)
{
    (void)state;
    begin_usual();
    for (unsigned i = 0; i <= DG_TENBIT_ALL; i++) {
        assert_int_equal(word_of(i), i);
    }
    assert_string_equal(heard.note, "word 1023");
    assert_int_equal(heard.rises, DG_TENBIT_BITS * (DG_TENBIT_ALL + 1u));
    assert_int_equal(master.silent, 0);
}

static void a_note_is_as_bad_as_its_frame(void **state)
{
    static const struct {
        enum dg_master_verdict verdict;
        bool error;
        bool warning;
        enum dg_severity severity;
    } rows[] = {
        {DG_MASTER_GOOD, false, false, DG_SEVERITY_OK},
        {DG_MASTER_GOOD, false, true, DG_SEVERITY_WARNING},
        {DG_MASTER_GOOD, true, false, DG_SEVERITY_ERROR},
        {DG_MASTER_GOOD, true, true, DG_SEVERITY_ERROR},
        {DG_MASTER_WRONG, false, false, DG_SEVERITY_ERROR},
        {DG_MASTER_SILENT, false, false, DG_SEVERITY_ERROR},
    };
    (void)state;
    begin_usual();
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        made.verdict = rows[i].verdict;
        made.error = rows[i].error;
        made.warning = rows[i].warning;
        (void)word_of(1);
        assert_int_equal(heard.severity, rows[i].severity);
    }
    assert_string_equal(heard.note, "no answer");
}

/* Within the monoflop time the word stands still; behind it the line is high. */
static void clocks_go_on(void **state)
{
    (void)state;
    begin_usual();
    turn_to(0x155);
    assert_int_equal(take_word(&master), 0x155);
    turn_to(0x0AA);
    assert_false(dg_bus_master_bit(&master));
    assert_int_equal(take_word(&master), 0x155);
    const dg_ns end = master.now - DG_US(1) / 2 + DG_TENBIT_MONOFLOP;
    const bool data = line->data;
    dg_bus_master_pause(&master, end - 1u);
    assert_int_equal(dg_bus_next(line->bus), end);
    assert_int_equal(line->data, data);
    dg_bus_master_pause(&master, end);
    assert_true(line->data);
    assert_int_equal(word_of(0x0AA), 0x0AA);
}

/* Nobody measures the cable: it is as long as half a period allows. */
static void a_cable_is_not_made_up_for(void **state)
{
    (void)state;
    begin(&(struct dg_plan_timing){.clock_hz = DG_PLAN_CLOCK_HZ, .line_delay_ns = 249});
    assert_int_equal(word_of(0x2A5), 0x2A5);
    begin(&(struct dg_plan_timing){.clock_hz = DG_PLAN_CLOCK_HZ, .line_delay_ns = 251});
    assert_int_equal(word_of(0x2A5), DG_TENBIT_ALL & (1u << (DG_TENBIT_BITS - 1u) | 0x2A5u >> 1));
}

/* A frame behind them is like all others. */
static void faults_come_and_go_between_frames(void **state)
{
    (void)state;
    begin_usual();
    control.faults.wire = 1u << DG_WIRE_BREAK;
    control.faults.slot[DG_WIRE_BREAK] = DG_WIRE_BREAK;
    control.faults.fault[DG_WIRE_BREAK] =
        (struct dg_fault){.active = true, .probability_ppm = 1000000, .until = DG_NEVER};
    assert_int_equal(word_of(0x155), 0);
    assert_false(line->data);
    control.faults = (struct dg_faults){0};
    dg_bus_master_pause(&master, 0);
    assert_true(line->data);
    assert_int_equal(word_of(0x155), 0x155);
}

/* --- from a plan --- */

static void one_line_has_one_protocol(void **state)
{
    struct sim_rig rig;
    (void)state;
    sim_rig_plan(&rig, 3);
    rig.plan.encoders[2].model = dg_device_find("f3668");
    sim_rig_prepare(&rig);
    assert_string_equal(sim_rig_refused(&rig).text, "sim: f3668 cannot be on this wire");
    rig.plan.encoders[0].model = dg_device_find("s3684-rs485");
    assert_string_equal(sim_rig_refused(&rig).text, "sim: s3684-rs485 cannot be on this wire");
    rig.event = sd_event_unref(rig.event);
    plan_rig_free(&rig.plan);
}

static void a_line_has_no_more_encoders_than_its_protocol(void **state)
{
    struct sim_rig rig;
    (void)state;
    sim_rig_plan(&rig, 2);
    sim_rig_prepare(&rig);
    sim_rig_make(&rig); /* a chain has room for both */
    lx_engine_close(&rig.engine);
    rig.plan.wires[0].stack = dg_device_find("ssi-25")->stack;
    rig.plan.encoders[0].model = rig.plan.encoders[1].model = dg_device_find("ssi-25");
    assert_string_equal(sim_rig_refused(&rig).text,
                        "sim: this wire is full: expected at most 1 encoders");
    rig.event = sd_event_unref(rig.event);
    plan_rig_free(&rig.plan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_come_over_the_wire),
        cmocka_unit_test(a_note_is_as_bad_as_its_frame),
        cmocka_unit_test(clocks_go_on),
        cmocka_unit_test(a_cable_is_not_made_up_for),
        cmocka_unit_test(faults_come_and_go_between_frames),
        cmocka_unit_test(one_line_has_one_protocol),
        cmocka_unit_test(a_line_has_no_more_encoders_than_its_protocol),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    lx_clocked_close(line);
    return failed;
}

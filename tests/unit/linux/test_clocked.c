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

#include "biss_clocked.h"
#include "clocked_rig.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instrument.h"
#include "drehgeber/tenbit.h"
#include "host_rig.h"
#include "sim_master.h"
#include "sim_rig.h"

#define BEGIN DG_S(1)

/* The line, and what the master read last. */
struct word_line {
    struct lx_clocked base;
    unsigned got;
    enum lx_clocked_verdict verdict; /* what the master makes of it; likewise the next two */
    bool error;
    bool warning;
};

static unsigned take_word(struct lx_clocked_wire *wire)
{
    unsigned bits = 0;
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        bits = bits << 1 | lx_clocked_wire_bit(wire);
    }
    return bits;
}

static void read_word(struct lx_clocked *base, struct lx_clocked_wire *wire)
{
    ((struct word_line *)base)->got = take_word(wire);
    lx_clocked_wire_pause(wire, wire->now + DG_TENBIT_MONOFLOP + DG_US(1));
}

static enum lx_clocked_verdict judge(const struct lx_clocked *base, size_t encoder)
{
    (void)encoder;
    return ((const struct word_line *)base)->verdict;
}

static void word(const struct lx_clocked *base, size_t encoder, struct lx_clocked_word *out)
{
    const struct word_line *self = (const struct word_line *)base;
    (void)encoder;
    *out = (struct lx_clocked_word){
        .bits = self->got, .count = DG_TENBIT_BITS, .error = self->error, .warning = self->warning};
}

static void note(const struct lx_clocked *base, const struct lx_clocked_wire *wire, size_t encoder,
                 char *text, size_t size)
{
    (void)wire;
    (void)encoder;
    (void)snprintf(text, size, "word %u", ((const struct word_line *)base)->got);
}

static const struct lx_clocked_protocol protocol = {
    .clock = "CLOCK",
    .data = "DATA",
    .size = sizeof(struct word_line),
    .read = read_word,
    .judge = judge,
    .word = word,
    .note = note,
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
static struct word_line *line;
static struct lx_tap tap;
static struct lx_sim_master master;
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
    lx_clocked_close(line != NULL ? &line->base : NULL);
    line = (struct word_line *)lx_clocked_new(&protocol);
    assert_non_null(line);
    tap = (struct lx_tap){.first = NULL};
    heard = (struct heard){.listener = {.event = on_event, .ctx = &heard}, .clock = true};
    lx_tap_add(&tap, &heard.listener);
    const struct dg_bus_edges_setup cable = lx_clocked_wire_cable(timing);
    clocked_rig_connect(&line->base, host, &control, &cable, &tap);
    lx_sim_master_init(&master, &tap, &line->base, timing, BEGIN);
}

static void begin_usual(void)
{
    begin(&(struct dg_plan_timing){.clock_hz = DG_PLAN_CLOCK_HZ});
}

static void turn_to(unsigned position)
{
    dg_host_shaft(dg_bus_encoder(line->base.bus, 0), 0,
                  (int64_t)position * (DG_TURN >> DG_TENBIT_BITS), 0);
}

static unsigned word_of(unsigned position)
{
    turn_to(position);
    lx_sim_master_frame(&master);
    return line->got;
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
    assert_int_equal(master.wire.silent, 0);
}

static void a_note_is_as_bad_as_its_frame(void **state)
{
    static const struct {
        enum lx_clocked_verdict verdict;
        bool error;
        bool warning;
        enum dg_severity severity;
    } rows[] = {
        {LX_CLOCKED_GOOD, false, false, DG_SEVERITY_OK},
        {LX_CLOCKED_GOOD, false, true, DG_SEVERITY_WARNING},
        {LX_CLOCKED_GOOD, true, false, DG_SEVERITY_ERROR},
        {LX_CLOCKED_GOOD, true, true, DG_SEVERITY_ERROR},
        {LX_CLOCKED_WRONG, false, false, DG_SEVERITY_ERROR},
        {LX_CLOCKED_SILENT, false, false, DG_SEVERITY_ERROR},
    };
    (void)state;
    begin_usual();
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        line->verdict = rows[i].verdict;
        line->error = rows[i].error;
        line->warning = rows[i].warning;
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
    assert_int_equal(take_word(&master.wire), 0x155);
    turn_to(0x0AA);
    assert_false(lx_clocked_wire_bit(&master.wire));
    assert_int_equal(take_word(&master.wire), 0x155);
    const dg_ns end = master.wire.now - DG_US(1) / 2 + DG_TENBIT_MONOFLOP;
    const bool data = line->base.data;
    lx_clocked_wire_pause(&master.wire, end - 1u);
    assert_int_equal(dg_bus_next(line->base.bus), end);
    assert_int_equal(line->base.data, data);
    lx_clocked_wire_pause(&master.wire, end);
    assert_true(line->base.data);
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
    assert_false(line->base.data);
    control.faults = (struct dg_faults){0};
    lx_sim_master_pause(&master, 0);
    assert_true(line->base.data);
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
                        "sim: this wire is full: at most 1 encoders is right");
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
    lx_clocked_close(&line->base);
    return failed;
}

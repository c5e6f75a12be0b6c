/* SPDX-License-Identifier: MIT */
/*
 * Clocked lines with a protocol that is nothing like BiSS: a word, most significant bit first, from
 * the first falling edge on; no start bit, no Ack, no chain. What the wire, its cable, its master,
 * its faults and its traces do may depend on none of these.
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
#include "sim_master.h"
#include "sim_rig.h"

#define BITS 10u
#define MONOFLOP DG_US(20)
#define BEGIN DG_S(1)
#define ALL ((1u << BITS) - 1u)

/* The line, its one encoder, and what the master read last. */
struct plain {
    struct lx_clocked base;
    struct dg_line_fault fault;
    unsigned position; /* of the shaft */
    unsigned word;     /* as latched */
    unsigned left;     /* bits of it to come */
    dg_ns deadline;
    bool clock;
    bool data;
    unsigned got;
    enum lx_clocked_verdict verdict; /* what the master makes of it; likewise the next two */
    bool error;
    bool warning;
};

static struct plain *plain_of(struct lx_clocked *base)
{
    return (struct plain *)base;
}

static bool level(const struct lx_clocked *base)
{
    const struct plain *self = (const struct plain *)base;
    return dg_line_fault_level(&self->fault, self->data);
}

static void settle(struct lx_clocked *base)
{
    dg_line_fault_end(&plain_of(base)->fault);
}

static dg_ns step(struct lx_clocked *base, dg_ns now)
{
    struct plain *self = plain_of(base);
    if (self->deadline <= now) {
        self->deadline = DG_NEVER;
        self->data = true;
        settle(base);
    }
    return self->deadline;
}

/* Whoever clocks on gets the word again, behind a 0. */
static void shift(struct plain *self)
{
    if (self->left == 0) {
        self->data = false;
        self->left = BITS;
        return;
    }
    self->left--;
    self->data = (self->word >> self->left & 1u) != 0;
}

static bool edge(struct lx_clocked *base, dg_ns now, bool high)
{
    struct plain *self = plain_of(base);
    (void)step(base, now);
    if (high != self->clock && !high) {
        if (self->deadline == DG_NEVER) {
            self->word = self->position;
            self->left = BITS;
            dg_line_fault_begin(&self->fault);
        }
        self->deadline = now + MONOFLOP;
    } else if (high != self->clock) {
        shift(self);
        dg_line_fault_advance(&self->fault, self->data, base->period);
    }
    self->clock = high;
    return level(base);
}

static bool clocked(const struct lx_clocked *base)
{
    return ((const struct plain *)base)->clock;
}

static uint32_t rises(const struct lx_clocked *base)
{
    (void)base;
    return BITS;
}

static unsigned take_word(struct lx_clocked_wire *wire)
{
    unsigned bits = 0;
    for (unsigned i = 0; i < BITS; i++) {
        bits = bits << 1 | lx_clocked_wire_bit(wire);
    }
    return bits;
}

static void read_word(struct lx_clocked *base, struct lx_clocked_wire *wire)
{
    plain_of(base)->got = take_word(wire);
    lx_clocked_wire_pause(wire, wire->now + MONOFLOP + DG_US(1));
}

static enum lx_clocked_verdict judge(const struct lx_clocked *base, size_t encoder)
{
    (void)encoder;
    return ((const struct plain *)base)->verdict;
}

static void word(const struct lx_clocked *base, size_t encoder, struct lx_clocked_word *out)
{
    const struct plain *self = (const struct plain *)base;
    (void)encoder;
    *out = (struct lx_clocked_word){
        .bits = self->got, .count = BITS, .error = self->error, .warning = self->warning};
}

static void note(const struct lx_clocked *base, const struct lx_clocked_wire *wire, size_t encoder,
                 char *text, size_t size)
{
    (void)wire;
    (void)encoder;
    (void)snprintf(text, size, "word %u", ((const struct plain *)base)->got);
}

static const struct lx_clocked_ops ops = {
    .clock = "CLOCK",
    .data = "DATA",
    LX_CLOCKED_OPERATIONS,
    .read = read_word,
    .word = word,
};

/* --- a master, and somebody who listens --- */

struct heard {
    struct lx_tap_listener listener;
    unsigned rises;
    bool clock;
    char note[64];
    enum dg_severity severity;
};

static struct plain line;
static struct lx_tap tap;
static struct lx_sim_master master;
static struct dg_faults faults;
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

static void begin(const struct lx_clocked_timing *timing)
{
    line = (struct plain){
        .base = {.ops = &ops, .count = 1, .name = {"a"}},
        .fault = {.frame = {.bits = BITS, .delay = DG_US(3)}, .faults = &faults},
        .deadline = DG_NEVER,
        .clock = true,
        .data = true,
    };
    faults = (struct dg_faults){.random = 1};
    tap = (struct lx_tap){.first = NULL};
    heard = (struct heard){.listener = {.event = on_event, .ctx = &heard}, .clock = true};
    lx_tap_add(&tap, &heard.listener);
    lx_sim_master_init(&master, &tap, &line.base, timing, BEGIN);
}

static void begin_usual(void)
{
    begin(&(struct lx_clocked_timing){.clock_hz = LX_CLOCK_HZ});
}

static unsigned word_of(unsigned position)
{
    line.position = position;
    lx_sim_master_frame(&master);
    return line.got;
}

static void words_come_over_the_wire(void **state)
{
    (void)state;
    begin_usual();
    for (unsigned i = 0; i <= ALL; i++) {
        assert_int_equal(word_of(i), i);
    }
    assert_string_equal(heard.note, "word 1023");
    assert_int_equal(heard.rises, BITS * (ALL + 1u));
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
        line.verdict = rows[i].verdict;
        line.error = rows[i].error;
        line.warning = rows[i].warning;
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
    line.position = 0x155;
    assert_int_equal(take_word(&master.wire), 0x155);
    line.position = 0x0AA;
    assert_false(lx_clocked_wire_bit(&master.wire));
    assert_int_equal(take_word(&master.wire), 0x155);
    const dg_ns end = master.wire.now - DG_US(1) / 2 + MONOFLOP;
    lx_clocked_wire_pause(&master.wire, end - 1u);
    assert_int_equal(line.deadline, end);
    lx_clocked_wire_pause(&master.wire, end);
    assert_true(master.wire.data);
    assert_int_equal(word_of(0x0AA), 0x0AA);
}

/* Nobody measures the cable: it is as long as half a period allows. */
static void a_cable_is_not_made_up_for(void **state)
{
    (void)state;
    begin(&(struct lx_clocked_timing){.clock_hz = LX_CLOCK_HZ, .line_delay_ns = 249});
    assert_int_equal(word_of(0x2A5), 0x2A5);
    begin(&(struct lx_clocked_timing){.clock_hz = LX_CLOCK_HZ, .line_delay_ns = 251});
    assert_int_equal(word_of(0x2A5), ALL & (1u << (BITS - 1u) | 0x2A5u >> 1));
}

/* --- faults --- */

static void let_happen(enum dg_wire_fault fault, uint32_t count)
{
    faults.slot[fault] = (uint8_t)fault;
    faults.wire |= 1u << fault;
    faults.fault[fault] = (struct dg_fault){
        .active = true, .left = count, .probability_ppm = 1000000, .until = DG_NEVER};
}

static void a_dead_driver_reads_as_the_receiver_does(void **state)
{
    (void)state;
    for (unsigned open = 0; open < 2; open++) {
        begin_usual();
        line.fault.frame.open = open != 0;
        let_happen(DG_WIRE_DROP, 1);
        assert_int_equal(word_of(0x155), open * ALL);
        assert_int_equal(word_of(0x155), 0x155);
        let_happen(DG_WIRE_BREAK, 0);
        assert_int_equal(word_of(0x155), open * ALL);
        assert_int_equal(level(&line.base), open);
        faults = (struct dg_faults){0};
        lx_sim_master_pause(&master, 0);
        assert_true(level(&line.base));
    }
}

/* Of each of its bits, and of nothing else. */
static void a_damage_flips_a_bit_of_the_word(void **state)
{
    unsigned flipped = 0;
    (void)state;
    begin_usual();
    for (unsigned i = 0; i < 200; i++) {
        let_happen(DG_WIRE_DAMAGE, 1);
        const unsigned bit = word_of(0x155) ^ 0x155u;
        assert_true(bit != 0 && (bit & (bit - 1u)) == 0);
        flipped |= bit;
        assert_int_equal(word_of(0x155), 0x155);
    }
    assert_int_equal(flipped, ALL);
}

/* The line is as it was at rest until then. */
static void a_delay_moves_the_word(void **state)
{
    (void)state;
    begin_usual();
    let_happen(DG_WIRE_DELAY, 1);
    assert_int_equal(word_of(0x155), 7u << (BITS - 3u) | 0x155u >> 3);
    assert_int_equal(word_of(0x155), 0x155);
}

/* --- from a plan --- */

static void one_line_has_one_protocol(void **state)
{
    struct sim_rig rig;
    struct lx_error error = {.right = ""};
    (void)state;
    sim_rig_plan(&rig, 3);
    rig.plan.encoders[2].model = dg_device_find("f3668");
    sim_rig_stations(&rig);
    assert_null(lx_clocked_make(&rig.setup, LX_CLOCKED_HERE, &error));
    assert_string_equal(lx_error_line(&error).text, "f3668 cannot be on this wire");
    rig.plan.encoders[0].model = dg_device_find("s3684-rs485");
    assert_null(lx_clocked_make(&rig.setup, LX_CLOCKED_HERE, &error));
    assert_string_equal(lx_error_line(&error).text, "s3684-rs485 cannot be on this wire");
    rig.event = sd_event_unref(rig.event);
    lx_plan_free(&rig.plan);
}

static void a_line_has_no_more_encoders_than_its_protocol(void **state)
{
    struct sim_rig rig;
    struct lx_station *stations[LX_CLOCKED_MAX + 1u];
    struct lx_error error = {.right = ""};
    (void)state;
    sim_rig_plan(&rig, SIM_RIG_ENCODERS_MAX);
    sim_rig_stations(&rig);
    for (size_t i = 0; i < sizeof stations / sizeof stations[0]; i++) {
        stations[i] = rig.stations[i % SIM_RIG_ENCODERS_MAX];
    }
    rig.setup.stations = stations;
    rig.setup.count = lx_clocked_biss.encoders_max + 1u;
    assert_null(lx_clocked_make(&rig.setup, LX_CLOCKED_HERE, &error));
    assert_string_equal(lx_error_line(&error).text,
                        "this wire is full: at most 8 encoders is right");
    rig.setup.count = lx_clocked_biss.encoders_max;
    lx_clocked_close(lx_clocked_make(&rig.setup, LX_CLOCKED_HERE, &error));
    rig.event = sd_event_unref(rig.event);
    lx_plan_free(&rig.plan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_come_over_the_wire),
        cmocka_unit_test(a_note_is_as_bad_as_its_frame),
        cmocka_unit_test(clocks_go_on),
        cmocka_unit_test(a_cable_is_not_made_up_for),
        cmocka_unit_test(a_dead_driver_reads_as_the_receiver_does),
        cmocka_unit_test(a_damage_flips_a_bit_of_the_word),
        cmocka_unit_test(a_delay_moves_the_word),
        cmocka_unit_test(one_line_has_one_protocol),
        cmocka_unit_test(a_line_has_no_more_encoders_than_its_protocol),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

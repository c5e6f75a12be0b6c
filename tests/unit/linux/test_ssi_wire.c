/* SPDX-License-Identifier: MIT */
/*
 * An encoder with SSI on the simulated wire: what its master reads and says, faults, cable, clocks
 * that are too slow; and how a plan makes the line.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "clocked_rig.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"
#include "drehgeber/ssi.h"
#include "engine.h"
#include "host_rig.h"
#include "plan_rig.h"
#include "ssi_rig.h"
#include "stacks.h"
#include "station_rig.h"

#define BEGIN CLOCKED_RIG_BEGIN

static struct ssi_rig rig; /* world, shaft, model; not its encoder, nor its master */
static struct host_rig_place place;
static struct dg_encoder control;
static struct lx_clocked *line;
static struct dg_ssi *ssi;
static struct lx_tap tap;
static struct dg_bus_master master;

static void begin_with(const struct dg_ssi_model *model, const struct dg_plan_timing *timing)
{
    struct dg_host *host = dg_host_init_on_bus(place.bytes, sizeof place.bytes, &dg_ssi_25,
                                               dg_bus_side_of(&dg_ssi_25));
    control =
        (struct dg_encoder){.name = "a", .instrument = &dg_ssi_instrument, .faults.random = 1};
    assert_int_equal(ssi_rig_init(&rig, model), DG_OK);
    *(struct dg_ssi_model *)dg_host_line_of(host)->settings = *model;
    *dg_host_world(host) = rig.world;
    assert_int_equal(dg_host_power(host, BEGIN, true), DG_OK);
    lx_clocked_close(line);
    line = lx_clocked_new(lx_ssi_stack.clocked);
    assert_non_null(line);
    clocked_rig_begin(&master, line, host, &control, timing, &tap);
    ssi = dg_bus_device(line->bus, 0);
    dg_bus_master_pause(&master, BEGIN + model->init);
}

static void begin(const struct dg_device *device)
{
    begin_with(dg_ssi_model_of(device), &dg_plan_timing_usual);
}

/* The shaft at `count` of a turn and turns; the word that has to come. */
static uint64_t turn_to(uint32_t count)
{
    rig.angle = (dg_angle)count * (DG_TURN >> rig.model.singleturn_bits);
    return ssi_rig_word(&rig.model, count, false);
}

static enum dg_master_verdict read_word(void)
{
    dg_bus_master_read(&master);
    return dg_ssi_master.judge(&master, 0);
}

static void let_happen(enum dg_wire_fault fault, uint32_t count)
{
    control.faults.slot[fault] = (uint8_t)fault;
    control.faults.wire |= 1u << fault;
    control.faults.fault[fault] = (struct dg_fault){
        .active = true, .left = count, .probability_ppm = 1000000, .until = DG_NEVER};
}

/* --- words --- */

static void words_come_over_the_wire(void **state)
{
    static const struct dg_device *const devices[] = {&dg_ssi_13, &dg_ssi_25, &dg_ssi_28};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(devices); i++) {
        begin(devices[i]);
        const unsigned unused = 34u - ssi_rig_bits(&rig.model);
        for (uint32_t n = 1; n < 200; n++) {
            const uint64_t word = turn_to(n * 0x9E3779B1u >> (i < 2 ? unused - 2u : 4u));
            assert_int_equal(read_word(), DG_MASTER_GOOD);
            assert_int_equal(master.bits[0], word);
        }
        assert_int_equal(ssi->counters.frames, 199); /* each its own: the pause is enough */
        assert_int_equal(ssi->counters.repeats, 0);
        assert_int_equal(ssi->counters.aborted, 0);
        assert_int_equal(master.silent, 0);
        assert_int_equal(dg_ssi_master.rises(line->bus), ssi_rig_bits(&rig.model) + 1u);
    }
}

static void expect_texts(const char *printed, const char *noted)
{
    char text[DG_BUS_NOTE_MAX];
    struct dg_text to = dg_text_in(text, sizeof text);
    dg_ssi_master.line(&master, 0, &to);
    assert_string_equal(text, printed);
    to = dg_text_in(text, sizeof text);
    dg_ssi_master.note(&master, 0, &to);
    assert_string_equal(text, noted);
}

static void what_is_said_of_a_word(void **state)
{
    struct dg_ssi_model model = *dg_ssi_model_of(&dg_ssi_28);
    (void)state;
    begin(&dg_ssi_13);
    (void)turn_to(2048);
    assert_int_equal(read_word(), DG_MASTER_GOOD);
    expect_texts("MT 0  ST 2048  90.000000 deg", "position 0:2048");
    begin(&dg_ssi_28);
    (void)turn_to(3u << 16 | 1u << 15);
    dg_host_world(dg_bus_encoder(line->bus, 0))->watchdog_fired = true;
    assert_int_equal(read_word(), DG_MASTER_GOOD);
    expect_texts("MT 3  ST 32768  180.000000 deg  error 1  parity valid",
                 "position 3:32768  error 1  parity ok");
    master.bits[0] ^= 1u;
    assert_int_equal(dg_ssi_master.judge(&master, 0), DG_MASTER_WRONG);
    expect_texts("MT 3  ST 32768  180.000000 deg  error 1  parity WRONG",
                 "position 3:32768  error 1  parity wrong");
    model.parity = DG_SSI_PARITY_NONE;
    begin_with(&model, &dg_plan_timing_usual);
    assert_int_equal(read_word(), DG_MASTER_GOOD);
    expect_texts("MT 0  ST 0  0.000000 deg  error 0", "position 0:0  error 0");
}

static void without_power_nobody_answers(void **state)
{
    (void)state;
    begin(&dg_ssi_13);
    dg_ssi_power_off(ssi);
    dg_bus_master_pause(&master, master.now);
    assert_int_equal(read_word(), DG_MASTER_SILENT);
    assert_int_equal(master.silent, 1);
    dg_ssi_power_on(ssi, master.now);
    assert_int_equal(read_word(), DG_MASTER_SILENT); /* it is not ready yet */
    dg_bus_master_pause(&master, master.now + DG_S(1));
    assert_int_equal(read_word(), DG_MASTER_GOOD);
}

/* --- the wire --- */

static void clocks_from_one_word_in_a_monoflop_time_to_10_mhz(void **state)
{
    const struct dg_ssi_model *model = dg_ssi_model_of(&dg_ssi_25);
    static const uint32_t rates[] = {51000, 100000, 2000000, DG_PLAN_CLOCK_MAX_HZ};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rates); i++) {
        begin_with(model, &(struct dg_plan_timing){.clock_hz = rates[i]});
        const uint64_t word = turn_to(0x1234567);
        assert_int_equal(read_word(), DG_MASTER_GOOD);
        assert_int_equal(master.bits[0], word);
        assert_int_equal(ssi->counters.fast, i < 3 ? 0 : 25);
    }
    begin_with(model, &(struct dg_plan_timing){.clock_hz = DG_PLAN_CLOCK_MIN_HZ});
    (void)turn_to(0);
    assert_int_equal(read_word(), DG_MASTER_GOOD); /* which it cannot know */
    assert_int_equal(master.bits[0], (1u << 25) - 1u);
}

/* From no cable to 1 km of it, at clocks of which it takes many. */
static void a_cable_is_made_up_for(void **state)
{
    static const struct dg_plan_timing rows[] = {
        {.clock_hz = DG_PLAN_CLOCK_HZ, .line_delay_ns = 249, .compensate = true},
        {.clock_hz = DG_PLAN_CLOCK_HZ, .line_delay_ns = 250, .compensate = true},
        {.clock_hz = DG_PLAN_CLOCK_HZ, .line_delay_ns = 300, .compensate = true},
        {.clock_hz = DG_PLAN_CLOCK_HZ, .line_delay_ns = DG_BUS_CABLE_MAX_NS, .compensate = true},
        {.clock_hz = 100000, .line_delay_ns = DG_BUS_CABLE_MAX_NS, .compensate = true},
        {.clock_hz = 2000000, .line_delay_ns = 130, .compensate = true},
        {.clock_hz = DG_PLAN_CLOCK_MAX_HZ, .line_delay_ns = 777, .compensate = true},
        {.clock_hz = DG_PLAN_CLOCK_MAX_HZ,
         .line_delay_ns = DG_BUS_CABLE_MAX_NS,
         .compensate = true},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        begin_with(dg_ssi_model_of(&dg_ssi_28), &rows[i]);
        for (uint32_t n = 1; n < 50; n++) {
            const uint64_t word = turn_to(n * 0x9E3779B1u >> 4);
            assert_int_equal(read_word(), DG_MASTER_GOOD);
            assert_int_equal(master.bits[0], word);
        }
        assert_int_equal(ssi->counters.frames, 49);
        let_happen(DG_WIRE_DROP, 1);
        assert_int_equal(read_word(), DG_MASTER_SILENT);
    }
}

static void a_master_that_does_not_compensate_is_right_up_to_half_a_period(void **state)
{
    const struct dg_ssi_model *model = dg_ssi_model_of(&dg_ssi_13);
    struct dg_plan_timing timing = {.clock_hz = DG_PLAN_CLOCK_HZ, .line_delay_ns = 249};
    (void)state;
    begin_with(model, &timing);
    const uint64_t word = turn_to(4779);
    assert_int_equal(read_word(), DG_MASTER_GOOD);
    assert_int_equal(master.bits[0], word);
    timing.line_delay_ns = 251;
    begin_with(model, &timing);
    (void)turn_to(4779);
    (void)read_word();
    assert_int_equal(master.bits[0], 1u << 12 | word >> 1);
}

/* --- faults --- */

static void a_dead_driver_reads_low(void **state)
{
    (void)state;
    begin(&dg_ssi_13);
    const uint64_t word = turn_to(4779);
    let_happen(DG_WIRE_DROP, 1);
    assert_int_equal(read_word(), DG_MASTER_SILENT);
    assert_int_equal(read_word(), DG_MASTER_GOOD);
    assert_int_equal(master.bits[0], word);
    let_happen(DG_WIRE_BREAK, 0);
    dg_bus_master_pause(&master, 0);
    assert_false(line->data);
    assert_int_equal(read_word(), DG_MASTER_SILENT);
    assert_int_equal(read_word(), DG_MASTER_SILENT);
    control.faults = (struct dg_faults){0};
    dg_bus_master_pause(&master, 0);
    assert_true(line->data);
    assert_int_equal(read_word(), DG_MASTER_GOOD);
    assert_int_equal(master.silent, 3);
}

/* Only a parity bit tells. */
static void a_damage_flips_a_bit_of_the_word(void **state)
{
    static const struct dg_device *const devices[] = {&dg_ssi_13, &dg_ssi_28};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        uint64_t flipped = 0;
        begin(devices[i]);
        const uint64_t word = turn_to(4779);
        for (unsigned n = 0; n < 400; n++) {
            let_happen(DG_WIRE_DAMAGE, 1);
            assert_int_equal(read_word(), i == 0 ? DG_MASTER_GOOD : DG_MASTER_WRONG);
            const uint64_t bit = master.bits[0] ^ word;
            assert_true(bit != 0 && (bit & (bit - 1u)) == 0);
            flipped |= bit;
        }
        assert_int_equal(flipped, ((uint64_t)1 << ssi_rig_bits(&rig.model)) - 1u);
    }
}

static void a_delay_moves_the_word_by_a_clock(void **state)
{
    (void)state;
    begin(&dg_ssi_28);
    const uint64_t word = turn_to(0x1230001); /* no error, parity 1: no 0 behind it */
    let_happen(DG_WIRE_DELAY, 1);
    assert_int_equal(read_word(), DG_MASTER_SILENT);
    assert_int_equal(master.bits[0], 1u << 29 | word >> 1);
    assert_int_equal(read_word(), DG_MASTER_GOOD);
}

/* --- from a plan --- */

static struct dg_plan plan;
static struct lx_engine engine;

/* A wire that nobody opens. */
static struct {
    struct lx_bus bus;
    struct lx_clocked *line;
    enum lx_clocked_master who;
} wire;

static int check_settings(struct lx_bus *bus, struct lx_station *station, struct lx_error *error)
{
    return lx_clocked_check(wire.line, &bus->setup, station, error);
}

static void close_wire(struct lx_bus *bus)
{
    (void)bus;
    lx_clocked_close(wire.line);
}

static struct lx_bus *make_wire(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                struct lx_error *error)
{
    static const struct lx_bus_ops ops = {.check = check_settings, .close = close_wire};
    wire.bus = (struct lx_bus){.ops = &ops, .setup = *setup};
    wire.line = lx_clocked_make(setup, to, wire.who, error);
    assert_non_null(wire.line);
    return &wire.bus;
}

static int make_line(enum lx_clocked_master who, const char *setting, struct lx_error *error)
{
    static const struct lx_wire door = {.make = make_wire};
    struct lx_engine_setup setup = station_setup(&plan, NULL, NULL);
    struct dg_plan_encoder *encoder = &plan.encoders[0];
    lx_plan_free_settings(&encoder->settings);
    if (setting != NULL) {
        assert_int_equal(lx_plan_add_assignment(&encoder->settings, setting, 0, error), 0);
    }
    wire.who = who;
    setup.door = &door;
    return lx_engine_make(&engine, &setup, error);
}

static dg_ns monoflop_of(enum lx_clocked_master who, const char *setting)
{
    struct lx_error error = {.right = ""};
    assert_int_equal(make_line(who, setting, &error), 0);
    assert_int_equal(
        lx_clocked_open(wire.line, &wire.bus.setup, wire.bus.core, &tap, BEGIN, &error), 0);
    const struct dg_ssi *opened = engine.stations[0].control->device;
    const dg_ns monoflop = opened->setup.model->monoflop;
    assert_int_equal(opened->state, DG_SSI_START);
    assert_int_equal(lx_clocked_init(wire.line), DG_MS(100));
    lx_engine_close(&engine);
    return monoflop;
}

static void refuse(const char *setting, const char *right)
{
    struct lx_error error = {.right = ""};
    assert_int_equal(make_line(LX_CLOCKED_HERE, setting, &error), -1);
    assert_string_equal(lx_error_line(&error).text, right);
    lx_engine_close(&engine);
}

static void a_plan_makes_the_line(void **state)
{
    (void)state;
    begin(&dg_ssi_25);
    plan_rig_begin(&plan, "wire", dg_plan_find_kind("sim", 3), NULL);
    assert_int_equal(dg_plan_add_encoder(&plan, "a", &dg_ssi_25, 0, 0), 0);
    assert_int_equal(monoflop_of(LX_CLOCKED_HERE, NULL), DG_US(20));
    assert_int_equal(monoflop_of(LX_CLOCKED_THERE, NULL), DG_MS(20));
    assert_int_equal(monoflop_of(LX_CLOCKED_HERE, "monoflop_us=30"), DG_US(30));
    assert_int_equal(monoflop_of(LX_CLOCKED_THERE, "monoflop_us=20"), DG_US(20));
    refuse("monoflop_us=9", "monoflop_us=9: expected a number in 10..1000000 us");
    refuse("st=33", "st=33: expected a number in 1..32");
    refuse("st=7", "mt 12 and st 7; expected 10 to 32 bits together, mt 0..24 and st 8..31");
    refuse("st=21", "mt 12 and st 21; expected 10 to 32 bits together");
    refuse("parity=mark", "parity=mark: expected none, even or odd");
    plan.encoders[0].nvm = "x.nvm";
    refuse(NULL, "nvm: ssi-25 has no EEPROM; leave it out");
    plan.encoders[0].serial = "5";
    refuse(NULL, "serial 5: ssi-25 has none; leave it out");
    plan_rig_free(&plan);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_come_over_the_wire),
        cmocka_unit_test(what_is_said_of_a_word),
        cmocka_unit_test(without_power_nobody_answers),
        cmocka_unit_test(clocks_from_one_word_in_a_monoflop_time_to_10_mhz),
        cmocka_unit_test(a_cable_is_made_up_for),
        cmocka_unit_test(a_master_that_does_not_compensate_is_right_up_to_half_a_period),
        cmocka_unit_test(a_dead_driver_reads_low),
        cmocka_unit_test(a_damage_flips_a_bit_of_the_word),
        cmocka_unit_test(a_delay_moves_the_word_by_a_clock),
        cmocka_unit_test(a_plan_makes_the_line),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    lx_clocked_close(line);
    return failed;
}

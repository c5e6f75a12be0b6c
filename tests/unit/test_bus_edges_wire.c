/* SPDX-License-Identifier: MIT */
/*
 * The wire of a clocked bus: a cable delays what goes both ways, faults, what is held back for a
 * slow memory, hints. None of it knows a protocol.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/tenbit.h"
#include "edges_cable.h"
#include "edges_rig.h"

/* --- the cable --- */

static void a_cable_delays_both_ways(void **state)
{
    static const struct dg_bus_edges_setup wire = {
        .size = sizeof wire, .there_ns = 1200, .back_ns = 1700};
    uint64_t at;
    uint64_t counts;

    (void)state;
    edges_rig_begin(&wire, 1);
    (void)edges_rig_make(&edges_rig.place[0], &dg_tenbit_low, &dg_tenbit_side,
                         &dg_tenbit_instrument);
    dg_host_shaft(edges_rig.place[0].host, 0, 0x155 * (TURN >> DG_TENBIT_BITS), 0);
    edges_rig_attach(0);
    edges_rig_power(0, true);
    edges_rig_rest();
    edges_rig.heard_count = 0;
    const dg_ns first = edges_rig.now + EDGES_RIG_HALF;
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        (void)edges_rig_clock();
    }
    assert_int_equal(dg_host_latched(edges_rig.place[0].host, &at, &counts), DG_HOST_OK);
    assert_int_equal(at, first + 1200u);
    assert_int_equal(counts, 0x155);
    /* Bits change with each clock: the first is a 0. */
    const dg_ns monoflop = first + 9u * 2u * EDGES_RIG_HALF + 1200u + DG_TENBIT_MONOFLOP;
    assert_int_equal(dg_bus_edges_fell(edges_rig.bus), first + 17u * EDGES_RIG_HALF + 2900u);
    while (dg_bus_next(edges_rig.bus) != DG_NEVER) {
        (void)dg_bus_step(edges_rig.bus, dg_bus_next(edges_rig.bus));
    }
    assert_int_equal(edges_rig.heard_count, DG_TENBIT_BITS);
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        assert_int_equal(edges_rig.heard[i].at,
                         first + EDGES_RIG_HALF + (dg_ns)i * 2u * EDGES_RIG_HALF + 2900u);
        assert_int_equal(edges_rig.heard[i].levels.data, i % 2u);
    }
    assert_true(dg_bus_edges_data(edges_rig.bus, monoflop + 1700u));
}

/* An encoder that was silent for long enough when the edge gets there has ended its word. */
static void what_is_due_on_the_way_comes_first(void **state)
{
    static const struct dg_bus_edges_setup wire = {.size = sizeof wire, .there_ns = 1200};

    (void)state;
    edges_rig_begin(&wire, 1);
    (void)edges_rig_make(&edges_rig.place[0], &dg_tenbit_low, &dg_tenbit_side,
                         &dg_tenbit_instrument);
    edges_rig_attach(0);
    edges_rig_power(0, true);
    edges_rig_rest();
    (void)edges_rig_take(DG_TENBIT_BITS); /* all low */
    const dg_ns end = edges_rig.now - EDGES_RIG_HALF + 1200u + DG_TENBIT_MONOFLOP;
    edges_rig.heard_count = 0;
    (void)dg_bus_edge(edges_rig.bus, end - 600u, false);
    (void)dg_bus_edge(edges_rig.bus, end - 100u, true);
    (void)dg_bus_step(edges_rig.bus, end + 1200u);
    assert_int_equal(edges_rig.heard_count, 2);
    assert_int_equal(edges_rig.heard[0].at, end);
    assert_true(edges_rig.heard[0].levels.data);
    assert_int_equal(edges_rig.heard[1].at, end + 1100u);
}

/* Before it has arrived, too. */
static void a_master_looks_ahead(void **state)
{
    static const struct dg_bus_edges_setup wire = {
        .size = sizeof wire, .there_ns = DG_BUS_CABLE_MAX_NS, .back_ns = DG_BUS_CABLE_MAX_NS};
    uint64_t bits = 0;

    (void)state;
    edges_rig_begin(&wire, 1);
    (void)edges_rig_make(&edges_rig.place[0], &dg_tenbit_low, &dg_tenbit_side,
                         &dg_tenbit_instrument);
    dg_host_shaft(edges_rig.place[0].host, 0, 0x2B5 * (TURN >> DG_TENBIT_BITS), 0);
    edges_rig_attach(0);
    edges_rig_power(0, true);
    edges_rig_rest();
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        (void)edges_rig_clock();
        bits =
            bits << 1 | dg_bus_edges_data(edges_rig.bus, edges_rig.now + 2u * DG_BUS_CABLE_MAX_NS);
    }
    assert_int_equal(bits, 0x2B5);
}

static void a_cable_keeps_the_order(void **state)
{
    struct dg_bus_cable cable;
    struct dg_bus_cable_change change;
    (void)state;
    dg_bus_cable_init(&cable, 100, true);
    dg_bus_cable_put(&cable, 1000, true); /* no change */
    assert_false(dg_bus_cable_take(&cable, DG_NEVER, &change));
    dg_bus_cable_put(&cable, 1000, false);
    dg_bus_cable_put(&cable, 990, true); /* the past */
    assert_int_equal(cable.fell, 1100);
    assert_true(dg_bus_cable_level(&cable, 1099));
    assert_true(dg_bus_cable_level(&cable, 1100));
    dg_bus_cable_put(&cable, 1500, false);
    assert_false(dg_bus_cable_level(&cable, 1600));
    assert_false(dg_bus_cable_take(&cable, 1099, &change));
    assert_true(dg_bus_cable_take(&cable, 1100, &change));
    assert_false(change.level);
    assert_true(dg_bus_cable_take(&cable, 1100, &change));
    assert_true(change.level && cable.level && change.at == 1100);
    for (unsigned i = 0; i < 2u * DG_BUS_CABLE_CHANGES + 1u; i++) {
        dg_bus_cable_put(&cable, 2000 + i, i % 2u == 0);
    }
    while (dg_bus_cable_take(&cable, DG_NEVER, &change)) {
    }
    assert_true(cable.level); /* as it was put last */
}

static void setups_out_of_range_are_refused(void **state)
{
    static const struct dg_bus_edges_setup rows[] = {
        {.size = sizeof rows[0] - 1u},
        {.size = sizeof rows[0], .there_ns = DG_BUS_CABLE_MAX_NS + 1u},
        {.size = sizeof rows[0], .back_ns = DG_BUS_CABLE_MAX_NS + 1u},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_bus_setup setup = {.size = sizeof setup,
                                           .medium = &dg_bus_edges,
                                           .encoders = 1,
                                           .wire = &rows[i],
                                           .ops = &edges_rig.ops};
        assert_null(dg_bus_init(edges_rig.memory, sizeof edges_rig.memory, &setup));
    }
}

/* --- a protocol that nobody has --- */

static void begin_tenbit(const struct dg_device *model)
{
    edges_rig_begin(NULL, 1);
    (void)edges_rig_make(&edges_rig.place[0], model, &dg_tenbit_side, &dg_tenbit_instrument);
    edges_rig_attach(0);
    edges_rig_power(0, true);
    edges_rig_rest();
}

static unsigned word_of(unsigned position)
{
    dg_host_shaft(edges_rig.place[0].host, edges_rig.now,
                  (int64_t)position * (TURN >> DG_TENBIT_BITS), 0);
    const unsigned word = (unsigned)edges_rig_take(DG_TENBIT_BITS);

    edges_rig_rest();
    return word;
}

static void words_come_over_the_wire(void **state)
{
    (void)state;
    begin_tenbit(&dg_tenbit_low);
    edges_rig.taps = 0;
    for (unsigned i = 0; i <= DG_TENBIT_ALL; i++) {
        assert_int_equal(word_of(i), i);
    }
    /* Each edge, and the end of each word that ends low. */
    assert_int_equal(edges_rig.taps,
                     (DG_TENBIT_ALL + 1u) * (2u * DG_TENBIT_BITS) + (DG_TENBIT_ALL + 1u) / 2u);
}

static void a_dead_driver_reads_as_the_receiver_does(void **state)
{
    static const struct dg_device *const models[] = {&dg_tenbit_low, &dg_tenbit_high};

    (void)state;
    for (unsigned open = 0; open < 2; open++) {
        begin_tenbit(models[open]);
        edges_rig_bend(0, DG_WIRE_DROP, 1);
        assert_int_equal(word_of(0x155), open * DG_TENBIT_ALL);
        edges_rig_heal(0);
        assert_int_equal(word_of(0x155), 0x155);
        edges_rig_bend(0, DG_WIRE_BREAK, 0);
        assert_int_equal(dg_bus_edges_data(edges_rig.bus, edges_rig.now), open);
        assert_int_equal(word_of(0x155), open * DG_TENBIT_ALL);
        assert_int_equal(dg_bus_edges_data(edges_rig.bus, edges_rig.now), open);
        edges_rig_heal(0);
        assert_true(dg_bus_edges_data(edges_rig.bus, edges_rig.now));
    }
}

static void a_damage_flips_a_bit_of_the_word(void **state)
{
    unsigned flipped = 0;

    (void)state;
    begin_tenbit(&dg_tenbit_low);
    edges_rig_bend(0, DG_WIRE_DAMAGE, 0);
    for (unsigned i = 0; i < 200; i++) {
        const unsigned bit = word_of(0x155) ^ 0x155u;
        assert_true(bit != 0 && (bit & (bit - 1u)) == 0);
        flipped |= bit;
    }
    assert_int_equal(flipped, DG_TENBIT_ALL);
}

/* By the clock's own period, and by one that is said. */
static void a_delay_takes_whole_clocks(void **state)
{
    static const struct dg_bus_edges_setup slower = {.size = sizeof slower, .period_ns = 1500};

    (void)state;
    begin_tenbit(&dg_tenbit_low);
    edges_rig_bend(0, DG_WIRE_DELAY, 0);
    assert_int_equal(word_of(0x155), 7u << (DG_TENBIT_BITS - 3u) | 0x155u >> 3);
    edges_rig_heal(0);
    assert_int_equal(word_of(0x155), 0x155);
    edges_rig_begin(&slower, 1);
    (void)edges_rig_make(&edges_rig.place[0], &dg_tenbit_low, &dg_tenbit_side,
                         &dg_tenbit_instrument);
    edges_rig_attach(0);
    edges_rig_power(0, true);
    edges_rig_rest();
    edges_rig_bend(0, DG_WIRE_DELAY, 0);
    assert_int_equal(word_of(0x155), 3u << (DG_TENBIT_BITS - 2u) | 0x155u >> 2);
}

/* Time goes on all the same. */
static void an_encoder_that_asks_for_the_present_again_stops_nobody(void **state)
{
    static const struct dg_bus_edges_setup wire = {.size = sizeof wire, .there_ns = 100};
    struct dg_tenbit *device;

    (void)state;
    edges_rig_begin(&wire, 1);
    (void)edges_rig_make(&edges_rig.place[0], &dg_tenbit_low, &dg_tenbit_side,
                         &dg_tenbit_instrument);
    edges_rig_attach(0);
    edges_rig_power(0, true);
    device = dg_host_line_of(edges_rig.place[0].host)->device;
    device->stuck = true;
    for (unsigned i = 0; i < 20; i++) {
        edges_rig.now += 100;
        (void)dg_bus_edge(edges_rig.bus, edges_rig.now, i % 2u != 0);
    }
    assert_int_equal(device->frames, 1);
}

/* The same level again is no edge, and no clock to a fault. */
static void a_level_that_is_told_twice_is_one(void **state)
{
    unsigned word = 0;

    (void)state;
    begin_tenbit(&dg_tenbit_low);
    dg_host_shaft(edges_rig.place[0].host, 0, 0x155 * (TURN >> DG_TENBIT_BITS), 0);
    edges_rig_bend(0, DG_WIRE_DELAY, 0);
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        (void)edges_rig_clock();
        word = word << 1 | dg_bus_edge(edges_rig.bus, edges_rig.now, true);
    }
    assert_int_equal(word, 7u << (DG_TENBIT_BITS - 3u) | 0x155u >> 3);
}

/* --- a slow memory, and hints --- */

/* A frame that would acknowledge what is not durable yet is not sent, nor is it later. */
static void a_lone_encoder_is_held_back(void **state)
{
    (void)state;
    begin_tenbit(&dg_tenbit_high);
    edges_rig.ops.answer = edges_rig_answer;
    edges_rig.answer = DG_BUS_DROP;
    assert_int_equal(word_of(0x155), DG_TENBIT_ALL);
    edges_rig.answer = DG_BUS_SAY;
    assert_int_equal(word_of(0x155), 0x155);
}

static void a_hint_comes_once_for_the_line(void **state)
{
    dg_ns due;

    (void)state;
    edges_rig_begin(NULL, 2);
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(dg_host_set(edges_rig_model(i, "s3684-biss"), "hint_us", "1000000"),
                         DG_HOST_OK);
        edges_rig_attach(i);
    }
    edges_rig_power(0, true);
    assert_null(dg_bus_edges_hint(edges_rig.bus, 0, &due)); /* its neighbour is silent, too */
    assert_int_equal(due, DG_NEVER);
    edges_rig_power(1, true);
    assert_null(dg_bus_edges_hint(edges_rig.bus, DG_MS(1), &due));
    assert_int_equal(due, DG_MS(1) + DG_S(1));
    assert_string_equal(dg_bus_edges_hint(edges_rig.bus, due, &due), DG_BISS_HINT);
    assert_null(dg_bus_edges_hint(edges_rig.bus, DG_S(9), &due));
    assert_int_equal(due, DG_NEVER);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cable_delays_both_ways),
        cmocka_unit_test(what_is_due_on_the_way_comes_first),
        cmocka_unit_test(a_master_looks_ahead),
        cmocka_unit_test(a_cable_keeps_the_order),
        cmocka_unit_test(setups_out_of_range_are_refused),
        cmocka_unit_test(words_come_over_the_wire),
        cmocka_unit_test(a_dead_driver_reads_as_the_receiver_does),
        cmocka_unit_test(a_damage_flips_a_bit_of_the_word),
        cmocka_unit_test(a_delay_takes_whole_clocks),
        cmocka_unit_test(a_level_that_is_told_twice_is_one),
        cmocka_unit_test(an_encoder_that_asks_for_the_present_again_stops_nobody),
        cmocka_unit_test(a_lone_encoder_is_held_back),
        cmocka_unit_test(a_hint_comes_once_for_the_line),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

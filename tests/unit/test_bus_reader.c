/* SPDX-License-Identifier: MIT */
/*
 * The master of a clocked line that reads by itself: which frames are clocked, and that those which
 * are only counted come to the same.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/bus_reader.h"
#include "edges_rig.h"

#define INIT DG_MS(50)
#define FIRST (READY + INIT)

static struct dg_bus_reader reader;
static uint64_t noted;

static void count_note(void *ctx, const struct dg_tap_event *event)
{
    (void)ctx;
    noted += event->kind == DG_TAP_NOTE ? 1u : 0u;
}

static void begin(void)
{
    struct dg_bus_master_setup setup = {
        .size = sizeof setup, .protocol = &dg_biss_master, .clock_hz = 1000000};
    const struct dg_bus_edges_setup wire = dg_bus_master_wire(&setup);

    noted = 0;
    edges_rig_begin(&wire, 1);
    edges_rig.ops.tap = count_note;
    (void)dg_host_set(edges_rig_model(0, "s3684-biss"), "busy_jitter_us", "0");
    edges_rig_attach(0);
    edges_rig_power(0, true);
    setup.bus = edges_rig.bus;
    dg_bus_reader_init(&reader, &setup, INIT, READY);
    dg_bus_reader_watch(&reader, false);
}

static uint64_t run(dg_ns now)
{
    dg_bus_reader_run(&reader, now);
    return reader.counters.frames;
}

static void frames_at_rest_are_counted(void **state)
{
    (void)state;
    begin();
    assert_int_equal(run(READY), 0);
    assert_int_equal(dg_bus_reader_next(&reader), FIRST);
    assert_int_equal(run(FIRST - 1), 0);
    assert_int_equal(run(FIRST), 1);
    assert_int_equal(dg_bus_reader_next(&reader), FIRST + DG_MS(100));
    /* For 300 ms behind the longest initialisation each one is clocked. */
    assert_int_equal(run(FIRST + DG_MS(349)), 4);
    assert_true(dg_bus_reader_next(&reader) == DG_NEVER);
    assert_int_equal(run(FIRST + DG_S(100)), 1001);
    assert_true(dg_bus_reader_next(&reader) == DG_NEVER);
    assert_true(reader.master.now < FIRST + DG_S(100) + DG_MS(1));
    assert_int_equal(reader.master.silent, 0);
    dg_bus_reader_stir(&reader, FIRST + DG_S(100));
    assert_int_equal(dg_bus_reader_next(&reader), FIRST + DG_S(100) + DG_MS(100));
    assert_int_equal(run(FIRST + DG_S(100) + DG_MS(349)), 1004);
    assert_true(dg_bus_reader_next(&reader) == DG_NEVER);
    assert_int_equal(noted, 0);
}

static void whoever_watches_wants_each_frame(void **state)
{
    (void)state;
    begin();
    (void)run(FIRST + DG_S(1));
    dg_bus_reader_watch(&reader, true);
    for (unsigned i = 1; i <= 20; i++) {
        const dg_ns at = FIRST + DG_S(1) + i * DG_MS(100);
        assert_int_equal(dg_bus_reader_next(&reader), at);
        assert_int_equal(run(at), 11 + i);
        assert_int_equal(noted, i);
    }
    /* Of many that are late the oldest are left out. */
    assert_int_equal(run(FIRST + DG_S(1003)), 31 + 1001);
    assert_int_equal(noted, 20 + 1001);
}

/* What a reader has come to at the end of a life with a fault in it. */
struct life {
    struct dg_bus_reader_counters counters;
    uint32_t silent;
    struct dg_master_word word;
};

static struct life live(bool watched, enum dg_wire_fault fault, uint32_t count)
{
    const dg_ns bent = FIRST + DG_S(2) + DG_MS(30);
    const dg_ns healed = bent + DG_S(3);
    const dg_ns end = FIRST + DG_S(20);
    struct life life = {.silent = 0};

    begin();
    dg_bus_reader_watch(&reader, watched);
    (void)run(bent);
    edges_rig.now = bent;
    edges_rig_bend(0, fault, count);
    dg_bus_reader_stir(&reader, bent);
    (void)run(healed);
    edges_rig.now = reader.master.now > healed ? reader.master.now : healed;
    edges_rig_heal(0);
    dg_bus_reader_stir(&reader, healed);
    (void)run(end);
    life.counters = reader.counters;
    life.silent = reader.master.silent;
    assert_int_equal(reader.master.setup.protocol->judge(&reader.master, 0), DG_MASTER_GOOD);
    reader.master.setup.protocol->word(&reader.master, 0, &life.word);
    return life;
}

static void counted_and_clocked_agree(void **state)
{
    static const struct {
        enum dg_wire_fault fault;
        uint32_t count;
    } rows[] = {
        {DG_WIRE_DROP, 1},  {DG_WIRE_DROP, 7},   {DG_WIRE_DROP, 0},
        {DG_WIRE_BREAK, 0}, {DG_WIRE_DAMAGE, 1}, {DG_WIRE_DAMAGE, 0},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct life lazy = live(false, rows[i].fault, rows[i].count);
        const struct life each = live(true, rows[i].fault, rows[i].count);
        assert_int_equal(lazy.counters.frames, each.counters.frames);
        assert_int_equal(lazy.counters.frames, 201);
        assert_int_equal(lazy.counters.wrong, each.counters.wrong);
        assert_int_equal(lazy.silent, each.silent);
        assert_true(lazy.silent + lazy.counters.wrong > 0);
        assert_int_equal(lazy.word.bits, each.word.bits);
        assert_int_equal(lazy.word.life, each.word.life);
    }
}

/* An encoder without power has no answer, also in frames that are only counted. */
static void silent_frames_are_counted_as_such(void **state)
{
    (void)state;
    begin();
    edges_rig_power(0, false);
    dg_bus_reader_stir(&reader, READY);
    assert_int_equal(run(FIRST + DG_S(60)), 601);
    assert_int_equal(reader.master.silent, 601);
    assert_true(dg_bus_reader_next(&reader) == DG_NEVER);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_at_rest_are_counted),
        cmocka_unit_test(whoever_watches_wants_each_frame),
        cmocka_unit_test(counted_and_clocked_agree),
        cmocka_unit_test(silent_frames_are_counted_as_such),
    };
    return cmocka_run_group_tests_name("a master that reads by itself", tests, NULL, NULL);
}

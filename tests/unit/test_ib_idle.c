/* SPDX-License-Identifier: MIT */
/*
 * Two couplers with the same ring and the same fate: one runs every cycle at its moment, the other
 * one as dg_ring_master does. Random clients, faults, worlds and power; whoever looks sees the same,
 * and what the one has stored at any time, the other one has, too.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/ring_coupler.h"
#include "drehgeber/ring_master.h"
#include "effort.h"
#include "ring_rig.h"

#define START DG_S(1)
#define DEVICES 3u
#define K3 1u /* the words 1 and 2 */
#define OUT_AT 0x0801u
#define MEMORY_MAX 4096u

/* A shaft that turns steadily. */
struct shaft {
    dg_angle angle;
    int64_t per_us;
};

struct side {
    struct ring_rig rig; /* first: dg_bus_ops have it */
    struct shaft shaft;
    struct dg_ring_master master;
    struct dg_ib_coupler coupler;
    uint64_t runs;
};

static struct side lazy;
static struct side eager;
static struct side *const sides[] = {&eager, &lazy};
static dg_ns eager_next;
static dg_ns period;
static dg_ns now;
static uint32_t noise;
static bool broken; /* a fault of the ring is there for long enough */

static uint32_t next(void)
{
    noise = noise * 1664525u + 1013904223u;
    return noise >> 8;
}

static bool one_in(uint32_t n)
{
    return next() % n == 0;
}

static dg_angle angle(void *ctx, dg_ns at)
{
    const struct shaft *self = ctx;
    return (dg_angle)((uint64_t)self->angle + (uint64_t)self->per_us * (at / 1000u));
}

static void count_run(void *ctx, const struct dg_tap_event *event)
{
    struct side *self = ctx;
    self->runs += event->kind == DG_TAP_WORDS ? 1u : 0u;
}

/* --- both sides --- */

static void open_side(struct side *self, dg_ns every)
{
    static const char *const models[DEVICES] = {"ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2"};
    memset(self, 0, sizeof *self);
    ring_rig_init(&self->rig);
    self->rig.wire.identifies = true;
    self->rig.ops.tap = count_run;
    self->rig.now = START;
    for (size_t i = 0; i < DEVICES; i++) {
        struct dg_world *world = dg_host_world(ring_rig_add(&self->rig, models[i]));
        world->angle = angle;
        world->angle_ctx = &self->shaft;
        world->calm = NULL;
    }
    ring_rig_open(&self->rig);
    const struct dg_ring_master_setup setup = {sizeof setup, self->rig.bus, self->rig.out, every};
    dg_ring_master_init(&self->master, &setup);
    dg_ib_coupler_init(&self->coupler, &self->master, false);
}

static void open_both(uint32_t seed)
{
    static const dg_ns periods[] = {DG_US(250), DG_US(333), DG_MS(1), DG_MS(7), DG_MS(50)};
    noise = seed;
    now = START;
    period = periods[next() % (DG_COUNT(periods))];
    broken = false;
    open_side(&eager, 0);
    open_side(&lazy, period);
    assert_int_equal(dg_ring_master_next(&lazy.master), 0);
    dg_ring_master_due(&lazy.master, now);
    eager_next = now;
}

static const struct dg_ib *device_of(const struct side *self, size_t place)
{
    return ring_rig_device(&self->rig, place);
}

/* --- time --- */

static void run_eager(void)
{
    for (; eager_next <= now; eager_next += period) {
        (void)dg_ring_master_cycle(&eager.master, eager_next);
    }
}

/* What would be there after the processes have died. */
static void check_stored(void)
{
    uint8_t is[MEMORY_MAX];
    uint8_t wanted[MEMORY_MAX];
    const size_t n = dg_host_memory_size(eager.rig.encoders[K3]);
    assert_in_range(n, 1, MEMORY_MAX);
    assert_int_equal(dg_host_memory_copy(lazy.rig.encoders[K3], is, n), DG_HOST_OK);
    assert_int_equal(dg_host_memory_copy(eager.rig.encoders[K3], wanted, n), DG_HOST_OK);
    assert_memory_equal(is, wanted, n);
}

/* Time goes on; the lazy one is woken when it wants to be, unless the loop is busy. */
static void pass(dg_ns span)
{
    const bool busy = one_in(8);
    now += span;
    run_eager();
    while (!busy && dg_ring_master_next(&lazy.master) <= now) {
        dg_ring_master_due(&lazy.master, dg_ring_master_next(&lazy.master));
    }
    if (!busy) {
        check_stored();
    }
}

static dg_ns some_time(void)
{
    static const dg_ns spans[] = {1,        DG_US(1),  DG_US(100), DG_MS(1),
                                  DG_MS(3), DG_MS(30), DG_MS(200), DG_S(2)};
    if (one_in(8)) { /* just before a cycle, or at it */
        return eager_next + period * (next() % 100u) - next() % 2u - now;
    }
    const dg_ns span = spans[next() % (DG_COUNT(spans))];
    const dg_ns long_span = period * 5000u + DG_S(next() % 700u);
    return one_in(40) && period >= DG_MS(7) ? long_span : 1u + span * (next() % 1000u) / 500u;
}

/* --- looking --- */

#define SAME(field) assert_int_equal(is->field, wanted->field)

static void check_device(const struct dg_ib *is, const struct dg_ib *wanted)
{
    assert_memory_equal(&is->counters, &wanted->counters, sizeof wanted->counters);
    /* Behind the last field there is padding, which a copy need not take along. */
    assert_memory_equal(&is->program, &wanted->program,
                        offsetof(struct dg_ib_program, off_given) + 1u);
    SAME(powered), SAME(reconfigure), SAME(crc_error), SAME(outgoing_off), SAME(invalid);
    SAME(ready_at), SAME(last_id), SAME(last_data), SAME(time_10min), SAME(time_mark);
    SAME(out), SAME(pending), SAME(wait), SAME(frozen), SAME(answer), SAME(item);
    SAME(last_command), SAME(last_error), SAME(lost), SAME(sent.waits), SAME(sent.judged);
    SAME(steps), SAME(revolutions), SAME(preset), SAME(offset), SAME(shift), SAME(direction);
    SAME(preset_flag), SAME(mode), SAME(shift_iw), SAME(program_number);
    assert_int_equal(dg_ib_leds(is, now), dg_ib_leds(wanted, now));
    assert_int_equal(dg_ib_position(is, now), dg_ib_position(wanted, now));
}

static void check_registers(struct dg_ib_registers range)
{
    uint16_t is[64];
    uint16_t wanted[64];
    dg_ib_coupler_read(&lazy.coupler, range, is);
    dg_ib_coupler_read(&eager.coupler, range, wanted);
    assert_memory_equal(is, wanted, range.count * sizeof is[0]);
}

static void look_at_rings(void)
{
    const struct dg_ring_state *is = dg_ring_state(lazy.rig.bus);
    const struct dg_ring_state *wanted = dg_ring_state(eager.rig.bus);
    dg_ring_master_to(&lazy.master, now);
    assert_int_equal(lazy.master.stopped, eager.master.stopped);
    SAME(result), SAME(reached);
    assert_memory_equal(&is->counters, &wanted->counters, sizeof wanted->counters);
    assert_memory_equal(lazy.rig.in, eager.rig.in, sizeof eager.rig.in);
    assert_memory_equal(lazy.rig.out, eager.rig.out, sizeof eager.rig.out);
    for (size_t i = 0; i < DEVICES; i++) {
        assert_int_equal(dg_ring_id_word(lazy.rig.bus, i), dg_ring_id_word(eager.rig.bus, i));
        check_device(device_of(&lazy, i), device_of(&eager, i));
    }
    check_stored();
}

/* --- what happens to them --- */

static void read_by_a_client(void)
{
    static const struct dg_ib_registers ranges[] = {
        {0x0000, 5}, {0x0800, 5}, {0x100C, 1}, {0x1014, 2}, {0x1020, 1}, {0x1120, 4}, {0x2000, 48}};
    for (size_t i = 0; i < 2; i++) {
        dg_ib_coupler_request(&sides[i]->coupler, now);
    }
    check_registers(ranges[next() % (DG_COUNT(ranges))]);
}

static void write_by_a_client(uint16_t first, const uint16_t *values, uint16_t count)
{
    for (size_t i = 0; i < 2; i++) {
        dg_ib_coupler_request(&sides[i]->coupler, now);
        assert_true(dg_ib_coupler_write(&sides[i]->coupler, (struct dg_ib_registers){first, count},
                                        values));
    }
}

static void write_out(void)
{
    static const uint32_t words[][2] = {
        {0x00000000, 0},          {0x80000000, 0},    {0x40000000, 0},    {0x60000000, 0},
        {0x02000000, 0x1FFF},     {0x04000000, 0x1F}, {0x06000000, 7},    {0x08000000, 0x00FFFFFF},
        {0x0A000000, 0xFFFF},     {0x0E000000, 0},    {0x20400000, 0xFF}, {0x20800000, 0x0F},
        {0x20210000, 0x0F},       {0x20100000, 0x1F}, {0x20200000, 0x3F}, {0x40000000, 0x0E0000FF},
        {0x60000000, 0x0E0000FF}, {0x60000000, 0},
    };
    const uint32_t *const row = words[next() % (DG_COUNT(words))];
    const uint32_t word = row[0] | (next() & row[1]);
    const uint16_t values[] = {(uint16_t)(word >> 16), (uint16_t)word};
    write_by_a_client(OUT_AT, values, 2);
}

static void write_watchdog(void)
{
    const uint16_t times[] = {0, 1, 20, 100, 1000, 60000};
    const uint16_t values[][2] = {{0x1120, times[next() % 6u]},
                                  {0x1122, (uint16_t)(next() % 2u)},
                                  {0x1123, (uint16_t)(next() % 3u)},
                                  {0x1121, 0xBECF},
                                  {0x1121, 0xAFFE}};
    const uint16_t *const row = values[next() % 5u];
    write_by_a_client(row[0], &row[1], 1);
}

static void change_world(void)
{
    const uint32_t how = next();
    const uint32_t where = next();
    dg_ring_master_to(&lazy.master, now);
    for (size_t i = 0; i < 2; i++) {
        for (size_t n = 0; n < DEVICES; n++) {
            struct dg_world *world = ring_rig_world(&sides[i]->rig, n);
            world->singleturn_ok = how % 4u != 0;
            world->multiturn_sync_ok = how / 4u % 8u != 0;
            world->eeprom_acknowledges = how / 32u % 8u != 0;
            world->temperature_mdegc = (int32_t)(where % 100000u);
        }
        sides[i]->shaft.per_us = how / 256u % 3u == 0 ? 0 : (int64_t)(where % 2000000u) - 1000000;
        sides[i]->shaft.angle = (dg_angle)((uint64_t)where << 24);
    }
    dg_ring_master_stir(&lazy.master);
}

static void switch_power(void)
{
    const uint32_t which = next() % DEVICES;
    const bool on = !one_in(3);
    dg_ring_master_to(&lazy.master, now);
    for (size_t i = 0; i < 2; i++) {
        sides[i]->rig.now = now;
        ring_rig_power(&sides[i]->rig, which, on);
    }
    dg_ring_master_stir(&lazy.master);
}

static void hurt_ring(void)
{
    const uint16_t where = (uint16_t)(next() % DEVICES);
    const bool corrupt = one_in(2);
    broken = !broken;
    dg_ring_master_to(&lazy.master, now);
    for (size_t i = 0; i < 2; i++) {
        struct dg_bus *bus = sides[i]->rig.bus;
        dg_ring_cut(bus, broken && !corrupt ? where : DG_RING_WHOLE);
        if (corrupt) {
            dg_ring_spoil(bus, where);
        }
        ((struct dg_ib *)dg_bus_device(bus, where))->reconfigure = true;
    }
    dg_ring_master_stir(&lazy.master);
}

/* A wire fault takes cycles away, and comes to its end by itself or is taken away. */
static void bend_ring(void)
{
    const uint32_t which = next() % DEVICES;
    const enum dg_wire_fault fault = one_in(2) ? DG_WIRE_DROP : DG_WIRE_DAMAGE;
    dg_ring_master_to(&lazy.master, now);
    for (size_t i = 0; i < 2; i++) {
        sides[i]->rig.now = now;
        ring_rig_bend(&sides[i]->rig, which, fault, 5);
    }
    dg_ring_master_changed(&lazy.master, false, now);
    for (int i = 0; i < 20; i++) {
        assert_true(!lazy.master.bent || dg_ring_master_next(&lazy.master) == eager_next);
        now = eager_next;
        run_eager();
        dg_ring_master_due(&lazy.master, now);
        look_at_rings();
    }
    for (size_t i = 0; i < 2; i++) {
        ring_rig_mend(&sides[i]->rig, which, fault);
    }
    dg_ring_master_changed(&lazy.master, false, now);
    assert_false(lazy.master.bent);
}

/* Watched, it is run in real time: here it is never late. */
static void watch(void)
{
    dg_ring_master_changed(&lazy.master, true, now);
    assert_int_equal(dg_ring_master_next(&lazy.master), eager_next);
    for (int i = 0; i < 20; i++) {
        now = eager_next;
        run_eager();
        dg_ring_master_due(&lazy.master, now);
        look_at_rings();
    }
    dg_ring_master_changed(&lazy.master, false, now);
}

static void fates(uint32_t seed)
{
    static void (*const happenings[])(void) = {
        look_at_rings, look_at_rings, read_by_a_client, read_by_a_client, write_out,
        write_out,     write_out,     write_out,        write_out,        write_watchdog,
        change_world,  switch_power,  hurt_ring,        bend_ring,        watch,
    };
    open_both(seed);
    for (int i = 0; i < 300; i++) {
        pass(some_time());
        happenings[next() % (DG_COUNT(happenings))]();
    }
    pass(DG_S(1));
    look_at_rings();
}

static void lazy_and_eager_agree(void **state)
{
    const uint32_t seeds = effort(24, 120);
    (void)state;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        fates(seed);
    }
}

/* A day without anybody: the operating time is stored every ten minutes, and that is all. */
static void a_day_alone(void **state)
{
    (void)state;
    open_both(4711);
    dg_ring_master_to(&lazy.master, now + DG_S(1));
    const uint64_t before = lazy.runs;
    while (dg_ring_master_next(&lazy.master) <= START + DG_S(86400)) {
        dg_ring_master_due(&lazy.master, dg_ring_master_next(&lazy.master));
    }
    assert_true(lazy.runs - before <= 3u * 144u);
    assert_int_equal(device_of(&lazy, K3)->time_10min, 144);
    dg_ring_master_to(&lazy.master, START + DG_S(86400));
    const uint64_t cycles = DG_S(86400) / period; /* the first one was an ID cycle, too */
    assert_int_equal(dg_ring_state(lazy.rig.bus)->counters.cycles, (uint32_t)(cycles + 1u));
    assert_int_equal(device_of(&lazy, K3)->counters.cycles, (uint32_t)cycles);
}

static void write_register(uint16_t address, uint16_t value)
{
    assert_true(dg_ib_coupler_write(&lazy.coupler, (struct dg_ib_registers){address, 1}, &value));
}

/* K1 and K2 store nothing: nothing wakes them. A watchdog does, once. */
static void what_wakes_a_ring(void **state)
{
    const uint16_t ms = 100;
    const uint16_t stop = DG_RING_FALLBACK_STOP;
    (void)state;
    open_both(1);
    period = DG_MS(1);
    lazy.master.setup.period = period;
    lazy.master.next = START + period;
    now = START + DG_S(1);
    dg_ring_master_to(&lazy.master, now);
    assert_int_equal(dg_ring_master_next(&lazy.master), START + DG_S(600));
    struct dg_ib_model *model = dg_host_line_of(lazy.rig.encoders[K3])->settings;
    model->profile = DG_IB_K2;
    assert_true(dg_ring_master_next(&lazy.master) == DG_NEVER);
    model->profile = DG_IB_K3;
    dg_ib_coupler_request(&lazy.coupler, now);
    write_register(0x1120, ms);
    write_register(0x1123, stop);
    assert_true(dg_ib_coupler_write(&lazy.coupler, (struct dg_ib_registers){OUT_AT, 2},
                                    (const uint16_t[]){0, 0}));
    assert_int_equal(dg_ring_master_next(&lazy.master), now + DG_MS(1));
    dg_ring_master_due(&lazy.master, now + DG_MS(1));
    /* It fires in the first cycle that comes later than its time. */
    assert_int_equal(dg_ring_master_next(&lazy.master), now + DG_MS(101));
    dg_ring_master_due(&lazy.master, now + DG_MS(100));
    assert_false(lazy.master.watchdog.fired);
    dg_ring_master_due(&lazy.master, now + DG_MS(101));
    assert_true(lazy.master.watchdog.fired);
    assert_true(dg_ring_master_next(&lazy.master) == DG_NEVER); /* ID cycles only */
}

/* Late, a watched ring leaves cycles out and counts them; one that is not is never late. */
static void late(void **state)
{
    (void)state;
    open_both(2);
    dg_ring_master_to(&lazy.master, START + 10u * period);
    assert_int_equal(lazy.master.missed, 0);
    dg_ring_master_changed(&lazy.master, true, START + 10u * period);
    const uint64_t before = lazy.runs;
    dg_ring_master_due(&lazy.master, START + 14u * period + 1u);
    assert_int_equal(lazy.master.missed, 3);
    assert_int_equal(lazy.runs - before, 1);
    assert_int_equal(dg_ring_master_next(&lazy.master), START + 15u * period);
    dg_ring_master_to(&lazy.master, START + 20u * period); /* only when it is due */
    assert_int_equal(lazy.runs - before, 1);
    dg_ring_master_due(&lazy.master, START + 15u * period - 1u); /* too soon */
    assert_int_equal(lazy.runs - before, 1);
    dg_ring_master_changed(&lazy.master, false, START + 15u * period);
    dg_ring_master_to(&lazy.master, START + 1000u * period);
    assert_int_equal(lazy.master.missed, 3);
    assert_int_equal(dg_ring_state(lazy.rig.bus)->counters.cycles, 1001u - 3u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lazy_and_eager_agree),
        cmocka_unit_test(a_day_alone),
        cmocka_unit_test(what_wakes_a_ring),
        cmocka_unit_test(late),
    };
    return cmocka_run_group_tests_name("a ring that sleeps", tests, NULL, NULL);
}

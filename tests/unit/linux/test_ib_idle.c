/* SPDX-License-Identifier: MIT */
/*
 * Two couplers with the same ring and the same fate: one runs every cycle at its moment, the other
 * one as lx_ring_time does. Random clients, faults, worlds and power; whoever looks sees the same,
 * and what the one has stored at any time, the other one has, too.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "effort.h"
#include "modbus_rig.h"
#include "modbus_time.h"

#define START DG_S(1)
#define DEVICES 3u
#define K3 1u /* the words 1 and 2 */
#define OUT_AT 0x0801u

/* A shaft that turns steadily. */
struct shaft {
    dg_angle angle;
    int64_t per_us;
};

struct side {
    struct shaft shaft;
    struct modbus_rig rig;
    struct lx_ring *ring;
    struct lx_map map;
    uint64_t runs;
};

static struct side lazy;
static struct side eager;
static struct side *const sides[] = {&eager, &lazy};
static struct lx_ring_time lazy_time;
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

static void drive(void *ctx, dg_ns at)
{
    struct side *self = ctx;
    self->runs++;
    (void)lx_ring_cycle(self->ring, at);
}

/* --- both sides --- */

static void open_side(struct side *self)
{
    static const struct dg_device *const models[DEVICES] = {&dg_ocd_ib_k1, &dg_ocd_ib_k3,
                                                            &dg_ocd_ib_k2};
    struct lx_error error;
    memset(self, 0, sizeof *self);
    modbus_rig_plan(&self->rig, models, DEVICES);
    self->ring = &self->rig.ring;
    assert_int_equal(modbus_rig_open(&self->rig, angle, &self->shaft, START, &error), 0);
    lx_map_init(&self->map, self->ring);
}

static void open_both(uint32_t seed)
{
    static const dg_ns periods[] = {DG_US(250), DG_US(333), DG_MS(1), DG_MS(7), DG_MS(50)};
    noise = seed;
    now = START;
    period = periods[next() % (DG_COUNT(periods))];
    broken = false;
    open_side(&eager);
    open_side(&lazy);
    const struct lx_ring_time_setup setup = {&lazy.map, period, drive, &lazy};
    lx_ring_time_init(&lazy_time, &setup);
    assert_int_equal(lx_ring_time_next(&lazy_time), 0);
    lx_ring_time_due(&lazy_time, now);
    eager_next = now;
}

static void close_both(void)
{
    modbus_rig_close(&eager.rig);
    modbus_rig_close(&lazy.rig);
}

/* --- time --- */

static void run_eager(void)
{
    for (; eager_next <= now; eager_next += period) {
        lx_map_tick(&eager.map, eager_next);
        drive(&eager, eager_next);
    }
}

static const struct lx_nvm_memory *memory_of(const struct side *self)
{
    return &self->ring->part_of[K3]->image->memory;
}

/* What would be there after the processes have died. */
static void check_stored(void)
{
    const struct lx_nvm_memory *is = memory_of(&lazy);
    const struct lx_nvm_memory *wanted = memory_of(&eager);
    assert_int_equal(is->size, wanted->size);
    assert_memory_equal(is->bytes, wanted->bytes, wanted->size);
}

/* Time goes on; the lazy one is woken when it wants to be, unless the loop is busy. */
static void pass(dg_ns span)
{
    const bool busy = one_in(8);
    now += span;
    run_eager();
    while (!busy && lx_ring_time_next(&lazy_time) <= now) {
        lx_ring_time_due(&lazy_time, lx_ring_time_next(&lazy_time));
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

static void check_registers(struct lx_range range)
{
    uint16_t is[64];
    uint16_t wanted[64];
    lx_map_read(&lazy.map, range, is);
    lx_map_read(&eager.map, range, wanted);
    assert_memory_equal(is, wanted, range.count * sizeof is[0]);
}

static void look(void)
{
    const struct lx_ring *is = lazy.ring;
    const struct lx_ring *wanted = eager.ring;
    lx_ring_time_to(&lazy_time, now);
    SAME(stopped), SAME(is->result), SAME(is->reached);
    assert_memory_equal(&is->is->counters, &wanted->is->counters, sizeof wanted->is->counters);
    assert_memory_equal(is->in, wanted->in, sizeof wanted->in);
    assert_memory_equal(is->out, wanted->out, sizeof wanted->out);
    for (size_t i = 0; i < DEVICES; i++) {
        assert_int_equal(dg_ring_id_word(is->bus, i), dg_ring_id_word(wanted->bus, i));
        check_device(lx_ring_device(is, i), lx_ring_device(wanted, i));
    }
    check_stored();
}

/* --- what happens to them --- */

static void read_by_a_client(void)
{
    static const struct lx_range ranges[] = {{0x0000, 5}, {0x0800, 5}, {0x100C, 1}, {0x1014, 2},
                                             {0x1020, 1}, {0x1120, 4}, {0x2000, 48}};
    lx_ring_time_to(&lazy_time, now);
    for (size_t i = 0; i < 2; i++) {
        lx_map_request(&sides[i]->map, now);
    }
    check_registers(ranges[next() % (DG_COUNT(ranges))]);
}

static void write_by_a_client(uint16_t first, const uint16_t *values, uint16_t count)
{
    lx_ring_time_to(&lazy_time, now);
    for (size_t i = 0; i < 2; i++) {
        lx_map_request(&sides[i]->map, now);
        assert_true(lx_map_write(&sides[i]->map, (struct lx_range){first, count}, values));
    }
    lx_ring_time_stir(&lazy_time);
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
    lx_ring_time_to(&lazy_time, now);
    for (size_t i = 0; i < 2; i++) {
        for (size_t n = 0; n < DEVICES; n++) {
            struct dg_world *world = dg_host_world(sides[i]->ring->setup->stations[n]->host);
            world->singleturn_ok = how % 4u != 0;
            world->multiturn_sync_ok = how / 4u % 8u != 0;
            world->eeprom_acknowledges = how / 32u % 8u != 0;
            world->temperature_mdegc = (int32_t)(where % 100000u);
        }
        sides[i]->shaft.per_us = how / 256u % 3u == 0 ? 0 : (int64_t)(where % 2000000u) - 1000000;
        sides[i]->shaft.angle = (dg_angle)((uint64_t)where << 24);
    }
    lx_ring_time_stir(&lazy_time);
}

static void switch_power(void)
{
    const uint32_t which = next() % DEVICES;
    const bool on = !one_in(3);
    lx_ring_time_to(&lazy_time, now);
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(dg_host_power(sides[i]->rig.engine.stations[which].host, now, on),
                         DG_HOST_OK);
        (void)dg_bus_changed(sides[i]->ring->bus, which, now);
    }
    lx_ring_time_stir(&lazy_time);
}

static void hurt_ring(void)
{
    const uint16_t where = (uint16_t)(next() % DEVICES);
    const bool corrupt = one_in(2);
    broken = !broken;
    lx_ring_time_to(&lazy_time, now);
    for (size_t i = 0; i < 2; i++) {
        struct lx_ring *ring = sides[i]->ring;
        dg_ring_cut(ring->bus, broken && !corrupt ? where : DG_RING_WHOLE);
        if (corrupt) {
            dg_ring_spoil(ring->bus, where);
        }
        lx_ring_device(ring, where)->reconfigure = true;
    }
    lx_ring_time_stir(&lazy_time);
}

/* Watched, it is run in real time: here it is never late. */
static void watch(void)
{
    lx_ring_time_watch(&lazy_time, !lazy_time.watched, now);
    if (lazy_time.watched) {
        assert_int_equal(lx_ring_time_next(&lazy_time), eager_next);
        for (int i = 0; i < 20; i++) {
            now = eager_next;
            run_eager();
            lx_ring_time_due(&lazy_time, now);
            look();
        }
        lx_ring_time_watch(&lazy_time, false, now);
    }
}

static void fates(uint32_t seed)
{
    static void (*const happenings[])(void) = {
        look,      look,      read_by_a_client, read_by_a_client, write_out,    write_out,
        write_out, write_out, write_out,        write_watchdog,   change_world, switch_power,
        hurt_ring, watch,
    };
    open_both(seed);
    for (int i = 0; i < 300; i++) {
        pass(some_time());
        happenings[next() % (DG_COUNT(happenings))]();
    }
    pass(DG_S(1));
    look();
    close_both();
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
    lx_ring_time_to(&lazy_time, now + DG_S(1));
    const uint64_t before = lazy.runs;
    while (lx_ring_time_next(&lazy_time) <= START + DG_S(86400)) {
        lx_ring_time_due(&lazy_time, lx_ring_time_next(&lazy_time));
    }
    assert_true(lazy.runs - before <= 3u * 144u);
    assert_int_equal(lx_ring_device(lazy.ring, K3)->time_10min, 144);
    lx_ring_time_to(&lazy_time, START + DG_S(86400));
    const uint64_t cycles = DG_S(86400) / period; /* the first one was an ID cycle, too */
    assert_int_equal(lazy.ring->is->counters.cycles, (uint32_t)(cycles + 1u));
    assert_int_equal(lx_ring_device(lazy.ring, K3)->counters.cycles, (uint32_t)cycles);
    close_both();
}

/* K1 and K2 store nothing: nothing wakes them. A watchdog does, once. */
static void what_wakes_a_ring(void **state)
{
    const uint16_t ms = 100;
    const uint16_t stop = LX_FALLBACK_STOP;
    (void)state;
    open_both(1);
    period = DG_MS(1);
    lazy_time.setup.period = period;
    lazy_time.next = START + period;
    now = START + DG_S(1);
    lx_ring_time_to(&lazy_time, now);
    assert_int_equal(lx_ring_time_next(&lazy_time), START + DG_S(600));
    struct dg_ib_model *model = dg_host_line_of(lazy.rig.engine.stations[K3].host)->settings;
    model->profile = DG_IB_K2;
    assert_true(lx_ring_time_next(&lazy_time) == DG_NEVER);
    model->profile = DG_IB_K3;
    lx_map_request(&lazy.map, now);
    assert_true(lx_map_write(&lazy.map, (struct lx_range){0x1120, 1}, &ms));
    assert_true(lx_map_write(&lazy.map, (struct lx_range){0x1123, 1}, &stop));
    assert_true(lx_map_write(&lazy.map, (struct lx_range){OUT_AT, 2}, (const uint16_t[]){0, 0}));
    lx_ring_time_stir(&lazy_time);
    assert_int_equal(lx_ring_time_next(&lazy_time), now + DG_MS(1));
    lx_ring_time_due(&lazy_time, now + DG_MS(1));
    /* It fires in the first cycle that comes later than its time. */
    assert_int_equal(lx_ring_time_next(&lazy_time), now + DG_MS(101));
    lx_ring_time_due(&lazy_time, now + DG_MS(100));
    assert_false(lazy.map.watchdog.fired);
    lx_ring_time_due(&lazy_time, now + DG_MS(101));
    assert_true(lazy.map.watchdog.fired);
    assert_true(lx_ring_time_next(&lazy_time) == DG_NEVER); /* ID cycles only */
    close_both();
}

/* Late, a watched ring leaves cycles out and counts them; one that is not is never late. */
static void late(void **state)
{
    (void)state;
    open_both(2);
    lx_ring_time_to(&lazy_time, START + 10u * period);
    assert_int_equal(lazy.map.missed, 0);
    lx_ring_time_watch(&lazy_time, true, START + 10u * period);
    const uint64_t before = lazy.runs;
    lx_ring_time_due(&lazy_time, START + 14u * period + 1u);
    assert_int_equal(lazy.map.missed, 3);
    assert_int_equal(lazy.runs - before, 1);
    assert_int_equal(lx_ring_time_next(&lazy_time), START + 15u * period);
    lx_ring_time_to(&lazy_time, START + 20u * period); /* only when it is due */
    assert_int_equal(lazy.runs - before, 1);
    lx_ring_time_due(&lazy_time, START + 15u * period - 1u); /* too soon */
    assert_int_equal(lazy.runs - before, 1);
    lx_ring_time_watch(&lazy_time, false, START + 15u * period);
    lx_ring_time_to(&lazy_time, START + 1000u * period);
    assert_int_equal(lazy.map.missed, 3);
    assert_int_equal(lazy.ring->is->counters.cycles, 1001u - 3u);
    close_both();
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

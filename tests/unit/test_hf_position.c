/* SPDX-License-Identifier: MIT */
/*
 * Position and process channel at their edges: geometries up to 2^32 steps, both sides of zero,
 * presets with and without synchronization (5.1.2.1, 5.1.2.2, 5.1.2.19, R18), and sine and cosine
 * (4.1.3) against long double arithmetic and against the 5 LSB of the position.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "hf_rig.h"

#define TWO_PI 6.283185307179586476925286766559L
#define PEAK_UV 250000.0L /* of one line, at nominal amplitude: the figure of 4.1.3 */
#define DC_UV 2500000.0L

/* periods, steps, turns */
static const struct {
    uint16_t periods;
    uint32_t steps;
    uint32_t turns;
} geometries[] = {{2048, 32, 1},     {2048, 32, 4096},  {2048, 32, 65536}, /* 2^32 */
                  {512, 128, 65536},                                       /* 2^32 */
                  {65535, 1, 65537},                                       /* 2^32 - 1 */
                  {65535, 255, 257}, {1, 1, 1},         {1, 255, 1},       {1000, 31, 3},
                  {3, 5, 7},         {1, 4, 1u << 30},  {5, 1, 858993459}, /* 2^32 - 1 */
                  {2048, 512, 1},    {2048, 512, 4096}, {2048, 256, 3},    {1, 1u << 24, 256},
                  {100, 167772, 2}};
#define GEOMETRIES DG_COUNT(geometries)

static struct dg_hf_model model;
static struct hf_rig rig;
static uint32_t seed;

static uint32_t noise(void)
{
    seed = seed * 1664525u + 1013904223u;
    return seed ^ seed >> 15;
}

/* Somewhere within some thousand turns on either side of zero. */
static dg_angle any_angle(void)
{
    return (dg_angle)(noise() % 8192u) * DG_TURN + (dg_angle)noise() - 4096 * DG_TURN;
}

static void begin(uint16_t periods, uint32_t steps, uint32_t turns)
{
    model = *dg_hf_model_of(dg_device_find("s3684-rs485"));
    model.periods_per_turn = periods;
    model.steps_per_period = steps;
    model.turns = turns;
    assert_int_equal(hf_rig_init(&rig, &model), DG_OK);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    seed = 1;
}

static uint64_t per_turn(void)
{
    return (uint64_t)model.periods_per_turn * model.steps_per_period;
}

static uint64_t range(void)
{
    return per_turn() * model.turns;
}

/* Whole turns and the fraction of a turn apart: nothing here needs more than 64 bits. */
static uint64_t raw(dg_angle angle)
{
    const uint64_t fraction = (uint64_t)angle & 0xFFFFFFFFu;
    const int64_t turns = (angle - (dg_angle)fraction) / DG_TURN;
    const int64_t inside = turns % (int64_t)model.turns;
    const uint64_t turn = (uint64_t)(inside < 0 ? inside + (int64_t)model.turns : inside);

    return turn * per_turn() + (fraction * per_turn() >> 32);
}

/* Position on the wire with the shaft at `angle`. */
static uint64_t position_at(dg_angle angle)
{
    rig.angle = angle;
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
    assert_int_equal(rig.reply_length, 7);
    assert_int_equal(dg_hf_position(&rig.device, rig.now), dg_load_be32(&rig.reply[2]));
    return dg_load_be32(&rig.reply[2]);
}

static int preset(uint8_t command, uint64_t value)
{
    uint8_t bytes[] = {command, 0, 0, 0, 0, DG_HF_CODE_DEFAULT};

    dg_store_be32(&bytes[1], (uint32_t)value);
    return hf_rig_ask_bytes(&rig, bytes, sizeof bytes);
}

static void the_position_is_the_floor_of_the_angle_in_the_range(void **state)
{
    (void)state;
    for (size_t i = 0; i < GEOMETRIES; i++) {
        begin(geometries[i].periods, geometries[i].steps, geometries[i].turns);
        const dg_angle full = (dg_angle)model.turns * DG_TURN;
        const dg_angle edges[] = {0,           -1,   1,        DG_TURN, -DG_TURN,
                                  DG_TURN - 1, full, full - 1, -full,   -full - 1};
        for (size_t k = 0; k < DG_COUNT(edges); k++) {
            assert_int_equal(position_at(edges[k]), raw(edges[k]));
        }
        for (int k = 0; k < 500; k++) {
            const dg_angle angle = any_angle();
            assert_int_equal(position_at(angle), raw(angle));
        }
        assert_int_equal(position_at(-1), range() - 1);
        assert_int_equal(position_at(full), 0);
    }
}

/* Every step of a turn begins at its own angle, and is as wide as the others. */
static void every_step_of_a_turn(void **state)
{
    (void)state;
    begin(100, 31, 2);
    for (uint64_t count = 0; count < 2 * per_turn(); count++) {
        const dg_angle first = (dg_angle)(((count << 32) + per_turn() - 1) / per_turn());
        rig.angle = first;
        assert_int_equal(dg_hf_position(&rig.device, rig.now), count);
        rig.angle = first - 1;
        assert_int_equal(dg_hf_position(&rig.device, rig.now), (count + range() - 1) % range());
    }
}

static void a_preset_shifts_every_angle(void **state)
{
    (void)state;
    for (size_t i = 0; i < GEOMETRIES; i++) {
        begin(geometries[i].periods, geometries[i].steps, geometries[i].turns);
        for (int k = 0; k < 60; k++) {
            const uint64_t wanted = k == 0 ? 0 : k == 1 ? range() - 1 : noise() % range();
            const dg_angle here = any_angle();
            const dg_angle there = any_angle();
            rig.angle = here;
            assert_int_equal(preset(0x43, wanted), 0);
            assert_int_equal(position_at(here), wanted);
            const uint64_t moved = (raw(there) + range() - raw(here)) % range();
            assert_int_equal(position_at(there), (wanted + moved) % range());
        }
        const uint64_t last = position_at(0);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        assert_int_equal(position_at(0), last);
    }
}

static void a_preset_outside_of_the_range_is_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < GEOMETRIES; i++) {
        begin(geometries[i].periods, geometries[i].steps, geometries[i].turns);
        const uint64_t last = position_at(0);
        for (uint64_t value = range(); value <= UINT32_MAX && value < range() + 3; value++) {
            assert_int_equal(preset(0x43, value), DG_HF_ARGUMENT);
            assert_int_equal(preset(0x6A, value), DG_HF_ARGUMENT);
        }
        assert_int_equal(preset(0x43, UINT32_MAX), range() > UINT32_MAX ? 0 : DG_HF_ARGUMENT);
        assert_int_equal(position_at(0), range() > UINT32_MAX ? UINT32_MAX : last);
    }
}

/* R18: to whole periods, to the nearest, ties up; the reply has the preset in force. */
static void assert_synchronized(dg_angle angle, uint64_t wanted)
{
    const uint64_t offset = (wanted + range() - raw(angle)) % range();
    const uint64_t over = offset % model.steps_per_period;
    const bool up = 2 * over >= model.steps_per_period;
    const uint64_t rounded = offset - over + (up ? model.steps_per_period : 0u);
    const uint64_t used = (raw(angle) + rounded) % range();

    rig.angle = angle;
    assert_int_equal(preset(0x6A, wanted), 0);
    assert_int_equal(rig.reply_length, 7);
    assert_int_equal(dg_load_be32(&rig.reply[2]), used);
    assert_int_equal(rig.device.offset, rounded % range());
    assert_int_equal(position_at(angle), used);
}

static void synchronization_rounds_to_whole_periods(void **state)
{
    (void)state;
    for (size_t i = 0; i < GEOMETRIES; i++) {
        begin(geometries[i].periods, geometries[i].steps, geometries[i].turns);
        const dg_angle angle = any_angle();
        /* Every phase, from the range's end across zero: ties, and rounding up to the range. */
        const uint64_t stride = model.steps_per_period > 1000u ? 509u : 1u;
        for (uint64_t k = 0; k < 2u * (uint64_t)model.steps_per_period; k += stride) {
            const uint64_t wanted = range() - model.steps_per_period % range() + k;
            assert_synchronized(angle, (raw(angle) + wanted) % range());
        }
        for (int k = 0; k < 30; k++) {
            assert_synchronized(any_angle(), noise() % range());
        }
    }
}

/* A tie, in words: 16 of 32 steps go up, 15 go down; 15 of 31 go down, 16 go up. */
static void ties_go_up(void **state)
{
    static const struct {
        uint32_t steps;
        uint32_t wanted;
        uint32_t used;
    } rows[] = {{32, 15, 0},        {32, 16, 32},
                {32, 17, 32},       {31, 15, 0},
                {31, 16, 31},       {1, 7, 7},
                {2, 1, 2},          {2, 2, 2},
                {255, 127, 0},      {255, 128, 255},
                {256, 127, 0},      {256, 128, 256},
                {167772, 83885, 0}, {167772, 83886, 167772}};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        begin(100, rows[i].steps, 10);
        assert_int_equal(preset(0x6A, rows[i].wanted), 0);
        assert_int_equal(dg_load_be32(&rig.reply[2]), rows[i].used);
    }
}

/* A singleturn device has no multiturn sensor that could fail (20h-23h, table of 5.1.2.1). */
static void singleturn_has_no_multiturn_faults(void **state)
{
    static const struct {
        uint32_t turns;
        int answer;
    } rows[] = {{1, 0}, {2, DG_HF_MULTITURN_AMPLITUDE}};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        begin(2048, 32, rows[i].turns);
        rig.world.multiturn_amplitude_ok = false;
        rig.world.multiturn_sync_ok = false;
        rig.world.multiturn_vector_ok = false;
        assert_int_equal(hf_rig_ask(&rig, "42"), rows[i].answer);
        assert_int_equal(preset(0x43, 0), rows[i].answer);
        assert_int_equal(preset(0x6A, 0), rows[i].answer);
    }
}

/* Process channel. */

static void assert_near(int32_t uv, long double expected)
{
    assert_true(fabsl((long double)uv - expected) <= 2.0L);
}

/* `signal` in units of the nominal amplitude, on both lines of a pair. */
static void assert_pair(int32_t plus_uv, int32_t minus_uv, long double signal)
{
    assert_near(plus_uv, DC_UV + PEAK_UV * signal);
    assert_near(minus_uv, DC_UV - PEAK_UV * signal);
}

static void assert_sincos(dg_angle angle)
{
    const struct dg_world *world = &rig.world;
    const uint64_t phase = ((uint64_t)angle & 0xFFFFFFFFu) * model.periods_per_turn & 0xFFFFFFFFu;
    const long double radians = TWO_PI * (long double)phase / 4294967296.0L;
    struct dg_hf_sincos out;

    rig.angle = angle;
    dg_hf_sincos(&rig.device, rig.now, &out);
    assert_pair(out.sin_plus_uv, out.sin_minus_uv,
                sinl(radians) * world->sin_amplitude_permille / 1000 +
                    world->sin_offset_permille / 1000.0L);
    assert_pair(out.cos_plus_uv, out.cos_minus_uv,
                cosl(radians) * world->cos_amplitude_permille / 1000 +
                    world->cos_offset_permille / 1000.0L);
}

static void sine_and_cosine_are_within_two_microvolts(void **state)
{
    static const uint16_t periods[] = {2048, 1, 1000, 65535};
    static const uint16_t amplitudes[] = {1000, 0, 1, 999, 2000};
    static const int16_t offsets[] = {0, 1000, -1000, 1, -333};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(periods); i++) {
        begin(periods[i], 32, 16);
        for (size_t k = 0; k < 5; k++) {
            rig.world.sin_amplitude_permille = amplitudes[k];
            rig.world.cos_amplitude_permille = amplitudes[4 - k];
            rig.world.sin_offset_permille = offsets[k];
            rig.world.cos_offset_permille = offsets[4 - k];
            for (int n = 0; n < 5000; n++) {
                assert_sincos(any_angle());
            }
            for (dg_angle angle = -100; angle < 100; angle++) {
                assert_sincos(angle);
                assert_sincos(angle * (DG_TURN / 8192));
            }
        }
    }
}

/* Which of 32 steps of its period the master's arc tangent finds. */
static uint64_t phase_step(void)
{
    struct dg_hf_sincos out;

    dg_hf_sincos(&rig.device, rig.now, &out);
    const long double turn = atan2l((long double)out.sin_plus_uv - (long double)out.sin_minus_uv,
                                    (long double)out.cos_plus_uv - (long double)out.cos_minus_uv) /
                             TWO_PI;
    return (uint64_t)floorl((turn < 0 ? turn + 1 : turn) * 32);
}

/* In the middle of every step of two turns around zero, and of many others. */
static void assert_locked(uint64_t shift)
{
    for (int64_t i = 0; i < 8000; i++) {
        const int64_t count = i < 4000 ? i - 2000 : (int64_t)noise() - (1 << 30);
        const int64_t counts_per_turn = (int64_t)per_turn();
        const int64_t turn = count / counts_per_turn;
        const int64_t rest = count % counts_per_turn;
        rig.angle = turn * DG_TURN + (2 * rest + 1) * (DG_TURN / 2) / counts_per_turn;
        const uint64_t position = dg_hf_position(&rig.device, rig.now);
        assert_int_equal((position + 32 - shift) % 32, phase_step());
    }
}

static void the_signals_are_locked_to_the_five_lsb(void **state)
{
    static const uint16_t periods[] = {2048, 1000, 7};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(periods); i++) {
        begin(periods[i], 32, 4096);
        assert_locked(0);
        rig.angle = 0;
        for (uint64_t shift = 1; shift < 32; shift += 10) {
            assert_int_equal(preset(0x43, 64 + shift), 0);
            assert_locked(shift);
            rig.angle = 0;
        }
        assert_int_equal(preset(0x6A, 77), 0);
        assert_locked(0);
    }
}

/* hiperface.h: sin 0 and cos at its peak where the raw position's 5 LSB turn to 0. */
static void a_period_begins_where_the_five_lsb_turn_to_zero(void **state)
{
    struct dg_hf_sincos out;

    (void)state;
    begin(2048, 32, 4096);
    for (int64_t period = -5000; period < 5000; period++) {
        rig.angle = period * (DG_TURN / 2048);
        dg_hf_sincos(&rig.device, rig.now, &out);
        assert_int_equal(dg_hf_position(&rig.device, rig.now) % 32, 0);
        assert_int_equal(out.sin_plus_uv, 2500000);
        assert_int_equal(out.cos_plus_uv, 2750000);
        assert_int_equal(out.cos_minus_uv, 2250000);
        rig.angle += DG_TURN / 2048 / 4;
        dg_hf_sincos(&rig.device, rig.now, &out);
        assert_int_equal(out.sin_plus_uv, 2750000); /* clockwise: the sine rises */
        rig.angle -= DG_TURN / 2048 / 4 + 1;
        assert_int_equal(dg_hf_position(&rig.device, rig.now) % 32, 31);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_position_is_the_floor_of_the_angle_in_the_range),
        cmocka_unit_test(every_step_of_a_turn),
        cmocka_unit_test(a_preset_shifts_every_angle),
        cmocka_unit_test(a_preset_outside_of_the_range_is_refused),
        cmocka_unit_test(synchronization_rounds_to_whole_periods),
        cmocka_unit_test(ties_go_up),
        cmocka_unit_test(singleturn_has_no_multiturn_faults),
        cmocka_unit_test(sine_and_cosine_are_within_two_microvolts),
        cmocka_unit_test(the_signals_are_locked_to_the_five_lsb),
        cmocka_unit_test(a_period_begins_where_the_five_lsb_turn_to_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The line of an encoder with SSI: deadlines, late hosts, copies, whole words, and random clocks
 * against what the history of the clock line says.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ssi_rig.h"

static const struct dg_ssi_model ssi_13 = {
    .singleturn_bits = 13, .monoflop = DG_US(20), .init = DG_MS(100)};
static const struct dg_ssi_model ssi_28 = {.multiturn_bits = 12,
                                           .singleturn_bits = 16,
                                           .code = DG_SSI_BINARY,
                                           .error_bit = DG_SSI_ERROR_HIGH,
                                           .parity = DG_SSI_PARITY_EVEN,
                                           .monoflop = DG_US(20)};
static struct ssi_rig rig;

static int setup(void **state)
{
    (void)state;
    const int result = ssi_rig_init(&rig, &ssi_13);
    ssi_rig_power_on(&rig);
    return result;
}

/* The shaft at `count` of 13 bits. */
static void turn_to(int64_t count)
{
    rig.angle = count * (DG_TURN >> 13);
}

static void test_arguments(void **state)
{
    struct dg_world blind = rig.world;
    struct dg_ssi device;

    (void)state;
    blind.angle = NULL;
    assert_int_equal(dg_ssi_init(&device, &(struct dg_ssi_setup){NULL, &rig.world}),
                     DG_ERR_ARGUMENT);
    assert_int_equal(dg_ssi_init(&device, &(struct dg_ssi_setup){&ssi_13, NULL}), DG_ERR_ARGUMENT);
    assert_int_equal(dg_ssi_init(&device, &(struct dg_ssi_setup){&ssi_13, &blind}),
                     DG_ERR_ARGUMENT);
    assert_int_equal(dg_ssi_init(&device, &(struct dg_ssi_setup){&ssi_13, &rig.world}), DG_OK);
    assert_int_equal(device.state, DG_SSI_OFF);
    assert_true(dg_ssi_step(&device, DG_S(9)) == DG_NEVER);
}

static void test_deadlines(void **state)
{
    (void)state;
    assert_true(dg_ssi_step(&rig.device, rig.now) == DG_NEVER);
    const dg_ns fell = rig.now;
    (void)dg_ssi_clock(&rig.device, fell, false);
    assert_int_equal(dg_ssi_step(&rig.device, fell), fell + DG_US(20));
    (void)dg_ssi_clock(&rig.device, fell + 700, true);
    assert_int_equal(dg_ssi_step(&rig.device, fell + 700), fell + DG_US(20));
    (void)dg_ssi_clock(&rig.device, fell + 1500, false);
    assert_int_equal(dg_ssi_step(&rig.device, fell + DG_US(20)), fell + 1500 + DG_US(20));
    assert_int_equal(rig.device.state, DG_SSI_SHIFT);
    assert_true(dg_ssi_step(&rig.device, fell + 1500 + DG_US(20)) == DG_NEVER);
    assert_int_equal(rig.device.state, DG_SSI_IDLE);
    assert_true(rig.device.deadline == DG_NEVER);
    assert_true(dg_ssi_data(&rig.device));
}

static void test_start_deadline(void **state)
{
    (void)state;
    dg_ssi_power_on(&rig.device, DG_S(5));
    assert_false(dg_ssi_data(&rig.device));
    assert_int_equal(dg_ssi_step(&rig.device, DG_S(5)), DG_S(5) + DG_MS(100));
    dg_ssi_power_off(&rig.device);
    assert_true(dg_ssi_step(&rig.device, DG_S(6)) == DG_NEVER);
    assert_false(dg_ssi_data(&rig.device));
    dg_ssi_power_on(&rig.device, DG_NEVER - 5u); /* as long as time goes */
    assert_true(dg_ssi_step(&rig.device, DG_NEVER - 5u) == DG_NEVER);
}

/* Nobody called dg_ssi_step(): the edge at the very end of tm begins a new word, 1 ns earlier it is
 * one more of the old one. */
static void test_late_host(void **state)
{
    (void)state;
    for (dg_ns early = 0; early < 2; early++) {
        assert_int_equal(setup(NULL), 0);
        turn_to(0);
        const dg_ns fell = rig.now;
        (void)dg_ssi_clock(&rig.device, fell, false);
        assert_false(dg_ssi_clock(&rig.device, fell + 500, true));
        turn_to(4096);
        (void)dg_ssi_clock(&rig.device, fell + DG_US(20) - early, false);
        assert_int_equal(dg_ssi_clock(&rig.device, fell + DG_US(21), true), early == 0);
        assert_int_equal(rig.device.counters.frames, 2u - early);
        assert_int_equal(rig.device.counters.aborted, 1u - early);
    }
}

/* The same level again is no edge, whenever it comes. */
static void test_no_edge(void **state)
{
    (void)state;
    turn_to(4779);
    assert_true(dg_ssi_clock(&rig.device, rig.now, true));
    assert_int_equal(rig.device.state, DG_SSI_IDLE);
    (void)dg_ssi_clock(&rig.device, rig.now, false);
    (void)dg_ssi_clock(&rig.device, rig.now + 100, false);
    assert_int_equal(rig.device.deadline, rig.now + DG_US(20));
    assert_true(dg_ssi_clock(&rig.device, rig.now + 200, true));
    assert_true(dg_ssi_clock(&rig.device, rig.now + 300, true));
    assert_int_equal(rig.device.left, 12);
}

/* Time that goes backwards is no time: tm runs from the latest moment known. */
static void test_time_goes_on(void **state)
{
    const dg_ns now = rig.now;

    (void)state;
    (void)dg_ssi_clock(&rig.device, now, false);
    (void)dg_ssi_clock(&rig.device, now + DG_US(5), true);
    (void)dg_ssi_clock(&rig.device, now - DG_US(1), false);
    assert_int_equal(rig.device.deadline, now + DG_US(25));
    assert_int_equal(rig.device.counters.fast, 0);
    rig.model.init = 0;
    dg_ssi_power_on(&rig.device, now + DG_S(1));
    (void)dg_ssi_clock(&rig.device, now, true);
    (void)dg_ssi_clock(&rig.device, now, false);
    assert_int_equal(rig.device.deadline, now + DG_S(1) + DG_US(20));
}

/* A clock that begins with time itself has no falling edge before its first one. */
static void test_time_begins(void **state)
{
    struct dg_ssi_model model = ssi_13;
    struct dg_ssi device;

    (void)state;
    model.init = 0;
    assert_int_equal(dg_ssi_init(&device, &(struct dg_ssi_setup){&model, &rig.world}), DG_OK);
    dg_ssi_power_on(&device, 0);
    assert_true(dg_ssi_clock(&device, 1, false));
    assert_int_equal(device.counters.fast, 0);
    assert_false(dg_ssi_clock(&device, 200, true));
    (void)dg_ssi_clock(&device, 500, false);
    assert_int_equal(device.counters.fast, 1);
    assert_int_equal(device.counters.frames, 1);
}

static void test_copies(void **state)
{
    struct dg_ssi copy;

    (void)state;
    turn_to(4779);
    assert_int_equal(ssi_rig_take(&rig, 5), 0x1B);
    copy = rig.device;
    assert_memory_equal(&copy, &rig.device, sizeof copy);
    const uint64_t rest = ssi_rig_take(&rig, 9);
    assert_int_equal(rest, 0x1FC);
    rig.device = copy;
    turn_to(0);
    rig.now -= 9u * 1000u;
    assert_int_equal(ssi_rig_take(&rig, 9), rest);
}

static void test_two_encoders(void **state)
{
    static struct ssi_rig other;
    uint64_t bits = 0;

    (void)state;
    assert_int_equal(ssi_rig_init(&other, &ssi_28), DG_OK);
    ssi_rig_power_on(&other);
    turn_to(4779);
    other.angle = DG_TURN * 291 + DG_TURN / 4;
    assert_int_equal(ssi_rig_take(&rig, 5), 0x1B);
    assert_int_equal(ssi_rig_take(&other, 31), 0x1234000 << 3 | 1 << 1); /* 5 ones: parity 1 */
    assert_int_equal(dg_ssi_frame(&other.device, other.now + DG_US(20), &bits), 30);
    assert_int_equal(ssi_rig_take(&rig, 9), 0x1FC);
    assert_int_equal(rig.device.position, 4779);
    assert_int_equal(other.device.position, 0x1234000);
}

static void test_whole_words(void **state)
{
    uint64_t bits = 99;

    (void)state;
    turn_to(4779);
    assert_int_equal(dg_ssi_frame(&rig.device, rig.now, &bits), 13);
    assert_int_equal(bits, 0x1BFE);
    assert_int_equal(rig.device.counters.frames, 1);
    assert_int_equal(dg_ssi_frame(&rig.device, rig.now + 1, &bits), 13);
    assert_int_equal(rig.device.counters.frames, 2);
    assert_int_equal(rig.device.counters.aborted, 0);
    dg_ssi_power_on(&rig.device, rig.now);
    assert_int_equal(dg_ssi_frame(&rig.device, rig.now + DG_MS(100) - 1u, &bits), 0);
    assert_int_equal(dg_ssi_frame(&rig.device, rig.now + DG_MS(100), &bits), 13);
    dg_ssi_power_off(&rig.device);
    assert_int_equal(dg_ssi_frame(&rig.device, rig.now + DG_S(1), &bits), 0);
    assert_int_equal(rig.device.counters.frames, 3);
}

/* --- random clocks ------------------------------------------------------------------------- */

#define EDGES_MAX 600u

/* The history of the clock line, edge by edge; even ones fall. */
struct history {
    dg_ns at[EDGES_MAX];
    unsigned n;
};

/* The first falling edge of the word that the last edge belongs to. */
static unsigned word_begin(const struct history *h, dg_ns monoflop)
{
    unsigned first = h->n - 1u - (h->n - 1u) % 2u;

    while (first >= 2 && h->at[first] - h->at[first - 2u] < monoflop) {
        first -= 2;
    }
    return first;
}

/* What data must be at `now`, from nothing but the history and the position stored. */
static bool expected(const struct history *h, const struct dg_ssi_model *model, dg_ns now,
                     uint32_t position)
{
    const unsigned first = h->n > 0 ? word_begin(h, model->monoflop) : 0;
    const unsigned fell = h->n > 0 ? h->n - 1u - (h->n - 1u) % 2u : 0;
    const unsigned bits = ssi_rig_bits(model);
    unsigned rises = (h->n - first) / 2u;

    if (h->n == 0 || now - h->at[fell] >= model->monoflop || rises == 0) {
        return true;
    }
    if (model->once && rises > bits) {
        return false;
    }
    rises = (rises - 1u) % (bits + 1u);
    return rises < bits && (ssi_rig_word(model, position, false) >> (bits - 1u - rises) & 1u) != 0;
}

/* A rising edge behind the end of the monoflop time is nothing: the history forgets what was before
 * it, as the line is at rest. */
static void note_edge(struct history *h, const struct dg_ssi_model *model, dg_ns now)
{
    if (h->n % 2u == 1 && now - h->at[h->n - 1u] >= model->monoflop) {
        h->n = 0;
        return;
    }
    h->at[h->n++] = now;
}

static uint32_t noise = 1;

static uint32_t random_below(uint32_t n)
{
    noise = noise * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)noise * n) >> 32);
}

static struct dg_ssi_model random_model(void)
{
    struct dg_ssi_model model = {.init = 0};

    model.singleturn_bits = (uint8_t)(8u + random_below(24));
    const unsigned most = 32u - model.singleturn_bits;
    const unsigned least = model.singleturn_bits < 10 ? 10u - model.singleturn_bits : 0;
    model.multiturn_bits = (uint8_t)(least + random_below(most - least + 1u));
    model.code = (uint8_t)random_below(DG_SSI_CODE_COUNT);
    model.error_bit = (uint8_t)random_below(DG_SSI_ERROR_BIT_COUNT);
    model.parity = (uint8_t)random_below(DG_SSI_PARITY_COUNT);
    model.once = random_below(4) == 0;
    model.monoflop = DG_US(10u + random_below(21));
    return model;
}

static void one_random_clock(void)
{
    const struct dg_ssi_model model = random_model();
    struct history history = {.n = 0};
    uint32_t position = 0;

    assert_int_equal(ssi_rig_init(&rig, &model), DG_OK);
    ssi_rig_power_on(&rig);
    for (unsigned i = 0; i < EDGES_MAX - 1u; i++) {
        /* Mostly a clock, at times a pause around the monoflop time. */
        dg_ns pause = 100u + random_below(2000);
        pause = random_below(40) == 0 ? model.monoflop - 2u + random_below(4) : pause;
        rig.angle = (dg_angle)((uint64_t)noise << 20);
        if (random_below(2) == 0) {
            (void)ssi_rig_wait(&rig, pause);
            assert_int_equal(dg_ssi_data(&rig.device),
                             expected(&history, &model, rig.now, position));
        } else {
            rig.now += pause;
        }
        const uint32_t frames = rig.device.counters.frames;
        note_edge(&history, &model, rig.now);
        (void)ssi_rig_edge(&rig, !rig.device.clock);
        if (rig.device.counters.frames != frames) {
            position = (uint32_t)dg_ssi_position(&rig.device, rig.now);
        }
        assert_int_equal(dg_ssi_data(&rig.device), expected(&history, &model, rig.now, position));
    }
    assert_false(rig.strayed);
}

static void test_random_clocks(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 300; i++) {
        one_random_clock();
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_arguments, setup),
        cmocka_unit_test_setup(test_deadlines, setup),
        cmocka_unit_test_setup(test_start_deadline, setup),
        cmocka_unit_test_setup(test_late_host, setup),
        cmocka_unit_test_setup(test_no_edge, setup),
        cmocka_unit_test_setup(test_time_goes_on, setup),
        cmocka_unit_test_setup(test_time_begins, setup),
        cmocka_unit_test_setup(test_copies, setup),
        cmocka_unit_test_setup(test_two_encoders, setup),
        cmocka_unit_test_setup(test_whole_words, setup),
        cmocka_unit_test(test_random_clocks),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

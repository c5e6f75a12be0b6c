/* SPDX-License-Identifier: MIT */
/* Encoders of an FMU below what FMI calls: tokens, states, and what comes from foreign importers.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "describe.h"
#include "drehgeber/bits.h"
#include "drehgeber/crc.h"
#include "fmu_rig.h"

static const uint32_t rx = VARIABLE(FMU_BUS, FMU_RX);
static const uint32_t tx = VARIABLE(FMU_BUS, FMU_TX);
static const uint32_t rx_clock = VARIABLE(FMU_BUS, FMU_RX_CLOCK);

static void tokens_are_whole_or_refused(void **state)
{
    static const char *const bad[] = {
        "",
        "drehgeber",
        "drehgeber 0.0.0 =f3668",
        TOKEN,
        TOKEN " ",
        TOKEN " =f3699",
        TOKEN " f3668",
        TOKEN " =f3668,node=0",
        TOKEN " =f3668,node",
        TOKEN " =f3668,nonsense=1",
        TOKEN " =f3668@0",
        TOKEN " a=f3668",
        TOKEN " =f3668 b=f3668",
        TOKEN " 00000000.rig",
        TOKEN " =f3668,node=%3",
        TOKEN " =f3668,node=%3x",
        TOKEN " =f3668 ",
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(bad); i++) {
        assert_null(fmu_make(bad[i]));
    }
    assert_null(fmu_make(NULL));
    fmu_free(NULL);
    struct fmu *fmu = fmu_running(TOKEN " =f3668,node=%35");
    char text[32];
    assert_int_equal(dg_host_get(fmu_host(fmu, 0), "node", text, sizeof text), 1);
    assert_string_equal(text, "5");
    fmu_free(fmu);
    fmu = fmu_running(TOKEN " =s3684-rs485,designation=it%20is");
    assert_int_equal(fmu_count(fmu), 1);
    assert_string_equal(fmu_prefix(fmu, 0), "");
    assert_true(dg_host_get(fmu_host(fmu, 0), "designation", text, sizeof text) > 0);
    assert_string_equal(text, "it is");
    fmu_free(fmu);
}

/* Each has a number of its own that leads back to it, and inputs take what they tell. */
static void variables_are_what_they_say(void **state)
{
    (void)state;
    for (size_t model = 0; dg_host_name(model) != NULL; model++) {
        char token[96];
        (void)snprintf(token, sizeof token, "%s =%s", TOKEN, dg_host_name(model));
        struct fmu *fmu = fmu_running(token);
        struct fmu_variable row;
        struct fmu_variable other;
        size_t count = 0;
        for (; fmu_variable(fmu, count, &row); count++) {
            struct fmu_value value = {.type = row.type};
            for (size_t i = 0; i < count; i++) {
                assert_true(fmu_variable(fmu, i, &other));
                assert_int_not_equal(other.reference, row.reference);
                assert_string_not_equal(other.name, row.name);
            }
            if (row.type == FMU_BINARY || row.type == FMU_CLOCK) {
                continue;
            }
            assert_int_equal(fmu_get(fmu, row.reference, &value), DG_HOST_OK);
            value.type = row.type;
            const int set = fmu_set(fmu, row.reference, &value);
            const int want = row.parameter                     ? DG_HOST_ERR_STATE
                             : row.input && row.reference != 0 ? DG_HOST_OK
                                                               : DG_HOST_ERR_NAME;
            assert_int_equal(set, want);
        }
        assert_true(count > 15);
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_PARAMETER, 200), &(struct fmu_value){0}),
                         DG_HOST_ERR_NAME);
        assert_int_equal(fmu_set(fmu, UINT32_C(1) << 16, &(struct fmu_value){0}), DG_HOST_ERR_NAME);
        fmu_free(fmu);
    }
}

/* A truth value is no number, and neither is a text. */
static void values_of_another_kind_are_refused(void **state)
{
    static const enum fmu_type types[] = {FMU_REAL, FMU_INT, FMU_BOOL, FMU_TEXT};
    (void)state;
    struct fmu *fmu = fmu_running(TOKEN " =s3684-biss");
    struct fmu_variable row;
    struct fmu_value value;
    size_t truths = 0;
    for (size_t i = 1; fmu_variable(fmu, i, &row); i++) {
        if (!row.input || row.parameter || row.type == FMU_CLOCK) {
            continue;
        }
        truths += row.type == FMU_BOOL ? 1 : 0;
        for (size_t k = 0; k < DG_COUNT(types); k++) {
            const bool number = types[k] == FMU_REAL || types[k] == FMU_INT;
            const bool fits = row.type == types[k] || (number && row.type == FMU_REAL);
            assert_int_equal(fmu_get(fmu, row.reference, &value), DG_HOST_OK);
            value.type = types[k];
            assert_int_equal(fmu_set(fmu, row.reference, &value),
                             fits ? DG_HOST_OK : DG_HOST_ERR_ARGUMENT);
        }
    }
    assert_true(truths > 1);
    fmu_free(fmu);
}

static void time_goes_on_and_ends(void **state)
{
    (void)state;
    struct fmu *fmu = fmu_make(TOKEN " =s3684-biss");
    assert_int_equal(fmu_start(fmu, (double)NAN), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(fmu_start(fmu, -2 * FMU_TIME_MAX), DG_HOST_ERR_ARGUMENT);
    assert_false(fmu_may_step(fmu, 0, 1));
    assert_int_equal(fmu_start(fmu, -5), DG_HOST_OK);
    assert_true(fmu_may_step(fmu, -5, 3));
    assert_true(fmu_step(fmu, -5, 3, false) == -2);
    assert_true(fmu_may_step(fmu, -2 - 1e-9, 0)); /* sums of steps are not exact */
    assert_true(fmu_step(fmu, -2 - 1e-9, 0, false) <= -2);
    assert_int_equal(fmu_get(fmu, 0, &(struct fmu_value){0}), DG_HOST_OK);
    assert_false(fmu_may_step(fmu, -2.5, 1));
    assert_false(fmu_may_step(fmu, -2, -1));
    assert_false(fmu_may_step(fmu, (double)NAN, 1));
    assert_false(fmu_may_step(fmu, -2, (double)NAN));
    assert_false(fmu_may_step(fmu, -2, (double)INFINITY));
    assert_false(fmu_may_step(fmu, -2, FMU_TIME_MAX));
    assert_true(fmu_may_step(fmu, -2, 8e9));
    assert_true(fmu_step(fmu, -2, 8e9, false) == 8e9 - 2);
    fmu_free(fmu);
}

static void refused_around(const struct fmu *fmu, double point, double tolerance)
{
    assert_true(fmu_may_step(fmu, point, 1e-3));
    assert_true(fmu_may_step(fmu, point - 0.9 * tolerance, 1e-3));
    assert_true(fmu_may_step(fmu, point + 0.9 * tolerance, 1e-3));
    assert_false(fmu_may_step(fmu, point - 1.3 * tolerance, 1e-3));
    assert_false(fmu_may_step(fmu, point + 1.3 * tolerance, 1e-3));
    assert_false(fmu_may_step(fmu, point + 1e5, 1e-3));
}

/* 4 times the distance of doubles, 2^-52 of a power of 2, is more than 1 us from 2^31 s on. */
static void steps_begin_where_the_last_one_ended(void **state)
{
    static const struct {
        double start, tolerance;
    } rows[] = {
        {0, 1e-6}, {-3.5, 1e-6}, {1e9, 1e-6}, {4294967296.0, 4 * 0x1p-20}, {-8e9, 4 * 0x1p-20},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct fmu *fmu = fmu_make(TOKEN " =s3684-biss");
        assert_int_equal(fmu_start(fmu, rows[i].start), DG_HOST_OK);
        refused_around(fmu, rows[i].start, rows[i].tolerance);
        const double then = fmu_step(fmu, rows[i].start, 0.25, false);
        refused_around(fmu, then, rows[i].tolerance);
        fmu_free(fmu);
    }
}

/* What an importer adds up is its time, however far it is from count times step. */
static void a_million_summed_steps_are_taken(void **state)
{
    static const struct {
        double start;
        long steps;
    } rows[] = {{0, 1000000}, {1e9, 100000}};
    /* Not as literals: x87 has them, and what is worked out with them, with more bits. */
    const volatile double step = 1e-3;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct fmu *fmu = fmu_make(TOKEN " =ssi-25");
        double time = rows[i].start;
        assert_int_equal(fmu_start(fmu, time), DG_HOST_OK);
        fmu_use_events(fmu, true);
        for (long n = 0; n < rows[i].steps; n++) {
            const volatile double next = time + step;
            assert_true(fmu_may_step(fmu, time, step));
            const volatile double reached = fmu_step(fmu, time, step, false);
            assert_true(reached == next);
            time = next;
        }
        assert_true(fmu_time(fmu) - time < 1e-6 && time - fmu_time(fmu) < 1e-6);
        fmu_free(fmu);
    }
}

/* Characters that begin at `at`, as README.md has them. */
static void send_at(struct fmu *fmu, uint64_t at, const char *characters, uint8_t n)
{
    uint8_t bytes[16 + 8] = {0};
    dg_store_le64(bytes, at);
    bytes[12] = n;
    memcpy(bytes + 16, characters, n);
    assert_int_equal(fmu_clock_set(fmu, rx_clock, true), DG_HOST_OK);
    assert_int_equal(fmu_binary_set(fmu, rx, bytes, 16u + n), DG_HOST_OK);
    fmu_clocks_end(fmu);
}

/* 5 s are more nanoseconds than 32 bits have. */
static void moments_have_64_bits(void **state)
{
    (void)state;
    struct fmu *fmu = fmu_running(TOKEN " =s3684-rs485");
    const uint8_t *bytes = NULL;
    size_t n = 0;
    (void)fmu_step(fmu, 0, 4.5, false);
    send_at(fmu, UINT64_C(5000000000), "\x40\x42\x02", 3);
    (void)fmu_step(fmu, 4.5, 0.45, false);
    assert_false(fmu_ticks(fmu));
    (void)fmu_step(fmu, 4.95, 0.1, false);
    assert_true(fmu_ticks(fmu));
    assert_int_equal(fmu_binary_get(fmu, tx, &bytes, &n), DG_HOST_OK);
    assert_true(n > 16);
    const uint64_t at = dg_load_le32(bytes) | (uint64_t)dg_load_le32(bytes + 4) << 32;
    assert_true(at > UINT64_C(5000000000) && at < UINT64_C(5050000000));
    fmu_free(fmu);
}

/* A reply waits, and something happens where the FMU is behind its importer. */
static void early_return_never_goes_back(void **state)
{
    (void)state;
    struct fmu *fmu = fmu_running(TOKEN " =s3684-rs485");
    const double asked = fmu_step(fmu, 0, 0.25, false);
    send_at(fmu, 250000000, "\x40\x42\x02", 3);
    const double begin = fmu_step(fmu, asked, 0.25, false) + 0.9e-6;
    assert_true(fmu_ticks(fmu));
    send_at(fmu, 500000500, "\x40", 1);
    assert_true(fmu_may_step(fmu, begin, 1));
    const double last = fmu_step(fmu, begin, 1, true);
    assert_true(last >= begin && last < begin + 1e-6);
    assert_true(fmu_may_step(fmu, last, 1));
    fmu_free(fmu);
}

/* Whatever bytes a bus brings, in exactly the memory they have. */
static void any_bytes_are_taken_or_refused(void **state)
{
    static const char *const tokens[] = {TOKEN " =f3668", TOKEN " =s3684-rs485"};
    (void)state;
    uint32_t seed = 1;
    for (size_t i = 0; i < 2; i++) {
        struct fmu *fmu = fmu_running(tokens[i]);
        assert_int_equal(fmu_binary_set(fmu, rx, NULL, 0), DG_HOST_OK);
        assert_int_equal(fmu_clock_set(fmu, VARIABLE(FMU_BUS, FMU_TX_CLOCK), true),
                         DG_HOST_ERR_NAME);
        for (int round = 0; round < 3000; round++) {
            const size_t n = (size_t)(round % 40);
            uint8_t *bytes = malloc(n + 1);
            assert_non_null(bytes);
            for (size_t k = 0; k < n; k++) {
                seed = seed * 1664525u + 1013904223u;
                bytes[k] = (seed >> 24 & 3u) == 0 ? (uint8_t)(seed >> 16) : 0;
            }
            static const uint8_t codes[] = {0x10, 0x20, 0x31, 0x40};
            if (n > 8) {
                bytes[0] = codes[round % 4];
                bytes[4] = (uint8_t)n;
                bytes[5] = bytes[6] = bytes[7] = 0;
            }
            assert_int_equal(fmu_clock_set(fmu, rx_clock, true), DG_HOST_OK);
            (void)fmu_binary_set(fmu, rx, bytes, n);
            fmu_clocks_end(fmu);
            (void)fmu_step(fmu, round * 1e-3, 1e-3, round % 2 == 0);
            free(bytes);
        }
        fmu_free(fmu);
    }
}

/* Nobody fetches: what is told stays bounded, and the first of it is kept. */
static void silent_importers_do_no_harm(void **state)
{
    (void)state;
    struct fmu *fmu = fmu_running(TOKEN " =f3668");
    const struct fmu_value off = {.type = FMU_BOOL};
    const struct fmu_value power = {.type = FMU_BOOL, .integer = 1};
    const uint8_t *bytes = NULL;
    size_t n = 0;
    for (int i = 0; i < 300; i++) {
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_POWER), &off), DG_HOST_OK);
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_POWER), &power), DG_HOST_OK);
        (void)fmu_step(fmu, i, 1, false);
    }
    assert_true(fmu_ticks(fmu));
    assert_int_equal(fmu_binary_get(fmu, VARIABLE(FMU_BUS, FMU_TX), &bytes, &n), DG_HOST_OK);
    assert_true(n > 1000 && n <= FMU_WIRE_MAX);
    assert_int_equal(bytes[0], 0x40);
    fmu_clocks_end(fmu);
    (void)fmu_step(fmu, 300, 1e-3, false);
    fmu_free(fmu);
}

/* An encoder that is none, in every group; what a wire brings is not what it tells. */
static void references_to_nowhere_are_refused(void **state)
{
    const struct fmu_value zero = {.type = FMU_REAL};
    const uint8_t *bytes = NULL;
    struct fmu_value value;
    bool clock;
    size_t n = 5;
    struct fmu *fmu = fmu_running(TOKEN " =s3684-rs485");

    (void)state;
    for (uint32_t group = 0; group <= 256; group++) {
        for (uint32_t index = 0; index < 256; index += group <= FMU_BUS + 1 ? 1 : 51) {
            const uint32_t other = UINT32_C(1) << 16 | group << 8 | index;
            assert_int_equal(fmu_get(fmu, other, &value), DG_HOST_ERR_NAME);
            assert_int_equal(fmu_set(fmu, other, &zero), DG_HOST_ERR_NAME);
            assert_int_equal(fmu_clock_get(fmu, other, &clock), DG_HOST_ERR_NAME);
            assert_int_equal(fmu_binary_get(fmu, other, &bytes, &n), DG_HOST_ERR_NAME);
        }
    }
    assert_int_equal(fmu_get(fmu, VARIABLE(FMU_INPUT, FMU_POWER + 1), &value), DG_HOST_ERR_NAME);
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_POWER + 1), &zero), DG_HOST_ERR_NAME);
    assert_int_equal(fmu_get(fmu, VARIABLE(FMU_OUTPUT, FMU_BUS_STATE + 1), &value),
                     DG_HOST_ERR_NAME);
    assert_int_equal(fmu_get(fmu, VARIABLE(FMU_BUS, FMU_RX), &value), DG_HOST_ERR_NAME);
    assert_int_equal(fmu_binary_get(fmu, VARIABLE(FMU_BUS, FMU_RX_CLOCK), &bytes, &n),
                     DG_HOST_ERR_NAME);
    assert_int_equal(fmu_binary_set(fmu, tx, bytes, 0), DG_HOST_ERR_NAME);
    assert_int_equal(fmu_binary_get(fmu, rx, &bytes, &n), DG_HOST_OK);
    assert_int_equal(n, 0);
    fmu_free(fmu);
}

/* Numbers go to the nearest one, below 0 as well: ns, 2^-32 turns, 0.001 degC. */
static void numbers_are_rounded_to_the_nearest(void **state)
{
    static const struct {
        double units;
        int64_t angle;
    } rows[] = {{1.4, 1}, {1.6, 2}, {-1.4, -1}, {-1.6, -2}, {0.6, 1}, {-0.6, -1}};
    const double unit = 6.283185307179586 / 4294967296.0;
    const uint32_t temperature = VARIABLE(FMU_WORLD, 3);
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct fmu_value angle = {.type = FMU_REAL, .real = rows[i].units * unit};
        const struct fmu_value cold = {.type = FMU_REAL, .real = rows[i].units * 1e-3};
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_ANGLE), &angle), DG_HOST_OK);
        (void)fmu_step(fmu, fmu_time(fmu), 1.6e-9, false);
        assert_int_equal(dg_host_angle(fmu_host(fmu, 0), 100), rows[i].angle);
        assert_int_equal(fmu_set(fmu, temperature, &cold), DG_HOST_OK);
        const double milli = fmu_real(fmu, temperature) * 1e3 - (double)rows[i].angle;
        assert_true(milli > -1e-6 && milli < 1e-6);
    }
    assert_true(fmu_time(fmu) > 11.9e-9 && fmu_time(fmu) < 12.1e-9);
    (void)fmu_step(fmu, fmu_time(fmu), 1.4e-9, false);
    assert_true(fmu_time(fmu) > 12.9e-9 && fmu_time(fmu) < 13.1e-9);
    fmu_free(fmu);
}

/* While a frame goes on, which takes 55 us here, the shaft goes on, too: what is set meanwhile is
   of the moment that it was set at, and the next frame begins behind this one, not before. */
static void a_frame_takes_its_time(void **state)
{
    const double turn = 6.283185307179586;
    const struct fmu_value slow = {.type = FMU_REAL, .real = 10 * turn};
    const struct fmu_value fast = {.type = FMU_REAL, .real = 100 * turn};
    const struct fmu_value ahead = {.type = FMU_REAL, .real = 0.5 * turn};
    const uint32_t ma = VARIABLE(FMU_BUS, FMU_MA);
    const uint32_t latched = VARIABLE(FMU_OUTPUT, FMU_FRAME_POSITION);
    const uint32_t position = VARIABLE(FMU_OUTPUT, FMU_POSITION);
    struct dg_host_frame frame;
    struct fmu *fmu = fmu_running(TOKEN " =s3684-biss");
    struct fmu *other = fmu_running(TOKEN " =s3684-biss");

    (void)state;
    assert_int_equal(dg_host_frame(fmu_host(other, 0), 100000000, &frame), DG_HOST_OK);
    const double span = (double)(frame.end - 100000000) * 1e-9;
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_FRAME_GOOD)), 0); /* none yet */
    assert_true(span > 45e-6 && span < 100e-6);
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &slow), DG_HOST_OK);
    (void)fmu_step(fmu, 0, 0.1, false);
    assert_int_equal(fmu_clock_set(fmu, ma, true), DG_HOST_OK);
    fmu_clocks_end(fmu);
    const int64_t first = fmu_integer(fmu, latched);
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_ANGLE), &ahead), DG_HOST_OK);
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &fast), DG_HOST_OK);
    (void)fmu_step(fmu, 0.1, span - 1e-9, false);
    assert_int_equal(fmu_clock_set(fmu, ma, true), DG_HOST_OK);
    fmu_clocks_end(fmu);
    assert_int_equal(fmu_integer(fmu, latched), first);
    (void)fmu_step(fmu, fmu_time(fmu), 1e-9, false);
    assert_int_equal(fmu_clock_set(fmu, ma, true), DG_HOST_OK);
    fmu_clocks_end(fmu);
    assert_int_not_equal(fmu_integer(fmu, latched), first);
    (void)fmu_step(fmu, fmu_time(fmu), 0.01, false);
    const double turns = 0.5 + 100 * (fmu_time(fmu) - 0.1);
    const double off = (double)fmu_integer(fmu, position) - turns * (1 << 21);
    assert_true(off > -3 && off < 3);
    fmu_free(other);
    fmu_free(fmu);
}

/* The bounds belong to it: 1 us. */
static void bounds_are_within(void **state)
{
    struct fmu *fmu = fmu_running(TOKEN " =ssi-25");

    (void)state;
    assert_true(fmu_may_step(fmu, 1e-6, 1) && fmu_may_step(fmu, -1e-6, 1));
    assert_false(fmu_may_step(fmu, 1.001e-6, 1) || fmu_may_step(fmu, -1.001e-6, 1));
    fmu_free(fmu);
}

/* A supply that is off from the start is no fault, and a fault waits for power. */
static void an_encoder_may_start_without_power(void **state)
{
    const struct fmu_value no = {.type = FMU_BOOL};
    const struct fmu_value yes = {.type = FMU_BOOL, .real = 1, .integer = 1};
    const uint32_t power = VARIABLE(FMU_INPUT, FMU_POWER);
    struct fmu *fmu = fmu_make(TOKEN " =s3684-rs485");

    (void)state;
    assert_non_null(fmu);
    assert_int_equal(fmu_set(fmu, power, &no), DG_HOST_OK);
    assert_int_equal(fmu_start(fmu, 0), DG_HOST_OK);
    assert_int_equal(fmu_integer(fmu, power), 0);
    assert_false(dg_host_powered(fmu_host(fmu, 0)));
    (void)fmu_step(fmu, 0, 1, false);
    assert_true(fmu_real(fmu, VARIABLE(FMU_OUTPUT, FMU_SIN_PLUS)) == 0);
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_POSITION)), 0);
    assert_int_equal(fmu_set(fmu, power, &yes), DG_HOST_OK);
    (void)fmu_step(fmu, 1, 1, false);
    assert_true(dg_host_powered(fmu_host(fmu, 0)));
    assert_true(fmu_real(fmu, VARIABLE(FMU_OUTPUT, FMU_SIN_PLUS)) > 1);
    assert_true(fmu_real(fmu, power) == 1);
    fmu_free(fmu);
}

/* Faults beyond the 64th have a bit of their own. */
static void each_fault_has_its_own_truth_value(void **state)
{
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
    struct fmu *fmu = fmu_make(TOKEN " =f3668");

    (void)state;
    assert_non_null(fmu);
    for (uint32_t on = 0; on < FMU_FAULTS_MAX; on++) {
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_FAULT, on), &yes), DG_HOST_OK);
        for (uint32_t i = 0; i < FMU_FAULTS_MAX; i++) {
            assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_FAULT, i)), i <= on);
        }
    }
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_FAULT, FMU_FAULTS_MAX), &yes), DG_HOST_ERR_NAME);
    assert_true(fmu_start(fmu, 0) < 0); /* there are fewer */
    fmu_free(fmu);
    fmu = fmu_running(TOKEN " =f3668");
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_FAULT, 90), &yes), DG_HOST_ERR_NAME);
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_FAULT, 90)), 0);
    fmu_free(fmu);
}

/* Variables of the second encoder. */
#define OF_B(reference) (UINT32_C(1) << 16 | (reference))

static const struct fmu_value turn = {.type = FMU_REAL, .real = 6.283185307179586};

static size_t waiting(struct fmu *fmu, uint32_t reference)
{
    const uint8_t *bytes = NULL;
    size_t n = 0;
    assert_int_equal(fmu_binary_get(fmu, reference, &bytes, &n), DG_HOST_OK);
    return n;
}

/* Each node tells its own bus, and nobody else's; any clock of all is an event. */
static void each_node_has_its_own_bus(void **state)
{
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
    struct fmu *fmu = fmu_running_rig("[encoder a]\nmodel = f3668\nwire = slcan\n"
                                      "[encoder b]\nmodel = f3668\nnode = 9\nwire = slcan\n");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    const size_t first = waiting(fmu, tx);
    assert_true(first > 0);
    assert_int_equal(waiting(fmu, OF_B(tx)), first);
    fmu_clocks_end(fmu);
    assert_int_equal(waiting(fmu, tx) + waiting(fmu, OF_B(tx)), 0);
    assert_false(fmu_ticks(fmu));
    assert_int_equal(fmu_set(fmu, OF_B(VARIABLE(FMU_FAULT, 1)), &yes), DG_HOST_OK);
    (void)fmu_step(fmu, 1, 1, false);
    assert_true(fmu_ticks(fmu));
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE)), 0);
    assert_int_equal(fmu_integer(fmu, OF_B(VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE))), 0x4200);
    assert_int_equal(waiting(fmu, tx), 0);
    assert_true(fmu_ticks(fmu));
    assert_true(waiting(fmu, OF_B(tx)) > 0);
    assert_false(fmu_ticks(fmu));
    fmu_free(fmu);
}

/* Whoever sits on the shaft of another one follows it, whichever has faults, and is not turned. */
static void followers_follow_with_faults_too(void **state)
{
    static const uint32_t faulty[] = {VARIABLE(FMU_FAULT, 0), OF_B(VARIABLE(FMU_FAULT, 0))};
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
    const uint32_t position = VARIABLE(FMU_OUTPUT, FMU_POSITION);

    (void)state;
    for (size_t i = 0; i < DG_COUNT(faulty); i++) {
        struct fmu *fmu = fmu_running_rig("[shaft s]\n[encoder a]\nmodel = f3668\nwire = slcan\n"
                                          "[encoder b]\nmodel = f3668\nwire = slcan\n");
        assert_int_equal(fmu_set(fmu, OF_B(VARIABLE(FMU_INPUT, FMU_ANGLE)), &turn),
                         DG_HOST_ERR_NAME);
        assert_int_equal(fmu_set(fmu, OF_B(VARIABLE(FMU_INPUT, FMU_SPEED)), &turn),
                         DG_HOST_ERR_NAME);
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &turn), DG_HOST_OK);
        (void)fmu_step(fmu, 0, 1, false);
        assert_int_equal(fmu_set(fmu, faulty[i], &yes), DG_HOST_OK);
        (void)fmu_step(fmu, 1, 1, false);
        assert_int_equal(fmu_integer(fmu, position), 2 << 16);
        assert_int_equal(fmu_integer(fmu, OF_B(position)), 2 << 16);
        fmu_free(fmu);
    }
}

/* Without events every clocked encoder is read at the end of each step, and no other one. */
static void all_are_latched_without_events(void **state)
{
    const uint32_t latched = VARIABLE(FMU_OUTPUT, FMU_FRAME_POSITION);
    struct fmu *fmu = fmu_running_rig("[encoder a]\nmodel = ssi-25\nwire = sim\n"
                                      "[encoder b]\nmodel = s3684-biss\nwire = sim\n");

    (void)state;
    fmu_use_events(fmu, false);
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &turn), DG_HOST_OK);
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(fmu_integer(fmu, latched), 1 << 13);
    assert_int_equal(fmu_integer(fmu, OF_B(latched)), 1 << 21);
    assert_int_equal(fmu_integer(fmu, OF_B(VARIABLE(FMU_OUTPUT, FMU_NERR))), 1);
    assert_int_equal(fmu_integer(fmu, OF_B(VARIABLE(FMU_OUTPUT, FMU_NWARN))), 1);
    fmu_use_events(fmu, true);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(fmu_integer(fmu, latched), 1 << 13);
    assert_int_equal(fmu_integer(fmu, OF_B(latched)), 1 << 21);
    assert_int_equal(fmu_clock_set(fmu, OF_B(VARIABLE(FMU_BUS, FMU_MA)), true), DG_HOST_OK);
    assert_int_equal(fmu_integer(fmu, latched), 1 << 13);
    assert_int_equal(fmu_integer(fmu, OF_B(latched)), 2 << 21);
    fmu_free(fmu);
}

/* The position of a frame is that of the end of the step whatever is set before it is read, and LC
   counts the frames that somebody has read. */
static void a_frame_that_nobody_reads_is_none(void **state)
{
    const uint32_t bits = VARIABLE(FMU_OUTPUT, FMU_FRAME);
    const uint32_t latched = VARIABLE(FMU_OUTPUT, FMU_FRAME_POSITION);
    const struct fmu_value turned = {.type = FMU_REAL, .real = 3.0};
    const struct fmu_value no = {.type = FMU_BOOL};
    (void)state;
    struct fmu *fmu = fmu_running(TOKEN " =s3684-biss");
    struct fmu_variable row;
    size_t i = 0;
    fmu_use_events(fmu, false);
    for (uint64_t step = 0; step < 5; step++) {
        assert_true(fmu_step(fmu, (double)step, 1, false) > (double)step);
    }
    assert_int_equal(fmu_integer(fmu, bits) >> 6 & 63, 0); /* the first one since power-on */
    assert_true(fmu_step(fmu, 5, 1, false) > 5);
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_ANGLE), &turned), DG_HOST_OK);
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_POSITION)), 0);
    assert_int_equal(fmu_integer(fmu, latched), 0);
    assert_int_equal(fmu_integer(fmu, bits) >> 6 & 63, 1);
    assert_true(fmu_step(fmu, 6, 1, false) > 6);
    while (fmu_variable(fmu, i, &row) && strcmp(row.name, "world.singleturn_ok") != 0) {
        i++;
    }
    assert_int_equal(fmu_set(fmu, row.reference, &no), DG_HOST_OK);
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_NERR)), 1);
    assert_true(fmu_step(fmu, 7, 1, false) > 7);
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_NERR)), 0);
    fmu_free(fmu);
}

/* Off and on again is a restart, on and on is none. */
static void power_that_stays_is_no_restart(void **state)
{
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
    const struct fmu_value no = {.type = FMU_BOOL};
    const uint32_t power = VARIABLE(FMU_INPUT, FMU_POWER);
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    assert_true(waiting(fmu, tx) > 0);
    fmu_clocks_end(fmu);
    assert_int_equal(fmu_set(fmu, power, &yes), DG_HOST_OK);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(waiting(fmu, tx), 0);
    assert_int_equal(fmu_set(fmu, power, &no), DG_HOST_OK);
    assert_int_equal(fmu_set(fmu, power, &yes), DG_HOST_OK);
    (void)fmu_step(fmu, 2, 1, false);
    assert_true(waiting(fmu, tx) > 0);
    fmu_free(fmu);
}

/* What is no number, or is beyond what a shaft or a world can be; nothing changes. */
static void numbers_that_are_none_are_refused(void **state)
{
    static const uint32_t inputs[] = {VARIABLE(FMU_INPUT, FMU_ANGLE),
                                      VARIABLE(FMU_INPUT, FMU_SPEED), VARIABLE(FMU_WORLD, 3)};
    const double wrong[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e300, -1e300};
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    for (size_t i = 0; i < DG_COUNT(inputs); i++) {
        const double before = fmu_real(fmu, inputs[i]);
        for (size_t k = 0; k < DG_COUNT(wrong); k++) {
            const struct fmu_value value = {.type = FMU_REAL, .real = wrong[k]};
            assert_int_equal(fmu_set(fmu, inputs[i], &value), DG_HOST_ERR_ARGUMENT);
        }
        assert_true(fmu_real(fmu, inputs[i]) == before);
    }
    assert_int_equal(
        fmu_set(fmu, VARIABLE(FMU_WORLD, 3), &(struct fmu_value){.type = FMU_REAL, .real = 1001}),
        DG_HOST_ERR_ARGUMENT);
    fmu_free(fmu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tokens_are_whole_or_refused),
        cmocka_unit_test(variables_are_what_they_say),
        cmocka_unit_test(values_of_another_kind_are_refused),
        cmocka_unit_test(time_goes_on_and_ends),
        cmocka_unit_test(steps_begin_where_the_last_one_ended),
        cmocka_unit_test(a_million_summed_steps_are_taken),
        cmocka_unit_test(moments_have_64_bits),
        cmocka_unit_test(early_return_never_goes_back),
        cmocka_unit_test(any_bytes_are_taken_or_refused),
        cmocka_unit_test(silent_importers_do_no_harm),
        cmocka_unit_test(references_to_nowhere_are_refused),
        cmocka_unit_test(numbers_are_rounded_to_the_nearest),
        cmocka_unit_test(a_frame_takes_its_time),
        cmocka_unit_test(bounds_are_within),
        cmocka_unit_test(an_encoder_may_start_without_power),
        cmocka_unit_test(each_fault_has_its_own_truth_value),
        cmocka_unit_test(each_node_has_its_own_bus),
        cmocka_unit_test(followers_follow_with_faults_too),
        cmocka_unit_test(all_are_latched_without_events),
        cmocka_unit_test(a_frame_that_nobody_reads_is_none),
        cmocka_unit_test(power_that_stays_is_no_restart),
        cmocka_unit_test(numbers_that_are_none_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

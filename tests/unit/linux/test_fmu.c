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
#include "drehgeber/version.h"
#include "fmu.h"

#define TOKEN "drehgeber " DG_VERSION
#define VARIABLE(group, index) ((uint32_t)(group) << 8 | (uint32_t)(index))

static const uint32_t rx = VARIABLE(FMU_BUS, FMU_RX);
static const uint32_t tx = VARIABLE(FMU_BUS, FMU_TX);
static const uint32_t rx_clock = VARIABLE(FMU_BUS, FMU_RX_CLOCK);

static int64_t integer(struct fmu *fmu, uint32_t reference)
{
    struct fmu_value value;
    assert_int_equal(fmu_get(fmu, reference, &value), DG_HOST_OK);
    return value.integer;
}

static struct fmu *on(const char *token)
{
    struct fmu *fmu = fmu_make(token);
    assert_non_null(fmu);
    fmu_use_events(fmu, true);
    assert_int_equal(fmu_start(fmu, 0), DG_HOST_OK);
    return fmu;
}

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
        TOKEN " a=f3668 b=f3668@1",
        TOKEN " =f3668,node=%3",
        TOKEN " =f3668,node=%3x",
        TOKEN " =f3668 ",
    };
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_null(fmu_make(bad[i]));
    }
    assert_null(fmu_make(NULL));
    fmu_free(NULL);
    struct fmu *fmu = on(TOKEN " a=f3668,node=%35 b=s3684-rs485@0,designation=it%20is");
    assert_int_equal(fmu_count(fmu), 2);
    assert_string_equal(fmu_prefix(fmu, 0), "a.");
    assert_false(fmu_follows(fmu, 0));
    assert_true(fmu_follows(fmu, 1));
    char text[32];
    assert_int_equal(dg_host_get(fmu_host(fmu, 0), "node", text, sizeof text), 1);
    assert_string_equal(text, "5");
    assert_true(dg_host_get(fmu_host(fmu, 1), "designation", text, sizeof text) > 0);
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
        struct fmu *fmu = on(token);
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
    struct fmu *fmu = on(TOKEN " =s3684-biss");
    struct fmu_variable row;
    struct fmu_value value;
    size_t truths = 0;
    for (size_t i = 1; fmu_variable(fmu, i, &row); i++) {
        if (!row.input || row.parameter || row.type == FMU_CLOCK) {
            continue;
        }
        truths += row.type == FMU_BOOL ? 1 : 0;
        for (size_t k = 0; k < sizeof types / sizeof types[0]; k++) {
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

static void states_go_on(void **state)
{
    (void)state;
    const struct fmu_value fast = {.type = FMU_REAL, .real = 314.0};
    struct fmu *one = on(TOKEN " =s3684-rs485");
    struct fmu *two = on(TOKEN " =s3684-rs485");
    struct fmu *foreign = on(TOKEN " =s3674-rs485");
    assert_int_equal(fmu_set(one, VARIABLE(FMU_INPUT, FMU_SPEED), &fast), DG_HOST_OK);
    (void)fmu_step(one, 0, 0.3, false);
    const size_t n = fmu_state_size(one);
    uint8_t *bytes = malloc(n);
    assert_non_null(bytes);
    assert_int_equal(fmu_save(one, bytes, n - 1), DG_HOST_ERR_SPACE);
    assert_int_equal(fmu_save(one, bytes, n), DG_HOST_OK);
    assert_int_equal(fmu_restore(two, bytes, n - 1), DG_HOST_ERR_OTHER);
    assert_int_equal(fmu_restore(foreign, bytes, n), DG_HOST_ERR_OTHER);
    assert_int_equal(fmu_restore(two, bytes, n), DG_HOST_OK);
    (void)fmu_step(one, 0.3, 0.1, false);
    (void)fmu_step(two, 0.3, 0.1, false);
    assert_true(integer(one, VARIABLE(FMU_OUTPUT, FMU_POSITION)) > 0);
    assert_int_equal(integer(one, VARIABLE(FMU_OUTPUT, FMU_POSITION)),
                     integer(two, VARIABLE(FMU_OUTPUT, FMU_POSITION)));
    assert_int_equal(fmu_reset(one), 0);
    assert_int_equal(fmu_start(one, 5), DG_HOST_OK);
    assert_int_equal(integer(one, VARIABLE(FMU_OUTPUT, FMU_POSITION)), 0);
    free(bytes);
    fmu_free(one);
    fmu_free(two);
    fmu_free(foreign);
}

/* Importers keep states in files: one that is not what was saved is refused, and changes nothing.
 */
static void damaged_states_are_refused(void **state)
{
    (void)state;
    struct fmu *fmu = on(TOKEN " =f3668");
    (void)fmu_step(fmu, 0, 0.3, false);
    const size_t n = fmu_state_size(fmu);
    uint8_t *bytes = malloc(n + 1u);
    uint8_t *again = malloc(n);
    assert_non_null(bytes);
    assert_non_null(again);
    assert_int_equal(fmu_save(fmu, bytes, n), DG_HOST_OK);
    bytes[n] = 0;
    assert_int_equal(fmu_restore(fmu, bytes, n + 1u), DG_HOST_ERR_OTHER);
    for (size_t i = 0; i < n; i += i < 300u ? 1u : 61u) {
        bytes[i] ^= 0x80u;
        assert_true(fmu_restore(fmu, bytes, n) < 0);
        bytes[i] ^= 0x80u;
    }
    assert_int_equal(fmu_save(fmu, again, n), DG_HOST_OK);
    assert_memory_equal(again, bytes, n);
    assert_int_equal(fmu_restore(fmu, bytes, n), DG_HOST_OK);
    free(bytes);
    free(again);
    fmu_free(fmu);
}

/* Both sums of a state of one encoder, made right. */
static void sign(struct fmu *fmu, uint8_t *bytes, size_t n)
{
    const struct dg_host *host = fmu_host(fmu, 0);
    const size_t body = dg_host_size_of(dg_host_model(host));
    uint32_t sum = dg_crc32(0, bytes + (n - sizeof sum - body), body);
    memcpy(bytes + (n - 2 * sizeof sum - body), &sum, sizeof sum);
    sum = dg_crc32(0, bytes, n - sizeof sum);
    memcpy(bytes + (n - sizeof sum), &sum, sizeof sum);
}

static void live(struct fmu *fmu, uint64_t round)
{
    const struct fmu_value speed = {.type = FMU_REAL, .real = (double)round};
    struct fmu_variable row;
    struct fmu_value value;
    const uint8_t *bytes;
    size_t waits;
    (void)fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &speed);
    (void)fmu_clock_set(fmu, VARIABLE(FMU_BUS, FMU_MA), true);
    fmu_clocks_end(fmu);
    if (fmu_may_step(fmu, fmu_time(fmu), 0.05)) {
        (void)fmu_step(fmu, fmu_time(fmu), 0.05, round % 2 == 0);
    }
    for (size_t i = 1; fmu_variable(fmu, i, &row); i++) {
        (void)fmu_get(fmu, row.reference, &value);
    }
    (void)fmu_binary_get(fmu, VARIABLE(FMU_BUS, FMU_TX), &bytes, &waits);
    fmu_clocks_end(fmu);
}

/* States that somebody has made: refused without a trace, or lived with. */
static void forged_states_do_no_harm(void **state)
{
    static const char *const tokens[] = {TOKEN " =f3668", TOKEN " =s3684-rs485",
                                         TOKEN " =s3684-biss"};
    static const uint8_t values[] = {0x00, 0x02, 0x40, 0x7F, 0xC5, 0xFF};
    (void)state;
    unsigned refused = 0;
    for (size_t i = 0; i < sizeof tokens / sizeof tokens[0]; i++) {
        struct fmu *fmu = on(tokens[i]);
        (void)fmu_step(fmu, 0, 0.3, false);
        const size_t n = fmu_state_size(fmu);
        const size_t head = strlen(tokens[i]);
        uint8_t *whole = malloc(n);
        uint8_t *forged = malloc(n);
        assert_true(whole != NULL && forged != NULL);
        assert_int_equal(fmu_save(fmu, whole, n), DG_HOST_OK);
        for (uint64_t at = head; at + 8 < head + 330; at++) {
            memcpy(forged, whole, n);
            memset(forged + at, values[at % sizeof values], at % 3 == 0 ? 8 : 1);
            sign(fmu, forged, n);
            const int result = fmu_restore(fmu, forged, n);
            assert_true(result == DG_HOST_OK || result == DG_HOST_ERR_DAMAGED);
            if (result == DG_HOST_OK) {
                live(fmu, at);
                assert_int_equal(fmu_restore(fmu, whole, n), DG_HOST_OK);
            } else {
                refused++;
            }
            assert_int_equal(fmu_save(fmu, forged, n), DG_HOST_OK);
            assert_memory_equal(forged, whole, n);
        }
        free(whole);
        free(forged);
        fmu_free(fmu);
    }
    assert_true(refused > 20);
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
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
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
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
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
    struct fmu *fmu = on(TOKEN " =s3684-rs485");
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
    struct fmu *fmu = on(TOKEN " =s3684-rs485");
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

/* One that was never on takes a state with a fault, and makes it good. */
static void states_bring_their_faults(void **state)
{
    (void)state;
    const uint32_t fault = VARIABLE(FMU_FAULT, 1); /* temperature_high */
    const uint32_t code = VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE);
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
    const struct fmu_value no = {.type = FMU_BOOL};
    struct fmu *one = on(TOKEN " =f3668");
    struct fmu *two = fmu_make(TOKEN " =f3668");
    assert_non_null(two);
    (void)fmu_step(one, 0, 1, false);
    assert_int_equal(fmu_set(one, fault, &yes), DG_HOST_OK);
    (void)fmu_step(one, 1, 1, false);
    assert_int_equal(integer(one, code), 0x4200);
    const size_t n = fmu_state_size(one);
    uint8_t *bytes = malloc(n);
    assert_non_null(bytes);
    assert_int_equal(fmu_save(one, bytes, n), DG_HOST_OK);
    assert_int_equal(fmu_restore(two, bytes, n), DG_HOST_OK);
    assert_int_equal(integer(two, fault), 1);
    assert_int_equal(fmu_set(two, fault, &no), DG_HOST_OK);
    (void)fmu_step(two, 2, 2, false);
    assert_int_equal(integer(two, code), 0);
    free(bytes);
    fmu_free(one);
    fmu_free(two);
}

/* Whatever bytes a bus brings, in exactly the memory they have. */
static void any_bytes_are_taken_or_refused(void **state)
{
    static const char *const tokens[] = {TOKEN " =f3668", TOKEN " =s3684-rs485"};
    (void)state;
    uint32_t seed = 1;
    for (size_t i = 0; i < 2; i++) {
        struct fmu *fmu = on(tokens[i]);
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
    struct fmu *fmu = on(TOKEN " =f3668");
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tokens_are_whole_or_refused),
        cmocka_unit_test(variables_are_what_they_say),
        cmocka_unit_test(values_of_another_kind_are_refused),
        cmocka_unit_test(states_go_on),
        cmocka_unit_test(damaged_states_are_refused),
        cmocka_unit_test(forged_states_do_no_harm),
        cmocka_unit_test(time_goes_on_and_ends),
        cmocka_unit_test(steps_begin_where_the_last_one_ended),
        cmocka_unit_test(a_million_summed_steps_are_taken),
        cmocka_unit_test(moments_have_64_bits),
        cmocka_unit_test(early_return_never_goes_back),
        cmocka_unit_test(states_bring_their_faults),
        cmocka_unit_test(any_bytes_are_taken_or_refused),
        cmocka_unit_test(silent_importers_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

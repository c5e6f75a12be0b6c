/* SPDX-License-Identifier: MIT */
/* States of an FMU: they go on elsewhere, and those that somebody has damaged or made do no harm.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/crc.h"
#include "fmu_rig.h"

static void states_go_on(void **state)
{
    (void)state;
    const struct fmu_value fast = {.type = FMU_REAL, .real = 314.0};
    struct fmu *one = fmu_running(TOKEN " =s3684-rs485");
    struct fmu *two = fmu_running(TOKEN " =s3684-rs485");
    struct fmu *foreign = fmu_running(TOKEN " =s3674-rs485");
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
    assert_true(fmu_integer(one, VARIABLE(FMU_OUTPUT, FMU_POSITION)) > 0);
    assert_int_equal(fmu_integer(one, VARIABLE(FMU_OUTPUT, FMU_POSITION)),
                     fmu_integer(two, VARIABLE(FMU_OUTPUT, FMU_POSITION)));
    assert_int_equal(fmu_reset(one), 0);
    assert_int_equal(fmu_start(one, 5), DG_HOST_OK);
    assert_int_equal(fmu_integer(one, VARIABLE(FMU_OUTPUT, FMU_POSITION)), 0);
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
    struct fmu *fmu = fmu_running(TOKEN " =f3668");
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
    for (size_t i = 0; i < DG_COUNT(tokens); i++) {
        struct fmu *fmu = fmu_running(tokens[i]);
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

/* One that was never on takes a state with a fault, and makes it good. */
static void states_bring_their_faults(void **state)
{
    (void)state;
    const uint32_t fault = VARIABLE(FMU_FAULT, 1); /* temperature_high */
    const uint32_t code = VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE);
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
    const struct fmu_value no = {.type = FMU_BOOL};
    struct fmu *one = fmu_running(TOKEN " =f3668");
    struct fmu *two = fmu_make(TOKEN " =f3668");
    assert_non_null(two);
    (void)fmu_step(one, 0, 1, false);
    assert_int_equal(fmu_set(one, fault, &yes), DG_HOST_OK);
    (void)fmu_step(one, 1, 1, false);
    assert_int_equal(fmu_integer(one, code), 0x4200);
    const size_t n = fmu_state_size(one);
    uint8_t *bytes = malloc(n);
    assert_non_null(bytes);
    assert_int_equal(fmu_save(one, bytes, n), DG_HOST_OK);
    assert_int_equal(fmu_restore(two, bytes, n), DG_HOST_OK);
    assert_int_equal(fmu_integer(two, fault), 1);
    assert_int_equal(fmu_set(two, fault, &no), DG_HOST_OK);
    (void)fmu_step(two, 2, 2, false);
    assert_int_equal(fmu_integer(two, code), 0);
    free(bytes);
    fmu_free(one);
    fmu_free(two);
}

static uint8_t *saved(struct fmu *fmu, size_t *n)
{
    *n = fmu_state_size(fmu);
    uint8_t *bytes = malloc(*n);
    assert_non_null(bytes);
    assert_int_equal(fmu_save(fmu, bytes, *n), DG_HOST_OK);
    return bytes;
}

/* Of two encoders the second one's is damaged within: the first one goes on as it was, too. */
static void a_state_is_taken_whole_or_not(void **state)
{
    const struct fmu_value fast = {.type = FMU_REAL, .real = 100.0};
    const uint32_t position = VARIABLE(FMU_OUTPUT, FMU_POSITION);
    const uint32_t of_b = UINT32_C(1) << 16;
    struct fmu *fmu = fmu_running_rig("[encoder a]\nmodel = f3668\nwire = slcan\n"
                                      "[encoder b]\nmodel = s3684-biss\nwire = sim\n");
    size_t n = 0;

    (void)state;
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &fast), DG_HOST_OK);
    (void)fmu_step(fmu, 0, 0.25, false);
    uint8_t *forged = saved(fmu, &n);
    uint8_t *whole = saved(fmu, &n);
    (void)fmu_step(fmu, 0.25, 0.25, false);
    const int64_t before[] = {fmu_integer(fmu, position), fmu_integer(fmu, of_b | position)};
    forged[n - 100] ^= 1;
    const uint32_t sum = dg_crc32(0, forged, n - sizeof sum);
    memcpy(forged + n - sizeof sum, &sum, sizeof sum);
    assert_int_equal(fmu_restore(fmu, forged, n), DG_HOST_ERR_DAMAGED);
    assert_true(fmu_time(fmu) == 0.5);
    assert_int_equal(fmu_integer(fmu, position), before[0]);
    assert_int_equal(fmu_integer(fmu, of_b | position), before[1]);
    assert_int_equal(fmu_restore(fmu, whole, n), DG_HOST_OK);
    assert_true(fmu_time(fmu) == 0.25);
    assert_true(fmu_integer(fmu, position) < before[0]);
    (void)fmu_step(fmu, 0.25, 0.25, false);
    assert_int_equal(fmu_integer(fmu, position), before[0]);
    assert_int_equal(fmu_integer(fmu, of_b | position), before[1]);
    free(whole);
    free(forged);
    fmu_free(fmu);
}

/* Before power as well: then settings are open again, and time begins elsewhere. */
static void a_state_brings_its_beginning(void **state)
{
    const struct fmu_value nine = {.type = FMU_INT, .real = 9, .integer = 9};
    const uint32_t node = VARIABLE(FMU_PARAMETER, 0);
    struct fmu *early = fmu_make(TOKEN " =f3668");
    struct fmu *late = fmu_make(TOKEN " =f3668");
    size_t n = 0;

    (void)state;
    assert_true(early != NULL && late != NULL);
    assert_true(fmu_time(early) == 0);
    assert_int_equal(fmu_start(late, 7.5), DG_HOST_OK);
    (void)fmu_step(late, 7.5, 0.5, false);
    uint8_t *new = saved(early, &n);
    uint8_t *old = saved(late, &n);
    assert_int_equal(fmu_restore(early, old, n), DG_HOST_OK);
    assert_true(fmu_time(early) == 8.0 && fmu_real(early, 0) == 8.0);
    assert_true(fmu_started(early));
    assert_int_equal(fmu_set(early, node, &nine), DG_HOST_ERR_STATE);
    assert_int_equal(fmu_restore(late, new, n), DG_HOST_OK);
    assert_false(fmu_started(late));
    assert_true(fmu_time(late) == 0);
    assert_int_equal(fmu_set(late, node, &nine), DG_HOST_OK);
    assert_int_equal(fmu_integer(late, node), 9);
    assert_int_equal(fmu_start(late, -3), DG_HOST_OK);
    assert_true(fmu_time(late) == -3);
    free(new);
    free(old);
    fmu_free(early);
    fmu_free(late);
}

/* Whether a state is taken with this value in one of its bytes. */
static bool takes(struct fmu *fmu, const uint8_t *whole, uint8_t *forged, size_t n, size_t at,
                  uint8_t value)
{
    memcpy(forged, whole, n);
    forged[at] = value;
    sign(fmu, forged, n);
    return fmu_restore(fmu, forged, n) == DG_HOST_OK;
}

/* Truth values are 0 or 1, of which a state has one for all, two for a shaft and five for an
   encoder; a controller is 0 to 2, as it is and as its wire was told; at most 2048 bytes wait. */
static void numbers_in_a_state_have_their_range(void **state)
{
    static const char token[] = TOKEN " =s3684-biss";
    unsigned truths = 0;
    unsigned controllers = 0;
    unsigned lengths = 0;
    size_t n = 0;
    struct fmu *fmu = fmu_running(token);

    (void)state;
    (void)fmu_step(fmu, 0, 0.3, false);
    uint8_t *whole = saved(fmu, &n);
    uint8_t *forged = saved(fmu, &n);
    for (size_t at = strlen(token); at < strlen(token) + 180; at++) {
        const bool one = takes(fmu, whole, forged, n, at, 1);
        const bool two = takes(fmu, whole, forged, n, at, 2);
        truths += one && !two ? 1 : 0;
        controllers += two && !takes(fmu, whole, forged, n, at, 3) ? 1 : 0;
        lengths += takes(fmu, whole, forged, n, at, 8) && !takes(fmu, whole, forged, n, at, 9);
    }
    assert_int_equal(truths, 8);
    assert_int_equal(controllers, 2);
    assert_int_equal(lengths, 1);
    free(whole);
    free(forged);
    fmu_free(fmu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(states_go_on),
        cmocka_unit_test(damaged_states_are_refused),
        cmocka_unit_test(forged_states_do_no_harm),
        cmocka_unit_test(states_bring_their_faults),
        cmocka_unit_test(a_state_is_taken_whole_or_not),
        cmocka_unit_test(a_state_brings_its_beginning),
        cmocka_unit_test(numbers_in_a_state_have_their_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

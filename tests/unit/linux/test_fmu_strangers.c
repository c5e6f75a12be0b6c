/* SPDX-License-Identifier: MIT */
/*
 * Protocols that an FMU has never heard of: it goes by their medium and by what they can do, and
 * refuses what it cannot have.
 */
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "fmu_rig.h"
#include "strangers.h"

static bool has(struct fmu *fmu, const char *name)
{
    struct fmu_variable row;

    for (size_t i = 0; fmu_variable(fmu, i, &row); i++) {
        if (strcmp(row.name, name) == 0) {
            return true;
        }
    }
    return false;
}

/* The variables of wires that a stranger has of all these. */
static void assert_wire(const char *model, const char *const *own, size_t count)
{
    static const char *const all[] = {"sin_plus",
                                      "frame",
                                      "nERR",
                                      "error.code",
                                      "bus_state",
                                      "MA",
                                      "CanChannel.Rx_Data",
                                      "CanChannel.Tx_Clock",
                                      "RS485.Rx_Data",
                                      "RS485.Tx_Clock"};
    char token[64] = TOKEN " =";
    struct fmu *fmu = fmu_make(strcat(token, model));

    assert_non_null(fmu);
    assert_true(has(fmu, "position"));
    for (size_t i = 0; i < DG_COUNT(all); i++) {
        bool is_own = false;
        for (size_t k = 0; k < count; k++) {
            is_own = is_own || strcmp(own[k], all[i]) == 0;
        }
        assert_int_equal(has(fmu, all[i]), is_own);
    }
    fmu_free(fmu);
}

static void the_medium_says_which_wire_there_is(void **state)
{
    static const char *const characters[] = {"RS485.Rx_Data", "RS485.Tx_Clock"};
    static const char *const edges[] = {"frame", "nERR", "MA"};

    (void)state;
    assert_wire(STRANGER_CHARACTERS, characters, 2);
    assert_wire(STRANGER_EDGES, edges, 3);
    assert_wire(STRANGER_WORDS, NULL, 0);
}

/* A quarter of a turn: 2^11 of 13 bits. */
static void a_frame_of_a_stranger_is_read(void **state)
{
    struct fmu *fmu = fmu_running(TOKEN " =" STRANGER_EDGES);
    const struct fmu_value quarter = {.type = FMU_REAL, .real = 1.5707963267948966};
    const uint32_t ma = VARIABLE(FMU_BUS, FMU_MA);

    (void)state;
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_ANGLE), &quarter), DG_HOST_OK);
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(fmu_clock_set(fmu, ma, true), DG_HOST_OK);
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_FRAME_POSITION)), 1 << 11);
    assert_int_equal(fmu_integer(fmu, VARIABLE(FMU_OUTPUT, FMU_FRAME_BITS)), 25);
    fmu_free(fmu);
}

/* Nobody knows how long its characters take but the master. */
static void characters_for_a_stranger_say_how_long_they_take(void **state)
{
    static uint8_t request[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0x40, 0x42, 0x02};
    struct fmu *fmu = fmu_running(TOKEN " =" STRANGER_CHARACTERS);
    const uint32_t rx = VARIABLE(FMU_BUS, FMU_RX);
    const uint8_t *bytes = NULL;
    size_t n = 0;

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(fmu_clock_set(fmu, VARIABLE(FMU_BUS, FMU_RX_CLOCK), true), DG_HOST_OK);
    assert_int_equal(fmu_binary_set(fmu, rx, request, sizeof request), DG_HOST_ERR_WIRE);
    request[9] = 0x7C; /* 1145834 ns would be exact; 1146 us and a bit are near enough */
    request[8] = 0xEA;
    request[10] = 0x11;
    assert_int_equal(fmu_binary_set(fmu, rx, request, sizeof request), DG_HOST_OK);
    fmu_clocks_end(fmu);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(fmu_binary_get(fmu, VARIABLE(FMU_BUS, FMU_TX), &bytes, &n), DG_HOST_OK);
    assert_true(n >= 16 + 7);
    assert_int_equal(bytes[16], 0x40);
    assert_int_equal(bytes[17], 0x42);
    fmu_free(fmu);
}

/* A medium from later releases; a CAN channel that would begin without its bit rate. */
static void what_an_fmu_cannot_have_is_refused(void **state)
{
    static const char *const models[] = {STRANGER_FUTURE, STRANGER_FRAMES};
    static alignas(DG_HOST_ALIGN) uint8_t memory[STRANGER_MEMORY_MAX];

    (void)state;
    for (size_t i = 0; i < DG_COUNT(models); i++) {
        char token[64] = TOKEN " =";
        struct dg_host *host = dg_host_make(memory, sizeof memory, models[i]);
        assert_non_null(host);
        assert_false(fmu_can_have(host));
        assert_null(fmu_make(strcat(token, models[i])));
    }
    assert_true(fmu_can_have(dg_host_make(memory, sizeof memory, STRANGER_WORDS)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_medium_says_which_wire_there_is),
        cmocka_unit_test(a_frame_of_a_stranger_is_read),
        cmocka_unit_test(characters_for_a_stranger_say_how_long_they_take),
        cmocka_unit_test(what_an_fmu_cannot_have_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/* The wires of an FMU: what a bus brings, bit for bit and error for error, and what comes of it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "fmu_rig.h"

/* --- CAN: operations of FMI-LS-BUS 1.0 --- */

/* Give the node these, and let their clock tick. @return what the FMU makes of them */
static int give(struct fmu *fmu, const uint8_t *bytes, size_t n)
{
    assert_int_equal(fmu_clock_set(fmu, VARIABLE(FMU_BUS, FMU_RX_CLOCK), true), DG_HOST_OK);
    const int result = fmu_binary_set(fmu, VARIABLE(FMU_BUS, FMU_RX), bytes, n);
    fmu_clocks_end(fmu);
    return result;
}

/* Fetch what waits. @return how many bytes */
static size_t fetch(struct fmu *fmu, const uint8_t **bytes)
{
    size_t n = 0;
    assert_int_equal(fmu_binary_get(fmu, VARIABLE(FMU_BUS, FMU_TX), bytes, &n), DG_HOST_OK);
    fmu_clocks_end(fmu);
    return n;
}

static int64_t bus_state(struct fmu *fmu)
{
    struct fmu_value value;
    assert_int_equal(fmu_get(fmu, VARIABLE(FMU_OUTPUT, FMU_BUS_STATE), &value), DG_HOST_OK);
    return value.integer;
}

enum { PRIMARY = 1, SECONDARY = 2, RECEIVED = 0, SENT = 1 };

static void give_errors(struct fmu *fmu, int times, uint8_t flag, uint8_t sent)
{
    const uint8_t error[] = {0x31, 0, 0, 0, 15, 0, 0, 0, 0x3F, 7, 0, 0, 1, flag, sent};
    for (int i = 0; i < times; i++) {
        assert_int_equal(give(fmu, error, sizeof error), DG_HOST_OK);
    }
}

/* A frame that no node of these has. */
static void give_frames(struct fmu *fmu, int times)
{
    static const uint8_t frame[] = {0x10, 0, 0, 0, 16, 0, 0, 0, 0xFF, 7, 0, 0, 0, 0, 0, 0};
    for (int i = 0; i < times; i++) {
        assert_int_equal(give(fmu, frame, sizeof frame), DG_HOST_OK);
    }
}

static void give_confirms(struct fmu *fmu, int times)
{
    static const uint8_t confirm[] = {0x20, 0, 0, 0, 12, 0, 0, 0, 0x3F, 7, 0, 0};
    for (int i = 0; i < times; i++) {
        assert_int_equal(give(fmu, confirm, sizeof confirm), DG_HOST_OK);
    }
}

/* ISO 11898-1, fault confinement: 8 up for what was sent, 1 down; error passive beyond 127,
   bus-off beyond 255, which frames do not end. */
static void errors_of_a_sender_are_counted(void **state)
{
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    give_confirms(fmu, 3); /* not below 0 */
    give_errors(fmu, 15, PRIMARY, SENT);
    give_confirms(fmu, 1); /* 119 */
    give_errors(fmu, 1, SECONDARY, SENT);
    assert_int_equal(bus_state(fmu), 0); /* 127 */
    give_errors(fmu, 1, PRIMARY, SENT);
    assert_int_equal(bus_state(fmu), 1); /* 135 */
    give_confirms(fmu, 7);
    assert_int_equal(bus_state(fmu), 1); /* 128 */
    give_confirms(fmu, 1);
    assert_int_equal(bus_state(fmu), 0);
    give_errors(fmu, 16, PRIMARY, SENT);
    assert_int_equal(bus_state(fmu), 1); /* 255 */
    give_errors(fmu, 1, PRIMARY, SENT);
    assert_int_equal(bus_state(fmu), 2);
    give_confirms(fmu, 300);
    give_frames(fmu, 300);
    assert_int_equal(bus_state(fmu), 2);
    fmu_free(fmu);
}

/* 1 up for what was received, 8 for whoever saw it first; a good frame is 1 down, and from beyond
   127 it goes to between 119 and 127. No receiver goes bus-off. */
static void errors_of_a_receiver_are_counted(void **state)
{
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    give_frames(fmu, 3); /* not below 0 */
    give_errors(fmu, 127, SECONDARY, RECEIVED);
    give_frames(fmu, 1);
    give_errors(fmu, 1, SECONDARY, RECEIVED);
    assert_int_equal(bus_state(fmu), 0); /* 127 */
    give_errors(fmu, 1, SECONDARY, RECEIVED);
    assert_int_equal(bus_state(fmu), 1); /* 128 */
    give_frames(fmu, 1);
    assert_int_equal(bus_state(fmu), 0);
    give_errors(fmu, 10000, PRIMARY, RECEIVED);
    assert_int_equal(bus_state(fmu), 1);
    give_frames(fmu, 1);
    assert_int_equal(bus_state(fmu), 0);
    give_frames(fmu, 200);
    give_errors(fmu, 15, PRIMARY, RECEIVED); /* 120 */
    assert_int_equal(bus_state(fmu), 0);
    give_errors(fmu, 1, PRIMARY, RECEIVED);
    assert_int_equal(bus_state(fmu), 1);
    fmu_free(fmu);
}

/* Both counters have to be below 128; the bus hears of each change, once. */
static void a_node_is_active_when_both_counters_allow_it(void **state)
{
    static const uint8_t passive[] = {0x41, 0, 0, 0, 9, 0, 0, 0, 2};
    const uint8_t *bytes = NULL;
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    (void)fetch(fmu, &bytes);
    give_errors(fmu, 16, PRIMARY, SENT);
    give_errors(fmu, 16, PRIMARY, RECEIVED);
    assert_int_equal(fetch(fmu, &bytes), sizeof passive + 24); /* and an EMCY */
    assert_memory_equal(bytes, passive, sizeof passive);
    give_confirms(fmu, 1);
    assert_int_equal(bus_state(fmu), 1);
    give_errors(fmu, 1, PRIMARY, SENT);
    give_frames(fmu, 9);
    assert_int_equal(bus_state(fmu), 1);
    give_confirms(fmu, 8);
    assert_int_equal(bus_state(fmu), 0);
    fmu_free(fmu);
}

static void cycle_power(struct fmu *fmu)
{
    const struct fmu_value off = {.type = FMU_BOOL};
    const struct fmu_value on = {.type = FMU_BOOL, .integer = 1};
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_POWER), &off), DG_HOST_OK);
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_POWER), &on), DG_HOST_OK);
}

static void set_fault(struct fmu *fmu, const char *name, bool on)
{
    const struct fmu_value value = {.type = FMU_BOOL, .integer = on};
    struct fmu_variable row = {.name = ""};
    for (size_t i = 0; strcmp(row.name, name) != 0; i++) {
        assert_true(fmu_variable(fmu, i, &row));
    }
    assert_int_equal(fmu_set(fmu, row.reference, &value), DG_HOST_OK);
}

/* The worse of what the node has counted and what a fault makes of it is told, each once; a power
   cycle mends no fault. */
static void a_controller_with_a_fault_is_told_to_its_bus(void **state)
{
    static const uint8_t off[] = {0x41, 0, 0, 0, 9, 0, 0, 0, 3};
    const uint8_t *bytes = NULL;
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    (void)fetch(fmu, &bytes);
    set_fault(fmu, "fault.bus_off", true);
    assert_int_equal(bus_state(fmu), 2);
    give_errors(fmu, 16, PRIMARY, SENT);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(fetch(fmu, &bytes), sizeof off);
    assert_memory_equal(bytes, off, sizeof off);
    set_fault(fmu, "fault.bus_off", false);
    (void)fmu_step(fmu, 2, 1, false);
    assert_int_equal(bus_state(fmu), 1);
    set_fault(fmu, "fault.bus_off", true);
    (void)fetch(fmu, &bytes);
    cycle_power(fmu);
    (void)fmu_step(fmu, 3, 1, false);
    assert_int_equal(bus_state(fmu), 2);
    set_fault(fmu, "fault.bus_off", false);
    (void)fmu_step(fmu, 4, 1, false);
    assert_int_equal(bus_state(fmu), 0);
    fmu_free(fmu);
}

/* Then it counts from 0, tells its bus, and hears again: a remote frame to 700h + node is answered
   with its state (CiA 301), 17 bytes. */
static void a_power_cycle_ends_bus_off(void **state)
{
    static const uint8_t guard[] = {0x10, 0, 0, 0, 16, 0, 0, 0, 0x3F, 7, 0, 0, 0, 1, 0, 0};
    static const uint8_t active[] = {0x41, 0, 0, 0, 9, 0, 0, 0, 1};
    const uint8_t *bytes = NULL;
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    give_errors(fmu, 20000, PRIMARY, SENT);
    assert_int_equal(bus_state(fmu), 2);
    (void)fetch(fmu, &bytes);
    assert_int_equal(give(fmu, guard, sizeof guard), DG_HOST_OK);
    assert_int_equal(fetch(fmu, &bytes), 0);
    cycle_power(fmu);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(bus_state(fmu), 0);
    assert_true(fetch(fmu, &bytes) > sizeof active);
    assert_memory_equal(bytes, active, sizeof active);
    assert_int_equal(give(fmu, guard, sizeof guard), DG_HOST_OK);
    assert_int_equal(fetch(fmu, &bytes), 17);
    give_errors(fmu, 15, PRIMARY, SENT); /* 120 */
    assert_int_equal(bus_state(fmu), 0);
    fmu_free(fmu);
}

static void a_power_cycle_forgets_what_was_received_badly(void **state)
{
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    give_errors(fmu, 16, PRIMARY, RECEIVED); /* 128 */
    assert_int_equal(bus_state(fmu), 1);
    cycle_power(fmu);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(bus_state(fmu), 0);
    give_errors(fmu, 15, PRIMARY, RECEIVED); /* 120 */
    assert_int_equal(bus_state(fmu), 0);
    fmu_free(fmu);
}

/* CiA 301: a remote frame to 700h + node asks for its state, 7Fh: pre-operational, and a data frame
   asks nothing. Neither does one with 29 bits of the same number. */
static void only_remote_frames_are_asked_for_a_state(void **state)
{
    static const struct {
        uint8_t extended, remote;
        size_t answers;
    } rows[] = {{0, 0, 0}, {1, 1, 0}, {0, 1, 17}};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const uint8_t guard[] = {
            0x10, 0, 0, 0, 16, 0, 0, 0, 0x3F, 7, 0, 0, rows[i].extended, rows[i].remote, 0, 0};
        const uint8_t *bytes = NULL;
        struct fmu *fmu = fmu_running(TOKEN " =f3668");
        (void)fmu_step(fmu, 0, 1, false);
        (void)fetch(fmu, &bytes);
        assert_int_equal(give(fmu, guard, sizeof guard), DG_HOST_OK);
        assert_int_equal(fetch(fmu, &bytes), rows[i].answers);
        if (rows[i].answers > 0) {
            static const uint8_t head[] = {0x10, 0, 0, 0, 17, 0, 0, 0, 0x3F, 7, 0, 0, 0, 0, 1, 0};
            assert_memory_equal(bytes, head, sizeof head);
            assert_int_equal(bytes[16] & 0x7F, 0x7F);
        }
        fmu_free(fmu);
    }
}

/* What is cut off, or says that it is longer than it is; what belongs to other nodes is passed. */
static void operations_have_their_length(void **state)
{
    static const struct {
        uint8_t bytes[28];
        size_t n;
        int result;
    } rows[] = {
        {{0x10, 0, 0, 0, 7}, 8, DG_HOST_ERR_ARGUMENT},
        {{0x40, 0, 0, 0, 8}, 8, DG_HOST_OK},
        {{0x40, 0, 0, 0, 9}, 8, DG_HOST_ERR_ARGUMENT},
        {{0x40, 0, 0, 0, 8}, 7, DG_HOST_ERR_ARGUMENT},
        {{0x40, 0, 0, 0, 8, 0, 0, 0, 1}, 9, DG_HOST_ERR_ARGUMENT},
        {{0x10, 0, 0, 0, 15}, 15, DG_HOST_ERR_ARGUMENT},
        {{0x10, 0, 0, 0, 16}, 16, DG_HOST_OK},
        {{0x10, 0, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 16, DG_HOST_ERR_ARGUMENT},
        {{0x10, 0, 0, 0, 17, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 17, DG_HOST_OK},
        {{0x10, 0, 0, 0, 24, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8}, 24, DG_HOST_OK},
        {{0x10, 0, 0, 0, 25, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9}, 25, DG_HOST_ERR_ARGUMENT},
        {{0x31, 0, 0, 0, 14}, 14, DG_HOST_ERR_ARGUMENT},
        {{0x31, 0, 0, 0, 15}, 15, DG_HOST_OK},
    };
    struct fmu *fmu = fmu_running(TOKEN " =f3668");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_int_equal(give(fmu, rows[i].bytes, rows[i].n), rows[i].result);
    }
    fmu_free(fmu);
}

/* EMCY of the first and of the last node is 81h and FFh; its bytes are code, 1001h and more. */
static void emergencies_are_seen_at_every_node(void **state)
{
    static const char *const tokens[] = {TOKEN " =f3668,node=1", TOKEN " =f3668,node=127"};
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(tokens); i++) {
        struct fmu_value value;
        struct fmu *fmu = fmu_running(tokens[i]);
        (void)fmu_step(fmu, 0, 1, false);
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_FAULT, 1), &yes), DG_HOST_OK);
        (void)fmu_step(fmu, 1, 1, false);
        assert_int_equal(fmu_get(fmu, VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE), &value), DG_HOST_OK);
        assert_int_equal(value.integer, 0x4200);
        assert_true(value.real == 0x4200);
        assert_int_equal(fmu_get(fmu, VARIABLE(FMU_OUTPUT, FMU_ERROR_REGISTER), &value),
                         DG_HOST_OK);
        assert_int_equal(value.integer, 9);
        fmu_free(fmu);
    }
}

/* --- RS485 --- */

/* A record of `n` characters at once, of `each` ns each, damaged or not. */
static int say_characters(struct fmu *fmu, const uint8_t *characters, uint8_t n, uint32_t each,
                          bool damaged)
{
    uint8_t bytes[16 + 64] = {0};
    assert_true(n <= 64);
    for (unsigned i = 0; i < 4; i++) {
        bytes[8 + i] = (uint8_t)(each >> 8 * i);
    }
    bytes[12] = n;
    bytes[14] = damaged ? 1 : 0;
    memcpy(&bytes[16], characters, n);
    return give(fmu, bytes, 16u + n);
}

/* Characters of a reply, without what stands before them. */
static size_t hear_reply(struct fmu *fmu, uint8_t *reply)
{
    const uint8_t *bytes = NULL;
    size_t count = 0;
    for (size_t n = fetch(fmu, &bytes); n > 0;) {
        const size_t length = 16u + bytes[12];
        assert_true(length > 16 && length <= n);
        memcpy(&reply[count], &bytes[16], length - 16);
        count += length - 16;
        bytes += length;
        n -= length;
    }
    return count;
}

/* HIPERFACE: what is damaged, or has a pause within, is no request. At 9600 baud a character of 11
   bits takes 1145.8 us. */
static void requests_are_whole_or_unanswered(void **state)
{
    static const struct {
        uint32_t each;
        bool damaged, answered;
    } rows[] = {
        {0, false, true}, {1145833, false, true}, {0, true, false}, {90000000, false, false}};
    static const uint8_t request[] = {0x40, 0x42, 0x02};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        uint8_t reply[256];
        struct fmu *fmu = fmu_running(TOKEN " =s3684-rs485");
        (void)fmu_step(fmu, 0, 1, false);
        assert_int_equal(
            say_characters(fmu, request, sizeof request, rows[i].each, rows[i].damaged),
            DG_HOST_OK);
        (void)fmu_step(fmu, 1, 1, false);
        const size_t n = hear_reply(fmu, reply);
        assert_int_equal(n > 2 && reply[0] == 0x40 && reply[1] == 0x42, rows[i].answered);
        fmu_free(fmu);
    }
}

/* HIPERFACE: with 57h, 04h a character has 10 bits, and 11 bits of silence end a frame, from the
   reset by 53h on (init: 100 ms). A request that the library takes in several pieces is whole all
   the same: 4Bh, Save data, of 32 bytes to a field that is not there: 12h. */
static void long_requests_have_no_pause_within(void **state)
{
    static const uint8_t set[] = {0x40, 0x57, 0x04, 0x55, 0x46};
    static const uint8_t reset[] = {0x40, 0x53, 0x13};
    uint8_t save[5 + 1 + 32 + 1] = {0x40, 0x4B, 0x00, 0x00, 32, 0x55};
    uint8_t reply[256];
    struct fmu *fmu = fmu_running(TOKEN " =s3684-rs485");

    (void)state;
    for (size_t i = 0; i + 1 < sizeof save; i++) {
        save[sizeof save - 1] ^= save[i];
    }
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(say_characters(fmu, set, sizeof set, 0, false), DG_HOST_OK);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(hear_reply(fmu, reply), 4);
    assert_memory_equal(reply, "\x40\x57\x04", 3);
    assert_int_equal(say_characters(fmu, reset, sizeof reset, 0, false), DG_HOST_OK);
    (void)fmu_step(fmu, 2, 1, false);
    assert_int_equal(hear_reply(fmu, reply), 0);
    assert_int_equal(say_characters(fmu, save, sizeof save, 0, false), DG_HOST_OK);
    (void)fmu_step(fmu, 3, 1, false);
    assert_int_equal(hear_reply(fmu, reply), 4);
    assert_memory_equal(reply, "\x40\x50\x12\x02", 4);
    fmu_free(fmu);
}

/* Cut off, or longer than it says; nothing is nothing. */
static void records_of_characters_have_their_length(void **state)
{
    static const uint8_t one[17] = {[12] = 1};
    static const uint8_t none[16] = {0};
    static const uint8_t many[16 + 0x800] = {[13] = 8};
    struct fmu *fmu = fmu_running(TOKEN " =s3684-rs485");

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(give(fmu, one, 17), DG_HOST_OK);
    assert_int_equal(give(fmu, one, 16), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(give(fmu, one, 15), DG_HOST_ERR_ARGUMENT);
    assert_int_equal(give(fmu, none, 16), DG_HOST_OK);
    assert_int_equal(give(fmu, none, 0), DG_HOST_OK);
    /* 16 characters are an event, and of those DG_HOST_QUEUE wait. */
    assert_int_equal(give(fmu, many, sizeof many), DG_HOST_ERR_SPACE);
    fmu_free(fmu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_of_a_sender_are_counted),
        cmocka_unit_test(errors_of_a_receiver_are_counted),
        cmocka_unit_test(a_node_is_active_when_both_counters_allow_it),
        cmocka_unit_test(a_controller_with_a_fault_is_told_to_its_bus),
        cmocka_unit_test(a_power_cycle_ends_bus_off),
        cmocka_unit_test(a_power_cycle_forgets_what_was_received_badly),
        cmocka_unit_test(only_remote_frames_are_asked_for_a_state),
        cmocka_unit_test(operations_have_their_length),
        cmocka_unit_test(emergencies_are_seen_at_every_node),
        cmocka_unit_test(requests_are_whole_or_unanswered),
        cmocka_unit_test(long_requests_have_no_pause_within),
        cmocka_unit_test(records_of_characters_have_their_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

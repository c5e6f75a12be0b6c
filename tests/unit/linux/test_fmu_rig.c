/* SPDX-License-Identifier: MIT */
/*
 * The FMU of a rig file: its shafts and gears, several encoders on a wire that has its variables
 * once, what is in its file beside the text, and states at any moment.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/rig.h"
#include "fmu_rig.h"

#define OF(number, reference) ((uint32_t)(number) << 16 | (reference))
#define POSITION VARIABLE(FMU_OUTPUT, FMU_POSITION)
#define RX VARIABLE(FMU_BUS, FMU_RX)
#define TX VARIABLE(FMU_BUS, FMU_TX)
#define RX_CLOCK VARIABLE(FMU_BUS, FMU_RX_CLOCK)
#define TRANSMIT 0x10u
#define LOG_MAX 65536u

static const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
static const struct fmu_value turn = {.type = FMU_REAL, .real = 6.283185307179586};

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

/* ------------------------------------------------------------ shafts */

static void a_shaft_that_is_turned_has_no_inputs(void **state)
{
    struct fmu *fmu = fmu_running_rig("[shaft motor]\nmotion = 60RPM\n"
                                      "[shaft load]\ndriver = motor\nratio = 1:4\n"
                                      "[shaft free]\n[shaft idle]\n"
                                      "[encoder m]\nmodel = f3668\nshaft = motor\nwire = slcan\n"
                                      "[encoder l]\nmodel = f3668\nshaft = load\nwire = slcan\n"
                                      "[encoder f]\nmodel = f3668\nshaft = free\nwire = slcan\n");

    (void)state;
    assert_false(has(fmu, "m.shaft.angle"));
    assert_false(has(fmu, "l.shaft.speed"));
    assert_true(has(fmu, "f.shaft.angle"));
    assert_true(has(fmu, "idle.speed"));
    assert_false(has(fmu, "motor.speed"));
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &turn), DG_HOST_ERR_NAME);
    assert_int_equal(fmu_set(fmu, OF(2, VARIABLE(FMU_INPUT, FMU_SPEED)), &turn), DG_HOST_OK);
    assert_true(fmu_real(fmu, OF(2, VARIABLE(FMU_INPUT, FMU_SPEED))) > 6);
    (void)fmu_step(fmu, 0, 2, false);
    assert_int_equal(fmu_integer(fmu, OF(0, POSITION)), 2 << 16);
    assert_int_equal(fmu_integer(fmu, OF(1, POSITION)), 1 << 15);
    assert_int_equal(fmu_integer(fmu, OF(2, POSITION)), 2 << 16);
    fmu_free(fmu);
}

/* A driver that no encoder sits on has inputs by its own name. */
static void gears_follow_what_turns_them(void **state)
{
    struct fmu *fmu = fmu_running_rig("[shaft motor]\n[shaft load]\ndriver = motor\nratio = 1:4\n"
                                      "[encoder it]\nmodel = f3668\nshaft = load\nwire = slcan\n");

    (void)state;
    assert_true(has(fmu, "motor.angle"));
    assert_false(has(fmu, "shaft.angle"));
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_ANGLE), &turn), DG_HOST_OK);
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(fmu_integer(fmu, POSITION), 1 << 14);
    fmu_free(fmu);
}

/* ------------------------------------------------------------ wires */

#define NODES                                                                                      \
    "[bus field-1]\nwire = slcan\n[encoder a]\nmodel = f3668\nbus = field-1\nnode = 1\n"           \
    "[encoder b]\nmodel = f3668\nbus = field-1\nnode = 2\n"                                        \
    "[encoder c]\nmodel = f3668\nnode = 3\nwire = slcan\n"

/* Frames with this identifier that wait. */
static unsigned frames_of(struct fmu *fmu, uint32_t reference, uint16_t id)
{
    const uint8_t *bytes = NULL;
    size_t n = 0;
    unsigned count = 0;

    assert_int_equal(fmu_binary_get(fmu, reference, &bytes, &n), DG_HOST_OK);
    for (size_t at = 0; at < n; at += bytes[at + 4]) {
        const unsigned of = bytes[at + 8] | (unsigned)bytes[at + 9] << 8;
        count += bytes[at] == TRANSMIT && of == id ? 1 : 0;
    }
    return count;
}

static void send_frame(struct fmu *fmu, uint32_t encoder, uint16_t id, const uint8_t data[8])
{
    uint8_t bytes[24] = {TRANSMIT, 0, 0, 0, sizeof bytes, 0, 0, 0};

    bytes[8] = (uint8_t)id;
    bytes[9] = (uint8_t)(id >> 8);
    bytes[14] = 8;
    memcpy(bytes + 16, data, 8);
    assert_int_equal(fmu_clock_set(fmu, OF(encoder, RX_CLOCK), true), DG_HOST_OK);
    assert_int_equal(fmu_binary_set(fmu, OF(encoder, RX), bytes, sizeof bytes), DG_HOST_OK);
}

static void encoders_on_a_bus_share_its_variables(void **state)
{
    static const uint8_t request[8] = {0x40, 0x04, 0x60};
    struct fmu *fmu = fmu_running_rig(NODES);
    bool ticks = true;

    (void)state;
    assert_true(has(fmu, "field_1.CanChannel.Tx_Data"));
    assert_true(has(fmu, "c.CanChannel.Tx_Data"));
    assert_false(has(fmu, "a.CanChannel.Tx_Data"));
    assert_false(has(fmu, "b.CanChannel.Rx_Clock"));
    assert_int_equal(fmu_clock_get(fmu, OF(1, RX_CLOCK), &ticks), DG_HOST_ERR_NAME);
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(frames_of(fmu, TX, 0x701), 1);
    assert_int_equal(frames_of(fmu, TX, 0x702), 1);
    assert_int_equal(frames_of(fmu, TX, 0x703), 0);
    assert_int_equal(frames_of(fmu, OF(2, TX), 0x703), 1);
    fmu_clocks_end(fmu);
    for (uint16_t node = 1; node <= 3; node++) {
        send_frame(fmu, node == 3 ? 2 : 0, (uint16_t)(0x600 + node), request);
    }
    (void)fmu_step(fmu, 1, 0.1, false);
    assert_int_equal(frames_of(fmu, TX, 0x581), 1);
    assert_int_equal(frames_of(fmu, TX, 0x582), 1);
    assert_int_equal(frames_of(fmu, OF(2, TX), 0x583), 1);
    fmu_free(fmu);
}

/* Node 2 listens to the heartbeat of node 1, and misses it. */
static void nodes_hear_each_other(void **state)
{
    static const uint8_t beat[8] = {0x2B, 0x17, 0x10, 0, 50};
    static const uint8_t watch[8] = {0x23, 0x16, 0x10, 1, 100, 0, 1};
    const struct fmu_value no = {.type = FMU_BOOL, .integer = 0};
    struct fmu *fmu = fmu_running_rig(NODES);

    (void)state;
    (void)fmu_step(fmu, 0, 1, false);
    send_frame(fmu, 0, 0x601, beat);
    send_frame(fmu, 0, 0x602, watch);
    (void)fmu_step(fmu, 1, 1, false);
    assert_int_equal(fmu_integer(fmu, OF(1, VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE))), 0);
    assert_int_equal(fmu_set(fmu, OF(0, VARIABLE(FMU_INPUT, FMU_POWER)), &no), DG_HOST_OK);
    (void)fmu_step(fmu, 2, 1, false);
    assert_int_equal(fmu_integer(fmu, OF(1, VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE))), 0x8130);
    assert_int_equal(fmu_integer(fmu, OF(0, VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE))), 0);
    assert_int_equal(fmu_integer(fmu, OF(2, VARIABLE(FMU_OUTPUT, FMU_ERROR_CODE))), 0);
    fmu_free(fmu);
}

#define LINE                                                                                       \
    "[bus l]\nwire = pty\n[encoder a]\nmodel = s3684-rs485\nbus = l\naddress = 0x40\n"             \
    "[encoder b]\nmodel = s3684-rs485\nbus = l\naddress = 0x41\n"

/* 0x42: position. @param at when it begins, in ns; 0: now */
static void ask_position(struct fmu *fmu, uint8_t address, uint64_t at, uint32_t each)
{
    uint8_t bytes[19] = {[12] = 3, [16] = address, [17] = 0x42, [18] = (uint8_t)(address ^ 0x42)};

    for (unsigned i = 0; i < 8; i++) {
        bytes[i] = (uint8_t)(at >> 8 * i);
        bytes[8 + i % 4] = (uint8_t)(each >> 8 * (i % 4));
    }
    assert_int_equal(fmu_clock_set(fmu, RX_CLOCK, true), DG_HOST_OK);
    assert_int_equal(fmu_binary_set(fmu, RX, bytes, sizeof bytes), DG_HOST_OK);
}

/* @return the characters of the first reply, whose start bit is at `*at`; 0: none */
static size_t reply(struct fmu *fmu, uint64_t *at, uint8_t *first)
{
    const uint8_t *bytes = NULL;
    size_t n = 0;

    assert_int_equal(fmu_binary_get(fmu, TX, &bytes, &n), DG_HOST_OK);
    *at = 0;
    for (unsigned i = 0; n > 0 && i < 8; i++) {
        *at |= (uint64_t)bytes[i] << 8 * i;
    }
    *first = n > 0 ? bytes[16] : 0;
    const size_t count = n > 0 ? bytes[12] : 0;
    fmu_clocks_end(fmu);
    return count;
}

static void encoders_on_a_line_answer_one_by_one(void **state)
{
    struct fmu *fmu = fmu_running_rig(LINE);
    uint64_t at = 0;
    uint8_t first = 0;

    (void)state;
    (void)fmu_step(fmu, 0, 2, false);
    for (uint8_t address = 0x40; address <= 0x41; address++) {
        ask_position(fmu, address, 0, 0);
        (void)fmu_step(fmu, fmu_time(fmu), 0.1, false);
        assert_int_equal(reply(fmu, &at, &first), 7);
        assert_int_equal(first, address);
    }
    ask_position(fmu, 0x41, UINT64_C(2500000000), 0);
    (void)fmu_step(fmu, fmu_time(fmu), 0.2, false);
    assert_int_equal(reply(fmu, &at, &first), 0);
    (void)fmu_step(fmu, fmu_time(fmu), 0.2, true);
    assert_int_equal(reply(fmu, &at, &first) > 0, 1);
    assert_in_range(at, UINT64_C(2503000000), UINT64_C(2520000000));
    fmu_free(fmu);
}

/* At another data rate nobody hears anything. */
static void characters_have_their_data_rate(void **state)
{
    struct fmu *fmu = fmu_running_rig(LINE);
    uint64_t at = 0;
    uint8_t first = 0;

    (void)state;
    (void)fmu_step(fmu, 0, 2, false);
    ask_position(fmu, 0x40, 0, 286459);
    (void)fmu_step(fmu, fmu_time(fmu), 0.1, false);
    assert_int_equal(reply(fmu, &at, &first), 0);
    ask_position(fmu, 0x40, 0, 1145834);
    (void)fmu_step(fmu, fmu_time(fmu), 0.1, false);
    assert_int_equal(reply(fmu, &at, &first), 7);
    fmu_free(fmu);
}

static void a_chain_has_positions_and_no_frames(void **state)
{
    struct fmu *fmu =
        fmu_running_rig("[bus c]\nwire = sim\n[encoder a]\nmodel = s3684-biss\nbus = c\n"
                        "[encoder b]\nmodel = s3684-biss\nbus = c\n"
                        "[encoder s]\nmodel = s3684-biss\nwire = sim\n");

    (void)state;
    assert_true(has(fmu, "s.MA") && has(fmu, "s.frame"));
    assert_false(has(fmu, "a.frame") || has(fmu, "c.MA") || has(fmu, "a.nERR"));
    assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &turn), DG_HOST_OK);
    (void)fmu_step(fmu, 0, 1, false);
    assert_int_equal(fmu_clock_set(fmu, OF(2, VARIABLE(FMU_BUS, FMU_MA)), true), DG_HOST_OK);
    assert_int_equal(fmu_integer(fmu, OF(2, VARIABLE(FMU_OUTPUT, FMU_FRAME_POSITION))), 1 << 21);
    assert_int_equal(fmu_integer(fmu, OF(1, POSITION)), 1 << 21);
    fmu_free(fmu);
}

/* ------------------------------------------------------------ its file */

static const char whole[] = "file 92 r.ini\n"
                            "[rig]\ninclude = s.ini\n"
                            "[encoder a]\nmodel = own\nshaft = s\nwire = pty\n"
                            "temperature = t.csv,STEP\n"
                            "file 26 s.ini\n[shaft s]\nmotion = s.csv\n\n"
                            "model 15 own\nown:s3684-rs485"
                            "motion 26 4\n0 0\n1000000000 4294967296\n"
                            "course 25 10\n0 20000\n1500000000 90000\n";

static struct fmu *make_of(const char *bundle, struct dg_plan_error *error)
{
    char token[RIG_TOKEN_MAX];
    struct fmu_files files = fmu_bundle_files(bundle, token);

    memset(error, 0, sizeof *error);
    files.error = error;
    return fmu_make_with(token, &files);
}

static void all_that_it_names_is_in_its_file(void **state)
{
    struct dg_plan_error error;
    struct fmu *fmu = make_of(whole, &error);

    (void)state;
    if (fmu == NULL) {
        fail_msg("%u: %s: %s; %s", error.line, error.key, error.what, error.right);
    }
    assert_int_equal(fmu_start(fmu, 0), DG_HOST_OK);
    (void)fmu_step(fmu, 0, 0.5, false);
    assert_int_equal(fmu_integer(fmu, POSITION), 1 << 15);
    int64_t value = 0;
    assert_int_equal(dg_host_world_get(fmu_host(fmu, 0), "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 20000);
    (void)fmu_step(fmu, 0.5, 1.5, false);
    assert_int_equal(dg_host_world_get(fmu_host(fmu, 0), "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 90000);
    assert_int_equal(fmu_reset(fmu), 0);
    assert_int_equal(fmu_start(fmu, 0), DG_HOST_OK);
    assert_int_equal(dg_host_world_get(fmu_host(fmu, 0), "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 20000);
    fmu_free(fmu);
}

static void what_is_wrong_with_it_is_told(void **state)
{
    struct dg_plan_error error;

    (void)state;
    for (size_t n = 0; n + 1u < sizeof whole; n++) {
        char part[sizeof whole] = "";
        memcpy(part, whole, n);
        assert_null(make_of(part, &error));
    }
    assert_null(
        make_of("file 52 r.ini\n[encoder a]\nmodel = f3668\nwire = slcan\nmt_bits = 13\n", &error));
    assert_string_equal(error.key, "mt_bits");
    assert_string_equal(error.right, "expected 12 or 16");
    assert_int_equal(error.line, 4);
    assert_null(make_of("file 4 r.ini\n[rig", &error));
    char token[RIG_TOKEN_MAX];
    struct fmu_files files = fmu_rig_files("[encoder a]\nmodel = f3668\nwire = slcan\n", token);
    token[strlen(token) - 5] ^= 1;
    assert_null(fmu_make_with(token, &files));
    assert_null(fmu_make(token));
}

/* ------------------------------------------------------------ states */

static uint8_t told[2][LOG_MAX];
static size_t told_count[2];

static void note(unsigned log, const void *bytes, size_t n)
{
    assert_true(told_count[log] + n <= LOG_MAX);
    memcpy(told[log] + told_count[log], bytes, n);
    told_count[log] += n;
}

static void note_all(struct fmu *fmu, unsigned log)
{
    for (size_t i = 0; i < fmu_count(fmu); i++) {
        const uint32_t at = (uint32_t)i << 16;
        const uint8_t *bytes = NULL;
        size_t n = 0;
        const int64_t position = fmu_integer(fmu, at | POSITION);
        note(log, &position, sizeof position);
        if (fmu_binary_get(fmu, at | TX, &bytes, &n) == DG_HOST_OK) {
            note(log, bytes, n);
        }
    }
    fmu_clocks_end(fmu);
}

static void do_something(struct fmu *fmu, unsigned i)
{
    static const uint8_t request[8] = {0x40, 0x04, 0x60};
    const struct fmu_value speed = {.type = FMU_REAL, .real = i};
    const struct fmu_value on = {.type = FMU_BOOL, .integer = i % 12 == 5 ? 0 : 1};

    send_frame(fmu, 0, (uint16_t)(0x601 + i % 2), request);
    (void)fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_SPEED), &speed);
    (void)fmu_set(fmu, OF(1, VARIABLE(FMU_INPUT, FMU_POWER)), &on);
    if (i == 7) {
        (void)fmu_set(fmu, OF(1, VARIABLE(FMU_FAULT, 1)), &yes);
    }
}

static void play(struct fmu *fmu, unsigned from, unsigned to, unsigned log)
{
    for (unsigned i = from; i < to; i++) {
        do_something(fmu, i);
        (void)fmu_step(fmu, fmu_time(fmu), 0.0531, false);
        note_all(fmu, log);
    }
}

static void states_of_a_rig_go_on(void **state)
{
    const unsigned end = 40;

    (void)state;
    for (unsigned at = 0; at < end; at += 3) {
        struct fmu *first = fmu_running_rig(NODES);
        struct fmu *other = fmu_running_rig(NODES);
        told_count[0] = told_count[1] = 0;
        play(first, 0, at, 1);
        const size_t n = fmu_state_size(first);
        uint8_t *bytes = malloc(n);
        assert_non_null(bytes);
        assert_int_equal(fmu_save(first, bytes, n), DG_HOST_OK);
        told_count[1] = 0;
        play(other, 0, at / 2, 1);
        told_count[1] = 0;
        play(first, at, end, 0);
        assert_int_equal(fmu_restore(other, bytes, n), DG_HOST_OK);
        play(other, at, end, 1);
        assert_int_equal(told_count[0], told_count[1]);
        assert_memory_equal(told[0], told[1], told_count[0]);
        bytes[n - 100] ^= 1;
        assert_int_equal(fmu_restore(other, bytes, n), DG_HOST_ERR_DAMAGED);
        assert_int_equal(fmu_restore(other, bytes, 50), DG_HOST_ERR_OTHER);
        free(bytes);
        fmu_free(first);
        fmu_free(other);
    }
}

/* Characters that begin later are in a state. */
static void what_comes_later_is_in_a_state(void **state)
{
    struct fmu *fmu = fmu_running_rig(LINE);
    uint64_t at = 0;
    uint8_t first = 0;

    (void)state;
    (void)fmu_step(fmu, 0, 2, false);
    ask_position(fmu, 0x41, UINT64_C(2100000000), 0);
    const size_t n = fmu_state_size(fmu);
    uint8_t *bytes = malloc(n);
    assert_non_null(bytes);
    assert_int_equal(fmu_save(fmu, bytes, n), DG_HOST_OK);
    fmu_free(fmu);
    fmu = fmu_running_rig(LINE);
    assert_int_equal(fmu_restore(fmu, bytes, n), DG_HOST_OK);
    (void)fmu_step(fmu, 2, 0.2, false);
    assert_int_equal(reply(fmu, &at, &first), 7);
    assert_int_equal(first, 0x41);
    free(bytes);
    fmu_free(fmu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_shaft_that_is_turned_has_no_inputs),
        cmocka_unit_test(gears_follow_what_turns_them),
        cmocka_unit_test(encoders_on_a_bus_share_its_variables),
        cmocka_unit_test(nodes_hear_each_other),
        cmocka_unit_test(encoders_on_a_line_answer_one_by_one),
        cmocka_unit_test(characters_have_their_data_rate),
        cmocka_unit_test(a_chain_has_positions_and_no_frames),
        cmocka_unit_test(all_that_it_names_is_in_its_file),
        cmocka_unit_test(what_is_wrong_with_it_is_told),
        cmocka_unit_test(states_of_a_rig_go_on),
        cmocka_unit_test(what_comes_later_is_in_a_state),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

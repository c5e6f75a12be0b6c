/* SPDX-License-Identifier: MIT */
/* What an FMU tells: clocks, answers within an event, and what each variable is for. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "describe.h"
#include "fmu_rig.h"

static void clocks_that_are_none_are_refused(void **state)
{
    static const uint32_t none[] = {
        VARIABLE(FMU_BUS, FMU_RX),      VARIABLE(FMU_BUS, FMU_TX),
        VARIABLE(FMU_BUS, FMU_MA + 1),  VARIABLE(FMU_BUS, 0xFF),
        VARIABLE(FMU_INPUT, FMU_POWER), UINT32_C(1) << 16 | VARIABLE(FMU_BUS, FMU_RX_CLOCK),
    };
    struct fmu *fmu = fmu_running(TOKEN " =f3668");
    bool on = true;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(none); i++) {
        assert_int_equal(fmu_clock_get(fmu, none[i], &on), DG_HOST_ERR_NAME);
        assert_int_equal(fmu_clock_set(fmu, none[i], true), DG_HOST_ERR_NAME);
    }
    assert_int_equal(fmu_clock_get(fmu, VARIABLE(FMU_BUS, FMU_RX_CLOCK), &on), DG_HOST_OK);
    assert_false(on);
    assert_int_equal(fmu_clock_set(fmu, VARIABLE(FMU_BUS, FMU_RX_CLOCK), true), DG_HOST_OK);
    assert_int_equal(fmu_clock_get(fmu, VARIABLE(FMU_BUS, FMU_RX_CLOCK), &on), DG_HOST_OK);
    assert_true(on);
    fmu_free(fmu);
}

/* The node answers a request at once, within the event that brings it, however many there are.
   40 00 10 00 to 63Fh reads 1000h; 43 00 10 00 96 01 from 5BFh tells that it is a CiA 406. */
static void frames_are_answered_in_their_event(void **state)
{
    enum { FRAME = 24, FRAMES = 80 };
    static const uint8_t request[FRAME] = {0x10, 0, 0, 0, FRAME, 0, 0,    0, 0x3F, 0x06,
                                           0,    0, 0, 0, 8,     0, 0x40, 0, 0x10};
    static const uint8_t reply[] = {0x43, 0x00, 0x10, 0x00, 0x96, 0x01};
    struct fmu *fmu = fmu_running(TOKEN " =f3668");
    uint8_t requests[FRAMES * FRAME];
    const uint8_t *bytes = NULL;
    size_t n = 0;

    (void)state;
    for (size_t i = 0; i < FRAMES; i++) {
        memcpy(&requests[i * FRAME], request, FRAME);
    }
    (void)fmu_step(fmu, 0, 1, false);
    assert_true(fmu_ticks(fmu));
    assert_int_equal(fmu_binary_get(fmu, VARIABLE(FMU_BUS, FMU_TX), &bytes, &n), DG_HOST_OK);
    fmu_clocks_end(fmu);
    assert_false(fmu_ticks(fmu));
    assert_int_equal(fmu_clock_set(fmu, VARIABLE(FMU_BUS, FMU_RX_CLOCK), true), DG_HOST_OK);
    assert_int_equal(fmu_binary_set(fmu, VARIABLE(FMU_BUS, FMU_RX), requests, sizeof requests),
                     DG_HOST_OK);
    assert_true(fmu_ticks(fmu));
    assert_int_equal(fmu_binary_get(fmu, VARIABLE(FMU_BUS, FMU_TX), &bytes, &n), DG_HOST_OK);
    assert_int_equal(n, FRAMES * FRAME);
    for (; n > 0; n -= FRAME, bytes += FRAME) {
        assert_int_equal(bytes[8], 0xBF);
        assert_int_equal(bytes[9], 0x05);
        assert_memory_equal(&bytes[16], reply, sizeof reply);
    }
    fmu_free(fmu);
}

static void each_variable_says_what_it_is_for(void **state)
{
    static const enum fmu_type explained[] = {FMU_REAL, FMU_INT, FMU_BOOL, FMU_TEXT};

    (void)state;
    for (size_t model = 0; dg_host_name(model) != NULL; model++) {
        char token[96];
        struct fmu_variable row;
        (void)snprintf(token, sizeof token, "%s =%s", TOKEN, dg_host_name(model));
        struct fmu *fmu = fmu_running(token);
        for (size_t i = 1; fmu_variable(fmu, i, &row); i++) {
            for (size_t k = 0; k < DG_COUNT(explained); k++) {
                if (row.type == explained[k] && row.help[0] == '\0') {
                    fail_msg("%s %s", dg_host_name(model), row.name);
                }
            }
        }
        fmu_free(fmu);
    }
}

static void find_variable(struct fmu *fmu, const char *name, struct fmu_variable *row)
{
    size_t i = 0;
    while (fmu_variable(fmu, i, row) && strcmp(row->name, name) != 0) {
        i++;
    }
    assert_string_equal(row->name, name);
}

/* As FMI-LS-BUS has it: an encoder receives by Rx, by a clock of the importer's, and sends by Tx.
 */
static void wires_lead_in_and_out(void **state)
{
    static const struct {
        const char *model;
        const char *name;
        enum fmu_type type;
        bool input;
    } rows[] = {
        {"f3668", "CanChannel.Rx_Data", FMU_BINARY, true},
        {"f3668", "CanChannel.Tx_Data", FMU_BINARY, false},
        {"f3668", "CanChannel.Rx_Clock", FMU_CLOCK, true},
        {"f3668", "CanChannel.Tx_Clock", FMU_CLOCK, false},
        {"s3684-rs485", "RS485.Rx_Data", FMU_BINARY, true},
        {"s3684-rs485", "RS485.Tx_Data", FMU_BINARY, false},
        {"s3684-rs485", "RS485.Rx_Clock", FMU_CLOCK, true},
        {"s3684-rs485", "RS485.Tx_Clock", FMU_CLOCK, false},
        {"s3684-biss", "MA", FMU_CLOCK, true},
        {"ssi-25", "MA", FMU_CLOCK, true},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        char token[96];
        struct fmu_variable row;
        (void)snprintf(token, sizeof token, "%s =%s", TOKEN, rows[i].model);
        struct fmu *fmu = fmu_running(token);
        find_variable(fmu, rows[i].name, &row);
        assert_int_equal(row.type, rows[i].type);
        assert_int_equal(row.input, rows[i].input);
        assert_false(row.parameter);
        fmu_free(fmu);
    }
}

/* A setting tells its help, and its words; a fault its cause and what comes of it. */
static void helps_are_those_of_the_encoder(void **state)
{
    struct fmu *fmu = fmu_running(TOKEN " =f3668");
    struct fmu_variable row;

    (void)state;
    find_variable(fmu, "node", &row);
    assert_string_equal(row.help, "node-ID of a new EEPROM");
    find_variable(fmu, "mt_bits", &row);
    assert_string_equal(row.help, "bits of the turns: 12, 16");
    find_variable(fmu, "fault.error_passive", &row);
    assert_string_equal(row.help, "many damaged frames -> EMCY 8120h, 1001h 11h");
    fmu_free(fmu);
}

/* What an importer shows beside a name. */
static void descriptions_have_the_helps(void **state)
{
    static char text[1 << 17];
    const struct fmu_about about = {.token = TOKEN " =f3668", .name = "f3668"};

    (void)state;
    for (int version = 2; version <= 3; version++) {
        struct fmu *fmu = fmu_make(about.token);
        FILE *file = tmpfile();
        assert_non_null(fmu);
        assert_non_null(file);
        fmu_describe(fmu, &about, version, file);
        rewind(file);
        text[fread(text, 1, sizeof text - 1, file)] = '\0';
        (void)fclose(file);
        char *node = strstr(text, "name=\"node\"");
        char *fault = strstr(text, "name=\"fault.error_passive\"");
        assert_non_null(node);
        assert_non_null(fault);
        *strchr(node, '>') = '\0';
        *strchr(fault, '>') = '\0';
        assert_non_null(strstr(node, "description=\"node-ID of a new EEPROM\""));
        assert_non_null(strstr(fault, "description=\"many damaged frames -&gt; EMCY 8120h"));
        fmu_free(fmu);
    }
}

/* As new, as often as an importer likes; with a sanitizer nothing of what was is left. */
static void a_reset_makes_it_new(void **state)
{
    const uint32_t position = VARIABLE(FMU_OUTPUT, FMU_POSITION);
    const uint32_t fault = VARIABLE(FMU_FAULT, 1); /* temperature_high */
    const struct fmu_value turn = {.type = FMU_REAL, .real = 6.283185307179586};
    const struct fmu_value yes = {.type = FMU_BOOL, .integer = 1};
    char token[RIG_TOKEN_MAX];
    const struct fmu_files files = fmu_rig_files("[encoder a]\nmodel = f3668\nwire = slcan\n"
                                                 "[encoder b]\nmodel = s3684-biss\nwire = sim\n",
                                                 token);
    struct fmu *fmu = fmu_make_with(token, &files);
    struct fmu_value value;

    (void)state;
    assert_non_null(fmu);
    for (int times = 0; times < 3; times++) {
        assert_false(fmu_started(fmu));
        assert_int_equal(fmu_start(fmu, 0), DG_HOST_OK);
        (void)fmu_step(fmu, 0, 1, false);
        assert_int_equal(fmu_get(fmu, position, &value), DG_HOST_OK);
        assert_int_equal(value.integer, 0);
        assert_int_equal(fmu_get(fmu, fault, &value), DG_HOST_OK);
        assert_int_equal(value.integer, 0);
        assert_int_equal(fmu_set(fmu, fault, &yes), DG_HOST_OK);
        assert_int_equal(fmu_set(fmu, VARIABLE(FMU_INPUT, FMU_ANGLE), &turn), DG_HOST_OK);
        (void)fmu_step(fmu, 1, 1, false);
        assert_int_equal(fmu_get(fmu, position, &value), DG_HOST_OK);
        assert_int_equal(value.integer, 65536);
        assert_int_equal(fmu_reset(fmu), 0);
    }
    fmu_free(fmu);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clocks_that_are_none_are_refused),
        cmocka_unit_test(frames_are_answered_in_their_event),
        cmocka_unit_test(each_variable_says_what_it_is_for),
        cmocka_unit_test(wires_lead_in_and_out),
        cmocka_unit_test(helps_are_those_of_the_encoder),
        cmocka_unit_test(descriptions_have_the_helps),
        cmocka_unit_test(a_reset_makes_it_new),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

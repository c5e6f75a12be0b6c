/* SPDX-License-Identifier: MIT */
/*
 * Every row of the catalogue, injected into a running device and seen on its wire, then cleared:
 * what the column 'effect' promises. A protocol that is not here does the same in a test of its
 * own, test_NAME_faults.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/instruments.h"
#include "fault_rig.h"

#define SAVE 0x65766173u

/* ------------------------------------------------------------ looks: RS485 */

static uint32_t ask_42(void)
{
    return (uint32_t)hf_rig_ask(&fault_rig.hf, "42");
}

static uint32_t ask_43(void)
{
    return (uint32_t)hf_rig_ask(&fault_rig.hf, "43 00 00 00 00 55");
}

static uint32_t ask_6a(void)
{
    return (uint32_t)hf_rig_ask(&fault_rig.hf, "6A 00 00 00 00 55");
}

static uint32_t ask_46(void)
{
    return (uint32_t)hf_rig_ask(&fault_rig.hf, "46");
}

static uint32_t channel(const char *command)
{
    assert_int_equal(hf_rig_ask(&fault_rig.hf, command), 0);
    return dg_load_be16(&fault_rig.hf.reply[3]);
}

static uint32_t temperature(void)
{
    return channel("44 48");
}

static uint32_t led_current(void)
{
    return channel("44 49");
}

static uint32_t at_sine(void)
{
    fault_rig.hf.angle = DG_TURN / 2048 / 4;
    return channel("44 4A");
}

static uint32_t at_cosine(void)
{
    fault_rig.hf.angle = 0;
    return channel("44 4A");
}

/* Between both lines, in permille of the nominal peak. */
static uint32_t sine_signal(void)
{
    struct dg_hf_sincos signal;

    fault_rig.hf.angle = DG_TURN / 2048 / 4;
    dg_hf_sincos(&fault_rig.hf.device, fault_rig.hf.now, &signal);
    return (uint32_t)(signal.sin_plus_uv - signal.sin_minus_uv) / 500u;
}

static uint32_t cosine_signal(void)
{
    struct dg_hf_sincos signal;

    fault_rig.hf.angle = 0;
    dg_hf_sincos(&fault_rig.hf.device, fault_rig.hf.now, &signal);
    return (uint32_t)(signal.cos_plus_uv - signal.cos_minus_uv) / 500u;
}

/* ------------------------------------------------------------ looks: BiSS */

static uint32_t valid_60(void)
{
    return (uint32_t)biss_rig_get(&fault_rig.biss, 0x60) & DG_BISS_STATUS_VALID;
}

static uint32_t user_bank(void)
{
    assert_int_equal(biss_rig_put(&fault_rig.biss, 0x40, 7), 1);
    return (uint32_t)biss_rig_get(&fault_rig.biss, 0x00);
}

static void mask(uint8_t address, uint8_t bits)
{
    assert_int_equal(biss_rig_put(&fault_rig.biss, 0x40, 0), 1);
    assert_int_equal(biss_rig_put(&fault_rig.biss, address, bits), 1);
}

static uint32_t monitored_as_error(void)
{
    mask(0x22, 0xFF);
    const uint32_t seen = fault_rig_errors() << 8 | fault_rig_states();
    mask(0x22, DG_BISS_EMASK_DEFAULT);
    return seen;
}

static uint32_t monitored_as_warning(void)
{
    mask(0x23, DG_BISS_TEMPERATURE);
    const uint32_t seen = fault_rig_errors() << 8 | fault_rig_states();
    mask(0x23, DG_BISS_WMASK_DEFAULT);
    return seen;
}

static uint32_t temperature_6a(void)
{
    return (uint32_t)biss_rig_get(&fault_rig.biss, 0x6B) << 8 |
           (uint32_t)biss_rig_get(&fault_rig.biss, 0x6A);
}

/* ------------------------------------------------------------ looks: CANopen */

static uint32_t object(uint16_t index, uint8_t sub)
{
    co_rig_run(&fault_rig.co, FAULT_RIG_LOOK);
    return co_rig_get(&fault_rig.co, index, sub);
}

static uint32_t register_1001(void)
{
    return object(0x1001, 0);
}

static uint32_t alarms(void)
{
    return object(0x6503, 0);
}

static uint32_t warnings(void)
{
    return object(0x6505, 0);
}

static uint32_t temperature_2120(void)
{
    return object(0x2120, 4);
}

static uint32_t battery_2125(void)
{
    return object(0x2125, 0);
}

static uint32_t store_parameters(void)
{
    return co_rig_write(&fault_rig.co, 0x1010, 1, SAVE, 4);
}

static uint32_t store_bus(void)
{
    return co_rig_write(&fault_rig.co, 0x2105, 0, SAVE, 4);
}

/* Patterns: of the bus LED in the tens, of the error LED in the ones. */
static uint32_t lamps(void)
{
    co_rig_run(&fault_rig.co, DG_S(4)); /* an event's own blinking is over */
    const struct dg_cia406_leds leds = dg_cia406_leds(&fault_rig.co.node);
    co_rig_forget(&fault_rig.co);
    return (uint32_t)leds.bus_pattern * 16u + (uint32_t)leds.err_pattern;
}

#define QUIET (DG_CIA406_LAMP_BLINK * 16u + DG_CIA406_LAMP_OFF)
#define BOTH_FAST (DG_CIA406_LAMP_FAST * 16u + DG_CIA406_LAMP_FAST_OTHER)
#define BOTH_300 (DG_CIA406_LAMP_300 * 16u + DG_CIA406_LAMP_300)

/* ------------------------------------------------------------ looks: INTERBUS */

static uint32_t in_bit_31(void)
{
    return ib_rig_cycle(&fault_rig.ib, 0) >> 31;
}

static uint32_t parameter(void)
{
    const uint32_t answer = ib_rig_send(&fault_rig.ib, 0x08000000u);

    (void)ib_rig_release(&fault_rig.ib);
    return answer;
}

static uint32_t id_bit_13(void)
{
    (void)ib_rig_cycle(&fault_rig.ib, 0);
    return (uint32_t)dg_ib_id(&fault_rig.ib.device, fault_rig.ib.now) >> 13 & 1u;
}

/* ------------------------------------------------------------ rows */

struct proof {
    const char *fault;
    uint32_t (*look)(void);
    uint32_t healthy;
    uint32_t faulty;
};

/* clang-format off */
static const struct proof rs485[] = {
    {"led_current_high",    ask_42,           0,    0x1D},
    {"led_current_high",    ask_43,           0,    0x1D},
    {"led_current_high",    ask_6a,           0,    0x1D},
    {"led_current_high",    fault_rig_oldest, 0,    0x1D},
    {"led_current_high",    led_current,      12,   40},
    {"led_current_low",     led_current,      12,   0},
    {"led_current_low",     fault_rig_oldest, 0,    0},
    {"temperature_high",    fault_rig_oldest, 0,    0x1E},
    {"temperature_high",    temperature,      37,   125},
    {"temperature_low",     fault_rig_oldest, 0,    0x1E},
    {"temperature_low",     temperature,      37,   0x10000 - 45},
    {"sin_amplitude_low",   at_sine,          1000, 500},
    {"sin_amplitude_low",   sine_signal,      1000, 500},
    {"sin_amplitude_high",  at_sine,          1000, 1500},
    {"sin_amplitude_high",  sine_signal,      1000, 1500},
    {"cos_amplitude_low",   at_cosine,        1000, 500},
    {"cos_amplitude_low",   cosine_signal,    1000, 500},
    {"cos_amplitude_high",  at_cosine,        1000, 1500},
    {"cos_amplitude_high",  cosine_signal,    1000, 1500},
    {"sin_offset",          at_sine,          1000, 1500},
    {"sin_offset",          sine_signal,      1000, 1500},
    {"cos_offset",          at_cosine,        1000, 1500},
    {"cos_offset",          cosine_signal,    1000, 1500},
    {"cos_offset",          fault_rig_oldest, 0,    0},
    {"singleturn_lost",     ask_42,           0,    0x20},
    {"singleturn_lost",     ask_43,           0,    0x20},
    {"singleturn_lost",     ask_6a,           0,    0x20},
    {"multiturn_amplitude", ask_42,           0,    0x21},
    {"multiturn_amplitude", ask_43,           0,    0x21},
    {"multiturn_amplitude", ask_6a,           0,    0x21},
    {"multiturn_sync",      ask_42,           0,    0x22},
    {"multiturn_sync",      ask_43,           0,    0x22},
    {"multiturn_sync",      ask_6a,           0,    0x22},
    {"multiturn_vector",    ask_42,           0,    0x23},
    {"multiturn_vector",    ask_43,           0,    0x23},
    {"multiturn_vector",    ask_6a,           0,    0x23},
    {"eeprom_silent",       ask_46,           0,    0x05},
    {NULL, NULL, 0, 0},
};

static const struct proof slave[] = {
    {"led_current_high",    fault_rig_errors,     0,      0x01},
    {"led_current_high",    fault_rig_states,     3,      1},
    {"temperature_high",    fault_rig_errors,     0,      0},
    {"temperature_high",    monitored_as_error,   0x0003, 0x0401},
    {"temperature_high",    monitored_as_warning, 0x0003, 0x0402},
    {"temperature_high",    temperature_6a,       370,    1250},
    {"temperature_low",     fault_rig_errors,     0,      0},
    {"temperature_low",     monitored_as_error,   0x0003, 0x0401},
    {"temperature_low",     monitored_as_warning, 0x0003, 0x0402},
    {"temperature_low",     temperature_6a,       370,    0x10000 - 450},
    {"sin_amplitude_low",   fault_rig_errors,     0,      0x02},
    {"sin_amplitude_low",   fault_rig_states,     3,      1},
    {"sin_amplitude_high",  fault_rig_errors,     0,      0x02},
    {"sin_amplitude_high",  fault_rig_states,     3,      1},
    {"cos_amplitude_low",   fault_rig_errors,     0,      0x02},
    {"cos_amplitude_low",   fault_rig_states,     3,      1},
    {"cos_amplitude_high",  fault_rig_errors,     0,      0x02},
    {"cos_amplitude_high",  fault_rig_states,     3,      1},
    {"sin_offset",          fault_rig_errors,     0,      0x02},
    {"sin_offset",          fault_rig_states,     3,      1},
    {"cos_offset",          fault_rig_errors,     0,      0x02},
    {"cos_offset",          fault_rig_states,     3,      1},
    {"singleturn_lost",     fault_rig_errors,     0,      0x20},
    {"singleturn_lost",     fault_rig_states,     3,      1},
    {"singleturn_lost",     valid_60,             1,      0},
    {"multiturn_amplitude", fault_rig_errors,     0,      0x40},
    {"multiturn_amplitude", fault_rig_states,     3,      1},
    {"multiturn_amplitude", valid_60,             1,      0},
    {"multiturn_sync",      fault_rig_errors,     0,      0x08},
    {"multiturn_sync",      fault_rig_states,     3,      1},
    {"multiturn_sync",      valid_60,             1,      0},
    {"multiturn_vector",    fault_rig_errors,     0,      0x40},
    {"multiturn_vector",    fault_rig_states,     3,      1},
    {"multiturn_vector",    valid_60,             1,      0},
    {"eeprom_silent",       fault_rig_errors,     0,      0x10},
    {"eeprom_silent",       fault_rig_states,     3,      1},
    {"eeprom_silent",       user_bank,            0xFF,   (uint32_t)BISS_RIG_REFUSED},
    {"watchdog_fired",      fault_rig_errors,     0,      0x80},
    {"watchdog_fired",      fault_rig_states,     3,      1},
    {NULL, NULL, 0, 0},
};

static const struct proof node[] = {
    {"led_current_high",    fault_rig_emcy,   0,     0x5200},
    {"led_current_high",    register_1001,    0,     0x01},
    {"temperature_high",    fault_rig_emcy,   0,     0x4200},
    {"temperature_high",    register_1001,    0,     0x09},
    {"temperature_high",    warnings,         0,     0x8000},
    {"temperature_high",    temperature_2120, 0x65,  0xBD},
    {"temperature_low",     fault_rig_emcy,   0,     0x4200},
    {"temperature_low",     register_1001,    0,     0x09},
    {"temperature_low",     warnings,         0,     0x8000},
    {"temperature_low",     temperature_2120, 0x65,  0x13},
    {"battery_low",         fault_rig_emcy,   0,     0x3200},
    {"battery_low",         register_1001,    0,     0x01},
    {"battery_low",         warnings,         0,     0x0010},
    {"battery_missing",     fault_rig_emcy,   0,     0x3200},
    {"battery_missing",     register_1001,    0,     0x05},
    {"battery_missing",     warnings,         0,     0x0010},
    {"battery_missing",     battery_2125,     361,   0x3FF},
    {"singleturn_lost",     fault_rig_emcy,   0,     0x1000},
    {"singleturn_lost",     register_1001,    0,     0x01},
    {"singleturn_lost",     alarms,           0,     0x0001},
    {"singleturn_lost",     lamps,            QUIET, BOTH_FAST},
    {"multiturn_amplitude", fault_rig_emcy,   0,     0x1000},
    {"multiturn_amplitude", register_1001,    0,     0x01},
    {"multiturn_amplitude", alarms,           0,     0x0001},
    {"multiturn_amplitude", lamps,            QUIET, BOTH_FAST},
    {"multiturn_sync",      fault_rig_emcy,   0,     0x1000},
    {"multiturn_sync",      register_1001,    0,     0x01},
    {"multiturn_sync",      alarms,           0,     0x0001},
    {"multiturn_sync",      lamps,            QUIET, BOTH_FAST},
    {"multiturn_vector",    fault_rig_emcy,   0,     0x1000},
    {"multiturn_vector",    register_1001,    0,     0x01},
    {"multiturn_vector",    alarms,           0,     0x0001},
    {"multiturn_vector",    lamps,            QUIET, BOTH_FAST},
    {"eeprom_silent",       fault_rig_emcy,   0,     0x51001000},
    {"eeprom_silent",       alarms,           0,     0x0002},
    {"eeprom_silent",       store_parameters, 0,     0x06060000},
    {"eeprom_silent",       store_bus,        0,     0x06060000},
    {"watchdog_fired",      fault_rig_emcy,   0,     0},
    {"watchdog_fired",      warnings,         0,     0x0004},
    {"watchdog_fired",      lamps,            QUIET, BOTH_300},
    {NULL, NULL, 0, 0},
};

static const struct proof k3[] = {
    {"singleturn_lost",     in_bit_31, 0,          1},
    {"multiturn_amplitude", in_bit_31, 0,          1},
    {"multiturn_sync",      in_bit_31, 0,          1},
    {"multiturn_vector",    in_bit_31, 0,          1},
    {"eeprom_silent",       parameter, 0xC8000000, DG_IB_LOST},
    {NULL, NULL, 0, 0},
};

static const struct proof k2[] = {
    {"singleturn_lost",     id_bit_13, 0, 1},
    {"multiturn_amplitude", id_bit_13, 0, 1},
    {"multiturn_sync",      id_bit_13, 0, 1},
    {"multiturn_vector",    id_bit_13, 0, 1},
    {NULL, NULL, 0, 0},
};

static const struct device {
    const struct dg_stack *stack;
    void (*start)(void);
    const struct proof *proofs;
} devices[] = {
    {&dg_hf_stack,     fault_rig_start_hf,   rs485},
    {&dg_biss_stack,   fault_rig_start_biss, slave},
    {&dg_cia406_stack, fault_rig_start_co,   node},
    {&dg_ib_stack,     fault_rig_start_k3,   k3},
    {&dg_ib_stack,     fault_rig_start_k2,   k2},
};
/* clang-format on */
#define DEVICES DG_COUNT(devices)

static void expect(const struct proof *proof, const char *when, uint32_t wanted)
{
    const uint32_t seen = proof->look();

    if (seen != wanted) {
        fail_msg("%s %s: %Xh, not %Xh", proof->fault, when, seen, wanted);
    }
}

/* Twice: what a device does not forget by itself would show. */
static void test_what_bends_the_world_is_seen_and_goes(void **state)
{
    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        for (const struct proof *proof = devices[i].proofs; proof->fault != NULL; proof++) {
            devices[i].start();
            for (unsigned n = 0; n < 2; n++) {
                expect(proof, "before", proof->healthy);
                fault_rig_set(proof->fault);
                expect(proof, "at work", proof->faulty);
                fault_rig_clear(proof->fault);
                expect(proof, "cleared", proof->healthy);
            }
        }
    }
}

static bool proven(const struct dg_stack *stack, const char *fault)
{
    for (size_t i = 0; i < DEVICES; i++) {
        const struct proof *proof = devices[i].proofs;
        while (proof->fault != NULL && strcmp(proof->fault, fault) != 0) {
            proof++;
        }
        if (devices[i].stack == stack && proof->fault != NULL) {
            return true;
        }
    }
    return false;
}

/* Whether this file, or a test of its own, is about the faults of `stack`. */
static bool is_here(const struct dg_stack *stack)
{
    char name[64];

    for (size_t i = 0; i < DEVICES; i++) {
        if (devices[i].stack == stack) {
            return true;
        }
    }
    (void)snprintf(name, sizeof name, " test_%s_faults ", stack->name);
    if (strstr(UNIT_TESTS, name) == NULL) {
        fail_msg("there is no%s", name);
    }
    return false;
}

static void test_every_row_of_the_world_is_proven(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_instrument_count; i++) {
        const struct dg_instrument *instrument = dg_instruments[i];
        const size_t count = is_here(instrument->stack) ? instrument->fault_count : 0;
        for (size_t k = 0; k < count; k++) {
            const struct dg_fault_row *row = &instrument->faults[k];
            if (row->kind == DG_FAULT_WORLD && !proven(instrument->stack, row->name)) {
                fail_msg("%s of %s is not proven", row->name, instrument->stack->name);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_bends_the_world_is_seen_and_goes),
        cmocka_unit_test(test_every_row_of_the_world_is_proven),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

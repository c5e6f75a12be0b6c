/* SPDX-License-Identifier: MIT */
/*
 * Every row of SSI's catalogue that bends the world, injected into a running encoder and seen in
 * its words, then cleared; and the modes that STATe? tells.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/control.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"
#include "ssi_rig.h"

static const struct {
    const char *fault;
    uint8_t error; /* as dg_ssi_errors() tells */
} proofs[] = {
    {"led_current_high", DG_SSI_LIGHT},      {"temperature_high", DG_SSI_TEMPERATURE},
    {"temperature_low", DG_SSI_TEMPERATURE}, {"supply_low", DG_SSI_SUPPLY},
    {"sin_amplitude_low", DG_SSI_SIGNAL},    {"sin_amplitude_high", DG_SSI_SIGNAL},
    {"cos_amplitude_low", DG_SSI_SIGNAL},    {"cos_amplitude_high", DG_SSI_SIGNAL},
    {"sin_offset", DG_SSI_SIGNAL},           {"cos_offset", DG_SSI_SIGNAL},
    {"singleturn_lost", DG_SSI_SINGLETURN},  {"multiturn_amplitude", DG_SSI_MULTITURN},
    {"multiturn_sync", DG_SSI_MULTITURN},    {"multiturn_vector", DG_SSI_MULTITURN},
    {"watchdog_fired", DG_SSI_SYSTEM},
};

static struct ssi_rig rig;
static struct dg_faults faults;
static const struct dg_fault_limits forever = {0, 1000000, DG_NEVER};

static struct dg_fault_target target(void)
{
    return (struct dg_fault_target){.instrument = &dg_ssi_instrument, .world = &rig.world};
}

static void start_encoder(const struct dg_device *device)
{
    faults = (struct dg_faults){.random = 1};
    assert_int_equal(ssi_rig_init(&rig, dg_ssi_model_of(device)), DG_OK);
    ssi_rig_power_on(&rig);
    rig.angle = DG_TURN * 3 + DG_TURN / 4;
}

static void expect(bool error)
{
    const unsigned bits = ssi_rig_bits(&rig.model);
    const uint64_t word = ssi_rig_take(&rig, bits + 1u);

    assert_int_equal(word, ssi_rig_word(&rig.model, (uint32_t)rig.device.position, error) << 1);
    assert_int_equal(rig.device.position, dg_ssi_position(&rig.device, rig.now));
    (void)ssi_rig_wait(&rig, DG_US(30));
}

static void what_bends_the_world_is_seen_and_goes(void **state)
{
    const struct dg_fault_target here = target();

    (void)state;
    for (size_t i = 0; i < DG_COUNT(proofs); i++) {
        start_encoder(&dg_ssi_28);
        const int index = dg_fault_find(&here, proofs[i].fault);
        assert_true(index >= 0);
        for (unsigned n = 0; n < 2; n++) {
            expect(false);
            assert_int_equal(dg_fault_set(&faults, &here, (size_t)index, 0, &forever), DG_OK);
            expect(true);
            assert_int_equal(dg_ssi_errors(&rig.device), proofs[i].error);
            assert_int_equal(dg_fault_clear(&faults, &here, (size_t)index), DG_OK);
            expect(false);
        }
    }
}

static bool proven(const char *fault)
{
    size_t i = 0;

    while (i < DG_COUNT(proofs) && strcmp(proofs[i].fault, fault) != 0) {
        i++;
    }
    return i < DG_COUNT(proofs);
}

static void every_row_of_the_world_is_proven(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_ssi_instrument.fault_count; i++) {
        const struct dg_fault_row *row = &dg_ssi_instrument.faults[i];
        if (row->kind == DG_FAULT_WORLD && !proven(row->name)) {
            fail_msg("%s is not proven", row->name);
        }
    }
}

static void modes(void **state)
{
    (void)state;
    start_encoder(&dg_ssi_13);
    assert_string_equal(dg_ssi_instrument.mode(&rig.device, rig.now), "idle");
    (void)ssi_rig_edge(&rig, false);
    assert_string_equal(dg_ssi_instrument.mode(&rig.device, rig.now), "transmitting");
    assert_string_equal(dg_ssi_instrument.mode(&rig.device, rig.now + DG_US(20) - 1u),
                        "transmitting");
    assert_string_equal(dg_ssi_instrument.mode(&rig.device, rig.now + DG_US(20)), "idle");
    dg_ssi_power_on(&rig.device, rig.now);
    assert_string_equal(dg_ssi_instrument.mode(&rig.device, rig.now), "initialising");
    assert_string_equal(dg_ssi_instrument.mode(&rig.device, rig.now + DG_MS(100)), "idle");
    dg_ssi_power_off(&rig.device);
    assert_string_equal(dg_ssi_instrument.mode(&rig.device, rig.now + DG_S(1)), "off");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_bends_the_world_is_seen_and_goes),
        cmocka_unit_test(every_row_of_the_world_is_proven),
        cmocka_unit_test(modes),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The control plane's commands for defects: FAULt, NVM, *RST, and what a rig does when time is
 * over.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "control_rig.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/text.h"

static struct control_rig rig;

static int setup(void **state)
{
    (void)state;
    control_rig_start(&rig);
    return 0;
}

static void expect(const char *line, const char *answer)
{
    control_rig_expect(&rig, line, answer);
}

static void refuse(const char *line, const char *error, const char *text)
{
    control_rig_refuse(&rig, line, error, text);
}

/* Parts of an answer; commas in strings are none. */
static unsigned parts(const char *answer)
{
    unsigned count = 1;
    bool quoted = false;

    for (; *answer != '\0'; answer++) {
        quoted ^= *answer == '"';
        count += *answer == ',' && !quoted;
    }
    return count;
}

/* ------------------------------------------------------------ FAULt */

static void test_catalogue(void **state)
{
    struct dg_fault_entry entry;

    (void)state;
    for (size_t i = 0; i < CONTROL_RIG_ENCODERS; i++) {
        char line[32];
        const struct dg_fault_target target = dg_encoder_target(&rig.encoder[i]);
        size_t count = 0;
        while (dg_fault_entry(&target, count, &entry)) {
            count++;
        }
        (void)snprintf(line, sizeof line, "INST:SEL %s;:FAUL:CAT?", rig.encoder[i].name);
        assert_int_equal(parts(control_rig_say(&rig, line)), 5 * count);
    }
    expect("INST:SEL hf", "");
    const char *catalogue = control_rig_say(&rig, "FAUL:CAT?");
    assert_int_equal(strncmp(catalogue, "\"led_current_high\",WORLD,\"the LED", 32), 0);
    assert_non_null(strstr(catalogue, "\"wire_drop\",WIRE,\""));
    assert_non_null(strstr(catalogue, "\"eeprom_offset\",MEMORY,\""));
    assert_non_null(strstr(catalogue, "\"5.1.3\""));
    assert_non_null(strstr(catalogue, "\"multiturn_sync\""));
    rig.hf.device.setup.model = dg_hf_model_of(dg_device_find("s3674-rs485"));
    catalogue = control_rig_say(&rig, "FAUL:CAT?");
    assert_non_null(strstr(catalogue, "\"singleturn_lost\""));
    assert_null(strstr(catalogue, "\"multiturn_"));
}

/* Without a multiturn track it cannot have the faults of one. */
static void test_a_singleturn_offers_no_multiturn_faults(void **state)
{
    static const char *const kinds[] = {"multiturn_amplitude", "multiturn_sync",
                                        "multiturn_vector"};

    (void)state;
    expect("INST:SEL hf", "");
    for (int turns = 2; turns > 0; turns--) {
        struct dg_hf_model model = *rig.hf.device.setup.model;
        model.turns = (uint32_t)turns;
        rig.hf.device.setup.model = &model;
        const char *catalogue = control_rig_say(&rig, "FAUL:CAT?");
        assert_non_null(strstr(catalogue, "\"singleturn_lost\""));
        for (size_t i = 0; i < DG_COUNT(kinds); i++) {
            assert_int_equal(strstr(catalogue, kinds[i]) == NULL, turns == 1);
        }
        rig.hf.device.setup.model = dg_hf_model_of(dg_device_find("s3684-rs485"));
    }
}

static void test_set_and_clear(void **state)
{
    (void)state;
    expect("FAUL:ACT?", "\"\"");
    expect("FAUL:SET temperature_high", "");
    assert_int_equal(rig.changes, 1);
    assert_ptr_equal(rig.changed, &rig.encoder[CONTROL_RIG_HF]);
    expect("WORL:TEMP?", "125.000");
    expect("FAUL:SET Wire_Drop;ACT?", "\"temperature_high\",\"wire_drop\"");
    expect("FAUL:CLE temperature_high;ACT?", "\"wire_drop\"");
    expect("WORL:TEMP?", "37.000");
    expect("FAUL:SET eeprom_type;CLE;ACT?", "\"\"");
    assert_int_equal(rig.hf.device.store.damaged, 0);
    assert_int_equal(rig.encoder[CONTROL_RIG_BISS].faults.wire, 0);
    refuse("FAUL:SET nonsense", "-224", "nonsense: no such fault");
    refuse("FAUL:SET battery_low", "-224", NULL);
    refuse("FAUL:CLE nonsense", "-224", NULL);
    refuse("FAUL:SET", "-109", NULL);
}

static void test_limits_in_any_order(void **state)
{
    static const struct {
        const char *line;
        struct dg_fault_limits limits;
    } rows[] = {
        {"FAUL:SET wire_drop", {0, 1000000, DG_NEVER}},
        {"FAUL:SET wire_drop,COUN 3", {3, 1000000, DG_NEVER}},
        {"FAUL:SET wire_drop,PROBability 0.25", {0, 250000, DG_NEVER}},
        {"FAUL:SET wire_drop,DUR 2S", {0, 1000000, DG_S(3)}},
        {"FAUL:SET wire_drop,dur 5 ms,count 7,prob 1E-6", {7, 1, DG_S(1) + DG_MS(5)}},
        {"FAUL:SET wire_drop,PROB 0,DURATION 1US,COUNT 1", {1, 0, DG_S(1) + DG_US(1)}},
    };

    (void)state;
    const struct dg_fault_target target = dg_encoder_target(&rig.encoder[0]);
    const int index = dg_fault_find(&target, "wire_drop");
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_fault *fault = &rig.encoder[0].faults.fault[index];
        expect(rows[i].line, "");
        assert_true(fault->active);
        assert_int_equal(fault->left, rows[i].limits.count);
        assert_int_equal(fault->probability_ppm, rows[i].limits.probability_ppm);
        assert_int_equal(fault->until, rows[i].limits.duration);
    }
}

static void test_limits_that_cannot_be(void **state)
{
    (void)state;
    refuse("FAUL:SET wire_drop,COUNT 0", "-222", NULL);
    refuse("FAUL:SET wire_drop,PROB 1.1", "-222", NULL);
    refuse("FAUL:SET wire_drop,DUR 0S", "-222", NULL);
    refuse("FAUL:SET wire_drop,DUR 5", "-130", "Suffix error;5; expected 5MS or 5S");
    refuse("FAUL:SET wire_drop,DUR 1.5E3 ,COUN 3", "-130", "1.5E3; expected 1.5E3MS or 1.5E3S");
    refuse("FAUL:SET wire_drop,DUR 0", "-222", "0.000001..9223372036854.775807 MS");
    refuse("FAUL:SET wire_drop,DUR -5", "-222", "0.000001..9223372036854.775807 MS");
    refuse("FAUL:SET wire_drop,DUR 1E16", "-222", "0.000001..9223372036854.775807 MS");
    refuse("FAUL:SET wire_drop,DUR 1E10", "-130", "1E10; expected 1E10MS");
    refuse("FAUL:SET wire_drop,DUR 1E-7", "-130", "1E-7; expected 1E-7S");
    refuse("FAUL:SET wire_drop,DUR 5MIN", "-131", "MIN; expected MS, S, US or NS");
    refuse("FAUL:SET wire_drop,TIMES 3", "-224", NULL);
    refuse("FAUL:SET wire_drop,COUNT", "-109", NULL);
    refuse("FAUL:SET wire_drop,3", "-224", NULL);
    expect("FAUL:ACT?", "\"\"");
    refuse("FAUL:SET temperature_high,COUNT 3", "-221", "single frames");
    refuse("FAUL:SET eeprom_type,PROB 0.5", "-221", "single frames");
    expect("INST:SEL can", "");
    refuse("FAUL:SET bus_off,COUNT 3", "-221", "single frames");
    expect("FAUL:ACT?", "\"\"");
}

static void test_happened(void **state)
{
    (void)state;
    expect("FAUL:HAPP? wire_damage", "0");
    expect("FAUL:SET wire_damage,COUNT 2", "");
    assert_true(dg_fault_wire_takes(&rig.encoder[0].faults, DG_WIRE_DAMAGE));
    expect("FAUL:HAPP? WIRE_DAMAGE", "1");
    assert_true(dg_fault_wire_takes(&rig.encoder[0].faults, DG_WIRE_DAMAGE));
    expect("FAUL:HAPP? wire_damage;ACT?", "2;\"\"");
    refuse("FAUL:HAPP? nonsense", "-224", NULL);
    refuse("FAUL:HAPP?", "-109", NULL);
}

static void test_the_world_by_hand_ends_a_fault(void **state)
{
    (void)state;
    expect("FAUL:SET temperature_high;SET singleturn_lost", "");
    expect("WORL:TEMP 40;:FAUL:ACT?", "\"singleturn_lost\"");
    expect("FAUL:CLE;:WORL:TEMP?;SING?", "40.000;1");
    expect("FAUL:SET temperature_high;SET wire_deaf;:WORL:DEF;:FAUL:ACT?", "\"wire_deaf\"");
    expect("WORL:TEMP?", "37.000");
}

static void test_memory_that_does_not_answer(void **state)
{
    (void)state;
    rig.hf.fail_count = UINT32_MAX;
    refuse("FAUL:SET eeprom_type", "-250", "hf: the memory");
    refuse("NVM:CORR user", "-250", "hf: the memory");
    refuse("NVM:DATA?", "-250", "hf: the memory");
    rig.hf.fail_count = 0;
    expect("FAUL:SET eeprom_type", "");
    rig.hf.fail_count = UINT32_MAX;
    rig.hf.fail_from = 0;
    refuse("FAUL:CLE eeprom_type", "-250", NULL);
    refuse("FAUL:CLE", "-250", NULL);
    expect("FAUL:ACT?", "\"eeprom_type\"");
    refuse("*RST", "-250", NULL);
    refuse("POW OFF;:NVM:ERAS", "-250", NULL);
}

/* ------------------------------------------------------------ NVM */

static void test_regions(void **state)
{
    (void)state;
    expect("NVM:CAT?",
           "\"resolution\",\"calibration\",\"offset\",\"sync\",\"uart\",\"memory\","
           "\"codes\",\"fields\",\"type\",\"counter\",\"label\",\"field-sums\",\"user\","
           "\"steps\",\"implemented\"");
    expect("INST:SEL k2;:NVM:CAT?", "\"\"");
    refuse("NVM:CORR steps", "-241", "k2: it has no EEPROM");
    refuse("NVM:ERAS", "-241", "k2: it has no EEPROM");
    expect("INST:SEL k3;:NVM:CORR cams-8;:FAUL:ACT?", "\"eeprom_cams_8\"");
    refuse("NVM:CORR cams-9", "-224", "cams-9: no such region");
    refuse("NVM:CORR", "-109", NULL);
}

static void test_data(void **state)
{
    char last[60];

    (void)state;
    rig.hf.nvm.bytes[0] = 0x01;
    rig.hf.nvm.bytes[1] = 0xAB;
    rig.hf.nvm.bytes[2] = 0x00;
    expect("NVM:DATA? 0,3", "\"01AB00\"");
    expect("NVM:DATA? 1,1;:POW OFF;:NVM:DATA? 1,1", "\"AB\";\"AB\"");
    const uint32_t size = dg_store_size(&dg_hf_layout);
    (void)snprintf(last, sizeof last, "NVM:DATA? %u", (unsigned)size - 1u);
    rig.hf.nvm.bytes[size - 1u] = 0x5A;
    expect(last, "\"5A\"");
    (void)snprintf(last, sizeof last, "NVM:DATA? %u", (unsigned)size);
    refuse(last, "-222", NULL);
    (void)snprintf(last, sizeof last, "NVM:DATA? 1,%u", (unsigned)size);
    refuse(last, "-222", NULL);
    refuse("NVM:DATA? 0,0", "-222", NULL);
    refuse("NVM:DATA? -1", "-222", NULL);
    refuse("NVM:DATA? 0,1,2", "-108", NULL);
    refuse("NVM:DATA 0", "-113", NULL);
    refuse("INST:SEL k2;:NVM:DATA?", "-241", "k2: it has no EEPROM");
}

/* All of it, as the memory has it. */
static void test_all_data(void **state)
{
    static char whole[2u * RAM_NVM_MAX + 3u];
    struct dg_text to = dg_text_in(whole, sizeof whole);

    (void)state;
    dg_text_add(&to, "\"");
    for (uint32_t i = 0; i < dg_store_size(&dg_hf_layout); i++) {
        char digits[3];
        (void)snprintf(digits, sizeof digits, "%02X", (unsigned)rig.hf.nvm.bytes[i]);
        dg_text_add(&to, digits);
    }
    dg_text_add(&to, "\"");
    expect("NVM:DATA?", whole);
}

static void test_corrupt_is_seen_at_the_next_start(void **state)
{
    (void)state;
    expect("NVM:CORR OFFSET", "");
    assert_int_equal(rig.hf.device.store.damaged, 0);
    expect("POW CYCLE", "");
    assert_int_equal(rig.hf.device.store.damaged, 1u << DG_HF_REGION_OFFSET);
    expect("FAUL:CLE;:POW CYCL", "");
    assert_int_equal(rig.hf.device.store.damaged, 0);
}

/* Raw regions have no sum: one bit for good. */
static void test_corrupt_of_what_is_not_checked(void **state)
{
    static struct ram_nvm before;
    unsigned changed = 0;

    (void)state;
    before = rig.hf.nvm;
    expect("NVM:CORR field_sums;:FAUL:ACT?", "\"\"");
    const uint32_t first = dg_store_address(&dg_hf_layout, DG_HF_REGION_FIELD_SUMS);
    const uint32_t end = dg_store_address(&dg_hf_layout, DG_HF_REGION_USER);
    for (uint32_t i = 0; i < before.size; i++) {
        if (rig.hf.nvm.bytes[i] != before.bytes[i]) {
            assert_in_range(i, first, end - 1u);
            changed++;
        }
    }
    assert_int_equal(changed, 1);
}

static void test_erase(void **state)
{
    static const char *const names[] = {"hf", "biss-1", "can", "k3"};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        char line[40];
        (void)snprintf(line, sizeof line, "INST:SEL %s", names[i]);
        expect(line, "");
        refuse("NVM:ERAS", "-221", "its power is on");
        expect("POW OFF;:NVM:ERAS;:POW ON;POW?", "1");
    }
    expect("INST:SEL can", "");
    assert_int_equal(rig.co.node.serial, 1234567890u);
}

/* ------------------------------------------------------------ *RST, time */

static void test_reset(void **state)
{
    (void)state;
    expect("SHAF:VEL 60;:FAUL:SET temperature_low;SET eeprom_type;SET wire_drop", "");
    expect("INST:SEL can;:FAUL:SET bus_off;:WORL:BATT 1;:POW OFF", "");
    expect("INST:SEL biss-1", "");
    rig.changes = 0;
    expect("*RST", "");
    assert_true(rig.changes >= CONTROL_RIG_ENCODERS);
    expect("INST:SEL?;:SHAF:VEL?", "\"biss-1\";60.000");
    expect("INST:SEL hf;:FAUL:ACT?;:WORL:TEMP?", "\"\";37.000");
    expect("INST:SEL can;:FAUL:ACT?;:WORL:BATT?;:POW?", "\"\";3610;1");
    expect("INST:SEL hf;:POW CYCL", "");
    assert_int_equal(rig.hf.device.store.damaged, 0);
}

static void test_reset_of_what_does_not_start(void **state)
{
    (void)state;
    memset(rig.k3.nvm.bytes, 0xFF, rig.k3.nvm.size);
    expect("INST:SEL k3;:POW OFF", "");
    refuse("*RST", "-240", "k3: its EEPROM is blank");
    expect("INST:SEL?;:POW?", "\"k3\";0");
}

static void test_what_is_over_ends(void **state)
{
    (void)state;
    assert_int_equal(dg_rig_step(&rig.rig, rig.now), DG_NEVER);
    expect("FAUL:SET temperature_high,DUR 2S;:INST:SEL k2;:FAUL:SET wire_drop,DUR 1S", "");
    rig.changes = 0;
    const dg_ns begin = rig.now;
    assert_int_equal(dg_rig_step(&rig.rig, begin), begin + DG_S(1));
    assert_int_equal(rig.changes, 0);
    rig.now = begin + DG_S(1) - 1;
    expect("FAUL:ACT?", "\"wire_drop\"");
    rig.now = begin + DG_S(1);
    expect("FAUL:ACT?", "\"\""); /* also before the rig has stepped */
    assert_int_equal(dg_rig_step(&rig.rig, rig.now), begin + DG_S(2));
    assert_int_equal(rig.changes, 1);
    assert_ptr_equal(rig.changed, &rig.encoder[CONTROL_RIG_K2]);
    rig.now = begin + DG_S(3);
    assert_int_equal(dg_rig_step(&rig.rig, rig.now), DG_NEVER);
    assert_int_equal(rig.changes, 2);
    assert_ptr_equal(rig.changed, &rig.encoder[CONTROL_RIG_HF]);
    expect("INST:SEL hf;:WORL:TEMP?;:FAUL:ACT?", "37.000;\"\"");
}

/* The lines that the page begins with. */
static void test_page(void **state)
{
    static const char move[] = "SHAF:ACC 600RPM/S;MOVE 2.5REV,300RPM;*OPC?\n";

    (void)state;
    const char *line = "INST:SEL can;:FAUL:SET temperature_high,DURation 5S;:STAT?";
    assert_int_equal(strncmp(control_rig_say(&rig, line), "power=1,mode=", 13), 0);
    expect("WORL:TEMP?", "125.000");
    rig.length = 0;
    assert_int_equal(dg_control_rx(&rig.control, rig.now, move, strlen(move)), strlen(move));
    assert_int_equal(rig.length, 0);
    /* 0.5 s to 300 rpm, 1.25 turns in it; as long and as far down again. */
    rig.now = dg_control_step(&rig.control, rig.now);
    assert_int_equal(rig.now, DG_S(2));
    assert_int_equal(dg_control_step(&rig.control, rig.now), DG_NEVER);
    assert_string_equal(rig.answer, "1\n");
    expect("SHAF:POS?", "900.000000");
    assert_int_equal(dg_rig_step(&rig.rig, DG_S(6) - 1), DG_S(6));
    rig.now = DG_S(6);
    assert_int_equal(dg_rig_step(&rig.rig, rig.now), DG_NEVER);
    expect("WORL:TEMP?", "37.000");
}

/* What is written anew is not damaged any more, and no other fault goes with it. */
static void test_erase_forgets_damage(void **state)
{
    (void)state;
    expect("FAUL:SET eeprom_offset;SET eeprom_type;SET temperature_high", "");
    expect("FAUL:ACT?", "\"temperature_high\",\"eeprom_offset\",\"eeprom_type\"");
    expect("POW OFF;:NVM:ERAS;:FAUL:ACT?", "\"temperature_high\"");
    expect("POW ON", "");
    assert_int_equal(rig.hf.device.store.damaged, 0);
}

/* One error, and no bytes, whatever stands behind it. */
static void test_data_of_no_place(void **state)
{
    (void)state;
    refuse("NVM:DATA? -1,1", "-222", NULL);
    refuse("NVM:DATA? 999999,1", "-222", NULL);
    refuse("NVM:DATA? nowhere,1", "-104", NULL);
    refuse("NVM:DATA? nowhere", "-104", NULL);
    refuse("NVM:DATA? 0,nowhere", "-104", NULL);
    rig.hf.nvm.no_acknowledge = true; /* nobody asks it */
    refuse("NVM:DATA? -1", "-222", NULL);
    refuse("NVM:DATA? 0", "-250", NULL);
}

/* Of an encoder whose only faults are its memory's, the first region is the first of its list. */
static void test_corrupt_is_the_first_fault_of_all(void **state)
{
    struct dg_encoder *encoder = &rig.encoder[CONTROL_RIG_HF];
    struct dg_instrument bare = *encoder->instrument;

    (void)state;
    bare.fault_count = 0;
    encoder->instrument = &bare;
    expect("NVM:CORR resolution;:FAUL:ACT?", "\"eeprom_resolution\"");
    expect("FAUL:CLE;:FAUL:ACT?;:POW CYCL", "\"\"");
    assert_int_equal(rig.hf.device.store.damaged, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_catalogue, setup),
        cmocka_unit_test_setup(test_a_singleturn_offers_no_multiturn_faults, setup),
        cmocka_unit_test_setup(test_set_and_clear, setup),
        cmocka_unit_test_setup(test_limits_in_any_order, setup),
        cmocka_unit_test_setup(test_limits_that_cannot_be, setup),
        cmocka_unit_test_setup(test_happened, setup),
        cmocka_unit_test_setup(test_the_world_by_hand_ends_a_fault, setup),
        cmocka_unit_test_setup(test_memory_that_does_not_answer, setup),
        cmocka_unit_test_setup(test_regions, setup),
        cmocka_unit_test_setup(test_data, setup),
        cmocka_unit_test_setup(test_all_data, setup),
        cmocka_unit_test_setup(test_corrupt_is_seen_at_the_next_start, setup),
        cmocka_unit_test_setup(test_corrupt_of_what_is_not_checked, setup),
        cmocka_unit_test_setup(test_erase, setup),
        cmocka_unit_test_setup(test_reset, setup),
        cmocka_unit_test_setup(test_reset_of_what_does_not_start, setup),
        cmocka_unit_test_setup(test_what_is_over_ends, setup),
        cmocka_unit_test_setup(test_page, setup),
        cmocka_unit_test_setup(test_erase_forgets_damage, setup),
        cmocka_unit_test_setup(test_data_of_no_place, setup),
        cmocka_unit_test_setup(test_corrupt_is_the_first_fault_of_all, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

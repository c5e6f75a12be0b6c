/* SPDX-License-Identifier: MIT */
/*
 * Faults: the catalogue as a table, limits, what bends what, bits of the memory, frames by chance.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/control.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/instruments.h"
#include "hf_rig.h"

#define NAME_CHARACTERS "abcdefghijklmnopqrstuvwxyz0123456789_"
#define PPM 1000000u
#define FRAMES 100000u

static const struct dg_fault_limits forever = {.probability_ppm = PPM, .duration = DG_NEVER};
static struct hf_rig rig;
static struct dg_faults faults;
static struct dg_fault_target target;

static int setup(void **state)
{
    (void)state;
    assert_int_equal(hf_rig_init(&rig, dg_hf_model_of(dg_device_find("s3684-rs485"))), DG_OK);
    memset(&faults, 0, sizeof faults);
    target = (struct dg_fault_target){.instrument = &dg_hf_instrument,
                                      .world = &rig.world,
                                      .layout = &dg_hf_layout,
                                      .nvm = hf_rig_setup(&rig, NULL).nvm};
    return 0;
}

static size_t find(const char *name)
{
    const int index = dg_fault_find(&target, name);

    assert_true(index >= 0);
    return (size_t)index;
}

static int set(const char *name, const struct dg_fault_limits *limits)
{
    return dg_fault_set(&faults, &target, find(name), rig.now, limits);
}

static void set_ok(const char *name)
{
    assert_int_equal(set(name, &forever), DG_OK);
}

static int clear(const char *name)
{
    return dg_fault_clear(&faults, &target, find(name));
}

static bool active(const char *name)
{
    return faults.fault[find(name)].active;
}

/* ------------------------------------------------------------ the catalogue */

static void expect_line(const char *text)
{
    assert_non_null(text);
    assert_true(strlen(text) > 0);
    assert_null(strpbrk(text, "\n\""));
}

static void expect_catalogue(const struct dg_device *device)
{
    const struct dg_fault_target all = {.instrument = dg_instrument_of(device->stack),
                                        .world = &rig.world,
                                        .layout = device->stack->layout(device->model)};
    struct dg_fault_entry entry;
    size_t count = 0;

    for (; dg_fault_entry(&all, count, &entry); count++) {
        assert_int_equal(strspn(entry.name, NAME_CHARACTERS), strlen(entry.name));
        assert_int_equal(dg_fault_find(&all, entry.name), (int)count);
        assert_true((entry.row == NULL) == (entry.kind == DG_FAULT_MEMORY));
        expect_line(entry.cause);
        expect_line(entry.effect);
        expect_line(entry.chapter);
    }
    assert_true(count > 0 && count <= DG_FAULTS_MAX);
    assert_false(dg_fault_entry(&all, DG_FAULTS_MAX, &entry));
}

static void test_catalogues(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_device_count; i++) {
        expect_catalogue(dg_devices[i]);
    }
}

/* Every stack is an instrument; those of models with an EEPROM say what its damage does. */
static void test_instruments(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_device_count; i++) {
        const struct dg_instrument *instrument = dg_instrument_of(dg_devices[i]->stack);
        assert_non_null(instrument);
        assert_ptr_equal(instrument->stack, dg_devices[i]->stack);
        assert_true(instrument->mode != NULL && instrument->state != NULL);
        assert_true(instrument->damage != NULL ||
                    dg_devices[i]->stack->layout(dg_devices[i]->model) == NULL);
    }
    for (size_t i = 0; i < dg_instrument_count; i++) {
        assert_ptr_equal(dg_instrument_of(dg_instruments[i]->stack), dg_instruments[i]);
    }
    assert_null(dg_instrument_of(NULL));
}

/* A row has what its kind needs, and a value that is not the healthy one. */
static void expect_rows(const struct dg_instrument *instrument)
{
    struct dg_world world;

    dg_world_init(&world);
    for (size_t i = 0; i < instrument->fault_count; i++) {
        const struct dg_fault_row *row = &instrument->faults[i];
        if (row->kind == DG_FAULT_WORLD) {
            const struct dg_quantity *quantity = dg_quantity_at(row->offset);
            assert_true(row->size == 1 || row->size == 2 || row->size == 4);
            assert_true(row->offset + row->size <= sizeof world);
            assert_non_null(quantity);
            assert_true(dg_quantity_get(quantity, &world) != row->value);
        } else {
            assert_int_equal(row->kind, DG_FAULT_WIRE);
            assert_true(row->wire < DG_WIRE_FAULT_COUNT);
            assert_true((row->value > 0) == (row->wire == DG_WIRE_DELAY));
        }
    }
}

static void test_rows(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_instrument_count; i++) {
        expect_rows(dg_instruments[i]);
    }
}

static void test_names_are_found(void **state)
{
    (void)state;
    assert_int_equal(find("LED_Current_High"), find("led_current_high"));
    assert_int_equal(dg_fault_find(&target, "eeprom_field_sums"), DG_ERR_ARGUMENT); /* raw */
    assert_int_equal(dg_fault_find(&target, "led_current"), DG_ERR_ARGUMENT);
    assert_int_equal(dg_fault_find(&target, "led_current_highest"), DG_ERR_ARGUMENT);
    assert_int_equal(dg_fault_find(&target, ""), DG_ERR_ARGUMENT);
    assert_int_equal(dg_fault_find(&target, "bus_off"), DG_ERR_ARGUMENT);
}

static void test_without_memory_there_is_no_region(void **state)
{
    struct dg_fault_entry entry;

    (void)state;
    const size_t first = find("eeprom_resolution");
    assert_true(dg_fault_entry(&target, first, &entry));
    assert_int_equal(entry.code, DG_HF_COMPENSATION);
    target.layout = NULL;
    assert_false(dg_fault_entry(&target, first, &entry));
    assert_int_equal(dg_fault_find(&target, "eeprom_resolution"), DG_ERR_ARGUMENT);
    assert_int_equal(dg_fault_find(&target, "eeprom_silent"), DG_ERR_ARGUMENT);
    assert_true(dg_fault_find(&target, "wire_drop") >= 0);
}

static void test_singleturn_has_no_multiturn_sensor(void **state)
{
    static const char *const names[] = {"multiturn_amplitude", "multiturn_sync",
                                        "multiturn_vector"};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        target.singleturn = false;
        assert_true(dg_fault_find(&target, names[i]) >= 0);
        target.singleturn = true;
        assert_int_equal(dg_fault_find(&target, names[i]), DG_ERR_ARGUMENT);
    }
    assert_true(dg_fault_find(&target, "eeprom_silent") >= 0);
}

static void test_no_such_entry(void **state)
{
    (void)state;
    assert_int_equal(dg_fault_set(&faults, &target, DG_FAULTS_MAX, 0, &forever), DG_ERR_ARGUMENT);
    assert_int_equal(dg_fault_clear(&faults, &target, DG_FAULTS_MAX), DG_ERR_ARGUMENT);
}

/* Behind the last fault nothing is looked at, and nothing is written. */
static void test_faults_end_with_the_last(void **state)
{
    struct {
        struct dg_faults faults;
        uint8_t behind[sizeof(struct dg_fault)];
    } place;
    uint8_t dirt[sizeof place.behind];

    (void)state;
    memset(&place, 1, sizeof place);
    memset(dirt, 1, sizeof dirt);
    memset(&place.faults, 0, sizeof place.faults);
    assert_true(dg_fault_step(&place.faults, &target, DG_S(1)) == DG_NEVER);
    assert_memory_equal(place.behind, dirt, sizeof dirt);
    assert_true(dg_fault_step(&place.faults, &target, DG_NEVER - 1u) == DG_NEVER);
    assert_memory_equal(place.behind, dirt, sizeof dirt);
}

static void test_limits_that_cannot_be(void **state)
{
    static const struct {
        const char *name;
        struct dg_fault_limits limits;
        int result;
    } rows[] = {
        {"wire_drop", {1, PPM, DG_NEVER}, DG_OK},
        {"wire_drop", {0, 0, DG_NEVER}, DG_OK},
        {"wire_drop", {0, PPM + 1, DG_NEVER}, DG_ERR_ARGUMENT},
        {"temperature_high", {0, PPM, DG_S(1)}, DG_OK},
        {"temperature_low", {1, PPM, DG_NEVER}, DG_ERR_ARGUMENT},
        {"temperature_low", {0, PPM - 1, DG_NEVER}, DG_ERR_ARGUMENT},
        {"eeprom_offset", {1, PPM, DG_NEVER}, DG_ERR_ARGUMENT},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_int_equal(set(rows[i].name, &rows[i].limits), rows[i].result);
        assert_int_equal(active(rows[i].name), rows[i].result == DG_OK);
        assert_int_equal(clear(rows[i].name), DG_OK);
    }
    target = (struct dg_fault_target){.instrument = &dg_cia406_instrument, .world = &rig.world};
    assert_int_equal(set("bus_off", &rows[0].limits), DG_ERR_ARGUMENT);
    assert_int_equal(set("error_passive", &rows[1].limits), DG_ERR_ARGUMENT);
    assert_int_equal(set("overrun", &rows[0].limits), DG_OK);
    target.instrument = &dg_biss_instrument;
    assert_int_equal(set("wire_break", &rows[0].limits), DG_ERR_ARGUMENT);
}

/* ------------------------------------------------------------ the world */

static void test_quantity_is_as_before(void **state)
{
    (void)state;
    rig.world.temperature_mdegc = 41000;
    set_ok("temperature_high");
    assert_int_equal(rig.world.temperature_mdegc, 125000);
    set_ok("temperature_high");
    assert_int_equal(clear("temperature_high"), DG_OK);
    assert_int_equal(rig.world.temperature_mdegc, 41000);
    assert_int_equal(clear("temperature_high"), DG_OK);
}

static void test_every_size_and_sign(void **state)
{
    (void)state;
    rig.world.sin_offset_permille = -7;
    set_ok("sin_offset");
    assert_int_equal(rig.world.sin_offset_permille, 500);
    assert_int_equal(clear("sin_offset"), DG_OK);
    assert_int_equal(rig.world.sin_offset_permille, -7);
    set_ok("temperature_low");
    assert_int_equal(rig.world.temperature_mdegc, -45000);
    assert_int_equal(clear("temperature_low"), DG_OK);
    assert_int_equal(rig.world.temperature_mdegc, 37000);
    set_ok("singleturn_lost");
    assert_false(rig.world.singleturn_ok);
    assert_int_equal(clear("singleturn_lost"), DG_OK);
    assert_true(rig.world.singleturn_ok);
}

static void test_one_quantity_bends_one_way(void **state)
{
    (void)state;
    set_ok("temperature_high");
    set_ok("temperature_low");
    assert_false(active("temperature_high"));
    assert_int_equal(rig.world.temperature_mdegc, -45000);
    assert_int_equal(clear("temperature_high"), DG_OK);
    assert_int_equal(rig.world.temperature_mdegc, -45000);
    assert_int_equal(clear("temperature_low"), DG_OK);
    assert_int_equal(rig.world.temperature_mdegc, 37000);
}

static void test_quantity_that_was_changed_since_stays(void **state)
{
    (void)state;
    set_ok("led_current_high");
    rig.world.led_current_ua = 13000;
    assert_int_equal(clear("led_current_high"), DG_OK);
    assert_int_equal(rig.world.led_current_ua, 13000);
    assert_false(active("led_current_high"));
}

static void test_duration(void **state)
{
    const struct dg_fault_limits second = {.probability_ppm = PPM, .duration = DG_S(1)};
    const struct dg_fault_limits two = {.probability_ppm = PPM, .duration = DG_S(2)};

    (void)state;
    rig.now = DG_S(10);
    assert_int_equal(set("temperature_high", &second), DG_OK);
    assert_int_equal(set("wire_drop", &two), DG_OK);
    set_ok("led_current_high");
    assert_int_equal(dg_fault_step(&faults, &target, DG_S(10)), DG_S(11));
    assert_int_equal(dg_fault_step(&faults, &target, DG_S(11) - 1), DG_S(11));
    assert_true(active("temperature_high"));
    assert_int_equal(dg_fault_step(&faults, &target, DG_S(11)), DG_S(12));
    assert_int_equal(rig.world.temperature_mdegc, 37000);
    assert_true(dg_fault_wire_active(&faults, DG_WIRE_DROP));
    assert_int_equal(dg_fault_step(&faults, &target, DG_S(100)), DG_NEVER);
    assert_false(dg_fault_wire_active(&faults, DG_WIRE_DROP));
    assert_true(active("led_current_high"));
    assert_int_equal(faults.wire, 0);
}

static void test_again_is_with_the_new_limits(void **state)
{
    const struct dg_fault_limits second = {.probability_ppm = PPM, .duration = DG_S(1)};

    (void)state;
    assert_int_equal(set("temperature_high", &second), DG_OK);
    set_ok("temperature_high");
    assert_int_equal(dg_fault_step(&faults, &target, DG_S(5)), DG_NEVER);
    assert_true(active("temperature_high"));
}

/* ------------------------------------------------------------ the memory */

/* Bits by which the medium differs from `before`. */
static unsigned differences(const struct ram_nvm *before)
{
    unsigned count = 0;

    for (uint32_t i = 0; i < rig.nvm.size; i++) {
        for (unsigned bits = (unsigned)(rig.nvm.bytes[i] ^ before->bytes[i]); bits != 0;
             bits &= bits - 1u) {
            count++;
        }
    }
    return count;
}

static void test_one_bit_of_the_region(void **state)
{
    const struct ram_nvm before = rig.nvm;

    (void)state;
    const uint32_t first = dg_store_address(&dg_hf_layout, DG_HF_REGION_OFFSET);
    for (unsigned i = 0; i < 50; i++) { /* again and again: flipped back, and another one */
        set_ok("eeprom_offset");
        assert_int_equal(differences(&before), 1);
        assert_memory_not_equal(&rig.nvm.bytes[first], &before.bytes[first], 4);
    }
    assert_int_equal(clear("eeprom_offset"), DG_OK);
    assert_int_equal(differences(&before), 0);
    assert_memory_equal(rig.nvm.synced, before.synced, rig.nvm.size);
}

static void test_every_bit_has_its_turn(void **state)
{
    const struct ram_nvm before = rig.nvm;
    uint32_t seen = 0;

    (void)state;
    const uint32_t first = dg_store_address(&dg_hf_layout, DG_HF_REGION_OFFSET);
    for (unsigned i = 0; i < 1000; i++) {
        set_ok("eeprom_offset");
        for (unsigned byte = 0; byte < 4; byte++) {
            const unsigned changed =
                (unsigned)(rig.nvm.bytes[first + byte] ^ before.bytes[first + byte]);
            seen |= (uint32_t)changed << 8 * byte;
        }
    }
    assert_int_equal(seen, 0xFFFFFFFF);
}

/* Mount, and write the offset as the device would. */
static void write_offset(const uint8_t *bytes)
{
    struct dg_store store;

    assert_int_equal(dg_store_mount(&store, &dg_hf_layout, target.nvm), DG_OK);
    assert_true(dg_store_damaged(&store, DG_HF_REGION_OFFSET));
    assert_int_equal(dg_store_put(&store, DG_HF_REGION_OFFSET, 0, bytes, 4), DG_OK);
}

static void test_region_that_was_written_since_stays(void **state)
{
    const uint8_t *region = &rig.nvm.bytes[dg_store_address(&dg_hf_layout, DG_HF_REGION_OFFSET)];
    uint8_t before[4];
    struct dg_store store;

    (void)state;
    memcpy(before, region, sizeof before);
    /* Round 0: what was there before. Then: other values, of which one byte or another is what the
     * damage had made of it. */
    for (unsigned round = 0; round <= 16; round++) {
        uint8_t written[4];
        set_ok("eeprom_offset");
        memcpy(written, round == 0 ? before : region, sizeof written);
        written[round % 4] ^= (uint8_t)round;
        write_offset(written);
        assert_int_equal(clear("eeprom_offset"), DG_OK);
        assert_false(active("eeprom_offset"));
        assert_memory_equal(region, written, sizeof written);
        assert_int_equal(dg_store_mount(&store, &dg_hf_layout, target.nvm), DG_OK);
        assert_int_equal(store.damaged, 0);
    }
}

/* Whichever access fails, nothing is claimed that is not so. */
static void test_memory_that_does_not_answer(void **state)
{
    struct ram_nvm before = rig.nvm;

    (void)state;
    for (uint32_t n = 0; n < 4; n++) {
        rig.fail_from = rig.accesses + n;
        rig.fail_count = 1;
        assert_int_equal(set("eeprom_type", &forever), DG_ERR_IO);
        assert_false(active("eeprom_type"));
        rig.nvm = before;
    }
    rig.fail_count = 0;
    set_ok("eeprom_type");
    for (uint32_t n = 0; n < 4; n++) {
        rig.fail_from = rig.accesses + n;
        rig.fail_count = 1;
        assert_int_equal(clear("eeprom_type"), DG_ERR_IO);
        assert_true(active("eeprom_type"));
        rig.fail_count = 0;
        set_ok("eeprom_type");
    }
    assert_int_equal(clear("eeprom_type"), DG_OK);
}

/* It is not asked again and again. */
static void test_memory_that_does_not_answer_in_time(void **state)
{
    const struct dg_fault_limits second = {.probability_ppm = PPM, .duration = DG_S(1)};

    (void)state;
    assert_int_equal(set("eeprom_type", &second), DG_OK);
    rig.fail_from = 0;
    rig.fail_count = UINT32_MAX;
    assert_int_equal(dg_fault_step(&faults, &target, DG_S(1)), DG_NEVER);
    assert_true(active("eeprom_type"));
    assert_int_equal(set("eeprom_type", &second), DG_ERR_IO);
    rig.fail_count = 0;
    assert_int_equal(clear("eeprom_type"), DG_OK);
    assert_false(active("eeprom_type"));
}

static void test_memory_without_sync(void **state)
{
    struct dg_nvm_ops ops = *target.nvm.ops;
    const struct ram_nvm before = rig.nvm;

    (void)state;
    ops.sync = NULL;
    target.nvm.ops = &ops;
    set_ok("eeprom_type");
    assert_int_equal(differences(&before), 1);
    assert_int_equal(clear("eeprom_type"), DG_OK);
    assert_int_equal(differences(&before), 0);
}

/* ------------------------------------------------------------ the wire */

static void test_nothing_happens_by_itself(void **state)
{
    (void)state;
    for (unsigned i = 0; i < DG_WIRE_FAULT_COUNT; i++) {
        assert_false(dg_fault_wire_active(&faults, (enum dg_wire_fault)i));
        assert_false(dg_fault_wire_takes(&faults, (enum dg_wire_fault)i));
    }
}

/* Every one on its own, in every encoder that has it. */
static void test_each_wire_fault_is_its_own(void **state)
{
    (void)state;
    for (size_t d = 0; d < dg_device_count; d++) {
        const struct dg_stack *stack = dg_devices[d]->stack;
        struct dg_fault_entry entry;
        target =
            (struct dg_fault_target){.instrument = dg_instrument_of(stack), .world = &rig.world};
        for (size_t i = 0; dg_fault_entry(&target, i, &entry); i++) {
            if (entry.kind != DG_FAULT_WIRE) {
                continue;
            }
            assert_int_equal(dg_fault_set(&faults, &target, i, 0, &forever), DG_OK);
            assert_int_equal(faults.wire, 1u << entry.row->wire);
            assert_true(dg_fault_wire_takes(&faults, (enum dg_wire_fault)entry.row->wire));
            assert_int_equal(faults.fault[i].happened, 1);
            assert_int_equal(
                dg_fault_wire_value(target.instrument, (enum dg_wire_fault)entry.row->wire),
                entry.row->value);
            assert_int_equal(dg_fault_clear(&faults, &target, i), DG_OK);
            assert_int_equal(faults.wire, 0);
        }
    }
    assert_int_equal(dg_fault_wire_value(&dg_biss_instrument, DG_WIRE_DELAY), 100000);
    assert_int_equal(dg_fault_wire_value(&dg_biss_instrument, DG_WIRE_BUS_OFF), 0);
}

static void test_count(void **state)
{
    const struct dg_fault_limits three = {.count = 3, .probability_ppm = PPM, .duration = DG_NEVER};

    (void)state;
    assert_int_equal(set("wire_damage", &three), DG_OK);
    for (unsigned i = 0; i < 3; i++) {
        assert_true(active("wire_damage"));
        assert_true(dg_fault_wire_takes(&faults, DG_WIRE_DAMAGE));
    }
    assert_false(active("wire_damage"));
    assert_false(dg_fault_wire_takes(&faults, DG_WIRE_DAMAGE));
    assert_int_equal(faults.fault[find("wire_damage")].happened, 3);
    set_ok("wire_damage");
    assert_int_equal(faults.fault[find("wire_damage")].happened, 0);
}

/* Within five standard deviations of what chance should give. */
static void test_probability(void **state)
{
    struct dg_fault_limits tenth = {.probability_ppm = PPM / 10, .duration = DG_NEVER};

    (void)state;
    assert_int_equal(set("wire_drop", &tenth), DG_OK);
    for (unsigned i = 0; i < FRAMES; i++) {
        (void)dg_fault_wire_takes(&faults, DG_WIRE_DROP);
    }
    assert_in_range(faults.fault[find("wire_drop")].happened, FRAMES / 10 - 475, FRAMES / 10 + 475);
    tenth.probability_ppm = 0;
    assert_int_equal(set("wire_drop", &tenth), DG_OK);
    for (unsigned i = 0; i < FRAMES; i++) {
        assert_false(dg_fault_wire_takes(&faults, DG_WIRE_DROP));
    }
}

static void test_chance_is_repeatable_and_even(void **state)
{
    struct dg_faults other = {.random = 1};
    unsigned seen[7] = {0};

    (void)state;
    faults.random = 1;
    for (unsigned i = 0; i < 7000; i++) {
        const uint32_t bit = dg_fault_pick(&faults, 7);
        assert_int_equal(bit, dg_fault_pick(&other, 7));
        assert_true(bit < 7);
        seen[bit]++;
    }
    for (unsigned i = 0; i < 7; i++) {
        assert_in_range(seen[i], 850, 1150);
    }
    assert_int_equal(dg_fault_pick(&faults, 1), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_catalogues, setup),
        cmocka_unit_test_setup(test_instruments, setup),
        cmocka_unit_test_setup(test_rows, setup),
        cmocka_unit_test_setup(test_names_are_found, setup),
        cmocka_unit_test_setup(test_without_memory_there_is_no_region, setup),
        cmocka_unit_test_setup(test_singleturn_has_no_multiturn_sensor, setup),
        cmocka_unit_test_setup(test_no_such_entry, setup),
        cmocka_unit_test_setup(test_faults_end_with_the_last, setup),
        cmocka_unit_test_setup(test_limits_that_cannot_be, setup),
        cmocka_unit_test_setup(test_quantity_is_as_before, setup),
        cmocka_unit_test_setup(test_every_size_and_sign, setup),
        cmocka_unit_test_setup(test_one_quantity_bends_one_way, setup),
        cmocka_unit_test_setup(test_quantity_that_was_changed_since_stays, setup),
        cmocka_unit_test_setup(test_duration, setup),
        cmocka_unit_test_setup(test_again_is_with_the_new_limits, setup),
        cmocka_unit_test_setup(test_one_bit_of_the_region, setup),
        cmocka_unit_test_setup(test_every_bit_has_its_turn, setup),
        cmocka_unit_test_setup(test_region_that_was_written_since_stays, setup),
        cmocka_unit_test_setup(test_memory_that_does_not_answer, setup),
        cmocka_unit_test_setup(test_memory_that_does_not_answer_in_time, setup),
        cmocka_unit_test_setup(test_memory_without_sync, setup),
        cmocka_unit_test_setup(test_nothing_happens_by_itself, setup),
        cmocka_unit_test_setup(test_each_wire_fault_is_its_own, setup),
        cmocka_unit_test_setup(test_count, setup),
        cmocka_unit_test_setup(test_probability, setup),
        cmocka_unit_test_setup(test_chance_is_repeatable_and_even, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

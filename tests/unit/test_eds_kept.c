/* SPDX-License-Identifier: MIT */
/*
 * Values of an EDS file that only store, and its objects on top of those of an encoder: what 1010h
 * keeps, also in a memory that fails, and which values an object takes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "eds_rig.h"

#define SAVE 0x65766173u
#define TYPE "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
#define ERRORS "[1001]\nDataType=5\nAccessType=ro\n"
#define MEMORY "[1010]\nObjectType=8\n[1010sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
#define VALUES(index, count)                                                                       \
    "[" index "]\nObjectType=8\nDataType=7\nAccessType=rw\nDefaultValue=5\nCompactSubObj=" count   \
    "\n"
#define F3668                                                                                      \
    "[1018]\nObjectType=9\n[1018sub1]\nDataType=7\nAccessType=ro\nDefaultValue=0x13\n"             \
    "[1018sub2]\nDataType=7\nAccessType=ro\nDefaultValue=0x56682001\n"                             \
    "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=65536\n"                                      \
    "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=4096\n"
/* 32 of them are in a region of the EEPROM. */
#define COUNT 100u

static struct eds_rig rig;

static void start_with_values(void)
{
    eds_rig_start(&rig, TYPE ERRORS MEMORY VALUES("2000", "100"));
    assert_int_equal(rig.file.file.kept, COUNT);
}

/* Where each value lies follows from the size: a change of it, or of the identifier, makes EEPROMs
 * foreign that users have. */
static void an_eeprom_is_the_one_that_it_always_was(void **state)
{
    (void)state;
    start_with_values();
    assert_int_equal(dg_store_size(rig.file.file.device.layout), 1570);
    assert_int_equal(rig.file.file.device.layout->id, 0x3FE2B047);
}

static void write_all(void)
{
    for (uint8_t sub = 1; sub <= COUNT; sub++) {
        co_rig_put(&rig.co, 0x2000, sub, 1000u + sub, 4);
    }
}

/* Sub-indices `from` to `to` have what was written, the others their default. */
static void expect_written(uint8_t from, uint8_t to)
{
    for (uint8_t sub = 1; sub <= COUNT; sub++) {
        const bool written = sub >= from && sub <= to;
        assert_int_equal(co_rig_get(&rig.co, 0x2000, sub), written ? 1000u + sub : 5);
    }
}

static void save_all(void)
{
    write_all();
    co_rig_put(&rig.co, 0x1010, 1, SAVE, 4);
}

/* ------------------------------------------------------------ the memory */

static void values_are_kept_however_many_regions_they_take(void **state)
{
    (void)state;
    start_with_values();
    save_all();
    eds_rig_power_cycle(&rig);
    expect_written(1, COUNT);
}

static void only_the_word_saves(void **state)
{
    (void)state;
    start_with_values();
    write_all();
    assert_int_not_equal(co_rig_write(&rig.co, 0x1010, 1, SAVE + 1u, 4), 0);
    (void)co_rig_get(&rig.co, 0x1010, 1);
    eds_rig_power_cycle(&rig);
    expect_written(1, 0);
}

static void a_memory_that_is_silent_saves_nothing(void **state)
{
    (void)state;
    start_with_values();
    write_all();
    rig.co.world.eeprom_acknowledges = false;
    assert_int_not_equal(co_rig_write(&rig.co, 0x1010, 1, SAVE, 4), 0);
    rig.co.world.eeprom_acknowledges = true;
    eds_rig_power_cycle(&rig);
    expect_written(1, 0);
}

/* As delivered, and what was saved comes back with the memory. An f3668 has a node-ID then. */
static void a_memory_that_is_silent_at_the_power_has_the_defaults(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE F3668 MEMORY VALUES("2000", "100"));
    save_all();
    rig.co.world.eeprom_acknowledges = false;
    eds_rig_power_cycle(&rig);
    expect_written(1, 0);
    rig.co.world.eeprom_acknowledges = true;
    eds_rig_power_cycle(&rig);
    expect_written(1, COUNT);
}

static void damage(const char *name)
{
    const struct dg_store_layout *layout = &rig.file.file.layout;
    const int region = dg_store_find(layout, name);

    assert_true(region >= 0);
    rig.co.nvm.bytes[dg_store_address(layout, (uint8_t)region)] ^= 1u;
}

static void a_damaged_region_loses_its_own_values_only(void **state)
{
    (void)state;
    start_with_values();
    save_all();
    damage("valuesa");
    eds_rig_power_cycle(&rig);
    expect_written(33, COUNT);
    assert_int_not_equal(co_rig_get(&rig.co, 0x1001, 0), 0);
}

/* Whether anything was saved stands in a region of its own. */
static void without_the_mark_nothing_was_saved(void **state)
{
    (void)state;
    start_with_values();
    save_all();
    damage(rig.file.file.layout.regions[DG_CO_REGION_SAVED].name);
    eds_rig_power_cycle(&rig);
    expect_written(1, 0);
}

static void values_behind_the_memory_are_lost_at_power_off(void **state)
{
    uint16_t kept;
    (void)state;
    eds_rig_start(&rig, TYPE MEMORY VALUES("2000", "254") VALUES("2001", "254")
                            VALUES("2002", "254") VALUES("2003", "254"));
    kept = rig.file.file.kept;
    assert_true(eds_rig_is_noted(&rig, "", "more values than 1010h can keep"));
    assert_in_range(kept, 33, 1015);
    for (unsigned i = 0; i < 2; i++) {
        const unsigned n = kept - 1u + i; /* the last one that is kept, and the next */
        co_rig_put(&rig.co, (uint16_t)(0x2000u + n / 254u), (uint8_t)(n % 254u + 1u), 77, 4);
    }
    co_rig_put(&rig.co, 0x1010, 1, SAVE, 4);
    eds_rig_power_cycle(&rig);
    for (unsigned i = 0; i < 2; i++) {
        const unsigned n = kept - 1u + i;
        const uint32_t value =
            co_rig_get(&rig.co, (uint16_t)(0x2000u + n / 254u), (uint8_t)(n % 254u + 1u));
        assert_int_equal(value, i == 0 ? 77 : 5);
    }
}

static void a_value_with_a_sign_has_two_limits(void **state)
{
    static const struct {
        uint32_t value;
        uint32_t result;
    } rows[] = {{0xF6, DG_CO_RANGE}, {0xF7, 0}, {0, 0}, {9, 0}, {10, DG_CO_RANGE}};
    (void)state;
    eds_rig_start(&rig, TYPE "[2000]\nDataType=2\nAccessType=rw\nDefaultValue=0\nLowLimit=-9\n"
                             "HighLimit=9\n");
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        assert_int_equal(co_rig_write(&rig.co, 0x2000, 0, rows[i].value, 1), rows[i].result);
    }
}

/* ------------------------------------------------------------ on top of an encoder's objects */

/* The encoder's own default and range stay where the file's do not fit. */
static void what_the_encoder_does_not_take_is_its_own(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE F3668
                  "[6001]\nDataType=7\nAccessType=rw\nDefaultValue=70000\nLowLimit=0\n"
                  "HighLimit=100000\n[2120]\nObjectType=8\n[2120sub2]\nDataType=5\nAccessType=rw\n"
                  "DefaultValue=0x10\n[2120sub3]\nDataType=5\nAccessType=rw\nDefaultValue=0x80\n"
                  "LowLimit=0x70\nHighLimit=0x90\n");
    assert_true(eds_rig_is_noted(&rig, "6001", "none that the encoder takes"));
    assert_true(eds_rig_is_noted(&rig, "2120sub2", "none that the encoder takes"));
    assert_int_equal(co_rig_get(&rig.co, 0x6001, 0), 65536);
    assert_int_equal(co_rig_get(&rig.co, 0x2120, 2), 0x20);
    assert_int_equal(co_rig_write(&rig.co, 0x6001, 0, 0, 4), DG_CO_RANGE);
    assert_int_equal(co_rig_write(&rig.co, 0x6001, 0, 65537, 4), DG_CO_RANGE);
    assert_int_equal(co_rig_write(&rig.co, 0x2120, 3, 0x91, 1), DG_CO_RANGE);
    assert_int_equal(co_rig_write(&rig.co, 0x2120, 3, 0x6F, 1), DG_CO_RANGE);
    assert_int_equal(co_rig_write(&rig.co, 0x2120, 3, 0x90, 1), 0);
}

/* Temperature limits of an f3668 are nothing to an encoder of another maker: a value. */
static void objects_of_another_maker_are_values(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE ERRORS "[2120]\nObjectType=8\n[2120sub2]\nDataType=5\nAccessType=rw\n"
                                    "DefaultValue=0x10\n");
    co_rig_put(&rig.co, 0x2120, 2, 0xFF, 1);
    co_rig_run(&rig.co, DG_S(1));
    assert_int_equal(co_rig_get(&rig.co, 0x2120, 2), 0xFF);
    assert_int_equal(co_rig_get(&rig.co, 0x1001, 0), 0);
}

/* There is room for fifteen ranges of objects that behave; what is behind takes any value. */
static void one_range_too_many_is_noted(void **state)
{
    static const char *const sections[] = {
        "6001",     "6002",     "6003",     "6031sub1", "6031sub3", "6031sub4",
        "6401sub1", "6401sub2", "6402sub1", "6402sub2", "2140sub1", "2140sub2",
        "2140sub3", "2140sub4", "1006",     "1007",
    };
    char text[4096];
    size_t n = 0;
    (void)state;
    n += (size_t)snprintf(text, sizeof text, "%s", TYPE F3668);
    for (unsigned i = 0; i < DG_COUNT(sections); i++) {
        const bool small = memcmp(sections[i], "6031", 4) == 0;
        n += (size_t)snprintf(text + n, sizeof text - n,
                              "[%s]\nDataType=%u\nAccessType=rw\nDefaultValue=1\nHighLimit=%u\n",
                              sections[i], small ? 6u : 7u, 100u + i);
    }
    eds_rig_start(&rig, text);
    assert_true(eds_rig_is_noted(&rig, "6402sub2", "one limit too many"));
    assert_false(eds_rig_is_noted(&rig, "6402sub1", "one limit too many"));
    assert_int_equal(co_rig_write(&rig.co, 0x6402, 1, 109, 4), DG_CO_RANGE);
    assert_int_equal(co_rig_write(&rig.co, 0x6402, 2, 1000, 4), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_eeprom_is_the_one_that_it_always_was),
        cmocka_unit_test(values_are_kept_however_many_regions_they_take),
        cmocka_unit_test(only_the_word_saves),
        cmocka_unit_test(a_memory_that_is_silent_saves_nothing),
        cmocka_unit_test(a_memory_that_is_silent_at_the_power_has_the_defaults),
        cmocka_unit_test(a_damaged_region_loses_its_own_values_only),
        cmocka_unit_test(without_the_mark_nothing_was_saved),
        cmocka_unit_test(values_behind_the_memory_are_lost_at_power_off),
        cmocka_unit_test(a_value_with_a_sign_has_two_limits),
        cmocka_unit_test(what_the_encoder_does_not_take_is_its_own),
        cmocka_unit_test(objects_of_another_maker_are_values),
        cmocka_unit_test(one_range_too_many_is_noted),
    };
    return cmocka_run_group_tests_name("eds_kept", tests, NULL, NULL);
}

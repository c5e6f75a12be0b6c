/* SPDX-License-Identifier: MIT */
/*
 * PDOs that an EDS file has no sections for: CompactPDO.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "eds_rig.h"

#define START 0x01
#define SYNC 0x080
#define NO_OBJECT 0x06020000u
#define NO_SUB 0x06090011u
#define OFF 0x80000000u

#define INFO(compact, rpdos, tpdos)                                                                \
    "[DeviceInfo]\nCompactPDO=" compact "\nNrOfRXPDO=" rpdos "\nNrOfTXPDO=" tpdos "\n"
#define OBJECTS                                                                                    \
    "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"                                    \
    "[6004]\nDataType=7\nAccessType=ro\nPDOMapping=1\n"                                            \
    "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n"                                       \
    "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=4096\n"

static struct eds_rig rig;

static uint32_t refusal(uint16_t index, uint8_t sub)
{
    uint32_t value;

    return co_rig_read(&rig.co, index, sub, &value);
}

/* Bits 0, 1 and 4: COB-ID, transmission type, event timer. */
static void tpdos_need_no_sections(void **state)
{
    (void)state;
    eds_rig_start(&rig, INFO("0x13", "0", "2") OBJECTS);
    assert_int_equal(rig.note_count, 0);
    assert_int_equal(co_rig_get(&rig.co, 0x1800, 0), 5);
    assert_int_equal(co_rig_get(&rig.co, 0x1801, 2), 255);
    assert_int_equal(co_rig_get(&rig.co, 0x1801, 5), 0);
    assert_int_equal(refusal(0x1801, 3), NO_SUB);
    assert_int_equal(refusal(0x1802, 1), NO_OBJECT);
    assert_int_equal(refusal(0x1A02, 0), NO_OBJECT);
    assert_int_equal(refusal(0x1400, 1), NO_OBJECT);
    assert_int_equal(co_rig_get(&rig.co, 0x1801, 1) & 0x7FFu, 0x2BF);
    co_rig_put(&rig.co, 0x1801, 1, OFF | 0x2BF, 4);
    co_rig_put(&rig.co, 0x1801, 2, 1, 1);
    co_rig_put(&rig.co, 0x1A01, 1, 0x60040020, 4);
    co_rig_put(&rig.co, 0x1A01, 0, 1, 1);
    co_rig_put(&rig.co, 0x1801, 1, 0x2BF, 4);
    co_rig_nmt(&rig.co, START);
    co_rig_rx(&rig.co, SYNC, "");
    co_rig_expect_count(&rig.co, 1);
    co_rig_expect(&rig.co, 0, 0x2BF, "00 00 00 00");
}

static void a_section_has_the_last_word(void **state)
{
    (void)state;
    eds_rig_start(&rig, INFO("3", "0", "1") OBJECTS
                  "[1800sub2]\nDataType=5\nAccessType=rw\nDefaultValue=1\n"
                  "[1A00sub0]\nDataType=5\nAccessType=rw\nDefaultValue=1\n"
                  "[1A00sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0x60040020\n");
    assert_int_equal(co_rig_get(&rig.co, 0x1800, 1), 0x1BF);
    assert_int_equal(co_rig_get(&rig.co, 0x1800, 2), 1);
    assert_int_equal(co_rig_get(&rig.co, 0x1A00, 1), 0x60040020);
    co_rig_nmt(&rig.co, START);
    co_rig_rx(&rig.co, SYNC, "");
    co_rig_expect(&rig.co, 0, 0x1BF, "00 00 00 00");
}

/* RPDOs and TPDO5 are values; those behind the predefined connection set are switched off. */
static void the_others_are_values(void **state)
{
    (void)state;
    eds_rig_start(&rig, INFO("3", "5", "5") OBJECTS);
    assert_int_equal(co_rig_get(&rig.co, 0x1400, 1), 0x23F);
    assert_int_equal(co_rig_get(&rig.co, 0x1403, 1), 0x53F);
    assert_int_equal(co_rig_get(&rig.co, 0x1404, 1), OFF);
    assert_int_equal(co_rig_get(&rig.co, 0x1804, 1), OFF);
    assert_int_equal(refusal(0x1405, 1), NO_OBJECT);
    co_rig_put(&rig.co, 0x1600, 1, 0x62000008, 4);
    assert_int_equal(co_rig_get(&rig.co, 0x1600, 1), 0x62000008);
    assert_true(eds_rig_is_noted(&rig, "1804sub1", "a PDO that this node does not have"));
    assert_true(eds_rig_is_noted(&rig, "1400sub1", "a PDO that this node does not have"));
    assert_false(eds_rig_is_noted(&rig, "1803sub1", "a PDO that this node does not have"));
}

/* Six bits stand for sub-indices; the others, for nothing. */
static void a_bit_without_a_sub_index_adds_nothing(void **state)
{
    (void)state;
    eds_rig_start(&rig, INFO("0xFFFFFFC3", "0", "1") OBJECTS);
    assert_int_equal(rig.note_count, 0);
    assert_int_equal(co_rig_get(&rig.co, 0x1800, 0), 2);
    assert_int_equal(refusal(0x1800, 3), NO_SUB);
    assert_int_equal(refusal(0x1800, 7), NO_SUB);
    eds_rig_start(&rig, INFO("0x20", "0", "1") OBJECTS);
    assert_int_equal(co_rig_get(&rig.co, 0x1800, 0), 6);
}

static void without_the_key_there_are_none(void **state)
{
    (void)state;
    eds_rig_start(&rig, INFO("0", "4", "4") OBJECTS);
    assert_int_equal(refusal(0x1800, 1), NO_OBJECT);
    assert_int_equal(refusal(0x1400, 1), NO_OBJECT);
    eds_rig_read_text(&rig, INFO("3", "0xFFFFFFFF", "0") OBJECTS);
    assert_int_equal(rig.file.file.objects, 4u + 2u * 512u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tpdos_need_no_sections),
        cmocka_unit_test(a_section_has_the_last_word),
        cmocka_unit_test(the_others_are_values),
        cmocka_unit_test(a_bit_without_a_sub_index_adds_nothing),
        cmocka_unit_test(without_the_key_there_are_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/* EDS and DCF files as makers and tools write them: what is read of them, and what is noted. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "eds_rig.h"

#define TYPE "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
#define IDENTITY(vendor, product)                                                                  \
    "[1018]\nObjectType=9\n[1018sub1]\nDataType=7\nAccessType=ro\nDefaultValue=" vendor "\n"       \
    "[1018sub2]\nDataType=7\nAccessType=ro\nDefaultValue=" product "\n"
#define CONSTANT(index, value) "[" index "]\nDataType=7\nAccessType=ro\nDefaultValue=" value "\n"

static struct eds_rig rig;

static bool is_noted(const char *section, const char *what)
{
    return eds_rig_is_noted(&rig, section, what);
}

/* ------------------------------------------------------------ numbers and words */

static void numbers_come_in_many_forms(void **state)
{
    static const struct {
        const char *text;
        uint32_t value;
    } rows[] = {
        {"18", 18},
        {"0x12", 18},
        {"12h", 18},
        {"12H", 18},
        {"022", 18},
        {"0", 0},
        {"+18", 18},
        {"-1", UINT32_MAX},
        {"089", 89},
        {"\"18\"", 18},
        {"18 ; tr", 18},
        {"18#", 18},
        {"4294967295", UINT32_MAX},
        {"0xFFFFFFFF", UINT32_MAX},
    };
    char text[256];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        (void)snprintf(text, sizeof text, TYPE CONSTANT("2000", "%s"), rows[i].text);
        eds_rig_start(&rig, text);
        assert_false(is_noted("2000", ""));
        assert_int_equal(co_rig_get(&rig.co, 0x2000, 0), rows[i].value);
    }
}

static void what_is_no_number_is_left_out(void **state)
{
    static const char *const texts[] = {"4294967296",
                                        "0x1FFFFFFFF",
                                        "h",
                                        "0x",
                                        "1G",
                                        "-",
                                        "1.5",
                                        "GHh",
                                        "08h1",
                                        "00000000000000000000"
                                        "00000000000000000012"
                                        "3456789012345678901"};
    char text[256];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(texts); i++) {
        (void)snprintf(text, sizeof text, TYPE CONSTANT("2000", "%s"), texts[i]);
        eds_rig_start(&rig, text);
        if (!is_noted("2000", "no number of its type")) {
            fail_msg("'%s' was taken for a number", texts[i]);
        }
        assert_int_equal(co_rig_get(&rig.co, 0x2000, 0), 0);
    }
}

static void a_number_beyond_its_key_is_left_out(void **state)
{
    (void)state;
    eds_rig_read_text(&rig,
                      "[DeviceInfo]\nVendorNumber=0x100000000\nBaudRate_125=256\n"
                      "BaudRate_x=1\n[DeviceComissioning]\nNodeID=300\nBaudrate=2000\n" TYPE
                      "[2000]\nObjectType=700\nDataType=0x10007\nPDOMapping=x\nAccessType=ro\n");
    assert_int_equal(rig.file.file.node_id, 0);
    assert_true(is_noted("DeviceInfo", "is no number here"));
    assert_true(is_noted("DeviceComissioning", "is no number here"));
    assert_true(is_noted("2000", "is no number here"));
}

static void an_identity_may_be_in_the_head_only(void **state)
{
    (void)state;
    eds_rig_start(&rig, "[DeviceInfo]\nVendorNumber=0x2A\nProductNumber=7\nRevisionNumber=3\n" TYPE
                        "[1018]\nObjectType=9\n[1018sub1]\nDataType=7\nAccessType=ro\n"
                        "[1018sub2]\nDataType=7\nAccessType=ro\n"
                        "[1018sub3]\nDataType=7\nAccessType=ro\n");
    assert_int_equal(co_rig_get(&rig.co, 0x1018, 1), 0x2A);
    assert_int_equal(co_rig_get(&rig.co, 0x1018, 2), 7);
    assert_int_equal(co_rig_get(&rig.co, 0x1018, 3), 3);
}

static void words_may_have_something_behind_them(void **state)
{
    static const struct {
        const char *access;
        bool writable;
    } rows[] = {{"rw", true},     {"RW;as delivered", true},
                {"rww#", true},   {"rwr ", true},
                {"rwx", false},   {"ro;", false},
                {"r", false},     {"const x", false},
                {"rw\tany", true}};
    char text[256];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        (void)snprintf(text, sizeof text, TYPE "[2000]\nDataType=5\nAccessType=%s\n",
                       rows[i].access);
        eds_rig_start(&rig, text);
        const uint32_t result = co_rig_write(&rig.co, 0x2000, 0, 7, 1);
        assert_int_equal(result, rows[i].writable ? 0 : DG_CO_READ_ONLY);
    }
    assert_false(is_noted("2000", "no access"));
    eds_rig_read_text(&rig, TYPE "[2000]\nDataType=5\nAccessType=rwx\n");
    assert_true(is_noted("2000", "no access"));
}

/* ------------------------------------------------------------ sections */

/* What looks like a section of an object and is none is noted: it may be a slip of the pen. */
static void comments_and_sections_of_tools_are_left_alone(void **state)
{
    (void)state;
    eds_rig_start(&rig,
                  "; by a tool\n# by another\n\n[Comments]\nLine1=x\n[10]\nx=1\n[zzzz]\nx=1\n" TYPE
                  "[1000Name]\n1=x\n[1000subx]\nDataType=7\n[1000sub100]\nDataType=7\n"
                  "[1000sub]\nDataType=7\n[1000Denotation]\nNrOfEntries=1\n"
                  "[2000]\nDataType=5\nAccessType=ro\nDefaultValue=3\nUpperText=x\n");
    assert_int_equal(rig.note_count, 5);
    assert_true(is_noted("6501", "")); /* is not there */
    assert_true(is_noted("10", "is no section of an object"));
    assert_true(is_noted("1000subx", "is no section of an object"));
    assert_true(is_noted("1000sub100", "is no section of an object"));
    assert_true(is_noted("1000sub", "is no section of an object"));
    assert_int_equal(co_rig_get(&rig.co, 0x2000, 0), 3);
}

static void both_spellings_of_commissioning_count(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, "[DeviceCommissioning]\nNodeID=0x22\nNodeName=x\n" TYPE);
    assert_int_equal(rig.file.file.node_id, 0x22);
    eds_rig_read_text(&rig, "[DeviceComissioning]\nNodeID=34\nLSS_SerialNumber=1\n" TYPE);
    assert_int_equal(rig.file.file.node_id, 34);
    eds_rig_read_text(&rig, "[DeviceComissioning]\nNodeID=255\n" TYPE); /* none yet */
    assert_int_equal(rig.file.file.node_id, 0);
}

static void lists_count_what_they_name(void **state)
{
    (void)state;
    eds_rig_read_text(&rig,
                      "[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n=x\n123456=0x2000\n" TYPE);
    assert_false(is_noted("", "lists name other objects"));
    eds_rig_read_text(&rig, "[ManufacturerObjects]\n1=0x2000\n2=0x2001\n" TYPE);
    assert_true(is_noted("", "lists name other objects"));
}

/* 2010h:0 is their number; 2 has a default of its own, what stands twice counts once. */
static void compact_arrays_are_read(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE "[2010]\nObjectType=8\nDataType=6\nAccessType=rw\nDefaultValue=7\n"
                             "PDOMapping=1\nLowLimit=1\nHighLimit=100\nCompactSubObj=20\n"
                             "[2010Value]\nNrOfEntries=3\n2=9\n2=11\n300=5\n17=500\nx=1\n");
    assert_int_equal(co_rig_get(&rig.co, 0x2010, 0), 20);
    assert_int_equal(co_rig_get(&rig.co, 0x2010, 1), 7);
    assert_int_equal(co_rig_write(&rig.co, 0x2010, 3, 101, 2), DG_CO_RANGE);
    assert_int_equal(co_rig_get(&rig.co, 0x2010, 20), 7);
    assert_true(is_noted("2010sub11", "outside of its limits"));
}

/* A mapped entry of an array can be in a TPDO. */
static void compact_arrays_may_be_mapped(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE "[1800]\nObjectType=9\n[1800sub1]\nDataType=7\nAccessType=rw\n"
                             "DefaultValue=$NODEID+0x80000180\n"
                             "[1a00]\nObjectType=9\n[1a00sub0]\nDataType=5\nAccessType=rw\n"
                             "DefaultValue=0\n[1a00sub1]\nDataType=7\nAccessType=rw\n"
                             "[2010]\nObjectType=8\nDataType=6\nAccessType=rw\nPDOMapping=1\n"
                             "CompactSubObj=2\n[2011]\nObjectType=8\nDataType=6\nAccessType=rw\n"
                             "CompactSubObj=2\n");
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 1, 0x20100110, 4), 0);
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 1, 0x20110110, 4), DG_CO_NOT_MAPPABLE);
}

/* ParameterValue of a DCF is what the node has, also beside a value of the array. */
static void values_of_a_dcf_win(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE "[2010]\nObjectType=8\nSubNumber=2\n"
                             "[2010sub1]\nDataType=6\nAccessType=rw\nParameterValue=4\n"
                             "DefaultValue=1\n[2010sub2]\nDataType=6\nAccessType=rw\n"
                             "DefaultValue=1\n[2010Value]\n1=9\n2=9\n");
    assert_int_equal(co_rig_get(&rig.co, 0x2010, 1), 4);
    assert_int_equal(co_rig_get(&rig.co, 0x2010, 2), 9);
}

/* A DOMAIN is told as a text; an object of no type is none, and an array none of its own. */
static void kinds_of_objects_are_told_apart(void **state)
{
    uint32_t value;
    (void)state;
    eds_rig_start(&rig, TYPE "[2000]\nObjectType=2\nDataType=0x0F\nAccessType=ro\n"
                             "[2001]\nObjectType=9\nDataType=7\n[2002]\nAccessType=ro\n"
                             "[2003]\nDataType=5\nAccessType=ro\nDefaultValue=1\n");
    assert_int_not_equal(co_rig_read(&rig.co, 0x2001, 0, &value), 0);
    assert_int_not_equal(co_rig_read(&rig.co, 0x2002, 0, &value), 0);
    assert_int_equal(co_rig_get(&rig.co, 0x2003, 0), 1);
}

/* ------------------------------------------------------------ limits */

static void limits_of_a_type_with_a_sign_have_one(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE "[2000]\nDataType=3\nAccessType=rw\nDefaultValue=0\nLowLimit=-5\n"
                             "HighLimit=5\n[2001]\nDataType=2\nAccessType=rw\nDefaultValue=-9\n"
                             "LowLimit=-5\n[2002]\nDataType=2\nAccessType=rw\nDefaultValue=9\n"
                             "HighLimit=5\n");
    assert_int_equal(co_rig_write(&rig.co, 0x2000, 0, 6, 2), DG_CO_RANGE);
    assert_int_equal(co_rig_write(&rig.co, 0x2000, 0, 0xFFFA, 2), DG_CO_RANGE);
    assert_int_equal(co_rig_write(&rig.co, 0x2000, 0, 0xFFFB, 2), 0);
    assert_true(is_noted("2001", "outside of its limits"));
    assert_true(is_noted("2002", "outside of its limits"));
    assert_int_equal(co_rig_write(&rig.co, 0x2002, 0, 100, 1), 0);
}

/* The default goes with the node-ID: it has to fit with each of them; limits that go are none. */
static void limits_hold_for_every_node_id(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE "[2000]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x180\n"
                             "HighLimit=0x1C0\n[2001]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
                             "LowLimit=$NODEID\n[2002]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
                             "HighLimit=$NODEID\n[2003]\nDataType=7\nAccessType=rw\n"
                             "DefaultValue=$NODEID+0x180\nLowLimit=0x181\nHighLimit=0x1FF\n");
    assert_true(is_noted("2000", "outside of its limits"));
    assert_int_equal(co_rig_write(&rig.co, 0x2000, 0, 0x1FF, 4), 0);
    assert_int_equal(co_rig_write(&rig.co, 0x2001, 0, 0, 4), 0);
    assert_int_equal(co_rig_write(&rig.co, 0x2002, 0, 1000, 4), 0);
    assert_int_equal(co_rig_get(&rig.co, 0x2003, 0), 0x180u + EDS_RIG_NODE);
    assert_int_equal(co_rig_write(&rig.co, 0x2003, 0, 0x180, 4), DG_CO_RANGE);
}

/* ------------------------------------------------------------ figures */

static void figures_of_a_singleturn(void **state)
{
    (void)state;
    eds_rig_read_text(
        &rig, "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x10196\n" CONSTANT("6501", "8192"));
    assert_int_equal(rig.file.turns, 1);
    assert_false(is_noted("6501", ""));
    assert_string_equal(rig.file.device.resolution, "8192 steps, singleturn");
    eds_rig_read_text(&rig, TYPE CONSTANT("6501", "8192"));
    assert_int_equal(rig.file.turns, 4096);
    assert_true(is_noted("6501", "without a default"));
}

/* What a master could change, or what is a text, is no figure of the disc. */
static void figures_are_constant_numbers(void **state)
{
    (void)state;
    eds_rig_read_text(
        &rig, TYPE "[6501]\nDataType=7\nAccessType=rw\nDefaultValue=8192\n" CONSTANT("6502", "16"));
    assert_int_equal(rig.file.steps, 65536);
    assert_int_equal(rig.file.turns, 16);
    eds_rig_read_text(
        &rig, TYPE "[6501]\nDataType=9\nAccessType=ro\nDefaultValue=8192\n" CONSTANT("6502", "16"));
    assert_int_equal(rig.file.steps, 65536);
}

static void more_than_32_bits_have_fewer_turns(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, TYPE CONSTANT("6501", "0x1000000") CONSTANT("6502", "4096"));
    assert_int_equal(rig.file.turns, 256);
    assert_true(is_noted("6501", "beyond 2^32"));
}

static void a_name_has_letters_that_names_have(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, "[DeviceInfo]\nProductName=Ab~{x}_9 (\xC3\xA4)\n" TYPE);
    assert_string_equal(rig.file.device.name, "ab--x-_9-----");
    eds_rig_read_text(&rig, "[DeviceInfo]\n"
                            "ProductName=0123456789012345678901234567890123456789\n" TYPE);
    assert_string_equal(rig.file.device.name, "01234567890123456789012345678901");
    eds_rig_read_text(&rig, TYPE);
    assert_string_equal(rig.file.device.name, "eds");
}

#define KUEBLER IDENTITY("0x13", "0x56682001")

/* The identity of an f3668 with other figures is a mistake; of another type it is another one. */
static void the_identity_of_an_f3668_has_its_figures(void **state)
{
    static const char other[] = TYPE KUEBLER CONSTANT("6501", "8192") CONSTANT("6502", "4096");
    struct dg_eds_setup setup = {.size = sizeof setup, .text = other, .n = sizeof other - 1u};
    (void)state;
    assert_int_equal(eds_rig_read(&rig, other, sizeof other - 1u, sizeof rig.memory),
                     DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.right, "65536 steps, and 4096 turns or one");
    setup.memory = rig.memory;
    setup.memory_size = sizeof rig.memory;
    assert_int_equal(dg_cia406_read(&rig.file, &setup, NULL), DG_ERR_ARGUMENT);
    eds_rig_read_text(&rig,
                      "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x30196\n" KUEBLER CONSTANT(
                          "6501", "8192") CONSTANT("6502", "4096"));
    assert_int_equal(rig.file.steps, 8192);
}

/* ------------------------------------------------------------ bit rates */

static void the_lowest_rate_of_the_file_is_the_delivered_one(void **state)
{
    static const uint16_t rates[] = {10, 20, 50, 100, 125, 250, 500, 800, 1000};
    char text[256];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rates); i++) {
        (void)snprintf(text, sizeof text, "[DeviceInfo]\nBaudRate_%u=1\n" TYPE, rates[i]);
        eds_rig_start(&rig, text);
        assert_int_equal(rig.co.kbaud, rates[i]);
    }
    eds_rig_start(&rig, "[DeviceInfo]\nBaudRate_20=0\nBaudRate_1000=1\nBaudRate_50=1\n" TYPE);
    assert_int_equal(rig.co.kbaud, 50);
    eds_rig_start(&rig, "[DeviceInfo]\nBaudRate_500=1\n[DeviceComissioning]\nBaudrate=800\n" TYPE);
    assert_int_equal(rig.co.kbaud, 800);
    eds_rig_start(&rig, "[DeviceInfo]\nBaudRate_20=1\n[DeviceComissioning]\nBaudrate=1000\n" TYPE);
    assert_int_equal(rig.co.kbaud, 1000);
}

/* ------------------------------------------------------------ hosts */

static void nobody_has_to_hear_what_is_wrong(void **state)
{
    static const char text[] = TYPE "junk\n[2000]\nDataType=99\n";
    struct dg_eds_setup setup = {
        .size = sizeof setup, .text = text, .n = sizeof text - 1u, .memory = rig.memory};
    (void)state;
    setup.memory_size = sizeof rig.memory;
    assert_int_equal(dg_cia406_read(&rig.file, &setup, NULL), DG_OK);
    setup.n = 0;
    assert_int_equal(dg_cia406_read(&rig.file, &setup, NULL), DG_ERR_ARGUMENT);
}

static void a_setup_that_is_none_is_refused(void **state)
{
    struct dg_eds_setup setup = {.size = sizeof setup - 1u, .text = TYPE, .n = sizeof TYPE - 1u};
    (void)state;
    assert_int_equal(dg_cia406_read(&rig.file, &setup, &rig.error), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "not a setup of this version");
    setup.size = sizeof setup;
    assert_int_equal(dg_cia406_read(&rig.file, &setup, &rig.error), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "not a setup of this version");
}

static void more_sub_indices_than_there_can_be_are_refused(void **state)
{
    static char text[65536];
    size_t n = 0;
    (void)state;
    for (unsigned i = 0; i < 70; i++) {
        n +=
            (size_t)snprintf(text + n, sizeof text - n,
                             "[%04X]\nDataType=5\nAccessType=ro\nCompactSubObj=254\n", 0x2000u + i);
    }
    assert_int_equal(eds_rig_read(&rig, text, n, sizeof rig.memory), DG_ERR_ARGUMENT);
    assert_string_equal(rig.error.what, "too many objects");
}

/* A section and a key that are longer than a note has room for are cut off. */
static void notes_have_the_beginning_of_long_words(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, TYPE "[2000]\nDataType=5\nAccessType="
                                 "sometimes_and_never_at_night_or_on_sundays_or_on_holidays\n");
    assert_true(is_noted("2000", "no access"));
    for (size_t i = 0; i < rig.note_count; i++) {
        if (strcmp(rig.notes[i].what, "no access: read only") == 0) {
            assert_string_equal(rig.notes[i].value,
                                "sometimes_and_never_at_night_or_on_sundays_or_o");
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_come_in_many_forms),
        cmocka_unit_test(what_is_no_number_is_left_out),
        cmocka_unit_test(a_number_beyond_its_key_is_left_out),
        cmocka_unit_test(an_identity_may_be_in_the_head_only),
        cmocka_unit_test(words_may_have_something_behind_them),
        cmocka_unit_test(comments_and_sections_of_tools_are_left_alone),
        cmocka_unit_test(both_spellings_of_commissioning_count),
        cmocka_unit_test(lists_count_what_they_name),
        cmocka_unit_test(compact_arrays_are_read),
        cmocka_unit_test(compact_arrays_may_be_mapped),
        cmocka_unit_test(values_of_a_dcf_win),
        cmocka_unit_test(kinds_of_objects_are_told_apart),
        cmocka_unit_test(limits_of_a_type_with_a_sign_have_one),
        cmocka_unit_test(limits_hold_for_every_node_id),
        cmocka_unit_test(figures_of_a_singleturn),
        cmocka_unit_test(figures_are_constant_numbers),
        cmocka_unit_test(more_than_32_bits_have_fewer_turns),
        cmocka_unit_test(a_name_has_letters_that_names_have),
        cmocka_unit_test(the_identity_of_an_f3668_has_its_figures),
        cmocka_unit_test(the_lowest_rate_of_the_file_is_the_delivered_one),
        cmocka_unit_test(nobody_has_to_hear_what_is_wrong),
        cmocka_unit_test(a_setup_that_is_none_is_refused),
        cmocka_unit_test(more_sub_indices_than_there_can_be_are_refused),
        cmocka_unit_test(notes_have_the_beginning_of_long_words),
    };
    return cmocka_run_group_tests_name("eds_written", tests, NULL, NULL);
}

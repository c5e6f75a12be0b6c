/* SPDX-License-Identifier: MIT */
/*
 * What is noted of an EDS file, and what its objects do.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "drehgeber/model.h"
#include "eds_client.h"

static struct eds_client rig;

static void read_text(const char *text)
{
    assert_int_equal(eds_client_read(&rig, text, strlen(text)), DG_OK);
}

/* Nothing vanishes without a word: a slip of the pen is an object less. */
static void what_is_left_out_is_noted(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\n"
              "[100Z]\n[1018subX]\n[2005sub1FF]\n[200\n[20050]\n[2000]\nParameterName=lost\n"
              "[2001]\nObjectType=0x33\n[2002]\nObjectType=9\n[2003Value]\n1=3\n");
    assert_true(eds_client_noted(&rig, "100Z", "is no section of an object"));
    assert_true(eds_client_noted(&rig, "1018subX", "is no section of an object"));
    assert_true(eds_client_noted(&rig, "2005sub1FF", "is no section of an object"));
    assert_true(eds_client_noted(&rig, "20050", "is no section of an object"));
    assert_true(eds_client_noted(&rig, "200", "has no ']'"));
    assert_true(eds_client_noted(&rig, "2000", "is missing: left out"));
    assert_true(eds_client_noted(&rig, "2001", "is none: left out"));
    assert_true(eds_client_noted(&rig, "2002", "has no sub-index: left out"));
    assert_true(eds_client_noted(&rig, "2003sub1", "a default of no sub-index: left out"));
    /* What files have besides, and heads of arrays whose type nobody says. */
    read_text(
        "[FileInfo]\n[DummyUsage]\nDummy0001=0\n[Comments]\nLines=0\n[ToolInfos]\n[M1ModuleInfo]\n"
        "[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\n"
        "[2000]\nParameterName=Array\n[2000sub1]\nDataType=5\nAccessType=rw\n"
        "[2000Name]\n[2000Denotation]\n[2000ObjectLinks]\n[0005]\nObjectType=7\nDataType=5\nAccessType=ro\n"
        "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=8\n");
    assert_int_equal(rig.notes, 0);
}

/* Where it stands: empty lines and comments count, too. */
static void a_note_says_where_it_stands(void **state)
{
    (void)state;
    read_text("; a comment\n\n[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\n"
              "[2001]\n\nObjectType=0x33\n"
              "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=8\n");
    assert_int_equal(rig.notes, 1);
    assert_int_equal(rig.kept[0].line, 7);
    assert_string_equal(rig.kept[0].section, "2001");
    assert_string_equal(rig.kept[0].key, "ObjectType");
}

/* The model itself lies in the memory, before anything of the file. */
static void a_model_needs_room_for_itself(void **state)
{
    static const char text[] = "[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\n";
    static const size_t sizes[] = {0, 1, sizeof(struct dg_cia406_file)};
    const struct dg_model_file *kind = dg_model_file_of("own.eds");
    struct dg_model_made made;
    struct dg_model_flaw flaw;

    (void)state;
    assert_non_null(kind);
    for (size_t i = 0; i < DG_COUNT(sizes); i++) {
        const struct dg_model_source from = {text, sizeof text - 1u, rig.memory, sizes[i]};
        assert_int_equal(kind->read(&from, &made, &flaw), DG_ERR_SPACE);
        assert_null(made.device);
    }
}

/* Without a word about access a master reads it. */
static void an_object_without_access_is_read_only(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\n"
              "[2000]\nDataType=5\nDefaultValue=7\n"
              "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n");
    assert_true(eds_client_noted(&rig, "2000", "is missing: read only"));
    eds_client_make(&rig);
    eds_client_switch_on(&rig);
    assert_int_equal(eds_client_upload(&rig, 0x2000, 0), 7);
    assert_int_equal(eds_client_download(&rig, 0x2000, 0, 5, 1), 0x06010002);
}

/* What the encoder finds out by itself nobody writes, whatever the file says. */
static void a_position_is_read_only(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nDefaultValue=0x10196\nAccessType=ro\n"
              "[6004]\nDataType=7\nAccessType=rw\n"
              "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n");
    assert_true(eds_client_noted(&rig, "6004", "read only"));
    assert_true(rig.lacks == 1);
    eds_client_make(&rig);
    eds_client_switch_on(&rig);
    assert_int_equal(eds_client_download(&rig, 0x6004, 0, 5, 4), 0x06010002);
}

static enum dg_co_role role_of(uint16_t index, uint8_t sub)
{
    const struct dg_co_dictionary *dictionary = &rig.file.file.device.dictionary;

    for (uint16_t i = 0; i < dictionary->count; i++) {
        if ((dictionary->rows[i].key & 0xFFFFFF00u) == DG_CO_KEY(index, sub)) {
            return dg_co_role_of(&rig.file.file, i);
        }
    }
    fail_msg("%04Xh:%u is not there", index, sub);
    return DG_CO_ROLE_COUNT;
}

static void what_an_object_does_can_be_asked(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020196\n"
              "[1001]\nDataType=5\nAccessType=ro\n[1008]\nDataType=9\nAccessType=const\n"
              "[1017]\nDataType=6\nAccessType=rw\n"
              "[1200sub1]\nDataType=7\nAccessType=ro\nDefaultValue=0x600+$NODEID\n"
              "[1800sub1]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x180\n"
              "[2000]\nDataType=5\nAccessType=rw\n"
              "[2010]\nObjectType=8\nDataType=6\nAccessType=rw\nCompactSubObj=4\n"
              "[2021]\nDataType=0x0F\nAccessType=ro\n[6004]\nDataType=7\nAccessType=ro\n"
              "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=16384\n");
    assert_int_equal(role_of(0x1000, 0), DG_CO_CONSTANT);
    assert_int_equal(role_of(0x1001, 0), DG_CO_SIMULATED);
    assert_int_equal(role_of(0x1008, 0), DG_CO_CONSTANT);
    assert_int_equal(role_of(0x1017, 0), DG_CO_SIMULATED);
    assert_int_equal(role_of(0x1200, 1), DG_CO_CONSTANT);
    assert_int_equal(role_of(0x1800, 1), DG_CO_SIMULATED);
    assert_int_equal(role_of(0x2000, 0), DG_CO_STORES);
    assert_int_equal(role_of(0x2010, 3), DG_CO_STORES);
    assert_int_equal(role_of(0x2021, 0), DG_CO_CONSTANT);
    assert_int_equal(role_of(0x6004, 0), DG_CO_SIMULATED);
    assert_int_equal(role_of(0x6501, 0), DG_CO_CONSTANT);
}

/* Of values of more than 32 bits, of 64 that the encoder itself has, and of another profile. */
static void what_a_long_value_does_can_be_asked(void **state)
{
    (void)state;
    read_text("[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020196\n"
              "[2000]\nDataType=0x1B\nAccessType=rw\n[2001]\nDataType=0x1B\nAccessType=ro\n"
              "[2002]\nDataType=0x09\nAccessType=rw\n"
              "[6003]\nDataType=7\nAccessType=rw\n"
              "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=16384\n");
    assert_int_equal(role_of(0x2000, 0), DG_CO_STORES);
    assert_int_equal(role_of(0x2001, 0), DG_CO_CONSTANT);
    assert_int_equal(role_of(0x2002, 0), DG_CO_STORES);
    assert_int_equal(role_of(0x6003, 0), DG_CO_SIMULATED);
    read_text("[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x00020191\n"
              "[6003]\nDataType=7\nAccessType=rw\n[6004]\nDataType=7\nAccessType=rw\n");
    assert_int_equal(role_of(0x6003, 0), DG_CO_STORES);
}

/* As `[section] key=value`, of which each may be missing. */
static void a_place_is_said(void **state)
{
    static const struct {
        struct dg_eds_note note;
        const char *said;
    } rows[] = {
        {{.section = "", .key = "", .value = ""}, ""},
        {{.section = "2000", .key = "", .value = ""}, "[2000]"},
        {{.section = "", .key = "x", .value = ""}, "x"},
        {{.section = "", .key = "x", .value = "1"}, "x=1"},
        {{.section = "2000", .key = "x", .value = ""}, "[2000] x"},
        {{.section = "2000", .key = "x", .value = "1"}, "[2000] x=1"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        char text[64];
        struct dg_text to = dg_text_in(text, sizeof text);
        dg_co_say_place(&rows[i].note, &to);
        assert_string_equal(text, rows[i].said);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_left_out_is_noted),
        cmocka_unit_test(a_note_says_where_it_stands),
        cmocka_unit_test(a_model_needs_room_for_itself),
        cmocka_unit_test(an_object_without_access_is_read_only),
        cmocka_unit_test(a_position_is_read_only),
        cmocka_unit_test(what_an_object_does_can_be_asked),
        cmocka_unit_test(what_a_long_value_does_can_be_asked),
        cmocka_unit_test(a_place_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

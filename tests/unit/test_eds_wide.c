/* SPDX-License-Identifier: MIT */
/*
 * Objects of 64 bits of an EDS file in TPDOs, and those of the encoder profile: 6008h and 6009h.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "eds_rig.h"

#define ASK 0x63F
#define ANSWER 0x5BF
#define ZEROS " 00 00 00 00"
#define SYNC 0x080
#define START 0x01

#define HEAD                                                                                       \
    "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"                                    \
    "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n"                                       \
    "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=4096\n"                                       \
    "[6003]\nDataType=7\nAccessType=rw\n[6004]\nDataType=7\nAccessType=ro\nPDOMapping=1\n"
#define WIDE                                                                                       \
    "[2110]\nDataType=0x1B\nAccessType=rw\nPDOMapping=1\nDefaultValue=0x1122334455667788\n"        \
    "[2111]\nDataType=0x1B\nAccessType=rw\nDefaultValue=1\n"                                       \
    "[2112]\nDataType=0x14\nAccessType=rw\nPDOMapping=1\n"                                         \
    "[2113]\nDataType=0x5\nAccessType=ro\nPDOMapping=1\nDefaultValue=7\n"                          \
    "[2114]\nDataType=0x1B\nAccessType=rw\nPDOMapping=1\nDefaultValue=0x12345678ABCD\n"            \
    "[6008]\nDataType=0x1B\nAccessType=ro\nPDOMapping=1\n[6009]\nDataType=0x1B\nAccessType=rw\n"
#define TPDO(n, cob, count, first, second)                                                         \
    "[180" n "sub1]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+" cob "\n"                    \
    "[180" n "sub2]\nDataType=5\nAccessType=rw\nDefaultValue=1\n"                                  \
    "[1A0" n "sub0]\nDataType=5\nAccessType=rw\nDefaultValue=" count "\n"                          \
    "[1A0" n "sub1]\nDataType=7\nAccessType=rw\nDefaultValue=" first "\n"                          \
    "[1A0" n "sub2]\nDataType=7\nAccessType=rw\nDefaultValue=" second "\n"

static struct eds_rig rig;

static void start_node(const char *text)
{
    eds_rig_start(&rig, text);
}

static void ask(const char *request, const char *answer)
{
    co_rig_forget(&rig.co);
    co_rig_rx(&rig.co, ASK, request);
    co_rig_expect_count(&rig.co, 1);
    co_rig_expect(&rig.co, 0, ANSWER, answer);
}

static void synchronise(void)
{
    co_rig_forget(&rig.co);
    co_rig_rx(&rig.co, SYNC, "");
}

/* ------------------------------------------------------------ mapping */

/* TPDO2 has half of a number in front of another value, as the WDGA's file has it. Such a number is
 * in no TPDO as a whole. */
static void a_tpdo_has_all_of_a_number_or_half(void **state)
{
    (void)state;
    start_node(HEAD WIDE TPDO("0", "0x180", "1", "0x21100040", "0")
                   TPDO("1", "0x280", "2", "0x21140020", "0x21130008"));
    assert_int_equal(rig.note_count, 0);
    co_rig_nmt(&rig.co, START);
    synchronise();
    co_rig_expect_count(&rig.co, 2);
    co_rig_expect(&rig.co, 0, 0x1BF, "88 77 66 55 44 33 22 11");
    co_rig_expect(&rig.co, 1, 0x2BF, "CD AB 78 56 07");
    ask("21 10 21 00 08 00 00 00", "60 10 21 00" ZEROS);
    ask("00 01 02 03 04 05 06 07", "20 00 00 00" ZEROS);
    ask("1D 08 00 00" ZEROS, "30 00 00 00" ZEROS);
    ask("40 10 21 00", "41 10 21 00 08 00 00 00");
    ask("60", "00 01 02 03 04 05 06 07");
    synchronise();
    co_rig_expect(&rig.co, 0, 0x1BF, "01 02 03 04 05 06 07 08");
    co_rig_expect(&rig.co, 1, 0x2BF, "CD AB 78 56 07");
    ask("40 14 21 00", "41 14 21 00 08 00 00 00");
    ask("60", "00 CD AB 78 56 34 12 00");
}

static void what_cannot_be_mapped_is_refused(void **state)
{
    (void)state;
    start_node(HEAD WIDE TPDO("0", "0x180", "0", "0", "0"));
    co_rig_put(&rig.co, 0x1800, 1, 0x800001BF, 4);
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 1, 0x21110040, 4), 0x06040041);
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 1, 0x21120038, 4), 0x06040041);
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 1, 0x21100038, 4), 0x06040043);
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 1, 0x60040040, 4), 0x06040043);
    co_rig_put(&rig.co, 0x1A00, 1, 0x21100040, 4);
    co_rig_put(&rig.co, 0x1A00, 2, 0x21130008, 4);
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 0, 2, 1), 0x06040042);
    co_rig_put(&rig.co, 0x1A00, 0, 1, 1);
    co_rig_put(&rig.co, 0x1800, 1, 0x1BF, 4);
}

/* Seven bytes and then 64 bits: nine rows, which are more than a TPDO has. */
static void a_number_behind_seven_bytes_does_not_fit(void **state)
{
    (void)state;
    start_node(HEAD WIDE "[1800sub1]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x80000180\n"
                         "[1A00]\nObjectType=9\nDataType=7\nAccessType=rw\nCompactSubObj=8\n"
                         "[1A00sub0]\nDataType=5\nAccessType=rw\nDefaultValue=0\n");
    for (uint8_t sub = 1; sub <= 7; sub++) {
        co_rig_put(&rig.co, 0x1A00, sub, 0x21130008, 4);
    }
    co_rig_put(&rig.co, 0x1A00, 8, 0x21100040, 4);
    assert_int_equal(co_rig_write(&rig.co, 0x1A00, 0, 8, 1), 0x06040042);
    co_rig_put(&rig.co, 0x1A00, 0, 7, 1);
}

/* ------------------------------------------------------------ 6008h, 6009h */

static void the_position_has_64_bits(void **state)
{
    (void)state;
    start_node(HEAD WIDE TPDO("0", "0x180", "1", "0x60080040", "0"));
    ask("21 09 60 00 08 00 00 00", "60 09 60 00" ZEROS);
    ask("00 34 12 00 00 00 00 00", "20 00 00 00" ZEROS);
    ask("1D 00 00 00" ZEROS, "30 00 00 00" ZEROS);
    assert_int_equal(co_rig_get(&rig.co, 0x6004, 0), 0x1234);
    assert_int_equal(co_rig_get(&rig.co, 0x6003, 0), 0x1234);
    ask("40 12 21 00", "41 12 21 00 07 00 00 00"); /* a shorter one before it */
    ask("60", "01 00 00 00" ZEROS);
    ask("40 08 60 00", "41 08 60 00 08 00 00 00");
    ask("60", "00 34 12 00 00 00 00 00");
    ask("70", "1D 00 00 00" ZEROS);
    ask("40 09 60 00", "41 09 60 00 08 00 00 00");
    ask("60", "00 34 12 00 00 00 00 00");
    co_rig_put(&rig.co, 0x6003, 0, 0x77, 4);
    co_rig_nmt(&rig.co, START);
    synchronise();
    co_rig_expect(&rig.co, 0, 0x1BF, "77 00 00 00 00 00 00 00");
    ask("21 08 60 00 08 00 00 00", "80 08 60 00 02 00 01 06");
}

/* 4096 steps and turns: 1000000h is the first that is none. */
static void a_preset_beyond_the_range_is_refused(void **state)
{
    (void)state;
    start_node(HEAD WIDE);
    ask("21 09 60 00 08 00 00 00", "60 09 60 00" ZEROS);
    ask("00 05 00 00 00 01 00 00", "20 00 00 00" ZEROS);
    ask("1D 00 00 00" ZEROS, "80 09 60 00 30 00 09 06"); /* 2^32 + 5 */
    ask("21 09 60 00 08 00 00 00", "60 09 60 00" ZEROS);
    ask("00 00 00 00 01 00 00 00", "20 00 00 00" ZEROS);
    ask("1D 00 00 00" ZEROS, "80 09 60 00 30 00 09 06");
    assert_int_equal(co_rig_get(&rig.co, 0x6003, 0), 0);
}

static void another_type_is_a_value_only(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, HEAD "[6008]\nDataType=7\nAccessType=ro\n"
                                 "[6009]\nDataType=0x11\nAccessType=rw\n"
                                 "[6030sub1]\nDataType=0x1B\nAccessType=ro\n");
    assert_true(eds_rig_is_noted(&rig, "6008", "a value only"));
    assert_true(eds_rig_is_noted(&rig, "6009", "a value only"));
    assert_true(eds_rig_is_noted(&rig, "6030sub1", "a value only"));
    eds_rig_read_text(&rig, HEAD "[6008]\nDataType=0x1B\nAccessType=rw\n");
    assert_true(eds_rig_is_noted(&rig, "6008", "read only"));
}

static bool is_long(const struct dg_co_file *file, uint32_t key)
{
    bool found = false;

    for (uint16_t i = 0; i < file->long_count; i++) {
        found = found || file->longs[i].key == (key & 0xFFFFFF00u);
    }
    return found;
}

/* Whoever writes rows down sees that these are no texts of the stack, nor its numbers. */
static void their_rows_have_a_hook_of_their_own(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, HEAD WIDE "[2120]\nDataType=9\nAccessType=rw\n");
    const struct dg_co_file *file = &rig.file.file;
    const struct dg_co_row *rows = file->device.dictionary.rows;
    uint8_t hook = 0;

    for (uint16_t i = 0; i < file->device.dictionary.count; i++) {
        if (is_long(file, rows[i].key)) {
            assert_true(rows[i].hook != 0 && (hook == 0 || hook == rows[i].hook));
            hook = rows[i].hook;
        }
    }
    for (uint16_t i = 0; i < file->device.dictionary.count; i++) {
        assert_true((rows[i].hook == hook) == is_long(file, rows[i].key));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tpdo_has_all_of_a_number_or_half),
        cmocka_unit_test(what_cannot_be_mapped_is_refused),
        cmocka_unit_test(a_number_behind_seven_bytes_does_not_fit),
        cmocka_unit_test(the_position_has_64_bits),
        cmocka_unit_test(a_preset_beyond_the_range_is_refused),
        cmocka_unit_test(another_type_is_a_value_only),
        cmocka_unit_test(their_rows_have_a_hook_of_their_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

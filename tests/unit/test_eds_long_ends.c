/* SPDX-License-Identifier: MIT */
/*
 * Values of an EDS file that 32 bits do not hold, where they end: transfers that cannot be, segments
 * out of place, limits and defaults. The frames are written by hand from the formats of CiA 301.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "co_file.h"
#include "drehgeber/bits.h"
#include "eds_rig.h"

#define ASK 0x63F
#define ANSWER 0x5BF
#define TEXT "64 72 65 68 67 65 62" /* "drehgeb" */
#define ZEROS " 00 00 00 00"
#define LONG_MAX_BYTES 1024u
#define SEGMENT 7u
#define SAVE 0x65766173u

static const char file[] =
    "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
    "[1010]\nObjectType=8\n[1010sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
    "[1011]\nObjectType=8\n[1011sub1]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"
    "[2100]\nDataType=9\nAccessType=rw\nDefaultValue=hello\n"
    "[2101]\nDataType=0x0F\nAccessType=rw\n"
    "[2102]\nDataType=0x0A\nAccessType=ro\nDefaultValue=01 02 FF 00 A5\n"
    "[2104]\nDataType=0x1B\nAccessType=rw\nDefaultValue=0x0123456789ABCDEF\n"
    "HighLimit=0x7FFFFFFFFFFFFFFF\n"
    "[2105]\nDataType=0x15\nAccessType=rw\nDefaultValue=-2\nLowLimit=-10\nHighLimit=10\n"
    "[2106]\nDataType=0x0F\nAccessType=wo\n"
    "[2107]\nDataType=0x16\nAccessType=rw\nDefaultValue=0x123456\n"
    "[2108]\nDataType=0x11\nAccessType=ro\nDefaultValue=0x3FF8000000000000\n"
    "[2109]\nDataType=0x10\nAccessType=ro\nDefaultValue=-3\n"
    "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=4096\n"
    "[6502]\nDataType=6\nAccessType=ro\nDefaultValue=4096\n";

static struct eds_rig rig;

static void start_node(void)
{
    eds_rig_start(&rig, file);
}

/* A request, and the one answer that it has at once; "": none. */
static void ask(const char *request, const char *answer)
{
    co_rig_forget(&rig.co);
    co_rig_rx(&rig.co, ASK, request);
    co_rig_expect_count(&rig.co, answer[0] != '\0' ? 1 : 0);
    if (answer[0] != '\0') {
        co_rig_expect(&rig.co, 0, ANSWER, answer);
    }
}

/* The server waits for a second: for each segment anew, and for nothing once a value is there. */
static void each_segment_has_its_own_second(void **state)
{
    static const char *const answers[] = {"20" ZEROS " 00 00 00", "30" ZEROS " 00 00 00"};
    static const char *const segments[] = {"00 " TEXT, "10 " TEXT};
    (void)state;
    start_node();
    ask("21 01 21 00 15 00 00 00", "60 01 21 00" ZEROS);
    for (size_t i = 0; i < DG_COUNT(segments); i++) {
        co_rig_run(&rig.co, DG_MS(900));
        ask(segments[i], answers[i]);
    }
    co_rig_run(&rig.co, DG_MS(900));
    ask("01 " TEXT, answers[0]);
    co_rig_forget(&rig.co);
    co_rig_run(&rig.co, DG_S(3));
    co_rig_expect_count(&rig.co, 0);
    ask("40 01 21 00", "41 01 21 00 15 00 00 00");
    co_rig_forget(&rig.co);
    co_rig_run(&rig.co, DG_MS(1001));
    co_rig_expect_count(&rig.co, 1);
    co_rig_expect(&rig.co, 0, ANSWER, "80 01 21 00 00 00 04 05");
}

/* Copies count up to FFFEh, and from 0 on again; FFFFh is that of a memory never written. */
static void the_number_of_a_copy_goes_round(void **state)
{
    const struct dg_store_layout *layout = &rig.file.file.layout;
    (void)state;
    start_node();
    ask("2B 00 21 00 68 69 00 00", "60 00 21 00" ZEROS);
    co_rig_put(&rig.co, 0x1010, 1, SAVE, 4);
    const int region = dg_store_find(layout, "texts");
    assert_true(region >= 0);
    uint8_t *copies = &rig.co.nvm.bytes[dg_store_address(layout, (uint8_t)region)];
    assert_int_equal(dg_load_le16(copies), 0);
    dg_store_le16(copies, 0xFFFE);
    eds_rig_power_cycle(&rig);
    ask("40 00 21 00", "4B 00 21 00 68 69 00 00");
    ask("2B 00 21 00 78 78 00 00", "60 00 21 00" ZEROS);
    co_rig_put(&rig.co, 0x1010, 1, SAVE, 4);
    assert_int_equal(dg_load_le16(&copies[EDS_COPY_HEAD + rig.file.file.long_kept]), 0);
    eds_rig_power_cycle(&rig);
    ask("40 00 21 00", "4B 00 21 00 78 78 00 00");
    dg_store_le16(&copies[EDS_COPY_HEAD + rig.file.file.long_kept], 0xFFFF);
    eds_rig_power_cycle(&rig);
    ask("40 00 21 00", "4B 00 21 00 68 69 00 00");
}

/* Whatever somebody has written into the transfer of a node: the transfer is over, and nothing was written. */
static void a_transfer_that_somebody_has_made_is_over(void **state)
{
    static const struct {
        uint16_t words[4]; /* number, length, announced, done */
        uint8_t step;
    } rows[] = {
        {{99, 0, 9, 0}, 2},     {{1, LONG_MAX_BYTES + SEGMENT, 9, 0}, 2},
        {{1, 0, 0xFFFF, 0}, 2}, {{1, 0, LONG_MAX_BYTES + 1u, 0}, 2},
        {{1, 0, 9, 1}, 2},      {{1, LONG_MAX_BYTES + 2u, 9, LONG_MAX_BYTES + 1u}, 2},
        {{1, 0, 9, 0}, 9},      {{1, 0, 9, 0}, 0xFF},
        {{1, 0, 9, 0}, 1},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        start_node();
        ask("21 00 21 00 09 00 00 00", "60 00 21 00" ZEROS);
        uint8_t *at = (uint8_t *)&rig.co.encoder + rig.file.file.longs_at;
        memcpy(at, rows[i].words, sizeof rows[i].words);
        at[sizeof rows[i].words] = rows[i].step;
        co_rig_forget(&rig.co);
        co_rig_rx(&rig.co, ASK, "00 " TEXT);
        co_rig_expect_count(&rig.co, 1);
        assert_int_equal(rig.co.frame[0].data[0], 0x80);
        assert_int_equal(dg_load_le32(&rig.co.frame[0].data[4]), 0x05040001);
        const struct dg_co_long *text = dg_co_find_long(&rig.file.file, DG_CO_KEY(0x2100, 0));
        assert_memory_equal(dg_co_long_bytes(&rig.co.node) + text->at, "\x05\0hello", 7);
    }
}

/* A length that cannot be is the nearest one that can. */
static void a_stored_length_that_cannot_be_is_not_used(void **state)
{
    static const uint16_t lengths[] = {0, 7, 9, 0xFFFF};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(lengths); i++) {
        start_node();
        const struct dg_co_long *wide = dg_co_find_long(&rig.file.file, DG_CO_KEY(0x2104, 0));
        assert_non_null(wide);
        dg_store_le16(dg_co_long_bytes(&rig.co.node) + wide->at, lengths[i]);
        ask("40 04 21 00", "41 04 21 00 08 00 00 00");
    }
}

static void segments_out_of_place_are_refused(void **state)
{
    (void)state;
    start_node();
    ask("C6 01 21 00 00 04 00 00", "A4 01 21 00 1F 00 00 00");
    ask("00 " TEXT, "80 01 21 00 03 00 04 05"); /* no segment 0 */
    ask("C6 01 21 00 00 04 00 00", "A4 01 21 00 1F 00 00 00");
    ask("20 " TEXT, "80 64 72 65 00 00 02 06"); /* no segment 32: another request */
    ask("C6 01 21 00 07 00 00 00", "A4 01 21 00 1F 00 00 00");
    ask("82 " TEXT, "A2 00 1F 00" ZEROS); /* the last, and segment 1 is not there */
    ask("81 " TEXT, "A2 01 1F 00" ZEROS);
    ask("81 " TEXT, ""); /* twice */
    ask("60 00 00 00" ZEROS, "80 01 21 00 01 00 04 05");
    start_node();
    ask("40 00 21 00", "41 00 21 00 05 00 00 00");
    ask("70", "80 00 21 00 00 00 03 05"); /* toggle */
    ask("40 00 21 00", "41 00 21 00 05 00 00 00");
    ask("A1", "80 00 21 00 01 00 04 05");
}

/* Within a block the server waits for the number behind the last one that it took. */
static void a_segment_that_comes_again_counts_once(void **state)
{
    (void)state;
    start_node();
    ask("C2 01 21 00 0E 00 00 00", "A4 01 21 00 1F 00 00 00");
    ask("01 " TEXT, "");
    ask("01 " TEXT, "");
    ask("82 " TEXT, "A2 02 1F 00" ZEROS);
    ask("C1 00 00 00" ZEROS, "A1 00 00 00" ZEROS);
    ask("40 01 21 00", "41 01 21 00 0E 00 00 00");
}

/* 147 segments are 1029 bytes. */
static void more_than_there_is_room_for_is_refused(void **state)
{
    (void)state;
    start_node();
    ask("20 01 21 00", "60 01 21 00" ZEROS);
    for (unsigned i = 0; i < 146; i++) {
        ask(i % 2u == 0 ? "00 " TEXT : "10 " TEXT,
            i % 2u == 0 ? "20 00 00 00" ZEROS : "30 00 00 00" ZEROS);
    }
    ask("00 " TEXT, "80 01 21 00 12 00 07 06");
    ask("40 01 21 00", "41 01 21 00 00 00 00 00");
}

/* Both ends of both kinds. */
static void wide_limits_have_two_ends(void **state)
{
    static const struct {
        const char *last; /* segment of one byte */
        const char *first;
        uint16_t index;
        bool fits;
    } rows[] = {
        {"1D 00 00 00" ZEROS, "00 04 00 00 00 00 00 00", 0x2200, false},
        {"1D 00 00 00" ZEROS, "00 05 00 00 00 00 00 00", 0x2200, true},
        {"1D 00 00 00" ZEROS, "00 09 00 00 00 00 00 00", 0x2200, true},
        {"1D 00 00 00" ZEROS, "00 0A 00 00 00 00 00 00", 0x2200, false},
        {"1D 80 00 00" ZEROS, "00 05 00 00 00 00 00 00", 0x2200, false},
        {"1D FF 00 00" ZEROS, "00 FC FF FF FF FF FF FF", 0x2201, false},
        {"1D FF 00 00" ZEROS, "00 FD FF FF FF FF FF FF", 0x2201, true},
        {"1D 00 00 00" ZEROS, "00 03 00 00 00 00 00 00", 0x2201, true},
        {"1D 00 00 00" ZEROS, "00 04 00 00 00 00 00 00", 0x2201, false},
    };
    (void)state;
    eds_rig_start(&rig, "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
                        "[2200]\nDataType=0x1B\nAccessType=rw\nDefaultValue=7\n"
                        "LowLimit=5\nHighLimit=9\n"
                        "[2201]\nDataType=0x15\nAccessType=rw\nDefaultValue=0\n"
                        "LowLimit=-3\nHighLimit=3\n");
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const bool first_one = rows[i].index == 0x2200;
        ask(first_one ? "21 00 22 00 08 00 00 00" : "21 01 22 00 08 00 00 00",
            first_one ? "60 00 22 00" ZEROS : "60 01 22 00" ZEROS);
        ask(rows[i].first, "20 00 00 00" ZEROS);
        co_rig_forget(&rig.co);
        co_rig_rx(&rig.co, ASK, rows[i].last);
        assert_int_equal(rig.co.frame[0].data[0], rows[i].fits ? 0x30 : 0x80);
    }
}

/* Digits in twos are bytes, anything else is a text; numbers have the width of their type. */
static void what_a_default_can_be(void **state)
{
    static const struct {
        const char *text;
        const char *note; /* NULL: none */
        uint64_t bytes;   /* of the value, little-endian */
        uint16_t n;
    } rows[] = {
        {"DataType=0x0A\nDefaultValue=aB cd09\n", NULL, 0x09CDAB, 3},
        {"DataType=0x0A\nDefaultValue=0 1\n", NULL, 0x312030, 3},
        {"DataType=0x0A\nDefaultValue=012\n", NULL, 0x323130, 3},
        {"DataType=0x0F\nDefaultValue=01 0g\n", NULL, 0x6730203130, 5},
        {"DataType=0x09\nDefaultValue=0102\n", NULL, 0x32303130, 4},
        {"DataType=0x1B\nDefaultValue=18446744073709551615\n", NULL, UINT64_MAX, 8},
        {"DataType=0x1B\nDefaultValue=18446744073709551616\n", "no number", 0, 8},
        {"DataType=0x1B\nDefaultValue=$NODEID+1\n", "no number", 0, 8},
        {"DataType=0x16\nDefaultValue=0xFFFFFF\n", NULL, 0xFFFFFF, 3},
        {"DataType=0x16\nDefaultValue=0x1000000\n", "no number", 0, 3},
        {"DataType=0x10\nDefaultValue=-8388608\n", NULL, 0xFFFFFFFFFF800000, 3},
        {"DataType=0x10\nDefaultValue=0xFFFFFF\n", NULL, UINT64_MAX, 3},
        {"DataType=0x10\nDefaultValue=-8388609\n", "no number", 0, 3},
        {"DataType=0x1B\nDefaultValue=4\nLowLimit=5\n", "outside of its limits", 4, 8},
        {"DataType=0x1B\nDefaultValue=6\nHighLimit=5\n", "outside of its limits", 6, 8},
        {"DataType=0x15\nDefaultValue=-6\nLowLimit=-5\n", "outside of its limits",
         0xFFFFFFFFFFFFFFFA, 8},
        {"DataType=0x15\nDefaultValue=6\nHighLimit=5\n", "outside of its limits", 6, 8},
    };
    char text[256];
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        (void)snprintf(text, sizeof text,
                       "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
                       "[2300]\nAccessType=rw\n%s",
                       rows[i].text);
        eds_rig_read_text(&rig, text);
        const struct dg_co_long *value = dg_co_find_long(&rig.file.file, DG_CO_KEY(0x2300, 0));
        assert_non_null(value);
        uint8_t bytes[8];
        dg_store_le64(bytes, rows[i].bytes);
        if (value->n != rows[i].n || memcmp(value->initial, bytes, rows[i].n) != 0 ||
            eds_rig_is_noted(&rig, "2300", rows[i].note == NULL ? "" : rows[i].note) !=
                (rows[i].note != NULL)) {
            fail_msg("%s", rows[i].text);
        }
    }
}

/* As many bytes as there is room for; more digits than that are a text, of which the end is left out. */
static void digits_without_end(void **state)
{
    static char text[2200];
    (void)state;
    for (unsigned bytes = DG_EDS_LONG_MAX; bytes <= DG_EDS_LONG_MAX + 1u; bytes++) {
        const int n = snprintf(text, sizeof text,
                               "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
                               "[2300]\nAccessType=rw\nDataType=0x0A\nDefaultValue=");
        memset(&text[n], '5', 2u * bytes);
        memcpy(&text[(size_t)n + 2u * bytes], "\n", 2);
        eds_rig_read_text(&rig, text);
        const struct dg_co_long *value = dg_co_find_long(&rig.file.file, DG_CO_KEY(0x2300, 0));
        assert_non_null(value);
        assert_int_equal(value->n, DG_EDS_LONG_MAX);
        assert_int_equal(value->initial[0], bytes == DG_EDS_LONG_MAX ? 0x55 : '5');
    }
}

/* What stands where the encoder has something of 32 bits, or a text, only stores. */
static void objects_of_the_encoder_keep_their_types(void **state)
{
    (void)state;
    eds_rig_read_text(&rig, "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
                            "[1008]\nDataType=0x1B\nAccessType=ro\n"
                            "[6003]\nDataType=0x1B\nAccessType=rw\n"
                            "[6004]\nDataType=0x0F\nAccessType=rw\n");
    assert_false(eds_rig_is_noted(&rig, "1008", "has not the type"));
    assert_true(eds_rig_is_noted(&rig, "6003", "has not the type"));
    assert_true(eds_rig_is_noted(&rig, "6004", "has not the type"));
    assert_null(dg_co_find_long(&rig.file.file, DG_CO_KEY(0x6003, 0))->bound.row);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_segment_has_its_own_second),
        cmocka_unit_test(the_number_of_a_copy_goes_round),
        cmocka_unit_test(a_transfer_that_somebody_has_made_is_over),
        cmocka_unit_test(a_stored_length_that_cannot_be_is_not_used),
        cmocka_unit_test(segments_out_of_place_are_refused),
        cmocka_unit_test(a_segment_that_comes_again_counts_once),
        cmocka_unit_test(more_than_there_is_room_for_is_refused),
        cmocka_unit_test(wide_limits_have_two_ends),
        cmocka_unit_test(what_a_default_can_be),
        cmocka_unit_test(digits_without_end),
        cmocka_unit_test(objects_of_the_encoder_keep_their_types),
    };
    return cmocka_run_group_tests_name("eds_long_ends", tests, NULL, NULL);
}

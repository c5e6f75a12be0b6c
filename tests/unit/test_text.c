/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/text.h"

static void a_text_grows_up_to_its_end(void **state)
{
    char room[8] = "xxxxxxx";
    struct dg_text text = dg_text_in(room, sizeof room);

    (void)state;
    assert_string_equal(room, "");
    dg_text_add(&text, "abc");
    dg_text_add(&text, "");
    dg_text_add_n(&text, "defg", 2);
    assert_string_equal(room, "abcde");
    assert_int_equal(text.length, 5);
    dg_text_add_n(&text, "f", 9);
    assert_string_equal(room, "abcdef");
    dg_text_add(&text, "gh");
    assert_string_equal(room, "abcdefg");
    dg_text_add(&text, "h");
    assert_int_equal(text.length, 7);
    assert_string_equal(room, "abcdefg");
}

static void a_text_without_room_stays_empty(void **state)
{
    char room[2] = "xx";
    struct dg_text text = dg_text_in(room, 1);

    (void)state;
    dg_text_add(&text, "a");
    assert_int_equal(text.length, 0);
    assert_true(room[0] == '\0' && room[1] == 'x');
}

static void numbers_are_added_as_text(void **state)
{
    static const struct {
        int64_t value;
        const char *decimal;
    } rows[] = {
        {0, "0"},
        {-5, "-5"},
        {65535, "65535"},
        {4294967295, "4294967295"},
        {INT64_MAX, "9223372036854775807"},
        {INT64_MIN, "-9223372036854775808"},
    };
    char room[24];

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_text text = dg_text_in(room, sizeof room);
        dg_text_add_number(&text, rows[i].value);
        assert_string_equal(room, rows[i].decimal);
    }
    struct dg_text text = dg_text_in(room, 8);
    dg_text_add_hex(&text, 0x1A, 1);
    dg_text_add_hex(&text, 0x1A, 4);
    assert_string_equal(room, "A001A");
    dg_text_add_hex(&text, 0xFEDCBA9876543210, 16);
    assert_string_equal(room, "A001AFE");
}

static void a_point_stands_before_its_places(void **state)
{
    char digits[DG_TEXT_DIGITS_MAX];

    (void)state;
    assert_int_equal(dg_text_digits(digits, 12345, true, 3), 7);
    assert_memory_equal(digits, "-12.345", 7);
    assert_int_equal(dg_text_digits(digits, 7, false, 3), 5);
    assert_memory_equal(digits, "0.007", 5);
    assert_int_equal(dg_text_digits(digits, UINT64_MAX, true, 18), 22);
    assert_memory_equal(digits, "-18.446744073709551615", 22);
}

static char dashed(char c)
{
    return c == '_' ? '-' : c;
}

static void texts_are_the_same_to_their_ends(void **state)
{
    (void)state;
    assert_true(dg_text_same("", "", SIZE_MAX, NULL));
    assert_true(dg_text_same("ab", "ab", SIZE_MAX, NULL));
    assert_false(dg_text_same("ab", "abc", SIZE_MAX, NULL));
    assert_false(dg_text_same("abc", "ab", SIZE_MAX, NULL));
    assert_false(dg_text_same("ab", "aB", SIZE_MAX, NULL));
    assert_true(dg_text_same("ab", "abc", 2, NULL));
    assert_false(dg_text_same("ab", "abc", 3, NULL));
    assert_true(dg_text_same("x", "y", 0, NULL));
}

static void characters_may_count_as_others(void **state)
{
    (void)state;
    assert_true(dg_text_same("aZ-1", "Az-1", SIZE_MAX, dg_text_upper));
    assert_false(dg_text_same("a[", "a{", SIZE_MAX, dg_text_upper));
    assert_false(dg_text_same("@", "`", SIZE_MAX, dg_text_upper));
    assert_true(dg_text_same("a_b", "a-b", SIZE_MAX, dashed));
    assert_false(dg_text_same("a_b", "A-b", SIZE_MAX, dashed));
}

static unsigned edits(const char *word, const char *text, bool brief)
{
    return dg_text_edits(word, strlen(word), text, strlen(text), brief);
}

/* Examples that every book has; CA and ABC are 2 apart where a place may change twice, 3 here. */
static void texts_are_compared_by_what_has_to_change(void **state)
{
    (void)state;
    assert_int_equal(edits("kitten", "sitting", false), 3);
    assert_int_equal(edits("saturday", "sunday", false), 3);
    assert_int_equal(edits("help", "hlep", false), 1);
    assert_int_equal(edits("CA", "ABC", false), 3);
    assert_int_equal(edits("", "abc", false), 3);
    assert_int_equal(edits("abc", "", false), 3);
    assert_int_equal(edits("xabc", "abc", false), 1);
    assert_int_equal(edits("Run", "rUN", false), 0);
    assert_int_equal(edits("position", "pos", false), 5);
    assert_int_equal(edits("POSition", "pos", true), 0);
    assert_int_equal(edits("POSition", "posi", true), 0);
    assert_int_equal(edits("POSition", "poss", true), 1);
    assert_int_equal(edits("POSition", "ps", true), 1);
    assert_int_equal(edits("abcdefghijklmnop", "abcdefghijklmnop", false), 0);
    assert_int_equal(edits("abcdefghijklmnop", "abcdefghijklmnopq", false), ~0u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_grows_up_to_its_end),
        cmocka_unit_test(a_text_without_room_stays_empty),
        cmocka_unit_test(numbers_are_added_as_text),
        cmocka_unit_test(a_point_stands_before_its_places),
        cmocka_unit_test(texts_are_the_same_to_their_ends),
        cmocka_unit_test(characters_may_count_as_others),
        cmocka_unit_test(texts_are_compared_by_what_has_to_change),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The engine of settings, with rows of the test's own: how values are written, and what is none.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/hal.h"
#include "drehgeber/key.h"

struct things {
    uint8_t u8;
    uint32_t u32;
    int16_t i16;
    int32_t milli;
    uint64_t span;
    uint8_t colour;
    char text[9];
    char digits[10];
};

static const char *const colours[] = {"red", "green", "blue"};
static char long_text[400];

/* clang-format off */
static const struct dg_key rows[] = {
    {"u8",     "",   offsetof(struct things, u8),     DG_KEY_U8,     0, 1,    0, 255,        NULL,    "a byte"},
    {"u32",    "",   offsetof(struct things, u32),    DG_KEY_U32,    0, 1,    0, UINT32_MAX, NULL,    "a word"},
    {"i16",    "",   offsetof(struct things, i16),    DG_KEY_I16,    0, 1, -273, 1000,       NULL,    "signed"},
    {"milli",  "V",  offsetof(struct things, milli),  DG_KEY_I32,    3, 1, -5000, 5000,      NULL,    "three places"},
    {"span",   "us", offsetof(struct things, span),   DG_KEY_NS,     0, 1000, 0, 250000,     NULL,    "a time"},
    {"colour", "",   offsetof(struct things, colour), DG_KEY_WORD,   0, 1,    0, 2,          colours, "a word of some"},
    {"text",   "",   offsetof(struct things, text),   DG_KEY_TEXT,   0, 1,    2, 8,          NULL,    "characters"},
    {"digits", "",   offsetof(struct things, digits), DG_KEY_DIGITS, 0, 1,    1, 9,          NULL,    "digits"},
};
/* clang-format on */
static const struct dg_keys keys = {rows, DG_COUNT(rows)};

/* What is set is told as `told`. */
static const struct {
    const char *key;
    const char *value;
    const char *told;
} taken[] = {
    {"u8", "0", "0"},
    {"u8", "+255", "255"},
    {"u8", "007", "7"},
    {"u8", "0xfF", "255"},
    {"u8", "FFh", "255"},
    {"u8", "0cH", "12"},
    {"u8", "0X1a", "26"},
    {"u32", "4294967295", "4294967295"},
    {"u32", "0xFFFFFFFF", "4294967295"},
    {"i16", "-273", "-273"},
    {"i16", "1000", "1000"},
    {"milli", "0", "0.000"},
    {"milli", "0.005", "0.005"},
    {"milli", ".25", "0.250"},
    {"milli", "-1.5", "-1.500"},
    {"milli", "5.0000", "5.000"},
    {"milli", "-5.", "-5.000"},
    {"span", "250000", "250000"},
    {"colour", "blue", "blue"},
    {"text", "ab", "ab"},
    {"text", "abcdefgh", "abcdefgh"},
    {"digits", "42", "000000042"},
};

static const struct {
    const char *key;
    const char *value;
} refused[] = {
    {"u8", ""},
    {"u8", "256"},
    {"u8", "-1"},
    {"u8", "1.0.0"},
    {"u8", "1.5"},
    {"u8", "+"},
    {"u8", "x"},
    {"u8", "0x"},
    {"u8", "h"},
    {"u8", "0x0Ah"}, /* one of the two */
    {"u8", "01g1"},
    {"u8", "0z1"},
    {"u8", "12 "},
    {"u32", "4294967296"},
    {"u32", "0x100000000"},
    {"u32", "FFFFFFFFFh"},
    {"u32", "99999999999999999999999999"},
    {"i16", "-274"},
    {"i16", "-0x1"},
    {"milli", "0.0001"},
    {"milli", "5.001"},
    {"milli", "0x1"},
    {"milli", "."},
    {"milli", "1e3"},
    {"milli", "999999999999999999"}, /* too large once it is in thousandths */
    {"span", "250001"},
    {"colour", "Blue"},
    {"colour", "bluee"},
    {"colour", ""},
    {"text", "a"},
    {"text", "abcdefghi"},
    {"text", long_text},
    {"digits", ""},
    {"digits", "12a"},
    {"digits", "1234567890"},
};

static void a_value_is_told_as_it_was_taken(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(taken); i++) {
        const struct dg_key *key = dg_keys_find(&keys, taken[i].key);
        struct things things;
        char told[32];
        memset(&things, 0xA5, sizeof things);
        assert_non_null(key);
        assert_int_equal(dg_key_set(key, &things, taken[i].value), DG_OK);
        assert_int_equal(dg_key_get(key, &things, told, sizeof told), strlen(taken[i].told));
        assert_string_equal(told, taken[i].told);
    }
}

/* And what was there stays. */
static void what_is_no_value_is_refused(void **state)
{
    (void)state;
    memset(long_text, 'a', sizeof long_text - 1u);
    for (size_t i = 0; i < DG_COUNT(refused); i++) {
        struct things things;
        struct things before;
        memset(&things, 0xA5, sizeof things);
        before = things;
        if (dg_key_set(dg_keys_find(&keys, refused[i].key), &things, refused[i].value) !=
            DG_ERR_ARGUMENT) {
            fail_msg("%s=%s is taken", refused[i].key, refused[i].value);
        }
        assert_memory_equal(&things, &before, sizeof things);
    }
}

/* The longest number there is: all digits of the smallest one, with its sign and a point. */
static void a_number_is_told_whole_or_not_at_all(void **state)
{
    static const struct dg_key lowest = {"lowest", "",        0, DG_KEY_I32, 9,
                                         1,        INT32_MIN, 0, NULL,       "nine places"};
    const int32_t value = INT32_MIN;
    char told[14];

    (void)state;
    assert_int_equal(dg_key_get(&lowest, &value, told, sizeof told - 1u), 12);
    assert_string_equal(told, "-2.147483648");
    assert_int_equal(dg_key_get(&lowest, &value, told, 13), 12);
    const struct dg_key tenths = {"tenths", "", 0, DG_KEY_I32, 1, 1, -100, 100, NULL, "one place"};
    assert_int_equal(dg_key_get(&tenths, &(const int32_t){-5}, told, sizeof told), 4);
    assert_string_equal(told, "-0.5");
    assert_int_equal(dg_key_get(&lowest, &value, told, 12), DG_ERR_SPACE);
    assert_int_equal(dg_key_get(&lowest, &value, told, 0), DG_ERR_SPACE);
}

/* A text ends with the first zero, also where that is the first byte; what stands behind it is not
 * looked at. One whose field is full has no end. */
static void a_text_that_ends_holds(void **state)
{
    const struct dg_key *key = dg_keys_find(&keys, "text");
    struct things things;

    (void)state;
    for (size_t n = 0; n < sizeof things.text; n++) {
        memset(&things, 'a', sizeof things);
        assert_false(dg_key_holds(key, &things));
        things.text[n] = '\0';
        assert_true(dg_key_holds(key, &things));
    }
}

/* Names are looked at whole. */
static void a_row_is_found_by_its_name(void **state)
{
    (void)state;
    assert_ptr_equal(dg_keys_find(&keys, "u8"), &rows[0]);
    assert_ptr_equal(dg_keys_find(&keys, "digits"), &rows[keys.count - 1u]);
    assert_null(dg_keys_find(&keys, "u"));
    assert_null(dg_keys_find(&keys, "u88"));
    assert_null(dg_keys_find(&keys, ""));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_value_is_told_as_it_was_taken),
        cmocka_unit_test(what_is_no_value_is_refused),
        cmocka_unit_test(a_number_is_told_whole_or_not_at_all),
        cmocka_unit_test(a_text_that_ends_holds),
        cmocka_unit_test(a_row_is_found_by_its_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

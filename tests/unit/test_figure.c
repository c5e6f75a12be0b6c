/* SPDX-License-Identifier: MIT */
/*
 * Numbers as people write them, at the borders of what fits.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/figure.h"
#include "drehgeber/hal.h"

static void whole_numbers(void **state)
{
    static const struct {
        const char *text;
        uint64_t value;
        bool good;
    } rows[] = {
        {"0", 0, true},
        {"39", 39, true},
        {"0x27", 39, true},
        {"0X2f", 47, true},
        {"27h", 39, true},
        {"2FH", 47, true},
        {"18446744073709551615", UINT64_MAX, true},
        {"18446744073709551616", 0, false},
        {"0xFFFFFFFFFFFFFFFF", UINT64_MAX, true},
        {"0x10000000000000000", 0, false},
        {"", 0, false},
        {"0x", 0, false},
        {"h", 0, false},
        {"2f", 0, false},
        {"1g", 0, false},
        {"12 ", 0, false},
        {"-1", 0, false},
        {"1x2", 0, false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        uint64_t value = 0;
        if (dg_unsigned_parse(rows[i].text, &value) != rows[i].good) {
            fail_msg("%s is %s", rows[i].text, rows[i].good ? "refused" : "taken");
        }
        assert_int_equal(rows[i].good ? value : 0, rows[i].value);
    }
}

/* More characters than are looked at are no number, whatever they are. */
static void a_long_number(void **state)
{
    static char text[5000];
    uint64_t value = 0;
    (void)state;
    memset(text, '0', sizeof text - 1u);
    assert_false(dg_unsigned_parse(text, &value));
}

static void decimals(void **state)
{
    static const struct {
        const char *text;
        unsigned places;
        int64_t value;
        bool cut;
        bool good;
    } rows[] = {
        {"1.5", 3, 1500, false, true},
        {"+1.5", 0, 1, true, true},
        {"-.25", 2, -25, false, true},
        {"1.2500", 2, 125, false, true},
        {"1.2501", 2, 125, true, true},
        {"9223372036854775807", 0, INT64_MAX, false, true},
        {"9223372036854775808", 0, 0, false, false},
        {"9223372036854775807", 1, 0, false, false},
        {"1.2.3", 3, 0, false, false},
        {".", 3, 0, false, false},
        {"-", 0, 0, false, false},
        {"1e3", 0, 0, false, false},
        {"", 0, 0, false, false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_decimal got = {0, false};
        if (dg_decimal_parse(rows[i].text, strlen(rows[i].text), rows[i].places, &got) !=
            rows[i].good) {
            fail_msg("%s is %s", rows[i].text, rows[i].good ? "refused" : "taken");
        }
        if (rows[i].good) {
            assert_int_equal(got.value, rows[i].value);
            assert_int_equal(got.cut, rows[i].cut);
        }
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_numbers),
        cmocka_unit_test(a_long_number),
        cmocka_unit_test(decimals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

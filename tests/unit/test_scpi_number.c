/* SPDX-License-Identifier: MIT */
/*
 * Numbers: the forms of IEEE 488.2 7.7.2 to 7.7.4, the units, and that nothing is lost on the way
 * in and out. Expected angles: ceil(degrees * 2^32 / 360), worked out by hand with 128 bits.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/angle.h"
#include "scpi_rig.h"

#define ROUNDS 20000u

static struct scpi_rig rig;
static uint64_t seed = 88172645463325252u;

static uint64_t random64(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}

/* Command, what it leaves, and the error. */
struct row {
    const char *line;
    int64_t value;
    const char *error;
};
#define GOOD "0,\"No error\"\n"
#define RANGE(text) "-222,\"Data out of range;" text "\"\n"
#define TYPE(text) "-104,\"Data type error;" text "; expected a number\"\n"
#define SUFFIX(text, right) "-131,\"Invalid suffix;" text "; expected " right "\"\n"
#define BEFORE 77 /* what a value is when a command is refused */

static void check_all(enum scpi_rig_value which, const char *header, const struct row *rows,
                      size_t count)
{
    char line[DG_SCPI_LINE_MAX];

    for (size_t i = 0; i < count; i++) {
        scpi_rig_init(&rig);
        rig.values[which] = BEFORE;
        (void)snprintf(line, sizeof line, "%s %s\nSYST:ERR:ALL?\n", header, rows[i].line);
        scpi_rig_send(&rig, line);
        if (rig.values[which] != rows[i].value || strcmp(rig.out, rows[i].error) != 0) {
            print_error("%s gives %lld, %s", line, (long long)rig.values[which], rig.out);
        }
        assert_true(rig.values[which] == rows[i].value);
        assert_string_equal(rig.out, rows[i].error);
        assert_int_equal(rig.taken, strcmp(rig.out, GOOD) == 0 ? 1 : 0);
        assert_false(rig.lost);
    }
}

/* clang-format off */
static const struct row whole[] = {
    {"0", 0, GOOD}, {"1", 1, GOOD}, {"+1", 1, GOOD}, {"-1", -1, GOOD}, {"007", 7, GOOD}, {"-0", 0, GOOD},
    {"1.", 1, GOOD}, {".5", 0, GOOD}, {"1.9", 1, GOOD}, {"-1.9", -1, GOOD}, {"-.9", 0, GOOD},
    {"1e3", 1000, GOOD}, {"1.5E3", 1500, GOOD}, {"1.5E+3", 1500, GOOD}, {"15000E-1", 1500, GOOD}, {"1 E 3", 1000, GOOD},
    {"1 E -0", 1, GOOD}, {"12345E-2", 123, GOOD}, {"12345E-4", 1, GOOD}, {"12345E-5", 0, GOOD}, {"12345E-9", 0, GOOD},
    {"0E99999999999999999999", 0, GOOD}, {"1E-99999999999999999999", 0, GOOD}, {"0.00000000000000000000000000000000001E35", 1, GOOD},
    {"100000000000000000000000000000000000E-35", 1, GOOD}, {"1.23456789012345678E18", 1234567890123456780, GOOD},
    {"9223372036854775807", INT64_MAX, GOOD}, {"-9223372036854775808", INT64_MIN, GOOD},
    {"9223372036854775807.9", INT64_MAX, GOOD}, {"922337203685477580.7E1", INT64_MAX, GOOD},
    {"9223372036854775808", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"-9223372036854775809", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"18446744073709551615", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"18446744073709551616", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"99999999999999999999999", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"1E19", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"1E99999999999999999999", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"MIN", INT64_MIN, GOOD}, {"MAX", INT64_MAX, GOOD}, {"minimum", INT64_MIN, GOOD}, {"Maximum", INT64_MAX, GOOD},
    {"#H1f", 31, GOOD}, {"#hFF", 255, GOOD}, {"0x1F", 31, GOOD}, {"0Xab", 171, GOOD}, {"#Q17", 15, GOOD}, {"#b1010", 10, GOOD},
    {"#H7FFFFFFFFFFFFFFF", INT64_MAX, GOOD}, {"#H00000000000000000001", 1, GOOD},
    {"#H8000000000000000", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"#H10000000000000000", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"#H1000000000000000000", BEFORE, RANGE("-9223372036854775808..9223372036854775807")},
    {"", BEFORE, "-109,\"Missing parameter;NUMBer N\"\n"},
    {"MINI", BEFORE, TYPE("MINI")}, {"MAX 1", BEFORE, "-102,\"Syntax error;1; expected NUMBer N\"\n"}, {"abc", BEFORE, TYPE("abc")}, {"-", BEFORE, TYPE("-")},
    {".", BEFORE, TYPE(".")}, {"+.", BEFORE, TYPE("+.")}, {"--1", BEFORE, TYPE("--1")}, {"\"1\"", BEFORE, TYPE("\"\"1\"\"")},
    {"#H", BEFORE, TYPE("#H")}, {"#HG", BEFORE, TYPE("#HG")}, {"#Q8", BEFORE, TYPE("#Q8")}, {"#B2", BEFORE, TYPE("#B2")}, {"#X1", BEFORE, TYPE("#X1")},
    {"#B12", BEFORE, "-104,\"Data type error;2\"\n"}, {"0x", BEFORE, TYPE("0x")}, {"#H1 2", BEFORE, "-102,\"Syntax error;2; expected NUMBer N\"\n"},
    {"1.2.3", BEFORE, SUFFIX(".3", "a number alone")}, {"1E", BEFORE, SUFFIX("E", "a number alone")}, {"1E+", BEFORE, SUFFIX("E+", "a number alone")}, {"1V", BEFORE, SUFFIX("V", "a number alone")}, {"1 2", BEFORE, "-102,\"Syntax error;2; expected NUMBer N\"\n"},
};
static const struct row thousandths[] = {
    {"0.5", 500, GOOD}, {"-1.5", -1500, GOOD}, {"0.0019", 1, GOOD}, {"-0.0019", -1, GOOD}, {"5E-4", 0, GOOD}, {"1", 1000, GOOD}, {"MAX", 1000, GOOD},
    {"1.001", BEFORE, RANGE("-1.5..1")}, {"-1.501", BEFORE, RANGE("-1.5..1")}, {"1E9", BEFORE, RANGE("-1.5..1")},
    {"18446744073709551.615", BEFORE, RANGE("-1.5..1")}, {"18446744073709552", BEFORE, RANGE("-1.5..1")},
    {"#H1", BEFORE, TYPE("#H1")}, {"0x1", BEFORE, SUFFIX("x1", "a number alone")},
};
static const struct row angles[] = {
    {"90", 1073741824, GOOD}, {"90DEG", 1073741824, GOOD}, {"90 deg", 1073741824, GOOD}, {"90\tDEG", 1073741824, GOOD}, {"90\t", 1073741824, GOOD}, {"-90", -1073741824, GOOD}, {"9E1DEG", 1073741824, GOOD},
    {"1REV", 4294967296, GOOD}, {"0.25rev", 1073741824, GOOD}, {"-2.5 REV", -10737418240, GOOD}, {"360", 4294967296, GOOD},
    {"1", 11930465, GOOD}, {"-1", -11930464, GOOD}, {"1E-6", 12, GOOD}, {"-1E-6", -11, GOOD}, {"1E-9", 1, GOOD}, {"-1E-9", 0, GOOD},
    {"0.000000000000000000000000000000001", 1, GOOD}, {"1E-2000", 1, GOOD}, {"-1E-2000", 0, GOOD}, {"0.0E-3", 0, GOOD},
    {"90.0000000000000000000000000000000000001", 1073741825, GOOD}, {"89.9999999999999999999999999999999999999", 1073741824, GOOD},
    {"0.1", 1193047, GOOD}, {"0.12", 1431656, GOOD}, {"0.123", 1467448, GOOD}, {"0.1234", 1472220, GOOD}, {"0.12345", 1472816, GOOD},
    {"0.00000000023283064365386962890625REV", 1, GOOD}, {"0.00000000023283064365386962890626REV", 2, GOOD},
    {"6000000000", 71582788266666667, GOOD}, {"-6000000000", -71582788266666666, GOOD}, {"6E9DEG", 71582788266666667, GOOD},
    {"16666666.666666666REV", 71582788266666664, GOOD},
    {"1E12", BEFORE, RANGE("-386547056640..386547056640 DEG")}, {"-1E30", BEFORE, RANGE("-386547056640..386547056640 DEG")},
    {"90GRAD", BEFORE, SUFFIX("GRAD", "DEG or REV")}, {"90RPM", BEFORE, SUFFIX("RPM", "DEG or REV")}, {"90 DEG REV", BEFORE, "-102,\"Syntax error;REV; expected SHAFt:POSition ANGLE\"\n"}, {"REV", BEFORE, TYPE("REV")},
};
static const struct row speeds[] = {
    {"60", 60000, GOOD}, {"60RPM", 60000, GOOD}, {"-0.001 rpm", -1, GOOD}, {"0.0009", 0, GOOD}, {"6000", 6000000, GOOD},
    {"6000.001", BEFORE, RANGE("-6000..6000 RPM")}, {"60RPM/S", BEFORE, SUFFIX("RPM/S", "RPM")},
};
static const struct row accelerations[] = {
    {"60", 60000, GOOD}, {"60 RPM/S", 60000, GOOD}, {"-1", BEFORE, RANGE("0..1000000.5 RPM/S")}, {"60RPM", BEFORE, SUFFIX("RPM", "RPM/S")},
};
static const struct row spans[] = {
    {"5", 5000000, GOOD}, {"5\t", 5000000, GOOD}, {"5MS", 5000000, GOOD}, {"5 s", 5000000000, GOOD}, {"5us", 5000, GOOD}, {"5NS", 5, GOOD}, {"0.5NS", 0, GOOD}, {"1E-3S", 1000000, GOOD},
    {"9223372036.854775807S", INT64_MAX, GOOD}, {"MAX", INT64_MAX, GOOD},
    {"9223372036.854775808S", BEFORE, RANGE("0..9223372036854.775807 MS")}, {"-1", BEFORE, RANGE("0..9223372036854.775807 MS")}, {"1M", BEFORE, SUFFIX("M", "MS, S, US or NS")},
    {"18446744073.9S", BEFORE, RANGE("0..9223372036854.775807 MS")},
};
static const struct row temperatures[] = {
    {"85", 85000, GOOD}, {"-40.5DEGC", -40500, GOOD}, {"20 cel", 20000, GOOD}, {"201", BEFORE, RANGE("-100..200 DEGC")}, {"85DEG", BEFORE, SUFFIX("DEG", "DEGC or CEL")},
};
static const struct row voltages[] = {
    {"5000", 5000, GOOD}, {"5V", 5000, GOOD}, {"2.8 v", 2800, GOOD}, {"2800mV", 2800, GOOD}, {"31V", BEFORE, RANGE("0..30000 MV")}, {"5UV", BEFORE, SUFFIX("UV", "MV or V")},
};
static const struct row currents[] = {
    {"5000", 5000, GOOD}, {"5mA", 5000, GOOD}, {"5000 UA", 5000, GOOD}, {"0.0015MA", 1, GOOD}, {"101MA", BEFORE, RANGE("0..100000 UA")}, {"1A", BEFORE, SUFFIX("A", "UA or MA")},
};
/* clang-format on */

static void numbers_are_read(void **state)
{
    (void)state;
    check_all(SCPI_RIG_NUMBER, "NUMB", whole, DG_COUNT(whole));
    check_all(SCPI_RIG_THOUSANDTHS, "VAL", thousandths, DG_COUNT(thousandths));
}

static void units_are_read(void **state)
{
    (void)state;
    check_all(SCPI_RIG_POSITION, "SHAF:POS", angles, DG_COUNT(angles));
    check_all(SCPI_RIG_VELOCITY, "SHAF:VEL", speeds, DG_COUNT(speeds));
    check_all(SCPI_RIG_ACCELERATION, "SHAF:ACC", accelerations, DG_COUNT(accelerations));
    check_all(SCPI_RIG_SPAN, "TIME:STEP", spans, DG_COUNT(spans));
    check_all(SCPI_RIG_TEMPERATURE, "WORL:TEMP", temperatures, DG_COUNT(temperatures));
    check_all(SCPI_RIG_SUPPLY, "WORL:SUPP", voltages, DG_COUNT(voltages));
    check_all(SCPI_RIG_CURRENT, "WORL:LED:CURR", currents, DG_COUNT(currents));
}

/* What a query answers sets the same value again, whatever it is. */
static void whole_numbers_go_round(void **state)
{
    (void)state;
    scpi_rig_init(&rig);
    for (unsigned i = 0; i < ROUNDS; i++) {
        const int64_t value = (int64_t)(random64() >> random64() % 64u) * (i % 2 != 0 ? 1 : -1);
        char line[SCPI_RIG_OUT_MAX + 8u] = "NUMB ";
        rig.values[SCPI_RIG_NUMBER] = value;
        scpi_rig_send(&rig, "NUMB?\n");
        (void)snprintf(&line[5], sizeof line - 5u, "%s", rig.out);
        rig.values[SCPI_RIG_NUMBER] = 0;
        scpi_rig_send(&rig, line);
        assert_true(rig.values[SCPI_RIG_NUMBER] == value);
    }
    assert_int_equal(rig.session.error_count, 0);
}

static void decimals_go_round(void **state)
{
    (void)state;
    scpi_rig_init(&rig);
    for (int64_t value = -1500; value <= 1000; value++) {
        char line[SCPI_RIG_OUT_MAX + 8u] = "VAL ";
        rig.values[SCPI_RIG_THOUSANDTHS] = value;
        scpi_rig_send(&rig, "VAL?\n");
        (void)snprintf(&line[4], sizeof line - 4u, "%s", rig.out);
        rig.values[SCPI_RIG_THOUSANDTHS] = 0;
        scpi_rig_send(&rig, line);
        assert_true(rig.values[SCPI_RIG_THOUSANDTHS] == value);
    }
}

/* All places of a point and all exponents that make the same number of the same digits. */
static void the_point_may_stand_anywhere(void **state)
{
    static const char digits[] = "1234567890123456789";
    enum { COUNT = sizeof digits - 1 };
    (void)state;

    for (int point = 0; point <= COUNT; point++) {
        char line[DG_SCPI_LINE_MAX];
        scpi_rig_init(&rig);
        (void)snprintf(line, sizeof line, "NUMB %.*s.%sE%d\n", point, digits, &digits[point],
                       COUNT - point);
        scpi_rig_send(&rig, line);
        assert_true(rig.values[SCPI_RIG_NUMBER] == 1234567890123456789);
        (void)snprintf(line, sizeof line, "NUMB -000%.*s.%s000E%d\n", point, digits, &digits[point],
                       COUNT - point - 18);
        scpi_rig_send(&rig, line);
        assert_true(rig.values[SCPI_RIG_NUMBER] == -1);
    }
}

#define BILLION UINT64_C(1000000000)
#define DEGREES_PER_TURN 360u

/* n * 10^-9 degrees; `sign` is "" or "-". */
static uint64_t magnitude_of(const char *sign, uint64_t n)
{
    char line[DG_SCPI_LINE_MAX];

    (void)snprintf(line, sizeof line, "SHAF:POS %s%llu.%09llu\n", sign,
                   (unsigned long long)(n / BILLION), (unsigned long long)(n % BILLION));
    scpi_rig_send(&rig, line);
    return (uint64_t)(sign[0] == '-' ? -rig.values[SCPI_RIG_POSITION]
                                     : rig.values[SCPI_RIG_POSITION]);
}

/* angle * 360 * 10^9 is at least n * 2^32, by less than 360 * 10^9; backwards, it is at most that.
 * Modulo 2^64 the difference is right when whole turns are. */
static void angles_are_rounded_up(void **state)
{
    const uint64_t one = DEGREES_PER_TURN * BILLION;
    (void)state;

    scpi_rig_init(&rig);
    for (unsigned i = 0; i < ROUNDS; i++) {
        const uint64_t n = random64() % (6000000000u * BILLION) >> random64() % 62u;
        const uint64_t up = magnitude_of("", n);
        const uint64_t down = magnitude_of("-", n);
        assert_true(up * one - (n << 32) < one);
        assert_true((n << 32) - down * one < one);
        assert_true(down >> 32 == n / one);
        assert_true(up - down <= 1);
    }
    assert_int_equal(rig.session.error_count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_read),
        cmocka_unit_test(units_are_read),
        cmocka_unit_test(whole_numbers_go_round),
        cmocka_unit_test(decimals_go_round),
        cmocka_unit_test(the_point_may_stand_anywhere),
        cmocka_unit_test(angles_are_rounded_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

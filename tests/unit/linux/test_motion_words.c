/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/figure.h"
#include "motion_words.h"

/* Texts and the decimals they are, in units of 10^-places. */
static void decimals(void **state)
{
    static const struct {
        const char *text;
        unsigned places;
        int64_t value;
        bool cut;
    } rows[] = {
        {"0", 0, 0, false},
        {"12", 3, 12000, false},
        {"-1.5", 1, -15, false},
        {"+0.25", 2, 25, false},
        {".5", 1, 5, false},
        {"5.", 1, 50, false},
        {"0.30000000000000004", 9, 300000000, true},
        {"1.500", 1, 15, false},
        {"9223372036854775807", 0, INT64_MAX, false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_decimal got = {-1, false};
        assert_true(dg_decimal_parse(rows[i].text, strlen(rows[i].text), rows[i].places, &got));
        assert_true(got.value == rows[i].value);
        assert_int_equal(got.cut, rows[i].cut);
    }
}

static void not_decimals(void **state)
{
    static const char *const texts[] = {
        "",
        "-",
        "+",
        ".",
        "1e3",
        "0x10",
        "1,5",
        " 1",
        "1 ",
        "1.2.3",
        "--1",
        "nan",
        "9223372036854775808",
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(texts); i++) {
        struct dg_decimal got;
        assert_false(dg_decimal_parse(texts[i], strlen(texts[i]), 0, &got));
    }
}

static void unsigned_numbers(void **state)
{
    uint64_t value = 0;
    (void)state;
    assert_true(dg_unsigned_parse("39", &value) && value == 39);
    assert_true(dg_unsigned_parse("0x27", &value) && value == 39);
    assert_true(dg_unsigned_parse("27h", &value) && value == 39);
    assert_true(dg_unsigned_parse("FFh", &value) && value == 255);
    assert_true(dg_unsigned_parse("18446744073709551615", &value) && value == UINT64_MAX);
    assert_false(dg_unsigned_parse("18446744073709551616", &value));
    assert_false(dg_unsigned_parse("", &value));
    assert_false(dg_unsigned_parse("h", &value));
    assert_false(dg_unsigned_parse("0x", &value));
    assert_false(dg_unsigned_parse("2F", &value));
    assert_false(dg_unsigned_parse("-1", &value));
}

static struct dg_motion parsed(const char *text)
{
    struct lx_shaft shaft;
    struct lx_error error;
    assert_int_equal(lx_shaft_parse(&shaft, text, NULL, &error), 0);
    assert_null(shaft.points);
    return shaft.motion;
}

static void angles_stand_still(void **state)
{
    static const struct {
        const char *text;
        dg_angle angle;
    } rows[] = {
        {"0", 0},
        {"0.0", 0},
        {"90DEG", DG_TURN / 4},
        {"90deg", DG_TURN / 4},
        {"-90DEG", -(DG_TURN / 4)},
        {"2.5REV", DG_TURN * 5 / 2},
        {"-0.25Rev", -(DG_TURN / 4)},
        {"4096REV", DG_TURN * 4096},
        {"16000000REV", DG_TURN * 16000000},
        /* 0.36 degree is 2^32 / 1000 = 4294967.296 units: up, so that it is in its step */
        {"0.36DEG", 4294968},
        {"-0.36DEG", -4294967},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_motion motion = parsed(rows[i].text);
        assert_int_equal(motion.kind, DG_MOTION_STANDSTILL);
        assert_true(motion.from == rows[i].angle);
    }
}

static void speeds_turn(void **state)
{
    (void)state;
    struct dg_motion motion = parsed("60RPM");
    assert_int_equal(motion.kind, DG_MOTION_SPEED);
    assert_int_equal(motion.mrpm, 60000);
    motion = parsed("-0.001rpm");
    assert_int_equal(motion.mrpm, -1);
    motion = parsed("1000000RPM");
    assert_int_equal(motion.mrpm, DG_MOTION_SPEED_MAX_MRPM);
}

static void sines(void **state)
{
    (void)state;
    const struct dg_motion motion = parsed("sine:90DEG,2S");
    assert_int_equal(motion.kind, DG_MOTION_SINE);
    assert_true(motion.amplitude == DG_TURN / 4);
    assert_true(motion.period == DG_S(2));
    assert_true(motion.from == 0);
    assert_true(parsed("SINE:-1rev,0.5ms").period == DG_US(500));
}

static void ramps(void **state)
{
    (void)state;
    struct dg_motion motion = parsed("ramp:3000RPM,1S");
    assert_int_equal(motion.kind, DG_MOTION_RAMP);
    assert_int_equal(motion.mrpm, 3000000);
    assert_true(motion.accel == DG_S(1));
    assert_true(motion.hold == DG_NEVER);
    motion = parsed("ramp:-10RPM,250MS,1.5S");
    assert_int_equal(motion.mrpm, -10000);
    assert_true(motion.accel == DG_MS(250));
    assert_true(motion.hold == DG_MS(1500));
    assert_true(parsed("ramp:1RPM,1S,0S").hold == 0);
}

/* Everything that is no motion is refused with the piece at fault in the message. */
static void refusals(void **state)
{
    static const struct {
        const char *text;
        const char *says;
    } rows[] = {
        {"", "''"},
        {"90", "'90'"},
        {"DEG", "'DEG'"},
        {"1e3DEG", "'1e3DEG'"},
        {"90GRAD", "'90GRAD'"},
        {"2S", "'2S' is a time"},
        {"16000001REV", "outside -16000000..16000000 REV"},
        {"1000000.001RPM", "outside -1000000..1000000 RPM"},
        {"0.0001RPM", "more than 3 decimals"},
        {"0.0054931640625REV", "more than 9 decimals"},
        {"99999999999999999999DEG", "is not a number"},
        {"sine:90DEG", "is missing"},
        {"sine:90DEG,", "''"},
        {"sine:2S,90DEG", "'2S' stands where an angle"},
        {"sine:90DEG,2S,3S", "'3S' is too much"},
        {"sine:257REV,1S", "out of range"},
        {"sine:1REV,0S", "out of range"},
        {"ramp:3000RPM", "a time such as 2S or 500MS is missing"},
        {"ramp:90DEG,1S", "'90DEG' stands where a speed"},
        {"ramp:1RPM,-1S", "outside 0..86400 S"},
        {"ramp:1RPM,0S", "out of range"},
        {"ramp:1RPM,3601S", "out of range"},
        {"ramp:1RPM,1S,1S,1S", "'1S' is too much"},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct lx_shaft shaft;
        struct lx_error error = {.right = ""};
        assert_int_equal(lx_shaft_parse(&shaft, rows[i].text, NULL, &error), LX_SHAFT_WORDS);
        assert_non_null(strstr(lx_error_line(&error).text, rows[i].says));
        assert_null(strchr(lx_error_line(&error).text, '\n'));
    }
}

static void a_missing_file(void **state)
{
    struct lx_shaft shaft;
    struct lx_error error = {.right = ""};
    (void)state;
    assert_int_equal(lx_shaft_parse(&shaft, "no/such/file.CSV", NULL, &error), LX_SHAFT_FILE);
    assert_non_null(strstr(lx_error_line(&error).text, "no/such/file.CSV"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(decimals),
        cmocka_unit_test(not_decimals),
        cmocka_unit_test(unsigned_numbers),
        cmocka_unit_test(angles_stand_still),
        cmocka_unit_test(speeds_turn),
        cmocka_unit_test(sines),
        cmocka_unit_test(ramps),
        cmocka_unit_test(refusals),
        cmocka_unit_test(a_missing_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

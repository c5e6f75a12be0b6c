/* SPDX-License-Identifier: MIT */
/*
 * What every setting of every kind of encoder may be, as the reference of its keys has it: the
 * least and the most are taken and told, what is beyond them is refused and changes nothing.
 */
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "host_rig.h"

/* clang-format off */
static const struct {
    const char *model;
    const char *key;
    const char *unit;
    uint8_t places;
    int64_t min; /* in the last place */
    int64_t max;
} numbers[] = {
    {"s3684-rs485", "address",                "",         0,      64,         95},
    {"s3684-rs485", "reaction_us",            "us",       0,       0,     250000},
    {"s3684-rs485", "init_ms",                "ms",       0,       0,     600000},
    {"s3684-rs485", "periods",                "",         0,       1,      65535},
    {"s3684-rs485", "steps",                  "",         0,       1,   16777216},
    {"s3684-rs485", "turns",                  "",         0,       1, 4294967295},
    {"s3684-rs485", "memory",                 "blocks",   0,       1,        112},
    {"s3684-rs485", "implemented",            "blocks",   0,       0,        128},
    {"s3684-rs485", "type",                   "",         0,       0,        255},
    {"s3684-rs485", "option",                 "",         0,       0,        255},
    {"s3684-rs485", "temperature_min",        "degC",     0,    -273,       1000},
    {"s3684-rs485", "temperature_max",        "degC",     0,    -273,       1000},
    {"s3684-rs485", "led_min_ma",             "mA",       0,       0,      65535},
    {"s3684-rs485", "led_max_ma",             "mA",       0,       0,      65535},
    {"s3684-rs485", "speed_max_rpm",          "rpm",      0,       1,      65535},
    {"s3684-biss",  "serial",                 "",         0,       0, 4294967295},
    {"s3684-biss",  "mt",                     "",         0,       0,         32},
    {"s3684-biss",  "st",                     "",         0,       8,         32},
    {"s3684-biss",  "busy_us",                "us",       3,       0,      40000},
    {"s3684-biss",  "busy_jitter_us",         "us",       3,       0,      40000},
    {"s3684-biss",  "hint_us",                "us",       0,       0,   10000000},
    {"s3684-biss",  "eeprom_read_us",         "us",       0,       0,       1000},
    {"s3684-biss",  "eeprom_write_us",        "us",       0,       0,      19000},
    {"s3684-biss",  "timeout_us",             "us",       0,       0,    1000000},
    {"s3684-biss",  "init_ms",                "ms",       0,       0,     600000},
    {"ssi-25",      "mt",                     "",         0,       0,         32},
    {"ssi-25",      "st",                     "",         0,       1,         32},
    {"ssi-25",      "monoflop_us",            "us",       0,      10,    1000000},
    {"ssi-25",      "init_ms",                "ms",       0,       0,     600000},
    {"f3668",       "node",                   "",         0,       1,        127},
    {"f3668",       "serial",                 "",         0,       0, 4294967295},
    {"ocd-ib-k3",   "steps",                  "",         0,       1,       8192},
    {"ocd-ib-k3",   "turns",                  "",         0,       1,       4096},
    {"ocd-ib-k3",   "param_cycles",           "cycles",   0,       1,        255},
    {"ocd-ib-k3",   "self_test_ms",           "ms",       0,       0,       1000},
    {"ocd-ib-k3",   "version",                "",         0,       0,   33554431},
    {"ocd-ib-k3",   "serial",                 "",         0,       0,   33554431},
    {"s3684-rs485", "temperature",            "degC",     3, -273000,    1000000},
    {"s3684-rs485", "led_current_ua",         "uA",       0,       0,    1000000},
    {"s3684-rs485", "supply_mv",              "mV",       0,       0,     100000},
    {"s3684-rs485", "battery_mv",             "mV",       0,       0,     100000},
    {"s3684-rs485", "sin_amplitude_permille", "permille", 0,       0,       2000},
    {"s3684-rs485", "cos_amplitude_permille", "permille", 0,       0,       2000},
    {"s3684-rs485", "sin_offset_permille",    "permille", 0,   -1000,       1000},
    {"s3684-rs485", "cos_offset_permille",    "permille", 0,   -1000,       1000},
};

static const struct {
    const char *model;
    const char *key;
    const char *value[4];
} words[] = {
    {"s3684-biss",  "lc",                  {"0", "1"}},
    {"s3684-biss",  "autostore",           {"0", "1"}},
    {"s3684-biss",  "sl_low_at_start",     {"0", "1"}},
    {"s3684-biss",  "stop_bit",            {"own", "early"}},
    {"ssi-25",      "code",                {"gray", "binary"}},
    {"ssi-25",      "error_bit",           {"none", "high", "low"}},
    {"ssi-25",      "parity",              {"none", "even", "odd"}},
    {"ssi-25",      "once",                {"0", "1"}},
    {"f3668",       "mt_bits",             {"12", "16"}},
    {"ocd-ib-k3",   "steps_minus_one",     {"0", "1"}},
    {"ocd-ib-k3",   "temperature_sensor",  {"0", "1"}},
    {"ocd-ib-k3",   "loop",                {"0", "1"}},
    {"s3684-biss",  "singleturn_ok",       {"0", "1"}},
    {"s3684-biss",  "watchdog_fired",      {"0", "1"}},
    {"s3684-biss",  "eeprom_acknowledges", {"0", "1"}},
};

static const struct {
    const char *model;
    const char *key;
    const char *least;
    const char *most;
} texts[] = {
    {"s3684-rs485", "version",     "",         "abcdefghijklmnopqrs"},
    {"s3684-rs485", "designation", "",         "abcdefghijklmnopqr"},
    {"s3684-rs485", "date",        "01020304", "31129999"},
};
/* clang-format on */

static void expect(struct dg_host *self, const char *name, const char *value)
{
    char told[64];

    assert_int_equal(dg_host_get(self, name, told, sizeof told), strlen(value));
    assert_string_equal(told, value);
}

static void take_setting(struct dg_host *self, const char *name, const char *value)
{
    if (dg_host_set(self, name, value) != DG_HOST_OK) {
        fail_msg("%s of %s: %s is refused", name, dg_host_model(self), value);
    }
    expect(self, name, value);
}

static void refuse(struct dg_host *self, const char *name, const char *value)
{
    char before[64];

    assert_true(dg_host_get(self, name, before, sizeof before) >= 0);
    if (dg_host_set(self, name, value) != DG_HOST_ERR_ARGUMENT) {
        fail_msg("%s of %s: %s is taken", name, dg_host_model(self), value);
    }
    expect(self, name, before);
}

static const char *written(int64_t value, uint8_t places)
{
    static char text[32];
    const int64_t whole = places == 3 ? value / 1000 : value;
    const int64_t rest = value % 1000 < 0 ? -(value % 1000) : value % 1000;

    if (places == 3) {
        (void)snprintf(text, sizeof text, "%s%" PRId64 ".%03" PRId64,
                       value < 0 && whole == 0 ? "-" : "", whole, rest);
    } else {
        (void)snprintf(text, sizeof text, "%" PRId64, value);
    }
    return text;
}

static void numbers_have_limits(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(numbers); i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, numbers[i].model);
        struct dg_host_key key;
        size_t at = 0;
        do {
            assert_int_equal(dg_host_key(self, at++, &key), DG_HOST_OK);
        } while (strcmp(key.name, numbers[i].key) != 0);
        assert_string_equal(key.unit, numbers[i].unit);
        assert_int_equal(key.places, numbers[i].places);
        assert_int_equal(key.min, numbers[i].min);
        assert_int_equal(key.max, numbers[i].max);
        take_setting(self, key.name, written(key.min, key.places));
        refuse(self, key.name, written(key.min - 1, key.places));
        take_setting(self, key.name, written(key.max, key.places));
        refuse(self, key.name, written(key.max + 1, key.places));
    }
}

static void words_are_all_there(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(words); i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, words[i].model);
        for (size_t k = 0; words[i].value[k] != NULL; k++) {
            take_setting(self, words[i].key, words[i].value[k]);
        }
        refuse(self, words[i].key, "2");
        refuse(self, words[i].key, "");
    }
}

static void texts_have_limits(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(texts); i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, texts[i].model);
        char longer[32];
        (void)snprintf(longer, sizeof longer, "%s1", texts[i].most);
        take_setting(self, texts[i].key, texts[i].least);
        take_setting(self, texts[i].key, texts[i].most);
        refuse(self, texts[i].key, longer);
        if (texts[i].least[0] != '\0') {
            refuse(self, texts[i].key, texts[i].least + 1);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_have_limits),
        cmocka_unit_test(words_are_all_there),
        cmocka_unit_test(texts_have_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * One row for each key. Help, error messages and the writing itself all work from the table, so a
 * new quantity is a new row. Rows point into struct lx_settings by offset and are copied with
 * memcpy(): the table knows sizes, not types.
 */
#include "settings.h"

#include <stddef.h>
#include <string.h>

#include "figure.h"

/* How a value lies in memory. */
enum kind { U8, U16, U32, I16, I32, NS, WORD, TEXT };

/* A row: numbers have `places` decimals and are multiplied by `factor` (NS only); min and max are
   in units of the last decimal. WORD: false or true in its own words. TEXT: up to `max` characters.
 */
struct setting {
    const char *key;
    const char *unit;
    size_t offset;
    enum kind kind;
    unsigned places;
    int64_t factor;
    int64_t min;
    int64_t max;
    const char *const *words;
    const char *help;
};

static const char *const no_yes[] = {"0", "1"};
static const char *const own_any[] = {"own", "any"};

#define MODEL(field) offsetof(struct lx_settings, model.field)
#define WORLD(field) offsetof(struct lx_settings, world.field)
#define HERE(field) offsetof(struct lx_settings, field)

/* clang-format off */
static const struct setting settings[] = {
    /* key                      unit        field                          kind pl factor   min         max  words help */
    {"pace",                    "",         HERE(pace),                    WORD, 0, 1,        0,          1, no_yes,  "requests and replies at the speed of the line; 0: at once"},
    {"line",                    "",         HERE(any_line),                WORD, 0, 1,        0,          1, own_any, "data rate the master must use: the encoder's own, or any"},
    {"sincos_us",               "us",       HERE(sincos),                  NS,   0, 1000,     0,    1000000, NULL, "sine and cosine in a VCD trace: time between samples; 0: none"},
    {"reaction_us",             "us",       MODEL(reaction),               NS,   0, 1000,     0,     250000, NULL, "from a request's timeout to the reply; cut to the command's maximum"},
    {"init_ms",                 "ms",       MODEL(init),                   NS,   0, 1000000,  0,     600000, NULL, "initialisation time after power-on and reset"},
    {"periods",                 "",         MODEL(periods_per_turn),       U16,  0, 1,        1,      65535, NULL, "sine periods a turn (factory)"},
    {"steps",                   "",         MODEL(steps_per_period),       U32,  0, 1,        1,   16777216, NULL, "steps of 42h in a period; periods x steps: at most 16777216 (factory)"},
    {"turns",                   "",         MODEL(turns),                  U32,  0, 1,        1, UINT32_MAX, NULL, "turns; 1: singleturn (factory)"},
    {"memory",                  "blocks",   MODEL(memory_blocks),          U8,   0, 1,        1,        112, NULL, "user memory in blocks of 16 bytes (factory)"},
    {"implemented",             "blocks",   MODEL(implemented_blocks),     U8,   0, 1,        0,        128, NULL, "memory size that 52h tells, memory..128; 0: as memory (factory)"},
    {"type",                    "",         MODEL(type_code),              U8,   0, 1,        0,        255, NULL, "type code, e.g. 27h (factory)"},
    {"option",                  "",         MODEL(option_code),            U8,   0, 1,        0,        255, NULL, "option code (factory)"},
    {"version",                 "",         MODEL(version),                TEXT, 0, 1,        0,         19, NULL, "firmware version (factory)"},
    {"date",                    "",         MODEL(date),                   TEXT, 0, 1,        8,          8, NULL, "date of the firmware (factory)"},
    {"designation",             "",         MODEL(designation),            TEXT, 0, 1,        0,         18, NULL, "designation in the type label (factory)"},
    {"temperature_min",         "degC",     MODEL(temperature_min_degc),   I16,  0, 1,     -273,       1000, NULL, "limit in the type label (factory)"},
    {"temperature_max",         "degC",     MODEL(temperature_max_degc),   I16,  0, 1,     -273,       1000, NULL, "limit in the type label (factory)"},
    {"led_min_ma",              "mA",       MODEL(led_min_ma),             U16,  0, 1,        0,      65535, NULL, "limit in the type label (factory)"},
    {"led_max_ma",              "mA",       MODEL(led_max_ma),             U16,  0, 1,        0,      65535, NULL, "limit in the type label (factory)"},
    {"speed_max_rpm",           "rpm",      MODEL(speed_max_rpm),          U16,  0, 1,        1,      65535, NULL, "fastest speed with a position (factory)"},
    {"temperature",             "degC",     WORLD(temperature_mdegc),      I32,  3, 1,  -273000,    1000000, NULL, "in the housing"},
    {"led_current_ua",          "uA",       WORLD(led_current_ua),         U32,  0, 1,        0,    1000000, NULL, "of the optical scanner"},
    {"supply_mv",               "mV",       WORLD(supply_mv),              U32,  0, 1,        0,     100000, NULL, "supply voltage"},
    {"battery_mv",              "mV",       WORLD(battery_mv),             U32,  0, 1,        0,     100000, NULL, "battery of the multiturn counter"},
    {"sin_amplitude_permille",  "permille", WORLD(sin_amplitude_permille), U16,  0, 1,        0,       2000, NULL, "of the nominal amplitude"},
    {"cos_amplitude_permille",  "permille", WORLD(cos_amplitude_permille), U16,  0, 1,        0,       2000, NULL, "of the nominal amplitude"},
    {"sin_offset_permille",     "permille", WORLD(sin_offset_permille),    I16,  0, 1,    -1000,       1000, NULL, "of the nominal amplitude"},
    {"cos_offset_permille",     "permille", WORLD(cos_offset_permille),    I16,  0, 1,    -1000,       1000, NULL, "of the nominal amplitude"},
    {"singleturn_ok",           "",         WORLD(singleturn_ok),          WORD, 0, 1,        0,          1, no_yes, "the singleturn track can be read"},
    {"multiturn_amplitude_ok",  "",         WORLD(multiturn_amplitude_ok), WORD, 0, 1,        0,          1, no_yes, "the multiturn sensor's amplitude is sufficient"},
    {"multiturn_sync_ok",       "",         WORLD(multiturn_sync_ok),      WORD, 0, 1,        0,          1, no_yes, "multiturn and singleturn agree"},
    {"multiturn_vector_ok",     "",         WORLD(multiturn_vector_ok),    WORD, 0, 1,        0,          1, no_yes, "the multiturn sensor's vector length is in range"},
    {"eeprom_acknowledges",     "",         WORLD(eeprom_acknowledges),    WORD, 0, 1,        0,          1, no_yes, "the EEPROM answers"},
    {"watchdog_fired",          "",         WORLD(watchdog_fired),         WORD, 0, 1,        0,          1, no_yes, "the watchdog has reset the processor"},
};
/* clang-format on */
#define SETTING_COUNT (sizeof settings / sizeof settings[0])

/* Whether the encoder has this key. */
static bool applies(const struct lx_settings *self, const struct setting *row)
{
    const size_t world = offsetof(struct lx_settings, world);
    return self->rs485 || (row->offset >= world && row->offset < world + sizeof self->world);
}

static const struct setting *find(const struct lx_settings *self, const char *key, size_t n)
{
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        if (applies(self, &settings[i]) && strlen(settings[i].key) == n &&
            memcmp(settings[i].key, key, n) == 0) {
            return &settings[i];
        }
    }
    return NULL;
}

static void append(struct lx_error *to, const char *word)
{
    const size_t used = strlen(to->text);
    (void)snprintf(to->text + used, sizeof to->text - used, " %s", word);
}

/* All keys fit one line; whoever mistyped one finds it there. */
static int unknown_key(const struct lx_settings *self, const char *key, size_t n,
                       struct lx_error *error)
{
    struct lx_error keys = {""};
    (void)lx_fail(&keys, "%s", self->own_keys);
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        if (applies(self, &settings[i])) {
            append(&keys, settings[i].key);
        }
    }
    const bool wire = self->wire_keys != NULL;
    return lx_fail(error, "--set %.*s: no such key; valid:%s%s%s", (int)n, key, keys.text,
                   wire ? "; of the wire: " : "", wire ? self->wire_keys : "");
}

/* The value has been checked against the row's range, so it fits the type. */
static void store(const struct setting *row, uint8_t *to, int64_t value)
{
    const uint8_t u8 = (uint8_t)value;
    const uint16_t u16 = (uint16_t)value;
    const uint32_t u32 = (uint32_t)value;
    const uint64_t u64 = (uint64_t)(value * row->factor);
    const bool word = value != 0;
    switch (row->kind) {
    case U8:
        *to = u8;
        break;
    case U16:
    case I16: /* two's complement: the same bytes */
        memcpy(to, &u16, sizeof u16);
        break;
    case U32:
    case I32:
        memcpy(to, &u32, sizeof u32);
        break;
    case NS:
        memcpy(to, &u64, sizeof u64);
        break;
    case WORD:
        memcpy(to, &word, sizeof word);
        break;
    case TEXT:
        break;
    }
}

/* What store() has put there. */
static int64_t load(const struct setting *row, const uint8_t *from)
{
    uint16_t u16 = 0;
    uint32_t u32 = 0;
    uint64_t u64 = 0;
    switch (row->kind) {
    case U16:
        memcpy(&u16, from, sizeof u16);
        return u16;
    case I16:
        memcpy(&u16, from, sizeof u16);
        return (int16_t)u16;
    case U32:
        memcpy(&u32, from, sizeof u32);
        return u32;
    case I32:
        memcpy(&u32, from, sizeof u32);
        return (int32_t)u32;
    case NS:
        memcpy(&u64, from, sizeof u64);
        return (int64_t)u64 / row->factor;
    case U8:
    case WORD:
    case TEXT:
        break;
    }
    return *from;
}

/* The range of a number in words, "0..250000 us". */
static struct lx_error range_of(const struct setting *row)
{
    struct lx_error range;
    const long long one = (long long)lx_power_of_ten(row->places);
    (void)snprintf(range.text, sizeof range.text, "%lld..%lld%s%s", (long long)row->min / one,
                   (long long)row->max / one, row->unit[0] == '\0' ? "" : " ", row->unit);
    return range;
}

static int set_number(const struct setting *row, uint8_t *to, const char *value,
                      struct lx_error *error)
{
    struct lx_decimal number;
    uint64_t hex = 0;
    /* Codes are written as the manual writes them, 27h, as well as decimal. */
    bool valid = lx_decimal_parse(value, strlen(value), row->places, &number);
    if (!valid && lx_unsigned_parse(value, &hex) && hex <= UINT32_MAX && row->places == 0) {
        number = (struct lx_decimal){(int64_t)hex, false};
        valid = true;
    }
    if (!valid || number.cut || number.value < row->min || number.value > row->max) {
        const struct lx_error range = range_of(row);
        return lx_fail(error, "--set %s=%s: a number in %s with at most %u decimals is right",
                       row->key, value, range.text, row->places);
    }
    store(row, to, number.value);
    return 0;
}

static int set_word(const struct setting *row, uint8_t *to, const char *value,
                    struct lx_error *error)
{
    for (int i = 0; i < 2; i++) {
        if (strcmp(value, row->words[i]) == 0) {
            store(row, to, i);
            return 0;
        }
    }
    return lx_fail(error, "--set %s=%s: %s or %s is right", row->key, value, row->words[0],
                   row->words[1]);
}

/* The rest of the field is cleared: it goes to the EEPROM as a whole. */
static int set_text(const struct setting *row, uint8_t *to, const char *value,
                    struct lx_error *error)
{
    const size_t n = strlen(value);
    if (n < (size_t)row->min || n > (size_t)row->max) {
        return lx_fail(error, "--set %s=%s: %lld to %lld characters are right", row->key, value,
                       (long long)row->min, (long long)row->max);
    }
    memset(to, 0, (size_t)row->max + 1);
    memcpy(to, value, n);
    return 0;
}

void lx_settings_init(struct lx_settings *self, const struct dg_hf_model *model)
{
    *self = (struct lx_settings){.rs485 = model != NULL, .pace = true, .sincos = DG_MS(1)};
    if (model != NULL) {
        self->model = *model;
    }
    dg_world_init(&self->world);
}

void lx_settings_name(struct lx_settings *self, const char *key)
{
    const size_t used = strlen(self->own_keys);
    (void)snprintf(self->own_keys + used, sizeof self->own_keys - used, " %s", key);
}

int lx_settings_set(struct lx_settings *self, const char *assignment, struct lx_error *error)
{
    const char *equals = strchr(assignment, '=');
    if (equals == NULL) {
        return lx_fail(error, "--set %s: KEY=VALUE is right", assignment);
    }
    const size_t n = (size_t)(equals - assignment);
    const struct setting *row = find(self, assignment, n);
    if (row == NULL) {
        return unknown_key(self, assignment, n, error);
    }
    uint8_t *to = (uint8_t *)self + row->offset;
    if (row->kind == WORD) {
        return set_word(row, to, equals + 1, error);
    }
    if (row->kind == TEXT) {
        return set_text(row, to, equals + 1, error);
    }
    return set_number(row, to, equals + 1, error);
}

int lx_settings_assignment(char to[LX_ASSIGNMENT_MAX], const struct lx_plan *plan,
                           const struct lx_plan_setting *setting, struct lx_error *error)
{
    const int n = snprintf(to, LX_ASSIGNMENT_MAX, "%s=%s", setting->key, setting->value);
    return n >= 0 && (size_t)n < LX_ASSIGNMENT_MAX
               ? 0
               : lx_plan_fail(plan, setting->line, error, "%.40s: the value is too long",
                              setting->key);
}

int lx_settings_take(struct lx_settings *self, const struct lx_plan *plan,
                     const struct lx_plan_setting *setting, struct lx_error *error)
{
    char assignment[LX_ASSIGNMENT_MAX];
    if (lx_settings_assignment(assignment, plan, setting, error) != 0) {
        return -1;
    }
    return lx_settings_set(self, assignment, error) == 0
               ? 0
               : lx_settings_refuse(plan, setting->line, error);
}

int lx_settings_serial(struct lx_settings *self, const char *digits, struct lx_error *error)
{
    const size_t length = sizeof self->model.serial - 1;
    const size_t n = strlen(digits);
    if (n == 0 || n > length || strspn(digits, "0123456789") != n) {
        return lx_fail(error, "--serial %s: 1 to 9 digits are right", digits);
    }
    memset(self->model.serial, '0', length - n);
    memcpy(self->model.serial + length - n, digits, n + 1);
    self->serial_given = true;
    return 0;
}

void lx_settings_world(const struct lx_settings *self, struct dg_world *to)
{
    const struct dg_world before = *to;
    *to = self->world;
    to->angle = before.angle;
    to->angle_ctx = before.angle_ctx;
}

int lx_settings_refuse(const struct lx_plan *plan, lx_line_number line, struct lx_error *error)
{
    static const char *const options[] = {"--set ", "--set: ", "--"};
    const struct lx_error said = *error;
    if (line == 0) {
        return -1;
    }
    size_t skip = 0;
    for (size_t i = 0; skip == 0 && i < sizeof options / sizeof options[0]; i++) {
        const size_t n = strlen(options[i]);
        skip = strncmp(said.text, options[i], n) == 0 ? n : 0;
    }
    return lx_plan_fail(plan, line, error, "%s", said.text + skip);
}

int lx_settings_check(const struct lx_settings *self, struct lx_error *error)
{
    const struct dg_hf_model *model = &self->model;
    const uint64_t steps = (uint64_t)model->periods_per_turn * model->steps_per_period;
    const uint64_t counts = steps * model->turns;
    if (steps > DG_HF_STEPS_PER_TURN_MAX) {
        return lx_fail(error, "--set: periods x steps is %llu; at most %lu is right",
                       (unsigned long long)steps, (unsigned long)DG_HF_STEPS_PER_TURN_MAX);
    }
    if (model->implemented_blocks != 0 && model->implemented_blocks < model->memory_blocks) {
        return lx_fail(error, "--set implemented=%u: %u..128 is right, or 0: as memory",
                       model->implemented_blocks, model->memory_blocks);
    }
    /* 42h answers with 32 bits of position. */
    if (counts > (uint64_t)1 << 32) {
        return lx_fail(error, "--set: turns x periods x steps is %llu; at most 4294967296 is right",
                       (unsigned long long)counts);
    }
    return 0;
}

/* Valid values and the default; a factory figure's default is the model's. */
static struct lx_error values_of(const struct lx_settings *self, const struct setting *row)
{
    const int64_t now = load(row, (const uint8_t *)self + row->offset);
    struct lx_error values = range_of(row);
    struct lx_error text;
    if (row->kind == TEXT) {
        (void)snprintf(text.text, sizeof text.text, "%lld..%lld characters", (long long)row->min,
                       (long long)row->max);
        return text;
    }
    if (row->kind == WORD) {
        (void)snprintf(text.text, sizeof text.text, "%s|%s, default %s", row->words[0],
                       row->words[1], row->words[now != 0 ? 1 : 0]);
        return text;
    }
    if (row->offset < sizeof self->model && row->kind != NS) {
        return values;
    }
    (void)snprintf(text.text, sizeof text.text, "%.100s, default %lld", values.text,
                   (long long)(now / lx_power_of_ten(row->places)));
    return text;
}

void lx_settings_help(const struct lx_settings *self, FILE *to)
{
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        const struct lx_error values = values_of(self, &settings[i]);
        (void)fprintf(to, "  %-23s %s (%s)\n", settings[i].key, settings[i].help, values.text);
    }
}

/* SPDX-License-Identifier: MIT */
/* One row for each figure; what is in no row but is a quantity of the world goes to settings.c. */
#include "modbus_settings.h"

#include <stddef.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "figure.h"

struct setting {
    const char *key;
    const char *unit;
    size_t offset;
    int32_t min;
    int32_t max;
    int32_t initial; /* LX_AS_MODEL: each model's own */
    bool of_ring;    /* else of each device */
    const char *help;
};

#define HERE(field) offsetof(struct lx_ring_settings, field)

/* clang-format off */
static const struct setting settings[] = {
    /* key                 unit       field                     min    max      initial      ring   help */
    {"cycle",              " us",     HERE(cycle_us),           250,   50000,   1000,        true,  "from one data cycle of the ring to the next"},
    {"tear",               "",        HERE(tear),               0,     1,       0,           true,  "1: half of an OUT word is taken from a request (fault)"},
    {"break_at",           "",        HERE(break_at),           0,     511,     LX_AS_MODEL, true,  "the bus is cut before this device, 0 is the first (fault)"},
    {"steps",              "",        HERE(steps),              1,     8192,    LX_AS_MODEL, false, "steps of the discs a turn (factory)"},
    {"turns",              "",        HERE(turns),              1,     4096,    LX_AS_MODEL, false, "turns of a K2 and K3; 1: singleturn (factory)"},
    {"steps_minus_one",    "",        HERE(steps_minus_one),    0,     1,       LX_AS_MODEL, false, "a K3 has one step more than its parameter says (factory)"},
    {"temperature_sensor", "",        HERE(temperature_sensor), 0,     1,       LX_AS_MODEL, false, "a K3 has one (factory)"},
    {"loop",               "",        HERE(loop),               0,     1,       LX_AS_MODEL, false, "INTERBUS Loop: ID B2h and B3h (factory)"},
    {"param_cycles",       " cycles", HERE(param_cycles),       1,     255,     LX_AS_MODEL, false, "from a K3's command to its answer"},
    {"self_test_ms",       " ms",     HERE(self_test_ms),       0,     1000,    LX_AS_MODEL, false, "self-test after power-on"},
    {"version",            "",        HERE(version),            0,     DG_IB_DATA_MASK, LX_AS_MODEL, false, "software version of a K3 (factory)"},
};
/* clang-format on */
#define SETTING_COUNT (sizeof settings / sizeof settings[0])

/* What these encoders sense, of everything settings.c knows. */
static const char *const world_keys[] = {
    "temperature",       "singleturn_ok",       "multiturn_amplitude_ok",
    "multiturn_sync_ok", "multiturn_vector_ok", "eeprom_acknowledges",
};
#define WORLD_COUNT (sizeof world_keys / sizeof world_keys[0])

static bool named(const char *name, const char *key, size_t n)
{
    return strlen(name) == n && memcmp(name, key, n) == 0;
}

static bool of_the_world(const char *key, size_t n)
{
    for (size_t i = 0; i < WORLD_COUNT; i++) {
        if (named(world_keys[i], key, n)) {
            return true;
        }
    }
    return false;
}

/* Whether it is a key of the ring as a whole. */
static bool of_the_ring(const char *key)
{
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        if (strcmp(settings[i].key, key) == 0) {
            return settings[i].of_ring;
        }
    }
    return false;
}

static void put(struct lx_ring_settings *self, const struct setting *row, int32_t value)
{
    memcpy((uint8_t *)self + row->offset, &value, sizeof value);
}

void lx_ring_settings_init(struct lx_ring_settings *self)
{
    memset(self, 0, sizeof *self);
    lx_settings_init(&self->common, dg_hf_model_of(dg_devices[0]));
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        put(self, &settings[i], settings[i].initial);
    }
    self->serial = LX_AS_MODEL;
}

static void append(struct lx_error *to, const char *word)
{
    const size_t used = strlen(to->text);
    (void)snprintf(to->text + used, sizeof to->text - used, " %s", word);
}

static int unknown_key(const char *key, size_t n, struct lx_error *error)
{
    struct lx_error keys = {""};
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        append(&keys, settings[i].key);
    }
    for (size_t i = 0; i < WORLD_COUNT; i++) {
        append(&keys, world_keys[i]);
    }
    return lx_fail(error, "--set %.*s: no such key; valid:%.400s", (int)n, key, keys.text);
}

static int set_row(struct lx_ring_settings *self, const struct setting *row, const char *value,
                   struct lx_error *error)
{
    uint64_t number = 0;
    if (!lx_unsigned_parse(value, &number) || number < (uint64_t)row->min ||
        number > (uint64_t)row->max) {
        return lx_fail(error, "--set %s=%s: a whole number in %ld..%ld%s is right", row->key, value,
                       (long)row->min, (long)row->max, row->unit);
    }
    put(self, row, (int32_t)number);
    return 0;
}

int lx_ring_settings_set(struct lx_ring_settings *self, const char *assignment,
                         struct lx_error *error)
{
    const char *equals = strchr(assignment, '=');
    if (equals == NULL) {
        return lx_fail(error, "--set %s: KEY=VALUE is right", assignment);
    }
    const size_t n = (size_t)(equals - assignment);
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        if (named(settings[i].key, assignment, n)) {
            return set_row(self, &settings[i], equals + 1, error);
        }
    }
    return of_the_world(assignment, n) ? lx_settings_set(&self->common, assignment, error)
                                       : unknown_key(assignment, n, error);
}

int lx_ring_settings_take(struct lx_ring_settings *self, const struct lx_plan *plan,
                          const struct lx_plan_setting *setting, bool of_ring,
                          struct lx_error *error)
{
    char assignment[LX_ASSIGNMENT_MAX];
    if (lx_settings_assignment(assignment, plan, setting, error) != 0) {
        return -1;
    }
    if (of_the_ring(setting->key) != of_ring) {
        return lx_plan_fail(plan, setting->line, error, "%.40s: a key of %s", setting->key,
                            of_ring ? "an encoder, not of the ring"
                                    : "the ring, not of one of its encoders");
    }
    return lx_ring_settings_set(self, assignment, error) == 0
               ? 0
               : lx_settings_refuse(plan, setting->line, error);
}

int lx_ring_settings_serial(struct lx_ring_settings *self, const char *digits,
                            struct lx_error *error)
{
    uint64_t number = 0;
    if (!lx_unsigned_parse(digits, &number) || number > DG_IB_DATA_MASK) {
        return lx_fail(error, "--serial %s: a number in 0..%lu is right", digits,
                       (unsigned long)DG_IB_DATA_MASK);
    }
    self->serial = (int32_t)number;
    return 0;
}

/* A figure that was set, or the model's. */
static uint32_t either(int32_t set, uint32_t own)
{
    return set == LX_AS_MODEL ? own : (uint32_t)set;
}

struct dg_ib_model lx_ring_settings_model(const struct lx_ring_settings *self,
                                          const struct dg_ib_model *model, uint32_t index)
{
    struct dg_ib_model own = *model;
    own.steps = (uint16_t)either(self->steps, own.steps);
    if (own.profile != DG_IB_K1) {
        own.turns = (uint16_t)either(self->turns, own.turns);
    }
    own.steps_minus_one = either(self->steps_minus_one, own.steps_minus_one) != 0;
    own.temperature_sensor = either(self->temperature_sensor, own.temperature_sensor) != 0;
    own.loop = either(self->loop, own.loop) != 0;
    own.param_cycles = (uint8_t)either(self->param_cycles, own.param_cycles);
    own.version = either(self->version, own.version);
    own.serial = (either(self->serial, own.serial) + index) & DG_IB_DATA_MASK;
    if (self->self_test_ms != LX_AS_MODEL) {
        own.self_test = DG_MS(self->self_test_ms);
    }
    return own;
}

void lx_ring_settings_help(FILE *to)
{
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        const struct setting *row = &settings[i];
        (void)fprintf(to, "  %-23s %s (%ld..%ld%s", row->key, row->help, (long)row->min,
                      (long)row->max, row->unit);
        (void)(row->initial == LX_AS_MODEL ? fputs(")\n", to)
                                           : fprintf(to, ", default %ld)\n", (long)row->initial));
    }
}

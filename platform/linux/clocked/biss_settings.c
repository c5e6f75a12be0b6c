/* SPDX-License-Identifier: MIT */
#include "biss_settings.h"

#include <stddef.h>
#include <string.h>

#include "figure.h"

/* How a value lies in memory; times are in ns there, words are the two values of a flag. */
enum kind { BITS, FLAG, WORDS, US, MS };

/* The encoder's own keys; the others are the world's. */
struct key {
    const char *name;
    size_t offset; /* in the model */
    enum kind kind;
    unsigned min;
    unsigned max;
    const char *help;
};

#define MODEL(field) offsetof(struct dg_biss_model, field)

/* clang-format off */
static const char *const stop_bits[] = {"own", "early"};

static const struct key keys[] = {
    {"mt",              MODEL(multiturn_bits),  BITS,  0,     24, "multiturn bits"},
    {"st",              MODEL(singleturn_bits), BITS, 12,     24, "singleturn bits"},
    {"lc",              MODEL(life_counter),    FLAG,  0,      1, "the frame has a life counter"},
    {"autostore",       MODEL(autostore),       FLAG,  0,      1, "offsets and masks go to the EEPROM when they are written"},
    {"busy_us",         MODEL(busy),            US,    0,     40, "from the first clock edge to the start bit, in us"},
    {"busy_jitter_us",  MODEL(busy_jitter),     US,    0,     40, "up to as much more, another time in every frame, in us"},
    {"sl_low_at_start", MODEL(sl_low_at_start), FLAG,  0,      1, "SLO is low from power-on to the first clock"},
    {"stop_bit",        MODEL(stop_bit_early),  WORDS, 0,      1, "P = 1 refuses the register just transferred, or ahead of time the next one"},
    {"eeprom_read_us",  MODEL(eeprom_read),     US,    0,   1000, "an access to a user bank, in us"},
    {"eeprom_write_us", MODEL(eeprom_write),    US,    0,  19000, "what the EEPROM needs after a write, in us"},
    {"timeout_us",      MODEL(timeout),         US,   13, 1000000, "--gpio: silence on MA that ends a frame, in us; 20000 unless set"},
    {"init_ms",         MODEL(init),            MS,    0, 600000, "initialisation after power-on and reset, in ms"},
};
/* clang-format on */
#define KEY_COUNT (sizeof keys / sizeof keys[0])
#define RANGE_MAX 40u
/* busy_us and busy_jitter_us together. */
#define BUSY_MAX_US (DG_BISS_BUSY_S_MAX_NS / 1000u)

void lx_biss_settings_init(struct lx_biss_settings *self, const struct dg_biss_model *model)
{
    self->model = *model;
    lx_settings_init(&self->common, NULL);
    self->common.wire_keys = "clock_hz line_delay_ns";
    for (size_t i = 0; i < KEY_COUNT; i++) {
        lx_settings_name(&self->common, keys[i].name);
    }
}

/* What would be right. */
static const char *range_of(const struct key *key, char *text, size_t size)
{
    if (key->kind == WORDS) {
        (void)snprintf(text, size, "%s or %s", stop_bits[0], stop_bits[1]);
    } else {
        (void)snprintf(text, size, "%u..%u", key->min, key->max);
    }
    return text;
}

void lx_biss_settings_help(FILE *to)
{
    char range[RANGE_MAX];
    for (size_t i = 0; i < KEY_COUNT; i++) {
        (void)fprintf(to, "  %-23s %s (%s)\n", keys[i].name, keys[i].help,
                      range_of(&keys[i], range, sizeof range));
    }
}

static void store(struct dg_biss_model *model, const struct key *key, uint64_t value)
{
    uint8_t *to = (uint8_t *)model + key->offset;
    const bool flag = value != 0;
    const dg_ns time = key->kind == MS ? DG_MS(value) : DG_US(value);
    switch (key->kind) {
    case BITS:
        *to = (uint8_t)value;
        break;
    case FLAG:
    case WORDS:
        memcpy(to, &flag, sizeof flag);
        break;
    case US:
    case MS:
        memcpy(to, &time, sizeof time);
        break;
    }
}

static bool parse(const struct key *key, const char *text, uint64_t *value)
{
    if (key->kind == WORDS) {
        *value = strcmp(text, stop_bits[1]) == 0;
        return *value != 0 || strcmp(text, stop_bits[0]) == 0;
    }
    return lx_unsigned_parse(text, value) && *value >= key->min && *value <= key->max;
}

int lx_biss_settings_set(struct lx_biss_settings *self, const char *assignment,
                         struct lx_error *error)
{
    const size_t n = strcspn(assignment, "=");
    for (size_t i = 0; i < KEY_COUNT; i++) {
        const struct key *key = &keys[i];
        uint64_t value = 0;
        char range[RANGE_MAX];
        if (strlen(key->name) != n || strncmp(key->name, assignment, n) != 0) {
            continue;
        }
        if (assignment[n] == '\0' || !parse(key, &assignment[n + 1], &value)) {
            return lx_fail(error, "--set %s: %s%s is right", assignment,
                           key->kind == WORDS ? "" : "a number in ",
                           range_of(key, range, sizeof range));
        }
        store(&self->model, key, value);
        return 0;
    }
    return lx_settings_set(&self->common, assignment, error);
}

int lx_biss_settings_check(const struct lx_biss_settings *self, struct lx_error *error)
{
    if (self->model.busy + self->model.busy_jitter <= DG_BISS_BUSY_S_MAX_NS) {
        return 0;
    }
    return lx_fail(error, "busy_us %u and busy_jitter_us %u: together at most %u is right",
                   (unsigned)(self->model.busy / 1000u),
                   (unsigned)(self->model.busy_jitter / 1000u), (unsigned)BUSY_MAX_US);
}

static int take(struct lx_biss_settings *self, const struct lx_plan *plan,
                const struct lx_plan_setting *setting, struct lx_error *error)
{
    char assignment[LX_ASSIGNMENT_MAX];
    if (lx_settings_assignment(assignment, plan, setting, error) != 0) {
        return -1;
    }
    return lx_biss_settings_set(self, assignment, error) == 0
               ? 0
               : lx_settings_refuse(plan, setting->line, error);
}

int lx_biss_settings_serial(struct lx_biss_settings *self, const char *digits,
                            struct lx_error *error)
{
    uint64_t serial = 0;
    if (!lx_unsigned_parse(digits, &serial) || serial > UINT32_MAX) {
        return lx_fail(error, "--serial %s: 0..4294967295 is right", digits);
    }
    self->model.serial = (uint32_t)serial;
    return 0;
}

int lx_biss_settings_plan(struct lx_biss_settings *self, const struct lx_plan *plan,
                          const struct lx_plan_encoder *encoder, struct lx_error *error)
{
    lx_biss_settings_init(self, dg_biss_model_of(encoder->model));
    for (size_t i = 0; i < encoder->settings.count; i++) {
        if (take(self, plan, &encoder->settings.list[i], error) != 0) {
            return -1;
        }
    }
    if (encoder->address != NULL) {
        return lx_plan_fail(plan, encoder->address_line, error,
                            "address %s: a BiSS encoder has none, only its place on the wire",
                            encoder->address);
    }
    if (encoder->serial != NULL && lx_biss_settings_serial(self, encoder->serial, error) != 0) {
        return lx_settings_refuse(plan, encoder->serial_line, error);
    }
    return lx_biss_settings_check(self, error) == 0
               ? 0
               : lx_settings_refuse(plan, encoder->line, error);
}

int lx_biss_eeprom_open(struct lx_biss_eeprom *self, const char *path, struct lx_error *error)
{
    *self = (struct lx_biss_eeprom){.file = {.fd = -1}};
    if (lx_nvm_memory_init(&self->memory, dg_store_size(&dg_biss_layout)) != 0) {
        return lx_fail(error, "no memory for the EEPROM");
    }
    self->nvm = lx_nvm_memory_port(&self->memory);
    if (dg_biss_format(self->nvm) != DG_OK) {
        return lx_fail(error, "the EEPROM cannot be formatted");
    }
    if (path == NULL) {
        return 0;
    }
    const struct lx_nvm_image image = {self->memory.bytes, self->memory.size,
                                       "the encoder answers P = 1"};
    if (lx_nvm_file_open(&self->file, path, &image, error) != 0) {
        return -1;
    }
    self->nvm = lx_nvm_file_port(&self->file);
    return 0;
}

int lx_biss_eeprom_defer(struct lx_biss_eeprom *self, struct lx_nvm_writer *writer,
                         struct lx_error *error)
{
    const struct lx_nvm_queue_setup queue = {
        .writer = self->file.fd < 0 ? NULL : writer,
        .below = self->nvm,
        .size = self->memory.size,
    };
    return lx_nvm_queue_open(&self->queue, &queue, &self->nvm, error);
}

void lx_biss_eeprom_close(struct lx_biss_eeprom *self)
{
    lx_nvm_queue_close(&self->queue);
    lx_nvm_file_close(&self->file);
    lx_nvm_memory_free(&self->memory);
}

int lx_biss_switch_on(struct dg_biss *device, const struct dg_biss_setup *setup, dg_ns now,
                      const char *path, struct lx_error *error)
{
    if (dg_biss_init(device, setup) != DG_OK) {
        return lx_fail(error, "these factory figures make no encoder");
    }
    if (dg_biss_power_on(device, now) != DG_OK) {
        return lx_fail(error, "--nvm %s: not the EEPROM of a BiSS encoder; another name is right",
                       path == NULL ? "" : path);
    }
    return 0;
}

/* SPDX-License-Identifier: MIT */
#include "biss_settings.h"

#include <stddef.h>
#include <string.h>

#include "number.h"

/* How a value lies in memory; times are in ns there. */
enum kind { BITS, FLAG, US, MS };

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
static const struct key keys[] = {
    {"mt",              MODEL(multiturn_bits),  BITS,  0,     24, "multiturn bits"},
    {"st",              MODEL(singleturn_bits), BITS, 12,     23, "singleturn bits"},
    {"lc",              MODEL(life_counter),    FLAG,  0,      1, "the frame has a life counter"},
    {"autostore",       MODEL(autostore),       FLAG,  0,      1, "offsets and masks go to the EEPROM when they are written"},
    {"busy_us",         MODEL(busy),            US,    0,     40, "from the first clock edge to the start bit, in us"},
    {"eeprom_read_us",  MODEL(eeprom_read),     US,    0,   1000, "an access to a user bank, in us"},
    {"eeprom_write_us", MODEL(eeprom_write),    US,    0,  19000, "what the EEPROM needs after a write, in us"},
    {"timeout_us",      MODEL(timeout),         US,   13, 1000000, "--gpio: silence on MA that ends a frame, in us; 20000 unless set"},
    {"init_ms",         MODEL(init),            MS,    0, 600000, "initialisation after power-on and reset, in ms"},
};
/* clang-format on */
#define KEY_COUNT (sizeof keys / sizeof keys[0])

void lx_biss_settings_init(struct lx_biss_settings *self, const struct dg_biss_model *model)
{
    self->model = *model;
    lx_settings_init(&self->common, NULL);
}

void lx_biss_settings_help(FILE *to)
{
    for (size_t i = 0; i < KEY_COUNT; i++) {
        (void)fprintf(to, "  %-23s %s (%u..%u)\n", keys[i].name, keys[i].help, keys[i].min,
                      keys[i].max);
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
        memcpy(to, &flag, sizeof flag);
        break;
    case US:
    case MS:
        memcpy(to, &time, sizeof time);
        break;
    }
}

int lx_biss_settings_set(struct lx_biss_settings *self, const char *assignment,
                         struct lx_error *error)
{
    const size_t n = strcspn(assignment, "=");
    for (size_t i = 0; i < KEY_COUNT; i++) {
        const struct key *key = &keys[i];
        uint64_t value = 0;
        if (strlen(key->name) != n || strncmp(key->name, assignment, n) != 0) {
            continue;
        }
        if (assignment[n] == '\0' || !lx_unsigned_parse(&assignment[n + 1], &value) ||
            value < key->min || value > key->max) {
            return lx_fail(error, "--set %s: a number in %u..%u is right", assignment, key->min,
                           key->max);
        }
        store(&self->model, key, value);
        return 0;
    }
    return lx_settings_set(&self->common, assignment, error);
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
    lx_biss_settings_init(self, encoder->model->biss);
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
    return 0;
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
    const struct lx_nvm_image image = {self->memory.bytes, self->memory.size};
    if (lx_nvm_file_open(&self->file, path, &image, error) != 0) {
        return -1;
    }
    self->nvm = lx_nvm_file_port(&self->file);
    return 0;
}

void lx_biss_eeprom_close(struct lx_biss_eeprom *self)
{
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

/* SPDX-License-Identifier: MIT */
#include "biss_session.h"

#include <errno.h>
#include <stddef.h>
#include <string.h>

#include "biss.h"
#include "biss_gpio.h"
#include "drehgeber/devices.h"
#include "number.h"
#include "run.h"

/* Ends a frame on GPIO lines; see src/biss/README.md, 'GPIO'. */
#define GPIO_TIMEOUT DG_MS(20)

/* The encoder's own KEYs; the others are the world's. */
static const struct key {
    const char *name;
    unsigned max;
    unsigned min;
    const char *help;
} keys[] = {
    {"mt", 24, 0, "multiturn bits"},
    {"st", 23, 12, "singleturn bits"},
    {"lc", 1, 0, "the frame has a life counter"},
    {"autostore", 1, 0, "offsets and masks go to the EEPROM when they are written"},
    {"busy_us", 40, 0, "from the first clock edge to the start bit, in us"},
    {"eeprom_read_us", 1000, 0, "an access to a user bank, in us"},
    {"eeprom_write_us", 19000, 0, "what the EEPROM needs after a write, in us"},
    {"timeout_us", 1000000, 13, "--gpio: silence on MA that ends a frame, in us; 20000 unless set"},
    {"init_ms", 600000, 0, "initialisation after power-on and reset, in ms"},
};
#define KEY_COUNT (sizeof keys / sizeof keys[0])

void biss_settings_help(FILE *to)
{
    for (size_t i = 0; i < KEY_COUNT; i++) {
        (void)fprintf(to, "  %-23s %s (%u..%u)\n", keys[i].name, keys[i].help, keys[i].min,
                      keys[i].max);
    }
}

/* By place in the table. */
static void apply(struct dg_biss_model *model, size_t key, uint64_t value)
{
    uint8_t *const bits[] = {&model->multiturn_bits, &model->singleturn_bits};
    bool *const flags[] = {&model->life_counter, &model->autostore};
    dg_ns *const times[] = {&model->busy, &model->eeprom_read, &model->eeprom_write,
                            &model->timeout, &model->init};

    if (key < 2) {
        *bits[key] = (uint8_t)value;
    } else if (key < 4) {
        *flags[key - 2] = value != 0;
    } else {
        *times[key - 4] = key == KEY_COUNT - 1 ? DG_MS(value) : DG_US(value);
    }
}

static int set(struct biss_session *self, const char *assignment, struct lx_error *error)
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
        apply(&self->model, i, value);
        return 0;
    }
    return lx_settings_set(&self->settings, assignment, error);
}

/* Scheduling makes every moment on a GPIO line uncertain by milliseconds, so that 13 us of silence
   mean nothing there. The simulated wire has the encoder's own timeout. */
static int settle_timeout(struct biss_session *self, const struct options *options,
                          struct lx_error *error)
{
    if (!biss_on_gpio(options)) {
        return self->model.timeout == 0
                   ? 0
                   : lx_fail(error, "--set timeout_us: only with --gpio; the simulated wire has "
                                    "the encoder's own timeout");
    }
    if (self->model.timeout == 0) {
        self->model.timeout = GPIO_TIMEOUT;
    }
    return 0;
}

static int understand(struct biss_session *self, const struct options *options,
                      struct lx_error *error)
{
    uint64_t serial = 0;

    self->model = *dg_device_find(options->model)->biss;
    lx_settings_init(&self->settings, NULL);
    for (size_t i = 0; i < options->set_count; i++) {
        if (set(self, options->sets[i], error) != 0) {
            return -1;
        }
    }
    if (settle_timeout(self, options, error) != 0) {
        return -1;
    }
    if (options->serial == NULL) {
        return 0;
    }
    if (!lx_unsigned_parse(options->serial, &serial) || serial > UINT32_MAX) {
        return lx_fail(error, "--serial %s: 0..4294967295 is right", options->serial);
    }
    self->model.serial = (uint32_t)serial;
    return 0;
}

/* A new file gets the delivery state. */
static int open_memory(struct biss_session *self, const char *path, struct dg_nvm *nvm,
                       struct lx_error *error)
{
    if (lx_nvm_memory_init(&self->memory, dg_store_size(&dg_biss_layout)) != 0) {
        return lx_fail(error, "no memory for the EEPROM");
    }
    *nvm = lx_nvm_memory_port(&self->memory);
    if (dg_biss_format(*nvm) != DG_OK) {
        return lx_fail(error, "the EEPROM cannot be formatted");
    }
    if (path == NULL) {
        return 0;
    }
    const struct lx_nvm_image image = {self->memory.bytes, self->memory.size};
    if (lx_nvm_file_open(&self->file, path, &image, error) != 0) {
        return -1;
    }
    *nvm = lx_nvm_file_port(&self->file);
    return 0;
}

static int power_on(struct biss_session *self, const struct options *options, dg_ns now,
                    struct lx_error *error)
{
    struct dg_biss_setup setup = {.model = &self->model, .world = &self->settings.world};

    if (open_memory(self, options->nvm, &setup.nvm, error) != 0) {
        return -1;
    }
    self->settings.world.angle = dg_motion_angle;
    self->settings.world.angle_ctx = &self->shaft.motion;
    self->shaft.motion.start = dg_after(now, self->model.init);
    if (dg_biss_init(&self->device, &setup) != DG_OK) {
        return lx_fail(error, "these factory figures make no encoder");
    }
    if (dg_biss_power_on(&self->device, now) != DG_OK) {
        return lx_fail(error, "--nvm %s: not the EEPROM of a BiSS encoder; another name is right",
                       options->nvm == NULL ? "" : options->nvm);
    }
    return 0;
}

int biss_session_open(struct biss_session *self, const struct options *options, dg_ns now,
                      struct lx_error *error)
{
    const char *shaft = options->shaft == NULL ? "0" : options->shaft;

    *self = (struct biss_session){.file = {.fd = -1}};
    if (understand(self, options, error) != 0) {
        return EXIT_USAGE;
    }
    const int parsed = lx_shaft_parse(&self->shaft, shaft, error);
    if (parsed != 0) {
        return parsed == LX_SHAFT_WORDS ? EXIT_USAGE : EXIT_OTHER;
    }
    if (power_on(self, options, now, error) != 0) {
        return EXIT_OTHER;
    }
    if (options->trace != NULL) {
        self->trace = fopen(options->trace, "w");
        if (self->trace == NULL) {
            (void)lx_fail(error, "--trace %s: %s", options->trace, strerror(errno));
            return EXIT_OTHER;
        }
    }
    biss_wire_init(&self->wire, &self->device, now, self->trace);
    return 0;
}

int biss_session_close(struct biss_session *self, struct lx_error *error)
{
    int status = 0;

    dg_biss_power_off(&self->device);
    if (self->trace != NULL) {
        const bool failed = ferror(self->trace) != 0;
        if (fclose(self->trace) != 0 || failed) {
            (void)lx_fail(error, "--trace: cannot be written: %s", strerror(errno));
            status = EXIT_OTHER;
        }
    }
    lx_nvm_file_close(&self->file);
    lx_nvm_memory_free(&self->memory);
    lx_shaft_free(&self->shaft);
    return status;
}

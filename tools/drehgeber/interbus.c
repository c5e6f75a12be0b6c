/* SPDX-License-Identifier: MIT */
/* A ring of INTERBUS encoders on one shaft, behind a Modbus/TCP coupler. */
#include "interbus.h"

#include <stdlib.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "modbus.h"
#include "modbus_settings.h"
#include "run.h"
#include "shaft.h"

#define DEFAULT_ADDRESS "127.0.0.1:5020"

/* Everything a running coupler consists of. */
struct plant {
    const struct options *options;
    struct lx_ring_settings settings;
    const struct dg_ib_model *models[DG_IB_RING_MAX];
    size_t count;
    struct lx_shaft shaft;
    struct lx_ring ring;
    struct lx_modbus coupler;
    sd_event *event;
};

bool is_interbus(const struct options *options)
{
    const struct dg_device *device = options->model == NULL ? NULL : dg_device_find(options->model);
    return options->ring != NULL || (device != NULL && device->stack == DG_STACK_INTERBUS);
}

/* Append the model of `n` characters. */
static int take_model(struct plant *self, const char *name, size_t n, struct lx_error *error)
{
    char text[32] = "";
    if (n < sizeof text) {
        memcpy(text, name, n);
    }
    const struct dg_device *device = dg_device_find(text);
    if (device == NULL || device->stack != DG_STACK_INTERBUS) {
        return lx_fail(error,
                       "%.*s: no INTERBUS model; valid: ocd-ib-k1 ocd-ib-k2 ocd-ib-k3, several "
                       "after --ring with commas between them",
                       (int)n, name);
    }
    if (self->count == DG_IB_RING_MAX) {
        return lx_fail(error, "--ring: more than %u devices", DG_IB_RING_MAX);
    }
    self->models[self->count++] = device->interbus;
    return 0;
}

/* The devices: of --ring, or the model alone. */
static int take_models(struct plant *self, struct lx_error *error)
{
    const char *list = self->options->ring;
    if (self->options->model != NULL &&
        take_model(self, self->options->model, strlen(self->options->model), error) != 0) {
        return -1;
    }
    if (list == NULL) {
        return self->count > 0 ? 0
                               : lx_fail(error, "map needs a model; right is 'drehgeber map "
                                                "ocd-ib-k3' or 'map --ring MODEL,MODEL'");
    }
    self->count = 0;
    for (;;) {
        const size_t n = strcspn(list, ",");
        if (take_model(self, list, n, error) != 0) {
            return -1;
        }
        if (list[n] == '\0') {
            return 0;
        }
        list += n + 1;
    }
}

/* The user's words become figures. */
static int understand(struct plant *self, struct lx_error *error)
{
    const struct options *options = self->options;
    lx_ring_settings_init(&self->settings);
    if (take_models(self, error) != 0) {
        return -1;
    }
    if (options->wire != NULL && strcmp(options->wire->name, "modbus") != 0) {
        return lx_fail(error, "--%s is no wire of an INTERBUS encoder; right is --modbus HOST:PORT",
                       options->wire->name);
    }
    if (options->where != NULL && !lx_modbus_address_fits(options->where)) {
        return lx_fail(error, "--modbus %s: HOST:PORT is right, e.g. %s", options->where,
                       DEFAULT_ADDRESS);
    }
    for (size_t i = 0; i < options->set_count; i++) {
        if (lx_ring_settings_set(&self->settings, options->sets[i], error) != 0) {
            return -1;
        }
    }
    return options->serial == NULL
               ? 0
               : lx_ring_settings_serial(&self->settings, options->serial, error);
}

/* From here on the ring cycles. Time 0 of the motion is now. */
static int switch_on(struct plant *self, struct lx_error *error)
{
    const struct options *options = self->options;
    const struct lx_ring_setup ring = {
        .models = self->models,
        .count = self->count,
        .settings = &self->settings,
        .nvm = options->nvm,
        .say = &options->say,
    };
    const struct lx_modbus_setup coupler = {
        .event = self->event,
        .where = options->where == NULL ? DEFAULT_ADDRESS : options->where,
        .ring = &self->ring,
        .settings = &self->settings,
    };
    const dg_ns now = lx_now();
    struct dg_world *world = &self->settings.common.world;
    self->shaft.motion.start = now;
    world->angle = dg_motion_angle;
    world->angle_ctx = &self->shaft.motion;
    if (lx_ring_open(&self->ring, &ring, now, error) != 0) {
        return -1;
    }
    return lx_modbus_open(&self->coupler, &coupler, now, error);
}

static int live(struct plant *self, struct lx_error *error)
{
    const struct options *options = self->options;
    const char *name = options->model == NULL ? options->ring : options->model;
    if (run_make_loop(&self->event, error) != 0 || switch_on(self, error) != 0 ||
        run_announce(name, "modbus", self->coupler.address, error) != 0) {
        return run_complain(error, EXIT_OTHER);
    }
    return run_loop(self->event, error);
}

/* Too large for the stack of some machines. */
static struct plant *new_plant(const struct options *options)
{
    struct plant *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->options = options;
        self->ring.file.fd = -1;
        self->coupler.listener = -1;
    }
    return self;
}

int run_interbus(const struct options *options)
{
    struct lx_error error = {""};
    struct plant *self = new_plant(options);
    if (self == NULL) {
        (void)lx_fail(&error, "no memory");
        return run_complain(&error, EXIT_OTHER);
    }
    int status = EXIT_USAGE;
    const char *shaft = options->shaft == NULL ? "0" : options->shaft;
    if (understand(self, &error) != 0) {
        status = run_complain(&error, EXIT_USAGE);
    } else {
        const int parsed = lx_shaft_parse(&self->shaft, shaft, &error);
        status = parsed == 0
                     ? live(self, &error)
                     : run_complain(&error, parsed == LX_SHAFT_WORDS ? EXIT_USAGE : EXIT_OTHER);
        lx_modbus_close(&self->coupler);
        lx_ring_close(&self->ring);
        lx_shaft_free(&self->shaft);
    }
    self->event = sd_event_unref(self->event);
    free(self);
    return status;
}

int print_map(const struct options *options)
{
    struct lx_error error = {""};
    struct plant *self = new_plant(options);
    int status = EXIT_OK;
    if (self == NULL) {
        (void)lx_fail(&error, "no memory");
        status = run_complain(&error, EXIT_OTHER);
    } else if (understand(self, &error) != 0) {
        status = run_complain(&error, EXIT_USAGE);
    } else {
        lx_map_print(self->models, self->count, stdout);
    }
    free(self);
    return status;
}

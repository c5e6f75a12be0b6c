/* SPDX-License-Identifier: MIT */
#include "biss_session.h"

#include "drehgeber/devices.h"
#include "run.h"
#include "sim_settings.h"

/* Shown of an idle wire in front of the first edge. */
#define TRACE_AHEAD DG_US(1)

static int take_set(struct biss_session *self, const char *assignment, struct lx_error *error)
{
    return lx_sim_settings_has(assignment)
               ? lx_sim_settings_set(&self->timing, assignment, error)
               : lx_biss_settings_set(&self->settings, assignment, error);
}

static int understand(struct biss_session *self, const struct options *options,
                      struct lx_error *error)
{
    lx_biss_settings_init(&self->settings, dg_biss_model_of(dg_device_find(options->model)));
    lx_sim_settings_init(&self->timing);
    for (size_t i = 0; i < options->set_count; i++) {
        if (take_set(self, options->sets[i], error) != 0) {
            return -1;
        }
    }
    if (self->settings.model.timeout != 0) {
        return lx_fail(error, "--set timeout_us: only with --gpio; the simulated wire has the "
                              "encoder's own timeout");
    }
    if (lx_biss_settings_check(&self->settings, error) != 0) {
        return -1;
    }
    return options->serial == NULL
               ? 0
               : lx_biss_settings_serial(&self->settings, options->serial, error);
}

static int power_on(struct biss_session *self, const struct options *options, dg_ns now,
                    struct lx_error *error)
{
    struct dg_world *world = &self->settings.common.world;
    if (lx_biss_eeprom_open(&self->eeprom, options->nvm, error) != 0) {
        return -1;
    }
    const struct dg_biss_setup setup = {&self->settings.model, world, self->eeprom.nvm};
    world->angle = dg_motion_angle;
    world->angle_ctx = &self->shaft.motion;
    self->shaft.motion.start = dg_after(now, self->settings.model.init);
    return lx_biss_switch_on(&self->device, &setup, now, options->nvm, error);
}

/* The initialisation, in which nothing happens on the wire, is not in it. */
static int open_trace(struct biss_session *self, const struct options *options, dg_ns ready,
                      struct lx_error *error)
{
    const struct lx_trace_setup trace = {
        .path = options->trace,
        .stack = &dg_biss_stack,
        .wire = options->model,
        .tap = &self->tap,
    };
    self->trace = lx_trace_open(&trace, ready, error);
    lx_sim_master_pause(&self->master, dg_after(ready, TRACE_AHEAD));
    return self->trace == NULL ? EXIT_OTHER : 0;
}

int biss_session_open(struct biss_session *self, const struct options *options, dg_ns now,
                      struct lx_error *error)
{
    const char *shaft = options->shaft == NULL ? "0" : options->shaft;

    *self = (struct biss_session){.eeprom = {.file = {.fd = -1}}};
    if (understand(self, options, error) != 0) {
        return EXIT_USAGE;
    }
    const int parsed = lx_shaft_parse(&self->shaft, shaft, NULL, error);
    if (parsed != 0) {
        return parsed == LX_SHAFT_WORDS ? EXIT_USAGE : EXIT_OTHER;
    }
    if (power_on(self, options, now, error) != 0) {
        return EXIT_OTHER;
    }
    const dg_ns ready = dg_after(now, self->settings.model.init);
    lx_biss_line_init(&self->line);
    lx_biss_line_add(&self->line, &self->device, NULL, options->model);
    lx_sim_master_init(&self->master, &self->tap, &self->line.base, &self->timing, now);
    lx_sim_master_pause(&self->master, ready);
    return options->trace == NULL ? 0 : open_trace(self, options, ready, error);
}

int biss_session_close(struct biss_session *self, struct lx_error *error)
{
    dg_biss_power_off(&self->device);
    const int result = lx_trace_close(self->trace, error);
    lx_biss_eeprom_close(&self->eeprom);
    lx_shaft_free(&self->shaft);
    return result == 0 ? 0 : EXIT_OTHER;
}

/* SPDX-License-Identifier: MIT */
#include "biss_session.h"

#include "drehgeber/devices.h"
#include "run.h"

static int understand(struct biss_session *self, const struct options *options,
                      struct lx_error *error)
{
    lx_biss_settings_init(&self->settings, dg_device_find(options->model)->biss);
    for (size_t i = 0; i < options->set_count; i++) {
        if (lx_biss_settings_set(&self->settings, options->sets[i], error) != 0) {
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

int biss_session_open(struct biss_session *self, const struct options *options, dg_ns now,
                      struct lx_error *error)
{
    const char *shaft = options->shaft == NULL ? "0" : options->shaft;

    *self = (struct biss_session){.eeprom = {.file = {.fd = -1}}};
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
    lx_sim_master_init(&self->master, &self->tap, now);
    lx_sim_master_add(&self->master, &self->device, NULL, options->model);
    if (options->trace != NULL) {
        self->trace =
            lx_trace_open(options->trace, DG_STACK_BISS, options->model, &self->tap, now, error);
        return self->trace == NULL ? EXIT_OTHER : 0;
    }
    return 0;
}

int biss_session_close(struct biss_session *self, struct lx_error *error)
{
    dg_biss_power_off(&self->device);
    const int result = lx_trace_close(self->trace, error);
    lx_biss_eeprom_close(&self->eeprom);
    lx_shaft_free(&self->shaft);
    return result == 0 ? 0 : EXIT_OTHER;
}

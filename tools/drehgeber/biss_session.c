/* SPDX-License-Identifier: MIT */
#include "biss_session.h"

#include <string.h>

#include "drehgeber/devices.h"
#include "run.h"
#include "sim_settings.h"

/* Shown of an idle wire in front of the first edge. */
#define TRACE_AHEAD DG_US(1)

static int understand(struct biss_session *self, const struct options *options,
                      struct lx_error *error)
{
    if (options_plan(options, &self->plan, error) != 0) {
        return -1;
    }
    const struct lx_plan *plan = &self->plan;
    const struct lx_plan_encoder *encoder = &plan->encoders[0];
    const struct lx_plan_wire *wire = &plan->wires[0];
    dg_world_init(&self->world);
    self->timing = lx_sim_timing;
    return lx_stack_settings(plan, wire, encoder, &self->model, &self->world, error) == 0 &&
                   lx_biss_own_timeout(plan, encoder, &self->model, error) == 0 &&
                   lx_wire_settings(&lx_sim_keys, plan, wire, &self->timing, error) == 0
               ? 0
               : -1;
}

static int power_on(struct biss_session *self, const struct options *options, dg_ns now,
                    struct lx_error *error)
{
    struct dg_world *world = &self->world;
    const struct lx_image_setup image = {options->nvm, .say = &options->say};
    if (lx_biss_memory_open(&self->memory, &self->model, &image, error) != 0) {
        return lx_about(error, LX_ABOUT_KEY, "nvm", NULL);
    }
    const struct dg_biss_setup setup = {&self->model, world, self->memory.part.device.nvm};
    world->angle = dg_motion_angle;
    world->angle_ctx = &self->shaft.motion;
    self->shaft.motion.start = dg_after(now, self->model.init);
    return lx_biss_switch_on(&self->device, &setup, now, error);
}

/* The initialisation, in which nothing happens on the wire, is not in it. */
static int open_trace(struct biss_session *self, const struct options *options, dg_ns ready,
                      struct lx_error *error)
{
    const struct lx_trace_setup trace = {
        .path = options->trace,
        .kind = lx_biss_stack.trace,
        .wire = options->model,
        .tap = &self->tap,
    };
    self->trace = lx_trace_open(&trace, ready, error);
    lx_sim_master_pause(&self->master, dg_after(ready, TRACE_AHEAD));
    if (self->trace == NULL) {
        (void)lx_about(error, LX_ABOUT_KEY, "trace", NULL);
        return EXIT_OTHER;
    }
    return 0;
}

int biss_session_open(struct biss_session *self, const struct options *options, dg_ns now,
                      struct lx_error *error)
{
    const char *shaft = options->shaft == NULL ? "0" : options->shaft;

    memset(self, 0, sizeof *self);
    if (understand(self, options, error) != 0) {
        return EXIT_USAGE;
    }
    const int parsed = lx_shaft_parse(&self->shaft, shaft, NULL, error);
    if (parsed != 0) {
        (void)lx_about(error, LX_ABOUT_KEY, "motion", NULL);
        return parsed == LX_SHAFT_WORDS ? EXIT_USAGE : EXIT_OTHER;
    }
    if (power_on(self, options, now, error) != 0) {
        return EXIT_OTHER;
    }
    const dg_ns ready = dg_after(now, self->model.init);
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
    lx_image_close(&self->memory.image);
    lx_shaft_free(&self->shaft);
    lx_plan_free(&self->plan);
    return result == 0 ? 0 : EXIT_OTHER;
}

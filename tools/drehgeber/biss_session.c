/* SPDX-License-Identifier: MIT */
#include "biss_session.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

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
    if (dg_biss_init(&self->device, &setup) != DG_OK) {
        return lx_fail(error, "these factory figures make no encoder");
    }
    if (dg_biss_power_on(&self->device, now) != DG_OK) {
        return lx_fail(error, "--nvm %s: not the EEPROM of a BiSS encoder; another name is right",
                       options->nvm == NULL ? "" : options->nvm);
    }
    return 0;
}

/* Value change dump (IEEE 1364): two wires, nanoseconds. */
static void begin_trace(const struct biss_session *self)
{
    (void)fprintf(self->trace,
                  "$timescale 1 ns $end\n$scope module biss $end\n"
                  "$var wire 1 m MA $end\n$var wire 1 s SLO $end\n"
                  "$upscope $end\n$enddefinitions $end\n"
                  "#%" PRIu64 "\n$dumpvars\n1m\n1s\n$end\n",
                  self->wire.now);
}

static void record(void *ctx, dg_ns at, bool ma, bool slo)
{
    const struct biss_session *self = ctx;
    (void)fprintf(self->trace, "#%" PRIu64 "\n%dm\n%ds\n", at, ma, slo);
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
    if (options->trace != NULL) {
        self->trace = fopen(options->trace, "w");
        if (self->trace == NULL) {
            (void)lx_fail(error, "--trace %s: %s", options->trace, strerror(errno));
            return EXIT_OTHER;
        }
    }
    lx_biss_wire_init(&self->wire, now);
    lx_biss_wire_add(&self->wire, &self->device, NULL);
    if (self->trace != NULL) {
        begin_trace(self);
        self->wire.levels = record;
        self->wire.ctx = self;
    }
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
    lx_biss_eeprom_close(&self->eeprom);
    lx_shaft_free(&self->shaft);
    return status;
}

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "run.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <systemd/sd-daemon.h>
#include <systemd/sd-event.h>

#include "canopen.h"
#include "drehgeber/devices.h"
#include "settings.h"
#include "shaft.h"
#include "timer.h"

/* Everything a running encoder consists of. */
struct rig {
    const struct options *options;
    const struct wire *wire;
    struct lx_settings settings;
    struct lx_shaft shaft;
    struct lx_plan plan; /* RS485: one encoder on its own line */
    struct lx_station station;
    struct lx_bus *bus;
    struct lx_can_nodes nodes; /* CANopen: instead of these */
    struct lx_can_nodes_setup nodes_setup;
    struct dg_cia406_model cia406;
    const struct dg_device *device;
    sd_event *event;
};

int run_complain(const struct lx_error *error, int status)
{
    lx_complain("%s", error->text);
    return status;
}

static int unknown_model(const struct options *options, struct lx_error *error)
{
    struct lx_error names = {""};
    size_t used = 0;
    for (size_t i = 0; i < dg_device_count && used < sizeof names.text; i++) {
        const int n =
            snprintf(names.text + used, sizeof names.text - used, " %s", dg_devices[i].name);
        used += n > 0 ? (size_t)n : 0u;
    }
    if (options->model == NULL) {
        return lx_fail(error, "run needs a model; valid:%s", names.text);
    }
    return lx_fail(error, "unknown model %s; valid:%s", options->model, names.text);
}

/* The user's words become figures. */
static int understand(struct rig *self, struct lx_error *error)
{
    const struct options *options = self->options;
    const struct dg_device *device = options->model == NULL ? NULL : dg_device_find(options->model);
    if (device == NULL) {
        return unknown_model(options, error);
    }
    self->device = device;
    self->wire = options_wire(options, device->stack, error);
    if (self->wire == NULL) {
        return -1;
    }
    lx_settings_init(&self->settings, device->hiperface);
    if (device->stack == DG_STACK_CANOPEN) {
        self->cia406 = *device->cia406;
    }
    for (size_t i = 0; i < options->set_count; i++) {
        const int taken = device->stack == DG_STACK_CANOPEN
                              ? canopen_set(&self->cia406, options->sets[i], error)
                              : 0;
        if (taken < 0 ||
            (taken == 0 && lx_settings_set(&self->settings, options->sets[i], error) != 0)) {
            return -1;
        }
    }
    if (device->stack == DG_STACK_CANOPEN) {
        return canopen_understand(options, &self->nodes_setup, error);
    }
    if (options->node != NULL) {
        return lx_fail(error, "--node %s: only CANopen encoders have a node-ID", options->node);
    }
    if (options->serial != NULL &&
        lx_settings_serial(&self->settings, options->serial, error) != 0) {
        return -1;
    }
    return lx_settings_check(&self->settings, error);
}

/* Blocked from here on and read by the loop: no way out that leaves a link behind. A closed stdout
   or a file size limit is an errno then, not the end. */
static int take_signals(sd_event *event)
{
    sigset_t stop;
    (void)sigemptyset(&stop);
    (void)sigaddset(&stop, SIGTERM);
    (void)sigaddset(&stop, SIGINT);
    const struct sigaction ignore = {.sa_handler = SIG_IGN};
    if (sigprocmask(SIG_BLOCK, &stop, NULL) != 0 || sigaction(SIGPIPE, &ignore, NULL) != 0 ||
        sigaction(SIGXFSZ, &ignore, NULL) != 0) {
        return -errno;
    }
    /* Without a handler of its own a signal ends the loop with 0. */
    const int result = sd_event_add_signal(event, NULL, SIGTERM, NULL, NULL);
    return result < 0 ? result : sd_event_add_signal(event, NULL, SIGINT, NULL, NULL);
}

int run_make_loop(sd_event **event, struct lx_error *error)
{
    int result = sd_event_new(event);
    if (result >= 0) {
        result = take_signals(*event);
    }
    return result < 0 ? lx_fail(error, "no event loop: %s", strerror(-result)) : 0;
}

static int plan_rs485(struct rig *self, struct lx_error *error)
{
    const struct options *options = self->options;
    static const struct lx_wire kind = {.stack = DG_STACK_HIPERFACE};
    if (lx_plan_add_wire(&self->plan, options->model, &kind, options->where) < 0 ||
        lx_plan_add_encoder(&self->plan, options->model, self->device, 0, 0) < 0) {
        return lx_fail(error, "no memory");
    }
    struct lx_plan_encoder *encoder = self->plan.encoders;
    encoder->nvm = options->nvm == NULL ? NULL : strdup(options->nvm);
    encoder->serial = options->serial == NULL ? NULL : strdup(options->serial);
    for (size_t i = 0; i < options->set_count; i++) {
        if (lx_plan_add_setting(&encoder->settings, options->sets[i], 0, error) != 0) {
            return -1;
        }
    }
    return 0;
}

static int switch_on_rs485(struct rig *self, dg_ns now, struct lx_error *error)
{
    struct lx_station *stations[] = {&self->station};
    if (plan_rs485(self, error) != 0) {
        return -1;
    }
    const struct lx_bus_setup setup = {
        .event = self->event,
        .say = &self->options->say,
        .plan = &self->plan,
        .wire = self->plan.wires,
        .stations = stations,
        .count = 1,
    };
    self->station.world = self->settings.world;
    self->station.plan = self->plan.encoders;
    self->bus = self->wire->make(&setup, error);
    return self->bus == NULL ? -1 : self->bus->ops->open(self->bus, now, error);
}

static int switch_on_canopen(struct rig *self, dg_ns now, struct lx_error *error)
{
    struct lx_can_nodes_setup *setup = &self->nodes_setup;
    setup->event = self->event;
    setup->say = &self->options->say;
    setup->model = &self->cia406;
    setup->world = &self->settings.world;
    setup->open = self->wire->can;
    setup->where = self->options->where;
    setup->nvm = self->options->nvm;
    return lx_can_nodes_open(&self->nodes, setup, now, error);
}

/* From here on the encoder answers. Time 0 of the motion is now. */
static int switch_on(struct rig *self, struct lx_error *error)
{
    const dg_ns now = lx_now();
    self->shaft.motion.start = now;
    self->settings.world.angle = dg_motion_angle;
    self->settings.world.angle_ctx = &self->shaft.motion;
    return self->device->stack == DG_STACK_CANOPEN ? switch_on_canopen(self, now, error)
                                                   : switch_on_rs485(self, now, error);
}

int run_announce(const char *model, const char *wire, const char *address, struct lx_error *error)
{
    if (printf("ready %s %s:%s\n", model, wire, address) < 0 || fflush(stdout) != 0) {
        return lx_fail(error, "cannot write the ready line to stdout: %s", strerror(errno));
    }
    (void)sd_notify(0, "READY=1");
    return 0;
}

/* One line for each encoder. */
static int announce(const struct rig *self, struct lx_error *error)
{
    const char *model = self->options->model;
    char address[LX_BUS_ADDRESS_MAX];
    int result = 0;
    if (self->device->stack == DG_STACK_HIPERFACE) {
        self->bus->ops->address(self->bus, &self->station, address, sizeof address);
        return run_announce(model, self->wire->name, address, error);
    }
    for (unsigned i = 0; result == 0 && i < self->nodes.count; i++) {
        (void)snprintf(address, sizeof address, "%s/%u", self->nodes.bus->address,
                       (unsigned)self->nodes.node[i].device.id);
        result = run_announce(model, self->wire->name, address, error);
    }
    return result;
}

int run_loop(sd_event *event, struct lx_error *error)
{
    const int result = sd_event_loop(event);
    (void)sd_notify(0, "STOPPING=1");
    if (result < 0) {
        (void)lx_fail(error, "the event loop failed: %s", strerror(-result));
        return run_complain(error, EXIT_OTHER);
    }
    return result;
}

static int live(struct rig *self, struct lx_error *error)
{
    if (run_make_loop(&self->event, error) != 0 || switch_on(self, error) != 0 ||
        announce(self, error) != 0) {
        return run_complain(error, EXIT_OTHER);
    }
    return run_loop(self->event, error);
}

int run_encoder(const struct options *options)
{
    struct rig self = {.options = options};
    struct lx_error error;
    if (understand(&self, &error) != 0) {
        return run_complain(&error, EXIT_USAGE);
    }
    const char *shaft = options->shaft == NULL ? "0" : options->shaft;
    const int parsed = lx_shaft_parse(&self.shaft, shaft, &error);
    if (parsed != 0) {
        return run_complain(&error, parsed == LX_SHAFT_WORDS ? EXIT_USAGE : EXIT_OTHER);
    }
    const int status = live(&self, &error);
    lx_can_nodes_close(&self.nodes);
    if (self.bus != NULL) {
        self.bus->ops->close(self.bus);
    }
    lx_plan_free(&self.plan);
    lx_shaft_free(&self.shaft);
    self.event = sd_event_unref(self.event);
    return status;
}

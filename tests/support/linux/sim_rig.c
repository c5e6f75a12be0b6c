/* SPDX-License-Identifier: MIT */
#include "sim_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"
#include "stacks.h"
#include "station_rig.h"
#include "timer.h"

#define MODEL "s3684-biss"

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct sim_heard *self = ctx;
    self->disordered = self->disordered || event->at < self->last;
    self->last = event->at;
    if (event->kind == DG_TAP_LEVELS) {
        self->edges += event->levels.clock != self->ma;
        self->ma = event->levels.clock;
        if (self->count < SIM_RIG_LEVELS_MAX) {
            self->level[self->count].at = event->at;
            self->level[self->count].ma = event->levels.clock;
            self->level[self->count++].slo = event->levels.data;
        }
        return;
    }
    assert_int_equal(event->kind, DG_TAP_NOTE);
    self->notes++;
    (void)snprintf(self->note, sizeof self->note, "%s", event->note);
}

void sim_rig_plan(struct sim_rig *self, size_t count)
{
    *self = (struct sim_rig){.say = {.quiet = true}, .clock = {.virtual_ = SIM_RIG_POWER_ON}};
    plan_rig_begin(&self->plan, "wire", dg_plan_find_kind("sim", 3), NULL);
    for (size_t i = 0; i < count; i++) {
        char name[24];
        (void)snprintf(name, sizeof name, "b%zu", i);
        assert_int_equal(dg_plan_add_encoder(&self->plan, name, dg_device_find(MODEL), 0, 0),
                         (int)i);
    }
}

void sim_rig_prepare(struct sim_rig *self)
{
    assert_true(sd_event_new(&self->event) >= 0);
    self->clock.real = lx_now();
    self->setup = station_setup(&self->plan, self->event, &self->clock);
    self->setup.bus.say = &self->say;
}

void sim_rig_make(struct sim_rig *self)
{
    struct lx_error error = {.right = ""};
    assert_int_equal(lx_engine_make(&self->engine, &self->setup, &error), 0);
    self->bus = self->engine.wires[0].bus;
    self->station = self->engine.stations;
    for (size_t i = 0; i < self->plan.encoder_count; i++) {
        station_turn(&self->station[i], &self->shaft[i]);
    }
}

struct lx_words sim_rig_refused(struct sim_rig *self)
{
    struct lx_error error = {.right = ""};
    assert_int_equal(lx_engine_make(&self->engine, &self->setup, &error), -1);
    lx_engine_close(&self->engine);
    return lx_error_line(&error);
}

void sim_rig_step_to(struct sim_rig *self, dg_ns now)
{
    self->clock.virtual_ = now;
    self->bus->ops->changed(self->bus, NULL, now);
}

void sim_rig_open(struct sim_rig *self)
{
    struct lx_error error = {.right = ""};
    sim_rig_prepare(self);
    sim_rig_make(self);
    assert_int_equal(self->bus->ops->open(self->bus, SIM_RIG_POWER_ON, &error), 0);
    self->heard.listener = (struct lx_tap_listener){.event = on_event, .ctx = &self->heard};
    self->heard.ma = true;
    lx_tap_add(&self->bus->tap, &self->heard.listener);
    sim_rig_step_to(self, SIM_RIG_READY);
}

void sim_rig_close(struct sim_rig *self)
{
    assert_false(self->heard.disordered);
    assert_int_equal(self->bus->late, 0);
    lx_engine_close(&self->engine);
    self->event = sd_event_unref(self->event);
    plan_rig_free(&self->plan);
}

int sim_rig_frame(struct sim_rig *self, size_t place)
{
    const struct dg_encoder *encoder = self->station[place].control;
    const struct dg_biss_port_ops *port = encoder->port;

    return port->frame(encoder->port_ctx, &self->bits, &self->count, self->detail);
}

/* MT:ST of the last frame. */
uint64_t sim_rig_position(const struct sim_rig *self)
{
    return self->bits >> 14 & (((uint64_t)1 << 33) - 1u);
}

bool sim_rig_crc_ok(const struct sim_rig *self)
{
    const uint64_t data = self->bits >> 6 & (((uint64_t)1 << 41) - 1u);
    return biss_rig_crc6(data, 41) == (self->bits & 0x3Fu);
}

int sim_rig_read(struct sim_rig *self, size_t place, uint8_t address, uint8_t *bytes, size_t n)
{
    const struct dg_encoder *encoder = self->station[place].control;
    const struct dg_biss_port_ops *port = encoder->port;

    return port->read(encoder->port_ctx, address, bytes, n, self->detail);
}

int sim_rig_write(struct sim_rig *self, size_t place, uint8_t address, const uint8_t *bytes,
                  size_t n)
{
    const struct dg_encoder *encoder = self->station[place].control;
    const struct dg_biss_port_ops *port = encoder->port;

    return port->write(encoder->port_ctx, address, bytes, n, self->detail);
}

void sim_rig_bend(struct sim_rig *self, size_t place, enum dg_wire_fault fault, uint32_t count)
{
    station_bend(&self->station[place], self->clock.virtual_, fault, count);
}

/* SPDX-License-Identifier: MIT */
#include "modbus_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "station_rig.h"

/* Makers know nothing of who asks. */
static struct modbus_rig *making;

static void close_bus(struct lx_bus *bus)
{
    free(bus);
}

static struct lx_bus *make_bus(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                               struct lx_error *error)
{
    static const struct lx_bus_ops ops = {.close = close_bus};
    struct lx_bus *bus = calloc(1, sizeof *bus);
    (void)error;
    assert_non_null(bus);
    bus->ops = &ops;
    bus->setup = *setup;
    to->ops = &lx_ring_ops;
    to->ctx = &making->ring;
    return bus;
}

void modbus_rig_plan(struct modbus_rig *self, const struct dg_device *const *models, size_t count)
{
    *self = (struct modbus_rig){.plan = {.file = NULL}};
    plan_rig_begin(&self->plan, "ring", dg_plan_find_kind("modbus", 6), NULL);
    for (size_t i = 0; i < count; i++) {
        char name[24];
        (void)snprintf(name, sizeof name, "k%zu", i);
        assert_int_equal(dg_plan_add_encoder(&self->plan, name, models[i], 0, 0), (int)i);
    }
}

void modbus_rig_set(struct modbus_rig *self, size_t index, const char *assignment)
{
    struct lx_error error;
    assert_int_equal(
        lx_plan_add_assignment(&self->plan.encoders[index].settings, assignment, 0, &error), 0);
}

int modbus_rig_open(struct modbus_rig *self, dg_angle (*angle)(void *ctx, dg_ns now), void *ctx,
                    dg_ns now, struct lx_error *error)
{
    static const struct lx_wire door = {.make = make_bus};
    struct lx_engine_setup setup = station_setup(&self->plan, NULL, NULL);
    setup.door = &door;
    making = self;
    assert_int_equal(lx_engine_make(&self->engine, &setup, error), 0);
    for (size_t i = 0; angle != NULL && i < self->plan.encoder_count; i++) {
        struct dg_world *world = self->engine.stations[i].control->world;
        world->angle = angle;
        world->angle_ctx = ctx;
        world->calm = NULL;
    }
    const struct lx_bus *bus = self->engine.wires[0].bus;
    const struct lx_ring_setup ring = {
        .bus = &bus->setup, .core = bus->core, .tap = &bus->tap, .cycle = DG_S(3600)};
    return lx_ring_open(&self->ring, &ring, now, error);
}

void modbus_rig_close(struct modbus_rig *self)
{
    lx_ring_close(&self->ring);
    lx_engine_close(&self->engine);
    plan_rig_free(&self->plan);
}

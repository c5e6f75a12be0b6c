/* SPDX-License-Identifier: MIT */
#include "ib_rig.h"

#include <string.h>

static dg_angle shaft_angle(void *ctx, dg_ns now)
{
    const struct ib_rig *self = ctx;

    /* Whole milliseconds and the rest apart, modulo 2^64: nothing overflows. */
    const uint64_t whole = (uint64_t)self->angle_per_ms * (now / 1000000u);
    const int64_t rest = self->angle_per_ms * (int64_t)(now % 1000000u) / 1000000;
    return (dg_angle)((uint64_t)self->angle + whole + (uint64_t)rest);
}

int ib_rig_init(struct ib_rig *self, const struct dg_ib_model *model)
{
    memset(self, 0, sizeof *self);
    self->model = *model;
    dg_world_init(&self->world);
    self->world.angle = shaft_angle;
    self->world.angle_ctx = self;
    ram_nvm_init(&self->nvm, dg_store_size(&dg_ib_layout));
    const struct dg_ib_setup setup = {&self->model, &self->world, ram_nvm_port(&self->nvm)};
    const int result = dg_ib_format(&self->model, setup.nvm);
    return result == DG_OK ? dg_ib_init(&self->device, &setup) : result;
}

uint32_t ib_rig_cycle(struct ib_rig *self, uint32_t out)
{
    self->now += IB_RIG_CYCLE;
    dg_ib_cycle(&self->device, self->now, out, &self->in);
    return self->in;
}

int ib_rig_power_on(struct ib_rig *self)
{
    const int result = dg_ib_power_on(&self->device, self->now);
    const dg_ns ready = self->now + self->model.self_test;
    while (self->now < ready) {
        (void)ib_rig_cycle(self, 0);
    }
    return result;
}

uint32_t ib_rig_send(struct ib_rig *self, uint32_t out)
{
    for (unsigned i = 0; i <= self->model.param_cycles; i++) {
        (void)ib_rig_cycle(self, out);
    }
    return self->in;
}

uint32_t ib_rig_release(struct ib_rig *self)
{
    (void)ib_rig_cycle(self, 0x80000000);
    (void)ib_rig_cycle(self, 0);
    return ib_rig_cycle(self, 0);
}

void ib_rig_turn_to(struct ib_rig *self, int64_t counts)
{
    self->angle = counts * (DG_TURN / self->model.steps) + DG_TURN / self->model.steps / 2;
}

/* SPDX-License-Identifier: MIT */
/* Power, time, and what a host gets at. */
#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"
#include "engine_private.h"

/* ---------------------------------------------------------------- power */

/* Where the EEPROM is said to be, if that is what is wrong. */
static int refuse_start(const struct dg_engine *self, size_t index, int result,
                        struct dg_plan_error *error)
{
    const struct dg_plan_encoder *row = &self->setup.plan->encoders[index];

    if (result == DG_HOST_ERR_ARGUMENT) {
        (void)dg_plan_refuse(error, NULL, RIG_SAY("these figures make no encoder"));
    } else {
        (void)dg_plan_refuse(error, NULL, RIG_SAY("the encoder does not start: not its EEPROM"));
        (void)(row->nvm == NULL ? 0 : dg_plan_about(error, "nvm", NULL));
    }
    (void)dg_plan_stand(self->setup.plan, row->nvm != NULL ? row->nvm_line : row->line, error);
    return DG_ERR_ARGUMENT;
}

void dg_engine_know_device(struct engine_encoder *encoder)
{
    const bool made = dg_host_made(encoder->host);

    encoder->control.device = made ? dg_host_line_of(encoder->host)->device : NULL;
    encoder->control.nvm = made ? dg_host_setup(encoder->host).nvm : (struct dg_nvm){.ops = NULL};
}

int dg_engine_power_encoder(struct dg_engine *self, size_t index, dg_ns now,
                            struct dg_plan_error *error)
{
    struct engine_encoder *encoder = &self->encoders[index];
    const int result = dg_host_power(encoder->host, now, true);

    if (result != DG_HOST_OK) {
        return refuse_start(self, index, result, error);
    }
    dg_engine_know_device(encoder);
    return 0;
}

int dg_engine_power(struct dg_engine *self, dg_ns now, struct dg_plan_error *error)
{
    for (size_t i = 0; i < self->control.encoder_count; i++) {
        if (dg_engine_power_encoder(self, i, now, error) != 0) {
            return DG_ERR_ARGUMENT;
        }
    }
    for (size_t i = 0; i < self->control.encoder_count; i++) {
        (void)dg_bus_changed(dg_engine_bus_of(self, &self->encoders[i]), self->encoders[i].place,
                             now);
    }
    self->now = now > self->now ? now : self->now;
    return 0;
}

/* ---------------------------------------------------------------- time */

static dg_ns next_of_wires(const struct dg_engine *self)
{
    dg_ns next = DG_NEVER;

    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        next = dg_earliest(next, dg_bus_next(self->wires[i].bus));
    }
    return next;
}

static dg_ns next_of_faults(const struct dg_engine *self)
{
    return self->control.waits == NULL ? DG_NEVER : self->control.waits->wait.until;
}

dg_ns dg_engine_next(const struct dg_engine *self)
{
    return dg_earliest(next_of_faults(self), next_of_wires(self));
}

/* The bus of an encoder whose fault ends goes up to there by itself (dg_rig_ops.look). */
dg_ns dg_engine_step(struct dg_engine *self, dg_ns now)
{
    dg_ns next = DG_NEVER;

    if (now == DG_NEVER) {
        return dg_engine_next(self);
    }
    self->now = now > self->now ? now : self->now;
    while (next_of_faults(self) <= self->now) {
        (void)dg_rig_step(&self->control, next_of_faults(self));
    }
    for (size_t i = 0; i < self->setup.plan->wire_count; i++) {
        next = dg_earliest(next, dg_bus_step(self->wires[i].bus, self->now));
    }
    return dg_earliest(next, next_of_faults(self));
}

/* ---------------------------------------------------------------- access */

struct dg_bus *dg_engine_bus_of(const struct dg_engine *self, const struct engine_encoder *encoder)
{
    const size_t index = (size_t)(encoder - self->encoders);

    return self->wires[self->setup.plan->encoders[index].wire].bus;
}

struct dg_bus *dg_engine_bus(const struct dg_engine *self, size_t index)
{
    return self->wires[index].bus;
}

const struct dg_engine_wire *dg_engine_wire_of(const struct dg_engine *self, size_t index)
{
    return &self->wires[index].is;
}

struct dg_host *dg_engine_encoder(const struct dg_engine *self, size_t index)
{
    return self->encoders[index].host;
}

size_t dg_engine_place(const struct dg_engine *self, size_t index)
{
    return self->encoders[index].place;
}

struct dg_engine_end dg_engine_end_of(const struct dg_engine *self, size_t index)
{
    return self->encoders[index].end;
}

struct dg_rig *dg_engine_control(struct dg_engine *self)
{
    return &self->control;
}

void *dg_engine_ctx(const struct dg_rig *rig)
{
    const struct dg_engine *self = rig->host;

    return self->setup.ctx;
}

size_t dg_engine_index(const struct dg_rig *rig, const struct dg_encoder *encoder)
{
    const struct dg_engine *self = rig->host;

    return (size_t)((const struct engine_encoder *)encoder - self->encoders);
}

size_t dg_engine_shaft_index(const struct dg_rig *rig, const struct dg_rig_shaft *shaft)
{
    const struct dg_engine *self = rig->host;

    return (size_t)((const struct engine_shaft *)shaft - self->shafts);
}

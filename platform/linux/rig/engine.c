/* SPDX-License-Identifier: MIT */
/*
 * Wire by wire, in the order of the plan: what its kind says of its address, then each encoder on
 * it. What this port refuses it tells in its own words; the rest is the library's.
 */
#include "engine.h"

#include <stdlib.h>

#include "drehgeber/instruments.h"

/* --- what is refused --- */

/* About its wire, if nobody has said something nearer. Always -1. */
static int refuse_door(struct lx_engine *self)
{
    if (self->making != NULL) {
        (void)lx_plan_refuse_wire(self->setup.bus.plan, self->making, self->error);
    }
    self->told = true;
    return -1;
}

/* Of an encoder the library only names settings; but for its serial number. */
static int take_plan_error(struct lx_engine *self, const struct dg_plan_error *wrong)
{
    if (self->told) {
        return -1;
    }
    (void)lx_error_take(self->error, wrong);
    if (self->making != NULL && self->error->where.about == LX_ABOUT_KEY &&
        wrong->valued == DG_PLAN_UNVALUED) {
        self->error->where.about = LX_ABOUT_SETTING;
    }
    return refuse_door(self);
}

/* --- what the library asks --- */

/* The library has handles by now. */
static void gather_doors(struct lx_engine *self)
{
    const struct dg_plan *plan = self->setup.bus.plan;
    struct lx_station **at = self->on_wires;
    for (size_t i = 0; i < plan->wire_count; i++) {
        self->wires[i].stations = at;
        at += plan->wires[i].encoder_count;
    }
    for (size_t i = 0; i < plan->encoder_count; i++) {
        self->stations[i] = (struct lx_station){
            .plan = &plan->encoders[i],
            .host = dg_engine_encoder(self->core, i),
            .control = self->control->encoders[i],
            .place = dg_engine_place(self->core, i),
        };
        self->wires[plan->encoders[i].wire].stations[self->stations[i].place] = &self->stations[i];
    }
}

static struct lx_bus *make_door_bus(struct lx_engine *self, size_t index, struct dg_engine_wire *to)
{
    struct lx_bus_setup setup = self->setup.bus;
    setup.wire = self->making;
    setup.engine = self->core;
    setup.index = index;
    setup.stations = self->wires[index].stations;
    setup.count = self->making->encoder_count;
    setup.door = self->setup.door != NULL ? self->setup.door : lx_wire_of(setup.wire->kind);
    return setup.door->check == NULL || setup.door->check(setup.wire->where, self->error) == 0
               ? setup.door->make(&setup, to, self->error)
               : NULL;
}

static int make_wire(void *ctx, size_t index, struct dg_engine_wire *to,
                     struct dg_plan_error *ignored)
{
    struct lx_engine *self = ctx;
    struct lx_engine_wire *wire = &self->wires[index];
    (void)ignored;
    if (self->making == NULL) {
        gather_doors(self);
    }
    self->making = to->plan;
    if (self->setup.wire != NULL && self->setup.wire(self->setup.ctx, index, self->error) != 0) {
        return refuse_door(self);
    }
    wire->bus = make_door_bus(self, index, to);
    for (size_t i = 0; wire->bus != NULL && i < to->plan->encoder_count; i++) {
        wire->stations[i]->bus = wire->bus;
    }
    return wire->bus != NULL ? 0 : refuse_door(self);
}

static void *give_rows(void *ctx, size_t index, void *settings, struct dg_keys *rows)
{
    const struct lx_engine *self = ctx;
    const struct lx_station *station = &self->stations[index];
    (void)settings;
    *rows = station->rows;
    return station->base;
}

/* Several in a ring may share a file that only some have something in. */
static int check_memory(const struct lx_engine *self, const struct lx_station *station,
                        struct lx_error *error)
{
    const struct dg_plan_encoder *plan = station->plan;
    if (plan->nvm == NULL || lx_stack_of(plan->model)->is_ring ||
        dg_host_memory_size(station->host) != 0) {
        return 0;
    }
    (void)lx_refuse(error, "leave it out", "%s has no EEPROM", plan->model->name);
    return lx_plan_refuse_key(self->setup.bus.plan, "nvm", plan->nvm_line, error);
}

static int check_settings(const struct lx_engine *self, const struct lx_station *station,
                          const void *settings, struct lx_error *error)
{
    const struct lx_stack *stack = lx_stack_of(station->plan->model);
    if (stack->check == NULL || stack->check(settings, error) == 0) {
        return 0;
    }
    (void)lx_about(error, LX_ABOUT_ITSELF, "", NULL);
    return lx_plan_stands(self->setup.bus.plan, station->plan->line, error);
}

static int check_encoder(void *ctx, size_t index, const void *settings,
                         struct dg_plan_error *ignored)
{
    struct lx_engine *self = ctx;
    struct lx_station *station = &self->stations[index];
    const struct lx_bus_ops *ops = station->bus->ops;
    (void)ignored;
    return check_settings(self, station, settings, self->error) == 0 &&
                   check_memory(self, station, self->error) == 0 &&
                   (ops->check == NULL || ops->check(station->bus, station, self->error) == 0)
               ? 0
               : refuse_door(self);
}

static int find_host_motion(void *ctx, size_t index, const char *path, struct dg_motion *to,
                            struct dg_plan_error *ignored)
{
    struct lx_engine *self = ctx;
    (void)ignored;
    return self->setup.motion(self->setup.ctx, index, path, to, self->error) == 0
               ? 0
               : refuse_door(self);
}

static struct dg_rig_course *find_course(void *ctx, size_t index,
                                         const struct dg_plan_setting *setting,
                                         struct dg_plan_error *ignored)
{
    struct lx_engine *self = ctx;
    struct dg_rig_course *course = self->setup.course(self->setup.ctx, index, setting, self->error);
    (void)ignored;
    if (course == NULL) {
        (void)refuse_door(self);
    }
    return course;
}

/* --- all of it --- */

static bool make_engine_room(struct lx_engine *self, size_t size)
{
    const struct dg_plan *plan = self->setup.bus.plan;
    self->core = aligned_alloc(DG_HOST_ALIGN, size);
    self->stations = calloc(plan->encoder_count, sizeof *self->stations);
    self->on_wires = calloc(plan->encoder_count, sizeof(struct lx_station *));
    self->wires = calloc(plan->wire_count, sizeof *self->wires);
    return self->core != NULL && self->stations != NULL && self->on_wires != NULL &&
           self->wires != NULL;
}

static int make_core(struct lx_engine *self, const struct dg_engine_setup *setup)
{
    struct dg_plan_error wrong;
    const size_t size = dg_engine_size(setup);
    if (!make_engine_room(self, size)) {
        (void)lx_fail(self->error, "no memory for a rig");
        return LX_ENGINE_SCARCE;
    }
    self->control = dg_engine_control(self->core);
    return dg_engine_make(self->core, size, setup, &wrong) != NULL ? 0
                                                                   : take_plan_error(self, &wrong);
}

int lx_engine_make(struct lx_engine *self, const struct lx_engine_setup *setup,
                   struct lx_error *error)
{
    const struct dg_engine_setup core = {
        .size = sizeof core,
        .plan = setup->bus.plan,
        .begin = setup->begin,
        .memory_is_host = true,
        .instruments = dg_instruments,
        .instrument_count = dg_instrument_count,
        .ops = setup->ops,
        .wire = make_wire,
        .rows = give_rows,
        .check = check_encoder,
        .motion = setup->motion == NULL ? NULL : find_host_motion,
        .course = setup->course == NULL ? NULL : find_course,
        .ctx = self,
    };
    *self = (struct lx_engine){.setup = *setup, .error = error};
    const int result = make_core(self, &core);
    for (size_t i = 0; result == 0 && i < setup->bus.plan->wire_count; i++) {
        struct lx_bus *bus = self->wires[i].bus;
        if (bus != NULL) { /* each is there */
            bus->core = dg_engine_bus(self->core, i);
        }
    }
    return result;
}

struct lx_engine *lx_engine_of(const struct dg_rig *control)
{
    return dg_engine_ctx(control);
}

struct lx_station *lx_engine_station(const struct dg_rig *control, const struct dg_encoder *encoder)
{
    return &lx_engine_of(control)->stations[dg_engine_index(control, encoder)];
}

void lx_engine_close(struct lx_engine *self)
{
    for (size_t i = 0; self->wires != NULL && i < self->setup.bus.plan->wire_count; i++) {
        if (self->wires[i].bus != NULL) {
            self->wires[i].bus->ops->close(self->wires[i].bus);
        }
    }
    free(self->wires);
    free(self->on_wires);
    free(self->stations);
    free(self->core);
    *self = (struct lx_engine){.core = NULL};
}

/* SPDX-License-Identifier: MIT */
/* What stands where in the memory of a rig, and how much of it there is. */
#include "engine_private.h"

#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/host_wire.h"

/* Frames that wait on a bus: what one moment can make each encoder send, beside what waits for a
 * memory or for its time, and what is late by a fault: as much as a wire at 1 MBd carries until
 * then. What is not used is not touched. */
#define ROOMS_EACH 8u
#define ROOMS_LATE 4096u
#define ROOMS (DG_BUS_FRAMES_ANSWERS + DG_BUS_FRAMES_PACED + ROOMS_LATE)

_Static_assert(_Alignof(struct dg_engine) <= DG_HOST_ALIGN, "what the header asks for is enough");
_Static_assert(_Alignof(struct engine_encoder) <= DG_HOST_ALIGN, "likewise");
_Static_assert(_Alignof(struct dg_bus_frames_room) <= DG_HOST_ALIGN, "likewise");

static size_t round_up(size_t n)
{
    return (n + DG_HOST_ALIGN - 1u) / DG_HOST_ALIGN * DG_HOST_ALIGN;
}

const struct dg_bus_medium *dg_engine_medium(const struct dg_plan_wire *wire)
{
    static const struct dg_bus_medium *const media[] = {
        [DG_MEDIUM_CHARACTERS] = &dg_bus_characters,
        [DG_MEDIUM_FRAMES] = &dg_bus_frames,
        [DG_MEDIUM_EDGES] = &dg_bus_edges,
        [DG_MEDIUM_WORDS] = &dg_bus_words,
    };
    _Static_assert(DG_COUNT(media) == DG_MEDIUM_COUNT, "each has one");

    return media[wire->stack->medium];
}

size_t dg_engine_rooms(const struct dg_engine_setup *setup, size_t encoders)
{
    return setup->frames_wait != 0 ? setup->frames_wait : ROOMS + ROOMS_EACH * encoders;
}

size_t dg_engine_handle_size(const struct dg_engine_setup *setup, const struct dg_device *model)
{
    const struct dg_bus_side *side = dg_bus_side_of(model);

    return round_up(setup->memory_is_host ? dg_host_size_with_port(model, side)
                                          : dg_host_size_on_bus(model, side));
}

/* 0 also of a wire that has none. */
size_t dg_engine_bus_size(const struct dg_plan_wire *wire)
{
    return wire->stack == NULL ? 0
                               : round_up(dg_bus_size(dg_engine_medium(wire), wire->encoder_count));
}

size_t dg_engine_room_size(const struct dg_engine_setup *setup, const struct dg_plan_wire *wire)
{
    const size_t n = wire->encoder_count;

    switch (wire->stack->medium) {
    case DG_MEDIUM_FRAMES:
        return round_up(dg_engine_rooms(setup, n) * sizeof(struct dg_bus_frames_room));
    case DG_MEDIUM_WORDS:
        return round_up(n * DG_RING_WORDS_MAX * sizeof(uint16_t));
    case DG_MEDIUM_CHARACTERS:
    case DG_MEDIUM_EDGES:
    case DG_MEDIUM_COUNT:
        break;
    }
    return 0;
}

/* The next `n` bytes behind `at`, which moves on. */
static void *carve_memory(uint8_t **at, size_t n)
{
    void *here = *at;

    *at += round_up(n);
    return here;
}

static size_t lists_size(const struct dg_plan *plan)
{
    return round_up(sizeof(struct dg_engine)) +
           round_up(plan->shaft_count * sizeof(struct engine_shaft)) +
           round_up(plan->encoder_count * sizeof(struct engine_encoder)) +
           round_up(plan->wire_count * sizeof(struct engine_wire)) +
           round_up(dg_engine_course_count(plan) * sizeof(struct engine_course)) +
           round_up(plan->shaft_count * sizeof(struct dg_rig_shaft *)) +
           round_up(plan->encoder_count * sizeof(struct dg_encoder *));
}

void dg_engine_lay_out(struct dg_engine *self, const struct dg_engine_setup *setup)
{
    const struct dg_plan *plan = setup->plan;
    uint8_t *at = (uint8_t *)self + round_up(sizeof *self);

    memset(self, 0, lists_size(plan));
    self->setup = *setup;
    self->now = setup->begin;
    self->shafts = carve_memory(&at, plan->shaft_count * sizeof(struct engine_shaft));
    self->encoders = carve_memory(&at, plan->encoder_count * sizeof(struct engine_encoder));
    self->wires = carve_memory(&at, plan->wire_count * sizeof(struct engine_wire));
    self->courses = carve_memory(&at, dg_engine_course_count(plan) * sizeof(struct engine_course));
    self->control.shafts = carve_memory(&at, plan->shaft_count * sizeof(struct dg_rig_shaft *));
    self->control.encoders = carve_memory(&at, plan->encoder_count * sizeof(struct dg_encoder *));
    self->handles = at;
    for (size_t i = 0; i < plan->encoder_count; i++) {
        (void)carve_memory(&at, dg_engine_handle_size(setup, plan->encoders[i].model));
    }
    self->buses = at;
}

size_t dg_engine_size(const struct dg_engine_setup *setup)
{
    const struct dg_plan *plan = setup->plan;

    if (setup->size != sizeof *setup || plan == NULL) {
        return 0;
    }
    size_t n = lists_size(plan);
    for (size_t i = 0; i < plan->encoder_count; i++) {
        n += dg_engine_handle_size(setup, plan->encoders[i].model);
    }
    for (size_t i = 0; i < plan->wire_count; i++) {
        const size_t bus = dg_engine_bus_size(&plan->wires[i]);
        if (bus == 0) {
            return 0;
        }
        n += bus + dg_engine_room_size(setup, &plan->wires[i]);
    }
    return n;
}

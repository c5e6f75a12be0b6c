/* SPDX-License-Identifier: MIT */
/*
 * Who listens to what: an identifier has a list of the filters that let it through.
 *
 *   head[080h] --> filter 2 of place 0 --> filter 2 of place 1 --> ...
 */
#include <string.h>

#include "frames_private.h"

/* The link to `filter` in the list of its identifier. */
static uint16_t *link_to(const struct dg_bus *self, uint16_t id, uint16_t filter)
{
    uint16_t *link = &dg_bus_frames_wire(self)->head[id];

    while (*link != filter) {
        const uint16_t at = (uint16_t)(*link - 1u);
        struct frames_place *place = dg_bus_frames_at(self, at / DG_HOST_FILTERS);
        link = &place->filter[at % DG_HOST_FILTERS].next;
    }
    return link;
}

static uint16_t filter_number_of(const struct frames_place *place, uint8_t filter)
{
    return (uint16_t)(DG_HOST_FILTERS * place->base.index + filter + 1u);
}

static bool are_same_filters(const struct frames_place *place, const uint16_t *ids, uint8_t count)
{
    bool same = count == place->filters;

    for (uint8_t i = 0; same && i < count; i++) {
        same = place->filter[i].id == ids[i];
    }
    return same;
}

void dg_bus_filter_list(struct frames_wire *self, struct frames_place *place)
{
    const struct dg_bus *bus = place->base.bus;
    uint16_t ids[DG_HOST_FILTERS];
    const uint8_t count = place->hears ? place->ask->listens(place->device, ids) : 0;

    if (are_same_filters(place, ids, count)) {
        return;
    }
    for (uint8_t i = 0; i < place->filters; i++) {
        *link_to(bus, place->filter[i].id, filter_number_of(place, i)) = place->filter[i].next;
    }
    for (uint8_t i = 0; i < count; i++) {
        uint16_t *head = &self->head[ids[i] % FRAMES_IDS];
        place->filter[i] = (struct frames_filter){(uint16_t)(ids[i] % FRAMES_IDS), *head};
        *head = filter_number_of(place, i);
    }
    place->filters = count;
    self->listed = 0;
    self->refiltered = true;
}

void dg_bus_filter_list_all(struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);

    memset(wire->head, 0, sizeof wire->head);
    wire->listed = 0;
    for (size_t i = 0; i < self->count; i++) {
        dg_bus_frames_at(self, i)->filters = 0;
    }
    for (size_t i = 0; i < self->count; i++) {
        dg_bus_filter_list(wire, dg_bus_frames_at(self, i));
    }
    wire->refiltered = true;
}

/* Most often it is SYNC's again, and the list of all is long. */
struct frames_set dg_bus_filter_of(const struct dg_bus *self, uint16_t id)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    uint16_t next = wire->head[id];

    if (wire->listed == id + 1u) {
        return wire->listeners;
    }
    wire->listed = (uint16_t)(id + 1u);
    wire->listeners = (struct frames_set){{0}};
    while (next != 0) {
        const uint16_t at = (uint16_t)(next - 1u);
        const uint16_t index = at / DG_HOST_FILTERS;
        wire->listeners.word[index / 32u] |= UINT32_C(1) << index % 32u;
        next = dg_bus_frames_at(self, index)->filter[at % DG_HOST_FILTERS].next;
    }
    return wire->listeners;
}

void dg_bus_filter_tell(const struct dg_bus *self)
{
    struct frames_wire *wire = dg_bus_frames_wire(self);
    const struct dg_bus_frames_ops *ops = wire->setup.ops;

    if (ops != NULL && ops->filter != NULL) {
        ops->filter(self->ctx);
    }
    wire->refiltered = false;
}

bool dg_bus_frames_listens(const struct dg_bus *self, uint16_t id)
{
    return dg_bus_frames_wire(self)->head[id % FRAMES_IDS] != 0;
}

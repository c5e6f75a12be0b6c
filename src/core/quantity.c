/* SPDX-License-Identifier: MIT */
#include "drehgeber/quantity.h"

#include <string.h>

_Static_assert(sizeof(bool) == 1, "a state of the world is a byte");

#define QUANTITY(id, member, name, header, unit, healthy, min, max, multiturn, help)               \
    {offsetof(struct dg_world, member),                                                            \
     sizeof(((struct dg_world *)0)->member),                                                       \
     DG_UNIT_##unit,                                                                               \
     multiturn,                                                                                    \
     min,                                                                                          \
     max},

const struct dg_quantity dg_quantities[DG_QUANTITY_COUNT] = {DG_QUANTITIES(QUANTITY)};

const struct dg_quantity *dg_quantity_at(size_t offset)
{
    for (size_t i = 0; i < DG_QUANTITY_COUNT; i++) {
        if (dg_quantities[i].offset == offset) {
            return &dg_quantities[i];
        }
    }
    return NULL;
}

/* All of them fit the signed type of their size: the unsigned ones have limits far below. */
int64_t dg_quantity_get(const struct dg_quantity *self, const struct dg_world *world)
{
    const unsigned char *at = (const unsigned char *)world + self->offset;
    int32_t wide;
    int16_t narrow;

    if (self->size == sizeof wide) {
        memcpy(&wide, at, sizeof wide);
        return wide;
    }
    if (self->size == sizeof narrow) {
        memcpy(&narrow, at, sizeof narrow);
        return narrow;
    }
    return *at;
}

void dg_quantity_set(const struct dg_quantity *self, struct dg_world *world, int64_t value)
{
    unsigned char *at = (unsigned char *)world + self->offset;
    const int32_t wide = (int32_t)value;
    const int16_t narrow = (int16_t)value;

    if (self->size == sizeof wide) {
        memcpy(at, &wide, sizeof wide);
    } else if (self->size == sizeof narrow) {
        memcpy(at, &narrow, sizeof narrow);
    } else {
        *at = value != 0 ? 1 : 0;
    }
}

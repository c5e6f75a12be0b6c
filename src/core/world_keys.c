/* SPDX-License-Identifier: MIT */
/*
 * The quantities of the world as settings.
 */
#include "drehgeber/key.h"

/* How a quantity of a unit is written, and how it lies there. */
#define UNIT_MDEGC "degC"
#define UNIT_UA "uA"
#define UNIT_MV "mV"
#define UNIT_PERMILLE "permille"
#define UNIT_STATE ""
#define PLACES_MDEGC 3
#define PLACES_UA 0
#define PLACES_MV 0
#define PLACES_PERMILLE 0
#define PLACES_STATE 0
#define TYPE_OF(member)                                                                            \
    _Generic(((struct dg_world *)0)->member, bool                                                  \
             : DG_KEY_FLAG, int16_t                                                                \
             : DG_KEY_I16, uint16_t                                                                \
             : DG_KEY_U16, int32_t                                                                 \
             : DG_KEY_I32, uint32_t                                                                \
             : DG_KEY_U32)
#define QUANTITY(id, member, name, header, unit, healthy, min, max, multiturn, help)               \
    {name,                                                                                         \
     UNIT_##unit,                                                                                  \
     offsetof(struct dg_world, member),                                                            \
     TYPE_OF(member),                                                                              \
     PLACES_##unit,                                                                                \
     1,                                                                                            \
     min,                                                                                          \
     max,                                                                                          \
     dg_key_no_yes,                                                                                \
     help},

static const struct dg_key rows[DG_QUANTITY_COUNT] = {DG_QUANTITIES(QUANTITY)};

const struct dg_keys dg_world_keys = {rows, DG_QUANTITY_COUNT};

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The object dictionary: rows of the stack and of the device, access, ranges, CAN-IDs in them.
 */
#ifndef DREHGEBER_CO_OD_H
#define DREHGEBER_CO_OD_H

#include "canopen_private.h"

/** The stack's rows, 1000h-1FFFh. TPDO2 to TPDO4 have those of TPDO1, with slots further on. */
extern const struct dg_co_dictionary dg_co_common_dictionary;
/** Find an object by its key, DG_CO_KEY(). @return DG_CO_OK; whether the index or the sub-index is
 * missing */
enum dg_co_abort dg_co_find(const struct dg_co_device *device, uint32_t key,
                            struct dg_co_object *object);
/** The first object of what a device keeps, and the one behind; false: there is none. Those of the
 * stack, those that the device hides, those of its dictionary: of a device whose dictionary is
 * whole some come twice, with one slot, and TPDO2 to TPDO4 are among the hidden. */
struct dg_co_object dg_co_first(void);
bool dg_co_next(const struct dg_co_device *device, struct dg_co_object *object);
/** What a row stands for, the first of it. */
static inline struct dg_co_object co_object(const struct dg_co_dictionary *dictionary,
                                            const struct dg_co_row *row)
{
    return (struct dg_co_object){row, dictionary, row->slot, (uint8_t)(row->key >> 8),
                                 (uint16_t)(row->key >> 16)};
}
/** The dictionary of a mappable object, and its row, by its number, see dg_co_tpdo.mapped. */
static inline const struct dg_co_dictionary *co_numbered_in(const struct dg_co_device *device,
                                                            uint16_t number)
{
    return (number & 0x8000u) != 0 ? &device->dictionary : &dg_co_common_dictionary;
}
static inline const struct dg_co_row *co_row_in(const struct dg_co_dictionary *dictionary,
                                                uint16_t number)
{
    return &dictionary->rows[number & 0x7FFFu];
}
uint16_t dg_co_number(const struct dg_co_object *object);

/** Whether all of some flags are set. */
static inline bool co_is(const struct dg_co_object *object, uint16_t flags)
{
    return (object->row->flags & flags) == flags;
}
static inline enum dg_co_type co_type(const struct dg_co_object *object)
{
    return (enum dg_co_type)(object->row->flags >> 12);
}
/** Bytes of each type; 0 for strings. */
extern const uint8_t dg_co_sizes[DG_CO_TYPE_COUNT];
static inline uint8_t co_size(const struct dg_co_object *object)
{
    return dg_co_sizes[(uint32_t)object->row->flags >> 12];
}
/** What is left of a value in the bytes of the type, which is no string. */
static inline uint32_t co_cut(const struct dg_co_object *object, uint32_t value)
{
    return value & 0xFFFFFFFFu >> (32u - 8u * co_size(object));
}
/** Its hook, or NULL. */
static inline dg_co_hook *co_hook(const struct dg_co_object *object)
{
    return object->dictionary->hooks[object->row->hook];
}
/** The store's region that keeps it, with DG_CO_SAVE. */
uint8_t dg_co_region_of(const struct dg_co_object *object);
/** A value as it stands on the wire or in the memory, sign-extended where the type is signed. */
uint32_t dg_co_extend(const struct dg_co_object *object, uint32_t value);
/** What the type holds; default (without the node-ID) and limits: the device's, or the row's own.
 */
uint32_t dg_co_default(const struct dg_co_device *device, const struct dg_co_object *object);
struct dg_co_limits dg_co_type_limits(const struct dg_co_object *object);
struct dg_co_limits dg_co_limits_of(const struct dg_co_object *object);
/** Whether it has limits of its own; else each value that dg_co_extend() gives is inside. */
static inline bool co_has_limits(const struct dg_co_object *object)
{
    return (object->row->key & 0xF0u) != 0;
}
/** Whether a value is inside the limits. */
bool dg_co_in_range(const struct dg_co_object *object, uint32_t value);
/** Read an object that is no string, whatever its access. Without a slot its default is its own. */
static inline enum dg_co_abort co_read(struct dg_co_node *self, const struct dg_co_object *object,
                                       uint32_t *value)
{
    const struct dg_co_row *row = object->row;
    dg_co_hook *const hook = co_hook(object);

    *value = (row->flags & DG_CO_SLOT) != 0 ? self->value[object->slot] : row->initial;
    return hook == NULL ? DG_CO_OK : hook(self, object, DG_CO_READ, value);
}
/** Write an object with DG_CO_W: range, hook, slot, hook again. `value` as from dg_co_extend(). */
enum dg_co_abort dg_co_write(struct dg_co_node *self, const struct dg_co_object *object,
                             uint32_t value);
/** Default for this node (the node-ID added where the row says so). */
uint32_t dg_co_initial(const struct dg_co_node *self, const struct dg_co_object *object);
/** Whether a CAN-ID may not be given to a configurable COB-ID. */
bool dg_co_restricted(uint32_t can_id);

/** Hooks of 1000h, 1018h, 1013h, 1005h, 1012h. */
dg_co_hook dg_co_hook_device, dg_co_hook_identity, dg_co_hook_clock, dg_co_hook_sync_id,
    dg_co_hook_time_id;

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The object dictionary: rows of the stack and of the device, access, ranges, CAN-IDs in them.
 */
#ifndef DREHGEBER_CO_OD_H
#define DREHGEBER_CO_OD_H

#include "canopen_private.h"

/** The stack's rows, 1000h-1FFFh, sorted. */
extern const struct dg_co_object co_objects[];
extern const uint16_t co_object_count;
/** Find a row; `*abort` says whether index or sub is missing when NULL is returned. */
const struct dg_co_object *co_find(const struct dg_co_node *self, uint16_t index, uint8_t sub,
                                   enum dg_co_abort *abort);
/** A row by its number: the stack's come first, then the device's. */
static inline const struct dg_co_object *co_row(const struct dg_co_node *self, uint16_t number)
{
    return number < co_object_count ? &co_objects[number]
                                    : &self->setup.device->objects[number - co_object_count];
}
/** The number of a row. */
uint16_t co_row_number(const struct dg_co_node *self, const struct dg_co_object *object);
/** Bytes of a row's type; 0 for strings. */
static inline uint8_t co_size(const struct dg_co_object *object)
{
    static const uint8_t sizes[] = {
        [DG_CO_I8] = 1,  [DG_CO_I16] = 2, [DG_CO_I32] = 4,    [DG_CO_U8] = 1,
        [DG_CO_U16] = 2, [DG_CO_U32] = 4, [DG_CO_STRING] = 0,
    };
    return sizes[object->type];
}
/** A value as it stands on the wire or in the memory, sign-extended where the type is signed. */
uint32_t co_extend(const struct dg_co_object *object, uint32_t value);
/** Default (without the node-ID) and maximum of a row: the device's, or its own. */
uint32_t co_default(const struct dg_co_device *device, const struct dg_co_object *object);
uint32_t co_maximum(const struct dg_co_device *device, const struct dg_co_object *object);
/** Whether a value is inside min..max. */
bool co_in_range(const struct dg_co_device *device, const struct dg_co_object *object,
                 uint32_t value);
/** Read any row but a string, whatever its access. */
enum dg_co_abort co_read(struct dg_co_node *self, const struct dg_co_object *object,
                         uint32_t *value);
/** Write a row with DG_CO_W: range, hook, slot, hook again. */
enum dg_co_abort co_write(struct dg_co_node *self, const struct dg_co_object *object,
                          uint32_t value);
/** Default of a row for this node (the node-ID added where the row says so). */
uint32_t co_initial(const struct dg_co_node *self, const struct dg_co_object *object);
/** Call `visit` for every row of the node: the stack's, then the device's. */
void co_each(struct dg_co_node *self,
             void (*visit)(struct dg_co_node *self, const struct dg_co_object *object, void *ctx),
             void *ctx);
/** Whether a CAN-ID may not be given to a configurable COB-ID. */
bool co_restricted(uint32_t can_id);
/** Whether the node itself has a use for a CAN-ID: SYNC, EMCY, TIME if consumed, valid TPDOs. The
 * others it uses are restricted. */
bool co_in_use(const struct dg_co_node *self, uint32_t can_id);

/** Hooks of 1000h, 1018h, 1013h, 1005h, 1012h. */
dg_co_hook co_hook_device, co_hook_identity, co_hook_clock, co_hook_sync_id, co_hook_time_id;

#endif

/* SPDX-License-Identifier: MIT */
/*
 * Devices of EDS files that were written down as C: hooks and functions of the base have no names
 * outside of the library, so the rows ask for those of the base by their keys.
 */
#include "co_file.h"
#include "co_pdo.h"

_Static_assert((int)DG_CO_VALUE_HEARTBEAT_MS == (int)CO_HEARTBEAT_MS, "names of the same slots");
_Static_assert((int)DG_CO_VALUE_BEHAVIOUR_3 == (int)CO_BEHAVIOUR_3, "names of the same slots");
_Static_assert((int)DG_CO_VALUE_TPDO1_COB_ID == (int)CO_TPDO_SLOTS, "names of the same slots");
_Static_assert((int)DG_CO_VALUE_TPDO2_MAPPED == (int)CO_TPDO(1, CO_PDO_MAPPED),
               "names of the same slots");
_Static_assert((int)DG_CO_VALUE_TPDO4_ENTRY_8 == (int)CO_TPDO(4, 0) - 1, "names of the same slots");
_Static_assert(DG_CO_VALUE_BUS_NODE_ID == DG_CO_SLOT_NODE_ID, "names of the same slots");

/* The base has one row for all parts of a memory. */
static uint32_t base_key(const struct dg_co_object *object)
{
    const bool memory = (object->index == 0x1010 || object->index == 0x1011) && object->sub != 0;

    return DG_CO_KEY(object->index, memory ? 1u : object->sub);
}

static enum dg_co_abort hook_base(struct dg_co_node *node, const struct dg_co_object *object,
                                  enum dg_co_op op, uint32_t *value)
{
    struct dg_co_object base;

    if (dg_co_find(co_file_of(node)->base, base_key(object), &base) != DG_CO_OK) {
        return DG_CO_NO_OBJECT;
    }
    return co_hook(&base)(node, object, op, value);
}

dg_co_hook *const dg_co_row_hooks[DG_CO_ROW_HOOK_COUNT] = {
    [DG_CO_HOOK_BASE] = hook_base,
    [DG_CO_HOOK_CELL] = dg_co_hook_cell,
    [DG_CO_HOOK_FOLLOWS] = dg_co_hook_follows,
    [DG_CO_HOOK_KEEP] = dg_co_hook_keep,
};

enum dg_co_row_hook dg_co_row_hook_of(const struct dg_co_file *self, uint16_t n)
{
    const struct dg_co_dictionary *dictionary = &self->device.dictionary;
    const struct dg_co_object object = co_object(dictionary, &dictionary->rows[n]);
    dg_co_hook *const hook = co_hook(&object);
    enum dg_co_row_hook number = DG_CO_HOOK_NONE;
    struct dg_co_object base;

    while (number < DG_CO_ROW_HOOK_COUNT && dg_co_row_hooks[number] != hook) {
        number++;
    }
    if (number == DG_CO_ROW_HOOK_COUNT &&
        dg_co_find(self->base, base_key(&object), &base) == DG_CO_OK && co_hook(&base) == hook) {
        number = DG_CO_HOOK_BASE;
    }
    return number;
}

void dg_co_sample_file(struct dg_co_node *node)
{
    co_file_of(node)->base->sample(node);
}

dg_ns dg_co_step_file(struct dg_co_node *node)
{
    return co_file_of(node)->base->step(node);
}

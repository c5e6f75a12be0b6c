/* SPDX-License-Identifier: MIT */
/*
 * The object dictionary: rows, access, ranges, hooks.
 */
#include "co_od.h"

#include "co_emcy.h"
#include "co_nmt.h"
#include "co_pdo.h"
#include "co_storage.h"

/* The short names of co_objects.def. */
enum {
    R = DG_CO_R,
    W = DG_CO_W,
    M = DG_CO_MAP,
    I = DG_CO_ID,
    S = DG_CO_SAVE,
    V = DG_CO_SLOT,
    C = DG_CO_CONST,
    G = DG_CO_GAP,
    X = DG_CO_ACTION,
    L = DG_CO_LIVE,
    F = DG_CO_FIGURE,
    COM = DG_CO_REGION_COMMUNICATION,
    PDO1 = DG_CO_REGION_TPDO1,
};

#define DG_CO_PARENT(index, kind, name)
#define DG_CO_OBJECT(index, sub, type, access, slot, region, initial, min, max, hook, name)        \
    {DG_CO_##type, sub, index, access, slot, region, initial, min, max, hook},

const struct dg_co_object co_objects[] = {
#include "co_objects.def"
};
#undef DG_CO_PARENT
#undef DG_CO_OBJECT
const uint8_t dg_co_slot_event_timer = CO_TPDO(0, CO_PDO_EVENT_MS);
const uint16_t co_object_count = DG_COUNT(co_objects);

/* Compared with the type below them: one load, where the machine has its least significant byte
 * first. */
static uint32_t key(uint16_t index, uint8_t sub, uint8_t type)
{
    return (uint32_t)index << 16 | (uint32_t)sub << 8 | type;
}

/* The last of `count` sorted rows that is not behind `wanted`; the first when all are. Halving
 * without a way out for the row that fits, and without a branch: cheaper than to look at each
 * twice. */
static const struct dg_co_object *last_not_behind(const struct dg_co_object *rows, uint32_t count,
                                                  uint32_t wanted)
{
    while (count > 1) {
        uint32_t half = count / 2u;
        const struct dg_co_object *middle = rows + half;
        rows = key(middle->index, middle->sub, middle->type) <= wanted ? middle : rows;
        count -= half;
    }
    return rows;
}

/* The stack's rows end where the device's begin. A neighbour of the same index means that only the
 * sub-index is missing. */
const struct dg_co_object *co_find(const struct dg_co_node *self, uint16_t index, uint8_t sub,
                                   enum dg_co_abort *abort)
{
    const struct dg_co_device *device = self->setup.device;
    bool own = index < 0x2000;
    const struct dg_co_object *rows = own ? co_objects : device->objects;
    const struct dg_co_object *end = rows + (own ? co_object_count : device->object_count);
    const struct dg_co_object *found =
        last_not_behind(rows, (uint32_t)(end - rows), key(index, sub, 0xFF));

    if (found < end && found->index == index && found->sub == sub) {
        return found;
    }
    bool known =
        (found < end && found->index == index) || (found + 1 < end && (found + 1)->index == index);
    *abort = known ? DG_CO_NO_SUB : DG_CO_NO_OBJECT;
    return NULL;
}

uint16_t co_row_number(const struct dg_co_node *self, const struct dg_co_object *object)
{
    return (uint16_t)(object->index < 0x2000
                          ? object - co_objects
                          : co_object_count + (object - self->setup.device->objects));
}

static bool is_signed(const struct dg_co_object *object)
{
    return object->type <= DG_CO_I32;
}

uint32_t co_extend(const struct dg_co_object *object, uint32_t value)
{
    uint32_t sign = 1u << (8u * co_size(object) - 1u);

    return is_signed(object) ? (value ^ sign) - sign : value;
}

/* NULL: the row says all by itself. */
static const struct dg_co_figure *figure_of(const struct dg_co_device *device,
                                            const struct dg_co_object *object)
{
    uint8_t count = (object->flags & DG_CO_FIGURE) != 0 ? device->figure_count : 0;

    for (uint8_t i = 0; i < count; i++) {
        const struct dg_co_figure *figure = &device->figures[i];
        if (figure->index == object->index && figure->sub == object->sub) {
            return figure;
        }
    }
    return NULL;
}

uint32_t co_default(const struct dg_co_device *device, const struct dg_co_object *object)
{
    const struct dg_co_figure *figure = figure_of(device, object);

    return figure != NULL ? figure->initial : object->initial;
}

uint32_t co_maximum(const struct dg_co_device *device, const struct dg_co_object *object)
{
    const struct dg_co_figure *figure = figure_of(device, object);

    return figure != NULL ? figure->max : object->max;
}

uint32_t co_initial(const struct dg_co_node *self, const struct dg_co_object *object)
{
    if ((object->flags & (DG_CO_ID | DG_CO_FIGURE)) == 0) {
        return object->initial;
    }
    return co_default(self->setup.device, object) +
           ((object->flags & DG_CO_ID) != 0 ? self->id : 0u);
}

enum dg_co_abort co_read(struct dg_co_node *self, const struct dg_co_object *object,
                         uint32_t *value)
{
    *value =
        (object->flags & DG_CO_SLOT) != 0 ? self->value[object->slot] : co_initial(self, object);
    return object->hook == NULL ? DG_CO_OK : object->hook(self, object, DG_CO_READ, value);
}

bool co_in_range(const struct dg_co_device *device, const struct dg_co_object *object,
                 uint32_t value)
{
    uint32_t max = co_maximum(device, object);

    if (is_signed(object)) {
        return (int32_t)value >= (int32_t)object->min && (int32_t)value <= (int32_t)max;
    }
    return value >= object->min && value <= max;
}

enum dg_co_abort co_write(struct dg_co_node *self, const struct dg_co_object *object,
                          uint32_t value)
{
    enum dg_co_abort abort = DG_CO_OK;

    if (!co_in_range(self->setup.device, object, value)) {
        return DG_CO_RANGE;
    }
    self->moved = true;
    if (object->hook != NULL) {
        abort = object->hook(self, object, DG_CO_WRITE, &value);
    }
    if (abort != DG_CO_OK || (object->flags & DG_CO_SLOT) == 0) {
        return abort;
    }
    self->value[object->slot] = value;
    self->filter_version++;
    if (object->hook != NULL) {
        (void)object->hook(self, object, DG_CO_WRITTEN, &value);
    }
    return DG_CO_OK;
}

void co_each(struct dg_co_node *self,
             void (*visit)(struct dg_co_node *self, const struct dg_co_object *object, void *ctx),
             void *ctx)
{
    const uint16_t count = (uint16_t)(co_object_count + self->setup.device->object_count);

    for (uint16_t i = 0; i < count; i++) {
        visit(self, co_row(self, i), ctx);
    }
}

bool co_restricted(uint32_t can_id)
{
    static const struct {
        uint16_t first;
        uint16_t last;
    } ranges[] = {
        {0x000, 0x07F}, {0x101, 0x180}, {0x581, 0x5FF},
        {0x601, 0x67F}, {0x6E0, 0x6FF}, {0x701, 0x7FF},
    };

    for (uint8_t i = 0; i < DG_COUNT(ranges); i++) {
        if (can_id >= ranges[i].first && can_id <= ranges[i].last) {
            return true;
        }
    }
    return can_id > CO_COB_CAN_ID;
}

DG_CO_TELL(co_hook_device, node->setup.device->device_type)

enum dg_co_abort co_hook_identity(struct dg_co_node *self, const struct dg_co_object *object,
                                  enum dg_co_op op, uint32_t *value)
{
    const struct dg_co_device *device = self->setup.device;
    const uint32_t identity[] = {device->vendor_id, device->product_code, device->revision,
                                 self->serial};

    (void)op;
    *value = identity[object->sub - 1u];
    return DG_CO_OK;
}

bool co_in_use(const struct dg_co_node *self, uint32_t can_id)
{
    bool used = can_id == CO_ID_EMCY + self->id || can_id == self->value[CO_SYNC_COB_ID] ||
                (can_id | CO_COB_INVALID) == self->value[CO_TIME_COB_ID];

    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        used = used || (self->tpdo[n].valid && self->tpdo[n].can_id == can_id);
    }
    return used;
}

/* 1013h counts microseconds from Initialisation, or from what is written; TIME leaves it alone. */
enum dg_co_abort co_hook_clock(struct dg_co_node *self, const struct dg_co_object *object,
                               enum dg_co_op op, uint32_t *value)
{
    uint32_t now_us = (uint32_t)(self->now / DG_US(1));

    (void)object;
    if (op == DG_CO_READ) {
        *value = self->clock_us + now_us;
    } else {
        self->clock_us = *value - now_us;
    }
    return DG_CO_OK;
}

/* 1005h and 1012h: a CAN-ID of CiA 301's free ranges, 11 bit; no SYNC or TIME is produced. A
 * `fresh` one must not be in use. */
static enum dg_co_abort consumed_id(const struct dg_co_node *self, uint32_t id, bool fresh)
{
    return co_restricted(id) || (fresh && co_in_use(self, id)) ? DG_CO_RANGE : DG_CO_OK;
}

enum dg_co_abort co_hook_sync_id(struct dg_co_node *self, const struct dg_co_object *object,
                                 enum dg_co_op op, uint32_t *value)
{
    bool fresh = *value != self->value[object->slot];

    return op == DG_CO_WRITE ? consumed_id(self, *value, fresh) : DG_CO_OK;
}

/* Bit 31: the node consumes TIME. Without it the CAN-ID is not used. */
enum dg_co_abort co_hook_time_id(struct dg_co_node *self, const struct dg_co_object *object,
                                 enum dg_co_op op, uint32_t *value)
{
    uint32_t id = *value & ~CO_COB_INVALID;
    bool fresh = id != *value && *value != self->value[object->slot];

    return op == DG_CO_WRITE ? consumed_id(self, id, fresh) : DG_CO_OK;
}

/* SPDX-License-Identifier: MIT */
/*
 * The object dictionary: rows, access, ranges, hooks.
 */
#include "co_od.h"

#include "co_emcy.h"
#include "co_nmt.h"
#include "co_pdo.h"
#include "co_storage.h"

/* ------------------------------------------------------------ rows */

/* Hooks by number, and the numbers. */
#define HOOKS(HOOK)                                                                                \
    HOOK(dg_co_hook_device)                                                                        \
    HOOK(dg_co_hook_error_register)                                                                \
    HOOK(dg_co_hook_status)                                                                        \
    HOOK(dg_co_hook_history)                                                                       \
    HOOK(dg_co_hook_sync_id)                                                                       \
    HOOK(dg_co_hook_store)                                                                         \
    HOOK(dg_co_hook_restore)                                                                       \
    HOOK(dg_co_hook_time_id)                                                                       \
    HOOK(dg_co_hook_clock)                                                                         \
    HOOK(dg_co_hook_consumer)                                                                      \
    HOOK(dg_co_hook_heartbeat)                                                                     \
    HOOK(dg_co_hook_identity)                                                                      \
    HOOK(dg_co_hook_tpdo)                                                                          \
    HOOK(dg_co_hook_mapping)
#define POINTER(hook) hook,
#define NUMBER(hook) NUMBER_##hook,

static dg_co_hook *const hooks[] = {NULL, HOOKS(POINTER)};
enum { NUMBER_NULL, HOOKS(NUMBER) };

/* Limits by number. */
enum { FULL, TO_2, LIMIT_COUNT };
static const struct dg_co_limits limits[LIMIT_COUNT] = {[TO_2] = {0, 2}};

/* The short names of co_objects.def. */
enum { DG_CO_SHORT_FLAGS };

#define DG_CO_PARENT(index, kind, name)
#define DG_CO_OBJECT(index, sub, more, type, access, slot, initial, limits, hook, name)            \
    DG_CO_ROW(index, sub, more, DG_CO_##type, access, slot, initial, limits, NUMBER_##hook),
#define DG_CO_MORE(index, sub, name)
#define DG_CO_REPEATED(...)

static const struct dg_co_row rows[] = {
#include "co_objects.def"
};

const struct dg_co_dictionary dg_co_common_dictionary = {DG_CO_ROWS(rows), limits, hooks};
const uint8_t dg_co_slot_event_timer = CO_TPDO(0, CO_PDO_EVENT_MS);
const uint8_t dg_co_sizes[DG_CO_TYPE_COUNT] = {
    [DG_CO_I8] = 1,  [DG_CO_I16] = 2, [DG_CO_I32] = 4,    [DG_CO_U8] = 1,
    [DG_CO_U16] = 2, [DG_CO_U32] = 4, [DG_CO_STRING] = 0, [DG_CO_WIDE] = 4,
};

static uint16_t index_of(const struct dg_co_row *row)
{
    return (uint16_t)(row->key >> 16);
}

static uint8_t sub_of(const struct dg_co_row *row)
{
    return (uint8_t)(row->key >> 8);
}

static uint8_t more_of(const struct dg_co_row *row)
{
    return row->key & 0xFu;
}

/* The stack's 1800h-1803h and 1A00h-1A03h have the rows of the first: by how much a key is above
 * it. */
static uint32_t repeated(uint32_t key)
{
    return (key & 0xFDFC0000u) == 0x18000000u ? key & 0x00030000u : 0;
}

/* The last row that is not behind `wanted`; the first when all are. Powers of two, without a way
 * out for the row that fits; what the first step leaves out at one end it has twice at the other.
 * Dictionaries of 32 to 63 rows, as those of the stack and of the F36x8, need no loop. */
static const struct dg_co_row *last_not_behind(const struct dg_co_dictionary *half, uint32_t wanted)
{
    const struct dg_co_row *row = half->rows;
    const uint32_t power = half->power;

    row = row[half->count - power].key <= wanted ? &row[half->count - power] : row;
    if (power != 32) {
        for (uint32_t step = power / 2u; step != 0; step /= 2u) {
            row = row[step].key <= wanted ? &row[step] : row;
        }
        return row;
    }
    row = row[16].key <= wanted ? &row[16] : row;
    row = row[8].key <= wanted ? &row[8] : row;
    row = row[4].key <= wanted ? &row[4] : row;
    row = row[2].key <= wanted ? &row[2] : row;
    return row[1].key <= wanted ? &row[1] : row;
}

/* Of what has no row a neighbour of the same index says that only the sub-index is missing. */
static enum dg_co_abort tell_missing(const struct dg_co_dictionary *half,
                                     const struct dg_co_row *row, uint32_t index)
{
    const bool behind = row + 1 < &half->rows[half->count] && index_of(row + 1) == index;

    return index_of(row) == index || behind ? DG_CO_NO_SUB : DG_CO_NO_OBJECT;
}

static enum dg_co_abort find_repeated(const struct dg_co_device *device, uint32_t key,
                                      struct dg_co_object *object);

enum dg_co_abort dg_co_find(const struct dg_co_device *device, uint32_t key,
                            struct dg_co_object *object)
{
    const bool common = key < 0x20000000u && !device->whole;

    if (common && repeated(key) != 0) {
        return find_repeated(device, key, object);
    }
    const struct dg_co_dictionary *half = common ? &dg_co_common_dictionary : &device->dictionary;
    const struct dg_co_row *row = last_not_behind(half, key | 0xFFu);
    const uint32_t nth = ((key | 0xFFu) - row->key) >> 8; /* large for any other index */

    object->row = row;
    object->dictionary = half;
    if (nth > more_of(row)) {
        return tell_missing(half, row, key >> 16);
    }
    const uint32_t all = key | (uint8_t)(row->slot + nth);
    object->slot = (uint8_t)all; /* one store for the three */
    object->sub = (uint8_t)(all >> 8);
    object->index = (uint16_t)(all >> 16);
    return DG_CO_OK;
}

/* TPDO2 to TPDO4 have the rows of TPDO1, with slots further on. */
static enum dg_co_abort find_repeated(const struct dg_co_device *device, uint32_t key,
                                      struct dg_co_object *object)
{
    const enum dg_co_abort abort = dg_co_find(device, key - repeated(key), object);
    const uint32_t index = key >> 16;

    object->index = (uint16_t)index;
    object->slot = (uint8_t)(object->slot + CO_PDO_SLOTS * (index & 3u));
    return abort;
}

struct dg_co_object dg_co_first(void)
{
    return co_object(&dg_co_common_dictionary, dg_co_common_dictionary.rows);
}

/* Behind the last row of a TPDO its first one follows, for the next TPDO. */
bool dg_co_next(const struct dg_co_device *device, struct dg_co_object *object)
{
    const struct dg_co_dictionary *half = object->dictionary;
    const struct dg_co_row *row = object->row;
    const uint32_t index = index_of(row);
    const uint32_t behind = DG_CO_KEY(object->index + 1u, 0);

    if (object->sub - sub_of(row) < more_of(row)) {
        object->sub++;
        object->slot++;
        return true;
    }
    row++;
    if (row == &half->rows[half->count]) {
        if (half != &dg_co_common_dictionary) {
            return false;
        }
        half = &device->dictionary;
        row = half->rows - device->hidden;
    }
    if (index_of(row) == index) {
        object->row = row;
        object->slot = (uint8_t)(row->slot + CO_PDO_SLOTS * (object->index - index));
        object->sub = sub_of(row);
        return true;
    }
    if (behind - repeated(behind) == DG_CO_KEY(index, 0) && !device->whole) {
        return dg_co_find(device, behind, object) == DG_CO_OK;
    }
    *object = co_object(half, row);
    return true;
}

uint16_t dg_co_number(const struct dg_co_object *object)
{
    const ptrdiff_t place = object->row - object->dictionary->rows;

    return (uint16_t)(place | (object->dictionary == &dg_co_common_dictionary ? 0 : 0x8000));
}

uint8_t dg_co_region_of(const struct dg_co_object *object)
{
    if (object->index >= 0x2000) {
        return DG_CO_REGION_APPLICATION;
    }
    return object->index < 0x1800 ? DG_CO_REGION_COMMUNICATION
                                  : (uint8_t)(DG_CO_REGION_TPDO1 + (object->index & 3u));
}

/* ------------------------------------------------------------ values */

static bool is_signed(const struct dg_co_object *object)
{
    return co_type(object) <= DG_CO_I32;
}

/* All bits of a type set. */
static uint32_t ones(const struct dg_co_object *object)
{
    return 0xFFFFFFFFu >> (32u - 8u * co_size(object));
}

uint32_t dg_co_extend(const struct dg_co_object *object, uint32_t value)
{
    const uint32_t sign = is_signed(object) ? ones(object) / 2u + 1u : 0;

    return ((value & ones(object)) ^ sign) - sign;
}

/* COB-IDs of TPDOs are 100h apart. */
uint32_t dg_co_default(const struct dg_co_device *device, const struct dg_co_object *object)
{
    const uint32_t key = DG_CO_KEY(object->index, object->sub);
    const uint32_t apart = co_is(object, DG_CO_ID) ? 0x100u : 0u;
    const uint32_t count = co_is(object, DG_CO_FIGURE) ? device->figure_count : 0;
    uint32_t i = 0;

    while (i < count && device->figures[i].key < key) {
        i++;
    }
    if (i < count && device->figures[i].key == key) {
        return device->figures[i].initial;
    }
    return object->row->initial + apart * (object->index - index_of(object->row));
}

struct dg_co_limits dg_co_type_limits(const struct dg_co_object *object)
{
    const uint32_t most = is_signed(object) ? ones(object) / 2u : ones(object);

    return (struct dg_co_limits){is_signed(object) ? ~most : 0, most};
}

struct dg_co_limits dg_co_limits_of(const struct dg_co_object *object)
{
    return co_has_limits(object) ? object->dictionary->limits[object->row->key >> 4 & 0xFu]
                                 : dg_co_type_limits(object);
}

uint32_t dg_co_initial(const struct dg_co_node *self, const struct dg_co_object *object)
{
    return dg_co_default(self->setup.device, object) + (co_is(object, DG_CO_ID) ? self->id : 0u);
}

bool dg_co_in_range(const struct dg_co_object *object, uint32_t value)
{
    const struct dg_co_limits range = dg_co_limits_of(object);

    if (is_signed(object)) {
        return (int32_t)value >= (int32_t)range.min && (int32_t)value <= (int32_t)range.max;
    }
    return value >= range.min && value <= range.max;
}

enum dg_co_abort dg_co_write(struct dg_co_node *self, const struct dg_co_object *object,
                             uint32_t value)
{
    dg_co_hook *const hook = co_hook(object);
    enum dg_co_abort abort = DG_CO_OK;

    if (co_has_limits(object) && !dg_co_in_range(object, value)) {
        return DG_CO_RANGE;
    }
    if (object->index >= 0x2000) {
        self->others = 0; /* what the device does with it is its own; the stack's hooks say so */
    }
    if (hook != NULL) {
        abort = hook(self, object, DG_CO_WRITE, &value);
    }
    if (abort != DG_CO_OK || !co_is(object, DG_CO_SLOT)) {
        return abort;
    }
    self->value[object->slot] = value;
    self->filter_version++;
    if (hook != NULL) {
        (void)hook(self, object, DG_CO_WRITTEN, &value);
    }
    return DG_CO_OK;
}

/* ------------------------------------------------------------ CAN-IDs, hooks */

bool dg_co_restricted(uint32_t can_id)
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

DG_CO_TELL(dg_co_hook_device, node->setup.device->device_type)

enum dg_co_abort dg_co_hook_identity(struct dg_co_node *self, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    const struct dg_co_device *device = self->setup.device;
    const uint32_t identity[] = {device->vendor_id, device->product_code, device->revision,
                                 self->serial};

    (void)op;
    *value = identity[object->sub - 1u];
    return DG_CO_OK;
}

/* 1013h counts microseconds from Initialisation, or from what is written; TIME leaves it alone. */
enum dg_co_abort dg_co_hook_clock(struct dg_co_node *self, const struct dg_co_object *object,
                                  enum dg_co_op op, uint32_t *value)
{
    uint32_t now_us = (uint32_t)dg_divide_ns(self->now, 1000);

    (void)object;
    if (op == DG_CO_READ) {
        *value = self->clock_us + now_us;
    } else {
        self->clock_us = *value - now_us;
    }
    return DG_CO_OK;
}

/* 1005h and 1012h change at any time, within CiA 301's free ranges, 11 bit (C43). No SYNC or TIME
 * is produced. */
enum dg_co_abort dg_co_hook_sync_id(struct dg_co_node *self, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    (void)self;
    (void)object;
    return op == DG_CO_WRITE && dg_co_restricted(*value) ? DG_CO_RANGE : DG_CO_OK;
}

/* Bit 31: the node consumes TIME. Without it the CAN-ID is not used. */
enum dg_co_abort dg_co_hook_time_id(struct dg_co_node *self, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    uint32_t id = *value & ~CO_COB_INVALID;

    return dg_co_hook_sync_id(self, object, op, &id);
}

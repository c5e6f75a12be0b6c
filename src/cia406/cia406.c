/* SPDX-License-Identifier: MIT */
/*
 * The F36x8's rows of the dictionary and the values behind them.
 */
#include "drehgeber/cia406.h"

#include "drehgeber/bits.h"
#include "drehgeber/crc.h"

#define FIRMWARE_VERSION 108u
#define CRC_SEED 0xFFFFu
#define RPM_LIMIT_SINGLETURN 4000
#define RPM_LIMIT_MULTITURN 15000

static struct dg_cia406 *encoder(const struct dg_co_node *node)
{
    return node->setup.application;
}

static void sample(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder(node);
    dg_angle angle = dg_world_angle(node->setup.world, node->now);

    self->raw = (uint32_t)dg_angle_counts(angle, DG_CIA406_STEPS) &
                (uint32_t)((uint64_t)self->model->turns * DG_CIA406_STEPS - 1);
}

static enum dg_co_abort hook_position(struct dg_co_node *node, const struct dg_co_object *object,
                                      enum dg_co_op op, uint32_t *value)
{
    (void)object;
    (void)op;
    *value = encoder(node)->raw;
    return DG_CO_OK;
}

/* 2160h raw, 2161h inverted, 2162h CRC over the bytes of 2160h as they stand on the wire (C24). */
static enum dg_co_abort hook_raw(struct dg_co_node *node, const struct dg_co_object *object,
                                 enum dg_co_op op, uint32_t *value)
{
    uint8_t bytes[4];

    (void)op;
    *value = encoder(node)->raw;
    if (object->index == 0x2161) {
        *value = ~*value;
    } else if (object->index == 0x2162) {
        dg_store_le32(bytes, *value);
        *value = dg_crc16(CRC_SEED, bytes, sizeof bytes);
    }
    return DG_CO_OK;
}

static enum dg_co_abort hook_speed(struct dg_co_node *node, const struct dg_co_object *object,
                                   enum dg_co_op op, uint32_t *value)
{
    int32_t limit = encoder(node)->model->turns > 1 ? RPM_LIMIT_MULTITURN : RPM_LIMIT_SINGLETURN;
    int32_t rpm = dg_world_speed_mrpm(node->setup.world, node->now) / 1000;

    (void)object;
    (void)op;
    rpm = rpm > limit ? limit : rpm < -limit ? -limit : rpm;
    *value = (uint32_t)rpm;
    return DG_CO_OK;
}

/* 6200h is 1800h:5 seen through another object (C5). */
static enum dg_co_abort hook_cyclic_timer(struct dg_co_node *node,
                                          const struct dg_co_object *object, enum dg_co_op op,
                                          uint32_t *value)
{
    (void)object;
    if (op == DG_CO_READ) {
        *value = node->value[dg_co_slot_event_timer];
    } else if (op == DG_CO_WRITE) {
        node->value[dg_co_slot_event_timer] = *value;
        dg_co_pdo_rearm(node, 0);
    }
    return DG_CO_OK;
}

/* 65536 turns do not fit 16 bits. */
static enum dg_co_abort hook_turns(struct dg_co_node *node, const struct dg_co_object *object,
                                   enum dg_co_op op, uint32_t *value)
{
    uint32_t turns = encoder(node)->model->turns;

    (void)object;
    (void)op;
    *value = turns > 0xFFFF ? 0xFFFF : turns;
    return DG_CO_OK;
}

/* 2100h has no rate 7 (chapter 8). */
static enum dg_co_abort hook_bit_rate(struct dg_co_node *node, const struct dg_co_object *object,
                                      enum dg_co_op op, uint32_t *value)
{
    (void)node;
    (void)object;
    return op == DG_CO_WRITE && *value == 7 ? DG_CO_RANGE : DG_CO_OK;
}

/* The short names of objects.def. */
enum {
    R = DG_CO_R,
    W = DG_CO_W,
    M = DG_CO_MAP,
    V = DG_CO_SLOT,
    C = DG_CO_CONST,
};

#define DG_CO_PARENT(index, kind, name)
#define DG_CO_OBJECT(index, sub, type, access, slot, region, initial, min, max, hook, name)        \
    {index, sub, DG_CO_##type, access, slot, region, initial, min, max, hook},

static const struct dg_co_object objects[] = {
#include "objects.def"
};

static const struct dg_store_region regions[] = {DG_CO_STORE_REGIONS};

static const struct dg_store_layout layout = {
    .id = 0x434F3101u,
    .journal_size = DG_CO_JOURNAL_SIZE,
    .region_count = sizeof regions / sizeof regions[0],
    .regions = regions,
};

static const char *const strings[] = {"F36x8 CANopen encoder", "1.00", "1.08"};

#define F36X8                                                                                      \
    .objects = objects, .object_count = sizeof objects / sizeof objects[0], .strings = strings,    \
    .vendor_id = 0x13, .product_code = 0x56682001, .revision = 108, .layout = &layout,             \
    .sample = sample

const struct dg_co_device dg_cia406_singleturn = {
    F36X8,
    .name = "F3658",
    .device_type = 0x00010196,
};

const struct dg_co_device dg_cia406_multiturn = {
    F36X8,
    .name = "F3668",
    .device_type = 0x00020196,
};

int dg_cia406_init(struct dg_cia406 *self, const struct dg_cia406_model *model)
{
    uint32_t turns = model->turns;

    if (model->device == NULL || turns == 0 || turns > 65536 || (turns & (turns - 1u)) != 0) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_cia406){.model = model};
    return DG_OK;
}

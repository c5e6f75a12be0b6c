/* SPDX-License-Identifier: MIT */
/*
 * An OCD INTERBUS behind a handle: one encoder's part of the cycles of its ring.
 */
#include "drehgeber/host_wire.h"
#include "drehgeber/interbus.h"

/* of dg_ib_keys, as dg_host_wire.without has them */
#define ROW_TURNS (UINT32_C(1) << 1)

/* A K1 has no turns. */
static uint32_t without(const void *settings)
{
    const struct dg_ib_model *model = settings;

    return model->profile == DG_IB_K1 ? ROW_TURNS : 0;
}

static int check(const struct dg_host_event *event)
{
    return event->kind == DG_HOST_WORDS ? DG_HOST_OK : DG_HOST_ERR_WIRE;
}

/* Without power a device is a break of the ring: nothing comes back. */
static bool take(struct dg_host_line *line, const struct dg_host_event *event)
{
    struct dg_ib *device = line->device;
    struct dg_host_event back = {.at = line->now, .flags = event->flags, .kind = DG_HOST_WORDS};

    if (!device->powered) {
        return true;
    }
    if ((event->flags & DG_HOST_IDENTIFY) != 0) {
        back.id = dg_ib_id(device, line->now);
        back.length = 2;
    } else {
        dg_ib_cycle(device, line->now, event->id, &back.id);
        back.length = (uint8_t)(2u * dg_ib_image_words(line->settings));
    }
    /* The high word first, as they stand in the ring. */
    for (uint8_t i = 0; i < back.length; i++) {
        back.data[i] = (uint8_t)(back.id >> 8u * (back.length - 1u - i));
    }
    dg_host_emit(line, &back);
    return true;
}

/* Which form the EEPROM has is the model's to say, and in no state. */
static void arrange(void *settings, struct dg_stack_setup *setup)
{
    struct dg_ib_model *self = settings;
    const struct dg_ib_model *delivered = setup == NULL ? NULL : setup->model;

    self->layout = delivered == NULL ? NULL : delivered->layout;
}

const struct dg_host_wire dg_ib_wire = {
    .stack = &dg_ib_stack,
    .keys = &dg_ib_keys,
    .blind = DG_IB_BLIND,
    .settings_size = sizeof(struct dg_ib_model),
    .without = without,
    .arrange = arrange,
    .check = check,
    .take = take,
    .state = &dg_ib_check,
};

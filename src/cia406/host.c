/* SPDX-License-Identifier: MIT */
/*
 * An F36x8 behind a handle: frames in and out, and what its CAN controller sees.
 */
#include <string.h>

#include "drehgeber/cia406.h"
#include "drehgeber/host_wire.h"

#define ID_MAX 0x7FFu
#define DLC_MAX 8u

_Static_assert((int)DG_HOST_BUS_ACTIVE == (int)DG_CO_BUS_ACTIVE, "the numbers are the same");
_Static_assert((int)DG_HOST_BUS_PASSIVE == (int)DG_CO_BUS_PASSIVE, "the numbers are the same");
_Static_assert((int)DG_HOST_BUS_OFF == (int)DG_CO_BUS_OFF, "the numbers are the same");
_Static_assert((int)DG_HOST_BUS_OVERRUN == (int)DG_CO_BUS_OVERRUN, "the numbers are the same");
_Static_assert((int)DG_HOST_BUS_ABSENT == (int)DG_CO_BUS_ABSENT, "the numbers are the same");
_Static_assert((int)DG_HOST_BUS_PRESENT == (int)DG_CO_BUS_PRESENT, "the numbers are the same");

static void furnish(void *settings, const struct dg_device *device)
{
    dg_cia406_settings_init(settings, dg_cia406_model_of(device));
}

static uint32_t without(const void *settings)
{
    const struct dg_cia406_settings *self = settings;

    return dg_cia406_without(&self->model);
}

/* ------------------------------------------------------------ out */

/* A node asks for nothing: it sends no remote frames. */
static void send(void *ctx, const struct dg_can_frame *frame)
{
    struct dg_host_line *line = ctx;
    const struct dg_cia406_device *device = line->device;
    struct dg_host_event event = {
        .at = line->now,
        .id = frame->id,
        .kind = DG_HOST_CAN,
        .length = frame->dlc,
    };

    memcpy(event.data, frame->data, sizeof frame->data);
    if (!device->node.bus_off) {
        dg_host_emit(line, &event);
    }
}

static const struct dg_co_ops ops = {.send = send};

static void arrange(void *settings, struct dg_stack_setup *setup)
{
    struct dg_cia406_settings *self = settings;

    if (setup == NULL) {
        self->model.device = NULL;
        return;
    }
    const struct dg_cia406_model *ordered = setup->model;
    self->model.device = ordered->device;
    dg_cia406_settings_apply(self);
    setup->serial = self->serial;
    setup->address = self->node;
    setup->port = &ops;
}

/* ------------------------------------------------------------ in */

static int check(const struct dg_host_event *event)
{
    if (event->kind == DG_HOST_BUS) {
        return event->id <= DG_HOST_BUS_PRESENT ? DG_HOST_OK : DG_HOST_ERR_ARGUMENT;
    }
    if (event->kind != DG_HOST_CAN) {
        return DG_HOST_ERR_WIRE;
    }
    return event->id <= ID_MAX && event->length <= DLC_MAX ? DG_HOST_OK : DG_HOST_ERR_ARGUMENT;
}

static dg_ns feed(struct dg_host_line *line, const struct dg_host_event *event)
{
    struct dg_cia406_device *device = line->device;
    struct dg_co_node *node = &device->node;

    if (event->kind == DG_HOST_BUS) {
        const enum dg_co_bus_event said = (enum dg_co_bus_event)event->id;
        return said <= DG_CO_BUS_OFF ? dg_co_controller(node, line->now, said)
                                     : dg_co_bus(node, line->now, said);
    }
    struct dg_can_frame frame = {
        .id = (uint16_t)event->id,
        .rtr = (event->flags & DG_HOST_REMOTE) != 0,
        .dlc = event->length,
    };
    memcpy(frame.data, event->data, sizeof frame.data);
    return node->bus_off ? dg_co_step(node, line->now) : dg_co_rx(node, line->now, &frame);
}

static bool take(struct dg_host_line *line, const struct dg_host_event *event)
{
    (void)feed(line, event);
    return true;
}

const struct dg_host_wire dg_cia406_wire = {
    .stack = &dg_cia406_stack,
    .keys = &dg_cia406_keys,
    .settings_size = sizeof(struct dg_cia406_settings),
    .furnish = furnish,
    .without = without,
    .arrange = arrange,
    .check = check,
    .take = take,
    .feed = feed,
    .state = &dg_cia406_check,
};

int dg_host_bit_rate(const struct dg_host *self)
{
    int result;
    const struct dg_cia406_device *device = dg_host_device(self, &dg_cia406_wire, &result);

    return device != NULL ? (int)device->node.setup.device->kbaud[device->node.bit_rate] : result;
}

int dg_host_bus_state(const struct dg_host *self)
{
    int result;
    const struct dg_cia406_device *device = dg_host_device(self, &dg_cia406_wire, &result);

    return device != NULL ? (int)dg_co_controller_state(&device->node) : result;
}

int dg_host_filters(const struct dg_host *self, uint16_t ids[DG_HOST_FILTERS])
{
    int result;
    const struct dg_cia406_device *device = dg_host_device(self, &dg_cia406_wire, &result);

    return device != NULL ? (int)dg_co_filters(&device->node, ids) : result;
}

uint64_t dg_host_answer_at(const struct dg_host *self)
{
    int result;
    const struct dg_cia406_device *device = dg_host_device(self, &dg_cia406_wire, &result);

    return device != NULL && device->node.sdo.state == DG_CO_SDO_DELAYED ? device->node.sdo.deadline
                                                                         : DG_HOST_NEVER;
}

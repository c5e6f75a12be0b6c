/* SPDX-License-Identifier: MIT */
/*
 * An encoder that answers with eleven characters behind a handle.
 */
#include "drehgeber/eleven.h"
#include "drehgeber/host_wire.h"

static void furnish(void *settings, const struct dg_device *device)
{
    *(struct dg_eleven_model *)settings = *(const struct dg_eleven_model *)device->model;
}

static void send_reply(void *ctx, const uint8_t *bytes)
{
    dg_host_emit_reply(ctx, bytes, DG_ELEVEN_REPLY);
}

static const struct dg_eleven_ops ops = {.tx = send_reply};

static void arrange(void *settings, struct dg_stack_setup *setup)
{
    (void)settings;
    if (setup != NULL) {
        setup->port = &ops;
    }
}

static int check(const struct dg_host_event *event)
{
    return event->kind == DG_HOST_BYTES ? DG_HOST_OK : DG_HOST_ERR_WIRE;
}

/* The end of each character; on a bus there is one, and it ends now. */
static dg_ns due(const struct dg_host_line *line, const struct dg_host_event *event)
{
    const uint32_t ends = (event->flags & DG_HOST_ENDED) != 0 ? line->part : line->part + 1u;

    return dg_after(event->at, ends * (event->id != 0 ? event->id : DG_ELEVEN_CHARACTER_NS));
}

/* It does not mind when a character begins. */
static bool take_event(struct dg_host_line *line, const struct dg_host_event *event)
{
    const uint32_t part = line->part++;

    if ((event->flags & DG_HOST_START) == 0 && part < event->length) {
        (void)dg_eleven_hear(line->device, line->now, event->data[part],
                             (event->flags & DG_HOST_DAMAGED) != 0);
    }
    return line->part >= event->length;
}

static void tell_uart(const struct dg_host_line *line, bool stored, struct dg_host_uart *to)
{
    (void)line;
    (void)stored;
    *to = (struct dg_host_uart){.baud = DG_ELEVEN_BAUD, .parity = 'N', .timeout_bits = 10};
}

const struct dg_host_wire dg_eleven_wire = {
    .stack = &dg_eleven_stack,
    .keys = &dg_eleven_keys,
    .settings_size = sizeof(struct dg_eleven_model),
    .furnish = furnish,
    .arrange = arrange,
    .check = check,
    .due = due,
    .take = take_event,
    .uart = tell_uart,
    .state = &dg_eleven_state,
};

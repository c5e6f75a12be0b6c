/* SPDX-License-Identifier: MIT */
/*
 * An encoder with SSI behind a handle: edges, and a master of its own.
 */
#include "drehgeber/host_wire.h"
#include "drehgeber/ssi.h"

#define PERIOD_NS DG_US(1)

static bool level(const struct dg_host_line *line)
{
    return dg_ssi_data(line->device);
}

static bool set_clock(struct dg_host_line *line, dg_ns now, bool high)
{
    struct dg_ssi *device = line->device;
    const uint32_t frames = device->counters.frames;
    const bool data = dg_ssi_clock(device, now, high);

    line->latched = device->counters.frames != frames ? now : line->latched;
    return data;
}

static uint64_t latched(const struct dg_host_line *line)
{
    const struct dg_ssi *device = line->device;

    return device->position;
}

/* Data of each rising edge is read just before the next falling one. */
static int frame(struct dg_host_line *line, struct dg_host_frame *to)
{
    struct dg_ssi *device = line->device;
    struct dg_ssi_frame decoded;

    if (device->state != DG_SSI_IDLE || !device->clock) {
        return DG_HOST_ERR_STATE;
    }
    to->at = line->now;
    line->latched = line->now;
    to->count = dg_ssi_word_bits(device->setup.model);
    for (uint8_t i = 0; i < to->count; i++) {
        (void)dg_ssi_clock(device, line->now, false);
        const dg_ns rising = dg_after(line->now, PERIOD_NS / 2u);
        to->bits = to->bits << 1 | dg_ssi_clock(device, rising, true);
        line->now = dg_after(line->now, PERIOD_NS);
    }
    /* The monoflop is over: the next falling edge stores anew. */
    const dg_ns end = dg_ssi_step(device, line->now);
    line->now = end != DG_NEVER ? end : line->now;
    (void)dg_ssi_step(device, line->now);
    to->good = dg_ssi_frame_decode(device->setup.model, to->bits, &decoded) == DG_OK;
    to->position = decoded.position;
    to->multiturn = decoded.multiturn;
    to->singleturn = decoded.singleturn;
    to->error = decoded.error;
    return DG_HOST_OK;
}

/* Which form words have is the model's to say, and in no state. */
static void arrange(void *settings, struct dg_stack_setup *setup)
{
    struct dg_ssi_model *self = settings;
    const struct dg_ssi_model *delivered = setup == NULL ? NULL : setup->model;

    self->form = delivered == NULL ? NULL : delivered->form;
}

const struct dg_host_wire dg_ssi_wire = {
    .stack = &dg_ssi_stack,
    .keys = &dg_ssi_keys,
    .settings_size = sizeof(struct dg_ssi_model),
    .arrange = arrange,
    .level = level,
    .clock = set_clock,
    .latched = latched,
    .frame = frame,
    .state = &dg_ssi_check,
};

const struct dg_bus_side dg_ssi_side = {.wire = &dg_ssi_wire};

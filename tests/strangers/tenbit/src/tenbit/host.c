/* SPDX-License-Identifier: MIT */
/*
 * An encoder with words of ten bits behind a handle. It brings no master of its own.
 */
#include "drehgeber/host_wire.h"
#include "drehgeber/tenbit.h"

static bool level(const struct dg_host_line *line)
{
    return ((const struct dg_tenbit *)line->device)->data;
}

static bool set_clock(struct dg_host_line *line, dg_ns now, bool high)
{
    struct dg_tenbit *device = line->device;
    const uint32_t frames = device->frames;
    const bool data = dg_tenbit_clock(device, now, high);

    line->latched = device->frames != frames ? now : line->latched;
    return data;
}

static uint64_t latched(const struct dg_host_line *line)
{
    return ((const struct dg_tenbit *)line->device)->word;
}

const struct dg_keys dg_tenbit_keys = {NULL, 0};

const struct dg_host_wire dg_tenbit_wire = {
    .stack = &dg_tenbit_stack,
    .keys = &dg_tenbit_keys,
    .settings_size = sizeof(struct dg_tenbit_model),
    .level = level,
    .clock = set_clock,
    .latched = latched,
    .state = &dg_tenbit_state,
};

const struct dg_bus_side dg_tenbit_side = {.wire = &dg_tenbit_wire};

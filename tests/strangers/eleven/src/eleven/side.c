/* SPDX-License-Identifier: MIT */
/*
 * What a bus asks of an encoder that answers with eleven characters.
 */
#include "drehgeber/eleven.h"
#include "drehgeber/host_wire.h"

static int address(const struct dg_host_line *line)
{
    return ((const struct dg_eleven_model *)line->settings)->slot;
}

static bool wants(const struct dg_host_line *line, uint8_t byte)
{
    return byte == dg_eleven_request((uint8_t)address(line));
}

const struct dg_bus_side dg_eleven_side = {
    .wire = &dg_eleven_wire,
    .wants = wants,
    .address = address,
};

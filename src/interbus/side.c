/* SPDX-License-Identifier: MIT */
/*
 * What a ring asks of an OCD INTERBUS in it.
 */
#include "drehgeber/host_wire.h"
#include "drehgeber/interbus.h"

static uint8_t words(const struct dg_host_line *line)
{
    return dg_ib_image_words(line->settings);
}

static bool identified(const struct dg_host_line *line)
{
    const struct dg_ib *device = line->device;

    return device->last_id != DG_NEVER;
}

static uint16_t identify(struct dg_host_line *line, dg_ns now, bool last)
{
    struct dg_ib *device = line->device;

    device->outgoing_off = last;
    return dg_ib_id(device, now);
}

static uint32_t exchange(struct dg_host_line *line, dg_ns now, uint32_t out)
{
    uint32_t in = 0;

    dg_ib_cycle(line->device, now, out, &in);
    return in;
}

static void spoil(struct dg_host_line *line)
{
    struct dg_ib *device = line->device;

    device->crc_error = true;
    device->counters.crc_errors++;
}

static dg_ns quiet(const struct dg_host_line *line, dg_ns now)
{
    return dg_ib_quiet(line->device, now);
}

static void skip(struct dg_host_line *line, uint32_t cycles)
{
    struct dg_ib *device = line->device;

    device->counters.cycles += cycles;
}

static const struct dg_host_ring ring = {
    .words = words,
    .identified = identified,
    .identify = identify,
    .exchange = exchange,
    .spoil = spoil,
    .quiet = quiet,
    .skip = skip,
};

const struct dg_bus_side dg_ib_side = {.wire = &dg_ib_wire, .ring = &ring};

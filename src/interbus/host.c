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

/* ------------------------------------------------------------ in a ring */

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

/* ------------------------------------------------------------ alone */

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
        back.id = exchange(line, line->now, event->id);
        back.length = (uint8_t)(2u * words(line));
    }
    /* The high word first, as they stand in the ring. */
    for (uint8_t i = 0; i < back.length; i++) {
        back.data[i] = (uint8_t)(back.id >> 8u * (back.length - 1u - i));
    }
    dg_host_emit(line, &back);
    return true;
}

const struct dg_host_wire dg_ib_wire = {
    .stack = &dg_ib_stack,
    .keys = &dg_ib_keys,
    .blind = DG_IB_BLIND,
    .settings_size = sizeof(struct dg_ib_model),
    .without = without,
    .check = check,
    .take = take,
    .ring = &ring,
    .state = &dg_ib_check,
};

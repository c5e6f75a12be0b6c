/* SPDX-License-Identifier: MIT */
/*
 * Eleven characters behind the seam of all protocols. A request is answered once the reaction time
 * is over; what comes in between is not looked at.
 */
#include "drehgeber/angle.h"
#include "drehgeber/eleven.h"

#define SLOT_SHIFT 3u
#define REQUEST 0x02u
#define PARITY 0x80u

uint8_t dg_eleven_request(uint8_t slot)
{
    const unsigned halves = slot ^ slot >> 2;
    const bool odd = ((halves ^ halves >> 1) & 1u) != 0;

    return (uint8_t)(REQUEST | (unsigned)slot << SLOT_SHIFT | (odd ? PARITY : 0u));
}

uint8_t dg_eleven_check(const uint8_t *bytes, size_t n)
{
    uint8_t sum = 0;

    for (size_t i = 0; i < n; i++) {
        sum ^= bytes[i];
    }
    return sum;
}

DG_STACK_WITHOUT_MEMORY;

static bool senses_multiturn(const void *figures)
{
    (void)figures;
    return false;
}

static int format(const struct dg_stack_setup *setup)
{
    const struct dg_eleven_model *figures = setup->model;

    return figures->slot < DG_ELEVEN_SLOTS ? DG_OK : DG_ERR_ARGUMENT;
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    static const struct dg_stack_setup none;
    const struct dg_stack_setup *from = setup != NULL ? setup : &none;
    struct dg_eleven *device = self;

    device->model = from->model;
    device->world = from->world;
    device->ops = from->port;
    device->ctx = from->ctx;
}

static int init(void *self, const struct dg_stack_setup *setup)
{
    if (setup->model == NULL || setup->world == NULL || setup->world->angle == NULL) {
        return DG_ERR_ARGUMENT;
    }
    *(struct dg_eleven *)self = (struct dg_eleven){.due = DG_NEVER};
    attach(self, setup);
    return format(setup);
}

static int power_on(void *self, dg_ns now)
{
    struct dg_eleven *device = self;

    (void)now;
    device->powered = true;
    device->due = DG_NEVER;
    return DG_OK;
}

static void power_off(void *self)
{
    struct dg_eleven *device = self;

    device->powered = false;
    device->due = DG_NEVER;
}

static bool powered(const void *self)
{
    return ((const struct dg_eleven *)self)->powered;
}

static const void *model(const void *self)
{
    return ((const struct dg_eleven *)self)->model;
}

static uint64_t position(const void *self, dg_ns now)
{
    const struct dg_eleven *device = self;
    const uint64_t angle = powered(self) ? (uint64_t)dg_world_angle(device->world, now) : 0;

    return (angle >> (32u - DG_ELEVEN_BITS)) & ((1u << DG_ELEVEN_BITS) - 1u);
}

static void reply(struct dg_eleven *self, dg_ns now)
{
    const uint64_t counts = position(self, now);
    uint8_t bytes[DG_ELEVEN_REPLY] = {self->asked, (uint8_t)counts, (uint8_t)(counts >> 8),
                                      (uint8_t)(counts >> 16),
                                      self->world->singleturn_ok ? 0 : DG_ELEVEN_LOST};

    bytes[DG_ELEVEN_REPLY - 1u] = dg_eleven_check(bytes, DG_ELEVEN_REPLY - 1u);
    self->counters.replies++;
    if (self->ops != NULL) {
        self->ops->tx(self->ctx, bytes);
    }
}

static dg_ns step(void *self, dg_ns now)
{
    struct dg_eleven *device = self;

    if (device->due <= now && device->due != DG_NEVER) {
        device->due = DG_NEVER;
        reply(device, now);
    }
    return device->due;
}

dg_ns dg_eleven_hear(struct dg_eleven *self, dg_ns now, uint8_t byte, bool damaged)
{
    (void)step(self, now);
    if (!self->powered || self->due != DG_NEVER) {
        return self->due;
    }
    const bool strange = byte != dg_eleven_request(self->model->slot);
    self->counters.damaged += damaged;
    self->counters.strange += !damaged && strange;
    if (!damaged && !strange) {
        self->asked = byte;
        self->due = dg_after(now, self->model->reaction);
    }
    return self->due;
}

const struct dg_stack dg_eleven_stack = {
    .name = "eleven",
    .medium = DG_MEDIUM_CHARACTERS,
    .address_key = "slot",
    .address_what = "a slot",
    .device_size = sizeof(struct dg_eleven),
    .mount = mount,
    DG_STACK_OPERATIONS,
};

/* --- states that somebody has made --- */

static const struct dg_stack_range ranges[] = {DG_STACK_BOOL(dg_eleven, powered)};

static bool fits(const void *own, const void *settings, const void *device)
{
    (void)own;
    (void)settings;
    (void)device;
    return true;
}

const struct dg_stack_check dg_eleven_state = {ranges, DG_COUNT(ranges), fits};

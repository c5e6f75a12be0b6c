/* SPDX-License-Identifier: MIT */
/*
 * A master's ring: one shift register through all devices, each with a window by its position.
 * Only what becomes of a cycle is modelled: loop-back, check sequence, breaks, dead cycles.
 */
#include "interbus_private.h"

int dg_ib_ring_init(struct dg_ib_ring *self, struct dg_ib *devices, size_t count)
{
    if (devices == NULL || count < 1 || count > DG_IB_RING_MAX) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_ib_ring){
        .devices = devices,
        .count = (uint16_t)count,
        .broken_at = DG_IB_RING_WHOLE,
        .corrupt_at = DG_IB_RING_WHOLE,
    };
    for (size_t i = 0; i < count; i++) {
        self->words = (uint16_t)(self->words + dg_ib_image_words(devices[i].setup.model));
    }
    return DG_OK;
}

/* Devices before the first break; one without power is a break. */
static uint16_t reachable(const struct dg_ib_ring *self)
{
    const uint16_t whole = self->broken_at < self->count ? self->broken_at : self->count;
    const struct dg_ib *device = self->devices;
    const struct dg_ib *end = device + whole;

    while (device < end && device->powered) {
        device++;
    }
    return (uint16_t)(device - self->devices);
}

/* A device that was switched on again takes part only after an ID cycle. */
static bool all_identified(const struct dg_ib_ring *self)
{
    const struct dg_ib *end = self->devices + self->count;

    for (const struct dg_ib *device = self->devices; device < end; device++) {
        if (device->last_id == DG_NEVER) {
            return false;
        }
    }
    return self->configured;
}

uint16_t dg_ib_ring_id(struct dg_ib_ring *self, dg_ns now, uint16_t *ids)
{
    uint16_t reached = reachable(self);

    for (uint16_t i = 0; i < reached; i++) {
        ids[i] = dg_ib_id(&self->devices[i], now);
        self->devices[i].outgoing_off = reached < self->count && i + 1u == reached;
    }
    self->configured = reached == self->count;
    self->counters.ids++;
    return reached;
}

static enum dg_ib_ring_result interrupted(struct dg_ib_ring *self)
{
    self->configured = false;
    self->dead = 0;
    self->counters.interrupted++;
    return DG_IB_RING_INTERRUPTED;
}

static enum dg_ib_ring_result corrupted(struct dg_ib_ring *self)
{
    struct dg_ib *device = &self->devices[self->corrupt_at];

    device->crc_error = true;
    device->counters.crc_errors++;
    self->corrupt_at = DG_IB_RING_WHOLE;
    self->dead = DG_IB_DEAD_CYCLES;
    self->counters.crc_errors++;
    return DG_IB_RING_CRC;
}

static void exchange(const struct dg_ib_ring *self, dg_ns now, const uint16_t *out, uint16_t *in)
{
    struct dg_ib *end = self->devices + self->count;
    size_t at = 0;

    for (struct dg_ib *device = self->devices; device < end; device++) {
        const bool one = device->setup.model->profile == DG_IB_K1;
        uint32_t word = 0;

        dg_ib_cycle(device, now, one ? 0 : (uint32_t)out[at] << 16 | out[at + 1u], &word);
        if (!one) {
            in[at++] = (uint16_t)(word >> 16);
        }
        in[at++] = (uint16_t)word;
    }
}

enum dg_ib_ring_result dg_ib_ring_cycle(struct dg_ib_ring *self, dg_ns now, const uint16_t *out,
                                        uint16_t *in)
{
    self->counters.cycles++;
    if (reachable(self) < self->count) {
        return interrupted(self);
    }
    if (!all_identified(self)) {
        return DG_IB_RING_IDENTIFY;
    }
    if (self->corrupt_at < self->count) {
        return corrupted(self);
    }
    if (self->dead > 0) {
        self->dead--;
        self->counters.dead++;
        return DG_IB_RING_DEAD;
    }
    exchange(self, now, out, in);
    return DG_IB_RING_OK;
}

int dg_ib_ring_module_error(const struct dg_ib_ring *self)
{
    for (uint16_t i = 0; i < self->count; i++) {
        if (self->devices[i].invalid && self->devices[i].setup.model->profile != DG_IB_K3) {
            return i;
        }
    }
    return -1;
}

uint32_t dg_ib_bit_times(uint32_t bytes, uint32_t devices)
{
    return 13u * (6u + bytes) + 4u * devices;
}

dg_ns dg_ib_ring_cycle_time(const struct dg_ib_ring *self, uint32_t baud, dg_ns software)
{
    return dg_after(dg_bit_times_ns(dg_ib_bit_times(2u * self->words, self->count), baud),
                    software);
}

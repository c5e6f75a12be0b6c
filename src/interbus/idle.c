/* SPDX-License-Identifier: MIT */
/*
 * Data cycles that nobody has to run. With the same OUT as before, a cycle only counts and latches,
 * unless
 *
 *   a command waits              it is handled after param_cycles
 *   the self-test ends           OUT is looked at for the first time
 *   ten minutes are over         the operating time is stored
 *   the ring recovers            ID cycle, dead cycles
 *
 * Latching is a function of time (60000000h, too: the offset of the last cycle counts), so of all
 * cycles before such a moment only the last one has to be run.
 */
#include "interbus_private.h"

static dg_ns device_quiet(const struct dg_ib *self, dg_ns now)
{
    if (self->setup.model->profile != DG_IB_K3) {
        return DG_NEVER;
    }
    dg_ns until = dg_after(self->time_mark, IB_TIME_UNIT);
    if (now < self->ready_at) {
        return dg_earliest(until, self->ready_at);
    }
    return self->wait > 0 ? now : until;
}

dg_ns dg_ib_ring_quiet(const struct dg_ib_ring *self, enum dg_ib_ring_result last, dg_ns now)
{
    dg_ns until = DG_NEVER;

    if (last == DG_IB_RING_INTERRUPTED) {
        return DG_NEVER;
    }
    if (last != DG_IB_RING_OK) {
        return now;
    }
    for (uint16_t i = 0; i < self->count; i++) {
        until = dg_earliest(until, device_quiet(&self->devices[i], now));
    }
    return until;
}

void dg_ib_ring_skip(struct dg_ib_ring *self, enum dg_ib_ring_result last, uint32_t cycles)
{
    self->counters.cycles += cycles;
    if (last == DG_IB_RING_INTERRUPTED) {
        self->counters.interrupted += cycles;
        return;
    }
    for (uint16_t i = 0; i < self->count; i++) {
        self->devices[i].counters.cycles += cycles;
    }
}

void dg_ib_ring_skip_ids(struct dg_ib_ring *self, uint32_t cycles)
{
    self->counters.ids += cycles;
}

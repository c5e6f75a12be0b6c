/* SPDX-License-Identifier: MIT */
/*
 * Data cycles that nobody has to run. With the same OUT as before, a cycle only counts and latches,
 * unless
 *
 *   a command waits              it is handled after param_cycles
 *   the self-test ends           OUT is looked at for the first time
 *   ten minutes are over         the operating time is stored
 *
 * Latching is a function of time (60000000h, too: the offset of the last cycle counts), so of all
 * cycles before such a moment only the last one has to be run.
 */
#include "interbus_private.h"

dg_ns dg_ib_quiet(const struct dg_ib *self, dg_ns now)
{
    if (self->setup.model->profile != DG_IB_K3) {
        return DG_NEVER;
    }
    const dg_ns until = dg_after(self->time_mark, IB_TIME_UNIT);
    if (now < self->ready_at) {
        return dg_earliest(until, self->ready_at);
    }
    return self->wait > 0 ? now : until;
}

/* SPDX-License-Identifier: MIT */
#include "drehgeber/bus_reader.h"

#include "bus_private.h"

/* Frames that are clocked after something has happened, for what takes its time to show. */
#define STIRRED (3u * DG_BUS_READ_EVERY)
/* Frames that are caught up with after a step or a pause of the host; older ones are left out. */
#define READS_MAX 1000u

void dg_bus_reader_init(struct dg_bus_reader *self, const struct dg_bus_master_setup *setup,
                        dg_ns init, dg_ns now)
{
    *self = (struct dg_bus_reader){.init = init, .due = dg_after(now, init)};
    dg_bus_master_init(&self->master, setup, now);
    dg_bus_reader_stir(self, self->due);
}

void dg_bus_reader_watch(struct dg_bus_reader *self, bool watched)
{
    self->watched = watched;
    dg_bus_watch(self->master.setup.bus, watched);
}

void dg_bus_reader_stir(struct dg_bus_reader *self, dg_ns now)
{
    self->stirred = dg_after(dg_after(now, self->init), STIRRED);
}

void dg_bus_reader_read(struct dg_bus_reader *self)
{
    const struct dg_master_protocol *protocol = self->master.setup.protocol;
    const uint32_t silent = self->master.silent;

    dg_bus_master_pause(&self->master, self->master.now);
    dg_bus_master_read(&self->master);
    self->counters.frames++;
    self->bad = 0;
    for (size_t i = 0; i < dg_bus_count(self->master.setup.bus); i++) {
        self->bad += protocol->judge(&self->master, i) == DG_MASTER_WRONG;
    }
    self->counters.wrong += self->bad;
    self->silent = self->master.silent - silent;
}

/* Frames are counted that are like the latest one. */
static void skip_frames(struct dg_bus_reader *self, uint64_t n)
{
    self->master.setup.protocol->skip(&self->master, n);
    self->counters.frames += n;
    self->counters.wrong += n * self->bad;
    self->master.silent += (uint32_t)n * self->silent;
    self->due += n * DG_BUS_READ_EVERY;
}

/* Whether somebody wants each frame, or it may come to something. */
static bool is_live(const struct dg_bus_reader *self)
{
    return self->watched || dg_bus_is_bent(self->master.setup.bus);
}

/* Not before the wire is free. */
static dg_ns next_read(const struct dg_bus_reader *self)
{
    return self->due > self->master.now ? self->due : self->master.now;
}

/* Before a frame that is due: the ones that are not clocked. The last one of all is. */
static void pass_over(struct dg_bus_reader *self, dg_ns now)
{
    const dg_ns late = dg_elapsed(now, self->due) / DG_BUS_READ_EVERY;

    if (is_live(self)) {
        self->due += late > READS_MAX ? (late - READS_MAX) * DG_BUS_READ_EVERY : 0;
    } else if (self->due >= self->stirred) {
        skip_frames(self, late);
    }
}

void dg_bus_reader_run(struct dg_bus_reader *self, dg_ns now)
{
    while (next_read(self) <= now) {
        const bool live = is_live(self);
        pass_over(self, now);
        self->master.now = next_read(self);
        dg_bus_reader_read(self);
        self->due += DG_BUS_READ_EVERY;
        if (live && !is_live(self)) { /* a fault is used up: the next ones are not like it */
            dg_bus_reader_stir(self, self->due);
        }
    }
}

dg_ns dg_bus_reader_next(const struct dg_bus_reader *self)
{
    const dg_ns next = next_read(self);

    return is_live(self) || next < self->stirred ? next : DG_NEVER;
}

/* SPDX-License-Identifier: MIT */
/* What a bus tells, kept for a host that is not called. */
#include "drehgeber/bus_queue.h"

static void keep_event(struct dg_bus_queue *self, size_t place, const struct dg_tap_event *event,
                       bool looked)
{
    if (self->count == self->room) {
        self->lost++;
        return;
    }
    self->told[self->count++] =
        (struct dg_bus_told){.event = *event, .place = (uint32_t)place, .looked = looked};
}

static void keep_sent(void *ctx, size_t place, const struct dg_tap_event *event)
{
    keep_event(ctx, place, event, false);
}

static void keep_looked(void *ctx, const struct dg_tap_event *event)
{
    keep_event(ctx, 0, event, true);
}

const struct dg_bus_ops dg_bus_queue_ops = {.tx = keep_sent, .tap = keep_looked};

/* Whoever asks for the present again would stop time. */
static dg_ns later_than(dg_ns moment, dg_ns next)
{
    return next > moment ? next : dg_after(moment, 1);
}

static dg_ns next_step(const struct dg_bus *bus, const struct dg_bus_queue *queue)
{
    return later_than(queue->stepped, dg_bus_next(bus));
}

/* @return when the next one is */
static dg_ns step_queued(struct dg_bus *bus, struct dg_bus_queue *queue, dg_ns at)
{
    queue->stepped = at;
    return later_than(at, dg_bus_step(bus, at));
}

dg_ns dg_bus_step_queued(struct dg_bus *bus, struct dg_bus_queue *queue, dg_ns until, uint32_t most)
{
    dg_ns next = next_step(bus, queue);

    while (next <= until && queue->count < most) {
        next = step_queued(bus, queue, next);
    }
    return next;
}

dg_ns dg_bus_step_burst(struct dg_bus *bus, struct dg_bus_queue *queue, dg_ns until, dg_ns gap)
{
    dg_ns next = dg_bus_step_queued(bus, queue, until, 1);

    while (queue->count > 0 && queue->count < queue->room / 2u &&
           next <= dg_after(queue->told[queue->count - 1u].event.at, gap)) {
        next = step_queued(bus, queue, next);
    }
    return queue->stepped;
}

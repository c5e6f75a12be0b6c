/* SPDX-License-Identifier: MIT */
/*
 * A handle on a bus: apart, so that who has none does not link this.
 */
#include "host_private.h"

static struct host_parts parts_on_bus(const struct dg_device *model, const struct dg_bus_side *side,
                                      bool with_port)
{
    struct host_parts parts = dg_host_parts_of(model, side->wire);
    const size_t queues = parts.settings - HOST_QUEUES_AT;

    parts.settings -= queues;
    parts.device -= queues;
    parts.memory -= queues;
    parts.end = with_port ? parts.memory : parts.end - queues;
    return parts;
}

static size_t size_on_bus(const struct dg_device *model, const struct dg_bus_side *side,
                          bool with_port)
{
    return model->stack == side->wire->stack ? parts_on_bus(model, side, with_port).end : 0;
}

size_t dg_host_size_on_bus(const struct dg_device *model, const struct dg_bus_side *side)
{
    return size_on_bus(model, side, false);
}

size_t dg_host_size_with_port(const struct dg_device *model, const struct dg_bus_side *side)
{
    return size_on_bus(model, side, true);
}

struct dg_host *dg_host_init_on_bus(void *memory, size_t size, const struct dg_device *model,
                                    const struct dg_bus_side *side)
{
    const bool with_port = size < dg_host_size_on_bus(model, side);
    const struct host_parts parts = parts_on_bus(model, side, with_port);
    struct dg_host *self = dg_host_init_parts(memory, size, model, side->wire, &parts);

    if (self != NULL) {
        self->refs.side = side;
    }
    return self;
}

void dg_host_take_side(struct dg_host *self, const struct dg_bus_side *side)
{
    self->refs.side = side;
}

void dg_host_memory_known(struct dg_host *self)
{
    self->loaded = true;
}

void dg_host_join_bus(struct dg_host *self, void (*heard)(void *, const struct dg_host_event *),
                      void *ctx)
{
    dg_host_listen(self, heard, ctx);
    self->line.on_bus = true;
}

bool dg_host_made(const struct dg_host *self)
{
    return self->made;
}

const struct dg_host_wire *dg_host_wire_at(const struct dg_host *self)
{
    return self->refs.wire;
}

const struct dg_bus_side *dg_host_side_at(const struct dg_host *self)
{
    return self->refs.side;
}

struct dg_host_line *dg_host_line_of(struct dg_host *self)
{
    return &self->line;
}

struct dg_world *dg_host_world(struct dg_host *self)
{
    return &self->world;
}

void dg_host_skip(struct dg_host *self, uint64_t now)
{
    self->line.now = now > self->line.now ? now : self->line.now;
}

void dg_host_tell_controller(struct dg_host *self, uint32_t event)
{
    struct dg_host_line *line = &self->line;
    const struct dg_host_event said = {.at = line->now, .id = event, .kind = DG_HOST_BUS};

    if (self->made && !self->line.on_bus) {
        (void)self->refs.wire->take(line, &said);
    }
}

static void take_whole(struct dg_host *self, const struct dg_host_event *event)
{
    struct dg_host_event copy = *event;

    self->line.part = 0;
    while (!dg_host_take_event(self, &copy)) {
    }
    self->line.part = 0;
    dg_host_look_at_level(self);
    dg_host_serve(self);
}

uint64_t dg_host_feed(struct dg_host *self, const struct dg_host_event *event)
{
    const struct dg_host_wire *wire = self->refs.wire;

    dg_host_run_until(self, event->at);
    if (self->made && (wire->feed == NULL || (self->refs.faults != NULL && !self->line.on_bus))) {
        take_whole(self, event);
    } else if (self->made) {
        dg_host_note_controller(self, event);
        self->deadline = wire->feed(&self->line, event);
    }
    return self->refs.queues != NULL ? dg_host_next(self) : self->deadline;
}

/* SPDX-License-Identifier: MIT */
/*
 * Clocked lines into a VCD file. Levels are held back for a moment, so that the note on a frame,
 * which comes when it is over, can stand where it began.
 */
#include "trace_format.h"

#define CLOCK_ID 'm'
#define DATA_ID 's'
/* Not for long. */
#define HELD_MAX DG_MS(100)
/* The fastest clock, 10 MHz, has an edge every 50 ns. */
#define STEP_NS 10u

void lx_trace_clocked_begin(struct lx_trace *self)
{
    static const char ids[] = {CLOCK_ID, DATA_ID, '\0'};
    const struct lx_trace_format *format = self->format;
    const struct lx_vcd_head head = {
        format->scope, STEP_NS, ids, {format->lines[0], format->lines[1]}};
    struct lx_trace_clocked *clocked = self->own;
    clocked->clock = true;
    clocked->data = true;
    lx_vcd_begin(&clocked->vcd, self, &head);
}

/* All levels and texts up to `at`. */
static void release_edge(struct lx_trace_clocked *self, dg_ns at)
{
    while (self->count > 0 && self->held[self->first].at <= at) {
        const struct lx_trace_held *oldest = &self->held[self->first];
        lx_vcd_level(&self->vcd, oldest->at, oldest->id, oldest->level);
        self->first = (self->first + 1u) % LX_TRACE_HELD;
        self->count--;
    }
    lx_vcd_advance(&self->vcd, at);
}

static void hold_edge(struct lx_trace_clocked *self, dg_ns at, char id, bool level)
{
    if (self->count == LX_TRACE_HELD) {
        release_edge(self, self->held[self->first].at);
    }
    self->held[(self->first + self->count) % LX_TRACE_HELD] = (struct lx_trace_held){at, id, level};
    self->count++;
}

static void on_note(struct lx_trace_clocked *self, dg_ns at, const char *note)
{
    if (self->vcd.count == LX_VCD_TEXTS) {
        release_edge(self, self->vcd.texts[0].at);
    }
    lx_vcd_text(&self->vcd, at, note);
}

/* The data line may be low from power-on to the first clock. Nobody tells of it before the first
   edge of the clock, which is a falling one and leaves it as it was. */
static void begin_at(struct lx_trace_clocked *self, bool data)
{
    if (!self->begun && data != self->data && self->vcd.at == 0) {
        self->data = data;
        lx_vcd_level(&self->vcd, 0, DATA_ID, data);
    }
    self->begun = true;
}

static void on_levels(struct lx_trace_clocked *self, dg_ns at, bool clock, bool data)
{
    begin_at(self, data);
    if (clock != self->clock) {
        hold_edge(self, at, CLOCK_ID, clock);
    }
    if (data != self->data) {
        hold_edge(self, at, DATA_ID, data);
    }
    self->clock = clock;
    self->data = data;
}

void lx_trace_clocked_event(struct lx_trace *self, const struct dg_tap_event *event)
{
    struct lx_trace_clocked *clocked = self->own;
    const dg_ns at = dg_elapsed(event->at, self->opened);
    release_edge(clocked, dg_elapsed(at, HELD_MAX));
    if (event->kind == DG_TAP_NOTE) {
        on_note(clocked, at, event->note);
    } else if (event->kind == DG_TAP_LEVELS) {
        on_levels(clocked, at, event->levels.clock, event->levels.data);
    }
}

void lx_trace_clocked_end(struct lx_trace *self)
{
    struct lx_trace_clocked *clocked = self->own;
    release_edge(clocked, DG_NEVER);
    lx_vcd_end(&clocked->vcd);
}

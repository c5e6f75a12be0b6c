/* SPDX-License-Identifier: MIT */
/*
 * Listening costs a line of text for each frame, so a wire is listened to from the first question
 * on, or always with --verbose.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rig_parts.h"

#define US 1000u
#define S 1000000000u

/* "12.345678 < text": seconds of the rig, '<' from the master, '>' from an encoder. */
static void on_line(void *ctx, dg_ns at, bool ours, const char *text)
{
    struct lx_rig_wire *self = ctx;
    const dg_ns since = dg_elapsed(at, self->rig->begin);
    char *line = self->lines[self->line_count % LX_RIG_LINES];
    const int seconds =
        snprintf(line, LX_RIG_LINE_MAX, "%llu.%06llu", (unsigned long long)(since / S),
                 (unsigned long long)(since % S / US));
    (void)snprintf(line + seconds, LX_RIG_LINE_MAX - (size_t)seconds, " %c %s", ours ? '>' : '<',
                   text);
    self->line_count++;
    if (self->rig->setup.verbose) {
        lx_print("%.*s %s%s", seconds, line, self->plan->name, line + seconds);
    }
}

static void look(struct lx_rig_wire *self, dg_ns now)
{
    const dg_ns next = lx_decoder_step(&self->decoder, now);
    lx_timer_at(&self->silence, lx_clock_real(&self->rig->clock, next));
}

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct lx_rig_wire *self = ctx;
    lx_decoder_event(&self->decoder, event);
    look(self, event->at);
}

static void on_silence(void *ctx, dg_ns now)
{
    struct lx_rig_wire *self = ctx;
    (void)now;
    look(self, lx_clock_now(&self->rig->clock));
}

int lx_rig_listen(struct lx_rig_wire *self, struct lx_error *error)
{
    if (self->listens) {
        return 0;
    }
    self->lines = calloc(LX_RIG_LINES, sizeof *self->lines);
    if (self->lines == NULL) {
        return lx_fail(error, "no memory for decoded lines");
    }
    const int result = lx_timer_open(&self->silence, self->rig->setup.event, on_silence, self);
    if (result < 0) {
        free(self->lines);
        self->lines = NULL;
        return lx_fail(error, "no timer: %s", strerror(-result));
    }
    lx_decoder_init(&self->decoder, on_line, self);
    self->listener = (struct lx_tap_listener){.event = on_event, .ctx = self};
    lx_tap_add(&self->bus->tap, &self->listener);
    self->listens = true;
    return 0;
}

void lx_rig_deaf(struct lx_rig_wire *self)
{
    if (!self->listens) {
        return;
    }
    lx_tap_remove(&self->bus->tap, &self->listener);
    lx_timer_close(&self->silence);
    free(self->lines);
    self->lines = NULL;
    self->listens = false;
}

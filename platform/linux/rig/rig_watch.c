/* SPDX-License-Identifier: MIT */
/*
 * Listening costs a line of text for each frame, so a wire is listened to from the first question
 * on, or always with --verbose.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>

#include "rig_parts.h"

#define US 1000u
#define S 1000000000u
#define BEFORE_MAX 32u /* time and direction */
_Static_assert(DG_RIG_LINE_MAX >= BEFORE_MAX + DG_WORDS_MAX, "a line is kept as a whole");

/* "12.345678 < text": seconds of the rig, '<' from the master, '>' from an encoder. */
static void on_line(void *ctx, const struct dg_words_line *words)
{
    struct lx_rig_wire *self = ctx;
    const dg_ns since = dg_elapsed(words->at, self->rig->begin);
    struct dg_rig_line *line = &self->lines[self->line_count % LX_RIG_LINES];
    const int seconds =
        snprintf(line->text, sizeof line->text, "%llu.%06llu", (unsigned long long)(since / S),
                 (unsigned long long)(since % S / US));
    (void)snprintf(line->text + seconds, sizeof line->text - (size_t)seconds, " %c %s",
                   words->ours ? '>' : '<', words->text);
    line->severity = words->severity;
    self->line_count++;
    if (self->rig->setup.verbose) {
        lx_print("%.*s %s%s", seconds, line->text, self->plan->name, line->text + seconds);
    }
}

static void refresh_wire(struct lx_rig_wire *self, dg_ns now)
{
    const dg_ns next = dg_words_step(&self->words, now);
    lx_timer_at(&self->silence, lx_clock_real(&self->rig->clock, next));
}

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct lx_rig_wire *self = ctx;
    dg_words_event(&self->words, event);
    refresh_wire(self, event->at);
}

static void on_silence(void *ctx, dg_ns now)
{
    struct lx_rig_wire *self = ctx;
    (void)now;
    refresh_wire(self, lx_clock_now(&self->rig->clock));
}

/* @return whether there was memory */
static bool make_lines(struct lx_rig_wire *self)
{
    const struct dg_words *words = lx_rig_words(self);
    void *memory = words == NULL ? NULL : calloc(1, words->size);
    self->lines = calloc(LX_RIG_LINES, sizeof *self->lines);
    self->words = (struct dg_words_wire){words, memory, {on_line, self}};
    return self->lines != NULL && (words == NULL || memory != NULL);
}

static void free_lines(struct lx_rig_wire *self)
{
    free(self->words.memory);
    free(self->lines);
    self->words.memory = NULL;
    self->lines = NULL;
}

/* Whoever waits for lines is told why there are none. */
static void tell_mixed(struct lx_rig_wire *self)
{
    const struct dg_tap_event event = {
        .at = lx_clock_now(&self->rig->clock),
        .kind = DG_TAP_NOTE,
        .ours = true,
        .severity = DG_SEVERITY_NOTICE,
        .note = "encoders of several protocols: the data on this wire is not shown in words",
    };
    if (lx_rig_mixed(self)) {
        dg_words_event(&self->words, &event);
    }
}

int lx_rig_listen(struct lx_rig_wire *self, struct lx_error *error)
{
    if (self->listens) {
        return 0;
    }
    if (!make_lines(self)) {
        free_lines(self);
        return lx_fail(error, "no memory for decoded lines");
    }
    if (lx_timer_make(&self->silence, self->rig->setup.event, on_silence, self, error) != 0) {
        free_lines(self);
        return -1;
    }
    self->listener = (struct lx_tap_listener){.event = on_event, .ctx = self};
    lx_tap_add(&self->bus->tap, &self->listener);
    self->listens = true;
    tell_mixed(self);
    return 0;
}

void lx_rig_deaf(struct lx_rig_wire *self)
{
    if (!self->listens) {
        return;
    }
    lx_tap_remove(&self->bus->tap, &self->listener);
    lx_timer_close(&self->silence);
    free_lines(self);
    self->listens = false;
}

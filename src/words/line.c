/* SPDX-License-Identifier: MIT */
/*
 * Lines, and the wire that they tell of.
 */
#include <string.h>

#include "drehgeber/words.h"

/* Of a long frame, so that there is room for what is wrong with it. */
#define BYTES_SHOWN 16u

void dg_words_begin(struct dg_words_draft *self)
{
    self->text = dg_text_in(self->room, sizeof self->room);
    self->severity = DG_SEVERITY_OK;
    self->whole = false;
    self->clause = NULL;
}

void dg_words_judge(struct dg_words_draft *self, enum dg_severity severity)
{
    if (severity > self->severity) {
        self->severity = severity;
    }
}

void dg_words_add_bytes(struct dg_words_draft *self, const char *before, const uint8_t *bytes,
                        size_t n)
{
    struct dg_text *text = &self->text;

    dg_text_add(text, n > 0 ? before : "");
    for (size_t i = 0; i < n && i < BYTES_SHOWN; i++) {
        dg_text_add(text, " ");
        dg_text_add_hex(text, bytes[i], 2);
    }
    dg_text_add(text, n > BYTES_SHOWN ? " ..." : "");
}

void dg_words_add_code(struct dg_words_draft *self, uint32_t code, unsigned digits)
{
    dg_text_add_hex(&self->text, code, digits);
    dg_text_add(&self->text, "h");
}

void dg_words_give(struct dg_words_draft *self, dg_ns at, bool ours, const struct dg_words_to *to)
{
    static const char cut[] = "...";
    const struct dg_words_line line = {
        .at = at,
        .ours = ours,
        .severity = self->severity,
        .text = self->room,
        .whole = self->whole,
        .clause = self->clause,
    };

    if (self->text.length >= DG_WORDS_MAX) {
        memcpy(self->room + DG_WORDS_MAX - sizeof cut, cut, sizeof cut);
    }
    to->line(to->ctx, &line);
}

static void tell_note(const struct dg_words_wire *self, const struct dg_tap_event *event)
{
    struct dg_words_draft draft;

    dg_words_begin(&draft);
    dg_words_judge(&draft, event->severity);
    dg_text_add(&draft.text, event->note);
    dg_words_give(&draft, event->at, event->ours, &self->to);
}

void dg_words_event(const struct dg_words_wire *self, const struct dg_tap_event *event)
{
    if (event->kind == DG_TAP_NOTE) {
        tell_note(self, event);
    } else if (self->words != NULL) {
        self->words->event(self->memory, event, &self->to);
    }
}

dg_ns dg_words_step(const struct dg_words_wire *self, dg_ns now)
{
    const struct dg_words *words = self->words;

    return words == NULL || words->step == NULL ? DG_NEVER
                                                : words->step(self->memory, now, &self->to);
}

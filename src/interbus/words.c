/* SPDX-License-Identifier: MIT */
/*
 * Cycles of an INTERBUS ring: the words that have changed, in runs that name their first one. How
 * they are meant say the highest bits of a device's 32 (manual 5.2, 9.3, 9.4; a K1 has none):
 *
 *   31 30 29 28..25
 *    0                   in operation
 *    1  1                parameters are set: no valid position
 *    1  0  1  0          self-test or read-out: likewise
 *    1  0                error
 */
#include "drehgeber/words.h"
#include "drehgeber/interbus.h"

#include <string.h>

/* More than the devices of a ring have; words beyond are not told. */
#define WORDS_MAX 512u

#define STATUS_WIDTH 2u     /* words of a device that has one */
#define STATUS_MASK 0xFE00u /* of the high word */
#define STATUS_NO_POSITION 0x8000u
#define STATUS_PARAMETERS 0x4000u
#define STATUS_READ_OUT 0xA000u

/* What was told last. */
struct ib_words {
    uint16_t count;
    bool valid;
    uint16_t in[WORDS_MAX];
    uint16_t out[WORDS_MAX];
};

/* Words of an image; `before` NULL: there was none like it. */
struct image {
    const char *name;
    const uint16_t *before;
    const uint16_t *words;
    size_t count;
};

static bool has_word_changed(const struct image *self, size_t i)
{
    return self->before == NULL || self->words[i] != self->before[i];
}

/* @return whether there was a change */
static bool add_changes(struct dg_words_draft *draft, const struct image *image)
{
    struct dg_text *text = &draft->text;
    bool changed = false;
    bool run = false;

    for (size_t i = 0; i < image->count; i++) {
        const bool differs = has_word_changed(image, i);

        if (differs && !run) {
            dg_text_add(text, text->length > 0 ? " " : "");
            dg_text_add(text, image->name);
            dg_text_add(text, "[");
            dg_text_add_number(text, (int64_t)i);
            dg_text_add(text, "]");
        }
        if (differs) {
            dg_text_add(text, " ");
            dg_text_add_hex(text, image->words[i], 4);
        }
        run = differs;
        changed |= differs;
    }
    return changed;
}

static enum dg_severity word_severity_of(uint16_t high)
{
    const unsigned status = high & STATUS_MASK;

    if ((status & STATUS_NO_POSITION) == 0) {
        return DG_SEVERITY_OK;
    }
    return (status & STATUS_PARAMETERS) != 0 || status == STATUS_READ_OUT ? DG_SEVERITY_NOTICE
                                                                          : DG_SEVERITY_ERROR;
}

/* The devices of which the line tells. */
static void judge_devices(struct dg_words_draft *draft, const struct image *in,
                          const uint8_t *widths)
{
    size_t at = 0;

    if (widths == NULL) {
        return;
    }
    for (size_t i = 0; at < in->count; at += widths[i], i++) {
        const bool whole = widths[i] == STATUS_WIDTH && at + 1u < in->count;

        if (whole && (has_word_changed(in, at) || has_word_changed(in, at + 1u))) {
            dg_words_judge(draft, word_severity_of(in->words[at]));
        }
    }
}

/* @return whether there is something to tell */
static bool add_validity(struct dg_words_draft *draft, bool before, bool now)
{
    if (before == now) {
        return false;
    }
    dg_words_judge(draft, now ? DG_SEVERITY_NOTICE : DG_SEVERITY_ERROR);
    dg_text_add(&draft->text, draft->text.length > 0 ? ", " : "");
    dg_text_add(&draft->text, now ? "cycles are valid" : "cycle not completed");
    return true;
}

static void tell_event(void *memory, const struct dg_tap_event *event, const struct dg_words_to *to)
{
    struct ib_words *self = memory;
    const size_t n = event->words.count < WORDS_MAX ? event->words.count : WORDS_MAX;
    const bool first = self->count != n;
    const struct image in = {"IN", first ? NULL : self->in, event->words.in, n};
    const struct image out = {"OUT", first ? NULL : self->out, event->words.out, n};
    struct dg_words_draft draft;

    if (event->kind != DG_TAP_WORDS || n == 0) {
        return;
    }
    dg_words_begin(&draft);
    bool changed = add_changes(&draft, &in);
    changed |= add_changes(&draft, &out);
    judge_devices(&draft, &in, event->words.widths);
    changed |=
        add_validity(&draft, self->valid || (first && event->words.valid), event->words.valid);
    self->count = (uint16_t)n;
    self->valid = event->words.valid;
    memcpy(self->in, event->words.in, n * sizeof self->in[0]);
    memcpy(self->out, event->words.out, n * sizeof self->out[0]);
    if (changed) {
        dg_words_give(&draft, event->at, event->ours, to);
    }
}

const struct dg_words dg_ib_words = {
    .stack = &dg_ib_stack,
    .size = sizeof(struct ib_words),
    .event = tell_event,
};

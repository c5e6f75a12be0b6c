/* SPDX-License-Identifier: MIT */
/*
 * Cycles of an INTERBUS ring: the words that have changed, in runs that name their first one.
 */
#include <string.h>

#include "decode.h"

/* Half of the decoder's words are for IN, half for OUT. */
#define WORDS (sizeof((struct lx_decoder *)0)->words / sizeof(uint16_t) / 2u)

/* @return whether there was a change */
static bool add_changes(struct lx_text *text, const char *name, const uint16_t *before,
                        const uint16_t *words, size_t n)
{
    bool changed = false;
    bool run = false;
    for (size_t i = 0; i < n; i++) {
        const bool differs = before == NULL || words[i] != before[i];
        if (differs && !run) {
            lx_text_add(text, "%s%s[%zu]", text->length > 0 ? " " : "", name, i);
        }
        if (differs) {
            lx_text_add(text, " %04X", words[i]);
        }
        run = differs;
        changed |= differs;
    }
    return changed;
}

bool lx_decode_words(struct lx_decoder *self, const struct dg_tap_event *event,
                     struct lx_text *text)
{
    const size_t n = event->words.count < WORDS ? event->words.count : WORDS;
    const bool first = self->word_count != n;
    if (n == 0) {
        return false;
    }
    uint16_t *in = self->words;
    uint16_t *out = self->words + WORDS;
    bool changed = add_changes(text, "IN", first ? NULL : in, event->words.in, n);
    changed |= add_changes(text, "OUT", first ? NULL : out, event->words.out, n);
    if (event->words.valid != self->valid && !(first && event->words.valid)) {
        lx_text_add(text, "%s%s", text->length > 0 ? ", " : "",
                    event->words.valid ? "cycles are valid" : "cycle not completed");
        changed = true;
    }
    self->word_count = (uint16_t)n;
    self->valid = event->words.valid;
    memcpy(in, event->words.in, n * sizeof *in);
    memcpy(out, event->words.out, n * sizeof *out);
    return changed;
}

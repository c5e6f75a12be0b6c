/* SPDX-License-Identifier: MIT */
/*
 * Eleven characters in words: a line for each request, and one for each reply.
 */
#include "drehgeber/words.h"
#include "drehgeber/eleven.h"

/* A reply that is being collected. */
struct collected {
    dg_ns begin;
    uint32_t length;
    uint8_t bytes[DG_ELEVEN_REPLY];
};

static void tell_request(const struct dg_tap_event *event, const struct dg_words_to *to)
{
    struct dg_words_draft draft;

    dg_words_begin(&draft);
    draft.whole = true;
    dg_text_add(&draft.text, event->character.damaged ? "damaged " : "request ");
    dg_words_add_code(&draft, event->character.byte, 2);
    dg_words_judge(&draft, event->character.damaged ? DG_SEVERITY_ERROR : DG_SEVERITY_OK);
    dg_words_give(&draft, event->at, event->ours, to);
}

static void tell_reply(const struct collected *self, const struct dg_words_to *to)
{
    const uint8_t *bytes = self->bytes;
    const bool lost = (bytes[4] & DG_ELEVEN_LOST) != 0;
    struct dg_words_draft draft;

    dg_words_begin(&draft);
    draft.whole = true;
    dg_words_add_code(&draft, bytes[0], 2);
    dg_text_add(&draft.text, " -> position ");
    dg_text_add_number(&draft.text, bytes[1] | bytes[2] << 8 | (int64_t)bytes[3] << 16);
    dg_text_add(&draft.text, lost ? ", lost" : "");
    dg_words_judge(&draft, lost ? DG_SEVERITY_ERROR : DG_SEVERITY_OK);
    if (dg_eleven_check(bytes, DG_ELEVEN_REPLY) != 0) {
        dg_text_add(&draft.text, ", check sum wrong");
        dg_words_judge(&draft, DG_SEVERITY_ERROR);
    }
    dg_words_give(&draft, self->begin, true, to);
}

static void take_event(void *memory, const struct dg_tap_event *event, const struct dg_words_to *to)
{
    struct collected *self = memory;

    if (event->kind != DG_TAP_CHARACTER) {
        return;
    }
    if (!event->ours) {
        self->length = 0;
        tell_request(event, to);
        return;
    }
    self->begin = self->length == 0 ? event->at : self->begin;
    self->bytes[self->length++] = event->character.byte;
    if (self->length == DG_ELEVEN_REPLY) {
        tell_reply(self, to);
        self->length = 0;
    }
}

const struct dg_words dg_eleven_words = {
    .stack = &dg_eleven_stack, .size = sizeof(struct collected), .event = take_event};

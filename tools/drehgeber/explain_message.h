/* SPDX-License-Identifier: MIT */
/*
 * What is said on a wire as a whole, in words: a frame of a bus, a request or a reply of a line.
 */
#ifndef DREHGEBER_TOOL_EXPLAIN_MESSAGE_H
#define DREHGEBER_TOOL_EXPLAIN_MESSAGE_H

#include "drehgeber/words.h"
#include "explain_source.h"

/* Characters of a line that are one message; more are another one. */
#define EXPLAIN_BYTES_MAX 160u
/* In the key of a remote frame. */
#define EXPLAIN_REMOTE 0x10000u

struct explain_message {
    dg_ns at;      /* characters: the first start bit */
    dg_ns end;     /* of the last character */
    bool ours;     /* an encoder sends it */
    bool other;    /* ... or is asked, with another address */
    bool damaged;  /* a character of it was */
    bool matched;  /* for who compares: the model has said something to it */
    bool waited;   /* ... or was waited for in vain */
    uint32_t key;  /* the CAN-ID; characters: 0 */
    uint32_t each; /* ns that a character takes; frames: 0 */
    size_t n;
    uint8_t bytes[EXPLAIN_BYTES_MAX];
    const char *clause; /* NULL: none */
    char text[DG_WORDS_MAX];
};

/* Messages of a recording. Not to be moved. */
struct explain_talk {
    struct explain_source *source;
    uint32_t address; /* of the encoder that is told; 0: of any */
    enum dg_medium medium;
    bool begun;
    bool held; /* `event` is the next one */
    struct dg_tap_event event;
    struct dg_words_wire wire;    /* of all messages */
    struct explain_message *told; /* gets the words */
};

/* The medium is that of the first event. `wire->words` NULL: those of the medium are taken.
   @return 1; 0: there is nothing in the recording; -1 with `error` */
int explain_talk_begin(struct explain_talk *self, struct lx_error *error);

/* The next message. @return 1; 0: that was all; -1 with `error` */
int explain_talk_next(struct explain_talk *self, struct explain_message *to,
                      struct lx_error *error);

/* Give `message` its words. */
void explain_talk_say(struct explain_talk *self, struct explain_message *message);

/* Give the memory of the words back. */
void explain_talk_end(struct explain_talk *self);

#endif

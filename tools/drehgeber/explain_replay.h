/* SPDX-License-Identifier: MIT */
/*
 * The master's side of a recording, replayed at its moments into a model (explain_model.h), and
 * what the encoder of the recording said against what the model says.
 *
 * What is compared with what: an answer with the answer to the same request, before the next
 * request of its kind; what is said without being asked with what comes within a second. A model
 * that is slower than the encoder was gets the time: what follows in the recording moves by it.
 */
#ifndef DREHGEBER_TOOL_EXPLAIN_REPLAY_H
#define DREHGEBER_TOOL_EXPLAIN_REPLAY_H

#include "explain_message.h"
#include "explain_model.h"

/* Messages that are there at a time, of a second at most. */
#define EXPLAIN_RING 512u
/* Kinds of message that are known. */
#define EXPLAIN_KINDS 64u

/* What the model and the probe say in one call. */
#define EXPLAIN_SAID 64u

struct explain_said {
    dg_ns at;
    uint32_t key;
    size_t n;
    uint8_t bytes[EXPLAIN_BYTES_MAX];
};

/* What one of the two says. */
struct explain_voice {
    size_t count;
    struct explain_said said[EXPLAIN_SAID];
};

/* A difference. */
struct explain_difference {
    dg_ns at;                            /* of the recording */
    const struct explain_message *asked; /* what was answered; NULL: nothing was asked */
    const struct explain_message *came;  /* NULL: nothing */
    const struct explain_said *model;    /* NULL: nothing */
};

/* What is known of messages with a key. */
struct explain_kind {
    uint32_t key;
    dg_ns matched;     /* of the recording: the last one that both have said */
    uint64_t answered; /* the last request that it was said behind; 0: none, else 1 more */
    bool known;        /* both have said it */
    bool spontaneous;  /* ... without being asked */
    bool missing;      /* it was told that the recording does not have it */
};

struct explain_replay {
    struct explain_model *model;
    struct explain_talk *talk;
    void (*differs)(void *ctx, const struct explain_difference *difference);
    void *ctx;
    bool frames;
    bool over;                    /* the recording is */
    dg_ns base;                   /* of the recording */
    dg_ns slip;                   /* the model's time is later by this */
    dg_ns now;                    /* of the model */
    dg_ns busy;                   /* ... which says something until then */
    dg_ns planned;                /* what it had in mind when it was asked last */
    uint64_t first;               /* message in the ring, counted from the first of the recording */
    uint64_t next;                /* that the model has not been told yet */
    uint64_t end;                 /* behind the last one */
    bool was_asked;               /* since it is on, */
    uint64_t asked;               /* ... by this message */
    uint64_t messages;            /* from the encoder */
    struct explain_said greeting; /* at power-on; n 0: none */
    struct explain_message question; /* a copy of `asked` */
    size_t kind_count;
    struct explain_kind kinds[EXPLAIN_KINDS];
    struct explain_voice voices[2];
    struct explain_message ring[EXPLAIN_RING];
};

/* Replay all. @return 0, or -1 with `error` of the recording */
int explain_replay_run(struct explain_replay *self, struct lx_error *error);

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A ring from inside: ring.c is its cycles, ring_answers.c what the master sees in place of what an
 * encoder has said, ring_master.c when there is a cycle.
 *
 *   | struct dg_bus | struct ring | struct member | struct member | ...
 */
#ifndef DREHGEBER_RING_PRIVATE_H
#define DREHGEBER_RING_PRIVATE_H

#include "bus_private.h"
#include "drehgeber/bus_words.h"

/** The wire. */
struct ring {
    struct dg_bus_words_setup setup;
    struct dg_ring_state is;
    uint16_t cut_at;   /* before this encoder, or DG_RING_WHOLE */
    uint16_t spoil_at; /* likewise: the transmission error to come */
    uint8_t dead;      /* cycles to come */
    bool configured;   /* an ID cycle has reached all */
    bool steady;       /* as the latest cycle, which moved words without faults: nothing is new */
    size_t timed;      /* encoders before this place may have a deadline */
    bool id_only;      /* the latest cycle was an ID cycle that the master asked for */
    bool bent;         /* wire faults are at work in this cycle */
    bool keeps;        /* `whole` of each encoder is that of the latest cycle */
    /* what the tap was told last */
    enum dg_ring_result told;
    uint16_t told_reached;
};

/* IN words that are held back: an encoder stores and answers within one cycle, but what its answer
 * acknowledges is not durable yet. */
struct held {
    uint64_t settled; /* ticket of the latest write that is known to be durable, or lost */
    uint64_t looked;  /* ... of the one that was there in the cycle before */
    bool holds;       /* the master sees: */
    uint16_t shown[DG_RING_WORDS_MAX];
    uint16_t command[DG_RING_WORDS_MAX]; /* the OUT words that it answers */
};

/* An encoder at its place. */
struct member {
    struct bus_place place;
    const struct dg_host_ring *ops;
    struct dg_host_line *line;
    uint16_t at; /* of its first word in both images */
    uint16_t id;
    uint8_t words;
    uint16_t whole[DG_RING_WORDS_MAX]; /* IN of the latest cycle, not torn */
    struct held held;
};

static inline struct ring *ring_of(const struct dg_bus *self)
{
    return self->wire;
}

static inline struct member *member_at(const struct dg_bus *self, size_t index)
{
    return (struct member *)(void *)dg_bus_place_at(self, index);
}

static inline struct dg_faults *faults_of(const struct member *self)
{
    return self->place.control != NULL ? &self->place.control->faults : NULL;
}

/** In a data cycle that is about to take place: whether dg_bus_ring_bend_words() is to be called,
 * ring->keeps. From the first such cycle on the words of the one before are known. */
void dg_bus_ring_decide_to_bend(const struct dg_bus *self);
/** The encoders have said IN words, in answer to `out`; the master sees others while faults tear
 * them, and while what they acknowledge is not durable. */
void dg_bus_ring_bend_words(const struct dg_bus *self, const uint16_t *out);

#endif

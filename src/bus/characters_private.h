/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The line of characters from inside: bus_characters.c is the line and its master, reply.c what an
 * encoder says.
 */
#ifndef DREHGEBER_CHARACTERS_PRIVATE_H
#define DREHGEBER_CHARACTERS_PRIVATE_H

#include "bus_private.h"
#include "drehgeber/bus_characters.h"

/** No character of a reply is damaged. */
#define CHARACTERS_WHOLE UINT8_MAX

/** How long a character takes: `whole` ns and `rest` / `baud` of one. */
struct characters_pace {
    uint32_t baud;
    char parity; /**< 'N', 'E', 'O' */
    uint32_t rest;
    dg_ns whole;
};

/** A reply: waiting for its moment, or on the line. */
struct characters_reply {
    struct characters_pace pace; /**< as when it began */
    dg_ns next;                  /**< when something happens to it; DG_NEVER */
    dg_ns start;                 /**< falling edge of the first start bit */
    dg_ns from;                  /**< beginning of the present character, and its end: */
    dg_ns to;
    dg_ns floor;   /**< the end without what it is rounded up by: */
    uint32_t rest; /**< ... rest / pace.baud ns */
    uint8_t bytes[DG_REPLY_MAX];
    uint8_t length;
    uint8_t sent;    /**< characters that are over */
    uint8_t damaged; /**< index of the one that a bit was flipped in (fault) */
    bool begun;      /**< all at once: it was told already */
    bool again;      /**< it is sent a second time (fault) */
    bool merged;     /**< its present character is lost in another one */
};

/** An encoder on the line. */
struct characters_place {
    struct bus_place place;
    struct dg_characters_end end;
    struct characters_pace pace;
    struct dg_host_uart uart; /**< of which `pace` was made */
    struct characters_reply reply;
    dg_ns missed; /**< the latest call in which it was late */
    bool deaf;    /**< inside a request that does not reach it (fault) */
    bool steady;  /**< its protocol has dg_host_wire.feed */
    bool kept;    /**< what it has said waits until what it acknowledges is durable */
    uint8_t said; /**< characters of a reply that is said in the call at hand, or kept: */
    uint8_t saying[DG_REPLY_MAX];
};

/** A character on its way in. */
struct characters_coming {
    dg_ns end; /**< of its stop bit */
    uint32_t baud;
    char parity;
    uint8_t byte;
    bool damaged;
};

/** The line. */
struct characters_line {
    struct dg_characters_setup setup;
    struct dg_characters_counters counters;
    struct characters_pace pace; /**< of the master's latest character */
    dg_ns heard;                 /**< its end; 0: a reply has come since */
    dg_ns end;                   /**< of the last one that is on its way in */
    size_t first;                /**< of these: */
    size_t count;
    struct characters_coming coming[DG_COMING_MAX];
};

static inline struct characters_line *characters_line_of(const struct dg_bus *self)
{
    return self->wire;
}

static inline struct characters_place *characters_place_at(const struct dg_bus *self, size_t index)
{
    return (struct characters_place *)(void *)dg_bus_place_at(self, index);
}

/* --- the line, bus_characters.c --- */

/** A character of `from` is over: tell who looks, and everybody else hears it. */
void dg_bus_spread(struct characters_place *from, dg_ns at, uint8_t byte, bool damaged);

/* --- states, characters_state.c: as struct dg_bus_medium has them --- */

void dg_bus_characters_pass_wire(const struct dg_bus *self, struct bus_tape *tape);
void dg_bus_characters_pass_place(struct bus_place *base, struct bus_tape *tape);

/* --- replies, reply.c --- */

/** The encoder says `n` bytes of a reply; dg_bus_reply_begin() when that was all. What it said
 * before and was kept is lost. */
void dg_bus_reply_add(struct characters_place *self, const uint8_t *bytes, size_t n);

/** What it has said is a reply that is due at `at`: it is kept, is lost, or begins, which cuts off
 * what was on its way. */
void dg_bus_reply_begin(struct characters_place *self, dg_ns at);

/** A kept one may go. */
void dg_bus_reply_release(struct characters_place *self, dg_ns at);

/** A reply ends with the power. */
void dg_bus_reply_stop(struct characters_place *self);

/** Whether a reply is on the line at `now`. */
bool dg_bus_reply_sends(const struct characters_place *self, dg_ns now);

/** Whether it is busy with one, also with one that is kept or late: then it hears nothing. */
bool dg_bus_reply_is_busy(const struct characters_place *self);

/** What is due with it at `at`. */
void dg_bus_reply_go_on(struct characters_place *self, dg_ns at);

#endif

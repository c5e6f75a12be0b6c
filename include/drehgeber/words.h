/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What goes over a wire, in words: a protocol makes lines of text of the events of a tap (tap.h),
 * each with a severity. Each is one const object in a file of its own, src/FOLDER/words.c, so that
 * an image without traces carries nothing of it.
 *
 *   struct dg_words_wire wire = {&dg_hf_words, memory of dg_hf_words.size bytes, all zero, {line,
 * ctx}}; dg_words_event(&wire, event) ... dg_words_step(&wire, now) when the deadline that it
 * returned is over
 *
 * A wire whose protocol has no words is one too: its notes are told, and nothing else.
 */
#ifndef DREHGEBER_WORDS_H
#define DREHGEBER_WORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/tap.h"
#include "drehgeber/text.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_stack;

/** Longest text of a line, with its zero. What does not fit is cut, and ends in "...". */
#define DG_WORDS_MAX 160u

/** A line. The text is valid during the call. */
struct dg_words_line {
    dg_ns at;  /**< when what it tells began */
    bool ours; /**< an encoder sent it, not the master */
    enum dg_severity severity;
    const char *text;
    bool whole; /**< it ends with the event that is being told; else it has ended before */
    /** Chapter of the manual or standard that says what this is, e.g. "5.1.2.1", for as long as the
     * library; NULL: none does. */
    const char *clause;
};

/** Who sends something, for readers of recordings that do not tell. */
enum dg_words_side {
    DG_WORDS_AS_TOLD, /**< it does not say: as event->ours has it */
    DG_WORDS_MASTER,
    DG_WORDS_ENCODER, /**< the encoder with that address */
    DG_WORDS_OTHER,   /**< for or of an encoder with another address */
};

/** Where lines go. */
struct dg_words_to {
    void (*line)(void *ctx, const struct dg_words_line *line);
    void *ctx;
};

/** A protocol's words. What it remembers of a wire is plain data without pointers, all zero at
 * first. */
struct dg_words {
    const struct dg_stack *stack;
    size_t size; /**< bytes that it remembers of a wire, aligned for max_align_t */
    /** Something happened: up to two lines. Never a note. Kinds that the protocol's wire does not
     * have are left alone. */
    void (*event)(void *self, const struct dg_tap_event *event, const struct dg_words_to *to);
    /** It is `now`, all events up to then were told: up to one line. @return when to call again;
     * DG_NEVER. NULL as operation: no line waits for time to pass */
    dg_ns (*step)(void *self, dg_ns now, const struct dg_words_to *to);
    /** Who sends this frame, or the message that begins with this character, on a wire with an
     * encoder at `address`; 0: whatever its address. NULL: nothing on this wire says that.
     * @return enum dg_words_side */
    int (*side)(const struct dg_tap_event *event, uint32_t address);
};

/** A wire that is told in words. */
struct dg_words_wire {
    const struct dg_words *words; /**< NULL: its protocol has none */
    void *memory;                 /**< words->size bytes, the caller's */
    struct dg_words_to to;
};

/** Tell an event of the wire: up to two lines. A note is a line as it is. */
DG_API void dg_words_event(const struct dg_words_wire *self, const struct dg_tap_event *event);

/** Tell that it is `now`: up to one line. @return when to call again, later than `now`; DG_NEVER:
 * only an event can change anything */
DG_API dg_ns dg_words_step(const struct dg_words_wire *self, dg_ns now);

/** All of this library. They link all stacks; who names one of them, in the header of its
 * protocol, links that one. */
DG_API extern const struct dg_words *const dg_words_list[];
DG_API extern const size_t dg_words_count;

/** The words of a stack, or NULL: it has none. */
DG_API const struct dg_words *dg_words_of(const struct dg_stack *stack);

/* ---------------------------------------------------------------- for dg_words.event */

/** A line that is being written; not to be moved. */
struct dg_words_draft {
    struct dg_text text;
    enum dg_severity severity;
    bool whole;                   /**< the event at hand is the last one of what it tells */
    const char *clause;           /**< as in the line; NULL */
    char room[DG_WORDS_MAX + 1u]; /**< a character more than a line has: then it is cut */
};

/** An empty line, which is fine so far. */
DG_API void dg_words_begin(struct dg_words_draft *self);

/** The line tells something of this severity; the worst one counts. */
DG_API void dg_words_judge(struct dg_words_draft *self, enum dg_severity severity);

/** Append bytes, as in " 0A FF", 16 at most, then " ..."; `before` stands before the first, and not
 * without one. */
DG_API void dg_words_add_bytes(struct dg_words_draft *self, const char *before,
                               const uint8_t *bytes, size_t n);

/** Append a code as in "0Ah", with so many digits. */
DG_API void dg_words_add_code(struct dg_words_draft *self, uint32_t code, unsigned digits);

/** The line is whole. */
DG_API void dg_words_give(struct dg_words_draft *self, dg_ns at, bool ours,
                          const struct dg_words_to *to);

#ifdef __cplusplus
}
#endif

#endif

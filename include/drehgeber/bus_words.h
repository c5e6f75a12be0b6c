/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A ring: one shift register through all its encoders, each with one or two words in either image,
 * in the order in which they were attached. Words and time go in, words come out; bits on the wire
 * are not emulated.
 *
 *   const struct dg_bus_words_setup ring = {sizeof ring, in, DG_COUNT(in), true};
 *   setup.medium = &dg_bus_words, setup.wire = &ring
 *   event = {.at = now, .kind = DG_TAP_WORDS, .words = {.out = out, .count = n}}
 *   dg_bus_rx(bus, &event)            a data cycle: IN words are in `in`
 *   event.words.identify = true       an ID cycle
 *
 * Both images have the same layout, the high word of an encoder first. The master reads the IN
 * image and dg_ring_state(); dg_bus_ops.tx is not told.
 *
 * A data cycle brings nothing, and takes no OUT words, while an encoder is without power or cut off
 * before (interrupted), until an ID cycle has reached all of them (identify), and after a
 * transmission error (crc, dead). IN words then are those from before.
 */
#ifndef DREHGEBER_BUS_WORDS_H
#define DREHGEBER_BUS_WORDS_H

#include "drehgeber/bus.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The medium. */
DG_API extern const struct dg_bus_medium dg_bus_words;

/** Most encoders in a ring. */
#define DG_RING_MAX 512u
/** Most words of an encoder in either image. */
#define DG_RING_WORDS_MAX 2u
/** "The ring is not interrupted." */
#define DG_RING_WHOLE UINT16_MAX

/** What dg_bus_setup.wire is for a ring; it must be there. */
struct dg_bus_words_setup {
    size_t size;     /**< sizeof(struct dg_bus_words_setup) */
    uint16_t *in;    /**< the IN image: the ring writes it, and it outlives the ring */
    size_t words;    /**< room in it; dg_bus_attach() is DG_ERR_SPACE when it is full */
    bool identifies; /**< the master runs an ID cycle at once behind a data cycle that was
                          interrupted, or that an ID cycle has to come before */
};

/** What became of a data cycle. Other than OK: no OUT was taken, IN holds its last value. */
enum dg_ring_result {
    DG_RING_OK,          /**< loop-back word and check sequence came back right */
    DG_RING_CRC,         /**< transmission error */
    DG_RING_DEAD,        /**< one of the DG_RING_DEAD_CYCLES after it */
    DG_RING_INTERRUPTED, /**< no loop-back: a break, or an encoder without power */
    DG_RING_IDENTIFY,    /**< whole, but an ID cycle has to come first: start, after a break */
};

/** Things nobody has to act on; they only count up. */
struct dg_ring_counters {
    uint32_t cycles;      /**< data cycles, whatever became of them */
    uint32_t ids;         /**< ID cycles */
    uint32_t crc_errors;  /**< DG_RING_CRC */
    uint32_t dead;        /**< DG_RING_DEAD */
    uint32_t interrupted; /**< DG_RING_INTERRUPTED */
};

/** What a ring has come to. */
struct dg_ring_state {
    enum dg_ring_result result; /**< of the latest data cycle; DG_RING_IDENTIFY before the first */
    bool dropped;               /**< ... but a fault let the latest one not take place at all */
    uint16_t words;             /**< of either image */
    uint16_t reached;           /**< encoders, by the latest ID cycle */
    struct dg_ring_counters counters;
};

/** The same struct for the life of the bus, which has to be a ring. */
DG_API const struct dg_ring_state *dg_ring_state(const struct dg_bus *self);

/** The ID word of the encoder at `place`, as the latest ID cycle that reached it has read it; 0:
 * none has. */
DG_API uint16_t dg_ring_id_word(const struct dg_bus *self, size_t place);

/** The ring is cut before the encoder at `place`; DG_RING_WHOLE: it is not. Beside that, wire
 * faults of the encoders cut it. */
DG_API void dg_ring_cut(struct dg_bus *self, uint16_t place);

/** The next data cycle that would bring something fails at the encoder at `place`. */
DG_API void dg_ring_spoil(struct dg_bus *self, uint16_t place);

/**
 * Until when cycles need not be run, for masters that sleep: those before the returned time that
 * are like the latest one, with the same OUT words, only count and latch. It is enough to run the
 * last of them and to count the others, dg_ring_skip(); the first one at or after the time has to
 * be run. What is done to the ring, an encoder or its world ends it: the next cycle has to be run
 * then.
 * @return the moment of the latest one: the next cycle has to be run; DG_NEVER
 */
DG_API dg_ns dg_ring_quiet(const struct dg_bus *self);

/** Count `cycles` that are not run and would have come to the same as the latest one. */
DG_API void dg_ring_skip(struct dg_bus *self, uint32_t cycles);

#ifdef __cplusplus
}
#endif

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A serial protocol that no encoder has: one character asks, eleven answer. 2.5 MBd, 8N1; several
 * encoders on a line, each in a slot. Its figures are those of no device.
 *
 *   master   |request|
 *   encoder           reaction |request|position, 3|status|0|0|0|0|0|check|
 *
 *   request   bits 0-2: 010, 3-6: slot, 7: their even parity
 *   position  in the turn, 24 bits, low byte first
 *   status    bit 0: the singleturn track cannot be read
 *   check     exclusive or of the ten before it
 */
#ifndef DREHGEBER_ELEVEN_H
#define DREHGEBER_ELEVEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/key.h"
#include "drehgeber/stack.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dg_bus_side;
struct dg_host_wire;
struct dg_instrument;
struct dg_words;

/** Data rate of the line; there is no parity. */
#define DG_ELEVEN_BAUD 2500000u
/** Start bit, eight of data, stop bit. */
#define DG_ELEVEN_CHARACTER_NS 4000u
/** Characters of a reply. */
#define DG_ELEVEN_REPLY 11u
/** Slots there are. */
#define DG_ELEVEN_SLOTS 16u
/** Bits of a position. */
#define DG_ELEVEN_BITS 24u
/** In a status: the position is not to be trusted. */
#define DG_ELEVEN_LOST 1u

/** What a model is. */
struct dg_eleven_model {
    uint8_t slot;   /**< 0..15 */
    dg_ns reaction; /**< from the end of the request to the start of the reply */
};

/** What goes out. */
struct dg_eleven_ops {
    /** Send DG_ELEVEN_REPLY bytes without a gap, from now on. May not call back. */
    void (*tx)(void *ctx, const uint8_t *bytes);
};

/** Things nobody has to act on; they only count up. */
struct dg_eleven_counters {
    uint32_t replies;
    uint32_t strange; /**< characters that are no request for its slot */
    uint32_t damaged; /**< characters with a framing error, or at another data rate */
};

/** A device: caller-owned plain data, made by dg_eleven_stack. */
struct dg_eleven {
    const struct dg_eleven_model *model;
    const struct dg_world *world;
    const struct dg_eleven_ops *ops; /**< NULL: nobody hears it */
    void *ctx;
    dg_ns due; /**< the reply; DG_NEVER: none */
    struct dg_eleven_counters counters;
    uint8_t asked;
    bool powered;
};

/** The request for a slot, 0..15. */
DG_API uint8_t dg_eleven_request(uint8_t slot);
/** A character came in, its stop bit ended at `now`. @return when to step; DG_NEVER */
DG_API dg_ns dg_eleven_hear(struct dg_eleven *self, dg_ns now, uint8_t byte, bool damaged);
/** The exclusive or of n bytes. */
DG_API uint8_t dg_eleven_check(const uint8_t *bytes, size_t n);

/** The protocol: devices are struct dg_eleven, without an EEPROM. */
DG_API extern const struct dg_stack dg_eleven_stack;
/** Its model. */
DG_API extern const struct dg_device dg_eleven_24;
/** What can be set of a struct dg_eleven_model. */
DG_API extern const struct dg_keys dg_eleven_keys;
/** The protocol behind a handle, as an instrument, in words. */
DG_API extern const struct dg_host_wire dg_eleven_wire;
DG_API extern const struct dg_bus_side dg_eleven_side;
DG_API extern const struct dg_instrument dg_eleven_instrument;
DG_API extern const struct dg_words dg_eleven_words;
/** What looks at a device that somebody has made, see stack.h. */
DG_API extern const struct dg_stack_check dg_eleven_state;

#ifdef __cplusplus
}
#endif

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What wire faults do to what one encoder sends and hears: characters, frames and words. Levels of
 * a clocked line have line_fault.h.
 */
#ifndef DREHGEBER_WIRE_FAULT_H
#define DREHGEBER_WIRE_FAULT_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/control.h"
#include "drehgeber/time.h"

#ifdef __cplusplus
extern "C" {
#endif

/** No byte of it is damaged. */
#define DG_WIRE_WHOLE SIZE_MAX

/** What becomes of a reply or a frame, of all that an encoder sends at once. */
struct dg_wire_sent {
    dg_ns delay;    /**< it begins later by that */
    unsigned times; /**< it arrives: 0 not at all, 2 once more behind the first time */
    size_t damaged; /**< the byte that a bit is flipped in; DG_WIRE_WHOLE */
    uint8_t flip;   /**< that bit of it */
};

/** Of something that nothing happens to. */
#define DG_WIRE_UNBENT ((struct dg_wire_sent){.times = 1, .damaged = DG_WIRE_WHOLE})

/** The faults at work on `encoder` happen to something of `length` bytes that it sends. Each one
 * that happens counts down. */
DG_API struct dg_wire_sent dg_wire_fault_send(struct dg_encoder *encoder, size_t length);

/** What becomes of something that the encoder should hear. */
enum dg_wire_heard {
    DG_WIRE_HEARD,   /**< it hears it */
    DG_WIRE_UNHEARD, /**< it does not */
    DG_WIRE_LOST,    /**< its controller has lost it, and says so */
};

/** The faults at work on `encoder` happen to something that it should hear. */
DG_API enum dg_wire_heard dg_wire_fault_hear(struct dg_encoder *encoder);

#ifdef __cplusplus
}
#endif

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the decoder: a line under construction, and what each wire says.
 */
#ifndef DREHGEBER_LINUX_DECODE_H
#define DREHGEBER_LINUX_DECODE_H

#include "trace.h"

/** A line; what does not fit is cut, and its end shows it. */
struct lx_text {
    char text[LX_DECODE_MAX];
    size_t length;
};

/** Append, printf style. */
void lx_text_add(struct lx_text *self, const char *format, ...);

/** Append bytes, as in " 0A FF", but not too many; `before` stands before the first. */
void lx_text_bytes(struct lx_text *self, const char *before, const uint8_t *bytes, size_t n);

/** The RS485 frame that was collected (manual of the S36, chapter 5.1). */
void lx_decode_hf(const struct lx_decoder *self, struct lx_text *text);

/** A CAN frame in the words of CANopen, by the predefined connection set. Keeps track of SDO block
 * transfers. */
void lx_decode_can(struct lx_decoder *self, const struct dg_can_frame *frame, struct lx_text *text);

/** The SDO part of it: `reply` is from the server, node 1..127. */
void lx_decode_sdo(struct lx_decoder *self, const struct dg_can_frame *frame, uint8_t node,
                   bool reply, struct lx_text *text);

/** A cycle of an INTERBUS ring. @return false when nothing has changed and there is no line */
bool lx_decode_words(struct lx_decoder *self, const struct dg_tap_event *event,
                     struct lx_text *text);

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The frames of a CAN bus in one message of a simulation, little endian:
 *
 *   8  ns: when the first one was sent      then of each frame, in their order:
 *   2  how many frames                      4  ns behind the first one
 *   2  0                                    2  identifier; 8000h more: it is remote
 *                                           1  DLC, 0..8
 *                                           1  0
 *                                           DLC bytes, none of a remote one
 */
#ifndef DREHGEBER_LINUX_SILKIT_PACK_H
#define DREHGEBER_LINUX_SILKIT_PACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/frame.h"

/** The media type of such messages. */
#define LX_SILKIT_PACK_TYPE "application/vnd.drehgeber.can.v1"
/** Bytes in front, and of a frame without its data. */
#define LX_SILKIT_PACK_HEAD 12u
#define LX_SILKIT_PACK_FRAME 8u
/** The longest message, below a megabyte. */
#define LX_SILKIT_PACK_FRAMES UINT16_MAX
#define LX_SILKIT_PACK_MAX                                                                         \
    (LX_SILKIT_PACK_HEAD + LX_SILKIT_PACK_FRAMES * (LX_SILKIT_PACK_FRAME + 8u))

/** A message that is being put together. All zero: it is empty. */
struct lx_silkit_pack {
    uint8_t *bytes; /**< owned; grows to what the busiest step needs */
    size_t length;  /**< 0: there is no frame in it */
    size_t capacity;
    uint64_t begin; /**< when the first one was sent */
    uint16_t count;
};

/** Append a frame that is sent at `at`, not before the last one. @return false: it does not fit any
 * more, or there is no memory; then it is as before */
bool lx_silkit_pack_add(struct lx_silkit_pack *self, uint64_t at, const struct dg_can_frame *frame);

/** Begin anew; its memory stays. */
void lx_silkit_pack_clear(struct lx_silkit_pack *self);

/** Give its memory back. */
void lx_silkit_pack_free(struct lx_silkit_pack *self);

/** Whether `n` bytes of somebody else are such a message, to the last byte. */
bool lx_silkit_pack_is_good(const uint8_t *bytes, size_t n);

/** The frame at `*at` of a good message; the first one is at LX_SILKIT_PACK_HEAD.
 * @return false: there is none any more. Else `*at` is that of the next one */
bool lx_silkit_pack_next(const uint8_t *bytes, size_t n, size_t *at, struct dg_can_frame *frame);

#endif

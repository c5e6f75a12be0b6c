/* SPDX-License-Identifier: MIT */
/* CAN frames to and from a real encoder: by SocketCAN, by an SLCAN adapter, by a socketcand; in a
   SIL Kit simulation. */
#ifndef DREHGEBER_TOOL_VERIFY_FRAMES_H
#define DREHGEBER_TOOL_VERIFY_FRAMES_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/canopen.h"
#include "error.h"
#include "verify_stream.h"

/* Longest line of an adapter, longest message of a socketcand. */
#define VERIFY_LINE_MAX 80u

struct verify_frames_form;

struct verify_frames {
    struct verify_stream stream;
    const struct verify_frames_form *form; /* what frames look like; NULL: as SocketCAN has them */
    char line[VERIFY_LINE_MAX];            /* of an adapter, so far */
    size_t length;
    uint8_t bytes[256]; /* that the adapter has sent, and that were not looked at */
    size_t count;
    size_t seen;
};

/* Open options->wire at options->where: "can", "slcan", "socketcand" or "silkit". 0, or -1 with `error`. */
int verify_frames_open(struct verify_frames *self, const struct options *options,
                       struct lx_error *error);

/* @return 0, or -1: the wire takes nothing any more. A socketcand has no remote frames: they get
   lost */
int verify_frames_send(struct verify_frames *self, const struct dg_can_frame *frame);

/* Whether it carries remote frames. */
bool verify_frames_has_remote(const struct verify_frames *self);

/* The next frame that comes by `until`. @return 1, 0: none, -1: the wire is gone */
int verify_frames_receive(struct verify_frames *self, dg_ns until, struct dg_can_frame *to);

void verify_frames_close(struct verify_frames *self);

#endif

/* SPDX-License-Identifier: MIT */
/* CAN frames to and from a real encoder: by SocketCAN, or by an SLCAN adapter. */
#ifndef DREHGEBER_TOOL_VERIFY_FRAMES_H
#define DREHGEBER_TOOL_VERIFY_FRAMES_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/canopen.h"
#include "error.h"

/* Longest line of an adapter. */
#define VERIFY_LINE_MAX 64u

struct verify_frames {
    int fd; /* -1: closed */
    bool adapter;
    char line[VERIFY_LINE_MAX]; /* of an adapter, so far */
    size_t length;
    uint8_t bytes[256]; /* that the adapter has sent, and that were not looked at */
    size_t count;
    size_t seen;
};

/* Open the wire of this kind, "can" or "slcan", at `where`. 0, or -1 with `error`. */
int verify_frames_open(struct verify_frames *self, const char *kind, const char *where,
                       struct lx_error *error);

/* @return 0, or -1: the wire takes nothing any more */
int verify_frames_send(struct verify_frames *self, const struct dg_can_frame *frame);

/* The next frame that comes by `until`. @return 1, 0: none, -1: the wire is gone */
int verify_frames_receive(struct verify_frames *self, dg_ns until, struct dg_can_frame *to);

void verify_frames_close(struct verify_frames *self);

#endif

/* SPDX-License-Identifier: MIT */
/* A real encoder with RS485 (verify_hiperface.c), and how it is put back (verify_hiperface_back.c). */
#ifndef DREHGEBER_TOOL_VERIFY_HIPERFACE_H
#define DREHGEBER_TOOL_VERIFY_HIPERFACE_H

#include "hiperface_steps.h"
#include "verify_parts.h"
#include "verify_stream.h"

#define FRAME_MAX DG_HF_FRAME_MAX
#define ADDRESS 0x40u
/* Bits of a character, and of the pause that ends a frame and that a master keeps behind one. */
#define CHARACTER_BITS 11u
#define PAUSE_BITS 55u
/* A frame is over when nothing has come for so long; adapters hand over what came in pieces, and
   networks hold them up. */
#define IDLE DG_MS(40)
#define NETWORK_IDLE DG_MS(200)
/* The longest time of 5.1.2 that a reply may take, and what a host adds to it. */
#define REPLY_MAX DG_MS(300)
/* How long an answer that must not come is waited for: those that read take 30 ms at most. */
#define SILENCE DG_MS(100)
#define HOST_ADDS DG_MS(20)
/* 52h is answered within 5 ms behind its pause. */
#define SCAN_REPLY_MAX DG_MS(60)
/* What is thrown away before somebody is said never to stop. */
#define NOISE_MAX 2000u
/* Readings from which the shaft's rest and the host's jitter are known. */
#define READINGS 20u
#define MOVES_MAX 64u
#define STATUS_READS_MAX 8u
/* Increments that may be needed to put a counter back; each takes 50 ms. */
#define COUNTS_MAX 50u
#define CODE DG_HF_CODE_DEFAULT
/* Bytes of the label with the sensors of 44h: three of them, three words each. */
#define LIMITS 18u
#define LIMITS_EACH 6u

struct frame {
    uint8_t bytes[FRAME_MAX + 1u]; /* room to notice one too many */
    size_t n;
    dg_ns at; /* of its first byte */
};

struct hiperface {
    struct verify_encoder base;
    struct dg_hf_model model;
    struct cf_hiperface_trial trial;
    struct verify_stream wire;
    dg_ns sent;  /* end of the last request, as the line has it */
    dg_ns quiet; /* of the last byte in either direction */
    dg_ns jitter;
    uint32_t moves;         /* counts between readings at rest */
    uint8_t setting;        /* of the line, as 52h has it */
    bool has_limits;        /* its label tells what its sensors can measure */
    uint8_t limits[LIMITS]; /* from 1Eh of the label: channel, lowest and highest value of each */
    bool has_fields;        /* data of its owner, which nothing may touch */
    struct frame request;
};

static inline struct hiperface *of(struct verify_encoder *base)
{
    return (struct hiperface *)base;
}

static inline uint32_t be32(const uint8_t *from)
{
    return (uint32_t)from[0] << 24 | (uint32_t)from[1] << 16 | (uint32_t)from[2] << 8 | from[3];
}

/* Ask up to three times: a host that is busy may have been late. `command` alone is the request.
   @return whether `length` bytes came that answer it */
bool verify_hiperface_ask_again(struct hiperface *self, uint8_t command, size_t length,
                                struct frame *to, struct cf_report *report);

/* Put it back to its address from each one that the journal says it was given. @return whether it answers
   there */
bool verify_hiperface_find(struct hiperface *self, struct cf_report *report);

/* Send `request`, with its check sum behind it. @return whether something has come that is no
   error */
bool verify_hiperface_command(struct hiperface *self, const uint8_t *request, size_t n,
                              struct frame *to);

/* Whether two positions are as near to each other as readings at rest. */
bool verify_hiperface_is_near(const struct hiperface *self, uint32_t a, uint32_t b);

/* See verify_parts.h. */
bool verify_hiperface_put_back(struct verify_encoder *base, struct cf_report *report);

#endif

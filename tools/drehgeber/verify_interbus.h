/* SPDX-License-Identifier: MIT */
/* A real encoder with INTERBUS (verify_interbus.c), and how it is put back (verify_interbus_back.c). */
#ifndef DREHGEBER_TOOL_VERIFY_INTERBUS_H
#define DREHGEBER_TOOL_VERIFY_INTERBUS_H

#include "interbus_steps.h"
#include "verify_coupler.h"
#include "verify_parts.h"

/* Status bits of a word, and those of them that a position does not have (2.1.3). */
#define STATUS 0xFE000000u
#define RELEASE 0x80000000u
/* Words that set the mode, with bit 0 for speed, and with the number of a cam program. */
#define POSITION_MODE 0x20400000u
#define PROGRAM 0x20800000u
/* Words that read (9.2): an item, and what cams are set to. */
#define READ_ITEM 0x20210000u
#define READ_BACK 0x20200000u
#define READ_SHIFT_IW 0x20200040u
/* What is read: 9.2. */
enum item {
    ITEM_SERIAL = 0,
    ITEM_STEPS = 1,
    ITEM_REVOLUTIONS = 2,
    ITEM_DIRECTION = 3,
    ITEM_PRESET = 4,
    ITEM_SHIFT = 5,
    ITEM_VERSION = 7,
    ITEM_TIME = 8,
    ITEM_MODE = 9,
    ITEM_FLAGS = 10,
    ITEM_TEMPERATURE = 12,
    ITEM_CHIP = 13
};

struct interbus {
    struct verify_encoder base;
    struct verify_coupler wire;
    struct dg_ib_model model; /* with what is the encoder's own */
    struct cf_interbus_trial trial;
    dg_ns jitter;
    dg_ns handled;  /* the longest time that an OUT took so far to be seen in IN */
    uint32_t moves; /* counts between readings at rest */
    bool delivered; /* its parameters are as it was delivered */
    bool named;     /* the coupler says the ID word */
    uint16_t id;
    dg_ns sent; /* when OUT was written last */
    uint32_t out;
    uint32_t command; /* the last OUT that was one */
    uint32_t before;  /* IN when OUT was written */
    bool settled;     /* IN was looked at since, and stays */
    bool chosen;      /* the row has set the mode */
    unsigned writes;  /* what the row that was rehearsed last changes, bits of enum cf_need */
};

static inline struct interbus *of(struct verify_encoder *base)
{
    return (struct interbus *)base;
}

/* Write OUT, and wait until IN is what `is_right` wants of it, up to the longest time that an
   encoder may take. @return false: it is not, or the coupler is lost */
bool verify_interbus_exchange(struct interbus *self, uint32_t out,
                              bool (*is_right)(uint32_t out, uint32_t in), uint32_t *in);

/* What is read by this word, 25 bits. @return false: it is not answered */
bool verify_interbus_read(struct interbus *self, uint32_t word, uint32_t *value);

/* The encoder is in operation, and OUT is 0. @return false: it cannot be put there, as `report`
   says */
bool verify_interbus_settle(struct interbus *self, struct cf_report *report);

bool verify_interbus_is_near(const struct interbus *self, uint32_t a, uint32_t b);

/* Note how everything is put back that a row may write. @return false: the journal is full, or the
   encoder does not say it */
bool verify_interbus_note(struct interbus *self);

/* See verify_parts.h. */
bool verify_interbus_put_back(struct verify_encoder *base, struct cf_report *report);

#endif

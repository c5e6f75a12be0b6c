/* SPDX-License-Identifier: MIT */
/* A real encoder with BiSS (verify_biss.c), and how it is put back (verify_biss_back.c). */
#ifndef DREHGEBER_TOOL_VERIFY_BISS_H
#define DREHGEBER_TOOL_VERIFY_BISS_H

#include "biss_steps.h"
#include "verify_lines.h"
#include "verify_parts.h"

#define BANK_SELECT 0x40u
#define COMMAND 0x60u
#define TIMEOUT_SELECT 0x7Cu
/* Bank 0. */
#define CONFIG_FIRST 0x1Bu
#define CONFIG_SIZE 9u
/* Commands, 60h written. */
#define STORE 0x01u
#define CLEAR 0x06u
/* How a note of the journal says that a command frame was sent, where others have an address. */
#define NOTE_COMMAND 0xC0u
/* Longest time that an EEPROM may take, and a start. */
#define EEPROM_MAX DG_MS(20)

/* Longest text about what was asked or answered. */
#define VERIFY_BISS_TEXT 500u

/* What is known of the life counter in place of its latest value. */
enum life { LIFE_ANY = -1, LIFE_START = -2 };

struct biss {
    struct verify_encoder base;
    struct verify_lines wire;
    struct biss_master master;
    struct dg_biss_model model; /* with what is the encoder's own */
    struct cf_biss_trial trial;
    uint64_t moves; /* counts between readings at rest */
    int life;       /* of the latest frame, or enum life */
    bool delivered; /* bank 0 is selected and as delivered */
    /* what the row that was rehearsed last does */
    unsigned writes; /* bits of enum cf_need */
    uint32_t banks;  /* bit n: user bank n is written */
    uint8_t bank;    /* that is selected */
    /* what was asked last, and has come */
    struct cf_biss_frames frames;
    struct cf_biss_access access;
    struct biss_command command;
    unsigned bad;                 /* frames of it that were not good */
    int expected;                 /* what LC of its last frame had to be, or enum life */
    char asked[VERIFY_BISS_TEXT]; /* that access, in words */
};

static inline struct biss *of(struct verify_encoder *base)
{
    return (struct biss *)base;
}

/* Read registers of the window, or others. @return false: they are refused, or nobody answers */
bool verify_biss_read(struct biss *self, uint8_t address, uint8_t *bytes, size_t n);

/* Write them, likewise. */
bool verify_biss_write(struct biss *self, uint8_t address, const uint8_t *bytes, size_t n);

/* A frame with CDM = 0 that is good, so that its word is in self->frames.last. @return false: there
   is none */
bool verify_biss_frame(struct biss *self);

/* Whether two positions are as near to each other as readings at rest. */
bool verify_biss_is_near(const struct biss *self, uint64_t a, uint64_t b);

/* Whether what was asked last was answered as the model has answered it. */
enum cf_verdict verify_biss_judge(const struct biss *self, const struct cf_unit *answer);

/* An access in words, in VERIFY_BISS_TEXT bytes. */
void verify_biss_print_request(const struct cf_biss_access *access, char *to);

/* What was asked last, what the model has answered, what has come. */
void verify_biss_tell(const struct biss *self, const struct cf_unit *got,
                      char text[3][VERIFY_BISS_TEXT]);

/* Note how everything is put back that the row may write. @return false: the journal is full, or the
   encoder does not say it */
bool verify_biss_note(struct biss *self);

/* See verify_parts.h. */
bool verify_biss_put_back(struct verify_encoder *base, struct cf_report *report);

#endif

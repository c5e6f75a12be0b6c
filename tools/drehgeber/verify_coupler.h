/* SPDX-License-Identifier: MIT */
/* The first encoder of a ring, behind a Modbus/TCP coupler with the registers of `drehgeber map`. */
#ifndef DREHGEBER_TOOL_VERIFY_COUPLER_H
#define DREHGEBER_TOOL_VERIFY_COUPLER_H

#include <modbus/modbus.h>
#include <stdbool.h>
#include <stdint.h>

#include "error.h"

/* How long the coupler may take for an answer. */
#define VERIFY_COUPLER_LIMIT_MS 1000u

struct verify_coupler {
    modbus_t *modbus; /* NULL: closed */
    unsigned words;   /* of the encoder, in either image */
    bool lost;        /* it does not answer: nothing is sent any more */
};

/* Connect to the coupler at HOST:PORT. 0, or -1 with `error`. */
int verify_coupler_open(struct verify_coupler *self, const char *where, unsigned words,
                        struct lx_error *error);

/* What the encoder sends. @return false: the coupler is lost */
bool verify_coupler_in(struct verify_coupler *self, uint32_t *in);

/* What the encoder is sent from the next cycle on, whole. @return false: the coupler is lost */
bool verify_coupler_out(struct verify_coupler *self, uint32_t out);

/* The ID word of the encoder, without messages. @return false: the coupler does not say it */
bool verify_coupler_id(struct verify_coupler *self, uint16_t *id);

/* Words of the whole ring. @return false: the coupler does not say it */
bool verify_coupler_ring(struct verify_coupler *self, uint16_t *words);

void verify_coupler_close(struct verify_coupler *self);

#endif

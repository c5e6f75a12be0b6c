/* SPDX-License-Identifier: MIT */
/*
 * The wire of a CiA 406 encoder in words: those of CANopen.
 */
#include "drehgeber/words.h"

#include "drehgeber/canopen.h"
#include "drehgeber/cia406.h"

const struct dg_words dg_cia406_words = {
    .stack = &dg_cia406_stack,
    .size = sizeof(struct dg_co_words),
    .event = dg_co_words_event,
    .side = dg_co_words_side,
};

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The protocols of this library as instruments. Each is an object file of its own, so that a
 * program which names one of them (in the header of its protocol) carries that one; dg_instruments
 * and dg_instrument_of() link them all, and with them all stacks.
 */
#ifndef DREHGEBER_INSTRUMENTS_H
#define DREHGEBER_INSTRUMENTS_H

#include "drehgeber/api.h"
#include "drehgeber/instrument.h"

#ifdef __cplusplus
extern "C" {
#endif

/** All of them, in the order in which their commands are told. */
DG_API extern const struct dg_instrument *const dg_instruments[];
DG_API extern const size_t dg_instrument_count;

/** The instrument of a stack, or NULL: it has none. */
DG_API const struct dg_instrument *dg_instrument_of(const struct dg_stack *stack);

#ifdef __cplusplus
}
#endif

#endif

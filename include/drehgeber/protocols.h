/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The protocols and models of this library, a word for each: all lists of them are made of these
 * rows, each by whoever needs it, so that a program links what it names. The handles' list is in
 * src/host/make.c, those of models and of what texts can say of them, of instruments and of words
 * in src/devices, src/instruments and src/words.
 */
#ifndef DREHGEBER_PROTOCOLS_H
#define DREHGEBER_PROTOCOLS_H

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "drehgeber/ssi.h"

/** ROW(PREFIX) for each protocol: there are dg_PREFIX_stack, dg_PREFIX_wire for its handles,
 * dg_PREFIX_side for buses and dg_PREFIX_instrument. Their commands are told in this order. */
#define DG_PROTOCOLS(ROW) ROW(hf) ROW(biss) ROW(cia406) ROW(ib) ROW(ssi)

/** ROW(PREFIX) for those that have dg_PREFIX_words; the masters of the others tell their frames in
 * notes, which need none. */
#define DG_PROTOCOLS_IN_WORDS(ROW) ROW(hf) ROW(cia406) ROW(ib)

/** ROW(PREFIX) for those that have dg_PREFIX_model_text; a model of another one is no text. */
#define DG_PROTOCOLS_WITH_MODEL_TEXT(ROW) ROW(hf) ROW(biss) ROW(ib) ROW(ssi)

/** ROW(PREFIX) for those that have dg_PREFIX_model_file: files of another kind are models of
 * theirs. */
#define DG_PROTOCOLS_WITH_MODEL_FILE(ROW) ROW(cia406)

/* clang-format off */
/** ROW(NAME) for each model: there is dg_NAME, a struct dg_device. They are listed in this order.
 */
#define DG_MODELS(ROW) \
    ROW(s3674_rs485) ROW(s3684_rs485) \
    ROW(s3674_biss) ROW(s3684_biss) \
    ROW(ssi_13) ROW(ssi_25) ROW(ssi_28) \
    ROW(f3658) ROW(f3668) \
    ROW(ocd_ib_k1) ROW(ocd_ib_k2) ROW(ocd_ib_k3)
/* clang-format on */

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Kübler F36x8 CANopen: what the encoder adds to a CANopen node. Source: manual F36x8 CANopen,
 * chapters 10 and 26; decisions in src/cia406/README.md.
 */
#ifndef DREHGEBER_CIA406_H
#define DREHGEBER_CIA406_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/canopen.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Physical steps a turn: 16 bit. */
#define DG_CIA406_STEPS 65536u

/** What a model is; every figure is configuration. */
struct dg_cia406_model {
    uint32_t turns;                    /**< 1 (singleturn) .. 65536; a power of two */
    const struct dg_co_device *device; /**< identity and dictionary */
};

/** An encoder behind a node: dg_co_setup.application points to it. Caller-owned plain data. */
struct dg_cia406 {
    const struct dg_cia406_model *model;
    uint32_t raw; /**< physical position of the latest sample, 0..turns * steps - 1 */
};

/** The singleturn and the multiturn device. */
extern const struct dg_co_device dg_cia406_singleturn;
extern const struct dg_co_device dg_cia406_multiturn;

/** Make an encoder. @return 0 or DG_ERR_ARGUMENT */
int dg_cia406_init(struct dg_cia406 *self, const struct dg_cia406_model *model);

#ifdef __cplusplus
}
#endif

#endif

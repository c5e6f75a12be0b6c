/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A rig for SSI: an encoder with its world on a line in virtual time, and a master as simple
 * as can be. Everything lives in the struct; a rig may be saved and put back by assignment, to the
 * same place only.
 */
#ifndef DREHGEBER_VERIFY_SSI_RIG_H
#define DREHGEBER_VERIFY_SSI_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/ssi.h"

/** Encoder, shaft and master. */
struct ssi_rig {
    struct dg_world world;
    dg_angle angle;       /**< of the shaft, at time 0 */
    int64_t angle_per_us; /**< speed */
    struct dg_ssi_model model;
    struct dg_ssi device;

    dg_ns now;
    dg_ns low_ns;  /**< from a falling edge to the next rising one; 500 ns from ssi_rig_init() */
    dg_ns high_ns; /**< from a rising edge to the next falling one, likewise */
    bool strayed;  /**< data moved where it must not: on a falling edge */
};

/** A healthy world, shaft at angle 0, an encoder without power. @return dg_ssi_init()'s */
int ssi_rig_init(struct ssi_rig *self, const struct dg_ssi_model *model);

/** Power on, and wait for the end of the initialisation. */
void ssi_rig_power_on(struct ssi_rig *self);

/** Let time pass, with a call of dg_ssi_step() when it is due. @return the level of data */
bool ssi_rig_wait(struct ssi_rig *self, dg_ns span);

/** The clock is at `level` now. @return the level of data */
bool ssi_rig_edge(struct ssi_rig *self, bool level);

/**
 * `n` pulses: the clock falls, rises, and data is looked at when it is about to fall again, which
 * is the moment this returns. @param n 0..64 @return the bits, the last one lowest
 */
uint64_t ssi_rig_take(struct ssi_rig *self, unsigned n);

/** Bits of a word, worked out here and not by the library. */
unsigned ssi_rig_bits(const struct dg_ssi_model *model);

/** The word that has to come, likewise. @param error whether there is one */
uint64_t ssi_rig_word(const struct dg_ssi_model *model, uint32_t position, bool error);

#endif

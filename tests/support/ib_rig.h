/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for an OCD INTERBUS encoder: one device with its world, its EEPROM and a master that
 * cycles in virtual time. Everything lives in the struct; a rig may be saved and put back by
 * assignment, to the same place only (the device points to its world and its EEPROM).
 */
#ifndef TESTS_SUPPORT_IB_RIG_H
#define TESTS_SUPPORT_IB_RIG_H

#include <stdint.h>

#include "drehgeber/interbus.h"
#include "ram_nvm.h"

/** From cycle to cycle. */
#define IB_RIG_CYCLE DG_MS(1)

struct ib_rig {
    struct dg_ib_model model;
    struct dg_world world;
    dg_angle angle;       /**< of the shaft, at time 0 */
    int64_t angle_per_ms; /**< speed, at most 2^43 */
    struct ram_nvm nvm;
    struct dg_ib device;
    dg_ns now;
    uint32_t in; /**< of the last cycle */
};

/** A healthy world, shaft at angle 0, a formatted EEPROM, the device off. @return dg_ib_init()'s */
int ib_rig_init(struct ib_rig *self, const struct dg_ib_model *model);

/** Power on, and OUT 00000000h until the self-test is over. @return dg_ib_power_on()'s */
int ib_rig_power_on(struct ib_rig *self);

/** One cycle later. @return IN */
uint32_t ib_rig_cycle(struct ib_rig *self, uint32_t out);

/** OUT until its answer is there: model.param_cycles + 1 cycles. @return the last IN */
uint32_t ib_rig_send(struct ib_rig *self, uint32_t out);

/** Release, then OUT 00000000h. @return IN in operation */
uint32_t ib_rig_release(struct ib_rig *self);

/** Turn the shaft to the middle of a step of the discs. */
void ib_rig_turn_to(struct ib_rig *self, int64_t counts);

#endif

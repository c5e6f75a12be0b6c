/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for faults: one device of a kind at a time, running in virtual time, the faults on it,
 * and how it looks from its wire. There is one, as there is one of each rig in it.
 */
#ifndef TESTS_SUPPORT_FAULT_RIG_H
#define TESTS_SUPPORT_FAULT_RIG_H

#include "biss_rig.h"
#include "co_rig.h"
#include "drehgeber/control.h"
#include "hf_rig.h"
#include "ib_rig.h"

/** Long enough for a node to have looked at its world. */
#define FAULT_RIG_LOOK DG_MS(150)

struct fault_rig {
    struct dg_faults faults;
    struct dg_fault_target target; /**< of the device that was started last */
    struct hf_rig hf;
    struct biss_rig biss;
    struct co_rig co;
    struct ib_rig ib;
};

extern struct fault_rig fault_rig;
/** Until cleared, at every frame. */
extern const struct dg_fault_limits fault_rig_forever;

/** A fresh device, powered on and ready, without a fault (cmocka assertions, all of them). */
void fault_rig_start_hf(void);
void fault_rig_start_biss(void);
void fault_rig_start_co(void);
void fault_rig_start_k3(void);
void fault_rig_start_k2(void);

/** Let the fault called `name` happen, and make it good. */
void fault_rig_set(const char *name);
void fault_rig_clear(const char *name);

/** RS485: the oldest entry of the error stack, which is empty afterwards. */
uint32_t fault_rig_oldest(void);
/** BiSS: 69h; and nERR and nWARN of a frame, 3 when both are high. */
uint32_t fault_rig_errors(void);
uint32_t fault_rig_states(void);
/** CANopen: EMCY codes since the last look, the newest on the right. */
uint32_t fault_rig_emcy(void);

#endif

/* SPDX-License-Identifier: MIT */
/*
 * OCD INTERBUS. Identities are examples; the command line changes them.
 */
#include "drehgeber/devices.h"
#include "drehgeber/interbus.h"

/* What the OCD share: manual 2.1, 5.4; serial number and version are chosen. */
#define OCD_IB                                                                                     \
    .steps = 4096, .temperature_sensor = true, .param_cycles = 3, .serial = 1234567,               \
    .version = 0x0110, .self_test = DG_MS(100)

static const struct dg_ib_model ocd_ib_k1 = {OCD_IB, .profile = DG_IB_K1, .turns = 1};
static const struct dg_ib_model ocd_ib_k2 = {OCD_IB, .profile = DG_IB_K2, .turns = 4096};
static const struct dg_ib_model ocd_ib_k3 = {OCD_IB, .profile = DG_IB_K3, .turns = 4096};

/* clang-format off */
const struct dg_device dg_ocd_ib_k1 = {"ocd-ib-k1", "INTERBUS, ENCOM profile K1", "4096 steps, singleturn", &dg_ib_stack, &ocd_ib_k1, 0};
const struct dg_device dg_ocd_ib_k2 = {"ocd-ib-k2", "INTERBUS, ENCOM profile K2", "4096 steps, 4096 turns", &dg_ib_stack, &ocd_ib_k2, 0};
const struct dg_device dg_ocd_ib_k3 = {"ocd-ib-k3", "INTERBUS, ENCOM profile K3", "4096 steps, 4096 turns, parameters", &dg_ib_stack, &ocd_ib_k3, 0};
/* clang-format on */

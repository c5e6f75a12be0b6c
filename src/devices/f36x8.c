/* SPDX-License-Identifier: MIT */
/*
 * F36x8 CANopen.
 */
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"

#define F36X8_PASSWORD 0x004B7562u
static const struct dg_cia406_model f3658 = {
    .turns = 1,
    .device = &dg_cia406_singleturn,
    .password = F36X8_PASSWORD,
};
static const struct dg_cia406_model f3668 = {
    .turns = 4096,
    .device = &dg_cia406_multiturn,
    .password = F36X8_PASSWORD,
};

const struct dg_device dg_f3658 = {
    "f3658", "CANopen (CiA 406)", "65536 steps, singleturn", &dg_cia406_stack, &f3658, 0};
const struct dg_device dg_f3668 = {
    "f3668", "CANopen (CiA 406)", "65536 steps, 4096 turns", &dg_cia406_stack, &f3668, 0};

/* SPDX-License-Identifier: MIT */
/*
 * An encoder that answers with eleven characters.
 */
#include "drehgeber/eleven.h"
#include "drehgeber/devices.h"

static const struct dg_eleven_model figures = {.reaction = DG_US(3)};

const struct dg_device dg_eleven_24 = {
    "eleven-24", "eleven characters", "24 bit, singleturn", &dg_eleven_stack, &figures, 0};

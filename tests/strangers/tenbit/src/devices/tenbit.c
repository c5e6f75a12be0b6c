/* SPDX-License-Identifier: MIT */
/*
 * Encoders with words of ten bits.
 */
#include "drehgeber/tenbit.h"
#include "drehgeber/devices.h"

static const struct dg_tenbit_model low = {.open = false};
static const struct dg_tenbit_model high = {.open = true};

/* clang-format off */
const struct dg_device dg_tenbit_low = {"tenbit-low", "words of ten bits", "10 bit, singleturn; low without a driver", &dg_tenbit_stack, &low, 0};
const struct dg_device dg_tenbit_high = {"tenbit-high", "words of ten bits", "10 bit, singleturn; high without a driver", &dg_tenbit_stack, &high, 0};
/* clang-format on */

/* SPDX-License-Identifier: MIT */
/*
 * Generic SSI: the layouts that makers have in common (src/ssi/README.md).
 */
#include "drehgeber/ssi.h"
#include "drehgeber/devices.h"

static const struct dg_ssi_model ssi_13 = {
    .singleturn_bits = 13,
    .monoflop = DG_SSI_MONOFLOP_NS,
    .init = DG_MS(100),
};
static const struct dg_ssi_model ssi_25 = {
    .multiturn_bits = 12,
    .singleturn_bits = 13,
    .monoflop = DG_SSI_MONOFLOP_NS,
    .init = DG_MS(100),
};
static const struct dg_ssi_model ssi_28 = {
    .multiturn_bits = 12,
    .singleturn_bits = 16,
    .code = DG_SSI_BINARY,
    .error_bit = DG_SSI_ERROR_HIGH,
    .parity = DG_SSI_PARITY_EVEN,
    .monoflop = DG_SSI_MONOFLOP_NS,
    .init = DG_MS(100),
};

/* clang-format off */
const struct dg_device dg_ssi_13 = {"ssi-13", "SSI", "13 bit Gray, singleturn", &dg_ssi_stack, &ssi_13, 0};
const struct dg_device dg_ssi_25 = {"ssi-25", "SSI", "13 bit Gray, 4096 turns", &dg_ssi_stack, &ssi_25, 0};
const struct dg_device dg_ssi_28 = {"ssi-28", "SSI", "16 bit, 4096 turns, error bit, parity", &dg_ssi_stack, &ssi_28, 0};
/* clang-format on */

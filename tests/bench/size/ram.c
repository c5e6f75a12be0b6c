/* SPDX-License-Identifier: MIT */
/* What a device costs in RAM: `nm -S` of this object says it for a machine that cannot run us. */
#include "drehgeber/hiperface.h"

extern const unsigned char dg_hf_ram[sizeof(struct dg_hf)];
const unsigned char dg_hf_ram[sizeof(struct dg_hf)] = {0};

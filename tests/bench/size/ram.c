/* SPDX-License-Identifier: MIT */
/* What a device costs in RAM: `nm -S` of this object says it for a machine that cannot run us. */
#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"

#define RAM(device)                                                                                \
    extern const unsigned char ram_##device[sizeof(struct device)];                                \
    const unsigned char ram_##device[sizeof(struct device)] = {0}

RAM(dg_hf);
RAM(dg_biss);
RAM(dg_cia406_device);
RAM(dg_ib);

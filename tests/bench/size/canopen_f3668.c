/* SPDX-License-Identifier: MIT */
#include "canopen_device.h"
#include "drehgeber/cia406.h"

static struct dg_cia406 encoder;

const struct dg_co_device *const device = &dg_cia406_multiturn;

void *device_start(void)
{
    static const struct dg_cia406_model model = {.turns = 4096, .device = &dg_cia406_multiturn};

    (void)dg_cia406_init(&encoder, &model);
    return &encoder;
}

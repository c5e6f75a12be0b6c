/* SPDX-License-Identifier: MIT */
/*
 * All models; their figures are in a file for each family.
 */
#include "drehgeber/devices.h"

#include <stdint.h>

#include "drehgeber/protocols.h"
#include "drehgeber/text.h"

#define ROW(name) &dg_##name,
const struct dg_device *const dg_devices[] = {DG_MODELS(ROW)};
#undef ROW

const size_t dg_device_count = DG_COUNT(dg_devices);

const struct dg_device *dg_device_find(const char *name)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        if (dg_text_same(dg_devices[i]->name, name, SIZE_MAX, NULL)) {
            return dg_devices[i];
        }
    }
    return NULL;
}

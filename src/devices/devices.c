/* SPDX-License-Identifier: MIT */
/*
 * All models; their figures are in a file for each family.
 */
#include "drehgeber/devices.h"

#include <stdint.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "drehgeber/ssi.h"
#include "drehgeber/text.h"

const struct dg_device *const dg_devices[] = {
    &dg_s3674_rs485, &dg_s3684_rs485,             /* RS485 + SinCos */
    &dg_s3674_biss,  &dg_s3684_biss,              /* BiSS */
    &dg_ssi_13,      &dg_ssi_25,      &dg_ssi_28, /* SSI */
    &dg_f3658,       &dg_f3668,                   /* CANopen */
    &dg_ocd_ib_k1,   &dg_ocd_ib_k2,   &dg_ocd_ib_k3,
};

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

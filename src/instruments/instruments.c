/* SPDX-License-Identifier: MIT */
/*
 * All instruments; each is described in its protocol's folder.
 */
#include "drehgeber/instruments.h"

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "drehgeber/ssi.h"

const struct dg_instrument *const dg_instruments[] = {
    &dg_hf_instrument, &dg_biss_instrument, &dg_cia406_instrument,
    &dg_ib_instrument, &dg_ssi_instrument,
};

const size_t dg_instrument_count = DG_COUNT(dg_instruments);

const struct dg_instrument *dg_instrument_of(const struct dg_stack *stack)
{
    for (size_t i = 0; i < dg_instrument_count; i++) {
        if (dg_instruments[i]->stack == stack) {
            return dg_instruments[i];
        }
    }
    return NULL;
}

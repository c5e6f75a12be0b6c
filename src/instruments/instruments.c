/* SPDX-License-Identifier: MIT */
/*
 * All instruments; each is described in its protocol's folder.
 */
#include "drehgeber/instruments.h"

#include "drehgeber/protocols.h"

#define ROW(prefix) &dg_##prefix##_instrument,
const struct dg_instrument *const dg_instruments[] = {DG_PROTOCOLS(ROW)};
#undef ROW

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

/* SPDX-License-Identifier: MIT */
/** Wire faults of an encoder on a bus under test, by what they do. */
#ifndef TESTS_SUPPORT_STATION_FAULT_H
#define TESTS_SUPPORT_STATION_FAULT_H

#include "bus.h"

/** Let `fault` happen to `count` frames, 0: until mended. The bus is not told. */
void station_bend(struct lx_station *station, const struct dg_stack *stack,
                  enum dg_wire_fault fault, uint32_t count);

/** Make it good. The bus is not told. */
void station_mend(struct lx_station *station, const struct dg_stack *stack,
                  enum dg_wire_fault fault);

#endif

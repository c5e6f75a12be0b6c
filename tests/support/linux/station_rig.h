/* SPDX-License-Identifier: MIT */
/** Encoders of a bus under test: healthy, on a shaft that the test turns; wire faults of one. */
#ifndef TESTS_SUPPORT_STATION_RIG_H
#define TESTS_SUPPORT_STATION_RIG_H

#include "bus.h"

/** The encoder `plan`, the one at `place` of its bus, on a shaft that stands at `*angle`. */
void station_make(struct lx_station *station, const struct dg_plan_encoder *plan, size_t place,
                  dg_angle *angle);

/** Let `fault` happen to `count` frames from `now` on, 0: until mended. The bus is not told. */
void station_bend(struct lx_station *station, dg_ns now, enum dg_wire_fault fault, uint32_t count);

/** Make it good. The bus is not told. */
void station_mend(struct lx_station *station, enum dg_wire_fault fault);

/** Close it. Says in a line `stall: ...` what its wire was late: if the test fails,
 * tests/gates/tally.py wants to know. */
void station_close_bus(struct lx_bus *bus);

#endif

/* SPDX-License-Identifier: MIT */
/** Encoders of a bus under test, on a shaft that the test turns; wire faults of one. */
#ifndef TESTS_SUPPORT_STATION_RIG_H
#define TESTS_SUPPORT_STATION_RIG_H

#include "engine.h"

/** Its shaft stands at `*angle`. */
void station_turn(struct lx_station *station, dg_angle *angle);

/** What is made of `plan` on `event` with `clock`, quiet; bus.writer and the like are NULL. */
struct lx_engine_setup station_setup(const struct dg_plan *plan, sd_event *event,
                                     const struct lx_clock *clock);

/** Let `fault` happen to `count` frames from `now` on, 0: until mended. The bus is not told. */
void station_bend(struct lx_station *station, dg_ns now, enum dg_wire_fault fault, uint32_t count);

/** Make it good. The bus is not told. */
void station_mend(struct lx_station *station, enum dg_wire_fault fault);

/** Close the engine with its only bus. Says in a line `stall: ...` what its wire was late: if the
 * test fails, tests/gates/tally.py wants to know. */
void station_close(struct lx_engine *engine);

#endif

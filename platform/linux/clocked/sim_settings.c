/* SPDX-License-Identifier: MIT */
#include "sim_settings.h"

#include <stddef.h>

#define AT(field) offsetof(struct lx_clocked_timing, field)

/* clang-format off */
static const struct dg_key keys[] = {
    {"clock_hz",      "Hz", AT(clock_hz),      DG_KEY_U32, 0, 1, LX_CLOCK_MIN_HZ, LX_CLOCK_MAX_HZ,      NULL, "simulated wire: clock of the master"},
    {"line_delay_ns", "ns", AT(line_delay_ns), DG_KEY_U32, 0, 1, 0,                    LX_CABLE_DELAY_MAX_NS, NULL, "simulated wire: delay of the cable each way; 5 ns are a metre"},
};
/* clang-format on */

const struct lx_keys lx_sim_keys = {.rows = keys, .count = DG_COUNT(keys)};

const struct lx_clocked_timing lx_sim_timing = {.clock_hz = LX_CLOCK_HZ};

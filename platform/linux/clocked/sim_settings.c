/* SPDX-License-Identifier: MIT */
#include "sim_settings.h"

#include <stddef.h>
#include <string.h>

#define AT(field) offsetof(struct lx_clocked_timing, field)

/* clang-format off */
static const struct dg_key keys[] = {
    {"clock_hz",      "Hz", AT(clock_hz),      DG_KEY_U32,  0, 1, LX_CLOCK_MIN_HZ, LX_CLOCK_MAX_HZ,       NULL,          "simulated wire: clock of the master"},
    {"line_delay_ns", "ns", AT(line_delay_ns), DG_KEY_U32,  0, 1, 0,               DG_BUS_CABLE_MAX_NS, NULL,          "simulated wire: delay of the cable each way; 5 ns are a metre"},
    {"compensate",    "",   AT(compensate),    DG_KEY_FLAG, 0, 1, 0,               1,                     dg_key_no_yes, "simulated wire: the master takes its samples later by the way there and back"},
};
/* clang-format on */

const struct dg_keys lx_sim_keys = {.rows = keys, .count = DG_COUNT(keys)};

const struct lx_clocked_timing lx_sim_timing = {.clock_hz = LX_CLOCK_HZ, .compensate = true};

/* A bit is looked at half a period behind the edge that it belongs to. */
static int check_timing(const struct lx_clocked_timing *timing, struct lx_error *error)
{
    const uint64_t back_ns = (uint64_t)2u * timing->line_delay_ns;
    struct lx_words right = {""};
    if (timing->compensate || 2u * back_ns * timing->clock_hz <= DG_S(1)) {
        return 0;
    }
    lx_words_add(&right, "clock_hz up to %u is right", (unsigned)(DG_S(1) / (2u * back_ns)));
    return lx_refuse(error, right.text,
                     "the way there and back, %u ns, is longer than half a period of %u Hz",
                     (unsigned)back_ns, timing->clock_hz);
}

/* By itself it is right: somebody has set it. */
static int refuse_key(const struct dg_plan *plan, const struct dg_plan_wire *wire, const char *key,
                      struct lx_error *error)
{
    const struct dg_plan_setting *row = wire->settings.list;
    while (strcmp(row->key, key) != 0) {
        row++;
    }
    return lx_plan_refuse_setting(plan, row, error);
}

int lx_sim_timing_set(const struct dg_plan *plan, const struct dg_plan_wire *wire,
                      const struct lx_clocked *line, struct lx_clocked_timing *timing,
                      struct lx_error *error)
{
    *timing = lx_sim_timing;
    if (lx_wire_settings(&lx_sim_keys, plan, wire, timing, error) != 0) {
        return -1;
    }
    if (check_timing(timing, error) != 0) {
        return refuse_key(plan, wire, "compensate", error);
    }
    return lx_clocked_check_rate(line, timing->clock_hz, error) == 0
               ? 0
               : refuse_key(plan, wire, "clock_hz", error);
}

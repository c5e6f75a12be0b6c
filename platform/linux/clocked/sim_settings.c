/* SPDX-License-Identifier: MIT */
#include "sim_settings.h"

#include <string.h>

/* A bit is looked at half a period behind the edge that it belongs to. */
static int check_timing(const struct dg_plan_timing *timing, struct lx_error *error)
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

int lx_sim_timing_check(const struct lx_bus_setup *setup, const struct lx_clocked *line,
                        struct lx_error *error)
{
    const struct dg_plan_timing *timing =
        &dg_engine_wire_of(setup->engine, setup->index)->line.timing;
    if (check_timing(timing, error) != 0) {
        return refuse_key(setup->plan, setup->wire, "compensate", error);
    }
    return lx_clocked_check_rate(line, timing->clock_hz, error) == 0
               ? 0
               : refuse_key(setup->plan, setup->wire, "clock_hz", error);
}

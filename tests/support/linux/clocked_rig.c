/* SPDX-License-Identifier: MIT */
#include "clocked_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

void clocked_rig_connect(struct lx_clocked *line, struct dg_host *host, struct dg_encoder *control,
                         const struct dg_bus_edges_setup *wire, const struct lx_tap *tap)
{
    static _Alignas(DG_HOST_ALIGN) uint8_t memory[4096];
    const struct dg_bus_setup setup = {
        .size = sizeof setup,
        .medium = &dg_bus_edges,
        .encoders = 1,
        .wire = wire,
        .ops = &line->ops,
        .ctx = line,
    };
    struct dg_bus *bus = dg_bus_init(memory, sizeof memory, &setup);
    assert_non_null(bus);
    assert_int_equal(dg_bus_attach(bus, host, control), 0);
    lx_clocked_connect(line, bus, tap);
}

void clocked_rig_begin(struct dg_bus_master *master, struct lx_clocked *line, struct dg_host *host,
                       struct dg_encoder *control, const struct dg_plan_timing *timing,
                       const struct lx_tap *tap)
{
    struct dg_bus_master_setup setup = {
        .size = sizeof setup,
        .protocol = line->protocol->master,
        .clock_hz = timing->clock_hz,
        .line_delay_ns = timing->line_delay_ns,
        .compensates = timing->compensate,
    };
    const struct dg_bus_edges_setup cable = dg_bus_master_wire(&setup);
    clocked_rig_connect(line, host, control, &cable, tap);
    lx_clocked_listen(line);
    setup.bus = line->bus;
    dg_bus_master_init(master, &setup, CLOCKED_RIG_BEGIN);
}

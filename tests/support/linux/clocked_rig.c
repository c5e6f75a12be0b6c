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

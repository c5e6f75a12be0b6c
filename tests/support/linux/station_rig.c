/* SPDX-License-Identifier: MIT */
#include "station_rig.h"

#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

#include "drehgeber/instruments.h"

static dg_angle turned(void *ctx, dg_ns now)
{
    (void)now;
    return *(const dg_angle *)ctx;
}

void station_turn(struct lx_station *station, dg_angle *angle)
{
    struct dg_world *world = station->control->world;
    world->angle = turned;
    world->angle_ctx = angle;
    world->calm = NULL;
}

struct lx_engine_setup station_setup(const struct dg_plan *plan, sd_event *event,
                                     const struct lx_clock *clock)
{
    static const struct lx_say quiet = {.quiet = true};
    return (struct lx_engine_setup){
        .bus = {.event = event, .say = &quiet, .plan = plan, .clock = clock}};
}

static size_t entry_of(const struct dg_fault_target *target, enum dg_wire_fault fault)
{
    struct dg_fault_entry entry;
    for (size_t n = 0; dg_fault_entry(target, n, &entry); n++) {
        if (entry.kind == DG_FAULT_WIRE && entry.row->wire == fault) {
            return n;
        }
    }
    fail_msg("no entry for wire fault %d", (int)fault);
    return 0;
}

static struct dg_fault_target target_of(struct lx_station *station)
{
    return (struct dg_fault_target){
        .instrument = dg_instrument_of(station->plan->model->stack),
        .world = station->control->world,
    };
}

void station_bend(struct lx_station *station, dg_ns now, enum dg_wire_fault fault, uint32_t count)
{
    const struct dg_fault_target target = target_of(station);
    const struct dg_fault_limits limits = {count, 1000000, DG_NEVER};
    assert_int_equal(
        dg_fault_set(&station->control->faults, &target, entry_of(&target, fault), now, &limits),
        DG_OK);
}

void station_mend(struct lx_station *station, enum dg_wire_fault fault)
{
    const struct dg_fault_target target = target_of(station);
    assert_int_equal(dg_fault_clear(&station->control->faults, &target, entry_of(&target, fault)),
                     DG_OK);
}

void station_close(struct lx_engine *engine)
{
    const struct lx_bus *bus = engine->wires[0].bus;
    const uint64_t late = bus->late + bus->stalls;
    if (late > 0) {
        (void)printf("stall: wire_late=%" PRIu64 "\n", late);
    }
    lx_engine_close(engine);
}

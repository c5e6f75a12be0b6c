/* SPDX-License-Identifier: MIT */
#include "edges_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"

struct edges_rig edges_rig;

static void keep_event(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    assert_int_equal(place, 0); /* the wires are of all encoders */
    assert_true(event->ours && event->kind == DG_TAP_LEVELS);
    if (edges_rig.heard_count < EDGES_RIG_HEARD_MAX) {
        edges_rig.heard[edges_rig.heard_count++] = *event;
    }
}

static void count_event(void *ctx, const struct dg_tap_event *event)
{
    (void)ctx;
    assert_true(event->at >= edges_rig.tapped);
    edges_rig.tapped = event->at;
    edges_rig.taps++;
}

enum dg_bus_answer edges_rig_answer(void *ctx, size_t place)
{
    (void)ctx;
    (void)place;
    return edges_rig.answer;
}

void edges_rig_begin(const struct dg_bus_edges_setup *wire, size_t encoders)
{
    memset(&edges_rig, 0, sizeof edges_rig);
    edges_rig.ops = (struct dg_bus_ops){.tx = keep_event, .tap = count_event};
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = &dg_bus_edges,
                                       .encoders = encoders,
                                       .wire = wire,
                                       .ops = &edges_rig.ops};
    assert_in_range(dg_bus_size(&dg_bus_edges, encoders), 1, sizeof edges_rig.memory);
    edges_rig.bus = dg_bus_init(edges_rig.memory, sizeof edges_rig.memory, &setup);
    assert_non_null(edges_rig.bus);
}

/* A handle without queues. */
struct dg_host *edges_rig_make(struct edges_rig_place *self, const struct dg_device *model,
                               const struct dg_bus_side *side,
                               const struct dg_instrument *instrument)
{
    self->host = dg_host_init_on_bus(self->memory.bytes, sizeof self->memory.bytes, model, side);
    assert_non_null(self->host);
    self->control = (struct dg_encoder){
        .name = model->name,
        .model = model,
        .instrument = instrument,
        .device = dg_host_line_of(self->host)->device,
        .world = dg_host_world(self->host),
        .faults.random = 1,
    };
    return self->host;
}

struct dg_host *edges_rig_model(size_t place, const char *name)
{
    const struct dg_device *model = dg_device_find(name);

    return edges_rig_make(&edges_rig.place[place], model, dg_bus_side_of(model),
                          dg_instrument_of(model->stack));
}

void edges_rig_attach(size_t place)
{
    struct edges_rig_place *self = &edges_rig.place[place];

    assert_int_equal(dg_bus_attach(edges_rig.bus, self->host, &self->control), (int)place);
}

void edges_rig_power(size_t place, bool on)
{
    (void)dg_bus_step(edges_rig.bus, edges_rig.now);
    assert_int_equal(dg_host_power(edges_rig.place[place].host, edges_rig.now, on), DG_OK);
    (void)dg_bus_changed(edges_rig.bus, place, edges_rig.now);
}

void edges_rig_bend(size_t place, enum dg_wire_fault fault, uint32_t count)
{
    struct dg_faults *faults = &edges_rig.place[place].control.faults;

    faults->slot[fault] = (uint8_t)fault;
    faults->wire |= 1u << fault;
    faults->fault[fault] = (struct dg_fault){
        .active = true, .left = count, .probability_ppm = 1000000, .until = DG_NEVER};
    (void)dg_bus_changed(edges_rig.bus, place, edges_rig.now);
}

void edges_rig_heal(size_t place)
{
    edges_rig.place[place].control.faults = (struct dg_faults){.random = 1};
    (void)dg_bus_changed(edges_rig.bus, place, edges_rig.now);
}

bool edges_rig_clock(void)
{
    edges_rig.now += EDGES_RIG_HALF;
    (void)dg_bus_edge(edges_rig.bus, edges_rig.now, false);
    edges_rig.now += EDGES_RIG_HALF;
    return dg_bus_edge(edges_rig.bus, edges_rig.now, true);
}

uint64_t edges_rig_take(unsigned n)
{
    uint64_t bits = 0;

    while (n-- > 0) {
        bits = bits << 1 | edges_rig_clock();
    }
    return bits;
}

void edges_rig_rest(void)
{
    edges_rig.now += DG_US(50);
    (void)dg_bus_step(edges_rig.bus, edges_rig.now);
}

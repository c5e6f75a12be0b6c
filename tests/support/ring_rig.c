/* SPDX-License-Identifier: MIT */
#include "ring_rig.h"

#include <stdlib.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"

/* A rig that cannot be made is a mistake in its test. */
static void must(bool held)
{
    if (!held) {
        abort();
    }
}

void ring_rig_init(struct ring_rig *self)
{
    memset(self, 0, sizeof *self);
    self->wire = (struct dg_bus_words_setup){sizeof self->wire, self->in, RING_RIG_WORDS, false};
}

struct dg_host *ring_rig_add(struct ring_rig *self, const char *model)
{
    const struct dg_device *device = dg_device_find(model);
    const struct dg_bus_side *side = dg_bus_side_of(device);

    must(self->count < RING_RIG_ENCODERS && side != NULL);
    struct ring_rig_place *place = &self->places[self->count];
    memset(place, 0xA5, sizeof *place);
    struct dg_host *host = dg_host_init_on_bus(place->bytes, sizeof place->bytes, device, side);
    must(host != NULL);
    self->encoders[self->count] = host;
    self->controls[self->count++] =
        (struct dg_encoder){.model = device, .instrument = dg_instrument_of(device->stack)};
    return host;
}

void ring_rig_open(struct ring_rig *self)
{
    const struct dg_bus_setup setup = {
        .size = sizeof setup,
        .medium = &dg_bus_words,
        .encoders = RING_RIG_ENCODERS,
        .wire = &self->wire,
        .ops = &self->ops,
        .ctx = self,
    };

    self->bus = dg_bus_init(self->of_bus.bytes, sizeof self->of_bus.bytes, &setup);
    must(self->bus != NULL);
    for (size_t i = 0; i < self->count; i++) {
        struct dg_encoder *control = &self->controls[i];
        must(dg_host_power(self->encoders[i], self->now, true) == DG_HOST_OK);
        control->device = ring_rig_device(self, i);
        control->world = ring_rig_world(self, i);
        must(dg_bus_attach(self->bus, self->encoders[i], control) == (int)i);
    }
}

enum dg_ring_result ring_rig_cycle(struct ring_rig *self)
{
    const struct dg_tap_event event = {
        .at = self->now,
        .kind = DG_TAP_WORDS,
        .words = {.out = self->out, .count = dg_ring_state(self->bus)->words},
    };

    (void)dg_bus_rx(self->bus, &event);
    return dg_ring_state(self->bus)->result;
}

uint16_t ring_rig_identify(struct ring_rig *self)
{
    const struct dg_tap_event event = {
        .at = self->now, .kind = DG_TAP_WORDS, .words = {.identify = true}};

    (void)dg_bus_rx(self->bus, &event);
    return dg_ring_state(self->bus)->reached;
}

void *ring_rig_device(const struct ring_rig *self, size_t place)
{
    return dg_host_line_of(self->encoders[place])->device;
}

struct dg_world *ring_rig_world(const struct ring_rig *self, size_t place)
{
    return dg_host_world(self->encoders[place]);
}

void ring_rig_power(struct ring_rig *self, size_t place, bool on)
{
    must(dg_host_power(self->encoders[place], self->now, on) == DG_HOST_OK);
    (void)dg_bus_changed(self->bus, place, self->now);
}

static size_t entry_of(const struct dg_fault_target *target, enum dg_wire_fault fault)
{
    struct dg_fault_entry entry;
    size_t n = 0;

    while (dg_fault_entry(target, n, &entry) &&
           (entry.kind != DG_FAULT_WIRE || entry.row->wire != fault)) {
        n++;
    }
    return n;
}

void ring_rig_bend(struct ring_rig *self, size_t place, enum dg_wire_fault fault, uint32_t count)
{
    const struct dg_fault_target target = dg_encoder_target(&self->controls[place]);
    const struct dg_fault_limits limits = {count, 1000000, DG_NEVER};

    must(dg_fault_set(&self->controls[place].faults, &target, entry_of(&target, fault), self->now,
                      &limits) == DG_OK);
    (void)dg_bus_changed(self->bus, place, self->now);
}

void ring_rig_mend(struct ring_rig *self, size_t place, enum dg_wire_fault fault)
{
    const struct dg_fault_target target = dg_encoder_target(&self->controls[place]);

    must(dg_fault_clear(&self->controls[place].faults, &target, entry_of(&target, fault)) == DG_OK);
    (void)dg_bus_changed(self->bus, place, self->now);
}

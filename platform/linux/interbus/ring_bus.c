/* SPDX-License-Identifier: MIT */
/*
 * A ring of INTERBUS encoders behind a Modbus/TCP coupler, as a bus. Somebody who listens, and
 * faults of the wire, want every cycle at its moment; else they are run when they are needed. In
 * each cycle:
 *
 *   coupler -- drive() --> faults: no cycle, a transmission error?
 *                          lx_ring_cycle()
 *                          faults: IN words torn?
 *                          tap
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus.h"
#include "endpoint.h"
#include "modbus.h"
#include "modbus_settings.h"
#include "ring_silkit.h"

#define NOTE_MAX 80u
#define HIGH_BYTE 0xFF00u
#define LOW_BYTE 0x00FFu

struct ring_bus {
    struct lx_bus bus;
    struct lx_ring_settings settings; /* of the ring as a whole */
    struct lx_ring_member *members;   /* owned, as many as stations */
    struct lx_ring ring;
    struct lx_modbus coupler;
    bool coupled; /* the coupler was opened */
    bool driven;  /* there is none: a simulation lets it cycle */
    struct lx_ring_silkit silkit;
    bool bent;                            /* wire faults may be active at a station */
    uint16_t whole_in[LX_RING_WORDS_MAX]; /* while bent: IN of the latest cycle, not torn */
    /* what the tap was told last */
    enum dg_ib_ring_result told;
    uint16_t told_reached;
};

static struct ring_bus *ring_of(struct lx_bus *bus)
{
    return (struct ring_bus *)bus;
}

static struct dg_faults *faults_at(const struct ring_bus *self, size_t place)
{
    return &self->bus.setup.stations[place]->control.faults;
}

/* --- faults --- */

static bool is_bent(const struct ring_bus *self)
{
    bool bent = false;
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        bent = bent || faults_at(self, i)->wire != 0;
    }
    return bent;
}

/* Whether a data cycle comes next that a transmission error could end. */
static bool data_is_next(const struct lx_ring *ring)
{
    return !ring->stopped && ring->ring.configured && ring->ring.dead == 0 &&
           ring->ring.corrupt_at == DG_IB_RING_WHOLE;
}

/* What faults do to the cycle to come. @return false: it takes no place */
static bool prepare(struct ring_bus *self)
{
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        struct dg_faults *faults = faults_at(self, i);
        if (faults->wire == 0) {
            continue;
        }
        if (dg_fault_wire_takes(faults, DG_WIRE_DROP)) {
            return false;
        }
        if (data_is_next(&self->ring) && dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
            self->ring.ring.corrupt_at = (uint16_t)i;
        }
    }
    return true;
}

/* The high half of the cycle before: the high word, of a K1 the high byte. */
static void tear_words(uint16_t *in, const uint16_t *before, uint8_t words)
{
    in[0] = words > 1 ? before[0] : (uint16_t)((before[0] & HIGH_BYTE) | (in[0] & LOW_BYTE));
}

static void tear(struct ring_bus *self)
{
    struct lx_ring *ring = &self->ring;
    uint16_t whole[LX_RING_WORDS_MAX];
    size_t at = 0;
    if (ring->stopped || ring->result != DG_IB_RING_OK) {
        return;
    }
    memcpy(whole, ring->in, sizeof whole);
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        const uint8_t words = dg_ib_image_words(&ring->models[i]);
        if (dg_fault_wire_takes(faults_at(self, i), DG_WIRE_TEAR)) {
            tear_words(&ring->in[at], &self->whole_in[at], words);
        }
        at += words;
    }
    memcpy(self->whole_in, whole, sizeof whole);
}

/* The first place where the ring is cut, by a fault or as set. */
static uint16_t first_break(const struct ring_bus *self)
{
    for (size_t i = 0; i < self->bus.setup.count && i < self->settings.break_at; i++) {
        if (dg_fault_wire_active(faults_at(self, i), DG_WIRE_BREAK)) {
            return (uint16_t)i;
        }
    }
    return self->settings.break_at;
}

/* --- the tap --- */

static void tell(const struct ring_bus *self, struct dg_tap_event *event, dg_ns now)
{
    event->at = now;
    lx_tap_tell(&self->bus.tap, event);
}

/* ID cycles, breaks and errors, once each: a broken ring is identified again in every cycle. */
static void tell_state(struct ring_bus *self, dg_ns now)
{
    const struct lx_ring *ring = &self->ring;
    const unsigned count = ring->ring.count;
    char text[NOTE_MAX] = "";
    struct dg_tap_event event = {.kind = DG_TAP_NOTE, .note = text};
    if (ring->result == self->told && ring->reached == self->told_reached) {
        return;
    }
    self->told = ring->result;
    self->told_reached = ring->reached;
    event.severity = DG_SEVERITY_ERROR;
    if (ring->result == DG_IB_RING_CRC) {
        (void)snprintf(text, sizeof text, "transmission error");
    } else if (ring->reached < count) {
        (void)snprintf(text, sizeof text,
                       "ID cycle: %u of %u devices, interrupted before device %u", ring->reached,
                       count, ring->reached);
    } else if (ring->result == DG_IB_RING_IDENTIFY) {
        event.severity = DG_SEVERITY_NOTICE;
        (void)snprintf(text, sizeof text, "ID cycle: %u of %u devices", ring->reached, count);
    } else {
        return;
    }
    tell(self, &event, now);
}

static void tell_words(const struct ring_bus *self, dg_ns now, bool took_place)
{
    const struct lx_ring *ring = &self->ring;
    struct dg_tap_event event = {.kind = DG_TAP_WORDS};
    uint8_t widths[DG_IB_RING_MAX];
    for (size_t i = 0; i < self->bus.setup.count; i++) {
        widths[i] = dg_ib_image_words(&ring->models[i]);
    }
    event.words.widths = widths;
    event.words.in = ring->in;
    event.words.out = ring->out;
    event.words.count = ring->ring.words;
    event.words.valid = took_place && !ring->stopped && ring->result == DG_IB_RING_OK;
    tell(self, &event, now);
}

/* A fault may have happened as often as it was to, which nobody hears of. */
static void straighten(struct ring_bus *self)
{
    if (!self->bent || is_bent(self)) {
        return;
    }
    self->bent = false;
    if (self->coupled && !lx_tap_on(&self->bus.tap)) {
        lx_modbus_unwatch(&self->coupler);
    }
}

static bool drive_once(void *ctx, dg_ns now)
{
    struct ring_bus *self = ctx;
    const bool takes_place = !self->bent || prepare(self);
    self->bus.late = self->coupled ? self->coupler.map.missed : 0;
    if (takes_place) {
        lx_ring_cycle(&self->ring, now);
        if (self->bent) {
            tear(self);
        }
    }
    if (lx_tap_on(&self->bus.tap)) {
        tell_state(self, now);
        tell_words(self, now, takes_place);
    }
    straighten(self);
    return takes_place;
}

static void drive(void *ctx, dg_ns now)
{
    (void)drive_once(ctx, now);
}

/* --- the operations --- */

/* Whoever watches wants each cycle. In a simulation there is nothing but that. */
static void stir(struct ring_bus *self, dg_ns now)
{
    if (self->coupled) {
        lx_modbus_stir(&self->coupler, self->bent || lx_tap_on(&self->bus.tap), now);
    }
}

/* IN words that were held back come with the next cycle. */
static void on_settled(void *ctx, dg_ns now)
{
    stir(ctx, now);
}

static int open_topics(struct ring_bus *self, struct lx_error *error)
{
    self->silkit.ring = &self->ring;
    self->silkit.drive = drive_once;
    self->silkit.ctx = self;
    return lx_ring_silkit_open(&self->silkit, &self->bus.setup, error);
}

static int open_coupler(struct ring_bus *self, struct lx_error *error)
{
    const struct lx_plan_wire *wire = self->bus.setup.wire;
    const struct lx_modbus_setup coupler = {
        .event = self->bus.setup.event,
        .where = wire->where,
        .ring = &self->ring,
        .cycle = DG_US(self->settings.cycle_us),
        .tear = self->settings.tear,
        .drive = drive,
        .ctx = self,
    };
    self->coupled = true;
    if (lx_modbus_open(&self->coupler, &coupler, error) != 0) {
        return -1;
    }
    if (!lx_endpoint_is_loopback(self->coupler.listener)) {
        lx_note(self->bus.setup.say,
                "modbus:%s: beyond loopback; whoever reaches it writes to this ring, as with the "
                "real coupler",
                self->coupler.address);
    }
    return 0;
}

/* A file that several may share stands where the first of them names it. */
static int place_nvm(const struct lx_bus_setup *setup, const char *refused, struct lx_error *error)
{
    for (size_t i = 0; refused != NULL && i < setup->count; i++) {
        const struct lx_plan_encoder *plan = setup->stations[i]->plan;
        if (plan->nvm != NULL && strcmp(plan->nvm, refused) == 0) {
            return lx_stands(error, setup->plan->file, plan->nvm_line);
        }
    }
    return -1;
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct ring_bus *self = ring_of(bus);
    const struct lx_bus_setup *setup = &bus->setup;
    const struct lx_ring_setup ring = {
        .members = self->members,
        .count = setup->count,
        .say = setup->say,
        .writer = setup->writer,
        .settled = on_settled,
        .ctx = self,
    };
    if (lx_ring_open(&self->ring, &ring, now, error) != 0) {
        return place_nvm(setup, self->ring.refused, error);
    }
    if ((self->driven ? open_topics : open_coupler)(self, error) != 0) {
        return -1;
    }
    self->ring.ring.broken_at = self->settings.break_at;
    stir(self, now);
    for (size_t i = 0; i < setup->count; i++) {
        struct dg_encoder *encoder = &setup->stations[i]->control;
        encoder->device = &self->ring.devices[i];
        if (self->ring.models[i].profile == DG_IB_K3) {
            encoder->nvm = lx_ring_nvm(&self->ring, i);
            setup->stations[i]->queue = lx_ring_queue(&self->ring, i);
        }
    }
    return 0;
}

static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    const struct ring_bus *self = (const struct ring_bus *)bus;
    (void)snprintf(to, size, "%s/%zu", self->driven ? self->silkit.address : self->coupler.address,
                   station->place);
}

static void look(struct lx_bus *bus, dg_ns now)
{
    if (ring_of(bus)->coupled) {
        lx_modbus_look(&ring_of(bus)->coupler, now);
    }
}

/* Power and worlds are looked at in the next cycle. */
static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct ring_bus *self = ring_of(bus);
    const bool before = self->bent;
    (void)station;
    look(bus, now); /* what is over was not bent by what comes now */
    self->bent = is_bent(self);
    if (self->bent && !before) {
        memcpy(self->whole_in, self->ring.in, sizeof self->whole_in);
    }
    self->ring.ring.broken_at = first_break(self);
    stir(self, now);
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct ring_bus *self = (const struct ring_bus *)bus;
    const struct dg_ib_ring_counters *ring = &self->ring.ring.counters;
    const struct lx_count rows[] = {
        {"wire_up", self->driven || self->coupler.listener >= 0},
        {"wire_late", bus->late + bus->stalls},
        {"wire_cycles", ring->cycles},
        {"wire_ids", ring->ids},
        {"wire_crc_errors", ring->crc_errors},
        {"wire_interrupted", ring->interrupted},
        {"wire_requests", self->coupler.counters.requests},
    };
    (void)station;
    lx_bus_count(to, rows, DG_COUNT(rows));
}

static void close_bus(struct lx_bus *bus)
{
    struct ring_bus *self = ring_of(bus);
    if (self->coupled) {
        lx_modbus_close(&self->coupler);
    }
    lx_ring_close(&self->ring);
    free(self->members);
    free(self);
}

static const struct lx_bus_ops bus_ops = {
    LX_BUS_OPERATIONS,
    .look = look,
    .turns = look,
};

/* --- from the plan --- */

static int understand_ring(struct ring_bus *self, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    const char *where = setup->wire->where;
    if (!lx_modbus_address_fits(where)) {
        return lx_refuse(error, LX_MODBUS_RIGHT, "%s", "");
    }
    return lx_wire_settings(&lx_ring_keys, setup->plan, setup->wire, &self->settings, error);
}

/* A serial number that was asked for is this one's; the models' own count up. */
static int understand(struct ring_bus *self, size_t place, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    struct lx_station *station = setup->stations[place];
    const struct lx_plan_encoder *encoder = station->plan;
    struct lx_ring_member *member = &self->members[place];
    struct dg_ib_model settings;
    if (lx_stack_settings(setup->plan, setup->wire, encoder, &settings, &station->world, error) !=
        0) {
        return -1;
    }
    const uint32_t index = encoder->serial == NULL ? (uint32_t)place : 0u;
    member->model = lx_ib_settings_model(&settings, index);
    member->world = &station->world;
    member->nvm = encoder->nvm;
    station->control.serial = member->model.serial;
    return 0;
}

static struct lx_bus *make(const struct lx_bus_setup *setup, bool driven, struct lx_error *error)
{
    struct ring_bus *self = calloc(1, sizeof *self);
    struct lx_ring_member *members = calloc(setup->count, sizeof *members);
    if (self == NULL || members == NULL) {
        (void)lx_fail(error, "no memory for %zu encoders", setup->count);
        free(members);
        free(self);
        return NULL;
    }
    self->bus = (struct lx_bus){.ops = &bus_ops, .setup = *setup};
    self->members = members;
    self->driven = driven;
    self->settings = lx_ring_defaults;
    int result = driven ? 0 : understand_ring(self, error);
    for (size_t i = 0; result == 0 && i < setup->count; i++) {
        result = understand(self, i, error);
    }
    if (result != 0) {
        close_bus(&self->bus);
        return NULL;
    }
    return &self->bus;
}

struct lx_bus *lx_ring_bus_make(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return make(setup, false, error);
}

struct lx_bus *lx_ring_bus_make_silkit(const struct lx_bus_setup *setup, struct lx_error *error)
{
    return make(setup, true, error);
}

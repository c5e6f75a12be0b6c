/* SPDX-License-Identifier: MIT */
/*
 * TPDOs and SYNC (CiA 301).
 *
 *   type      sampled   sent
 *   0         SYNC      at the SYNC after an event, and after entering Operational
 *   1..240    SYNC      at every nth SYNC
 *   252       SYNC      on request (RTR)
 *   253       RTR       on request
 *   254, 255  when sent entering Operational, event timer, event; not within the inhibit time
 *
 * A remote frame is answered by every type. It neither waits for the inhibit time nor restarts it,
 * nor does it take the place of an event that waits; like any transmission it restarts the event
 * timer.
 */
#include <string.h>

#include "co_od.h"
#include "co_pdo.h"

static bool is_synchronous(uint8_t type)
{
    return type <= CO_PDO_CYCLIC_MAX || type == CO_PDO_REQUEST_SYNC;
}

/* ------------------------------------------------------------ sending */

/* Most of what is mapped is a value, such as the position: 6004h. */
static uint32_t read_mapped(struct dg_co_node *self, uint16_t number, uint8_t *size)
{
    const struct dg_co_dictionary *dictionary = co_numbered_in(self->setup.device, number);
    const struct dg_co_row *row = co_row_in(dictionary, number);

    *size = dg_co_sizes[row->flags >> 12];
    if (row->hook == 0 && (row->flags & DG_CO_SLOT) != 0) {
        return self->value[row->slot];
    }
    const struct dg_co_object object = co_object(dictionary, row);
    uint32_t value;
    (void)co_read(self, &object, &value);
    return value;
}

/* Values little-endian, one behind the other; a store's surplus is zeros, and overwritten by the
 * next. */
static void build_frame(struct dg_co_node *self, const struct dg_co_tpdo *tpdo, uint8_t *data)
{
    for (uint8_t i = 0; i < tpdo->mapped_count; i++) {
        uint8_t size;
        const uint32_t value = read_mapped(self, tpdo->mapped[i], &size);
        dg_store_le32(data, value & 0xFFFFFFFFu >> (32u - 8u * size));
        data += size;
    }
}

static void send_last(struct dg_co_node *self, const struct dg_co_tpdo *tpdo)
{
    struct dg_can_frame frame = {.id = tpdo->can_id, .dlc = tpdo->length};

    memcpy(frame.data, tpdo->last, sizeof frame.data);
    dg_co_send_frame(self, &frame);
}

static void transmit_tpdo(struct dg_co_node *self, struct dg_co_tpdo *tpdo)
{
    build_frame(self, tpdo, tpdo->last);
    tpdo->sampled = tpdo->type != CO_PDO_REQUEST_SYNC; /* whose sample comes from a SYNC only */
    send_last(self, tpdo);
}

/* One sample serves all TPDOs of a moment. It can raise an EMCY, whose reaction (1029h) may end
 * Operational: false. */
static bool sample_once(struct dg_co_node *self, bool *sampled)
{
    if (!*sampled) {
        *sampled = true;
        if (self->setup.device->sample != NULL) {
            self->setup.device->sample(self);
        }
    }
    return self->state == DG_CO_OPERATIONAL;
}

/* The event timer runs from `from`; when a whole period has been missed, from now. It only counts
 * for a TPDO that serve_tpdos() looks at; whatever makes it look at one comes by here. */
static void arm_event_timer(struct dg_co_node *self, uint8_t n, dg_ns from)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];
    uint32_t period_ms = co_pdo_parameter(self, n, CO_PDO_EVENT_MS);
    dg_ns next = dg_co_after_ms(from, period_ms);

    self->others = 0;
    self->pdo_at = 0;
    tpdo->event_at = next > self->now ? next : dg_co_after_ms(self->now, period_ms);
}

void dg_co_pdo_rearm(struct dg_co_node *self, uint8_t tpdo)
{
    arm_event_timer(self, tpdo, self->now);
}

/* Forget events, samples and the phase of SYNC. */
void dg_co_pdo_restart(struct dg_co_node *self, uint8_t n)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];

    tpdo->pending = false;
    tpdo->sampled = false;
    tpdo->sync_count = 0;
    self->sync_mask = (uint8_t)(self->sync_mask & ~(1u << n));
    if (tpdo->valid && is_synchronous(tpdo->type)) {
        self->sync_mask |= (uint8_t)(1u << n);
    }
    arm_event_timer(self, n, self->now);
}

/* ------------------------------------------------------------ events */

/*
 * An event within the inhibit time waits for its end, and carries the value of that moment:
 *
 *   events  e   e e                e
 *   sent    e     |      e         e
 *           |<-inhibit-->|<-inhibit-->|
 */
static dg_ns serve_tpdo(struct dg_co_node *self, uint8_t n, bool *sampled)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];
    dg_ns from = self->now;

    if (tpdo->event_at <= self->now) {
        from = tpdo->event_at; /* keeps the period exact when the host comes late */
        tpdo->event_at = DG_NEVER;
        tpdo->pending = true;
    }
    if (!tpdo->pending) {
        return tpdo->event_at;
    }
    if (tpdo->inhibit_until > self->now) {
        return dg_earliest(tpdo->event_at, tpdo->inhibit_until);
    }
    if (!sample_once(self, sampled)) {
        return DG_NEVER;
    }
    tpdo->pending = false;
    transmit_tpdo(self, tpdo);
    tpdo->inhibit_until =
        dg_co_after(self->now, DG_US(100u * co_pdo_parameter(self, n, CO_PDO_INHIBIT_100US)));
    arm_event_timer(self, n, from);
    return tpdo->event_at;
}

static void serve_tpdos(struct dg_co_node *self, bool sampled)
{
    dg_ns next = DG_NEVER;

    for (uint8_t n = 0; n < DG_CO_TPDOS && self->state == DG_CO_OPERATIONAL; n++) {
        if (self->tpdo[n].valid && self->tpdo[n].type >= CO_PDO_EVENT) {
            next = dg_earliest(next, serve_tpdo(self, n, &sampled));
        }
    }
    self->pdo_at = next;
}

dg_ns dg_co_pdo_step(struct dg_co_node *self)
{
    if (self->pdo_at <= self->now) {
        serve_tpdos(self, false);
    }
    return self->pdo_at;
}

/* Only objects with DG_CO_EVENT count. */
static bool has_tpdo_changed(const struct dg_co_tpdo *tpdo, const uint8_t *data)
{
    bool changed = !tpdo->sampled;

    for (uint8_t i = 0; i < tpdo->length; i++) {
        changed = changed || ((tpdo->event_bytes >> i & 1u) != 0 && data[i] != tpdo->last[i]);
    }
    return changed;
}

void dg_co_pdo_event(struct dg_co_node *self)
{
    bool sampled = false;

    if (self->state != DG_CO_OPERATIONAL || !sample_once(self, &sampled)) {
        return;
    }
    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        struct dg_co_tpdo *tpdo = &self->tpdo[n];
        uint8_t data[sizeof tpdo->last];
        if (tpdo->valid && tpdo->event_bytes != 0 && co_pdo_takes_events(tpdo->type) &&
            !tpdo->pending) {
            build_frame(self, tpdo, data);
            tpdo->pending = has_tpdo_changed(tpdo, data);
        }
    }
    serve_tpdos(self, sampled);
}

void dg_co_pdo_state(struct dg_co_node *self, bool operational)
{
    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        dg_co_pdo_restart(self, n);
        self->tpdo[n].pending = operational && co_pdo_takes_events(self->tpdo[n].type);
    }
    serve_tpdos(self, false);
}

/* ------------------------------------------------------------ SYNC and RTR */

static bool is_tpdo_due(struct dg_co_tpdo *tpdo)
{
    if (tpdo->type == CO_PDO_ACYCLIC) {
        return tpdo->pending;
    }
    if (tpdo->type == CO_PDO_REQUEST_SYNC) {
        return true;
    }
    tpdo->sync_count++;
    if (tpdo->sync_count < tpdo->type) {
        return false;
    }
    tpdo->sync_count = 0;
    return true;
}

/* `late`: the window 1007h is over. The phase goes on, an event waits for the next SYNC. */
static void synchronise_tpdo(struct dg_co_node *self, struct dg_co_tpdo *tpdo, bool late)
{
    if (!is_tpdo_due(tpdo)) {
        return;
    }
    if (late) {
        self->counters.late_sync++;
    } else if (tpdo->type == CO_PDO_REQUEST_SYNC) {
        build_frame(self, tpdo, tpdo->last);
        tpdo->sampled = true;
    } else {
        tpdo->pending = false;
        transmit_tpdo(self, tpdo);
    }
}

/* Without 1019h a SYNC has no counter, and nothing else (8240h). */
static bool check_length(struct dg_co_node *self, const struct dg_can_frame *sync)
{
    static const uint8_t no_details[5];

    if (sync->dlc != 0) {
        self->counters.malformed++;
        dg_co_raise(self, DG_CO_CAUSE_SYNC_LENGTH, no_details);
        return false;
    }
    if (self->active_causes != 0) {
        dg_co_clear(self, DG_CO_CAUSE_SYNC_LENGTH);
    }
    return true;
}

/* SYNC is answered in the call, so only one that the host delivers late can miss its window. */
static bool is_late(const struct dg_co_node *self)
{
    dg_ns window = DG_US(self->value[CO_SYNC_WINDOW_US]);

    return window != 0 && dg_elapsed(self->now, self->rx_at) > window;
}

void dg_co_sync_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    bool sampled = false;

    if (!check_length(self, frame) || self->state != DG_CO_OPERATIONAL ||
        !sample_once(self, &sampled)) {
        return;
    }
    bool late = is_late(self);
    struct dg_co_tpdo *tpdo = self->tpdo;
    for (unsigned mask = self->sync_mask; mask != 0; mask >>= 1) {
        if ((mask & 1u) != 0) {
            synchronise_tpdo(self, tpdo, late);
        }
        tpdo++;
    }
}

static void answer_remote(struct dg_co_node *self, uint8_t n)
{
    struct dg_co_tpdo *tpdo = &self->tpdo[n];
    bool sampled = false;

    if (tpdo->type == CO_PDO_REQUEST_SYNC && tpdo->sampled) {
        send_last(self, tpdo);
    } else if (sample_once(self, &sampled)) {
        transmit_tpdo(self, tpdo);
        arm_event_timer(self, n, self->now);
    }
}

void dg_co_pdo_rtr(struct dg_co_node *self, uint16_t id)
{
    for (uint8_t n = 0; n < DG_CO_TPDOS; n++) {
        const struct dg_co_tpdo *tpdo = &self->tpdo[n];
        if (tpdo->valid && tpdo->can_id == id && tpdo->rtr_allowed) {
            answer_remote(self, n);
        }
    }
}

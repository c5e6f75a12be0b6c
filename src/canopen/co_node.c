/* SPDX-License-Identifier: MIT */
/*
 * A node: power, reset, frames to services, deadlines.
 */
#include <string.h>

#include "co_emcy.h"
#include "co_lss.h"
#include "co_nmt.h"
#include "co_od.h"
#include "co_pdo.h"
#include "co_sdo.h"
#include "co_storage.h"

/* SYNC, EMCY, TIME, TPDOs: whose CAN-IDs can be the same. */
#define SERVICES_MAX (3u + DG_CO_TPDOS)

/* The NMT states that most services work in (CiA 301). */
static bool is_on(const struct dg_co_node *self)
{
    return self->state == DG_CO_OPERATIONAL || self->state == DG_CO_PRE_OPERATIONAL;
}

/* Those of LSS (CiA 305). */
static bool is_configurable(const struct dg_co_node *self)
{
    return self->state == DG_CO_PRE_OPERATIONAL || self->state == DG_CO_STOPPED ||
           self->id == DG_CO_UNCONFIGURED;
}

void dg_co_send_frame(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    if (!co_lss_silent(self)) {
        self->counters.tx++;
        self->setup.ops->send(self->setup.ctx, frame);
    }
}

void dg_co_send(struct dg_co_node *self, uint16_t id, const uint8_t *data, uint8_t dlc)
{
    struct dg_can_frame frame = {.id = id, .dlc = dlc};

    memcpy(frame.data, data, dlc);
    dg_co_send_frame(self, &frame);
}

dg_ns dg_co_after(dg_ns from, dg_ns span)
{
    return dg_after(from, span);
}

dg_ns dg_co_after_ms(dg_ns from, uint32_t ms)
{
    return ms != 0 ? dg_co_after(from, DG_MS(ms)) : DG_NEVER;
}

uint16_t dg_co_kbaud(const struct dg_co_device *device, uint8_t number)
{
    return number < device->kbaud_count ? device->kbaud[number] : 0;
}

void dg_co_use_bit_rate(struct dg_co_node *self)
{
    self->bit_rate = self->lss.bit_rate;
    if (self->setup.ops->bit_rate != NULL) {
        self->setup.ops->bit_rate(self->setup.ctx, dg_co_kbaud(self->setup.device, self->bit_rate));
    }
}

/* Time does not run backwards, and DG_NEVER is no moment. */
static void advance_time(struct dg_co_node *self, dg_ns now)
{
    if (now > self->now && now != DG_NEVER) {
        self->now = now;
    }
}

int dg_co_init(struct dg_co_node *self, const struct dg_co_setup *setup)
{
    if (setup->device == NULL || setup->world == NULL || setup->nvm.ops == NULL ||
        setup->ops == NULL || setup->ops->send == NULL) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_co_node){.setup = *setup, .state = DG_CO_OFF};
    return DG_OK;
}

/* Initialisation (CiA 301): application, then communication, then boot-up. */
static void initialise_node(struct dg_co_node *self, bool application)
{
    const struct dg_co_device *device = self->setup.device;
    bool operational = false;

    self->others = 0;
    self->state = DG_CO_BOOT;
    if (application) {
        self->id = self->lss.node_id;
        if (self->bit_rate != self->lss.bit_rate) {
            dg_co_use_bit_rate(self);
        }
    }
    self->clock_us = 0u - (uint32_t)dg_divide_ns(self->now, 1000);
    bool loaded = dg_co_load(self, 0x1000, application ? 0xFFFF : 0x1FFF);
    self->filter_version++;
    dg_co_emcy_start(self);
    dg_co_sdo_start(self);
    dg_co_nmt_start(self);
    dg_co_pdo_start(self);
    dg_co_lss_start(self);
    if (device->reset != NULL) {
        operational = device->reset(self, application);
    }
    if (self->id == DG_CO_UNCONFIGURED) {
        return; /* only LSS can give it a node-ID (CiA 305) */
    }
    static const uint8_t boot_up[1] = {DG_CO_BOOT};
    dg_co_send(self, (uint16_t)(CO_ID_GUARD + self->id), boot_up, sizeof boot_up);
    dg_co_enter(self, operational ? DG_CO_OPERATIONAL : DG_CO_PRE_OPERATIONAL);
    dg_co_report_memory(self, loaded); /* an EMCY comes after boot-up */
}

/* The wire is as bad as it was: a controller that was error passive finds that again. */
void dg_co_reset(struct dg_co_node *self, bool application)
{
    static const uint8_t none[5];
    const bool passive = (self->active_causes >> DG_CO_CAUSE_PASSIVE & 1u) != 0;

    dg_co_remount(self);
    initialise_node(self, application);
    if (passive) {
        dg_co_raise(self, DG_CO_CAUSE_PASSIVE, none);
    }
}

int dg_co_power_on(struct dg_co_node *self, dg_ns now)
{
    dg_co_power_off(self);
    self->now = now;
    int result = dg_co_mount_node(self);
    if (result == DG_ERR_BLANK || result == DG_ERR_FOREIGN) {
        return result;
    }
    self->bus_off = false;
    self->lss.silent_until = 0;
    self->bus_found = false;
    dg_co_use_bit_rate(self);
    initialise_node(self, true);
    return DG_OK;
}

void dg_co_power_off(struct dg_co_node *self)
{
    self->state = DG_CO_OFF;
    self->filter_version++;
}

/* TIME (CiA 301): milliseconds after midnight, 28 bits, and days since 1984-01-01. */
static void time_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    if (frame->dlc != 6) {
        self->counters.malformed++;
        return;
    }
    self->time_ms = dg_load_le32(frame->data) & 0x0FFFFFFFu;
    self->time_days = dg_load_le16(&frame->data[4]);
}

static bool is_time(const struct dg_co_node *self, uint32_t id)
{
    return self->value[CO_TIME_COB_ID] == (CO_COB_INVALID | id);
}

static void remote_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    if (self->id == DG_CO_UNCONFIGURED) {
        return;
    }
    if (frame->id == CO_ID_GUARD + self->id) {
        dg_co_guard_rx(self);
    } else if (self->state == DG_CO_OPERATIONAL) {
        dg_co_pdo_rtr(self, frame->id);
    }
}

static void sdo_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    if (!is_on(self)) {
        return;
    }
    if (frame->dlc != 8) {
        self->counters.malformed++;
        return;
    }
    const enum dg_co_abort abort = dg_co_sdo_rx(self, frame->data);
    if (abort != DG_CO_OK) {
        dg_co_sdo_refuse(self, frame->data, abort);
    }
}

/* What is less frequent. */
static void other_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    const uint32_t id = frame->id;

    if (id == CO_ID_LSS_RX) {
        if (is_configurable(self)) {
            self->others = 0;
            dg_co_lss_rx(self, frame);
        }
    } else if (id == CO_ID_NMT) {
        if (self->id != DG_CO_UNCONFIGURED) {
            dg_co_nmt_rx(self, frame);
        }
    } else if ((id & 0x780u) == CO_ID_GUARD) {
        if (self->id != DG_CO_UNCONFIGURED) {
            dg_co_heartbeat_rx(self, frame);
        }
    } else if (is_time(self, id) && is_on(self)) {
        time_rx(self, frame);
    }
}

/* Only LSS works without a node-ID, with which no node is on. */
static void service_rx(struct dg_co_node *self, const struct dg_can_frame *frame)
{
    if (frame->rtr) {
        remote_rx(self, frame);
    } else if (frame->id == self->value[CO_SYNC_COB_ID]) {
        if (is_on(self)) {
            dg_co_sync_rx(self, frame);
        }
    } else if (frame->id == CO_ID_SDO_RX + self->id) {
        sdo_rx(self, frame);
    } else {
        other_rx(self, frame);
    }
}

/* Every service does what is due at self->now and says when it wants to be called again. The SDO
 * server's answer stands by itself, for service_rx(). */
static dg_ns step_services(struct dg_co_node *self)
{
    /* The device first, emergencies last: what the former raises or changes leaves in this round.
     */
    dg_ns next = self->setup.device->step != NULL ? self->setup.device->step(self) : DG_NEVER;

    next = dg_earliest(next, dg_co_nmt_step(self));
    next = dg_earliest(next, dg_co_pdo_step(self));
    dg_ns sdo = dg_co_sdo_step(self);
    next = dg_earliest(next, dg_co_lss_step(self));
    self->others = dg_earliest(next, dg_co_emcy_step(self));
    return dg_earliest(self->others, sdo);
}

/* One service's work can make another's due at the same moment. */
static dg_ns settle_services(struct dg_co_node *self)
{
    do {
        self->deadline = step_services(self);
    } while (self->deadline <= self->now);
    return self->deadline;
}

dg_ns dg_co_step(struct dg_co_node *self, dg_ns now)
{
    if (self->state == DG_CO_OFF) {
        return DG_NEVER;
    }
    advance_time(self, now);
    return settle_services(self);
}

dg_ns dg_co_rx(struct dg_co_node *self, dg_ns now, const struct dg_can_frame *frame)
{
    if (self->state == DG_CO_OFF) {
        return DG_NEVER;
    }
    self->rx_at = now;
    self->bus_found = true;
    advance_time(self, now);
    if (self->deadline <= self->now) {
        (void)settle_services(self);
    }
    if (co_lss_silent(self)) {
        return self->deadline;
    }
    self->counters.rx++;
    service_rx(self, frame);
    /* Most frames move no deadline but the SDO server's. */
    self->deadline = dg_earliest(self->others, self->sdo.deadline);
    return self->deadline <= self->now ? settle_services(self) : self->deadline;
}

dg_ns dg_co_bus(struct dg_co_node *self, dg_ns now, enum dg_co_bus_event event)
{
    static const uint8_t none[5] = {0};

    if (event == DG_CO_BUS_ABSENT || event == DG_CO_BUS_PRESENT) {
        self->bus_absent = event == DG_CO_BUS_ABSENT;
    }
    if (self->state == DG_CO_OFF) {
        return DG_NEVER;
    }
    advance_time(self, now);
    switch (event) {
    case DG_CO_BUS_OVERRUN:
        dg_co_raise(self, DG_CO_CAUSE_OVERRUN, none);
        dg_co_clear(self, DG_CO_CAUSE_OVERRUN);
        break;
    case DG_CO_BUS_PASSIVE:
        dg_co_raise(self, DG_CO_CAUSE_PASSIVE, none);
        break;
    case DG_CO_BUS_OFF:
        self->bus_off = true;
        dg_co_react(self, DG_CO_CLASS_COMMUNICATION);
        break;
    case DG_CO_BUS_ACTIVE:
        if (self->bus_off) { /* nobody could have heard it before */
            self->bus_off = false;
            dg_co_raise(self, DG_CO_CAUSE_BUS_OFF, none);
        }
        dg_co_clear(self, DG_CO_CAUSE_PASSIVE);
        dg_co_clear(self, DG_CO_CAUSE_BUS_OFF);
        break;
    case DG_CO_BUS_PRESENT:
        self->bus_found = true;
        break;
    case DG_CO_BUS_ABSENT:
        break;
    }
    return settle_services(self);
}

enum dg_co_bus_event dg_co_controller_state(const struct dg_co_node *self)
{
    if (self->bus_off) {
        return DG_CO_BUS_OFF;
    }
    return (self->active_causes >> DG_CO_CAUSE_PASSIVE & 1u) != 0 ? DG_CO_BUS_PASSIVE
                                                                  : DG_CO_BUS_ACTIVE;
}

dg_ns dg_co_controller(struct dg_co_node *self, dg_ns now, enum dg_co_bus_event state)
{
    if (self->state == DG_CO_OFF) {
        return DG_NEVER;
    }
    if (self->bus_off && state == DG_CO_BUS_PASSIVE) {
        (void)dg_co_bus(self, now, DG_CO_BUS_ACTIVE);
    }
    return state != dg_co_controller_state(self) ? dg_co_bus(self, now, state) : self->deadline;
}

static bool has_id(const uint16_t *ids, uint8_t n, uint16_t id)
{
    while (n > 0 && ids[n - 1u] != id) {
        n--;
    }
    return n > 0;
}

/* Each once, as services may share one (C43). */
static uint8_t add_filter(uint16_t *ids, uint8_t n, uint32_t id)
{
    const uint16_t can_id = (uint16_t)(id & CO_COB_CAN_ID);

    ids[n] = can_id;
    return (uint8_t)(has_id(ids, n, can_id) ? n : n + 1u);
}

uint8_t dg_co_filters(const struct dg_co_node *self, uint16_t ids[DG_CO_FILTERS_MAX])
{
    uint8_t n = 0;

    if (self->state == DG_CO_OFF) {
        return 0;
    }
    n = add_filter(ids, n, CO_ID_LSS_RX);
    if (self->id == DG_CO_UNCONFIGURED) {
        return n;
    }
    n = add_filter(ids, n, CO_ID_NMT);
    n = add_filter(ids, n, self->value[CO_SYNC_COB_ID]);
    n = add_filter(ids, n, CO_ID_SDO_RX + self->id);
    n = add_filter(ids, n, CO_ID_GUARD + self->id);
    if ((self->value[CO_TIME_COB_ID] & CO_COB_INVALID) != 0) {
        n = add_filter(ids, n, self->value[CO_TIME_COB_ID]);
    }
    for (uint8_t i = 0; i < DG_CO_CONSUMERS; i++) {
        uint32_t node = self->value[CO_CONSUMER_1 + i] >> 16 & 0x7Fu;
        if (node != 0) {
            n = add_filter(ids, n, CO_ID_GUARD + node);
        }
    }
    for (uint8_t i = 0; i < DG_CO_TPDOS; i++) {
        if (self->tpdo[i].valid && self->tpdo[i].rtr_allowed) {
            n = add_filter(ids, n, self->tpdo[i].can_id);
        }
    }
    return n;
}

/* The others have CAN-IDs that nothing can be moved to. */
static uint8_t list_services(const struct dg_co_node *self, uint16_t ids[SERVICES_MAX])
{
    uint8_t n = 0;

    ids[n++] = (uint16_t)self->value[CO_SYNC_COB_ID];
    ids[n++] = (uint16_t)(CO_ID_EMCY + self->id);
    if ((self->value[CO_TIME_COB_ID] & CO_COB_INVALID) != 0) {
        ids[n++] = (uint16_t)(self->value[CO_TIME_COB_ID] & CO_COB_CAN_ID);
    }
    for (uint8_t i = 0; i < DG_CO_TPDOS; i++) {
        if (self->tpdo[i].valid) {
            ids[n++] = self->tpdo[i].can_id;
        }
    }
    return n;
}

uint8_t dg_co_shared_ids(const struct dg_co_node *self, uint16_t ids[DG_CO_SHARED_MAX])
{
    uint16_t used[SERVICES_MAX];
    uint8_t shared = 0;
    const bool has_services = self->state != DG_CO_OFF && self->id != DG_CO_UNCONFIGURED;
    const uint8_t n = has_services ? list_services(self, used) : 0;

    for (uint8_t i = 1; i < n; i++) {
        if (has_id(used, i, used[i]) && !has_id(ids, shared, used[i])) {
            ids[shared++] = used[i];
        }
    }
    return shared;
}

/* SPDX-License-Identifier: MIT */
/*
 * Emergencies: causes, error register 1001h, history 1003h, EMCY frames with inhibit time, and the
 * reaction of 1029h (CiA 301; C11, C14).
 */
#include <string.h>

#include "co_emcy.h"
#include "co_nmt.h"

#define GENERIC 0x01u
#define COMMUNICATION 0x11u

/* The stack's causes. */
static const struct dg_co_cause causes[DG_CO_CAUSES] = {
    [DG_CO_CAUSE_OVERRUN] = {0x8110, COMMUNICATION, DG_CO_CLASS_NONE},
    [DG_CO_CAUSE_PASSIVE] = {0x8120, COMMUNICATION, DG_CO_CLASS_NONE},
    [DG_CO_CAUSE_BUS_OFF] = {0x8140, COMMUNICATION, DG_CO_CLASS_NONE},
    [DG_CO_CAUSE_LIFE] = {0x8130, COMMUNICATION, DG_CO_CLASS_COMMUNICATION},
    [DG_CO_CAUSE_HEARTBEAT] = {0x8130, COMMUNICATION, DG_CO_CLASS_COMMUNICATION},
    [DG_CO_CAUSE_HEARTBEAT_2] = {0x8130, COMMUNICATION, DG_CO_CLASS_COMMUNICATION},
    [DG_CO_CAUSE_SYNC_LENGTH] = {0x8240, COMMUNICATION, DG_CO_CLASS_NONE},
    [DG_CO_CAUSE_MEMORY] = {0x5100, GENERIC, DG_CO_CLASS_MANUFACTURER},
};

static const struct dg_co_cause *cause_at(const struct dg_co_node *self, uint8_t cause)
{
    return cause < DG_CO_CAUSES ? &causes[cause]
                                : &self->setup.device->causes[cause - DG_CO_CAUSES];
}

static uint8_t error_register(const struct dg_co_node *self)
{
    uint8_t bits = 0;

    for (uint8_t i = 0; self->active_causes >> i != 0; i++) {
        if ((self->active_causes >> i & 1u) != 0) {
            bits |= cause_at(self, i)->reg;
        }
    }
    return bits;
}

void dg_co_react(struct dg_co_node *self, enum dg_co_error_class class_of)
{
    if (class_of == DG_CO_CLASS_NONE || self->state == DG_CO_BOOT) {
        return; /* Initialisation is left after boot-up, without a node-ID never */
    }
    uint32_t behaviour = self->value[CO_BEHAVIOUR_1 + (unsigned)class_of - 1u];
    if (behaviour == 0 && self->state == DG_CO_OPERATIONAL) {
        dg_co_enter(self, DG_CO_PRE_OPERATIONAL);
    } else if (behaviour == 2) {
        dg_co_enter(self, DG_CO_STOPPED);
    }
}

/* Both lists are rings. */
static uint8_t in_ring(unsigned place)
{
    return (uint8_t)(place % DG_CO_HISTORY);
}

/* Waiting EMCYs are sent oldest first; when too many wait, the newest are lost from the wire, but
 * not from 1003h. */
static void queue_emergency(struct dg_co_node *self, uint16_t code, const uint8_t *manufacturer)
{
    if (self->emcy_count == DG_CO_HISTORY) {
        return;
    }
    uint8_t *frame = self->emcy[in_ring(self->emcy_first + self->emcy_count++)];
    dg_store_le16(frame, code);
    frame[2] = error_register(self);
    memcpy(&frame[3], manufacturer, 5);
}

static void remember_error(struct dg_co_node *self, uint16_t code, const uint8_t *manufacturer)
{
    self->history_newest = in_ring(self->history_newest + 1u);
    self->history[self->history_newest] = (uint32_t)dg_load_le16(manufacturer) << 16 | code;
    if (self->history_count < DG_CO_HISTORY) {
        self->history_count++;
    }
}

void dg_co_raise(struct dg_co_node *self, uint8_t cause, const uint8_t manufacturer[5])
{
    const struct dg_co_cause *row = cause_at(self, cause);
    uint32_t bit = 1u << cause;

    if ((self->active_causes & bit) != 0) {
        return;
    }
    self->others = 0;
    self->active_causes |= bit;
    remember_error(self, row->code, manufacturer);
    queue_emergency(self, row->code, manufacturer);
    (void)dg_co_emcy_step(self); /* before a reaction can leave the state that allows it */
    dg_co_react(self, (enum dg_co_error_class)row->class_of);
}

void dg_co_clear(struct dg_co_node *self, uint8_t cause)
{
    static const uint8_t none[5];
    uint32_t bit = 1u << cause;

    if ((self->active_causes & bit) == 0) {
        return;
    }
    self->others = 0;
    self->active_causes &= ~bit;
    if (self->active_causes == 0) {
        queue_emergency(self, 0, none);
    }
}

void dg_co_emcy_start(struct dg_co_node *self)
{
    self->active_causes = 0;
    self->history_count = 0; /* power-on values (C37) */
    self->emcy_count = 0;
    self->emcy_until = 0;
}

dg_ns dg_co_emcy_step(struct dg_co_node *self)
{
    bool allowed = self->state == DG_CO_PRE_OPERATIONAL || self->state == DG_CO_OPERATIONAL;

    while (self->emcy_count > 0 && allowed && self->emcy_until <= self->now) {
        dg_co_send(self, (uint16_t)(CO_ID_EMCY + self->id), self->emcy[self->emcy_first], 8);
        self->emcy_count--;
        self->emcy_first = in_ring(self->emcy_first + 1u);
        self->emcy_until = dg_co_after(self->now, DG_US(100u * self->value[CO_EMCY_INHIBIT_100US]));
    }
    return self->emcy_count > 0 && allowed ? self->emcy_until : DG_NEVER;
}

DG_CO_TELL(dg_co_hook_error_register, error_register(node))

/* 1002h: a bit for every cause that lasts. */
DG_CO_TELL(dg_co_hook_status, node->active_causes)

enum dg_co_abort dg_co_hook_history(struct dg_co_node *self, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    if (op == DG_CO_WRITE) {
        if (*value != 0) {
            return DG_CO_RANGE;
        }
        self->history_count = 0;
        return DG_CO_OK;
    }
    if (object->sub == 0) {
        *value = self->history_count;
        return DG_CO_OK;
    }
    if (object->sub > self->history_count) {
        return DG_CO_NO_DATA;
    }
    *value = self->history[in_ring(self->history_newest + 1u - object->sub)];
    return DG_CO_OK;
}

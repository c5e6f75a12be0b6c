/* SPDX-License-Identifier: MIT */
/**
 * @file
 * TPDOs: at work (co_pdo.c), and their parameters, 1800h and 1A00h (co_mapping.c).
 */
#ifndef DREHGEBER_CO_PDO_H
#define DREHGEBER_CO_PDO_H

#include "canopen_private.h"

/** Parameters of a TPDO, from CO_TPDO_SLOTS on. */
enum co_tpdo_slot {
    CO_PDO_COB_ID,
    CO_PDO_TYPE,
    CO_PDO_INHIBIT_100US,
    CO_PDO_EVENT_MS,
    CO_PDO_MAPPED,  /* sub 0 of 1A00h */
    CO_PDO_ENTRIES, /* 8 of them */
    CO_PDO_SLOTS = CO_PDO_ENTRIES + DG_CO_MAPPED_MAX,
};
#define CO_TPDO(n, parameter) (CO_TPDO_SLOTS + (n)*CO_PDO_SLOTS + (parameter))
_Static_assert(CO_TPDO(DG_CO_TPDOS, 0) <= DG_CO_SLOT_BIT_RATE, "room for the stack's slots");

/** Transmission types, and the ends of their ranges. */
enum co_pdo_type {
    CO_PDO_ACYCLIC = 0,
    CO_PDO_CYCLIC_MAX = 240,
    CO_PDO_REQUEST_SYNC = 252,
    CO_PDO_REQUEST = 253,
    CO_PDO_EVENT = 254, /* and 255 */
};

/** CAN-ID of TPDO `n` in the predefined connection set. */
static inline uint32_t co_predefined(uint8_t n, uint8_t node_id)
{
    return 0x180u + 0x100u * n + node_id;
}

static inline uint32_t co_pdo_parameter(const struct dg_co_node *self, uint8_t n, uint8_t slot)
{
    return self->value[CO_TPDO(n, slot)];
}

static inline bool co_pdo_takes_events(uint8_t type)
{
    return type == CO_PDO_ACYCLIC || type >= CO_PDO_EVENT;
}

/* co_mapping.c */

void dg_co_pdo_start(struct dg_co_node *self);
/** Hooks of 1800h and 1A00h. */
dg_co_hook dg_co_hook_tpdo, dg_co_hook_mapping;

/* co_pdo.c */

/** The NMT state has become operational, or is not any more. */
void dg_co_pdo_state(struct dg_co_node *self, bool operational);
void dg_co_sync_rx(struct dg_co_node *self, const struct dg_can_frame *frame);
/** A remote frame: TPDOs of this node that have its CAN-ID answer. */
void dg_co_pdo_rtr(struct dg_co_node *self, uint16_t id);
dg_ns dg_co_pdo_step(struct dg_co_node *self);
/** Forget events, samples and the phase of SYNC of TPDO `n`; its event timer runs from now. */
void dg_co_pdo_restart(struct dg_co_node *self, uint8_t n);

#endif

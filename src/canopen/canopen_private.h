/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the CANopen stack: what all of its files share. Each service has a header of its own:
 * co_SERVICE.h. There *_start() sets the state after a reset (values are loaded), *_rx() takes a
 * frame, and *_step() does what is due at self->now and returns the next moment it wants to be
 * called.
 */
#ifndef DREHGEBER_CANOPEN_PRIVATE_H
#define DREHGEBER_CANOPEN_PRIVATE_H

#include "drehgeber/bits.h"
#include "drehgeber/canopen.h"

/** Slots of the stack's own values in dg_co_node.value. */
enum co_slot {
    CO_SYNC_COB_ID,
    CO_SYNC_PERIOD_US,
    CO_SYNC_WINDOW_US,
    CO_GUARD_TIME_MS,
    CO_LIFE_FACTOR,
    CO_TIME_COB_ID,
    CO_NODE_ID,
    CO_EMCY_COB_ID,
    CO_EMCY_INHIBIT_100US,
    CO_CONSUMER_1,
    CO_CONSUMER_2,
    CO_HEARTBEAT_MS,
    CO_BEHAVIOUR_1, /* 1029h:1-3, in the order of enum dg_co_error_class */
    CO_BEHAVIOUR_2,
    CO_BEHAVIOUR_3,
    CO_TPDO_SLOTS, /* CO_TPDO(n, ...), see co_pdo.h */
};

/** CAN-IDs of the predefined connection set; a node's own are the base plus its node-ID. */
#define CO_ID_NMT 0x000u
#define CO_ID_EMCY 0x080u
#define CO_ID_SDO_TX 0x580u
#define CO_ID_SDO_RX 0x600u
#define CO_ID_GUARD 0x700u
#define CO_ID_LSS_TX 0x7E4u
#define CO_ID_LSS_RX 0x7E5u

/** Bits of COB-IDs. */
#define CO_COB_INVALID 0x80000000u
#define CO_COB_BIT30 0x40000000u /* TPDO: no RTR; SYNC, TIME: producer */
#define CO_COB_EXTENDED 0x20000000u
#define CO_COB_CAN_ID 0x7FFu

/* co_node.c */

/** Send a frame now, unless the bus has to be silent. */
void dg_co_send_frame(struct dg_co_node *self, const struct dg_can_frame *frame);
/** The same, with up to 8 bytes of data. */
void dg_co_send(struct dg_co_node *self, uint16_t id, const uint8_t *data, uint8_t dlc);
/** A bit rate by its number; 0: the device has no such number. */
uint16_t dg_co_kbaud(const struct dg_co_device *device, uint8_t number);
/** The configured bit rate comes into force. */
void dg_co_use_bit_rate(struct dg_co_node *self);
/** dg_after() once for all: inside a function it takes as much as a call and ten instructions. */
dg_ns dg_co_after(dg_ns from, dg_ns span);
/** `ms` after `from`; DG_NEVER when `ms` is 0, which is how a dictionary switches a timer off. */
dg_ns dg_co_after_ms(dg_ns from, uint32_t ms);
/** Enter Initialisation; `application` also resets 2000h-9FFFh (NMT 81h, LSS). */
void dg_co_reset(struct dg_co_node *self, bool application);

#endif

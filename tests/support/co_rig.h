/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CANopen node on a RAM EEPROM with a shaft, in virtual time; what it sends is kept.
 */
#ifndef TESTS_SUPPORT_CO_RIG_H
#define TESTS_SUPPORT_CO_RIG_H

#include "drehgeber/cia406.h"
#include "drehgeber/motion.h"
#include "ram_nvm.h"

#define CO_RIG_FRAMES 256u
/** Values that only store, of an encoder from an EDS file; others have none. */
#define CO_RIG_CELLS 32768u

struct co_rig {
    const struct dg_cia406_model *model;
    struct ram_nvm nvm;
    struct dg_motion motion;
    struct dg_world world;
    union {
        struct dg_cia406_device device;
        struct { /* its parts */
            struct dg_co_node node;
            struct dg_cia406 encoder;
        };
    };
    uint32_t cells[CO_RIG_CELLS]; /**< directly behind the encoder, where its device looks */
    dg_ns now;
    uint16_t kbaud;                           /**< last bit rate the node reported */
    uint32_t count;                           /**< frames sent since co_rig_forget() */
    struct dg_can_frame frame[CO_RIG_FRAMES]; /**< the first CO_RIG_FRAMES of them */
    dg_ns at[CO_RIG_FRAMES];
};

/** A fresh f3668 (node-ID 3Fh, serial number 1234567890), powered on at 1 s, boot-up forgotten. */
void co_rig_start(struct co_rig *self);
/** The same with another model, which must outlive the rig. */
void co_rig_start_model(struct co_rig *self, const struct dg_cia406_model *model);
/** The same on the memory as it is. @return as dg_co_power_on() */
int co_rig_power_on(struct co_rig *self);
/** Forget what was sent. */
void co_rig_forget(struct co_rig *self);
/** A data frame comes in now. `bytes` in hex, e.g. "40 00 10 00"; padded to 8 for CAN-IDs
 * 600h-67Fh. */
void co_rig_rx(struct co_rig *self, uint16_t id, const char *bytes);
/** A remote frame comes in now. */
void co_rig_rtr(struct co_rig *self, uint16_t id);
/** Time passes; every deadline on the way is served exactly. */
void co_rig_run(struct co_rig *self, dg_ns span);
/** The frame `n` sent since co_rig_forget() is exactly this (cmocka assertion). */
void co_rig_expect(const struct co_rig *self, uint32_t n, uint16_t id, const char *bytes);
/** Exactly `count` frames were sent since co_rig_forget() (cmocka assertion). */
void co_rig_expect_count(const struct co_rig *self, uint32_t count);
/** NMT command to the node, e.g. 01h start; forgets what was sent. */
void co_rig_nmt(struct co_rig *self, uint8_t command);
/** Write `size` bytes of an object by expedited SDO. @return 0 or the abort code */
uint32_t co_rig_write(struct co_rig *self, uint16_t index, uint8_t sub, uint32_t value,
                      uint8_t size);
/** Read an object by expedited SDO. @return 0 or the abort code */
uint32_t co_rig_read(struct co_rig *self, uint16_t index, uint8_t sub, uint32_t *value);
/** A write and a read that must succeed (cmocka assertions). */
void co_rig_put(struct co_rig *self, uint16_t index, uint8_t sub, uint32_t value, uint8_t size);
uint32_t co_rig_get(struct co_rig *self, uint16_t index, uint8_t sub);
/** 1010h, and the TPDOs' COB-IDs in the memory as earlier releases stored them: absolute. */
void co_rig_store_cob_ids(struct co_rig *self, const uint32_t cob_ids[DG_CO_TPDOS]);

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CANopen node for tests of TPDOs, in virtual time, used through frames only. The device has
 * objects whose values the test sets, and counts its samples. One rig for a test program.
 */
#ifndef TESTS_SUPPORT_PDO_RIG_H
#define TESTS_SUPPORT_PDO_RIG_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/canopen.h"
#include "ram_nvm.h"

/** CAN-IDs that go with node-ID 3Fh. */
#define TPDO1 0x1BFu
#define TPDO2 0x2BFu
#define TPDO3 0x3BFu
#define TPDO4 0x4BFu
#define EMCY 0x0BFu
/** Bits of a TPDO's COB-ID. */
#define NOT_VALID 0x80000000u
#define NO_RTR 0x40000000u
/** Frames that are kept at most. */
#define PDO_RIG_FRAMES 512u

/** NMT commands. */
enum { START = 0x01, STOP = 0x02, PRE_OPERATIONAL = 0x80, RESET_NODE = 0x81 };

/** A frame the node has sent. */
struct pdo_sent {
    struct dg_can_frame frame;
    dg_ns at;
};

/** The rig. */
extern struct pdo_rig {
    struct dg_world world;
    struct ram_nvm nvm;
    struct dg_co_node node;
    dg_ns now;
    uint32_t count; /**< frames kept */
    struct pdo_sent sent[PDO_RIG_FRAMES];
    uint32_t live;    /**< value of all objects */
    uint32_t sample;  /**< the one taken last */
    unsigned samples; /**< counted up */
    bool event;       /**< next step: the values may have changed */
    bool fault;       /**< next sample: raise an EMCY */
} pdo_rig;

extern const struct dg_store_layout pdo_rig_layout;
/**
 * U8 2001h, U16 2002h and U32 2003h, 6004h: the sample. I8 2004h:1 FEh, U32 2008h 44332211h, I16
 * 6030h:1 FF85h, U32 2160h 017F3A15h, U16 2162h 2900h. Not to be mapped: 2005h, 2006h (write-only),
 * 2007h (a string). 6200h is TPDO1's event timer.
 */
extern const struct dg_co_device pdo_rig_device;
/** The same without 2001h-2008h. */
extern const struct dg_co_device pdo_rig_smaller_device;

/** Forget the frames and samples so far. */
void pdo_forget(void);

/** Power the node on as a device of this kind; nothing is kept yet. */
void pdo_power_on(const struct dg_co_device *with);

/** A formatted memory, the node pre-operational at 1 s, objects 01020304h. For cmocka. */
int pdo_set_up(void **state);

/** Time passes; every deadline on the way is served exactly. */
void pdo_run_until(dg_ns end);
void pdo_run_ms(uint32_t ms);

/** Frames that come in now: any, NMT to all, SYNC, SYNC with a counter, RTR. */
void pdo_receive(struct dg_can_frame frame);
void pdo_nmt(uint8_t command);
void pdo_sync(void);
void pdo_sync_counted(uint8_t counter);
void pdo_request(uint32_t id);

/** All objects change, and the device notices it at once. */
void pdo_change(uint32_t value);

/** Expedited download; the answer is not kept. @return 0 or the abort code */
uint32_t pdo_put(uint16_t index, uint8_t sub, uint32_t value, uint8_t size);

/** Expedited upload; the answer is not kept. */
uint32_t pdo_get(uint16_t index, uint8_t sub);

/** A download that is accepted; that of a transmission type (TPDO n + 1). */
void pdo_put_ok(uint16_t index, uint8_t sub, uint32_t value, uint8_t size);
void pdo_put_type(uint8_t n, uint8_t type);

/** TPDO n + 1 not valid, valid, with its predefined CAN-ID. */
void pdo_disable(uint8_t n);
void pdo_enable(uint8_t n);

/** TPDO2 alone, of this type, operational; nothing kept. */
void pdo_only_tpdo2(uint8_t type);

/** TPDO1 alone, type 255, operational; what it sent on entering is not kept. */
void pdo_only_tpdo1(uint16_t event_ms, uint16_t inhibit_ms);

/** Frame i is this one; a TPDO with this 32-bit value; was sent at this moment. */
void pdo_expect(uint32_t i, uint32_t id, const uint8_t *data, uint8_t dlc);
void pdo_expect_u32(uint32_t i, uint32_t id, uint32_t value);
void pdo_expect_at_ms(uint32_t i, dg_ns since, uint32_t ms);

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A test rig for the SDO server: a node with a dictionary of every type, driven by scripts of
 * requests and the answers they must have, in virtual time.
 */
#ifndef TESTS_SUPPORT_SDO_RIG_H
#define TESTS_SUPPORT_SDO_RIG_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/canopen.h"
#include "ram_nvm.h"

#define SDO_RIG_FRAMES_MAX 16u
/** Time between two requests of a script. */
#define SDO_RIG_PAUSE DG_MS(1)

/**
 * Slots of the rig's objects. 2000h: U16, reads as the number of samples taken. 2001h-2006h: I8,
 * I16, I32, U8, U16, U32, read and write; the signed ones within -100..100, -1000..1000,
 * -100000..100000. 2007h:0-1: an array with U8 and U32.
 */
enum sdo_rig_slot {
    SDO_RIG_I8 = DG_CO_SLOT_APPLICATION,
    SDO_RIG_I16,
    SDO_RIG_I32,
    SDO_RIG_U8,
    SDO_RIG_U16,
    SDO_RIG_U32,
    SDO_RIG_ARRAY,
    SDO_RIG_WRITE_ONLY, /**< 2008h: U32 */
    /* 200Ah: U32, a write is refused with the value as abort code. 200Bh: U8, reading is refused
     * with 08000024h. 2010h-2018h: texts of 0, 4, 5, 7, 8, 9, 14, 32 and 46 characters. */
};

struct sdo_rig {
    struct dg_world world;
    struct ram_nvm nvm;
    struct dg_co_node node;
    dg_ns now;
    unsigned samples; /**< taken by the device */
    unsigned count;   /**< frames sent since they were last looked at */
    struct dg_can_frame frames[SDO_RIG_FRAMES_MAX];
};

/** A step of a transfer: eight bytes in hexadecimal each; answers are joined by " / ". */
struct sdo_rig_step {
    const char *request;
    const char *answer; /**< "" when there is none */
};

/** A node 3Fh, pre-operational. Asserts that this works. */
void sdo_rig_init(struct sdo_rig *self);

/** Receive up to 8 bytes on a CAN-ID, at the rig's `now`. */
void sdo_rig_receive(struct sdo_rig *self, uint16_t id, const char *bytes);

/** Assert what has been sent since the last look, all of it from 580h + 3Fh with 8 bytes. */
void sdo_rig_expect(struct sdo_rig *self, const char *answer);

/** A request to 600h + 3Fh must have this answer, at once. */
void sdo_rig_ask(struct sdo_rig *self, const char *request, const char *answer);

/** Let time pass, with the node's deadlines met. */
void sdo_rig_wait(struct sdo_rig *self, dg_ns span);

/** Play `n` steps. */
void sdo_rig_play(struct sdo_rig *self, const struct sdo_rig_step *steps, size_t n);

/**
 * Play a transfer, again and again on new nodes, and disturb it after each step but the last: by a
 * new request, which must be served; by a client's abort; by a timeout; by silence for almost as
 * long, a frame that is too short, a frame for another node, all without effect.
 */
void sdo_rig_disturb(struct sdo_rig *self, const struct sdo_rig_step *steps, size_t n);

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A CANopen stack, ours or another one, as exchanges.c asks it. What stands behind these functions
 * is written for this comparison: the least a frame needs to be answered, without a driver, in
 * virtual time.
 */
#ifndef BENCH_PEERS_PEER_H
#define BENCH_PEERS_PEER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define NODE_ID 63u

/** A frame; from_peer() gets one, to_peer() takes one. */
struct peer_frame {
    uint16_t id;
    uint8_t dlc;
    uint8_t data[8];
};

/** A sub-index of the dictionary, as the EDS file says (rows.py). */
struct row {
    uint16_t index;
    uint8_t sub;
    uint8_t type;  /**< number of CiA 301 */
    uint16_t bits; /**< of its value */
    bool readable;
    bool writable;
    bool mappable;
    uint32_t value;
    const char *text; /**< of a string */
};
enum { TYPE_I8 = 2, TYPE_I16, TYPE_I32, TYPE_U8, TYPE_U16, TYPE_U32, TYPE_STRING = 9 };

/** All of them, sorted. */
extern const struct row rows[];
extern const size_t row_count;

/** Make a node that has booted, of `rows` where it is a peer's. @return whether it works */
bool peer_start(void);
/** A frame comes in, 100 us after the one before. */
void to_peer(const struct peer_frame *frame);
/** A millisecond passes, with nothing due. */
void peer_wait(void);
/** It sends a frame. Called by the peer. */
void from_peer(uint16_t id, uint8_t dlc, const uint8_t *data);

#endif

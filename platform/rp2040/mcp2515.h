/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A Microchip MCP2515 CAN controller with a crystal of 16 MHz on SPI0: pins 16 (SO), 17 (/CS), 18
 * (SCK), 19 (SI) and 20 (/INT). Names are those of its data sheet, DS20001801.
 */
#ifndef MCP2515_H
#define MCP2515_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/canopen.h"

/** Pins and SPI, once. */
void mcp2515_start(void);

/** Of 11 bits. */
#define MCP2515_ID_MAX 0x7FFu

/** What it hears, of frames with 11 bits: the first buffer takes what is one of two patterns in the
 * bits of the mask, and the second one what comes while that is full, and one identifier more. */
struct mcp2515_filters {
    uint16_t mask;       /**< bits that count, 0..7FFh; 0: all is heard */
    uint16_t pattern[2]; /**< 0..7FFh */
    uint16_t extra;      /**< 0..7FFh; it may overtake the others, and has one buffer only */
};

/** Go on the bus. Sample points: 87.5 %, 75 % at 1 Mbit/s.
 * @param kbaud 10, 20, 50, 100, 125, 250, 500 or 1000; others: off the bus
 * @return false: nothing answers on SPI */
bool mcp2515_open(uint16_t kbaud, const struct mcp2515_filters *filters);
/** Other filters, for which it leaves the bus: for 11 bits and some 40 us, when what it sends is
 * sent. Its error counters are 0 afterwards. @return false: not yet, call again */
bool mcp2515_filter(const struct mcp2515_filters *filters);

/** Whether it wants something: one of the next three has something to say. */
bool mcp2515_pending(void);
/** Whether a frame can be sent; it goes out when the bus lets it. One at a time keeps the order. */
bool mcp2515_ready(void);
void mcp2515_send(const struct dg_can_frame *frame);
/** @return false: none has come */
bool mcp2515_receive(struct dg_can_frame *to);

/** What has become of its error states. */
struct mcp2515_errors {
    bool off;     /**< bus-off; it is back by itself behind 128 * 11 recessive bits */
    bool passive; /**< error passive */
    bool overrun; /**< a frame was lost since the last time */
};
struct mcp2515_errors mcp2515_errors(void);

#endif

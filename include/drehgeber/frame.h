/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A frame of a CAN bus (ISO 11898-1, CAN 2.0A), whatever protocol it belongs to.
 */
#ifndef DREHGEBER_FRAME_H
#define DREHGEBER_FRAME_H

#include <stdbool.h>
#include <stdint.h>

/** A CAN 2.0A data or remote frame. */
struct dg_can_frame {
    uint16_t id; /**< 0..7FFh */
    bool rtr;
    uint8_t dlc; /**< 0..8 */
    uint8_t data[8];
};

#endif

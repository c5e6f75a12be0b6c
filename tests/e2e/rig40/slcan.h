/* SPDX-License-Identifier: MIT */
/** @file CAN frames on a terminal with SLCAN, as Lawicel's CANUSB manual has it. */
#ifndef DREHGEBER_TESTS_SLCAN_H
#define DREHGEBER_TESTS_SLCAN_H

#include <linux/can.h>

#include "masters.h"

/** Open the terminal and the adapter's channel, which nobody has open, at 250 kBd. */
void slcan_open(struct master *self);

void slcan_send(const struct master *self, const struct can_frame *frame);

/** @return whether a frame came before `end` */
bool slcan_take(struct master *self, struct can_frame *frame, int64_t end);

#endif

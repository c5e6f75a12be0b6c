/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SCPI on UART0, 115200 Bd 8N1, pins 0 (out) and 1 (in): the control plane of the library with one
 * encoder on one shaft.
 */
#ifndef CONSOLE_H
#define CONSOLE_H

#include "drehgeber/instrument.h"
#include "drehgeber/stack.h"

/** Once, when the encoder is on. */
void console_start(const struct dg_device *model, const struct dg_instrument *instrument,
                   struct dg_nvm nvm);
/** From the main loop. @return as port_loop() */
dg_ns console_loop(void);

#endif

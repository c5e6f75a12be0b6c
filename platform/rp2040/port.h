/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What an image is made of: one encoder, one shaft and one world (main.c), and one port, the wire
 * that it is on. Each port is a file; an image links one of them.
 *
 * Pins 0 and 1 are the console's. The world is the encoder's; who bends it or the shaft has a copy
 * of its own and hands that over at once, so that a position is never half of one and half of
 * another (port_turn()).
 */
#ifndef PORT_H
#define PORT_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/hal.h"
#include "drehgeber/shaft.h"
#include "drehgeber/stack.h"
#include "drehgeber/world.h"

/** The encoder: its memory is for the port to take as what it is. */
extern void *const port_device;

/** The world and the shaft are these from now on. */
void port_turn(const struct dg_world *to, const struct dg_shaft *turning);

/** What the device hands its output to, as dg_stack_setup.port; NULL: it has none. */
extern const void *const port_ops;
/** What the wire is, for INSTrument:WIRE?. */
extern const char *const port_name;
/** Pins and peripherals, once, when the encoder has been made. */
void port_start(void);
/** Power, world or shaft have changed. Called between board_lock() and board_unlock(). */
void port_changed(void);
/** From the main loop: what is not done in interrupts. @return when to call again, if no interrupt
 * was before that */
dg_ns port_loop(void);
/** The device writes to its EEPROM, or begins to. Called in whichever interrupt it does. */
void port_stores(void);
/** Whether nothing is wanted of the encoder for some time: see flash_log_loop(). */
bool port_idle(void);
/** Whether somebody has just been answered, and nothing more has come since: a moment for what
 * cannot wait for port_idle() any longer, and makes the next answer late. false: there is none that
 * would not lose something. */
bool port_pause(void);
/** Nothing is sent or received between these two: for who works on the device. */
void port_hold(void);
void port_release(void);

#endif

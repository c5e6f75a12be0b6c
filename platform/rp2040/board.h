/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The board: clocks, time, pins, interrupts. The system clock has 125 MHz, a cycle is 8 ns.
 */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#include "drehgeber/time.h"

/** The system clock, and one cycle of it. */
#define BOARD_HZ 125000000u
#define BOARD_CYCLE_NS 8u
/** SysTick counts so far, downwards. */
#define BOARD_COUNT_MASK 0xFFFFFFu

/** What a pin is for: the numbers of IO_CTRL (data sheet, 2.19.2). */
enum board_function {
    BOARD_SPI = 1,
    BOARD_UART = 2,
    BOARD_PWM = 4,
    BOARD_SIO = 5,
    BOARD_PIO0 = 6,
    BOARD_PIO1 = 7,
};

/** Priorities of interrupts; the lower number comes first. */
enum board_priority { BOARD_LATCH, BOARD_WIRE, BOARD_CONSOLE, BOARD_LOW };

/** Start clocks and time, take the peripherals out of their resets. */
void board_start(void);

/** Now. Counts from the start of the timer, in steps of a cycle. */
dg_ns board_now(void);
/** The moment at which SysTick stood at `count`, less than 60 ms ago. */
dg_ns board_at(uint32_t count);

/** Give a pin to `function`. */
void board_pin(uint32_t pin, enum board_function function);

/** Sleep until an interrupt has been, at `until` at the latest, a few microseconds before. */
void board_sleep(dg_ns until);

/** Enable an interrupt. */
void board_interrupt(uint32_t irq, enum board_priority priority);

/** Nothing of the encoder runs between these two; they may be nested. */
void board_lock(void);
void board_unlock(void);

#endif

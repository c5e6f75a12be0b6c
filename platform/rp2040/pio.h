/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Instructions of the RP2040's PIO (data sheet, 3.4), so that the compiler is the assembler: a
 * program is a table whose labels are its indices. Each takes a cycle.
 *
 * Programs keep to what silicon and emulators agree on: no joined FIFOs, no PULL IFEMPTY, and
 * OUT NULL,32 behind MOV OSR,NULL, as one of them only counts.
 */
#ifndef PIO_H
#define PIO_H

#include <stddef.h>
#include <stdint.h>

#include "rp2040.h"

/** Conditions of a jump. */
enum pio_condition {
    PIO_ALWAYS,
    PIO_NOT_X,
    PIO_X_DEC, /**< X is not 0; it is one less afterwards */
    PIO_NOT_Y,
    PIO_Y_DEC,
    PIO_X_NOT_Y,
    PIO_PIN,      /**< the pin of EXECCTRL is high */
    PIO_NOT_OSRE, /**< OSR has bits left */
};

/** Sources and destinations; some instructions know fewer. */
enum pio_where { PIO_PINS, PIO_X, PIO_Y, PIO_NULL, PIO_PINDIRS, PIO_STATUS, PIO_ISR, PIO_OSR };

/** Instructions. WAIT_IRQ clears the flag; PUSH does not wait for room, PULL not for a word: OSR is
 * X without. MOV knows ISR and OSR as destinations by the numbers PIO_TO_ISR, PIO_TO_OSR. */
#define PIO_JMP(condition, to) ((uint16_t)((condition) << 5 | (to)))
#define PIO_WAIT_PIN(level, pin) ((uint16_t)(0x2020 | (level) << 7 | (pin)))
#define PIO_WAIT_IRQ(flag) ((uint16_t)(0x20C0 | (flag)))
#define PIO_IN(from, bits) ((uint16_t)(0x4000 | (from) << 5 | ((bits)&31)))
#define PIO_OUT(to, bits) ((uint16_t)(0x6000 | (to) << 5 | ((bits)&31)))
#define PIO_PUSH ((uint16_t)0x8000)
#define PIO_PULL ((uint16_t)0x8080)
#define PIO_PULL_BLOCK ((uint16_t)0x80A0)
#define PIO_MOV(to, from) ((uint16_t)(0xA000 | (to) << 5 | (from)))
#define PIO_MOV_NOT(to, from) ((uint16_t)(0xA008 | (to) << 5 | (from)))
#define PIO_RAISE(flag) ((uint16_t)(0xC000 | (flag)))
#define PIO_SET(to, value) ((uint16_t)(0xE000 | (to) << 5 | (value)))
/** The same instruction with `n` cycles more, or with side-set pin 0 (optional) at `level`. */
#define PIO_DELAY(n, instruction) ((uint16_t)((instruction) | (n) << 8))
#define PIO_SIDE(level, instruction) ((uint16_t)((instruction) | 0x1000 | (level) << 11))

/** How a state machine runs. */
struct pio_machine {
    uint32_t pio;       /**< PIO0 or PIO1 */
    uint32_t index;     /**< 0..3 */
    uint32_t clkdiv;    /**< in 1/65536 */
    uint32_t execctrl;  /**< without the range it wraps in */
    uint32_t shiftctrl; /**< as the register */
    uint32_t pinctrl;   /**< as the register */
    uint8_t wrap_from;  /**< behind this instruction ... */
    uint8_t wrap_to;    /**< ... this one */
    uint8_t start;      /**< the first one */
};

/** Write a program to the instruction memory, from instruction `at` on; its jumps know that. */
void pio_load(uint32_t pio, uint32_t at, const uint16_t *program, size_t n);
/** Set a machine up; it does not run yet. */
void pio_set_up(const struct pio_machine *machine);
/** Make a pin an output of it; what it sets next stays as it was set up. */
void pio_direct(const struct pio_machine *machine, uint32_t pin);
/** Let it run, or not. */
void pio_run(const struct pio_machine *machine, int on);

/** Do an instruction now, between two of its own. */
static inline void pio_do(const struct pio_machine *machine, uint16_t instruction)
{
    REG(machine->pio + PIO_SM(machine->index) + PIO_SM_INSTR) = instruction;
}

#endif

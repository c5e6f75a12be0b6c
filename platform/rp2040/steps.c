/* SPDX-License-Identifier: MIT */
#include "steps.h"

#include "board.h"
#include "pio.h"

#define PIN_STEP 14u
#define PIN_DIRECTION 15u

/* Labels, behind what a port has in PIO1. */
enum { FIRST = 20, UP = FIRST + 5, SAME = FIRST + 7, END = FIRST + 8 };

/* X counts. JMP X-- takes one off whether it jumps or not; the complement of that adds one. */
static const uint16_t program[END - FIRST] = {
    PIO_WAIT_PIN(0, 0),
    PIO_WAIT_PIN(1, 0),
    PIO_JMP(PIO_PIN, UP),
    PIO_JMP(PIO_X_DEC, FIRST),
    PIO_JMP(PIO_ALWAYS, FIRST), /* from 0 */
    [UP - FIRST] = PIO_MOV_NOT(PIO_X, PIO_X),
    PIO_JMP(PIO_X_DEC, SAME),
    [SAME - FIRST] = PIO_MOV_NOT(PIO_X, PIO_X),
};

static const struct pio_machine counter = {.pio = PIO1,
                                           .index = 3,
                                           .clkdiv = 1u << 16,
                                           .execctrl = PIN_DIRECTION << 24,
                                           .pinctrl = PIN_STEP << 15,
                                           .wrap_from = END - 1,
                                           .wrap_to = FIRST,
                                           .start = FIRST};

void steps_start(void)
{
    board_pin(PIN_STEP, BOARD_PIO1);
    board_pin(PIN_DIRECTION, BOARD_PIO1);
    REG_SET(PAD(PIN_STEP)) = PAD_PULL_DOWN;
    REG_SET(PAD(PIN_DIRECTION)) = PAD_PULL_DOWN;
    pio_load(PIO1, FIRST, program, END - FIRST);
    pio_set_up(&counter);
    pio_do(&counter, PIO_SET(PIO_X, 0));
    pio_run(&counter, 1);
}

uint32_t steps_count(void)
{
    pio_do(&counter, PIO_MOV(PIO_ISR, PIO_X));
    pio_do(&counter, PIO_PUSH);
    return REG(PIO1 + PIO_RXF(3));
}

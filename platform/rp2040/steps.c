/* SPDX-License-Identifier: MIT */
#include "steps.h"

#include <stdbool.h>

#include "board.h"
#include "pio.h"

#define PIN_QUADRATURE 13u
#define PIN_STEP 14u
#define PIN_DIRECTION 15u
#define PIN_A PIN_STEP
#define PIN_B PIN_DIRECTION

#define FIRST 20u /* behind what a port has in PIO1 */

/* ------------------------------------------------------------ step and direction */

/* Labels. */
enum { UP = FIRST + 5, SAME = FIRST + 7, STEPS_END = FIRST + 8 };

/* X counts. JMP X-- takes one off whether it jumps or not; the complement of that adds one. */
static const uint16_t steps[STEPS_END - FIRST] = {
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
                                           .wrap_from = STEPS_END - 1,
                                           .wrap_to = FIRST,
                                           .start = FIRST};

/* ------------------------------------------------------------ quadrature */

/*
 *   A ___|¯¯¯¯¯¯¯|_______|¯¯     Clockwise A leads. One machine waits for the edges of A and looks
 *   B _______|¯¯¯¯¯¯¯|_______    at B, another one the other way round.
 */

/* Labels. */
enum { RISE = FIRST, RISE_HIGH = FIRST + 4, FALL, FALL_HIGH = FIRST + 9, EDGES_END };

/* X is one less for each edge behind which the pins differ from what they are for Y: the other one
   is low at a rise, high at a fall. */
static const uint16_t edges[EDGES_END - FIRST] = {
    [RISE - FIRST] = PIO_WAIT_PIN(1, 0),
    PIO_JMP(PIO_PIN, RISE_HIGH),
    PIO_JMP(PIO_X_DEC, FALL),
    PIO_JMP(PIO_ALWAYS, FALL), /* from 0 */
    [RISE_HIGH - FIRST] = PIO_JMP(PIO_Y_DEC, FALL),
    [FALL - FIRST] = PIO_WAIT_PIN(0, 0),
    PIO_JMP(PIO_PIN, FALL_HIGH),
    PIO_JMP(PIO_Y_DEC, RISE),
    PIO_JMP(PIO_ALWAYS, RISE),
    [FALL_HIGH - FIRST] = PIO_JMP(PIO_X_DEC, RISE),
};

static struct pio_machine edges_of_a = {.pio = PIO1,
                                        .index = 2,
                                        .clkdiv = 1u << 16,
                                        .execctrl = PIN_B << 24,
                                        .pinctrl = PIN_A << 15,
                                        .wrap_from = EDGES_END - 1,
                                        .wrap_to = RISE};
static struct pio_machine edges_of_b = {.pio = PIO1,
                                        .index = 3,
                                        .clkdiv = 1u << 16,
                                        .execctrl = PIN_A << 24,
                                        .pinctrl = PIN_B << 15,
                                        .wrap_from = EDGES_END - 1,
                                        .wrap_to = RISE};

/* ------------------------------------------------------------ counting */

static bool quadrature;

static bool pin_level_of(uint32_t pin)
{
    return (REG(SIO_IN) & 1u << pin) != 0;
}

static void count_from_0(const struct pio_machine *machine)
{
    pio_set_up(machine);
    pio_do(machine, PIO_SET(PIO_X, 0));
    pio_do(machine, PIO_SET(PIO_Y, 0));
    pio_run(machine, 1);
}

static uint32_t register_of(const struct pio_machine *machine, enum pio_where which)
{
    pio_do(machine, (uint16_t)PIO_MOV(PIO_ISR, which));
    pio_do(machine, PIO_PUSH);
    return REG(PIO1 + PIO_RXF(machine->index));
}

/* What X has lost and Y has not. */
static uint32_t balance_of(const struct pio_machine *machine)
{
    return register_of(machine, PIO_Y) - register_of(machine, PIO_X);
}

uint32_t steps_start(void)
{
    static const uint8_t pins[] = {PIN_QUADRATURE, PIN_STEP, PIN_DIRECTION};

    for (size_t i = 0; i < sizeof pins; i++) {
        board_pin(pins[i], BOARD_PIO1);
        REG_SET(PAD(pins[i])) = PAD_PULL_DOWN;
    }
    quadrature = pin_level_of(PIN_QUADRATURE);
    if (!quadrature) {
        pio_load(PIO1, FIRST, steps, STEPS_END - FIRST);
        count_from_0(&counter);
        return STEPS_PER_TURN;
    }
    pio_load(PIO1, FIRST, edges, EDGES_END - FIRST);
    edges_of_a.start = pin_level_of(PIN_A) ? FALL : RISE;
    edges_of_b.start = pin_level_of(PIN_B) ? FALL : RISE;
    count_from_0(&edges_of_a);
    count_from_0(&edges_of_b);
    return EDGES_PER_TURN;
}

uint32_t steps_count(void)
{
    return quadrature ? balance_of(&edges_of_a) - balance_of(&edges_of_b)
                      : register_of(&counter, PIO_X);
}

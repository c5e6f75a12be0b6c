/* SPDX-License-Identifier: MIT */
/*
 * SSI: the clock comes in on pin 2, data goes out on pin 3.
 *
 *   clock ¯¯|__|¯¯|__|¯¯|__|¯ ... ¯|__|¯¯¯¯¯¯¯¯¯¯¯¯¯
 *           f1 r1    r2    r3         rn+1
 *   data  ¯¯¯¯¯|MSB  |     |   ...    |_______|¯¯¯¯¯
 *                                     |<-tm ->| from the last falling edge
 *
 * The word has to be there half a clock behind f1, which no processor does: one is always ready,
 * renewed whenever the main loop comes by, of a moment AGE_NS ahead, in the middle of the time that
 * it will be the latest for. So a position is that of f1 give or take AGE_NS.
 *
 * X has the word, left-aligned, with the 0 behind it; after that it begins anew.
 */
#include "board.h"
#include "drehgeber/ssi.h"
#include "flash_log.h"
#include "pio.h"
#include "port.h"

#define PIN_CLOCK 2u
#define PIN_DATA 3u
/* Cycles between two looks at the clock. */
#define POLL 2u
#define AGE_NS DG_US(25)

/* Labels. */
enum { READY, FALL = 4, LOW, RISE = 10, SHIFT = 12, HIGH, STILL = 15, END = 18 };

/* Y: looks at the clock until tm is over. ISR: how many these are. */
static const uint16_t program[END] = {
    [READY] = PIO_PULL, /* the latest word, or X again */
    PIO_MOV(PIO_X, PIO_OSR),
    PIO_JMP(PIO_PIN, READY),
    PIO_MOV(PIO_OSR, PIO_X),
    [FALL] = PIO_MOV(PIO_Y, PIO_ISR),
    [LOW] = PIO_JMP(PIO_PIN, RISE),
    PIO_JMP(PIO_Y_DEC, LOW),
    PIO_SET(PIO_PINS, 1),
    PIO_WAIT_PIN(1, 0),
    PIO_JMP(PIO_ALWAYS, READY),
    [RISE] = PIO_JMP(PIO_NOT_OSRE, SHIFT),
    PIO_MOV(PIO_OSR, PIO_X),
    [SHIFT] = PIO_OUT(PIO_PINS, 1),
    [HIGH] = PIO_JMP(PIO_PIN, STILL),
    PIO_JMP(PIO_ALWAYS, FALL),
    [STILL] = PIO_JMP(PIO_Y_DEC, HIGH),
    PIO_SET(PIO_PINS, 1),
    PIO_JMP(PIO_ALWAYS, READY),
};

static struct pio_machine slave = {
    .pio = PIO0,
    .index = 0,
    .clkdiv = 1u << 16,
    .execctrl = PIN_CLOCK << 24,
    .pinctrl = 1u << 26 | 1u << 20 | PIN_CLOCK << 15 | PIN_DATA << 5 | PIN_DATA,
    .wrap_from = END - 1,
    .wrap_to = READY,
    .start = READY,
};

const void *const port_ops = NULL;
const char *const port_name = "pio:2,3";
const bool flash_log_behind = false; /* there is no EEPROM */
static bool running;

static struct dg_ssi *ssi(void)
{
    return port_device;
}

static const struct dg_ssi_model *model(void)
{
    return ssi()->setup.model;
}

/* It idles, and what was sent for it is taken. */
static bool wants_word(void)
{
    return REG(PIO0 + PIO_SM(0) + PIO_SM_ADDR) <= 2u && (REG(PIO0 + PIO_FSTAT) & 1u << 24) != 0;
}

static void send_word(uint64_t bits, uint8_t n)
{
    REG(PIO0 + PIO_TXF(0)) = (uint32_t)bits << (32u - n);
}

static void start_machines(void)
{
    pio_run(&slave, 0);
    pio_do(&slave, PIO_JMP(PIO_ALWAYS, READY));
    pio_do(&slave, PIO_SET(PIO_PINS, 1));
    pio_run(&slave, 1);
    running = true;
}

static void stop_machines(void)
{
    running = false;
    pio_run(&slave, 0);
    pio_do(&slave, PIO_SET(PIO_PINS, 0));
}

dg_ns port_loop(void)
{
    const dg_ns now = board_now();
    uint64_t bits;
    uint8_t n;

    (void)dg_ssi_step(ssi(), now);
    if (ssi()->state == DG_SSI_OFF || ssi()->state == DG_SSI_START) {
        return ssi()->deadline;
    }
    if (!running || wants_word()) {
        n = dg_ssi_frame(ssi(), now + AGE_NS, &bits);
        send_word(bits, n);
        if (!running) {
            start_machines();
        }
    }
    return now;
}

void port_start(void)
{
    const uint32_t bits = dg_ssi_word_bits(model()) + 1u;

    board_pin(PIN_CLOCK, BOARD_PIO0);
    board_pin(PIN_DATA, BOARD_PIO0);
    pio_load(PIO0, 0, program, END);
    slave.shiftctrl = (bits & 31u) << 25; /* OSR is empty behind so many */
    pio_set_up(&slave);
    pio_direct(&slave, PIN_DATA);
    REG(PIO0 + PIO_TXF(0)) = (uint32_t)model()->monoflop / (BOARD_CYCLE_NS * POLL);
    pio_do(&slave, PIO_PULL_BLOCK);
    pio_do(&slave, PIO_MOV(PIO_ISR, PIO_OSR));
    stop_machines();
}

void port_changed(void)
{
    if (running && (ssi()->state == DG_SSI_OFF || ssi()->state == DG_SSI_START)) {
        stop_machines();
    }
}

void port_stores(void)
{
}

bool port_idle(void)
{
    return true;
}

bool port_pause(void)
{
    return true;
}

void port_hold(void)
{
}

void port_release(void)
{
}

/* SPDX-License-Identifier: MIT */
/*
 * RS485, half duplex: RX is pin 2, TX pin 3, the driver's enable (DE) pin 4. PIO1 is the UART, as
 * that of the chip tells no start bit and knows no DE:
 *
 *   TX  ¯¯¯¯¯|start| 8 data, parity |stop|start| ...  |stop|¯¯¯
 *   DE  ___|¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯|___
 *
 * Machines go at 8 cycles a bit. Machine 0 sends: DE rises 2 cycles before the start bit and falls
 * 1 behind the stop bit. Machine 1 receives: flag 0 is the edge of a start bit.
 */
#include "board.h"
#include "drehgeber/hiperface.h"
#include "flash_log.h"
#include "pio.h"
#include "port.h"
#include "sincos.h"

#define PIN_RX 2u
#define PIN_TX 3u
#define PIN_DE 4u

#define SIGNALS_NS                                                                                 \
    DG_US(50) /* what the process channel takes, and more: a reply is not late for it */
#define CYCLES_PER_BIT 8u
#define START_EDGE (1u << 0) /* flag of PIO1 */
/* Bits of INTE. */
#define RX_FILLED (1u << 1)
#define TX_ROOM (1u << 4)
#define ON_START_EDGE (1u << 8)

#define DE(level, instruction) ((uint16_t)((instruction) | (level) << 12))

/* Labels. */
enum { OFF = 1, SEND = 3, BIT, STOP = 6, RECEIVE = 10, LENGTH = 12, SAMPLE, END = 18 };

/* X is 0 while something is sent: a PULL without a word gives X, and a character is never 0. */
static const uint16_t program[END] = {
    DE(1, PIO_DELAY(1, PIO_SET(PIO_PINS, 1))), /* behind the last stop bit */
    [OFF] = DE(0, PIO_PULL_BLOCK),
    DE(1, PIO_SET(PIO_X, 0)),
    [SEND] = DE(1, PIO_SET(PIO_Y, 0)), /* bits in front of the stop bit, less one: set_up_uart() */
    [BIT] = DE(1, PIO_DELAY(6, PIO_OUT(PIO_PINS, 1))),
    DE(1, PIO_JMP(PIO_Y_DEC, BIT)),
    [STOP] = DE(1, PIO_DELAY(3, PIO_SET(PIO_PINS, 1))),
    DE(1, PIO_PULL),
    DE(1, PIO_MOV(PIO_Y, PIO_OSR)),
    DE(1, PIO_JMP(PIO_NOT_Y, 0)),
    [RECEIVE] = PIO_WAIT_PIN(0, 0),
    PIO_RAISE(0),
    [LENGTH] =
        PIO_DELAY(9, PIO_SET(PIO_X, 0)), /* bits between start and stop bit, less one: likewise */
    [SAMPLE] = PIO_IN(PIO_PINS, 1),
    PIO_DELAY(6, PIO_JMP(PIO_X_DEC, SAMPLE)),
    PIO_IN(PIO_PINS, 1), /* the stop bit, in its middle */
    PIO_PUSH,
    PIO_WAIT_PIN(1, 0), /* behind a break */
};

static struct pio_machine sender = {
    .pio = PIO1,
    .index = 0,
    .shiftctrl = 1u << 19, /* the least significant bit first */
    .pinctrl = 1u << 29 | 1u << 26 | 1u << 20 | PIN_DE << 10 | PIN_TX << 5 | PIN_TX,
    .wrap_from = RECEIVE - 1,
    .wrap_to = SEND,
    .start = OFF,
};
static struct pio_machine receiver = {.pio = PIO1,
                                      .index = 1,
                                      .shiftctrl = 1u << 18,
                                      .pinctrl = PIN_RX << 15,
                                      .wrap_from = END - 1,
                                      .wrap_to = RECEIVE,
                                      .start = RECEIVE};

/* What came in, with its moment: each character has a start and an end. The erase of a sector may take
   as long as the longest request. */
#define HEARD_MAX 512u /* a power of two */

struct heard {
    dg_ns at;
    uint8_t byte;
    uint8_t flags; /* enum dg_hf_rx_flags */
};

_Static_assert(HEARD_MAX >= 2u * DG_HF_FRAME_MAX, "a request has room");

static struct heard heard[HEARD_MAX];
static volatile uint32_t heard_in, heard_out;

static struct dg_hf_uart uart; /* as the machines are set */
static uint32_t character_bits;
static dg_ns start_edge; /* of the character that comes in */

static uint8_t reply[DG_HF_FRAME_MAX];
static volatile size_t reply_length, reply_sent;
static volatile bool answered; /* by the last reply, and nothing has come in since */
static dg_ns due;              /* of the device */
static dg_ns quiet_since;
static dg_ns signals_due;

const bool flash_log_behind = false; /* what is acknowledged is stored */

static struct dg_hf *hf(void)
{
    return port_device;
}

/* ------------------------------------------------------------ characters */

static uint32_t byte_parity_of(uint8_t byte, char parity)
{
    uint32_t odd = byte;

    odd ^= odd >> 4;
    odd ^= odd >> 2;
    odd ^= odd >> 1;
    return (odd ^ (parity == 'O' ? 1u : 0u)) & 1u;
}

/* From the start bit on, without the stop bit. One bit more keeps it from being 0. */
static uint32_t frame_bits_of(uint8_t byte)
{
    const uint32_t parity = uart.parity == 'N' ? 1u : byte_parity_of(byte, uart.parity);

    return (uint32_t)byte << 1 | parity << 9 | 1u << 10;
}

/* `word`: the bits behind the start bit, left-aligned. */
static void take_bits(uint32_t word)
{
    const uint32_t bits = word >> (32u - (character_bits - 1u));
    const uint8_t byte = (uint8_t)bits;
    const bool stopped = (bits >> (character_bits - 2u) & 1u) != 0;
    const bool good = uart.parity == 'N' || (bits >> 8 & 1u) == byte_parity_of(byte, uart.parity);
    struct heard *to = &heard[heard_in % HEARD_MAX];

    to->at = start_edge + dg_bit_times_ns(character_bits, uart.baud);
    to->byte = byte;
    to->flags = stopped && good ? DG_HF_RX_OK : DG_HF_RX_DAMAGED;
    heard_in = heard_in + 1u;
}

static void send_more(void)
{
    while (reply_sent < reply_length && (REG(PIO1 + PIO_FSTAT) & 1u << 16) == 0) {
        REG(PIO1 + PIO_TXF(0)) = frame_bits_of(reply[reply_sent]);
        reply_sent = reply_sent + 1u;
    }
    if (reply_sent == reply_length) {
        REG_CLR(PIO1 + PIO_IRQ0_INTE) = TX_ROOM;
    }
}

/* Half duplex: what comes in while a reply is on the line is dropped. */
static bool sending(void)
{
    return reply_sent < reply_length || (REG(PIO1 + PIO_FSTAT) & 1u << 24) == 0 ||
           REG(PIO1 + PIO_SM(0) + PIO_SM_ADDR) != OFF;
}

void on_pio1(void);
void on_pio1(void)
{
    if ((REG(PIO1 + PIO_IRQ) & START_EDGE) != 0) {
        REG(PIO1 + PIO_IRQ) = START_EDGE;
        start_edge = board_now();
        answered = answered && sending();
        if (!sending() && heard_in - heard_out < HEARD_MAX - 1u) {
            heard[heard_in % HEARD_MAX] = (struct heard){.at = start_edge, .flags = DG_HF_RX_START};
            heard_in = heard_in + 1u;
        }
    }
    while ((REG(PIO1 + PIO_FSTAT) & 1u << (8 + 1)) == 0) {
        const uint32_t word = REG(PIO1 + PIO_RXF(1));
        if (!sending() && heard_in - heard_out < HEARD_MAX) {
            take_bits(word);
        }
    }
    if (reply_sent < reply_length) {
        send_more();
    }
}

/* The first characters at once: the reply starts now. */
static void tx(void *ctx, const uint8_t *bytes, size_t n)
{
    (void)ctx;
    for (size_t i = 0; i < n; i++) {
        reply[i] = bytes[i];
    }
    reply_sent = 0;
    reply_length = n;
    answered = true;
    board_lock();
    send_more();
    if (reply_sent < reply_length) {
        REG_SET(PIO1 + PIO_IRQ0_INTE) = TX_ROOM;
    }
    board_unlock();
}

static const struct dg_hf_ops ops = {.tx = tx};
const void *const port_ops = &ops;
const char *const port_name = "pio:2,3,4";

/* ------------------------------------------------------------ setting */

static void set_up_uart(void)
{
    const uint32_t divider = (uint32_t)(((uint64_t)BOARD_HZ << 8) / CYCLES_PER_BIT / uart.baud)
                             << 8;

    character_bits = uart.parity == 'N' ? 10u : 11u;
    pio_run(&sender, 0);
    pio_run(&receiver, 0);
    pio_load(PIO1, 0, program, END);
    REG(PIO1 + PIO_INSTR_MEM(SEND)) = DE(1, PIO_SET(PIO_Y, character_bits - 2u));
    REG(PIO1 + PIO_INSTR_MEM(LENGTH)) = PIO_DELAY(9, PIO_SET(PIO_X, character_bits - 3u));
    sender.clkdiv = divider;
    receiver.clkdiv = divider;
    pio_set_up(&sender);
    pio_set_up(&receiver);
    pio_run(&sender, 1);
    pio_run(&receiver, 1);
}

static void follow_uart_setting(void)
{
    const struct dg_hf_uart wanted = dg_hf_uart(hf());

    if ((wanted.baud != uart.baud || wanted.parity != uart.parity) && !sending()) {
        uart = wanted;
        set_up_uart();
    }
}

/* ------------------------------------------------------------ port */

void port_start(void)
{
    for (uint32_t pin = PIN_RX; pin <= PIN_DE; pin++) {
        board_pin(pin, BOARD_PIO1);
    }
    sincos_start();
    uart = dg_hf_uart(hf());
    set_up_uart();
    pio_do(&sender, DE(0, PIO_SET(PIO_PINS, 1)));
    pio_direct(&sender, PIN_TX);
    pio_direct(&sender, PIN_DE);
    REG(PIO1 + PIO_IRQ0_INTE) = ON_START_EDGE | RX_FILLED;
    board_interrupt(IRQ_PIO1_0, BOARD_WIRE);
}

void port_changed(void)
{
    due = 0; /* it looks at the world */
    signals_due = 0;
}

dg_ns port_loop(void)
{
    const struct heard *next = &heard[heard_out % HEARD_MAX];
    const dg_ns now = board_now();

    if (heard_in != heard_out && next->at <= now) {
        due = dg_hf_rx(hf(), next->at, next->byte, next->flags);
        heard_out = heard_out + 1u;
        quiet_since = now;
    } else if (due <= now) {
        due = dg_hf_step(hf(), now);
        follow_uart_setting();
    }
    if (signals_due <= now && dg_after(now, SIGNALS_NS) < due) {
        signals_due = sincos_follow(hf(), now);
    }
    const dg_ns next_due = dg_earliest(due, signals_due);
    return heard_in != heard_out ? dg_earliest(next_due, heard[heard_out % HEARD_MAX].at)
                                 : next_due;
}

void port_stores(void)
{
}

/* Masters ask at once, or not at all for long. */
bool port_idle(void)
{
    return !sending() && board_now() - quiet_since > DG_MS(500);
}

/* The master has yet to think of what to ask next. */
bool port_pause(void)
{
    return answered && !sending() && heard_in == heard_out;
}

void port_hold(void)
{
}

void port_release(void)
{
}

/* SPDX-License-Identifier: MIT */
#include "mcp2515.h"

#include <stddef.h>

#include "board.h"
#include "rp2040.h"

#define PIN_SO 16u
#define PIN_CS 17u
#define PIN_SCK 18u
#define PIN_SI 19u
#define PIN_INT 20u

#define SPI_DIVISOR 14u /* 8.9 MHz; 10 are allowed */
#define SPI_TX_ROOM (1u << 1)
#define SPI_RX_FILLED (1u << 2)

/* Instructions (table 12-1) and registers (table 11-1). */
enum {
    WRITE = 0x02,
    READ = 0x03,
    MODIFY = 0x05,
    LOAD_TXB0 = 0x40,
    SEND_TXB0 = 0x81,
    READ_RXB0 = 0x90,
    READ_RXB1 = 0x94,
    STATUS = 0xA0,
    RESET = 0xC0
};
enum {
    RXF0 = 0x00,
    CANSTAT = 0x0E,
    CANCTRL = 0x0F,
    RXF3 = 0x10,
    RXM0 = 0x20,
    CNF3 = 0x28,
    CANINTF = 0x2C,
    EFLG = 0x2D,
    TXB0CTRL = 0x30,
    RXB0CTRL = 0x60,
    RXB1CTRL = 0x70
};
#define MODE_CONFIGURATION 0x80u
#define MODE_NORMAL 0x00u
#define RX0IF 0x01u
#define RX1IF 0x02u
#define TX0IF 0x04u
#define ERRIF 0x20u
#define TXREQ 0x08u
#define RX_BOTH 0x04u /* what does not fit the first buffer goes to the second one */
#define RXEP 0x08u
#define TXEP 0x10u
#define TXBO 0x20u
#define RX_OVERRUN 0xC0u
#define STATUS_TXREQ 0x04u
#define RTR 0x40u /* in DLC */
#define SRR 0x10u /* in SIDL: a remote frame */
#define IDE 0x08u
#define EXIDE 0x08u /* in SIDL of a filter: for 29 bits */
#define MODE_BITS 0xE0u
#define FILTER_BYTES 4u /* SIDH, SIDL, EID8, EID0 */
#define FRAME_BYTES 13u /* SIDH, SIDL, EID8, EID0, DLC, data */

/* A time quantum is 125 ns times `prescaler`; 1 of them and the segments are a bit. */
/* clang-format off */
static const struct rate {
    uint16_t kbaud;
    uint8_t prescaler;
    uint8_t propagation;
    uint8_t phase_1;
    uint8_t phase_2;
} rates[] = {
    {1000,  1, 3, 2, 2},
    { 500,  1, 7, 6, 2},
    { 250,  2, 7, 6, 2},
    { 125,  4, 7, 6, 2},
    { 100,  5, 7, 6, 2},
    {  50, 10, 7, 6, 2},
    {  20, 25, 7, 6, 2},
    {  10, 50, 7, 6, 2},
};
/* clang-format on */

static uint8_t mode; /* that it is to be in */

/* ------------------------------------------------------------ SPI */

static void select_chip(bool on)
{
    REG(on ? SIO_OUT_CLR : SIO_OUT_SET) = 1u << PIN_CS;
}

static uint8_t exchange_byte(uint8_t byte)
{
    while ((REG(SPI0 + SPI_SR) & SPI_TX_ROOM) == 0) {
    }
    REG(SPI0 + SPI_DR) = byte;
    while ((REG(SPI0 + SPI_SR) & SPI_RX_FILLED) == 0) {
    }
    return (uint8_t)REG(SPI0 + SPI_DR);
}

/* An instruction, with bytes out, then bytes in. */
static void send_instruction(const uint8_t *out, size_t n, uint8_t *in, size_t m)
{
    select_chip(true);
    for (size_t i = 0; i < n; i++) {
        (void)exchange_byte(out[i]);
    }
    for (size_t i = 0; i < m; i++) {
        in[i] = exchange_byte(0);
    }
    select_chip(false);
}

static uint8_t read_chip_register(uint8_t at)
{
    uint8_t value;

    send_instruction((const uint8_t[]){READ, at}, 2, &value, 1);
    return value;
}

static void write_chip_register(uint8_t at, uint8_t value)
{
    send_instruction((const uint8_t[]){WRITE, at, value}, 3, NULL, 0);
}

static void clear_bits(uint8_t at, uint8_t bits)
{
    send_instruction((const uint8_t[]){MODIFY, at, bits, 0}, 4, NULL, 0);
}

/* ------------------------------------------------------------ bus */

/* It only wakes the main loop. */
void on_pins(void);
void on_pins(void)
{
    REG(IO_INTR(PIN_INT)) = IO_EDGE_LOW(PIN_INT);
}

void mcp2515_start(void)
{
    board_pin(PIN_SO, BOARD_SPI);
    board_pin(PIN_SCK, BOARD_SPI);
    board_pin(PIN_SI, BOARD_SPI);
    board_pin(PIN_CS, BOARD_SIO);
    board_pin(PIN_INT, BOARD_SIO);
    select_chip(false);
    REG(SIO_OE_SET) = 1u << PIN_CS;
    REG(SPI0 + SPI_CPSR) = SPI_DIVISOR;
    REG(SPI0 + SPI_CR0) = 8u - 1u; /* mode 0 */
    REG(SPI0 + SPI_CR1) = 1u << 1;
    REG_SET(IO_INTE(PIN_INT)) = IO_EDGE_LOW(PIN_INT);
    board_interrupt(IRQ_IO_BANK0, BOARD_WIRE);
}

static bool configuring(void)
{
    return (read_chip_register(CANSTAT) & MODE_BITS) == MODE_CONFIGURATION;
}

static uint8_t put_id(uint8_t *to, uint16_t id, uint8_t extended)
{
    to[0] = (uint8_t)(id >> 3);
    to[1] = (uint8_t)((uint32_t)id << 5 | extended);
    to[2] = 0;
    to[3] = 0;
    return FILTER_BYTES;
}

/* `n` filters or masks, from a register on. */
static void write_ids(uint8_t at, const uint16_t *ids, size_t n, uint8_t extended)
{
    uint8_t bytes[2u + 3u * FILTER_BYTES] = {WRITE, at};
    size_t length = 2;

    for (size_t i = 0; i < n; i++) {
        length += put_id(bytes + length, ids[i], extended);
    }
    send_instruction(bytes, length, NULL, 0);
}

/* In configuration mode. Filters 0 and 1 with mask 0 are the first buffer's, 2 to 5 with mask 1 the
   second one's; those that are left are for 29 bits that begin with eleven recessive ones, which
   CAN does not allow. */
static void write_filters(const struct mcp2515_filters *filters)
{
    const uint16_t first[] = {filters->pattern[0], filters->pattern[1], filters->extra};
    const uint16_t nobody[] = {MCP2515_ID_MAX, MCP2515_ID_MAX, MCP2515_ID_MAX};
    const uint16_t masks[] = {filters->mask, MCP2515_ID_MAX};

    write_ids(RXF0, first, 3, 0);
    write_ids(RXF3, nobody, 3, EXIDE);
    write_ids(RXM0, masks, 2, 0);
    write_chip_register(RXB0CTRL, RX_BOTH);
    write_chip_register(RXB1CTRL, 0);
}

static void set_rate(const struct rate *rate)
{
    /* CNF3, CNF2, CNF1 and CANINTE stand one behind the other. */
    const uint8_t bytes[] = {
        WRITE,
        CNF3,
        (uint8_t)(rate->phase_2 - 1u),
        (uint8_t)(0x80u | (rate->phase_1 - 1u) << 3 | (rate->propagation - 1u)),
        (uint8_t)(rate->prescaler - 1u),
        RX0IF | RX1IF | TX0IF | ERRIF};

    send_instruction(bytes, sizeof bytes, NULL, 0);
    mode = MODE_NORMAL;
    write_chip_register(CANCTRL, mode);
}

bool mcp2515_open(uint16_t kbaud, const struct mcp2515_filters *filters)
{
    send_instruction((const uint8_t[]){RESET}, 1, NULL, 0);
    const dg_ns end = board_now() + DG_MS(1);
    while (board_now() < end) { /* 128 cycles of its oscillator */
    }
    if (!configuring()) {
        return false;
    }
    write_filters(filters);
    mode = MODE_CONFIGURATION;
    for (size_t i = 0; i < DG_COUNT(rates); i++) {
        if (rates[i].kbaud == kbaud) {
            set_rate(&rates[i]);
        }
    }
    return true;
}

bool mcp2515_filter(const struct mcp2515_filters *filters)
{
    write_chip_register(CANCTRL, MODE_CONFIGURATION);
    if (!configuring()) {
        return false;
    }
    write_filters(filters);
    write_chip_register(CANCTRL, mode);
    return true;
}

bool mcp2515_pending(void)
{
    return (REG(SIO_IN) & 1u << PIN_INT) == 0;
}

bool mcp2515_ready(void)
{
    uint8_t status;

    send_instruction((const uint8_t[]){STATUS}, 1, &status, 1);
    return (status & STATUS_TXREQ) == 0;
}

void mcp2515_send(const struct dg_can_frame *frame)
{
    uint8_t bytes[1u + FRAME_BYTES] = {LOAD_TXB0, (uint8_t)(frame->id >> 3),
                                       (uint8_t)(frame->id << 5)};

    bytes[5] = (uint8_t)(frame->dlc | (frame->rtr ? RTR : 0u));
    for (size_t i = 0; i < frame->dlc; i++) {
        bytes[6u + i] = frame->data[i];
    }
    clear_bits(CANINTF, TX0IF);
    send_instruction(bytes, 6u + frame->dlc, NULL, 0);
    send_instruction((const uint8_t[]){SEND_TXB0}, 1, NULL, 0);
}

bool mcp2515_receive(struct dg_can_frame *to)
{
    const uint8_t flags = read_chip_register(CANINTF);
    uint8_t bytes[FRAME_BYTES];

    if ((flags & TX0IF) != 0) { /* only woke us up */
        clear_bits(CANINTF, TX0IF);
    }
    if ((flags & (RX0IF | RX1IF)) == 0) {
        return false;
    }
    /* Reading a buffer clears its flag. The first one is the older one. */
    send_instruction((const uint8_t[]){(flags & RX0IF) != 0 ? READ_RXB0 : READ_RXB1}, 1, bytes,
                     sizeof bytes);
    *to = (struct dg_can_frame){.id = (uint16_t)((uint32_t)bytes[0] << 3 | bytes[1] >> 5),
                                .rtr = (bytes[1] & SRR) != 0,
                                .dlc = bytes[4] & 0x0Fu};
    to->dlc = to->dlc > 8u ? 8u : to->dlc;
    for (size_t i = 0; i < to->dlc && !to->rtr; i++) {
        to->data[i] = bytes[5u + i];
    }
    return (bytes[1] & IDE) == 0;
}

struct mcp2515_errors mcp2515_errors(void)
{
    const uint8_t flags = read_chip_register(EFLG);

    clear_bits(CANINTF, ERRIF);
    if ((flags & RX_OVERRUN) != 0) {
        clear_bits(EFLG, RX_OVERRUN);
    }
    return (struct mcp2515_errors){.off = (flags & TXBO) != 0,
                                   .passive = (flags & (TXEP | RXEP)) != 0,
                                   .overrun = (flags & RX_OVERRUN) != 0};
}

/* SPDX-License-Identifier: MIT */
/*
 * CANopen behind an adapter: UART1 speaks SLCAN at 1 MBd 8N1, pins 8 (out) and 9 (in). There is no
 * bus and so no arbitration and no error state: the encoder and who has the port are alone on it.
 */
#include "board.h"
#include "drehgeber/canopen.h"
#include "drehgeber/cia406.h"
#include "drehgeber/slcan.h"
#include "flash_log.h"
#include "port.h"
#include "rp2040.h"

#define PIN_TX 8u
#define PIN_RX 9u
#define BAUD 1000000u
#define RX_EMPTY (1u << 4)
#define TX_FULL (1u << 5)
#define RX_INTERRUPTS (1u << 4 | 1u << 6)
#define IN_ROOM 512u /* both powers of two */
#define OUT_ROOM 2048u

static volatile uint8_t in[IN_ROOM];
static volatile uint32_t in_head, in_tail;
static uint8_t out[OUT_ROOM];
static uint32_t out_head, out_tail;

static struct dg_slcan adapter;
static uint16_t kbaud; /* of the node */
static dg_ns due;

const bool flash_log_behind = false;

static struct dg_co_node *slcan_node(void)
{
    struct dg_cia406_device *device = port_device;

    return &device->node;
}

void on_uart1(void);
void on_uart1(void)
{
    while (!(REG(UART1 + UART_FR) & RX_EMPTY)) {
        const uint8_t byte = (uint8_t)REG(UART1 + UART_DR);
        if (in_head - in_tail < IN_ROOM) {
            in[in_head % IN_ROOM] = byte;
            in_head = in_head + 1u;
        }
    }
}

/* ------------------------------------------------------------ out */

static void send_some(void)
{
    while (out_tail != out_head && !(REG(UART1 + UART_FR) & TX_FULL)) {
        REG(UART1 + UART_DR) = out[out_tail % OUT_ROOM];
        out_tail++;
    }
}

static void send_text(const char *text, size_t n)
{
    while (OUT_ROOM - (out_head - out_tail) < n) { /* nothing is lost: the encoder waits */
        send_some();
    }
    for (size_t i = 0; i < n; i++) {
        out[out_head++ % OUT_ROOM] = (uint8_t)text[i];
    }
}

/* A channel at another bit rate hears nothing, and is not heard. */
static bool open_here(void)
{
    return adapter.state != DG_SLCAN_CLOSED && (adapter.kbaud == 0 || adapter.kbaud == kbaud);
}

static void send_frame(void *ctx, const struct dg_can_frame *frame)
{
    char text[DG_SLCAN_TEXT_MAX + 1u];

    (void)ctx;
    if (open_here()) {
        const size_t n = dg_slcan_print(&adapter, frame, board_now() / DG_MS(1), text);
        send_text(text, n);
    }
}

static void set_bit_rate(void *ctx, uint16_t rate)
{
    (void)ctx;
    kbaud = rate;
}

static const struct dg_co_ops ops = {.send = send_frame, .bit_rate = set_bit_rate};
const void *const port_ops = &ops;
const char *const port_name = "slcan:8,9";

/* ------------------------------------------------------------ in */

static void take_byte(uint8_t byte)
{
    struct dg_slcan_event event;
    size_t n = 0;

    if (!dg_slcan_feed(&adapter, byte, &event)) {
        return;
    }
    while (event.reply[n] != '\0') {
        n++;
    }
    send_text(event.reply, n);
    if (event.has_frame && open_here()) {
        due = dg_co_rx(slcan_node(), board_now(), &event.frame);
    }
}

dg_ns port_loop(void)
{
    if (in_tail != in_head) {
        take_byte(in[in_tail % IN_ROOM]);
        in_tail = in_tail + 1u;
    }
    if (due <= board_now()) {
        due = dg_co_step(slcan_node(), board_now());
    }
    send_some();
    return in_tail != in_head || out_tail != out_head ? 0 : due;
}

/* ------------------------------------------------------------ port */

void port_start(void)
{
    const uint32_t divisor = (BOARD_HZ * 4u + BAUD / 2u) / BAUD;

    board_pin(PIN_TX, BOARD_UART);
    board_pin(PIN_RX, BOARD_UART);
    REG(UART1 + UART_IBRD) = divisor >> 6;
    REG(UART1 + UART_FBRD) = divisor & 63u;
    REG(UART1 + UART_LCR_H) = 3u << 5 | 1u << 4;
    REG(UART1 + UART_IMSC) = RX_INTERRUPTS;
    REG(UART1 + UART_CR) = 1u << 9 | 1u << 8 | 1u << 0;
    board_interrupt(IRQ_UART1, BOARD_WIRE);
}

void port_changed(void)
{
    due = 0;
}

void port_stores(void)
{
}

/* A sector takes as long as a heartbeat may be late. */
bool port_idle(void)
{
    return adapter.state == DG_SLCAN_CLOSED;
}

bool port_pause(void)
{
    return false;
}

void port_hold(void)
{
}

void port_release(void)
{
}

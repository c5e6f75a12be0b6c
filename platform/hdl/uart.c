/* SPDX-License-Identifier: MIT */
/*
 * RS485 bit by bit, with the data rate and parity that the encoder has at the moment:
 *
 *   RX  ¯¯|_|D0|D1| ... |D7|P|¯¯
 *          0 1  2        8  9 10
 *   TX  ¯¯|_|D0|D1| ... |D7|P|¯|_|D0| ... |P|¯¯
 *   DE  __|¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯¯|__
 *
 * RX is sampled in the middle of each bit. If a start bit is high there, it was none. The character
 * is reported at the end of its stop bit, or at the edge of the next start bit if that comes first.
 * DE is high from the first start bit to the end of the last stop bit.
 *
 * A character whose parity is wrong, or whose stop bit is low, is told as damaged. After a low stop
 * bit the line has to be high before there is another start bit.
 */
#include "hdl_private.h"

#define PS_PER_S INT64_C(1000000000000)
#define DATA_BITS 8u
#define IDLE DG_HDL_TX

/* `n` bits and `halves` halves of one. */
static int64_t bits_ps(const struct hdl_uart *self, uint32_t n, uint32_t halves)
{
    return (int64_t)(2u * n + halves) * PS_PER_S / (2 * (int64_t)self->baud);
}

/* Behind start bit and data: a parity bit or none. */
static uint32_t stop_bit(const struct hdl_uart *self)
{
    return 1u + DATA_BITS + (self->parity != 'N' ? 1u : 0u);
}

static bool configure_uart(struct dg_hdl *self)
{
    struct dg_host_uart uart;

    if (dg_host_uart(self->host, &uart) != DG_HOST_OK) {
        return false;
    }
    self->uart.baud = uart.baud;
    self->uart.parity = uart.parity;
    return true;
}

static bool is_odd(uint32_t bits)
{
    bits ^= bits >> 4;
    bits ^= bits >> 2;
    return ((bits ^ bits >> 1) & 1u) != 0;
}

/* --- what the master sends --- */

static void report_character(struct dg_hdl *self, uint16_t flags)
{
    struct dg_host_event event = {.at = (uint64_t)(self->now / HDL_PS_PER_NS),
                                  .flags = flags,
                                  .kind = DG_HOST_BYTES,
                                  .length = (flags & DG_HOST_START) != 0 ? 0 : 1,
                                  .data = {(uint8_t)(self->uart.taken >> 1)}};

    /* It is taken at once, so that there is always room. */
    (void)dg_host_send(self->host, &event);
    (void)dg_host_step(self->host, event.at);
}

static bool damaged(const struct hdl_uart *self)
{
    const uint32_t data = self->taken >> 1 & 0xFFu;
    const bool parity = (self->taken >> (1u + DATA_BITS) & 1u) != 0;
    const bool stop = (self->taken >> stop_bit(self) & 1u) != 0;

    return !stop || (self->parity == 'E' && is_odd(data) != parity) ||
           (self->parity == 'O' && is_odd(data) == parity);
}

static void end_character(struct dg_hdl *self)
{
    struct hdl_uart *uart = &self->uart;
    const uint16_t flags = damaged(uart) ? DG_HOST_ENDED | DG_HOST_DAMAGED : DG_HOST_ENDED;

    uart->receives = false;
    uart->due = HDL_NEVER;
    report_character(self, flags);
}

static void start_character(struct dg_hdl *self, int64_t now)
{
    struct hdl_uart *uart = &self->uart;

    if (!configure_uart(self)) {
        return;
    }
    uart->receives = true;
    uart->began = now;
    uart->bit = 0;
    uart->taken = 0;
    uart->due = now + bits_ps(uart, 0, 1);
    report_character(self, DG_HOST_START);
}

static void take_level(struct dg_hdl *self, int64_t now, int levels)
{
    struct hdl_uart *uart = &self->uart;
    const bool high = (levels & DG_HDL_RX) != 0;

    uart->high = high;
    if (!high && uart->receives && uart->bit > stop_bit(uart)) {
        end_character(self);
    }
    if (!high && !uart->receives) {
        start_character(self, now);
    }
}

/* The middle of a bit, or the end of the character. */
static void sample_bit(struct dg_hdl *self)
{
    struct hdl_uart *uart = &self->uart;

    if (uart->bit > stop_bit(uart)) {
        end_character(self);
        return;
    }
    if (uart->bit == 0 && uart->high) {
        uart->receives = false;
        uart->due = HDL_NEVER;
        return;
    }
    uart->taken |= (uart->high ? 1u : 0u) << uart->bit;
    uart->bit++;
    const bool all = uart->bit > stop_bit(uart);
    uart->due = uart->began + bits_ps(uart, uart->bit, all ? 0 : 1);
}

/* --- what the encoder sends --- */

static int64_t put_character(struct dg_hdl *self, int64_t at, uint32_t byte)
{
    const struct hdl_uart *uart = &self->uart;
    const uint32_t parity = (is_odd(byte) != (uart->parity == 'O') ? 1u : 0u) << (1u + DATA_BITS);
    const uint32_t stop = 1u << stop_bit(uart);
    const uint32_t bits = byte << 1 | (uart->parity != 'N' ? parity : 0) | stop;

    for (uint32_t i = 0; i <= stop_bit(uart); i++) {
        const int level = (bits >> i & 1u) != 0 ? DG_HDL_TX : 0;
        hdl_put(self, at + bits_ps(uart, i, 0), level | DG_HDL_DRIVER);
    }
    return at + bits_ps(uart, stop_bit(uart) + 1u, 0);
}

/* A run goes on where the one before ended, whose driver stays on. */
static void heard_bytes(struct dg_hdl *self, const struct dg_host_event *event)
{
    struct hdl_uart *uart = &self->uart;
    int64_t at = (int64_t)event->at * HDL_PS_PER_NS;

    if (!configure_uart(self)) {
        return;
    }
    if (uart->release != HDL_NEVER && at < uart->release + bits_ps(uart, 0, 1)) {
        at = uart->release;
    }
    for (uint8_t i = 0; i < event->length; i++) {
        at = put_character(self, at, event->data[i]);
    }
    uart->release = at;
}

/* --- time --- */

static int64_t due(const struct dg_hdl *self)
{
    return self->uart.due < self->uart.release ? self->uart.due : self->uart.release;
}

static void run(struct dg_hdl *self, int64_t now)
{
    struct hdl_uart *uart = &self->uart;

    if (uart->release <= now) {
        uart->release = HDL_NEVER;
        hdl_put(self, now, IDLE);
    }
    if (uart->due <= now) {
        sample_bit(self);
    }
}

static void reset(struct dg_hdl *self)
{
    self->uart = (struct hdl_uart){.due = HDL_NEVER, .release = HDL_NEVER, .high = true};
}

const struct hdl_wire_ops hdl_serial = {
    .idle_in = DG_HDL_RX,
    .idle_out = IDLE,
    .reset = reset,
    .take = take_level,
    .due = due,
    .run = run,
    .heard = heard_bytes,
};

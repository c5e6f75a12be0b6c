/* SPDX-License-Identifier: MIT */
/*
 * CANopen on a bus: an MCP2515 does the bits, arbitration and error states.
 */
#include "board.h"
#include "drehgeber/canopen.h"
#include "drehgeber/cia406.h"
#include "flash_log.h"
#include "mcp2515.h"
#include "port.h"

#define OUT_MAX 64u /* a power of two */
/* An error state may end without an interrupt. */
#define LOOK_NS DG_MS(10)

static struct dg_can_frame out[OUT_MAX];
static uint32_t out_head, out_tail;
static uint16_t kbaud, opened; /* of the node, of the controller */
static enum dg_co_bus_event state;
static dg_ns due, look;

const bool flash_log_behind = false;

static struct dg_co_node *node(void)
{
    struct dg_cia406_device *device = port_device;

    return &device->node;
}

/* What does not fit is lost, as on a bus that nobody is on. */
static void send(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    if (out_head - out_tail < OUT_MAX) {
        out[out_head++ % OUT_MAX] = *frame;
    }
}

static void set_bit_rate(void *ctx, uint16_t rate)
{
    (void)ctx;
    kbaud = rate;
}

static const struct dg_co_ops ops = {.send = send, .bit_rate = set_bit_rate};
const void *const port_ops = &ops;
const char *const port_name = "mcp2515:16-20";

static void tell(enum dg_co_bus_event event)
{
    due = dg_co_bus(node(), board_now(), event);
}

/* A bus that was off is active again before it is anything else. */
static void look_at_errors(void)
{
    const struct mcp2515_errors errors = mcp2515_errors();
    const enum dg_co_bus_event passive = errors.passive ? DG_CO_BUS_PASSIVE : DG_CO_BUS_ACTIVE;
    enum dg_co_bus_event now = errors.off ? DG_CO_BUS_OFF : passive;

    if (errors.overrun) {
        tell(DG_CO_BUS_OVERRUN);
    }
    if (state == DG_CO_BUS_OFF && now == DG_CO_BUS_PASSIVE) {
        now = DG_CO_BUS_ACTIVE;
    }
    if (now != state) {
        state = now;
        tell(now);
    }
}

static void receive(void)
{
    struct dg_can_frame frame;

    if (mcp2515_receive(&frame)) {
        due = dg_co_rx(node(), board_now(), &frame);
    }
}

static void follow_rate(void)
{
    if (kbaud != opened) {
        opened = kbaud;
        (void)mcp2515_open(kbaud);
    }
}

dg_ns port_loop(void)
{
    const dg_ns now = board_now();
    const bool pending = mcp2515_pending();

    if (pending) {
        receive();
    }
    if (pending || look <= now) {
        look = now + LOOK_NS;
        look_at_errors();
    }
    if (due <= now) {
        due = dg_co_step(node(), now);
    }
    if (out_tail != out_head && mcp2515_ready()) {
        mcp2515_send(&out[out_tail % OUT_MAX]);
        out_tail++;
    }
    follow_rate();
    return mcp2515_pending() ? now : dg_earliest(due, out_tail != out_head ? now : look);
}

void port_start(void)
{
    mcp2515_start();
    follow_rate();
}

void port_changed(void)
{
    due = 0;
}

void port_stores(void)
{
}

/* Frames would be lost meanwhile. */
bool port_idle(void)
{
    return node()->state == DG_CO_OFF;
}

void port_hold(void)
{
}

void port_release(void)
{
}

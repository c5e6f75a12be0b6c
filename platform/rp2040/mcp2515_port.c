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
static struct mcp2515_filters filters; /* that the controller has, or is to have */
static uint8_t filter_version;         /* of the node, that they are for */
static bool filters_due;

const bool flash_log_behind = false;

static struct dg_co_node *port_node(void)
{
    struct dg_cia406_device *device = port_device;

    return &device->node;
}

/* What does not fit is lost, as on a bus that nobody is on. */
static void send_frame(void *ctx, const struct dg_can_frame *frame)
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

static const struct dg_co_ops ops = {.send = send_frame, .bit_rate = set_bit_rate};
const void *const port_ops = &ops;
const char *const port_name = "mcp2515:16-20";

static void report_event(enum dg_co_bus_event event)
{
    due = dg_co_bus(port_node(), board_now(), event);
}

/* A bus that was off is active again before it is anything else. */
static void look_at_errors(void)
{
    const struct mcp2515_errors errors = mcp2515_errors();
    const enum dg_co_bus_event passive = errors.passive ? DG_CO_BUS_PASSIVE : DG_CO_BUS_ACTIVE;
    enum dg_co_bus_event now = errors.off ? DG_CO_BUS_OFF : passive;

    if (errors.overrun) {
        report_event(DG_CO_BUS_OVERRUN);
    }
    if (state == DG_CO_BUS_OFF && now == DG_CO_BUS_PASSIVE) {
        now = DG_CO_BUS_ACTIVE;
    }
    if (now != state) {
        state = now;
        report_event(now);
    }
}

static void receive_frames(void)
{
    struct dg_can_frame frame;

    if (mcp2515_receive(&frame)) {
        due = dg_co_rx(port_node(), board_now(), &frame);
    }
}

/* ------------------------------------------------------------ filters */

/* LSS has an identifier of its own, which would cost the mask all bits that it does not share with
   the others; nobody minds when one of its frames is early. */
#define LSS 0x7E5u

static unsigned bits_in(uint32_t word)
{
    unsigned n = 0;

    for (; word != 0; word &= word - 1u) {
        n++;
    }
    return n;
}

/* The identifiers in two groups, by one bit of theirs: what is the same in each group can be asked
   for. */
static struct mcp2515_filters split_filters(const uint16_t *ids, uint8_t n, unsigned bit)
{
    struct mcp2515_filters to = {.mask = MCP2515_ID_MAX, .extra = LSS};
    bool there[2] = {false, false};

    for (uint8_t i = 0; i < n; i++) {
        const unsigned group = (unsigned)ids[i] >> bit & 1u;
        if (ids[i] == LSS) {
            continue;
        }
        if (there[group]) {
            to.mask &= (uint16_t) ~(ids[i] ^ to.pattern[group]);
        } else {
            there[group] = true;
            to.pattern[group] = ids[i];
        }
    }
    for (unsigned group = 0; group < 2u; group++) {
        to.pattern[group] = to.pattern[there[group] ? group : 1u - group];
    }
    return to;
}

/* Whatever two patterns can be: a bit that tells them apart splits them. */
static struct mcp2515_filters fit_filters(const uint16_t *ids, uint8_t n)
{
    struct mcp2515_filters best = {.mask = 0};
    unsigned most = 0;

    for (unsigned bit = 0; bit < 11u; bit++) {
        const struct mcp2515_filters candidate = split_filters(ids, n, bit);
        if (bits_in(candidate.mask) > most) {
            most = bits_in(candidate.mask);
            best = candidate;
        }
    }
    best.extra = LSS;
    return best;
}

static bool lets_in(const struct mcp2515_filters *by, uint16_t id)
{
    return id == by->extra || ((id ^ by->pattern[0]) & by->mask) == 0 ||
           ((id ^ by->pattern[1]) & by->mask) == 0;
}

static bool lets_all_in(const struct mcp2515_filters *by, const uint16_t *ids, uint8_t n)
{
    for (uint8_t i = 0; i < n; i++) {
        if (!lets_in(by, ids[i])) {
            return false;
        }
    }
    return true;
}

/* It costs the controller some time off the bus to let others in, and none to hear too much. */
static void follow_filters(void)
{
    uint16_t ids[DG_CO_FILTERS_MAX];

    if (port_node()->filter_version != filter_version) {
        filter_version = port_node()->filter_version;
        const uint8_t n = dg_co_filters(port_node(), ids);
        filters_due = filters_due || !lets_all_in(&filters, ids, n);
        filters = filters_due ? fit_filters(ids, n) : filters;
    }
    filters_due = filters_due && !mcp2515_filter(&filters);
}

static void follow_rate(void)
{
    uint16_t ids[DG_CO_FILTERS_MAX];

    if (kbaud != opened) {
        opened = kbaud;
        filter_version = port_node()->filter_version;
        filters = fit_filters(ids, dg_co_filters(port_node(), ids));
        filters_due = false;
        (void)mcp2515_open(kbaud, &filters);
    }
}

/* ------------------------------------------------------------ port */

dg_ns port_loop(void)
{
    const dg_ns now = board_now();
    const bool pending = mcp2515_pending();

    if (pending) {
        receive_frames();
    }
    if (pending || look <= now) {
        look = now + LOOK_NS;
        look_at_errors();
    }
    if (due <= now) {
        due = dg_co_step(port_node(), now);
    }
    follow_rate();
    follow_filters();
    /* A master may answer at once to what is sent. */
    if (out_tail != out_head && !filters_due && mcp2515_ready()) {
        mcp2515_send(&out[out_tail % OUT_MAX]);
        out_tail++;
    }
    const bool more = mcp2515_pending() || out_tail != out_head || filters_due;
    return more ? now : dg_earliest(due, look);
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
    return port_node()->state == DG_CO_OFF;
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

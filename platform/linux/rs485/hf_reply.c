/* SPDX-License-Identifier: MIT */
/*
 * A reply of an encoder, from the core to its last stop bit:
 *
 *   send_reply --[the disk is not through]--> held --> start_reply --[faults]--> own line
 *                                                                                   |
 *   pump (hf_line.c) --> lx_hf_reply_go_on --> emit: with what others send, into the port
 */
#include <string.h>

#include "drehgeber/instruments.h"
#include "hf_line.h"

#define BITS_PER_CHARACTER 8u

_Static_assert(DG_HF_FRAME_MAX <= LX_REPLY_MAX, "a reply fits the line");

/* How a reply gets out. */
enum pace {
    PACE_TIMER, /* a character at a time, each at the end of its stop bit */
    PACE_UART,  /* at once, a UART does the timing */
    PACE_NONE,  /* at once, and it takes no time */
};

static enum pace pace_of(const struct lx_hf_drop *self)
{
    if (self->all->port->timed) {
        return PACE_UART;
    }
    return self->settings.pace ? PACE_TIMER : PACE_NONE;
}

/* Also before its start, when it is late (fault). */
static bool has_reply(const struct lx_hf_drop *self, dg_ns now)
{
    return pace_of(self) != PACE_NONE && lx_line_busy(&self->line, now);
}

bool lx_hf_sends(const struct lx_hf_drop *self, dg_ns now)
{
    return has_reply(self, now) && now > self->line.start;
}

bool lx_hf_is_busy(const struct lx_hf_drop *self, dg_ns now)
{
    return self->held.length > 0 || has_reply(self, now);
}

/* --- begin --- */

static void send_damaged(struct lx_hf_drop *self, dg_ns now, const uint8_t *bytes, size_t n)
{
    struct dg_faults *faults = lx_hf_faults(self);
    uint8_t copy[DG_HF_FRAME_MAX];
    if (dg_fault_wire_takes(faults, DG_WIRE_DROP)) {
        return;
    }
    if (dg_fault_wire_takes(faults, DG_WIRE_DELAY)) {
        now += (dg_ns)dg_fault_wire_value(&dg_hf_instrument, DG_WIRE_DELAY);
    }
    memcpy(copy, bytes, n);
    if (dg_fault_wire_takes(faults, DG_WIRE_DAMAGE)) {
        const uint32_t bit = dg_fault_pick(faults, (uint32_t)n * BITS_PER_CHARACTER);
        self->flipped = (int)(bit / BITS_PER_CHARACTER);
        copy[self->flipped] ^= (uint8_t)(1u << bit % BITS_PER_CHARACTER);
    }
    self->again = dg_fault_wire_takes(faults, DG_WIRE_DUPLICATE);
    lx_line_start(&self->line, now, copy, n);
}

static void start_reply(struct lx_hf_drop *self, const uint8_t *bytes, size_t n)
{
    self->begun = false;
    self->again = false;
    self->merged = false;
    self->flipped = -1;
    if (lx_hf_faults(self)->wire != 0) {
        send_damaged(self, lx_now(), bytes, n);
        return;
    }
    lx_line_start(&self->line, lx_now(), bytes, n);
}

/* Called inside dg_hf_step(), which may run late: the reply starts when it really does. What the
   others hear of it waits until this call is over. */
static void send_reply(void *ctx, const uint8_t *bytes, size_t n)
{
    struct lx_hf_drop *self = ctx;
    const enum lx_nvm_answer what = lx_nvm_queue_answer(&self->image.queue);
    if (what == LX_NVM_SAY) {
        start_reply(self, bytes, n);
    } else if (what == LX_NVM_KEEP) {
        memcpy(self->held.bytes, bytes, n);
        self->held.length = n;
    }
}

/* What is lost is not acknowledged. */
void lx_hf_on_settled(void *ctx, dg_ns now)
{
    struct lx_hf_drop *self = ctx;
    const size_t n = self->held.length;
    const enum lx_nvm_answer what = n == 0 ? LX_NVM_KEEP : lx_nvm_queue_answer(&self->image.queue);
    (void)now;
    if (what == LX_NVM_KEEP) {
        return;
    }
    self->held.length = 0;
    if (what == LX_NVM_SAY) {
        start_reply(self, self->held.bytes, n);
        lx_hf_settle(self->all);
    }
}

const struct dg_hf_ops lx_hf_device_ops = {.tx = send_reply};

/* --- go on --- */

/* `character` of `from` with what others send at the same time. */
static void merge(struct lx_hf_drop *from, dg_ns at, struct lx_character *character, bool swallow)
{
    struct lx_hf_bus *self = from->all;
    for (size_t i = 0; i < self->count; i++) {
        struct lx_hf_drop *other = &self->drop[i];
        uint8_t byte = 0;
        if (other != from && lx_line_on(&other->line, at, &byte)) {
            character->byte &= byte;
            character->damaged = true;
            other->merged = other->merged || swallow;
        }
    }
}

/* A character of a reply: into the port unless it is there already, and to everybody else. */
static void emit(struct lx_hf_drop *self, dg_ns at, uint8_t byte, size_t index)
{
    struct lx_character character = {.byte = byte};
    if (self->merged) {
        self->merged = false;
        return;
    }
    if (self->flipped == (int)index) {
        character.damaged = true;
    }
    merge(self, at, &character, true);
    if (pace_of(self) != PACE_UART) {
        self->all->port->sends =
            self->settings.any_line ? (struct lx_uart){LX_BAUD_ANY, 0} : lx_hf_uart(&self->uart);
        lx_serial_put(self->all->port, &character.byte, 1);
    }
    lx_hf_spread(self, at, &character);
}

/* The whole reply into a UART. What is sent at the same time is there already: the later reply
   follows it, damaged. */
static void fill_uart(struct lx_hf_drop *self)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    for (size_t i = 0; i < self->line.length; i++) {
        struct lx_character character = {.byte = self->line.bytes[i]};
        merge(self, self->line.start, &character, false);
        bytes[i] = character.byte;
    }
    lx_serial_put(self->all->port, bytes, self->line.length);
}

static void begin_at_once(struct lx_hf_drop *self)
{
    const dg_ns at = self->line.start;
    const uint8_t *bytes = NULL;
    self->begun = true;
    if (pace_of(self) == PACE_UART) {
        fill_uart(self);
        return;
    }
    const size_t n = lx_line_take_all(&self->line, &bytes);
    for (size_t i = 0; i < n; i++) {
        emit(self, at, bytes[i], i);
    }
}

dg_ns lx_hf_reply_next(const struct lx_hf_drop *self)
{
    const bool waits = !self->begun && self->line.sent < self->line.length;
    return waits && pace_of(self) != PACE_TIMER ? self->line.start : lx_line_next(&self->line);
}

void lx_hf_reply_go_on(struct lx_hf_drop *self, dg_ns at)
{
    if (!self->begun && pace_of(self) != PACE_TIMER) {
        begin_at_once(self);
    } else {
        const uint8_t *byte = NULL;
        const size_t index = self->line.sent;
        if (lx_line_take(&self->line, at, &byte) > 0) {
            emit(self, at, *byte, index);
        }
    }
    if (self->again && self->line.sent == self->line.length) {
        self->again = false;
        self->begun = false;
        lx_line_repeat(&self->line);
    }
}

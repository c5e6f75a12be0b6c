/* SPDX-License-Identifier: MIT */
/*
 * An RS485 line with 1..32 encoders. The core says what is next, this file makes it happen:
 *
 *   serial -- on_character --> listen() --> dg_hf_rx() --\
 *                                 ^                       > next deadline, UART setting
 *   timer --- on_time ---> pump() -+----> dg_hf_step() --/
 *                            ^                  \-- send_reply --> own line
 *                            \-------------------------------------/
 *
 * Every encoder has a transmitter of its own, and hears the master and all the others, each
 * character at the end of its stop bit. Two at once: the characters overlap and the line carries
 * their AND (a 0 is driven against an idle 1), once, when the first of them is over; the one that
 * is over later is lost in it.
 */
#include "hf_line.h"

#include <ctype.h>
#include <stdio.h>

bool lx_hf_powered(const struct lx_hf_drop *self)
{
    return self->device.line != DG_HF_OFF;
}

/* --- the line --- */

/* Whether a character with this setting arrives as what it is; a parity of 0 fits. */
static bool fits(const struct lx_hf_drop *self, uint32_t baud, char parity)
{
    return self->settings.any_line || baud == LX_BAUD_ANY ||
           (baud == self->uart.baud && (parity == 0 || parity == self->uart.parity));
}

static void tell(struct lx_hf_bus *self, dg_ns at, bool ours, const struct lx_uart *uart,
                 const struct lx_character *character)
{
    const struct dg_tap_event event = {
        .at = at,
        .kind = DG_TAP_CHARACTER,
        .ours = ours,
        .character = {uart->baud, uart->parity, character->byte, character->damaged},
    };
    self->told = at;
    lx_tap_tell(&self->bus.tap, &event);
}

void lx_hf_follow(struct lx_hf_drop *self, dg_ns deadline)
{
    struct lx_hf_bus *all = self->all;
    self->deadline = deadline;
    const struct dg_hf_uart uart = dg_hf_uart(&self->device);
    if (uart.baud == self->uart.baud && uart.parity == self->uart.parity) {
        return;
    }
    self->uart = uart;
    const struct lx_uart line = lx_hf_uart(&uart);
    lx_line_set(&self->line, &line);
    if (self == all->drop) { /* a UART has one setting: the first encoder's */
        lx_serial_set(all->port, &line);
    }
}

static void step(struct lx_hf_drop *self, dg_ns now)
{
    lx_bus_serve(&self->all->bus, self->deadline, now);
    lx_hf_follow(self, dg_hf_step(&self->device, now));
}

static void hear(struct lx_hf_drop *self, dg_ns at, const struct lx_character *character)
{
    const uint8_t flags = character->damaged ? DG_HF_RX_DAMAGED : DG_HF_RX_OK;
    lx_bus_serve(&self->all->bus, self->deadline, at);
    lx_hf_follow(self, dg_hf_rx(&self->device, at, character->byte, flags));
}

/* Whether the master's character is kept from the encoder. Decided at the first one of a request
   for it; what is for others it would not take anyway. */
static bool deafened(struct lx_hf_drop *self, dg_ns now, uint8_t byte)
{
    struct dg_faults *faults = lx_hf_faults(self);
    if (faults->wire == 0 && !self->deaf) {
        return false;
    }
    const dg_ns silence = dg_bit_times_ns(self->uart.timeout_bits, self->uart.baud);
    if (self->all->heard == 0 || dg_elapsed(now, self->all->heard) > silence) {
        const bool mine = byte == self->device.address || byte == DG_HF_ADDRESS_BROADCAST;
        self->deaf = mine && dg_fault_wire_takes(faults, DG_WIRE_DEAF);
    }
    return self->deaf;
}

void lx_hf_spread(struct lx_hf_drop *from, dg_ns at, const struct lx_character *character)
{
    struct lx_hf_bus *self = from->all;
    self->heard = 0;
    if (lx_tap_on(&self->bus.tap)) {
        const struct lx_uart uart = lx_hf_uart(&from->uart);
        tell(self, at, true, &uart, character);
    }
    for (size_t i = 0; i < self->count; i++) {
        struct lx_hf_drop *to = &self->drop[i];
        if (to == from || lx_hf_is_busy(to, at)) {
            continue;
        }
        struct lx_character heard = *character;
        if (!fits(to, from->uart.baud, from->uart.parity)) {
            heard.damaged = true;
        }
        hear(to, at, &heard);
    }
}

static void arrive(struct lx_hf_bus *self, const struct lx_coming *coming);

/* All that has gone over the line by `now`, in the order of time. */
static void pump(struct lx_hf_bus *self, dg_ns now)
{
    for (;;) {
        struct lx_hf_drop *first = self->drop;
        for (size_t i = 1; i < self->count; i++) {
            if (lx_hf_reply_next(&self->drop[i]) < lx_hf_reply_next(first)) {
                first = &self->drop[i];
            }
        }
        const dg_ns coming = lx_intake_next(&self->intake);
        const dg_ns at = dg_earliest(coming, lx_hf_reply_next(first));
        if (at > now || at == DG_NEVER) {
            return;
        }
        if (coming <= at) {
            const struct lx_coming character = lx_intake_take(&self->intake);
            arrive(self, &character);
        } else {
            lx_hf_reply_go_on(first, at);
        }
    }
}

void lx_hf_settle(struct lx_hf_bus *self)
{
    const dg_ns now = lx_now();
    pump(self, now);
    /* The last character is early enough, as each one tells when it ended; not for those who look
       at the line as it goes. */
    const bool watched = lx_tap_on(&self->bus.tap);
    dg_ns next = watched ? lx_intake_next(&self->intake) : lx_intake_last(&self->intake);
    next = dg_earliest(next, lx_hf_sample(self, now));
    for (size_t i = 0; i < self->count; i++) {
        next = dg_earliest(next,
                           dg_earliest(self->drop[i].deadline, lx_hf_reply_next(&self->drop[i])));
    }
    lx_timer_at(&self->timer, next);
}

void lx_hf_on_time(void *ctx, dg_ns now)
{
    struct lx_hf_bus *self = ctx;
    pump(self, now);
    for (size_t i = 0; i < self->count; i++) {
        if (self->drop[i].deadline <= now) {
            step(&self->drop[i], now);
        }
    }
    lx_hf_settle(self);
}

/* --- in --- */

/* Once per episode, which setting would be right. */
static void tell_mismatch(struct lx_hf_bus *self, const struct lx_hf_drop *first)
{
    const uint32_t baud = self->port->baud;
    const char parity = self->port->parity;
    struct lx_words speed = {"another speed"};
    if (baud != 0 && baud != LX_BAUD_ANY) {
        (void)snprintf(speed.text, sizeof speed.text, "%lu Bd", (unsigned long)baud);
    }
    if (parity != 0 && isalpha((unsigned char)parity) != 0) {
        lx_words_add(&speed, " 8%c1", parity);
    } else if (parity != 0) {
        lx_words_add(&speed, " without 8 data bits");
    }
    lx_note(self->bus.setup.say,
            "the master talks at %s, the encoder expects %lu Bd 8%c1; line=any takes any "
            "data rate",
            speed.text, (unsigned long)first->uart.baud, first->uart.parity);
}

/* Said when nobody on the line can read the master. */
static void check_speed(struct lx_hf_bus *self)
{
    const struct lx_hf_drop *first = NULL;
    for (size_t i = 0; i < self->count; i++) {
        const struct lx_hf_drop *drop = &self->drop[i];
        if (lx_hf_powered(drop) && fits(drop, self->port->baud, self->port->parity)) {
            self->mismatch = false;
            return;
        }
        first = first == NULL && lx_hf_powered(drop) ? drop : first;
    }
    if (first != NULL && !self->mismatch) {
        self->mismatch = true;
        tell_mismatch(self, first);
    }
}

static bool anybody_sends(const struct lx_hf_bus *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        if (lx_hf_sends(&self->drop[i], now)) {
            return true;
        }
    }
    return false;
}

/* A character of the master, as one encoder hears it. One that sends does not hear. */
static void listen(struct lx_hf_drop *self, const struct lx_coming *coming)
{
    struct lx_character heard = coming->character;
    if (!lx_hf_powered(self) || lx_hf_is_busy(self, coming->end) ||
        deafened(self, coming->end, heard.byte)) {
        return;
    }
    if (!fits(self, coming->baud, coming->parity)) {
        heard.damaged = true;
    }
    hear(self, coming->end, &heard);
}

/* What the master sends at, as far as it is known; else what the port is set to. */
static struct lx_uart uart_of(const struct lx_hf_bus *self, uint32_t baud, char parity)
{
    struct lx_uart uart = self->port->uart;
    if (baud != LX_BAUD_ANY && baud != 0) {
        uart.baud = baud;
    }
    if (parity == 'N' || parity == 'E' || parity == 'O') {
        uart.parity = parity;
    }
    return uart;
}

/* A character of the master is over. */
static void arrive(struct lx_hf_bus *self, const struct lx_coming *coming)
{
    struct lx_coming heard = *coming;
    if (self->paced && lx_tap_on(&self->bus.tap)) {
        const struct lx_uart uart = uart_of(self, coming->baud, coming->parity);
        tell(self, coming->end, false, &uart, &coming->character);
    }
    if (anybody_sends(self, coming->end)) {
        self->collided++;
        heard.character.damaged = true;
    }
    for (size_t i = 0; i < self->count; i++) {
        listen(&self->drop[i], &heard);
    }
    self->heard = coming->end;
}

/* A character begins on a line that was idle: whose frame goes on must not take it for over. */
static void begin(struct lx_hf_bus *self, dg_ns now)
{
    for (size_t i = 0; i < self->count; i++) {
        struct lx_hf_drop *drop = &self->drop[i];
        if (lx_hf_powered(drop) && !lx_hf_is_busy(drop, now) && !drop->deaf) {
            lx_bus_serve(&self->bus, drop->deadline, now);
            lx_hf_follow(drop, dg_hf_rx(&drop->device, now, 0, DG_HF_RX_START));
        }
    }
}

static dg_ns duration_of(const struct lx_uart *uart)
{
    return dg_bit_times_ns(lx_character_bits(uart->parity), uart->baud);
}

/* A master on a pty hands over a request at once: to the tap it is as if the last character had
   ended now, and the others before it, as far as that is after what was told before. */
static void tell_received(struct lx_hf_bus *self, dg_ns now, const struct lx_character *character)
{
    const struct lx_uart uart = uart_of(self, self->port->baud, self->port->parity);
    const dg_ns each = duration_of(&uart);
    const dg_ns spread_at = dg_elapsed(now, each * self->port->more);
    const dg_ns earliest = self->told + each;
    dg_ns at = spread_at > earliest ? spread_at : earliest;
    at = at < now ? at : now;
    tell(self, at > self->told ? at : self->told, false, &uart, character);
}

/* A character that a pty hands over begins now, or behind those that are on the line. */
static void take_in(struct lx_hf_bus *self, dg_ns now, const struct lx_coming *coming)
{
    const struct lx_uart uart = uart_of(self, coming->baud, coming->parity);
    if (self->intake.end < now && self->intake.count == 0) {
        begin(self, now);
    }
    if (!lx_intake_put(&self->intake, now, duration_of(&uart), coming)) {
        self->overrun++;
    }
}

void lx_hf_on_character(void *ctx, dg_ns now, const struct lx_character *character)
{
    struct lx_hf_bus *self = ctx;
    const struct lx_coming coming = {now, *character, self->port->baud, self->port->parity};
    pump(self, now);
    check_speed(self);
    if (self->paced) {
        take_in(self, now, &coming);
    } else {
        if (lx_tap_on(&self->bus.tap)) {
            tell_received(self, now, character);
        }
        arrive(self, &coming);
    }
    lx_hf_settle(self);
}

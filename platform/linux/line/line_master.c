/* SPDX-License-Identifier: MIT */
/*
 * The door of a line of characters. What encoders make of them is the library's business:
 *
 *   serial -- on_character --> dg_bus_rx() ---\
 *   timer --- on_time -------> dg_bus_step() --> next deadline; send_character --> serial
 *   writer -- on_settled ----> dg_bus_durable()
 */
#include <ctype.h>
#include <stdio.h>

#include "line_bus.h"

_Static_assert(LX_BAUD_ANY == DG_BAUD_ANY, "the same to the port and to the library");

/* --- out --- */

static void send_character(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct lx_line_bus *self = ctx;
    (void)place;
    self->port->sends = (struct lx_uart){event->character.baud, event->character.parity};
    lx_serial_put(self->port, &event->character.byte, 1);
}

void lx_line_whole(void *ctx, size_t place, dg_ns at, const uint8_t *bytes, size_t n)
{
    struct lx_line_bus *self = ctx;
    (void)place;
    (void)at;
    lx_serial_put(self->port, bytes, n);
}

/* A UART hands over several characters at once: to the tap it is as if the last one had ended now,
   and the others before it, as far as that is after what was told before. */
static dg_ns spread_received(const struct lx_line_bus *self, const struct dg_tap_event *event)
{
    const dg_ns each =
        dg_bit_times_ns(lx_character_bits(event->character.parity), event->character.baud);
    const dg_ns spread_at = dg_elapsed(event->at, each * self->port->more);
    const dg_ns earliest = self->told + each;
    dg_ns at = spread_at > earliest ? spread_at : earliest;
    at = at < event->at ? at : event->at;
    return at > self->told ? at : self->told;
}

static void tell_character(void *ctx, const struct dg_tap_event *event)
{
    struct lx_line_bus *self = ctx;
    struct dg_tap_event told = *event;
    if (!event->ours && !self->paced) {
        told.at = spread_received(self, event);
    }
    self->told = told.at;
    lx_tap_tell(&self->bus.tap, &told);
}

static enum dg_bus_answer ask_writer(void *ctx, size_t place)
{
    struct lx_line_bus *self = ctx;
    return lx_nvm_queue_answer(&self->encoder[place].station->image.queue);
}

const struct dg_bus_ops lx_line_ops = {
    .tx = send_character, .tap = tell_character, .answer = ask_writer};

/* --- time --- */

void lx_line_enter(struct lx_line_bus *self)
{
    dg_bus_watch(self->bus.core, lx_tap_on(&self->bus.tap));
}

/* A UART has one setting: the first encoder's. */
static void follow_line_setting(struct lx_line_bus *self)
{
    const struct dg_host_uart first = dg_bus_characters_uart(self->bus.core, 0);
    const struct lx_uart uart = lx_line_uart(&first);
    if (uart.baud != self->port->uart.baud || uart.parity != self->port->uart.parity) {
        lx_serial_set(self->port, &uart);
    }
}

/* Most of the time nobody asks for sine and cosine. */
static dg_ns sample_levels(struct lx_line_bus *self)
{
    const bool wanted = self->sampling || lx_tap_asked(&self->bus.tap);
    return wanted ? lx_line_sample(self, lx_now()) : DG_NEVER;
}

/* The library goes on when its time comes: what a master has handed over with this character is on
   its way together with it. */
void lx_line_settle(struct lx_line_bus *self, dg_ns next)
{
    self->bus.late = dg_bus_characters_counters(self->bus.core).late;
    follow_line_setting(self);
    lx_timer_at(&self->timer, dg_earliest(next, sample_levels(self)));
}

void lx_line_on_time(void *ctx, dg_ns now)
{
    struct lx_line_bus *self = ctx;
    lx_line_enter(self);
    lx_line_settle(self, dg_bus_step(self->bus.core, now));
}

void lx_line_on_settled(void *ctx, dg_ns now)
{
    const struct lx_line_encoder *encoder = ctx;
    struct lx_line_bus *self = encoder->all;
    if (self->port != NULL) {
        lx_line_enter(self);
        lx_line_settle(self,
                       dg_bus_durable(self->bus.core, (size_t)(encoder - self->encoder), now));
    }
}

/* --- in --- */

/* Once per episode, which setting would be right. */
static void tell_mismatch(struct lx_line_bus *self, size_t first)
{
    const uint32_t baud = self->port->baud;
    const char parity = self->port->parity;
    const struct dg_host_uart uart = dg_bus_characters_uart(self->bus.core, first);
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
            speed.text, (unsigned long)uart.baud, uart.parity);
}

/* Said when nobody on the line can read the master. */
static void check_speed(struct lx_line_bus *self)
{
    size_t first = self->count;
    for (size_t i = 0; i < self->count; i++) {
        const bool powered = dg_host_powered(self->encoder[i].station->host);
        if (powered &&
            dg_bus_characters_fits(self->bus.core, i, self->port->baud, self->port->parity)) {
            self->mismatch = false;
            return;
        }
        first = first == self->count && powered ? i : first;
    }
    if (first != self->count && !self->mismatch) {
        self->mismatch = true;
        tell_mismatch(self, first);
    }
}

void lx_line_on_character(void *ctx, dg_ns now, const struct lx_character *character)
{
    struct lx_line_bus *self = ctx;
    const struct dg_tap_event event = {
        .at = now,
        .kind = DG_TAP_CHARACTER,
        .character = {self->port->baud, self->port->parity, character->byte, character->damaged},
    };
    lx_line_enter(self);
    const dg_ns next = dg_bus_rx(self->bus.core, &event);
    check_speed(self);
    lx_line_settle(self, next);
}

/* SPDX-License-Identifier: MIT */
#include "explain_levels.h"

#include <string.h>
#include <strings.h>

#include "drehgeber/bits.h"

#define DATA_BITS 8u

/* clang-format off */
static const struct {
    const char *name;
    enum explain_wire wire;
    enum explain_side side;
} names[] = {
    {"REQUEST", EXPLAIN_CHARACTERS, EXPLAIN_FIRST},
    {"TX",      EXPLAIN_CHARACTERS, EXPLAIN_FIRST},
    {"REPLY",   EXPLAIN_CHARACTERS, EXPLAIN_SECOND},
    {"RX",      EXPLAIN_CHARACTERS, EXPLAIN_SECOND},
    {"MA",      EXPLAIN_CLOCKED,    EXPLAIN_FIRST},
    {"CLOCK",   EXPLAIN_CLOCKED,    EXPLAIN_FIRST},
    {"CLK",     EXPLAIN_CLOCKED,    EXPLAIN_FIRST},
    {"SLO",     EXPLAIN_CLOCKED,    EXPLAIN_SECOND},
    {"SL",      EXPLAIN_CLOCKED,    EXPLAIN_SECOND},
    {"DATA",    EXPLAIN_CLOCKED,    EXPLAIN_SECOND},
};
/* clang-format on */

const char explain_levels_right[] =
    "expected signals request and reply, MA and SLO, or CLOCK and DATA";

enum explain_side explain_levels_find(struct explain_levels *self, const char *name, size_t n)
{
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        struct explain_signal *signal = &self->signals[names[i].side];
        const bool same = strlen(names[i].name) == n && strncasecmp(names[i].name, name, n) == 0;
        const bool fits = self->wire == EXPLAIN_UNKNOWN || self->wire == names[i].wire;
        if (same && fits && !signal->found) {
            self->wire = names[i].wire;
            signal->found = true;
            signal->level = true;
            return names[i].side;
        }
    }
    return EXPLAIN_SIDES;
}

bool explain_levels_whole(const struct explain_levels *self)
{
    return self->signals[EXPLAIN_FIRST].found && self->signals[EXPLAIN_SECOND].found;
}

static void put_event(struct explain_levels *self, const struct dg_tap_event *event)
{
    if (self->count < EXPLAIN_LEVELS_EVENTS) {
        self->events[self->count++] = *event;
    }
}

bool explain_levels_take(struct explain_levels *self, struct dg_tap_event *to)
{
    if (self->count == 0) {
        return false;
    }
    *to = self->events[0];
    self->events[0] = self->events[1];
    self->count--;
    return true;
}

static unsigned bits_of(const struct dg_host_uart *uart)
{
    return uart->parity == 'N' ? 1u + DATA_BITS : 2u + DATA_BITS;
}

/* Start, data and parity bits are there. The stop bit is at the level of now. */
static void end_character(struct explain_levels *self, const struct dg_host_uart *uart,
                          enum explain_side side)
{
    struct explain_signal *signal = &self->signals[side];
    const unsigned bits = bits_of(uart);
    struct dg_tap_event event = {
        .at = signal->start + dg_bit_times_ns(bits + 1u, uart->baud),
        .kind = DG_TAP_CHARACTER,
        .ours = side == EXPLAIN_SECOND,
    };
    unsigned ones = 0;
    for (unsigned i = 1; i < bits; i++) {
        ones += (unsigned)signal->bits >> i & 1u;
    }
    event.character.baud = uart->baud;
    event.character.parity = (char)uart->parity;
    event.character.byte = (uint8_t)(signal->bits >> 1);
    event.character.damaged = (uart->parity != 'N' && (ones & 1u) != (uart->parity == 'O')) ||
                              ((unsigned)signal->bits >> bits & 1u) == 0;
    put_event(self, &event);
    signal->busy = false;
}

/* The middles of bits up to `at` have the level that the signal had until then. */
static void sample_bits(struct explain_levels *self, const struct dg_host_uart *uart,
                        enum explain_side side, dg_ns at)
{
    struct explain_signal *signal = &self->signals[side];
    while (signal->busy) {
        const dg_ns middle =
            signal->start + dg_bit_times_ns(2u * signal->count + 1u, 2u * uart->baud);
        if (middle >= at) {
            return;
        }
        signal->bits |= (uint16_t)(signal->level ? 1u << signal->count : 0u);
        signal->count++;
        if (signal->count > bits_of(uart)) {
            end_character(self, uart, side);
        }
    }
}

void explain_levels_change(struct explain_levels *self, enum explain_side side, bool level)
{
    struct explain_signal *signal = &self->signals[side];
    const bool new = level != signal->level;
    if (new && self->wire == EXPLAIN_CHARACTERS && !level && !signal->busy) {
        signal->busy = true;
        signal->start = self->now;
        signal->count = 0;
        signal->bits = 0;
    }
    signal->level = level;
    self->changed |= new;
}

void explain_levels_advance(struct explain_levels *self, const struct dg_host_uart *uart, dg_ns at)
{
    if (self->wire == EXPLAIN_CLOCKED && self->changed) {
        struct dg_tap_event event = {.at = self->now, .kind = DG_TAP_LEVELS};
        event.levels.clock = self->signals[EXPLAIN_FIRST].level;
        event.levels.data = self->signals[EXPLAIN_SECOND].level;
        put_event(self, &event);
    } else if (self->wire == EXPLAIN_CHARACTERS) {
        sample_bits(self, uart, EXPLAIN_FIRST, at);
        sample_bits(self, uart, EXPLAIN_SECOND, at);
    }
    self->changed = false;
}

/* SPDX-License-Identifier: MIT */
/*
 * The master's end of a clocked line. Its edges are at whole nanoseconds, and yet the clock is
 * right on average: what half a period is longer is summed up, and owed.
 */
#include "drehgeber/bus_master.h"

#include "bus_private.h"

/* Longest name of an encoder in a text. */
#define NAME_MAX 32u
#define DEGREES 360u
#define PLACES 6u
#define PER_DEGREE 1000000u

/* Edges of the clock in a second. */
static uint32_t edges_per_second(const struct dg_bus_master_setup *setup)
{
    return 2u * setup->clock_hz;
}

static uint32_t half_of(const struct dg_bus_master_setup *setup)
{
    return (uint32_t)(DG_S(1) / edges_per_second(setup));
}

struct dg_bus_edges_setup dg_bus_master_wire(const struct dg_bus_master_setup *setup)
{
    return (struct dg_bus_edges_setup){
        .size = sizeof(struct dg_bus_edges_setup),
        .there_ns = setup->line_delay_ns,
        .back_ns = setup->line_delay_ns,
        .period_ns = 2u * half_of(setup),
    };
}

void dg_bus_master_init(struct dg_bus_master *self, const struct dg_bus_master_setup *setup,
                        dg_ns now)
{
    *self = (struct dg_bus_master){
        .setup = *setup,
        .half_ns = half_of(setup),
        .rest = (uint32_t)(DG_S(1) % edges_per_second(setup)),
        .now = now,
    };
}

/* ---------------------------------------------------------------- edges */

static dg_ns next_edge(struct dg_bus_master *self)
{
    const dg_ns at = self->now + self->half_ns;

    self->owed += self->rest;
    if (self->owed < edges_per_second(&self->setup)) {
        return at;
    }
    self->owed -= edges_per_second(&self->setup);
    return at + 1u;
}

void dg_bus_master_edge(struct dg_bus_master *self, bool level)
{
    self->now = next_edge(self);
    (void)dg_bus_edge(self->setup.bus, self->now, level);
}

bool dg_bus_master_sample(const struct dg_bus_master *self, dg_ns at)
{
    return dg_bus_edges_data(self->setup.bus, at + self->delay);
}

bool dg_bus_master_bit(struct dg_bus_master *self)
{
    dg_bus_master_edge(self, false);
    dg_bus_master_edge(self, true);
    return dg_bus_master_sample(self, self->now + self->half_ns);
}

void dg_bus_master_pause(struct dg_bus_master *self, dg_ns now)
{
    struct dg_bus *bus = self->setup.bus;

    self->now = now > self->now ? now : self->now;
    for (size_t i = 0; i < bus->count; i++) {
        (void)dg_bus_changed(bus, i, self->now);
    }
}

dg_ns dg_bus_master_way(const struct dg_bus_master *self)
{
    return 2u * (dg_ns)self->setup.line_delay_ns;
}

/* ---------------------------------------------------------------- words */

struct dg_text dg_bus_master_text(const struct dg_bus_master *self, size_t place, char *to,
                                  size_t size)
{
    const struct dg_encoder *control = dg_bus_place_at(self->setup.bus, place)->control;
    struct dg_text text = dg_text_in(to, size);

    if (self->setup.bus->count > 1u && control != NULL) {
        dg_text_add_n(&text, control->name, NAME_MAX);
        dg_text_add(&text, ": ");
    }
    return text;
}

void dg_master_say(struct dg_text *to, const char *name, uint64_t value)
{
    char digits[DG_TEXT_DIGITS_MAX];

    dg_text_add(to, name);
    dg_text_add_n(to, digits, dg_text_digits(digits, value, false, 0));
}

void dg_master_note_position(struct dg_text *to, uint32_t multiturn, uint32_t singleturn)
{
    dg_master_say(to, "position ", multiturn);
    dg_master_say(to, ":", singleturn);
}

/* In units of the last place, to the nearest one; from the middle to the even one. */
static uint64_t degrees_of(uint32_t singleturn, uint8_t bits)
{
    const uint64_t product = (uint64_t)singleturn * DEGREES * PER_DEGREE;
    const uint64_t mask = ((uint64_t)1 << bits) - 1u;
    const uint64_t twice = 2u * (product & mask);
    const uint64_t down = product >> bits;

    return down + (twice > mask + 1u || (twice == mask + 1u && (down & 1u) != 0) ? 1u : 0u);
}

void dg_master_line_position(struct dg_text *to, uint32_t multiturn, uint32_t singleturn,
                             uint8_t bits)
{
    char digits[DG_TEXT_DIGITS_MAX];

    dg_master_say(to, "MT ", multiturn);
    dg_master_say(to, "  ST ", singleturn);
    dg_text_add(to, "  ");
    dg_text_add_n(to, digits, dg_text_digits(digits, degrees_of(singleturn, bits), false, PLACES));
    dg_text_add(to, " deg");
}

/* ---------------------------------------------------------------- frames */

void dg_bus_master_note(const struct dg_bus_master *self, const char *text,
                        enum dg_severity severity)
{
    const struct dg_tap_event event = {
        .at = self->now,
        .kind = DG_TAP_NOTE,
        .ours = true,
        .severity = severity,
        .note = text,
    };

    dg_bus_tell(self->setup.bus, &event);
}

static enum dg_severity reading_severity_of(const struct dg_bus_master *self, size_t place)
{
    const struct dg_master_protocol *protocol = self->setup.protocol;
    struct dg_master_word word;

    if (protocol->judge(self, place) != DG_MASTER_GOOD) {
        return DG_SEVERITY_ERROR;
    }
    protocol->word(self, place, &word);
    if (word.error) {
        return DG_SEVERITY_ERROR;
    }
    return word.warning ? DG_SEVERITY_WARNING : DG_SEVERITY_OK;
}

void dg_bus_master_read(struct dg_bus_master *self)
{
    const struct dg_master_protocol *protocol = self->setup.protocol;
    const struct dg_bus *bus = self->setup.bus;

    protocol->read(self);
    for (size_t i = 0; bus->watched && i < bus->count; i++) {
        char note[DG_BUS_NOTE_MAX];
        struct dg_text text = dg_bus_master_text(self, i, note, sizeof note);
        if (protocol->judge(self, i) == DG_MASTER_SILENT) {
            dg_text_add(&text, "no answer");
        } else {
            protocol->note(self, i, &text);
        }
        dg_bus_master_note(self, note, reading_severity_of(self, i));
    }
}

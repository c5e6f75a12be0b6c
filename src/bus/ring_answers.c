/* SPDX-License-Identifier: MIT */
/*
 * What the master sees in place of the IN words that an encoder has said: those of the cycle
 * before, while what they acknowledge is not durable (held back), or half of them (torn).
 */
#include <string.h>

#include "ring_private.h"

#define HIGH_BYTE 0xFF00u
#define LOW_BYTE 0x00FFu

/* The high half of the cycle before: the high word, of a single one the high byte. */
static void tear_words(struct member *self, uint16_t *in, uint16_t before)
{
    struct dg_faults *faults = faults_of(self);

    if (faults != NULL && dg_fault_wire_takes(faults, DG_WIRE_TEAR)) {
        in[0] = self->words > 1 ? before : (uint16_t)((before & HIGH_BYTE) | (in[0] & LOW_BYTE));
    }
}

static bool are_same_words(const struct member *self, const uint16_t *a, const uint16_t *b)
{
    return memcmp(a, b, self->words * sizeof *a) == 0;
}

/* What an encoder stores by itself, without a command, holds up nothing. What is lost is not
 * answered: the old words stay until there is another command. */
static void hold_words_back(struct member *self, uint64_t ticket, uint16_t *in, const uint16_t *out)
{
    static const uint16_t nothing[DG_RING_WORDS_MAX];
    const struct dg_bus *bus = self->place.bus;
    const size_t size = self->words * sizeof *in;
    struct held *held = &self->held;
    const enum dg_bus_answer answer = bus->ops->answer(bus->ctx, self->place.index);

    if (answer != DG_BUS_SAY && ticket != held->looked && !are_same_words(self, out, nothing)) {
        if (!held->holds) {
            memcpy(held->shown, self->whole, size);
        }
        held->holds = true;
        memcpy(held->command, out, size);
    }
    held->looked = ticket;
    const bool same = held->holds && are_same_words(self, held->command, out);
    if (answer == DG_BUS_SAY || (answer == DG_BUS_DROP && !same)) {
        held->settled = ticket;
        held->holds = false;
    }
    if (held->holds) {
        memcpy(in, held->shown, size);
    }
}

/* What the master sees in place of what the encoder has said. */
static void bend_words(struct member *self, uint16_t *in, const uint16_t *out)
{
    const struct dg_bus *bus = self->place.bus;
    const uint16_t before = self->whole[0];

    if (bus->ops->ticket != NULL) {
        const uint64_t ticket = bus->ops->ticket(bus->ctx, self->place.index);
        if (ticket != self->held.settled) {
            hold_words_back(self, ticket, in, out);
        }
    }
    memcpy(self->whole, in, self->words * sizeof *in);
    tear_words(self, in, before);
}

void dg_bus_ring_decide_to_bend(const struct dg_bus *self)
{
    struct ring *ring = ring_of(self);
    const bool keeps = self->ops->ticket != NULL || ring->bent;

    for (size_t i = 0; keeps && !ring->keeps && i < self->count; i++) {
        struct member *member = member_at(self, i);
        memcpy(member->whole, ring->setup.in + member->at, member->words * sizeof(uint16_t));
    }
    ring->keeps = keeps;
}

void dg_bus_ring_bend_words(const struct dg_bus *self, const uint16_t *out)
{
    uint16_t *in = ring_of(self)->setup.in;

    for (size_t i = 0; i < self->count; i++) {
        struct member *member = member_at(self, i);
        bend_words(member, in + member->at, out + member->at);
    }
}

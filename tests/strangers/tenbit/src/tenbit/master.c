/* SPDX-License-Identifier: MIT */
/* The master of a line: a word at a time. There is nothing in it that could be wrong. */
#include "drehgeber/bus_master.h"
#include "drehgeber/tenbit.h"

/* A master waits a little longer than the monoflop time. */
#define PAUSE_NS DG_US(1)

static uint32_t count_rises(const struct dg_bus *bus)
{
    (void)bus;
    return DG_TENBIT_BITS;
}

static void read_word(struct dg_bus_master *self)
{
    const dg_ns way = dg_bus_master_way(self);

    self->bits[0] = 0;
    self->answered = true;
    self->delay = self->setup.compensates ? way : 0;
    for (unsigned i = 0; i < DG_TENBIT_BITS; i++) {
        self->bits[0] = self->bits[0] << 1 | dg_bus_master_bit(self);
    }
    dg_bus_master_pause(self, self->now + DG_TENBIT_MONOFLOP + way + PAUSE_NS);
}

static void skip_words(const struct dg_bus_master *self, uint64_t n)
{
    struct dg_tenbit *device = dg_bus_device(self->setup.bus, 0);

    device->frames += (uint32_t)n;
}

static enum dg_master_verdict judge(const struct dg_bus_master *self, size_t place)
{
    (void)self;
    (void)place;
    return DG_MASTER_GOOD;
}

static void tell_word(const struct dg_bus_master *self, size_t place, struct dg_master_word *to)
{
    *to = (struct dg_master_word){.bits = self->bits[place],
                                  .count = DG_TENBIT_BITS,
                                  .singleturn = (uint32_t)self->bits[place]};
}

static void say_word(const struct dg_bus_master *self, size_t place, struct dg_text *to)
{
    dg_master_say(to, "word ", self->bits[place]);
}

const struct dg_master_protocol dg_tenbit_master = {
    .rises = count_rises,
    .read = read_word,
    .skip = skip_words,
    .judge = judge,
    .word = tell_word,
    .note = say_word,
    .line = say_word,
};

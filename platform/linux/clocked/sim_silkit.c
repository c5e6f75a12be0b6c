/* SPDX-License-Identifier: MIT */
/* All numbers of a message are little endian. */
#include "sim_silkit.h"

#include "drehgeber/bits.h"
#include "sim_bus.h"

#define LATCH_TYPE "application/vnd.drehgeber.latch.v1"
#define FRAME_TYPE "application/vnd.drehgeber.frame.v1"
/* A message: the moment, and for each encoder, the nearest to the master first:
   verdict, flags, life counter, number of bits; multiturn; singleturn; 0; the bits. */
#define AHEAD 8u
#define ENTRY 24u
#define FLAG_ERROR 1u
#define FLAG_WARNING 2u

static void put_entry(uint8_t *to, const struct dg_bus_master *master, size_t encoder)
{
    const enum dg_master_verdict verdict = master->setup.protocol->judge(master, encoder);
    struct dg_master_word word = {0};
    if (verdict != DG_MASTER_SILENT) {
        master->setup.protocol->word(master, encoder, &word);
    }
    to[0] = (uint8_t)verdict;
    to[1] = (uint8_t)((word.error ? FLAG_ERROR : 0u) | (word.warning ? FLAG_WARNING : 0u));
    to[2] = word.life;
    to[3] = word.count;
    dg_store_le32(to + 4, word.multiturn);
    dg_store_le32(to + 8, word.singleturn);
    dg_store_le32(to + 12, 0);
    dg_store_le64(to + 16, word.bits);
}

static void publish_reading(struct lx_sim_silkit *self)
{
    const struct dg_bus_master *master = lx_sim_bus_begin(self->bus);
    const size_t count = self->bus->setup.count;
    uint8_t message[AHEAD + ENTRY * LX_CLOCKED_MAX];
    dg_store_le64(message, lx_silkit_time_at(self->frame.all, master->now));
    lx_sim_bus_read(self->bus);
    for (size_t i = 0; i < count; i++) {
        put_entry(message + AHEAD + ENTRY * i, master, i);
    }
    lx_silkit_publish(&self->frame, message, AHEAD + ENTRY * count);
    lx_sim_bus_end(self->bus);
}

static void receive(void *ctx, dg_ns now, const struct lx_silkit_message *message, bool last)
{
    struct lx_sim_silkit *self = ctx;
    (void)now;
    (void)message;
    (void)last;
    self->latched = true;
    publish_reading(self);
}

static void step_frames(void *ctx, dg_ns now)
{
    struct lx_sim_silkit *self = ctx;
    (void)now;
    if (!self->latched) {
        publish_reading(self);
    }
}

int lx_sim_silkit_open(struct lx_sim_silkit *self, struct lx_bus *bus, struct lx_error *error)
{
    struct lx_silkit *silkit = bus->setup.silkit;
    if (lx_silkit_join(silkit, bus->setup.wire->where, &self->where, error) != 0) {
        return -1;
    }
    self->bus = bus;
    self->latch = (struct lx_silkit_port){.receive = receive, .ctx = self};
    self->frame = (struct lx_silkit_port){.step = step_frames, .ctx = self};
    lx_silkit_name_topic(&self->latch, self->where.network, "latch");
    lx_silkit_name_topic(&self->frame, self->where.network, "frame");
    return lx_silkit_subscribe(silkit, &self->latch, LATCH_TYPE, error) != 0
               ? -1
               : lx_silkit_offer(silkit, &self->frame, FRAME_TYPE, error);
}

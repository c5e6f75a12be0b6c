/* SPDX-License-Identifier: MIT */
/* All numbers of a message are little endian. */
#include "ring_silkit.h"

#include "drehgeber/bits.h"

#define MEDIA_TYPE "application/vnd.drehgeber.interbus.v1"
/* In front of IN: what the cycle came to, enum dg_ring_result or that it was left out, and how
   many devices were reached. */
#define AHEAD 4u
#define WORD 2u
#define LEFT_OUT 0xFFFFu

static void receive(void *ctx, dg_ns now, const struct lx_silkit_message *message, bool last)
{
    struct lx_ring_silkit *self = ctx;
    const uint8_t *bytes = lx_silkit_bytes(message);
    (void)now;
    (void)last;
    for (size_t i = 0; i < message->length / WORD; i++) {
        self->ring->out[i] = dg_load_le16(bytes + WORD * i);
    }
}

static void step_ring(void *ctx, dg_ns now)
{
    struct lx_ring_silkit *self = ctx;
    const struct lx_ring *ring = self->ring;
    const uint16_t *in = dg_ring_master_in(&ring->master);
    uint8_t message[AHEAD + WORD * LX_RING_WORDS_MAX];
    const bool took_place = dg_ring_master_cycle(&self->ring->master, now);
    dg_store_le16(message, took_place ? (uint16_t)ring->is->result : LEFT_OUT);
    dg_store_le16(message + WORD, ring->is->reached);
    for (size_t i = 0; i < ring->is->words; i++) {
        dg_store_le16(message + AHEAD + WORD * i, in[i]);
    }
    lx_silkit_publish(&self->in, message, AHEAD + (size_t)WORD * ring->is->words);
}

int lx_ring_silkit_open(struct lx_ring_silkit *self, const struct lx_bus_setup *setup,
                        struct lx_error *error)
{
    const size_t size = (size_t)WORD * self->ring->is->words;
    if (lx_silkit_join(setup->silkit, setup->wire->where, &self->where, error) != 0) {
        return -1;
    }
    self->out = (struct lx_silkit_port){
        .length_min = size, .length_max = size, .receive = receive, .ctx = self};
    self->in = (struct lx_silkit_port){.step = step_ring, .ctx = self};
    lx_silkit_name_topic(&self->out, self->where.network, "out");
    lx_silkit_name_topic(&self->in, self->where.network, "in");
    return lx_silkit_subscribe(setup->silkit, &self->out, MEDIA_TYPE, error) != 0
               ? -1
               : lx_silkit_offer(setup->silkit, &self->in, MEDIA_TYPE, error);
}

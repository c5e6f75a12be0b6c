/* SPDX-License-Identifier: MIT */
/*
 * A CAN bus in a SIL Kit simulation: one controller for all encoders of it. Without a network
 * simulator every frame gets through at once; with one, frames get lost, and the controller has an
 * error state. Until the simulation begins, frames wait: a real controller tries until somebody
 * acknowledges.
 *
 * Or packed: there is no controller, and all frames of a step are one message (silkit_pack.h).
 *
 *   NETWORK/frames/to --> encoders
 *   NETWORK/frames    <-- encoders
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "can.h"
#include "silkit.h"
#include "silkit_pack.h"

/* Of 11 bits. */
#define ID_MAX 0x7FFu
/* What encoders send by themselves before anybody is there; the oldest ones are kept. */
#define EARLY_MAX 4096u

struct silkit_can {
    struct lx_can can;
    struct lx_silkit_port port; /* the controller, or what is received packed: */
    struct lx_silkit_port out;  /* ... and where packed frames go to */
    struct lx_silkit_pack pack; /* of this step */
    struct lx_silkit_where where;
    struct dg_can_frame *early; /* owned */
    size_t early_count;
};

static struct silkit_can *silkit_of(struct lx_can *can)
{
    return (struct silkit_can *)can;
}

/* --- out --- */

static void flush(void *ctx, dg_ns now)
{
    struct silkit_can *self = ctx;
    (void)now;
    if (self->pack.count > 0) {
        lx_silkit_publish(&self->out, self->pack.bytes, self->pack.length);
        lx_silkit_pack_clear(&self->pack);
    }
}

/* A message has room for more than a bus carries in the longest step. */
static void pack_frame(struct silkit_can *self, const struct dg_can_frame *frame)
{
    const uint64_t at = lx_silkit_time_at(self->port.all, lx_now());
    self->can.counters.lost += lx_silkit_pack_add(&self->pack, at, frame) ? 0u : 1u;
}

static void publish_frame(struct silkit_can *self, const struct dg_can_frame *frame)
{
    if (self->port.packed) {
        pack_frame(self, frame);
        return;
    }
    const uint8_t n = frame->dlc < sizeof frame->data ? frame->dlc : (uint8_t)sizeof frame->data;
    lx_silkit_send(&self->port, frame->id, frame->rtr, frame->data, n);
}

static bool write_frame(struct lx_can *can, const struct dg_can_frame *frame)
{
    struct silkit_can *self = silkit_of(can);
    if (lx_silkit_is_ready(self->port.all)) {
        publish_frame(self, frame);
        return true;
    }
    if (self->early == NULL) {
        self->early = malloc(EARLY_MAX * sizeof *self->early);
    }
    if (self->early == NULL || self->early_count == EARLY_MAX) {
        can->counters.lost++;
    } else {
        self->early[self->early_count++] = *frame;
    }
    return true;
}

/* In real time there are no steps to collect them in. */
static void push(struct lx_can *can)
{
    struct silkit_can *self = silkit_of(can);
    if (!lx_silkit_is_virtual(self->port.all)) {
        flush(self, lx_now());
    }
}

static void on_ready(void *ctx, dg_ns now)
{
    struct silkit_can *self = ctx;
    for (size_t i = 0; i < self->early_count; i++) {
        publish_frame(self, &self->early[i]);
    }
    free(self->early);
    self->early = NULL;
    self->early_count = 0;
    self->can.setup.settle(self->can.setup.ctx, now);
}

/* --- in --- */

static void take_silkit_frame(struct silkit_can *self, dg_ns now,
                              const struct lx_silkit_message *message)
{
    const struct lx_can_setup *setup = &self->can.setup;
    struct dg_can_frame frame = {
        .id = (uint16_t)message->id,
        .rtr = (message->flags & LX_SK_FRAME_REMOTE) != 0,
    };
    const uint16_t n = frame.rtr ? message->dlc : (uint16_t)message->length;
    frame.dlc = n > sizeof frame.data ? sizeof frame.data : (uint8_t)n;
    memcpy(frame.data, lx_silkit_bytes(message), message->length);
    if ((message->flags & LX_SK_FRAME_EXTENDED) != 0) {
        setup->foreign(setup->ctx, DG_CAN_EXTENDED_BITS(1u, dg_can_bytes(&frame)));
    } else if ((message->flags & ~LX_SK_FRAME_REMOTE) == 0 && message->id <= ID_MAX) {
        setup->rx(setup->ctx, now, &frame);
    }
}

static void take_state(struct silkit_can *self, dg_ns now, uint32_t state)
{
    static const enum dg_host_bus events[] = {
        [LX_SK_ERROR_ACTIVE] = DG_HOST_BUS_ACTIVE,
        [LX_SK_ERROR_PASSIVE] = DG_HOST_BUS_PASSIVE,
        [LX_SK_BUS_OFF] = DG_HOST_BUS_OFF,
    };
    const struct lx_can_setup *setup = &self->can.setup;
    if (state != LX_SK_ERROR_UNKNOWN && state < DG_COUNT(events)) {
        setup->bus(setup->ctx, now, events[state]);
    }
}

static void receive(void *ctx, dg_ns now, const struct lx_silkit_message *message, bool last)
{
    struct silkit_can *self = ctx;
    if (message->kind == LX_SILKIT_FRAME) {
        take_silkit_frame(self, now, message);
    } else if (message->kind == LX_SILKIT_STATE) {
        take_state(self, now, message->id);
    } else if (message->kind == LX_SILKIT_LOST) {
        self->can.counters.lost++;
    }
    if (last) {
        self->can.setup.settle(self->can.setup.ctx, now);
    }
}

/* --- the operations --- */

static void expect(struct lx_can *can, uint16_t kbaud)
{
    struct silkit_can *self = silkit_of(can);
    if (can->expected != kbaud) {
        can->expected = kbaud;
        lx_silkit_baud_rate(&self->port, 1000u * kbaud);
    }
}

/* A message has no bit rate. */
static void expect_any(struct lx_can *can, uint16_t kbaud)
{
    can->expected = kbaud;
}

static void close_silkit(struct lx_can *can)
{
    free(silkit_of(can)->early);
    lx_silkit_pack_free(&silkit_of(can)->pack);
}

static const struct lx_can_ops silkit_ops = {
    .write = write_frame,
    .expect = expect,
    .close = close_silkit,
};
static const struct lx_can_ops packed_ops = {
    .write = write_frame,
    .push = push,
    .expect = expect_any,
    .close = close_silkit,
};

/* --- making --- */

static int join_network(struct silkit_can *self, struct lx_error *error)
{
    struct lx_can *can = &self->can;
    self->port = (struct lx_silkit_port){.receive = receive, .ready = on_ready, .ctx = self};
    const int result = lx_silkit_join(can->setup.silkit, can->setup.where, &self->where, error);
    (void)snprintf(can->address, sizeof can->address, "%s", self->where.ready);
    return result;
}

static int start_controller(struct lx_can *can, struct lx_error *error)
{
    struct silkit_can *self = silkit_of(can);
    return join_network(self, error) != 0
               ? -1
               : lx_silkit_open_can(can->setup.silkit, &self->port, self->where.network, error);
}

static int start_packed(struct lx_can *can, struct lx_error *error)
{
    struct silkit_can *self = silkit_of(can);
    struct lx_silkit *silkit = can->setup.silkit;
    if (join_network(self, error) != 0) {
        return -1;
    }
    self->port.packed = true;
    self->port.timer = can->setup.timer;
    self->port.tap = can->setup.tap;
    self->out = (struct lx_silkit_port){.step = flush, .ctx = self};
    lx_silkit_name_topic(&self->out, self->where.network, "frames");
    lx_silkit_name_topic(&self->port, self->out.topic, "to");
    return lx_silkit_subscribe(silkit, &self->port, LX_SILKIT_PACK_TYPE, error) != 0
               ? -1
               : lx_silkit_offer(silkit, &self->out, LX_SILKIT_PACK_TYPE, error);
}

struct lx_can *lx_silkit_can_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    static const struct lx_can_kind kind = {sizeof(struct silkit_can), &silkit_ops,
                                            start_controller, NULL};
    return lx_can_make(&kind, setup, error);
}

struct lx_can *lx_silkit_pack_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    static const struct lx_can_kind kind = {sizeof(struct silkit_can), &packed_ops, start_packed,
                                            NULL};
    return lx_can_make(&kind, setup, error);
}

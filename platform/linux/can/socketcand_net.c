/* SPDX-License-Identifier: MIT */
/* A CAN bus behind a socketcand. */
#define _GNU_SOURCE
#include <string.h>

#include "can_net.h"
#include "socketcand.h"

static void take_byte(struct lx_can_net *self, struct lx_peer *from, dg_ns now, uint8_t byte)
{
    const struct lx_can_setup *setup = &self->can.setup;
    struct lx_socketcand *own = (void *)from->own;
    const enum lx_socketcand_mode before = own->mode;
    struct lx_socketcand_event event;
    if (!lx_socketcand_feed(own, self->where.word, byte, &event)) {
        return;
    }
    if (event.reply != NULL) {
        lx_peer_answer(from, event.reply, strlen(event.reply));
    }
    if (event.has_frame && lx_can_net_spread(self, from, now, &event.frame)) {
        const uint32_t bytes = dg_can_bytes(&event.frame.frame);
        if (event.frame.extended) {
            setup->foreign(setup->ctx, DG_CAN_EXTENDED_BITS(1u, bytes));
        } else {
            setup->rx(setup->ctx, now, &event.frame.frame);
        }
    }
    if (event.has_frame || own->mode != before) {
        setup->settle(setup->ctx, now);
    }
}

static bool is_open(const void *own)
{
    return ((const struct lx_socketcand *)own)->mode != LX_SOCKETCAND_NO_BUS;
}

static bool wants(const void *own, const struct lx_can_wide *frame)
{
    return lx_socketcand_wants(own, frame);
}

static size_t print(const void *own, const struct lx_can_wide *frame, dg_ns now,
                    char to[LX_CAN_TEXT_MAX])
{
    (void)own;
    return lx_socketcand_print(frame, now, to);
}

static const struct lx_can_dialect socketcand = {
    .kind = "socketcand",
    .address = {"", "expected HOST:PORT or HOST:PORT,BUS, with or without ,open", true},
    .own_size = sizeof(struct lx_socketcand),
    .hello = lx_socketcand_hello,
    .byte = take_byte,
    .is_open = is_open,
    .wants = wants,
    .print = print,
};

static const struct lx_can_kind kind = {sizeof(struct lx_can_net), &lx_can_net_ops,
                                        lx_can_net_start, &socketcand};

struct lx_can *lx_socketcand_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    return lx_can_make(&kind, setup, error);
}

int lx_socketcand_check(const char *where, struct lx_error *error)
{
    return lx_peers_check(&socketcand.address, where, error);
}

/* SPDX-License-Identifier: MIT */
/* SLCAN adapters on one CAN bus, one for each TCP client. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "can_net.h"
#include "slcan_channel.h"

/* Where a line has its identifier, of 3 digits or of 8. */
#define ID_AT 1u
#define SHORT_ID 3u
#define LONG_ID 8u
#define LONG_LETTER ('T' - 't')

/* The identifier of a frame with 29 bits stands in the line, as `line` was before its end. */
static struct lx_can_wide wide_of(const struct dg_slcan *line, const struct dg_slcan_event *event)
{
    struct lx_can_wide frame = {.extended = event->extended, .frame = event->frame};
    char id[LONG_ID + 1u] = "";
    if (event->extended) {
        memcpy(id, line->line + ID_AT, LONG_ID);
    }
    frame.id = event->extended ? (uint32_t)strtoul(id, NULL, 16) : event->frame.id;
    return frame;
}

static void take_byte(struct lx_can_net *self, struct lx_peer *from, dg_ns now, uint8_t byte)
{
    struct lx_slcan_channel *own = (void *)from->own;
    const struct dg_slcan before = own->codec;
    struct dg_slcan_event event;
    if (!dg_slcan_feed(&own->codec, byte, &event)) {
        return;
    }
    lx_peer_answer(from, event.reply, strlen(event.reply));
    const bool sends = event.has_frame || event.extended;
    const struct lx_can_wide frame = wide_of(&before, &event);
    if (!sends || lx_can_net_spread(self, from, now, &frame)) {
        lx_slcan_act(own, &self->can, now, &event, own->codec.state != before.state);
    }
}

static bool is_open(const void *own)
{
    return ((const struct lx_slcan_channel *)own)->codec.state != DG_SLCAN_CLOSED;
}

static uint16_t kbaud(const void *own)
{
    return ((const struct lx_slcan_channel *)own)->codec.kbaud;
}

static void check(void *own, const struct lx_say *say, uint16_t expected)
{
    lx_slcan_check(own, say, expected);
}

static size_t print(const void *own, const struct lx_can_wide *frame, dg_ns now,
                    char to[LX_CAN_TEXT_MAX])
{
    const struct dg_slcan *codec = &((const struct lx_slcan_channel *)own)->codec;
    char text[DG_SLCAN_TEXT_MAX + 1u];
    const size_t n = dg_slcan_print(codec, &frame->frame, now / DG_MS(1), text);
    if (!frame->extended) {
        memcpy(to, text, n + 1u);
        return n;
    }
    return (size_t)snprintf(to, LX_CAN_TEXT_MAX, "%c%08lX%s", text[0] + LONG_LETTER,
                            (unsigned long)frame->id, text + ID_AT + SHORT_ID);
}

static const struct lx_can_dialect slcan = {
    .kind = "slcan",
    .address = {"tcp:", "expected LINK, tcp:HOST:PORT or tcp:HOST:PORT,open", false},
    .own_size = sizeof(struct lx_slcan_channel),
    .byte = take_byte,
    .is_open = is_open,
    .kbaud = kbaud,
    .check = check,
    .print = print,
};

static const struct lx_can_kind kind = {sizeof(struct lx_can_net), &lx_can_net_ops,
                                        lx_can_net_start, &slcan};

/* What is no TCP port is the link of a pty, or without a name. */
static bool is_net(const char *where)
{
    const char *prefix = slcan.address.prefix;
    return where != NULL && strncmp(where, prefix, strlen(prefix)) == 0;
}

struct lx_can *lx_slcan_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    return is_net(setup->where) ? lx_can_make(&kind, setup, error)
                                : lx_slcan_pty_open(setup, error);
}

int lx_slcan_address_check(const char *where, struct lx_error *error)
{
    return is_net(where) ? lx_peers_check(&slcan.address, where, error) : 0;
}

/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: messages of a client to the socketcand. The input is what comes in, byte by byte.
 * Every message has one reply of those that are known, or none; a frame is one that a bus can
 * carry, comes from a client with the bus open only, and is the same when it is sent as it is
 * written out here.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "fuzz_input.h"
#include "socketcand.h"

#define BUS "can0"

static bool is_known(const char *reply)
{
    static const char *const replies[] = {
        "< ok >",
        "< echo >",
        "< error could not open bus >",
        "< error unknown command >",
        "< error syntax error in subscription >",
        "< error syntax error in send command >",
    };

    for (size_t i = 0; i < DG_COUNT(replies); i++) {
        if (strcmp(reply, replies[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* Another client that writes the frame out sends the same one. */
static void check_again(const struct lx_can_wide *frame)
{
    struct lx_socketcand other = {.mode = LX_SOCKETCAND_RAW};
    struct lx_socketcand_event event;
    char text[LX_SOCKETCAND_MAX];
    int n = snprintf(text, sizeof text, frame->extended ? "< send %08lX %u" : "<send %lx %u",
                     (unsigned long)frame->id, frame->frame.dlc);

    for (size_t i = 0; i < frame->frame.dlc; i++) {
        n += snprintf(text + n, sizeof text - (size_t)n, " %x", frame->frame.data[i]);
    }
    for (int i = 0; i < n; i++) {
        fuzz_must(!lx_socketcand_feed(&other, "", (uint8_t)text[i], &event));
    }
    fuzz_must(lx_socketcand_feed(&other, "", '>', &event));
    fuzz_must(event.has_frame && event.reply == NULL && event.frame.extended == frame->extended);
    fuzz_must(event.frame.id == frame->id && event.frame.frame.dlc == frame->frame.dlc);
    fuzz_must(memcmp(event.frame.frame.data, frame->frame.data, sizeof frame->frame.data) == 0);
}

static void check_print(const struct lx_can_wide *frame, dg_ns now)
{
    char text[LX_SOCKETCAND_TEXT_MAX];
    const size_t n = lx_socketcand_print(frame, now, text);

    fuzz_must(n == strlen(text) && strncmp(text, "< frame ", 8) == 0);
    fuzz_must(strcmp(text + n - 2, " >") == 0 && strchr(text, '>') == text + n - 1);
}

static void check(const struct lx_socketcand *self, enum lx_socketcand_mode before,
                  const struct lx_socketcand_event *event)
{
    const struct lx_can_wide *frame = &event->frame;

    fuzz_must(event->reply == NULL || is_known(event->reply));
    fuzz_must(self->mode != LX_SOCKETCAND_NO_BUS || before == LX_SOCKETCAND_NO_BUS);
    if (event->has_frame) {
        fuzz_must(self->mode != LX_SOCKETCAND_NO_BUS && event->reply == NULL);
        fuzz_must(frame->id <= (frame->extended ? 0x1FFFFFFFu : 0x7FFu) && frame->frame.dlc <= 8);
        fuzz_must(frame->extended || frame->frame.id == frame->id);
        fuzz_must(self->mode != LX_SOCKETCAND_RAW || lx_socketcand_wants(self, frame));
        check_again(frame);
        check_print(frame, DG_NEVER);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    struct lx_socketcand client = {.mode = LX_SOCKETCAND_NO_BUS};
    struct lx_socketcand_event event;

    for (size_t i = 0; i < n; i++) {
        const enum lx_socketcand_mode before = client.mode;
        const bool inside = client.inside;
        const bool ended = lx_socketcand_feed(&client, BUS, bytes[i], &event);
        fuzz_must(ended == (inside && bytes[i] == '>') && client.length <= LX_SOCKETCAND_MAX);
        if (ended) {
            check(&client, before, &event);
        }
    }
    return 0;
}

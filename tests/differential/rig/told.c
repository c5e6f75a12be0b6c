/* SPDX-License-Identifier: MIT */
#include "told.h"

#include <inttypes.h>
#include <stdio.h>

#define REMOTE 8u /* DG_HOST_REMOTE */

bool told_levels;

static void print_frame(dg_ns at, const struct dg_can_frame *frame)
{
    printf("@%" PRIu64 " message %" PRIx32 " %x ", at, (uint32_t)frame->id,
           frame->rtr ? REMOTE : 0u);
    for (uint8_t i = 0; !frame->rtr && i < frame->dlc; i++) {
        printf("%02x", frame->data[i]);
    }
    printf(";\n");
}

void told_print(void *ctx, const struct dg_tap_event *event)
{
    (void)ctx;
    if (event->kind == DG_TAP_LEVELS && told_levels) {
        printf("@%" PRIu64 " levels %d %d\n", event->at, event->levels.clock, event->levels.data);
    } else if (event->kind == DG_TAP_CHARACTER && event->ours) {
        printf("@%" PRIu64 " byte %02x\n", event->at, event->character.byte);
    } else if (event->kind == DG_TAP_FRAME && event->ours) {
        print_frame(event->at, &event->frame);
    }
}

/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: lines of a master to the SLCAN adapter. The input is what comes in, byte by byte.
 * Every line has one reply, which is OK, BEL or a known one; a frame is one that a bus can carry,
 * comes from an open channel only, and is the same after it was printed and read by another
 * adapter.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/slcan.h"
#include "fuzz_input.h"

#define STAMP 4u

static bool is_known(const char *reply)
{
    static const char *const replies[] = {"\r", "\a", "z\r", "Z\r", "F00\r", "V1010\r", "NDG01\r"};

    for (size_t i = 0; i < DG_COUNT(replies); i++) {
        if (strcmp(reply, replies[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* Another master that is told of the frame would send the same one. */
static void check_print(const struct dg_slcan *self, const struct dg_can_frame *frame)
{
    struct dg_slcan other = {.state = DG_SLCAN_OPEN};
    struct dg_slcan_event event;
    char text[DG_SLCAN_TEXT_MAX + 1u];
    const size_t n = dg_slcan_print(self, frame, 4711, text);
    const size_t end = n - 1u - (self->stamps ? STAMP : 0u);

    fuzz_must(n <= DG_SLCAN_TEXT_MAX && text[n] == '\0' && text[n - 1] == '\r');
    for (size_t i = 0; i < end; i++) {
        fuzz_must(!dg_slcan_feed(&other, (uint8_t)text[i], &event));
    }
    fuzz_must(dg_slcan_feed(&other, '\r', &event) && event.has_frame);
    fuzz_must(event.frame.id == frame->id && event.frame.rtr == frame->rtr);
    fuzz_must(event.frame.dlc == frame->dlc);
    fuzz_must(memcmp(event.frame.data, frame->data, sizeof frame->data) == 0);
}

static void check_event(const struct dg_slcan *self, const struct dg_slcan_event *event)
{
    fuzz_must(self->length == 0 && !self->overlong && is_known(event->reply));
    fuzz_must(!(event->has_frame && event->extended));
    if (event->has_frame) {
        fuzz_must(self->state == DG_SLCAN_OPEN && event->reply[0] == 'z');
        fuzz_must(event->frame.id <= 0x7FF && event->frame.dlc <= 8);
        check_print(self, &event->frame);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    struct dg_slcan adapter = {.state = DG_SLCAN_CLOSED};
    struct dg_slcan_event event;

    for (size_t i = 0; i < n; i++) {
        const bool ended = dg_slcan_feed(&adapter, bytes[i], &event);
        fuzz_must(ended == (bytes[i] == '\r') && adapter.length <= DG_SLCAN_LINE_MAX);
        if (ended) {
            check_event(&adapter, &event);
        }
    }
    return 0;
}

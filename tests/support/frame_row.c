/* SPDX-License-Identifier: MIT */
#include "frame_row.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "drehgeber/hal.h"

#define QUARTER (INT64_C(1) << 30)

/* @return bits, of which there are `count` */
static uint64_t bits_of(const char *text, unsigned *count)
{
    uint64_t bits = 0;
    *count = 0;
    for (; *text != '\0'; text++) {
        if (*text != ' ') {
            bits = bits << 1 | (*text == '1');
            ++*count;
        }
    }
    return bits;
}

void frame_row_read(struct dg_host *host, uint64_t *now, struct dg_host_frame *frame)
{
    assert_int_equal(dg_host_frame(host, *now, frame), DG_HOST_OK);
    *now = frame->end + DG_MS(1);
}

void frame_row_compare(const struct dg_host_frame *frame, const struct frame_row *row)
{
    unsigned count = 0;
    const uint64_t want = bits_of(row->bits, &count);
    if (frame->bits != want || frame->count != count) {
        fail_msg("%s: expected %016llX (%u), got %016llX (%u)", row->figures,
                 (unsigned long long)want, count, (unsigned long long)frame->bits, frame->count);
    }
    assert_int_equal(frame->multiturn, row->turns);
    assert_int_equal(frame->singleturn, row->counts);
    assert_int_equal(frame->error, row->error);
    assert_int_equal(frame->good, !row->damaged);
}

void frame_row_check(struct dg_host *host, uint64_t *now, const struct frame_row *row)
{
    struct dg_host_frame frame = {.at = 0};
    dg_host_shaft(host, *now, row->quarters * QUARTER, 0);
    if (row->bent != NULL) {
        assert_int_equal(dg_host_world_set(host, *now, row->bent, row->value), DG_HOST_OK);
    }
    frame_row_read(host, now, &frame);
    frame_row_compare(&frame, row);
}

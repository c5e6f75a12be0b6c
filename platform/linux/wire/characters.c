/* SPDX-License-Identifier: MIT */
#include "characters.h"

#define ESCAPE 0xFFu

bool lx_parmrk_feed(struct lx_parmrk *self, uint8_t byte, struct lx_character *out)
{
    const uint8_t seen = self->seen;
    if (seen == 0 && byte == ESCAPE) {
        self->seen = 1;
        return false;
    }
    if (seen == 1 && byte == 0) {
        self->seen = 2;
        return false;
    }
    /* After one FF, everything but 00 stands for itself; the kernel only sends FF there. */
    self->seen = 0;
    out->byte = byte;
    out->damaged = seen == 2;
    return true;
}

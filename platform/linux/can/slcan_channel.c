/* SPDX-License-Identifier: MIT */
#include "slcan_channel.h"

void lx_slcan_check(struct lx_slcan_channel *self, const struct lx_say *say, uint16_t expected)
{
    if (self->codec.state == DG_SLCAN_CLOSED) {
        return;
    }
    const bool differs = self->codec.kbaud != 0 && self->codec.kbaud != expected;
    if (differs && !self->mismatch) {
        lx_note(say, "the master has opened the channel at %u kBd, the encoder expects %u kBd",
                self->codec.kbaud, expected);
    }
    self->mismatch = differs;
}

void lx_slcan_act(struct lx_slcan_channel *self, struct lx_can *can, dg_ns now,
                  const struct dg_slcan_event *event, bool switched)
{
    const struct lx_can_setup *setup = &can->setup;
    if (event->has_frame) {
        setup->rx(setup->ctx, now, &event->frame);
        setup->settle(setup->ctx, now);
    } else if (event->extended) {
        setup->foreign(setup->ctx, DG_CAN_EXTENDED_BITS(1u, dg_can_bytes(&event->frame)));
    } else if (switched) {
        lx_slcan_check(self, setup->say, can->expected);
        setup->settle(setup->ctx, now);
    }
}

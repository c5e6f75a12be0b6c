/* SPDX-License-Identifier: MIT */
/* What a row has made of a CANopen encoder: its owner cannot have set that to something else. */
#include "verify_canopen.h"

/* What goes with the node number is delivered for one of them; the number itself is the encoder's own. */
static bool is_brought_back(const struct canopen *self, uint16_t index, uint8_t sub)
{
    const bool of_node = index == 0x100Bu || index == 0x1014u || (index >> 8 == 0x18u && sub == 1);
    return (index < BUS_FIRST || index > BUS_LAST) && (!of_node || self->node == ROW_NODE);
}

/* What was written, or brought back, is no longer what somebody may have changed before. */
bool verify_canopen_is_known(const struct canopen *self, const uint8_t *answer)
{
    const uint16_t index = (uint16_t)(answer[1] | (unsigned)answer[2] << 8);
    bool known = self->restored && is_brought_back(self, index, answer[3]);
    for (size_t i = 0; i < self->written_count; i++) {
        known = known || (self->written[i].index == index && self->written[i].sub == answer[3]);
    }
    return known;
}

/* A download was confirmed. */
void verify_canopen_remember(struct canopen *self, const struct cf_unit *answer)
{
    if (answer->id != SDO_ANSWER + ROW_NODE || answer->n != 8 || answer->bytes[0] != 0x60u) {
        return;
    }
    const struct object object = {
        .index = (uint16_t)(answer->bytes[1] | (unsigned)answer->bytes[2] << 8),
        .sub = answer->bytes[3],
    };
    self->loads = self->loads || object.index == 0x1011u;
    if (self->written_count < TOUCHED_MAX) {
        self->written[self->written_count++] = object;
    }
}

/* The encoder starts anew: with its own values, unless they were given up before. */
void verify_canopen_forget(struct canopen *self)
{
    self->written_count = 0;
    self->restored = self->restored || self->loads;
}

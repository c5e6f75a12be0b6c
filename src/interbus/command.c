/* SPDX-License-Identifier: MIT */
/*
 * From OUT to a handler and to the word that IN holds afterwards (manual 5.3).
 *
 *   answer       what the last command left: C..., E..., A... or an error; 0 in operation
 *   item         the read-out in force, shown in place of it; when it ends, `answer` shows again
 */
#include "interbus_private.h"

enum {
    P = IB_IN_POSITION,
    C = IB_IN_CAM,
};

#define DG_IB_COMMAND(mask, value, modes, at_once, pattern, name, handler, answer, errors)         \
    {mask, value, modes, at_once, handler},

const struct ib_command dg_ib_commands[] = {
#include "commands.def"
};
#undef DG_IB_COMMAND
const uint8_t dg_ib_command_count = DG_COUNT(dg_ib_commands);

/* Row of a word in the mode in force, or NULL. */
static const struct ib_command *find_command(const struct dg_ib *self, uint32_t word)
{
    uint8_t mode = self->mode > DG_IB_CAM ? IB_IN_CAM : IB_IN_POSITION;

    for (uint8_t i = 0; i < dg_ib_command_count; i++) {
        const struct ib_command *row = &dg_ib_commands[i];
        if ((word & row->mask) == row->value && (row->modes & mode) != 0) {
            return row;
        }
    }
    return NULL;
}

/* Bits 31..29 are 100 in every error, but for the read-out's. */
static bool is_error(uint32_t word)
{
    return word >> 29 == 4 || word >> 25 == DG_IB_UNKNOWN_ITEM >> 25;
}

void dg_ib_refuse(struct dg_ib *self, uint32_t word)
{
    self->answer = word;
    self->last_error = word;
    self->counters.refused++;
}

void dg_ib_sample(struct dg_ib *self, uint32_t out)
{
    bool rising = (out & ~self->out & IB_RELEASE) != 0;

    if (self->wait > 0) {
        self->counters.dropped++;
    }
    self->sampled = true;
    self->out = out;
    self->pending = out;
    if (out == IB_RELEASE && !rising) { /* I2: a level releases nothing */
        self->pending = 0;
        self->counters.releases_stale++;
    }
    const struct ib_command *row = find_command(self, self->pending);
    self->wait = row != NULL && row->at_once ? 1 : self->setup.model->param_cycles;
}

static void conclude_command(struct dg_ib *self, uint32_t result)
{
    if (self->item != 0) { /* the read-out's own error is shown by the item */
        self->answer = is_error(self->answer) ? 0 : self->answer;
    } else if (result != IB_ACCEPTED || is_error(self->answer)) {
        self->answer = result;
    }
    if (is_error(result)) {
        self->last_error = result;
        self->counters.refused++;
    } else {
        self->counters.commands++;
    }
}

void dg_ib_execute(struct dg_ib *self, dg_ns now)
{
    if (--self->wait > 0) {
        return;
    }
    const uint32_t word = self->pending;
    const struct ib_command *row = find_command(self, word);
    /* I12: every word ends the read-out but one in operation with bit 16 set. */
    if ((word & (IB_CODE_MASK | IB_READ_OUT_BIT)) != IB_READ_OUT_BIT) {
        self->item = 0;
    }
    uint32_t result = row == NULL ? DG_IB_UNKNOWN_CODE : row->handler(self, now, word);
    if ((word & IB_CODE_MASK) != 0) {
        self->last_command = word;
    }
    if (result != IB_IGNORED) {
        conclude_command(self, result);
    }
}

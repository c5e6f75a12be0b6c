/* SPDX-License-Identifier: MIT */
/*
 * The commands of the profile, and the manufacturer's outside the cams (manual 9.1, 9.2). Stored
 * first, in force afterwards: what the memory does not take is answered with 86000000h.
 */
#include "ib.h"

static uint32_t data_of(uint32_t word)
{
    return word & DG_IB_DATA_MASK;
}

static uint32_t answer(bool stored, uint32_t word)
{
    return stored ? word | IB_ANSWER_BITS : DG_IB_LOST;
}

uint32_t dg_ib_normal(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)self;
    (void)now;
    (void)word;
    return IB_IGNORED;
}

uint32_t dg_ib_release(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)now;
    (void)word;
    self->answer = 0;
    return IB_ACCEPTED;
}

/* Make the position at `now` the preset. */
static uint32_t apply_preset(struct dg_ib *self, dg_ns now, bool flag)
{
    uint32_t offset = dg_ib_preset_offset(self, now);

    if (!dg_ib_put_preset(self, self->preset, offset, flag)) {
        return DG_IB_LOST;
    }
    self->offset = offset;
    self->preset_flag = flag;
    return IB_ACCEPTED;
}

uint32_t dg_ib_activate_preset(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)word;
    if (!self->preset_flag) { /* I5 */
        self->counters.presets_unset++;
        return IB_IGNORED;
    }
    return apply_preset(self, now, false);
}

uint32_t dg_ib_fraba_preset(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)word;
    uint32_t result = apply_preset(self, now, self->preset_flag);
    self->frozen = result == IB_ACCEPTED;
    return result;
}

uint32_t dg_ib_set_steps(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t steps = data_of(word);

    (void)now;
    if (!dg_ib_fits(self->setup.model, steps, self->revolutions)) {
        return DG_IB_ILLEGAL_DATA;
    }
    bool stored = dg_ib_put_u32(self, DG_IB_REGION_STEPS, steps);
    self->steps = stored ? steps : self->steps;
    return answer(stored, word);
}

uint32_t dg_ib_set_revolutions(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t revolutions = data_of(word);

    (void)now;
    if (!dg_ib_fits(self->setup.model, self->steps, revolutions)) {
        return DG_IB_ILLEGAL_DATA;
    }
    bool stored = dg_ib_put_u32(self, DG_IB_REGION_REVOLUTIONS, revolutions);
    self->revolutions = stored ? revolutions : self->revolutions;
    return answer(stored, word);
}

uint32_t dg_ib_set_direction(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t direction = data_of(word);

    (void)now;
    if (direction != IB_CLOCKWISE && direction != IB_COUNTERCLOCKWISE) {
        return DG_IB_ILLEGAL_DATA;
    }
    bool stored = dg_ib_put_u8(self, DG_IB_REGION_DIRECTION, (uint8_t)direction);
    self->direction = stored ? (uint8_t)direction : self->direction;
    return answer(stored, word);
}

uint32_t dg_ib_set_preset(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t preset = data_of(word);

    (void)now;
    if (preset >= dg_ib_range(self)) {
        return DG_IB_ILLEGAL_DATA;
    }
    if (!dg_ib_put_preset(self, preset, self->offset, true)) {
        return DG_IB_LOST;
    }
    self->preset = preset;
    self->preset_flag = true;
    return answer(true, word);
}

uint32_t dg_ib_set_shift(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t shift = data_of(word);

    (void)now;
    if (shift >= dg_ib_range(self)) {
        return DG_IB_ILLEGAL_DATA;
    }
    bool stored = dg_ib_put_u32(self, DG_IB_REGION_SHIFT, shift);
    self->shift = stored ? shift : self->shift;
    return answer(stored, word);
}

uint32_t dg_ib_set_defaults(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)now;
    if (data_of(word) != 0) {
        return DG_IB_ILLEGAL_DATA;
    }
    return answer(dg_ib_put_defaults(self), word);
}

uint32_t dg_ib_set_mode(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint8_t mode = (word & 1u) != 0 ? DG_IB_SPEED : DG_IB_POSITION;

    (void)now;
    bool stored = dg_ib_put_u8(self, DG_IB_REGION_MODE, mode);
    self->mode = stored ? mode : self->mode;
    return answer(stored, word);
}

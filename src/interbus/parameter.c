/* SPDX-License-Identifier: MIT */
/*
 * The commands of the profile, and the manufacturer's outside the cams (manual 9.1, 9.2). Stored
 * first, in force afterwards: what the memory does not take is answered with 86000000h.
 *
 * Steps and revolutions are one gear factor, sent in two words (5.3), so neither can be judged by
 * itself: they wait, and with them every preset and shift that follows, for the release (I22).
 *
 *   02, 04          in its own range? --> sent.waits, answered unchecked
 *   08, 0A          a pair waits? yes --> sent.waits, answered unchecked; no --> checked, stored
 *   release         nothing of a pair waits --> operation
 *                   the pair and what was sent with it fit --> stored at once, operation
 *                   else --> all of it dropped, 82000000h
 */
#include "interbus_private.h"

#define STEPS_BIT IB_REGION_BIT(DG_IB_REGION_STEPS)
#define REVOLUTIONS_BIT IB_REGION_BIT(DG_IB_REGION_REVOLUTIONS)
#define PRESET_BIT IB_REGION_BIT(DG_IB_REGION_PRESET)
#define SHIFT_BIT IB_REGION_BIT(DG_IB_REGION_SHIFT)

static uint32_t data_of(uint32_t word)
{
    return word & DG_IB_DATA_MASK;
}

static uint32_t answer_command(bool stored, uint32_t word)
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

static bool pair_waits(const struct dg_ib_sent *sent)
{
    return (sent->waits & (STEPS_BIT | REVOLUTIONS_BIT)) != 0;
}

static uint32_t wait_for_release(struct dg_ib *self, unsigned bit, uint32_t word)
{
    self->sent.waits |= (uint8_t)bit;
    self->sent.judged |= (uint8_t)bit;
    return answer_command(true, word);
}

/* What was sent, and what is in force where nothing was. */
static struct dg_ib_sent complete_pair(const struct dg_ib *self)
{
    struct dg_ib_sent all = self->sent;

    all.steps = (all.waits & STEPS_BIT) != 0 ? all.steps : self->steps;
    all.revolutions = (all.waits & REVOLUTIONS_BIT) != 0 ? all.revolutions : self->revolutions;
    all.preset = (all.waits & PRESET_BIT) != 0 ? all.preset : self->preset;
    all.shift = (all.waits & SHIFT_BIT) != 0 ? all.shift : self->shift;
    return all;
}

static bool are_parameters_allowed(const struct dg_ib_model *model, const struct dg_ib_sent *all)
{
    if (!dg_ib_fits(model, all->steps, all->revolutions)) {
        return false;
    }
    uint32_t range = dg_ib_range_of(model, all->steps, all->revolutions);
    return ((all->judged & PRESET_BIT) == 0 || all->preset < range) &&
           ((all->judged & SHIFT_BIT) == 0 || all->shift < range);
}

uint32_t dg_ib_release(struct dg_ib *self, dg_ns now, uint32_t word)
{
    const struct dg_ib_sent all = complete_pair(self);

    (void)now;
    (void)word;
    self->answer = 0;
    self->sent = (struct dg_ib_sent){0}; /* whatever comes of it: the next release is a new one */
    if (!pair_waits(&all)) {
        return IB_ACCEPTED;
    }
    if (!are_parameters_allowed(self->setup.model, &all)) {
        return DG_IB_ILLEGAL_DATA;
    }
    return dg_ib_put_sent(self, &all) ? IB_ACCEPTED : DG_IB_LOST;
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

static uint32_t ignore_unset_preset(struct dg_ib *self)
{
    self->counters.presets_unset++;
    return IB_IGNORED;
}

/* The flag of a lost preset is clear, too. */
uint32_t dg_ib_activate_preset(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)word;
    return self->preset_flag ? apply_preset(self, now, false) : ignore_unset_preset(self); /* I5 */
}

uint32_t dg_ib_fraba_preset(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)word;
    if ((self->lost & PRESET_BIT) != 0) { /* I26 */
        return ignore_unset_preset(self);
    }
    uint32_t result = apply_preset(self, now, self->preset_flag);
    self->frozen = result == IB_ACCEPTED;
    return result;
}

uint32_t dg_ib_set_steps(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t steps = data_of(word);

    (void)now;
    if (steps < 1) {
        return DG_IB_ILLEGAL_DATA;
    }
    self->sent.steps = steps;
    return wait_for_release(self, STEPS_BIT, word);
}

uint32_t dg_ib_set_revolutions(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t revolutions = data_of(word);

    (void)now;
    if (revolutions < 1 || revolutions > self->setup.model->turns) {
        return DG_IB_ILLEGAL_DATA;
    }
    self->sent.revolutions = revolutions;
    return wait_for_release(self, REVOLUTIONS_BIT, word);
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
    return answer_command(stored, word);
}

uint32_t dg_ib_set_preset(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t preset = data_of(word);

    (void)now;
    if (pair_waits(&self->sent)) {
        self->sent.preset = preset;
        return wait_for_release(self, PRESET_BIT, word);
    }
    if (preset >= dg_ib_range(self)) {
        return DG_IB_ILLEGAL_DATA;
    }
    if (!dg_ib_put_preset(self, preset, self->offset, true)) {
        return DG_IB_LOST;
    }
    self->preset = preset;
    self->preset_flag = true;
    self->sent.judged |= PRESET_BIT;
    return answer_command(true, word);
}

uint32_t dg_ib_set_shift(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint32_t shift = data_of(word);

    (void)now;
    if (pair_waits(&self->sent)) {
        self->sent.shift = shift;
        return wait_for_release(self, SHIFT_BIT, word);
    }
    if (shift >= dg_ib_range(self)) {
        return DG_IB_ILLEGAL_DATA;
    }
    if (!dg_ib_put_u32(self, DG_IB_REGION_SHIFT, shift)) {
        return DG_IB_LOST;
    }
    self->shift = shift;
    self->sent.judged |= SHIFT_BIT;
    return answer_command(true, word);
}

uint32_t dg_ib_set_defaults(struct dg_ib *self, dg_ns now, uint32_t word)
{
    (void)now;
    if (data_of(word) != 0) {
        return DG_IB_ILLEGAL_DATA;
    }
    if (!dg_ib_put_defaults(self)) {
        return DG_IB_LOST;
    }
    self->sent = (struct dg_ib_sent){0};
    return answer_command(true, word);
}

uint32_t dg_ib_set_mode(struct dg_ib *self, dg_ns now, uint32_t word)
{
    uint8_t mode = (word & 1u) != 0 ? DG_IB_SPEED : DG_IB_POSITION;

    (void)now;
    bool stored = dg_ib_put_u8(self, DG_IB_REGION_MODE, mode);
    self->mode = stored ? mode : self->mode;
    return answer_command(stored, word);
}

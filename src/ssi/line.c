/* SPDX-License-Identifier: MIT */
/*
 * The line: edges, and the monoflop that tells where a word ends.
 *
 *   edge        f1      r1      r2            rn      rn+1    rn+2          tm after the last f
 *   state  IDLE | SHIFT | SHIFT | SHIFT | ... | SHIFT | SHIFT | SHIFT | ... | IDLE
 *   left        | n     | n-1   | n-2   | ... | 0     | n     | n-1   | ... |
 *   data   1    | 1     | MSB   | next  | ... | LSB   | 0     | MSB   | ... | 1
 *
 * With dg_ssi_model.once the word is not repeated: `left` stays 0 from rn on, and data is 0 from
 * rn+1 on.
 */
#include "ssi_private.h"

static bool in(uint32_t value, uint32_t low, uint32_t high)
{
    return value >= low && value <= high;
}

bool dg_ssi_model_ok(const struct dg_ssi_model *model)
{
    const uint32_t bits = (uint32_t)model->multiturn_bits + model->singleturn_bits;

    if (model->form != NULL) {
        return model->form->fits(model);
    }
    return in(bits, DG_SSI_BITS_MIN, DG_SSI_BITS_MAX) &&
           in(model->singleturn_bits, DG_SSI_SINGLETURN_BITS_MIN, DG_SSI_SINGLETURN_BITS_MAX) &&
           model->code < DG_SSI_CODE_COUNT && model->error_bit < DG_SSI_ERROR_BIT_COUNT &&
           model->parity < DG_SSI_PARITY_COUNT && model->monoflop >= DG_SSI_MONOFLOP_MIN_NS &&
           model->monoflop <= DG_SSI_MONOFLOP_MAX_NS;
}

int dg_ssi_init(struct dg_ssi *self, const struct dg_ssi_setup *setup)
{
    if (setup->model == NULL || setup->world == NULL || setup->world->angle == NULL ||
        !dg_ssi_model_ok(setup->model)) {
        return DG_ERR_ARGUMENT;
    }
    *self = (struct dg_ssi){.setup = *setup, .clock = true, .deadline = DG_NEVER};
    return DG_OK;
}

void dg_ssi_power_on(struct dg_ssi *self, dg_ns now)
{
    dg_ssi_power_off(self);
    self->state = DG_SSI_START;
    self->last = now;
    self->deadline = dg_after(now, self->setup.model->init);
}

void dg_ssi_power_off(struct dg_ssi *self)
{
    self->state = DG_SSI_OFF;
    self->deadline = DG_NEVER;
    self->data = false;
}

/* The 0 behind a word is on data: the word is over and the next one has not begun. */
static bool between_words(const struct dg_ssi *self)
{
    return self->left == self->bits && !self->data;
}

dg_ns dg_ssi_step(struct dg_ssi *self, dg_ns now)
{
    if (self->deadline > now || self->deadline == DG_NEVER) {
        return self->deadline;
    }
    if (self->state == DG_SSI_SHIFT && self->left != 0 && !between_words(self)) {
        self->counters.aborted++;
    }
    self->state = DG_SSI_IDLE;
    self->deadline = DG_NEVER;
    self->data = true;
    return DG_NEVER;
}

/* Each one sets off the monoflop anew. While the encoder starts it only puts off the end of that,
 * so that the first word is not answered from its middle on. */
static void falling(struct dg_ssi *self, dg_ns now)
{
    const dg_ns end = dg_after(now, self->setup.model->monoflop);

    switch (self->state) {
    case DG_SSI_OFF:
    case DG_SSI_STATE_COUNT:
        return;
    case DG_SSI_START:
        self->deadline = end > self->deadline ? end : self->deadline;
        return;
    case DG_SSI_IDLE:
        dg_ssi_latch(self, now);
        self->state = DG_SSI_SHIFT;
        break;
    case DG_SSI_SHIFT:
        self->counters.fast += now - self->fell < DG_SSI_PERIOD_MIN_NS ? 1u : 0u;
        break;
    }
    self->fell = now;
    self->deadline = end;
}

static void shift_out(struct dg_ssi *self)
{
    if (self->state != DG_SSI_SHIFT) {
        return;
    }
    if (self->left == 0) {
        self->left = self->setup.model->once ? 0 : self->bits;
        self->data = false;
        return;
    }
    self->counters.repeats += between_words(self) ? 1u : 0u;
    self->left--;
    self->data = (self->word >> self->left & 1u) != 0;
}

bool dg_ssi_clock(struct dg_ssi *self, dg_ns now, bool level)
{
    now = now > self->last ? now : self->last; /* earlier: no time has passed (time.h) */
    self->last = now;
    (void)dg_ssi_step(self, now);
    if (level != self->clock) {
        self->clock = level;
        if (level) {
            shift_out(self);
        } else {
            falling(self, now);
        }
    }
    return self->data;
}

bool dg_ssi_data(const struct dg_ssi *self)
{
    return self->data;
}

void dg_ssi_skip(struct dg_ssi *self, const struct dg_ssi_counters *each, uint64_t n)
{
    self->counters.frames += each->frames * (uint32_t)n;
    self->counters.repeats += each->repeats * (uint32_t)n;
    self->counters.aborted += each->aborted * (uint32_t)n;
    self->counters.fast += each->fast * (uint32_t)n;
}

uint8_t dg_ssi_frame(struct dg_ssi *self, dg_ns now, uint64_t *bits)
{
    (void)dg_ssi_step(self, now);
    if (self->state == DG_SSI_OFF || self->state == DG_SSI_START) {
        return 0;
    }
    dg_ssi_latch(self, now);
    *bits = self->word;
    return self->bits;
}

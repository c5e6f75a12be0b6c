/* SPDX-License-Identifier: MIT */
/*
 * Words of other forms, laid out by a text: of models that are texts only.
 */
#include "drehgeber/form.h"
#include "ssi_private.h"

/* Of an angle: below whole turns, and whole turns. */
#define TURN_BITS 32u

enum part { POSITION, ERROR, TOGGLE, POWER_FAIL, PARITY, PART_COUNT };

/* The parts that a word of this model can have. */
struct parts {
    struct dg_form form;
    struct dg_form_part list[PART_COUNT];
};

static void make_ssi_parts(const struct dg_ssi_model *model, struct parts *to)
{
    *to = (struct parts){
        .form = {.layout = model->form->layout, .parts = to->list, .count = PART_COUNT},
        .list = {[POSITION] = {'P', ssi_position_bits(model), 0},
                 [ERROR] = {'E', 1, 0},
                 [TOGGLE] = {'T', 1, 0},
                 [POWER_FAIL] = {'F', 1, 0},
                 [PARITY] = {'Y', 1, 0}},
    };
}

static uint64_t gray_of(uint64_t binary)
{
    return binary ^ binary >> 1;
}

static uint64_t binary_of(uint64_t gray)
{
    uint64_t binary = 0;

    /* Each bit is the parity of all bits from it upwards. */
    for (; gray != 0; gray >>= 1) {
        binary ^= gray;
    }
    return binary;
}

static uint64_t word_parity_of(const struct dg_ssi_model *model, const struct parts *parts)
{
    const uint64_t over = model->form->parity_over != 0 ? parts->list[POSITION].value
                                                        : dg_form_pack(&parts->form, 'Y').bits;

    /* The lowest bit of a number taken for Gray code is the parity of all its bits. */
    return (binary_of(over) & 1u) ^ (model->parity == DG_SSI_PARITY_ODD ? 1u : 0u);
}

static bool is_high(const struct dg_ssi_model *model)
{
    return model->error_bit == DG_SSI_ERROR_HIGH;
}

/* But for the widths all figures are those of a model without a form. */
bool dg_ssi_layout_fits(const struct dg_ssi_model *model)
{
    struct dg_ssi_model usual = *model;

    usual.form = NULL;
    usual.multiturn_bits = 0;
    usual.singleturn_bits = DG_SSI_SINGLETURN_BITS_MAX;
    return model->multiturn_bits <= DG_SSI_FORM_PART_BITS_MAX && model->singleturn_bits >= 1u &&
           model->singleturn_bits <= DG_SSI_FORM_PART_BITS_MAX &&
           dg_ssi_word_bits(model) <= DG_SSI_FORM_BITS_MAX && dg_ssi_model_ok(&usual);
}

/* Counts of a power of two are the upper bits of the angle, as many turns as there are bits for in
 * front of them; also below 0. */
uint64_t dg_ssi_layout_find_position(const struct dg_ssi *self, dg_ns now)
{
    const struct dg_ssi_model *model = self->setup.model;
    const uint64_t angle = (uint64_t)dg_world_angle(self->setup.world, now);

    return angle << (TURN_BITS - model->multiturn_bits) >>
           (2u * TURN_BITS - ssi_position_bits(model));
}

/* The toggle bit changes with each position that is stored. */
uint8_t dg_ssi_layout_make_word(const struct dg_ssi *self, uint8_t errors, uint64_t *word)
{
    const struct dg_ssi_model *model = self->setup.model;
    const bool error = errors != 0;
    struct parts parts;

    make_ssi_parts(model, &parts);
    parts.list[POSITION].value =
        model->code == DG_SSI_GRAY ? gray_of(self->position) : self->position;
    parts.list[ERROR].value = error == is_high(model) ? 1u : 0u;
    parts.list[TOGGLE].value = self->counters.frames & 1u;
    parts.list[POWER_FAIL].value = (errors & DG_SSI_SUPPLY) != 0 ? 1u : 0u;
    parts.list[PARITY].value =
        word_parity_of(model, &parts) ^ (error && model->form->error_parity ? 1u : 0u);
    const struct dg_form_word whole = dg_form_pack(&parts.form, '\0');
    *word = whole.bits;
    return whole.count;
}

/* An error that inverts the parity cannot be told from a word that was damaged. */
int dg_ssi_layout_take_apart(const struct dg_ssi_model *model, uint64_t bits,
                             struct dg_ssi_frame *frame)
{
    const char *layout = model->form->layout;
    struct parts parts;

    make_ssi_parts(model, &parts);
    const struct dg_form_word whole = dg_form_pack(&parts.form, '\0');
    const uint64_t word = bits & UINT64_MAX >> (DG_SSI_FORM_BITS_MAX - whole.count);
    dg_form_unpack(&parts.form, word);
    const uint64_t coded = parts.list[POSITION].value;
    frame->position = model->code == DG_SSI_GRAY ? binary_of(coded) : coded;
    frame->multiturn = (uint32_t)(frame->position >> model->singleturn_bits);
    frame->singleturn =
        (uint32_t)frame->position & UINT32_MAX >> (TURN_BITS - model->singleturn_bits);
    frame->error = dg_form_has(layout, 'E') && (parts.list[ERROR].value != 0) == is_high(model);
    frame->toggle = parts.list[TOGGLE].value != 0;
    frame->power_fail = parts.list[POWER_FAIL].value != 0;
    parts.list[PARITY].value = word_parity_of(model, &parts);
    return dg_form_pack(&parts.form, '\0').bits == word ? DG_OK : DG_ERR_DAMAGED;
}

const struct dg_ssi_form dg_ssi_any_form = {
    .fits = dg_ssi_layout_fits,
    .find_position = dg_ssi_layout_find_position,
    .make_word = dg_ssi_layout_make_word,
    .take_apart = dg_ssi_layout_take_apart,
};

const char *dg_ssi_form_settle(const struct dg_ssi_model *model, struct dg_ssi_form *form)
{
    const char *layout = form->layout;
    struct parts parts;

    make_ssi_parts(model, &parts);
    if (!dg_form_has(layout, 'P') || !dg_form_fits(&parts.form, DG_SSI_FORM_BITS_MAX)) {
        return "a frame of P and any of E T F Y, each once, 0 and 1, together at most 64 bits";
    }
    if (dg_form_has(layout, 'E') != (model->error_bit != DG_SSI_ERROR_NONE)) {
        return "E in the frame and error_bit = high or low, or neither";
    }
    if (dg_form_has(layout, 'Y') != (model->parity != DG_SSI_PARITY_NONE)) {
        return "Y in the frame and parity = even or odd, or neither";
    }
    if (!dg_form_has(layout, 'Y') && (form->parity_over != 0 || form->error_parity)) {
        return "Y in the frame, which parity_over and error_parity are about";
    }
    form->around = (uint8_t)(dg_form_pack(&parts.form, '\0').count - ssi_position_bits(model));
    return NULL;
}

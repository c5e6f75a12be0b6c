/* SPDX-License-Identifier: MIT */
/*
 * Frames of other forms, laid out by a text: of models that are texts only.
 */
#include "drehgeber/form.h"
#include "biss_private.h"

enum part { POSITION, ERROR, WARNING, LIFE, CRC, PART_COUNT };

/* The parts that a frame of this model can have. */
struct parts {
    struct dg_form form;
    struct dg_form_part list[PART_COUNT];
};

/* The polynomial has one bit more. */
static uint8_t crc_bits(const struct dg_biss_form *form)
{
    uint8_t bits = 0;

    while (form->crc_poly >> bits > 1u) {
        bits++;
    }
    return bits;
}

static uint8_t turns_and_counts(const struct dg_biss_model *model)
{
    return (uint8_t)(model->multiturn_bits + model->singleturn_bits);
}

static void make_biss_parts(const struct dg_biss_model *model, struct parts *to)
{
    *to = (struct parts){
        .form = {.layout = model->form->layout, .parts = to->list, .count = PART_COUNT},
        .list = {[POSITION] = {'P', turns_and_counts(model), 0},
                 [ERROR] = {'E', 1, 0},
                 [WARNING] = {'W', 1, 0},
                 [LIFE] = {'L', DG_BISS_LIFE_BITS, 0},
                 [CRC] = {'C', crc_bits(model->form), 0}},
    };
}

/* Bit by bit: which polynomial it is, nobody knows before. */
static uint32_t crc_of(const struct dg_biss_form *form, struct dg_form_word word)
{
    const uint8_t bits = crc_bits(form);
    const uint32_t mask = ((uint32_t)1 << bits) - 1u;
    uint32_t crc = form->crc_start & mask;

    for (uint8_t i = word.count; i > 0; i--) {
        const uint32_t carry = (crc >> (bits - 1u) ^ (uint32_t)(word.bits >> (i - 1u))) & 1u;
        crc = (crc << 1 ^ (carry != 0 ? form->crc_poly : 0u)) & mask;
    }
    return form->crc_plain ? crc : crc ^ mask;
}

bool dg_biss_layout_fits(const struct dg_biss_model *model)
{
    return model->multiturn_bits <= DG_BISS_MULTITURN_BITS_MAX &&
           model->singleturn_bits >= DG_BISS_SINGLETURN_BITS_MIN &&
           model->singleturn_bits <= DG_BISS_SINGLETURN_BITS_MAX &&
           dg_biss_frame_bits(model) <= DG_BISS_FRAME_BITS_MAX;
}

uint8_t dg_biss_layout_make_frame(const struct dg_biss *self, uint8_t flags, uint64_t *bits)
{
    const struct dg_biss_model *model = self->setup.model;
    const bool n_err = (flags & 2u) != 0;
    const bool n_warn = (flags & 1u) != 0;
    struct parts parts;

    make_biss_parts(model, &parts);
    parts.list[POSITION].value = self->position;
    parts.list[ERROR].value = n_err != model->form->error_high ? 1u : 0u;
    parts.list[WARNING].value = n_warn != model->form->warning_high ? 1u : 0u;
    parts.list[LIFE].value = self->life;
    parts.list[CRC].value = crc_of(model->form, dg_form_pack(&parts.form, 'C'));
    const struct dg_form_word frame = dg_form_pack(&parts.form, '\0');
    *bits = frame.bits;
    return frame.count;
}

/* The level that a part without polarity would have; one that is not sent says nothing is wrong. */
static bool bit_level_of(const struct parts *parts, enum part part, bool high)
{
    return !dg_form_has(parts->form.layout, parts->list[part].letter) ||
           (parts->list[part].value != 0) != high;
}

/* Over the bits that came, and not over what they were taken for: of constants, too. */
static bool crc_fits(const struct dg_biss_model *model, const struct parts *parts, uint64_t bits)
{
    const uint8_t count = dg_biss_frame_bits(model);
    struct dg_form_word front = dg_form_pack(&parts->form, 'C');

    front.bits = (bits & UINT64_MAX >> (64u - count)) >> (count - front.count);
    return !dg_form_has(parts->form.layout, 'C') ||
           parts->list[CRC].value == crc_of(model->form, front);
}

void dg_biss_layout_take_apart(const struct dg_biss_model *model, uint64_t bits,
                               struct dg_biss_data *out)
{
    const struct dg_biss_form *form = model->form;
    struct parts parts;

    make_biss_parts(model, &parts);
    dg_form_unpack(&parts.form, bits);
    const uint64_t position = parts.list[POSITION].value;
    const uint64_t mask = ((uint64_t)1 << model->singleturn_bits) - 1u;
    *out = (struct dg_biss_data){
        .position = position,
        .multiturn = (uint32_t)(position >> model->singleturn_bits),
        .singleturn = (uint32_t)(position & mask),
        .life = (uint8_t)parts.list[LIFE].value,
        .n_err = bit_level_of(&parts, ERROR, form->error_high),
        .n_warn = bit_level_of(&parts, WARNING, form->warning_high),
        .crc_ok = crc_fits(model, &parts, bits),
    };
}

const struct dg_biss_form dg_biss_any_form = {
    .fits = dg_biss_layout_fits,
    .make_frame = dg_biss_layout_make_frame,
    .take_apart = dg_biss_layout_take_apart,
    .crc_poly = 0x43,
};

const char *dg_biss_form_settle(const struct dg_biss_model *model, struct dg_biss_form *form)
{
    struct parts parts;

    make_biss_parts(model, &parts);
    if (!dg_form_has(form->layout, 'P') || !dg_form_fits(&parts.form, DG_BISS_FRAME_BITS_MAX)) {
        return "a frame of P and any of E W L C, each once, 0 and 1, together at most 63 bits";
    }
    if (dg_form_has(form->layout, 'L') != model->life_counter) {
        return "L in the frame and lc = 1, or neither";
    }
    if (form->crc_start >> crc_bits(form) != 0) {
        return "crc_start with at most as many bits as crc_poly has after its first 1";
    }
    form->around = (uint8_t)(dg_form_pack(&parts.form, '\0').count - turns_and_counts(model));
    return NULL;
}

/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: behind the figures of all SSI encoders stand those of words that are laid
 * out otherwise.
 */
#include <string.h>

#include "drehgeber/model.h"
#include "drehgeber/text.h"
#include "ssi_private.h"

struct text_model {
    struct dg_ssi_model model;
    struct dg_ssi_form form;
};

static const char *const parities_over[2] = {"word", "position"};

#define AT(field) offsetof(struct text_model, field)

/* clang-format off */
static const struct dg_key rows[] = {
    /* name          unit offset                type         places factor min max words       help */
    {"frame",        "",  AT(form.layout),       DG_KEY_TEXT, 0, 1, 0, DG_FORM_MAX, NULL,      "parts of the word as they are sent: P position, E error, T toggle, F supply too low, Y parity, 0 and 1 as they are"},
    {"parity_over",  "",  AT(form.parity_over),  DG_KEY_WORD, 0, 1, 0,           1, parities_over, "what the parity bit of a frame is about: all bits in front of it, or the position"},
    {"error_parity", "",  AT(form.error_parity), DG_KEY_FLAG, 0, 1, 0,           1, dg_key_no_yes, "an error inverts the parity bit of a frame"},
};
/* clang-format on */
static const struct dg_keys more = {rows, DG_COUNT(rows)};

static void copy(void *to, const void *from)
{
    struct text_model *self = to;
    const struct dg_ssi_model *base = from;

    *self = (struct text_model){.model = *base};
    self->form = base->form == NULL ? dg_ssi_any_form : *base->form;
}

/* The order of parts without a form, by whether there is an error bit, and a parity bit. */
static const char usual_layouts[2][2][4] = {{"P", "PY"}, {"PE", "PEY"}};

static bool is_usual_layout(const char *layout)
{
    bool usual = layout[0] == '\0';

    for (size_t i = 0; i < 4u; i++) {
        usual = usual || dg_text_same(layout, usual_layouts[i / 2u][i % 2u], SIZE_MAX, NULL);
    }
    return usual;
}

/* A layout that is as without a form is one when the position is wider than that can be. */
static const char *settle_model(void *model)
{
    struct text_model *self = model;
    const bool error = self->model.error_bit != DG_SSI_ERROR_NONE;
    const bool parity = self->model.parity != DG_SSI_PARITY_NONE;
    const bool plain = self->form.parity_over == 0 && !self->form.error_parity;
    char *layout = self->form.layout;

    if (is_usual_layout(layout)) {
        memset(layout, 0, sizeof self->form.layout);
        memcpy(layout, usual_layouts[error][parity], sizeof usual_layouts[0][0]);
        self->model.form = NULL;
        if (plain && dg_ssi_model_ok(&self->model)) {
            return NULL;
        }
    }
    self->model.form = &self->form;
    return dg_ssi_form_settle(&self->model, &self->form);
}

const struct dg_model_text dg_ssi_model_text = {
    .stack = &dg_ssi_stack,
    .keys = &dg_ssi_keys,
    .own_size = sizeof(struct dg_ssi_model),
    .more = &more,
    .size = sizeof(struct text_model),
    .copy = copy,
    .settle = settle_model,
};

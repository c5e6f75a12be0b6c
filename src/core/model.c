/* SPDX-License-Identifier: MIT */
#include "drehgeber/model.h"
#include "drehgeber/text.h"

/* Settings of an encoder begin with its model; what lies behind that is the encoder's own. */
static const struct dg_key *figure_in(const struct dg_keys *keys, size_t size, size_t *index)
{
    for (size_t i = 0; keys != NULL && i < keys->count; i++) {
        const bool figure = keys->rows[i].offset < size;
        if (figure && *index == 0) {
            return &keys->rows[i];
        }
        *index -= figure ? 1u : 0u;
    }
    return NULL;
}

const struct dg_key *dg_model_figure_at(const struct dg_model_text *self, size_t index)
{
    const struct dg_key *row = figure_in(self->keys, self->own_size, &index);

    return row != NULL ? row : figure_in(self->more, self->size, &index);
}

const struct dg_key *dg_model_figure(const struct dg_model_text *self, const char *name)
{
    const struct dg_key *row = dg_model_figure_at(self, 0);

    for (size_t i = 1; row != NULL && !dg_text_same(row->name, name, SIZE_MAX, NULL); i++) {
        row = dg_model_figure_at(self, i);
    }
    return row;
}

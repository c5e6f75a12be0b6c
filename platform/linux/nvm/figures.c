/* SPDX-License-Identifier: MIT */
#include "figures.h"

/* How many are told. */
#define FIGURES_TOLD 8u

struct telling {
    struct lx_words *to;
    unsigned count;
};

static void tell_figure(void *ctx, const struct dg_model_misfit *misfit)
{
    struct telling *self = ctx;
    if (self->count++ < FIGURES_TOLD) {
        lx_words_add(self->to, "%s%s: %s, expected %s", self->count == 1 ? "" : "; ", misfit->key,
                     misfit->found == NULL ? "none" : misfit->found,
                     misfit->expected == NULL ? "none" : misfit->expected);
    }
}

bool lx_figures_differ(const struct dg_model_stamp *model, struct dg_nvm image, struct lx_words *to)
{
    struct telling self = {.to = to};
    const int result = dg_model_stamp_compare(model, image, tell_figure, &self);
    if (self.count > FIGURES_TOLD) {
        lx_words_add(to, " and %u more", self.count - FIGURES_TOLD);
    }
    if (self.count == 0) {
        lx_words_add(to, "those of a built-in model");
    }
    return result == DG_ERR_ARGUMENT || result == DG_ERR_OLDER;
}

/* SPDX-License-Identifier: MIT */
/** Figures of a model or a world that steps name: `figure=value`. */
#ifndef DREHGEBER_VERIFY_ROW_FIGURES_H
#define DREHGEBER_VERIFY_ROW_FIGURES_H

#include <stdbool.h>
#include <stddef.h>

/** What stands in the field: a number, a truth, a time given in us or ms, or a text. */
enum cf_kind { CF_U8, CF_I16, CF_U16, CF_U32, CF_I32, CF_BOOL, CF_US, CF_MS, CF_TEXT };

/** A field of a struct; a table of them ends with a name of NULL. */
struct cf_figure {
    const char *name;
    size_t offset;
    size_t size;
    enum cf_kind kind;
};

/** A row: CF_FIGURE("init_ms", dg_hf_model, init, MS). */
#define CF_FIGURE(name, type, field, kind)                                                         \
    {                                                                                              \
        name, offsetof(struct type, field), sizeof((struct type *)0)->field, CF_##kind             \
    }

/** What an encoder senses, of struct dg_world, under the names of its fields. */
extern const struct cf_figure cf_world_figures[];

/** The figure of this name, of which the first `n` characters count, or NULL. */
const struct cf_figure *cf_find_figure(const struct cf_figure *figures, const char *name, size_t n);

/** Set what `word`, `figure=value`, says. @return false if there is no such figure */
bool cf_set_figure(const struct cf_figure *figures, void *object, const char *word);

#endif

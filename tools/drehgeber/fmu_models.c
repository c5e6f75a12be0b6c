/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "fmu_models.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/crc.h"
#include "drehgeber/drehgeber.h"
#include "eds_file.h"
#include "models.h"

/* Longest value of a figure, with its zero: one more is too long for a token. */
#define VALUE_MAX FMU_NAME_MAX

void fmu_put_escaped(const char *text, FILE *to)
{
    for (; *text != '\0'; text++) {
        if (isalnum((unsigned char)*text) || strchr("._-", *text) != NULL) {
            (void)fputc(*text, to);
        } else {
            (void)fprintf(to, "%%%02X", (unsigned)(unsigned char)*text);
        }
    }
}

/* --- files --- */

static char *read_resource(void *ctx, const char *name, size_t *n)
{
    const struct fmu_models *self = ctx;
    for (size_t i = 0; i < self->count; i++) {
        const struct fmu_resource *row = &self->resources[i];
        char *copy = strcmp(row->name, name) == 0 ? malloc(row->n + 1u) : NULL;
        if (copy != NULL) {
            memcpy(copy, row->bytes, row->n);
            *n = row->n;
            return copy;
        }
    }
    return NULL;
}

void fmu_models_begin(struct fmu_models *self, const struct options *options,
                      const struct dg_plan *plan)
{
    *self = (struct fmu_models){
        .options = options, .plan = plan, .files = {.read = read_resource, .ctx = self}};
}

void fmu_models_end(struct fmu_models *self)
{
    for (size_t i = 0; i < self->count; i++) {
        free(self->resources[i].bytes);
    }
    free(self->resources);
}

const char *fmu_models_add(struct fmu_models *self, const char *kind, const char *text, size_t n)
{
    struct fmu_resource one = {.n = n};
    const uint32_t sum = dg_crc32(0, (const uint8_t *)text, n);
    (void)snprintf(one.name, sizeof one.name, "%08" PRIX32 ".%s", sum, kind);
    for (size_t i = 0; i < self->count; i++) {
        if (strcmp(self->resources[i].name, one.name) == 0) {
            return self->resources[i].name;
        }
    }
    struct fmu_resource *more =
        reallocarray(self->resources, self->count + 1u, sizeof *self->resources);
    self->resources = more == NULL ? self->resources : more;
    one.bytes = more == NULL ? NULL : malloc(n + 1u);
    if (one.bytes == NULL) {
        return NULL;
    }
    memcpy(one.bytes, text, n);
    self->resources[self->count++] = one;
    return self->resources[self->count - 1u].name;
}

/* Of the command line: those of a rig are texts of its. */
static int put_eds_file(struct fmu_models *self, const struct dg_device *model, FILE *to,
                        struct lx_error *error)
{
    const struct eds_file *file = self->options->eds;
    if (file == NULL || &file->encoder.device != model) {
        return lx_fail(error, "%s: an FMU cannot have this model", model->name);
    }
    const char *name = fmu_models_add(self, "eds", file->text, file->length);
    if (name == NULL) {
        return lx_fail(error, "no memory for %s", model->name);
    }
    (void)fputs(name, to);
    return 0;
}

/* --- texts --- */

static const struct dg_plan_model *row_in(const struct dg_plan *plan, const struct dg_device *model)
{
    for (size_t i = 0; i < plan->model_count; i++) {
        if (plan->models[i].device == model) {
            return &plan->models[i];
        }
    }
    return NULL;
}

/* The section of a model: of the rig, of the file that was named, of those whose models it names.
 */
static const struct dg_plan_model *section_of(const struct fmu_models *self,
                                              const struct dg_device *model)
{
    const struct dg_plan_model *row = row_in(self->plan, model);
    const struct model_file *file = self->options->file;
    while (row == NULL && file != NULL) {
        row = row_in(&file->plan, model);
        file = file->others != NULL ? file->others : file->next;
    }
    return row;
}

/* As the base is without the heirlooms that `model` does not have. @return to be freed */
static void *make_trial(const struct dg_model_text *text, const struct dg_device *base,
                        const struct dg_device *model, FILE *to)
{
    void *trial = calloc(1, text->size);
    void *copy = calloc(1, text->size);
    if (trial != NULL && copy != NULL) {
        if (text->copy != NULL) {
            text->copy(trial, base->model);
        } else {
            memcpy(trial, base->model, text->own_size);
        }
    }
    for (size_t i = 0; copy != NULL && text->heirlooms != NULL && text->heirlooms[i] != NULL; i++) {
        memcpy(copy, model->model, text->size);
        text->drop(copy, i);
        if (trial != NULL && memcmp(copy, model->model, text->size) == 0) { /* it was out */
            text->drop(trial, i);
            (void)fprintf(to, ";-%s", text->heirlooms[i]);
        }
    }
    free(copy);
    return trial;
}

static int put_model_text(const struct dg_device *base, const struct dg_device *model, FILE *to,
                          struct lx_error *error)
{
    const struct dg_model_text *text = dg_model_text_of(base->stack);
    (void)fprintf(to, "%s:%s", model->name, base->name);
    void *trial = make_trial(text, base, model, to);
    if (trial == NULL) {
        return lx_fail(error, "no memory for %s", model->name);
    }
    const struct dg_key *figure = dg_model_figure_at(text, 0);
    for (size_t i = 1; figure != NULL; i++) {
        char is[VALUE_MAX];
        char was[VALUE_MAX];
        const bool told = dg_key_get(figure, model->model, is, sizeof is) >= 0 &&
                          dg_key_get(figure, trial, was, sizeof was) >= 0;
        if (told && strcmp(is, was) != 0) {
            (void)fprintf(to, ";%s=", figure->name);
            fmu_put_escaped(is, to);
        }
        figure = dg_model_figure_at(text, i);
    }
    free(trial);
    return 0;
}

int fmu_models_put(struct fmu_models *self, const struct dg_device *model, FILE *to,
                   struct lx_error *error)
{
    const struct dg_device *base = model;
    const struct dg_plan_model *row = NULL;
    do {
        row = section_of(self, base);
        base = row == NULL ? base : row->base;
    } while (row != NULL);
    if (dg_device_find(base->name) != base) {
        return put_eds_file(self, model, to, error);
    }
    if (base == model) {
        (void)fputs(model->name, to);
        return 0;
    }
    return put_model_text(base, model, to, error);
}

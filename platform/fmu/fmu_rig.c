/* SPDX-License-Identifier: MIT */
/*
 * A rig as its file says: the library reads the texts, and here is what an importer sees of it.
 */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/hal.h"
#include "fmu_engine.h"

/* Memory for a plan: to begin with, and where it ends. */
#define PLAN_MIN ((size_t)65536)
#define PLAN_MAX ((size_t)1 << 28)

/* --- the plan --- */

static const char *find_bundled_text(void *ctx, const char *path, struct dg_plan_text *to)
{
    const struct fmu_rig *self = ctx;
    return fmu_bundle_part(&self->bundle, "file", path, to, NULL) ? NULL : "it is not in the FMU";
}

/* Its text has to end with a zero. */
static const struct dg_device *make_shelf_model(struct fmu_rig *self,
                                                const struct dg_plan_text *text)
{
    struct shelf_model *row = calloc(1, sizeof *row);
    char *copy = calloc(1, text->n + 1u);
    const char *end = NULL;
    if (row != NULL && copy != NULL) {
        memcpy(copy, text->text, text->n);
        end = encoder_take_model(&row->of, copy, NULL);
    }
    free(copy);
    if (row != NULL) {
        row->next = self->models;
        self->models = row;
    }
    return end == NULL ? NULL : row->of.device;
}

static const struct dg_device *find_shelf_model(void *ctx, const char *name)
{
    struct fmu_rig *self = ctx;
    struct dg_plan_text text;
    for (const struct shelf_model *row = self->models; row != NULL; row = row->next) {
        if (strcmp(row->of.model, name) == 0) {
            return row->of.device;
        }
    }
    return fmu_bundle_part(&self->bundle, "model", name, &text, NULL)
               ? make_shelf_model(self, &text)
               : NULL;
}

/* In as much memory as it takes. */
static bool read_bundled_plan(struct fmu_rig *self)
{
    struct dg_plan_error ignored;
    struct dg_plan_text called;
    struct dg_plan_setup setup = {.size = sizeof setup,
                                  .include = find_bundled_text,
                                  .find_model = find_shelf_model,
                                  .ctx = self};
    int result = DG_ERR_SPACE;
    if (!fmu_bundle_part(&self->bundle, "file", NULL, &setup.text, &called)) {
        return false;
    }
    self->file = calloc(1, called.n + 1u);
    if (self->file == NULL) {
        return false;
    }
    memcpy(self->file, called.text, called.n);
    setup.file = self->file;
    for (size_t n = PLAN_MIN; result == DG_ERR_SPACE && n <= PLAN_MAX; n *= 2u) {
        free(self->plan_memory);
        self->plan_memory = setup.memory = malloc(n);
        setup.memory_size = n;
        result = setup.memory == NULL ? DG_ERR_ARGUMENT
                                      : dg_plan_read(&self->plan, &setup,
                                                     self->error != NULL ? self->error : &ignored);
    }
    return result == DG_OK && self->plan.encoder_count > 0;
}

/* --- its parts as an importer sees them --- */

/* As names of variables may be, with a stop behind it. */
static void put_prefix(const char *name, const char *behind, char to[FMU_NAME_MAX])
{
    size_t n = 0;
    if (isdigit((unsigned char)*name)) {
        to[n++] = '_';
    }
    for (; *name != '\0' && n + 1u < FMU_NAME_MAX; name++) {
        to[n++] = (char)(isalnum((unsigned char)*name) ? *name : '_');
    }
    (void)snprintf(to + n, FMU_NAME_MAX - n, "%s", behind);
}

static size_t first_on_shaft(const struct dg_plan *plan, size_t shaft)
{
    size_t i = 0;
    while (i < plan->encoder_count && plan->encoders[i].shaft != shaft) {
        i++;
    }
    return i < plan->encoder_count ? i : FMU_NOBODY;
}

static void describe_shafts(struct fmu *all, const struct dg_plan *plan)
{
    for (size_t i = 0; i < plan->shaft_count; i++) {
        struct fmu_shaft *shaft = &all->shafts[i];
        shaft->first = first_on_shaft(plan, i);
        shaft->input = plan->shafts[i].motion == NULL && plan->shafts[i].driver < 0;
        if (shaft->first == FMU_NOBODY) {
            put_prefix(plan->shafts[i].name, ".", shaft->prefix);
        } else if (plan->encoder_count == 1) {
            (void)snprintf(shaft->prefix, sizeof shaft->prefix, "shaft.");
        } else {
            put_prefix(plan->encoders[shaft->first].name, ".shaft.", shaft->prefix);
        }
    }
}

/* Behind all gears. */
static size_t turning_shaft(const struct dg_plan *plan, size_t shaft)
{
    while (plan->shafts[shaft].driver >= 0) {
        shaft = (size_t)plan->shafts[shaft].driver;
    }
    return shaft;
}

/* The first one on a wire has room for what all of them send. */
static bool describe_encoder(struct fmu *all, const struct dg_plan *plan, size_t index)
{
    const struct dg_plan_encoder *row = &plan->encoders[index];
    const struct dg_plan_wire *wire = &plan->wires[row->wire];
    struct fmu_encoder *encoder = &all->encoders[index];
    struct rig_wire *door = &all->rig->wires[row->wire];
    encoder->all = all;
    encoder->shaft = turning_shaft(plan, row->shaft);
    encoder->shares = wire->encoder_count > 1;
    encoder->leads = door->leader == NULL;
    if (plan->encoder_count > 1) {
        put_prefix(row->name, ".", encoder->prefix);
        put_prefix(encoder->shares ? wire->name : row->name, ".", encoder->wire);
    }
    (void)snprintf(encoder->model, sizeof encoder->model, "%.39s", row->model->name);
    if (!encoder->leads) {
        return true;
    }
    *door = (struct rig_wire){all, row->wire, encoder};
    return encoder_make_room(encoder, wire->encoder_count,
                             row->model->stack->medium == DG_MEDIUM_CHARACTERS);
}

static bool describe_rig(struct fmu *all)
{
    const struct dg_plan *plan = &all->rig->plan;
    bool good = true;
    all->rig->wires = calloc(plan->wire_count, sizeof *all->rig->wires);
    all->encoders = calloc(plan->encoder_count, sizeof *all->encoders);
    all->shafts = calloc(plan->shaft_count, sizeof *all->shafts);
    if (all->rig->wires == NULL || all->encoders == NULL || all->shafts == NULL) {
        return false;
    }
    all->count = plan->encoder_count;
    all->shaft_count = plan->shaft_count;
    describe_shafts(all, plan);
    for (size_t i = 0; i < plan->encoder_count; i++) {
        good = describe_encoder(all, plan, i) && good;
    }
    return good;
}

bool fmu_rig_read(struct fmu *self, const char *name, const struct fmu_files *files)
{
    struct fmu_rig *rig = calloc(1, sizeof *rig);
    if (rig == NULL) {
        return false;
    }
    self->ops = &fmu_rig_ops;
    self->rig = rig;
    rig->error = files == NULL ? NULL : files->error;
    char *text = fmu_read_file(files, name, &rig->bundle.n);
    rig->bundle.text = text == NULL ? NULL : realloc(text, rig->bundle.n + 1u);
    if (rig->bundle.text == NULL) {
        free(text);
        return false;
    }
    rig->bundle.text[rig->bundle.n] = '\0';
    return read_bundled_plan(rig) && describe_rig(self);
}

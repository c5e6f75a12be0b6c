/* SPDX-License-Identifier: MIT */
/*
 * [model NAME] of a rig file: an encoder as it can be ordered. It is a copy of its base, in the
 * memory of the plan, in which the words of the section have become figures.
 */
#include "drehgeber/model.h"
#include "drehgeber/stamp.h"
#include "rig_private.h"

#include <string.h>

const struct dg_device *dg_plan_find_model(const struct dg_plan *self, const char *name)
{
    const int at =
        dg_plan_names_find(self, &(struct dg_plan_name){.list = RIG_MODEL, .text = name});

    const struct dg_device *device = at < 0 ? dg_device_find(name) : self->models[at].device;

    return device == NULL && self->find_model != NULL ? self->find_model(self->ctx, name) : device;
}

static void say_models(const struct dg_plan *plan, struct dg_text *to)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        dg_plan_add(to, RIG_SAY(" ", dg_devices[i]->name));
    }
    for (size_t i = 0; i < plan->model_count; i++) {
        dg_plan_add(to, RIG_SAY(" ", plan->models[i].device->name));
    }
}

int dg_plan_refuse_model(struct rig_reader *in, const struct rig_section *section, const char *key,
                         const struct dg_plan_setting *word)
{
    struct rig_list models;

    dg_plan_list_begin(&models);
    say_models(in->plan, &models.text);
    return word == NULL
               ? dg_plan_wrong_section(in, section,
                                       RIG_SAY("expected ", key, " = MODEL, one of:", models.room),
                                       RIG_SAY("without a ", key))
               : dg_plan_wrong_word(in, word, RIG_SAY("expected one of:", models.room),
                                    RIG_SAY(word->value, " is unknown"));
}

/* ---------------------------------------------------------------- name, base */

/* A name says the same everywhere: no file can make another encoder of a built-in one. On a command
 * line a word that begins with '-' is an option. */
static int check_name(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan *plan = in->plan;
    const struct dg_plan_name name = {.list = RIG_MODEL, .text = self->name};
    const int same = dg_plan_names_find(plan, &name);

    if (dg_device_find(self->name) != NULL) {
        return dg_plan_wrong_section(in, self, RIG_SAY("expected another name"),
                                     RIG_SAY(self->name, " is built in"));
    }
    if (self->name[0] == '-') {
        return dg_plan_wrong_section(in, self, RIG_SAY("expected a letter, digit or '_' in front"),
                                     RIG_SAY(self->name, " looks like an option"));
    }
    return same < 0 ? 0 : dg_plan_taken(in, self, plan->models[same].line);
}

/* Models that one stands on: 0 of one that is not of this plan. */
static unsigned depth_of(const struct dg_plan *plan, const struct dg_device *device)
{
    const int at =
        dg_plan_names_find(plan, &(struct dg_plan_name){.list = RIG_MODEL, .text = device->name});

    return at >= 0 && plan->models[at].device == device ? plan->models[at].depth : 0;
}

static int check_base(struct rig_reader *in, const struct dg_plan_setting *word,
                      const struct dg_device *base)
{
    if (dg_model_text_of(base->stack) == NULL) {
        return dg_plan_wrong_word(in, word, RIG_SAY("expected a model of another protocol"),
                                  RIG_SAY(base->name, " has no figures that a text can change"));
    }
    return depth_of(in->plan, base) < DG_PLAN_BASES_MAX
               ? 0
               : dg_plan_wrong_word(in, word, RIG_SAY("expected a model with fewer"),
                                    RIG_SAY(base->name, " stands on ",
                                            dg_plan_number(DG_PLAN_BASES_MAX).text,
                                            " models already"));
}

/* What stands above does not know what follows: there are no circles. @return NULL with `error` */
static const struct dg_device *take_base(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan_setting *word = dg_plan_word(self, "base");
    const struct dg_device *base = word == NULL ? NULL : dg_plan_find_model(in->plan, word->value);

    if (base == NULL) {
        (void)dg_plan_refuse_model(in, self, "base", word);
        return NULL;
    }
    return check_base(in, word, base) == 0 ? base : NULL;
}

/* ---------------------------------------------------------------- figures */

static int refuse_figure(struct rig_reader *in, const struct dg_plan_setting *word,
                         const struct dg_model_text *text, const struct dg_device *base)
{
    const struct dg_key *figure = dg_model_figure_at(text, 0);
    struct rig_list figures;

    dg_plan_list_begin(&figures);
    for (size_t i = 1; figure != NULL; i++) {
        dg_plan_add(&figures.text, RIG_SAY(" ", figure->name));
        figure = dg_model_figure_at(text, i);
    }
    return dg_plan_wrong_word(
        in, word, RIG_SAY("expected one of: base inherit title source unmodelled", figures.room),
        RIG_SAY("no figure of ", base->name));
}

static int refuse_value(struct rig_reader *in, const struct dg_plan_setting *word,
                        const struct dg_key *figure)
{
    struct rig_list right;

    dg_plan_list_begin(&right);
    dg_key_say_right(figure, &right.text);
    (void)dg_plan_refuse(in->error, RIG_SAY(right.room), NULL);
    (void)dg_plan_about(in->error, word->key, word->value);
    return dg_plan_refuse_key(in, word->key, word->line);
}

static int take_figure(struct rig_reader *in, const struct dg_plan_setting *word,
                       const struct dg_device *base, void *model)
{
    const struct dg_model_text *text = dg_model_text_of(base->stack);
    const struct dg_key *figure = dg_model_figure(text, word->key);

    if (figure == NULL) {
        return refuse_figure(in, word, text, base);
    }
    return dg_key_set(figure, model, word->value) == DG_OK ? 0 : refuse_value(in, word, figure);
}

/* All words that are no keys of the section. */
static int take_figures(struct rig_reader *in, const struct rig_section *self,
                        const struct dg_device *base, void *model)
{
    for (size_t i = 0; i < self->count; i++) {
        const struct dg_plan_setting *word = dg_plan_word_at(self, i);
        if (!dg_plan_kind_has(self->kind, word->key) && take_figure(in, word, base, model) != 0) {
            return -1;
        }
    }
    const char *right = dg_model_text_of(base->stack)->settle(model);
    return right == NULL ? 0
                         : dg_plan_wrong_section(in, self, RIG_SAY("expected ", right),
                                                 RIG_SAY("figures that do not fit each other"));
}

/* ---------------------------------------------------------------- heirlooms */

static int refuse_heirloom(struct rig_reader *in, const struct dg_plan_setting *word,
                           const struct dg_device *base)
{
    const char *const *names = dg_model_text_of(base->stack)->heirlooms;
    struct rig_list right;

    if (names == NULL) {
        return dg_plan_wrong_word(in, word, RIG_SAY("leave it out"),
                                  RIG_SAY(base->name, " has nothing to inherit but figures"));
    }
    dg_plan_list_begin(&right);
    for (size_t i = 0; names[i] != NULL; i++) {
        dg_plan_add(&right.text, RIG_SAY(i == 0 ? "" : ",", names[i]));
    }
    return dg_plan_wrong_word(in, word, RIG_SAY("expected inherit = ", right.room),
                              RIG_SAY(word->value, " is unknown"));
}

/* Bit n: heirloom n is named by the first `n` characters; 0: none is. */
static uint32_t heirloom_of(const char *const *names, const char *item, size_t n)
{
    for (size_t i = 0; names != NULL && names[i] != NULL; i++) {
        if (dg_plan_length(names[i]) == n && dg_plan_begins(item, names[i])) {
            return UINT32_C(1) << i;
        }
    }
    return 0;
}

/* Frame and timing are the base's; what else it has, a model has only if it says so. */
static int take_heirlooms(struct rig_reader *in, const struct rig_section *self,
                          const struct dg_device *base, void *model)
{
    const struct dg_model_text *text = dg_model_text_of(base->stack);
    const struct dg_plan_setting *word = dg_plan_word(self, "inherit");
    const char *item = word == NULL ? NULL : word->value;
    uint32_t wanted = 0;

    while (item != NULL) {
        const size_t n = dg_plan_span(item, ',');
        const uint32_t heirloom = heirloom_of(text->heirlooms, item, n);
        if (heirloom == 0) {
            return refuse_heirloom(in, word, base);
        }
        wanted |= heirloom;
        item = item[n] == '\0' ? NULL : item + n + 1u;
    }
    for (size_t i = 0; text->heirlooms != NULL && text->heirlooms[i] != NULL; i++) {
        if ((wanted >> i & 1u) == 0) {
            text->drop(model, i);
        }
    }
    return 0;
}

/* ---------------------------------------------------------------- the whole */

static void copy_figures(const struct dg_model_text *text, void *to, const void *from)
{
    if (text->copy != NULL) {
        text->copy(to, from);
    } else {
        memcpy(to, from, text->own_size);
    }
}

/* With a copy of the base's figures. @return NULL: the memory is full */
static struct dg_device *make_model_device(struct rig_reader *in, const struct rig_section *self,
                                           const struct dg_device *base, void **model)
{
    const size_t size = dg_model_text_of(base->stack)->size;
    const struct dg_plan_setting *title = dg_plan_word(self, "title");
    const char *name = dg_plan_copy(in->plan, self->name);
    struct dg_device *device = dg_plan_reserve(in->plan, sizeof *device);

    *model = dg_plan_reserve(in->plan, size);
    if (name == NULL || device == NULL || *model == NULL) {
        return NULL;
    }
    copy_figures(dg_model_text_of(base->stack), *model, base->model);
    *device = (struct dg_device){.name = name,
                                 .wire = base->wire,
                                 .resolution = title == NULL ? base->resolution : title->value,
                                 .stack = base->stack,
                                 .model = *model};
    return device;
}

/* What it stores is told from what encoders of other figures have stored. */
static int stamp_memory(struct rig_reader *in, const struct dg_device *device, void *model)
{
    const struct dg_model_text *text = dg_model_text_of(device->stack);
    struct dg_model_stamp *stamp =
        text->memory == NULL ? NULL : dg_plan_reserve(in->plan, sizeof *stamp);

    if (stamp != NULL) {
        dg_model_stamp_make(stamp, text, model);
    }
    return text->memory != NULL && stamp == NULL ? -1 : 0;
}

static int add_model(struct rig_reader *in, const struct dg_plan_model *row)
{
    struct dg_plan *plan = in->plan;
    struct dg_plan_model *list = dg_plan_grow(plan, plan->models, plan->model_count, sizeof *list);

    if (list == NULL) {
        return -1;
    }
    const struct dg_plan_name name = {
        .list = RIG_MODEL, .text = row->device->name, .index = (int)plan->model_count};
    plan->models = list;
    list[plan->model_count++] = *row;
    return dg_plan_names_add(plan, &name);
}

/* NULL: not said */
static const char *text_of(const struct rig_section *self, const char *key)
{
    const struct dg_plan_setting *word = dg_plan_word(self, key);

    return word == NULL ? NULL : word->value;
}

int dg_plan_take_model(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_device *base = check_name(in, self) != 0 ? NULL : take_base(in, self);
    void *model = NULL;
    struct dg_device *device = base == NULL ? NULL : make_model_device(in, self, base, &model);

    if (device == NULL || take_heirlooms(in, self, base, model) != 0 ||
        take_figures(in, self, base, model) != 0 || stamp_memory(in, device, model) != 0) {
        return -1;
    }
    return add_model(in, &(struct dg_plan_model){.device = device,
                                                 .base = base,
                                                 .source = text_of(self, "source"),
                                                 .unmodelled = text_of(self, "unmodelled"),
                                                 .depth = depth_of(in->plan, base) + 1u,
                                                 .line = self->line});
}

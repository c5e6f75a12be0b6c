/* SPDX-License-Identifier: MIT */
/*
 * Files that words of a rig file name: where they may be, their texts, and those that are models.
 * Texts come from the host. What is made of a model's stands in the memory of the plan; it is
 * read by its protocol, which opens nothing, so no model leads to another file.
 */
#include "drehgeber/hal.h"
#include "drehgeber/model.h"
#include "rig_private.h"

/* ---------------------------------------------------------------- names, texts */

/* Whether it names something in this folder or below it. */
static bool is_below(const char *path)
{
    for (size_t n = dg_plan_span(path, '/');; n = dg_plan_span(path, '/')) {
        if (n == 0 || (n == 2u && path[0] == '.' && path[1] == '.')) {
            return false;
        }
        if (path[n] == '\0') {
            return true;
        }
        path += n + 1u;
    }
}

int dg_plan_check_below(struct rig_reader *in, const struct dg_plan_setting *word)
{
    if (word->value[0] == '\0') {
        return dg_plan_wrong_word(in, word, RIG_SAY("expected ", word->key, " = VALUE"),
                                  RIG_SAY("empty"));
    }
    return is_below(word->value)
               ? 0
               : dg_plan_wrong_word(
                     in, word, RIG_SAY("expected a file in the folder of this one, or below it"),
                     RIG_SAY(word->value, " is not allowed"));
}

int dg_plan_fetch_text(struct rig_reader *in, const struct dg_plan_setting *word, const char *path,
                       struct dg_plan_text *to)
{
    const struct dg_plan_setup *setup = in->setup;
    const char *wrong = setup->include == NULL ? "there are no other files here"
                                               : setup->include(setup->ctx, path, to);

    return wrong == NULL ? 0 : dg_plan_wrong_word(in, word, NULL, RIG_SAY(wrong));
}

/* ---------------------------------------------------------------- models */

static int refuse_model(struct rig_reader *in, const struct dg_plan_setting *word, const char *path,
                        const struct dg_model_flaw *flaw)
{
    const bool placed = flaw->line > 0;

    return dg_plan_wrong_word(
        in, word, flaw->right[0] == '\0' ? NULL : RIG_SAY("expected ", flaw->right),
        RIG_SAY(path, placed ? ":" : "", placed ? dg_plan_number(flaw->line).text : "", ": ",
                flaw->what));
}

/* All that is free is lent, and what was not used given back. */
static int make_model(struct rig_reader *in, const struct dg_plan_setting *word, const char *path,
                      struct dg_model_made *made)
{
    struct dg_plan_text text = {.text = ""};
    struct dg_model_flaw flaw = {.line = 0};

    if (dg_plan_fetch_text(in, word, path, &text) != 0) {
        return -1;
    }
    if (text.n > DG_PLAN_MODEL_FILES_MAX - in->modelled) {
        return dg_plan_wrong_word(in, word, RIG_SAY("expected less"),
                                  RIG_SAY("more than ",
                                          dg_plan_number(DG_PLAN_MODEL_FILES_MAX).text,
                                          " bytes in all files that are models"));
    }
    in->modelled += text.n;
    struct dg_plan *plan = in->plan;
    void *memory = dg_plan_reserve(plan, 0);
    const struct dg_model_source source = {
        .text = text.text,
        .n = text.n,
        .memory = memory,
        .memory_size = memory == NULL ? 0 : (size_t)(plan->end - plan->at),
    };
    const int result =
        memory == NULL ? DG_ERR_SPACE : dg_model_file_of(path)->read(&source, made, &flaw);
    if (result == DG_OK) {
        plan->at += made->used;
        return 0;
    }
    plan->out = result == DG_ERR_SPACE;
    return plan->out ? -1 : refuse_model(in, word, path, &flaw);
}

static const struct dg_plan_model_file *add_file(struct rig_reader *in,
                                                 const struct dg_plan_model_file *row)
{
    struct dg_plan *plan = in->plan;
    struct dg_plan_model_file *list =
        dg_plan_grow(plan, plan->model_files, plan->model_file_count, sizeof *list);

    if (list == NULL) {
        return NULL;
    }
    const struct dg_plan_name name = {
        .list = RIG_FILE, .text = row->file, .index = (int)plan->model_file_count};
    plan->model_files = list;
    list[plan->model_file_count] = *row;
    return dg_plan_names_add(plan, &name) == 0 ? &list[plan->model_file_count++] : NULL;
}

/* @return NULL with `error` */
static const struct dg_plan_model_file *take_file(struct rig_reader *in,
                                                  const struct dg_plan_setting *word)
{
    struct dg_model_made made;
    struct dg_plan_name name = {.list = RIG_FILE};

    if (dg_plan_check_below(in, word) == 0) {
        name.text = dg_plan_path(in, word->value, word->line);
    }
    if (name.text == NULL) {
        return NULL;
    }
    const int at = dg_plan_names_find(in->plan, &name);
    if (at >= 0) {
        return &in->plan->model_files[at];
    }
    return make_model(in, word, name.text, &made) != 0
               ? NULL
               : add_file(in, &(struct dg_plan_model_file){.file = name.text,
                                                           .device = made.device,
                                                           .lacks = made.lacks,
                                                           .address = made.address,
                                                           .line = word->line});
}

int dg_plan_take_name(struct rig_reader *in, const struct dg_plan_setting *word,
                      const struct dg_device **to)
{
    *to = NULL;
    if (word == NULL || dg_model_file_of(word->value) == NULL) {
        *to = word == NULL ? NULL : dg_plan_find_model(in->plan, word->value);
        return 0;
    }
    const struct dg_plan_model_file *file = take_file(in, word);
    *to = file == NULL ? NULL : file->device;
    return file == NULL ? -1 : 0;
}

/* SPDX-License-Identifier: MIT */
/* What MODEL names: one that is built in, or one of a file. */
#include <string.h>

#include "drehgeber/drehgeber.h"
#include "eds_file.h"
#include "models.h"
#include "options.h"

/* @return whether the file is there; its error is kept otherwise */
static bool read_models(struct options *self, const char *path)
{
    self->file = models_read(path);
    if (self->file == NULL) {
        (void)lx_fail(&self->unread, "%s: no memory", path);
        return false;
    }
    self->unread = self->file->unread;
    return self->file->plan.memory != NULL;
}

/* A file of nothing but models stands for the last one of them; one with encoders is a rig. */
static void read_model(struct options *self)
{
    const struct dg_plan *plan = read_models(self, self->model) ? &self->file->plan : NULL;
    if (plan != NULL && plan->encoder_count == 0) {
        self->text = &plan->models[plan->model_count - 1u];
    }
}

/* One of the models of --model. */
static void choose_model(struct options *self)
{
    struct lx_words right = {"expected one of:"};
    if (!read_models(self, self->models)) {
        return;
    }
    const struct dg_plan *plan = &self->file->plan;
    for (size_t i = 0; i < plan->model_count; i++) {
        const char *name = plan->models[i].device->name;
        const bool last = i + 1u == plan->model_count;
        if (self->model == NULL ? last : strcmp(self->model, name) == 0) {
            self->text = &plan->models[i];
            self->model = name;
            return;
        }
        lx_words_add(&right, " %s", name);
    }
    if (plan->model_count == 0) {
        (void)lx_fail(&self->unread, "%s has no models", self->models);
    } else {
        (void)lx_refuse(&self->unread, right.text, "%s has no model %s", self->models, self->model);
    }
}

static void search_model(struct options *self)
{
    self->file = models_read_all();
    self->text = models_find(self->file, self->model, &self->unread);
}

/* An EDS file is the model. */
static int open_eds(struct options *self)
{
    self->eds = eds_file_open(self->model, &self->error);
    if (self->eds == NULL) {
        return -1;
    }
    self->device = &self->eds->encoder.device;
    return 0;
}

/* Commands that have more to say of a file than its encoder; and help waits for no stdin. */
static bool reads_eds_itself(const struct options *self)
{
    return self->row->command == COMMAND_CHECK || self->row->command == COMMAND_EDS ||
           (self->command == COMMAND_HELP && strcmp(self->model, "-") == 0);
}

int options_find_model(struct options *self)
{
    const bool asked = self->row != NULL && self->command != COMMAND_CTL &&
                       self->command != COMMAND_TOP && self->command != COMMAND_WEB;
    if (!asked || (self->model == NULL && self->models == NULL)) {
        return 0;
    }
    if (self->models != NULL) {
        choose_model(self);
        self->device = self->text == NULL ? NULL : self->text->device;
        return 0;
    }
    if (eds_file_is(self->model)) {
        return reads_eds_itself(self) ? 0 : open_eds(self);
    }
    self->device = dg_device_find(self->model);
    if (self->device == NULL && models_is_file(self->model)) {
        read_model(self);
    } else if (self->device == NULL) {
        search_model(self);
    }
    if (self->text != NULL) {
        self->device = self->text->device;
    }
    return 0;
}

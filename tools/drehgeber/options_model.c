/* SPDX-License-Identifier: MIT */
/* What MODEL names: one that is built in, or one of a file. */
#include "drehgeber/drehgeber.h"
#include "eds_file.h"
#include "models.h"
#include "options.h"

/* A file that is wrong may be the one that has the model: it ends the search. */
static bool has_model(void *ctx, const struct dg_plan *plan, const struct lx_error *error)
{
    struct options *self = ctx;
    if (error != NULL) {
        self->unread = *error;
        return true;
    }
    self->device = dg_plan_find_model(plan, self->model);
    return self->device != NULL;
}

/* A file of nothing but models stands for the last one of them; one with encoders is a rig. */
static void read_model(struct options *self)
{
    self->file = models_read(self->model, &self->unread);
    const struct dg_plan *plan = self->file == NULL ? NULL : &self->file->plan;
    if (plan != NULL && plan->memory != NULL && plan->encoder_count == 0) {
        self->device = plan->models[plan->model_count - 1u].device;
    }
}

/* An EDS file is the model. */
static int open_eds(struct options *self)
{
    self->eds = eds_file_open(self->model, false, &self->error);
    if (self->eds == NULL) {
        return -1;
    }
    self->device = &self->eds->encoder.device;
    return 0;
}

int options_find_model(struct options *self)
{
    const bool asked = self->row != NULL && self->command != COMMAND_CTL &&
                       self->command != COMMAND_TOP && self->command != COMMAND_WEB;
    if (self->model == NULL || !asked) {
        return 0;
    }
    if (eds_file_is(self->model)) {
        return self->row->command == COMMAND_RUN ? open_eds(self) : 0;
    }
    self->device = dg_device_find(self->model);
    if (self->device == NULL && models_is_file(self->model)) {
        read_model(self);
    } else if (self->device == NULL) {
        self->file = models_search(has_model, self);
    }
    return 0;
}

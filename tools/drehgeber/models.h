/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: [model NAME] sections of rig files, of which a file may have nothing else.
 */
#ifndef DREHGEBER_TOOL_MODELS_H
#define DREHGEBER_TOOL_MODELS_H

#include <stdbool.h>

#include "plan.h"

/* The folder whose files say which models there are beside the built-in ones. */
#define MODELS_FOLDER "DREHGEBER_MODELS"

/* A rig file that was read; its models are there as long as it is. */
struct model_file {
    struct dg_plan plan;
    char path[];
};

/* Whether `name` is that of a file, as no model's is: it ends in .ini, or has a folder. */
bool models_is_file(const char *name);

/* Read it. NULL without memory; a file that could not be read has a plan without memory, and
   `error` is as long as it is. */
struct model_file *models_read(const char *path, struct lx_error *error);

/* Read the files of the folder, in the order of their names, up to the first one that is `wanted`,
   which is kept. `error`: why it could not be read; NULL. @return NULL: none is, or there is no
   folder */
struct model_file *models_search(bool (*wanted)(void *ctx, const struct dg_plan *plan,
                                                const struct lx_error *error),
                                 void *ctx);

void models_free(struct model_file *self);

#endif

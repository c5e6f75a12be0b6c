/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts: [model NAME] sections of rig files, of which a file may have nothing else.
 * Beside files that the user names there are two folders of them: the user's, and the catalogue of
 * encoders that are sold, which is installed with this program.
 */
#ifndef DREHGEBER_TOOL_MODELS_H
#define DREHGEBER_TOOL_MODELS_H

#include <stdbool.h>

#include "plan.h"

/* The user's folder of models. Its names go before those of the catalogue. */
#define MODELS_FOLDER "DREHGEBER_MODELS"

/* A rig file that was read; its models are there as long as it is. */
struct model_file {
    struct model_file *next;   /* of a list; NULL: the last one */
    bool sold;                 /* it is of the catalogue */
    struct dg_plan plan;       /* without memory: it could not be read */
    struct model_file *others; /* owned: those whose models it may name; NULL: nobody has asked */
    struct lx_error unread;    /* why; also of a folder, which has no models then */
    char path[];
};

/* Whether `name` is that of a file, as no model's is: it ends in .ini, or has a folder. */
bool models_is_file(const char *name);

/* Read it; it may name models of both folders. NULL without memory. */
struct model_file *models_read(const char *path);

/* Read all files of both folders, the user's first, each in the order of their names. NULL: there
   are none. To be freed. */
struct model_file *models_read_all(void);

/* The section called `name`, or NULL with `error`: two files of a folder have it, the one that has
   it is wrong, or none has and what could not be read is told. "" in `error`: none has. */
const struct dg_plan_model *models_find(const struct model_file *list, const char *name,
                                        struct lx_error *error);

/* The file of `list` before `self`, of the same folder, that has a model of this name, too; NULL:
   none has. */
const struct model_file *models_rival(const struct model_file *list, const struct model_file *self,
                                      const char *name);

/* A list, or one file; NULL: nothing. */
void models_free(struct model_file *self);

#endif

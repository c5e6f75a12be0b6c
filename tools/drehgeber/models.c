/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "models.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "file.h"

static const char ending[] = ".ini";

static bool ends_so(const char *name)
{
    const size_t n = strlen(name);
    return n > strlen(ending) && strcasecmp(name + n - strlen(ending), ending) == 0;
}

bool models_is_file(const char *name)
{
    return strchr(name, '/') != NULL || strcasecmp(name, ending) == 0 || ends_so(name);
}

static struct model_file *make_file(const char *path, struct lx_error *error)
{
    struct model_file *self = calloc(1, sizeof *self + strlen(path) + 1);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory", path);
        return NULL;
    }
    memcpy(self->path, path, strlen(path) + 1);
    return self;
}

struct model_file *models_read(const char *path, struct lx_error *error)
{
    struct model_file *self = make_file(path, error);
    if (self != NULL) {
        (void)lx_plan_read(&self->plan, self->path, error);
    }
    return self;
}

/* Nobody named this file: a FIFO among models would be waited for without end. */
static struct model_file *read_regular(const char *path, struct lx_error *error)
{
    struct model_file *self = make_file(path, error);
    FILE *stream = self == NULL ? NULL : lx_file_read(NULL, path, error);
    if (stream != NULL) {
        (void)fclose(stream);
        (void)lx_plan_read(&self->plan, self->path, error);
    }
    return self;
}

static int is_of_models(const struct dirent *entry)
{
    return ends_so(entry->d_name);
}

/* @return the file if it is wanted */
static struct model_file *
try_file(const char *folder, const char *name,
         bool (*wanted)(void *, const struct dg_plan *, const struct lx_error *), void *ctx)
{
    struct lx_error error;
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    struct model_file *file = read_regular(path, &error);
    const bool unread = file != NULL && file->plan.memory == NULL;
    if (file != NULL && wanted(ctx, &file->plan, unread ? &error : NULL)) {
        return file;
    }
    models_free(file);
    return NULL;
}

struct model_file *models_search(bool (*wanted)(void *ctx, const struct dg_plan *plan,
                                                const struct lx_error *error),
                                 void *ctx)
{
    const char *folder = getenv(MODELS_FOLDER);
    struct dirent **entries = NULL;
    struct model_file *found = NULL;
    if (folder == NULL || folder[0] == '\0') {
        return NULL;
    }
    const int count = scandir(folder, &entries, is_of_models, alphasort);
    for (int i = 0; i < count; i++) {
        found = found == NULL ? try_file(folder, entries[i]->d_name, wanted, ctx) : found;
        free(entries[i]);
    }
    free(entries);
    return found;
}

void models_free(struct model_file *self)
{
    if (self != NULL) {
        lx_plan_free(&self->plan);
        free(self);
    }
}

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "models.h"

#include <dirent.h>
#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "file.h"

#define BESIDE "share/drehgeber/models"

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

/* --- reading --- */

static struct model_file *make_file(const char *path)
{
    struct model_file *self = calloc(1, sizeof *self + strlen(path) + 1);
    if (self != NULL) {
        memcpy(self->path, path, strlen(path) + 1);
    }
    return self;
}

/* The folders are read once, and only if the file has a name that is not its own. */
static const struct dg_device *find_other(void *ctx, const char *name)
{
    struct model_file *self = ctx;
    struct lx_error error;
    if (self->others == NULL) {
        self->others = models_read_all();
    }
    const struct dg_plan_model *row = models_find(self->others, name, &error);
    return row == NULL ? NULL : row->device;
}

struct model_file *models_read(const char *path)
{
    struct model_file *self = make_file(path);
    const struct lx_plan_shelf shelf = {.find_model = find_other, .ctx = self};
    if (self != NULL) {
        (void)lx_plan_read_with(&self->plan, self->path, &shelf, &self->unread);
    }
    return self;
}

/* Nobody named this file: a FIFO among models would be waited for without end. */
static struct model_file *read_regular(const char *path)
{
    struct model_file *self = make_file(path);
    FILE *stream = self == NULL ? NULL : lx_file_read(NULL, path, &self->unread);
    if (stream != NULL) {
        (void)fclose(stream);
        (void)lx_plan_read(&self->plan, self->path, &self->unread);
    }
    return self;
}

static int is_of_models(const struct dirent *entry)
{
    return ends_so(entry->d_name);
}

/* A folder that cannot be looked into stands in the list as a file that could not be read. */
static struct model_file *refuse_folder(const char *folder, int reason)
{
    struct model_file *self = make_file(folder);
    if (self != NULL) {
        (void)lx_fail(&self->unread, "$" MODELS_FOLDER " %s: %s", folder, strerror(reason));
    }
    return self;
}

/* @return where the next file belongs */
static struct model_file **read_folder(struct model_file **to, const char *folder, bool sold)
{
    struct dirent **entries = NULL;
    const int count = scandir(folder, &entries, is_of_models, alphasort);
    if (count < 0 && !sold) {
        *to = refuse_folder(folder, errno);
        return *to == NULL ? to : &(*to)->next;
    }
    for (int i = 0; i < count; i++) {
        char path[PATH_MAX];
        (void)snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        *to = read_regular(path);
        if (*to != NULL) {
            (*to)->sold = sold;
            to = &(*to)->next;
        }
        free(entries[i]);
    }
    free(entries);
    return to;
}

/* Beside the program in a build tree, else where it is installed. @return whether there is one */
static bool find_catalogue(char *to, size_t size)
{
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    if (n < 0) {
        return false;
    }
    self[n] = '\0';
    const char *folder = dirname(self);
    (void)snprintf(to, size, "%s/" BESIDE, folder);
    if (access(to, X_OK) != 0) {
        (void)snprintf(to, size, "%s/" DREHGEBER_MODELS_FOLDER, folder);
    }
    return access(to, X_OK) == 0;
}

struct model_file *models_read_all(void)
{
    const char *own = getenv(MODELS_FOLDER);
    char catalogue[PATH_MAX + sizeof DREHGEBER_MODELS_FOLDER + sizeof BESIDE];
    struct model_file *first = NULL;
    struct model_file **to = &first;
    if (own != NULL && own[0] != '\0') {
        to = read_folder(to, own, false);
    }
    if (find_catalogue(catalogue, sizeof catalogue)) {
        (void)read_folder(to, catalogue, true);
    }
    return first;
}

/* --- finding --- */

static const struct dg_plan_model *find_in(const struct model_file *file, const char *name)
{
    for (size_t i = 0; i < file->plan.model_count; i++) {
        if (strcmp(file->plan.models[i].device->name, name) == 0) {
            return &file->plan.models[i];
        }
    }
    return NULL;
}

const struct model_file *models_rival(const struct model_file *list, const struct model_file *self,
                                      const char *name)
{
    for (; list != self; list = list->next) {
        if (list->sold == self->sold && find_in(list, name) != NULL) {
            return list;
        }
    }
    return NULL;
}

static bool is_unread(const struct model_file *file)
{
    return file->plan.memory == NULL;
}

/* Whether a file that nobody could read begins a section of this name. */
static bool begins_model(const struct model_file *file, const char *name)
{
    struct lx_error error;
    struct lx_words head = {""};
    FILE *stream = lx_file_read(NULL, file->path, &error);
    char *line = NULL;
    size_t size = 0;
    bool begins = false;
    lx_words_add(&head, "[model %s]", name);
    while (stream != NULL && !begins && getline(&line, &size, stream) >= 0) {
        begins = strncmp(line + strspn(line, " \t"), head.text, strlen(head.text)) == 0;
    }
    free(line);
    if (stream != NULL) {
        (void)fclose(stream);
    }
    return begins;
}

/* A file that is wrong says so if it is the one that was meant, or if nobody knows which was. */
static void refuse_name(const struct model_file *list, const char *name, struct lx_error *error)
{
    const struct model_file *wrong = NULL;
    for (; list != NULL; list = list->next) {
        if (is_unread(list) && begins_model(list, name)) {
            *error = list->unread;
            return;
        }
        wrong = wrong == NULL && is_unread(list) ? list : wrong;
    }
    if (wrong != NULL) {
        (void)lx_refuse(error, "'drehgeber list' prints all models",
                        "unknown model %s; not read: %s", name, lx_error_line(&wrong->unread).text);
    }
}

const struct dg_plan_model *models_find(const struct model_file *list, const char *name,
                                        struct lx_error *error)
{
    const struct model_file *found = NULL;
    *error = (struct lx_error){.what = ""};
    for (const struct model_file *file = list; file != NULL; file = file->next) {
        const bool has = find_in(file, name) != NULL;
        const struct model_file *rival = has ? models_rival(list, file, name) : NULL;
        if (rival != NULL && rival == found) {
            (void)lx_refuse(error, "expected it in only one file", "%s is in both %s and %s", name,
                            rival->path, file->path);
            return NULL;
        }
        found = has && found == NULL ? file : found;
    }
    if (found == NULL) {
        refuse_name(list, name, error);
        return NULL;
    }
    return find_in(found, name);
}

void models_free(struct model_file *self)
{
    while (self != NULL) {
        struct model_file *next = self->others == NULL ? self->next : self->others;
        lx_plan_free(&self->plan); /* one that has others is not in a list itself */
        free(self);
        self = next;
    }
}

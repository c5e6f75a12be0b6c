/* SPDX-License-Identifier: MIT */
/*
 * Models that are texts in a file: "la26.ini" is the last one in it, "trees.ini:tree" the one
 * called so.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/model.h"
#include "error.h"
#include "figures.h"
#include "file.h"
#include "hdl_private.h"
#include "nvm_memory.h"

#define ENDING ".ini"
/* What a file may have, and the memory that is tried for what is in it. */
#define TEXT_MAX 1048576u
#define MEMORY_MIN 65536u
#define MEMORY_MAX 33554432u

static bool is_model_file_name(const char *text, size_t n)
{
    const size_t of_ending = strlen(ENDING);

    return n > of_ending && strncmp(text + n - of_ending, ENDING, of_ending) == 0;
}

/* What stands behind the ending: nothing, or ':' and a name. NULL: no file is named. */
static const char *behind_file(const char *model)
{
    const size_t n = strlen(model);
    const char *name = is_model_file_name(model, n) ? model + n : strrchr(model, ':');

    return name != NULL && is_model_file_name(model, (size_t)(name - model)) ? name : NULL;
}

/* @return bytes, or -1 with an error */
static long read_model_text(struct dg_hdl *self, const char *path, char *to)
{
    struct lx_error error;
    FILE *file = to == NULL ? NULL : lx_file_read(NULL, path, &error);

    if (to == NULL) {
        return hdl_fail(self, -1, "%s: no memory for it", path);
    }
    if (file == NULL) {
        return hdl_fail(self, -1, "%s", lx_error_line(&error).text);
    }
    const size_t n = fread(to, 1, TEXT_MAX, file);
    const bool bad = ferror(file) != 0 || n == TEXT_MAX;
    (void)fclose(file);
    return bad ? hdl_fail(self, -1, "%s: cannot be read, or has 1 MiB", path) : (long)n;
}

/* It asks for more memory by failing. */
static int read_model_plan(struct dg_hdl *self, struct dg_plan_setup *setup)
{
    struct dg_plan_error wrong;
    struct lx_error error;
    int result = DG_ERR_SPACE;

    for (size_t size = MEMORY_MIN; result == DG_ERR_SPACE && size <= MEMORY_MAX; size *= 2u) {
        free(self->models);
        self->models = malloc(size);
        setup->memory = self->models;
        setup->memory_size = size;
        result = self->models == NULL ? DG_ERR_ARGUMENT : dg_plan_read(&self->plan, setup, &wrong);
    }
    if (self->models == NULL || result == DG_ERR_SPACE) {
        return hdl_fail(self, -1, "%s: no memory for its contents", setup->file);
    }
    if (result != DG_OK) {
        (void)lx_error_take(&error, &wrong);
        return hdl_fail(self, -1, "%s", lx_error_line(&error).text);
    }
    return 0;
}

static const struct dg_device *choose_model(struct dg_hdl *self, const char *path, const char *name)
{
    const struct dg_plan *plan = &self->plan;
    struct lx_words right = {""};

    for (size_t i = 0; i < plan->model_count; i++) {
        const struct dg_device *device = plan->models[i].device;
        if (name[0] == '\0' ? i + 1u == plan->model_count : strcmp(name, device->name) == 0) {
            return device;
        }
        lx_words_item(&right, device->name, i, plan->model_count, " and ");
    }
    (void)hdl_fail(self, 0, "%s has no model '%s'; it has %s", path, name,
                   plan->model_count == 0 ? "none" : right.text);
    return NULL;
}

static const struct dg_device *read_file(struct dg_hdl *self, const char *path, const char *name)
{
    char *text = malloc(TEXT_MAX);
    const long n = read_model_text(self, path, text);
    struct dg_plan_setup setup = {
        .size = sizeof setup,
        .file = path,
        .text = {text, n < 0 ? 0u : (size_t)n},
    };
    const bool read = n >= 0 && read_model_plan(self, &setup) == 0;

    free(text);
    return read ? choose_model(self, path, name) : NULL;
}

int hdl_read_model(struct dg_hdl *self, const char *model)
{
    const char *name = behind_file(model);
    char *path = name != NULL ? strndup(model, (size_t)(name - model)) : NULL;

    if (path != NULL) {
        self->device = read_file(self, path, name[0] == ':' ? name + 1 : name);
        self->plan.file = NULL; /* which was for messages */
    } else if (name != NULL) {
        (void)hdl_fail(self, -1, "%s: no memory for it", model);
    }
    free(path);
    return name == NULL || self->device != NULL ? 0 : -1;
}

/* Which figures of a model that is a text the EEPROM was made with, looked at in a copy. */
static bool differs(struct dg_hdl *self, struct lx_words *to)
{
    const struct dg_device *device = self->device;
    const struct dg_model_stamp *stamp =
        device == NULL ? NULL : dg_model_stamp_of(dg_model_text_of(device->stack), device->model);
    struct lx_nvm_memory copy;

    if (stamp == NULL || lx_nvm_memory_init(&copy, self->memory.size) != 0) {
        return false;
    }
    memcpy(copy.bytes, self->memory.bytes, copy.size);
    const bool result = lx_figures_differ(stamp, lx_nvm_memory_port(&copy), to);
    lx_nvm_memory_free(&copy);
    return result;
}

int hdl_fail_memory(struct dg_hdl *self, int result, const char *memory)
{
    struct lx_words figures = {""};

    if (memory[0] != '\0' && result == DG_HOST_ERR_FOREIGN && differs(self, &figures)) {
        return hdl_fail(self, result, "%s: of other figures: %s", memory, figures.text);
    }
    return hdl_fail(self, result, "%s%s%s", memory, memory[0] != '\0' ? ": " : "",
                    dg_host_result_text(result));
}

/* SPDX-License-Identifier: MIT */
/*
 * A row for each kind of section. What a section refers to stands above it, so that each can be
 * checked when it ends, with all that it may clash with.
 */
#define _GNU_SOURCE
#include "plan_section.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "access.h"
#include "stacks.h"

/* --- words --- */

const struct lx_plan_setting *lx_plan_word(const struct lx_plan_section *section, const char *key)
{
    for (size_t i = 0; i < section->words.count; i++) {
        if (strcmp(section->words.list[i].key, key) == 0) {
            return &section->words.list[i];
        }
    }
    return NULL;
}

bool lx_plan_section_has(const struct lx_plan_section_kind *kind, const char *key)
{
    for (size_t i = 0; kind->keys[i] != NULL; i++) {
        if (strcmp(kind->keys[i], key) == 0) {
            return true;
        }
    }
    return kind->numbered && lx_is_address_key(key);
}

/* "a, b and c are right" */
static struct lx_words keys_of(const struct lx_plan_section_kind *kind)
{
    struct lx_words list = {""};
    size_t count = 0;
    while (kind->keys[count] != NULL) {
        count++;
    }
    for (size_t i = 0; i < count; i++) {
        lx_words_item(&list, kind->keys[i], i, count, " and ");
    }
    lx_words_add(&list, " are right");
    return list;
}

static int check_words(const struct lx_plan *plan, const struct lx_plan_section *section,
                       struct lx_error *error)
{
    const struct lx_plan_section_kind *kind = section->kind;
    for (size_t i = 0; i < section->words.count; i++) {
        const struct lx_plan_setting *row = &section->words.list[i];
        const bool known = lx_plan_section_has(kind, row->key);
        if (!known && !kind->open) {
            return lx_plan_wrong_word(plan, row, error, keys_of(kind).text, "no key of [%s]",
                                      kind->name);
        }
        if (known && row->value[0] == '\0') {
            struct lx_words right = {""};
            lx_words_add(&right, "%s = VALUE is right", row->key);
            return lx_plan_wrong_word(plan, row, error, right.text, "empty");
        }
    }
    return 0;
}

/* --- what is wrong --- */

int lx_plan_wrong_word(const struct lx_plan *plan, const struct lx_plan_setting *row,
                       struct lx_error *error, const char *right, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)lx_refuse_v(error, right, format, arguments);
    va_end(arguments);
    return lx_plan_refuse_key(plan, row->key, row->line, error);
}

int lx_plan_wrong_section(const struct lx_plan *plan, const struct lx_plan_section *section,
                          struct lx_error *error, const char *right, const char *format, ...)
{
    struct lx_words name = {""};
    va_list arguments;
    va_start(arguments, format);
    (void)lx_refuse_v(error, right, format, arguments);
    va_end(arguments);
    lx_words_add(&name, "[%s %s]", section->kind->name, section->name);
    return lx_plan_refuse_key(plan, name.text, section->line, error);
}

int lx_plan_wrong_line(const struct lx_plan *plan, lx_line_number line, struct lx_error *error,
                       const char *right, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)lx_refuse_v(error, right, format, arguments);
    va_end(arguments);
    return lx_stands(error, plan->file, line);
}

int lx_plan_no_room(const struct lx_plan *plan, const struct lx_plan_section *section,
                    struct lx_error *error)
{
    return lx_plan_wrong_section(plan, section, error,
                                 "fewer shafts, buses and encoders, or more memory, is right",
                                 "no memory for one more");
}

int lx_plan_taken(const struct lx_plan *plan, const struct lx_plan_section *section,
                  lx_line_number by, struct lx_error *error)
{
    return lx_plan_wrong_section(plan, section, error, "another name is right",
                                 "line %u has the name already", by);
}

int lx_plan_take_path(const struct lx_plan *plan, const char *path, char **to,
                      struct lx_error *error)
{
    const char *slash = strrchr(plan->file, '/');
    const int folder = slash == NULL || path[0] == '/' ? 0 : (int)(slash + 1 - plan->file);
    if (asprintf(to, "%.*s%s", folder, plan->file, path) < 0) {
        *to = NULL;
        return lx_fail(error, "no memory for %s", path);
    }
    return 0;
}

int lx_plan_take_text(const struct lx_plan_setting *row, char **to, struct lx_error *error)
{
    *to = strdup(row->value);
    return *to == NULL ? lx_fail(error, "no memory for %s", row->value) : 0;
}

bool lx_plan_name_fits(const char *name)
{
    static const char right[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
    const size_t n = strlen(name);
    return n > 0 && n <= LX_PLAN_NAME_MAX && strspn(name, right) == n;
}

/* --- [rig] --- */

/* A path of a socket or a token is the rig file's neighbour. */
static int write_control(const struct lx_plan *plan, const struct lx_access *access, char **to,
                         struct lx_error *error)
{
    static const char socket[] = "unix:";
    const size_t n = access->tcp ? 0 : strlen(socket);
    const bool token = access->token_file[0] != '\0';
    char *where = NULL;
    char *file = NULL;
    int result = access->tcp ? 0 : lx_plan_take_path(plan, access->where + n, &where, error);
    if (result == 0 && token) {
        result = lx_plan_take_path(plan, access->token_file, &file, error);
    }
    if (result == 0 &&
        asprintf(to, "%.*s%s%s%s%s", (int)n, socket, access->tcp ? access->where : where,
                 access->open ? ",open" : "", token ? ",token=" : "", token ? file : "") < 0) {
        *to = NULL;
        result = lx_fail(error, "no memory for %s", access->where);
    }
    free(where);
    free(file);
    return result;
}

static int take_control(struct lx_plan *plan, const struct lx_plan_setting *row,
                        struct lx_error *error)
{
    struct lx_access access;
    if (plan->control_count == LX_PLAN_CONTROLS_MAX) {
        return lx_plan_wrong_word(plan, row, error, "fewer are right", "one more than %u",
                                  LX_PLAN_CONTROLS_MAX);
    }
    if (lx_access_parse(row->value, &access, error) != 0) {
        return lx_plan_refuse_key(plan, row->key, row->line, error);
    }
    plan->control_lines[plan->control_count] = row->line;
    return write_control(plan, &access, &plan->controls[plan->control_count++], error);
}

static int take_rig(struct lx_plan *plan, const struct lx_plan_section *self,
                    struct lx_error *error)
{
    const struct lx_plan_setting *name = lx_plan_word(self, "name");
    if (name != NULL && !lx_plan_name_fits(name->value)) {
        struct lx_words right = {""};
        lx_words_add(&right, "1 to %u letters, digits, _ and - are right", LX_PLAN_NAME_MAX);
        return lx_plan_wrong_word(plan, name, error, right.text, "%s is none", name->value);
    }
    if (name != NULL && plan->name != NULL) {
        return lx_plan_wrong_word(plan, name, error, "one name is right",
                                  "the rig is called %s already", plan->name);
    }
    int result = name == NULL ? 0 : lx_plan_take_text(name, &plan->name, error);
    const struct lx_plan_setting *files = lx_plan_word(self, "files");
    if (result == 0 && files != NULL && plan->files == NULL) {
        plan->files_line = files->line;
        result = lx_plan_take_path(plan, files->value, &plan->files, error);
    }
    for (size_t i = 0; result == 0 && i < self->words.count; i++) {
        if (strcmp(self->words.list[i].key, "control") == 0) {
            result = take_control(plan, &self->words.list[i], error);
        }
    }
    return result;
}

/* --- the kinds --- */

static const char *const rig_keys[] = {"name", "control", "files", NULL};
static const char *const shaft_keys[] = {"motion", "driver", "ratio", NULL};
static const char *const bus_keys[] = {"wire", "address", "trace", NULL};
static const char *const encoder_keys[] = {"model", "shaft", "bus",    "wire",
                                           "trace", "nvm",   "serial", NULL};

/* clang-format off */
static const struct lx_plan_section_kind kinds[] = {
    /* name      named  open   numb.  repeats    keys          take */
    {"rig",      false, false, false, "control", rig_keys,     take_rig},
    {"shaft",    true,  false, false, NULL,      shaft_keys,   lx_plan_take_shaft},
    {"bus",      true,  true,  false, NULL,      bus_keys,     lx_plan_take_bus},
    {"encoder",  true,  true,  true,  NULL,      encoder_keys, lx_plan_take_encoders},
};
/* clang-format on */
#define KIND_COUNT DG_COUNT(kinds)

const struct lx_plan_section_kind *lx_plan_section_find(const char *name)
{
    for (size_t i = 0; i < KIND_COUNT; i++) {
        if (strcmp(kinds[i].name, name) == 0) {
            return &kinds[i];
        }
    }
    return NULL;
}

int lx_plan_section_take(struct lx_plan *plan, const struct lx_plan_section *self,
                         struct lx_error *error)
{
    return check_words(plan, self, error) != 0 ? -1 : self->kind->take(plan, self, error);
}

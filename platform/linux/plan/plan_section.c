/* SPDX-License-Identifier: MIT */
/*
 * A row for each kind of section. What a section refers to stands above it, so that each can be
 * checked when it ends, with all that it may clash with.
 */
#define _GNU_SOURCE
#include "plan_section.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "access.h"

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
    return false;
}

/* "a, b and c" */
static struct lx_error keys_of(const struct lx_plan_section_kind *kind)
{
    struct lx_error list = {""};
    for (size_t i = 0; kind->keys[i] != NULL; i++) {
        const size_t used = strlen(list.text);
        const char *between = kind->keys[i + 1] == NULL ? " and " : ", ";
        (void)snprintf(list.text + used, sizeof list.text - used, "%s%s", i == 0 ? "" : between,
                       kind->keys[i]);
    }
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
            const struct lx_error keys = keys_of(kind);
            return lx_plan_fail(plan, row->line, error, "%s: no key of [%s]; %s are right",
                                row->key, kind->name, keys.text);
        }
        if (known && row->value[0] == '\0') {
            return lx_plan_fail(plan, row->line, error, "%s: empty; %s = VALUE is right", row->key,
                                row->key);
        }
    }
    return 0;
}

int lx_plan_no_room(const struct lx_plan *plan, const struct lx_plan_section *section,
                    struct lx_error *error)
{
    return lx_plan_fail(plan, section->line, error,
                        "[%s %s]: no memory, or too many; %u shafts, %u buses and private wires, "
                        "%u encoders at most are right",
                        section->kind->name, section->name, LX_PLAN_SHAFTS_MAX, LX_PLAN_WIRES_MAX,
                        LX_PLAN_ENCODERS_MAX);
}

int lx_plan_taken(const struct lx_plan *plan, const struct lx_plan_section *section,
                  lx_line_number by, struct lx_error *error)
{
    return lx_plan_fail(plan, section->line, error,
                        "[%s %s]: line %u has the name already; another name is right",
                        section->kind->name, section->name, by);
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

int lx_plan_copy_setting(struct lx_plan_settings *to, const struct lx_plan_setting *row,
                         struct lx_error *error)
{
    char *assignment = NULL;
    if (asprintf(&assignment, "%s=%s", row->key, row->value) < 0) {
        return lx_fail(error, "no memory for %s", row->key);
    }
    const int result = lx_plan_add_setting(to, assignment, row->line, error);
    free(assignment);
    return result;
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
        return lx_plan_fail(plan, row->line, error, "control: one more than %u; fewer are right",
                            LX_PLAN_CONTROLS_MAX);
    }
    if (lx_access_parse(row->value, &access, error) != 0) {
        return lx_plan_fail(plan, row->line, error, "control: %s", error->text);
    }
    plan->control_lines[plan->control_count] = row->line;
    return write_control(plan, &access, &plan->controls[plan->control_count++], error);
}

static int take_rig(struct lx_plan *plan, const struct lx_plan_section *self,
                    struct lx_error *error)
{
    const struct lx_plan_setting *name = lx_plan_word(self, "name");
    if (name != NULL && !lx_plan_name_fits(name->value)) {
        return lx_plan_fail(plan, name->line, error,
                            "name: %s is none; 1 to %u letters, digits, _ and - are right",
                            name->value, LX_PLAN_NAME_MAX);
    }
    if (name != NULL && plan->name != NULL) {
        return lx_plan_fail(plan, name->line, error,
                            "name: the rig is called %s already; one name is right", plan->name);
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
static const char *const encoder_keys[] = {"model", "shaft",   "bus", "wire",   "trace",
                                           "node",  "address", "nvm", "serial", NULL};

/* clang-format off */
static const struct lx_plan_section_kind kinds[] = {
    /* name      named  open   repeats    keys          take */
    {"rig",      false, false, "control", rig_keys,     take_rig},
    {"shaft",    true,  false, NULL,      shaft_keys,   lx_plan_take_shaft},
    {"bus",      true,  true,  NULL,      bus_keys,     lx_plan_take_bus},
    {"encoder",  true,  true,  NULL,      encoder_keys, lx_plan_take_encoder},
};
/* clang-format on */
#define KIND_COUNT (sizeof kinds / sizeof kinds[0])

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

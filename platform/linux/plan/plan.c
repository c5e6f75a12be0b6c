/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "plan.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "wire.h"

/* Room for one more behind `count` rows: the capacity is the next power of two. @return where the
   rows are now, or NULL with the old ones in place: without memory, or a number for one more */
static void *room(void *list, size_t count, size_t size)
{
    if (count > 0 && (count & (count - 1u)) != 0) {
        return list;
    }
    return count >= INT_MAX ? NULL : reallocarray(list, count == 0 ? 1u : count * 2u, size);
}

/* A copy; NULL stays NULL. @return false without memory */
static bool copy(char **to, const char *text)
{
    *to = text == NULL ? NULL : strdup(text);
    return text == NULL || *to != NULL;
}

/* What a row is called: a copy, which the names borrow. @return its index, or -1 without memory */
static int call(struct lx_plan *self, char **to, enum lx_plan_list list, const char *text,
                size_t count)
{
    const int index = (int)count - 1;
    if (!copy(to, text)) {
        return -1;
    }
    const struct lx_plan_name name = {.list = list, .text = *to};
    return lx_plan_names_add(&self->names, &name, index) == 0 ? index : -1;
}

int lx_plan_add_shaft(struct lx_plan *self, const char *name, const char *motion)
{
    struct lx_plan_shaft *list = room(self->shafts, self->shaft_count, sizeof *list);
    if (list == NULL) {
        return -1;
    }
    self->shafts = list;
    struct lx_plan_shaft *row = &list[self->shaft_count++];
    *row = (struct lx_plan_shaft){.driver = -1, .ratio = {1, 1}};
    return copy(&row->motion, motion)
               ? call(self, &row->name, LX_PLAN_SHAFT, name, self->shaft_count)
               : -1;
}

int lx_plan_add_wire(struct lx_plan *self, const char *name, const struct lx_wire *kind,
                     const char *where)
{
    struct lx_plan_wire *list = room(self->wires, self->wire_count, sizeof *list);
    if (list == NULL) {
        return -1;
    }
    self->wires = list;
    struct lx_plan_wire *row = &list[self->wire_count++];
    *row = (struct lx_plan_wire){.kind = kind};
    return copy(&row->where, where) ? call(self, &row->name, LX_PLAN_WIRE, name, self->wire_count)
                                    : -1;
}

int lx_plan_add_encoder(struct lx_plan *self, const char *name, const struct dg_device *model,
                        size_t shaft, size_t wire)
{
    struct lx_plan_encoder *list = room(self->encoders, self->encoder_count, sizeof *list);
    if (list == NULL) {
        return -1;
    }
    self->encoders = list;
    struct lx_plan_encoder *row = &list[self->encoder_count++];
    *row = (struct lx_plan_encoder){
        .model = model, .shaft = shaft, .wire = wire, .address = LX_PLAN_AS_DELIVERED};
    struct lx_plan_wire *on = &self->wires[wire];
    on->stack = model->stack;
    on->encoder_count++;
    const int index = call(self, &row->name, LX_PLAN_ENCODER, name, self->encoder_count);
    const struct lx_plan_name alias = {.list = LX_PLAN_ALIAS, .text = row->name};
    return index < 0 ? -1 : lx_plan_names_add(&self->names, &alias, index) == 0 ? index : -1;
}

int lx_plan_find_encoder(const struct lx_plan *self, const char *name)
{
    struct lx_plan_name wanted = {.list = LX_PLAN_ENCODER, .text = name};
    const int index = lx_plan_names_find(&self->names, &wanted);
    wanted.list = LX_PLAN_ALIAS;
    return index < 0 ? lx_plan_names_find(&self->names, &wanted) : index;
}

int lx_plan_add_setting(struct lx_plan_settings *self, const char *key, const char *value,
                        lx_line_number line, struct lx_error *error)
{
    struct lx_plan_setting *list = room(self->list, self->count, sizeof *list);
    if (list == NULL) {
        return lx_fail(error, "no memory for %s", key);
    }
    self->list = list;
    struct lx_plan_setting *row = &list[self->count++];
    *row = (struct lx_plan_setting){.line = line};
    return copy(&row->key, key) && copy(&row->value, value)
               ? 0
               : lx_fail(error, "no memory for %s", key);
}

int lx_plan_add_assignment(struct lx_plan_settings *self, const char *assignment,
                           lx_line_number line, struct lx_error *error)
{
    const char *equals = strchr(assignment, '=');
    if (equals == NULL || equals == assignment) {
        (void)lx_refuse(error, "KEY=VALUE is right", "%s", "");
        return lx_about(error, LX_ABOUT_SETTING, assignment, NULL);
    }
    char *key = strndup(assignment, (size_t)(equals - assignment));
    const int result = key == NULL ? lx_fail(error, "no memory for %s", assignment)
                                   : lx_plan_add_setting(self, key, equals + 1, line, error);
    free(key);
    return result;
}

lx_line_number lx_plan_setting_line(const struct lx_plan_encoder *encoder, const char *key)
{
    for (size_t i = 0; i < encoder->settings.count; i++) {
        if (strcmp(encoder->settings.list[i].key, key) == 0) {
            return encoder->settings.list[i].line;
        }
    }
    return encoder->line;
}

int lx_plan_refuse_setting(const struct lx_plan *self, const struct lx_plan_setting *setting,
                           struct lx_error *error)
{
    (void)lx_about(error, LX_ABOUT_SETTING, setting->key, setting->value);
    return lx_stands(error, self->file, setting->line);
}

int lx_plan_refuse_key(const struct lx_plan *self, const char *key, lx_line_number line,
                       struct lx_error *error)
{
    (void)lx_about(error, LX_ABOUT_KEY, key, NULL);
    return lx_stands(error, self->file, line);
}

int lx_plan_refuse_wire(const struct lx_plan *self, const struct lx_plan_wire *wire,
                        struct lx_error *error)
{
    (void)lx_about(error, LX_ABOUT_WIRE, wire->kind->name, wire->where);
    return lx_stands(error, self->file, wire->where_line != 0 ? wire->where_line : wire->line);
}

void lx_plan_free_settings(struct lx_plan_settings *self)
{
    for (size_t i = 0; i < self->count; i++) {
        free(self->list[i].key);
        free(self->list[i].value);
    }
    free(self->list);
    *self = (struct lx_plan_settings){.list = NULL};
}

static void free_shafts(struct lx_plan *self)
{
    for (size_t i = 0; i < self->shaft_count; i++) {
        free(self->shafts[i].name);
        free(self->shafts[i].motion);
    }
    free(self->shafts);
}

static void free_wires(struct lx_plan *self)
{
    for (size_t i = 0; i < self->wire_count; i++) {
        struct lx_plan_wire *wire = &self->wires[i];
        free(wire->name);
        free(wire->where);
        free(wire->trace);
        lx_plan_free_settings(&wire->settings);
    }
    free(self->wires);
}

static void free_encoders(struct lx_plan *self)
{
    for (size_t i = 0; i < self->encoder_count; i++) {
        struct lx_plan_encoder *encoder = &self->encoders[i];
        free(encoder->name);
        free(encoder->nvm);
        free(encoder->serial);
        lx_plan_free_settings(&encoder->settings);
    }
    free(self->encoders);
}

void lx_plan_free(struct lx_plan *self)
{
    lx_plan_names_free(&self->names);
    free_encoders(self);
    free_wires(self);
    free_shafts(self);
    free(self->files);
    for (size_t i = 0; i < self->control_count; i++) {
        free(self->controls[i]);
    }
    free(self->name);
    *self = (struct lx_plan){.file = NULL};
}

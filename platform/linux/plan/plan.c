/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "plan.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Room for one more behind `count` rows: the capacity is the next power of two. @return where the
   rows are now, or NULL with the old ones in place */
static void *room(void *list, size_t count, size_t size)
{
    if (count > 0 && (count & (count - 1u)) != 0) {
        return list;
    }
    return realloc(list, (count == 0 ? 1u : count * 2u) * size);
}

/* A copy; NULL stays NULL. @return false without memory */
static bool copy(char **to, const char *text)
{
    *to = text == NULL ? NULL : strdup(text);
    return text == NULL || *to != NULL;
}

int lx_plan_add_shaft(struct lx_plan *self, const char *name, const char *motion)
{
    struct lx_plan_shaft *list = self->shaft_count < LX_PLAN_SHAFTS_MAX
                                     ? room(self->shafts, self->shaft_count, sizeof *list)
                                     : NULL;
    if (list == NULL) {
        return -1;
    }
    self->shafts = list;
    struct lx_plan_shaft *row = &list[self->shaft_count++];
    *row = (struct lx_plan_shaft){.driver = -1, .ratio = {1, 1}};
    return copy(&row->name, name) && copy(&row->motion, motion) ? (int)self->shaft_count - 1 : -1;
}

int lx_plan_add_wire(struct lx_plan *self, const char *name, const struct lx_wire *kind,
                     const char *where)
{
    struct lx_plan_wire *list = self->wire_count < LX_PLAN_WIRES_MAX
                                    ? room(self->wires, self->wire_count, sizeof *list)
                                    : NULL;
    if (list == NULL) {
        return -1;
    }
    self->wires = list;
    struct lx_plan_wire *row = &list[self->wire_count++];
    *row = (struct lx_plan_wire){.kind = kind};
    return copy(&row->name, name) && copy(&row->where, where) ? (int)self->wire_count - 1 : -1;
}

int lx_plan_add_encoder(struct lx_plan *self, const char *name, const struct dg_device *model,
                        size_t shaft, size_t wire)
{
    struct lx_plan_encoder *list = self->encoder_count < LX_PLAN_ENCODERS_MAX
                                       ? room(self->encoders, self->encoder_count, sizeof *list)
                                       : NULL;
    if (list == NULL) {
        return -1;
    }
    self->encoders = list;
    struct lx_plan_encoder *row = &list[self->encoder_count++];
    *row = (struct lx_plan_encoder){.model = model, .shaft = shaft, .wire = wire};
    return copy(&row->name, name) ? (int)self->encoder_count - 1 : -1;
}

int lx_plan_add_setting(struct lx_plan_settings *self, const char *assignment, lx_line_number line,
                        struct lx_error *error)
{
    const char *equals = strchr(assignment, '=');
    if (equals == NULL) {
        return lx_fail(error, "--set %s: KEY=VALUE is right", assignment);
    }
    struct lx_plan_setting *list = room(self->list, self->count, sizeof *list);
    if (list == NULL) {
        return lx_fail(error, "no memory for %s", assignment);
    }
    self->list = list;
    struct lx_plan_setting *row = &list[self->count++];
    *row = (struct lx_plan_setting){.line = line};
    row->key = strndup(assignment, (size_t)(equals - assignment));
    if (row->key == NULL || !copy(&row->value, equals + 1)) {
        return lx_fail(error, "no memory for %s", assignment);
    }
    return 0;
}

/* Whoever was nearer to what is wrong has said where it stands. */
static bool is_placed(const struct lx_plan *self, const char *text)
{
    const size_t n = strlen(self->file);
    return strncmp(text, self->file, n) == 0 && text[n] == ':';
}

/* An argument may be the text of `error` itself. */
int lx_plan_fail(const struct lx_plan *self, lx_line_number line, struct lx_error *error,
                 const char *format, ...)
{
    struct lx_error text;
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text.text, sizeof text.text, format, arguments);
    va_end(arguments);
    if (self->file == NULL || line == 0 || is_placed(self, text.text)) {
        return lx_fail(error, "%s", text.text);
    }
    /* What is cut off is the end of the list of what would be right. */
    const int room_left = (int)sizeof error->text / 2;
    return lx_fail(error, "%.*s:%u: %s", room_left, self->file, line, text.text);
}

static void free_settings(struct lx_plan_settings *self)
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
        free_settings(&wire->settings);
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
        free(encoder->address);
        free_settings(&encoder->settings);
    }
    free(self->encoders);
}

void lx_plan_free(struct lx_plan *self)
{
    free_encoders(self);
    free_wires(self);
    free_shafts(self);
    free(self->files);
    for (size_t i = 0; i < self->control_count; i++) {
        free(self->controls[i]);
    }
    free(self->name);
    free(self->file);
    *self = (struct lx_plan){.file = NULL};
}

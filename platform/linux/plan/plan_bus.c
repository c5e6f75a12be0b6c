/* SPDX-License-Identifier: MIT */
/* [bus NAME] of a rig file, and the private wire of an encoder. */
#define _GNU_SOURCE
#include "plan_section.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "wire.h"

int lx_plan_find_wire(const struct lx_plan *plan, const char *name)
{
    for (size_t i = 0; i < plan->wire_count; i++) {
        if (strcasecmp(plan->wires[i].name, name) == 0) {
            return (int)i;
        }
    }
    return -1;
}

const struct lx_wire *lx_plan_take_kind(const struct lx_plan *plan,
                                        const struct lx_plan_setting *row, size_t n,
                                        struct lx_error *error)
{
    struct lx_error names = {""};
    const struct lx_wire *kind = lx_wire_find(row->value, n);
    for (size_t i = 0; kind == NULL && i < lx_wire_count; i++) {
        const size_t used = strlen(names.text);
        const char *between = i + 1 == lx_wire_count ? " and " : ", ";
        (void)snprintf(names.text + used, sizeof names.text - used, "%s%s", i == 0 ? "" : between,
                       lx_wires[i].name);
    }
    if (kind == NULL) {
        (void)lx_plan_fail(plan, row->line, error, "wire: %.*s is no kind of wire; %s are right",
                           (int)n, row->value, names.text);
    }
    return kind;
}

static int check_where(const struct lx_plan *plan, const struct lx_wire *kind,
                       const struct lx_plan_where *where, struct lx_error *error)
{
    if (where->text != NULL && kind->where == NULL) {
        return lx_plan_fail(plan, where->line, error, "%s: %s has no address; none is right",
                            where->key, kind->name);
    }
    if (where->text == NULL && kind->where_needed) {
        return lx_plan_fail(plan, where->line, error, "%s: %s needs an address; %s is right",
                            where->key, kind->name, kind->where);
    }
    return 0;
}

/* Whether two addresses are the same place; a free port never is. */
static bool same_place(const struct lx_plan_wire *a, const struct lx_plan_wire *b)
{
    static const char any[] = ":0";
    const bool comparable =
        a->kind == b->kind || (a->kind->where_is_path && b->kind->where_is_path);
    if (!comparable || a->where == NULL || b->where == NULL || strcmp(a->where, b->where) != 0) {
        return false;
    }
    const size_t n = strlen(a->where);
    return a->kind->where_is_path || n < strlen(any) ||
           strcmp(a->where + n - strlen(any), any) != 0;
}

/* Whoever gives two encoders one place most likely wants them to share it. */
static const char *right_instead(const struct lx_plan_wire *a, const struct lx_plan_wire *b,
                                 const struct lx_plan_where *where)
{
    const bool can_share = a->kind == b->kind && a->kind->stations_max > 1;
    return can_share && strcmp(where->key, "wire") == 0
               ? "another address, or a [bus NAME] with this one and bus = NAME in both encoders"
               : "another address";
}

static int check_place(const struct lx_plan *plan, int at, const struct lx_plan_where *where,
                       struct lx_error *error)
{
    const struct lx_plan_wire *wire = &plan->wires[at];
    for (int i = 0; i < at; i++) {
        const struct lx_plan_wire *other = &plan->wires[i];
        if (same_place(other, wire)) {
            return lx_plan_fail(plan, where->line, error,
                                "%s: %s is the wire in line %u already; %s is right", where->key,
                                wire->where, other->line, right_instead(other, wire, where));
        }
    }
    return 0;
}

int lx_plan_take_wire(struct lx_plan *plan, const struct lx_plan_section *self,
                      const struct lx_wire *kind, const struct lx_plan_where *where,
                      struct lx_error *error)
{
    char *path = NULL;
    const int same = lx_plan_find_wire(plan, self->name);
    if (same >= 0) {
        return lx_plan_taken(plan, self, plan->wires[same].line, error);
    }
    if (check_where(plan, kind, where, error) != 0 ||
        (where->text != NULL && kind->where_is_path &&
         lx_plan_take_path(plan, where->text, &path, error) != 0)) {
        return -1;
    }
    const char *given = path == NULL ? where->text : path;
    const int at = lx_plan_add_wire(plan, self->name, kind, given == NULL ? kind->usual : given);
    free(path);
    if (at < 0) {
        return lx_plan_no_room(plan, self, error);
    }
    plan->wires[at].line = self->line;
    return check_place(plan, at, where, error) == 0 ? at : -1;
}

int lx_plan_take_trace(struct lx_plan *plan, const struct lx_plan_setting *row, int wire,
                       struct lx_error *error)
{
    char **to = &plan->wires[wire].trace;
    if (row == NULL) {
        return 0;
    }
    if (lx_plan_take_path(plan, row->value, to, error) != 0) {
        return -1;
    }
    for (int i = 0; i < wire; i++) {
        if (plan->wires[i].trace != NULL && strcmp(plan->wires[i].trace, *to) == 0) {
            return lx_plan_fail(plan, row->line, error,
                                "trace: %s is of the wire in line %u already; another file is "
                                "right",
                                row->value, plan->wires[i].line);
        }
    }
    return 0;
}

/* ", a, b and c": the keys of a kind; "" without. */
static struct lx_error keys_of(const struct lx_wire *kind)
{
    struct lx_error list = {""};
    for (size_t i = 0; kind->keys != NULL && kind->keys[i] != NULL; i++) {
        const size_t used = strlen(list.text);
        const char *between = i > 0 && kind->keys[i + 1] == NULL ? " and " : ", ";
        (void)snprintf(list.text + used, sizeof list.text - used, "%s%s", between, kind->keys[i]);
    }
    return list;
}

/* A bus has only the keys of its kind. */
static int take_bus_settings(struct lx_plan *plan, const struct lx_plan_section *self, int wire,
                             struct lx_error *error)
{
    const struct lx_wire *kind = plan->wires[wire].kind;
    for (size_t i = 0; i < self->words.count; i++) {
        const struct lx_plan_setting *row = &self->words.list[i];
        if (lx_plan_section_has(self->kind, row->key)) {
            continue;
        }
        if (!lx_wire_has(kind, row->key)) {
            const struct lx_error keys = keys_of(kind);
            return lx_plan_fail(plan, row->line, error,
                                "%s: no key of a %s bus; wire, address, trace%s are right",
                                row->key, kind->name, keys.text);
        }
        if (lx_plan_copy_setting(&plan->wires[wire].settings, row, error) != 0) {
            return -1;
        }
    }
    return 0;
}

int lx_plan_take_bus(struct lx_plan *plan, const struct lx_plan_section *self,
                     struct lx_error *error)
{
    const struct lx_plan_setting *row = lx_plan_word(self, "wire");
    const struct lx_plan_setting *address = lx_plan_word(self, "address");
    if (row == NULL) {
        return lx_plan_fail(plan, self->line, error,
                            "[bus %s]: without a wire; wire = pty, for one, is right", self->name);
    }
    const struct lx_wire *kind = lx_plan_take_kind(plan, row, strlen(row->value), error);
    const struct lx_plan_where where = {
        .key = "address",
        .text = address == NULL ? NULL : address->value,
        .line = address == NULL ? self->line : address->line,
    };
    const int wire = kind == NULL ? -1 : lx_plan_take_wire(plan, self, kind, &where, error);
    if (wire < 0 || lx_plan_take_trace(plan, lx_plan_word(self, "trace"), wire, error) != 0) {
        return -1;
    }
    return take_bus_settings(plan, self, wire, error);
}

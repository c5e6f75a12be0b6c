/* SPDX-License-Identifier: MIT */
/* [bus NAME] of a rig file, and the private wire of an encoder. */
#define _GNU_SOURCE
#include "plan_section.h"

#include <stdlib.h>
#include <string.h>

#include "wire.h"

int lx_plan_find_wire(const struct lx_plan *plan, const char *name)
{
    return lx_plan_names_find(&plan->names,
                              &(struct lx_plan_name){.list = LX_PLAN_WIRE, .text = name});
}

const struct lx_wire *lx_plan_take_kind(const struct lx_plan *plan,
                                        const struct lx_plan_setting *row, size_t n,
                                        struct lx_error *error)
{
    const struct lx_wire *kind = lx_wire_find(row->value, n);
    struct lx_words names = {""};
    for (size_t i = 0; i < lx_wire_count; i++) {
        lx_words_item(&names, lx_wires[i].name, i, lx_wire_count, " and ");
    }
    lx_words_add(&names, " are right");
    if (kind == NULL) {
        (void)lx_plan_wrong_word(plan, row, error, names.text, "%.*s is no kind of wire", (int)n,
                                 row->value);
    }
    return kind;
}

/* The word that is wrong, or should be there. */
static int wrong_where(const struct lx_plan *plan, const struct lx_plan_section *self,
                       const struct lx_plan_where *where, struct lx_error *error)
{
    return lx_plan_refuse_key(plan, where->key,
                              where->word == NULL ? self->line : where->word->line, error);
}

static int check_where(const struct lx_plan *plan, const struct lx_plan_section *self,
                       const struct lx_wire *kind, const struct lx_plan_where *where,
                       struct lx_error *error)
{
    struct lx_words right = {""};
    if (where->text != NULL && kind->where == NULL) {
        (void)lx_refuse(error, "none is right", "%s has no address", kind->name);
        return wrong_where(plan, self, where, error);
    }
    if (where->text == NULL && kind->where_needed) {
        lx_words_add(&right, "%s is right", kind->where);
        (void)lx_refuse(error, right.text, "%s needs an address", kind->name);
        return wrong_where(plan, self, where, error);
    }
    return 0;
}

/* Port 0 behind the last colon, whatever words follow it. */
static bool is_any_port(const char *where)
{
    const char *port = strrchr(where, ':');
    return port != NULL && port[1] == '0' && (port[2] == '\0' || port[2] == ',');
}

/* Whether no other wire may have this address; a free port anybody may. */
static bool is_taken_up(const struct lx_plan_wire *self)
{
    return self->where != NULL &&
           (lx_wire_is_path(self->kind, self->where) || !is_any_port(self->where));
}

/* Paths are one scope, whatever wire is there; other addresses are each kind's own. */
static struct lx_plan_name place_of(const struct lx_plan_wire *self)
{
    return (struct lx_plan_name){
        .list = LX_PLAN_PLACE,
        .scope = lx_wire_is_path(self->kind, self->where) ? 0 : (uintptr_t)self->kind,
        .text = self->where,
    };
}

/* Whoever gives two encoders one place most likely wants them to share it. */
static struct lx_words right_instead(const struct lx_plan_wire *a, const struct lx_plan_wire *b,
                                     const struct lx_plan_where *where)
{
    const bool can_share = a->kind == b->kind && a->kind->stations_max > 1;
    struct lx_words right = {"another address"};
    if (can_share && strcmp(where->key, "wire") == 0) {
        lx_words_add(&right,
                     ", or [bus NAME] with wire = %s and address = %s, and bus = NAME in both "
                     "encoders,",
                     a->kind->name, a->where);
    }
    lx_words_add(&right, " is right");
    return right;
}

static int take_place(struct lx_plan *plan, const struct lx_plan_section *self, int at,
                      const struct lx_plan_where *where, struct lx_error *error)
{
    const struct lx_plan_wire *wire = &plan->wires[at];
    if (!is_taken_up(wire)) {
        return 0;
    }
    const struct lx_plan_name place = place_of(wire);
    const int same = lx_plan_names_find(&plan->names, &place);
    if (same >= 0) {
        const struct lx_plan_wire *other = &plan->wires[same];
        (void)lx_refuse(error, right_instead(other, wire, where).text,
                        "%s is the wire in line %u already", wire->where, other->line);
        return wrong_where(plan, self, where, error);
    }
    return lx_plan_names_add(&plan->names, &place, at) == 0 ? 0
                                                            : lx_plan_no_room(plan, self, error);
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
    if (check_where(plan, self, kind, where, error) != 0 ||
        (lx_wire_is_path(kind, where->text) &&
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
    plan->wires[at].where_line = where->word == NULL ? 0 : where->word->line;
    return take_place(plan, self, at, where, error) == 0 ? at : -1;
}

int lx_plan_take_trace(struct lx_plan *plan, const struct lx_plan_setting *row, int wire,
                       struct lx_error *error)
{
    char **to = &plan->wires[wire].trace;
    if (row == NULL) {
        return 0;
    }
    plan->wires[wire].trace_line = row->line;
    if (lx_plan_take_path(plan, row->value, to, error) != 0) {
        return -1;
    }
    const struct lx_plan_name name = {.list = LX_PLAN_TRACE, .text = *to};
    const int same = lx_plan_names_find(&plan->names, &name);
    if (same >= 0) {
        return lx_plan_wrong_word(plan, row, error, "another file is right",
                                  "%s is of the wire in line %u already", row->value,
                                  plan->wires[same].line);
    }
    return lx_plan_names_add(&plan->names, &name, wire) == 0
               ? 0
               : lx_fail(error, "no memory for %s", row->value);
}

/* The keys of a bus of this kind. */
static struct lx_words keys_of(const struct lx_plan_section *self, const struct lx_wire *kind)
{
    struct lx_words list = {""};
    size_t own = 0;
    while (self->kind->keys[own] != NULL) {
        own++;
    }
    const size_t count = own + (kind->keys == NULL ? 0 : kind->keys->count);
    for (size_t i = 0; i < count; i++) {
        lx_words_item(&list, i < own ? self->kind->keys[i] : kind->keys->rows[i - own].name, i,
                      count, " and ");
    }
    lx_words_add(&list, " are right");
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
            return lx_plan_wrong_word(plan, row, error, keys_of(self, kind).text,
                                      "no key of a %s bus", kind->name);
        }
        if (lx_plan_add_setting(&plan->wires[wire].settings, row->key, row->value, row->line,
                                error) != 0) {
            return -1;
        }
    }
    return 0;
}

/* KIND:ADDRESS is right in [encoder]; here they are two keys. */
static int check_kind(const struct lx_plan *plan, const struct lx_plan_setting *row,
                      struct lx_error *error)
{
    const size_t n = strcspn(row->value, ":");
    struct lx_words right = {""};
    if (row->value[n] == '\0' || lx_wire_find(row->value, n) == NULL) {
        return 0;
    }
    lx_words_add(&right, "wire = %.*s and address = %s in a line each are right", (int)n,
                 row->value, row->value + n + 1);
    return lx_plan_wrong_word(plan, row, error, right.text, "%s is a kind and an address",
                              row->value);
}

int lx_plan_take_bus(struct lx_plan *plan, const struct lx_plan_section *self,
                     struct lx_error *error)
{
    const struct lx_plan_setting *row = lx_plan_word(self, "wire");
    const struct lx_plan_setting *address = lx_plan_word(self, "address");
    if (row == NULL) {
        return lx_plan_wrong_section(plan, self, error, "wire = pty, for one, is right",
                                     "without a wire");
    }
    if (check_kind(plan, row, error) != 0) {
        return -1;
    }
    const struct lx_wire *kind = lx_plan_take_kind(plan, row, strlen(row->value), error);
    const struct lx_plan_where where = {
        .text = address == NULL ? NULL : address->value,
        .key = "address",
        .word = address,
    };
    const int wire = kind == NULL ? -1 : lx_plan_take_wire(plan, self, kind, &where, error);
    if (wire < 0 || lx_plan_take_trace(plan, lx_plan_word(self, "trace"), wire, error) != 0) {
        return -1;
    }
    return take_bus_settings(plan, self, wire, error);
}

/* SPDX-License-Identifier: MIT */
/* [bus NAME] of a rig file, and the private wire of an encoder. */
#include "rig_private.h"

const struct dg_plan_wire_kind *dg_plan_take_kind(struct rig_reader *in,
                                                  const struct dg_plan_setting *word, size_t n)
{
    const struct rig_cut name = dg_plan_cut(word->value, n);
    const struct dg_plan_wire_kind *kind = dg_plan_find_kind(word->value, n);
    struct rig_list names;

    dg_plan_list_begin(&names);
    for (size_t i = 0; kind == NULL && i < dg_plan_wire_count; i++) {
        dg_plan_list_item(&names, dg_plan_wires[i].name, i, dg_plan_wire_count);
    }
    if (kind == NULL) {
        (void)dg_plan_wrong_word(in, word, RIG_SAY("expected ", names.room),
                                 RIG_SAY(name.text, " is no kind of wire"));
    }
    return kind;
}

/* The word that is wrong, or should be there. */
static int refuse_where(struct rig_reader *in, const struct rig_section *self,
                        const struct rig_where *where)
{
    return dg_plan_refuse_key(in, where->key, where->word == NULL ? self->line : where->word->line);
}

static int check_where(struct rig_reader *in, const struct rig_section *self,
                       const struct dg_plan_wire_kind *kind, const struct rig_where *where)
{
    if (where->text != NULL && kind->where == NULL) {
        (void)dg_plan_refuse(in->error, RIG_SAY("expected no address"),
                             RIG_SAY(kind->name, " has no address"));
        return refuse_where(in, self, where);
    }
    if (where->text == NULL && kind->where_needed) {
        (void)dg_plan_refuse(in->error, RIG_SAY("expected ", kind->where),
                             RIG_SAY(kind->name, " needs an address"));
        return refuse_where(in, self, where);
    }
    return 0;
}

/* Port 0 behind the last colon, whatever words follow it. */
static bool is_any_port(const char *where)
{
    const char *port = NULL;

    for (const char *at = where; *at != '\0'; at++) {
        port = *at == ':' ? at : port;
    }
    return port != NULL && port[1] == '0' && (port[2] == '\0' || port[2] == ',');
}

/* Whether no other wire may have this address; a free port anybody may. */
static bool is_taken_up(const struct dg_plan_wire *self)
{
    return self->where != NULL &&
           (dg_plan_is_path(self->kind, self->where) || !is_any_port(self->where));
}

/* Paths are one scope, whatever wire is there; other addresses are each kind's own. */
static struct dg_plan_name wire_place_of(const struct dg_plan_wire *self)
{
    const uint32_t kind = (uint32_t)(self->kind - dg_plan_wires);

    return (struct dg_plan_name){
        .list = RIG_PLACE,
        .scope = dg_plan_is_path(self->kind, self->where) ? 0 : kind + 1u,
        .text = self->where,
    };
}

/* Whoever gives two encoders one place most likely wants them to share it. */
static int refuse_place(struct rig_reader *in, const struct rig_section *self,
                        const struct dg_plan_wire *a, const struct dg_plan_wire *b,
                        const struct rig_where *where)
{
    const bool can_share = a->kind == b->kind && a->kind->stations_max > 1u;
    const bool both = can_share && dg_plan_same(where->key, "wire");
    const struct rig_line line = dg_plan_line_text(in->plan, a->line, self->line);

    (void)dg_plan_refuse(
        in->error,
        both ? RIG_SAY("expected another address, or [bus NAME] with wire = ", a->kind->name,
                       " and address = ", a->where, ", and bus = NAME in both encoders")
             : RIG_SAY("expected another address"),
        RIG_SAY(b->where, " is the wire in line ", line.text, " already"));
    return refuse_where(in, self, where);
}

static int take_place(struct rig_reader *in, const struct rig_section *self, int at,
                      const struct rig_where *where)
{
    const struct dg_plan_wire *wire = &in->plan->wires[at];

    if (!is_taken_up(wire)) {
        return 0;
    }
    struct dg_plan_name place = wire_place_of(wire);
    const int same = dg_plan_names_find(in->plan, &place);
    if (same >= 0) {
        return refuse_place(in, self, &in->plan->wires[same], wire, where);
    }
    place.index = at;
    return dg_plan_names_add(in->plan, &place);
}

int dg_plan_take_wire(struct rig_reader *in, const struct rig_section *self,
                      const struct dg_plan_wire_kind *kind, const struct rig_where *where)
{
    struct dg_plan *plan = in->plan;
    const int same = dg_plan_find_wire(plan, self->name);

    if (same >= 0) {
        return dg_plan_taken(in, self, plan->wires[same].line);
    }
    if (check_where(in, self, kind, where) != 0) {
        return -1;
    }
    const int at = dg_plan_add_wire(plan, self->name, kind, NULL);
    if (at < 0) {
        return -1;
    }
    struct dg_plan_wire *wire = &plan->wires[at];
    const dg_plan_line line = where->word == NULL ? 0 : where->word->line;
    wire->where = where->text == NULL ? kind->usual : where->text;
    if (dg_plan_is_path(kind, where->text)) {
        wire->where = dg_plan_path(in, where->text, line);
    }
    wire->line = self->line;
    wire->where_line = line;
    return !plan->out && take_place(in, self, at, where) == 0 ? at : -1;
}

int dg_plan_take_trace(struct rig_reader *in, const struct dg_plan_setting *word, int wire)
{
    struct dg_plan *plan = in->plan;

    if (word == NULL) {
        return 0;
    }
    struct dg_plan_name name = {.list = RIG_TRACE, .index = wire};
    name.text = dg_plan_path(in, word->value, word->line);
    if (name.text == NULL) {
        return -1;
    }
    plan->wires[wire].trace_line = word->line;
    plan->wires[wire].trace = name.text;
    const int same = dg_plan_names_find(plan, &name);
    if (same >= 0) {
        return dg_plan_wrong_word(
            in, word, RIG_SAY("expected another file"),
            RIG_SAY(word->value, " is of the wire in line ",
                    dg_plan_line_text(plan, plan->wires[same].line, word->line).text, " already"));
    }
    return dg_plan_names_add(plan, &name);
}

/* A bus has only the keys of its kind. */
static int refuse_bus_key(struct rig_reader *in, const struct rig_section *self,
                          const struct dg_plan_wire_kind *kind, const struct dg_plan_setting *word)
{
    struct rig_list list;
    size_t own = 0;

    while (self->kind->keys[own].name != NULL) {
        own++;
    }
    const size_t count = own + (kind->keys == NULL ? 0 : kind->keys->count);
    dg_plan_list_begin(&list);
    for (size_t i = 0; i < count; i++) {
        dg_plan_list_item(
            &list, i < own ? self->kind->keys[i].name : kind->keys->rows[i - own].name, i, count);
    }
    return dg_plan_wrong_word(in, word, RIG_SAY("expected ", list.room),
                              RIG_SAY("no key of a ", kind->name, " bus"));
}

static int take_bus_settings(struct rig_reader *in, const struct rig_section *self, int wire)
{
    struct dg_plan_wire *of = &in->plan->wires[wire];

    for (size_t i = 0; i < self->count; i++) {
        const struct dg_plan_setting *word = dg_plan_word_at(self, i);
        if (!dg_plan_kind_has(self->kind, word->key) && !dg_plan_wire_has(of->kind, word->key)) {
            return refuse_bus_key(in, self, of->kind, word);
        }
    }
    return dg_plan_take_settings(in, self, of->kind, true, &of->settings);
}

/* KIND:ADDRESS is right in [encoder]; here they are two keys. */
static int check_wire_kind(struct rig_reader *in, const struct dg_plan_setting *word)
{
    const size_t n = dg_plan_span(word->value, ':');
    const struct rig_cut kind = dg_plan_cut(word->value, n);

    if (word->value[n] == '\0' || dg_plan_find_kind(word->value, n) == NULL) {
        return 0;
    }
    return dg_plan_wrong_word(in, word,
                              RIG_SAY("expected wire = ", kind.text,
                                      " and address = ", word->value + n + 1u, " in a line each"),
                              RIG_SAY(word->value, " is a kind and an address"));
}

int dg_plan_take_bus(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan_setting *word = dg_plan_word(self, "wire");
    const struct dg_plan_setting *address = dg_plan_word(self, "address");

    if (word == NULL) {
        return dg_plan_wrong_section(in, self, RIG_SAY("expected a wire, for example wire = pty"),
                                     RIG_SAY("without a wire"));
    }
    if (check_wire_kind(in, word) != 0) {
        return -1;
    }
    const struct dg_plan_wire_kind *kind = dg_plan_take_kind(in, word, dg_plan_length(word->value));
    const struct rig_where where = {
        .text = address == NULL ? NULL : address->value,
        .key = "address",
        .word = address,
    };
    const int wire = kind == NULL ? -1 : dg_plan_take_wire(in, self, kind, &where);
    if (wire < 0 || dg_plan_take_trace(in, dg_plan_word(self, "trace"), wire) != 0) {
        return -1;
    }
    return take_bus_settings(in, self, wire);
}

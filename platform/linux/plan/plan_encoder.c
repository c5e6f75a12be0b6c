/* SPDX-License-Identifier: MIT */
/* [encoder NAME] of a rig file, one encoder. */
#define _GNU_SOURCE
#include "plan_section.h"

#include <limits.h>
#include <string.h>

#include "wire.h"

/* The shaft of encoders in a file without one. */
#define DEFAULT_SHAFT "main"

/* The encoder that has this name of a list; NULL: none. */
static const struct lx_plan_encoder *holder(const struct lx_plan *plan,
                                            const struct lx_plan_name *name)
{
    const int at = lx_plan_names_find(&plan->names, name);
    return at < 0 ? NULL : &plan->encoders[at];
}

/* Whoever mistyped `model` has it in another line. @return the word, or NULL */
static const struct lx_plan_setting *mistyped_model(const struct lx_plan_section *self)
{
    for (size_t i = 0; i < self->words.count; i++) {
        const struct lx_plan_setting *row = &self->words.list[i];
        if (!lx_plan_section_has(self->kind, row->key) && dg_device_find(row->value) != NULL) {
            return row;
        }
    }
    return NULL;
}

static const struct dg_device *
take_model(const struct lx_plan *plan, const struct lx_plan_section *self, struct lx_error *error)
{
    const struct lx_plan_setting *row = lx_plan_word(self, "model");
    const struct lx_plan_setting *mistyped = mistyped_model(self);
    const struct dg_device *model = row == NULL ? NULL : dg_device_find(row->value);
    struct lx_words right = {""};
    if (row == NULL && mistyped != NULL) {
        lx_words_add(&right, "model = %s is right", mistyped->value);
        (void)lx_plan_wrong_word(plan, mistyped, error, right.text, "no such key");
        return NULL;
    }
    lx_words_add(&right, "%s one of:", row == NULL ? "model = MODEL is right," : "right is");
    lx_stack_models(NULL, &right);
    if (row == NULL) {
        (void)lx_plan_wrong_section(plan, self, error, right.text, "without a model");
    } else if (model == NULL) {
        (void)lx_plan_wrong_word(plan, row, error, right.text, "%s is none", row->value);
    }
    return model;
}

/* The first shaft is everybody's who names none; there always is one then. @return its index, or -1
   with `error` */
static int take_shaft_of(struct lx_plan *plan, const struct lx_plan_section *self,
                         struct lx_error *error)
{
    const struct lx_plan_setting *row = lx_plan_word(self, "shaft");
    if (row == NULL && plan->shaft_count == 0) {
        const int at = lx_plan_add_shaft(plan, DEFAULT_SHAFT, NULL);
        return at < 0 ? lx_plan_no_room(plan, self, error) : at;
    }
    const int shaft = row == NULL ? 0 : lx_plan_find_shaft(plan, row->value);
    return shaft >= 0 ? shaft
                      : lx_plan_wrong_word(plan, row, error, "the NAME of a [shaft] above is right",
                                           "no shaft %s so far", row->value);
}

static int no_plug(const struct lx_plan *plan, const struct lx_plan_setting *row,
                   const struct lx_wire *kind, const struct dg_device *model,
                   struct lx_error *error)
{
    struct lx_words right = {""};
    lx_stack_wires(lx_stack_of(model), &right);
    lx_words_add(&right, " is right");
    return lx_plan_wrong_word(plan, row, error, right.text, "%s is no wire of %s", kind->name,
                              model->name);
}

static int use_bus(const struct lx_plan *plan, const struct lx_plan_setting *row,
                   const struct dg_device *model, struct lx_error *error)
{
    const int at = lx_plan_find_wire(plan, row->value);
    if (at < 0 || plan->wires[at].is_private) {
        return lx_plan_wrong_word(plan, row, error, "the NAME of a [bus] above is right",
                                  "no bus %s so far", row->value);
    }
    const struct lx_plan_wire *wire = &plan->wires[at];
    const struct lx_wire *kind = wire->kind;
    if (!lx_wire_carries(kind, lx_stack_of(model))) {
        return no_plug(plan, row, kind, model, error);
    }
    if (wire->stack != NULL && wire->stack != model->stack && !kind->mixed) {
        return lx_plan_wrong_word(plan, row, error, "another bus is right",
                                  "%s has encoders of another protocol", row->value);
    }
    return wire->encoder_count < kind->stations_max
               ? at
               : lx_plan_wrong_word(plan, row, error, "no more are right",
                                    "%s has %zu encoders already", row->value, wire->encoder_count);
}

/* KIND or KIND:ADDRESS. */
static int make_wire(struct lx_plan *plan, const struct lx_plan_section *self,
                     const struct dg_device *model, struct lx_error *error)
{
    const struct lx_plan_setting *row = lx_plan_word(self, "wire");
    const size_t n = strcspn(row->value, ":");
    const struct lx_plan_where where = {
        .text = row->value[n] == '\0' ? NULL : row->value + n + 1,
        .key = "wire",
        .word = row,
    };
    const struct lx_wire *kind = lx_plan_take_kind(plan, row, n, error);
    if (kind == NULL) {
        return -1;
    }
    if (!lx_wire_carries(kind, lx_stack_of(model))) {
        return no_plug(plan, row, kind, model, error);
    }
    const int at = lx_plan_take_wire(plan, self, kind, &where, error);
    if (at >= 0) {
        plan->wires[at].is_private = true;
    }
    return at;
}

/* None, or two of them. */
static int wrong_wire(const struct lx_plan *plan, const struct lx_plan_section *self,
                      const struct lx_plan_setting *bus, struct lx_error *error)
{
    static const char right[] =
        "bus = NAME of a [bus] above, or wire = KIND or KIND:ADDRESS is right";
    struct lx_words name = {""};
    lx_words_add(&name, "[encoder %s]", self->name);
    (void)lx_refuse(error, right, "%s", bus == NULL ? "without a wire" : "a bus and a wire");
    return lx_plan_refuse_key(plan, name.text, bus == NULL ? self->line : bus->line, error);
}

static int take_wire_of(struct lx_plan *plan, const struct lx_plan_section *self,
                        const struct dg_device *model, struct lx_error *error)
{
    const struct lx_plan_setting *bus = lx_plan_word(self, "bus");
    const struct lx_plan_setting *wire = lx_plan_word(self, "wire");
    const struct lx_plan_setting *trace = lx_plan_word(self, "trace");
    if ((bus == NULL) == (wire == NULL)) {
        return wrong_wire(plan, self, bus, error);
    }
    if (bus != NULL && trace != NULL) {
        struct lx_words right = {""};
        lx_words_add(&right, "trace = FILE in [bus %s] is right", bus->value);
        return lx_plan_wrong_word(plan, trace, error, right.text,
                                  "a bus has one for all its encoders");
    }
    if (bus != NULL) {
        return use_bus(plan, bus, model, error);
    }
    const int at = make_wire(plan, self, model, error);
    return at < 0 || lx_plan_take_trace(plan, trace, at, error) != 0 ? -1 : at;
}

/* --- what the bus tells encoders apart by --- */

static int number_of(const struct lx_plan_encoder *encoder)
{
    return encoder->address == LX_PLAN_AS_DELIVERED ? lx_stack_of(encoder->model)->address.delivered
                                                    : encoder->address;
}

static struct lx_words text_of(const struct lx_plan_encoder *encoder)
{
    const bool hex = lx_stack_of(encoder->model)->address.hex;
    struct lx_words text = {""};
    lx_words_add(&text, hex ? "0x%02X" : "%u", (unsigned)number_of(encoder));
    return text;
}

/* A number for each wire, protocol and address. */
static struct lx_plan_name number_name(const struct lx_plan_encoder *self)
{
    return (struct lx_plan_name){
        .list = LX_PLAN_NUMBER,
        .scope = self->wire << CHAR_BIT | (size_t)(number_of(self) & UCHAR_MAX),
        .text = self->model->stack->name,
    };
}

/* `row` gives the number; NULL: it is as delivered. */
static int check_number(struct lx_plan *plan, const struct lx_plan_section *section,
                        const struct lx_plan_encoder *self, const struct lx_plan_setting *row,
                        struct lx_error *error)
{
    const char *key = lx_stack_of(self->model)->core->address_key;
    const struct lx_plan_name name = number_name(self);
    const struct lx_plan_encoder *other = key == NULL ? NULL : holder(plan, &name);
    if (other != NULL) {
        struct lx_words right = {""};
        lx_words_add(&right, "%s = N with another one is right", key);
        (void)lx_refuse(error, right.text, "%s%s is %s of [encoder %s] already",
                        row == NULL ? "as delivered " : "",
                        row == NULL ? text_of(self).text : row->value, key, other->name);
        return lx_plan_refuse_key(plan, key, row == NULL ? section->line : row->line, error);
    }
    return lx_plan_names_add(&plan->names, &name, (int)(self - plan->encoders)) == 0
               ? 0
               : lx_plan_no_room(plan, section, error);
}

static int refuse_number(const struct lx_plan *plan, const struct lx_plan_setting *row,
                         const struct dg_device *model, struct lx_error *error)
{
    const char *key = lx_stack_of(model)->core->address_key;
    struct lx_words right = {""};
    lx_words_add(&right, "%s%s is right",
                 key == NULL ? "its place among the encoders of its wire" : key,
                 key == NULL ? "" : " = N");
    return lx_plan_wrong_word(plan, row, error, right.text, "%s has none", model->name);
}

/* `node`, `address`, or whatever key the stack has. */
static int take_number(struct lx_plan *plan, const struct lx_plan_section *self,
                       struct lx_plan_encoder *encoder, struct lx_error *error)
{
    const struct lx_stack *stack = lx_stack_of(encoder->model);
    const char *key = stack->core->address_key;
    for (size_t i = 0; i < self->words.count; i++) {
        const struct lx_plan_setting *word = &self->words.list[i];
        if (lx_is_address_key(word->key) && (key == NULL || strcmp(key, word->key) != 0)) {
            return refuse_number(plan, word, encoder->model, error);
        }
    }
    const struct lx_plan_setting *row = key == NULL ? NULL : lx_plan_word(self, key);
    if (row != NULL) {
        encoder->address_line = row->line;
        encoder->address = lx_stack_address(stack, row->value, error);
        if (encoder->address < 0) {
            return lx_plan_refuse_key(plan, row->key, row->line, error);
        }
    }
    return check_number(plan, self, encoder, row, error);
}

static int take_nvm(struct lx_plan *plan, const struct lx_plan_setting *row,
                    struct lx_plan_encoder *encoder, struct lx_error *error)
{
    if (row == NULL) {
        return 0;
    }
    encoder->nvm_line = row->line;
    if (lx_plan_take_path(plan, row->value, &encoder->nvm, error) != 0) {
        return -1;
    }
    const struct lx_plan_name name = {.list = LX_PLAN_MEMORY, .text = encoder->nvm};
    const struct lx_plan_encoder *other = holder(plan, &name);
    if (other != NULL) {
        return lx_plan_wrong_word(plan, row, error, "another file is right",
                                  "%s is of [encoder %s] already", row->value, other->name);
    }
    return lx_plan_names_add(&plan->names, &name, (int)(encoder - plan->encoders)) == 0
               ? 0
               : lx_fail(error, "no memory for %s", row->value);
}

/* On a private wire its own keys may be set here, too. */
static int take_settings(struct lx_plan *plan, const struct lx_plan_section *self,
                         struct lx_plan_encoder *encoder, struct lx_error *error)
{
    struct lx_plan_wire *wire = &plan->wires[encoder->wire];
    for (size_t i = 0; i < self->words.count; i++) {
        const struct lx_plan_setting *row = &self->words.list[i];
        const bool of_wire = lx_wire_has(wire->kind, row->key);
        if (lx_plan_section_has(self->kind, row->key)) {
            continue;
        }
        if (of_wire && wire->line != encoder->line) {
            struct lx_words right = {""};
            lx_words_add(&right, "%s = %s in [bus %s] is right", row->key, row->value, wire->name);
            return lx_plan_wrong_word(plan, row, error, right.text,
                                      "a bus has one for all its encoders");
        }
        if (lx_plan_add_setting(of_wire ? &wire->settings : &encoder->settings, row->key,
                                row->value, row->line, error) != 0) {
            return -1;
        }
    }
    return 0;
}

int lx_plan_take_encoder(struct lx_plan *plan, const struct lx_plan_section *self,
                         struct lx_error *error)
{
    const struct lx_plan_encoder *same =
        holder(plan, &(struct lx_plan_name){.list = LX_PLAN_ENCODER, .text = self->name});
    const struct lx_plan_setting *serial = lx_plan_word(self, "serial");
    if (same != NULL) {
        return lx_plan_taken(plan, self, same->line, error);
    }
    const struct dg_device *model = take_model(plan, self, error);
    const int shaft = model == NULL ? -1 : take_shaft_of(plan, self, error);
    const int wire = shaft < 0 ? -1 : take_wire_of(plan, self, model, error);
    if (wire < 0) {
        return -1;
    }
    const int at = lx_plan_add_encoder(plan, self->name, model, (size_t)shaft, (size_t)wire);
    if (at < 0) {
        return lx_plan_no_room(plan, self, error);
    }
    struct lx_plan_encoder *encoder = &plan->encoders[at];
    encoder->line = self->line;
    if (serial != NULL) {
        encoder->serial_line = serial->line;
        if (lx_plan_take_text(serial, &encoder->serial, error) != 0) {
            return -1;
        }
    }
    if (take_number(plan, self, encoder, error) != 0 ||
        take_nvm(plan, lx_plan_word(self, "nvm"), encoder, error) != 0) {
        return -1;
    }
    return take_settings(plan, self, encoder, error);
}

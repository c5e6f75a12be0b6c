/* SPDX-License-Identifier: MIT */
/* [encoder NAME] of a rig file, one encoder. */
#include "drehgeber/figure.h"
#include "rig_private.h"

#include <limits.h>

/* The shaft of encoders in a file without one. */
#define DEFAULT_SHAFT "main"

/* ---------------------------------------------------------------- models */

/* Whoever mistyped `model` has it in another line. @return the word, or NULL */
static const struct dg_plan_setting *find_mistyped(const struct rig_reader *in,
                                                   const struct rig_section *self)
{
    for (size_t i = 0; i < self->count; i++) {
        const struct dg_plan_setting *word = dg_plan_word_at(self, i);
        if (!dg_plan_kind_has(self->kind, word->key) &&
            (dg_plan_find_model(in->plan, word->value) != NULL ||
             dg_model_file_of(word->value) != NULL)) {
            return word;
        }
    }
    return NULL;
}

static const struct dg_device *take_model(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan_setting *word = dg_plan_word(self, "model");
    const struct dg_plan_setting *mistyped = word == NULL ? find_mistyped(in, self) : NULL;
    const struct dg_device *model = NULL;

    if (dg_plan_take_name(in, word, &model) != 0) {
        return NULL;
    }
    if (mistyped != NULL) {
        (void)dg_plan_wrong_word(in, mistyped, RIG_SAY("expected model = ", mistyped->value),
                                 RIG_SAY("no such key"));
    } else if (model == NULL) {
        (void)dg_plan_refuse_model(in, self, "model", word);
    }
    return model;
}

/* ---------------------------------------------------------------- shafts, wires */

/* The first shaft is everybody's who names none; there always is one then. @return its index, or -1
   with `error` */
static int take_shaft_of(struct rig_reader *in, const struct rig_section *self)
{
    const struct dg_plan_setting *word = dg_plan_word(self, "shaft");

    if (word == NULL && in->plan->shaft_count == 0) {
        return dg_plan_add_shaft(in->plan, DEFAULT_SHAFT, NULL);
    }
    const int shaft = word == NULL ? 0 : dg_plan_find_shaft(in->plan, word->value);
    return shaft >= 0
               ? shaft
               : dg_plan_wrong_word(in, word, RIG_SAY("expected the NAME of a [shaft] above"),
                                    RIG_SAY("no shaft ", word->value, " so far"));
}

static int refuse_kind(struct rig_reader *in, const struct dg_plan_setting *word,
                       const struct dg_plan_wire_kind *kind, const struct dg_device *model)
{
    struct rig_list right;
    const char *between = "";

    dg_plan_list_begin(&right);
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        const struct dg_plan_wire_kind *other = &dg_plan_wires[i];
        if (dg_plan_carries(other, model->stack)) {
            dg_plan_add(&right.text, RIG_SAY(between, other->name));
            between = " or ";
        }
    }
    return dg_plan_wrong_word(in, word, RIG_SAY("expected ", right.room),
                              RIG_SAY(kind->name, " is no wire of ", model->name));
}

static int use_bus(struct rig_reader *in, const struct dg_plan_setting *word,
                   const struct dg_device *model)
{
    const int at = dg_plan_find_wire(in->plan, word->value);

    if (at < 0 || in->plan->wires[at].is_private) {
        return dg_plan_wrong_word(in, word, RIG_SAY("expected the NAME of a [bus] above"),
                                  RIG_SAY("no bus ", word->value, " so far"));
    }
    const struct dg_plan_wire *wire = &in->plan->wires[at];
    if (!dg_plan_carries(wire->kind, model->stack)) {
        return refuse_kind(in, word, wire->kind, model);
    }
    if (wire->stack != NULL && wire->stack != model->stack && !wire->kind->mixed) {
        return dg_plan_wrong_word(in, word, RIG_SAY("expected another bus"),
                                  RIG_SAY(word->value, " has encoders of another protocol"));
    }
    return wire->encoder_count < wire->kind->stations_max
               ? at
               : dg_plan_wrong_word(in, word, RIG_SAY("expected no more encoders"),
                                    RIG_SAY(word->value, " has ",
                                            dg_plan_number(wire->encoder_count).text,
                                            " encoders already"));
}

/* KIND or KIND:ADDRESS. */
static int make_encoder_wire(struct rig_reader *in, const struct rig_section *self,
                             const struct dg_device *model)
{
    const struct dg_plan_setting *word = dg_plan_word(self, "wire");
    const size_t n = dg_plan_span(word->value, ':');
    const struct rig_where where = {
        .text = word->value[n] == '\0' ? NULL : word->value + n + 1u,
        .key = "wire",
        .word = word,
    };
    const struct dg_plan_wire_kind *kind = dg_plan_take_kind(in, word, n);
    if (kind == NULL) {
        return -1;
    }
    if (!dg_plan_carries(kind, model->stack)) {
        return refuse_kind(in, word, kind, model);
    }
    const int at = dg_plan_take_wire(in, self, kind, &where);
    if (at >= 0) {
        in->plan->wires[at].is_private = true;
    }
    return at;
}

/* None, or two of them. */
static int refuse_wire(struct rig_reader *in, const struct rig_section *self,
                       const struct dg_plan_setting *bus)
{
    const struct dg_plan_setting word = {.line = bus == NULL ? self->line : bus->line};
    struct rig_section section = *self;

    section.line = word.line;
    return dg_plan_wrong_section(
        in, &section,
        RIG_SAY("expected bus = NAME of a [bus] above, or wire = KIND or KIND:ADDRESS"),
        RIG_SAY(bus == NULL ? "without a wire" : "a bus and a wire"));
}

static int take_wire_of(struct rig_reader *in, const struct rig_section *self,
                        const struct dg_device *model)
{
    const struct dg_plan_setting *bus = dg_plan_word(self, "bus");
    const struct dg_plan_setting *wire = dg_plan_word(self, "wire");
    const struct dg_plan_setting *trace = dg_plan_word(self, "trace");

    if ((bus == NULL) == (wire == NULL)) {
        return refuse_wire(in, self, bus);
    }
    if (bus != NULL && trace != NULL) {
        return dg_plan_wrong_word(in, trace,
                                  RIG_SAY("expected trace = FILE in [bus ", bus->value, "]"),
                                  RIG_SAY("a bus has one for all its encoders"));
    }
    if (bus != NULL) {
        return use_bus(in, bus, model);
    }
    const int at = make_encoder_wire(in, self, model);
    return at < 0 || dg_plan_take_trace(in, trace, at) != 0 ? -1 : at;
}

/* ---------------------------------------------------------------- addresses */

int dg_plan_address(const struct dg_device *model, const char *text)
{
    const struct dg_key *row = dg_plan_address_row(model);
    uint64_t number = 0;

    return dg_unsigned_parse(text, &number) && number >= (uint64_t)row->min &&
                   number <= (uint64_t)row->max
               ? (int)number
               : -1;
}

/* As delivered it is the model's, if that is a file which says so, else the protocol's. */
static int address_number_of(const struct dg_plan *plan, const struct dg_plan_encoder *encoder)
{
    int delivered = encoder->model->stack->address_delivered;

    for (size_t i = 0; i < plan->model_file_count; i++) {
        const struct dg_plan_model_file *file = &plan->model_files[i];
        delivered =
            file->device == encoder->model && file->address != 0 ? file->address : delivered;
    }
    return encoder->address == DG_PLAN_AS_DELIVERED ? delivered : encoder->address;
}

/* The encoder that has this name of a list; NULL: none. */
static const struct dg_plan_encoder *holder(const struct dg_plan *plan,
                                            const struct dg_plan_name *name)
{
    const int at = dg_plan_names_find(plan, name);

    return at < 0 ? NULL : &plan->encoders[at];
}

/* What the bus tells encoders apart by: a number for each wire, protocol and address. `word` gives
   it; NULL: it is as delivered. */
static int check_number(struct rig_reader *in, const struct rig_section *section,
                        const struct dg_plan_encoder *self, const struct dg_plan_setting *word)
{
    const char *key = self->model->stack->address_key;
    const int own = address_number_of(in->plan, self);
    const struct dg_plan_name name = {
        .list = RIG_NUMBER,
        .scope = (uint32_t)self->wire << CHAR_BIT | (uint32_t)(own & UCHAR_MAX),
        .text = self->model->stack->name,
        .index = (int)(self - in->plan->encoders),
    };
    const struct dg_plan_encoder *other = key == NULL ? NULL : holder(in->plan, &name);

    if (other != NULL) {
        const struct rig_number number = dg_plan_address_text(self->model, own);
        (void)dg_plan_refuse(in->error, RIG_SAY("expected ", key, " = N with another one"),
                             RIG_SAY(word == NULL ? "as delivered " : "",
                                     word == NULL ? number.text : word->value, " is ", key,
                                     " of [encoder ", other->name, "] already"));
        return dg_plan_refuse_key(in, key, word == NULL ? section->line : word->line);
    }
    return key == NULL ? 0 : dg_plan_names_add(in->plan, &name);
}

static int refuse_number(struct rig_reader *in, const struct dg_plan_setting *word,
                         const struct dg_device *model)
{
    const char *key = model->stack->address_key;

    return dg_plan_wrong_word(in, word,
                              key == NULL ? RIG_SAY("the order of the encoders on its wire decides")
                                          : RIG_SAY("expected ", key, " = N"),
                              RIG_SAY(model->name, " has none"));
}

static int refuse_address(struct rig_reader *in, const struct dg_plan_setting *word,
                          const struct dg_device *model)
{
    struct rig_list right;

    dg_plan_list_begin(&right);
    dg_plan_say_addresses(model, &right.text);
    (void)dg_plan_refuse(in->error, RIG_SAY("expected ", right.room), NULL);
    (void)dg_plan_about(in->error, word->key, word->value);
    return dg_plan_refuse_key(in, word->key, word->line);
}

/* `node`, `address`, or whatever key the stack has. */
static int take_address(struct rig_reader *in, const struct rig_section *self,
                        struct dg_plan_encoder *encoder)
{
    const char *key = encoder->model->stack->address_key;

    for (size_t i = 0; i < self->count; i++) {
        const struct dg_plan_setting *word = dg_plan_word_at(self, i);
        if (dg_plan_is_address_key(word->key) && (key == NULL || !dg_plan_same(key, word->key))) {
            return refuse_number(in, word, encoder->model);
        }
    }
    const struct dg_plan_setting *found = key == NULL ? NULL : dg_plan_word(self, key);
    if (found != NULL) {
        encoder->address_line = found->line;
        encoder->address = dg_plan_address(encoder->model, found->value);
        if (encoder->address < 0) {
            return refuse_address(in, found, encoder->model);
        }
    }
    return check_number(in, self, encoder, found);
}

/* ---------------------------------------------------------------- the rest of it */

static int take_nvm(struct rig_reader *in, const struct dg_plan_setting *word,
                    struct dg_plan_encoder *encoder)
{
    struct dg_plan_name name = {.list = RIG_MEMORY, .index = (int)(encoder - in->plan->encoders)};

    if (word == NULL) {
        return 0;
    }
    name.text = dg_plan_path(in, word->value, word->line);
    if (name.text == NULL) {
        return -1;
    }
    encoder->nvm_line = word->line;
    encoder->nvm = name.text;
    const struct dg_plan_encoder *other = holder(in->plan, &name);
    if (other != NULL) {
        return dg_plan_wrong_word(
            in, word, RIG_SAY("expected another file"),
            RIG_SAY(word->value, " is of [encoder ", other->name, "] already"));
    }
    return dg_plan_names_add(in->plan, &name);
}

/* On a private wire its own keys may be set here, too. Encoders of one section have the same. */
static int take_settings(struct rig_reader *in, const struct rig_section *self,
                         struct dg_plan_encoder *encoder)
{
    struct dg_plan_wire *wire = &in->plan->wires[encoder->wire];
    const bool first = encoder == in->plan->encoders || encoder[-1].line != self->line;

    for (size_t i = 0; i < self->count; i++) {
        const struct dg_plan_setting *word = dg_plan_word_at(self, i);
        if (!wire->is_private && !dg_plan_kind_has(self->kind, word->key) &&
            dg_plan_wire_has(wire->kind, word->key)) {
            return dg_plan_wrong_word(
                in, word,
                RIG_SAY("expected ", word->key, " = ", word->value, " in [bus ", wire->name, "]"),
                RIG_SAY("a bus has one for all its encoders"));
        }
    }
    if (!first) {
        encoder->settings = encoder[-1].settings;
        return 0;
    }
    if (wire->is_private &&
        dg_plan_take_settings(in, self, wire->kind, true, &wire->settings) != 0) {
        return -1;
    }
    return dg_plan_take_settings(in, self, wire->kind, false, &encoder->settings);
}

static int take_serial(struct rig_reader *in, const struct dg_plan_setting *word,
                       struct dg_plan_encoder *encoder)
{
    if (word == NULL) {
        return 0;
    }
    encoder->serial_line = word->line;
    encoder->serial = dg_plan_copy(in->plan, word->value);
    return encoder->serial == NULL ? -1 : 0;
}

int dg_plan_take_encoder(struct rig_reader *in, const struct rig_section *self)
{
    struct dg_plan *plan = in->plan;
    const struct dg_plan_encoder *same =
        holder(plan, &(struct dg_plan_name){.list = RIG_ENCODER, .text = self->name});

    if (same != NULL) {
        return dg_plan_taken(in, self, same->line);
    }
    const struct dg_device *model = take_model(in, self);
    const int shaft = model == NULL ? -1 : take_shaft_of(in, self);
    const int wire = shaft < 0 ? -1 : take_wire_of(in, self, model);
    const int at =
        wire < 0 ? -1 : dg_plan_add_encoder(plan, self->name, model, (size_t)shaft, (size_t)wire);
    if (at < 0) {
        return -1;
    }
    struct dg_plan_encoder *encoder = &plan->encoders[at];
    encoder->line = self->line;
    return take_serial(in, dg_plan_word(self, "serial"), encoder) != 0 ||
                   take_address(in, self, encoder) != 0 ||
                   take_nvm(in, dg_plan_word(self, "nvm"), encoder) != 0
               ? -1
               : take_settings(in, self, encoder);
}

/* SPDX-License-Identifier: MIT */
/* [encoder NAME] of a rig file. */
#define _GNU_SOURCE
#include "plan_section.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "figure.h"
#include "wire.h"

/* The shaft of encoders in a file without one. */
#define DEFAULT_SHAFT "main"

/* How the encoders of one stack are told apart on a bus; by their places where there is no key. */
static const struct place {
    const struct dg_stack *stack;
    const char *key;
    const char *what;
    uint8_t min;
    uint8_t max;
    uint8_t delivered;
} places[] = {
    {&dg_hf_stack, "address", "an RS485 address; 0x40..0x5F", 0x40, 0x5F, 0x40},
    {&dg_cia406_stack, "node", "a node-ID; 1..127", 1, 127, 63},
    {NULL, NULL, NULL, 0, 0, 0}, /* all others */
};

static const struct place *place_of(const struct dg_device *model)
{
    const struct place *row = places;
    while (row->stack != NULL && row->stack != model->stack) {
        row++;
    }
    return row;
}

static const struct lx_plan_encoder *find_encoder(const struct lx_plan *plan, const char *name)
{
    for (size_t i = 0; i < plan->encoder_count; i++) {
        if (strcasecmp(plan->encoders[i].name, name) == 0) {
            return &plan->encoders[i];
        }
    }
    return NULL;
}

static const struct dg_device *
take_model(const struct lx_plan *plan, const struct lx_plan_section *self, struct lx_error *error)
{
    const struct lx_plan_setting *row = lx_plan_word(self, "model");
    const struct dg_device *model = row == NULL ? NULL : dg_device_find(row->value);
    struct lx_error names = {""};
    for (size_t i = 0; i < dg_device_count; i++) {
        const size_t used = strlen(names.text);
        (void)snprintf(names.text + used, sizeof names.text - used, " %s", dg_devices[i]->name);
    }
    if (row == NULL) {
        (void)lx_plan_fail(plan, self->line, error,
                           "[encoder %s]: without a model; model = MODEL is right, one of:%s",
                           self->name, names.text);
    } else if (model == NULL) {
        (void)lx_plan_fail(plan, row->line, error, "model: %s is none; right is one of:%s",
                           row->value, names.text);
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
    return shaft >= 0
               ? shaft
               : lx_plan_fail(plan, row->line, error,
                              "shaft: no shaft %s so far; the NAME of a [shaft] above is right",
                              row->value);
}

/* A private wire has the line of its encoder, a bus one of its own. */
static bool is_bus(const struct lx_plan *plan, int wire)
{
    for (size_t i = 0; i < plan->encoder_count; i++) {
        if (plan->encoders[i].line == plan->wires[wire].line) {
            return false;
        }
    }
    return true;
}

static int no_plug(const struct lx_plan *plan, const struct lx_plan_setting *row,
                   const struct lx_wire *kind, const struct dg_device *model,
                   struct lx_error *error)
{
    struct lx_error names = {""};
    for (size_t i = 0; i < lx_wire_count; i++) {
        const size_t used = strlen(names.text);
        if (lx_wires[i].stack == model->stack) {
            (void)snprintf(names.text + used, sizeof names.text - used, "%s%s",
                           used == 0 ? "" : " or ", lx_wires[i].name);
        }
    }
    return lx_plan_fail(plan, row->line, error, "%s: %s is no wire of %s; %s is right", row->key,
                        kind->name, model->name, names.text);
}

static int use_bus(const struct lx_plan *plan, const struct lx_plan_setting *row,
                   const struct dg_device *model, struct lx_error *error)
{
    const int wire = lx_plan_find_wire(plan, row->value);
    size_t stations = 0;
    if (wire < 0 || !is_bus(plan, wire)) {
        return lx_plan_fail(plan, row->line, error,
                            "bus: no bus %s so far; the NAME of a [bus] above is right",
                            row->value);
    }
    const struct lx_wire *kind = plan->wires[wire].kind;
    for (size_t i = 0; i < plan->encoder_count; i++) {
        stations += plan->encoders[i].wire == (size_t)wire ? 1u : 0u;
    }
    if (kind->stack != model->stack) {
        return no_plug(plan, row, kind, model, error);
    }
    return stations < kind->stations_max
               ? wire
               : lx_plan_fail(plan, row->line, error,
                              "bus: %s has %lu encoders already; no more are right", row->value,
                              (unsigned long)stations);
}

/* KIND or KIND:ADDRESS. */
static int make_wire(struct lx_plan *plan, const struct lx_plan_section *self,
                     const struct dg_device *model, struct lx_error *error)
{
    const struct lx_plan_setting *row = lx_plan_word(self, "wire");
    const size_t n = strcspn(row->value, ":");
    const struct lx_plan_where where = {
        .key = "wire",
        .text = row->value[n] == '\0' ? NULL : row->value + n + 1,
        .line = row->line,
    };
    const struct lx_wire *kind = lx_plan_take_kind(plan, row, n, error);
    if (kind == NULL) {
        return -1;
    }
    if (kind->stack != model->stack) {
        return no_plug(plan, row, kind, model, error);
    }
    return lx_plan_take_wire(plan, self, kind, &where, error);
}

static int take_wire_of(struct lx_plan *plan, const struct lx_plan_section *self,
                        const struct dg_device *model, struct lx_error *error)
{
    const struct lx_plan_setting *bus = lx_plan_word(self, "bus");
    const struct lx_plan_setting *wire = lx_plan_word(self, "wire");
    const struct lx_plan_setting *trace = lx_plan_word(self, "trace");
    if ((bus == NULL) == (wire == NULL)) {
        return lx_plan_fail(plan, bus == NULL ? self->line : bus->line, error,
                            "[encoder %s]: %s; bus = NAME of a [bus] above, or wire = KIND or "
                            "KIND:ADDRESS is right",
                            self->name, bus == NULL ? "without a wire" : "a bus and a wire");
    }
    if (bus != NULL && trace != NULL) {
        return lx_plan_fail(plan, trace->line, error,
                            "trace: a bus has one for all its encoders; trace = FILE in [bus %s] "
                            "is right",
                            bus->value);
    }
    if (bus != NULL) {
        return use_bus(plan, bus, model, error);
    }
    const int at = make_wire(plan, self, model, error);
    return at < 0 || lx_plan_take_trace(plan, trace, at, error) != 0 ? -1 : at;
}

/* The number by which the bus tells `encoder` from others. It was checked. */
static uint64_t number_of(const struct lx_plan_encoder *encoder)
{
    uint64_t number = place_of(encoder->model)->delivered;
    if (encoder->address != NULL) {
        (void)lx_unsigned_parse(encoder->address, &number);
    }
    return number;
}

static int check_number(const struct lx_plan *plan, const struct lx_plan_encoder *self,
                        struct lx_error *error)
{
    const struct place *place = place_of(self->model);
    const lx_line_number line = self->address == NULL ? self->line : self->address_line;
    for (size_t i = 0; place->key != NULL && i < plan->encoder_count; i++) {
        const struct lx_plan_encoder *other = &plan->encoders[i];
        if (other != self && other->wire == self->wire && number_of(other) == number_of(self)) {
            return lx_plan_fail(
                plan, line, error, "%s: %s is %s of [encoder %s] already; another one is right",
                place->key, self->address == NULL ? "as delivered it" : self->address, place->key,
                other->name);
        }
    }
    return 0;
}

static int refuse_number(const struct lx_plan *plan, const struct lx_plan_setting *row,
                         const struct dg_device *model, struct lx_error *error)
{
    const char *key = place_of(model)->key;
    return lx_plan_fail(plan, row->line, error, "%s: %s has none; %s%s is right", row->key,
                        model->name, key == NULL ? "its place among the encoders of its wire" : key,
                        key == NULL ? "" : " = N");
}

/* `node` or `address`, whichever the stack has. */
static int take_number(struct lx_plan *plan, const struct lx_plan_section *self,
                       struct lx_plan_encoder *encoder, struct lx_error *error)
{
    static const char *const keys[] = {"node", "address"};
    const struct place *place = place_of(encoder->model);
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        const struct lx_plan_setting *row = lx_plan_word(self, keys[i]);
        uint64_t number = 0;
        if (row == NULL) {
            continue;
        }
        if (place->key == NULL || strcmp(place->key, row->key) != 0) {
            return refuse_number(plan, row, encoder->model, error);
        }
        if (!lx_unsigned_parse(row->value, &number) || number < place->min || number > place->max) {
            return lx_plan_fail(plan, row->line, error, "%s: %s is not %s is right", row->key,
                                row->value, place->what);
        }
        encoder->address_line = row->line;
        if (lx_plan_take_text(row, &encoder->address, error) != 0) {
            return -1;
        }
    }
    return check_number(plan, encoder, error);
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
    for (size_t i = 0; i < plan->encoder_count; i++) {
        const struct lx_plan_encoder *other = &plan->encoders[i];
        if (other != encoder && other->nvm != NULL && strcmp(other->nvm, encoder->nvm) == 0) {
            return lx_plan_fail(plan, row->line, error,
                                "nvm: %s is of [encoder %s] already; another file is right",
                                row->value, other->name);
        }
    }
    return 0;
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
            return lx_plan_fail(plan, row->line, error,
                                "%s: a bus has one for all its encoders; %s = %s in [bus %s] is "
                                "right",
                                row->key, row->key, row->value, wire->name);
        }
        if (lx_plan_copy_setting(of_wire ? &wire->settings : &encoder->settings, row, error) != 0) {
            return -1;
        }
    }
    return 0;
}

int lx_plan_take_encoder(struct lx_plan *plan, const struct lx_plan_section *self,
                         struct lx_error *error)
{
    const struct lx_plan_encoder *same = find_encoder(plan, self->name);
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

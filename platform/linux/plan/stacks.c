/* SPDX-License-Identifier: MIT */
#include "stacks.h"

#include <string.h>

#include "course_words.h"
#include "wire.h"

const struct lx_stack *lx_stack_of(const struct dg_device *device)
{
    size_t i = 0;
    while (lx_stacks[i]->core != device->stack) {
        i++; /* each has a row; a test looks */
    }
    return lx_stacks[i];
}

static const char serial_key[] = "serial";

const struct dg_key *lx_stack_serial(const struct lx_stack *self)
{
    return dg_keys_find(self->handle->keys, serial_key);
}

static const struct dg_key *address_row(const struct lx_stack *self)
{
    const char *key = self->core->address_key;
    return key == NULL ? NULL : dg_keys_find(self->handle->keys, key);
}

/* Bit n: row n of the core is not for --set. */
static uint32_t apart(const struct lx_stack *self)
{
    const struct dg_key *const rows[] = {lx_stack_serial(self), address_row(self)};
    uint32_t bits = 0;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        bits |= rows[i] == NULL ? 0 : UINT32_C(1) << (rows[i] - self->handle->keys->rows);
    }
    return bits;
}

void lx_stack_keys(const struct lx_stack *self, const struct dg_device *device, void *settings,
                   struct dg_world *world, struct lx_keys lists[LX_STACK_LISTS])
{
    const bool all = device == NULL || self->without == NULL;
    lists[LX_STACK_OWN] = (struct lx_keys){
        .rows = self->own.rows,
        .count = self->own.count,
        .base = settings,
    };
    lists[LX_STACK_CORE] = (struct lx_keys){
        .rows = self->handle->keys->rows,
        .count = self->handle->keys->count,
        .base = settings,
        .without = apart(self) | (all ? 0 : self->without(device)),
        .instead = self->instead,
    };
    lists[LX_STACK_WORLD] = (struct lx_keys){
        .rows = dg_world_keys.rows,
        .count = dg_world_keys.count,
        .base = world,
        .without = self->handle->blind,
    };
}

/* --- settings --- */

size_t lx_stack_size(const struct lx_stack *self)
{
    return self->own_size > 0 ? self->own_at + self->own_size : self->handle->settings_size;
}

void lx_stack_deliver(const struct lx_stack *self, const struct dg_device *device, void *settings)
{
    const struct dg_host_wire *handle = self->handle;
    if (handle->furnish != NULL) {
        handle->furnish(settings, device);
    } else {
        memcpy(settings, device->model, handle->settings_size);
    }
    if (self->own_size > 0) {
        memcpy((uint8_t *)settings + self->own_at, self->usual, self->own_size);
    }
}

/* A key of another kind of wire, or of none: whoever mistyped one finds it in the list. */
static int unknown_key(const struct lx_keys *lists, const struct dg_plan_wire_kind *kind,
                       const char *name, struct lx_error *error)
{
    struct lx_words right = {"valid:"};
    struct lx_words wires = {""};
    const size_t others = lx_wires_with(name, &wires);
    if (others > 0) {
        return lx_refuse(error, "leave it out", "only %s%s %s it", others == 1 ? "a " : "",
                         wires.text, others == 1 ? "wire has" : "wires have");
    }
    lx_keys_name(lists, LX_STACK_LISTS, &right);
    for (size_t i = 0; kind != NULL && kind->keys != NULL && i < kind->keys->count; i++) {
        lx_words_add(&wires, " %s", kind->keys->rows[i].name);
    }
    lx_words_add(&right, "%s%s", wires.text[0] == '\0' ? "" : "; of the wire:", wires.text);
    (void)lx_refuse(error, right.text, "no such key");
    return lx_about(error, LX_ABOUT_SETTING, name, NULL);
}

/* A course is understood here; its file is only read when the rig is made. */
static int check_course(const char *text, struct lx_error *error)
{
    struct dg_course_words words;
    return lx_course_parse(text, &words, error);
}

static int set_one(const struct lx_keys *lists, const struct dg_plan_wire_kind *kind,
                   const struct dg_plan_setting *setting, struct lx_error *error)
{
    void *base = NULL;
    const struct dg_key *key = lx_keys_find(lists, LX_STACK_LISTS, setting->key, &base);
    if (key == NULL) {
        return unknown_key(lists, kind, setting->key, error);
    }
    return base == lists[LX_STACK_WORLD].base && dg_course_is(setting->value)
               ? check_course(setting->value, error)
               : lx_key_set(key, base, setting->value, error);
}

static int set_serial(const struct dg_plan *plan, const struct dg_plan_encoder *encoder,
                      const struct lx_stack *self, void *settings, struct lx_error *error)
{
    const struct dg_key *serial = lx_stack_serial(self);
    if (encoder->serial == NULL) {
        return 0;
    }
    if (serial == NULL) {
        (void)lx_refuse(error, "leave it out", "%s has none", encoder->model->name);
    } else if (lx_key_set(serial, settings, encoder->serial, error) == 0) {
        return 0;
    }
    (void)lx_about(error, LX_ABOUT_KEY, serial_key, encoder->serial);
    return lx_plan_stands(plan, encoder->serial_line, error);
}

int lx_stack_settings(const struct dg_plan *plan, const struct dg_plan_wire *wire,
                      const struct dg_plan_encoder *encoder, void *settings, struct dg_world *world,
                      struct lx_error *error)
{
    const struct lx_stack *self = lx_stack_of(encoder->model);
    const struct dg_plan_settings *list = &encoder->settings;
    struct lx_keys lists[LX_STACK_LISTS];
    lx_stack_keys(self, encoder->model, settings, world, lists);
    lx_stack_deliver(self, encoder->model, settings);
    for (size_t i = 0; i < list->count; i++) {
        if (set_one(lists, wire->kind, &list->list[i], error) != 0) {
            return lx_plan_refuse_setting(plan, &list->list[i], error);
        }
    }
    if (set_serial(plan, encoder, self, settings, error) != 0) {
        return -1;
    }
    if (self->check == NULL || self->check(settings, error) == 0) {
        return 0;
    }
    (void)lx_about(error, LX_ABOUT_ITSELF, "", NULL);
    return lx_plan_stands(plan, encoder->line, error);
}

/* --- names --- */

void lx_stack_models(const struct lx_stack *self, struct lx_words *to)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        if (self == NULL || lx_stack_of(dg_devices[i]) == self) {
            lx_words_add(to, " %s", dg_devices[i]->name);
        }
    }
}

/* SPDX-License-Identifier: MIT */
/*
 * An encoder from its EDS file: which encoder its objects belong to, its steps and turns.
 */
#include "any.h"
#include "drehgeber/text.h"

#define PROFILE 406u
#define STEPS_DEFAULT 65536u
#define TURNS_DEFAULT 4096u
#define RANGE_MAX (UINT64_C(1) << 32)

/* Causes, their numbers and the default of `any` are the F36x8's. */
static const struct dg_co_device *choose_base(uint32_t type, uint32_t vendor, uint32_t product)
{
    static const struct dg_co_device *const own[] = {&dg_cia406_singleturn, &dg_cia406_multiturn};

    for (size_t i = 0; i < DG_COUNT(own); i++) {
        if (own[i]->vendor_id == vendor && own[i]->product_code == product &&
            own[i]->device_type == type) {
            return own[i];
        }
    }
    return &dg_cia406_any;
}

/* The default of a constant object; 0: there is none. */
static uint32_t constant_of(const struct dg_co_file *file, uint32_t key)
{
    const struct dg_co_dictionary *dictionary = &file->device.dictionary;

    for (uint16_t i = 0; i < dictionary->count; i++) {
        const struct dg_co_row *row = &dictionary->rows[i];
        if ((row->key & 0xFFFFFF00u) == key && row->flags >> 12 != DG_CO_STRING && row->hook == 0) {
            return (row->flags & DG_CO_W) == 0 ? row->initial : 0;
        }
    }
    return 0;
}

static void note_figure(const struct dg_eds_setup *setup, const char *what)
{
    if (setup->note != NULL) {
        const struct dg_eds_note note = {
            .line = dg_co_find_object(setup, 0x6501),
            .section = "6501",
            .what = what,
        };
        setup->note(setup->ctx, &note);
    }
}

/* 6501h and 6502h; a singleturn encoder need not have the latter. */
static void find_figures(struct dg_cia406_file *self, const struct dg_eds_setup *setup)
{
    const bool profile = (self->file.device.device_type & 0xFFFFu) == PROFILE;
    const bool multiturn = (self->file.device.device_type >> 16 & 2u) != 0;
    const uint32_t steps = profile ? constant_of(&self->file, DG_CO_KEY(0x6501, 0)) : STEPS_DEFAULT;
    const uint32_t turns = profile ? constant_of(&self->file, DG_CO_KEY(0x6502, 0)) : TURNS_DEFAULT;

    self->steps = steps != 0 ? steps : STEPS_DEFAULT;
    self->turns = turns != 0 ? turns : multiturn ? TURNS_DEFAULT : 1u;
    if (steps == 0 || (turns == 0 && multiturn)) {
        note_figure(setup, "6501h or 6502h without a default: 65536 steps, 4096 turns");
    }
    if ((uint64_t)self->steps * self->turns > RANGE_MAX) {
        self->turns = (uint32_t)(RANGE_MAX / self->steps);
        note_figure(setup, "6501h times 6502h is beyond 2^32: fewer turns");
    }
}

/* What only asks whether there are several turns takes powers of two. */
static uint32_t power_of_turns(uint32_t turns)
{
    uint32_t power = 1;

    while (power < TURNS_DEFAULT && 2u * power <= turns) {
        power *= 2u;
    }
    return power;
}

/* Letters, digits, '-' and '_'. */
static void make_name(struct dg_cia406_file *self)
{
    const char *from = self->file.device.name;
    size_t n = 0;

    while (n + 1u < sizeof self->name && from[n] != '\0') {
        const char c = (char)(from[n] >= 'A' && from[n] <= 'Z' ? from[n] - 'A' + 'a' : from[n]);
        const bool good = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
        self->name[n++] = (char)(good ? c : '-');
    }
    if (n == 0) {
        self->name[n++] = 'e';
        self->name[n++] = 'd';
        self->name[n++] = 's';
    }
    self->name[n] = '\0';
}

static void make_resolution(struct dg_cia406_file *self)
{
    struct dg_text text = dg_text_in(self->resolution, sizeof self->resolution);

    dg_text_add_number(&text, self->steps);
    dg_text_add(&text, " steps, ");
    if (self->turns == 1) {
        dg_text_add(&text, "singleturn");
        return;
    }
    dg_text_add_number(&text, self->turns);
    dg_text_add(&text, " turns");
}

/* One of a built-in encoder keeps its figures. */
static int check_own(const struct dg_cia406_file *self, const struct dg_eds_setup *setup,
                     struct dg_eds_note *error)
{
    const bool own = self->file.base != &dg_cia406_any;
    const bool fits = self->steps == DG_CIA406_STEPS &&
                      self->turns == (self->file.base == &dg_cia406_singleturn ? 1u : 4096u);

    if (!own || fits) {
        return DG_OK;
    }
    if (error != NULL) {
        *error = (struct dg_eds_note){
            .line = dg_co_find_object(setup, 0x6501),
            .section = "6501",
            .key = "DefaultValue",
            .what = "not the figures of the encoder with this identity",
            .right = "65536 steps, and 4096 turns or one",
        };
    }
    return DG_ERR_ARGUMENT;
}

int dg_cia406_read(struct dg_cia406_file *self, const struct dg_eds_setup *setup,
                   struct dg_eds_note *error)
{
    static const struct dg_co_ground ground = {
        .choose = choose_base,
        .profile = PROFILE,
        .cells_at = sizeof(struct dg_cia406),
    };
    const int result = dg_co_read(&self->file, setup, &ground, error);

    if (result != DG_OK) {
        return result;
    }
    struct dg_co_device *device = &self->file.device;
    device->causes = dg_cia406_causes;
    device->cause_count = DG_CIA406_CAUSES;
    find_figures(self, setup);
    make_name(self);
    make_resolution(self);
    self->model = (struct dg_cia406_model){power_of_turns(self->turns), device, 0};
    self->device = (struct dg_device){
        .name = self->name,
        .wire = "CANopen (from an EDS file)",
        .resolution = self->resolution,
        .stack = &dg_cia406_stack,
        .model = &self->model,
        .more = self->file.more,
    };
    return check_own(self, setup, error);
}

_Static_assert(sizeof(struct dg_cia406_device) ==
                   offsetof(struct dg_cia406_device, encoder) + sizeof(struct dg_cia406),
               "cells lie behind the device");

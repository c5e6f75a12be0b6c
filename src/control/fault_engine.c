/* SPDX-License-Identifier: MIT */
/*
 * Faults at work: what is active, what it bends, when it is over.
 *
 *   index   0 .. rows that concern it - 1  a row of the instrument
 *           .. + checked regions - 1     a region of the encoder's EEPROM
 */
#include "control_private.h"
#include "drehgeber/quantity.h"
#include <stddef.h>

/* A generator of full period; its upper bits are the good ones (Numerical Recipes, ranqd1). */
#define RANDOM_FACTOR 1664525u
#define RANDOM_STEP 1013904223u

/* Whether this encoder can notice it. */
static bool concerns(const struct dg_fault_target *target, const struct dg_fault_row *row)
{
    if (row->kind != DG_FAULT_WORLD) {
        return true;
    }
    if (target->singleturn && dg_quantity_at(row->offset)->multiturn) {
        return false;
    }
    return target->layout != NULL || row->offset != offsetof(struct dg_world, eeprom_acknowledges);
}

/* Row `index` of a catalogue, or NULL: a region or nothing. */
static const struct dg_fault_row *find_fault(const struct dg_fault_target *target, size_t index)
{
    const struct dg_instrument *instrument = target->instrument;

    for (size_t i = 0; i < instrument->fault_count; i++) {
        if (concerns(target, &instrument->faults[i]) && index-- == 0) {
            return &instrument->faults[i];
        }
    }
    return NULL;
}

static size_t rows_of(const struct dg_fault_target *target)
{
    size_t n = 0;

    while (find_fault(target, n) != NULL) {
        n++;
    }
    return n;
}

/* Checked region `n`, or region_count. */
static uint8_t region_at(const struct dg_store_layout *layout, size_t n)
{
    uint8_t region = 0;

    while (region < layout->region_count &&
           (layout->regions[region].check != DG_STORE_CHECKED || n-- > 0)) {
        region++;
    }
    return region;
}

static bool region_entry(const struct dg_fault_target *target, size_t n, struct dg_fault_entry *out)
{
    if (target->layout == NULL) {
        return false;
    }
    const uint8_t region = region_at(target->layout, n);
    if (region == target->layout->region_count) {
        return false;
    }
    const struct dg_store_region *row = &target->layout->regions[region];
    const struct dg_damage_row *damage = dg_control_damage_of(target->instrument, row->name);
    *out = (struct dg_fault_entry){
        .kind = DG_FAULT_MEMORY,
        .region = region,
        .cause = "a bit of the EEPROM has changed by itself",
        .effect = damage->effect,
        .chapter = damage->chapter,
        .code = row->startup_code,
    };
    struct dg_text name = dg_text_in(out->name, sizeof out->name);
    dg_text_add(&name, "eeprom_");
    dg_text_add(&name, row->name);
    for (char *c = out->name; *c != '\0'; c++) {
        if (*c == '-') {
            *c = '_';
        }
    }
    return true;
}

bool dg_fault_entry(const struct dg_fault_target *target, size_t index, struct dg_fault_entry *out)
{
    const struct dg_fault_row *row = find_fault(target, index);

    if (row == NULL) {
        const size_t rows = rows_of(target);
        return index < DG_FAULTS_MAX && region_entry(target, index - rows, out);
    }
    *out = (struct dg_fault_entry){
        .kind = row->kind,
        .row = row,
        .cause = row->cause,
        .effect = row->effect,
        .chapter = row->chapter,
    };
    struct dg_text name = dg_text_in(out->name, sizeof out->name);
    dg_text_add(&name, row->name);
    return true;
}

int dg_fault_find(const struct dg_fault_target *target, const char *name)
{
    struct dg_fault_entry entry;

    for (size_t i = 0; dg_fault_entry(target, i, &entry); i++) {
        if (dg_control_same(entry.name, name)) {
            return (int)i;
        }
    }
    return DG_ERR_ARGUMENT;
}

/* Another active fault on the same quantity, or DG_FAULTS_MAX. */
static size_t rival(const struct dg_faults *self, const struct dg_fault_target *target,
                    size_t offset)
{
    for (size_t i = 0; i < DG_FAULTS_MAX; i++) {
        const struct dg_fault_row *row = self->fault[i].active ? find_fault(target, i) : NULL;
        if (row != NULL && row->kind == DG_FAULT_WORLD && row->offset == offset) {
            return i;
        }
    }
    return DG_FAULTS_MAX;
}

void dg_fault_override(struct dg_faults *self, const struct dg_fault_target *target, size_t offset)
{
    const size_t i = rival(self, target, offset);

    if (i < DG_FAULTS_MAX) {
        self->fault[i].active = false;
    }
}

void dg_control_put_behind(struct dg_faults *self, const struct dg_fault_target *target,
                           size_t offset, int64_t value)
{
    const size_t i = rival(self, target, offset);

    if (i < DG_FAULTS_MAX) {
        self->fault[i].healthy = value;
    } else {
        dg_quantity_set(dg_quantity_at(offset), target->world, value);
    }
}

static void apply_row(struct dg_faults *self, const struct dg_fault_target *target, size_t index,
                      const struct dg_fault_row *row)
{
    const size_t before = rival(self, target, row->offset);

    /* What the quantity was before the first of them is what it will be after the last. */
    if (before == DG_FAULTS_MAX) {
        self->fault[index].healthy = dg_quantity_get(dg_quantity_at(row->offset), target->world);
    } else {
        self->fault[index].healthy = self->fault[before].healthy;
        self->fault[before].active = false;
    }
    dg_quantity_set(dg_quantity_at(row->offset), target->world, row->value);
}

static void restore_row(struct dg_faults *self, const struct dg_fault_target *target, size_t index,
                        const struct dg_fault_row *row)
{
    if (dg_quantity_get(dg_quantity_at(row->offset), target->world) == row->value) {
        dg_quantity_set(dg_quantity_at(row->offset), target->world, self->fault[index].healthy);
    }
}

/* A state lasts; it does not happen to single frames. */
static bool is_state(const struct dg_fault_row *row)
{
    return row->wire == DG_WIRE_BREAK || row->wire == DG_WIRE_BUS_OFF ||
           row->wire == DG_WIRE_PASSIVE;
}

static bool limits_fit(const struct dg_fault_entry *entry, const struct dg_fault_limits *limits)
{
    const bool single = entry->kind == DG_FAULT_WIRE && !is_state(entry->row);

    return limits->probability_ppm <= CONTROL_PPM &&
           (single || (limits->count == 0 && limits->probability_ppm == CONTROL_PPM));
}

static int corrupt_memory(struct dg_faults *self, const struct dg_fault_target *target,
                          size_t index, uint8_t region)
{
    const uint32_t bits = 8u * target->layout->regions[region].size;
    /* A bit that is flipped already would only be flipped back. */
    const int result = dg_fault_clear(self, target, index);

    return result == DG_OK ? dg_control_damage(target, region, dg_fault_pick(self, bits),
                                               &self->fault[index].flip)
                           : result;
}

static int begin_fault(struct dg_faults *self, const struct dg_fault_target *target, size_t index,
                       const struct dg_fault_entry *entry)
{
    switch (entry->kind) {
    case DG_FAULT_WORLD:
        apply_row(self, target, index, entry->row);
        break;
    case DG_FAULT_MEMORY:
        return corrupt_memory(self, target, index, entry->region);
    case DG_FAULT_WIRE:
        self->wire |= 1u << entry->row->wire;
        self->slot[entry->row->wire] = (uint8_t)index;
        break;
    }
    return DG_OK;
}

int dg_fault_set(struct dg_faults *self, const struct dg_fault_target *target, size_t index,
                 dg_ns now, const struct dg_fault_limits *limits)
{
    struct dg_fault_entry entry;

    if (!dg_fault_entry(target, index, &entry) || !limits_fit(&entry, limits)) {
        return DG_ERR_ARGUMENT;
    }
    if (begin_fault(self, target, index, &entry) != DG_OK) {
        return DG_ERR_IO;
    }
    struct dg_fault *fault = &self->fault[index];
    fault->active = true;
    fault->left = limits->count;
    fault->probability_ppm = limits->probability_ppm;
    fault->until = dg_after(now, limits->duration);
    fault->happened = 0;
    return DG_OK;
}

int dg_fault_clear(struct dg_faults *self, const struct dg_fault_target *target, size_t index)
{
    struct dg_fault_entry entry;

    if (!dg_fault_entry(target, index, &entry)) {
        return DG_ERR_ARGUMENT;
    }
    struct dg_fault *fault = &self->fault[index];
    if (!fault->active) {
        return DG_OK;
    }
    switch (entry.kind) {
    case DG_FAULT_WORLD:
        restore_row(self, target, index, entry.row);
        break;
    case DG_FAULT_MEMORY:
        if (dg_control_mend(target, entry.region, &fault->flip) != DG_OK) {
            return DG_ERR_IO;
        }
        break;
    case DG_FAULT_WIRE:
        self->wire &= ~(1u << entry.row->wire);
        break;
    }
    fault->active = false;
    return DG_OK;
}

dg_ns dg_control_next_end(const struct dg_faults *self)
{
    dg_ns next = DG_NEVER;

    for (size_t i = 0; i < DG_FAULTS_MAX; i++) {
        if (self->fault[i].active) {
            next = dg_earliest(next, self->fault[i].until);
        }
    }
    return next;
}

dg_ns dg_fault_step(struct dg_faults *self, const struct dg_fault_target *target, dg_ns now)
{
    for (size_t i = 0; i < DG_FAULTS_MAX; i++) {
        struct dg_fault *fault = &self->fault[i];
        if (fault->active && fault->until <= now && dg_fault_clear(self, target, i) != DG_OK) {
            fault->until = DG_NEVER;
        }
    }
    return dg_control_next_end(self);
}

bool dg_fault_wire_active(const struct dg_faults *self, enum dg_wire_fault fault)
{
    return (self->wire >> fault & 1u) != 0;
}

enum dg_controller dg_fault_controller(const struct dg_faults *self, enum dg_controller own)
{
    if (dg_fault_wire_active(self, DG_WIRE_BUS_OFF)) {
        return DG_CONTROLLER_OFF;
    }
    return own == DG_CONTROLLER_ACTIVE && dg_fault_wire_active(self, DG_WIRE_PASSIVE)
               ? DG_CONTROLLER_PASSIVE
               : own;
}

bool dg_fault_wire_takes(struct dg_faults *self, enum dg_wire_fault fault)
{
    if (!dg_fault_wire_active(self, fault)) {
        return false;
    }
    struct dg_fault *active = &self->fault[self->slot[fault]];
    if (active->probability_ppm < CONTROL_PPM &&
        dg_fault_pick(self, CONTROL_PPM) >= active->probability_ppm) {
        return false;
    }
    active->happened++;
    if (active->left > 0 && --active->left == 0) {
        active->active = false;
        self->wire &= ~(1u << fault);
    }
    return true;
}

uint32_t dg_fault_pick(struct dg_faults *self, uint32_t n)
{
    self->random = self->random * RANDOM_FACTOR + RANDOM_STEP;
    return (uint32_t)((uint64_t)self->random * n >> 32);
}

int64_t dg_fault_wire_value(const struct dg_instrument *instrument, enum dg_wire_fault fault)
{
    const struct dg_fault_target target = {.instrument = instrument};
    const struct dg_fault_row *row;

    for (size_t i = 0; (row = find_fault(&target, i)) != NULL; i++) {
        if (row->kind == DG_FAULT_WIRE && row->wire == fault) {
            return row->value;
        }
    }
    return 0;
}

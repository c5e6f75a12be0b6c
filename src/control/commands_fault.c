/* SPDX-License-Identifier: MIT */
/*
 * FAULt and NVM: what is wrong with the selected encoder, and its EEPROM.
 */
#include "control_private.h"

static const struct dg_scpi_range counts = {DG_SCPI_PLAIN, 0, 1, UINT32_MAX};
static const struct dg_scpi_range probabilities = {DG_SCPI_PLAIN, CONTROL_PPM_PLACES, 0,
                                                   CONTROL_PPM};
static const struct dg_scpi_range durations = {DG_SCPI_DURATION, 0, 1, INT64_MAX};

static const struct dg_fault_limits unlimited = {.probability_ppm = CONTROL_PPM,
                                                 .duration = DG_NEVER};

static struct dg_fault_target target_of(const struct dg_scpi *self)
{
    return dg_encoder_target(dg_control_selected(self));
}

void dg_control_catalogue(struct dg_scpi *self)
{
    static const char *const kinds[] = {
        [DG_FAULT_WORLD] = "WORLD",
        [DG_FAULT_MEMORY] = "MEMORY",
        [DG_FAULT_WIRE] = "WIRE",
    };
    _Static_assert(DG_COUNT(kinds) == DG_FAULT_WIRE + 1, "a word for each kind");
    const struct dg_fault_target target = target_of(self);
    struct dg_fault_entry entry;

    for (size_t i = 0; dg_fault_entry(&target, i, &entry); i++) {
        dg_scpi_put_string(self, entry.name);
        dg_scpi_put_word(self, kinds[entry.kind]);
        dg_scpi_put_string(self, entry.cause);
        dg_scpi_put_string(self, entry.effect);
        dg_scpi_put_string(self, entry.chapter);
    }
}

/* Take the name of a catalogue entry. @return its index, or -1: an error was raised */
static int take_fault(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);
    char name[CONTROL_NAME_MAX];
    char detail[CONTROL_DETAIL_SIZE];

    if (!dg_control_name(self, name)) {
        return -1;
    }
    const int index = dg_fault_find(&target, name);
    if (index >= 0) {
        return index;
    }
    struct dg_text to = dg_text_in(detail, sizeof detail);
    dg_text_add(&to, name);
    dg_text_add(&to, ": no such fault; FAUL:CAT? has their names");
    dg_scpi_raise(self, DG_SCPI_ILLEGAL, detail);
    return -1;
}

/* One "KEYWORD value". */
static bool take_limit(struct dg_scpi *self, struct dg_fault_limits *limits)
{
    static const char *const words[] = {"COUNt", "PROBability", "DURation"};
    static const struct dg_scpi_range *const ranges[] = {&counts, &probabilities, &durations};
    enum { COUNT, PROBABILITY };
    size_t word;
    int64_t value;

    if (!dg_scpi_word(self, words, DG_COUNT(words), &word) ||
        !dg_scpi_number(self, ranges[word], &value)) {
        return false;
    }
    if (word == COUNT) {
        limits->count = (uint32_t)value;
    } else if (word == PROBABILITY) {
        limits->probability_ppm = (uint32_t)value;
    } else {
        limits->duration = (dg_ns)value;
    }
    return true;
}

/* What the faults answered. */
static void done(struct dg_scpi *self, int result)
{
    if (result == DG_ERR_IO) {
        dg_control_refuse(self, DG_SCPI_STORAGE, "the memory did not answer");
    } else if (result != DG_OK) {
        dg_scpi_raise(self, DG_SCPI_CONFLICT,
                      "COUNt and PROBability are for what happens to single frames");
    }
    dg_control_changed(self);
}

void dg_control_fault(struct dg_scpi *self)
{
    struct dg_fault_limits limits = unlimited;
    const struct dg_fault_target target = target_of(self);
    const int index = take_fault(self);

    if (index < 0) {
        return;
    }
    while (dg_scpi_more(self)) {
        if (!take_limit(self, &limits)) {
            return;
        }
    }
    done(self, dg_fault_set(&dg_control_selected(self)->faults, &target, (size_t)index, self->now,
                            &limits));
}

static int clear_all(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);
    struct dg_faults *faults = &dg_control_selected(self)->faults;
    int result = DG_OK;

    for (size_t i = 0; i < DG_FAULTS_MAX; i++) {
        if (faults->fault[i].active && dg_fault_clear(faults, &target, i) == DG_ERR_IO) {
            result = DG_ERR_IO;
        }
    }
    return result;
}

void dg_control_clear_all(struct dg_scpi *self)
{
    done(self, clear_all(self));
}

void dg_control_clear(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);

    if (!dg_scpi_more(self)) {
        dg_control_clear_all(self);
        return;
    }
    const int index = take_fault(self);
    if (index >= 0) {
        done(self, dg_fault_clear(&dg_control_selected(self)->faults, &target, (size_t)index));
    }
}

void dg_control_active(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);
    const struct dg_faults *faults = &dg_control_selected(self)->faults;
    struct dg_fault_entry entry;
    size_t count = 0;

    for (size_t i = 0; dg_fault_entry(&target, i, &entry); i++) {
        /* The rig may have stepped a moment before this line was read. */
        if (faults->fault[i].active && faults->fault[i].until > self->now) {
            dg_scpi_put_string(self, entry.name);
            count++;
        }
    }
    dg_control_put_none(self, count);
}

void dg_control_happened(struct dg_scpi *self)
{
    const int index = take_fault(self);

    if (index >= 0) {
        dg_scpi_put_unsigned(self, dg_control_selected(self)->faults.fault[index].happened);
    }
}

void dg_control_regions(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);
    uint8_t count = 0;

    for (; target.layout != NULL && count < target.layout->region_count; count++) {
        dg_scpi_put_string(self, target.layout->regions[count].name);
    }
    dg_control_put_none(self, count);
}

/* Take the name of a region. @return false: an error was raised */
static bool take_region(struct dg_scpi *self, const struct dg_store_layout *layout, uint8_t *region)
{
    char name[CONTROL_NAME_MAX];
    char detail[CONTROL_DETAIL_SIZE];

    if (!dg_control_name(self, name)) {
        return false;
    }
    for (*region = 0; *region < layout->region_count; (*region)++) {
        if (dg_control_same(layout->regions[*region].name, name)) {
            return true;
        }
    }
    struct dg_text to = dg_text_in(detail, sizeof detail);
    dg_text_add(&to, name);
    dg_text_add(&to, ": no such region; NVM:CAT? has their names");
    dg_scpi_raise(self, DG_SCPI_ILLEGAL, detail);
    return false;
}

static bool has_fault_memory(struct dg_scpi *self, const struct dg_fault_target *target)
{
    if (target->layout == NULL) {
        dg_control_refuse(self, DG_SCPI_MISSING_HARDWARE, "it has no EEPROM");
    }
    return target->layout != NULL;
}

/* Which part of it; all of it without parameters. @return false: an error was raised */
static bool take_part(struct dg_scpi *self, uint32_t size, int64_t *at, int64_t *count)
{
    struct dg_scpi_range range = {DG_SCPI_PLAIN, 0, 0, (int64_t)size - 1};

    *at = 0;
    if (dg_scpi_more(self) && !dg_scpi_number(self, &range, at)) {
        return false;
    }
    range.min = 1;
    range.max = (int64_t)size - *at;
    *count = range.max;
    return !dg_scpi_more(self) || dg_scpi_number(self, &range, count);
}

static bool answers(const struct dg_nvm *nvm, int64_t at, int64_t count)
{
    uint8_t byte;

    while (count > 0 && nvm->ops->read(nvm->ctx, (uint32_t)at, &byte, 1) == DG_OK) {
        count--;
        at++;
    }
    return count == 0;
}

/* What the memory has, whether the device can reach it or not. It is read once before, as half an
   answer is none. */
void dg_control_data(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);
    int64_t at;
    int64_t count;

    if (!has_fault_memory(self, &target) ||
        !take_part(self, dg_store_size(target.layout), &at, &count)) {
        return;
    }
    if (!answers(&target.nvm, at, count)) {
        done(self, DG_ERR_IO);
        return;
    }
    dg_scpi_begin(self);
    dg_scpi_append(self, "\"");
    for (; count > 0; count--, at++) {
        uint8_t byte = 0;
        (void)target.nvm.ops->read(target.nvm.ctx, (uint32_t)at, &byte, 1);
        dg_scpi_append_hex(self, byte, 2);
    }
    dg_scpi_append(self, "\"");
}

/* The catalogue entry of a checked region, or -1. */
static int entry_of(const struct dg_fault_target *target, uint8_t region)
{
    struct dg_fault_entry entry;

    for (size_t i = 0; dg_fault_entry(target, i, &entry); i++) {
        if (entry.kind == DG_FAULT_MEMORY && entry.region == region) {
            return (int)i;
        }
    }
    return -1;
}

/* What is checked is a fault like others; the rest is damaged for good. */
static int corrupt_region(struct dg_scpi *self, uint8_t region)
{
    const struct dg_fault_target target = target_of(self);
    struct dg_faults *faults = &dg_control_selected(self)->faults;
    const int index = entry_of(&target, region);

    if (index < 0) {
        const uint32_t bits = 8u * target.layout->regions[region].size;
        return dg_control_flip(&target, region, dg_fault_pick(faults, bits));
    }
    return dg_fault_set(faults, &target, (size_t)index, self->now, &unlimited);
}

void dg_control_corrupt(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);
    uint8_t region;

    if (has_fault_memory(self, &target) && take_region(self, target.layout, &region)) {
        done(self, corrupt_region(self, region));
    }
}

/* What was damaged has been written since. */
static void forget_damage(struct dg_faults *faults, const struct dg_fault_target *target)
{
    struct dg_fault_entry entry;

    for (size_t i = 0; dg_fault_entry(target, i, &entry); i++) {
        if (entry.kind == DG_FAULT_MEMORY) {
            faults->fault[i].active = false;
        }
    }
}

void dg_control_erase(struct dg_scpi *self)
{
    const struct dg_fault_target target = target_of(self);
    struct dg_encoder *encoder = dg_control_selected(self);

    if (!has_fault_memory(self, &target)) {
        return;
    }
    if (dg_encoder_powered(encoder)) {
        dg_control_refuse(self, DG_SCPI_CONFLICT, "its power is on; POWer OFF first");
        return;
    }
    const bool formatted = dg_encoder_format(encoder) == DG_OK;
    if (formatted) {
        forget_damage(&encoder->faults, &target);
    }
    done(self, formatted ? DG_OK : DG_ERR_IO);
}

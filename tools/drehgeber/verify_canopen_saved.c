/* SPDX-License-Identifier: MIT */
/*
 * What a CANopen encoder has saved, for rows that write 1010h, 1011h or the preset:
 *
 *   note what is in force, cut the supply, note what was saved -> journal -> 1011h -> the row -> put back
 *
 * To put it back, the supply is cut: what is in force then is what is saved. If that has changed, 1011h is
 * tried, which is enough when nothing but what was delivered had been saved; then every object is written,
 * and saved by 1010h. Each time the supply is cut again, and every object is read.
 *
 * The offset of a preset, and the zero of USF, cannot be written: both follow from where the shaft was. An
 * encoder that has one of them, or bus parameters of its own, is not asked to run such a row. What a row
 * presets goes with the supply, or is saved and goes by 1011h.
 */
#include <string.h>

#include "drehgeber/bits.h"
#include "verify_canopen.h"

/* Signatures, "save" and "load". */
#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu
#define STORE 0x1010u
#define RESTORE 0x1011u
#define PRESET 0x6003u
#define CONSUMER 0x1016u
#define CONSUMERS 2u

bool verify_canopen_needs_saved(uint16_t index)
{
    return index == STORE || index == RESTORE || index == PRESET;
}

/* Why an encoder that has something else there is not asked to. */
static const char bus[] = "has its own bus parameters, and 1011h could lose them";
static const char preset[] = "has a preset, and 1011h would lose it";
static const char usf[] = "has USF on, and 1011h would lose its zero";

/* What cannot be written back, and how it has to be: as delivered. */
static const struct {
    uint16_t index;
    uint32_t mask;
    uint32_t value;
    const char *text;
} fixed[] = {
    /* clang-format off */
    {0x2100, 0xFFFFFFFF, 5,        bus},    {0x2101, 0xFFFFFFFF, ROW_NODE, bus},
    {0x2102, 0xFFFFFFFF, 1,        bus},    {PRESET, 0xFFFFFFFF, 0,        preset},
    {0x6509, 0xFFFFFFFF, 0,        preset}, {0x6000, 0x00001000, 0,        usf},
    /* clang-format on */
};

/* What 1010h saves (chapters 12 and 19), without TPDOs, in the order in which it can be written: 6000h, which
   switches the scaling on, comes behind its figures. 1014h cannot be written in every encoder, and 6200h is
   another name for a part of TPDO 1. */
static const struct {
    uint16_t index;
    uint8_t first, last;
} parameters[] = {
    /* clang-format off */
    {0x1005, 0, 0}, {0x1006, 0, 0}, {0x1007, 0, 0}, {0x100C, 0, 0}, {0x100D, 0, 0}, {0x1012, 0, 0},
    {0x1014, 0, 0}, {0x1015, 0, 0}, {0x1016, 1, 2}, {0x1017, 0, 0}, {0x1029, 1, 3}, {0x2120, 2, 3},
    {0x2140, 1, 4}, {0x6001, 0, 0}, {0x6002, 0, 0}, {0x6000, 0, 0}, {0x6031, 1, 4}, {0x6200, 0, 0},
    {0x6401, 1, 2}, {0x6402, 1, 2},
    /* clang-format on */
};

/* --- what is noted --- */

/* Whether the row may store; if not, `refusal` says why. */
static bool can_store(struct canopen *self)
{
    for (size_t i = 0; i < DG_COUNT(fixed); i++) {
        uint32_t value = 0;
        if (verify_canopen_upload(self, fixed[i].index, 0, &value) == 0) {
            (void)snprintf(self->refusal, sizeof self->refusal, "%04Xh cannot be read",
                           fixed[i].index);
            return false;
        }
        if ((value & fixed[i].mask) != fixed[i].value) {
            (void)snprintf(self->refusal, sizeof self->refusal, "the encoder %s (%04Xh)",
                           fixed[i].text, fixed[i].index);
            return false;
        }
    }
    return true;
}

/* A node that is watched can be replaced only by way of 0, and none may be there twice. */
static bool note_consumers(struct canopen *self, enum note_of of)
{
    bool noted = true;
    uint32_t value;
    for (uint8_t sub = 1; noted && sub <= CONSUMERS; sub++) {
        const struct object object = {CONSUMER, sub};
        noted = verify_canopen_upload(self, CONSUMER, sub, &value) == 0 ||
                verify_canopen_note_download(self, of, &object, 0, 4);
    }
    return noted;
}

/* @return false: the journal has no room */
static bool note_parameters(struct canopen *self, enum note_of of)
{
    bool noted = note_consumers(self, of);
    self->unread = (struct object){0};
    for (unsigned pdo = 0; noted && pdo < TPDOS; pdo++) {
        noted = verify_canopen_note_tpdo(self, of, pdo);
    }
    for (size_t i = 0; i < DG_COUNT(parameters); i++) {
        for (uint8_t sub = parameters[i].first; noted && sub <= parameters[i].last; sub++) {
            noted = verify_canopen_note_object(self, of, parameters[i].index, sub);
        }
    }
    if (self->unread.index != 0) {
        (void)snprintf(self->refusal, sizeof self->refusal, "%04Xh:%u cannot be read",
                       self->unread.index, self->unread.sub);
    }
    return noted;
}

static bool note_fixed(struct canopen *self)
{
    bool noted = true;
    for (size_t i = 0; noted && i < DG_COUNT(fixed); i++) {
        noted = verify_canopen_note_object(self, NOTE_FIXED, fixed[i].index, 0);
    }
    return noted;
}

static bool cut_supply(struct canopen *self, struct cf_report *report)
{
    return verify_powered(&self->base, false, report) &&
           verify_powered(&self->base, true, report) && verify_canopen_settle(self, report);
}

static bool fail_journal(struct canopen *self, struct cf_report *report)
{
    return verify_fail(&self->base, VERIFY_LOST, report, "the journal cannot be written");
}

/* What is in force is in the journal before the supply is cut. False: as `report` says */
static bool learn_saved(struct canopen *self, struct cf_report *report)
{
    const struct verify_journal *journal = self->base.journal;
    if (!verify_journal_sync(self->base.journal)) {
        return fail_journal(self, report);
    }
    if (!cut_supply(self, report)) {
        return false;
    }
    const size_t first = journal->count;
    if (!can_store(self)) {
        return true;
    }
    if (!note_parameters(self, NOTE_SAVED) || !note_fixed(self) ||
        journal->count - first > KEPT_MAX) {
        return fail_journal(self, report);
    }
    if (self->refusal[0] == '\0') {
        self->kept_count = journal->count - first;
        memcpy(self->kept, journal->notes + first, self->kept_count * sizeof self->kept[0]);
    }
    return true;
}

static bool note_kept(struct canopen *self)
{
    bool noted = true;
    for (size_t i = 0; noted && i < self->kept_count; i++) {
        const struct cf_unit unit = verify_note_unit(&self->kept[i]);
        noted = verify_journal_add(self->base.journal, true, &unit);
    }
    return noted;
}

/* Whether the supply can be cut for what is saved, and all of that be put back; if not, `refusal` says why. */
static bool can_put_back(struct canopen *self)
{
    if (self->base.power == NULL) {
        (void)snprintf(self->refusal, sizeof self->refusal,
                       "needs a program that cuts the supply (--power COMMAND)");
        return false;
    }
    return can_store(self);
}

bool verify_canopen_note_saved(struct canopen *self, struct cf_report *report)
{
    const bool stores = self->stores && !self->one_way;
    self->refusal[0] = '\0';
    if (!stores && !self->base.cuts) {
        return true;
    }
    if (stores && !can_put_back(self)) {
        return true;
    }
    if (!note_parameters(self, NOTE_CUT)) {
        return fail_journal(self, report);
    }
    if (!stores) {
        self->refusal[0] = '\0'; /* it does not store: what cannot be read is no matter */
        return true;
    }
    if (self->refusal[0] != '\0') {
        return true;
    }
    if (self->kept_count == 0) {
        return learn_saved(self, report);
    }
    return note_kept(self) || fail_journal(self, report);
}

/* --- how it is put back --- */

bool verify_canopen_has_saved(const struct canopen *self)
{
    const struct verify_journal *journal = self->base.journal;
    bool found = false;
    for (size_t i = 0; i < journal->count; i++) {
        found = found || journal->notes[i].id >= NOTE_SAVED;
    }
    return found;
}

/* Write "save" or "load". @return whether that was confirmed */
static bool write_signature(struct canopen *self, uint16_t index, uint32_t signature)
{
    uint8_t bytes[8] = {0x23, (uint8_t)index, (uint8_t)(index >> 8), 1};
    const struct cf_unit unit = {.bytes = bytes, .n = sizeof bytes};
    for (size_t i = 0; i < 4; i++) {
        bytes[4u + i] = (uint8_t)(signature >> 8u * i);
    }
    return verify_canopen_download(self, &unit);
}

/* Rows are about an encoder as delivered. One that has saved nothing else need not be asked again. */
bool verify_canopen_deliver(struct canopen *self, struct cf_report *report)
{
    if (!verify_canopen_has_saved(self) || self->refusal[0] != '\0') {
        return true;
    }
    if (!self->delivered) {
        self->restored = write_signature(self, RESTORE, LOAD);
        if (!cut_supply(self, report)) {
            return false;
        }
        self->delivered =
            self->restored &&
            verify_canopen_find_changed(self, NOTE_SAVED, NOTE_FIXED) == self->base.journal->count;
    }
    self->restored = self->restored || self->delivered;
    return true;
}

static void load_delivered(struct canopen *self)
{
    (void)write_signature(self, RESTORE, LOAD);
}

static void save_parameters(struct canopen *self)
{
    verify_canopen_write_notes(self, NOTE_SAVED);
    (void)write_signature(self, STORE, SAVE);
}

static void change_nothing(struct canopen *self)
{
    (void)self;
}

bool verify_canopen_save_again(struct canopen *self, struct cf_report *report)
{
    static void (*const steps[])(struct canopen *) = {change_nothing, load_delivered,
                                                      save_parameters};
    const struct verify_journal *journal = self->base.journal;
    size_t at = 0;
    if (self->base.power == NULL) {
        return verify_fail(&self->base, VERIFY_LOST, report,
                           "saved parameters need --power COMMAND");
    }
    for (size_t i = 0; i < DG_COUNT(steps); i++) {
        steps[i](self);
        if (!cut_supply(self, report)) {
            return false;
        }
        at = verify_canopen_find_changed(self, NOTE_SAVED, NOTE_FIXED);
        if (at == journal->count) {
            return true;
        }
    }
    const uint8_t *bytes = journal->notes[at].bytes;
    return verify_fail(&self->base, VERIFY_LOST, report, "%02X%02Xh:%u, saved", bytes[2], bytes[1],
                       (unsigned)bytes[3]);
}

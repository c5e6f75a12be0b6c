/* SPDX-License-Identifier: MIT */
/*
 * An encoder with BiSS is put back: the journal has what registers were, and which commands were sent.
 * The identifier of a note is BANK * 256 + ADDRESS; what is written is only what is another one, as
 * it goes to an EEPROM.
 */
#include <string.h>

#include "timer.h"
#include "verify_biss.h"
#include "verify_stream.h"

static bool select_register_bank(struct biss *self, uint8_t bank)
{
    return verify_biss_write(self, BANK_SELECT, &bank, 1);
}

static bool note_register_values(struct biss *self, uint8_t bank, uint8_t address, size_t n)
{
    uint8_t bytes[DG_BISS_BANK_SIZE];
    const struct cf_unit unit = {.id = (uint16_t)(bank << 8 | address), .bytes = bytes, .n = n};
    return (address >= BANK_SELECT || select_register_bank(self, bank)) &&
           verify_biss_read(self, address, bytes, n) &&
           verify_journal_add(self->base.journal, true, &unit);
}

/* Before anything else is selected the bank that was is on the disk. */
bool verify_biss_note(struct biss *self)
{
    bool noted =
        note_register_values(self, 0, BANK_SELECT, 1) && verify_journal_sync(self->base.journal);
    for (uint8_t bank = DG_BISS_BANK_USER_FIRST; noted && bank <= DG_BISS_BANK_USER_LAST; bank++) {
        noted = (self->banks >> bank & 1u) == 0 ||
                note_register_values(self, bank, 0, DG_BISS_BANK_SIZE);
    }
    return noted && note_register_values(self, 0, CONFIG_FIRST, CONFIG_SIZE) &&
           note_register_values(self, 0, TIMEOUT_SELECT, 1);
}

/* @return whether command `code` was sent, or with NOTE_COMMAND any */
static bool was_command_sent(const struct verify_journal *journal, uint16_t id, uint8_t code)
{
    for (size_t i = 0; i < journal->count; i++) {
        const struct verify_note *note = &journal->notes[i];
        if (!note->before && note->id == id && (id == NOTE_COMMAND || note->bytes[0] == code)) {
            return true;
        }
    }
    return false;
}

/* Communication is on for all, and data for the only encoder. */
static void undo_commands(struct biss *self)
{
    struct biss_command all = {.code = 1, .execute = true};
    struct biss_command one = {.ids = 1, .code = 0, .execute = true};
    self->master.now = lx_real_now();
    biss_master_command(&self->master, &all);
    biss_master_command(&self->master, &one);
}

/* What differs is written, run for run. @return whether it reads as it was */
static bool put_note_back(struct biss *self, const struct verify_note *note)
{
    const uint8_t bank = (uint8_t)(note->id >> 8);
    const uint8_t address = (uint8_t)note->id;
    uint8_t now[DG_BISS_BANK_SIZE];
    if (note->n > sizeof now || (address < BANK_SELECT && !select_register_bank(self, bank)) ||
        !verify_biss_read(self, address, now, note->n)) {
        return false;
    }
    for (size_t i = 0; i < note->n; i++) {
        size_t n = 0;
        while (i + n < note->n && now[i + n] != note->bytes[i + n]) {
            n++;
        }
        if (n > 0 && !verify_biss_write(self, (uint8_t)(address + i), note->bytes + i, n)) {
            return false;
        }
        i += n;
    }
    return verify_biss_read(self, address, now, note->n) && memcmp(now, note->bytes, note->n) == 0;
}

/* What was stored is stored again, as it was. */
static bool store_again(struct biss *self)
{
    const uint8_t store = STORE;
    const bool stored = verify_biss_write(self, COMMAND, &store, 1);
    verify_stream_sleep(lx_real_now() + 2u * EEPROM_MAX);
    return stored;
}

bool verify_biss_put_back(struct verify_encoder *base, struct cf_report *report)
{
    struct biss *self = of(base);
    const struct verify_journal *journal = base->journal;
    const uint8_t clear = CLEAR;
    if (was_command_sent(journal, NOTE_COMMAND, 0)) {
        undo_commands(self);
    }
    if (!verify_biss_frame(self) || !verify_biss_write(self, COMMAND, &clear, 1)) {
        return verify_fail(base, VERIFY_LOST, report, "it does not answer");
    }
    /* The bank that was selected is noted first, and selected last. */
    for (size_t i = journal->count; i > 0; i--) {
        const struct verify_note *note = &journal->notes[i - 1u];
        if (note->before && !put_note_back(self, note)) {
            return verify_fail(base, VERIFY_LOST, report, "bank %u, register %02Xh",
                               (unsigned)note->id >> 8, (unsigned)note->id & 0xFFu);
        }
        const bool config = note->before && note->id == CONFIG_FIRST;
        if (config && was_command_sent(journal, COMMAND, STORE) && !store_again(self)) {
            return verify_fail(base, VERIFY_LOST, report, "the stored bank 0");
        }
    }
    const bool known = self->trial.placed && self->delivered && verify_biss_frame(self);
    return !known ||
           verify_biss_is_near(self, self->frames.last.words[0].position,
                               (uint64_t)self->trial.raw) ||
           verify_fail(base, VERIFY_LOST, report, "the position");
}

/* SPDX-License-Identifier: MIT */
/* An encoder with INTERBUS is put back: the journal has the words that do it, in their order. */
#include "drehgeber/bits.h"
#include "verify_interbus.h"

#define DEFAULTS 0x0E000000u
#define SHIFT_IW 0x20100000u

/* Words with a value, and the words that read it: 9.1, 9.2, 9.5. */
static const struct {
    uint32_t write;
    uint32_t read;
} values[] = {
    {0x02000000u, READ_ITEM | ITEM_STEPS},
    {0x04000000u, READ_ITEM | ITEM_REVOLUTIONS},
    {0x06000000u, READ_ITEM | ITEM_DIRECTION},
    {0x0A000000u, READ_ITEM | ITEM_SHIFT},
    {SHIFT_IW, READ_SHIFT_IW},
};

static bool note_word(struct interbus *self, uint32_t word)
{
    uint8_t bytes[4];
    const struct cf_unit unit = {.bytes = bytes, .n = sizeof bytes};
    dg_store_be32(bytes, word);
    return verify_journal_add(self->base.journal, true, &unit);
}

/* The word of a mode (9.2, item 9): position, speed, or a cam program. */
static uint32_t word_of_mode(uint32_t mode)
{
    return mode <= DG_IB_SPEED ? POSITION_MODE | (mode == DG_IB_SPEED ? 1u : 0u)
                               : PROGRAM | (mode - DG_IB_CAM);
}

bool verify_interbus_note(struct interbus *self)
{
    uint32_t value = 0;
    bool noted = note_word(self, PROGRAM); /* out of whatever mode */
    for (size_t i = 0; noted && i < DG_COUNT(values); i++) {
        noted = verify_interbus_read(self, values[i].read, &value) &&
                note_word(self, values[i].write | value);
    }
    return noted && verify_interbus_read(self, READ_ITEM | ITEM_MODE, &value) &&
           note_word(self, word_of_mode(value));
}

static bool is_confirmed(uint32_t out, uint32_t in)
{
    return in == (out | 0xC0000000u);
}

/* Whether the encoder reads what the word has written. */
static bool is_back(struct interbus *self, uint32_t word)
{
    uint32_t value = 0;
    for (size_t i = 0; i < DG_COUNT(values); i++) {
        const uint32_t mask = values[i].write == SHIFT_IW ? 0xFFFFFF00u : STATUS;
        if ((word & mask) == values[i].write) {
            return verify_interbus_read(self, values[i].read, &value) && value == (word & ~mask);
        }
    }
    return true;
}

bool verify_interbus_put_back(struct verify_encoder *base, struct cf_report *report)
{
    struct interbus *self = of(base);
    const struct verify_journal *journal = base->journal;
    uint32_t in = 0;
    if (!verify_interbus_settle(self, report)) {
        return false;
    }
    if ((self->writes & CF_ONE_WAY) != 0) {
        (void)verify_interbus_exchange(self, DEFAULTS, is_confirmed, &in); /* no preset any more */
    }
    for (size_t i = 0; i < journal->count; i++) {
        const uint32_t word = dg_load_be32(journal->notes[i].bytes);
        if (!verify_interbus_exchange(self, word, is_confirmed, &in)) {
            return verify_fail(base, VERIFY_LOST, report, "%08lX was answered %08lX",
                               (unsigned long)word, (unsigned long)in);
        }
    }
    if (!verify_interbus_settle(self, report)) {
        return false;
    }
    for (size_t i = 0; i < journal->count; i++) {
        const uint32_t word = dg_load_be32(journal->notes[i].bytes);
        if (!is_back(self, word)) {
            return verify_fail(base, VERIFY_LOST, report, "%08lX", (unsigned long)word);
        }
    }
    const bool known = self->trial.placed && self->delivered && verify_coupler_in(&self->wire, &in);
    return !known || verify_interbus_is_near(self, in, (uint32_t)self->trial.raw) ||
           verify_fail(base, VERIFY_LOST, report, "the position");
}

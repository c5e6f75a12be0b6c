/* SPDX-License-Identifier: MIT */
/* An encoder with RS485 is put back: what it was and what was sent to it is in the journal. */
#include <string.h>

#include "timer.h"
#include "verify_hiperface.h"
#include "verify_stream.h"

bool verify_hiperface_find(struct hiperface *self, struct cf_report *report)
{
    const struct verify_journal *journal = self->base.journal;
    struct frame came;
    for (size_t i = journal == NULL ? 0 : journal->count; i > 0; i--) {
        const struct verify_note *note = &journal->notes[i - 1u];
        const bool moved = !note->before && note->n >= 5 && note->bytes[1] == 0x55u;
        if (moved && !verify_hiperface_ask_again(self, 0x42, 7, &came, report)) {
            const uint8_t back[] = {note->bytes[2], 0x55, ADDRESS, note->bytes[3]};
            (void)verify_hiperface_command(self, back, sizeof back, &came);
        }
    }
    return verify_hiperface_ask_again(self, 0x42, 7, &came, report);
}

/* Change every code that one may have now to the one as delivered. @return whether it is that */
static bool put_code_back(struct hiperface *self, uint8_t which)
{
    const struct verify_journal *journal = self->base.journal;
    const uint8_t same[] = {ADDRESS, 0x4F, which, CODE, CODE};
    struct frame came;
    for (size_t i = 0; i < journal->count; i++) {
        const struct verify_note *note = &journal->notes[i];
        const bool changed =
            !note->before && note->n >= 6 && note->bytes[1] == 0x4Fu && note->bytes[2] == which;
        if (changed && note->bytes[4] != CODE) {
            const uint8_t back[] = {ADDRESS, 0x4F, which, note->bytes[4], CODE};
            (void)verify_hiperface_command(self, back, sizeof back, &came);
        }
    }
    return verify_hiperface_command(self, same, sizeof same, &came);
}

static bool put_codes_back(struct hiperface *self)
{
    bool back = true;
    for (uint8_t which = 0; back && which < 4; which++) {
        back = put_code_back(self, which);
    }
    return back;
}

/* There were none: the last one is erased first. @return whether there is none again */
static bool erase_fields(struct hiperface *self)
{
    static const uint8_t first[] = {ADDRESS, 0x4C, 0x00};
    struct frame came;
    for (int field = 7; field >= 0; field--) {
        const uint8_t status[] = {ADDRESS, 0x4C, (uint8_t)field};
        if (verify_hiperface_command(self, status, sizeof status, &came) && came.n == 5) {
            const uint8_t erase[] = {ADDRESS, 0x4D, (uint8_t)field,
                                     (uint8_t)(came.bytes[3] & 0x7Fu), CODE};
            (void)verify_hiperface_command(self, erase, sizeof erase, &came);
        }
    }
    return !verify_hiperface_command(self, first, sizeof first, &came) && came.n == 4;
}

/* @return whether it is there again, as 46h says */
static bool put_counter_back(struct hiperface *self, const uint8_t *was)
{
    static const uint8_t erase[] = {ADDRESS, 0x49, CODE};
    static const uint8_t count[] = {ADDRESS, 0x47};
    static const uint8_t read[] = {ADDRESS, 0x46};
    struct frame came;
    if (was[0] != 0 || was[1] != 0 || was[2] > COUNTS_MAX) {
        return false;
    }
    (void)verify_hiperface_command(self, erase, sizeof erase, &came);
    for (unsigned i = 0; i < was[2]; i++) {
        (void)verify_hiperface_command(self, count, sizeof count, &came);
    }
    return verify_hiperface_command(self, read, sizeof read, &came) && came.n == 6 &&
           memcmp(came.bytes + 2, was, 3) == 0;
}

static bool put_position_back(struct hiperface *self, const uint8_t *was)
{
    const uint8_t set[] = {ADDRESS, 0x43, was[0], was[1], was[2], was[3], CODE};
    static const uint8_t read[] = {ADDRESS, 0x42};
    struct frame came;
    (void)verify_hiperface_command(self, set, sizeof set, &came);
    return verify_hiperface_command(self, read, sizeof read, &came) && came.n == 7 &&
           verify_hiperface_is_near(self, be32(came.bytes + 2), be32(was));
}

static bool put_setting_back(struct hiperface *self, const uint8_t *was)
{
    const uint8_t set[] = {ADDRESS, 0x57, was[0], CODE};
    static const uint8_t read[] = {ADDRESS, 0x52};
    struct frame came;
    (void)verify_hiperface_command(self, set, sizeof set, &came);
    return verify_hiperface_command(self, read, sizeof read, &came) && came.n == 7 &&
           came.bytes[2] == was[0];
}

static bool was_sent(const struct verify_journal *journal, uint8_t command)
{
    for (size_t i = 0; i < journal->count; i++) {
        if (!journal->notes[i].before && journal->notes[i].n > 1 &&
            journal->notes[i].bytes[1] == command) {
            return true;
        }
    }
    return false;
}

/* Only what was changed is put back. What is before has code 0, and so it is done first. */
bool verify_hiperface_put_back(struct verify_encoder *base, struct cf_report *report)
{
    static const struct {
        uint8_t read;
        uint8_t writes[2];
        bool (*put_back)(struct hiperface *self, const uint8_t *was);
        const char *what;
    } rows[] = {
        {0x52, {0x57, 0x57}, put_setting_back, "the setting of the line"},
        {0x46, {0x47, 0x49}, put_counter_back, "the counter"},
        {0x42, {0x43, 0x6A}, put_position_back, "the position"},
    };
    struct hiperface *self = of(base);
    const struct verify_journal *journal = base->journal;
    verify_stream_wait(&self->wire, lx_now() + (was_sent(journal, 0x53) ? REPLY_MAX : 0));
    if (!verify_hiperface_find(self, report)) {
        return verify_fail(base, VERIFY_LOST, report, "the address");
    }
    if (was_sent(journal, 0x4F) && !put_codes_back(self)) {
        return verify_fail(base, VERIFY_LOST, report, "the access codes");
    }
    if (was_sent(journal, 0x4D) && !erase_fields(self)) {
        return verify_fail(base, VERIFY_LOST, report, "the data fields");
    }
    for (size_t i = 0; i < journal->count; i++) {
        const struct verify_note *note = &journal->notes[i];
        for (size_t k = 0; note->before && k < DG_COUNT(rows); k++) {
            const bool changed =
                was_sent(journal, rows[k].writes[0]) || was_sent(journal, rows[k].writes[1]);
            if (note->bytes[0] == rows[k].read && changed &&
                !rows[k].put_back(self, note->bytes + 1)) {
                return verify_fail(base, VERIFY_LOST, report, "%s", rows[k].what);
            }
        }
    }
    return true;
}

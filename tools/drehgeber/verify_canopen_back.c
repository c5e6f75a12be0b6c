/* SPDX-License-Identifier: MIT */
/* A CANopen encoder is put back: what its objects were is in the journal, in the order in which they
   can be written. */
#include <string.h>

#include "drehgeber/bits.h"
#include "verify_canopen.h"

/* Abort codes (CiA 301): the encoder does not have this object, or this sub-index. */
#define NO_OBJECT 0x06020000u
#define NO_SUB 0x06090011u
/* Entries of a mapping. */
#define ENTRIES 8u
/* How often an object is asked for. */
#define UPLOADS 3u

bool verify_canopen_note_download(struct canopen *self, enum note_of of,
                                  const struct object *object, uint32_t value, size_t n)
{
    const uint8_t bytes[8] = {(uint8_t)(0x23u | (4u - n) << 2),
                              (uint8_t)object->index,
                              (uint8_t)(object->index >> 8),
                              object->sub,
                              (uint8_t)value,
                              (uint8_t)(value >> 8),
                              (uint8_t)(value >> 16),
                              (uint8_t)(value >> 24)};
    const struct cf_unit unit = {.id = (uint16_t)of, .bytes = bytes, .n = sizeof bytes};
    return verify_journal_add(self->base.journal, true, &unit);
}

bool verify_canopen_note_object(struct canopen *self, enum note_of of, uint16_t index, uint8_t sub)
{
    const struct object object = {index, sub};
    uint32_t value = 0;
    size_t n = 0;
    self->abort = 0;
    for (unsigned i = 0; i < UPLOADS && n == 0 && self->abort == 0; i++) {
        n = verify_canopen_upload(self, index, sub, &value);
    }
    if (n == 0 && self->abort != NO_OBJECT && self->abort != NO_SUB) {
        self->unread = object;
    }
    return n == 0 || verify_canopen_note_download(self, of, &object, value, n);
}

/* A mapping can be written only while its PDO is off and the mapping is empty. */
bool verify_canopen_note_tpdo(struct canopen *self, enum note_of of, unsigned number)
{
    const struct object communication = {(uint16_t)(0x1800u + number), 1};
    const struct object mapping = {(uint16_t)(0x1A00u + number), 0};
    uint32_t id;
    uint32_t count;
    if (verify_canopen_upload(self, communication.index, 1, &id) == 0 ||
        verify_canopen_upload(self, mapping.index, 0, &count) == 0) {
        self->unread = communication;
        return true;
    }
    bool noted = verify_canopen_note_download(self, of, &communication, id | OFF, 4) &&
                 verify_canopen_note_download(self, of, &mapping, 0, 1);
    for (uint8_t sub = 1; noted && sub <= ENTRIES; sub++) {
        noted = verify_canopen_note_object(self, of, mapping.index, sub);
    }
    return noted && verify_canopen_note_download(self, of, &mapping, count, 1) &&
           verify_canopen_note_object(self, of, communication.index, 2) &&
           verify_canopen_note_object(self, of, communication.index, 3) &&
           verify_canopen_note_object(self, of, communication.index, 5) &&
           verify_canopen_note_download(self, of, &communication, id, 4);
}

/* Everything that the row will write, before it writes any of it. */
bool verify_canopen_note_touched(struct canopen *self, struct cf_report *report)
{
    bool tpdos[TPDOS] = {false};
    bool noted = true;
    for (size_t i = self->touched_count; noted && i > 0; i--) {
        const struct object *object = &self->touched[i - 1u];
        const unsigned pdo = object->index & 0xFFu;
        const bool of_pdo = (object->index >> 8 == 0x18u || object->index >> 8 == 0x1Au);
        if (verify_canopen_needs_saved(object->index)) {
            continue; /* what it reads is no signature, and no place of the shaft */
        }
        if (!of_pdo || pdo >= TPDOS) {
            noted = verify_canopen_note_object(self, NOTE_NOW, object->index, object->sub);
        } else if (!tpdos[pdo]) {
            tpdos[pdo] = true;
            noted = verify_canopen_note_tpdo(self, NOTE_NOW, pdo);
        }
    }
    noted = noted && verify_journal_sync(self->base.journal);
    return noted || verify_fail(&self->base, VERIFY_LOST, report, "the journal cannot be written");
}

/* Whether an object is what its last note says; of a TPDO it was something else between. */
static bool is_back(struct canopen *self, size_t index)
{
    const struct verify_journal *journal = self->base.journal;
    const struct verify_note *note = &journal->notes[index];
    const uint16_t object = (uint16_t)(note->bytes[1] | (unsigned)note->bytes[2] << 8);
    const enum kind kind = verify_canopen_kind_of_object(object);
    uint32_t value = 0;
    if (kind == MEASURED || kind == POSITION) {
        return true;
    }
    for (size_t i = index + 1u; i < journal->count; i++) {
        if (journal->notes[i].id == note->id &&
            memcmp(journal->notes[i].bytes + 1, note->bytes + 1, 3) == 0) {
            return true;
        }
    }
    return verify_canopen_upload(self, object, note->bytes[3], &value) > 0 &&
           value == le32(note->bytes + 4);
}

size_t verify_canopen_find_changed(struct canopen *self, enum note_of first, enum note_of last)
{
    const struct verify_journal *journal = self->base.journal;
    size_t at = 0;
    while (at < journal->count &&
           (journal->notes[at].id < first || journal->notes[at].id > last || is_back(self, at))) {
        at++;
    }
    return at;
}

void verify_canopen_write_notes(struct canopen *self, enum note_of of)
{
    const struct verify_journal *journal = self->base.journal;
    for (size_t i = 0; i < journal->count; i++) {
        const struct cf_unit unit = verify_note_unit(&journal->notes[i]);
        if (unit.id == of) {
            (void)verify_canopen_download(self, &unit);
        }
    }
}

/* What is in force; what a constant object answers to is no matter: it is compared. */
static bool put_back_objects(struct canopen *self, struct cf_report *report)
{
    const struct verify_journal *journal = self->base.journal;
    if (verify_canopen_find_changed(self, NOTE_CUT, NOTE_CUT) != journal->count) {
        verify_canopen_write_notes(self, NOTE_CUT);
    }
    verify_canopen_write_notes(self, NOTE_NOW);
    const size_t at = verify_canopen_find_changed(self, NOTE_NOW, NOTE_CUT);
    if (at == journal->count) {
        return true;
    }
    const uint8_t *bytes = journal->notes[at].bytes;
    return verify_fail(&self->base, VERIFY_LOST, report, "%02X%02Xh:%u", bytes[2], bytes[1],
                       (unsigned)bytes[3]);
}

/* What is saved comes first. A run that was killed may have left the encoder without supply. */
bool verify_canopen_put_back(struct verify_encoder *base, struct cf_report *report)
{
    struct canopen *self = of(base);
    struct cf_report ignored = {0};
    uint32_t position = 0;
    if (!verify_canopen_settle(self, &ignored) && base->power != NULL) {
        (void)verify_powered(base, true, &ignored);
    }
    if ((verify_canopen_has_saved(self) && !verify_canopen_save_again(self, report)) ||
        !put_back_objects(self, report)) {
        return false;
    }
    const bool near = self->position == 0 ||
                      verify_canopen_upload(self, 0x6004, 0, &position) == 0 ||
                      verify_canopen_is_near(self, position, self->position);
    return near || verify_fail(base, VERIFY_LOST, report, "the position");
}

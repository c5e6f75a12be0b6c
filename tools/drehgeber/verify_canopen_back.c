/* SPDX-License-Identifier: MIT */
/* A CANopen encoder is put back: what its objects were is in the journal, in the order in which they
   can be written. */
#include <string.h>

#include "drehgeber/bits.h"
#include "verify_canopen.h"

/* Note a download that puts `value` into an object. */
static bool note_download(struct canopen *self, uint16_t index, uint8_t sub, uint32_t value,
                          size_t n)
{
    const uint8_t bytes[8] = {(uint8_t)(0x23u | (4u - n) << 2),
                              (uint8_t)index,
                              (uint8_t)(index >> 8),
                              sub,
                              (uint8_t)value,
                              (uint8_t)(value >> 8),
                              (uint8_t)(value >> 16),
                              (uint8_t)(value >> 24)};
    const struct cf_unit unit = {.bytes = bytes, .n = sizeof bytes};
    return verify_journal_add(self->base.journal, true, &unit);
}

/* Note what an object is; one that cannot be read cannot be written either. */
static bool note_object(struct canopen *self, uint16_t index, uint8_t sub)
{
    uint32_t value;
    const size_t n = verify_canopen_upload(self, index, sub, &value);
    return n == 0 || note_download(self, index, sub, value, n);
}

/* A mapping can be written only while its PDO is off and the mapping is empty. */
static bool note_tpdo(struct canopen *self, unsigned number)
{
    const uint16_t communication = (uint16_t)(0x1800u + number);
    const uint16_t mapping = (uint16_t)(0x1A00u + number);
    uint32_t id;
    uint32_t count;
    if (verify_canopen_upload(self, communication, 1, &id) == 0 ||
        verify_canopen_upload(self, mapping, 0, &count) == 0) {
        return true;
    }
    bool noted =
        note_download(self, communication, 1, id | OFF, 4) && note_download(self, mapping, 0, 0, 1);
    for (uint8_t sub = 1; noted && sub <= count && sub <= 8; sub++) {
        noted = note_object(self, mapping, sub);
    }
    return noted && note_download(self, mapping, 0, count, 1) &&
           note_object(self, communication, 2) && note_object(self, communication, 3) &&
           note_object(self, communication, 5) && note_download(self, communication, 1, id, 4);
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
        if (!of_pdo || pdo >= TPDOS) {
            noted = note_object(self, object->index, object->sub);
        } else if (!tpdos[pdo]) {
            tpdos[pdo] = true;
            noted = note_tpdo(self, pdo);
        }
    }
    noted = noted && verify_journal_sync(self->base.journal);
    return noted || verify_fail(&self->base, VERIFY_LOST, report, "the journal cannot be written");
}

static bool download(struct canopen *self, const struct cf_unit *unit)
{
    struct dg_can_frame frame = {.id = (uint16_t)(SDO_REQUEST + self->node), .dlc = 8};
    struct cf_report report = {0};
    memcpy(frame.data, unit->bytes, unit->n < 8 ? unit->n : 8u);
    return verify_canopen_send_frame(self, &frame, &report) &&
           verify_canopen_receive_id(self, (uint16_t)(SDO_ANSWER + self->node),
                                     self->base.since + ANSWER_MAX, &frame, &report) == 1 &&
           frame.data[0] == 0x60u;
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
        if (memcmp(journal->notes[i].bytes + 1, note->bytes + 1, 3) == 0) {
            return true;
        }
    }
    return verify_canopen_upload(self, object, note->bytes[3], &value) > 0 &&
           value == le32(note->bytes + 4);
}

/* What a constant object answers to is no matter: it is compared below. */
bool verify_canopen_put_back(struct verify_encoder *base, struct cf_report *report)
{
    struct canopen *self = of(base);
    struct cf_report ignored = {0};
    uint32_t position = 0;
    (void)verify_canopen_settle(self, &ignored);
    for (size_t i = 0; i < base->journal->count; i++) {
        const struct cf_unit unit = verify_note_unit(&base->journal->notes[i]);
        (void)download(self, &unit);
    }
    for (size_t i = 0; i < base->journal->count; i++) {
        if (!is_back(self, i)) {
            const uint8_t *bytes = base->journal->notes[i].bytes;
            return verify_fail(base, VERIFY_LOST, report, "%02X%02Xh:%u", bytes[2], bytes[1],
                               (unsigned)bytes[3]);
        }
    }
    const bool near = self->position == 0 ||
                      verify_canopen_upload(self, 0x6004, 0, &position) == 0 ||
                      verify_canopen_is_near(self, position, self->position);
    return near || verify_fail(base, VERIFY_LOST, report, "the position");
}

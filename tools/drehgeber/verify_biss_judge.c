/* SPDX-License-Identifier: MIT */
/* What a real encoder with BiSS has answered, beside what its model has: judged, and told. */
#include <string.h>

#include "verify_biss.h"

/* --- what is compared --- */

bool verify_biss_is_near(const struct biss *self, uint64_t a, uint64_t b)
{
    const uint64_t range = (uint64_t)1
                           << (self->model.multiturn_bits + self->model.singleturn_bits);
    const uint64_t up = (a + range - b) % range;
    return up <= self->moves || range - up <= self->moves;
}

enum kind {
    CONSTANT,   /* it is what the model says */
    CONFIGURED, /* so it is as delivered, but somebody may have changed it */
    MEASURED,   /* any value is right */
    POSITION    /* near to the model's */
};

static enum kind kind_of_register(uint8_t bank, uint8_t address)
{
    const bool user = bank >= DG_BISS_BANK_USER_FIRST && bank <= DG_BISS_BANK_USER_LAST;
    if (address < BANK_SELECT) {
        return bank == 0 || user ? CONFIGURED : CONSTANT;
    }
    if (address >= 0x61u && address <= 0x67u) {
        return POSITION;
    }
    if (address == 0x68u || address == 0x6Au || address == 0x6Bu) {
        return MEASURED;
    }
    return address == BANK_SELECT || address == TIMEOUT_SELECT ? CONFIGURED : CONSTANT;
}

/* The registers of the position as a number, the first one lowest; a count is bit 32 - ST of that of
   61h. */
static uint64_t number_of(const uint8_t *bytes, size_t n)
{
    uint64_t value = 0;
    while (n > 0) {
        n--;
        value = value << 8 | bytes[n];
    }
    return value;
}

static bool is_same_position(const struct biss *self, const struct biss_access *got,
                             const struct biss_access *came)
{
    const size_t n = got->done < 7u ? got->done : 7u;
    const uint64_t a = number_of(got->data, n);
    const uint64_t b = number_of(came->data, n);
    const uint64_t count = (uint64_t)1 << (32u - self->model.singleturn_bits);
    const uint64_t up = a > b ? a - b : b - a;
    return got->address == 0x61u ? up % count == 0 && up <= self->moves * count : a == b;
}

/* Whether everything but the data is the same. */
static bool is_same_course(const struct cf_biss_access *got, const struct cf_biss_access *came)
{
    const struct biss_access *g = &got->access;
    const struct biss_access *c = &came->access;
    return got->heard == came->heard && g->r == c->r && g->w == c->w && g->late == c->late &&
           g->stop == c->stop && g->crc_good == c->crc_good && g->done == c->done &&
           g->idl == c->idl;
}

/* What of an answer is another one: none, what its owner may have changed, or what has to be so. */
static enum cf_verdict judge_access(const struct biss *self, const struct cf_biss_access *got)
{
    const struct biss_access *g = &got->access;
    const struct biss_access *c = &self->access.access;
    enum cf_verdict verdict = CF_AGREES;
    if (!is_same_course(got, &self->access)) {
        return CF_DIFFERS;
    }
    for (size_t i = 0; i < g->done; i++) {
        const enum kind kind = kind_of_register(got->bank, (uint8_t)(g->address + i));
        const bool same = kind == MEASURED || g->data[i] == c->data[i] ||
                          (kind == POSITION && is_same_position(self, g, c));
        if (!same && (kind == CONSTANT || kind == POSITION)) {
            return CF_DIFFERS;
        }
        verdict = same ? verdict : CF_UNKNOWN;
    }
    /* A row has what it has written, unless something else was there before. */
    return verdict == CF_UNKNOWN && self->writes != 0 && self->delivered ? CF_DIFFERS : verdict;
}

/* CDS of each frame, but for those of which the row expects any. */
static bool is_same_cds(const struct cf_biss_frames *got, const struct cf_biss_frames *came)
{
    const size_t n = strlen(got->any);
    for (size_t i = 0; got->cds[i] != '\0'; i++) {
        const bool any = i < n && got->any[i] == 'x';
        if (!any && got->cds[i] != came->cds[i]) {
            return false;
        }
    }
    return true;
}

static enum cf_verdict judge_frames(const struct biss *self, const struct cf_biss_frames *got)
{
    const struct cf_biss_frames *came = &self->frames;
    const struct biss_word *g = &got->last.words[0];
    const struct biss_word *c = &came->last.words[0];
    const bool counted =
        !self->model.life_counter || self->expected == LIFE_ANY || c->lc == self->expected;
    if (!counted || !is_same_cds(got, came) || g->n_error != c->n_error ||
        g->n_warning != c->n_warning) {
        return CF_DIFFERS;
    }
    if (verify_biss_is_near(self, g->position, c->position)) {
        return CF_AGREES;
    }
    return self->delivered ? CF_DIFFERS : CF_UNKNOWN;
}

static enum cf_verdict judge_command(const struct biss *self, const struct biss_command *got)
{
    return got->idl == self->command.idl && got->ida == self->command.ida ? CF_AGREES : CF_DIFFERS;
}

/* Frames in between are as good as those that somebody looks at. */
enum cf_verdict verify_biss_judge(const struct biss *self, const struct cf_unit *answer)
{
    if (self->bad > 0) {
        return CF_DIFFERS;
    }
    if (answer->id == CF_BISS_FRAMES) {
        struct cf_biss_frames got;
        memcpy(&got, answer->bytes, sizeof got);
        return judge_frames(self, &got);
    }
    if (answer->id == CF_BISS_ACCESS) {
        struct cf_biss_access got;
        memcpy(&got, answer->bytes, sizeof got);
        return judge_access(self, &got);
    }
    struct biss_command got;
    memcpy(&got, answer->bytes, sizeof got);
    return judge_command(self, &got);
}

/* --- what is told --- */

/* What was wrong with some frames, if any. */
static void print_fault(const struct biss *self, unsigned bad, int at, char *to)
{
    if (bad > 0) {
        (void)snprintf(to + at, VERIFY_BISS_TEXT - (size_t)at, ", and %u frames with %s", bad,
                       self->master.fault);
    }
}

static void print_frames(const struct biss *self, const struct cf_biss_frames *frames, unsigned bad,
                         int life, char *to)
{
    const struct biss_word *word = &frames->last.words[0];
    int n = snprintf(to, VERIFY_BISS_TEXT, " CDS %.80s, position %llX, nE %d, nW %d", frames->cds,
                     (unsigned long long)word->position, word->n_error ? 1 : 0,
                     word->n_warning ? 1 : 0);
    if (life >= 0) {
        n += snprintf(to + n, VERIFY_BISS_TEXT - (size_t)n, ", LC %02X", (unsigned)life);
    }
    print_fault(self, bad, n, to);
}

static void print_access(const struct biss *self, const struct cf_biss_access *access, unsigned bad,
                         char *to)
{
    const struct biss_access *a = &access->access;
    const char *how = !access->heard ? " silent"
                      : a->late      ? " no start bit within 20 ms"
                      : a->r == a->w ? " refused"
                                     : "";
    int n = snprintf(to, VERIFY_BISS_TEXT, "%s", how);
    for (size_t i = 0; i < a->done; i++) {
        n += snprintf(to + n, VERIFY_BISS_TEXT - (size_t)n, " %02X", a->data[i]);
    }
    n += snprintf(to + n, VERIFY_BISS_TEXT - (size_t)n, "%s%s, RW %d%d, IDL %03X",
                  a->stop ? ", P 1" : "", a->crc_good ? "" : ", wrong CRC", a->r ? 1 : 0,
                  a->w ? 1 : 0, a->idl);
    print_fault(self, bad, n, to);
}

void verify_biss_print_request(const struct cf_biss_access *access, char *to)
{
    const struct biss_access *a = &access->access;
    int n = snprintf(to, VERIFY_BISS_TEXT, " %s ID %u register %02Xh", a->write ? "write" : "read",
                     a->id, a->address);
    for (size_t i = 0; a->write && i < a->n; i++) {
        n += snprintf(to + n, VERIFY_BISS_TEXT - (size_t)n, " %02X", a->data[i]);
    }
    if (!a->write) {
        (void)snprintf(to + n, VERIFY_BISS_TEXT - (size_t)n, ", %zu bytes", a->n);
    }
}

/* What was asked, what had to come, what has come. */
void verify_biss_tell(const struct biss *self, const struct cf_unit *got,
                      char text[3][VERIFY_BISS_TEXT])
{
    if (got->id == CF_BISS_FRAMES) {
        struct cf_biss_frames frames;
        memcpy(&frames, got->bytes, sizeof frames);
        (void)snprintf(text[0], VERIFY_BISS_TEXT, " CDM %.80s", frames.cdm);
        print_frames(self, &frames, 0, self->model.life_counter ? self->expected : -1, text[1]);
        print_frames(self, &self->frames, self->bad,
                     self->model.life_counter ? self->frames.last.words[0].lc : -1, text[2]);
    } else if (got->id == CF_BISS_ACCESS) {
        struct cf_biss_access access;
        memcpy(&access, got->bytes, sizeof access);
        (void)snprintf(text[0], VERIFY_BISS_TEXT, "%s", self->asked);
        print_access(self, &access, 0, text[1]);
        print_access(self, &self->access, self->bad, text[2]);
    } else {
        struct biss_command command;
        memcpy(&command, got->bytes, sizeof command);
        (void)snprintf(text[0], VERIFY_BISS_TEXT, " command %u for IDs %02X", command.code,
                       command.ids);
        (void)snprintf(text[1], VERIFY_BISS_TEXT, " IDL %03X, IDA %02X", command.idl, command.ida);
        (void)snprintf(text[2], VERIFY_BISS_TEXT, " IDL %03X, IDA %02X", self->command.idl,
                       self->command.ida);
    }
}

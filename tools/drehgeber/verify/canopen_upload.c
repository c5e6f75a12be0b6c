/* SPDX-License-Identifier: MIT */
/* What an object is, seen by an upload: the step of rows that are made of an EDS file. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "canopen_bench.h"
#include "drehgeber/bits.h"

/* Longest value of an expedited upload. */
#define EXPEDITED_MAX 4u
/* Abort codes (CiA 301): an object that can only be written; and the first and the last of those that
   say that there is no value now. */
#define WRITE_ONLY 0x06010001u
#define NO_VALUE_FIRST 0x08000020u
#define NO_VALUE_LAST 0x08000024u

/* What a row wants of an object. */
struct wanted {
    uint8_t head[3]; /* index and sub-index, as they are on the wire */
    size_t n;        /* bytes */
    uint64_t low;    /* the value; with `range` the smallest one */
    uint64_t high;
    bool is_signed;
};

/* The answer to an upload: of an abort `code`, otherwise bytes, or how many will come. */
struct uploaded {
    bool abort;
    uint32_t code;
    size_t n; /* 0: it does not say */
    bool expedited;
    uint64_t value; /* of an expedited one */
};

/* @return false: it is no answer to this upload */
static bool read_answer(const struct wanted *wanted, const struct cf_unit *came,
                        struct uploaded *to)
{
    if (came->bytes == NULL || came->rtr || came->n != 8 ||
        memcmp(came->bytes + 1, wanted->head, sizeof wanted->head) != 0) {
        return false;
    }
    const uint8_t command = came->bytes[0];
    const uint32_t data = dg_load_le32(came->bytes + 4);
    *to = (struct uploaded){.abort = command == 0x80u, .code = data};
    if (to->abort) {
        return true;
    }
    to->expedited = (command & 2u) != 0;
    if ((command & 1u) != 0) {
        to->n = to->expedited ? EXPEDITED_MAX - (command >> 2 & 3u) : data;
    }
    to->value = to->n == 0 || to->n >= EXPEDITED_MAX ? data : data & ((1u << 8 * to->n) - 1u);
    return command >> 5 == 2u;
}

static bool has_no_value(const struct uploaded *answer)
{
    return answer->abort && answer->code >= NO_VALUE_FIRST && answer->code <= NO_VALUE_LAST;
}

static enum cf_verdict judge_there(const void *ctx, const struct cf_unit *came)
{
    struct uploaded answer;
    return read_answer(ctx, came, &answer) && (!answer.abort || has_no_value(&answer)) ? CF_AGREES
                                                                                       : CF_DIFFERS;
}

static enum cf_verdict judge_write_only(const void *ctx, const struct cf_unit *came)
{
    struct uploaded answer;
    return read_answer(ctx, came, &answer) && answer.abort && answer.code == WRITE_ONLY
               ? CF_AGREES
               : CF_DIFFERS;
}

static enum cf_verdict judge_size(const void *ctx, const struct cf_unit *came)
{
    const struct wanted *wanted = ctx;
    struct uploaded answer;
    if (!read_answer(wanted, came, &answer)) {
        return CF_DIFFERS;
    }
    if (has_no_value(&answer) || (!answer.abort && answer.n == 0)) {
        return CF_UNKNOWN;
    }
    return !answer.abort && answer.n == wanted->n ? CF_AGREES : CF_DIFFERS;
}

/* Of what the upload brings at once. @return whether `value` is what it brings; otherwise `verdict` */
static bool take_value(const struct wanted *wanted, const struct cf_unit *came, uint64_t *value,
                       enum cf_verdict *verdict)
{
    struct uploaded answer;
    *verdict = CF_DIFFERS;
    if (!read_answer(wanted, came, &answer)) {
        return false;
    }
    *verdict =
        has_no_value(&answer) || (!answer.abort && !answer.expedited) ? CF_UNKNOWN : CF_DIFFERS;
    *value = answer.value;
    return !answer.abort && answer.expedited;
}

static enum cf_verdict judge_value(const void *ctx, const struct cf_unit *came)
{
    const struct wanted *wanted = ctx;
    enum cf_verdict verdict;
    uint64_t value;
    return take_value(wanted, came, &value, &verdict) && value == wanted->low ? CF_AGREES : verdict;
}

/* Somebody may have written it. */
static enum cf_verdict judge_delivered(const void *ctx, const struct cf_unit *came)
{
    enum cf_verdict verdict;
    uint64_t value;
    const bool brought = take_value(ctx, came, &value, &verdict);
    return brought ? (value == ((const struct wanted *)ctx)->low ? CF_AGREES : CF_UNKNOWN)
                   : verdict;
}

static int64_t sign_of(const struct wanted *wanted, uint64_t value)
{
    const uint64_t top = UINT64_C(1) << (8u * wanted->n - 1u);
    return (int64_t)((value ^ top) - top);
}

static enum cf_verdict judge_range(const void *ctx, const struct cf_unit *came)
{
    const struct wanted *wanted = ctx;
    enum cf_verdict verdict;
    uint64_t value;
    if (!take_value(wanted, came, &value, &verdict)) {
        return verdict;
    }
    const bool inside = wanted->is_signed
                            ? sign_of(wanted, value) >= sign_of(wanted, wanted->low) &&
                                  sign_of(wanted, value) <= sign_of(wanted, wanted->high)
                            : value >= wanted->low && value <= wanted->high;
    return inside ? CF_AGREES : CF_DIFFERS;
}

/* A number of so many bytes as 2, 4, 6 or 8 hexadecimal digits. */
static bool parse_value(const char *word, struct wanted *to, uint64_t *value)
{
    char *end;
    to->n = strlen(word) / 2u;
    *value = strtoull(word, &end, 16);
    return *end == '\0' && to->n >= 1 && to->n <= EXPEDITED_MAX && strlen(word) % 2u == 0;
}

/* What is wanted, by the words behind the object. */
static const struct {
    const char *word;
    size_t values; /* that stand behind it */
    enum cf_verdict (*judge)(const void *ctx, const struct cf_unit *came);
} relations[] = {
    {"there", 0, judge_there}, {"write-only", 0, judge_write_only}, {"size", 0, judge_size},
    {"is", 1, judge_value},    {"delivered", 1, judge_delivered},   {"within", 2, judge_range},
};

static bool parse_wanted(char **words, size_t n, size_t values, struct wanted *to)
{
    to->high = 0;
    if (values == 0) {
        to->n = n > 3 ? strtoul(words[3], NULL, 10) : 0;
        return true;
    }
    to->is_signed = n == values + 4u && strcmp(words[n - 1u], "signed") == 0;
    return n >= values + 3u && parse_value(words[3], to, &to->low) &&
           (values == 1 || parse_value(words[4], to, &to->high));
}

bool canopen_step_upload(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    struct dg_can_frame request = {.id = (uint16_t)(0x600u + b->node_id)};
    struct wanted wanted = {.n = 0};
    char text[200] = "an object that is";

    if (n < 3 || !canopen_parse_object(words[1], &request, report)) {
        return cf_fail(report, "upload INDEX:SUB there|write-only|size|is|delivered|within");
    }
    request.data[0] = 0x40;
    request.dlc = 8;
    memcpy(wanted.head, request.data + 1, sizeof wanted.head);
    for (size_t i = strcmp(words[2], "is") == 0 ? 3 : 2; i < n; i++) {
        (void)snprintf(text + strlen(text), sizeof text - strlen(text), " %s", words[i]);
    }
    for (size_t i = 0; i < DG_COUNT(relations); i++) {
        const struct cf_relation relation = {relations[i].judge, &wanted, text};
        if (strcmp(words[2], relations[i].word) == 0) {
            return parse_wanted(words, n, relations[i].values, &wanted)
                       ? canopen_ask(b, &request, &relation, report)
                       : cf_fail(report, "upload: not a value: %s", words[n - 1u]);
        }
    }
    return cf_fail(report, "upload: no such relation: %s", words[2]);
}

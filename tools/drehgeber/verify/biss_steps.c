/* SPDX-License-Identifier: MIT */
/*
 * Steps of the S36 with BiSS: frames and control frames, in virtual time. The table at the end
 * lists all steps; biss.rows explains them. Everything goes over MA and SL, through the reference
 * master; at the end of every row each frame it saw must have been a good one. A real encoder beside
 * the model is asked the same, and judged by what the model has answered.
 */
#include <stdlib.h>
#include <string.h>

#include "biss_bench.h"

#define BITS_MAX CF_BISS_FRAMES_MAX

static struct biss_bench bench;

/* --- lines and frames ---------------------------------------------------------------------- */

/* Equal where `want` is not x. */
static bool bits_match(const char *want, const char *got)
{
    while (*want != '\0' && *got != '\0' && (*want == 'x' || *want == *got)) {
        want++;
        got++;
    }
    return *want == *got;
}

/* Clock the frames of b->frames.cdm, and ask whoever is beside for the same. */
static bool clock_all_frames(struct biss_bench *b, struct cf_report *report)
{
    if (!biss_ask(b, CF_BISS_FRAMES, &b->frames, sizeof b->frames, report)) {
        return false;
    }
    cf_biss_clock(&b->master, &b->frames);
    return true;
}

/* The same for a single one. */
static bool clock_one_frame(struct biss_bench *b, bool cdm, struct cf_report *report)
{
    (void)snprintf(b->frames.cdm, sizeof b->frames.cdm, "%d", cdm ? 1 : 0);
    b->frames.any[0] = '\0';
    return clock_all_frames(b, report);
}

static bool judge_clocked(const struct biss_bench *b, bool matched, struct cf_report *report)
{
    const struct biss_said said = {&b->frames, sizeof b->frames, matched};

    return biss_judge(b, CF_BISS_FRAMES, &said, report);
}

/* What a frame of an encoder that is somewhere else has in common with that of a row: its length, the
   flags behind its position. */
static bool flags_match(const struct biss_bench *b, const char *want, const char *got)
{
    const struct dg_biss_model *model = &b->slaves[0].model;
    const size_t flags = 1u + model->multiturn_bits + model->singleturn_bits; /* behind CDS */
    bool match = strlen(want) == strlen(got) && (want[0] == 'x' || want[0] == got[0]);

    for (size_t i = flags; match && i < flags + 2u && want[i] != '\0'; i++) {
        match = want[i] == 'x' || want[i] == got[i];
    }
    return match;
}

/* ma LEVELS = LEVELS: one edge each, half a period apart; SL behind each */
static bool step_ma(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    size_t equals = cf_find_equals(words, n);
    char levels[BITS_MAX + 1];
    char want[BITS_MAX + 1];

    cf_join(levels, BITS_MAX + 1u, words, 1, equals);
    cf_join(want, BITS_MAX + 1u, words, equals + 1, n);
    for (char *c = levels; *c != '\0'; c++) {
        *c = biss_master_edge(&b->master, *c == '1') ? '1' : '0';
    }
    return bits_match(want, levels) ||
           cf_fail(report, "SL: expected %s\n    got          %s", want, levels);
}

/* sl L [T]: level of SL, after T without an edge */
static bool step_sl(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    bool want = n > 1 && words[1][0] == '1';

    biss_bench_wait(b, n == 3 ? biss_bench_span(words[2]) : 0);
    return b->master.sl == want || cf_fail(report, "SL is %d", b->master.sl ? 1 : 0);
}

/* frame CDM = BITS: CDS and all data bits */
static bool step_frame(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    size_t equals = cf_find_equals(words, n);
    char want[BITS_MAX + 1];
    char got[BITS_MAX + 1];

    if (!clock_one_frame(b, n > 1 && words[1][0] == '1', report)) {
        return false;
    }
    cf_join(want, BITS_MAX + 1u, words, equals + 1, n);
    (void)snprintf(got, sizeof got, "%d%s", b->frames.last.cds ? 1 : 0, b->frames.last.bits);
    if (biss_has_beside()) {
        const bool placed = biss_trial()->placed;
        return judge_clocked(b, placed ? flags_match(b, want, got) : bits_match(want, got), report);
    }
    return bits_match(want, got) ||
           cf_fail(report, "frame: expected %s\n    got             %s", want, got);
}

/* A slave's word against POSITION:nERRnWARN[:LC[:CRC]], hexadecimal, * for anything, `latch` for
 * the count at e1. */
static bool word_matches(struct biss_bench *b, const struct biss_word *word, size_t slave,
                         char *text)
{
    const unsigned st_bits = b->slaves[slave].model.singleturn_bits;
    const unsigned bits = st_bits + b->slaves[slave].model.multiturn_bits;
    uint64_t latched = (uint64_t)(biss_bench_angle(b, b->frames.last.latch) >> (32u - st_bits)) &
                       (((uint64_t)1 << bits) - 1u);
    const uint64_t got[4] = {word->position,
                             (word->n_error ? 0x10u : 0u) | (word->n_warning ? 1u : 0u), word->lc,
                             word->crc};
    /* Of an encoder that is somewhere else only the flags are the row's. */
    const bool placed = biss_trial()->placed;
    bool good = word->crc_good;

    for (size_t i = 0; i < 4 && *text != '\0'; i++) {
        size_t n = strcspn(text, ":");
        uint64_t want = strncmp(text, "latch", n) == 0 ? latched : strtoull(text, NULL, 16);

        good = good && (*text == '*' || want == got[i] || (placed && i != 1));
        text += text[n] == ':' ? n + 1 : n;
    }
    return good;
}

/* @EDGE, @FIRST..LAST */
static bool edge_matches(const char *text, unsigned edge)
{
    char *rest;
    unsigned long first = strtoul(text, &rest, 10);
    unsigned long last = strncmp(rest, "..", 2) == 0 ? strtoul(rest + 2, NULL, 10) : first;

    return edge >= first && edge <= last;
}

/* What is wrong with the words of the last frame. @return false after cf_fail() */
static bool check_frame_words(struct biss_bench *b, char **words, size_t n,
                              struct cf_report *report)
{
    const struct biss_frame *frame = &b->frames.last;

    if (!frame->started || n != b->master.channel_count) {
        return cf_fail(report, "%s", frame->started ? "one WORD per slave" : "no start bit");
    }
    for (size_t i = 0; i < n; i++) {
        const struct biss_word *word = &frame->words[i];

        if (!word_matches(b, word, i, words[i])) {
            return cf_fail(report, "slave %zu: got %llX:%d%d:%02X:%02X, CRC %s", i,
                           (unsigned long long)word->position, word->n_error ? 1 : 0,
                           word->n_warning ? 1 : 0, word->lc, word->crc,
                           word->crc_good ? "good" : "bad");
        }
    }
    return true;
}

/* scd [@EDGE] WORD...: one frame with CDM = 0 */
static bool step_scd(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    const bool timed = n > 1 && words[1][0] == '@';
    const size_t first = timed ? 2 : 1;

    if (!biss_need(timed ? CF_EXACT : 0u, report) || !clock_one_frame(b, false, report)) {
        return false;
    }
    const bool on_time = !timed || edge_matches(words[1] + 1, b->frames.last.start_edge);
    const bool right = on_time ? check_frame_words(b, words + first, n - first, report)
                               : cf_fail(report, "start bit at e%u", b->frames.last.start_edge);
    return biss_has_beside() ? judge_clocked(b, right, report) : right;
}

/* timeout MIN MAX: of the last `scd` or `frame` */
static bool step_timeout(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    bool good = n == 3 && b->frames.last.timed_out &&
                b->frames.last.timeout >= biss_bench_span(words[1]) &&
                b->frames.last.timeout <= biss_bench_span(words[2]);

    return good ||
           cf_fail(report, "timeout: got %llu ns", (unsigned long long)b->frames.last.timeout);
}

/* bad N: of the frames so far, N were not good; they are forgiven */
static bool step_bad(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    bool good = n == 2 && b->master.bad_frames == strtoul(words[1], NULL, 10);

    if (!good) {
        return cf_fail(report, "bad frames: got %u", b->master.bad_frames);
    }
    b->master.bad_frames = 0;
    return true;
}

/* --- control frames ------------------------------------------------------------------------ */

/* zeros N: frames with CDM = 0 */
static bool step_zeros(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    const unsigned long count = n == 2 ? strtoul(words[1], NULL, 10) : 0;

    if (count == 0 || count > BITS_MAX) {
        return cf_fail(report, "zeros N");
    }
    memset(b->frames.cdm, '0', count);
    b->frames.cdm[count] = '\0';
    b->frames.any[0] = '\0';
    return clock_all_frames(b, report) && (!biss_has_beside() || judge_clocked(b, true, report));
}

/* control CDM = CDS: one frame for each bit */
static bool step_control(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    size_t equals = cf_find_equals(words, n);
    char want[BITS_MAX + 1];

    cf_join(b->frames.cdm, BITS_MAX + 1u, words, 1, equals);
    cf_join(want, BITS_MAX + 1u, words, equals + 1, n);
    memcpy(b->frames.any, want, strlen(want) + 1u);
    if (!clock_all_frames(b, report)) {
        return false;
    }
    const bool matched = bits_match(want, b->frames.cds);
    if (biss_has_beside()) {
        return judge_clocked(b, matched, report);
    }
    return matched || cf_fail(report, "CDM %s:\n    expected %s\n    got      %s", b->frames.cdm,
                              want, b->frames.cds);
}

/* word HEX = CDS: 14 zeros, S, and the 31 bits of an address word */
static bool step_word(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    static const char start[] = "000000000000001";
    const size_t ahead = sizeof start - 2u; /* zeros */
    unsigned long value = n > 3 ? strtoul(words[1], NULL, 16) : 0;
    char *cdm = b->frames.cdm;
    char want[BITS_MAX + 1];

    memcpy(cdm, start, sizeof start);
    for (unsigned i = 0; i < 31; i++) {
        cdm[ahead + 1u + i] = (value >> (31u - i) & 1u) != 0 ? '1' : '0';
    }
    memcpy(cdm + ahead + 32u, "0", 2); /* no further byte */
    cf_join(want, BITS_MAX + 1u, words, 3, n);
    (void)snprintf(b->frames.any, sizeof b->frames.any, "%.*s%.40s", (int)ahead, start, want);
    if (!clock_all_frames(b, report)) {
        return false;
    }
    const char *cds = b->frames.cds + ahead;
    if (biss_has_beside()) {
        return judge_clocked(b, bits_match(want, cds), report);
    }
    return bits_match(want, cds) ||
           cf_fail(report, "word: expected %s\n    got            %s", want, cds);
}

/* What an access must come to. */
struct outcome {
    uint8_t low[BISS_SEQUENCE_MAX]; /* a byte read may be within a range */
    uint8_t high[BISS_SEQUENCE_MAX];
    size_t n;
    bool refused;
    bool silent;
    bool late;
    bool stop;
};

static bool set_option(struct biss_access *access, const char *word)
{
    static const char *const names[] = {"id=", "flip=", "dflip=", "patience_us=", "more="};
    const char *value = strchr(word, '=');
    size_t i = 0;
    unsigned long figure;

    if (value == NULL || value[1] == '\0') {
        return false;
    }
    figure = strtoul(value + 1, NULL, 16);
    while (i < DG_COUNT(names) && strncmp(word, names[i], strlen(names[i])) != 0) {
        i++;
    }
    access->id = i == 0 ? (uint8_t)figure : access->id;
    access->address_flips = i == 1 ? (uint8_t)figure : access->address_flips;
    access->data_flips = i == 2 ? (uint8_t)figure : access->data_flips;
    access->patience = i == 3 ? DG_US(strtoul(value + 1, NULL, 10)) : access->patience;
    access->n = i == 4 ? figure : access->n;
    return i < DG_COUNT(names);
}

/* "4B", "1F..21", "FFx64", "*", "*x8" */
static bool add_bytes(struct outcome *outcome, char *word)
{
    bool any = word[0] == '*';
    char *rest = word + 1;
    unsigned long low = any ? 0 : strtoul(word, &rest, 16);
    unsigned long high = any ? 0xFF : low;
    unsigned long times = 1;

    if (strncmp(rest, "..", 2) == 0) {
        high = strtoul(rest + 2, &rest, 16);
    }
    if (*rest == 'x') {
        times = strtoul(rest + 1, &rest, 10);
    }
    if (rest == word || *rest != '\0' || outcome->n + times > BISS_SEQUENCE_MAX) {
        return false;
    }
    memset(&outcome->low[outcome->n], (int)low, times);
    memset(&outcome->high[outcome->n], (int)high, times);
    outcome->n += times;
    return true;
}

/* Keywords of the outcome. */
static bool set_keyword(struct outcome *outcome, const char *word)
{
    const struct {
        const char *name;
        bool *flag;
    } keywords[] = {
        {"refused", &outcome->refused},
        {"silent", &outcome->silent},
        {"late", &outcome->late},
        {"P", &outcome->stop},
    };

    for (size_t i = 0; i < DG_COUNT(keywords); i++) {
        if (strcmp(word, keywords[i].name) == 0) {
            *keywords[i].flag = true;
            return true;
        }
    }
    return false;
}

static bool parse_access_words(struct biss_access *access, struct outcome *outcome, char **words,
                               size_t n)
{
    bool have_address = false;
    bool good = true;

    for (size_t i = 1; i < n && good; i++) {
        if (set_option(access, words[i]) || set_keyword(outcome, words[i])) {
            continue;
        }
        if (have_address) {
            good = add_bytes(outcome, words[i]);
        } else {
            access->address = (uint8_t)strtoul(words[i], NULL, 16);
            have_address = true;
        }
    }
    access->n += outcome->n > 0 ? outcome->n : 1;
    memcpy(access->data, outcome->low, sizeof access->data);
    return good && have_address && access->n <= BISS_SEQUENCE_MAX;
}

static const char *check_bytes(const struct biss_access *got, const struct outcome *want)
{
    if (got->done != want->n) {
        return "wrong length";
    }
    if (got->stop != want->stop) {
        return "wrong P";
    }
    if (!got->crc_good) {
        return "wrong CRC or echo";
    }
    for (size_t i = 0; i < want->n; i++) {
        const bool own = biss_trial()->placed && cf_biss_is_own((uint8_t)(got->address + i));

        if (!own && (got->data[i] < want->low[i] || got->data[i] > want->high[i])) {
            return "wrong data";
        }
    }
    return NULL;
}

/* @return what is wrong, or NULL */
static const char *check_outcome(const struct biss_bench *b, const struct outcome *want)
{
    const struct biss_access *got = &b->access.access;
    bool refused = got->r == got->w;

    if (want->silent) {
        return b->access.heard ? "not silent" : NULL;
    }
    if (refused != want->refused || (refused && got->r == got->write)) {
        return "wrong echo of RW";
    }
    if (want->late != got->late) {
        return "start bit";
    }
    return refused || want->late ? NULL : check_bytes(got, want);
}

/* read|write [id=N] [flip=BITS] [dflip=BITS] [patience_us=N] [more=N] ADDRESS BYTES...
 *     [P] [refused] [silent] [late] */
static bool step_access(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    struct outcome want = {.n = 0};
    const struct biss_access *got = &b->access.access;
    const char *wrong;
    char hex[4 * BISS_SEQUENCE_MAX] = "";

    memset(&b->access, 0, sizeof b->access);
    b->access.access.write = words[0][0] == 'w';
    b->access.stray = b->master.stray;
    b->access.bank = b->slaves[0].device.bank;
    if (!parse_access_words(&b->access.access, &want, words, n)) {
        return cf_fail(report, "read|write ADDRESS BYTES");
    }
    if (!biss_ask(b, CF_BISS_ACCESS, &b->access, sizeof b->access, report)) {
        return false;
    }
    cf_biss_access(&b->master, &b->access);
    wrong = check_outcome(b, &want);
    if (biss_has_beside()) {
        return biss_judge(b, CF_BISS_ACCESS,
                          &(struct biss_said){&b->access, sizeof b->access, wrong == NULL}, report);
    }
    for (size_t i = 0; i < got->done; i++) {
        (void)snprintf(hex + 3 * i, 4, " %02X", got->data[i]);
    }
    return wrong == NULL ||
           cf_fail(report, "%s: RW %d%d, %zu bytes%s, P %d%s%s\n    CDM %s\n    CDS %s", wrong,
                   got->r ? 1 : 0, got->w ? 1 : 0, got->done, hex, got->stop ? 1 : 0,
                   got->crc_good ? "" : ", bad CRC", got->late ? ", late" : "", b->master.cdm,
                   b->master.cds);
}

/* busy I MIN MAX: frames the start bit of byte I of the last access was late */
static bool step_busy(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    unsigned long at = n == 4 ? strtoul(words[1], NULL, 10) % BISS_SEQUENCE_MAX : 0;

    const unsigned busy = b->access.access.busy[at];

    if (n != 4 || busy < strtoul(words[2], NULL, 10) || busy > strtoul(words[3], NULL, 10)) {
        return cf_fail(report, "busy for %u frames", busy);
    }
    return true;
}

/* idl HEX: ID locks of the last access */
static bool step_idl(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    const uint16_t idl = b->access.access.idl;

    return (n == 2 && idl == strtoul(words[1], NULL, 16)) || cf_fail(report, "idl: got %03X", idl);
}

/* command [reduced] ids=HEX code=N [ex=0] [flip=HEX] = IDL IDA */
static bool step_command(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct biss_bench *b = ctx;
    struct biss_command command = {.execute = true};
    size_t equals = cf_find_equals(words, n);

    for (size_t i = 1; i < equals; i++) {
        const char *value = strchr(words[i], '=');
        unsigned long figure = value != NULL ? strtoul(value + 1, NULL, 16) : 0;

        command.reduced = command.reduced || strcmp(words[i], "reduced") == 0;
        command.execute = command.execute && strcmp(words[i], "ex=0") != 0;
        command.ids = strncmp(words[i], "ids=", 4) == 0 ? (uint8_t)figure : command.ids;
        command.code = strncmp(words[i], "code=", 5) == 0 ? (uint8_t)figure : command.code;
        command.crc_flips =
            strncmp(words[i], "flip=", 5) == 0 ? (uint8_t)figure : command.crc_flips;
    }
    if (!biss_ask(b, CF_BISS_COMMAND, &command, sizeof command, report)) {
        return false;
    }
    biss_master_command(&b->master, &command);
    const bool matched = n == equals + 3 && command.idl == strtoul(words[equals + 1], NULL, 16) &&
                         command.ida == strtoul(words[equals + 2], NULL, 16);
    if (biss_has_beside()) {
        return biss_judge(b, CF_BISS_COMMAND,
                          &(struct biss_said){&command, sizeof command, matched}, report);
    }
    if (!matched) {
        return cf_fail(report, "command: got IDL %03X IDA %02X\n    CDM %s\n    CDS %s",
                       command.idl, command.ida, b->master.cdm, b->master.cds);
    }
    return true;
}

/* --- table --------------------------------------------------------------------------------- */

/* clang-format off */
static const struct cf_step steps[] = {
    {"given",   biss_bench_given,  false, 0},         {"behind",  biss_bench_behind, false, CF_RING},
    {"power",   biss_bench_power,  false, CF_POWER},  {"pos",     biss_bench_pos,    false, 0},
    {"rpm",     biss_bench_rpm,    false, CF_SHAFT},  {"world",   biss_bench_world,  false, CF_INSIDE},
    {"wait",    biss_bench_after,  false, 0},         {"damage",  biss_bench_damage, false, CF_INSIDE},
    {"master",  biss_bench_master, false, 0},         {"zeros",   step_zeros,        false, 0},
    {"ma",      step_ma,           true,  CF_EXACT},  {"sl",      step_sl,           true,  CF_EXACT},
    {"frame",   step_frame,        true,  0},         {"scd",     step_scd,          true,  0},
    {"bad",     step_bad,          true,  CF_EXACT},  {"timeout", step_timeout,      true,  CF_EXACT},
    {"control", step_control,      true,  0},         {"word",    step_word,         true,  0},
    {"read",    step_access,       true,  0},         {"write",   step_access,       true,  0},
    {"busy",    step_busy,         true,  CF_EXACT},  {"idl",     step_idl,          true,  0},
    {"command", step_command,      true,  0},
};
/* clang-format on */

static void begin(void *ctx)
{
    biss_bench_begin(ctx);
}

static bool finish(void *ctx, struct cf_report *report)
{
    const struct biss_bench *b = ctx;

    return b->master.bad_frames == 0 ||
           cf_fail(report, "%u frames without Ack, start, stop or timeout, or with a bad CRC",
                   b->master.bad_frames);
}

const struct cf_device *cf_biss(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

/* SPDX-License-Identifier: MIT */
/*
 * Steps of an encoder with SSI, in virtual time. The table at the end lists all steps; ssi.rows
 * explains them. Data must never have moved on a falling edge when a row is over.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "rows.h"
#include "ssi_rig.h"

#define BITS_MAX 400u

/* Everything; plain data that begin() sets up. */
struct bench {
    struct ssi_rig rig;
    int64_t from; /* the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm;
};

static struct bench bench;

/* --- words of a step ----------------------------------------------------------------------- */

/* "5ms", "300us", "100ns", "1s" */
static bool span_of(const char *word, dg_ns *span)
{
    char *unit;
    const dg_ns n = strtoull(word, &unit, 10);
    const char *const units[] = {"ns", "us", "ms", "s"};
    dg_ns scale = 1;

    for (size_t i = 0; i < DG_COUNT(units); i++, scale *= 1000u) {
        if (unit != word && strcmp(unit, units[i]) == 0) {
            *span = n * scale;
            return true;
        }
    }
    return false;
}

/* Joins words[from..to) to one string of bits. */
static void join(char *bits, char **words, size_t from, size_t to)
{
    size_t at = 0;

    for (size_t i = from; i < to; i++) {
        for (const char *c = words[i]; *c != '\0' && at < BITS_MAX; c++) {
            bits[at++] = *c;
        }
    }
    bits[at] = '\0';
}

static size_t find_equals(char **words, size_t n)
{
    size_t i = 1;

    while (i < n && strcmp(words[i], "=") != 0) {
        i++;
    }
    return i;
}

/* Equal where `want` is not x. */
static bool bits_match(const char *want, const char *got)
{
    while (*want != '\0' && *got != '\0' && (*want == 'x' || *want == *got)) {
        want++;
        got++;
    }
    return *want == *got;
}

/* Bits that come now, as text. */
static void take_bits(struct bench *b, size_t n, char *bits)
{
    for (size_t i = 0; i < n; i++) {
        bits[i] = ssi_rig_take(&b->rig, 1) != 0 ? '1' : '0';
    }
    bits[n] = '\0';
}

/* --- given, shaft, world, power ------------------------------------------------------------ */

/* Exact to 100 ns: rpm * t is split in whole turns and a rest whose product fits 64 bits. */
static dg_angle angle(void *ctx, dg_ns now)
{
    const struct bench *b = ctx;
    const int64_t per_turn = 600000000; /* 100 ns in a minute */
    const int64_t travel = b->rpm * (int64_t)(dg_elapsed(now, b->since) / 100u);

    return b->from + travel / per_turn * DG_TURN + travel % per_turn * DG_TURN / per_turn;
}

/* A word for a number of its own, or a number. */
static uint64_t number(const char *text)
{
    static const char *const words[][4] = {
        {"gray", "binary"}, {"none", "high", "low"}, {"none", "even", "odd"}};

    for (size_t i = 0; i < 3; i++) {
        for (size_t k = 0; k < 4 && words[i][k] != NULL; k++) {
            if (strcmp(text, words[i][k]) == 0) {
                return k;
            }
        }
    }
    return strtoull(text, NULL, 0);
}

/* figure=value @return false when there is none of that name */
static bool set_figure(struct dg_ssi_model *model, const char *word)
{
    const char *equals = strchr(word, '=');
    const struct {
        const char *name;
        uint8_t *byte;
        dg_ns *span;
        dg_ns scale;
    } rows[] = {
        {"mt", &model->multiturn_bits, NULL, 0}, {"st", &model->singleturn_bits, NULL, 0},
        {"code", &model->code, NULL, 0},         {"error", &model->error_bit, NULL, 0},
        {"parity", &model->parity, NULL, 0},     {"monoflop_ns", NULL, &model->monoflop, 1},
        {"init_us", NULL, &model->init, 1000},   {"once", NULL, NULL, 0},
    };

    for (size_t i = 0; equals != NULL && i < DG_COUNT(rows); i++) {
        const uint64_t value = number(equals + 1);

        if (strlen(rows[i].name) != (size_t)(equals - word) ||
            strncmp(rows[i].name, word, strlen(rows[i].name)) != 0) {
            continue;
        }
        if (rows[i].byte != NULL) {
            *rows[i].byte = (uint8_t)value;
        } else if (rows[i].span != NULL) {
            *rows[i].span = value * rows[i].scale;
        } else {
            model->once = value != 0;
        }
        return true;
    }
    return false;
}

/* MODEL figure=value... [window] @return false when there is no such model or figure */
static bool find_model(struct dg_ssi_model *model, char **words, size_t n, struct cf_report *report)
{
    static const struct dg_device *const devices[] = {&dg_ssi_13, &dg_ssi_25, &dg_ssi_28};
    size_t at = 0;

    while (at < 3 && (n < 2 || strcmp(devices[at]->name, words[1]) != 0)) {
        at++;
    }
    if (at == 3) {
        return cf_fail(report, "no such model");
    }
    *model = *dg_ssi_model_of(devices[at]);
    for (size_t i = 2; i < n; i++) {
        if (strcmp(words[i], "window") != 0 && !set_figure(model, words[i])) {
            return cf_fail(report, "no such figure: %s", words[i]);
        }
    }
    return true;
}

static void power_on(struct bench *b, bool window)
{
    if (window) {
        dg_ssi_power_on(&b->rig.device, b->rig.now);
    } else {
        ssi_rig_power_on(&b->rig);
    }
}

/* given MODEL figure=value... [window] */
static bool step_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    struct dg_ssi_model model;

    if (!find_model(&model, words, n, report)) {
        return false;
    }
    *b = (struct bench){.rpm = 0};
    if (ssi_rig_init(&b->rig, &model) != DG_OK) {
        return cf_fail(report, "these figures are refused");
    }
    b->rig.world.angle = angle;
    b->rig.world.angle_ctx = b;
    power_on(b, strcmp(words[n - 1], "window") == 0);
    return true;
}

/* refused MODEL figure=value... */
static bool step_refused(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct dg_ssi_model model;
    struct ssi_rig rig;

    (void)ctx;
    return find_model(&model, words, n, report) &&
           (ssi_rig_init(&rig, &model) == DG_ERR_ARGUMENT || cf_fail(report, "is taken"));
}

/* pos N */
static bool step_pos(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    b->from = n == 2 ? strtoll(words[1], NULL, 0) * (DG_TURN >> b->rig.model.singleturn_bits) : 0;
    b->since = b->rig.now;
    b->rpm = 0;
    return n == 2 || cf_fail(report, "pos N");
}

/* rpm N */
static bool step_rpm(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    b->from = angle(b, b->rig.now);
    b->since = b->rig.now;
    b->rpm = n == 2 ? strtoll(words[1], NULL, 0) : 0;
    return n == 2 || cf_fail(report, "rpm N");
}

/* quantity=value @return false when there is none of that name */
static bool set_quantity(struct dg_world *world, const char *word)
{
    const char *equals = strchr(word, '=');
    const long value = equals != NULL ? strtol(equals + 1, NULL, 0) : 0;
    const struct {
        const char *name;
        bool *truth;
        uint16_t *share;
        int16_t *offset;
        uint32_t *amount;
    } rows[] = {
        {"singleturn_ok", &world->singleturn_ok, NULL, NULL, NULL},
        {"multiturn_amplitude_ok", &world->multiturn_amplitude_ok, NULL, NULL, NULL},
        {"multiturn_sync_ok", &world->multiturn_sync_ok, NULL, NULL, NULL},
        {"multiturn_vector_ok", &world->multiturn_vector_ok, NULL, NULL, NULL},
        {"eeprom_acknowledges", &world->eeprom_acknowledges, NULL, NULL, NULL},
        {"watchdog_fired", &world->watchdog_fired, NULL, NULL, NULL},
        {"sin_amplitude_permille", NULL, &world->sin_amplitude_permille, NULL, NULL},
        {"cos_amplitude_permille", NULL, &world->cos_amplitude_permille, NULL, NULL},
        {"sin_offset_permille", NULL, NULL, &world->sin_offset_permille, NULL},
        {"cos_offset_permille", NULL, NULL, &world->cos_offset_permille, NULL},
        {"led_current_ua", NULL, NULL, NULL, &world->led_current_ua},
        {"supply_mv", NULL, NULL, NULL, &world->supply_mv},
        {"battery_mv", NULL, NULL, NULL, &world->battery_mv},
    };

    if (equals != NULL && strncmp(word, "temperature_mdegc=", 18) == 0) {
        world->temperature_mdegc = (int32_t)value;
        return true;
    }
    for (size_t i = 0; equals != NULL && i < DG_COUNT(rows); i++) {
        if (strlen(rows[i].name) != (size_t)(equals - word) ||
            strncmp(rows[i].name, word, strlen(rows[i].name)) != 0) {
            continue;
        }
        if (rows[i].truth != NULL) {
            *rows[i].truth = value != 0;
        } else if (rows[i].share != NULL) {
            *rows[i].share = (uint16_t)value;
        } else if (rows[i].offset != NULL) {
            *rows[i].offset = (int16_t)value;
        } else {
            *rows[i].amount = (uint32_t)value;
        }
        return true;
    }
    return false;
}

/* world quantity=value... */
static bool step_world(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    for (size_t i = 1; i < n; i++) {
        if (!set_quantity(&b->rig.world, words[i])) {
            return cf_fail(report, "world: no such quantity: %s", words[i]);
        }
    }
    return true;
}

/* power off|on [window] */
static bool step_power(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    if (n > 1 && strcmp(words[1], "on") == 0) {
        power_on(b, n == 3);
    } else {
        dg_ssi_power_off(&b->rig.device);
    }
    return n > 1 || cf_fail(report, "power off|on");
}

/* --- the line ------------------------------------------------------------------------------ */

/* master low=T high=T */
static bool step_master(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    return (n == 3 && strncmp(words[1], "low=", 4) == 0 && strncmp(words[2], "high=", 5) == 0 &&
            span_of(words[1] + 4, &b->rig.low_ns) && span_of(words[2] + 5, &b->rig.high_ns)) ||
           cf_fail(report, "master low=T high=T");
}

/* wait T [L] */
static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    dg_ns span = 0;

    if (n < 2 || !span_of(words[1], &span)) {
        return cf_fail(report, "wait T [L]");
    }
    const bool data = ssi_rig_wait(&b->rig, span);
    return n < 3 || data == (words[2][0] == '1') || cf_fail(report, "data is %d", data ? 1 : 0);
}

/* clock LEVELS = LEVELS */
static bool step_clock(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const size_t equals = find_equals(words, n);
    char levels[BITS_MAX + 1];
    char want[BITS_MAX + 1];

    join(levels, words, 1, equals);
    join(want, words, equals + 1, n);
    for (char *c = levels; *c != '\0'; c++) {
        *c = ssi_rig_edge(&b->rig, *c == '1') ? '1' : '0';
        (void)ssi_rig_wait(&b->rig, 500);
    }
    return bits_match(want, levels) ||
           cf_fail(report, "data: expected %s\n    got            %s", want, levels);
}

/* back T L */
static bool step_back(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    dg_ns span = 0;

    if (n != 3 || !span_of(words[1], &span)) {
        return cf_fail(report, "back T L");
    }
    (void)dg_ssi_clock(&b->rig.device, b->rig.now - span, words[2][0] == '1');
    return true;
}

/* take N = BITS */
static bool step_take(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const size_t bits = n > 3 ? strtoul(words[1], NULL, 10) : 0;
    char want[BITS_MAX + 1];
    char got[BITS_MAX + 1];

    if (bits == 0 || bits > BITS_MAX) {
        return cf_fail(report, "take N = BITS");
    }
    join(want, words, 3, n);
    take_bits(b, bits, got);
    return bits_match(want, got) ||
           cf_fail(report, "take: expected %s\n    got            %s", want, got);
}

/* word [xN] BITS */
static bool step_word(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const bool counted = n > 2 && words[1][0] == 'x';
    unsigned long times = counted ? strtoul(words[1] + 1, NULL, 10) : 1;
    char want[BITS_MAX + 2];
    char got[BITS_MAX + 2];

    join(want, words, counted ? 2 : 1, n);
    strcat(want, "0");
    for (; times > 0; times--) {
        take_bits(b, strlen(want), got);
        if (!bits_match(want, got)) {
            return cf_fail(report, "word: expected %s\n    got            %s", want, got);
        }
    }
    (void)ssi_rig_wait(&b->rig, DG_US(100));
    return n > 1 || cf_fail(report, "word BITS");
}

/* value COUNT|latch[:E] */
static bool step_value(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const struct dg_ssi_model *model = &b->rig.model;
    const char *colon = n == 2 ? strchr(words[1], ':') : NULL;
    const unsigned bits = model->multiturn_bits + model->singleturn_bits;
    uint64_t count = (uint64_t)(angle(b, b->rig.now) >> (32u - model->singleturn_bits));

    if (n != 2) {
        return cf_fail(report, "value COUNT[:E]");
    }
    count = strncmp(words[1], "latch", 5) == 0 ? count : strtoull(words[1], NULL, 16);
    count &= ((uint64_t)1 << bits) - 1u;
    const uint64_t want = ssi_rig_word(model, (uint32_t)count, colon != NULL && colon[1] == '1');
    const uint64_t got = ssi_rig_take(&b->rig, ssi_rig_bits(model) + 1u);
    (void)ssi_rig_wait(&b->rig, DG_US(100));
    return got == want << 1 || cf_fail(report, "value: expected %llX\n    got             %llX",
                                       (unsigned long long)want << 1, (unsigned long long)got);
}

/* --- decoder and counters ------------------------------------------------------------------ */

/* apart BITS = MT ST [error] [damaged] */
static bool step_apart(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const size_t equals = find_equals(words, n);
    struct dg_ssi_frame frame;
    char bits[BITS_MAX + 1];
    bool error = false;
    bool damaged = false;

    if (n < equals + 3) {
        return cf_fail(report, "apart BITS = MT ST");
    }
    for (size_t i = equals + 3; i < n; i++) {
        error = error || strcmp(words[i], "error") == 0;
        damaged = damaged || strcmp(words[i], "damaged") == 0;
    }
    join(bits, words, 1, equals);
    const int result = dg_ssi_frame_decode(&b->rig.model, strtoull(bits, NULL, 2), &frame);
    return (frame.multiturn == strtoul(words[equals + 1], NULL, 16) &&
            frame.singleturn == strtoul(words[equals + 2], NULL, 16) && frame.error == error &&
            result == (damaged ? DG_ERR_DAMAGED : DG_OK)) ||
           cf_fail(report, "apart: got %X %X, error %d, result %d", (unsigned)frame.multiturn,
                   (unsigned)frame.singleturn, frame.error ? 1 : 0, result);
}

/* count frames=N repeats=N aborted=N fast=N */
static bool step_count(void *ctx, char **words, size_t n, struct cf_report *report)
{
    const struct bench *b = ctx;
    const struct dg_ssi_counters *counters = &b->rig.device.counters;
    const struct {
        const char *name;
        uint32_t value;
    } rows[] = {{"frames=", counters->frames},
                {"repeats=", counters->repeats},
                {"aborted=", counters->aborted},
                {"fast=", counters->fast}};

    for (size_t i = 1; i < n; i++) {
        size_t k = 0;

        while (k < 4 && strncmp(words[i], rows[k].name, strlen(rows[k].name)) != 0) {
            k++;
        }
        if (k == 4 || strtoul(words[i] + strlen(rows[k].name), NULL, 10) != rows[k].value) {
            return cf_fail(report, "count: got frames=%u repeats=%u aborted=%u fast=%u",
                           rows[0].value, rows[1].value, rows[2].value, rows[3].value);
        }
    }
    return true;
}

/* --- table --------------------------------------------------------------------------------- */

/* clang-format off */
static const struct cf_step steps[] = {
    {"given", step_given, false, 0}, {"pos",   step_pos,   false, 0}, {"rpm",   step_rpm,   false, 0},
    {"world", step_world, false, 0}, {"power", step_power, false, 0}, {"master", step_master, false, 0},
    {"back",  step_back,  false, 0}, {"wait",  step_wait,  true, 0},  {"clock", step_clock, true, 0},
    {"take",  step_take,  true, 0},  {"word",  step_word,  true, 0},  {"value", step_value, true, 0},
    {"apart", step_apart, true, 0},  {"count", step_count, true, 0},  {"refused", step_refused, true, 0},
};
/* clang-format on */

static void begin(void *ctx)
{
    *(struct bench *)ctx = (struct bench){.rpm = 0};
}

static bool finish(void *ctx, struct cf_report *report)
{
    const struct bench *b = ctx;

    return !b->rig.strayed || cf_fail(report, "data moved on a falling edge");
}

const struct cf_device *cf_ssi(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

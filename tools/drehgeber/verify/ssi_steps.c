/* SPDX-License-Identifier: MIT */
/*
 * Steps of an encoder with SSI, in virtual time. The table at the end lists all steps; ssi.rows
 * explains them. Data must never have moved on a falling edge when a row is over. A real encoder
 * beside the model is asked the same, and judged by what the model has answered.
 */
#include "ssi_steps.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "ssi_rig.h"

#define BITS_MAX CF_SSI_BITS_MAX
/* Between words, and between edges of a step. */
#define PAUSE DG_US(100)
#define EDGE 500u

/* Everything; plain data that begin() sets up. */
struct bench {
    struct ssi_rig rig;
    int64_t from; /* the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm;
    struct cf_ssi_look look; /* the last one */
    unsigned pulses;         /* since the position was stored */
    bool asked;              /* the row has looked at the wire */
    bool turned;             /* the row has said where the shaft is */
};

static struct bench bench;
static struct cf_ssi_trial trial;

/* --- beside the model ---------------------------------------------------------------------- */

void cf_ssi_try(const struct cf_ssi_trial *wanted)
{
    trial = wanted != NULL ? *wanted : (struct cf_ssi_trial){.model = NULL};
}

static bool has_real_one(void)
{
    return trial.beside.ops != NULL;
}

static bool need_of_real(unsigned needs, struct cf_report *report)
{
    return !has_real_one() || needs == 0 ||
           trial.beside.ops->needs(trial.beside.ctx, needs, report);
}

int cf_ssi_bit(const struct cf_ssi_look *look, const struct dg_ssi_model *model, size_t at)
{
    const unsigned bits = dg_ssi_word_bits(model);
    unsigned pulses = look->phase;
    bool low = look->low;

    if (look->clock[0] == '\0') {
        pulses += look->pulses > 0 ? (unsigned)at + 1u : 0u;
    }
    for (size_t i = 0; i <= at && look->clock[i] != '\0'; i++) {
        pulses += low && look->clock[i] == '1' ? 1u : 0u;
        low = look->clock[i] == '0';
    }
    if (pulses == 0) {
        return -1;
    }
    return (int)(model->once && pulses > bits ? bits : (pulses - 1u) % (bits + 1u));
}

/* What is to be looked at, to whoever is asked the same. The model is looked at next. */
static bool ask_look(struct bench *b, enum cf_ssi_kind kind, struct cf_report *report)
{
    const struct cf_unit unit = {
        .id = (uint16_t)kind, .bytes = (const uint8_t *)&b->look, .n = sizeof b->look};

    b->asked = true;
    b->pulses = b->rig.device.state == DG_SSI_SHIFT ? b->pulses : 0;
    b->look.phase = b->pulses;
    b->look.low = !b->rig.device.clock;
    return !has_real_one() || trial.beside.ops->sent(trial.beside.ctx, &unit, report);
}

/* Whether data is what the row expects; of an encoder that is somewhere else all but the position,
   and the parity that goes with it. */
static bool data_match(const struct bench *b, const char *want)
{
    const struct dg_ssi_model *model = &b->rig.model;
    const int position = model->multiturn_bits + model->singleturn_bits;
    const int parity =
        model->parity != DG_SSI_PARITY_NONE ? dg_ssi_word_bits(model) - 1 : position - 1;
    const char *got = b->look.data;
    bool match = strlen(want) == strlen(got);

    for (size_t i = 0; match && want[i] != '\0'; i++) {
        const int bit = cf_ssi_bit(&b->look, model, i);
        const bool own = trial.placed && bit >= 0 && (bit < position || bit == parity);
        match = own || want[i] == 'x' || want[i] == got[i];
    }
    return match;
}

/* @return whether the row goes on, which with nobody beside the model is what `matched` says */
static bool end_look(const struct bench *b, enum cf_ssi_kind kind, bool matched,
                     struct cf_report *report)
{
    const struct cf_unit got = {
        .id = (uint16_t)kind, .bytes = (const uint8_t *)&b->look, .n = sizeof b->look};
    const struct cf_answer answer = {.want = matched ? got : (struct cf_unit){.bytes = NULL},
                                     .got = got};

    return trial.beside.ops->answered(trial.beside.ctx, &answer, report);
}

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

/* `n` pulses, and then the time between words, or not: data is in b->look.data. @return false after
   cf_fail() */
static bool take_pulses(struct bench *b, size_t n, bool rests, struct cf_report *report)
{
    b->look = (struct cf_ssi_look){.pulses = (unsigned)n, .rests = rests};
    if (!ask_look(b, CF_SSI_PULSES, report)) {
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        b->look.data[i] = ssi_rig_take(&b->rig, 1) != 0 ? '1' : '0';
    }
    b->pulses += (unsigned)n;
    if (rests) {
        (void)ssi_rig_wait(&b->rig, PAUSE + 16u * trial.half_ns);
    }
    return true;
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
static uint64_t figure_of_word(const char *text)
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
static bool set_ssi_figure(struct dg_ssi_model *model, const char *word)
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
        const uint64_t value = figure_of_word(equals + 1);

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

/* Whether an encoder in place of the one that a row names has these figures. */
static bool has_figures(const struct dg_ssi_model *own, const struct dg_ssi_model *said)
{
    return own->multiturn_bits == said->multiturn_bits &&
           own->singleturn_bits == said->singleturn_bits && own->code == said->code &&
           own->error_bit == said->error_bit && own->parity == said->parity &&
           own->once == said->once && own->monoflop == said->monoflop && own->init == said->init;
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
    *model = trial.model != NULL ? *trial.model : *dg_ssi_model_of(devices[at]);
    for (size_t i = 2; i < n; i++) {
        if (strcmp(words[i], "window") != 0 && !set_ssi_figure(model, words[i])) {
            return cf_fail(report, "no such figure: %s", words[i]);
        }
    }
    return trial.model == NULL || has_figures(trial.model, model) ||
           cf_fail(report, "about other figures");
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
    const bool window = strcmp(words[n - 1], "window") == 0;
    struct dg_ssi_model model;

    if (!need_of_real(window ? CF_EXACT : 0u, report) || !find_model(&model, words, n, report)) {
        return false;
    }
    *b = (struct bench){.rpm = 0};
    if (ssi_rig_init(&b->rig, &model) != DG_OK) {
        return cf_fail(report, "these figures are refused");
    }
    b->rig.world.angle = angle;
    b->rig.world.angle_ctx = b;
    b->rig.low_ns = trial.half_ns > 0 ? trial.half_ns : b->rig.low_ns;
    b->rig.high_ns = trial.half_ns > 0 ? trial.half_ns : b->rig.high_ns;
    b->from = trial.placed ? trial.raw * (DG_TURN >> model.singleturn_bits) : 0;
    power_on(b, window);
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

/* at N: exactly there */
static bool step_at(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    b->from = n == 2 ? strtoll(words[1], NULL, 0) * (DG_TURN >> b->rig.model.singleturn_bits) : 0;
    b->since = b->rig.now;
    b->rpm = 0;
    return n == 2 || cf_fail(report, "pos N");
}

/* pos N: a real shaft is where it is, which is as good a place as that of a row; but it is not
   turned */
static bool step_pos(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;

    if (!need_of_real(b->asked || b->turned ? CF_SHAFT : 0u, report)) {
        return false;
    }
    b->turned = true;
    return trial.placed || step_at(ctx, words, n, report);
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
        } else if (rows[i].amount != NULL) {
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
    const bool on = n > 1 && strcmp(words[1], "on") == 0;

    if (!need_of_real(n > 2 ? CF_EXACT : 0u, report) ||
        (has_real_one() && !trial.beside.ops->powered(trial.beside.ctx, on, report))) {
        return false;
    }
    if (on) {
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

/* wait T [L]: data that is high later than that is as good, low data has to be looked at in time */
static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    dg_ns span = 0;

    if (n < 2 || !span_of(words[1], &span)) {
        return cf_fail(report, "wait T [L]");
    }
    const bool high = n > 2 && words[2][0] == '1';
    if (n > 2 && !need_of_real(high ? 0u : CF_EXACT, report)) {
        return false;
    }
    b->look = (struct cf_ssi_look){.wait_ns = span};
    if (n > 2 ? !ask_look(b, CF_SSI_LEVEL, report)
              : has_real_one() && !trial.beside.ops->waited(trial.beside.ctx, span, report)) {
        return false;
    }
    b->look.data[0] = ssi_rig_wait(&b->rig, span + trial.slack) ? '1' : '0';
    const bool matched = n < 3 || b->look.data[0] == words[2][0];
    if (n > 2 && has_real_one()) {
        return end_look(b, CF_SSI_LEVEL, matched, report);
    }
    return matched || cf_fail(report, "data is %c", b->look.data[0]);
}

/* clock LEVELS = LEVELS */
static bool step_clock(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const size_t equals = cf_find_equals(words, n);
    char want[BITS_MAX + 1];

    b->look = (struct cf_ssi_look){.pulses = 0};
    cf_join(b->look.clock, BITS_MAX + 1u, words, 1, equals);
    cf_join(want, BITS_MAX + 1u, words, equals + 1, n);
    if (!ask_look(b, CF_SSI_EDGES, report)) {
        return false;
    }
    for (size_t i = 0; b->look.clock[i] != '\0'; i++) {
        const bool level = b->look.clock[i] == '1';

        b->pulses += level && !b->rig.device.clock ? 1u : 0u;
        b->look.data[i] = ssi_rig_edge(&b->rig, level) ? '1' : '0';
        (void)ssi_rig_wait(&b->rig, trial.half_ns > 0 ? trial.half_ns : EDGE);
    }
    const bool matched = data_match(b, want);
    if (has_real_one()) {
        return end_look(b, CF_SSI_EDGES, matched, report);
    }
    return matched ||
           cf_fail(report, "data: expected %s\n    got            %s", want, b->look.data);
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

    if (bits == 0 || bits > BITS_MAX) {
        return cf_fail(report, "take N = BITS");
    }
    cf_join(want, BITS_MAX + 1u, words, 3, n);
    if (!take_pulses(b, bits, false, report)) {
        return false;
    }
    const bool matched = data_match(b, want);
    if (has_real_one()) {
        return end_look(b, CF_SSI_PULSES, matched, report);
    }
    return matched ||
           cf_fail(report, "take: expected %s\n    got            %s", want, b->look.data);
}

/* word [xN] BITS */
static bool step_word(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const bool counted = n > 2 && words[1][0] == 'x';
    unsigned long times = counted ? strtoul(words[1] + 1, NULL, 10) : 1;
    char want[BITS_MAX + 2];

    cf_join(want, BITS_MAX + 1u, words, counted ? 2 : 1, n);
    const size_t length = strlen(want);
    want[length] = '0';
    want[length + 1u] = '\0';
    for (; times > 0; times--) {
        if (!take_pulses(b, strlen(want), times == 1, report)) {
            return false;
        }
        const bool matched = data_match(b, want);
        if (!has_real_one() && !matched) {
            return cf_fail(report, "word: expected %s\n    got            %s", want, b->look.data);
        }
        if (has_real_one() && !end_look(b, CF_SSI_PULSES, matched, report)) {
            return false;
        }
    }
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
    if (!trial.placed && strncmp(words[1], "latch", 5) != 0) {
        count = strtoull(words[1], NULL, 16);
    }
    count &= ((uint64_t)1 << bits) - 1u;
    const uint64_t want = ssi_rig_word(model, (uint32_t)count, colon != NULL && colon[1] == '1');
    if (!take_pulses(b, ssi_rig_bits(model) + 1u, true, report)) {
        return false;
    }
    const uint64_t got = strtoull(b->look.data, NULL, 2);
    if (has_real_one()) {
        return end_look(b, CF_SSI_PULSES, got == want << 1, report);
    }
    return got == want << 1 || cf_fail(report, "value: expected %llX\n    got             %llX",
                                       (unsigned long long)want << 1, (unsigned long long)got);
}

/* --- decoder and counters ------------------------------------------------------------------ */

/* apart BITS = MT ST [error] [damaged] */
static bool step_apart(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const size_t equals = cf_find_equals(words, n);
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
    cf_join(bits, BITS_MAX + 1u, words, 1, equals);
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
    {"given", step_given, false, 0},         {"pos",   step_pos,   false, 0},         {"at",      step_at,      false, CF_SHAFT},
    {"rpm",   step_rpm,   false, CF_SHAFT},  {"world", step_world, false, CF_INSIDE}, {"power",   step_power,   false, CF_POWER},
    {"master", step_master, false, CF_EXACT}, {"back", step_back,  false, CF_INSIDE}, {"wait",    step_wait,    true,  0},
    {"clock", step_clock, true,  0},         {"take",  step_take,  true,  0},         {"word",    step_word,    true,  0},
    {"value", step_value, true,  0},         {"apart", step_apart, true,  CF_INSIDE}, {"count",   step_count,   true,  0},
    {"refused", step_refused, true, CF_INSIDE},
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

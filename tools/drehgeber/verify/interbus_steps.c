/* SPDX-License-Identifier: MIT */
/*
 * Steps of the OCD encoders with INTERBUS, in virtual time: one data cycle a millisecond. The table
 * at the end lists them; interbus.rows explains them. Words are looked at as the master sees them,
 * the ring's as 16-bit images.
 */
#include <stdlib.h>
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "interbus_bench.h"

/* An answer may come so many cycles later than the model's figure says, and has to stay so long. */
#define SLACK 5u
#define STAYS 3u

static struct interbus_bench bench;
static struct cf_interbus_trial trial;

void cf_interbus_try(const struct cf_interbus_trial *wanted)
{
    trial = wanted != NULL ? *wanted : (struct cf_interbus_trial){.model = NULL};
}

const struct cf_interbus_trial *interbus_trial(void)
{
    return &trial;
}

static bool has_beside(void)
{
    return trial.beside.ops != NULL;
}

static bool wait_beside(dg_ns wait, struct cf_report *report)
{
    return !has_beside() || trial.beside.ops->waited(trial.beside.ctx, wait, report);
}

/* What only an encoder that is not asked over its wire alone, or a master of its own, can do. */
static bool need_beside(unsigned needs, struct cf_report *report)
{
    return !has_beside() || trial.beside.ops->needs(trial.beside.ctx, needs, report);
}

/* --- figures by name ----------------------------------------------------------------------- */

/* clang-format off */
#define MODEL(field, kind) CF_FIGURE(#field, dg_ib_model, field, kind)
#define COUNTER(field) CF_FIGURE(#field, dg_ib_counters, field, U32)
static const struct cf_figure model_figures[] = {
    MODEL(steps, U16),  MODEL(turns, U16),   MODEL(steps_minus_one, BOOL), MODEL(temperature_sensor, BOOL),
    MODEL(serial, U32), MODEL(version, U32), MODEL(param_cycles, U8),      MODEL(loop, BOOL),
    CF_FIGURE("self_test_ms", dg_ib_model, self_test, MS),
    {NULL, 0, 0, CF_U8},
};
static const struct cf_figure counters[] = {
    COUNTER(commands), COUNTER(refused), COUNTER(dropped), COUNTER(presets_unset), COUNTER(releases_stale),
    COUNTER(crc_errors),
    {NULL, 0, 0, CF_U8},
};
/* clang-format on */

bool interbus_check_counter(const struct cf_figure *figures, const void *object, char **words,
                            size_t n, struct cf_report *report)
{
    const struct cf_figure *figure =
        n == 3 ? cf_find_figure(figures, words[1], strlen(words[1])) : NULL;
    uint32_t got;

    if (figure == NULL) {
        return cf_fail(report, "no such counter: %s", n > 1 ? words[1] : "");
    }
    memcpy(&got, (const uint8_t *)object + figure->offset, sizeof got);
    return got == strtoul(words[2], NULL, 0) ||
           cf_fail(report, "%s: got %lu", words[1], (unsigned long)got);
}

/* --- time, shaft, words -------------------------------------------------------------------- */

/* Exact to 100 ns: rpm * t is split in whole turns and a rest whose product fits 64 bits. */
static dg_angle shaft_angle(void *ctx, dg_ns now)
{
    const struct interbus_bench *b = ctx;
    const int64_t per_turn = 600000000; /* 100 ns in a minute */
    int64_t travel = b->rpm * (int64_t)(dg_elapsed(now, b->since) / 100u);

    return b->from + travel / per_turn * DG_TURN + travel % per_turn * DG_TURN / per_turn;
}

/* The first angle of that count of the first device, which is exactly on its edge. */
static void set_angle(struct interbus_bench *b, int64_t counts)
{
    b->from = dg_angle_of_counts(counts, b->slaves[0].model->steps);
    b->since = b->now;
    b->rpm = 0;
}

/* Hexadecimal digits of which `.` may be any. */
bool interbus_matches(uint32_t word, const char *pattern, int digits)
{
    char text[9];
    bool good = strlen(pattern) == (size_t)digits;

    (void)snprintf(text, sizeof text, "%0*lX", digits, (unsigned long)word);
    for (size_t i = 0; good && i < (size_t)digits; i++) {
        good = pattern[i] == '.' || pattern[i] == text[i];
    }
    return good;
}

static void cycle(struct interbus_bench *b)
{
    b->now += INTERBUS_CYCLE;
    dg_ib_cycle(b->ib[0], b->now, b->out, &b->in);
}

/* Cycles that nobody looks at. */
static void pass_time(struct interbus_bench *b, dg_ns time)
{
    for (; time >= INTERBUS_CYCLE; time -= INTERBUS_CYCLE) {
        cycle(b);
    }
}

static bool parse_word(const char *text, uint32_t *to)
{
    char *rest;

    *to = (uint32_t)strtoul(text, &rest, 16);
    return rest == text + 8 && *rest == '\0';
}

static bool unexpected(const struct interbus_bench *b, const char *pattern,
                       struct cf_report *report)
{
    return cf_fail(report, "expected %s, got %08lX (OUT is %08lX)", pattern, (unsigned long)b->in,
                   (unsigned long)b->out);
}

/* IN of the model, which the row expects to be `pattern`. */
static bool judge_in(struct interbus_bench *b, const char *pattern, struct cf_report *report)
{
    char text[9];
    uint8_t bytes[2][4];
    const struct cf_answer answer = {.want = {.bytes = bytes[0], .n = sizeof bytes[0]},
                                     .got = {.bytes = bytes[1], .n = sizeof bytes[1]}};
    const bool good = interbus_matches(b->in, pattern, 8);

    if (!has_beside() || strlen(pattern) != 8) {
        return good || unexpected(b, pattern, report);
    }
    (void)snprintf(text, sizeof text, "%08lX", (unsigned long)b->in);
    for (size_t i = 0; i < 8; i++) {
        if (pattern[i] != '.') {
            text[i] = pattern[i];
        }
    }
    dg_store_be32(bytes[0], (uint32_t)strtoul(text, NULL, 16));
    dg_store_be32(bytes[1], b->in);
    return trial.beside.ops->answered(trial.beside.ctx, &answer, report);
}

static bool send_out(struct interbus_bench *b, uint32_t out, struct cf_report *report)
{
    uint8_t bytes[4];
    const struct cf_unit unit = {.bytes = bytes, .n = sizeof bytes};

    b->out = out;
    dg_store_be32(bytes, out);
    return !has_beside() || trial.beside.ops->sent(trial.beside.ctx, &unit, report);
}

/* IN goes straight from what it was to `pattern`, and stays there. */
static bool become_word(struct interbus_bench *b, const char *pattern, struct cf_report *report)
{
    uint32_t before = b->in;
    unsigned patience = b->slaves[0].model->param_cycles + SLACK;

    do {
        cycle(b);
        patience--;
    } while (patience > 0 && b->in == before && !interbus_matches(b->in, pattern, 8));
    /* What stays the same anyway has to outlast the handling of the command. */
    for (unsigned i = 0; i < patience + STAYS && interbus_matches(b->in, pattern, 8); i++) {
        cycle(b);
    }
    pass_time(b, trial.slack);
    return judge_in(b, pattern, report);
}

/* --- words of one device ------------------------------------------------------------------- */

static bool step_out(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    uint32_t out;

    if (n != 2 || !parse_word(words[1], &out)) {
        return cf_fail(report, "not a word");
    }
    if (!send_out(b, out, report)) {
        return false;
    }
    pass_time(b, trial.slack);
    return true;
}

/* in WORD [xN] */
static bool step_in(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    unsigned long times = n == 3 && words[2][0] == 'x' ? strtoul(words[2] + 1, NULL, 10) : 1;

    if (n < 2 || times == 0) {
        return cf_fail(report, "in WORD [xN]");
    }
    do {
        cycle(b);
        times--;
    } while (times > 0 && interbus_matches(b->in, words[1], 8));
    return judge_in(b, words[1], report);
}

static bool step_cycles(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    unsigned long times = n == 2 ? strtoul(words[1], NULL, 10) : 0;

    pass_time(b, times * INTERBUS_CYCLE + trial.slack);
    return times > 0 ? wait_beside(times * INTERBUS_CYCLE, report) : cf_fail(report, "cycles N");
}

/* > OUT IN */
static bool step_command(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    uint32_t out;

    if (n != 3 || !parse_word(words[1], &out)) {
        return cf_fail(report, "> OUT IN");
    }
    return send_out(b, out, report) && become_word(b, words[2], report);
}

/* release IN: 80000000h until IN is there, then back to 0 */
static bool step_release(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    if (n != 2) {
        return cf_fail(report, "release IN");
    }
    return send_out(b, 0x80000000u, report) && become_word(b, words[1], report) &&
           send_out(b, 0, report) && become_word(b, words[1], report);
}

/* read ITEM ANSWER: out of operation and back to it; IN is the same before and behind it */
static bool step_read(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    char before[9];

    (void)snprintf(before, sizeof before, "%08lX", (unsigned long)b->in);
    return step_command(b, words, n, report) && send_out(b, 0, report) &&
           become_word(b, before, report);
}

/* --- the other steps ----------------------------------------------------------------------- */

/* led NAME on|off|blinks */
static bool step_led(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    static const struct {
        const char *name;
        uint8_t bit;
    } leds[] = {
        {"UL", DG_IB_LED_UL}, {"RC", DG_IB_LED_RC}, {"BA", DG_IB_LED_BA}, {"RD", DG_IB_LED_RD}};
    uint8_t lit = dg_ib_leds(b->ib[0], b->now);

    for (size_t i = 0; n == 3 && i < DG_COUNT(leds); i++) {
        if (strcmp(leds[i].name, words[1]) == 0) {
            bool blinks = leds[i].bit == DG_IB_LED_BA && (lit & DG_IB_LED_BA_BLINKS) != 0;
            const char *steady = (lit & leds[i].bit) != 0 ? "on" : "off";

            return strcmp(words[2], blinks ? "blinks" : steady) == 0 ||
                   cf_fail(report, "%s: LEDs are %02X", words[1], lit);
        }
    }
    return cf_fail(report, "led UL|RC|BA|RD on|off|blinks");
}

static bool step_count(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    return interbus_check_counter(counters, &b->ib[0]->counters, words, n, report);
}

static bool step_range(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    uint32_t got = dg_ib_range(b->ib[0]);

    return (n == 2 && got == strtoul(words[1], NULL, 0)) ||
           cf_fail(report, "range: got %lu", (unsigned long)got);
}

static int switch_power(struct interbus_bench *b, bool on)
{
    const int result = dg_host_power(b->slaves[0].encoder, b->now, on);

    if (b->ring != NULL) {
        (void)dg_bus_changed(b->ring, 0, b->now);
    }
    return result;
}

/* power off | power on [test] */
static bool step_power(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    const bool on = n > 1 && strcmp(words[1], "on") == 0;
    const bool test = n > 2 && strcmp(words[2], "test") == 0;
    int result;

    if (!send_out(b, 0, report) || !need_beside(test ? CF_EXACT : 0u, report) ||
        (has_beside() && !trial.beside.ops->powered(trial.beside.ctx, on, report))) {
        return false;
    }
    if (!on) {
        switch_power(b, false);
        b->now += DG_MS(10);
        return true;
    }
    result = switch_power(b, true);
    if (result != 0) {
        return cf_fail(report, "power on returned %d", result);
    }
    if (!test) {
        b->now += b->slaves[0].model->self_test;
        cycle(b);
    }
    return true;
}

/* What the words behind the model say of it. An encoder in place of the one that a row names has
   figures of its own, but what it says of itself is a matter of the row until it is there. */
static bool take_figures(struct interbus_bench *b, struct dg_ib_model *model, char **words,
                         size_t n, struct cf_report *report)
{
    const bool own = trial.model != NULL && b->count == 0;
    struct dg_ib_model said = *model;

    for (size_t i = 2; i < n; i++) {
        if (strncmp(words[i], "raw=", 4) != 0 && strcmp(words[i], "test") != 0 &&
            !cf_set_figure(model_figures, &said, words[i])) {
            return cf_fail(report, "no such figure: %s", words[i]);
        }
    }
    if (own && trial.model->profile != model->profile) {
        return cf_fail(report, "about another profile");
    }
    *model = own ? *trial.model : said;
    if (own && !trial.placed) {
        model->serial = said.serial;
        model->version = said.version;
        model->temperature_sensor = said.temperature_sensor;
    }
    return true;
}

/* Another device on the same shaft, in delivery state, powered. */
static bool add_device(struct interbus_bench *b, char **words, size_t n, struct cf_report *report)
{
    const struct dg_device *device = n > 1 ? dg_device_find(words[1]) : NULL;
    struct interbus_slave *slave = &b->slaves[b->count];

    if (device == NULL || device->stack != &dg_ib_stack || b->count == INTERBUS_DEVICES_MAX) {
        return cf_fail(report, "no such model, or too many");
    }
    slave->encoder = dg_host_init_on_bus(slave->memory, sizeof slave->memory, device, &dg_ib_side);
    slave->model = dg_host_line_of(slave->encoder)->settings;
    *dg_host_world(slave->encoder) = b->world;
    if (!take_figures(b, slave->model, words, n, report)) {
        return false;
    }
    cf_memory_init(&slave->nvm, dg_store_size(&dg_ib_layout));
    const struct dg_nvm nvm = cf_memory_port(&slave->nvm);
    if (dg_host_memory_port(slave->encoder, &nvm) != DG_HOST_OK ||
        dg_host_power(slave->encoder, b->now, true) != DG_HOST_OK) {
        return cf_fail(report, "these figures are refused");
    }
    b->ib[b->count] = dg_host_line_of(slave->encoder)->device;
    b->count++;
    b->ring = NULL;
    return true;
}

/* given MODEL figure=value... [raw=N] [test] */
static bool step_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    bool test = n > 2 && strcmp(words[n - 1], "test") == 0;

    if (b->count > 0) {
        return cf_fail(report, "a row has one `given`");
    }
    if (!need_beside(test ? CF_EXACT : 0u, report) || !add_device(b, words, n, report)) {
        return false;
    }
    for (size_t i = 2; i < n; i++) {
        if (strncmp(words[i], "raw=", 4) == 0) {
            set_angle(b, strtoll(words[i] + 4, NULL, 0));
        }
    }
    if (trial.placed) {
        set_angle(b, trial.raw);
    }
    if (!test) {
        b->now += b->slaves[0].model->self_test;
        cycle(b);
    }
    return true;
}

/* also MODEL figure=value...: one more device behind the others */
static bool step_also(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    bool good = add_device(b, words, n, report);

    b->now += good ? b->slaves[b->count - 1].model->self_test : 0;
    return good;
}

static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    char *unit = NULL;
    unsigned long number = n == 2 ? strtoul(words[1], &unit, 10) : 0;
    bool seconds = n == 2 && strcmp(unit, "s") == 0;

    b->now += seconds ? DG_S(number) : DG_MS(number);
    return (number > 0 && (seconds || strcmp(unit, "ms") == 0)) ||
           cf_fail(report, "wait 5ms or 5s");
}

static bool step_angle(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    if (n != 2) {
        return cf_fail(report, "angle COUNTS");
    }
    set_angle(b, strtoll(words[1], NULL, 0));
    return true;
}

static bool step_rpm(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    b->from = shaft_angle(b, b->now);
    b->since = b->now;
    b->rpm = n == 2 ? strtoll(words[1], NULL, 0) : 0;
    cycle(b);
    return n == 2 || cf_fail(report, "rpm N");
}

static bool step_world(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    for (size_t i = 1; i < n; i++) {
        if (!cf_set_figure(cf_world_figures, &b->world, words[i])) {
            return cf_fail(report, "no such quantity: %s", words[i]);
        }
    }
    for (size_t i = 0; i < b->count; i++) {
        *dg_host_world(b->slaves[i].encoder) = b->world;
    }
    return true;
}

/* damage REGION: a byte that changes by itself */
static bool step_damage(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    int region = n == 2 ? dg_store_find(&dg_ib_layout, words[1]) : -1;

    if (region < 0) {
        return cf_fail(report, "damage REGION");
    }
    b->slaves[0].nvm.bytes[dg_store_address(&dg_ib_layout, (uint8_t)region)] ^= 0x01u;
    return true;
}

/* opc REGISTER BYTE: set by the host */
static bool step_opc(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    unsigned long number = n == 3 ? strtoul(words[1], NULL, 10) : DG_IB_OPC_REGISTERS;

    if (number >= DG_IB_OPC_REGISTERS) {
        return cf_fail(report, "opc REGISTER BYTE");
    }
    b->ib[0]->opc[number] = (uint8_t)strtoul(words[2], NULL, 16);
    return true;
}

/* --- table --------------------------------------------------------------------------------- */

/* clang-format off */
static const struct cf_step steps[] = {
    {"given",     step_given,              false, 0},         {"also",      step_also,               false, CF_RING},
    {"out",       step_out,                false, 0},         {"in",        step_in,                 true,  0},
    {">",         step_command,            true,  0},         {"release",   step_release,            true,  0},
    {"read",      step_read,               true,  0},         {"cycles",    step_cycles,             false, 0},
    {"wait",      step_wait,               false, CF_EXACT},  {"angle",     step_angle,              false, CF_SHAFT},
    {"rpm",       step_rpm,                false, CF_SHAFT},  {"world",     step_world,              false, CF_INSIDE},
    {"power",     step_power,              false, CF_POWER},  {"damage",    step_damage,             false, CF_INSIDE},
    {"opc",       step_opc,                false, CF_INSIDE}, {"count",     step_count,              true,  CF_INSIDE},
    {"range",     step_range,              true,  CF_INSIDE}, {"led",       step_led,                true,  CF_INSIDE},
    {"blink",     interbus_step_blink,     true,  CF_INSIDE}, {"ids",       interbus_step_ids,       true,  0},
    {"data",      interbus_step_data,      true,  CF_RING},   {"break",     interbus_step_break,     false, CF_RING},
    {"corrupt",   interbus_step_corrupt,   false, CF_RING},   {"module",    interbus_step_module,    true,  CF_RING},
    {"cycletime", interbus_step_cycletime, true,  CF_RING},   {"bits",      interbus_step_bits,      true,  CF_RING},
    {"ringcount", interbus_step_ringcount, true,  CF_RING},   {"ringsize",  interbus_step_ringsize,  true,  CF_RING},
};
/* clang-format on */

static void begin(void *ctx)
{
    struct interbus_bench *b = ctx;

    memset(b, 0, sizeof *b);
    b->now = DG_S(1);
    dg_world_init(&b->world);
    b->world.angle = shaft_angle;
    b->world.angle_ctx = b;
}

/* Nothing is left to be seen when a row ends. */
static bool finish(void *ctx, struct cf_report *report)
{
    const struct interbus_bench *b = ctx;

    return b->count > 0 || cf_fail(report, "no device");
}

const struct cf_device *cf_interbus(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

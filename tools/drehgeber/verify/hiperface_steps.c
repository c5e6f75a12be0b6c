/* SPDX-License-Identifier: MIT */
/*
 * Steps of the S36 with RS485, in virtual time. The table at the end lists them; hiperface.rows
 * explains them. Every reply is checked for its moment too: timeout plus reaction time after the
 * request's last character.
 */
#include <stdlib.h>
#include <string.h>

#include "drehgeber/devices.h"
#include "hiperface_steps.h"
#include "row_figures.h"
#include "row_memory.h"

#define REPLIES_MAX 4u
/* Longest request of a row. */
#define REQUEST_MAX 1100u
/* Longer than any timeout (92 ms at 600 Bd) plus reaction time (250 ms). */
#define PATIENCE DG_MS(700)
/* A reply's moment may be off by rounding only. */
#define TOLERANCE DG_US(1)

struct reply {
    uint8_t bytes[DG_HF_FRAME_MAX];
    size_t n;
    dg_ns at;
};

struct bench {
    dg_ns now;
    dg_ns deadline;
    dg_ns request_end; /* end of the last character of the last request */
    uint8_t line;      /* UART setting of the master */
    int64_t from;      /* the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm;
    struct dg_hf_model model;
    struct dg_world world;
    struct cf_memory nvm;
    struct dg_hf hf;
    bool ready; /* `given` has been */
    struct reply replies[REPLIES_MAX];
    size_t reply_count;
    uint8_t request[REQUEST_MAX]; /* what has been sent last */
    size_t request_length;
};

static struct bench bench;
/* What a row is run for; ops NULL: for the model alone. */
static struct cf_hiperface_trial trial;

void cf_hiperface_try(const struct cf_hiperface_trial *wanted)
{
    trial = wanted != NULL ? *wanted : (struct cf_hiperface_trial){.model = NULL};
}

static bool is_beside(void)
{
    return trial.beside.ops != NULL;
}

/* --- figures by name ----------------------------------------------------------------------- */

/* clang-format off */
#define MODEL(field, kind) CF_FIGURE(#field, dg_hf_model, field, kind)
static const struct cf_figure model_figures[] = {
    CF_FIGURE("memory",      dg_hf_model, memory_blocks, U8),
    CF_FIGURE("reaction_ms", dg_hf_model, reaction,      MS),
    CF_FIGURE("init_ms",     dg_hf_model, init,          MS),
    MODEL(periods_per_turn, U16),     MODEL(steps_per_period, U32),     MODEL(turns, U32),
    MODEL(type_code, U8),             MODEL(option_code, U8),           MODEL(serial, TEXT),
    MODEL(version, TEXT),             MODEL(date, TEXT),                MODEL(designation, TEXT),
    MODEL(temperature_channel, U8),   MODEL(led_channel, U8),           MODEL(vector_channel, U8),
    MODEL(temperature_min_degc, I16), MODEL(temperature_max_degc, I16), MODEL(led_min_ma, U16),
    MODEL(led_max_ma, U16),           MODEL(vector_min, U16),           MODEL(vector_max, U16),
    MODEL(speed_max_rpm, U16),        MODEL(acceleration_max_krad_s2, U16),
    MODEL(implemented_blocks, U8),
    {NULL, 0, 0, CF_U8},
};
/* clang-format on */

/* --- time, shaft, wire --------------------------------------------------------------------- */

/* Exact to 100 ns: rpm * t is split in whole turns and a rest whose product fits 64 bits. */
static dg_angle shaft_angle(void *ctx, dg_ns now)
{
    const struct bench *b = ctx;
    const int64_t per_turn = 600000000; /* 100 ns in a minute */
    int64_t travel = b->rpm * (int64_t)(dg_elapsed(now, b->since) / 100u);

    return b->from + travel / per_turn * DG_TURN + travel % per_turn * DG_TURN / per_turn;
}

static void capture(void *ctx, const uint8_t *bytes, size_t n)
{
    struct bench *b = ctx;
    struct reply *reply = &b->replies[b->reply_count % REPLIES_MAX];

    reply->n = n < DG_HF_FRAME_MAX ? n : DG_HF_FRAME_MAX;
    memcpy(reply->bytes, bytes, reply->n);
    reply->at = b->now;
    b->reply_count++;
}

static const struct dg_hf_ops wire = {.tx = capture};

/* Lets the device do what is due until `until`, or until it has replied. */
static void run_until(struct bench *b, dg_ns until, bool stop_at_reply)
{
    while (b->deadline <= until && !(stop_at_reply && b->reply_count > 0)) {
        b->now = b->deadline > b->now ? b->deadline : b->now;
        b->deadline = dg_hf_step(&b->hf, b->now);
    }
    if (!(stop_at_reply && b->reply_count > 0)) {
        b->now = until > b->now ? until : b->now;
    }
}

/* Own decoding of the settings byte (5.1.1.2.4), independent of the device's. */
static uint32_t line_baud(const struct bench *b)
{
    static const uint32_t bauds[8] = {600, 1200, 2400, 4800, 9600, 19200, 38400, 1};

    return bauds[b->line & 7u];
}

static char line_parity(const struct bench *b)
{
    return "N?EO"[b->line >> 4 & 3u];
}

static dg_ns line_bits(const struct bench *b, unsigned bits)
{
    return ((dg_ns)bits * 1000000000u + line_baud(b) - 1u) / line_baud(b);
}

static dg_ns line_character(const struct bench *b)
{
    return line_bits(b, line_parity(b) == 'N' ? 10 : 11);
}

static dg_ns line_timeout(const struct bench *b)
{
    return line_bits(b, (b->line & 0x40u) != 0 ? 44 : 11);
}

/* What arrives at the moment of a deadline comes before it. */
static void receive_character(struct bench *b, dg_ns at, uint8_t byte, int flags)
{
    run_until(b, at - 1, false);
    b->now = at;
    b->deadline = dg_hf_rx(&b->hf, at, byte, (uint8_t)flags);
}

static void send_character(struct bench *b, uint8_t byte, bool damaged)
{
    if (b->request_length < sizeof b->request) {
        b->request[b->request_length++] = byte;
    }
    const struct dg_hf_uart uart = dg_hf_uart(&b->hf);
    bool foreign = uart.baud != line_baud(b) || uart.parity != line_parity(b);
    dg_ns start = b->now;

    receive_character(b, start, 0, DG_HF_RX_START);
    receive_character(b, start + line_character(b), byte,
                      damaged || foreign ? DG_HF_RX_DAMAGED : DG_HF_RX_OK);
}

/* "5ms", "300us", "43b" (bit times of the master's line); 0 when it is none of them. */
static dg_ns span(const struct bench *b, const char *word)
{
    char *unit;
    unsigned long n = strtoul(word, &unit, 10);

    if (strcmp(unit, "ms") == 0) {
        return DG_MS(n);
    }
    if (strcmp(unit, "us") == 0) {
        return DG_US(n);
    }
    return strcmp(unit, "b") == 0 ? line_bits(b, (unsigned)n) : 0;
}

/* --- frames -------------------------------------------------------------------------------- */

struct octet {
    uint8_t value;
    bool damaged;        /* "42!" */
    unsigned long times; /* "FFx16" */
};

static bool parse_octet(const char *word, struct octet *to)
{
    char *rest;

    to->value = (uint8_t)strtoul(word, &rest, 16);
    to->damaged = *rest == '!';
    to->times = *rest == 'x' ? strtoul(rest + 1, &rest, 10) : 1;
    rest += to->damaged ? 1 : 0;
    return rest != word && *rest == '\0' && to->times > 0;
}

/* Sends words[1..]; `sum` appends the XOR. */
static bool send_words(struct bench *b, char **words, size_t n, bool sum, struct cf_report *report)
{
    const struct cf_beside *beside = &trial.beside;
    uint8_t xor = 0;

    b->request_length = 0;
    for (size_t i = 1; i < n; i++) {
        struct octet octet;

        if (is_beside() && strpbrk(words[i], "~!") != NULL &&
            !beside->ops->needs(beside->ctx, CF_EXACT, report)) {
            return false;
        }
        if (words[i][0] == '~' && span(b, words[i] + 1) > 0) {
            run_until(b, b->now + span(b, words[i] + 1), false);
            continue;
        }
        if (!parse_octet(words[i], &octet)) {
            return cf_fail(report, "not a byte: %s", words[i]);
        }
        for (; octet.times > 0; octet.times--) {
            send_character(b, octet.value, octet.damaged);
            xor ^= octet.value;
        }
    }
    if (sum) {
        send_character(b, xor, false);
    }
    const struct cf_unit request = {.bytes = b->request, .n = b->request_length};
    return !is_beside() || beside->ops->sent(beside->ctx, &request, report);
}

static bool step_request(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool good = send_words(b, words, n, words[0][1] == '+', report);

    b->request_end = b->now;
    return good;
}

static bool step_noise(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    return send_words(b, words, n, false, report);
}

static size_t print_hex(char *to, size_t size, const uint8_t *bytes, size_t n)
{
    size_t at = 0;

    for (size_t i = 0; i < n && at + 4 < size; i++) {
        at += (size_t)snprintf(to + at, size - at, " %02X", bytes[i]);
    }
    return at;
}

static bool keep_silent(struct bench *b, dg_ns wait, struct cf_report *report)
{
    char hex[512] = "";

    run_until(b, b->now + (wait > 0 ? wait : PATIENCE), false);
    if (b->reply_count > 0) {
        (void)print_hex(hex, sizeof hex, b->replies[0].bytes, b->replies[0].n);
        return cf_fail(report, "expected no reply, got%s", hex);
    }
    return true;
}

static bool expect_nothing(struct bench *b, dg_ns wait, struct cf_report *report)
{
    return keep_silent(b, wait, report) &&
           (!is_beside() || trial.beside.ops->silent(trial.beside.ctx, wait, report));
}

static bool check_moment(const struct bench *b, const struct reply *got, dg_ns reaction,
                         struct cf_report *report)
{
    dg_ns due = b->request_end + line_timeout(b) + reaction;

    if (dg_elapsed(got->at, due) > TOLERANCE || dg_elapsed(due, got->at) > TOLERANCE) {
        return cf_fail(report, "reply moment: expected %llu ns after the request, got %llu",
                       (unsigned long long)(due - b->request_end),
                       (unsigned long long)(got->at - b->request_end));
    }
    return true;
}

/* The bytes of words[from..], with their XOR behind them when `sum`. */
static bool parse_reply(char **words, size_t from, size_t n, bool sum, struct reply *to,
                        struct cf_report *report)
{
    uint8_t xor = 0;

    to->n = 0;
    for (size_t i = from; i < n; i++) {
        struct octet octet;

        if (!parse_octet(words[i], &octet) || to->n + octet.times >= sizeof to->bytes) {
            return cf_fail(report, "not a byte: %s", words[i]);
        }
        memset(&to->bytes[to->n], octet.value, octet.times);
        to->n += octet.times;
    }
    for (size_t i = 0; sum && i < to->n; i++) {
        xor ^= to->bytes[i];
    }
    to->bytes[to->n] = xor;
    to->n += sum ? 1u : 0u;
    return true;
}

/* The model may answer earlier than the row says, which is about encoders that are slower. */
static bool judge_beside(const struct bench *b, const struct reply *want, const struct reply *got,
                         bool timed, dg_ns reaction, struct cf_report *report)
{
    const struct cf_answer answer = {
        .want = {.bytes = want->bytes, .n = want->n},
        .got = {.bytes = got->n > 0 ? got->bytes : NULL, .n = got->n},
        .latest_ns = line_timeout(b) + reaction,
        .timed = timed,
    };

    if (timed && got->n > 0 && got->at > b->request_end + answer.latest_ns) {
        return cf_fail(report, "the model answers later than that");
    }
    return trial.beside.ops->answered(trial.beside.ctx, &answer, report);
}

/* < none [T] | <[+] [@reaction] bytes */
static bool step_reply(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool timed = n > 1 && words[1][0] == '@';
    dg_ns reaction = timed ? span(b, words[1] + 1) : b->model.reaction;
    char hex[2][700] = {"", ""};
    struct reply want;
    struct reply got;

    if (n > 1 && strcmp(words[1], "none") == 0) {
        return expect_nothing(b, n > 2 ? span(b, words[2]) : 0, report);
    }
    if (!parse_reply(words, timed ? 2 : 1, n, words[0][1] == '+', &want, report)) {
        return false;
    }
    run_until(b, b->now + PATIENCE, true);
    got = b->replies[0];
    got.n = b->reply_count > 0 ? got.n : 0;
    if (is_beside() && !judge_beside(b, &want, &got, timed, reaction, report)) {
        return false;
    }
    (void)print_hex(hex[0], sizeof hex[0], want.bytes, want.n);
    (void)print_hex(hex[1], sizeof hex[1], got.bytes, got.n);
    if (!is_beside() &&
        (b->reply_count != 1 || got.n != want.n || memcmp(got.bytes, want.bytes, want.n) != 0)) {
        return cf_fail(report, "%zu replies; expected%s\n    got     %s", b->reply_count, hex[0],
                       hex[1]);
    }
    b->reply_count = 0;
    /* The master keeps the pause behind the reply that 5.1.1.1 asks for. */
    run_until(b, got.at + got.n * line_character(b) + line_timeout(b) + line_bits(b, 1), false);
    return is_beside() || check_moment(b, &got, reaction, report);
}

/* --- the other steps ----------------------------------------------------------------------- */

static bool switch_on(struct bench *b, bool in_window, struct cf_report *report)
{
    int result = dg_hf_power_on(&b->hf, b->now);

    if (result != 0) {
        return cf_fail(report, "power on returned %d", result);
    }
    b->deadline = dg_hf_step(&b->hf, b->now);
    if (!in_window) {
        run_until(b, b->now + b->model.init + DG_MS(10), false);
    }
    return true;
}

static bool step_power(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool on = n > 1 && strcmp(words[1], "on") == 0;

    if (is_beside() && !trial.beside.ops->powered(trial.beside.ctx, on, report)) {
        return false;
    }
    if (!on) {
        dg_hf_power_off(&b->hf);
        b->deadline = DG_NEVER;
        run_until(b, b->now + DG_MS(10), false);
        return true;
    }
    return switch_on(b, n == 3 && strcmp(words[2], "window") == 0, report);
}

static bool set_angle(struct bench *b, const char *word)
{
    int64_t per_turn = (int64_t)b->model.periods_per_turn * b->model.steps_per_period;
    int64_t count = strtoll(word, NULL, 0);

    /* The first angle of that count: rounded towards plus infinity. */
    int64_t scaled = count % per_turn * DG_TURN;
    b->from = count / per_turn * DG_TURN +
              (scaled > 0 ? (scaled + per_turn - 1) / per_turn : scaled / per_turn);
    b->since = b->now;
    b->rpm = 0;
    return per_turn > 0;
}

static bool step_angle(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    return (n == 3 && set_angle(b, words[1])) || cf_fail(report, "angle N counts");
}

static bool step_rpm(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    b->from = shaft_angle(b, b->now);
    b->since = b->now;
    b->rpm = n == 2 ? strtoll(words[1], NULL, 0) : 0;
    return n == 2 || cf_fail(report, "rpm N");
}

/* The counter of a real encoder may stand anywhere. */
static bool set_counter(struct bench *b, uint32_t count)
{
    const uint8_t bytes[3] = {(uint8_t)(count >> 16), (uint8_t)(count >> 8), (uint8_t)count};
    struct dg_store store;

    return count == 0 || (dg_store_mount(&store, &dg_hf_layout, cf_memory_port(&b->nvm)) == 0 &&
                          dg_store_put(&store, DG_HF_REGION_COUNTER, 0, bytes, sizeof bytes) == 0);
}

/* The encoder of b->model, as delivered, at count `raw`. */
static bool make_device(struct bench *b, const char *raw, bool in_window, struct cf_report *report)
{
    struct dg_hf_setup setup = {&b->model, &b->world, {NULL, NULL}, &wire, b};

    cf_memory_init(&b->nvm, dg_store_size(&dg_hf_layout));
    setup.nvm = cf_memory_port(&b->nvm);
    if (dg_hf_format(&b->model, setup.nvm) != 0 || !set_counter(b, trial.counter) ||
        dg_hf_init(&b->hf, &setup) != 0) {
        return cf_fail(report, "given: these figures are refused");
    }
    b->ready = true;
    return set_angle(b, raw) && switch_on(b, in_window, report);
}

/* The model in place of the one that a row names, and where it is. */
static const char *take_trial(struct bench *b, const char *raw, char *text, size_t size)
{
    if (trial.model == NULL) {
        return raw;
    }
    b->model = *trial.model;
    b->world.temperature_mdegc = trial.temperature_mdegc;
    (void)snprintf(text, size, "%lld", (long long)trial.raw);
    return trial.placed ? text : raw;
}

/* given MODEL key=value... [raw=N] [window] */
static bool step_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const struct dg_device *device = n > 1 ? dg_device_find(words[1]) : NULL;
    const char *raw = "0";
    char text[24];
    bool in_window = false;

    if (device == NULL || device->stack != &dg_hf_stack) {
        return cf_fail(report, "given: no such model");
    }
    b->model = *dg_hf_model_of(device);
    for (size_t i = 2; i < n; i++) {
        if (strcmp(words[i], "window") == 0) {
            in_window = true;
        } else if (strncmp(words[i], "raw=", 4) == 0) {
            raw = words[i] + 4;
        } else if (!cf_set_figure(model_figures, &b->model, words[i])) {
            return cf_fail(report, "given: no such figure: %s", words[i]);
        }
    }
    if (in_window && is_beside() &&
        !trial.beside.ops->needs(trial.beside.ctx, CF_EXACT | CF_POWER, report)) {
        return false;
    }
    return make_device(b, take_trial(b, raw, text, sizeof text), in_window, report);
}

static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    dg_ns wait = n == 2 ? span(b, words[1]) : 0;

    run_until(b, b->now + wait + trial.slack, false);
    if (wait == 0) {
        return cf_fail(report, "wait 5ms, 300us or 43b");
    }
    return !is_beside() || trial.beside.ops->waited(trial.beside.ctx, wait, report);
}

static bool step_world(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    for (size_t i = 1; i < n; i++) {
        if (!cf_set_figure(cf_world_figures, &b->world, words[i])) {
            return cf_fail(report, "world: no such quantity: %s", words[i]);
        }
    }
    if (b->ready) {
        b->deadline = dg_hf_step(&b->hf, b->now);
    }
    return true;
}

static bool step_eeprom(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    b->nvm.silent = n == 2 && strcmp(words[1], "silent") == 0;
    return b->nvm.silent || (n == 2 && strcmp(words[1], "back") == 0) ||
           cf_fail(report, "eeprom silent|back");
}

/* damage REGION OFFSET [MASK]: bytes that change by themselves */
static bool step_damage(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    int region = n >= 3 ? dg_store_find(&dg_hf_layout, words[1]) : -1;
    unsigned long offset = n >= 3 ? strtoul(words[2], NULL, 0) : 0;
    unsigned long mask = n == 4 ? strtoul(words[3], NULL, 16) : 0x01;

    if (region < 0 || offset >= dg_hf_layout.regions[region].size) {
        return cf_fail(report, "damage REGION OFFSET [MASK]");
    }
    offset += dg_store_address(&dg_hf_layout, (uint8_t)region);
    b->nvm.bytes[offset] ^= (uint8_t)mask;
    return true;
}

/* fill REGION BYTE: a good value that would take long to reach over the wire; power is off */
static bool step_fill(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    int region = n == 3 ? dg_store_find(&dg_hf_layout, words[1]) : -1;
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    struct dg_store store;

    if (region < 0 || dg_hf_layout.regions[region].size > sizeof bytes) {
        return cf_fail(report, "fill REGION BYTE");
    }
    memset(bytes, (int)strtoul(words[2], NULL, 16), sizeof bytes);
    if (dg_store_mount(&store, &dg_hf_layout, cf_memory_port(&b->nvm)) != 0 ||
        dg_store_put(&store, (uint8_t)region, 0, bytes, dg_hf_layout.regions[region].size) != 0) {
        return cf_fail(report, "fill: the store refuses");
    }
    return true;
}

static bool step_line(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    b->line = (uint8_t)(n == 2 ? strtoul(words[1], NULL, 16) : 0xE4u);
    return n == 2 || cf_fail(report, "line SETTING");
}

/* uart BAUD PARITY TIMEOUT_BITS: the setting the device uses */
static bool step_uart(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    struct dg_hf_uart uart = dg_hf_uart(&b->hf);

    if (n != 4 || uart.baud != strtoul(words[1], NULL, 10) || uart.parity != words[2][0] ||
        uart.timeout_bits != strtoul(words[3], NULL, 10)) {
        return cf_fail(report, "uart: got %lu %c %u", (unsigned long)uart.baud, uart.parity,
                       (unsigned)uart.timeout_bits);
    }
    return true;
}

/* sincos SIN+ SIN- COS+ COS-: millivolts against ground, to half a millivolt */
static bool step_sincos(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    struct dg_hf_sincos out;
    int32_t got[4];

    dg_hf_sincos(&b->hf, b->now, &out);
    memcpy(got, (int32_t[4]){out.sin_plus_uv, out.sin_minus_uv, out.cos_plus_uv, out.cos_minus_uv},
           sizeof got);
    for (size_t i = 0; i < 4; i++) {
        long want = n == 5 ? strtol(words[i + 1], NULL, 10) * 1000 : 0;

        if (got[i] < want - 500 || got[i] > want + 500) {
            return cf_fail(report, "sincos: got %ld %ld %ld %ld uV", (long)got[0], (long)got[1],
                           (long)got[2], (long)got[3]);
        }
    }
    return true;
}

/* --- table --------------------------------------------------------------------------------- */

/* clang-format off */
static const struct cf_step steps[] = {
    {"given",  step_given,   false, 0},         {">",      step_request, false, 0},
    {">+",     step_request, false, 0},         {"<",      step_reply,   true,  0},
    {"<+",     step_reply,   true,  0},         {"noise",  step_noise,   false, CF_EXACT},
    {"wait",   step_wait,    false, 0},         {"angle",  step_angle,   false, CF_SHAFT},
    {"rpm",    step_rpm,     false, CF_SHAFT},  {"world",  step_world,   false, CF_INSIDE},
    {"eeprom", step_eeprom,  false, CF_INSIDE}, {"damage", step_damage,  false, CF_INSIDE},
    {"fill",   step_fill,    false, CF_INSIDE}, {"power",  step_power,   false, CF_POWER},
    {"line",   step_line,    false, CF_EXACT},  {"uart",   step_uart,    true,  CF_INSIDE},
    {"sincos", step_sincos,  true,  CF_INSIDE},
};
/* clang-format on */

static void begin(void *ctx)
{
    struct bench *b = ctx;

    memset(b, 0, sizeof *b);
    b->now = DG_S(1);
    b->deadline = DG_NEVER;
    b->line = DG_HF_UART_DEFAULT;
    dg_world_init(&b->world);
    b->world.angle = shaft_angle;
    b->world.angle_ctx = b;
}

static bool finish(void *ctx, struct cf_report *report)
{
    return keep_silent(ctx, 0, report) &&
           (!is_beside() || trial.beside.ops->silent(trial.beside.ctx, 1, report));
}

const struct cf_device *cf_hiperface(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

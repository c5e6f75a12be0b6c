/* SPDX-License-Identifier: MIT */
/*
 * Steps of the S36 with RS485, in virtual time. The table at the end lists them; hiperface.rows
 * explains them. Every reply is checked for its moment too: timeout plus reaction time after the
 * request's last character.
 */
#include <stdlib.h>
#include <string.h>

#include "conformance.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "figures.h"
#include "ram_nvm.h"

#define REPLIES_MAX 4u
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
    struct ram_nvm nvm;
    struct dg_hf hf;
    bool ready; /* `given` has been */
    struct reply replies[REPLIES_MAX];
    size_t reply_count;
};

static struct bench bench;

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
static void receive(struct bench *b, dg_ns at, uint8_t byte, int flags)
{
    run_until(b, at - 1, false);
    b->now = at;
    b->deadline = dg_hf_rx(&b->hf, at, byte, (uint8_t)flags);
}

static void send_character(struct bench *b, uint8_t byte, bool damaged)
{
    const struct dg_hf_uart uart = dg_hf_uart(&b->hf);
    bool foreign = uart.baud != line_baud(b) || uart.parity != line_parity(b);
    dg_ns start = b->now;

    receive(b, start, 0, DG_HF_RX_START);
    receive(b, start + line_character(b), byte,
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
    uint8_t xor = 0;

    for (size_t i = 1; i < n; i++) {
        struct octet octet;

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
    return true;
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

static bool expect_nothing(struct bench *b, dg_ns wait, struct cf_report *report)
{
    char hex[512] = "";

    run_until(b, b->now + (wait > 0 ? wait : PATIENCE), false);
    if (b->reply_count > 0) {
        (void)print_hex(hex, sizeof hex, b->replies[0].bytes, b->replies[0].n);
        return cf_fail(report, "expected no reply, got%s", hex);
    }
    return true;
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

/* < none [T] | <[+] [@reaction] bytes */
static bool step_reply(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool timed = n > 1 && words[1][0] == '@';
    dg_ns reaction = timed ? span(b, words[1] + 1) : b->model.reaction;
    uint8_t want[256];
    size_t length = 0;
    char hex[2][700] = {"", ""};
    struct reply got;

    if (n > 1 && strcmp(words[1], "none") == 0) {
        return expect_nothing(b, n > 2 ? span(b, words[2]) : 0, report);
    }
    for (size_t i = timed ? 2 : 1; i < n; i++) {
        struct octet octet;

        if (!parse_octet(words[i], &octet) || length + octet.times >= sizeof want) {
            return cf_fail(report, "not a byte: %s", words[i]);
        }
        memset(&want[length], octet.value, octet.times);
        length += octet.times;
    }
    if (words[0][1] == '+') {
        want[length] = 0;
        for (size_t i = 0; i < length; i++) {
            want[length] ^= want[i];
        }
        length++;
    }
    run_until(b, b->now + PATIENCE, true);
    got = b->replies[0];
    got.n = b->reply_count > 0 ? got.n : 0;
    (void)print_hex(hex[0], sizeof hex[0], want, length);
    (void)print_hex(hex[1], sizeof hex[1], got.bytes, got.n);
    if (b->reply_count != 1 || got.n != length || memcmp(got.bytes, want, length) != 0) {
        return cf_fail(report, "%zu replies; expected%s\n    got     %s", b->reply_count, hex[0],
                       hex[1]);
    }
    b->reply_count = 0;
    /* The master keeps the pause behind the reply that 5.1.1.1 asks for. */
    run_until(b, got.at + got.n * line_character(b) + line_timeout(b) + line_bits(b, 1), false);
    return check_moment(b, &got, reaction, report);
}

/* --- the other steps ----------------------------------------------------------------------- */

static bool step_power(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool on = n > 1 && strcmp(words[1], "on") == 0;
    int result;

    if (!on) {
        dg_hf_power_off(&b->hf);
        b->deadline = DG_NEVER;
        run_until(b, b->now + DG_MS(10), false);
        return true;
    }
    result = dg_hf_power_on(&b->hf, b->now);
    if (result != 0) {
        return cf_fail(report, "power on returned %d", result);
    }
    b->deadline = dg_hf_step(&b->hf, b->now);
    if (n < 3 || strcmp(words[2], "window") != 0) {
        run_until(b, b->now + b->model.init + DG_MS(10), false);
    }
    return true;
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

/* given MODEL key=value... [raw=N] [window] */
static bool step_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const struct dg_device *device = n > 1 ? dg_device_find(words[1]) : NULL;
    struct dg_hf_setup setup = {&b->model, &b->world, {NULL, NULL}, &wire, b};
    char power[] = "power";
    char on[] = "on";
    char window[] = "window";
    char *power_on[] = {power, on, window};
    const char *raw = "0";
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
    ram_nvm_init(&b->nvm, dg_store_size(&dg_hf_layout));
    setup.nvm = ram_nvm_port(&b->nvm);
    if (dg_hf_format(&b->model, setup.nvm) != 0 || dg_hf_init(&b->hf, &setup) != 0) {
        return cf_fail(report, "given: these figures are refused");
    }
    b->ready = true;
    return set_angle(b, raw) && step_power(b, power_on, in_window ? 3 : 2, report);
}

static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    dg_ns wait = n == 2 ? span(b, words[1]) : 0;

    run_until(b, b->now + wait, false);
    return wait > 0 || cf_fail(report, "wait 5ms, 300us or 43b");
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
    b->nvm.no_acknowledge = n == 2 && strcmp(words[1], "silent") == 0;
    return b->nvm.no_acknowledge || (n == 2 && strcmp(words[1], "back") == 0) ||
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
    b->nvm.synced[offset] = b->nvm.bytes[offset];
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
    if (dg_store_mount(&store, &dg_hf_layout, ram_nvm_port(&b->nvm)) != 0 ||
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
    {"given",  step_given,   false}, {">",      step_request, false}, {">+",     step_request, false},
    {"<",      step_reply,   true},  {"<+",     step_reply,   true},  {"noise",  step_noise,   false},
    {"wait",   step_wait,    false}, {"angle",  step_angle,   false}, {"rpm",    step_rpm,     false},
    {"world",  step_world,   false}, {"eeprom", step_eeprom,  false}, {"damage", step_damage,  false},
    {"fill",   step_fill,    false}, {"power",  step_power,   false}, {"line",   step_line,    false},
    {"uart",   step_uart,    true},  {"sincos", step_sincos,  true},
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
    return expect_nothing(ctx, 0, report);
}

const struct cf_device *cf_hiperface(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

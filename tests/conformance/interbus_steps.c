/* SPDX-License-Identifier: MIT */
/*
 * Steps of the OCD encoders with INTERBUS, in virtual time: one data cycle a millisecond. The table
 * at the end lists them; interbus.rows explains them. Words are looked at as the master sees them,
 * the ring's as 16-bit images.
 */
#include <stdalign.h>
#include <stdlib.h>
#include <string.h>

#include "audit.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/devices.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/interbus.h"
#include "ram_nvm.h"
#include "row_figures.h"

#define DEVICES_MAX 4u
#define WORDS_MAX ((size_t)2 * DEVICES_MAX)
#define CYCLE DG_MS(1)
/* An answer may come so many cycles later than the model's figure says, and has to stay so long. */
#define SLACK 5u
#define STAYS 3u

#define MEMORY_MAX 16384u

struct slave {
    alignas(DG_HOST_ALIGN) uint8_t memory[MEMORY_MAX];
    struct dg_host *encoder;
    struct dg_ib_model *model; /* its settings */
    struct ram_nvm nvm;
};

struct bench {
    dg_ns now;
    int64_t from; /* the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm;
    struct dg_world world;
    struct slave slaves[DEVICES_MAX];
    struct dg_ib *ib[DEVICES_MAX]; /* the first is the one that `out` and `in` talk to */
    size_t count;
    alignas(DG_HOST_ALIGN) uint8_t of_ring[MEMORY_MAX];
    struct dg_bus *ring; /* of all devices so far; NULL: it is to be made */
    uint32_t out;
    uint32_t in;               /* last one seen */
    uint16_t image[WORDS_MAX]; /* IN of the ring; a failed cycle leaves it */
};

static struct bench bench;

/* --- figures by name ----------------------------------------------------------------------- */

/* clang-format off */
#define MODEL(field, kind) CF_FIGURE(#field, dg_ib_model, field, kind)
#define COUNTER(field) CF_FIGURE(#field, dg_ib_counters, field, U32)
#define RING(field) CF_FIGURE(#field, dg_ring_counters, field, U32)
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
static const struct cf_figure ring_counters[] = {
    RING(cycles), RING(ids), RING(crc_errors), RING(dead), RING(interrupted),
    {NULL, 0, 0, CF_U8},
};
/* clang-format on */

static bool check_counter(const struct cf_figure *figures, const void *object, char **words,
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
    const struct bench *b = ctx;
    const int64_t per_turn = 600000000; /* 100 ns in a minute */
    int64_t travel = b->rpm * (int64_t)(dg_elapsed(now, b->since) / 100u);

    return b->from + travel / per_turn * DG_TURN + travel % per_turn * DG_TURN / per_turn;
}

/* The first angle of that count of the first device, which is exactly on its edge. */
static void set_angle(struct bench *b, const char *word)
{
    b->from = dg_angle_of_counts(strtoll(word, NULL, 0), b->slaves[0].model->steps);
    b->since = b->now;
    b->rpm = 0;
}

/* Hexadecimal digits of which `.` may be any. */
static bool matches(uint32_t word, const char *pattern, int digits)
{
    char text[9];
    bool good = strlen(pattern) == (size_t)digits;

    (void)snprintf(text, sizeof text, "%0*lX", digits, (unsigned long)word);
    for (size_t i = 0; good && i < (size_t)digits; i++) {
        good = pattern[i] == '.' || pattern[i] == text[i];
    }
    return good;
}

static void cycle(struct bench *b)
{
    b->now += CYCLE;
    dg_ib_cycle(b->ib[0], b->now, b->out, &b->in);
}

static bool parse_word(const char *text, uint32_t *to)
{
    char *rest;

    *to = (uint32_t)strtoul(text, &rest, 16);
    return rest == text + 8 && *rest == '\0';
}

static bool unexpected(const struct bench *b, const char *pattern, struct cf_report *report)
{
    return cf_fail(report, "expected %s, got %08lX (OUT is %08lX)", pattern, (unsigned long)b->in,
                   (unsigned long)b->out);
}

/* IN goes straight from what it was to `pattern`, and stays there. */
static bool become(struct bench *b, const char *pattern, struct cf_report *report)
{
    uint32_t before = b->in;
    unsigned patience = b->slaves[0].model->param_cycles + SLACK;

    do {
        cycle(b);
        patience--;
    } while (patience > 0 && b->in == before && !matches(b->in, pattern, 8));
    /* What stays the same anyway has to outlast the handling of the command. */
    for (unsigned i = 0; i < patience + STAYS && matches(b->in, pattern, 8); i++) {
        cycle(b);
    }
    return matches(b->in, pattern, 8) || unexpected(b, pattern, report);
}

/* --- words of one device ------------------------------------------------------------------- */

static bool step_out(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    return (n == 2 && parse_word(words[1], &b->out)) || cf_fail(report, "not a word");
}

/* in WORD [xN] */
static bool step_in(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    unsigned long times = n == 3 && words[2][0] == 'x' ? strtoul(words[2] + 1, NULL, 10) : 1;
    bool good = n >= 2;

    for (; good && times > 0; times--) {
        cycle(b);
        good = matches(b->in, words[1], 8);
    }
    return good || unexpected(b, n >= 2 ? words[1] : "a word", report);
}

static bool step_cycles(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    unsigned long times = n == 2 ? strtoul(words[1], NULL, 10) : 0;

    for (unsigned long i = 0; i < times; i++) {
        cycle(b);
    }
    return times > 0 || cf_fail(report, "cycles N");
}

/* > OUT IN */
static bool step_command(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    return n == 3 && step_out(b, words, 2, report) ? become(b, words[2], report)
                                                   : cf_fail(report, "> OUT IN");
}

/* release IN: 80000000h until IN is there, then back to 0 */
static bool step_release(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    if (n != 2) {
        return cf_fail(report, "release IN");
    }
    b->out = 0x80000000u;
    if (!become(b, words[1], report)) {
        return false;
    }
    b->out = 0;
    return become(b, words[1], report);
}

/* read ITEM ANSWER: out of operation and back to it; IN is the same before and behind it */
static bool step_read(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    char before[9];

    (void)snprintf(before, sizeof before, "%08lX", (unsigned long)b->in);
    if (!step_command(b, words, n, report)) {
        return false;
    }
    b->out = 0;
    return become(b, before, report);
}

/* --- the ring ------------------------------------------------------------------------------ */

static bool link_ring(struct bench *b)
{
    static const struct dg_bus_ops ops = {.tx = NULL};
    const struct dg_bus_words_setup wire = {sizeof wire, b->image, WORDS_MAX, false};
    const struct dg_bus_setup setup = {sizeof setup, &dg_bus_words, DEVICES_MAX, &wire, &ops, NULL};

    if (b->ring != NULL) {
        return true;
    }
    b->ring = dg_bus_init(b->of_ring, sizeof b->of_ring, &setup);
    for (size_t i = 0; b->ring != NULL && i < b->count; i++) {
        if (dg_bus_attach(b->ring, b->slaves[i].encoder, NULL) != (int)i) {
            b->ring = NULL;
        }
    }
    return b->ring != NULL;
}

/* A cycle; without `out` an ID cycle. */
static const struct dg_ring_state *run(struct bench *b, const uint16_t *out)
{
    const struct dg_tap_event event = {
        .at = b->now,
        .kind = DG_TAP_WORDS,
        .words = {.out = out, .count = dg_ring_state(b->ring)->words, .identify = out == NULL},
    };

    (void)dg_bus_rx(b->ring, &event);
    return dg_ring_state(b->ring);
}

/* ids WORD... */
static bool step_ids(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    uint16_t reached;

    b->now += CYCLE;
    if (!link_ring(b)) {
        return cf_fail(report, "the ring is refused");
    }
    reached = run(b, NULL)->reached;
    for (size_t i = 0; i < reached && i + 1 < n; i++) {
        const uint16_t id = dg_ring_id_word(b->ring, i);
        if (id != strtoul(words[i + 1], NULL, 16)) {
            return cf_fail(report, "ID word %zu: got %04X", i, id);
        }
    }
    return reached + 1u == n || cf_fail(report, "%u devices reached", reached);
}

static bool check_image(const uint16_t *got, size_t length, char **words, size_t n,
                        struct cf_report *report)
{
    char text[WORDS_MAX * sizeof " FFFF"] = "";
    bool good = length == n;
    size_t at = 0;

    for (size_t i = 0; i < length; i++) {
        at += (size_t)snprintf(text + at, sizeof text - at, " %04X", got[i]);
        good = good && matches(got[i], words[i], 4);
    }
    return good || cf_fail(report, "IN image: got%s", text);
}

/* data RESULT OUT... : IN... */
static bool step_data(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    static const char *const results[] = {
        [DG_RING_OK] = "ok",
        [DG_RING_CRC] = "crc",
        [DG_RING_DEAD] = "dead",
        [DG_RING_INTERRUPTED] = "interrupted",
        [DG_RING_IDENTIFY] = "identify",
    };
    uint16_t out[WORDS_MAX] = {0};
    size_t colon = 2;

    while (colon < n && strcmp(words[colon], ":") != 0) {
        colon++;
    }
    const size_t length = link_ring(b) ? dg_ring_state(b->ring)->words : 0;
    if (colon == n || colon != length + 2) {
        return cf_fail(report, "data RESULT OUT... : IN...; the image has %zu words", length);
    }
    for (size_t i = 2; i < colon; i++) {
        out[i - 2] = (uint16_t)strtoul(words[i], NULL, 16);
    }
    b->now += CYCLE;
    const char *result = results[run(b, out)->result];
    if (strcmp(result, words[1]) != 0) {
        return cf_fail(report, "expected %s, got %s", words[1], result);
    }
    return check_image(b->image, length, words + colon + 1, n - colon - 1, report);
}

static bool step_break(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool heal = n == 2 && strcmp(words[1], "none") == 0;

    if (n != 2 || !link_ring(b)) {
        return cf_fail(report, "break N or break none");
    }
    dg_ring_cut(b->ring, heal ? DG_RING_WHOLE : (uint16_t)strtoul(words[1], NULL, 10));
    return true;
}

static bool step_corrupt(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    if (n != 2 || !link_ring(b)) {
        return cf_fail(report, "corrupt N");
    }
    dg_ring_spoil(b->ring, (uint16_t)strtoul(words[1], NULL, 10));
    return true;
}

/* module N: the first device with a module error; -1: none */
static bool step_module(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    long got = 0;

    while (got < (long)b->count && !dg_ib_module_error(b->ib[got])) {
        got++;
    }
    got = got < (long)b->count ? got : -1;
    return (n == 2 && got == strtol(words[1], NULL, 10)) ||
           cf_fail(report, "module error: got %ld", got);
}

/* cycletime BAUD SOFTWARE_US NS */
static bool step_cycletime(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    dg_ns got = 0;

    if (n == 4 && link_ring(b)) {
        got = dg_ib_cycle_time(dg_ring_state(b->ring)->words, (uint32_t)b->count,
                               (uint32_t)strtoul(words[1], NULL, 10),
                               DG_US(strtoul(words[2], NULL, 10)));
    }
    return (n == 4 && got == strtoul(words[3], NULL, 10)) ||
           cf_fail(report, "cycle time: got %llu ns", (unsigned long long)got);
}

/* bits BYTES DEVICES BITS */
static bool step_bits(void *ctx, char **words, size_t n, struct cf_report *report)
{
    uint32_t got = n == 4 ? dg_ib_bit_times((uint32_t)strtoul(words[1], NULL, 10),
                                            (uint32_t)strtoul(words[2], NULL, 10))
                          : 0;

    (void)ctx;
    return (n == 4 && got == strtoul(words[3], NULL, 10)) ||
           cf_fail(report, "bit times: got %lu", (unsigned long)got);
}

static bool step_ringcount(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    return link_ring(b) &&
           check_counter(ring_counters, &dg_ring_state(b->ring)->counters, words, n, report);
}

/* ringsize N ok|refused */
static bool step_ringsize(void *ctx, char **words, size_t n, struct cf_report *report)
{
    size_t count = n == 3 ? strtoul(words[1], NULL, 10) : 0;

    (void)ctx;
    return (n == 3 && (dg_bus_size(&dg_bus_words, count) != 0) == (strcmp(words[2], "ok") == 0)) ||
           cf_fail(report, "a ring of %zu devices is not %s", count, n == 3 ? words[2] : "");
}

/* --- the other steps ----------------------------------------------------------------------- */

/* led NAME on|off|blinks */
static bool step_led(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
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

/* blink ON OFF: how long BA is lit and dark in a second of ID cycles, to a cycle of 20 ms */
static bool step_blink(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const unsigned long period_ms = 20;
    unsigned long lit_ms = 0;
    unsigned long want_ms = n == 3 ? strtoul(words[1], NULL, 10) : 0;

    if (want_ms == 0 || want_ms + strtoul(words[2], NULL, 10) != 1000 || !link_ring(b)) {
        return cf_fail(report, "blink ON OFF, a second together");
    }
    for (unsigned long at_ms = 0; at_ms < 1000; at_ms += period_ms) {
        b->now += DG_MS(period_ms);
        (void)run(b, NULL);
        lit_ms += (dg_ib_leds(b->ib[0], b->now) & DG_IB_LED_BA) != 0 ? period_ms : 0;
    }
    return (lit_ms + period_ms >= want_ms && lit_ms <= want_ms + period_ms) ||
           cf_fail(report, "BA is lit for %lu ms", lit_ms);
}

static bool step_count(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    return check_counter(counters, &b->ib[0]->counters, words, n, report);
}

static bool step_range(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    uint32_t got = dg_ib_range(b->ib[0]);

    return (n == 2 && got == strtoul(words[1], NULL, 0)) ||
           cf_fail(report, "range: got %lu", (unsigned long)got);
}

static int switch_power(struct bench *b, bool on)
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
    struct bench *b = ctx;
    bool on = n > 1 && strcmp(words[1], "on") == 0;
    int result;

    b->out = 0;
    if (!on) {
        switch_power(b, false);
        b->now += DG_MS(10);
        return true;
    }
    result = switch_power(b, true);
    if (result != 0) {
        return cf_fail(report, "power on returned %d", result);
    }
    if (n < 3 || strcmp(words[2], "test") != 0) {
        b->now += b->slaves[0].model->self_test;
        cycle(b);
    }
    return true;
}

/* Another device on the same shaft, in delivery state, powered. */
static bool add_device(struct bench *b, char **words, size_t n, struct cf_report *report)
{
    const struct dg_device *device = n > 1 ? dg_device_find(words[1]) : NULL;
    struct slave *slave = &b->slaves[b->count];

    if (device == NULL || device->stack != &dg_ib_stack || b->count == DEVICES_MAX) {
        return cf_fail(report, "no such model, or too many");
    }
    slave->encoder = dg_host_init_on_bus(slave->memory, sizeof slave->memory, device, &dg_ib_side);
    slave->model = dg_host_line_of(slave->encoder)->settings;
    *dg_host_world(slave->encoder) = b->world;
    for (size_t i = 2; i < n; i++) {
        if (strncmp(words[i], "raw=", 4) != 0 && strcmp(words[i], "test") != 0 &&
            !cf_set_figure(model_figures, slave->model, words[i])) {
            return cf_fail(report, "no such figure: %s", words[i]);
        }
    }
    ram_nvm_init(&slave->nvm, dg_store_size(&dg_ib_layout));
    const struct dg_nvm nvm = ram_nvm_port(&slave->nvm);
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
    struct bench *b = ctx;
    bool test = n > 2 && strcmp(words[n - 1], "test") == 0;

    if (b->count > 0) {
        return cf_fail(report, "a row has one `given`");
    }
    if (!add_device(b, words, n, report)) {
        return false;
    }
    for (size_t i = 2; i < n; i++) {
        if (strncmp(words[i], "raw=", 4) == 0) {
            set_angle(b, words[i] + 4);
        }
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
    struct bench *b = ctx;
    bool good = add_device(b, words, n, report);

    b->now += good ? b->slaves[b->count - 1].model->self_test : 0;
    return good;
}

static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    char *unit = NULL;
    unsigned long number = n == 2 ? strtoul(words[1], &unit, 10) : 0;
    bool seconds = n == 2 && strcmp(unit, "s") == 0;

    b->now += seconds ? DG_S(number) : DG_MS(number);
    return (number > 0 && (seconds || strcmp(unit, "ms") == 0)) ||
           cf_fail(report, "wait 5ms or 5s");
}

static bool step_angle(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    if (n != 2) {
        return cf_fail(report, "angle COUNTS");
    }
    set_angle(b, words[1]);
    return true;
}

static bool step_rpm(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    b->from = shaft_angle(b, b->now);
    b->since = b->now;
    b->rpm = n == 2 ? strtoll(words[1], NULL, 0) : 0;
    cycle(b);
    return n == 2 || cf_fail(report, "rpm N");
}

static bool step_world(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
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
    struct bench *b = ctx;
    int region = n == 2 ? dg_store_find(&dg_ib_layout, words[1]) : -1;
    struct ram_nvm *nvm = &b->slaves[0].nvm;
    uint32_t at;

    if (region < 0) {
        return cf_fail(report, "damage REGION");
    }
    at = dg_store_address(&dg_ib_layout, (uint8_t)region);
    nvm->bytes[at] ^= 0x01u;
    nvm->synced[at] = nvm->bytes[at];
    return true;
}

/* opc REGISTER BYTE: set by the host */
static bool step_opc(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
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
    {"given",     step_given,     false, 0}, {"also",    step_also,     false, 0}, {"out",       step_out,       false, 0},
    {"in",        step_in,        true, 0},  {">",       step_command,  true, 0},  {"release",   step_release,   true, 0},
    {"read",      step_read,      true, 0},  {"cycles",  step_cycles,   false, 0}, {"wait",      step_wait,      false, 0},
    {"angle",     step_angle,     false, 0}, {"rpm",     step_rpm,      false, 0}, {"world",     step_world,     false, 0},
    {"power",     step_power,     false, 0}, {"damage",  step_damage,   false, 0}, {"opc",       step_opc,       false, 0},
    {"count",     step_count,     true, 0},  {"range",   step_range,    true, 0},  {"led",       step_led,       true, 0},
    {"blink",     step_blink,     true, 0},  {"ids",     step_ids,      true, 0},  {"data",      step_data,      true, 0},
    {"break",     step_break,     false, 0}, {"corrupt", step_corrupt,  false, 0}, {"module",    step_module,    true, 0},
    {"cycletime", step_cycletime, true, 0},  {"bits",    step_bits,     true, 0},  {"ringcount", step_ringcount, true, 0},
    {"ringsize",  step_ringsize,  true, 0},
};
/* clang-format on */

static void begin(void *ctx)
{
    struct bench *b = ctx;

    memset(b, 0, sizeof *b);
    b->now = DG_S(1);
    dg_world_init(&b->world);
    b->world.angle = shaft_angle;
    b->world.angle_ctx = b;
}

/* Nothing is left to be seen when a row ends. */
static bool finish(void *ctx, struct cf_report *report)
{
    const struct bench *b = ctx;

    return b->count > 0 || cf_fail(report, "no device");
}

const struct cf_device *cf_interbus(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

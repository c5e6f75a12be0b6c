/* SPDX-License-Identifier: MIT */
/* Steps of a ring with INTERBUS: ID cycles, images of several devices, breaks, times. */
#include <stdlib.h>
#include <string.h>

#include "drehgeber/bits.h"
#include "interbus_bench.h"

/* clang-format off */
#define RING(field) CF_FIGURE(#field, dg_ring_counters, field, U32)
static const struct cf_figure ring_counters[] = {
    RING(cycles), RING(ids), RING(crc_errors), RING(dead), RING(interrupted),
    {NULL, 0, 0, CF_U8},
};
/* clang-format on */

bool interbus_link_ring(struct interbus_bench *b)
{
    static const struct dg_bus_ops ops = {.tx = NULL};
    const struct dg_bus_words_setup wire = {sizeof wire, b->image, INTERBUS_WORDS_MAX, false};
    const struct dg_bus_setup setup = {sizeof setup, &dg_bus_words, INTERBUS_DEVICES_MAX,
                                       &wire,        &ops,          NULL};

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
static const struct dg_ring_state *run_ring(struct interbus_bench *b, const uint16_t *out)
{
    const struct dg_tap_event event = {
        .at = b->now,
        .kind = DG_TAP_WORDS,
        .words = {.out = out, .count = dg_ring_state(b->ring)->words, .identify = out == NULL},
    };

    (void)dg_bus_rx(b->ring, &event);
    return dg_ring_state(b->ring);
}

/* The ID word of the only device. Its messages are for the master of the ring. */
static bool judge_id(struct interbus_bench *b, char **words, size_t n, struct cf_report *report)
{
    const struct cf_beside *beside = &interbus_trial()->beside;
    uint8_t bytes[2][2];
    const struct cf_answer answer = {.want = {CF_INTERBUS_ID, false, bytes[0], sizeof bytes[0]},
                                     .got = {CF_INTERBUS_ID, false, bytes[1], sizeof bytes[1]}};

    if (n != 2) {
        return beside->ops->needs(beside->ctx, CF_RING, report);
    }
    dg_store_be16(bytes[0], (uint16_t)strtoul(words[1], NULL, 16));
    dg_store_be16(bytes[1], dg_ring_id_word(b->ring, 0));
    return beside->ops->needs(beside->ctx, (bytes[0][0] & 0xE0u) != 0 ? CF_RING : 0u, report) &&
           beside->ops->answered(beside->ctx, &answer, report);
}

/* ids WORD... */
bool interbus_step_ids(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    uint16_t reached;

    b->now += INTERBUS_CYCLE;
    if (!interbus_link_ring(b)) {
        return cf_fail(report, "the ring is refused");
    }
    reached = run_ring(b, NULL)->reached;
    if (interbus_trial()->beside.ops != NULL) {
        return judge_id(b, words, n, report);
    }
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
    char text[INTERBUS_WORDS_MAX * sizeof " FFFF"] = "";
    bool good = length == n;
    size_t at = 0;

    for (size_t i = 0; i < length; i++) {
        at += (size_t)snprintf(text + at, sizeof text - at, " %04X", got[i]);
        good = good && interbus_matches(got[i], words[i], 4);
    }
    return good || cf_fail(report, "IN image: got%s", text);
}

/* data RESULT OUT... : IN... */
bool interbus_step_data(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    static const char *const results[] = {
        [DG_RING_OK] = "ok",
        [DG_RING_CRC] = "crc",
        [DG_RING_DEAD] = "dead",
        [DG_RING_INTERRUPTED] = "interrupted",
        [DG_RING_IDENTIFY] = "identify",
    };
    uint16_t out[INTERBUS_WORDS_MAX] = {0};
    size_t colon = 2;

    while (colon < n && strcmp(words[colon], ":") != 0) {
        colon++;
    }
    const size_t length = interbus_link_ring(b) ? dg_ring_state(b->ring)->words : 0;
    if (colon == n || colon != length + 2) {
        return cf_fail(report, "data RESULT OUT... : IN...; the image has %zu words", length);
    }
    for (size_t i = 2; i < colon; i++) {
        out[i - 2] = (uint16_t)strtoul(words[i], NULL, 16);
    }
    b->now += INTERBUS_CYCLE;
    const char *result = results[run_ring(b, out)->result];
    if (strcmp(result, words[1]) != 0) {
        return cf_fail(report, "expected %s, got %s", words[1], result);
    }
    return check_image(b->image, length, words + colon + 1, n - colon - 1, report);
}

bool interbus_step_break(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    bool heal = n == 2 && strcmp(words[1], "none") == 0;

    if (n != 2 || !interbus_link_ring(b)) {
        return cf_fail(report, "break N or break none");
    }
    dg_ring_cut(b->ring, heal ? DG_RING_WHOLE : (uint16_t)strtoul(words[1], NULL, 10));
    return true;
}

bool interbus_step_corrupt(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    if (n != 2 || !interbus_link_ring(b)) {
        return cf_fail(report, "corrupt N");
    }
    dg_ring_spoil(b->ring, (uint16_t)strtoul(words[1], NULL, 10));
    return true;
}

/* module N: the first device with a module error; -1: none */
bool interbus_step_module(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    long got = 0;

    while (got < (long)b->count && !dg_ib_module_error(b->ib[got])) {
        got++;
    }
    got = got < (long)b->count ? got : -1;
    return (n == 2 && got == strtol(words[1], NULL, 10)) ||
           cf_fail(report, "module error: got %ld", got);
}

/* cycletime BAUD SOFTWARE_US NS */
bool interbus_step_cycletime(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    dg_ns got = 0;

    if (n == 4 && interbus_link_ring(b)) {
        got = dg_ib_cycle_time(dg_ring_state(b->ring)->words, (uint32_t)b->count,
                               (uint32_t)strtoul(words[1], NULL, 10),
                               DG_US(strtoul(words[2], NULL, 10)));
    }
    return (n == 4 && got == strtoul(words[3], NULL, 10)) ||
           cf_fail(report, "cycle time: got %llu ns", (unsigned long long)got);
}

/* bits BYTES DEVICES BITS */
bool interbus_step_bits(void *ctx, char **words, size_t n, struct cf_report *report)
{
    uint32_t got = n == 4 ? dg_ib_bit_times((uint32_t)strtoul(words[1], NULL, 10),
                                            (uint32_t)strtoul(words[2], NULL, 10))
                          : 0;

    (void)ctx;
    return (n == 4 && got == strtoul(words[3], NULL, 10)) ||
           cf_fail(report, "bit times: got %lu", (unsigned long)got);
}

bool interbus_step_ringcount(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    return interbus_link_ring(b) &&
           interbus_check_counter(ring_counters, &dg_ring_state(b->ring)->counters, words, n,
                                  report);
}

/* ringsize N ok|refused */
bool interbus_step_ringsize(void *ctx, char **words, size_t n, struct cf_report *report)
{
    size_t count = n == 3 ? strtoul(words[1], NULL, 10) : 0;

    (void)ctx;
    return (n == 3 && (dg_bus_size(&dg_bus_words, count) != 0) == (strcmp(words[2], "ok") == 0)) ||
           cf_fail(report, "a ring of %zu devices is not %s", count, n == 3 ? words[2] : "");
}

/* blink ON OFF: how long BA is lit and dark in a second of ID cycles, to a cycle of 20 ms */
bool interbus_step_blink(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct interbus_bench *b = ctx;
    const unsigned long period_ms = 20;
    unsigned long lit_ms = 0;
    unsigned long want_ms = n == 3 ? strtoul(words[1], NULL, 10) : 0;

    if (want_ms == 0 || want_ms + strtoul(words[2], NULL, 10) != 1000 || !interbus_link_ring(b)) {
        return cf_fail(report, "blink ON OFF, a second together");
    }
    for (unsigned long at_ms = 0; at_ms < 1000; at_ms += period_ms) {
        b->now += DG_MS(period_ms);
        (void)run_ring(b, NULL);
        lit_ms += (dg_ib_leds(b->ib[0], b->now) & DG_IB_LED_BA) != 0 ? period_ms : 0;
    }
    return (lit_ms + period_ms >= want_ms && lit_ms <= want_ms + period_ms) ||
           cf_fail(report, "BA is lit for %lu ms", lit_ms);
}

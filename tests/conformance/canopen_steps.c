/* SPDX-License-Identifier: MIT */
/*
 * Steps of the F36x8 on a CAN bus, in virtual time. The table at the end lists them; canopen.rows
 * explains them. The bench is a port: it delivers only frames that the node's filters ask for, asks
 * for the filters again only when their version has changed, and steps the node at its deadlines
 * only. Every frame the node sends has to be expected, in order; what is left over fails the row.
 */
#include <stdlib.h>
#include <string.h>

#include "canopen_bench.h"
#include "conformance.h"
#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "ram_nvm.h"

#define QUEUE_MAX 600u
/* Longer than the node takes for any answer to an SDO request. */
#define PATIENCE DG_MS(50)

struct bench {
    dg_ns now, deadline;
    int64_t from; /* the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm, ramp; /* the latter in rpm/s */
    const struct dg_device *device;
    struct dg_cia406_model model;
    struct dg_world world;
    struct ram_nvm nvm;
    struct dg_cia406 encoder;
    struct dg_co_node node;
    bool ready;      /* `given` has been */
    bool stuck;      /* the node returned a deadline that does not lie ahead */
    uint8_t node_id; /* whom `read` and `write` talk to */
    uint16_t kbaud;  /* last bit rate the node reported */
    dg_ns late;      /* the next frame is delivered so long after it came in */
    uint8_t filter_version, filter_count;
    uint16_t filters[DG_CO_FILTERS_MAX];
    struct dg_can_frame sent[QUEUE_MAX];
    dg_ns sent_at[QUEUE_MAX];
    size_t sent_count, seen; /* the latter: expected so far */
};

static struct bench bench;

/* --- time, shaft, bus ---------------------------------------------------------------------- */

/* Part of a turn times 2^32: split in whole turns and a rest whose product fits 64 bits. */
static dg_angle turns_of(int64_t figure, int64_t per_turn)
{
    return figure / per_turn * DG_TURN + figure % per_turn * DG_TURN / per_turn;
}

/* Speed is exact to 100 ns, the ramp to 1 ms. A motion has always been: it has a past, too. */
static dg_angle shaft_angle(void *ctx, dg_ns now)
{
    const struct bench *b = ctx;
    const int64_t per_turn = 600000000;      /* 100 ns in a minute */
    const int64_t ramp_per_turn = 120000000; /* 2 * 60 s * 10^6 ms^2/s^2 */
    int64_t ns = (int64_t)(now - b->since);
    int64_t ms = ns / 1000000;

    return b->from + turns_of(b->rpm * (ns / 100), per_turn) +
           turns_of(b->ramp * ms * ms, ramp_per_turn);
}

static void on_send(void *ctx, const struct dg_can_frame *frame)
{
    struct bench *b = ctx;

    if (b->sent_count < QUEUE_MAX) {
        b->sent[b->sent_count] = *frame;
        b->sent_at[b->sent_count] = b->now;
    }
    b->sent_count++;
}

static void on_bit_rate(void *ctx, uint16_t kbaud)
{
    struct bench *b = ctx;

    b->kbaud = kbaud;
}

static const struct dg_co_ops bus = {.send = on_send, .bit_rate = on_bit_rate};

/* A deadline counts from the end of the call that returned it, as a port's timer does. */
static void note_deadline(struct bench *b, dg_ns deadline)
{
    b->stuck = b->stuck || deadline <= b->now;
    b->deadline = deadline;
}

/* Lets the node do what is due until `until`, or until it has sent something. */
static void run_until(struct bench *b, dg_ns until, bool stop_at_frame)
{
    while (b->deadline <= until && !b->stuck && !(stop_at_frame && b->sent_count > b->seen)) {
        b->now = b->deadline;
        note_deadline(b, dg_co_step(&b->node, b->now));
    }
    if (!(stop_at_frame && b->sent_count > b->seen)) {
        b->now = until;
    }
}

static void ask_filters(struct bench *b)
{
    b->filter_version = b->node.filter_version;
    b->filter_count = dg_co_filters(&b->node, b->filters);
}

static void deliver(struct bench *b, const struct dg_can_frame *frame)
{
    if (b->filter_version != b->node.filter_version) {
        ask_filters(b);
    }
    if (b->late > 0) {
        note_deadline(b, dg_co_step(&b->node, b->now));
    }
    for (uint8_t i = 0; i < b->filter_count; i++) {
        if (b->filters[i] == frame->id) {
            note_deadline(b, dg_co_rx(&b->node, b->now - b->late, frame));
        }
    }
    b->late = 0;
}

/* "5ms", "300us", "1s"; 0 when it is none of them. `*end` is what follows. */
static dg_ns span(const char *word, const char **end)
{
    static const struct {
        const char *unit;
        dg_ns ns;
    } units[] = {{"ms", DG_MS(1)}, {"us", DG_US(1)}, {"s", DG_S(1)}};
    char *unit;
    unsigned long n = strtoul(word, &unit, 10);

    for (size_t i = 0; i < DG_COUNT(units); i++) {
        size_t length = strlen(units[i].unit);

        if (strncmp(unit, units[i].unit, length) == 0) {
            *end = unit + length;
            return n * units[i].ns;
        }
    }
    *end = word;
    return 0;
}

/* --- frames -------------------------------------------------------------------------------- */

/* The words are at most 8 bytes in hex. */
static bool parse_bytes(char **words, size_t n, struct dg_can_frame *to, struct cf_report *report)
{
    for (size_t i = 0; i < n; i++) {
        char *rest;
        unsigned long byte = strtoul(words[i], &rest, 16);

        if (rest == words[i] || *rest != '\0' || byte > 0xFF || to->dlc == 8) {
            return cf_fail(report, "not a byte, or one too many: %s", words[i]);
        }
        to->data[to->dlc++] = (uint8_t)byte;
    }
    return true;
}

static bool parse_id(const char *word, struct dg_can_frame *to, struct cf_report *report)
{
    char *rest;
    unsigned long id = strtoul(word, &rest, 16);

    to->id = (uint16_t)id;
    return (rest != word && *rest == '\0' && id <= 0x7FF) ||
           cf_fail(report, "not a CAN-ID: %s", word);
}

/* > ID BYTES: SDO and LSS requests are filled up to 8 bytes; >! ID BYTES: as it stands */
static bool step_data(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    struct dg_can_frame frame = {0};
    bool padded;

    if (n < 2) {
        return cf_fail(report, "> ID BYTES");
    }
    if (!parse_id(words[1], &frame, report) || !parse_bytes(&words[2], n - 2, &frame, report)) {
        return false;
    }
    padded = (frame.id >= 0x600 && frame.id <= 0x67F) || frame.id == 0x7E5;
    if (padded && words[0][1] != '!') {
        frame.dlc = 8;
    }
    deliver(b, &frame);
    return true;
}

/* rtr ID */
static bool step_rtr(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    struct dg_can_frame frame = {.rtr = true};

    if (n != 2) {
        return cf_fail(report, "rtr ID");
    }
    if (!parse_id(words[1], &frame, report)) {
        return false;
    }
    deliver(b, &frame);
    return true;
}

static void print_frame(char *to, size_t size, const struct dg_can_frame *frame)
{
    size_t at = (size_t)snprintf(to, size, "%03X%s", frame->id, frame->rtr ? " rtr" : "");

    for (uint8_t i = 0; i < frame->dlc && at < size; i++) {
        at += (size_t)snprintf(to + at, size - at, " %02X", frame->data[i]);
    }
}

/* The next frame the node sent, or NULL. */
static const struct dg_can_frame *next_frame(const struct bench *b)
{
    return b->seen < b->sent_count && b->seen < QUEUE_MAX ? &b->sent[b->seen] : NULL;
}

static bool expect_nothing(struct bench *b, dg_ns wait, struct cf_report *report)
{
    dg_ns from = b->now;
    char got[64];

    run_until(b, b->now + wait, true);
    if (b->stuck) {
        return cf_fail(report, "the node wants to be stepped at once, again and again");
    }
    if (next_frame(b) != NULL) {
        print_frame(got, sizeof got, next_frame(b));
        return cf_fail(report, "expected nothing, got %s after %llu ns", got,
                       (unsigned long long)(b->now - from));
    }
    return true;
}

static bool expect_frame(struct bench *b, const struct dg_can_frame *want, struct cf_report *report)
{
    const struct dg_can_frame *got = next_frame(b);
    char hex[2][64] = {"", "nothing"};

    print_frame(hex[0], sizeof hex[0], want);
    if (got != NULL) {
        print_frame(hex[1], sizeof hex[1], got);
    }
    if (got == NULL || got->id != want->id || got->rtr != want->rtr || got->dlc != want->dlc ||
        memcmp(got->data, want->data, want->dlc) != 0) {
        return cf_fail(report, "expected %s\n    got      %s", hex[0], hex[1]);
    }
    b->seen++;
    return true;
}

/* "@10ms" or "@13ms..15ms": the next frame is sent then, counted from now, and not earlier. */
static bool run_to_frame(struct bench *b, const char *word, struct cf_report *report)
{
    const char *rest;
    dg_ns from = b->now;
    dg_ns earliest = span(word + 1, &rest);
    dg_ns latest = earliest;
    dg_ns at;

    if (strncmp(rest, "..", 2) == 0) {
        latest = span(rest + 2, &rest);
    }
    if (earliest == 0 || latest < earliest || *rest != '\0') {
        return cf_fail(report, "not a moment: %s", word);
    }
    run_until(b, from + latest, true);
    at = next_frame(b) != NULL ? b->sent_at[b->seen] : DG_NEVER;
    return (at >= from + earliest && at <= from + latest) ||
           cf_fail(report, "expected a frame %s, got one after %lld ns", word,
                   at == DG_NEVER ? -1LL : (long long)(at - from));
}

/* < [@T] ID BYTES | < none [T] */
static bool step_expect(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    struct dg_can_frame want = {0};
    bool timed = n > 1 && words[1][0] == '@';
    size_t at = timed ? 2 : 1;
    const char *rest;

    if (n > 1 && strcmp(words[1], "none") == 0) {
        return expect_nothing(b, n > 2 ? span(words[2], &rest) : 0, report);
    }
    if (n <= at) {
        return cf_fail(report, "< [@T] ID BYTES, or < none [T]");
    }
    return parse_id(words[at], &want, report) &&
           parse_bytes(&words[at + 1], n - at - 1, &want, report) &&
           (!timed || run_to_frame(b, words[1], report)) && expect_frame(b, &want, report);
}

/* skip N: exactly N frames wait to be expected; what they say is proved elsewhere */
static bool step_skip(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    size_t want = n == 2 ? strtoul(words[1], NULL, 10) : 0;

    if (b->sent_count - b->seen != want) {
        return cf_fail(report, "skip: %zu frames are there", b->sent_count - b->seen);
    }
    b->seen = b->sent_count;
    return true;
}

/* --- expedited SDO ------------------------------------------------------------------------- */

/* "1018:1" */
static bool parse_object(const char *word, struct dg_can_frame *to, struct cf_report *report)
{
    char *rest;
    unsigned long index = strtoul(word, &rest, 16);
    unsigned long sub = *rest == ':' ? strtoul(rest + 1, &rest, 16) : 0x100;

    if (index > 0xFFFF || sub > 0xFF || *rest != '\0') {
        return cf_fail(report, "not an object: %s", word);
    }
    dg_store_le16(&to->data[1], (uint16_t)index);
    to->data[3] = (uint8_t)sub;
    to->dlc = 4;
    return true;
}

/* read INDEX:SUB and write INDEX:SUB BYTES, each with the answer expected: BYTES, nothing, or
 * `abort CODE`. Bytes are those on the wire. */
static bool step_sdo(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool reads = strcmp(words[0], "read") == 0;
    bool aborts = n >= 4 && strcmp(words[n - 2], "abort") == 0;
    size_t given = n < 2 ? 0 : n - 2 - (aborts ? 2u : 0u);
    struct dg_can_frame request = {.id = (uint16_t)(0x600u + b->node_id)};
    struct dg_can_frame answer = {.id = (uint16_t)(0x580u + b->node_id)};

    if (n < 2 || given > 4 || (given == 0) != (reads && aborts)) {
        return cf_fail(report, "read INDEX:SUB BYTES, write INDEX:SUB BYTES [abort CODE]");
    }
    if (!parse_object(words[1], &request, report)) {
        return false;
    }
    memcpy(answer.data, request.data, 4);
    answer.dlc = 4;
    if (!parse_bytes(&words[2], given, reads ? &answer : &request, report)) {
        return false;
    }
    request.dlc = 8;
    answer.dlc = 8;
    request.data[0] = reads ? 0x40u : (uint8_t)(0x23u | (4u - given) << 2);
    answer.data[0] = reads ? (uint8_t)(0x43u | (4u - given) << 2) : 0x60u;
    if (aborts) {
        answer.data[0] = 0x80;
        dg_store_le32(&answer.data[4], (uint32_t)strtoul(words[n - 1], NULL, 16));
    }
    deliver(b, &request);
    run_until(b, b->now + PATIENCE, true);
    return expect_frame(b, &answer, report);
}

/* --- the other steps ----------------------------------------------------------------------- */

static bool power_on(struct bench *b, struct cf_report *report)
{
    const struct dg_co_setup setup = {
        .device = b->model.device,
        .world = &b->world,
        .nvm = ram_nvm_port(&b->nvm),
        .ops = &bus,
        .ctx = b,
        .application = &b->encoder,
    };
    const bool absent = b->node.bus_absent;

    if (dg_cia406_init(&b->encoder, &b->model) != 0 || dg_co_init(&b->node, &setup) != 0) {
        return cf_fail(report, "the node cannot be made");
    }
    if (absent) {
        (void)dg_co_bus(&b->node, b->now, DG_CO_BUS_ABSENT);
    }
    if (dg_co_power_on(&b->node, b->now) != 0) {
        return cf_fail(report, "the node does not start");
    }
    note_deadline(b, dg_co_step(&b->node, b->now));
    ask_filters(b);
    return true;
}

/* power on|off; the memory keeps what it has */
static bool step_power(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    if (n == 2 && strcmp(words[1], "on") == 0) {
        return power_on(b, report);
    }
    dg_co_power_off(&b->node);
    b->deadline = DG_NEVER;
    run_until(b, b->now + DG_MS(10), false);
    return n == 2 && strcmp(words[1], "off") == 0 ? true : cf_fail(report, "power on|off");
}

/* given MODEL [serial=N] [turns=65536] [boot] */
static bool step_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const struct dg_device *device = n > 1 ? dg_device_find(words[1]) : NULL;
    uint32_t serial = 1234567890;
    bool keep = false;

    if (device == NULL || device->stack != &dg_cia406_stack) {
        return cf_fail(report, "given: no such model");
    }
    b->device = device;
    b->model = *dg_cia406_model_of(device);
    for (size_t i = 2; i < n; i++) {
        if (strncmp(words[i], "serial=", 7) == 0) {
            serial = (uint32_t)strtoul(words[i] + 7, NULL, 10);
        } else if (strcmp(words[i], "turns=65536") == 0) {
            b->model.turns = 65536;
            b->model.device = &dg_cia406_multiturn_32;
        } else if (strcmp(words[i], "boot") == 0) {
            keep = true;
        } else {
            return cf_fail(report, "given: no such figure: %s", words[i]);
        }
    }
    b->model.device = canopen_from_eds(b->model.device); /* if that is wanted */
    ram_nvm_init(&b->nvm, dg_store_size(b->model.device->layout));
    if (dg_co_format(b->model.device, ram_nvm_port(&b->nvm), serial) != 0) {
        return cf_fail(report, "given: the memory cannot be formatted");
    }
    b->ready = power_on(b, report);
    b->seen = keep ? 0 : b->sent_count;
    return b->ready;
}

static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const char *rest = "";
    dg_ns wait = n == 2 ? span(words[1], &rest) : 0;

    run_until(b, b->now + wait, false);
    return (wait > 0 && *rest == '\0') || cf_fail(report, "wait 5ms, 300us or 1s");
}

/* late T: a busy port delivers the next frame T after it came in */
static bool step_late(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const char *rest = "";

    b->late = n == 2 ? span(words[1], &rest) : 0;
    return (b->late > 0 && *rest == '\0') || cf_fail(report, "late 5ms, 300us or 1s");
}

/* turn 90DEG | turn 1000: to this angle, in degrees or in counts of 65536 a turn */
static bool step_turn(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    char *unit = NULL;
    int64_t figure = n == 2 ? strtoll(words[1], &unit, 10) : 0;
    int64_t per_turn = unit != NULL && strcmp(unit, "DEG") == 0 ? 360 : 65536;

    b->from = turns_of(figure, per_turn);
    b->since = b->now;
    b->rpm = 0;
    b->ramp = 0;
    return (unit != NULL && (*unit == '\0' || per_turn == 360)) || cf_fail(report, "turn 90DEG");
}

/* rpm N | ramp N: N rpm, or from standstill N rpm a second */
static bool step_rpm(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    int64_t figure = n == 2 ? strtoll(words[1], NULL, 10) : 0;
    bool ramp = strcmp(words[0], "ramp") == 0;

    b->from = shaft_angle(b, b->now);
    b->since = b->now;
    b->rpm = ramp ? 0 : figure;
    b->ramp = ramp ? figure : 0;
    return n == 2 || cf_fail(report, "rpm N | ramp N");
}

/* world QUANTITY N: a cause, in the unit of dg_world; bits are 0 and 1 */
static bool step_world(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    struct dg_world *world = &b->world;
    const struct {
        const char *name;
        uint32_t *figure;
        bool *bit;
    } quantities[] = {
        {"temperature_mdegc", (uint32_t *)&world->temperature_mdegc, NULL},
        {"battery_mv", &world->battery_mv, NULL},
        {"led_current_ua", &world->led_current_ua, NULL},
        {"singleturn_ok", NULL, &world->singleturn_ok},
        {"multiturn_amplitude_ok", NULL, &world->multiturn_amplitude_ok},
        {"multiturn_sync_ok", NULL, &world->multiturn_sync_ok},
        {"multiturn_vector_ok", NULL, &world->multiturn_vector_ok},
        {"eeprom_acknowledges", NULL, &world->eeprom_acknowledges},
        {"watchdog_fired", NULL, &world->watchdog_fired},
    };
    const size_t count = DG_COUNT(quantities);
    long value = n == 3 ? strtol(words[2], NULL, 10) : 0;
    size_t i = 0;

    while (i < count && (n != 3 || strcmp(quantities[i].name, words[1]) != 0)) {
        i++;
    }
    if (i == count) {
        return cf_fail(report, "world QUANTITY N");
    }
    if (quantities[i].bit == NULL) {
        *quantities[i].figure = (uint32_t)value;
        return true;
    }
    *quantities[i].bit = value != 0;
    return true;
}

/* --- LEDs ---------------------------------------------------------------------------------- */

static struct dg_cia406_leds look(struct bench *b)
{
    note_deadline(b, dg_co_step(&b->node, b->now));
    return dg_cia406_leds(&b->node);
}

static bool lit(struct bench *b, bool red)
{
    struct dg_cia406_leds leds = look(b);

    return red ? leds.err : leds.bus;
}

/* How long the LED stays as it is, at most 3 s. Leaves the bench at the change. */
static dg_ns until_change(struct bench *b, bool red)
{
    dg_ns from = b->now;
    bool first = lit(b, red);

    while (lit(b, red) == first && b->now < from + DG_S(3)) {
        run_until(b, b->now + DG_MS(1), false);
    }
    return b->now - from;
}

/* led bus|err on|off|T: lit, dark, or T lit and T dark */
static bool step_led(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool red = n == 3 && strcmp(words[1], "err") == 0;
    const char *rest;
    dg_ns want = n == 3 ? span(words[2], &rest) : 0;
    bool on = n == 3 && strcmp(words[2], "on") == 0;

    if (n != 3 || (want == 0 && !on && strcmp(words[2], "off") != 0)) {
        return cf_fail(report, "led bus|err on|off|T");
    }
    if (want > 0) {
        (void)until_change(b, red);
        return (until_change(b, red) == want && until_change(b, red) == want) ||
               cf_fail(report, "led: it does not change after %s", words[2]);
    }
    return lit(b, red) == on || cf_fail(report, "led: it is not %s", words[2]);
}

/* leds together|apart: both in the same phase, or in opposite phase, for half a second */
static bool step_leds(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    bool together = n == 2 && strcmp(words[1], "together") == 0;
    bool held = together || (n == 2 && strcmp(words[1], "apart") == 0);

    for (int i = 0; i < 500 && held; i++) {
        struct dg_cia406_leds leds = look(b);

        held = (leds.bus == leds.err) == together;
        run_until(b, b->now + DG_MS(1), false);
    }
    return held || cf_fail(report, "leds together|apart: they are not");
}

/* bus off|active|passive|overrun|absent|present: what the CAN controller reports, and whether there
 * is a bus; what is said of that without power holds when the power comes */
static bool step_bus(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    static const struct {
        const char *word;
        enum dg_co_bus_event event;
    } events[] = {
        {"active", DG_CO_BUS_ACTIVE}, {"passive", DG_CO_BUS_PASSIVE},
        {"off", DG_CO_BUS_OFF},       {"overrun", DG_CO_BUS_OVERRUN},
        {"absent", DG_CO_BUS_ABSENT}, {"present", DG_CO_BUS_PRESENT},
    };

    for (size_t i = 0; n == 2 && i < DG_COUNT(events); i++) {
        if (strcmp(words[1], events[i].word) == 0) {
            note_deadline(b, dg_co_bus(&b->node, b->now, events[i].event));
            return true;
        }
    }
    return cf_fail(report, "bus off|active|passive|overrun|absent|present");
}

static bool step_eeprom(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    b->nvm.no_acknowledge = n == 2 && strcmp(words[1], "silent") == 0;
    return b->nvm.no_acknowledge || (n == 2 && strcmp(words[1], "back") == 0) ||
           cf_fail(report, "eeprom silent|back");
}

/* damage REGION OFFSET [MASK] | stored REGION OFFSET BYTES: what has happened to the memory */
static bool step_memory(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    const struct dg_store_layout *layout = b->model.device->layout;

    return words[0][0] == 'd' ? canopen_damage(&b->nvm, layout, words, n, report)
                              : canopen_stored(&b->nvm, layout, words, n, report);
}

/* eds SECTION KEY VALUE|none: a line of the EDS file */
static bool step_eds(void *ctx, char **words, size_t n, struct cf_report *report)
{
    const struct bench *b = ctx;

    return canopen_eds(b->device, words, n, report);
}

/* node ID: whom `read` and `write` talk to from now on */
static bool step_node(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    b->node_id = (uint8_t)(n == 2 ? strtoul(words[1], NULL, 16) : 0);
    return b->node_id != 0 || cf_fail(report, "node ID");
}

/* rate KBAUD: the bit rate in force */
static bool step_rate(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct bench *b = ctx;
    return (n == 2 && strtoul(words[1], NULL, 10) == b->kbaud) ||
           cf_fail(report, "rate: got %u kBd", (unsigned)b->kbaud);
}

/* --- table --------------------------------------------------------------------------------- */

/* clang-format off */
static const struct cf_step steps[] = {
    {"given", step_given, false}, {">",     step_data,   false}, {">!",     step_data,   false},
    {"<",     step_expect, true}, {"skip",  step_skip,   true},  {"rtr",    step_rtr,    false},
    {"read",  step_sdo,   true},  {"write", step_sdo,    true},  {"wait",   step_wait,   false},
    {"turn",  step_turn,  false}, {"rpm",   step_rpm,    false}, {"bus",    step_bus,    false},
    {"power", step_power, false}, {"eeprom", step_eeprom, false}, {"damage", step_memory, false},
    {"node",  step_node,  false}, {"rate",  step_rate,   true},  {"late",  step_late,   false},
    {"ramp",  step_rpm,  false}, {"world", step_world,  false}, {"led",    step_led,    true},
    {"leds",  step_leds,  true},  {"stored", step_memory, false}, {"eds", step_eds, true},
};
/* clang-format on */

static void begin(void *ctx)
{
    struct bench *b = ctx;

    memset(b, 0, sizeof *b);
    b->now = DG_S(1);
    b->deadline = DG_NEVER;
    b->node_id = 0x3F;
    dg_world_init(&b->world);
    b->world.angle = shaft_angle;
    b->world.angle_ctx = b;
}

static bool finish(void *ctx, struct cf_report *report)
{
    return expect_nothing(ctx, 0, report);
}

const struct cf_device *cf_canopen(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

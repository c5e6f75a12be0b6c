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
#include "drehgeber/bits.h"

/* Longer than the node takes for any answer to an SDO request. */
#define PATIENCE DG_MS(50)

static struct canopen_bench bench;
/* What a row is run for; ops NULL: for the model alone. */
static struct cf_canopen_trial trial;
static const struct dg_co_device *(*made_of)(const struct dg_co_device *device);

void cf_canopen_make(const struct dg_co_device *(*make)(const struct dg_co_device *device))
{
    made_of = make;
}

void cf_canopen_try(const struct cf_canopen_trial *wanted)
{
    trial = wanted != NULL ? *wanted : (struct cf_canopen_trial){.device = NULL};
}

static bool is_beside(void)
{
    return trial.beside.ops != NULL;
}

static struct cf_unit unit_of(const struct dg_can_frame *frame)
{
    return (struct cf_unit){frame->id, frame->rtr, frame->data, frame->dlc};
}

/* --- time, shaft, bus ---------------------------------------------------------------------- */

/* Part of a turn times 2^32: split in whole turns and a rest whose product fits 64 bits. */
static dg_angle turns_of(int64_t figure, int64_t per_turn)
{
    return figure / per_turn * DG_TURN + figure % per_turn * DG_TURN / per_turn;
}

/* Speed is exact to 100 ns, the ramp to 1 ms. A motion has always been: it has a past, too. */
static dg_angle shaft_angle(void *ctx, dg_ns now)
{
    const struct canopen_bench *b = ctx;
    const int64_t per_turn = 600000000;      /* 100 ns in a minute */
    const int64_t ramp_per_turn = 120000000; /* 2 * 60 s * 10^6 ms^2/s^2 */
    int64_t ns = (int64_t)(now - b->since);
    int64_t ms = ns / 1000000;

    return b->from + turns_of(b->rpm * (ns / 100), per_turn) +
           turns_of(b->ramp * ms * ms, ramp_per_turn);
}

static void on_send(void *ctx, const struct dg_can_frame *frame)
{
    struct canopen_bench *b = ctx;

    if (b->sent_count < CANOPEN_QUEUE_MAX) {
        b->sent[b->sent_count] = *frame;
        b->sent_at[b->sent_count] = b->now;
    }
    b->sent_count++;
}

static void on_bit_rate(void *ctx, uint16_t kbaud)
{
    struct canopen_bench *b = ctx;

    b->kbaud = kbaud;
}

static const struct dg_co_ops bus = {.send = on_send, .bit_rate = on_bit_rate};

/* A deadline counts from the end of the call that returned it, as a port's timer does. */
void canopen_note_deadline(struct canopen_bench *b, dg_ns deadline)
{
    b->stuck = b->stuck || deadline <= b->now;
    b->deadline = deadline;
}

/* Lets the node do what is due until `until`, or until it has sent something. */
void canopen_run_until(struct canopen_bench *b, dg_ns until, bool stop_at_frame)
{
    while (b->deadline <= until && !b->stuck && !(stop_at_frame && b->sent_count > b->seen)) {
        b->now = b->deadline;
        canopen_note_deadline(b, dg_co_step(&b->node, b->now));
    }
    if (!(stop_at_frame && b->sent_count > b->seen)) {
        b->now = until;
    }
}

static void ask_filters(struct canopen_bench *b)
{
    b->filter_version = b->node.filter_version;
    b->filter_count = dg_co_filters(&b->node, b->filters);
}

static bool deliver_frame(struct canopen_bench *b, const struct dg_can_frame *frame,
                          struct cf_report *report)
{
    const struct cf_unit unit = unit_of(frame);

    if (b->filter_version != b->node.filter_version) {
        ask_filters(b);
    }
    if (b->late > 0) {
        canopen_note_deadline(b, dg_co_step(&b->node, b->now));
    }
    for (uint8_t i = 0; i < b->filter_count; i++) {
        if (b->filters[i] == frame->id) {
            canopen_note_deadline(b, dg_co_rx(&b->node, b->now - b->late, frame));
        }
    }
    b->late = 0;
    return !is_beside() || trial.beside.ops->sent(trial.beside.ctx, &unit, report);
}

/* "5ms", "300us", "1s"; 0 when it is none of them. `*end` is what follows. */
dg_ns canopen_span(const char *word, const char **end)
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
    struct canopen_bench *b = ctx;
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
    return deliver_frame(b, &frame, report);
}

/* rtr ID [N]: a remote frame has the length of the frame that it asks for (ISO 11898-1), and some nodes
   answer no other one; the state of a node is one byte */
static bool step_rtr(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    struct dg_can_frame frame = {.rtr = true};
    const unsigned long length = n == 3 ? strtoul(words[2], NULL, 10) : 0;

    if (n < 2 || n > 3 || length > 8) {
        return cf_fail(report, "rtr ID [N]");
    }
    if (!parse_id(words[1], &frame, report)) {
        return false;
    }
    frame.dlc = n == 3 ? (uint8_t)length : (frame.id & 0x780u) == 0x700u;
    return deliver_frame(b, &frame, report);
}

static void print_frame(char *to, size_t size, const struct dg_can_frame *frame)
{
    size_t at = (size_t)snprintf(to, size, "%03X%s", frame->id, frame->rtr ? " rtr" : "");

    for (uint8_t i = 0; i < frame->dlc && at < size; i++) {
        at += (size_t)snprintf(to + at, size - at, " %02X", frame->data[i]);
    }
}

/* The next frame the node sent, or NULL. */
static const struct dg_can_frame *next_frame(const struct canopen_bench *b)
{
    return b->seen < b->sent_count && b->seen < CANOPEN_QUEUE_MAX ? &b->sent[b->seen] : NULL;
}

static bool keep_silent(struct canopen_bench *b, dg_ns wait, struct cf_report *report)
{
    dg_ns from = b->now;
    char got[64];

    b->earliest = 0;
    b->latest = 0;
    canopen_run_until(b, b->now + wait, true);
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

static bool expect_nothing(struct canopen_bench *b, dg_ns wait, struct cf_report *report)
{
    return keep_silent(b, wait, report) &&
           (!is_beside() || trial.beside.ops->silent(trial.beside.ctx, wait, report));
}

/* The next frame of the model, and what the row expects of it; both may be what the other is not.
 */
static bool judge_beside(struct canopen_bench *b, const struct dg_can_frame *want,
                         struct cf_report *report)
{
    const struct dg_can_frame *got = next_frame(b);
    const struct cf_answer answer = {
        .want = unit_of(want),
        .got = got != NULL ? unit_of(got) : (struct cf_unit){.bytes = NULL},
        .earliest_ns = b->earliest,
        .latest_ns = b->latest,
        .timed = b->latest > 0,
    };

    b->seen += got != NULL ? 1u : 0u;
    b->earliest = 0;
    b->latest = 0;
    return trial.beside.ops->answered(trial.beside.ctx, &answer, report);
}

static bool expect_frame(struct canopen_bench *b, const struct dg_can_frame *want,
                         struct cf_report *report)
{
    const struct dg_can_frame *got = next_frame(b);
    char hex[2][64] = {"", "nothing"};

    if (is_beside()) {
        return judge_beside(b, want, report);
    }
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

bool canopen_ask(struct canopen_bench *b, const struct dg_can_frame *request,
                 const struct cf_relation *relation, struct cf_report *report)
{
    if (!deliver_frame(b, request, report)) {
        return false;
    }
    canopen_run_until(b, b->now + PATIENCE, true);
    const struct dg_can_frame *got = next_frame(b);
    const struct cf_unit unit = got != NULL ? unit_of(got) : (struct cf_unit){.bytes = NULL};
    const bool agrees = relation->judge(relation->ctx, &unit) == CF_AGREES;
    /* What a model that has nothing to do with the encoder answers is no matter. */
    const struct cf_answer answer = {
        .want = agrees || trial.device == NULL ? unit : (struct cf_unit){.bytes = NULL},
        .got = unit,
        .relation = relation,
    };
    char hex[64] = "nothing";

    b->seen += got != NULL ? 1u : 0u;
    if (is_beside()) {
        return trial.beside.ops->answered(trial.beside.ctx, &answer, report);
    }
    if (got != NULL) {
        print_frame(hex, sizeof hex, got);
    }
    return agrees || cf_fail(report, "expected %s\n    got      %s", relation->text, hex);
}

/* "@10ms" or "@13ms..15ms": the next frame is sent then, counted from now, and not earlier. */
static bool run_to_frame(struct canopen_bench *b, const char *word, struct cf_report *report)
{
    const char *rest;
    dg_ns from = b->now;
    dg_ns earliest = canopen_span(word + 1, &rest);
    dg_ns latest = earliest;
    dg_ns at;

    if (strncmp(rest, "..", 2) == 0) {
        latest = canopen_span(rest + 2, &rest);
    }
    if (earliest == 0 || latest < earliest || *rest != '\0') {
        return cf_fail(report, "not a moment: %s", word);
    }
    canopen_run_until(b, from + latest, true);
    at = next_frame(b) != NULL ? b->sent_at[b->seen] : DG_NEVER;
    b->earliest = earliest;
    b->latest = latest;
    return (at >= from + earliest && at <= from + latest) ||
           cf_fail(report, "expected a frame %s, got one after %lld ns", word,
                   at == DG_NEVER ? -1LL : (long long)(at - from));
}

/* < [@T] ID BYTES | < none [T] */
static bool step_expect(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    struct dg_can_frame want = {0};
    bool timed = n > 1 && words[1][0] == '@';
    size_t at = timed ? 2 : 1;
    const char *rest;

    if (n > 1 && strcmp(words[1], "none") == 0) {
        return expect_nothing(b, n > 2 ? canopen_span(words[2], &rest) : 0, report);
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
    struct canopen_bench *b = ctx;
    size_t want = n == 2 ? strtoul(words[1], NULL, 10) : 0;

    if (b->sent_count - b->seen != want) {
        return cf_fail(report, "skip: %zu frames are there", b->sent_count - b->seen);
    }
    while (is_beside() && next_frame(b) != NULL) {
        if (!judge_beside(b, next_frame(b), report)) {
            return false;
        }
    }
    b->seen = b->sent_count;
    return true;
}

/* --- expedited SDO ------------------------------------------------------------------------- */

/* "1018:1" */
bool canopen_parse_object(const char *word, struct dg_can_frame *to, struct cf_report *report)
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
    struct canopen_bench *b = ctx;
    bool reads = strcmp(words[0], "read") == 0;
    bool aborts = n >= 4 && strcmp(words[n - 2], "abort") == 0;
    size_t given = n < 2 ? 0 : n - 2 - (aborts ? 2u : 0u);
    struct dg_can_frame request = {.id = (uint16_t)(0x600u + b->node_id)};
    struct dg_can_frame answer = {.id = (uint16_t)(0x580u + b->node_id)};

    if (n < 2 || given > 4 || (given == 0) != (reads && aborts)) {
        return cf_fail(report, "read INDEX:SUB BYTES, write INDEX:SUB BYTES [abort CODE]");
    }
    if (!canopen_parse_object(words[1], &request, report)) {
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
    if (!deliver_frame(b, &request, report)) {
        return false;
    }
    canopen_run_until(b, b->now + PATIENCE, true);
    return expect_frame(b, &answer, report);
}

/* --- the other steps ----------------------------------------------------------------------- */

static bool power_on(struct canopen_bench *b, struct cf_report *report)
{
    const struct dg_co_setup setup = {
        .device = b->model.device,
        .world = &b->world,
        .nvm = cf_memory_port(&b->nvm),
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
    canopen_note_deadline(b, dg_co_step(&b->node, b->now));
    ask_filters(b);
    return true;
}

/* power on|off; the memory keeps what it has */
static bool step_power(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    const bool on = n == 2 && strcmp(words[1], "on") == 0;

    if (is_beside() && !trial.beside.ops->powered(trial.beside.ctx, on, report)) {
        return false;
    }
    if (on) {
        return power_on(b, report);
    }
    dg_co_power_off(&b->node);
    b->deadline = DG_NEVER;
    canopen_run_until(b, b->now + DG_MS(10), false);
    return n == 2 && strcmp(words[1], "off") == 0 ? true : cf_fail(report, "power on|off");
}

/* What the words behind the model say; `*keep`: the boot-up frame is still to be expected. */
static bool take_figures(struct canopen_bench *b, char **words, size_t n, uint32_t *serial,
                         bool *keep, struct cf_report *report)
{
    for (size_t i = 2; i < n; i++) {
        if (strncmp(words[i], "serial=", 7) == 0) {
            *serial = (uint32_t)strtoul(words[i] + 7, NULL, 10);
        } else if (strcmp(words[i], "turns=65536") == 0) {
            b->model.turns = 65536;
            b->model.device = &dg_cia406_multiturn_32;
        } else if (strcmp(words[i], "boot") == 0) {
            *keep = true;
        } else {
            return cf_fail(report, "given: no such figure: %s", words[i]);
        }
    }
    return true;
}

/* The encoder in place of the one that a row names, and what is its own of it. */
static void take_trial(struct canopen_bench *b, uint32_t *serial)
{
    if (trial.device != NULL) {
        b->device = trial.device;
        b->model = *dg_cia406_model_of(trial.device);
    }
    if (trial.placed) {
        *serial = trial.serial;
        b->from = turns_of(trial.raw, 65536);
    }
}

/* given MODEL [serial=N] [turns=65536] [boot] */
static bool step_given(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    uint32_t serial = 1234567890;
    bool keep = false;

    b->device = n > 1 ? dg_device_find(words[1]) : NULL;
    if (b->device == NULL || b->device->stack != &dg_cia406_stack) {
        return cf_fail(report, "given: no such model");
    }
    b->model = *dg_cia406_model_of(b->device);
    if (!take_figures(b, words, n, &serial, &keep, report)) {
        return false;
    }
    take_trial(b, &serial);
    if (made_of != NULL) {
        b->model.device = made_of(b->model.device);
    }
    cf_memory_init(&b->nvm, dg_store_size(b->model.device->layout));
    if (dg_co_format(b->model.device, cf_memory_port(&b->nvm), serial) != 0) {
        return cf_fail(report, "given: the memory cannot be formatted");
    }
    if (keep && is_beside() &&
        (!trial.beside.ops->powered(trial.beside.ctx, false, report) ||
         !trial.beside.ops->powered(trial.beside.ctx, true, report))) {
        return false;
    }
    b->ready = power_on(b, report);
    b->seen = keep ? 0 : b->sent_count;
    return b->ready;
}

static bool step_wait(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    const char *rest = "";
    dg_ns wait = n == 2 ? canopen_span(words[1], &rest) : 0;

    canopen_run_until(b, b->now + wait + trial.slack, false);
    if (wait == 0 || *rest != '\0') {
        return cf_fail(report, "wait 5ms, 300us or 1s");
    }
    return !is_beside() || trial.beside.ops->waited(trial.beside.ctx, wait, report);
}

/* late T: a busy port delivers the next frame T after it came in */
static bool step_late(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    const char *rest = "";

    b->late = n == 2 ? canopen_span(words[1], &rest) : 0;
    return (b->late > 0 && *rest == '\0') || cf_fail(report, "late 5ms, 300us or 1s");
}

/* turn 90DEG | turn 1000: to this angle, in degrees or in counts of 65536 a turn */
static bool step_turn(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
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
    struct canopen_bench *b = ctx;
    int64_t figure = n == 2 ? strtoll(words[1], NULL, 10) : 0;
    bool ramp = strcmp(words[0], "ramp") == 0;

    b->from = shaft_angle(b, b->now);
    b->since = b->now;
    b->rpm = ramp ? 0 : figure;
    b->ramp = ramp ? figure : 0;
    return n == 2 || cf_fail(report, "rpm N | ramp N");
}

static bool step_eeprom(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    b->nvm.silent = n == 2 && strcmp(words[1], "silent") == 0;
    return b->nvm.silent || (n == 2 && strcmp(words[1], "back") == 0) ||
           cf_fail(report, "eeprom silent|back");
}

/* damage REGION OFFSET [MASK] | stored REGION OFFSET BYTES: what has happened to the memory */
static bool step_memory(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    const struct dg_store_layout *layout = b->model.device->layout;

    return words[0][0] == 'd' ? canopen_damage(&b->nvm, layout, words, n, report)
                              : canopen_stored(&b->nvm, layout, words, n, report);
}

/* eds SECTION KEY VALUE|none: a line of the EDS file */
static bool step_eds(void *ctx, char **words, size_t n, struct cf_report *report)
{
    const struct canopen_bench *b = ctx;

    return canopen_eds(b->device, words, n, report);
}

/* node ID: whom `read` and `write` talk to from now on */
static bool step_node(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    b->node_id = (uint8_t)(n == 2 ? strtoul(words[1], NULL, 16) : 0);
    return b->node_id != 0 || cf_fail(report, "node ID");
}

/* rate KBAUD: the bit rate in force */
static bool step_rate(void *ctx, char **words, size_t n, struct cf_report *report)
{
    struct canopen_bench *b = ctx;
    return (n == 2 && strtoul(words[1], NULL, 10) == b->kbaud) ||
           cf_fail(report, "rate: got %u kBd", (unsigned)b->kbaud);
}

/* --- table --------------------------------------------------------------------------------- */

/* clang-format off */
static const struct cf_step steps[] = {
    {"given",  step_given,          false, 0},         {">",      step_data,           false, 0},
    {">!",     step_data,           false, 0},         {"<",      step_expect,         true,  0},
    {"skip",   step_skip,           true,  0},         {"rtr",    step_rtr,            false, 0},
    {"read",   step_sdo,            true,  0},         {"write",  step_sdo,            true,  0},
    {"wait",   step_wait,           false, 0},         {"turn",   step_turn,           false, CF_SHAFT},
    {"rpm",    step_rpm,            false, CF_SHAFT},  {"ramp",   step_rpm,            false, CF_SHAFT},
    {"bus",    canopen_step_bus,            false, CF_INSIDE}, {"power",  step_power,          false, CF_POWER},
    {"eeprom", step_eeprom,         false, CF_INSIDE}, {"damage", step_memory,         false, CF_INSIDE},
    {"stored", step_memory,         false, CF_INSIDE}, {"node",   step_node,           false, CF_INSIDE},
    {"rate",   step_rate,           true,  CF_INSIDE}, {"late",   step_late,           false, CF_INSIDE},
    {"world",  canopen_step_world,  false, CF_INSIDE}, {"led",    canopen_step_led,    true,  CF_INSIDE},
    {"leds",   canopen_step_leds,   true,  CF_INSIDE}, {"eds",    step_eds,            true,  CF_INSIDE},
    {"upload", canopen_step_upload, true,  0},
};
/* clang-format on */

static void begin(void *ctx)
{
    struct canopen_bench *b = ctx;

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
    return keep_silent(ctx, 0, report) &&
           (!is_beside() || trial.beside.ops->silent(trial.beside.ctx, 1, report));
}

const struct cf_device *cf_canopen(void)
{
    static const struct cf_device device = {&bench, begin, steps, DG_COUNT(steps), finish};

    return &device;
}

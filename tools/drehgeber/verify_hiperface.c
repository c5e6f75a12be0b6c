/* SPDX-License-Identifier: MIT */
/*
 * A real encoder with RS485 against its clauses. The row, the model and the encoder get the same
 * request, and the encoder has to answer what the model does:
 *
 *   row says  > 40 42 02   -> model, which is where the encoder was when the row began
 *                          -> encoder
 *   row says  < 40 42 ...  model: 40 42 00 27 25 51 51     encoder: 40 42 00 27 25 52 52
 *
 * Where the model answers otherwise than the row, as it is not as delivered, nothing can be said.
 * Positions may differ by what the shaft was seen to move at rest.
 */
#include <string.h>
#include <unistd.h>

#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "timer.h"
#include "verify_hiperface.h"
#include "verify_silkit.h"
#include "verify_stream.h"

static dg_ns bits(uint64_t n)
{
    return n * DG_S(1) / 9600u;
}

/* --- the line --- */

/* @return false: it never stops */
static bool drain_line(struct hiperface *self)
{
    uint8_t bytes[256];
    size_t thrown = 0;
    long n;
    while ((n = verify_stream_receive(&self->wire, lx_now(), bytes, sizeof bytes)) > 0) {
        thrown += (size_t)n;
        self->quiet = lx_now();
        verify_stream_wait(&self->wire, self->quiet + bits(PAUSE_BITS));
        if (thrown > NOISE_MAX) {
            return false;
        }
    }
    return true;
}

static bool send_request(struct hiperface *self, const uint8_t *bytes, size_t n,
                         struct cf_report *report)
{
    verify_stream_wait(&self->wire, self->quiet + bits(PAUSE_BITS + 1u));
    self->request.n = n < sizeof self->request.bytes ? n : sizeof self->request.bytes;
    memcpy(self->request.bytes, bytes, self->request.n);
    if (verify_stream_send(&self->wire, bytes, n) != 0) {
        return verify_fail(&self->base, VERIFY_LOST, report, "the wire accepts no more data");
    }
    self->sent = lx_now() + bits(n * CHARACTER_BITS);
    self->quiet = self->sent;
    return true;
}

/* A frame that begins before `until`, and ends with byte `length` or with a pause. */
static bool receive_frame(struct hiperface *self, dg_ns until, size_t length, struct frame *to,
                          struct cf_report *report)
{
    const dg_ns idle = self->wire.network ? NETWORK_IDLE : IDLE;
    to->n = 0;
    while (to->n < length && to->n < sizeof to->bytes) {
        const long n = verify_stream_receive(&self->wire, to->n == 0 ? until : self->quiet + idle,
                                             to->bytes + to->n, sizeof to->bytes - to->n);
        if (n < 0) {
            return verify_fail(&self->base, VERIFY_LOST, report, "the wire is gone");
        }
        if (n == 0) {
            break;
        }
        self->quiet = lx_now();
        to->at = to->n == 0 ? self->quiet : to->at;
        to->n += (size_t)n;
    }
    return true;
}

/* Ask for something of one's own: `request` gets its check sum. @return whether `length` bytes came
   that answer it */
static bool ask_encoder(struct hiperface *self, uint8_t command, size_t length, struct frame *to,
                        struct cf_report *report)
{
    const uint8_t request[3] = {ADDRESS, command, (uint8_t)(ADDRESS ^ command)};
    uint8_t sum = 0;
    to->n = 0;
    if (!drain_line(self)) {
        return verify_fail(&self->base, VERIFY_LOST, report, "it never stops sending");
    }
    if (!send_request(self, request, sizeof request, report) ||
        !receive_frame(self, self->sent + REPLY_MAX, length, to, report)) {
        return false;
    }
    for (size_t i = 0; i < to->n; i++) {
        sum ^= to->bytes[i];
    }
    return to->n == length && sum == 0 && to->bytes[0] == ADDRESS &&
           (to->bytes[1] & 0x7Fu) == command;
}

/* Ask up to three times: a host that is busy may have been late. */
bool verify_hiperface_ask_again(struct hiperface *self, uint8_t command, size_t length,
                                struct frame *to, struct cf_report *report)
{
    bool answered = false;
    for (unsigned i = 0; !answered && i < 3; i++) {
        answered = ask_encoder(self, command, length, to, report);
    }
    return answered;
}

/* Send `request`, with its check sum behind it. @return whether something has come that is no
   error */
bool verify_hiperface_command(struct hiperface *self, const uint8_t *request, size_t n,
                              struct frame *to)
{
    struct cf_report report = {0};
    uint8_t bytes[16] = {0};
    to->n = 0;
    for (size_t i = 0; i < n; i++) {
        bytes[i] = request[i];
        bytes[n] ^= request[i];
    }
    return drain_line(self) && send_request(self, bytes, n + 1u, &report) &&
           receive_frame(self, self->sent + REPLY_MAX, sizeof to->bytes, to, &report) &&
           to->n >= 3 && (to->bytes[1] & 0x7Fu) != 0x50u;
}

/* --- what is compared --- */

/* What is the encoder's own: its data are compared otherwise, or not at all. */
static const struct {
    uint8_t command;
    bool position;
} own[] = {
    {0x42, true}, {0x44, false}, {0x46, false}, {0x56, false}, {0x6A, true},
};

static bool is_own(const uint8_t *frame, size_t n, bool *position)
{
    for (size_t i = 0; n > 3 && i < DG_COUNT(own); i++) {
        if ((frame[1] & 0x7Fu) == own[i].command) {
            *position = own[i].position && n == 7;
            return true;
        }
    }
    *position = false;
    return false;
}

/* Whether the model, which is in the encoder's state, still says what the row is about. */
static bool is_as_delivered(const struct cf_answer *answer)
{
    const struct cf_unit *want = &answer->want;
    const struct cf_unit *got = &answer->got;
    bool position;
    if (got->bytes == NULL || got->n != want->n) {
        return false;
    }
    return is_own(want->bytes, want->n, &position) ? memcmp(want->bytes, got->bytes, 2) == 0
                                                   : memcmp(want->bytes, got->bytes, want->n) == 0;
}

static uint64_t range_of(const struct dg_hf_model *model)
{
    return (uint64_t)model->periods_per_turn * model->steps_per_period * model->turns;
}

/* Whether two positions are as near to each other as readings at rest. */
bool verify_hiperface_is_near(const struct hiperface *self, uint32_t a, uint32_t b)
{
    const uint64_t range = range_of(&self->model);
    const uint64_t up = ((uint64_t)a + range - b % range) % range;
    return a < range && (up <= self->moves || range - up <= self->moves);
}

static bool has_sum(const struct frame *frame)
{
    uint8_t sum = 0;
    for (size_t i = 0; i < frame->n; i++) {
        sum ^= frame->bytes[i];
    }
    return sum == 0;
}

/* What a sensor measures: `came` has to have the form, the figure is its own. */
static bool is_measured(const uint8_t *expected)
{
    return expected[1] == 0x44u;
}

static int16_t signed_be16(const uint8_t *from)
{
    return (int16_t)((unsigned)from[0] << 8 | from[1]);
}

/* Whether the answer to 44h is within what the encoder's own label tells of this channel. */
static bool is_within_limits(const struct hiperface *self, const uint8_t *answer)
{
    bool within = true;
    for (size_t i = 0; self->has_limits && i < LIMITS; i += LIMITS_EACH) {
        const uint8_t *sensor = &self->limits[i];
        const int16_t value = signed_be16(answer + 3);
        if (sensor[1] == answer[2]) {
            within = within && value >= signed_be16(sensor + 2) && value <= signed_be16(sensor + 4);
        }
    }
    return within;
}

static bool is_right(const struct hiperface *self, const struct cf_unit *expected,
                     const struct frame *came)
{
    bool position;
    if (came->n != expected->n || !has_sum(came)) {
        return came->n == expected->n && memcmp(came->bytes, expected->bytes, came->n) == 0;
    }
    (void)is_own(expected->bytes, expected->n, &position);
    if (position) {
        return memcmp(came->bytes, expected->bytes, 2) == 0 &&
               verify_hiperface_is_near(self, be32(came->bytes + 2), be32(expected->bytes + 2));
    }
    if (is_measured(expected->bytes)) {
        return memcmp(came->bytes, expected->bytes, 3) == 0 &&
               (came->n != 6 || is_within_limits(self, came->bytes));
    }
    return memcmp(came->bytes, expected->bytes, came->n) == 0;
}

/* --- beside the model --- */

/* Requests that change what the encoder keeps, and the one that restarts it. */
static unsigned needs_of(struct verify_encoder *base, const struct cf_unit *request)
{
    const struct hiperface *self = of(base);
    static const uint8_t writes[] = {0x43, 0x47, 0x49, 0x4B, 0x4D, 0x4F, 0x53, 0x55, 0x57, 0x6A};
    unsigned needs = request->n == 0 || request->bytes[0] == ADDRESS ? 0u : CF_ALONE;
    const uint8_t command = request->n > 1 ? request->bytes[1] : 0;
    for (size_t i = 0; request->n > 1 && i < sizeof writes; i++) {
        needs |= command == writes[i] ? CF_WRITE : 0u;
    }
    if ((self->has_fields && (command == 0x4Bu || command == 0x4Du)) ||
        (self->trial.counter > COUNTS_MAX && (command == 0x47u || command == 0x49u))) {
        needs |= CF_ONE_WAY;
    }
    return needs;
}

/* What it was is noted before the first change of a row, the change before it is sent. */
static bool note(struct hiperface *self, const struct cf_unit *request, struct cf_report *report)
{
    struct verify_journal *journal = self->base.journal;
    const uint32_t p = (uint32_t)self->trial.raw;
    const uint32_t c = self->trial.counter;
    const uint8_t position[5] = {0x42, (uint8_t)(p >> 24), (uint8_t)(p >> 16), (uint8_t)(p >> 8),
                                 (uint8_t)p};
    const uint8_t counter[4] = {0x46, (uint8_t)(c >> 16), (uint8_t)(c >> 8), (uint8_t)c};
    const uint8_t setting[2] = {0x52, self->setting};
    const struct cf_unit before[] = {{.bytes = position, .n = sizeof position},
                                     {.bytes = counter, .n = sizeof counter},
                                     {.bytes = setting, .n = sizeof setting}};
    bool noted = true;
    if ((needs_of(&self->base, request) & CF_WRITE) == 0) {
        return true;
    }
    const bool first = journal != NULL && journal->count == 0;
    for (size_t i = 0; first && noted && i < DG_COUNT(before); i++) {
        noted = verify_journal_add(journal, true, &before[i]);
    }
    return journal != NULL && noted && verify_journal_add(journal, false, request) &&
                   verify_journal_sync(journal)
               ? true
               : verify_fail(&self->base, VERIFY_LOST, report, "the journal cannot be written");
}

static bool on_sent(void *ctx, const struct cf_unit *request, struct cf_report *report)
{
    struct hiperface *self = ctx;
    if (!note(self, request, report)) {
        return false;
    }
    uint8_t bytes[256];
    const long n = verify_stream_receive(&self->wire, lx_now(), bytes, sizeof bytes);
    if (n != 0) {
        char text[400];
        const struct cf_unit came = {.bytes = bytes, .n = n > 0 ? (size_t)n : 0};
        (void)verify_print_unit(&came, text, sizeof text);
        return verify_fail(&self->base, n > 0 ? VERIFY_DIFFERS : VERIFY_LOST, report,
                           "received without a request, or after an answer:%s", text);
    }
    return send_request(self, request->bytes, request->n, report);
}

static bool report_answer(struct hiperface *self, const struct cf_answer *answer,
                          const struct frame *came, struct cf_report *report)
{
    char text[3][500];
    const struct cf_unit sent = {.bytes = self->request.bytes, .n = self->request.n};
    const struct cf_unit got = {.bytes = came->n > 0 ? came->bytes : NULL, .n = came->n};
    (void)verify_print_unit(&sent, text[0], sizeof text[0]);
    (void)verify_print_unit(&answer->got, text[1], sizeof text[1]);
    (void)verify_print_unit(&got, text[2], sizeof text[2]);
    return verify_fail(&self->base, VERIFY_DIFFERS, report, "sent%s; expected%s; came%s", text[0],
                       text[1], text[2]);
}

static bool check_time(struct hiperface *self, const struct cf_answer *answer,
                       const struct frame *came, struct cf_report *report)
{
    const dg_ns limit = answer->latest_ns + bits(CHARACTER_BITS) + self->jitter + HOST_ADDS;
    const dg_ns took = came->at > self->sent ? came->at - self->sent : 0;
    char text[500];
    if (!answer->timed || took <= limit) {
        return true;
    }
    const struct cf_unit sent = {.bytes = self->request.bytes, .n = self->request.n};
    (void)verify_print_unit(&sent, text, sizeof text);
    return verify_fail(&self->base, VERIFY_DIFFERS, report,
                       "sent%s; expected an answer within %llu us, and %llu us more for this host; "
                       "it came after %llu us",
                       text, (unsigned long long)answer->latest_ns / 1000u,
                       (unsigned long long)(limit - answer->latest_ns) / 1000u,
                       (unsigned long long)took / 1000u);
}

static bool on_answered(void *ctx, const struct cf_answer *answer, struct cf_report *report)
{
    struct hiperface *self = ctx;
    struct frame came = {.n = 0};
    if (!is_as_delivered(answer)) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                           "needs an encoder in its delivery state");
    }
    if (!receive_frame(self, self->sent + answer->latest_ns + REPLY_MAX, answer->got.n, &came,
                       report)) {
        return false;
    }
    return is_right(self, &answer->got, &came) ? check_time(self, answer, &came, report)
                                               : report_answer(self, answer, &came, report);
}

static bool on_silent(void *ctx, uint64_t ns, struct cf_report *report)
{
    struct hiperface *self = ctx;
    static const struct cf_answer nothing = {.timed = false};
    struct frame came;
    const dg_ns wait = ns != 0 ? ns : self->base.journal != NULL ? REPLY_MAX : SILENCE;
    return receive_frame(self, lx_now() + wait, sizeof came.bytes, &came, report) &&
           (came.n == 0 || report_answer(self, &nothing, &came, report));
}

static bool on_waited(void *ctx, uint64_t ns, struct cf_report *report)
{
    struct hiperface *self = ctx;
    (void)report;
    verify_stream_wait(&self->wire, lx_now() + ns);
    return true;
}

static const struct cf_beside_ops beside_ops = {
    .sent = on_sent,
    .answered = on_answered,
    .silent = on_silent,
    .waited = on_waited,
    .powered = verify_powered,
    .needs = verify_allowed,
};

/* --- rows --- */

static void rehearse(struct verify_encoder *base, const struct cf_beside *beside, dg_ns slack)
{
    struct hiperface *self = of(base);
    const struct cf_hiperface_trial trial = {
        .model = &self->model,
        .temperature_mdegc = 37000,
        .slack = slack,
        .beside = *beside,
    };
    cf_hiperface_try(&trial);
}

/* Where it is, what it has counted; nothing is on its stack of errors. */
static bool begin(struct verify_encoder *base, struct cf_report *report)
{
    struct hiperface *self = of(base);
    struct frame came;
    for (size_t i = 0; i < STATUS_READS_MAX; i++) {
        if (ask_encoder(self, 0x50, 4, &came, report) && came.bytes[1] == 0x50u &&
            came.bytes[2] == 0) {
            break;
        }
    }
    if (!verify_hiperface_ask_again(self, 0x46, 6, &came, report)) {
        return verify_fail(base, VERIFY_LOST, report, "it does not answer 46h any more");
    }
    self->trial.counter =
        (uint32_t)came.bytes[2] << 16 | (uint32_t)came.bytes[3] << 8 | came.bytes[4];
    if (!verify_hiperface_ask_again(self, 0x42, 7, &came, report)) {
        return verify_fail(base, VERIFY_LOST, report, "it does not answer 42h any more");
    }
    base->outcome = VERIFY_AGREES;
    self->trial.raw = be32(came.bytes + 2);
    self->trial.model = &self->model;
    self->trial.placed = true;
    self->trial.beside = (struct cf_beside){&beside_ops, self};
    cf_hiperface_try(&self->trial);
    return true;
}

/* Something that answers still is there; a wrong answer says nothing about that. A row that has changed the
   address may have ended before it changed it back. */
static bool end(struct verify_encoder *base, struct cf_report *report)
{
    if (base->outcome != VERIFY_DIFFERS) {
        return true;
    }
    verify_stream_wait(base->stream, lx_now() + REPLY_MAX);
    if (verify_hiperface_find(of(base), report)) {
        base->outcome = VERIFY_DIFFERS;
        return true;
    }
    return verify_fail(base, VERIFY_LOST, report, "it does not answer any more");
}

/* --- the encoder --- */

static int unanswered(const char *where, struct lx_error *error)
{
    return lx_refuse(error, "expected the wire of an encoder with address 40h, at 9600 Bd 8E1",
                     "%s: no encoder answers", where);
}

/* Serial number, version and date are of this encoder, its type is what there are clauses of. */
static int identify_encoder(struct hiperface *self, const char *where, struct lx_error *error)
{
    struct cf_report report = {0};
    struct frame type = {.at = 0};
    struct frame made = {.at = 0};
    bool answered = ask_encoder(self, 0x52, 7, &type, &report);
    answered = answered ||
               ask_encoder(self, 0x52, 7, &type, &report); /* the first one may have met noise */
    if (!answered) {
        return unanswered(where, error);
    }
    if (!ask_encoder(self, 0x56, 40, &made, &report)) {
        return unanswered(where, error);
    }
    self->setting = type.bytes[2];
    (void)snprintf(self->model.serial, sizeof self->model.serial, "%.9s",
                   (const char *)made.bytes + 2);
    (void)snprintf(self->model.version, sizeof self->model.version, "%.19s",
                   (const char *)made.bytes + 11);
    (void)snprintf(self->model.date, sizeof self->model.date, "%.8s",
                   (const char *)made.bytes + 31);
    (void)snprintf(self->base.serial, sizeof self->base.serial, "%s", self->model.serial);
    (void)snprintf(self->base.identity, sizeof self->base.identity,
                   "type code %02Xh, firmware %s, %s", type.bytes[3], self->model.version,
                   self->model.date);
    return 0;
}

/* How far readings of a shaft at rest, and times of answers, are apart. */
static int measure_encoder(struct hiperface *self, const char *where, struct lx_error *error)
{
    struct cf_report report = {0};
    struct frame came = {.at = 0};
    dg_ns shortest = DG_NEVER;
    dg_ns longest = 0;
    uint32_t before = 0;
    self->moves = 0;
    for (size_t i = 0; i < READINGS; i++) {
        if (!ask_encoder(self, 0x42, 7, &came, &report)) {
            return unanswered(where, error);
        }
        const dg_ns took = came.at > self->sent ? came.at - self->sent : 0;
        const uint32_t now = be32(came.bytes + 2);
        shortest = took < shortest ? took : shortest;
        longest = took > longest ? took : longest;
        while (i > 0 && !verify_hiperface_is_near(self, now, before) && self->moves <= MOVES_MAX) {
            self->moves++;
        }
        before = now;
    }
    if (self->moves > MOVES_MAX) {
        return lx_refuse(error, "expected a shaft at rest", "%s: the shaft turns", where);
    }
    static const uint8_t label[] = {ADDRESS, 0x4A, 0xFF, 0x1E, LIMITS, CODE};
    self->has_limits =
        verify_hiperface_command(self, label, sizeof label, &came) && came.n == LIMITS + 6u;
    memcpy(self->limits, came.bytes + 5, self->has_limits ? LIMITS : 0u);
    static const uint8_t field[] = {ADDRESS, 0x4C, 0x00};
    self->has_fields = verify_hiperface_command(self, field, sizeof field, &came);
    self->moves = 2u * self->moves + 1u;
    self->jitter = longest - shortest;
    return 0;
}

/* A type label hurts nobody. */
static int scan(struct verify_encoder *base, struct lx_error *error)
{
    struct hiperface *self = of(base);
    const dg_ns until = lx_now() + VERIFY_SCAN;
    struct cf_report report = {""};
    struct frame came = {.n = 0};
    for (uint8_t address = ADDRESS + 1u; address <= DG_HF_ADDRESS_LAST && came.n == 0; address++) {
        const uint8_t request[3] = {address, 0x52, (uint8_t)(address ^ 0x52u)};
        if (!send_request(self, request, sizeof request, &report) ||
            !receive_frame(self, self->sent + SCAN_REPLY_MAX, 7, &came, &report)) {
            return lx_fail(error, "%s", report.text);
        }
    }
    if (came.n == 0 && !receive_frame(self, until, 1, &came, &report)) {
        return lx_fail(error, "%s", report.text);
    }
    return came.n == 0 ? 0
                       : lx_refuse(error, "without --alone, verify disturbs no other device",
                                   "another device is on the wire: %02Xh was received",
                                   (unsigned)came.bytes[0]);
}

static void close_encoder(struct verify_encoder *base)
{
    struct hiperface *self = of(base);
    cf_hiperface_try(NULL);
    verify_stream_close(&self->wire);
}

static int open_encoder(struct verify_encoder *base, const struct options *options,
                        struct lx_error *error)
{
    static const struct lx_uart uart = {.baud = 9600, .parity = 'E'};
    struct hiperface *self = of(base);
    self->model = *dg_hf_model_of(options->device);
    self->trial.temperature_mdegc = 37000;
    self->moves = MOVES_MAX;
    base->stream = &self->wire;
    const int result = verify_silkit_is(options)
                           ? verify_stream_join(&self->wire, options, error)
                           : verify_stream_open(&self->wire, options->where, &uart, error);
    self->quiet = lx_now();
    return result;
}

static int identify(struct verify_encoder *base, const char *where, struct lx_error *error)
{
    const int identified = identify_encoder(of(base), where, error);
    return identified != 0 ? identified : measure_encoder(of(base), where, error);
}

const struct verify_protocol verify_hiperface = {
    .stack = &dg_hf_stack,
    .suites = {"hiperface"},
    .choices = "RD",
    .writes = "position and counter, data fields, access codes, address, setting of the line",
    .rows = cf_hiperface,
    .size = sizeof(struct hiperface),
    .open = open_encoder,
    .identify = identify,
    .scan = scan,
    .rehearse = rehearse,
    .needs = needs_of,
    .begin = begin,
    .end = end,
    .put_back = verify_hiperface_put_back,
    .close = close_encoder,
};

/* SPDX-License-Identifier: MIT */
/*
 * A real encoder with INTERBUS against its clauses: the first one of a ring whose coupler has the
 * registers of `drehgeber map`. The ring has its own cycle, which nobody here sees: OUT is written,
 * and IN is read until it is what it should become. On the way there it may only be what it was.
 * The model beside the encoder has its serial number, its version and its position.
 */
#include <string.h>

#include "drehgeber/bits.h"
#include "timer.h"
#include "verify_interbus.h"
#include "verify_stream.h"

/* How long a command may be handled; the manual has no limit. */
#define ANSWER_MAX DG_S(1)
/* How long an answer that changes nothing is waited for, and each OUT stands, at least. */
#define SETTLE_MIN DG_MS(20)
/* Between two looks at IN. */
#define LOOK DG_MS(1)
/* So often IN has to stay what it has become. */
#define STAYS 3u
#define READINGS 20u
#define MOVES_MAX 8u

/* --- the wire --- */

static bool lose_wire(struct interbus *self, struct cf_report *report)
{
    return verify_fail(&self->base, VERIFY_LOST, report,
                       "the coupler does not answer, or refuses its images");
}

/* Long enough for what this ring and this encoder do with an OUT. */
static dg_ns settle_time(const struct interbus *self)
{
    const dg_ns time = 2u * self->handled + self->jitter;
    return time > SETTLE_MIN ? time : SETTLE_MIN;
}

static bool write_ring_out(struct interbus *self, uint32_t out, struct cf_report *report)
{
    if (!self->settled) {
        verify_stream_sleep(self->sent + settle_time(self));
    }
    if (!verify_coupler_in(&self->wire, &self->before)) {
        return lose_wire(self, report);
    }
    if (!verify_coupler_out(&self->wire, out)) {
        return self->model.profile == DG_IB_K3
                   ? lose_wire(self, report)
                   : verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                                 "needs a coupler with OUT words for an encoder that has none");
    }
    self->sent = lx_real_now();
    self->settled = false;
    self->out = out;
    self->command = (out & STATUS) != 0 ? out : self->command;
    return true;
}

/* Look at IN until it is right, for `limit` at most. */
static bool look_until(struct interbus *self, bool (*is_right)(uint32_t out, uint32_t in),
                       uint32_t *in, dg_ns limit)
{
    for (;;) {
        if (!verify_coupler_in(&self->wire, in)) {
            return false;
        }
        const dg_ns took = lx_real_now() - self->sent;
        if (is_right(self->out, *in)) {
            self->handled = took > self->handled ? took : self->handled;
            self->settled = true;
            return true;
        }
        if (took > limit) {
            return false;
        }
        verify_stream_sleep(lx_real_now() + LOOK);
    }
}

bool verify_interbus_exchange(struct interbus *self, uint32_t out,
                              bool (*is_right)(uint32_t out, uint32_t in), uint32_t *in)
{
    struct cf_report ignored = {""};
    return write_ring_out(self, out, &ignored) &&
           look_until(self, is_right, in, ANSWER_MAX + self->jitter);
}

static bool has_read_out(uint32_t out, uint32_t in)
{
    (void)out;
    return (in & STATUS) == DG_IB_READ_OUT;
}

static bool is_in_operation(uint32_t out, uint32_t in)
{
    (void)out;
    return (in & STATUS) == 0;
}

bool verify_interbus_read(struct interbus *self, uint32_t word, uint32_t *value)
{
    uint32_t in = 0;
    const bool read = verify_interbus_exchange(self, word, has_read_out, &in);
    *value = in & DG_IB_DATA_MASK;
    if ((word & 0xFFFF0000u) != READ_ITEM) {
        (void)verify_interbus_exchange(self, RELEASE, is_in_operation, &in); /* it is held */
    }
    return verify_interbus_exchange(self, 0, is_in_operation, &in) && read;
}

bool verify_interbus_settle(struct interbus *self, struct cf_report *report)
{
    uint32_t in = 0;
    bool back = self->model.profile != DG_IB_K3;
    if (back) {
        (void)verify_coupler_out(&self->wire, 0);
        self->settled = true;
    }
    for (unsigned i = 0; i < 3 && !back; i++) {
        back = (write_ring_out(self, 0, report) &&
                look_until(self, is_in_operation, &in, settle_time(self))) ||
               (verify_interbus_exchange(self, RELEASE, is_in_operation, &in) &&
                verify_interbus_exchange(self, 0, is_in_operation, &in));
    }
    return back || verify_fail(&self->base, VERIFY_LOST, report,
                               "it does not return to operation: IN %08lX", (unsigned long)in);
}

/* --- what is compared --- */

enum kind {
    CONSTANT,   /* it is what the model says */
    CONFIGURED, /* so it is as delivered, but somebody may have changed it */
    MEASURED,   /* any value is right */
    OWN,        /* the encoder's own, and the model has the same */
    POSITION    /* near to the model's */
};

static uint32_t range_of(const struct dg_ib_model *model)
{
    return (uint32_t)model->steps * model->turns;
}

/* The last turn is next to the first one. */
bool verify_interbus_is_near(const struct interbus *self, uint32_t a, uint32_t b)
{
    const uint32_t range = range_of(&self->model);
    const uint32_t up = (a % range + range - b % range) % range;
    return a < range && b < range && (up <= self->moves || range - up <= self->moves);
}

static enum kind kind_of_item(uint32_t item)
{
    if ((item & 0xFu) == ITEM_CHIP) {
        return MEASURED;
    }
    switch (item) {
    case ITEM_SERIAL:
    case ITEM_VERSION:
        return OWN;
    case ITEM_TIME:
    case ITEM_TEMPERATURE:
        return MEASURED;
    case ITEM_FLAGS:
        return CONSTANT;
    default:
        return CONFIGURED;
    }
}

/* What IN is behind `command`, the last OUT that was one. */
static enum kind kind_of_word(const struct interbus *self, uint32_t in)
{
    if (self->model.profile != DG_IB_K3 || (in & STATUS) == 0) {
        return POSITION;
    }
    if (!has_read_out(0, in)) {
        return CONSTANT;
    }
    if ((self->command & 0xFFFF0000u) != READ_ITEM) {
        return CONFIGURED;
    }
    const uint32_t item = self->command & 0xFFFFu;
    return self->chosen && item == ITEM_MODE ? CONSTANT : kind_of_item(item);
}

static bool is_right(const struct interbus *self, uint32_t expected, uint32_t came)
{
    const enum kind kind = kind_of_word(self, expected);
    if (kind == POSITION) {
        return verify_interbus_is_near(self, came, expected);
    }
    return kind == MEASURED ? has_read_out(0, came) : came == expected;
}

/* Whether the model, which is in the encoder's state, still says what the row is about. */
static bool is_as_delivered(const struct interbus *self, uint32_t wanted, uint32_t got)
{
    const enum kind kind = kind_of_word(self, got);
    if (kind == POSITION) {
        return self->delivered && kind_of_word(self, wanted) == POSITION;
    }
    return wanted == got || (kind != CONSTANT && kind != CONFIGURED && has_read_out(0, wanted));
}

/* --- beside the model --- */

static bool on_sent(void *ctx, const struct cf_unit *request, struct cf_report *report)
{
    return write_ring_out(ctx, dg_load_be32(request->bytes), report);
}

static bool report_word(struct interbus *self, uint32_t expected, uint32_t came,
                        struct cf_report *report)
{
    if (kind_of_word(self, expected) == CONFIGURED && has_read_out(0, came)) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                           "needs the value of %08lX as delivered", (unsigned long)self->command);
    }
    return verify_fail(&self->base, VERIFY_DIFFERS, report,
                       "sent %08lX; expected %08lX; came %08lX", (unsigned long)self->out,
                       (unsigned long)expected, (unsigned long)came);
}

/* IN becomes what is expected, and was only what it was until then. */
static bool await_ring_word(struct interbus *self, uint32_t expected, struct cf_report *report)
{
    const dg_ns until = self->sent + ANSWER_MAX + self->jitter;
    for (;;) {
        uint32_t came = 0;
        if (!verify_coupler_in(&self->wire, &came)) {
            return lose_wire(self, report);
        }
        if (is_right(self, expected, came)) {
            return true;
        }
        const bool waits =
            came == self->before ||
            (is_in_operation(0, self->before) && verify_interbus_is_near(self, came, self->before));
        if (!waits || lx_real_now() >= until) {
            return report_word(self, expected, came, report);
        }
        verify_stream_sleep(lx_real_now() + LOOK);
    }
}

/* It stays that; for longer where it has not changed. */
static bool stay_word(struct interbus *self, uint32_t expected, struct cf_report *report)
{
    const bool changed = !is_right(self, expected, self->before);
    const dg_ns until = changed ? 0 : self->sent + settle_time(self);
    uint32_t came = 0;
    for (unsigned i = 0; i < STAYS || lx_real_now() < until; i++) {
        if (!verify_coupler_in(&self->wire, &came)) {
            return lose_wire(self, report);
        }
        if (!is_right(self, expected, came)) {
            return report_word(self, expected, came, report);
        }
        verify_stream_sleep(lx_real_now() + LOOK);
    }
    return true;
}

/* The answer to position or speed mode, or to a cam program. */
static bool sets_mode(uint32_t in)
{
    return (in & ~1u) == (0xC0000000u | POSITION_MODE) || (in & ~0xFu) == (0xC0000000u | PROGRAM);
}

static bool judge_id(struct interbus *self, const struct cf_answer *answer,
                     struct cf_report *report)
{
    const uint16_t expected = dg_load_be16(answer->got.bytes);
    if (!self->named) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                           "needs a coupler that reports the ID words of its devices");
    }
    return self->id == expected ||
           verify_fail(&self->base, VERIFY_DIFFERS, report,
                       "sent an ID cycle; expected %04X; came %04X", expected, self->id);
}

static bool on_answered(void *ctx, const struct cf_answer *answer, struct cf_report *report)
{
    struct interbus *self = ctx;
    if (answer->got.id == CF_INTERBUS_ID) {
        return judge_id(self, answer, report);
    }
    const uint32_t expected = dg_load_be32(answer->got.bytes);
    if (!is_as_delivered(self, dg_load_be32(answer->want.bytes), expected)) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                           "needs an encoder in its delivery state");
    }
    if (!self->settled && !await_ring_word(self, expected, report)) {
        return false;
    }
    self->settled = stay_word(self, expected, report);
    self->chosen = self->chosen || sets_mode(expected);
    return self->settled;
}

static bool on_waited(void *ctx, uint64_t ns, struct cf_report *report)
{
    const struct interbus *self = ctx;
    const dg_ns least = settle_time(self);
    (void)report;
    verify_stream_sleep(lx_real_now() + (ns > least ? ns : least));
    return true;
}

static bool on_powered(void *ctx, bool on, struct cf_report *report)
{
    struct interbus *self = ctx;
    if (!verify_powered(&self->base, on, report)) {
        return false;
    }
    self->sent = lx_real_now();
    return verify_coupler_in(&self->wire, &self->before) || lose_wire(self, report);
}

static const struct cf_beside_ops beside_ops = {
    .sent = on_sent,
    .answered = on_answered,
    .waited = on_waited,
    .powered = on_powered,
    .needs = verify_allowed,
};

/* --- rows --- */

static void rehearse(struct verify_encoder *base, const struct cf_beside *beside, dg_ns slack)
{
    struct interbus *self = of(base);
    const struct cf_interbus_trial trial = {
        .model = &self->model, .slack = slack, .beside = *beside};
    self->writes = 0;
    cf_interbus_try(&trial);
}

/* Words of cams, and the modes they act in: what was set of a cam cannot be taken back, and is seen
   in every row behind. */
static bool is_of_cams(uint32_t out)
{
    const bool edge = (out >> 30 == 1u) && (out & ~0x20000000u) != 0x40000000u;
    const bool program = (out & 0xFFFFFFF0u) == 0x20800000u && out != 0x20800000u;
    const bool mask = (out & 0xFFFF0000u) == 0x20400000u && out > 0x20400001u;
    return edge || program || mask;
}

/* Words that are no command, those that read, and those that there are not: of the profile's (9.1)
   0Ch and those from 10h on; with bit 31 all but the release. */
static bool changes_nothing(uint32_t out)
{
    const uint32_t code = out >> 25;
    return code == 0 || code == 0x06u || (code >= 0x08u && code < 0x10u) || out >> 31 != 0 ||
           (out & 0xFFFF0000u) == READ_ITEM || (out & 0xFFFFFF00u) == READ_BACK;
}

/* Steps, revolutions, direction, zero shift; shift_iw; position or speed. */
static bool can_be_put_back(uint32_t out)
{
    const uint32_t code = out >> 25;
    return (code >= 0x01u && code <= 0x03u) || code == 0x05u || out >> 8 == 0x201000u ||
           (out & ~1u) == 0x20400000u || out == 0x20800000u;
}

static unsigned needs_of(struct verify_encoder *base, const struct cf_unit *request)
{
    const uint32_t out = dg_load_be32(request->bytes);
    struct interbus *self = of(base);
    if (is_of_cams(out)) {
        return CF_INSIDE;
    }
    const unsigned needs = changes_nothing(out)   ? 0u
                           : can_be_put_back(out) ? CF_WRITE
                                                  : CF_WRITE | CF_ONE_WAY;
    self->writes |= needs;
    return needs;
}

static bool begin(struct verify_encoder *base, struct cf_report *report)
{
    struct interbus *self = of(base);
    uint32_t in = 0;
    if (!verify_interbus_settle(self, report)) {
        return false;
    }
    if (!verify_coupler_in(&self->wire, &in)) {
        return lose_wire(self, report);
    }
    base->outcome = VERIFY_AGREES;
    self->command = 0;
    self->chosen = false;
    self->trial.model = &self->model;
    self->trial.placed = true;
    self->trial.raw = in;
    self->trial.beside = (struct cf_beside){&beside_ops, self};
    cf_interbus_try(&self->trial);
    if (base->journal != NULL && self->writes != 0 &&
        (!verify_interbus_note(self) || !verify_journal_sync(base->journal))) {
        return verify_fail(base, VERIFY_LOST, report, "the journal cannot be written");
    }
    return true;
}

static bool end(struct verify_encoder *base, struct cf_report *report)
{
    const enum verify_outcome outcome = base->outcome;
    const bool there = verify_interbus_settle(of(base), report);
    base->outcome = there ? outcome : base->outcome;
    return there;
}

/* --- the encoder --- */

static bool is_no_item(uint32_t out, uint32_t in)
{
    (void)out;
    return in >> 25 == DG_IB_UNKNOWN_ITEM >> 25;
}

/* One that it does not know is a matter of the rows: not `told`. @return false: it does not answer */
static bool read_parameter(struct interbus *self, uint32_t item, uint32_t *value, bool *told)
{
    uint32_t in = 0;
    *told = verify_interbus_read(self, READ_ITEM | item, value);
    return *told || (verify_interbus_exchange(self, READ_ITEM | item, is_no_item, &in) &&
                     verify_interbus_exchange(self, 0, is_in_operation, &in));
}

/* Whether the parameters are as delivered; and what is its own. */
static bool read_parameters(struct interbus *self)
{
    struct dg_ib_model *model = &self->model;
    uint32_t value = 0;
    const struct {
        uint32_t item;
        uint32_t delivered;
    } parameters[] = {
        {ITEM_STEPS, (uint32_t)model->steps - (model->steps_minus_one ? 1u : 0u)},
        {ITEM_REVOLUTIONS, 1},
        {ITEM_DIRECTION, 3},
        {ITEM_PRESET, 0},
        {ITEM_SHIFT, 0},
        {ITEM_MODE, DG_IB_POSITION},
    };
    self->delivered = true;
    for (size_t i = 0; i < DG_COUNT(parameters); i++) {
        bool told = false;
        if (!read_parameter(self, parameters[i].item, &value, &told)) {
            return false;
        }
        self->delivered = self->delivered && (!told || value == parameters[i].delivered);
    }
    model->temperature_sensor = verify_interbus_read(self, READ_ITEM | ITEM_TEMPERATURE, &value);
    return verify_interbus_read(self, READ_ITEM | ITEM_SERIAL, &model->serial) &&
           verify_interbus_read(self, READ_ITEM | ITEM_VERSION, &model->version);
}

static int identify_encoder(struct interbus *self, const char *where, struct lx_error *error)
{
    static const char right[] =
        "expected an encoder in operation, first in the ring of a coupler with the registers of "
        "'drehgeber map'";
    struct cf_report report = {""};
    const uint16_t id = dg_ib_id_word(&self->model);
    self->named = verify_coupler_id(&self->wire, &self->id);
    if (self->named && self->id != id) {
        return lx_refuse(error, right, "%s: its ID word is %04X, not %04X", where, self->id, id);
    }
    self->delivered = true;
    if (self->model.profile != DG_IB_K3) {
        (void)snprintf(self->base.identity, sizeof self->base.identity, "ID word %04Xh", id);
        return 0;
    }
    uint32_t in = 0;
    if (!verify_interbus_exchange(self, 0, is_in_operation, &in)) {
        return lx_refuse(error, right, "%s: no position, IN is %08lX", where, (unsigned long)in);
    }
    if (!read_parameters(self) || !verify_interbus_settle(self, &report)) {
        return lx_refuse(error, right, "%s: it does not answer a read-out", where);
    }
    (void)snprintf(self->base.serial, sizeof self->base.serial, "%lu",
                   (unsigned long)self->model.serial);
    (void)snprintf(self->base.identity, sizeof self->base.identity,
                   "ID word %04Xh, software version %lXh%s", id, (unsigned long)self->model.version,
                   self->delivered ? "" : ", parameters not as delivered");
    return 0;
}

/* How far readings of a shaft at rest, and times of answers, are apart. */
static int measure_ring(struct interbus *self, const char *where, struct lx_error *error)
{
    dg_ns shortest = DG_NEVER;
    dg_ns longest = 0;
    uint32_t first = 0;
    for (unsigned i = 0; i < READINGS; i++) {
        uint32_t now = 0;
        const dg_ns from = lx_real_now();
        if (!verify_coupler_in(&self->wire, &now)) {
            return lx_fail(error, "%s: the coupler does not answer", where);
        }
        const dg_ns took = lx_real_now() - from;
        shortest = took < shortest ? took : shortest;
        longest = took > longest ? took : longest;
        while (i > 0 && self->delivered && !verify_interbus_is_near(self, now, first) &&
               self->moves <= MOVES_MAX) {
            self->moves++;
        }
        first = i == 0 ? now : first;
        verify_stream_sleep(lx_real_now() + DG_MS(5));
    }
    if (self->moves > MOVES_MAX) {
        return lx_refuse(error, "expected a shaft at rest", "%s: the shaft turns", where);
    }
    self->moves = 2u * self->moves + 1u;
    self->jitter = longest - shortest;
    return 0;
}

/* The image of the ring is longer when others are in it. */
static int scan(struct verify_encoder *base, struct lx_error *error)
{
    struct interbus *self = of(base);
    uint16_t words = 0;
    if (!verify_coupler_ring(&self->wire, &words)) {
        return lx_fail(error, "the coupler does not report how many words its ring has");
    }
    return words == self->wire.words
               ? 0
               : lx_refuse(error, "without --alone, verify disturbs no other device",
                           "another device is in the ring: it has %u words", (unsigned)words);
}

static void close_encoder(struct verify_encoder *base)
{
    struct interbus *self = of(base);
    cf_interbus_try(NULL);
    verify_coupler_close(&self->wire);
}

static int open_encoder(struct verify_encoder *base, const struct options *options,
                        struct lx_error *error)
{
    struct interbus *self = of(base);
    self->model = *dg_ib_model_of(options->device);
    self->settled = true;
    return verify_coupler_open(&self->wire, options->where, dg_ib_image_words(&self->model), error);
}

static int identify(struct verify_encoder *base, const char *where, struct lx_error *error)
{
    const int identified = identify_encoder(of(base), where, error);
    return identified != 0 ? identified : measure_ring(of(base), where, error);
}

const struct verify_protocol verify_interbus = {
    .stack = &dg_ib_stack,
    .suites = {"interbus"},
    .choices = "ID",
    .writes = "steps, revolutions, direction, zero shift, shift_iw, position or speed mode",
    .rows = cf_interbus,
    .wire = "modbus",
    .expects = "expected --modbus=HOST:PORT",
    .size = sizeof(struct interbus),
    .open = open_encoder,
    .identify = identify,
    .scan = scan,
    .rehearse = rehearse,
    .needs = needs_of,
    .begin = begin,
    .end = end,
    .put_back = verify_interbus_put_back,
    .close = close_encoder,
};

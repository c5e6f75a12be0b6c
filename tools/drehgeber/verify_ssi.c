/* SPDX-License-Identifier: MIT */
/*
 * A real encoder with SSI against its clauses. The model beside it is where the encoder was when the
 * row began. The encoder has to send what the model sends; or what the model would send from where
 * readings at rest were seen, bit for bit:
 *
 *   model    1101111111110 0 1101111111110
 *   encoder  1101111111111 0 1101111111111    a count away, and both times the same
 */
#include <stdlib.h>
#include <string.h>

#include "ssi_steps.h"
#include "timer.h"
#include "verify_lines.h"
#include "verify_parts.h"
#include "verify_stream.h"

#define READINGS 20u
#define MOVES_MAX 8
/* Words that have to be the same before a clock is said to suit the encoder, and others among them. */
#define WORDS_SAME 6u
#define WORDS_OTHER 6u
/* How often a word is asked for that was torn, or is not where the one before was. */
#define READS_MAX 5u
/* What a wait is longer, so that the encoder's own times are over. */
#define WAIT_ADDS DG_US(100)

struct ssi {
    struct verify_encoder base;
    struct verify_lines wire;
    struct dg_ssi_model model;
    struct cf_ssi_trial trial;
    uint64_t latest;         /* position of the word that came last */
    int64_t moves;           /* counts between readings at rest */
    struct cf_ssi_look came; /* as it was asked last */
    bool data;               /* at the latest look */
    bool strayed;            /* data has moved with a falling edge, or so late after a rising one */
};

static struct ssi *of(struct verify_encoder *base)
{
    return (struct ssi *)base;
}

/* --- the master --- */

/* The clock goes to `level`. @return data before it moves again */
static bool clock_edge(struct ssi *self, bool level)
{
    struct verify_lines *wire = &self->wire;
    verify_lines_clock(wire, wire->edge + wire->half, level);
    const bool data = verify_lines_data(wire, wire->edge + wire->half * 3u / 4u);
    self->strayed = self->strayed || (!level && data != self->data);
    self->data = data;
    return data;
}

static void begin_clocking(struct ssi *self)
{
    verify_lines_begin(&self->wire);
    self->data = verify_lines_data(&self->wire, 0);
    self->strayed = false;
}

static void clock_pulses(struct ssi *self, struct cf_ssi_look *look)
{
    begin_clocking(self);
    for (unsigned i = 0; i < look->pulses; i++) {
        (void)clock_edge(self, false);
        look->data[i] = clock_edge(self, true) ? '1' : '0';
    }
    look->data[look->pulses] = '\0';
    if (look->rests) {
        (void)verify_lines_rest(&self->wire);
    }
}

static void clock_edges(struct ssi *self, struct cf_ssi_look *look)
{
    size_t n = 0;
    begin_clocking(self);
    for (; look->clock[n] != '\0'; n++) {
        look->data[n] = clock_edge(self, look->clock[n] == '1') ? '1' : '0';
    }
    look->data[n] = '\0';
}

static void look_later(struct ssi *self, struct cf_ssi_look *look)
{
    self->strayed = false;
    const dg_ns at = lx_real_now() + look->wait_ns + WAIT_ADDS + 16u * self->trial.half_ns;
    look->data[0] = verify_lines_data(&self->wire, at) ? '1' : '0';
    look->data[1] = '\0';
}

/* --- positions --- */

static uint64_t ssi_range_of(const struct ssi *self)
{
    return (uint64_t)1 << (self->model.multiturn_bits + self->model.singleturn_bits);
}

/* The clock rests until any word is over. Data that is high does not say so: it may be a bit of a word, and
   there are encoders that want to see the clock high before they begin another one. */
static void end_any_word(const struct ssi *self)
{
    verify_stream_sleep(lx_real_now() + 2u * self->model.monoflop + WAIT_ADDS);
}

/* A word on its own: a 1 in front of it, and a 0 behind. @return whether it was whole */
static bool read_whole_word(struct ssi *self, struct dg_ssi_frame *frame)
{
    const unsigned bits = dg_ssi_word_bits(&self->model);
    struct cf_ssi_look look = {.pulses = bits + 1u, .rests = true};
    const bool rested = verify_lines_rest(&self->wire);
    clock_pulses(self, &look);
    const char last = look.data[bits];
    look.data[bits] = '\0';
    return rested && last == '0' && !self->strayed && !self->wire.gone &&
           !verify_lines_torn(&self->wire) && verify_lines_rest(&self->wire) &&
           dg_ssi_frame_decode(&self->model, strtoull(look.data, NULL, 2), frame) == DG_OK;
}

static uint64_t distance_of(const struct ssi *self, uint64_t a, uint64_t b)
{
    const uint64_t up = (a + ssi_range_of(self) - b) % ssi_range_of(self);
    return up <= ssi_range_of(self) / 2u ? up : ssi_range_of(self) - up;
}

/* @return whether the word is where the one before was */
static bool is_at_rest(struct ssi *self, const struct dg_ssi_frame *frame)
{
    const bool at_rest = distance_of(self, frame->position, self->latest) <= MOVES_MAX;
    self->latest = frame->position;
    return at_rest;
}

/* SSI has no check sum: a word that a busy host has torn can look whole, but hardly twice the same.
   Of a shaft that turns it is the latest. @return false: none was whole */
static bool read_at_rest(struct ssi *self, struct dg_ssi_frame *frame)
{
    struct dg_ssi_frame next;
    bool whole = false;
    bool at_rest = false;
    for (unsigned i = 0; !at_rest && i < READS_MAX; i++) {
        end_any_word(self);
        if (read_whole_word(self, &next)) {
            *frame = next;
            at_rest = is_at_rest(self, frame);
            whole = true;
        }
    }
    return whole;
}

static dg_angle stand_still(void *ctx, dg_ns now)
{
    (void)now;
    return *(const dg_angle *)ctx;
}

/* What a healthy encoder sends where it is `moved` counts from the model. */
static uint64_t make_word(const struct ssi *self, int64_t moved)
{
    dg_angle angle = (self->trial.raw + moved) * (DG_TURN >> self->model.singleturn_bits);
    struct dg_world world;
    struct dg_ssi device;
    uint64_t word = 0;
    dg_world_init(&world);
    world.angle = stand_still;
    world.angle_ctx = &angle;
    if (dg_ssi_init(&device, &(struct dg_ssi_setup){&self->model, &world}) == DG_OK) {
        dg_ssi_power_on(&device, 0);
        (void)dg_ssi_step(&device, DG_S(10));
        (void)dg_ssi_frame(&device, DG_S(10), &word);
    }
    return word;
}

static char word_bit(uint64_t word, int bits, int bit)
{
    return (word >> (bits - 1 - bit) & 1u) != 0 ? '1' : '0';
}

/* Whether `came` is what the model has sent, from `moved` counts away. */
static bool is_sent_from(const struct ssi *self, const struct cf_ssi_look *got,
                         const struct cf_ssi_look *came, int64_t moved)
{
    const int bits = dg_ssi_word_bits(&self->model);
    const uint64_t here = make_word(self, 0);
    const uint64_t there = make_word(self, moved);
    for (size_t i = 0; got->data[i] != '\0'; i++) {
        const int bit = cf_ssi_bit(got, &self->model, i);
        const bool of_word = bit >= 0 && bit < bits && got->data[i] == word_bit(here, bits, bit);
        if (came->data[i] != (of_word ? word_bit(there, bits, bit) : got->data[i])) {
            return false;
        }
    }
    return came->data[strlen(got->data)] == '\0';
}

/* --- beside the model --- */

static bool on_sent(void *ctx, const struct cf_unit *request, struct cf_report *report)
{
    static void (*const kinds[])(struct ssi * self, struct cf_ssi_look * look) = {
        [CF_SSI_PULSES] = clock_pulses,
        [CF_SSI_EDGES] = clock_edges,
        [CF_SSI_LEVEL] = look_later,
    };
    struct ssi *self = ctx;
    memcpy(&self->came, request->bytes, sizeof self->came);
    kinds[request->id](self, &self->came);
    self->base.held_up = self->base.held_up || verify_lines_torn(&self->wire);
    return !self->wire.gone || verify_fail(&self->base, VERIFY_LOST, report, "the lines are gone");
}

static bool report_look(struct ssi *self, uint16_t kind, const struct cf_ssi_look *got,
                        struct cf_report *report)
{
    const struct cf_ssi_look *came = &self->came;
    char sent[CF_SSI_BITS_MAX + 40u];
    if (kind == CF_SSI_LEVEL) {
        (void)snprintf(sent, sizeof sent, "no edge for %llu us",
                       (unsigned long long)came->wait_ns / 1000u);
    } else if (kind == CF_SSI_EDGES) {
        (void)snprintf(sent, sizeof sent, "clock %s", came->clock);
    } else {
        (void)snprintf(sent, sizeof sent, "%u pulses", came->pulses);
    }
    return verify_fail(&self->base, self->base.held_up ? VERIFY_NOT_SEEN : VERIFY_DIFFERS, report,
                       "sent %s; expected data %.300s; came %.300s%s%s", sent, got->data,
                       came->data, self->strayed ? ", and moved with a falling edge" : "",
                       self->base.held_up ? "; this host was held up" : "");
}

static bool on_answered(void *ctx, const struct cf_answer *answer, struct cf_report *report)
{
    struct ssi *self = ctx;
    struct cf_ssi_look got;
    memcpy(&got, answer->got.bytes, sizeof got);
    if (answer->want.bytes == NULL) {
        return verify_fail(&self->base, VERIFY_NOT_SEEN, report,
                           "needs an encoder in the row's state");
    }
    for (int64_t moved = -self->moves; moved <= self->moves && !self->strayed; moved++) {
        if (is_sent_from(self, &got, &self->came, moved)) {
            return true;
        }
    }
    return report_look(self, answer->got.id, &got, report);
}

static bool on_waited(void *ctx, uint64_t ns, struct cf_report *report)
{
    (void)ctx;
    (void)report;
    verify_stream_sleep(lx_real_now() + ns);
    return true;
}

static const struct cf_beside_ops beside_ops = {
    .sent = on_sent,
    .answered = on_answered,
    .waited = on_waited,
    .powered = verify_powered,
    .needs = verify_allowed,
};

/* --- rows --- */

static void rehearse(struct verify_encoder *base, const struct cf_beside *beside, dg_ns slack)
{
    const struct ssi *self = of(base);
    const struct cf_ssi_trial trial = {
        .model = &self->model,
        .half_ns = slack > 0 ? self->wire.half : 0,
        .slack = slack,
        .beside = *beside,
    };
    cf_ssi_try(&trial);
}

/* Whoever clocks reads: there is nothing to obey, and nothing to change. */
static unsigned needs_of(struct verify_encoder *base, const struct cf_unit *request)
{
    (void)base;
    (void)request;
    return 0;
}

static bool begin(struct verify_encoder *base, struct cf_report *report)
{
    struct ssi *self = of(base);
    struct dg_ssi_frame frame;
    if (!read_at_rest(self, &frame)) {
        return verify_fail(base, VERIFY_LOST, report, "it sends no whole word any more");
    }
    base->outcome = VERIFY_AGREES;
    self->trial.model = &self->model;
    self->trial.placed = true;
    self->trial.raw = (int64_t)frame.position;
    self->trial.half_ns = self->wire.half;
    self->trial.beside = (struct cf_beside){&beside_ops, self};
    cf_ssi_try(&self->trial);
    return true;
}

/* A row may end in the middle of a word, or with the clock low. */
static bool end(struct verify_encoder *base, struct cf_report *report)
{
    const enum verify_outcome outcome = base->outcome;
    struct ssi *self = of(base);
    struct dg_ssi_frame frame;
    verify_lines_clock(&self->wire, lx_real_now(), true);
    if (!read_at_rest(self, &frame)) {
        return verify_fail(base, VERIFY_LOST, report, "it sends no whole word any more");
    }
    base->outcome = outcome;
    return true;
}

/* --- the encoder --- */

/* A slow clock is for an encoder whose monoflop time is as slow. */
static void suit_model(struct ssi *self)
{
    const dg_ns least = 8u * self->wire.half;
    self->model.monoflop = least > self->model.monoflop ? least : self->model.monoflop;
}

/* @return whether this clock suits the encoder */
static bool try_clock(struct ssi *self, bool *turns)
{
    struct dg_ssi_frame frame;
    unsigned same = 0;
    for (unsigned i = 0; i < WORDS_SAME + WORDS_OTHER && same < WORDS_SAME; i++) {
        if (read_whole_word(self, &frame)) {
            const bool at_rest = is_at_rest(self, &frame);
            same += at_rest ? 1u : 0u;
            *turns = !at_rest;
        }
    }
    return same == WORDS_SAME;
}

static int refuse_turning(const char *where, struct lx_error *error)
{
    return lx_refuse(error, "expected a shaft at rest", "%s: the shaft turns", where);
}

/* An encoder with a monoflop time of its own may not follow the clock that settles. */
static int find_ssi_clock(struct ssi *self, const char *where, struct lx_error *error)
{
    bool turns = false;
    do {
        const dg_ns half = self->wire.half;
        if (try_clock(self, &turns)) {
            verify_lines_settle(&self->wire);
            if (self->wire.half != half && !try_clock(self, &turns)) {
                self->wire.half = half;
            }
            suit_model(self);
            return 0;
        }
    } while (verify_lines_slow_down(&self->wire));
    return turns ? refuse_turning(where, error)
                 : lx_refuse(error, "expected clock and data of an encoder with its supply",
                             "%s: no word that ends with a 0 and rests with a 1", where);
}

/* How far readings of a shaft at rest are apart. */
static int measure_ssi_shaft(struct ssi *self, const char *where, struct lx_error *error)
{
    struct dg_ssi_frame frame;
    uint64_t first = 0;
    uint64_t moves = 0;
    for (unsigned i = 0; i < READINGS; i++) {
        if (!read_at_rest(self, &frame)) {
            return lx_fail(error, "%s: it sends no whole word any more", where);
        }
        first = i == 0 ? frame.position : first;
        const uint64_t moved = distance_of(self, frame.position, first);
        moves = moved > moves ? moved : moves;
        verify_stream_sleep(lx_real_now() + DG_MS(5));
    }
    if (moves > MOVES_MAX) {
        return refuse_turning(where, error);
    }
    if (frame.error) {
        return lx_refuse(error, "expected a healthy one", "%s: the encoder reports an error",
                         where);
    }
    self->moves = 2 * (int64_t)moves + 1;
    return 0;
}

static int identify(struct verify_encoder *base, const char *where, struct lx_error *error)
{
    struct ssi *self = of(base);
    if (find_ssi_clock(self, where, error) != 0 || measure_ssi_shaft(self, where, error) != 0) {
        return -1;
    }
    (void)snprintf(base->identity, sizeof base->identity, "words of %u bits, clock %llu Hz",
                   (unsigned)dg_ssi_word_bits(&self->model),
                   (unsigned long long)(DG_S(1) / (2u * self->wire.half)));
    return 0;
}

static int open_encoder(struct verify_encoder *base, const struct options *options,
                        struct lx_error *error)
{
    struct ssi *self = of(base);
    self->model = *dg_ssi_model_of(options->device);
    return verify_lines_open(&self->wire, options->where, error);
}

/* Two lines lead to one encoder. */
static int scan(struct verify_encoder *base, struct lx_error *error)
{
    (void)base;
    (void)error;
    return 0;
}

static void close_encoder(struct verify_encoder *base)
{
    cf_ssi_try(NULL);
    verify_lines_close(&of(base)->wire);
}

const struct verify_protocol verify_ssi = {
    .stack = &dg_ssi_stack,
    .suites = {"ssi"},
    .choices = "S",
    .rows = cf_ssi,
    .wire = "gpio",
    .expects = "expected --gpio=CHIP:CLOCK,DATA",
    .size = sizeof(struct ssi),
    .open = open_encoder,
    .identify = identify,
    .scan = scan,
    .rehearse = rehearse,
    .needs = needs_of,
    .begin = begin,
    .end = end,
    .close = close_encoder,
};

/* SPDX-License-Identifier: MIT */
/*
 *   clock  ¯¯|__|¯¯|__|¯¯ ... ¯|__|¯¯|__|¯¯¯¯¯
 *   data   ¯¯¯¯¯|MSB  | ...    |LSB  |_________|¯¯
 *   master    1?   bits             0?
 *
 * The master of a simulated wire takes data for a word that is still high behind the first falling
 * edge, and low behind the last bit. SSI has nothing to measure the cable by: it is told how long
 * it is, and takes each sample later by the way there and back.
 */
#include "ssi_clocked.h"

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "sim_bus.h"
#include "trace_format.h"

#define CLOCK_NAME "CLOCK"
#define DATA_NAME "DATA"
/* A master waits a little longer than the monoflop time. */
#define PAUSE_NS DG_US(5)
/* Ends a word on GPIO lines; see src/ssi/README.md, 'GPIO'. */
#define GPIO_MONOFLOP DG_MS(20)

static struct lx_ssi_line *line_of(struct lx_clocked *base)
{
    return (struct lx_ssi_line *)base;
}

static const struct lx_ssi_line *view_of(const struct lx_clocked *base)
{
    return (const struct lx_ssi_line *)base;
}

static struct dg_ssi *device_of(const struct lx_clocked *base)
{
    return lx_clocked_device(base, 0);
}

static const struct dg_ssi_model *model_of(const struct lx_clocked *base)
{
    return device_of(base)->setup.model;
}

/* Those of the word, and the one behind it. */
static uint32_t rises(const struct lx_clocked *base)
{
    return dg_ssi_word_bits(model_of(base)) + 1u;
}

/* --- words --- */

/* What belongs to `at` at the master's end. */
static bool take_sample(const struct lx_clocked_wire *wire, dg_ns at)
{
    return dg_bus_edges_data(wire->line->bus, at + wire->delay);
}

/* What the master sees when the clock is about to move again. */
static bool look(const struct lx_clocked_wire *wire)
{
    return take_sample(wire, wire->now + wire->half_ns);
}

/* Each bit is taken with the falling edge behind it, by which the monoflop time of a clock that is
   too slow is over. */
static void read_frame(struct lx_clocked *base, struct lx_clocked_wire *wire)
{
    struct lx_ssi_line *self = line_of(base);
    const struct dg_ssi_model *model = model_of(base);
    uint64_t bits = 0;
    self->frame.before = device_of(base)->counters;
    wire->delay = wire->compensates ? wire->way_ns : 0;
    lx_clocked_wire_edge(wire, false);
    const bool high = look(wire);
    lx_clocked_wire_edge(wire, true);
    for (uint8_t left = dg_ssi_word_bits(model); left > 0; left--) {
        lx_clocked_wire_edge(wire, false);
        bits = bits << 1 | take_sample(wire, wire->now);
        lx_clocked_wire_edge(wire, true);
    }
    self->frame.bits = bits;
    self->frame.answered = high && !look(wire);
    wire->silent += !self->frame.answered;
    lx_clocked_wire_pause(wire, wire->now + model->monoflop + wire->way_ns + PAUSE_NS);
}

static void skip(struct lx_clocked *base, uint64_t n)
{
    const struct dg_ssi_counters *before = &view_of(base)->frame.before;
    const struct dg_ssi_counters *after = &device_of(base)->counters;
    const struct dg_ssi_counters each = {
        .frames = after->frames - before->frames,
        .repeats = after->repeats - before->repeats,
        .aborted = after->aborted - before->aborted,
        .fast = after->fast - before->fast,
    };
    dg_ssi_skip(device_of(base), &each, n);
}

/* @return whether the parity is right */
static bool take_apart(const struct lx_clocked *base, struct dg_ssi_frame *frame)
{
    const struct lx_ssi_line *self = view_of(base);
    return dg_ssi_frame_decode(model_of(base), self->frame.bits, frame) == DG_OK;
}

static enum lx_clocked_verdict judge(const struct lx_clocked *base, size_t encoder)
{
    struct dg_ssi_frame frame;
    (void)encoder;
    if (!view_of(base)->frame.answered) {
        return LX_CLOCKED_SILENT;
    }
    return take_apart(base, &frame) ? LX_CLOCKED_GOOD : LX_CLOCKED_WRONG;
}

static void word(const struct lx_clocked *base, size_t encoder, struct lx_clocked_word *out)
{
    const struct lx_ssi_line *self = view_of(base);
    struct dg_ssi_frame frame;
    (void)encoder;
    (void)take_apart(base, &frame);
    *out = (struct lx_clocked_word){
        .bits = self->frame.bits,
        .count = dg_ssi_word_bits(model_of(base)),
        .multiturn = frame.multiturn,
        .singleturn = frame.singleturn,
        .error = frame.error,
    };
}

/* What the bits around the position say, if there are any. */
static void add_bits(const struct dg_ssi_model *model, const struct dg_ssi_frame *frame,
                     const char *parity, struct lx_words *to)
{
    if (model->error_bit != DG_SSI_ERROR_NONE) {
        lx_words_add(to, "  error %d", frame->error);
    }
    if (model->parity != DG_SSI_PARITY_NONE) {
        lx_words_add(to, "  parity %s", parity);
    }
    if (model->form != NULL && dg_form_has(model->form->layout, 'T')) {
        lx_words_add(to, "  toggle %d", frame->toggle);
    }
    if (model->form != NULL && dg_form_has(model->form->layout, 'F')) {
        lx_words_add(to, "  power fail %d", frame->power_fail);
    }
}

static void note(const struct lx_clocked *base, const struct lx_clocked_wire *wire, size_t encoder,
                 char *text, size_t size)
{
    struct dg_ssi_frame frame;
    const bool right = take_apart(base, &frame);
    struct lx_words rest = {""};
    (void)wire;
    (void)encoder;
    add_bits(model_of(base), &frame, right ? "ok" : "wrong", &rest);
    (void)snprintf(text, size, "position %" PRIu32 ":%" PRIu32 "%s", frame.multiturn,
                   frame.singleturn, rest.text);
}

static void print(const struct lx_clocked *base, size_t encoder, char *text, size_t size)
{
    const struct dg_ssi_model *model = model_of(base);
    struct dg_ssi_frame frame;
    const bool right = take_apart(base, &frame);
    const double turns = (double)frame.singleturn / (double)(UINT64_C(1) << model->singleturn_bits);
    struct lx_words rest = {""};
    (void)encoder;
    add_bits(model, &frame, right ? "valid" : "WRONG", &rest);
    (void)snprintf(text, size, "MT %" PRIu32 "  ST %" PRIu32 "  %.6f deg%s", frame.multiturn,
                   frame.singleturn, 360.0 * turns, rest.text);
}

/* --- SCPI --- */

static int read_word(void *ctx, uint64_t *bits, char *detail)
{
    struct lx_station *station = ctx;
    const struct lx_clocked *line = lx_sim_bus_begin(station->bus)->wire.line;
    lx_sim_bus_read(station->bus);
    lx_sim_bus_end(station->bus);
    *bits = view_of(line)->frame.bits;
    if (view_of(line)->frame.answered) {
        return DG_SCPI_NO_ERROR;
    }
    (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "no answer");
    return DG_SCPI_HARDWARE;
}

static void offer(struct lx_station *station)
{
    static const struct dg_ssi_port_ops port = {.frame = read_word};
    station->control->port = &port;
    station->control->port_ctx = station;
}

/* --- from a plan --- */

/* A clock that user space can follow is slower than the encoder's own time allows. */
static void slow_down(void *settings)
{
    struct dg_ssi_model *model = settings;
    model->monoflop = GPIO_MONOFLOP;
}

static dg_ns init(const void *settings)
{
    return ((const struct dg_ssi_model *)settings)->init;
}

/* Each falling edge has to come before the monoflop time from the one before is over. The edges of
   the wire are at whole nanoseconds. */
static int check_rate(const void *settings, uint32_t hz, struct lx_error *error)
{
    const dg_ns monoflop = ((const struct dg_ssi_model *)settings)->monoflop;
    const dg_ns period = (DG_S(1) + hz - 1u) / hz;
    struct lx_words right = {""};
    if (period < monoflop) {
        return 0;
    }
    lx_words_add(&right, "expected clock_hz from %u or monoflop_us from %u on",
                 (unsigned)((DG_S(1) + monoflop - 2u) / (monoflop - 1u)),
                 (unsigned)(period / DG_US(1) + 1u));
    return lx_refuse(error, right.text,
                     "its period, %u ns, ends the word, as the monoflop time of %u ns is over",
                     (unsigned)period, (unsigned)monoflop);
}

const struct lx_clocked_protocol lx_clocked_ssi = {
    .clock = CLOCK_NAME,
    .data = DATA_NAME,
    .size = sizeof(struct lx_ssi_line),
    .slow_down = slow_down,
    .init = init,
    .check_rate = check_rate,
    .rises = rises,
    .read = read_frame,
    .skip = skip,
    .judge = judge,
    .word = word,
    .note = note,
    .print = print,
    .offer = offer,
};

/* --- the stack --- */

/* clang-format off */
static const struct dg_key monoflop =
    {"monoflop_us", "us", offsetof(struct dg_ssi_model, monoflop), DG_KEY_NS, 0, 1000, DG_SSI_MONOFLOP_MIN_NS / DG_US(1), DG_SSI_MONOFLOP_MAX_NS / DG_US(1), NULL, "silence on the clock that ends a word; gpio: 20000 unless set"};
/* clang-format on */

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_ssi_model *model = settings;
    const unsigned bits = (unsigned)model->multiturn_bits + model->singleturn_bits;
    const unsigned most =
        model->form == NULL ? DG_SSI_BITS_MAX : DG_SSI_FORM_BITS_MAX - model->form->around;
    const unsigned least = model->form == NULL ? DG_SSI_BITS_MIN : 1u;
    struct lx_words right = {""};
    const bool each =
        model->form != NULL || (model->multiturn_bits <= DG_SSI_MULTITURN_BITS_MAX &&
                                model->singleturn_bits >= DG_SSI_SINGLETURN_BITS_MIN &&
                                model->singleturn_bits <= DG_SSI_SINGLETURN_BITS_MAX);
    if (each && bits >= least && bits <= most) {
        return 0;
    }
    lx_words_add(&right, "together %u to %u bits are right", least, most);
    if (!each) {
        lx_words_add(&right, ", mt 0..%u and st %u..%u", DG_SSI_MULTITURN_BITS_MAX,
                     DG_SSI_SINGLETURN_BITS_MIN, DG_SSI_SINGLETURN_BITS_MAX);
    }
    return lx_refuse(error, right.text, "mt %u and st %u", model->multiturn_bits,
                     model->singleturn_bits);
}

static const struct lx_trace_format vcd = LX_TRACE_CLOCKED("ssi", CLOCK_NAME, DATA_NAME);
const struct lx_stack lx_ssi_stack = {
    .core = &dg_ssi_stack,
    .handle = &dg_ssi_wire,
    .trace = &(const struct lx_trace_kind){"SSI", {&vcd}, false},
    .clocked = &lx_clocked_ssi,
    .wire = "sim",
    .instead = &monoflop,
    .check = check,
};

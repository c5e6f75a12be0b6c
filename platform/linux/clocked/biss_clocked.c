/* SPDX-License-Identifier: MIT */
/*
 * Ack tells the master how long a level needs there and back:
 *
 *   MA   _|1|_|2|_|3|_|4|_|5|_      the clocks go on meanwhile
 *   SLO  ---------.___.---....      Ack here, start bit there
 *          e2 ----^ delay           bit n is sampled half a period behind its clock and the delay
 */
#include "biss_clocked.h"

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>

#include "biss_master.h"
#include "trace_format.h"

#define CLOCK_NAME "MA"
#define DATA_NAME "SLO"
/* Longer than 100 us at 10 MHz, by which a fault puts off a start bit. */
#define START_CLOCKS_MAX 1200u
/* A real master pauses a little longer than the encoder's timeout. */
#define PAUSE_NS 15000u
/* Rising edges of a frame in front of its data: e1, e2, start bit, CDS. */
#define EDGES_AHEAD 4u
/* A start bit later than this is worth a word. */
#define START_MAX DG_BISS_BUSY_S_MAX_NS
/* Ends a frame on GPIO lines; see src/biss/README.md, 'GPIO'. */
#define GPIO_TIMEOUT DG_MS(20)
/* Threads of a host are slower than the encoder's own timeout is short. */
#define TIMEOUT_MIN_US (DG_BISS_TIMEOUT_NS / DG_US(1))
#define TIMEOUT_MAX_US (DG_BISS_TIMEOUT_MAX_NS / DG_US(1))

static struct lx_biss_line *line_of(struct lx_clocked *base)
{
    return (struct lx_biss_line *)base;
}

static const struct lx_biss_line *view_of(const struct lx_clocked *base)
{
    return (const struct lx_biss_line *)base;
}

static const struct dg_biss *device_of(const struct lx_clocked *base, size_t encoder)
{
    return lx_clocked_device(base, encoder);
}

static const struct dg_biss_model *model_of(const struct lx_clocked *base, size_t encoder)
{
    return device_of(base, encoder)->setup.model;
}

static uint32_t rises(const struct lx_clocked *base)
{
    uint32_t edges = EDGES_AHEAD;
    for (size_t i = 0; i < base->count; i++) {
        edges += dg_biss_frame_bits(model_of(base, i));
    }
    return edges;
}

/* --- frames --- */

/* e1 and e2. @return the time of e1 */
static dg_ns await_ack(struct lx_biss_line *self, struct lx_clocked_wire *wire)
{
    wire->delay = 0;
    (void)lx_clocked_wire_bit(wire);
    const dg_ns begin = wire->now;
    (void)lx_clocked_wire_bit(wire);
    const dg_ns fell = dg_bus_edges_fell(wire->line->bus);
    self->frame.answered = fell >= wire->now;
    const bool measured = self->frame.answered && wire->compensates;
    wire->delay = measured ? fell - wire->now : 0;
    wire->silent += !self->frame.answered;
    return begin;
}

bool lx_biss_frame_begin(struct lx_clocked_wire *wire)
{
    struct lx_biss_line *self = lx_biss_line_of(wire);
    const dg_ns begin = await_ack(self, wire);
    for (unsigned i = 0; i < START_CLOCKS_MAX && !lx_clocked_wire_bit(wire); i++) {
    }
    self->frame.start = wire->now - begin;
    const dg_ns known = wire->now + wire->delay + wire->half_ns;
    self->frame.cds = lx_clocked_wire_bit(wire);
    for (size_t i = 0; i < self->base.count; i++) {
        uint64_t bits = 0;
        for (uint8_t left = dg_biss_frame_bits(model_of(&self->base, i)); left > 0; left--) {
            bits = bits << 1 | lx_clocked_wire_bit(wire);
        }
        self->frame.bits[i] = bits;
    }
    /* The master did not know when to end before it had seen the start bit. */
    while (wire->now < known) {
        (void)lx_clocked_wire_bit(wire);
    }
    return self->frame.cds;
}

void lx_biss_frame_end(struct lx_clocked_wire *wire, bool cdm)
{
    if (cdm) {
        lx_clocked_wire_edge(wire, false);
    }
    lx_clocked_wire_pause(wire, wire->now + PAUSE_NS + wire->delay);
    if (cdm) {
        lx_clocked_wire_edge(wire, true);
    }
}

static void read_frame(struct lx_clocked *base, struct lx_clocked_wire *wire)
{
    (void)base;
    (void)lx_biss_frame_begin(wire);
    lx_biss_frame_end(wire, false);
}

static void skip(struct lx_clocked *base, uint64_t n)
{
    for (size_t i = 0; i < base->count; i++) {
        dg_biss_skip(lx_clocked_device(base, i), n);
    }
}

static struct dg_biss_data data_of(const struct lx_clocked *base, size_t encoder)
{
    const struct lx_biss_line *self = view_of(base);
    struct dg_biss_data data;
    dg_biss_frame_decode(model_of(base, encoder), self->frame.bits[encoder], &data);
    return data;
}

static enum lx_clocked_verdict judge(const struct lx_clocked *base, size_t encoder)
{
    if (!view_of(base)->frame.answered) {
        return LX_CLOCKED_SILENT;
    }
    return data_of(base, encoder).crc_ok ? LX_CLOCKED_GOOD : LX_CLOCKED_WRONG;
}

static void word(const struct lx_clocked *base, size_t encoder, struct lx_clocked_word *out)
{
    const struct lx_biss_line *self = view_of(base);
    const struct dg_biss_data data = data_of(base, encoder);
    *out = (struct lx_clocked_word){
        .bits = self->frame.bits[encoder],
        .count = dg_biss_frame_bits(model_of(base, encoder)),
        .multiturn = data.multiturn,
        .singleturn = data.singleturn,
        .error = !data.n_err,
        .warning = !data.n_warn,
        .life = data.life,
    };
}

static void note(const struct lx_clocked *base, const struct lx_clocked_wire *wire, size_t encoder,
                 char *text, size_t size)
{
    const struct dg_biss_data data = data_of(base, encoder);
    const dg_ns start = view_of(base)->frame.start;
    int n = snprintf(text, size, "position %" PRIu32 ":%" PRIu32 " nERR %d nWARN %d LC %u CRC %s",
                     data.multiturn, data.singleturn, data.n_err, data.n_warn, data.life,
                     data.crc_ok ? "ok" : "wrong");
    if (start > START_MAX) {
        n += snprintf(text + n, size - (size_t)n, ", start bit after %" PRIu64 " us",
                      start / DG_US(1));
    }
    if (wire->delay > 0) {
        (void)snprintf(text + n, size - (size_t)n, ", line delay %" PRIu64 " ns", wire->delay);
    }
}

static void print(const struct lx_clocked *base, size_t encoder, char *text, size_t size)
{
    const struct dg_biss_data data = data_of(base, encoder);
    const uint8_t st_bits = model_of(base, encoder)->singleturn_bits;
    const double turns = (double)data.singleturn / (double)(UINT64_C(1) << st_bits);
    (void)snprintf(text, size,
                   "MT %" PRIu32 "  ST %" PRIu32 "  %.6f deg  nERR %d  nWARN %d  LC %u  CRC %s",
                   data.multiturn, data.singleturn, 360.0 * turns, data.n_err, data.n_warn,
                   data.life, data.crc_ok ? "valid" : "WRONG");
}

struct lx_biss_line *lx_biss_line_of(const struct lx_clocked_wire *wire)
{
    return line_of(wire->line);
}

/* --- from a plan --- */

/* A clock that user space can follow is slower than the encoder's own timeout allows. */
static void slow_down(void *settings)
{
    struct dg_biss_model *model = settings;
    model->timeout = model->timeout == 0 ? GPIO_TIMEOUT : model->timeout;
}

/* On a simulated wire the master leaves an encoder the time it has of its own. */
static int check_timeout(const struct lx_bus_setup *setup, const struct lx_station *station,
                         enum lx_clocked_master master, struct lx_error *error)
{
    const struct dg_biss_model *model = dg_host_line_of(station->host)->settings;
    if (master == LX_CLOCKED_THERE || model->timeout == 0) {
        return 0;
    }
    (void)lx_refuse(error, "only with gpio", "the simulated wire has the encoder's own timeout");
    (void)lx_about(error, LX_ABOUT_SETTING, "timeout_us", NULL);
    return lx_plan_stands(setup->plan, dg_plan_setting_line(station->plan, "timeout_us"), error);
}

static dg_ns init(const void *settings)
{
    return ((const struct dg_biss_model *)settings)->init;
}

const struct lx_clocked_protocol lx_clocked_biss = {
    .clock = CLOCK_NAME,
    .data = DATA_NAME,
    .size = sizeof(struct lx_biss_line),
    .slow_down = slow_down,
    .check = check_timeout,
    .init = init,
    .rises = rises,
    .read = read_frame,
    .skip = skip,
    .judge = judge,
    .word = word,
    .note = note,
    .print = print,
    .offer = lx_biss_master_offer,
};

/* --- the stack --- */

/* clang-format off */
static const struct dg_key timeout =
    {"timeout_us", "us", offsetof(struct dg_biss_model, timeout), DG_KEY_NS, 0, 1000, TIMEOUT_MIN_US, TIMEOUT_MAX_US, NULL, "gpio: silence on MA that ends a frame; 20000 unless set"};
/* clang-format on */

/* Bits of a frame that are no position, with a life counter. */
#define USUAL_AROUND (DG_BISS_FLAG_BITS + DG_BISS_LIFE_BITS + DG_BISS_CRC_BITS)

static int check(const void *settings, struct lx_error *error)
{
    const struct dg_biss_model *model = settings;
    struct lx_words right = {""};
    const unsigned bits = (unsigned)model->multiturn_bits + model->singleturn_bits;
    const unsigned around = model->form == NULL ? USUAL_AROUND : model->form->around;
    if (bits + around > DG_BISS_FRAME_BITS_MAX) {
        lx_words_add(&right, "together at most %u are right", DG_BISS_FRAME_BITS_MAX - around);
        return lx_refuse(error, right.text, "mt %u and st %u", model->multiturn_bits,
                         model->singleturn_bits);
    }
    if (model->busy + model->busy_jitter <= DG_BISS_BUSY_S_MAX_NS) {
        return 0;
    }
    lx_words_add(&right, "together at most %u is right", (unsigned)(DG_BISS_BUSY_S_MAX_NS / 1000u));
    return lx_refuse(error, right.text, "busy_us %g and busy_jitter_us %g",
                     (double)model->busy / 1000.0, (double)model->busy_jitter / 1000.0);
}

static const struct lx_trace_format vcd = LX_TRACE_CLOCKED("biss", CLOCK_NAME, DATA_NAME);
const struct lx_stack lx_biss_stack = {
    .core = &dg_biss_stack,
    .handle = &dg_biss_wire,
    .trace = &(const struct lx_trace_kind){"BiSS", {&vcd}, false},
    .clocked = &lx_clocked_biss,
    .wire = "sim",
    .spoiled = "the encoder answers P = 1",
    .instead = &timeout,
    .check = check,
};

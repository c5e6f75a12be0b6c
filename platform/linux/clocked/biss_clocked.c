/* SPDX-License-Identifier: MIT */
/*
 *            fault[0]            fault[1]
 *   master <--(bends)-- slave[0] <--(bends)-- slave[1] ... <-- low
 *
 * A fault sits behind the slave's driver: the slave itself works, its neighbour (or the master)
 * sees something else.
 *
 * Ack tells the master how long a level needs there and back:
 *
 *   MA   _|1|_|2|_|3|_|4|_|5|_      the clocks go on meanwhile
 *   SLO  ---------.___.---....      Ack here, start bit there
 *          e2 ----^ delay           bit n is sampled half a period behind its clock and the delay
 */
#include "biss_clocked.h"

#include <inttypes.h>
#include <stdio.h>

#include "biss_master.h"
#include "biss_settings.h"
#include "drehgeber/instruments.h"
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

_Static_assert(DG_BISS_CHAIN_MAX <= LX_CLOCKED_MAX, "room for a chain");

static struct lx_biss_line *line_of(struct lx_clocked *base)
{
    return (struct lx_biss_line *)base;
}

static const struct lx_biss_line *view_of(const struct lx_clocked *base)
{
    return (const struct lx_biss_line *)base;
}

/* --- the line --- */

/* P of a write comes with the frame behind it. What is not on the disk yet is not acknowledged:
   there is no start bit then. */
static void hold_back(struct lx_biss_line *self, uint8_t index)
{
    struct lx_nvm_queue *memory = self->memory[index];
    if (memory != NULL && lx_nvm_queue_answer(memory) != LX_NVM_SAY) {
        dg_line_fault_kill(&self->fault[index]);
    }
}

/* The chain's line behind slave `index`. A frame begins for it with the edge that has put it into
   the state behind e1. */
static bool bend(void *ctx, uint8_t index, bool slo, bool clocked)
{
    struct lx_biss_line *self = ctx;
    struct dg_line_fault *fault = &self->fault[index];
    if (clocked && self->chain.slave[index]->line.state == DG_BISS_ACK) {
        dg_line_fault_begin(fault);
        hold_back(self, index);
    }
    if (clocked) {
        dg_line_fault_advance(fault, slo, self->base.period);
    }
    return dg_line_fault_level(fault, slo);
}

/* Nobody asks a healthy line, nor one whose memory keeps nobody waiting. */
static void look_for_faults(struct lx_biss_line *self)
{
    bool due = false;
    for (uint8_t i = 0; i < self->chain.count; i++) {
        due = due || dg_line_fault_due(&self->fault[i]) || self->memory[i] != NULL;
    }
    self->chain.link = due ? bend : NULL;
}

static bool edge(struct lx_clocked *base, dg_ns now, bool level)
{
    struct lx_biss_line *self = line_of(base);
    if (self->chain.slave[0]->line.state == DG_BISS_IDLE) {
        look_for_faults(self); /* the next edge may be e1 */
    }
    return dg_biss_chain_ma(&self->chain, now, level);
}

static void settle(struct lx_clocked *base)
{
    struct lx_biss_line *self = line_of(base);
    for (uint8_t i = 0; i < self->chain.count; i++) {
        dg_line_fault_end(&self->fault[i]);
    }
    look_for_faults(self);
}

static dg_ns step(struct lx_clocked *base, dg_ns now)
{
    struct lx_biss_line *self = line_of(base);
    const dg_ns due = dg_biss_chain_step(&self->chain, 0);
    if (due > now) {
        return due;
    }
    const dg_ns next = dg_biss_chain_step(&self->chain, now);
    settle(base);
    return next;
}

static bool level(const struct lx_clocked *base)
{
    return dg_biss_chain_slo(&view_of(base)->chain);
}

static bool clocked(const struct lx_clocked *base)
{
    return view_of(base)->chain.slave[0]->line.ma;
}

static const char *hint(struct lx_clocked *base, dg_ns now, dg_ns *due)
{
    return dg_biss_chain_hint(&line_of(base)->chain, now, due) ? DG_BISS_HINT : NULL;
}

static uint32_t rises(const struct lx_clocked *base)
{
    const struct dg_biss_chain *chain = &view_of(base)->chain;
    uint32_t edges = EDGES_AHEAD;
    for (uint8_t i = 0; i < chain->count; i++) {
        edges += dg_biss_frame_bits(chain->slave[i]->setup.model);
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
    self->frame.answered = wire->cable.fell >= wire->now;
    const bool measured = self->frame.answered && wire->compensates;
    wire->delay = measured ? wire->cable.fell - wire->now : 0;
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
    for (uint8_t i = 0; i < self->chain.count; i++) {
        uint64_t bits = 0;
        for (uint8_t bit = 0; bit < self->fault[i].frame.bits; bit++) {
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
    struct lx_biss_line *self = line_of(base);
    for (uint8_t i = 0; i < self->chain.count; i++) {
        dg_biss_skip(self->chain.slave[i], n);
    }
}

static struct dg_biss_data data_of(const struct lx_clocked *base, size_t encoder)
{
    const struct lx_biss_line *self = view_of(base);
    struct dg_biss_data data;
    dg_biss_frame_decode(self->chain.slave[encoder]->setup.model, self->frame.bits[encoder], &data);
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
        .count = dg_biss_frame_bits(self->chain.slave[encoder]->setup.model),
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
    const uint8_t st_bits = view_of(base)->chain.slave[encoder]->setup.model->singleturn_bits;
    const double turns = (double)data.singleturn / (double)(1u << st_bits);
    (void)snprintf(text, size,
                   "MT %" PRIu32 "  ST %" PRIu32 "  %.6f deg  nERR %d  nWARN %d  LC %u  CRC %s",
                   data.multiturn, data.singleturn, 360.0 * turns, data.n_err, data.n_warn,
                   data.life, data.crc_ok ? "valid" : "WRONG");
}

static const struct lx_clocked_ops ops = {
    .clock = CLOCK_NAME,
    .data = DATA_NAME,
    LX_CLOCKED_OPERATIONS,
    .hint = hint,
    .read = read_frame,
    .skip = skip,
    .word = word,
    .print = print,
};

void lx_biss_line_init(struct lx_biss_line *self)
{
    *self = (struct lx_biss_line){.base.ops = &ops, .chain.ctx = self};
}

void lx_biss_line_add(struct lx_biss_line *self, struct dg_biss *device, struct dg_faults *faults,
                      const char *name)
{
    const uint8_t index = self->chain.count++;
    self->chain.slave[index] = device;
    self->base.name[index] = name;
    self->base.count = self->chain.count;
    dg_line_fault_init(&self->fault[index], &dg_biss_instrument, device, faults);
}

void lx_biss_line_hold(struct lx_biss_line *self, struct lx_nvm_queue *queue)
{
    self->memory[self->chain.count - 1u] = queue;
}

struct lx_biss_line *lx_biss_line_of(const struct lx_clocked_wire *wire)
{
    return line_of(wire->line);
}

/* --- from a plan --- */

struct encoder {
    struct dg_biss_model model;
    struct lx_biss_memory memory;
    struct dg_biss device;
};

struct planned {
    struct lx_biss_line line;
    size_t count; /* placed */
    enum lx_clocked_master master;
    struct encoder encoder[DG_BISS_CHAIN_MAX];
};

static struct encoder *encoder_of(struct lx_clocked *base, size_t index)
{
    return &((struct planned *)base)->encoder[index];
}

static void init(struct lx_clocked *base)
{
    lx_biss_line_init(line_of(base));
}

static int place(struct lx_clocked *base, const struct lx_bus_setup *setup, size_t index,
                 enum lx_clocked_master master, struct lx_error *error)
{
    struct encoder *self = encoder_of(base, index);
    struct dg_biss_model *model = &self->model;
    struct lx_station *station = setup->stations[index];
    ((struct planned *)base)->count = index + 1u;
    ((struct planned *)base)->master = master;
    if (lx_stack_settings(setup->plan, setup->wire, station->plan, model, &station->world, error) !=
        0) {
        return -1;
    }
    if (master == LX_CLOCKED_HERE &&
        lx_biss_own_timeout(setup->plan, station->plan, model, error) != 0) {
        return -1;
    }
    /* A clock that user space can follow is slower than the encoder's own timeout allows. */
    if (master == LX_CLOCKED_THERE && model->timeout == 0) {
        model->timeout = GPIO_TIMEOUT;
    }
    station->control.serial = model->serial;
    base->init = model->init > base->init ? model->init : base->init;
    return 0;
}

static int open_encoder(struct lx_clocked *base, const struct lx_bus_setup *setup, size_t index,
                        dg_ns now, struct lx_error *error)
{
    struct encoder *self = encoder_of(base, index);
    struct lx_station *station = setup->stations[index];
    const struct lx_image_setup image = {station->plan->nvm, .say = setup->say,
                                         .writer = setup->writer};
    if (lx_biss_memory_open(&self->memory, &self->model, &image, error) != 0) {
        return lx_plan_refuse_key(setup->plan, "nvm", station->plan->nvm_line, error);
    }
    station->control.nvm = self->memory.part.device.nvm;
    station->queue = lx_image_queue(&self->memory.image);
    const struct dg_biss_setup made = {&self->model, &station->world, station->control.nvm};
    if (lx_biss_switch_on(&self->device, &made, now, error) != 0) {
        return -1;
    }
    station->control.device = &self->device;
    lx_biss_line_add(line_of(base), &self->device, &station->control.faults, station->control.name);
    if (((const struct planned *)base)->master == LX_CLOCKED_THERE) {
        lx_biss_line_hold(line_of(base), &self->memory.image.queue);
    }
    return 0;
}

static void close_all(struct lx_clocked *base)
{
    for (size_t i = 0; i < ((struct planned *)base)->count; i++) {
        struct encoder *self = encoder_of(base, i);
        dg_biss_power_off(&self->device);
        lx_image_close(&self->memory.image);
    }
}

const struct lx_clocked_protocol lx_clocked_biss = {
    .encoders_max = DG_BISS_CHAIN_MAX,
    .size = sizeof(struct planned),
    .init = init,
    .place = place,
    .open = open_encoder,
    .close = close_all,
    .offer = lx_biss_master_offer,
};

/* --- in traces --- */

static void begin_trace(struct lx_trace *self)
{
    static const char *const lines[] = {CLOCK_NAME, DATA_NAME};
    lx_trace_clocked_begin(self, "biss", lines);
}

const struct lx_trace_format lx_trace_biss = {
    .ending = ".vcd",
    .mark = LX_VCD_MARK,
    .size = sizeof(struct lx_trace_clocked),
    .begin = begin_trace,
    .event = lx_trace_clocked_event,
    .end = lx_trace_clocked_end,
};

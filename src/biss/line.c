/* SPDX-License-Identifier: MIT */
/*
 * The line: edges and silence (5.2.1.1, 5.2.1.2).
 *
 *   edge      e1      e2       eS       eS+1    eS+2 ...          timeout
 *   IDLE ----> ACK --> WAIT ---> CDS ---> DATA --> DATA ... (any) --> IDLE, MA high
 *                                                                 --> RETURN, MA low --> IDLE
 *   SLO   1       1        0        1       CDS     data          1
 *
 * SLO stays at its level of the start until the first e1.
 *
 * In a chain the start bit comes in on SLI instead, and what comes in behind the neighbour's CDS is
 * shifted through behind the own data.
 */
#include "biss_private.h"

static void enter_rest(struct dg_biss_line *line, enum dg_biss_line_state state)
{
    line->state = state;
    line->deadline = DG_NEVER;
}

static dg_ns biss_timeout_ns(const struct dg_biss *self)
{
    const dg_ns chosen = self->setup.model->timeout;
    const dg_ns own = self->timeout == 0 ? DG_BISS_TIMEOUT_NS : DG_BISS_TIMEOUT_S_NS;

    return chosen != 0 ? chosen : own;
}

/* From e2 on there is a CDM bit: two clocks make a reduced frame. */
static bool has_cdm(enum dg_biss_line_state state)
{
    return state >= DG_BISS_WAIT && state <= DG_BISS_DATA;
}

dg_ns dg_biss_step(struct dg_biss *self, dg_ns now)
{
    struct dg_biss_line *line = &self->line;

    if (line->deadline > now || line->deadline == DG_NEVER) {
        return line->deadline;
    }
    const dg_ns moment = line->deadline;
    const bool frame = has_cdm(line->state);
    line->slo = line->slo || line->state != DG_BISS_IDLE;
    enter_rest(line, line->ma ? DG_BISS_IDLE : DG_BISS_RETURN);
    if (frame) {
        dg_biss_cdm(self, moment, !line->ma);
    }
    return DG_NEVER;
}

/* The sensor is read at e1, and takes its time from there. */
static uint8_t latch_position(struct dg_biss *self, dg_ns now, uint64_t *bits)
{
    const struct dg_biss_model *model = self->setup.model;

    self->noise = self->noise * 1664525u + 1013904223u;
    /* Below 2^32: the jitter is 40 000 ns at most. */
    const uint32_t jitter = (self->noise >> 16) * ((uint32_t)model->busy_jitter + 1u) >> 16;
    self->line.start = dg_after(now, model->busy + jitter);
    self->line.slo = true;
    return dg_biss_latch(self, now, bits);
}

static void take_rising_edge(struct dg_biss *self, dg_ns now, bool sli)
{
    struct dg_biss_line *line = &self->line;

    switch (line->state) {
    case DG_BISS_OFF:
        break;
    case DG_BISS_IDLE:
        line->length = latch_position(self, now, &line->shift);
        line->timeout = (uint32_t)biss_timeout_ns(self); /* 7Ch is written between frames */
        line->state = DG_BISS_ACK;
        break;
    case DG_BISS_ACK:
        /* At the start all SLO are low: only behind e1 does every neighbour show a 1. */
        line->is_last = !sli;
        line->slo = false;
        line->state = DG_BISS_WAIT;
        break;
    case DG_BISS_WAIT:
        if (line->is_last ? now >= line->start : sli) {
            line->slo = true;
            line->state = DG_BISS_CDS;
        }
        break;
    case DG_BISS_CDS:
        line->slo = dg_biss_cds(self, sli);
        line->state = DG_BISS_DATA;
        break;
    case DG_BISS_DATA:
        line->shift = line->shift << 1 | sli;
        line->slo = (line->shift >> line->length & 1u) != 0;
        break;
    case DG_BISS_RETURN:
        enter_rest(line, DG_BISS_IDLE);
        break;
    }
}

static bool slo_of(const struct dg_biss *self, bool sli)
{
    const struct dg_biss_line *line = &self->line;
    const bool idle = line->state == DG_BISS_IDLE || line->state == DG_BISS_RETURN;

    return idle && !line->is_last ? sli : line->slo;
}

/* An edge that shifts and nothing else: most are. */
static inline bool shifts(const struct dg_biss_line *line, dg_ns now, bool level)
{
    return line->state == DG_BISS_DATA && line->ma != level && line->last <= now &&
           now < line->deadline;
}

/* What take_any_edge() does with such an edge. */
static inline void shift_bit(struct dg_biss *self, dg_ns now, bool level, bool sli)
{
    struct dg_biss_line *line = &self->line;

    line->last = now;
    line->ma = level;
    line->deadline = dg_after(now, line->timeout);
    if (level) {
        line->shift = line->shift << 1 | sli;
        line->slo = (line->shift >> line->length & 1u) != 0;
    }
}

static bool take_any_edge(struct dg_biss *self, dg_ns now, bool level, bool sli)
{
    struct dg_biss_line *line = &self->line;

    now = now > line->last ? now : line->last; /* earlier: no time has passed (time.h) */
    line->last = now;
    if (line->deadline <= now) {
        (void)dg_biss_step(self, now);
    }
    if (level == line->ma) {
        return slo_of(self, sli);
    }
    line->ma = level;
    if (level) {
        take_rising_edge(self, now, sli);
    }
    if (line->state != DG_BISS_OFF && (line->state != DG_BISS_IDLE || !level)) {
        line->deadline = dg_after(now, biss_timeout_ns(self));
    }
    return slo_of(self, sli);
}

static inline bool take_edge(struct dg_biss *self, dg_ns now, bool level, bool sli)
{
    if (!shifts(&self->line, now, level)) {
        return take_any_edge(self, now, level, sli);
    }
    shift_bit(self, now, level, sli);
    return self->line.slo;
}

bool dg_biss_link(struct dg_biss *self, dg_ns now, bool level, bool sli)
{
    return take_edge(self, now, level, sli);
}

bool dg_biss_ma(struct dg_biss *self, dg_ns now, bool level)
{
    return take_edge(self, now, level, false);
}

bool dg_biss_slo(const struct dg_biss *self, bool sli)
{
    return slo_of(self, sli);
}

bool dg_biss_hint(struct dg_biss *self, dg_ns now, dg_ns *due)
{
    struct dg_biss_line *line = &self->line;
    const bool idle = line->state == DG_BISS_IDLE || line->state == DG_BISS_RETURN;

    *due = DG_NEVER;
    if (!idle || line->slo || line->hinted || self->setup.model->hint == 0) {
        return false;
    }
    line->hint = line->hint != 0 ? line->hint : dg_after(now, self->setup.model->hint);
    line->hinted = now >= line->hint;
    *due = line->hinted ? DG_NEVER : line->hint;
    return line->hinted;
}

/* What each one shows its neighbour, from the last to the first.
   @return what gets to the master; `sli` has what gets to the slaves */
static bool chain_levels(const struct dg_biss_chain *self, bool clocked, bool *sli)
{
    bool level = false;

    for (uint8_t i = self->count; i-- > 0;) {
        sli[i] = level;
        level = slo_of(self->slave[i], level);
        level = self->link == NULL ? level : self->link(self->ctx, i, level, clocked);
    }
    return level;
}

bool dg_biss_chain_slo(const struct dg_biss_chain *self)
{
    bool sli[DG_BISS_CHAIN_MAX];

    return chain_levels(self, false, sli);
}

/* MA is high: timeouts that ended before come first. @return whether it was low for any slave;
   after a power-on some may think of it as high that is low */
static bool chain_rises(const struct dg_biss_chain *self, dg_ns now)
{
    bool low = false;

    for (uint8_t i = 0; i < self->count; i++) {
        (void)dg_biss_step(self->slave[i], now);
        low = low || !self->slave[i]->line.ma;
    }
    return low;
}

static bool chain_takes_any_edge(struct dg_biss_chain *self, dg_ns now, bool level)
{
    bool sli[DG_BISS_CHAIN_MAX] = {false};
    const bool rises = level && chain_rises(self, now);

    /* All slaves see the same edge: what counts is their neighbours' level before it. */
    if (rises) {
        (void)chain_levels(self, false, sli);
    }
    for (uint8_t i = 0; i < self->count; i++) {
        (void)take_edge(self->slave[i], now, level, sli[i]);
    }
    return chain_levels(self, rises, sli);
}

/* All shift, and what they show each other is what they send: as one register, from the first on,
   so that each still sees its neighbour's level before the edge. */
static bool chain_shifts(struct dg_biss_chain *self, dg_ns now, bool level)
{
    const uint8_t last = (uint8_t)(self->count - 1u);

    for (uint8_t i = 0; i < last; i++) {
        shift_bit(self->slave[i], now, level, self->slave[i + 1u]->line.slo);
    }
    shift_bit(self->slave[last], now, level, false);
    return self->slave[0]->line.slo;
}

bool dg_biss_chain_ma(struct dg_biss_chain *self, dg_ns now, bool level)
{
    bool all = self->link == NULL && self->count > 0;

    for (uint8_t i = 0; all && i < self->count; i++) {
        all = shifts(&self->slave[i]->line, now, level);
    }
    return all ? chain_shifts(self, now, level) : chain_takes_any_edge(self, now, level);
}

dg_ns dg_biss_chain_step(struct dg_biss_chain *self, dg_ns now)
{
    dg_ns next = DG_NEVER;

    for (uint8_t i = 0; i < self->count; i++) {
        next = dg_earliest(next, dg_biss_step(self->slave[i], now));
    }
    return next;
}

bool dg_biss_chain_hint(struct dg_biss_chain *self, dg_ns now, dg_ns *due)
{
    dg_ns next = DG_NEVER;
    bool told = false;

    *due = DG_NEVER;
    for (uint8_t i = 0; i < self->count; i++) {
        told = dg_biss_hint(self->slave[i], now, &next) || told;
        *due = dg_earliest(*due, next);
    }
    /* The others have nothing to add. */
    for (uint8_t i = 0; told && i < self->count; i++) {
        (void)dg_biss_hint(self->slave[i], DG_NEVER, due);
    }
    return told;
}

uint8_t dg_biss_frame(struct dg_biss *self, dg_ns e1, uint64_t *bits)
{
    *bits = 0;
    if (self->line.state == DG_BISS_OFF) {
        return 0;
    }
    const uint8_t length = latch_position(self, e1, bits);
    *bits |= (uint64_t)dg_biss_cds(self, false) << length;
    return (uint8_t)(length + 1u);
}

void dg_biss_frame_end(struct dg_biss *self, dg_ns now, bool cdm)
{
    if (self->line.state != DG_BISS_OFF) {
        dg_biss_cdm(self, now, cdm);
    }
}

/* SPDX-License-Identifier: MIT */
/*
 * The line: edges and silence (5.2.1.1, 5.2.1.2).
 *
 *   edge      e1      e2       eS       eS+1    eS+2 ...          timeout
 *   IDLE ----> ACK --> WAIT ---> CDS ---> DATA --> DATA ... (any) --> IDLE, MA high
 *                                                                 --> RETURN, MA low --> IDLE
 *   SLO   1       1        0        1       CDS     data          1
 *
 * In a chain the start bit comes in on SLI instead, and what comes in behind the neighbour's CDS is
 * shifted through behind the own data.
 */
#include "slave.h"

static void rest(struct dg_biss_line *line, enum dg_biss_line_state state)
{
    line->state = state;
    line->deadline = DG_NEVER;
    line->slo = true;
}

static dg_ns timeout_ns(const struct dg_biss *self)
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
    rest(line, line->ma ? DG_BISS_IDLE : DG_BISS_RETURN);
    if (frame) {
        dg_biss_cdm(self, moment, !line->ma);
    }
    return DG_NEVER;
}

static void on_e1(struct dg_biss *self, dg_ns now, bool sli)
{
    struct dg_biss_line *line = &self->line;

    line->is_last = !sli;
    line->start = dg_after(now, self->setup.model->busy);
    line->length = dg_biss_latch(self, now, &line->shift);
    line->state = DG_BISS_ACK;
}

static void rising(struct dg_biss *self, dg_ns now, bool sli)
{
    struct dg_biss_line *line = &self->line;

    switch (line->state) {
    case DG_BISS_OFF:
        break;
    case DG_BISS_IDLE:
        on_e1(self, now, sli);
        break;
    case DG_BISS_ACK:
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
        rest(line, DG_BISS_IDLE);
        break;
    }
}

bool dg_biss_link(struct dg_biss *self, dg_ns now, bool level, bool sli)
{
    struct dg_biss_line *line = &self->line;

    now = now > line->last ? now : line->last; /* earlier: no time has passed (time.h) */
    line->last = now;
    if (line->deadline <= now) {
        (void)dg_biss_step(self, now);
    }
    if (level == line->ma) {
        return dg_biss_slo(self, sli);
    }
    line->ma = level;
    if (level) {
        rising(self, now, sli);
    }
    if (line->state != DG_BISS_OFF && (line->state != DG_BISS_IDLE || !level)) {
        line->deadline = dg_after(now, timeout_ns(self));
    }
    return dg_biss_slo(self, sli);
}

bool dg_biss_ma(struct dg_biss *self, dg_ns now, bool level)
{
    return dg_biss_link(self, now, level, false);
}

bool dg_biss_slo(const struct dg_biss *self, bool sli)
{
    const struct dg_biss_line *line = &self->line;
    const bool idle = line->state == DG_BISS_IDLE || line->state == DG_BISS_RETURN;

    return idle && !line->is_last ? sli : line->slo;
}

bool dg_biss_chain_slo(const struct dg_biss_chain *self)
{
    bool sli = false;

    for (uint8_t i = self->count; i > 0; i--) {
        sli = dg_biss_slo(self->slave[i - 1u], sli);
    }
    return sli;
}

bool dg_biss_chain_ma(struct dg_biss_chain *self, dg_ns now, bool level)
{
    bool sli[DG_BISS_CHAIN_MAX + 1u] = {false};

    /* All slaves see the same edge: what counts is their neighbours' level before it. */
    (void)dg_biss_chain_step(self, now);
    for (uint8_t i = self->count; i > 0; i--) {
        sli[i - 1u] = dg_biss_slo(self->slave[i - 1u], sli[i]);
    }
    for (uint8_t i = 0; i < self->count; i++) {
        (void)dg_biss_link(self->slave[i], now, level, sli[i + 1u]);
    }
    return dg_biss_chain_slo(self);
}

dg_ns dg_biss_chain_step(struct dg_biss_chain *self, dg_ns now)
{
    dg_ns next = DG_NEVER;

    for (uint8_t i = 0; i < self->count; i++) {
        next = dg_earliest(next, dg_biss_step(self->slave[i], now));
    }
    return next;
}

uint8_t dg_biss_frame(struct dg_biss *self, dg_ns latch, uint64_t *bits)
{
    *bits = 0;
    if (self->line.state == DG_BISS_OFF) {
        return 0;
    }
    const uint8_t length = dg_biss_latch(self, latch, bits);
    *bits |= (uint64_t)dg_biss_cds(self, false) << length;
    return (uint8_t)(length + 1u);
}

void dg_biss_frame_end(struct dg_biss *self, dg_ns now, bool cdm)
{
    if (self->line.state != DG_BISS_OFF) {
        dg_biss_cdm(self, now, cdm);
    }
}

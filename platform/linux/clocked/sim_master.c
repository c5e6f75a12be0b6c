/* SPDX-License-Identifier: MIT */
#include "sim_master.h"

#include <inttypes.h>
#include <stdio.h>

/* A start bit later than this is worth a word. */
#define START_MAX DG_BISS_BUSY_S_MAX_NS
/* Room for a note: 64 registers. */
#define NOTE_MAX 240u

/* --- the tap --- */

static void tell_levels(void *ctx, dg_ns at, bool ma, bool slo)
{
    const struct lx_sim_master *self = ctx;
    const struct lx_tap_event event = {.at = at, .kind = LX_TAP_LEVELS, .levels = {ma, slo}};
    lx_tap_tell(self->tap, &event);
}

/* Edges cost most of the time of a frame: they are only told while somebody listens. */
static void look_for_listeners(struct lx_sim_master *self)
{
    self->wire.levels = lx_tap_on(self->tap) ? tell_levels : NULL;
    self->wire.ctx = self;
}

/* Which encoder, where there are several. */
static int begin_note(const struct lx_sim_master *self, uint8_t slave, char *text, size_t size)
{
    return self->wire.chain.count == 1 ? 0 : snprintf(text, size, "%.32s: ", self->name[slave]);
}

static void tell_note(const struct lx_sim_master *self, const char *text)
{
    const struct lx_tap_event event = {
        .at = self->wire.now, .kind = LX_TAP_NOTE, .ours = true, .note = text};
    lx_tap_tell(self->tap, &event);
}

static void note_position(const struct lx_sim_master *self, uint8_t slave)
{
    char text[NOTE_MAX];
    const size_t size = sizeof text;
    const struct dg_biss_data data = lx_biss_wire_data(&self->wire, slave);
    int n = begin_note(self, slave, text, size);
    if (!self->wire.answered) {
        (void)snprintf(text + n, size - (size_t)n, "no answer");
        tell_note(self, text);
        return;
    }
    n +=
        snprintf(text + n, size - (size_t)n,
                 "position %" PRIu32 ":%" PRIu32 " nERR %d nWARN %d LC %u CRC %s", data.multiturn,
                 data.singleturn, data.n_err, data.n_warn, data.life, data.crc_ok ? "ok" : "wrong");
    if (self->wire.start > START_MAX) {
        n += snprintf(text + n, size - (size_t)n, ", start bit after %" PRIu64 " us",
                      self->wire.start / DG_US(1));
    }
    if (self->wire.delay > 0) {
        (void)snprintf(text + n, size - (size_t)n, ", line delay %" PRIu64 " ns", self->wire.delay);
    }
    tell_note(self, text);
}

/* "register 78h = 04 00" */
static void note_registers(const struct lx_sim_master *self, uint8_t slave, uint8_t address,
                           const uint8_t *bytes, size_t n)
{
    char text[NOTE_MAX];
    int used = begin_note(self, slave, text, sizeof text);
    used += snprintf(text + used, sizeof text - (size_t)used, "register %02Xh =", address);
    for (size_t i = 0; i < n && (size_t)used + 4u < sizeof text; i++) {
        used += snprintf(text + used, sizeof text - (size_t)used, " %02X", bytes[i]);
    }
    tell_note(self, text);
}

/* An access to `done` registers that ended in `result`. */
static void note_access(const struct lx_sim_master *self, uint8_t slave, uint8_t address,
                        const uint8_t *bytes, size_t done, int result)
{
    char text[NOTE_MAX];
    if (done > 0) {
        note_registers(self, slave, address, bytes, done);
    }
    if (result < 0) {
        lx_sim_master_explain(self, slave, (uint8_t)(address + done), result, text, sizeof text);
        tell_note(self, text);
    }
}

/* --- the master --- */

void lx_sim_master_init(struct lx_sim_master *self, const struct lx_tap *tap,
                        const struct lx_biss_timing *timing, dg_ns now)
{
    self->tap = tap;
    lx_biss_wire_init(&self->wire, timing, now);
}

void lx_sim_master_add(struct lx_sim_master *self, struct dg_biss *device, struct dg_faults *faults,
                       const char *name)
{
    self->name[self->wire.chain.count] = name;
    lx_biss_wire_add(&self->wire, device, faults);
}

void lx_sim_master_pause(struct lx_sim_master *self, dg_ns now)
{
    look_for_listeners(self);
    lx_biss_wire_pause(&self->wire, now);
}

void lx_sim_master_frame(struct lx_sim_master *self)
{
    look_for_listeners(self);
    lx_biss_wire_frame(&self->wire);
    for (uint8_t i = 0; lx_tap_on(self->tap) && i < self->wire.chain.count; i++) {
        note_position(self, i);
    }
}

int lx_sim_master_read(struct lx_sim_master *self, uint8_t slave, uint8_t address, uint8_t *bytes,
                       size_t n, size_t *done)
{
    int result = 0;
    look_for_listeners(self);
    for (*done = 0; result >= 0 && *done<n; *done += result> 0 ? (size_t)result : 0) {
        result = lx_biss_wire_read(&self->wire, slave, (uint8_t)(address + *done), bytes + *done,
                                   n - *done);
    }
    note_access(self, slave, address, bytes, *done, result);
    return result;
}

int lx_sim_master_write(struct lx_sim_master *self, uint8_t slave, uint8_t address,
                        const uint8_t *bytes, size_t n, size_t *done)
{
    int result = 0;
    look_for_listeners(self);
    for (*done = 0; result >= 0 && *done<n; *done += result> 0 ? (size_t)result : 0) {
        result = lx_biss_wire_write(&self->wire, slave, (uint8_t)(address + *done), bytes + *done,
                                    n - *done);
    }
    note_access(self, slave, address, bytes, *done, result);
    return result;
}

void lx_sim_master_explain(const struct lx_sim_master *self, uint8_t slave, uint8_t address,
                           int failure, char *to, size_t size)
{
    const int n = begin_note(self, slave, to, size);
    (void)snprintf(to + n, size - (size_t)n, "register %02Xh: %s", address,
                   lx_biss_failure_text(failure));
}

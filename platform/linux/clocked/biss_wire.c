/* SPDX-License-Identifier: MIT */
/*
 *                cable      link[0]            link[1]
 *   master <===(delay)=====(fault)-- slave[0] <--(fault)-- slave[1] ... <-- low
 *
 * A fault sits behind the encoder's driver: the encoder itself works, its neighbour (or the
 * master) sees something else.
 *
 * An edge of MA is taken at the encoders' end at once, with the time at which it gets there; what
 * it does to SLO is then on its way back. Ack tells the master how long that takes:
 *
 *   MA   _|1|_|2|_|3|_|4|_|5|_      the clocks go on meanwhile
 *   SLO  ---------.___.---....      Ack here, start bit there
 *          e2 ----^ delay           bit n is sampled half a period behind its clock and the delay
 */
#include "biss_wire.h"

#include <string.h>

#define START_CLOCKS_MAX 1000u
#define ZERO_FRAMES 14u
#define BUSY_MAX_NS 20000000u
/* A real master pauses a little longer than the encoder's timeout. */
#define PAUSE_NS 15000u

/* --- levels --- */

void lx_biss_wire_init(struct lx_biss_wire *self, const struct lx_biss_timing *timing, dg_ns now)
{
    const uint32_t edges = 2u * timing->clock_hz; /* in a second */
    *self = (struct lx_biss_wire){
        .half_ns = (uint32_t)(DG_S(1) / edges),
        .rest = (uint32_t)(DG_S(1) % edges),
        .edges_per_s = edges,
        .now = now,
        .ma = true,
        .slo = true,
    };
    lx_biss_cable_init(&self->cable, timing->line_delay_ns, true);
}

/* The next edge's time. Whole nanoseconds, and yet the clock is right on average. */
static dg_ns next_edge(struct lx_biss_wire *self)
{
    const dg_ns at = self->now + self->half_ns;
    self->owed += self->rest;
    if (self->owed < self->edges_per_s) {
        return at;
    }
    self->owed -= self->edges_per_s;
    return at + 1u;
}

/* The levels from `at` on, as far as they are new. */
static void record(struct lx_biss_wire *self, dg_ns at, bool ma, bool slo)
{
    const bool news = ma != self->ma || slo != self->slo;
    self->ma = ma;
    self->slo = slo;
    if (news && self->levels != NULL) {
        self->levels(self->ctx, at, ma, slo);
    }
}

/* What gets to the master up to `until`. */
static void arrive(struct lx_biss_wire *self, dg_ns until)
{
    struct lx_biss_change change;
    while (self->cable.count > 0 && lx_biss_cable_take(&self->cable, until, &change)) {
        record(self, change.at, self->ma, change.level);
    }
}

/* What each one shows its neighbour, from the last to the first; the last one's SLI is low.
   @return what goes into the cable */
static bool look(const struct lx_biss_wire *self, bool sli[DG_BISS_CHAIN_MAX])
{
    bool level = false;
    for (uint8_t i = self->count; i > 0; i--) {
        const struct lx_biss_slave *slave = &self->slave[i - 1u];
        sli[i - 1u] = level;
        level = lx_biss_link_level(&slave->link, dg_biss_slo(slave->device, level));
    }
    return level;
}

void lx_biss_wire_add(struct lx_biss_wire *self, struct dg_biss *device, struct dg_faults *faults)
{
    bool sli[DG_BISS_CHAIN_MAX];
    self->slave[self->count++] = (struct lx_biss_slave){
        .device = device,
        .faults = faults,
        .data_bits = dg_biss_frame_bits(device->setup.model),
    };
    self->slo = look(self, sli);
    lx_biss_cable_init(&self->cable, self->cable.delay, self->slo);
}

static dg_ns step(struct lx_biss_wire *self, dg_ns now)
{
    dg_ns next = DG_NEVER;
    for (uint8_t i = 0; i < self->count; i++) {
        next = dg_earliest(next, dg_biss_step(self->slave[i].device, now));
    }
    return next;
}

static void end_faults(struct lx_biss_wire *self)
{
    for (uint8_t i = 0; i < self->count; i++) {
        lx_biss_link_end(&self->slave[i].link, self->slave[i].faults);
    }
}

/* Timeouts that end at the encoders' end up to `now`, each at its moment. */
static void run_encoders(struct lx_biss_wire *self, dg_ns now)
{
    bool sli[DG_BISS_CHAIN_MAX];
    dg_ns due = step(self, 0);
    while (due <= now && due != DG_NEVER) {
        const dg_ns next = step(self, due);
        end_faults(self);
        lx_biss_cable_put(&self->cable, due, look(self, sli));
        due = next;
    }
}

/* All see the same edge, at `now`: what counts is their neighbours' level before it. SLO changes on
   rising edges only. */
static void clock_encoders(struct lx_biss_wire *self, dg_ns now, bool level)
{
    bool sli[DG_BISS_CHAIN_MAX] = {false};
    run_encoders(self, now);
    if (level) {
        (void)look(self, sli);
    }
    for (uint8_t i = 0; i < self->count; i++) {
        (void)dg_biss_link(self->slave[i].device, now, level, sli[i]);
    }
    bool seen = false;
    for (uint8_t i = self->count; level && i > 0; i--) {
        struct lx_biss_slave *slave = &self->slave[i - 1u];
        const bool raw = dg_biss_slo(slave->device, seen);
        lx_biss_link_advance(&slave->link, raw);
        seen = lx_biss_link_level(&slave->link, raw);
    }
    if (level) {
        lx_biss_cable_put(&self->cable, now, seen);
    }
}

static void edge(struct lx_biss_wire *self, bool level)
{
    const dg_ns now = next_edge(self);
    arrive(self, now - 1u);
    self->now = now;
    clock_encoders(self, now + self->cable.delay, level);
    /* Without delay the answer comes at once: one event for both. */
    struct lx_biss_change change = {.level = self->slo};
    while (lx_biss_cable_take(&self->cable, now, &change)) {
    }
    record(self, now, level, change.level);
}

void lx_biss_wire_pause(struct lx_biss_wire *self, dg_ns now)
{
    bool sli[DG_BISS_CHAIN_MAX];
    now = now > self->now ? now : self->now;
    run_encoders(self, now);
    end_faults(self);
    lx_biss_cable_put(&self->cable, now, look(self, sli));
    arrive(self, now);
    self->now = now;
}

/* --- frames --- */

/* @return the bit of this clock, sampled when it is on the line */
static bool clock_bit(struct lx_biss_wire *self)
{
    edge(self, false);
    edge(self, true);
    return lx_biss_cable_level(&self->cable, self->now + self->delay + self->half_ns);
}

/* e1 and e2. @return the time of e1 */
static dg_ns await_ack(struct lx_biss_wire *self)
{
    self->delay = 0;
    (void)clock_bit(self);
    const dg_ns begin = self->now;
    (void)clock_bit(self);
    self->answered = self->cable.fell >= self->now;
    self->delay = self->answered ? self->cable.fell - self->now : 0;
    self->silent += !self->answered;
    return begin;
}

/* Up to the last bit of the last CRC; the CDM bit is not yet decided. @return CDS */
static bool begin_frame(struct lx_biss_wire *self)
{
    for (uint8_t i = 0; i < self->count; i++) {
        struct lx_biss_slave *slave = &self->slave[i];
        lx_biss_link_begin(&slave->link, slave->faults, slave->data_bits, (dg_ns)2 * self->half_ns);
    }
    const dg_ns begin = await_ack(self);
    for (unsigned i = 0; i < START_CLOCKS_MAX && !clock_bit(self); i++) {
    }
    self->start = self->now - begin;
    const dg_ns known = self->now + self->delay + self->half_ns;
    self->cds = clock_bit(self);
    for (uint8_t i = 0; i < self->count; i++) {
        self->slave[i].bits = 0;
        for (uint8_t bit = 0; bit < self->slave[i].data_bits; bit++) {
            self->slave[i].bits = self->slave[i].bits << 1 | clock_bit(self);
        }
    }
    /* The master did not know when to end before it had seen the start bit. */
    while (self->now < known) {
        (void)clock_bit(self);
    }
    return self->cds;
}

static void end_frame(struct lx_biss_wire *self, bool cdm)
{
    if (cdm) {
        edge(self, false);
    }
    lx_biss_wire_pause(self, self->now + PAUSE_NS + self->delay);
    if (cdm) {
        edge(self, true);
    }
}

static bool frame(struct lx_biss_wire *self, bool cdm)
{
    const bool cds = begin_frame(self);
    end_frame(self, cdm);
    return cds;
}

void lx_biss_wire_frame(struct lx_biss_wire *self)
{
    (void)frame(self, false);
}

struct dg_biss_data lx_biss_wire_data(const struct lx_biss_wire *self, uint8_t slave)
{
    const struct lx_biss_slave *own = &self->slave[slave];
    struct dg_biss_data data;
    dg_biss_frame_decode(own->device->setup.model, own->bits, &data);
    return data;
}

/* --- registers --- */

/* The last `n` bits of `bits`. @return what came back, its last bit in bit 0 */
static unsigned send(struct lx_biss_wire *self, unsigned bits, unsigned n)
{
    unsigned back = 0;
    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | frame(self, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

/* CDS of the frames after R and after W: how the encoder takes it. The last encoder of the line
   gets ID 0. */
static int address_register(struct lx_biss_wire *self, uint8_t slave, uint8_t address, bool write)
{
    const unsigned id = self->count - 1u - slave;
    const unsigned bits = 1u << 10 | id << 7 | address; /* CTS first */
    const unsigned wanted = write ? 1u : 2u;

    (void)send(self, 0, ZERO_FRAMES);
    (void)frame(self, true);
    const unsigned locks = send(self, bits << 4 | dg_biss_crc4(bits, 11), 15);
    (void)frame(self, !write);
    unsigned answer = frame(self, write) ? 2u : 0u;
    answer |= frame(self, true) ? 1u : 0u;
    if (answer == wanted) {
        return 0;
    }
    return locks == 0 ? LX_BISS_SILENT : LX_BISS_REFUSED;
}

/* S is repeated until it comes back; the frame it comes back in stays open. */
static bool await_start(struct lx_biss_wire *self)
{
    const dg_ns begin = self->now;
    while (!begin_frame(self)) {
        end_frame(self, true);
        if (self->now - begin > BUSY_MAX_NS) {
            return false;
        }
    }
    return true;
}

/* One byte is exchanged. @return P */
static bool exchange(struct lx_biss_wire *self, uint8_t *byte, bool write, bool last, bool *good)
{
    const unsigned word = write ? (unsigned)*byte << 4 | dg_biss_crc4(*byte, 8) : 0;
    end_frame(self, (word >> 11 & 1u) != 0); /* D7 goes first */
    const unsigned back = send(self, word << 1, 12);
    const bool stop = begin_frame(self);
    end_frame(self, !last && !stop);
    *byte = (uint8_t)(back >> 4);
    *good = (back & 0x0Fu) == dg_biss_crc4(*byte, 8);
    return stop;
}

/* `bytes` is sent when writing, and replaced by what came back. P = 1 refuses the byte itself,
   unless the encoder tells of the next one (`early`). */
static int exchange_all(struct lx_biss_wire *self, uint8_t *bytes, size_t n, bool write, bool early)
{
    int done = 0;
    bool stop = false;
    for (size_t i = 0; i < n && !stop; i++) {
        bool good = false;
        if (!await_start(self)) {
            return LX_BISS_TOO_BUSY;
        }
        stop = exchange(self, &bytes[i], write, i + 1 == n, &good);
        if (!good) {
            return LX_BISS_DAMAGED;
        }
        done += !stop || early;
    }
    return done > 0 ? done : LX_BISS_REFUSED;
}

/* An SLO that reads high is no echo. */
static int access_registers(struct lx_biss_wire *self, uint8_t slave, uint8_t address,
                            uint8_t *bytes, size_t n, bool write)
{
    const uint32_t silent = self->silent;
    int result = address_register(self, slave, address, write);
    if (result == 0) {
        const bool early = self->slave[slave].device->setup.model->stop_bit_early;
        result = exchange_all(self, bytes, n, write, early);
    }
    return self->silent == silent ? result : LX_BISS_SILENT;
}

int lx_biss_wire_read(struct lx_biss_wire *self, uint8_t slave, uint8_t address, uint8_t *bytes,
                      size_t n)
{
    return access_registers(self, slave, address, bytes, n, false);
}

int lx_biss_wire_write(struct lx_biss_wire *self, uint8_t slave, uint8_t address,
                       const uint8_t *bytes, size_t n)
{
    uint8_t copy[DG_BISS_BANK_SIZE] = {0};
    if (n > sizeof copy) {
        return LX_BISS_REFUSED;
    }
    memcpy(copy, bytes, n);
    return access_registers(self, slave, address, copy, n, true);
}

const char *lx_biss_failure_text(int failure)
{
    static const char *const texts[] = {
        [-LX_BISS_SILENT] = "no answer",
        [-LX_BISS_REFUSED] = "refused: not implemented or protected",
        [-LX_BISS_TOO_BUSY] = "busy for more than 20 ms",
        [-LX_BISS_DAMAGED] = "wrong check sum",
    };
    return texts[-failure];
}

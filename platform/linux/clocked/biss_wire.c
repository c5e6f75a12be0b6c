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

/* The chain's line: each slave's SLO as its faults let it through. */
static bool through_fault(void *ctx, uint8_t index, bool slo, bool clocked)
{
    struct lx_line_fault *link = &((struct lx_biss_wire *)ctx)->slave[index].link;
    if (clocked) {
        lx_line_fault_advance(link, slo);
    }
    return lx_line_fault_level(link, slo);
}

void lx_biss_wire_init(struct lx_biss_wire *self, const struct lx_biss_timing *timing, dg_ns now)
{
    const uint32_t edges = 2u * timing->clock_hz; /* in a second */
    *self = (struct lx_biss_wire){
        .half_ns = (uint32_t)(DG_S(1) / edges),
        .rest = (uint32_t)(DG_S(1) % edges),
        .edges_per_s = edges,
        .chain = {.ctx = self},
        .now = now,
        .ma = true,
        .slo = true,
    };
    lx_cable_init(&self->cable, timing->line_delay_ns, true);
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
    struct lx_cable_change change;
    while (self->cable.count > 0 && lx_cable_take(&self->cable, until, &change)) {
        record(self, change.at, self->ma, change.level);
    }
}

/* Healthy lines are not asked. */
static void settle_links(struct lx_biss_wire *self)
{
    bool active = false;
    for (uint8_t i = 0; i < self->chain.count; i++) {
        active = active || self->slave[i].link.active;
    }
    self->chain.link = active ? through_fault : NULL;
}

/* @return what goes into the cable */
static bool look(const struct lx_biss_wire *self)
{
    return dg_biss_chain_slo(&self->chain);
}

void lx_biss_wire_add(struct lx_biss_wire *self, struct dg_biss *device, struct dg_faults *faults)
{
    self->chain.slave[self->chain.count] = device;
    self->slave[self->chain.count++] = (struct lx_biss_slave){
        .faults = faults,
        .data_bits = dg_biss_frame_bits(device->setup.model),
    };
    self->slo = look(self);
    lx_cable_init(&self->cable, self->cable.delay, self->slo);
}

static void end_faults(struct lx_biss_wire *self)
{
    for (uint8_t i = 0; i < self->chain.count; i++) {
        lx_line_fault_end(&self->slave[i].link, self->slave[i].faults);
    }
    settle_links(self);
}

/* Timeouts that end at the encoders' end up to `now`, each at its moment. */
static void run_encoders(struct lx_biss_wire *self, dg_ns now)
{
    dg_ns due = dg_biss_chain_step(&self->chain, 0);
    while (due <= now && due != DG_NEVER) {
        const dg_ns next = dg_biss_chain_step(&self->chain, due);
        end_faults(self);
        lx_cable_put(&self->cable, due, look(self));
        due = next;
    }
}

static void edge(struct lx_biss_wire *self, bool level)
{
    const dg_ns now = next_edge(self);
    arrive(self, now - 1u);
    self->now = now;
    const dg_ns there = now + self->cable.delay;
    run_encoders(self, there);
    lx_cable_put(&self->cable, there, dg_biss_chain_ma(&self->chain, there, level));
    /* Without delay the answer comes at once: one event for both. */
    struct lx_cable_change change = {.level = self->slo};
    while (lx_cable_take(&self->cable, now, &change)) {
    }
    record(self, now, level, change.level);
}

void lx_biss_wire_pause(struct lx_biss_wire *self, dg_ns now)
{
    now = now > self->now ? now : self->now;
    run_encoders(self, now);
    end_faults(self);
    lx_cable_put(&self->cable, now, look(self));
    arrive(self, now);
    self->now = now;
}

/* --- frames --- */

/* @return the bit of this clock, sampled when it is on the line */
static bool clock_bit(struct lx_biss_wire *self)
{
    edge(self, false);
    edge(self, true);
    return lx_cable_level(&self->cable, self->now + self->delay + self->half_ns);
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
    for (uint8_t i = 0; i < self->chain.count; i++) {
        struct lx_biss_slave *slave = &self->slave[i];
        lx_line_fault_begin(&slave->link, slave->faults, slave->data_bits,
                            (dg_ns)2 * self->half_ns);
    }
    settle_links(self);
    const dg_ns begin = await_ack(self);
    for (unsigned i = 0; i < START_CLOCKS_MAX && !clock_bit(self); i++) {
    }
    self->start = self->now - begin;
    const dg_ns known = self->now + self->delay + self->half_ns;
    self->cds = clock_bit(self);
    for (uint8_t i = 0; i < self->chain.count; i++) {
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
    struct dg_biss_data data;
    dg_biss_frame_decode(self->chain.slave[slave]->setup.model, self->slave[slave].bits, &data);
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
    const unsigned id = self->chain.count - 1u - slave;
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
        const bool early = self->chain.slave[slave]->setup.model->stop_bit_early;
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

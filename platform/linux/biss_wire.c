/* SPDX-License-Identifier: MIT */
/*
 *            link[0]            link[1]
 *   master <--(fault)-- slave[0] <--(fault)-- slave[1] ... <-- low
 *
 * A fault sits behind the encoder's driver: the encoder itself works, its neighbour (or the
 * master) sees something else.
 */
#include "biss_wire.h"

#include <string.h>

#define CLOCK_NS ((dg_ns)2u * LX_BISS_HALF_NS)
#define START_CLOCKS_MAX 1000u
#define ZERO_FRAMES 14u
#define BUSY_MAX_NS 20000000u
/* A real master pauses a little longer than the encoder's timeout. */
#define PAUSE_NS 15000u
#define CRC_BITS 6u
#define LIFE_BITS 6u

/* --- levels --- */

void lx_biss_wire_init(struct lx_biss_wire *self, dg_ns now)
{
    *self = (struct lx_biss_wire){.now = now, .ma = true, .slo = true};
}

void lx_biss_wire_add(struct lx_biss_wire *self, struct dg_biss *device, struct dg_faults *faults)
{
    self->slave[self->count++] = (struct lx_biss_slave){
        .device = device,
        .faults = faults,
        .data_bits = lx_biss_data_bits(device->setup.model),
    };
}

/* The levels from `now` on, as far as they are new. */
static void record(struct lx_biss_wire *self, bool ma, bool slo)
{
    const bool news = ma != self->ma || slo != self->slo;
    self->ma = ma;
    self->slo = slo;
    if (news && self->levels != NULL) {
        self->levels(self->ctx, self->now, ma, slo);
    }
}

/* What each one shows its neighbour, from the last to the first; the last one's SLI is low.
   @return what the master sees */
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

static dg_ns step(struct lx_biss_wire *self, dg_ns now)
{
    dg_ns next = DG_NEVER;
    for (uint8_t i = 0; i < self->count; i++) {
        next = dg_earliest(next, dg_biss_step(self->slave[i].device, now));
    }
    return next;
}

/* All see the same edge: what counts is their neighbours' level before it. */
static bool edge(struct lx_biss_wire *self, bool level)
{
    bool sli[DG_BISS_CHAIN_MAX];
    self->now += LX_BISS_HALF_NS;
    (void)step(self, self->now);
    (void)look(self, sli);
    for (uint8_t i = 0; i < self->count; i++) {
        (void)dg_biss_link(self->slave[i].device, self->now, level, sli[i]);
    }
    bool seen = false;
    for (uint8_t i = self->count; i > 0; i--) {
        struct lx_biss_slave *slave = &self->slave[i - 1u];
        const bool raw = dg_biss_slo(slave->device, seen);
        if (level) {
            lx_biss_link_advance(&slave->link, raw);
        }
        seen = lx_biss_link_level(&slave->link, raw);
    }
    record(self, level, seen);
    return seen;
}

void lx_biss_wire_pause(struct lx_biss_wire *self, dg_ns now)
{
    bool sli[DG_BISS_CHAIN_MAX];
    for (dg_ns deadline = step(self, self->now); deadline <= now && deadline != DG_NEVER;
         deadline = step(self, deadline)) {
        self->now = deadline > self->now ? deadline : self->now;
    }
    for (uint8_t i = 0; i < self->count; i++) {
        lx_biss_link_end(&self->slave[i].link, self->slave[i].faults);
    }
    record(self, self->ma, look(self, sli));
    self->now = now > self->now ? now : self->now;
}

/* --- frames --- */

static bool clock_bit(struct lx_biss_wire *self)
{
    (void)edge(self, false);
    return edge(self, true);
}

/* Up to the last bit of the last CRC; the CDM bit is not yet decided. @return CDS */
static bool begin_frame(struct lx_biss_wire *self)
{
    for (uint8_t i = 0; i < self->count; i++) {
        struct lx_biss_slave *slave = &self->slave[i];
        lx_biss_link_begin(&slave->link, slave->faults, slave->data_bits, CLOCK_NS);
    }
    const bool ready = clock_bit(self); /* e1 */
    const dg_ns begin = self->now;
    self->answered = !clock_bit(self) && ready; /* e2, Ack */
    for (unsigned i = 0; i < START_CLOCKS_MAX && !clock_bit(self); i++) {
    }
    self->start = self->now - begin;
    self->cds = clock_bit(self);
    for (uint8_t i = 0; i < self->count; i++) {
        self->slave[i].bits = 0;
        for (uint8_t bit = 0; bit < self->slave[i].data_bits; bit++) {
            self->slave[i].bits = self->slave[i].bits << 1 | clock_bit(self);
        }
    }
    self->silent += !self->answered;
    return self->cds;
}

static void end_frame(struct lx_biss_wire *self, bool cdm)
{
    if (cdm) {
        (void)edge(self, false);
    }
    lx_biss_wire_pause(self, self->now + PAUSE_NS);
    if (cdm) {
        (void)edge(self, true);
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

struct lx_biss_position lx_biss_wire_position(const struct lx_biss_wire *self, uint8_t slave)
{
    const struct lx_biss_slave *own = &self->slave[slave];
    const bool has_life = own->device->setup.model->life_counter;
    const uint64_t data = own->bits >> CRC_BITS;
    const uint64_t state = has_life ? data >> LIFE_BITS : data;
    return (struct lx_biss_position){
        .position = state >> 2,
        .life = has_life ? (uint8_t)(data & 0x3Fu) : 0,
        .n_err = (state & 2u) != 0,
        .n_warn = (state & 1u) != 0,
        .crc_ok = dg_biss_crc6(data, (uint8_t)(own->data_bits - CRC_BITS)) == (own->bits & 0x3Fu),
    };
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

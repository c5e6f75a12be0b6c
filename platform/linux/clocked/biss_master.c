/* SPDX-License-Identifier: MIT */
/*
 * Control frames (5.2.2): a bit of them in each frame, CDM from the master, CDS from the encoder.
 */
#include "biss_master.h"

#include <stdio.h>

#include "biss_clocked.h"
#include "sim_bus.h"

#define ZERO_FRAMES 14u
#define BUSY_MAX_NS 20000000u

/* --- control frames --- */

/* Registers of an encoder, to be read or written. */
struct access {
    struct lx_clocked_wire *wire;
    uint8_t slave;
    const uint8_t *sent; /* NULL: they are read */
    uint8_t *got;        /* NULL: they are written */
};

static bool frame(struct lx_clocked_wire *wire, bool cdm)
{
    const bool cds = lx_biss_frame_begin(wire);
    lx_biss_frame_end(wire, cdm);
    return cds;
}

/* The last `n` bits of `bits`. @return what came back, its last bit in bit 0 */
static unsigned send(struct lx_clocked_wire *wire, unsigned bits, unsigned n)
{
    unsigned back = 0;
    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | frame(wire, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

/* CDS of the frames after R and after W: how the encoder takes it. The last encoder of the line
   gets ID 0. */
static int address_register(const struct access *self, uint8_t address)
{
    struct lx_clocked_wire *wire = self->wire;
    const unsigned id = (unsigned)wire->line->count - 1u - self->slave;
    const unsigned bits = 1u << 10 | id << 7 | address; /* CTS first */
    const bool write = self->sent != NULL;
    const unsigned wanted = write ? 1u : 2u;

    (void)send(wire, 0, ZERO_FRAMES);
    (void)frame(wire, true);
    const unsigned locks = send(wire, bits << 4 | dg_biss_crc4(bits, 11), 15);
    (void)frame(wire, !write);
    unsigned answer = frame(wire, write) ? 2u : 0u;
    answer |= frame(wire, true) ? 1u : 0u;
    if (answer == wanted) {
        return 0;
    }
    return locks == 0 ? LX_BISS_SILENT : LX_BISS_REFUSED;
}

/* S is repeated until it comes back; the frame it comes back in stays open. */
static bool await_start(struct lx_clocked_wire *wire)
{
    const dg_ns begin = wire->now;
    while (!lx_biss_frame_begin(wire)) {
        lx_biss_frame_end(wire, true);
        if (wire->now - begin > BUSY_MAX_NS) {
            return false;
        }
    }
    return true;
}

/* Byte `index` is exchanged. @return P */
static bool exchange(const struct access *self, size_t index, bool last, bool *good)
{
    struct lx_clocked_wire *wire = self->wire;
    const uint8_t byte = self->sent == NULL ? 0 : self->sent[index];
    const unsigned word = self->sent == NULL ? 0 : (unsigned)byte << 4 | dg_biss_crc4(byte, 8);
    lx_biss_frame_end(wire, (word >> 11 & 1u) != 0); /* D7 goes first */
    const unsigned back = send(wire, word << 1, 12);
    const bool stop = lx_biss_frame_begin(wire);
    lx_biss_frame_end(wire, !last && !stop);
    *good = (back & 0x0Fu) == dg_biss_crc4(back >> 4, 8);
    if (self->got != NULL) {
        self->got[index] = (uint8_t)(back >> 4);
    }
    return stop;
}

/* Bytes from `first` up to `end`. P = 1 refuses the byte itself, unless the encoder tells of the
   next one. */
static int exchange_all(const struct access *self, size_t first, size_t end)
{
    const struct dg_biss *device = lx_clocked_device(self->wire->line, self->slave);
    int done = 0;
    bool stop = false;
    for (size_t i = first; i < end && !stop; i++) {
        bool good = false;
        if (!await_start(self->wire)) {
            return LX_BISS_TOO_BUSY;
        }
        stop = exchange(self, i, i + 1 == end, &good);
        if (!good) {
            return LX_BISS_DAMAGED;
        }
        done += !stop || device->setup.model->stop_bit_early;
    }
    return done > 0 ? done : LX_BISS_REFUSED;
}

/* One control frame, which begins with `first` of `n` registers. An SLO that reads high is no echo.
 */
static int transfer(const struct access *self, uint8_t address, size_t first, size_t n)
{
    const uint32_t silent = self->wire->silent;
    int result = address_register(self, (uint8_t)(address + first));
    if (result == 0) {
        result = exchange_all(self, first, n);
    }
    return self->wire->silent == silent ? result : LX_BISS_SILENT;
}

static int transfer_all(const struct access *self, uint8_t address, size_t n, size_t *done)
{
    int result = 0;
    *done = 0;
    while (result >= 0 && *done < n) {
        result = transfer(self, address, *done, n);
        *done += result > 0 ? (size_t)result : 0;
    }
    return result;
}

/* --- in words --- */

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

/* An access to `address` that ended in `failure`, in words: "register 78h: ...". */
static void explain_failure(const struct lx_sim_master *self, uint8_t slave, uint8_t address,
                            int failure, char *to, size_t size)
{
    const int n = lx_sim_master_name(self, slave, to, size);
    (void)snprintf(to + n, size - (size_t)n, "register %02Xh: %s", address,
                   lx_biss_failure_text(failure));
}

/* "register 78h = 04 00" */
static void note_registers(const struct lx_sim_master *self, uint8_t slave, uint8_t address,
                           const uint8_t *bytes, size_t n)
{
    char text[LX_SIM_NOTE_MAX];
    int used = lx_sim_master_name(self, slave, text, sizeof text);
    used += snprintf(text + used, sizeof text - (size_t)used, "register %02Xh =", address);
    for (size_t i = 0; i < n && (size_t)used + 4u < sizeof text; i++) {
        used += snprintf(text + used, sizeof text - (size_t)used, " %02X", bytes[i]);
    }
    lx_sim_master_note(self, text, DG_SEVERITY_OK);
}

/* An access to `done` registers that ended in `result`. */
static void note_access(const struct lx_sim_master *self, uint8_t slave, uint8_t address,
                        const uint8_t *bytes, size_t done, int result)
{
    char text[LX_SIM_NOTE_MAX];
    if (done > 0) {
        note_registers(self, slave, address, bytes, done);
    }
    if (result < 0) {
        explain_failure(self, slave, (uint8_t)(address + done), result, text, sizeof text);
        lx_sim_master_note(self, text, DG_SEVERITY_ERROR);
    }
}

/* --- registers --- */

static int access_registers(const struct lx_sim_master *self, const struct access *access,
                            uint8_t address, size_t n, size_t *done)
{
    const uint8_t *bytes = access->got != NULL ? access->got : access->sent;
    lx_clocked_listen(self->wire.line);
    const int result = transfer_all(access, address, n, done);
    note_access(self, access->slave, address, bytes, *done, result);
    return result;
}

int lx_biss_master_read(struct lx_sim_master *self, uint8_t slave, uint8_t address, uint8_t *bytes,
                        size_t n, size_t *done)
{
    const struct access access = {.wire = &self->wire, .slave = slave, .got = bytes};
    return access_registers(self, &access, address, n, done);
}

int lx_biss_master_write(struct lx_sim_master *self, uint8_t slave, uint8_t address,
                         const uint8_t *bytes, size_t n, size_t *done)
{
    const struct access access = {.wire = &self->wire, .slave = slave, .sent = bytes};
    return access_registers(self, &access, address, n, done);
}

/* --- what the control plane asks for --- */

static int read_frame(void *ctx, uint64_t *bits, uint8_t *count, char *detail)
{
    struct lx_station *station = ctx;
    struct lx_bus *bus = station->bus;
    const struct lx_biss_line *line = lx_biss_line_of(&lx_sim_bus_begin(bus)->wire);
    const struct dg_biss *device = lx_clocked_device(&line->base, station->place);
    const uint8_t data_bits = dg_biss_frame_bits(device->setup.model);
    lx_sim_bus_read(bus);
    lx_sim_bus_end(bus);
    if (!line->frame.answered) {
        (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "%s", lx_biss_failure_text(LX_BISS_SILENT));
        return DG_SCPI_HARDWARE;
    }
    *bits = (uint64_t)line->frame.cds << data_bits | line->frame.bits[station->place];
    *count = (uint8_t)(data_bits + 1u);
    return DG_SCPI_NO_ERROR;
}

/* Write `sent`, or read into `got` where that is not NULL. */
static int serve_access(void *ctx, uint8_t address, const uint8_t *sent, uint8_t *got, size_t n,
                        char *detail)
{
    const struct lx_station *station = ctx;
    struct lx_sim_master *master = lx_sim_bus_begin(station->bus);
    const struct access access = {&master->wire, (uint8_t)station->place, sent, got};
    size_t done = 0;
    const int result = access_registers(master, &access, address, n, &done);
    lx_sim_bus_end(station->bus);
    if (result >= 0) {
        return DG_SCPI_NO_ERROR;
    }
    explain_failure(master, access.slave, (uint8_t)(address + done), result, detail,
                    DG_SCPI_DETAIL_MAX + 1u);
    return DG_SCPI_HARDWARE;
}

static int read_registers(void *ctx, uint8_t address, uint8_t *bytes, size_t n, char *detail)
{
    return serve_access(ctx, address, NULL, bytes, n, detail);
}

static int write_registers(void *ctx, uint8_t address, const uint8_t *bytes, size_t n, char *detail)
{
    return serve_access(ctx, address, bytes, NULL, n, detail);
}

static const struct dg_biss_port_ops port = {
    .frame = read_frame,
    .read = read_registers,
    .write = write_registers,
};

void lx_biss_master_offer(struct lx_station *station)
{
    station->control->port = &port;
    station->control->port_ctx = station;
}

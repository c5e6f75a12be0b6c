/* SPDX-License-Identifier: MIT */
#include "chain.h"

#include <stdio.h>

#include "drehgeber/bus_edges.h"
#include "drehgeber/host_wire.h"

#define HALF_NS 500u
#define PAUSE_NS 15000u
#define EVERY DG_MS(100)
#define START_CLOCKS_MAX 1200u
#define ZERO_FRAMES 14u
#define BUSY_MAX DG_MS(20)

enum failure { SILENT = -1, REFUSED = -2, TOO_BUSY = -3, DAMAGED = -4 };

static const struct dg_biss *device_of(const struct chain *self, size_t place)
{
    return dg_host_line_of(dg_bus_encoder(self->bus, place))->device;
}

/* ------------------------------------------------------------ frames */

static void drive(struct chain *self, bool level)
{
    self->now += HALF_NS;
    (void)dg_bus_edge(self->bus, self->now, level);
}

static bool clock_bit(struct chain *self)
{
    drive(self, false);
    drive(self, true);
    return dg_bus_edges_data(self->bus, self->now + HALF_NS);
}

static void pause_until(struct chain *self, dg_ns now)
{
    self->now = now > self->now ? now : self->now;
    for (size_t i = 0; i < dg_bus_count(self->bus); i++) {
        (void)dg_bus_changed(self->bus, i, self->now);
    }
}

/* Up to the last bit; CDM is still to be said. @return CDS */
static bool begin_frame(struct chain *self)
{
    (void)clock_bit(self);
    (void)clock_bit(self);
    self->answered = dg_bus_edges_fell(self->bus) >= self->now;
    self->silent += self->answered ? 0u : 1u;
    for (unsigned i = 0; i < START_CLOCKS_MAX && !clock_bit(self); i++) {
    }
    self->cds = clock_bit(self);
    for (size_t i = 0; i < dg_bus_count(self->bus); i++) {
        self->bits[i] = 0;
        for (uint8_t left = dg_biss_frame_bits(device_of(self, i)->setup.model); left > 0; left--) {
            self->bits[i] = self->bits[i] << 1 | clock_bit(self);
        }
    }
    return self->cds;
}

static void end_frame(struct chain *self, bool cdm)
{
    if (cdm) {
        drive(self, false);
    }
    pause_until(self, self->now + PAUSE_NS);
    if (cdm) {
        drive(self, true);
    }
}

static bool run_frame(struct chain *self, bool cdm)
{
    const bool cds = begin_frame(self);

    end_frame(self, cdm);
    return cds;
}

static dg_ns next_frame(const struct chain *self)
{
    return self->due > self->now ? self->due : self->now;
}

void chain_catch_up(struct chain *self, dg_ns now)
{
    while (next_frame(self) <= now) {
        pause_until(self, next_frame(self));
        (void)run_frame(self, false);
        self->due += EVERY;
    }
    self->at = now > self->at ? now : self->at;
}

/* ------------------------------------------------------------ control frames */

/* Of an encoder, to be read or written. */
struct access {
    size_t place;
    uint8_t address;
    const uint8_t *sent; /* NULL: they are read */
    uint8_t *got;        /* NULL: they are written */
    size_t done;
};

static unsigned send_bits(struct chain *self, unsigned bits, unsigned n)
{
    unsigned back = 0;

    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | run_frame(self, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

/* The last encoder of the line gets ID 0. */
static int send_address(struct chain *self, const struct access *access)
{
    const unsigned id = (unsigned)(dg_bus_count(self->bus) - 1u - access->place);
    const unsigned bits = 1u << 10 | id << 7 | (uint8_t)(access->address + access->done);
    const bool write = access->sent != NULL;

    (void)send_bits(self, 0, ZERO_FRAMES);
    (void)run_frame(self, true);
    const unsigned locks = send_bits(self, bits << 4 | dg_biss_crc4(bits, 11), 15);
    (void)run_frame(self, !write);
    unsigned answer = run_frame(self, write) ? 2u : 0u;
    answer |= run_frame(self, true) ? 1u : 0u;
    if (answer == (write ? 1u : 2u)) {
        return 0;
    }
    return locks == 0 ? SILENT : REFUSED;
}

static bool await_start(struct chain *self)
{
    const dg_ns begin = self->now;

    while (!begin_frame(self)) {
        end_frame(self, true);
        if (self->now - begin > BUSY_MAX) {
            return false;
        }
    }
    return true;
}

/* @return P: the next one is refused */
static bool exchange_byte(struct chain *self, const struct access *access, bool last, bool *good)
{
    const uint8_t byte = access->sent == NULL ? 0 : access->sent[access->done];
    const unsigned word = access->sent == NULL ? 0 : (unsigned)byte << 4 | dg_biss_crc4(byte, 8);

    end_frame(self, (word >> 11 & 1u) != 0);
    const unsigned back = send_bits(self, word << 1, 12);
    const bool stop = begin_frame(self);
    end_frame(self, !last && !stop);
    *good = (back & 0x0Fu) == dg_biss_crc4(back >> 4, 8);
    if (access->got != NULL) {
        access->got[access->done] = (uint8_t)(back >> 4);
    }
    return stop;
}

/* A control frame: bytes up to `n`, or to the one that is refused. */
static int transfer(struct chain *self, struct access *access, size_t n)
{
    const struct dg_biss *device = device_of(self, access->place);
    const size_t first = access->done;
    size_t kept = first;
    bool stop = false;
    int result = send_address(self, access);

    for (access->done = first; result == 0 && access->done < n && !stop; access->done++) {
        bool good = false;
        if (!await_start(self)) {
            return TOO_BUSY;
        }
        stop = exchange_byte(self, access, access->done + 1u == n, &good);
        result = good ? 0 : DAMAGED;
        kept += result == 0 && (!stop || device->setup.model->stop_bit_early) ? 1u : 0u;
    }
    access->done = result < 0 ? first : kept;
    return result < 0 ? result : kept > first ? 0 : REFUSED;
}

static int access_registers(struct chain *self, struct access *access, size_t n, char *detail)
{
    static const char *const texts[] = {[-SILENT] = "no answer",
                                        [-REFUSED] = "refused: not implemented or protected",
                                        [-TOO_BUSY] = "busy for more than 20 ms",
                                        [-DAMAGED] = "wrong check sum"};
    int result = 0;

    chain_catch_up(self, self->at);
    pause_until(self, self->at);
    while (result == 0 && access->done < n) {
        const unsigned silent = self->silent;
        const size_t before = access->done;
        result = transfer(self, access, n);
        if (self->silent != silent) {
            access->done = before;
            result = SILENT;
        }
    }
    if (result == 0) {
        return 0;
    }
    (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "register %02Xh: %s",
                   (uint8_t)(access->address + access->done), texts[-result]);
    return DG_SCPI_HARDWARE;
}

/* ------------------------------------------------------------ what the control plane asks for */

/* Handed over by each encoder. */
static struct place {
    struct chain *chain;
    size_t index;
} places[DG_BISS_CHAIN_MAX];

static int read_frame(void *ctx, uint64_t *bits, uint8_t *count, char *detail)
{
    const struct place *place = ctx;
    struct chain *chain = place->chain;
    const uint8_t data = dg_biss_frame_bits(device_of(chain, place->index)->setup.model);

    chain_catch_up(chain, chain->at);
    pause_until(chain, chain->at);
    (void)run_frame(chain, false);
    if (!chain->answered) {
        (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "no answer");
        return DG_SCPI_HARDWARE;
    }
    *bits = (uint64_t)chain->cds << data | chain->bits[place->index];
    *count = (uint8_t)(data + 1u);
    return 0;
}

static int read_registers(void *ctx, uint8_t address, uint8_t *bytes, size_t n, char *detail)
{
    const struct place *place = ctx;
    struct access access = {.place = place->index, .address = address, .got = bytes};

    return access_registers(place->chain, &access, n, detail);
}

static int write_registers(void *ctx, uint8_t address, const uint8_t *bytes, size_t n, char *detail)
{
    const struct place *place = ctx;
    struct access access = {.place = place->index, .address = address, .sent = bytes};

    return access_registers(place->chain, &access, n, detail);
}

void chain_begin(struct chain *self, struct dg_engine *engine, dg_ns begin)
{
    static const struct dg_biss_port_ops port = {
        .frame = read_frame, .read = read_registers, .write = write_registers};
    struct dg_rig *rig = dg_engine_control(engine);
    dg_ns init = 0;

    *self = (struct chain){.bus = dg_engine_bus(engine, 0), .now = begin, .at = begin};
    for (size_t i = 0; i < rig->encoder_count; i++) {
        const struct dg_biss_model *model = dg_host_line_of(dg_engine_encoder(engine, i))->settings;
        places[i] = (struct place){self, i};
        rig->encoders[i]->port = &port;
        rig->encoders[i]->port_ctx = &places[i];
        init = model->init > init ? model->init : init;
    }
    self->due = begin + init;
}

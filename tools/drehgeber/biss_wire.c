/* SPDX-License-Identifier: MIT */
#include "biss_wire.h"

#include <inttypes.h>
#include <string.h>

#define START_CLOCKS_MAX 1000u
#define ZERO_FRAMES 14u
#define BUSY_MAX_NS 20000000u
/* A real master pauses a little longer than the encoder's timeout. */
#define PAUSE_NS 15000u
#define CRC_BITS 6u
#define LIFE_BITS 6u

/* Value change dump (IEEE 1364): two wires, nanoseconds. */
static void begin_trace(const struct biss_wire *self)
{
    (void)fprintf(self->trace,
                  "$timescale 1 ns $end\n$scope module biss $end\n"
                  "$var wire 1 m MA $end\n$var wire 1 s SLO $end\n"
                  "$upscope $end\n$enddefinitions $end\n"
                  "#%" PRIu64 "\n$dumpvars\n1m\n1s\n$end\n",
                  self->now);
}

/* The levels from `now` on, as far as they are new. */
static void record(struct biss_wire *self, bool ma, bool slo)
{
    const bool new_ma = ma != self->ma;
    const bool new_slo = slo != self->slo;

    if (self->trace != NULL && (new_ma || new_slo)) {
        (void)fprintf(self->trace, "#%" PRIu64 "\n", self->now);
        if (new_ma) {
            (void)fprintf(self->trace, "%dm\n", ma);
        }
        if (new_slo) {
            (void)fprintf(self->trace, "%ds\n", slo);
        }
    }
    self->ma = ma;
    self->slo = slo;
}

void biss_wire_init(struct biss_wire *self, struct dg_biss *device, dg_ns now, FILE *trace)
{
    const struct dg_biss_model *model = device->setup.model;

    *self =
        (struct biss_wire){.device = device, .now = now, .trace = trace, .ma = true, .slo = true};
    self->data_bits = (uint8_t)(model->multiturn_bits + model->singleturn_bits + 2u +
                                (model->life_counter ? LIFE_BITS : 0u) + CRC_BITS);
    if (trace != NULL) {
        begin_trace(self);
    }
}

void biss_wire_pause(struct biss_wire *self, dg_ns now)
{
    const dg_ns deadline = dg_biss_step(self->device, self->now);

    if (deadline <= now) {
        self->now = deadline;
        (void)dg_biss_step(self->device, deadline);
        record(self, self->ma, dg_biss_slo(self->device, false));
    }
    self->now = now;
}

static bool edge(struct biss_wire *self, bool level)
{
    self->now += BISS_WIRE_HALF_NS;
    record(self, level, dg_biss_ma(self->device, self->now, level));
    return self->slo;
}

static bool clock_bit(struct biss_wire *self)
{
    (void)edge(self, false);
    return edge(self, true);
}

/* Up to the last bit of the CRC; the CDM bit is not yet decided. @return CDS */
static bool begin_frame(struct biss_wire *self)
{
    (void)clock_bit(self); /* e1 */
    (void)clock_bit(self); /* e2, Ack */
    for (unsigned i = 0; i < START_CLOCKS_MAX && !clock_bit(self); i++) {
    }
    const bool cds = clock_bit(self);
    self->bits = 0;
    for (uint8_t i = 0; i < self->data_bits; i++) {
        self->bits = self->bits << 1 | clock_bit(self);
    }
    return cds;
}

static void end_frame(struct biss_wire *self, bool cdm)
{
    if (cdm) {
        (void)edge(self, false);
    }
    biss_wire_pause(self, self->now + PAUSE_NS);
    if (cdm) {
        (void)edge(self, true);
    }
}

static bool frame(struct biss_wire *self, bool cdm)
{
    const bool cds = begin_frame(self);

    end_frame(self, cdm);
    return cds;
}

struct biss_wire_position biss_wire_read_position(struct biss_wire *self)
{
    const bool has_life = self->device->setup.model->life_counter;

    (void)frame(self, false);
    const uint64_t data = self->bits >> CRC_BITS;
    const uint64_t state = has_life ? data >> LIFE_BITS : data;
    return (struct biss_wire_position){
        .position = state >> 2,
        .life = has_life ? (uint8_t)(data & 0x3Fu) : 0,
        .n_err = (state & 2u) != 0,
        .n_warn = (state & 1u) != 0,
        .crc_ok = dg_biss_crc6(data, (uint8_t)(self->data_bits - CRC_BITS)) == (self->bits & 0x3Fu),
    };
}

/* The last `n` bits of `bits`. @return what came back, its last bit in bit 0 */
static unsigned send(struct biss_wire *self, unsigned bits, unsigned n)
{
    unsigned back = 0;

    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | frame(self, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

/* CDS of the frames after R and after W: how the encoder takes it. */
static int address_register(struct biss_wire *self, uint8_t address, bool write)
{
    const unsigned bits = 1u << 10 | address; /* CTS, ID 0 */
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
    return locks == 0 ? BISS_WIRE_SILENT : BISS_WIRE_REFUSED;
}

/* S is repeated until it comes back; the frame it comes back in stays open. */
static bool await_start(struct biss_wire *self)
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

/* `bytes` is sent when writing, and replaced by what came back. */
static int access_registers(struct biss_wire *self, uint8_t address, uint8_t *bytes, size_t n,
                            bool write)
{
    int result = address_register(self, address, write);
    bool refused = false;

    for (size_t i = 0; result >= 0 && i < n && !refused; i++) {
        if (!await_start(self)) {
            return BISS_WIRE_TOO_BUSY;
        }
        const unsigned word =
            write ? (unsigned)bytes[i] << 4 | dg_biss_crc4(bytes[i], 8) : 0; /* D7 goes first */
        end_frame(self, (word >> 11 & 1u) != 0);
        const unsigned back = send(self, word << 1, 12);
        refused = begin_frame(self); /* P */
        end_frame(self, i + 1 < n && !refused);
        bytes[i] = (uint8_t)(back >> 4);
        result = (back & 0x0Fu) == dg_biss_crc4(bytes[i], 8) ? result + 1 : BISS_WIRE_DAMAGED;
    }
    return result;
}

int biss_wire_read(struct biss_wire *self, uint8_t address, uint8_t *bytes, size_t n)
{
    return access_registers(self, address, bytes, n, false);
}

int biss_wire_write(struct biss_wire *self, uint8_t address, const uint8_t *bytes, size_t n)
{
    uint8_t copy[DG_BISS_BANK_SIZE] = {0};

    if (n > sizeof copy) {
        return BISS_WIRE_REFUSED;
    }
    memcpy(copy, bytes, n);
    return access_registers(self, address, copy, n, true);
}

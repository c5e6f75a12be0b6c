/* SPDX-License-Identifier: MIT */
/*
 * A BiSS slave behind a handle: edges of a master outside, or frames and registers by a master in
 * here, point to point and without delay. It clocks edges as any other does, and takes apart what
 * comes back.
 */
#include <string.h>

#include "drehgeber/biss.h"
#include "drehgeber/host_wire.h"

#define PERIOD_NS DG_US(1)
/* What the slave may need before its start bit, and more: where time ends it has none. */
#define START_CLOCKS_MAX 200u

static bool level(const struct dg_host_line *line)
{
    return dg_biss_slo(line->device, line->behind);
}

/* Whether the edge is e1, at which the position is read. */
static bool begins_frame(const struct dg_biss_line *line, dg_ns now, bool high)
{
    return line->state == DG_BISS_IDLE && high && !line->ma && now < line->deadline;
}

static bool set_clock(struct dg_host_line *line, dg_ns now, bool high)
{
    struct dg_biss *device = line->device;

    if (begins_frame(&device->line, now, high)) {
        line->latched = now;
    }
    return dg_biss_link(device, now, high, line->behind);
}

static uint64_t latched(const struct dg_host_line *line)
{
    const struct dg_biss *device = line->device;

    return device->position;
}

static const char *hint(struct dg_host_line *line, dg_ns now, dg_ns *due)
{
    return dg_biss_hint(line->device, now, due) ? DG_BISS_HINT : NULL;
}

/* ------------------------------------------------------------ frames */

/* @return SLO behind the rising edge */
static bool clock_bit(struct dg_host_line *line)
{
    (void)dg_biss_ma(line->device, dg_after(line->now, PERIOD_NS / 2u), false);
    line->now = dg_after(line->now, PERIOD_NS);
    return dg_biss_ma(line->device, line->now, true);
}

/* From e1 at line->now to the last bit of the CRC. @return CDS, or DG_HOST_ERR_SILENT */
static int begin_exchange(struct dg_host_line *line, uint64_t *bits)
{
    struct dg_biss *device = line->device;
    unsigned clocks = 0;

    (void)dg_biss_ma(device, line->now, false);
    (void)dg_biss_ma(device, line->now, true);
    (void)clock_bit(line); /* Ack */
    while (!clock_bit(line)) {
        if (++clocks == START_CLOCKS_MAX) {
            return DG_HOST_ERR_SILENT;
        }
    }
    const int cds = clock_bit(line) ? 1 : 0;
    *bits = 0;
    for (uint8_t i = dg_biss_frame_bits(device->setup.model); i > 0; i--) {
        *bits = *bits << 1 | clock_bit(line);
    }
    return cds;
}

/* CDM is MA inverted while the slave's timeout runs. */
static void end_exchange(struct dg_host_line *line, bool cdm)
{
    line->now = dg_after(line->now, PERIOD_NS / 2u);
    (void)dg_biss_ma(line->device, line->now, !cdm);
    const dg_ns deadline = dg_biss_step(line->device, line->now);
    line->now = deadline != DG_NEVER ? deadline : line->now;
    (void)dg_biss_step(line->device, line->now);
    line->now = dg_after(line->now, PERIOD_NS / 2u);
    (void)dg_biss_ma(line->device, line->now, true);
    (void)dg_biss_step(line->device, line->now);
    line->now = dg_after(line->now, PERIOD_NS / 2u);
}

static bool idle(const struct dg_biss *device)
{
    return device->line.state == DG_BISS_IDLE && device->line.ma;
}

static int frame(struct dg_host_line *line, struct dg_host_frame *to)
{
    const struct dg_biss *device = line->device;
    struct dg_biss_data data;

    if (!idle(device)) {
        return DG_HOST_ERR_STATE;
    }
    to->at = line->now;
    line->latched = line->now;
    (void)begin_exchange(line, &to->bits); /* an idle slave always has a start bit */
    end_exchange(line, false);
    dg_biss_frame_decode(device->setup.model, to->bits, &data);
    to->count = dg_biss_frame_bits(device->setup.model);
    to->position = data.position;
    to->multiturn = data.multiturn;
    to->singleturn = data.singleturn;
    to->error = !data.n_err;
    to->warning = !data.n_warn;
    to->good = data.crc_ok;
    to->life = data.life;
    return DG_HOST_OK;
}

/* Which form frames and the EEPROM have is the model's to say, and in no state. */
static void arrange(void *settings, struct dg_stack_setup *setup)
{
    struct dg_biss_model *self = settings;
    const struct dg_biss_model *delivered = setup == NULL ? NULL : setup->model;

    self->form = delivered == NULL ? NULL : delivered->form;
    self->layout = delivered == NULL ? NULL : delivered->layout;
}

const struct dg_host_wire dg_biss_wire = {
    .stack = &dg_biss_stack,
    .keys = &dg_biss_keys,
    .settings_size = sizeof(struct dg_biss_model),
    .arrange = arrange,
    .level = level,
    .clock = set_clock,
    .latched = latched,
    .chains = true,
    .hint = hint,
    .frame = frame,
    .state = &dg_biss_check,
};

const struct dg_bus_side dg_biss_side = {.wire = &dg_biss_wire};

/* ------------------------------------------------------------ registers */

#define ZERO_FRAMES 14u
#define CTS (1u << 10)
#define ADDRESS_BITS 11u

/* A register access on its way. */
struct access {
    struct dg_host_line *line;
    bool write;
    bool silent; /* a frame was not answered */
};

/* A frame with this CDM. @return its CDS */
static bool bit(struct access *access, bool cdm)
{
    uint64_t bits;
    const int cds = begin_exchange(access->line, &bits);

    end_exchange(access->line, cdm);
    access->silent = access->silent || cds < 0;
    return cds > 0;
}

/* The last `n` bits of `bits`. @return what came back, its last bit in bit 0 */
static unsigned clock_bits(struct access *access, unsigned bits, unsigned n)
{
    unsigned back = 0;

    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | bit(access, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

/* The only slave has ID 0. CDS of the frames behind R and W is how it takes that. */
static int address_register(struct access *access, uint8_t address)
{
    const unsigned bits = CTS | address;
    const unsigned wanted = access->write ? 1u : 2u;

    (void)clock_bits(access, 0, ZERO_FRAMES);
    (void)bit(access, true);
    (void)clock_bits(access, bits << 4 | dg_biss_crc4(bits, ADDRESS_BITS), ADDRESS_BITS + 4u);
    (void)bit(access, !access->write);
    unsigned answer = bit(access, access->write) ? 2u : 0u;
    answer |= bit(access, true) ? 1u : 0u;
    return answer == wanted ? DG_HOST_OK : DG_HOST_ERR_REFUSED;
}

/* S is repeated until it comes back. The frame it comes back in has the first bit for its CDM, and
 * so has the one that P comes back in the S of the next byte, or the end. */
static bool await_start(struct access *access)
{
    const dg_ns latest = dg_after(access->line->now, DG_BISS_BUSY_R_MAX_NS);
    dg_ns begun = access->line->now;

    /* A timeout may be as long as that: what was asked in time is looked for in the next frame. */
    while (begun <= latest) {
        uint64_t bits;
        const int cds = begin_exchange(access->line, &bits);
        if (cds != 0) {
            return cds > 0;
        }
        begun = access->line->now;
        end_exchange(access->line, true);
    }
    return false;
}

/* One byte is exchanged. @return P */
static bool exchange_host_byte(struct access *access, uint8_t *byte, bool last, bool *good)
{
    const unsigned word = access->write ? (unsigned)*byte << 4 | dg_biss_crc4(*byte, 8) : 0;
    uint64_t bits;

    end_exchange(access->line, (word >> 11 & 1u) != 0); /* D7 goes first */
    const unsigned back = clock_bits(access, word << 1, 12);
    const bool stop = begin_exchange(access->line, &bits) > 0;
    end_exchange(access->line, !last && !stop);
    *byte = (uint8_t)(back >> 4);
    *good = (back & 0x0Fu) == dg_biss_crc4(*byte, 8);
    return stop;
}

/* P = 1 refuses the byte itself, unless the encoder tells of the next one (stop_bit_early). */
static int exchange_registers(struct access *access, uint8_t *bytes, size_t n)
{
    const struct dg_biss *device = access->line->device;
    bool stop = false;
    int done = 0;

    for (size_t i = 0; i < n && !stop; i++) {
        bool good = false;
        if (!await_start(access)) {
            return DG_HOST_ERR_SILENT;
        }
        stop = exchange_host_byte(access, &bytes[i], i + 1u == n, &good);
        if (!good) {
            return DG_HOST_ERR_DAMAGED;
        }
        done += !stop || device->setup.model->stop_bit_early ? 1 : 0;
    }
    return done > 0 ? done : DG_HOST_ERR_REFUSED;
}

/* `bytes` are sent when writing, and replaced by what came back. */
static int access_registers(struct dg_host *self, uint64_t *now, uint8_t address, uint8_t *bytes,
                            size_t n, bool write)
{
    int result;
    struct access access = {.line = dg_host_line_at(self, &dg_biss_wire, *now, &result),
                            .write = write};

    if (access.line == NULL) {
        return result;
    }
    if (!idle(access.line->device)) {
        return DG_HOST_ERR_STATE;
    }
    result = address_register(&access, address);
    if (result == DG_HOST_OK) {
        result = exchange_registers(&access, bytes, n);
    }
    *now = access.line->now;
    dg_host_line_done(self);
    return access.silent ? DG_HOST_ERR_SILENT : result;
}

int dg_host_registers_read(struct dg_host *self, uint64_t *now, uint8_t address, uint8_t *bytes,
                           size_t n)
{
    return n == 0 || n > DG_BISS_BANK_SIZE || address > 0x7Fu
               ? DG_HOST_ERR_ARGUMENT
               : access_registers(self, now, address, bytes, n, false);
}

int dg_host_registers_write(struct dg_host *self, uint64_t *now, uint8_t address,
                            const uint8_t *bytes, size_t n)
{
    uint8_t copy[DG_BISS_BANK_SIZE] = {0};

    if (n == 0 || n > sizeof copy || address > 0x7Fu) {
        return DG_HOST_ERR_ARGUMENT;
    }
    memcpy(copy, bytes, n);
    return access_registers(self, now, address, copy, n, true);
}

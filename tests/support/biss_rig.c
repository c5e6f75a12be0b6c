/* SPDX-License-Identifier: MIT */
#include "biss_rig.h"

#include <string.h>

#define TIMEOUT_WAIT_NS 14000u
#define START_CLOCKS_MAX 1000u
#define BUSY_FRAMES_MAX 4000u

static dg_angle shaft_angle(void *ctx, dg_ns now)
{
    const struct biss_rig *self = ctx;

    return (dg_angle)((uint64_t)self->angle + (uint64_t)self->angle_per_us * (now / 1000u));
}

/* Long division with polynomial `x`, whose highest bit is bit `width`. */
static uint8_t remainder_of(uint64_t bits, unsigned n, unsigned width, unsigned x)
{
    unsigned rest = 0;

    for (unsigned i = 0; i < n + width; i++) {
        const unsigned bit = i < n ? (unsigned)(bits >> (n - 1u - i)) & 1u : 0;
        rest = rest << 1 | bit;
        rest = (rest >> width & 1u) != 0 ? rest ^ x : rest;
    }
    return (uint8_t)(rest ^ ((1u << width) - 1u));
}

uint8_t biss_rig_crc4(unsigned bits, unsigned n)
{
    return remainder_of(bits, n, 4, 0x13);
}

uint8_t biss_rig_crc6(uint64_t bits, unsigned n)
{
    return remainder_of(bits, n, 6, 0x43);
}

int biss_rig_init(struct biss_rig *self, const struct dg_biss_model *model, uint8_t count)
{
    int result = DG_OK;

    memset(self, 0, sizeof *self);
    dg_world_init(&self->world);
    self->world.angle = shaft_angle;
    self->world.angle_ctx = self;
    self->model = *model;
    self->count = count;
    self->half_ns = 500;
    self->noise = 1;
    self->data_bits = (uint8_t)((model->multiturn_bits + model->singleturn_bits + 8u +
                                 (model->life_counter ? 6u : 0u)) *
                                count);
    for (uint8_t i = 0; i < count && result == DG_OK; i++) {
        ram_nvm_init(&self->nvm[i], dg_store_size(&dg_biss_layout));
        const struct dg_biss_setup setup = {
            .model = &self->model, .world = &self->world, .nvm = ram_nvm_port(&self->nvm[i])};
        result = dg_biss_format(setup.nvm);
        result = result == DG_OK ? dg_biss_init(&self->slave[i], &setup) : result;
    }
    return result;
}

int biss_rig_power_on(struct biss_rig *self)
{
    int result = DG_OK;

    for (uint8_t i = self->count; i > 0; i--) {
        result = dg_biss_power_on(&self->slave[i - 1u], self->now);
    }
    self->now += self->model.init;
    return result;
}

static struct dg_biss_chain chain_of(struct biss_rig *self)
{
    struct dg_biss_chain chain = {.count = self->count};

    for (uint8_t i = 0; i < self->count; i++) {
        chain.slave[i] = &self->slave[i];
    }
    return chain;
}

bool biss_rig_edge(struct biss_rig *self, bool level)
{
    struct dg_biss_chain chain = chain_of(self);

    self->noise = self->noise * 1664525u + 1013904223u;
    const int64_t permille =
        self->jitter == 0 ? 0 : (int64_t)((self->noise >> 8) % (2u * self->jitter)) - self->jitter;
    self->now += (dg_ns)((int64_t)self->half_ns + (int64_t)self->half_ns * permille / 1000);
    return self->count == 1 ? dg_biss_ma(&self->slave[0], self->now, level)
                            : dg_biss_chain_ma(&chain, self->now, level);
}

static bool clock_bit(struct biss_rig *self)
{
    (void)biss_rig_edge(self, false);
    return biss_rig_edge(self, true);
}

static void wait_timeout(struct biss_rig *self)
{
    struct dg_biss_chain chain = chain_of(self);

    self->now += TIMEOUT_WAIT_NS;
    (void)dg_biss_chain_step(&chain, self->now);
}

/* The same moments as with edges. */
static bool begin_word(struct biss_rig *self)
{
    const dg_ns period = 2u * self->half_ns;
    uint64_t bits = 0;

    self->now += period;
    const uint8_t n = dg_biss_frame(&self->slave[0], self->now, &bits);
    const dg_ns busy = self->slave[0].line.start - self->now;
    const dg_ns busy_clocks = (busy + period - 1u) / period;
    self->clocks = busy_clocks > 2u ? (uint32_t)busy_clocks : 2u;
    self->now += period * (self->clocks + 1u + self->data_bits);
    self->bits = (bits & (((uint64_t)1 << (n - 1u)) - 1u)) << (self->data_bits - (n - 1u));
    return (bits >> (n - 1u)) != 0;
}

bool biss_rig_begin(struct biss_rig *self)
{
    self->frames++;
    if (self->words) {
        return begin_word(self);
    }
    (void)clock_bit(self); /* e1 */
    (void)clock_bit(self); /* e2 */
    self->clocks = 2;
    while (!clock_bit(self) && self->clocks < START_CLOCKS_MAX) {
        self->clocks++;
    }
    const bool cds = clock_bit(self);
    self->bits = 0;
    for (uint8_t i = 0; i < self->data_bits; i++) {
        self->bits = self->bits << 1 | clock_bit(self);
    }
    return cds;
}

void biss_rig_end(struct biss_rig *self, bool cdm)
{
    if (self->words) {
        self->now += cdm ? self->half_ns : 0;
        dg_biss_frame_end(&self->slave[0], self->now + DG_BISS_TIMEOUT_NS, cdm);
        self->now += TIMEOUT_WAIT_NS + (cdm ? self->half_ns : 0);
        return;
    }
    if (cdm) {
        (void)biss_rig_edge(self, false);
    }
    wait_timeout(self);
    if (cdm) {
        (void)biss_rig_edge(self, true);
    }
}

bool biss_rig_frame(struct biss_rig *self, bool cdm)
{
    const bool cds = biss_rig_begin(self);

    biss_rig_end(self, cdm);
    return cds;
}

void biss_rig_cut(struct biss_rig *self, uint32_t edges)
{
    bool level = true;

    for (uint32_t i = 0; i < edges; i++) {
        level = !level;
        (void)biss_rig_edge(self, level);
    }
    wait_timeout(self);
    if (!level) {
        (void)biss_rig_edge(self, true);
    }
}

void biss_rig_zeros(struct biss_rig *self)
{
    for (unsigned i = 0; i < DG_BISS_ZEROS; i++) {
        (void)biss_rig_frame(self, false);
    }
}

void biss_rig_send(struct biss_rig *self, const char *cdm, char *cds)
{
    for (; *cdm != '\0'; cdm++) {
        if (*cdm != ' ') {
            *cds++ = biss_rig_frame(self, *cdm == '1') ? '1' : '0';
        }
    }
    *cds = '\0';
}

/* The last `n` bits of `bits`. @return what came back, its last bit in bit 0 */
static uint32_t send_bits(struct biss_rig *self, uint32_t bits, unsigned n)
{
    uint32_t back = 0;

    for (unsigned i = n; i > 0; i--) {
        back = back << 1 | biss_rig_frame(self, (bits >> (i - 1u) & 1u) != 0);
    }
    return back;
}

unsigned biss_rig_address(struct biss_rig *self, uint8_t id, uint8_t address, bool write)
{
    const uint32_t bits = 1u << 10 | (uint32_t)id << 7 | address;

    biss_rig_zeros(self);
    (void)send_bits(self, 1, 1);
    (void)send_bits(self, bits << 4 | biss_rig_crc4(bits, 11), 15);
    /* R goes out with frame 16, and is back in frame 17. */
    (void)send_bits(self, write ? 0 : 1, 1);
    unsigned answer = send_bits(self, write ? 1 : 0, 1) << 1;
    answer |= send_bits(self, 1, 1);
    return answer;
}

/* S again and again until it comes back; then the frame is still open for the first bit of data. */
static bool await_s(struct biss_rig *self)
{
    for (unsigned i = 0; i < BUSY_FRAMES_MAX; i++) {
        if (biss_rig_begin(self)) {
            return true;
        }
        biss_rig_end(self, true);
    }
    biss_rig_end(self, false);
    return false;
}

/* Frames 19 to 31 and the CDS of 32, which stays open. @return data and CRC that came back */
static unsigned exchange_byte(struct biss_rig *self, unsigned word)
{
    biss_rig_end(self, (word >> 11 & 1u) != 0);
    unsigned back = send_bits(self, (word & 0x7FFu) << 1, 12);
    self->p = biss_rig_begin(self);
    return back;
}

/* One control frame; `bytes` are sent, and replaced by what came back. */
static int access_registers(struct biss_rig *self, const uint8_t where[2], bool write,
                            uint8_t *bytes, size_t n)
{
    const unsigned answer = biss_rig_address(self, where[0], where[1], write);
    int done = 0;

    if (answer != (write ? 1u : 2u)) {
        return answer == 0 && !write ? BISS_RIG_SILENT : BISS_RIG_REFUSED;
    }
    for (size_t i = 0; i < n; i++) {
        if (!await_s(self)) {
            return done > 0 ? done : BISS_RIG_STUCK;
        }
        const unsigned data = (unsigned)bytes[i] << 4 | biss_rig_crc4(bytes[i], 8);
        const unsigned back = exchange_byte(self, write ? data : 0);
        const bool last = i + 1 == n || self->p;
        biss_rig_end(self, !last);
        if ((back & 0x0Fu) != biss_rig_crc4(back >> 4, 8)) {
            return BISS_RIG_CRC;
        }
        bytes[i] = (uint8_t)(back >> 4);
        /* P = 1 takes the byte back; early, it is about the next one. */
        done += !self->p || self->model.stop_bit_early;
        if (last) {
            break;
        }
    }
    return done > 0 ? done : BISS_RIG_REFUSED;
}

int biss_rig_read(struct biss_rig *self, uint8_t id, uint8_t address, uint8_t *bytes, size_t n)
{
    const uint8_t where[2] = {id, address};

    return access_registers(self, where, false, bytes, n);
}

int biss_rig_write(struct biss_rig *self, uint8_t id, uint8_t address, const uint8_t *bytes,
                   size_t n)
{
    const uint8_t where[2] = {id, address};
    uint8_t copy[DG_BISS_BANK_SIZE] = {0};

    memcpy(copy, bytes, n);
    return access_registers(self, where, true, copy, n);
}

int biss_rig_get(struct biss_rig *self, uint8_t address)
{
    uint8_t byte = 0;
    const int result = biss_rig_read(self, 0, address, &byte, 1);

    return result == 1 ? byte : result;
}

int biss_rig_put(struct biss_rig *self, uint8_t address, uint8_t value)
{
    return biss_rig_write(self, 0, address, &value, 1);
}

uint8_t biss_rig_command(struct biss_rig *self, uint8_t ids, uint8_t command)
{
    const uint32_t bits = (uint32_t)ids << 2 | command;
    uint32_t ida = 0;

    biss_rig_zeros(self);
    (void)send_bits(self, 1, 1);
    (void)send_bits(self, bits << 4 | biss_rig_crc4(bits, 11), 15);
    (void)send_bits(self, 1, 1);
    ida = send_bits(self, 1, ids == 0 ? 1 : 8); /* EX is the last bit */
    return (uint8_t)ida;
}

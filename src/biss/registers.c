/* SPDX-License-Identifier: MIT */
/*
 * The registers (5.2.1.3, 5.2.2, 5.2.3): one row for each kind, found by bank and address.
 */
#include "biss_private.h"
#include "drehgeber/bits.h"

#define BANK_EDS 3u
#define STATUS_ADDRESS 0x60u
/* nERR and nWARN of a frame are ERR and WARN inverted, in the same order. */
#define STATUS_WARN_BIT 5u
#define TIMEOUT_OFFSET 4u
#define TIMEOUT_MASK 0x07u
#define FIELD_MASK 0x1Fu
#define ST_ALIGNED_BITS 26u
/* DIR, RESO_CC and the two lowest bits of OFFS_ST; the rest of 1Bh is 0. */
#define CONFIG_1B_MASK 0xC7u

static void eeprom_works(struct dg_biss *self, dg_ns now)
{
    self->control.ready = dg_after(now, self->setup.model->eeprom_write);
}

static int store_config(struct dg_biss *self, dg_ns now)
{
    if (!dg_biss_eeprom(self)) {
        return DG_ERR_IO;
    }
    eeprom_works(self, now);
    return dg_store_put(&self->store, DG_BISS_REGION_CONFIG, 0, self->config, BISS_CONFIG_SIZE);
}

static int read_config(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)now;
    *value = self->config[offset];
    return DG_OK;
}

static int write_config(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t value)
{
    self->config[offset] = offset == 0 ? value & CONFIG_1B_MASK : value;
    return self->setup.model->autostore ? store_config(self, now) : DG_OK;
}

static int read_common(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)now;
    *value = dg_biss_eds_common(self->setup.model, offset);
    return DG_OK;
}

static int read_profile(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)now;
    *value = dg_biss_eds_profile(self->setup.model, offset);
    return DG_OK;
}

static uint8_t user_region(const struct dg_biss *self)
{
    return (uint8_t)(DG_BISS_REGION_USER + self->bank - DG_BISS_BANK_USER_FIRST);
}

static int read_user(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)now;
    return dg_store_read(&self->store, user_region(self), offset, value, 1);
}

/* A checked region is written as a whole. */
static int write_user(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t value)
{
    uint8_t bytes[DG_BISS_BANK_SIZE];
    const uint8_t region = user_region(self);
    const int result = dg_store_read(&self->store, region, 0, bytes, sizeof bytes);

    eeprom_works(self, now);
    bytes[offset] = value;
    return result == DG_OK ? dg_store_put(&self->store, region, 0, bytes, sizeof bytes) : result;
}

static int read_bank(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)now;
    (void)offset;
    *value = self->bank;
    return DG_OK;
}

static int write_bank(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t value)
{
    (void)now;
    (void)offset;
    self->bank = value;
    return DG_OK;
}

/* 41h..47h: EDS bank, profile, serial number. */
static int read_profile_id(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)now;
    const struct dg_biss_model *model = self->setup.model;
    uint8_t bytes[7] = {model->no_eds ? 0 : BANK_EDS, model->profile_id,
                        dg_biss_position_bits(model)};

    dg_store_be32(&bytes[3], model->serial);
    *value = bytes[offset];
    return DG_OK;
}

static int read_status(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    const uint8_t invalid = DG_BISS_SYNC | DG_BISS_INTERPOLATION | DG_BISS_ABSOLUTE;
    const uint8_t errors = dg_biss_errors(self, now);
    uint32_t status = (dg_biss_flags(self, now) ^ 3u) << STATUS_WARN_BIT;

    (void)offset;
    if (!dg_biss_initialising(self, now)) {
        status |= DG_BISS_STATUS_EWKH;
        status |= self->configured ? DG_BISS_STATUS_INIT : 0u;
        status |= now < self->control.ready ? DG_BISS_STATUS_BUSY : 0u;
        status |= (errors & DG_BISS_ABSOLUTE) == 0 ? DG_BISS_STATUS_ADV : 0u;
        status |= (errors & invalid) == 0 ? DG_BISS_STATUS_VALID : 0u;
    }
    *value = (uint8_t)status;
    return DG_OK;
}

static int do_nothing(struct dg_biss *self, dg_ns now)
{
    (void)self;
    (void)now;
    return DG_OK;
}

/* What the memory holds now; the values in force stay. */
static int check_eeprom(struct dg_biss *self, dg_ns now)
{
    if (!self->setup.world->eeprom_acknowledges) {
        return DG_ERR_IO;
    }
    eeprom_works(self, now);
    self->checked_at = self->control.ready;
    const int result = dg_biss_mount(&self->store, self->setup.model, self->setup.nvm);
    self->mounted = result == DG_OK;
    return result;
}

static int simulate_error(struct dg_biss *self, dg_ns now)
{
    (void)now;
    self->simulated = true;
    return DG_OK;
}

static int clear_error(struct dg_biss *self, dg_ns now)
{
    (void)now;
    self->simulated = false;
    return DG_OK;
}

static int soft_reset(struct dg_biss *self, dg_ns now)
{
    (void)dg_biss_restart(self, now);
    return DG_OK;
}

static int write_command(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t value)
{
    static int (*const commands[DG_BISS_COMMAND_COUNT])(struct dg_biss *, dg_ns) = {
        [DG_BISS_NEW_POSITION] = do_nothing, [DG_BISS_STORE] = store_config,
        [DG_BISS_SOFT_RESET] = soft_reset,   [DG_BISS_CHECK] = check_eeprom,
        [DG_BISS_SIMULATE] = simulate_error, [DG_BISS_CLEAR] = clear_error,
    };

    (void)offset;
    if (value >= DG_BISS_COMMAND_COUNT || commands[value] == NULL) {
        return DG_OK;
    }
    return commands[value](self, now);
}

/* 61h..67h: ST left-aligned in 26 bits, the lowest two in front; MT. Low bytes first. */
static int read_position(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    const uint8_t st_bits = self->setup.model->singleturn_bits;
    const uint64_t st = self->position & (((uint64_t)1 << st_bits) - 1u);
    const uint64_t mt = self->position >> st_bits;
    /* 6 zeros below ST(0): a whole number of bytes. */
    const uint64_t word = mt << 32 | st << (ST_ALIGNED_BITS - st_bits + 6u);

    (void)now;
    *value = (uint8_t)(word >> (8u * offset));
    return DG_OK;
}

static int read_life(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)now;
    (void)offset;
    *value = self->life;
    return DG_OK;
}

static int read_errors(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    (void)offset;
    *value = dg_biss_errors(self, now);
    return DG_OK;
}

/* 6Ah, 6Bh: in 0.1 degC, rounded towards 0, low byte first as 61h..67h. */
static int read_temperature(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    int32_t tenths = self->setup.world->temperature_mdegc / 100;
    uint8_t bytes[2];

    (void)now;
    tenths = tenths < INT16_MIN ? INT16_MIN : tenths;
    tenths = tenths > INT16_MAX ? INT16_MAX : tenths;
    dg_store_le16(bytes, (uint16_t)tenths);
    *value = bytes[offset];
    return DG_OK;
}

/* 78h..7Fh: device id, with the model's figures in it, and the manufacturer's. */
static int read_identity(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    const struct dg_biss_model *model = self->setup.model;
    static const uint8_t masks[sizeof model->device_id] = {
        [2] = FIELD_MASK, [3] = FIELD_MASK, [TIMEOUT_OFFSET] = TIMEOUT_MASK};
    const uint8_t bits[sizeof model->device_id] = {[2] = model->multiturn_bits,
                                                   [3] = model->singleturn_bits,
                                                   [TIMEOUT_OFFSET] = self->timeout};

    (void)now;
    *value =
        (uint8_t)((model->device_id[offset] & ~masks[offset]) | (bits[offset] & masks[offset]));
    return DG_OK;
}

static int write_timeout(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t value)
{
    (void)now;
    (void)offset;
    self->timeout = value & TIMEOUT_MASK;
    return DG_OK;
}

static int read_timeout(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    return read_identity(self, now, (uint8_t)(TIMEOUT_OFFSET + offset), value);
}

static int read_revision(struct dg_biss *self, dg_ns now, uint8_t offset, uint8_t *value)
{
    return read_identity(self, now, (uint8_t)(TIMEOUT_OFFSET + 1u + offset), value);
}

enum { R = BISS_READ, RW = BISS_READ | BISS_WRITE, E = BISS_EEPROM, D = BISS_EDS };

/* clang-format off */
/* Sorted by address. From 40h on the bank does not matter.
   R: read, W: write, E: in the EEPROM, takes its time, D: EDS */
const struct biss_register dg_biss_registers[] = {
    /* banks   addresses   access   read              write            chapter */
    { 3,   3,  0x00, 0x3F, R | D,   read_common,      NULL          }, /* 5.2.1.3.1 */
    { 4,   4,  0x00, 0x3F, R | D,   read_profile,     NULL          }, /* 5.2.1.3.2 */
    { 7,  31,  0x00, 0x3F, RW | E,  read_user,        write_user    }, /* 5.2.1.3 */
    { 0,   0,  0x1B, 0x23, RW,      read_config,      write_config  }, /* 5.2.2.2, 5.2.3 */
    { 0, 255,  0x40, 0x40, RW,      read_bank,        write_bank    }, /* 5.2.1.3 */
    { 0, 255,  0x41, 0x47, R,       read_profile_id,  NULL          }, /* 5.2.1.3 */
    { 0, 255,  0x60, 0x60, RW,      read_status,      write_command }, /* 5.2.2 */
    { 0, 255,  0x61, 0x67, R,       read_position,    NULL          }, /* 5.2.2.1 */
    { 0, 255,  0x68, 0x68, R,       read_life,        NULL          }, /* 5.2.1.2 */
    { 0, 255,  0x69, 0x69, R,       read_errors,      NULL          }, /* 5.2.3 */
    { 0, 255,  0x6A, 0x6B, R,       read_temperature, NULL          }, /* 5.2.3 */
    { 0, 255,  0x78, 0x7B, R,       read_identity,    NULL          }, /* 5.2.1.3 */
    { 0, 255,  0x7C, 0x7C, RW,      read_timeout,     write_timeout }, /* 5.2.1.3 */
    { 0, 255,  0x7D, 0x7F, R,       read_revision,    NULL          }, /* 5.2.1.3 */
};
/* clang-format on */

const uint8_t dg_biss_register_count = DG_COUNT(dg_biss_registers);

/* Row of an address in a bank, or NULL: not implemented. */
static const struct biss_register *find_register(uint8_t bank, uint8_t address)
{
    for (uint8_t i = 0; i < dg_biss_register_count; i++) {
        const struct biss_register *row = &dg_biss_registers[i];
        if (address >= row->first && address <= row->last && bank >= row->bank_first &&
            bank <= row->bank_last) {
            return row;
        }
    }
    return NULL;
}

const struct biss_register *dg_biss_permitted(const struct dg_biss *self, dg_ns now,
                                              uint8_t address, bool write)
{
    const struct biss_register *row = find_register(self->bank, address);
    const uint8_t wanted = write ? BISS_WRITE : BISS_READ;

    if (row == NULL || (row->access & wanted) == 0 ||
        ((row->access & BISS_EDS) != 0 && self->setup.model->no_eds)) {
        return NULL;
    }
    if (dg_biss_initialising(self, now) && (write || address != STATUS_ADDRESS)) {
        return NULL;
    }
    return (row->access & BISS_EEPROM) != 0 && !dg_biss_eeprom(self) ? NULL : row;
}

/* SPDX-License-Identifier: MIT */
/*
 * The registers of the S36 with BiSS over the wire: the table, every register of every bank by its
 * access, the electronic data sheet as the manual prints it, offsets, status, errors, EEPROM.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_private.h"
#include "biss_rig.h"
#include "drehgeber/devices.h"

static struct biss_rig rig;

static int start_encoder(const char *model)
{
    return biss_rig_init(&rig, dg_biss_model_of(dg_device_find(model)), 1) != DG_OK ||
           biss_rig_power_on(&rig) != DG_OK;
}

static int setup(void **state)
{
    (void)state;
    return start_encoder("s3674-biss");
}

static void test_table(void **state)
{
    (void)state;
    for (uint8_t i = 0; i < dg_biss_register_count; i++) {
        const struct biss_register *row = &dg_biss_registers[i];
        assert_true(row->first <= row->last && row->last <= 0x7F);
        assert_true(row->bank_first <= row->bank_last);
        assert_true(row->last <= 0x3F || row->first >= 0x40);
        assert_int_equal((row->access & BISS_READ) != 0, row->read != NULL);
        assert_int_equal((row->access & BISS_WRITE) != 0, row->write != NULL);
        for (uint8_t j = 0; j < i; j++) {
            const struct biss_register *other = &dg_biss_registers[j];
            const bool banks =
                row->bank_first <= other->bank_last && other->bank_first <= row->bank_last;
            assert_false(banks && row->first <= other->last && other->first <= row->last);
        }
    }
    for (uint8_t i = 0; i < dg_biss_layout.region_count; i++) {
        assert_int_equal(dg_biss_layout.regions[i].check, DG_STORE_CHECKED);
        assert_int_equal(dg_store_find(&dg_biss_layout, dg_biss_layout.regions[i].name), i);
    }
}

/* 'r', 'w' for both, '.' for not implemented, by bank and address, as the specification says. */
static char access_of(uint8_t bank, uint8_t address)
{
    if (address < 0x40) {
        const bool config = bank == 0 && address >= 0x1B && address <= 0x23;
        const bool user = bank >= 7 && bank <= 31;
        return bank == 3 || bank == 4 ? 'r' : config || user ? 'w' : '.';
    }
    if (address == 0x40 || address == 0x60 || address == 0x7C) {
        return 'w';
    }
    return address <= 0x47 || (address >= 0x61 && address <= 0x6B) || address >= 0x78 ? 'r' : '.';
}

static void test_every_access(void **state)
{
    static const uint8_t banks[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 30, 31, 32, 255};

    (void)state;
    rig.model.eeprom_read = 0;
    rig.half_ns = 50;
    rig.words = true;
    for (size_t i = 0; i < DG_COUNT(banks); i++) {
        for (uint8_t address = 0; address < 0x80; address++) {
            const char access = access_of(banks[i], address);
            rig.slave[0].bank = banks[i];
            assert_int_equal(biss_rig_address(&rig, 0, address, false), access != '.' ? 2 : 3);
            assert_int_equal(biss_rig_address(&rig, 0, address, true), access == 'w' ? 1 : 0);
        }
    }
}

static void read_bank(uint8_t bank, uint8_t *bytes)
{
    assert_int_equal(biss_rig_put(&rig, 0x40, bank), 1);
    assert_int_equal(biss_rig_get(&rig, 0x40), bank);
    assert_int_equal(biss_rig_read(&rig, 0, 0, bytes, DG_BISS_BANK_SIZE), DG_BISS_BANK_SIZE);
}

static void finish(uint8_t *bank)
{
    for (unsigned i = 0; i < 0x3F; i++) {
        bank[0x3F] = (uint8_t)(bank[0x3F] + bank[i]);
    }
}

/* 5.2.1.3.1 as printed; DLEN1 is 21 + 2 + 6 bits. */
static void test_eds_common(void **state)
{
    uint8_t expected[64] = {0x01, 0x02, 0x07, 0x1F, 0x64, 0x28, 0x44, 0x28, 0x44, 0x00, 0x00, 0x00,
                            0x16, 0x00, 0x00, 0x64, 0x01, 0x01, 0x00, 0x00, 0x04, 29,   0x0A, 0x21};
    uint8_t bytes[64];

    (void)state;
    finish(expected);
    read_bank(3, bytes);
    assert_memory_equal(bytes, expected, 64);
    rig.model.life_counter = false;
    rig.data_bits -= 6;
    rig.model.busy = 39001;
    rig.model.busy_jitter = 999;
    read_bank(3, bytes);
    assert_int_equal(bytes[0x15], 23);
    assert_int_equal(bytes[0x0C], 160);
}

/* 5.2.1.3.2 as printed, for singleturn and multiturn. */
static void test_eds_profile(void **state)
{
    uint8_t expected[64] = {0x01, 0x01, 0x62, 23,   0x01, 0x02, 0x64, 0x00, 0x00, 0x01, 0x00,
                            0x00, 0x0B, 0x01, 10,   0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                            0x08, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0x00, 0x21};
    uint8_t bytes[64];

    (void)state;
    finish(expected);
    read_bank(4, bytes);
    assert_memory_equal(bytes, expected, 64);
    assert_int_equal(start_encoder("s3684-biss"), 0);
    expected[0x03] = 35;
    expected[0x0A] = 12;
    expected[0x12] = 0x10; /* 4096 turns */
    expected[0x3F] = 0;
    finish(expected);
    read_bank(4, bytes);
    assert_memory_equal(bytes, expected, 64);
    rig.model.singleturn_bits = 12;
    rig.data_bits -= 9;
    read_bank(4, bytes);
    assert_int_equal(bytes[0x0E], 1);
    assert_memory_equal(&bytes[0x18], "\x00\x00\x00\x02", 4);
}

static void test_identity(void **state)
{
    uint8_t bytes[8];

    (void)state;
    rig.model.serial = 0x01020304;
    assert_int_equal(biss_rig_read(&rig, 0, 0x41, bytes, 7), 7);
    assert_memory_equal(bytes, "\x03\x62\x17\x01\x02\x03\x04", 7);
    assert_int_equal(start_encoder("s3684-biss"), 0);
    assert_int_equal(biss_rig_read(&rig, 0, 0x78, bytes, 8), 8);
    assert_memory_equal(bytes, "\x04\x00\xCC\x15\x00\x00\x4B\x55", 8);
}

/* 7Ch: the low three bits, in RAM; a short timeout at once. */
static void test_timeout(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_put(&rig, 0x7C, 0xFF), 1);
    assert_int_equal(biss_rig_get(&rig, 0x7C), 0x07);
    (void)biss_rig_begin(&rig);
    assert_int_equal(dg_biss_step(&rig.slave[0], rig.now), rig.now + DG_BISS_TIMEOUT_S_NS);
    rig.now += 14000;
    assert_int_equal(biss_rig_put(&rig, 0x7C, 0xF8), 1);
    (void)biss_rig_begin(&rig);
    assert_int_equal(dg_biss_step(&rig.slave[0], rig.now), rig.now + DG_BISS_TIMEOUT_NS);
    rig.now += 14000;
    assert_int_equal(biss_rig_put(&rig, 0x7C, 0x01), 1);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_get(&rig, 0x7C), 0x00);
}

static uint64_t position(void)
{
    (void)biss_rig_frame(&rig, false);
    return rig.bits >> 14;
}

/* 61h..67h of MT 5A5h, ST 123456h of 21 bits, with OFFS at 0. */
static void test_position_registers(void **state)
{
    uint8_t bytes[7];

    (void)state;
    assert_int_equal(start_encoder("s3684-biss"), 0);
    rig.angle = (dg_angle)0x5A5 * DG_TURN + dg_angle_of_counts(0x123456, 1u << 21);
    assert_true(position() == ((uint64_t)0x5A5 << 21 | 0x123456));
    assert_int_equal(biss_rig_read(&rig, 0, 0x61, bytes, 7), 7);
    /* 123456h << 5 is 2468AC0h in 26 bits. */
    const uint32_t st = (uint32_t)bytes[3] << 18 | (uint32_t)bytes[2] << 10 |
                        (uint32_t)bytes[1] << 2 | bytes[0] >> 6;
    assert_int_equal(st, 0x2468AC0);
    assert_int_equal(bytes[0] & 0x3F, 0);
    assert_memory_equal(&bytes[4], "\xA5\x05\x00", 3);
}

/* OFFS is subtracted, with a borrow; DIR negates; both at once. */
static void test_offset_and_direction(void **state)
{
    const uint8_t offset[7] = {0x00, 0x00, 0x00, 0x40, 0x01, 0x00, 0x00}; /* a turn and a quarter */
    const uint64_t quarter = (uint64_t)1 << 19;
    const uint64_t range = (uint64_t)1 << 33;

    (void)state;
    assert_int_equal(start_encoder("s3684-biss"), 0);
    rig.angle = DG_TURN / 2;
    assert_true(position() == 2 * quarter);
    assert_int_equal(biss_rig_write(&rig, 0, 0x1B, offset, 7), 7);
    assert_true(position() == range - 3 * quarter);
    assert_int_equal(biss_rig_put(&rig, 0x1B, 0x04), 1);
    assert_true(position() == 3 * quarter);
    rig.angle = DG_TURN * 2;
    assert_true(position() == range - 3 * quarter);
    /* The last bit of the resolution is bit 5 of 26; what is below does nothing. */
    assert_int_equal(biss_rig_put(&rig, 0x1B, 0xC0), 1);
    assert_true(position() == 3 * quarter);
    assert_int_equal(biss_rig_put(&rig, 0x1C, 0x07), 1);
    assert_true(position() == 3 * quarter);
    assert_int_equal(biss_rig_put(&rig, 0x1C, 0x08), 1);
    assert_true(position() == 3 * quarter - 1);
    assert_int_equal(biss_rig_put(&rig, 0x1B, 0xFF), 1);
    assert_int_equal(biss_rig_get(&rig, 0x1B), 0xC7);
}

static void test_life_register(void **state)
{
    (void)state;
    (void)biss_rig_frame(&rig, false);
    assert_int_equal(biss_rig_address(&rig, 0, 0x68, false), 2);
    assert_true(biss_rig_begin(&rig)); /* S: read at the end of the frame before */
    const uint8_t life = (uint8_t)((rig.bits >> 6 & 0x3Fu) - 1u);
    biss_rig_end(&rig, false);
    uint8_t value = 0;
    for (unsigned i = 0; i < 8; i++) {
        value = (uint8_t)(value << 1 | biss_rig_frame(&rig, false));
    }
    assert_int_equal(value, life);
}

static void test_temperature(void **state)
{
    static const struct {
        int32_t mdegc;
        int16_t tenths;
    } rows[] = {
        {25000, 250},       {-12345, -123},     {0, 0}, {99, 0}, {3276700, 32767}, {3276800, 32767},
        {-3276800, -32768}, {INT32_MIN, -32768}};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        uint8_t bytes[2];
        rig.world.temperature_mdegc = rows[i].mdegc;
        assert_int_equal(biss_rig_read(&rig, 0, 0x6A, bytes, 2), 2);
        assert_int_equal((int16_t)(bytes[1] << 8 | bytes[0]), rows[i].tenths);
    }
}

static void cause(unsigned bit, bool defect)
{
    struct dg_world *world = &rig.world;
    const bool fine = !defect;

    world->led_current_ua = bit == 0 && defect ? 30001 : 30000;
    world->sin_amplitude_permille = bit == 1 && defect ? 599 : 600;
    world->temperature_mdegc = bit == 2 && defect ? 120001 : 120000;
    world->multiturn_sync_ok = bit != 3 || fine;
    world->eeprom_acknowledges = bit != 4 || fine;
    world->singleturn_ok = bit != 5 || fine;
    world->multiturn_amplitude_ok = bit != 6 || fine;
    world->watchdog_fired = bit == 7 && defect;
}

/* Each bit by its cause, alone; gone with its cause; nERR and nWARN by EMASK and WMASK. */
static void test_errors(void **state)
{
    (void)state;
    for (unsigned bit = 0; bit < 8; bit++) {
        const uint8_t only = (uint8_t)(1u << bit);
        assert_int_equal(biss_rig_put(&rig, 0x22, only), 1);
        assert_int_equal(biss_rig_put(&rig, 0x23, 0), 1);
        cause(bit, true);
        assert_int_equal(biss_rig_get(&rig, 0x69), only);
        assert_int_equal(rig.bits >> 12 & 3u, 1); /* nERR 0, nWARN 1 */
        assert_int_equal(biss_rig_get(&rig, 0x60) & 0x60, 0x40);
        assert_int_equal(biss_rig_put(&rig, 0x22, (uint8_t)~only), 1);
        assert_int_equal(biss_rig_put(&rig, 0x23, only), 1);
        (void)biss_rig_frame(&rig, false);
        assert_int_equal(rig.bits >> 12 & 3u, 2);
        assert_int_equal(biss_rig_get(&rig, 0x60) & 0x60, 0x20);
        const bool valid = bit != 3 && bit != 5 && bit != 6;
        assert_int_equal(biss_rig_get(&rig, 0x60) & 0x01, valid ? 1 : 0);
        cause(bit, false);
        assert_int_equal(biss_rig_get(&rig, 0x69), 0);
        (void)biss_rig_frame(&rig, false);
        assert_int_equal(rig.bits >> 12 & 3u, 3);
    }
}

static void test_signal_limits(void **state)
{
    struct dg_world *world = &rig.world;

    (void)state;
    for (int i = 0; i < 4; i++) {
        world->sin_amplitude_permille = i == 0 ? 1401 : 1400;
        world->cos_amplitude_permille = i == 1 ? 599 : 600;
        world->sin_offset_permille = i == 2 ? 101 : 100;
        world->cos_offset_permille = i == 3 ? -101 : -100;
        assert_int_equal(dg_biss_errors(&rig.slave[0], rig.now), DG_BISS_SIGNAL);
    }
    world->cos_offset_permille = 0;
    assert_int_equal(dg_biss_errors(&rig.slave[0], rig.now), 0);
    world->multiturn_vector_ok = false;
    assert_int_equal(dg_biss_errors(&rig.slave[0], rig.now), DG_BISS_ABSOLUTE);
}

/* As delivered the temperature is not monitored, and nothing warns. */
static void test_masks_as_delivered(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_get(&rig, 0x22), 0xFB);
    assert_int_equal(biss_rig_get(&rig, 0x23), 0x00);
    rig.world.temperature_mdegc = -40001;
    assert_int_equal(biss_rig_get(&rig, 0x69), 0);
    assert_int_equal(biss_rig_put(&rig, 0x23, 0x04), 1);
    assert_int_equal(biss_rig_get(&rig, 0x69), 0x04);
    rig.world.temperature_mdegc = -40000;
    assert_int_equal(biss_rig_get(&rig, 0x69), 0);
}

/* 60h: simulated error and its end; others do nothing. */
static void test_commands(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_get(&rig, 0x60), 0x93);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x05), 1);
    assert_int_equal(biss_rig_get(&rig, 0x69), 0);
    assert_int_equal(biss_rig_get(&rig, 0x60), 0xD3);
    assert_int_equal(rig.bits >> 12 & 3u, 1);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x00), 1);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x02), 1);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x07), 1);
    assert_false(rig.p);
    assert_int_equal(biss_rig_get(&rig, 0x60), 0xD3);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x06), 1);
    assert_int_equal(biss_rig_get(&rig, 0x60), 0x93);
}

/* Values of bank 0 are kept only after command 01; a soft reset is a start, too. */
static void test_store_and_reset(void **state)
{
    static const uint8_t values[9] = {0xC5, 0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xFF, 0x81};
    uint8_t bytes[9];

    (void)state;
    assert_int_equal(biss_rig_write(&rig, 0, 0x1B, values, 9), 9);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x03), 1);
    assert_int_equal(biss_rig_get(&rig, 0x60), DG_BISS_STATUS_ERR | DG_BISS_STATUS_WARN);
    assert_int_equal(biss_rig_get(&rig, 0x78), BISS_RIG_REFUSED);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x06), BISS_RIG_REFUSED);
    rig.now += rig.model.init;
    assert_int_equal(biss_rig_read(&rig, 0, 0x1B, bytes, 9), 9);
    assert_memory_equal(bytes, "\0\0\0\0\0\0\0\xFB\0", 9);
    assert_int_equal(biss_rig_write(&rig, 0, 0x1B, values, 9), 9);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x01), 1);
    assert_int_equal(biss_rig_get(&rig, 0x60) & DG_BISS_STATUS_BUSY, DG_BISS_STATUS_BUSY);
    assert_int_equal(biss_rig_put(&rig, 0x40, 3), 1);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_get(&rig, 0x40), 0);
    assert_int_equal(biss_rig_read(&rig, 0, 0x1B, bytes, 9), 9);
    assert_memory_equal(bytes, values, 9);
}

static void test_autostore(void **state)
{
    (void)state;
    rig.model.autostore = true;
    assert_int_equal(biss_rig_put(&rig, 0x1F, 0x77), 1);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_get(&rig, 0x1F), 0x77);
}

/* All user banks, virgin FFh, different from each other, still there after a power cycle. */
static void test_user_banks(void **state)
{
    uint8_t bytes[64];
    uint8_t virgin[64];

    (void)state;
    memset(virgin, 0xFF, sizeof virgin);
    rig.model.eeprom_write = DG_US(100);
    rig.half_ns = 50;
    for (uint8_t bank = 7; bank <= 31; bank++) {
        read_bank(bank, bytes);
        assert_memory_equal(bytes, virgin, 64);
        memset(bytes, bank, sizeof bytes);
        assert_int_equal(biss_rig_write(&rig, 0, 0, bytes, 64), 64);
        assert_false(rig.p);
    }
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    for (uint8_t bank = 7; bank <= 31; bank++) {
        read_bank(bank, bytes);
        for (unsigned i = 0; i < 64; i++) {
            assert_int_equal(bytes[i], bank);
        }
    }
}

/* A silent EEPROM: user banks are refused, what is in force stays, bit 4 says why. */
static void test_silent_eeprom(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_put(&rig, 0x40, 8), 1);
    rig.world.eeprom_acknowledges = false;
    assert_int_equal(biss_rig_get(&rig, 0x00), BISS_RIG_REFUSED);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x01), BISS_RIG_REFUSED);
    assert_true(rig.p);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x04), BISS_RIG_REFUSED);
    assert_true(rig.p);
    assert_int_equal(biss_rig_get(&rig, 0x69), DG_BISS_CONFIGURATION);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_get(&rig, 0x69), DG_BISS_CONFIGURATION);
    rig.world.eeprom_acknowledges = true;
    assert_int_equal(biss_rig_get(&rig, 0x69), DG_BISS_CONFIGURATION); /* not read at the start */
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x04), 1);
    rig.now += rig.model.eeprom_write;
    assert_int_equal(biss_rig_get(&rig, 0x69), 0);
    /* It goes silent between the address and the data. */
    assert_int_equal(biss_rig_put(&rig, 0x40, 8), 1);
    assert_int_equal(biss_rig_address(&rig, 0, 0x00, false), 2);
    rig.nvm[0].no_acknowledge = true;
    for (unsigned i = 0; i < 1000; i++) {
        assert_false(biss_rig_frame(&rig, true));
    }
    rig.nvm[0].no_acknowledge = false;
    assert_int_equal(biss_rig_address(&rig, 0, 0x00, false), 2);
    rig.world.eeprom_acknowledges = false;
    for (unsigned i = 0; i < 1000; i++) {
        assert_false(biss_rig_frame(&rig, true));
    }
}

/* A write that the EEPROM does not take is answered with P = 1. */
static void test_write_not_taken(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_put(&rig, 0x40, 31), 1);
    assert_int_equal(biss_rig_put(&rig, 0x00, 0x12), 1);
    assert_false(rig.p);
    rig.nvm[0].no_acknowledge = true;
    assert_int_equal(biss_rig_put(&rig, 0x00, 0x34), BISS_RIG_REFUSED);
    assert_true(rig.p);
    rig.nvm[0].no_acknowledge = false;
    assert_int_equal(biss_rig_get(&rig, 0x00), 0x12);
}

/* Rotten bytes: bit 4 from the next start or command 04 on, bank 0 as delivered, until stored. */
static void test_damage(void **state)
{
    (void)state;
    assert_int_equal(biss_rig_put(&rig, 0x1C, 0x11), 1);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x01), 1);
    rig.nvm[0].bytes[dg_store_address(&dg_biss_layout, DG_BISS_REGION_CONFIG) + 1u] ^= 1;
    assert_int_equal(biss_rig_get(&rig, 0x69), 0);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x04), 1);
    assert_int_equal(biss_rig_get(&rig, 0x69), DG_BISS_CONFIGURATION);
    assert_int_equal(biss_rig_get(&rig, 0x1C), 0x11);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_get(&rig, 0x1C), 0);
    assert_int_equal(biss_rig_get(&rig, 0x22), 0xFB);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x01), 1);
    assert_int_equal(biss_rig_get(&rig, 0x69), 0);
    rig.nvm[0].bytes[dg_store_address(&dg_biss_layout, DG_BISS_REGION_USER + 24)] ^= 0x80;
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_get(&rig, 0x69), DG_BISS_CONFIGURATION);
}

static void test_foreign_memory(void **state)
{
    (void)state;
    memset(rig.nvm[0].bytes, 0xFF, 64);
    memset(rig.nvm[0].synced, 0xFF, 64);
    assert_int_equal(dg_biss_power_on(&rig.slave[0], rig.now), DG_ERR_BLANK);
    assert_int_equal(rig.slave[0].line.state, DG_BISS_OFF);
    memset(rig.nvm[0].bytes, 0x5A, 64);
    assert_int_equal(dg_biss_power_on(&rig.slave[0], rig.now), DG_ERR_FOREIGN);
}

static void test_missing_pointers(void **state)
{
    const struct dg_biss_setup good = rig.slave[0].setup;
    struct dg_biss_setup bad[3] = {good, good, good};
    struct dg_biss slave;

    (void)state;
    bad[0].model = NULL;
    bad[1].world = NULL;
    bad[2].nvm.ops = NULL;
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(dg_biss_init(&slave, &bad[i]), DG_ERR_ARGUMENT);
    }
    rig.world.angle = NULL;
    assert_int_equal(dg_biss_init(&slave, &good), DG_ERR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_table, setup),
        cmocka_unit_test_setup(test_every_access, setup),
        cmocka_unit_test_setup(test_eds_common, setup),
        cmocka_unit_test_setup(test_eds_profile, setup),
        cmocka_unit_test_setup(test_identity, setup),
        cmocka_unit_test_setup(test_timeout, setup),
        cmocka_unit_test_setup(test_position_registers, setup),
        cmocka_unit_test_setup(test_offset_and_direction, setup),
        cmocka_unit_test_setup(test_life_register, setup),
        cmocka_unit_test_setup(test_temperature, setup),
        cmocka_unit_test_setup(test_errors, setup),
        cmocka_unit_test_setup(test_signal_limits, setup),
        cmocka_unit_test_setup(test_masks_as_delivered, setup),
        cmocka_unit_test_setup(test_commands, setup),
        cmocka_unit_test_setup(test_store_and_reset, setup),
        cmocka_unit_test_setup(test_autostore, setup),
        cmocka_unit_test_setup(test_user_banks, setup),
        cmocka_unit_test_setup(test_silent_eeprom, setup),
        cmocka_unit_test_setup(test_write_not_taken, setup),
        cmocka_unit_test_setup(test_damage, setup),
        cmocka_unit_test_setup(test_foreign_memory, setup),
        cmocka_unit_test_setup(test_missing_pointers, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

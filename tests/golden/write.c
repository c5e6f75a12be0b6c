/* SPDX-License-Identifier: MIT */
/*
 * Writes a memory image of each kind of device as this build stores it: through the device's wire,
 * in virtual time, with values that are not the delivered ones. Once for each release, see
 * README.md.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "co_rig.h"
#include "drehgeber/devices.h"
#include "hf_rig.h"
#include "ib_rig.h"

#define BYTES_A_LINE 30u
#define SAVE 0x65766173u
#define COUNTED 300

/* As `xxd -p` writes it. */
static void write_image(const char *folder, const char *name, const struct ram_nvm *nvm)
{
    char path[512];
    (void)snprintf(path, sizeof path, "%s/%s.hex", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (uint32_t i = 0; i < nvm->size; i++) {
        (void)fprintf(file, "%02x", nvm->bytes[i]);
        if (i % BYTES_A_LINE == BYTES_A_LINE - 1 || i + 1 == nvm->size) {
            (void)fputc('\n', file);
        }
    }
    assert_int_equal(fclose(file), 0);
}

/* --- RS485 --- */

/* clang-format off */
static const char *const hiperface_setup[] = {
    "4F 01 55 21", "4F 02 55 32", "4F 03 55 43", /* codes */
    "4D 00 D9 21",                               /* field 0: 32 bytes, code 1 */
    "4D 01 C7 55",                               /* field 1: 128 bytes, no code */
    "4D 02 F8 43",                               /* field 2: 16 bytes, code 3 */
    ("4B 00 00 20 21 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F"
                    "10 11 12 13 14 15 16 17 18 19 1A 1B 1C 1D 1E 1F"),
    "4B 02 0B 05 43 68 65 6C 6C 6F",
    "57 65 55",                                  /* 19200 Bd, bus */
    "55 52 55",                                  /* address */
    "4F 00 55 A5",
};
/* clang-format on */

/* `position`: 43h with one that the model has. */
static void write_hiperface(const char *folder, const char *name, const char *position)
{
    static struct hf_rig rig;
    static struct dg_hf_model model;
    uint8_t save[5 + 128] = {0x4B, 1, 0, 128, 0x55};
    model = *dg_hf_model_of(dg_device_find(name));
    (void)strcpy(model.serial, "987654321");
    assert_int_equal(hf_rig_init(&rig, &model), DG_OK);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    for (int i = 0; i < COUNTED; i++) {
        assert_int_equal(hf_rig_ask(&rig, "47"), 0);
    }
    for (size_t i = 0; i + 1 < DG_COUNT(hiperface_setup); i++) {
        if (i == 7) { /* field 1 is written and then protected */
            for (size_t n = 0; n < 128; n++) {
                save[5 + n] = (uint8_t)(0xFF - n);
            }
            assert_int_equal(hf_rig_ask_bytes(&rig, save, sizeof save), 0);
            assert_int_equal(hf_rig_ask(&rig, "4D 01 87 55"), 0);
        }
        assert_int_equal(hf_rig_ask(&rig, hiperface_setup[i]), 0);
    }
    assert_int_equal(hf_rig_ask(&rig, position), 0);
    assert_int_equal(hf_rig_ask(&rig, "4F 00 55 A5"), 0);
    dg_hf_power_off(&rig.device);
    write_image(folder, name, &rig.nvm);
}

/* --- BiSS --- */

static void write_biss(const char *folder, const char *name)
{
    static const uint8_t config[9] = {0x46, 0x9E, 0x15, 0x8D, 0x23, 0x01, 0x45, 0x7F, 0x84};
    static struct biss_rig rig;
    uint8_t bank[64];
    for (size_t i = 0; i < sizeof bank; i++) {
        bank[i] = (uint8_t)(3 * i + 1);
    }
    assert_int_equal(biss_rig_init(&rig, dg_biss_model_of(dg_device_find(name)), 1), DG_OK);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_int_equal(biss_rig_write(&rig, 0, 0x1B, config, sizeof config), 9);
    assert_int_equal(biss_rig_put(&rig, 0x60, 0x01), 1);
    assert_int_equal(biss_rig_put(&rig, 0x40, 7), 1);
    assert_int_equal(biss_rig_write(&rig, 0, 0x00, bank, sizeof bank), 64);
    assert_int_equal(biss_rig_put(&rig, 0x40, 12), 1);
    assert_int_equal(biss_rig_put(&rig, 0x00, 0xA0), 1);
    assert_int_equal(biss_rig_put(&rig, 0x40, 31), 1);
    assert_int_equal(biss_rig_write(&rig, 0, 0x3C, (const uint8_t *)"last", 4), 4);
    dg_biss_power_off(&rig.slave[0]);
    write_image(folder, name, &rig.nvm[0]);
}

/* --- CANopen --- */

struct write {
    uint16_t index;
    uint8_t sub, size;
    uint32_t value;
};

/* clang-format off */
static const struct write bus_parameters[] = {
    {0x2100, 0, 1, 6}, {0x2101, 0, 1, 33}, {0x2102, 0, 1, 0}, {0x2105, 0, 4, SAVE},
    {0x300A, 0, 4, 0x004B7562}, {0x300B, 0, 4, 0x11223344},
};

/* TPDO 1 has a COB-ID of its own, 2 and 4 the default one, 3 the default one and is not valid. */
static const struct write parameters[] = {
    {0x1005, 0, 4, 0x85}, {0x1006, 0, 4, 20000}, {0x1007, 0, 4, 5000},
    {0x100C, 0, 2, 200}, {0x100D, 0, 1, 3},
    {0x1012, 0, 4, 0x80000195}, {0x1015, 0, 2, 30},
    {0x1016, 1, 4, 0x00050190}, {0x1016, 2, 4, 0x000603E8}, {0x1017, 0, 2, 500},
    {0x1029, 1, 1, 2}, {0x1029, 2, 1, 2}, {0x1029, 3, 1, 0},
    {0x1800, 1, 4, 0x80000199}, {0x1800, 2, 1, 4}, {0x1800, 3, 2, 50}, {0x1800, 5, 2, 33},
    {0x1A00, 0, 1, 0}, {0x1A00, 1, 4, 0x60300110}, {0x1A00, 2, 4, 0x60040020}, {0x1A00, 0, 1, 2},
    {0x1800, 1, 4, 0x40000199},
    {0x1801, 2, 1, 7}, {0x1801, 5, 2, 250},
    {0x1802, 1, 4, 0x800003A1},
    {0x1803, 1, 4, 0x800004A1}, {0x1803, 2, 1, 254}, {0x1803, 3, 2, 90},
    {0x1A03, 0, 1, 0}, {0x1A03, 1, 4, 0x65030010}, {0x1A03, 2, 4, 0x65050010},
    {0x1A03, 3, 4, 0x21200408}, {0x1A03, 0, 1, 3}, {0x1803, 1, 4, 0x000004A1},
    {0x2120, 2, 1, 0x30}, {0x2120, 3, 1, 0x90},
    {0x2140, 1, 4, 0x01234567}, {0x2140, 2, 4, 0x89ABCDEF}, {0x2140, 3, 4, 0xDEADBEEF},
    {0x2140, 4, 4, 0x76543210},
    {0x6001, 0, 4, 3600}, {0x6002, 0, 4, 1000000}, {0x6000, 0, 2, 0x3005},
    {0x6003, 0, 4, 123456},
    {0x6031, 1, 2, 1}, {0x6031, 2, 2, 200}, {0x6031, 3, 2, 7}, {0x6031, 4, 2, 9},
    {0x6401, 1, 4, 1000}, {0x6401, 2, 4, 2000}, {0x6402, 1, 4, 500000}, {0x6402, 2, 4, 600000},
    {0x1010, 1, 4, SAVE},
};

/* Limits that have no inside, and no TPDO that is valid: as a configuration may leave them. */
static const struct write crossed[] = {
    {0x2120, 2, 1, 0x90}, {0x2120, 3, 1, 0x30},
    {0x6401, 1, 4, 5000}, {0x6402, 1, 4, 100}, {0x6401, 2, 4, 65535}, {0x6402, 2, 4, 0},
    {0x1800, 1, 4, 0x80000199}, {0x1801, 1, 4, 0x800002BF}, {0x1802, 1, 4, 0xC00003BF},
    {0x1803, 1, 4, 0x800004BF},
    {0x1010, 1, 4, SAVE},
};

/* The other two tables of the family: their ids are their own. */
static const struct write few[] = {
    {0x2140, 1, 4, 0x01234567}, {0x6000, 0, 2, 0x0004}, {0x6001, 0, 4, 360}, {0x6003, 0, 4, 99},
    {0x1010, 1, 4, SAVE},
};
/* clang-format on */

static struct co_rig can;

static void put_all(const struct write *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t abort =
            co_rig_write(&can, rows[i].index, rows[i].sub, rows[i].value, rows[i].size);
        if (abort != 0) {
            fail_msg("%04Xh:%u: %08Xh", rows[i].index, rows[i].sub, abort);
        }
        co_rig_run(&can, DG_MS(20));
    }
}

static void write_node(const char *folder, const char *name, const struct dg_cia406_model *model,
                       const struct write *rows, size_t count)
{
    co_rig_start_model(&can, model);
    put_all(rows, count);
    dg_co_power_off(&can.node);
    write_image(folder, name, &can.nvm);
}

static void write_canopen(const char *folder)
{
    static const struct dg_cia406_model wide = {.turns = 65536, .device = &dg_cia406_multiturn_32};
    const struct dg_cia406_model *single = dg_cia406_model_of(dg_device_find("f3658"));
    const struct dg_cia406_model *multi = dg_cia406_model_of(dg_device_find("f3668"));
    co_rig_start_model(&can, multi);
    co_rig_run(&can, DG_S(800)); /* two tenths of an hour */
    put_all(bus_parameters, DG_COUNT(bus_parameters));
    co_rig_nmt(&can, 0x81);
    put_all(parameters, DG_COUNT(parameters));
    dg_co_power_off(&can.node);
    write_image(folder, "f3668", &can.nvm);
    write_node(folder, "f3658", single, few, DG_COUNT(few));
    write_node(folder, "f3668-16", &wide, few, DG_COUNT(few));
    write_node(folder, "f3658-crossed", single, crossed, DG_COUNT(crossed));
    write_node(folder, "f3668-crossed", multi, crossed, DG_COUNT(crossed));
    write_node(folder, "f3668-16-crossed", &wide, crossed, DG_COUNT(crossed));
}

/* --- INTERBUS --- */

/* clang-format off */
static const uint32_t interbus_setup[] = {
    0x02000E10, 0x04000002, 0x80000000,             /* 3600 steps over 2 turns */
    0x06000004, 0x080003E8, 0x80000000, 0x40000000, /* counter-clockwise, position 1000 */
    0x80000000, 0x0A000055, 0x08000064, 0x80000000, /* zero shift; a preset yet to be activated */
    0x20800008, 0x420000C8, 0x6200012C, 0x20400002, /* cam 1 of program 8: 200..300 */
    0x80000000,
    0x20800003, 0x40000064, 0x60000BB8,             /* cam 0 of program 3: 100..3000 */
    0x4E00000A, 0x6E700000, 0x20400081,             /* cam 7: 10..7340032, both on */
    0x20100002, 0x80000000,                         /* shift_iw */
};
/* clang-format on */

static void write_interbus(const char *folder)
{
    static struct ib_rig rig;
    assert_int_equal(ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k3"))), DG_OK);
    ib_rig_turn_to(&rig, 0);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    for (size_t i = 0; i < DG_COUNT(interbus_setup); i++) {
        const uint32_t out = interbus_setup[i];
        const uint32_t in = out == 0x80000000 ? ib_rig_release(&rig) : ib_rig_send(&rig, out);
        const bool answered = out != 0x80000000 && out != 0x40000000;
        if (answered && in != (out | 0xC0000000)) {
            fail_msg("%08X: %08X", out, in);
        }
    }
    rig.now += DG_S(1900); /* three times ten minutes */
    (void)ib_rig_cycle(&rig, 0);
    dg_ib_power_off(&rig.device);
    write_image(folder, "ocd-ib-k3", &rig.nvm);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        (void)fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
        return 2;
    }
    write_hiperface(argv[1], "s3674-rs485", "43 00 00 DE F0 55");
    write_hiperface(argv[1], "s3684-rs485", "43 0A BC DE F0 55");
    write_biss(argv[1], "s3674-biss");
    write_biss(argv[1], "s3684-biss");
    write_canopen(argv[1]);
    write_interbus(argv[1]);
    return 0;
}

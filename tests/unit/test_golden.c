/* SPDX-License-Identifier: MIT */
/*
 * The memory images of earlier releases (tests/golden) on the devices of today: nothing is damaged,
 * every value is there on the wire, and every region is where it was.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "co_rig.h"
#include "drehgeber/devices.h"
#include "hf_rig.h"
#include "ib_rig.h"

#define CHECKED DG_STORE_CHECKED
#define RAW DG_STORE_RAW

/* The image `name`, into a memory that is erased behind it. @return its bytes */
static uint32_t load(const char *name, struct ram_nvm *nvm)
{
    char path[512];
    unsigned byte;
    uint32_t n = 0;
    (void)snprintf(path, sizeof path, DREHGEBER_GOLDEN "/%s.hex", name);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    memset(nvm->bytes, 0xFF, sizeof nvm->bytes);
    while (fscanf(file, "%2x", &byte) == 1) {
        assert_true(n < nvm->size);
        nvm->bytes[n++] = (uint8_t)byte;
    }
    assert_int_not_equal(feof(file), 0);
    assert_int_equal(fclose(file), 0);
    memcpy(nvm->synced, nvm->bytes, sizeof nvm->bytes);
    return n;
}

/* --- where the regions are --- */

struct place {
    const char *name;
    uint16_t size;
    uint8_t check;
    uint16_t address;
};

/* clang-format off */
static const struct place hiperface[] = {
    {"resolution",    7, CHECKED, 0x0AE}, {"calibration", 16, CHECKED, 0x0B7},
    {"offset",        4, CHECKED, 0x0C9}, {"sync",         4, CHECKED, 0x0CF},
    {"uart",          2, CHECKED, 0x0D5}, {"memory",       1, CHECKED, 0x0D9},
    {"codes",         4, CHECKED, 0x0DC}, {"fields",     113, CHECKED, 0x0E2},
    {"type",         39, CHECKED, 0x155}, {"counter",      3, CHECKED, 0x17E},
    {"label",        64, CHECKED, 0x183}, {"field-sums", 224, RAW,     0x1C5},
    {"user",       1792, RAW,     0x2A5}, {"steps",        4, CHECKED, 0x9A5},
    {"implemented",   1, CHECKED, 0x9AB},
};
/* The last two are later ones. */
#define HIPERFACE_0_1 (DG_COUNT(hiperface) - 2u)

static const struct place biss[] = {
    {"config", 9,  CHECKED, 0x066},
    {"user7",  64, CHECKED, 0x071}, {"user8",  64, CHECKED, 0x0B3}, {"user9",  64, CHECKED, 0x0F5},
    {"user10", 64, CHECKED, 0x137}, {"user11", 64, CHECKED, 0x179}, {"user12", 64, CHECKED, 0x1BB},
    {"user13", 64, CHECKED, 0x1FD}, {"user14", 64, CHECKED, 0x23F}, {"user15", 64, CHECKED, 0x281},
    {"user16", 64, CHECKED, 0x2C3}, {"user17", 64, CHECKED, 0x305}, {"user18", 64, CHECKED, 0x347},
    {"user19", 64, CHECKED, 0x389}, {"user20", 64, CHECKED, 0x3CB}, {"user21", 64, CHECKED, 0x40D},
    {"user22", 64, CHECKED, 0x44F}, {"user23", 64, CHECKED, 0x491}, {"user24", 64, CHECKED, 0x4D3},
    {"user25", 64, CHECKED, 0x515}, {"user26", 64, CHECKED, 0x557}, {"user27", 64, CHECKED, 0x599},
    {"user28", 64, CHECKED, 0x5DB}, {"user29", 64, CHECKED, 0x61D}, {"user30", 64, CHECKED, 0x65F},
    {"user31", 64, CHECKED, 0x6A1},
};

static const struct place canopen[] = {
    {"bus",           3,  CHECKED, 0x156}, {"saved",   1,  CHECKED, 0x15B},
    {"communication", 35, CHECKED, 0x15E}, {"tpdo1",   43, CHECKED, 0x183},
    {"tpdo2",         43, CHECKED, 0x1B0}, {"tpdo3",   43, CHECKED, 0x1DD},
    {"tpdo4",         43, CHECKED, 0x20A}, {"serial",  4,  CHECKED, 0x237},
    {"profile",       60, CHECKED, 0x23D}, {"usf",     21, CHECKED, 0x27B},
    {"time",          4,  CHECKED, 0x292},
};

static const struct place interbus[] = {
    {"steps",     4,  CHECKED, 0x2AA}, {"revolutions", 4, CHECKED, 0x2B0},
    {"direction", 1,  CHECKED, 0x2B6}, {"preset",      9, CHECKED, 0x2B9},
    {"shift",     4,  CHECKED, 0x2C4}, {"mode",        1, CHECKED, 0x2CA},
    {"shift-iw",  1,  CHECKED, 0x2CD},
    {"cams-1",    67, CHECKED, 0x2D0}, {"cams-2", 67, CHECKED, 0x315},
    {"cams-3",    67, CHECKED, 0x35A}, {"cams-4", 67, CHECKED, 0x39F},
    {"cams-5",    67, CHECKED, 0x3E4}, {"cams-6", 67, CHECKED, 0x429},
    {"cams-7",    67, CHECKED, 0x46E}, {"cams-8", 67, CHECKED, 0x4B3},
    {"time",      4,  CHECKED, 0x4F8},
};

static const struct golden {
    const char *image;
    const char *model;
    const struct place *places;
    size_t count;
    uint32_t size;
} golden[] = {
    {"0.1.0/s3684-rs485",      "s3684-rs485", hiperface, HIPERFACE_0_1,   2469},
    {"0.1.0/s3684-biss",       "s3684-biss",  biss,      DG_COUNT(biss),      1763},
    {"0.1.0/f3658",            "f3658",       canopen,   DG_COUNT(canopen),   664},
    {"0.1.0/f3668",            "f3668",       canopen,   DG_COUNT(canopen),   664},
    {"0.1.0/f3668-16",         NULL,          canopen,   DG_COUNT(canopen),   664},
    {"0.1.0/ocd-ib-k3",        "ocd-ib-k3",   interbus,  DG_COUNT(interbus),  1278},
    {"0.3.0/s3674-rs485",      "s3674-rs485", hiperface, DG_COUNT(hiperface), 2478},
    {"0.3.0/s3684-rs485",      "s3684-rs485", hiperface, DG_COUNT(hiperface), 2478},
    {"0.3.0/s3674-biss",       "s3674-biss",  biss,      DG_COUNT(biss),      1763},
    {"0.3.0/s3684-biss",       "s3684-biss",  biss,      DG_COUNT(biss),      1763},
    {"0.3.0/f3658",            "f3658",       canopen,   DG_COUNT(canopen),   664},
    {"0.3.0/f3658-crossed",    "f3658",       canopen,   DG_COUNT(canopen),   664},
    {"0.3.0/f3668",            "f3668",       canopen,   DG_COUNT(canopen),   664},
    {"0.3.0/f3668-crossed",    "f3668",       canopen,   DG_COUNT(canopen),   664},
    {"0.3.0/f3668-16",         NULL,          canopen,   DG_COUNT(canopen),   664},
    {"0.3.0/f3668-16-crossed", NULL,          canopen,   DG_COUNT(canopen),   664},
    {"0.3.0/ocd-ib-k3",        "ocd-ib-k3",   interbus,  DG_COUNT(interbus),  1278},
};
/* clang-format on */

/* Of NULL: an f3668 with 65536 turns, which nobody delivers. */
static const struct dg_cia406_model wide = {.turns = 65536, .device = &dg_cia406_multiturn_32};

static const struct dg_store_layout *layout_of(const struct golden *self)
{
    const struct dg_device *device = self->model == NULL ? NULL : dg_device_find(self->model);
    return device == NULL ? wide.device->layout : device->stack->layout(device->model);
}

static void regions_are_where_they_were(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(golden); i++) {
        const struct dg_store_layout *layout = layout_of(&golden[i]);
        assert_true(layout->region_count >= golden[i].count);
        for (uint8_t region = 0; region < golden[i].count; region++) {
            const struct place *place = &golden[i].places[region];
            const struct dg_store_region *now = &layout->regions[region];
            if (strcmp(now->name, place->name) != 0 || now->size != place->size ||
                now->check != place->check || dg_store_address(layout, region) != place->address) {
                fail_msg("%s: region %s is not what it was", golden[i].image, place->name);
            }
        }
    }
}

static void images_are_mounted_without_damage(void **state)
{
    static struct ram_nvm nvm;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(golden); i++) {
        const struct dg_store_layout *layout = layout_of(&golden[i]);
        struct dg_store store;
        ram_nvm_init(&nvm, dg_store_size(layout));
        assert_int_equal(load(golden[i].image, &nvm), golden[i].size);
        const int result = dg_store_mount(&store, layout, ram_nvm_port(&nvm));
        const bool grown = layout->region_count > golden[i].count;
        assert_int_equal(result, grown ? DG_ERR_OLDER : DG_OK);
        assert_int_equal(store.region_count, golden[i].count);
        assert_int_equal(store.damaged, 0);
        assert_int_equal(store.repairs + store.replays, 0);
    }
}

/* --- RS485 --- */

static struct hf_rig drive;

/* The reply's data, after a command that succeeds. */
static void replies(const char *command, const char *data)
{
    uint8_t bytes[160];
    assert_int_equal(hf_rig_ask(&drive, command), 0);
    const size_t n = hf_rig_hex(data, bytes, sizeof bytes);
    assert_int_equal(drive.reply_length, n + 3);
    assert_memory_equal(drive.reply + 2, bytes, n);
}

/* An image with the values of all of them, and what differs from model to model. */
static const struct drive {
    const char *image, *model, *position, *type, *turns, *designation;
} drives[] = {
    {"0.1.0/s3684-rs485", "s3684-rs485", "0A BC DE F0", "65 27 70 00", "10 00", "53 33 36 38 34"},
    {"0.3.0/s3684-rs485", "s3684-rs485", "0A BC DE F0", "65 27 70 00", "10 00", "53 33 36 38 34"},
    {"0.3.0/s3674-rs485", "s3674-rs485", "00 00 DE F0", "65 22 70 00", "00 01", "53 33 36 37 34"},
};

static void start_hiperface(const struct drive *self)
{
    assert_int_equal(hf_rig_init(&drive, dg_hf_model_of(dg_device_find(self->model))), DG_OK);
    (void)load(self->image, &drive.nvm);
    assert_int_equal(hf_rig_power_on(&drive), DG_OK);
}

static void check_drive(const struct drive *self)
{
    char text[100];
    start_hiperface(self);
    replies("50", "00");
    assert_int_equal(drive.reply[0], 0x52);
    replies("42", self->position);
    replies("46", "00 01 2C");
    replies("52", self->type);
    assert_int_equal(dg_hf_uart(&drive.device).baud, 19200);
    /* "987654321", "v1.0.8", "12072019" */
    replies("56", "39 38 37 36 35 34 33 32 31"
                  "76 31 2E 30 2E 38 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
                  "31 32 30 37 32 30 31 39");
    assert_int_equal(hf_rig_ask(&drive, "4A FF 00 40 55"), 0);
    assert_int_equal(hf_rig_xor(drive.reply + 5, 64), 0);
    (void)snprintf(text, sizeof text, "FF 01 09 00 00 00 08 00 00 00 %s", self->turns);
    replies("4A FF 01 09 55", text);
    (void)snprintf(text, sizeof text, "FF 0A 12 %s %s", self->designation, /* RS485+SinCos */
                   "20 52 53 34 38 35 2B 53 69 6E 43 6F 73");
    replies("4A FF 0A 12 55", text);
    replies("4F 00 A5 A5", "00");
    assert_int_equal(hf_rig_ask(&drive, "4F 00 55 55"), 0x0F);
    replies("4F 01 21 21", "01");
    replies("4F 02 32 32", "02");
    replies("4F 03 43 43", "03");
    replies("50", "00");
}

static void rs485_has_its_position_setting_and_identity(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(drives); i++) {
        check_drive(&drives[i]);
    }
}

static void check_fields(const struct drive *self)
{
    uint8_t field[128];
    start_hiperface(self);
    replies("4E", "65 03");
    replies("4C 00", "00 D9");
    replies("4C 01", "01 87");
    replies("4C 02", "02 F8");
    assert_int_equal(hf_rig_ask(&drive, "4C 03"), 0x12);
    replies("4A 00 00 20 21", "00 00 20"
                              "00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F"
                              "10 11 12 13 14 15 16 17 18 19 1A 1B 1C 1D 1E 1F");
    assert_int_equal(hf_rig_ask(&drive, "4A 00 00 20 55"), 0x0F);
    assert_int_equal(hf_rig_ask(&drive, "4A 01 00 80 00"), 0);
    for (size_t i = 0; i < sizeof field; i++) {
        field[i] = (uint8_t)(0xFF - i);
    }
    assert_int_equal(drive.reply_length, 3 + 3 + sizeof field);
    assert_memory_equal(drive.reply + 5, field, sizeof field);
    assert_int_equal(hf_rig_ask(&drive, "4B 01 00 01 55 00"), 0x0E);
    replies("4A 02 0B 05 43", "02 0B 05 68 65 6C 6C 6F");
    assert_int_equal(hf_rig_ask(&drive, "4A 02 0B 05 A5"), 0x0F);
}

static void rs485_has_its_data_fields(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(drives); i++) {
        check_fields(&drives[i]);
    }
}

/* --- BiSS --- */

static struct biss_rig servo;

/* `position`: MT 123h, ST 11A2B3h, or without MT: an offset at angle 0, the other way round; see
   61h-67h */
static void check_servo(const char *image, const char *model, const uint8_t position[7])
{
    static const uint8_t config[9] = {0x46, 0x9E, 0x15, 0x8D, 0x23, 0x01, 0x45, 0x7F, 0x84};
    uint8_t found[64];
    assert_int_equal(biss_rig_init(&servo, dg_biss_model_of(dg_device_find(model)), 1), DG_OK);
    (void)load(image, &servo.nvm[0]);
    assert_int_equal(biss_rig_power_on(&servo), DG_OK);
    assert_int_equal(biss_rig_read(&servo, 0, 0x1B, found, 9), 9);
    assert_memory_equal(found, config, 9);
    assert_int_equal(biss_rig_read(&servo, 0, 0x61, found, 7), 7);
    assert_memory_equal(found, position, 7);
    assert_int_equal(biss_rig_get(&servo, 0x69), 0);
    for (int bank = 7; bank <= 31; bank++) {
        assert_int_equal(biss_rig_put(&servo, 0x40, (uint8_t)bank), 1);
        assert_int_equal(biss_rig_read(&servo, 0, 0x00, found, 64), 64);
        for (int i = 0; i < 64; i++) {
            const int last = bank == 31 && i >= 60 ? "last"[i - 60] : 0xFF;
            const int first = bank == 12 && i == 0 ? 0xA0 : last;
            assert_int_equal(found[i], bank == 7 ? (3 * i + 1) & 0xFF : first);
        }
    }
}

static void biss_has_its_registers_and_banks(void **state)
{
    static const uint8_t multi[7] = {0x00, 0x98, 0x15, 0x8D, 0x23, 0x01, 0x00};
    static const uint8_t single[7] = {0x00, 0x98, 0x15, 0x8D, 0x00, 0x00, 0x00};
    (void)state;
    check_servo("0.1.0/s3684-biss", "s3684-biss", multi);
    check_servo("0.3.0/s3684-biss", "s3684-biss", multi);
    check_servo("0.3.0/s3674-biss", "s3674-biss", single);
}

/* --- CANopen --- */

static struct co_rig can;

struct value {
    uint16_t index;
    uint8_t sub;
    uint32_t value;
};

/* clang-format off */
static const struct value values[] = {
    {0x1001, 0, 0}, {0x1018, 4, 0x11223344},
    {0x2100, 0, 6}, {0x2101, 0, 33}, {0x2102, 0, 0},
    {0x1005, 0, 0x85}, {0x1006, 0, 20000}, {0x1007, 0, 5000}, {0x100C, 0, 200}, {0x100D, 0, 3},
    {0x1012, 0, 0x80000195}, {0x1014, 0, 0xA1}, {0x1015, 0, 30},
    {0x1016, 1, 0x00050190}, {0x1016, 2, 0x000603E8}, {0x1017, 0, 500},
    {0x1029, 1, 2}, {0x1029, 2, 2}, {0x1029, 3, 0},
    {0x1800, 1, 0x40000199}, {0x1800, 2, 4},   {0x1800, 3, 50}, {0x1800, 5, 33},
    {0x1801, 1, 0x000002A1}, {0x1801, 2, 7},   {0x1801, 3, 0},  {0x1801, 5, 250},
    {0x1802, 1, 0x800003A1}, {0x1802, 2, 255}, {0x1802, 3, 0},  {0x1802, 5, 0},
    {0x1803, 1, 0x000004A1}, {0x1803, 2, 254}, {0x1803, 3, 90}, {0x1803, 5, 0},
    {0x1A00, 0, 2}, {0x1A00, 1, 0x60300110}, {0x1A00, 2, 0x60040020},
    {0x1A01, 0, 1}, {0x1A01, 1, 0x60040020},
    {0x1A02, 0, 1}, {0x1A02, 1, 0x60300110},
    {0x1A03, 0, 3}, {0x1A03, 1, 0x65030010}, {0x1A03, 2, 0x65050010}, {0x1A03, 3, 0x21200408},
    {0x2120, 2, 0x30}, {0x2120, 3, 0x90},
    {0x2140, 1, 0x01234567}, {0x2140, 2, 0x89ABCDEF}, {0x2140, 3, 0xDEADBEEF},
    {0x2140, 4, 0x76543210},
    {0x6000, 0, 0x3005}, {0x6001, 0, 3600}, {0x6002, 0, 1000000}, {0x6003, 0, 123456},
    {0x6031, 1, 1}, {0x6031, 2, 200}, {0x6031, 3, 7}, {0x6031, 4, 9},
    {0x6401, 1, 1000}, {0x6401, 2, 2000}, {0x6402, 1, 500000}, {0x6402, 2, 600000},
    {0x6508, 0, 2}, {0x650B, 0, 0x11223344},
};

/* Of the other two models: an eighth of a turn on from where 99 was preset. */
static const struct value few[] = {
    {0x1001, 0, 0}, {0x1018, 4, 1234567890}, {0x2101, 0, 63},
    {0x2140, 1, 0x01234567}, {0x6000, 0, 4}, {0x6001, 0, 360}, {0x6004, 0, 99 + 45},
};
/* 6400h:1 is what CiA 406 has for outside, above the high and below the low limit, of both areas
   (C42). */
static const struct value crossed[] = {
    {0x2120, 2, 0x90}, {0x2120, 3, 0x30},
    {0x6401, 1, 5000}, {0x6402, 1, 100}, {0x6401, 2, 65535}, {0x6402, 2, 0},
    {0x1800, 1, 0x80000199}, {0x1801, 1, 0x800002BF}, {0x1802, 1, 0xC00003BF},
    {0x1803, 1, 0x800004BF},
    {0x6004, 0, 4096}, {0x6400, 1, 0x3F},
};
/* clang-format on */

static void start_canopen(const struct dg_cia406_model *model, const char *image, dg_angle angle)
{
    co_rig_start_model(&can, model);
    (void)load(image, &can.nvm);
    can.motion.from = angle;
    assert_int_equal(co_rig_power_on(&can), DG_OK);
}

static void read_all(const struct value *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t found = co_rig_get(&can, rows[i].index, rows[i].sub);
        const uint32_t known = rows[i].value;
        if (found != known) {
            fail_msg("%04Xh:%u is %Xh, not %Xh", rows[i].index, rows[i].sub, found, known);
        }
    }
}

static void canopen_has_its_parameters(void **state)
{
    static const char *const images[] = {"0.1.0/f3668", "0.3.0/f3668"};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(images); i++) {
        /* 10.5 turns clockwise while it was off: the zero of USF stays where it was */
        start_canopen(dg_cia406_model_of(dg_device_find("f3668")), images[i], 21 * (DG_TURN / 2));
        assert_int_equal(can.node.id, 33);
        assert_int_equal(can.kbaud, 500);
        co_rig_expect(&can, 0, 0x721, "00");
        read_all(values, DG_COUNT(values));
        assert_int_equal(co_rig_get(&can, 0x6004, 0), 123456 - 37800);
        assert_int_equal(can.node.store.damaged, 0);
    }
}

static void canopen_has_them_in_every_model(void **state)
{
    const struct dg_cia406_model *single = dg_cia406_model_of(dg_device_find("f3658"));
    (void)state;
    start_canopen(single, "0.1.0/f3658", DG_TURN / 8);
    read_all(few, DG_COUNT(few));
    start_canopen(single, "0.3.0/f3658", DG_TURN / 8);
    read_all(few, DG_COUNT(few));
    start_canopen(&wide, "0.1.0/f3668-16", DG_TURN / 8);
    read_all(few, DG_COUNT(few));
    start_canopen(&wide, "0.3.0/f3668-16", DG_TURN / 8);
    read_all(few, DG_COUNT(few));
}

/* At 4096 of 65536 steps: above 100 and below 5000, above 0 and below 65535. No TPDO is valid. */
static void check_crossed(const struct dg_cia406_model *model, const char *image)
{
    start_canopen(model, image, DG_TURN / 16);
    read_all(crossed, DG_COUNT(crossed));
    assert_int_equal(can.node.store.damaged, 0);
    co_rig_forget(&can);
    co_rig_rx(&can, 0x000, "01 00");
    co_rig_rx(&can, 0x080, "");
    co_rig_run(&can, DG_S(1));
    co_rig_expect_count(&can, 0);
    /* One that is made valid again is sent at the next start. */
    co_rig_put(&can, 0x1800, 1, 0x199, 4);
    co_rig_nmt(&can, 0x80);
    co_rig_forget(&can);
    co_rig_rx(&can, 0x000, "01 00");
    co_rig_expect(&can, 0, 0x199, "00 10 00 00"); /* 4096 */
    co_rig_expect_count(&can, 1);
}

static void crossed_limits_and_invalid_pdos_stay(void **state)
{
    (void)state;
    check_crossed(dg_cia406_model_of(dg_device_find("f3658")), "0.3.0/f3658-crossed");
    check_crossed(dg_cia406_model_of(dg_device_find("f3668")), "0.3.0/f3668-crossed");
    check_crossed(&wide, "0.3.0/f3668-16-crossed");
}

/* --- INTERBUS --- */

static struct ib_rig plc;

struct exchange {
    uint32_t out, in;
};

/* clang-format off */
static const struct exchange exchanges[] = {
    {0x20210001, 0xA0000E10}, {0x20210002, 0xA0000002}, /* steps, revolutions */
    {0x20210003, 0xA0000004}, {0x20210004, 0xA0000064}, /* direction, preset */
    {0x20210005, 0xA0000055}, {0x20210006, 0xA0000001}, /* zero shift, preset flag */
    {0x20210008, 0xA0000003}, {0x20210009, 0xA0000005}, /* 30 min; cam program 3 */
    {0x20200030, 0xA0000002}, {0x20200000, 0xA0000081}, /* shift_iw, mask */
    {0x20200010, 0xA0000064}, {0x20200020, 0xA0000BB8}, /* cam 0 */
    {0x20200017, 0xA000000A}, {0x20200027, 0xA0700000}, /* cam 7 */
    {0x20200011, 0xA0000000}, {0x20200021, 0xA0000000}, /* cam 1 */
    {0x20800008, 0xE0800008}, {0x20200000, 0xA0000002}, /* program 8 */
    {0x20200011, 0xA00000C8}, {0x20200021, 0xA000012C},
    {0x20800001, 0xE0800001}, {0x20200000, 0xA0000000}, /* one that nobody wrote */
    {0x20800000, 0xE0800000},                           /* position mode */
};
/* clang-format on */

static void check_plc(const char *image)
{
    assert_int_equal(ib_rig_init(&plc, dg_ib_model_of(dg_device_find("ocd-ib-k3"))), DG_OK);
    (void)load(image, &plc.nvm);
    ib_rig_turn_to(&plc, 0);
    assert_int_equal(ib_rig_power_on(&plc), DG_OK);
    /* position 1000 + 55h; both cams are on */
    assert_int_equal(ib_rig_cycle(&plc, 0), (1085u >> 2) << 8 | 0x81);
    ib_rig_turn_to(&plc, 4096); /* a turn clockwise is 1800 steps less, past zero */
    assert_int_equal(ib_rig_cycle(&plc, 0), (7372085u >> 2 & 0x1FFFF) << 8);
    for (size_t i = 0; i < DG_COUNT(exchanges); i++) {
        const uint32_t in = ib_rig_send(&plc, exchanges[i].out);
        if (in != exchanges[i].in) {
            fail_msg("%08Xh: %08Xh, not %08Xh", exchanges[i].out, in, exchanges[i].in);
        }
    }
    assert_int_equal(ib_rig_release(&plc), 7372085);
    assert_int_equal(plc.device.lost, 0);
    (void)ib_rig_cycle(&plc, 0x40000000);
    assert_int_equal(ib_rig_cycle(&plc, 0), 100);
}

static void interbus_has_its_parameters_and_cams(void **state)
{
    (void)state;
    check_plc("0.1.0/ocd-ib-k3");
    check_plc("0.3.0/ocd-ib-k3");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regions_are_where_they_were),
        cmocka_unit_test(images_are_mounted_without_damage),
        cmocka_unit_test(rs485_has_its_position_setting_and_identity),
        cmocka_unit_test(rs485_has_its_data_fields),
        cmocka_unit_test(biss_has_its_registers_and_banks),
        cmocka_unit_test(canopen_has_its_parameters),
        cmocka_unit_test(canopen_has_them_in_every_model),
        cmocka_unit_test(crossed_limits_and_invalid_pdos_stay),
        cmocka_unit_test(interbus_has_its_parameters_and_cams),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The models as they are delivered: nothing is set, and every figure is read where a user meets it.
 * Figures from the manuals: R67057.0002 chapters 3.1, 5.1 and 5.2; F36x8 chapters 8, 10, 19 and 26;
 * UMD OCD IB 11/03 chapters 2 and 5; what is chosen stands in the device pages.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "co_rig.h"
#include "drehgeber/devices.h"
#include "hf_rig.h"
#include "host_rig.h"
#include "ib_rig.h"

static void models_are_listed_in_order(void **state)
{
    (void)state;
    assert_int_equal(dg_device_count, host_rig_model_count);
    for (size_t i = 0; i < host_rig_model_count; i++) {
        const struct host_rig_model *row = &host_rig_models[i];
        const struct dg_device *device = dg_devices[i];
        assert_string_equal(device->name, row->name);
        assert_string_equal(device->resolution, row->resolution);
        assert_int_equal(device->stack->senses_multiturn(device->model), row->senses_multiturn);
        assert_int_equal(device->stack->layout(device->model) != NULL, row->has_memory);
        assert_int_equal(device->more, 0); /* only one of a file has something behind it */
        assert_ptr_equal(dg_device_find(row->name), device);
    }
    assert_null(dg_device_find("s3674"));
}

/* Faults and NVM: commands name them. */
static void regions_of_a_memory_have_names_of_their_own(void **state)
{
    (void)state;
    for (size_t i = 0; i < dg_device_count; i++) {
        const struct dg_store_layout *layout = dg_devices[i]->stack->layout(dg_devices[i]->model);
        for (uint8_t k = 0; layout != NULL && k < layout->region_count; k++) {
            assert_true(layout->regions[k].name[0] != '\0');
            for (uint8_t other = 0; other < k; other++) {
                assert_string_not_equal(layout->regions[k].name, layout->regions[other].name);
            }
        }
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

/* What both have: the parameters in the label from 1Ch on (5.1.1.2.2), the identity. */
static void check_s36(void)
{
    replies("4A FF 1C 18 55",
            "FF 1C 18" /* selector, channel and limits of the temperature in degC, */
            "07 FF 00 48 FF D8 00 78"
            "00 49 00 01 00 1E" /* of the LED current in mA, */
            "00 4A 02 58 05 78" /* of the vector length in permille, */
            "2E E0 01 F4");     /* 12000 min-1, 5x10^5 rad/s2 */
    replies("4A FF 34 0C 55", "FF 34 0C 00 00 00 00 00 00 00 00 00 00 00 00");
    replies("4E", "70 00");
    replies("56", "31 32 33 34 35 36 37 38 39" /* 123456789, v1.0.8, 12072019 */
                  "76 31 2E 30 2E 38 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
                  "31 32 30 37 32 30 31 39");
    assert_int_equal(hf_rig_ask(&drive, "4A FF 00 40 55"), 0);
    assert_int_equal(hf_rig_xor(drive.reply + 5, 64), 0);
}

static void start_hiperface(const char *name)
{
    assert_int_equal(hf_rig_init(&drive, dg_hf_model_of(dg_device_find(name))), DG_OK);
    assert_int_equal(hf_rig_power_on(&drive), DG_OK);
    drive.angle = -1; /* the last step there is */
}

static void s3674_rs485(void **state)
{
    (void)state;
    start_hiperface("s3674-rs485");
    replies("42", "00 00 FF FF");
    replies("52", "E4 22 70 00");
    replies("4A FF 01 09 55", "FF 01 09 00 00 00 08 00 00 00 00 01");
    replies("4A FF 0A 12 55", "FF 0A 12 53 33 36 37 34 20 52 53 34 38 35 2B 53 69 6E 43 6F 73");
    check_s36();
}

static void s3684_rs485(void **state)
{
    (void)state;
    start_hiperface("s3684-rs485");
    replies("42", "0F FF FF FF");
    replies("52", "E4 27 70 00");
    replies("4A FF 01 09 55", "FF 01 09 00 00 00 08 00 00 00 10 00");
    replies("4A FF 0A 12 55", "FF 0A 12 53 33 36 38 34 20 52 53 34 38 35 2B 53 69 6E 43 6F 73");
    check_s36();
}

/* A reply begins 1 ms behind the timeout of 44 bit times at 9600 Bd; 53h takes 100 ms. */
static void rs485_answers_after_1_ms_and_starts_in_100_ms(void **state)
{
    const dg_ns timeout = UINT64_C(44) * 1000000000 / 9600;
    const dg_ns character = UINT64_C(11) * 1000000000 / 9600;
    static const char *const names[] = {"s3674-rs485", "s3684-rs485"};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        start_hiperface(names[i]);
        dg_ns before = drive.now;
        assert_int_equal(hf_rig_ask(&drive, "42"), 0);
        dg_ns wanted = before + 3 * character + timeout + DG_MS(1);
        assert_in_range(drive.reply_at, wanted - 10, wanted + 10);
        before = drive.now;
        assert_int_equal(hf_rig_ask(&drive, "53"), HF_RIG_SILENCE);
        wanted = before + 3 * character + timeout + DG_MS(100);
        assert_in_range(drive.now, wanted - 10, wanted + 10);
    }
}

/* --- BiSS --- */

static struct biss_rig servo;

/* A frame that is latched a period after it begins, and one whose CDM bit counts 64.5 us after it
 * began: a clock of 1 MHz, no processing time, 47 bits. */
#define LATCH_NS 1000u
#define CDM_NS 64500u
#define FRAME_NS 66000u

static void start_biss(const char *name)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find(name));
    model.busy = 0;
    assert_int_equal(biss_rig_init(&servo, &model, 1), DG_OK);
    servo.words = true;
    servo.angle = -1;
}

/* Position, nERR and nWARN of the next frame, latched at `at`. */
static uint64_t frame_at(dg_ns at)
{
    servo.now = at - LATCH_NS;
    (void)biss_rig_frame(&servo, false);
    return servo.bits >> 12;
}

/* Ready 100 ms after power-on, and not a nanosecond before. */
static void biss_is_ready_after_100_ms(const char *name, uint64_t last_position)
{
    start_biss(name);
    assert_int_equal(dg_biss_power_on(&servo.slave[0], 0), DG_OK);
    assert_int_equal(frame_at(DG_MS(99)), 0);
    assert_int_equal(frame_at(DG_MS(100) - 1), 0);
    start_biss(name);
    assert_int_equal(dg_biss_power_on(&servo.slave[0], 0), DG_OK);
    assert_int_equal(frame_at(DG_MS(100)), last_position << 2 | 3);
    for (unsigned count = 0; count < 3; count++) { /* with a life counter */
        assert_int_equal(servo.bits >> 6 & 0x3F, count);
        (void)biss_rig_frame(&servo, false);
    }
}

static void biss_says(const char *registers_78h)
{
    uint8_t found[8];
    uint8_t wanted[8];
    assert_int_equal(hf_rig_hex(registers_78h, wanted, sizeof wanted), 8);
    assert_int_equal(biss_rig_read(&servo, 0, 0x78, found, 8), 8);
    assert_memory_equal(found, wanted, 8);
    assert_int_equal(biss_rig_read(&servo, 0, 0x44, found, 4), 4);
    assert_memory_equal(found, "\x07\x5B\xCD\x15", 4); /* 123456789 */
}

static void s3674_biss(void **state)
{
    (void)state;
    biss_is_ready_after_100_ms("s3674-biss", 0x1FFFFF);
    biss_says("04 00 C0 15 00 00 4B 55");
}

static void s3684_biss(void **state)
{
    (void)state;
    biss_is_ready_after_100_ms("s3684-biss", 0x1FFFFFFFF);
    biss_says("04 00 CC 15 00 00 4B 55");
}

/* S was asked for, and the register is ready at `at`: not a nanosecond before. */
static void assert_ready_at(dg_ns at)
{
    const struct biss_rig start = servo;
    for (dg_ns early = 0; early <= 1; early++) {
        servo = start;
        servo.now = at - early - CDM_NS;
        assert_true(servo.now >= start.now);
        (void)biss_rig_frame(&servo, true);
        assert_int_equal(biss_rig_frame(&servo, false), early == 0);
    }
}

/* A byte of a user bank takes 100 us, and 5 ms more while the memory is writing. */
static void biss_memory_takes_its_time(void **state)
{
    (void)state;
    start_biss("s3684-biss");
    assert_int_equal(biss_rig_power_on(&servo), DG_OK);
    assert_int_equal(biss_rig_put(&servo, 0x40, 7), 1);
    const struct biss_rig start = servo;
    assert_int_equal(biss_rig_address(&servo, 0, 0x05, false), 2);
    assert_ready_at(servo.now - FRAME_NS + CDM_NS + DG_US(100));

    servo = start;
    assert_int_equal(biss_rig_put(&servo, 0x05, 0x12), 1);
    /* written at the end of the frame before the last one; neither has a CDM bit */
    const dg_ns written = servo.now - 2 * (FRAME_NS - 1000) + (CDM_NS - 500);
    assert_int_equal(biss_rig_address(&servo, 0, 0x05, false), 2);
    assert_ready_at(written + DG_MS(5) + DG_US(100));
}

/* --- CANopen --- */

static struct co_rig can;

static void check_canopen(const char *name, uint32_t last_position, uint32_t turns)
{
    static const dg_angle last = -1;
    co_rig_start_model(&can, dg_cia406_model_of(dg_device_find(name)));
    assert_int_equal(can.node.id, 0x3F);
    assert_int_equal(can.kbaud, 250);
    can.motion.from = last;
    assert_int_equal(co_rig_get(&can, 0x6004, 0), last_position);
    assert_int_equal(co_rig_get(&can, 0x6501, 0), 65536);
    assert_int_equal(co_rig_get(&can, 0x6502, 0), turns);
    /* The serial number is behind the password 004B7562h, and behind no other. */
    assert_int_not_equal(co_rig_write(&can, 0x300B, 0, 77, 4), 0);
    for (uint32_t wrong = 0x004B7561; wrong <= 0x004B7563; wrong += 2) {
        assert_int_not_equal(co_rig_write(&can, 0x300A, 0, wrong, 4), 0);
        assert_int_not_equal(co_rig_write(&can, 0x300B, 0, 77, 4), 0);
        co_rig_run(&can, DG_S(60)); /* a wrong one has to wait */
    }
    co_rig_put(&can, 0x300A, 0, 0x004B7562, 4);
    co_rig_put(&can, 0x300B, 0, 77, 4);
    assert_int_equal(co_rig_get(&can, 0x1018, 4), 77);
}

static void f3658_and_f3668(void **state)
{
    (void)state;
    check_canopen("f3658", 0xFFFF, 1);
    check_canopen("f3668", 0x0FFFFFFF, 4096);
}

/* --- INTERBUS --- */

static struct ib_rig plc;

static void start_interbus(const char *name, uint16_t id)
{
    assert_int_equal(ib_rig_init(&plc, dg_ib_model_of(dg_device_find(name))), DG_OK);
    assert_int_equal(dg_ib_id_word(&plc.model), id);
    plc.angle = -1;
    assert_int_equal(dg_ib_power_on(&plc.device, 0), DG_OK);
}

/* IN at `at`. */
static uint32_t in_at(dg_ns at)
{
    plc.now = at - IB_RIG_CYCLE;
    return ib_rig_cycle(&plc, 0);
}

/* The self-test takes 100 ms; then the last of 4096 steps a turn is there. */
static void ocd_interbus(void **state)
{
    (void)state;
    start_interbus("ocd-ib-k1", 0x0136);
    assert_int_equal(in_at(DG_MS(100) - 1), 0);
    assert_int_equal(in_at(DG_MS(100)), 0xFFF);
    start_interbus("ocd-ib-k2", 0x0236);
    assert_int_equal(in_at(DG_MS(100) - 1), 0);
    assert_int_equal(in_at(DG_MS(100)), 0xFFFFFF);
    start_interbus("ocd-ib-k3", 0x0237);
    assert_int_equal(in_at(DG_MS(100) - 1), 0xA0000000);
    assert_int_equal(in_at(DG_MS(100)), 0xFFFFFF);
}

/* A parameter has to stand for three cycles; then its answer is there. */
static void ocd_k3_parameters(void **state)
{
    static const uint32_t items[][2] = {
        {0x20210000, 1234567}, {0x20210001, 4096}, {0x20210002, 1}, {0x20210007, 0x0110},
        {0x2021000A, 2},       {0x2021000C, 250}, /* 25 degC, as it has the sensor */
    };
    (void)state;
    start_interbus("ocd-ib-k3", 0x0237);
    (void)in_at(DG_MS(100));
    plc.world.temperature_mdegc = 25000;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(ib_rig_cycle(&plc, 0x06000003), 0xFFFFFF);
    }
    assert_int_equal(ib_rig_cycle(&plc, 0x06000003), 0xC6000003);
    (void)ib_rig_release(&plc);
    for (size_t i = 0; i < DG_COUNT(items); i++) {
        assert_int_equal(ib_rig_send(&plc, items[i][0]), 0xA0000000 | items[i][1]);
        (void)ib_rig_cycle(&plc, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(models_are_listed_in_order),
        cmocka_unit_test(regions_of_a_memory_have_names_of_their_own),
        cmocka_unit_test(s3674_rs485),
        cmocka_unit_test(s3684_rs485),
        cmocka_unit_test(rs485_answers_after_1_ms_and_starts_in_100_ms),
        cmocka_unit_test(s3674_biss),
        cmocka_unit_test(s3684_biss),
        cmocka_unit_test(biss_memory_takes_its_time),
        cmocka_unit_test(f3658_and_f3668),
        cmocka_unit_test(ocd_interbus),
        cmocka_unit_test(ocd_k3_parameters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

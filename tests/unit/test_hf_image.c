/* SPDX-License-Identifier: MIT */
/*
 * An EEPROM of another make than the model it is put into: what is stored is what the encoder is.
 * Values by hand from chapters 5.1.1.2.2 (type label), 5.1.2.1, 5.1.2.3 and 5.1.2.11.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"
#include "host_rig.h"

#define RPM_IN_ANGLE_PER_MS (TURN / 60000)

static struct hf_rig rig;
static uint8_t image[HOST_RIG_MEMORY_MAX];

/* 11.25 turns: 3.25 of 8. */
static const dg_angle shaft = 11 * TURN + TURN / 4;

static const struct dg_hf_model *delivered(void)
{
    return dg_hf_model_of(dg_device_find("s3684-rs485"));
}

/* The EEPROM is `made`'s, the encoder around it as delivered. */
static void mount_memory_of(const struct dg_hf_model *made)
{
    assert_int_equal(hf_rig_init(&rig, made), DG_OK);
    const struct dg_hf_setup setup = hf_rig_setup(&rig, delivered());
    assert_int_equal(dg_hf_init(&rig.device, &setup), DG_OK);
    rig.angle = shaft;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
}

/* Without address, command and check sum. */
static void assert_reply(const char *request, const char *data)
{
    uint8_t bytes[16];
    const size_t n = hf_rig_hex(data, bytes, sizeof bytes);

    assert_int_equal(hf_rig_ask(&rig, request), 0);
    assert_int_equal(rig.reply_length, n + 3);
    assert_memory_equal(&rig.reply[2], bytes, n);
}

static void the_stored_resolution_is_counted(void **state)
{
    struct dg_hf_model made = *delivered();

    (void)state;
    made.periods_per_turn = 1024;
    made.turns = 8;
    mount_memory_of(&made);
    assert_reply("42", "00 01 A0 00"); /* 3.25 * 1024 * 32 */
    assert_reply("43 00 03 FF FF 55", "");
    assert_reply("42", "00 03 FF FF");
    assert_int_equal(hf_rig_ask(&rig, "43 00 04 00 00 55"), DG_HF_ARGUMENT);
    made.steps_per_period = 16;
    mount_memory_of(&made);
    assert_reply("42", "00 00 D0 00"); /* 3.25 * 1024 * 16 */
    made.steps_per_period = 512;       /* has a region of its own */
    mount_memory_of(&made);
    assert_reply("42", "00 1A 00 00"); /* 3.25 * 1024 * 512 */
}

static void a_preset_stays_in_the_stored_range(void **state)
{
    struct dg_hf_model made = *delivered();

    (void)state;
    made.turns = 8;
    assert_int_equal(hf_rig_init(&rig, &made), DG_OK);
    rig.angle = shaft;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_reply("43 00 00 12 34 55", "");
    const struct dg_hf_setup setup = hf_rig_setup(&rig, delivered());
    assert_int_equal(dg_hf_init(&rig.device, &setup), DG_OK);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_reply("42", "00 00 12 34");
    rig.angle += 5 * TURN; /* 8.25 of 8 */
    assert_reply("42", "00 05 12 34");
    rig.angle += 3 * TURN;
    assert_reply("42", "00 00 12 34");
}

static void the_stored_memory_is_handed_out(void **state)
{
    struct dg_hf_model made = *delivered();

    (void)state;
    made.memory_blocks = 4;
    made.implemented_blocks = 8;
    mount_memory_of(&made);
    assert_reply("4E", "04 00");
    assert_int_equal(hf_rig_ask(&rig, "52"), 0);
    assert_int_equal(rig.reply[4], 8);
    assert_int_equal(hf_rig_ask(&rig, "4D 00 CC 55"), DG_HF_FIELD_SIZE); /* 80 bytes */
    assert_int_equal(hf_rig_ask(&rig, "4D 00 CB 55"), 0);                /* 64 */
}

/* A data field is a block at least: there are as many fields as blocks, 112 at most. */
static void more_blocks_than_there_can_be_are_the_models(void **state)
{
    const uint8_t blocks = 113;
    struct dg_store store;

    (void)state;
    assert_int_equal(hf_rig_init(&rig, delivered()), DG_OK);
    assert_int_equal(dg_store_mount(&store, &dg_hf_layout, ram_nvm_port(&rig.nvm)), DG_OK);
    assert_int_equal(dg_store_put(&store, DG_HF_REGION_MEMORY, 0, &blocks, 1), DG_OK);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_reply("4E", "70 00");
}

static void what_is_another_makes_is_named(void **state)
{
    const struct dg_stack_setup setup = {.model = delivered()};
    struct dg_hf_model made = *delivered();

    (void)state;
    mount_memory_of(&made);
    assert_null(dg_hf_stack.differs(&setup, &rig.device.store));
    made.speed_max_rpm = 3000;
    mount_memory_of(&made);
    assert_string_equal(dg_hf_stack.differs(&setup, &rig.device.store), "type label");
    made.implemented_blocks = 128;
    mount_memory_of(&made);
    assert_string_equal(dg_hf_stack.differs(&setup, &rig.device.store), "implemented memory");
    made.memory_blocks = 4;
    mount_memory_of(&made);
    assert_string_equal(dg_hf_stack.differs(&setup, &rig.device.store), "user memory size");
    made.type_code = 0x37;
    mount_memory_of(&made);
    assert_string_equal(dg_hf_stack.differs(&setup, &rig.device.store), "type code or option");
    made.periods_per_turn = 1024;
    mount_memory_of(&made);
    assert_string_equal(dg_hf_stack.differs(&setup, &rig.device.store), "periods, steps or turns");
}

static void the_stored_label_is_told_and_holds(void **state)
{
    struct dg_hf_model made = *delivered();

    (void)state;
    made.temperature_channel = 0x50;
    made.led_channel = 0x51;
    made.vector_channel = 0x52;
    made.temperature_max_degc = 60;
    made.led_max_ma = 20;
    made.speed_max_rpm = 3000;
    mount_memory_of(&made);
    assert_reply("4A FF 1E 06 00", "FF 1E 06 00 50 FF D8 00 3C"); /* -40..60 */
    assert_reply("44 50", "50 00 25");
    assert_int_equal(hf_rig_ask(&rig, "44 51"), 0);
    assert_int_equal(hf_rig_ask(&rig, "44 52"), 0);
    assert_int_equal(hf_rig_ask(&rig, "44 48"), DG_HF_ARGUMENT);
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
    rig.angle_per_ms = 3001 * RPM_IN_ANGLE_PER_MS;
    assert_int_equal(hf_rig_ask(&rig, "42"), DG_HF_SPEED);
    rig.angle_per_ms = 2999 * RPM_IN_ANGLE_PER_MS;
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
    rig.world.led_current_ua = 20001;
    assert_int_equal(hf_rig_ask(&rig, "42"), DG_HF_LED_CURRENT);
    rig.world.led_current_ua = 20000;
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
    assert_int_equal(hf_rig_ask(&rig, "50"), 0);
}

static void the_stored_temperature_limit_is_watched(void **state)
{
    struct dg_hf_model made = *delivered();

    (void)state;
    made.temperature_max_degc = 60;
    mount_memory_of(&made);
    assert_reply("50", "00");
    rig.world.temperature_mdegc = 60000;
    assert_reply("50", "00");
    rig.world.temperature_mdegc = 60001;
    assert_int_equal(hf_rig_ask(&rig, "42"), 0); /* R32: the position is answered */
    assert_reply("50", "1E");
    rig.world.temperature_mdegc = -40000;
    assert_reply("50", "00");
    rig.world.temperature_mdegc = -40001;
    assert_reply("50", "1E");
}

/* The same through the handle: an image that another program has kept. */
static void an_image_makes_the_encoder_it_was(void **state)
{
    static const char *const figures[][2] = {
        {"periods", "1024"}, {"steps", "512"}, {"turns", "8"}, {"speed_max_rpm", "3000"}};
    struct dg_host *made = host_rig_make(&host_rig_there, "s3684-rs485");
    struct dg_host *self = host_rig_make(&host_rig_here, "s3684-rs485");
    const size_t n = dg_host_memory_size(made);
    uint64_t counts = 0;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(figures); i++) {
        assert_int_equal(dg_host_set(made, figures[i][0], figures[i][1]), DG_HOST_OK);
    }
    assert_int_equal(dg_host_power(made, 0, true), DG_HOST_OK);
    assert_int_equal(dg_host_memory_copy(made, image, n), DG_HOST_OK);
    assert_int_equal(dg_host_memory_load(self, image, n), DG_HOST_OK);
    dg_host_shaft(self, 0, (int64_t)shaft, 0);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    assert_int_equal(dg_host_position(self, READY, &counts), DG_HOST_OK);
    assert_int_equal(counts, 0x1A0000);
    const struct dg_host_event ask = {.at = READY,
                                      .kind = DG_HOST_BYTES,
                                      .length = 7,
                                      .data = {0x40, 0x4A, 0xFF, 0x02, 0x04, 0x00, 0xF3}};
    const uint8_t periods[] = {0x40, 0x4A, 0xFF, 0x02, 0x04, 0x00, 0x00, 0x04, 0x00, 0xF7};
    struct dg_host_event reply;
    assert_int_equal(dg_host_send(self, &ask), DG_HOST_OK);
    (void)dg_host_step(self, READY + 100 * MS);
    assert_int_equal(dg_host_receive(self, &reply), 1);
    assert_int_equal(reply.length, sizeof periods);
    assert_memory_equal(reply.data, periods, sizeof periods);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_stored_resolution_is_counted),
        cmocka_unit_test(a_preset_stays_in_the_stored_range),
        cmocka_unit_test(the_stored_memory_is_handed_out),
        cmocka_unit_test(more_blocks_than_there_can_be_are_the_models),
        cmocka_unit_test(what_is_another_makes_is_named),
        cmocka_unit_test(the_stored_label_is_told_and_holds),
        cmocka_unit_test(the_stored_temperature_limit_is_watched),
        cmocka_unit_test(an_image_makes_the_encoder_it_was),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * Memories whose check sums are right and whose contents are not: another program, or an encoder
 * with other figures, has written them. And worlds that no setting allows, which a program may
 * make.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "co_rig.h"
#include "hf_rig.h"
#include "hiperface_private.h"

static struct hf_rig rig;
static struct co_rig node;

static const struct dg_hf_model *start_hiperface(void)
{
    const struct dg_hf_model *model = dg_hf_model_of(&dg_s3684_rs485);

    assert_int_equal(hf_rig_init(&rig, model), DG_OK);
    return model;
}

/* A byte of a region is another one, with its check sum. */
static void store_byte(struct dg_store *store, uint8_t region, uint16_t at, uint8_t byte)
{
    uint8_t bytes[DG_STORE_CHECKED_MAX];
    const uint16_t size = store->layout->regions[region].size;

    assert_int_equal(dg_store_read(store, region, 0, bytes, size), DG_OK);
    bytes[at] = byte;
    assert_int_equal(dg_store_put(store, region, 0, bytes, size), DG_OK);
}

static void store_hiperface(const struct dg_hf_model *model, uint8_t region, uint16_t at,
                            uint8_t byte)
{
    struct dg_store store;

    assert_int_equal(dg_hf_mount(&store, model, ram_nvm_port(&rig.nvm)), DG_OK);
    store_byte(&store, region, at, byte);
}

static int64_t serial_of(const struct dg_hf_model *model)
{
    struct dg_store store;

    assert_int_equal(dg_hf_mount(&store, model, ram_nvm_port(&rig.nvm)), DG_OK);
    return dg_hf_serial(&store);
}

static void a_serial_number_with_other_characters_is_none(void **state)
{
    const struct dg_hf_model *model = start_hiperface();
    struct dg_store store;
    uint8_t label[DG_STORE_CHECKED_MAX];
    uint16_t at = 0;
    (void)state;
    assert_true(serial_of(model) >= 0);
    assert_int_equal(dg_hf_mount(&store, model, ram_nvm_port(&rig.nvm)), DG_OK);
    const uint16_t size = store.layout->regions[DG_HF_REGION_TYPE].size;
    assert_int_equal(dg_store_read(&store, DG_HF_REGION_TYPE, 0, label, size), DG_OK);
    while (memcmp(&label[at], model->serial, 9) != 0) {
        at++;
        assert_true(at + 9u <= size);
    }
    store_hiperface(model, DG_HF_REGION_TYPE, at, 'A');
    assert_int_equal(serial_of(model), -1);
    store_hiperface(model, DG_HF_REGION_TYPE, at, ' ');
    assert_int_equal(serial_of(model), -1);
    store_hiperface(model, DG_HF_REGION_TYPE, at, '7');
    assert_int_equal(serial_of(model) / 100000000, 7);
}

/* 52h tells the memory there is; a size beyond it is left alone. */
static void a_memory_size_that_cannot_be_is_left_alone(void **state)
{
    const struct dg_hf_model *model = start_hiperface();
    uint8_t delivered;
    (void)state;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_int_equal(hf_rig_ask(&rig, "52"), 0);
    delivered = rig.reply[4];
    dg_hf_power_off(&rig.device);
    store_hiperface(model, DG_HF_REGION_MEMORY, 0, 255);
    store_hiperface(model, DG_HF_REGION_IMPLEMENTED, 0, 255);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_int_equal(hf_rig_ask(&rig, "52"), 0);
    assert_int_equal(rig.reply[4], delivered);
}

/* Analog values have 16 bits: what is beyond is the last one there is. */
static void analog_values_end_at_16_bits(void **state)
{
    static const struct {
        int32_t mdegc;
        uint16_t told;
    } rows[] = {{INT32_MAX, 0x7FFF}, {INT32_MIN, 0x8000}, {37499, 37}, {-37500, 0xFFDA}};
    struct dg_hf_model model = *start_hiperface();
    (void)state;
    model.temperature_channel = 0x48;
    model.led_channel = 0x49;
    assert_int_equal(hf_rig_init(&rig, &model), DG_OK);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        rig.world.temperature_mdegc = rows[i].mdegc;
        (void)hf_rig_ask(&rig, "44 48");
        assert_int_equal(rig.reply[3] << 8 | rig.reply[4], rows[i].told);
    }
    rig.world.led_current_ua = UINT32_MAX;
    (void)hf_rig_ask(&rig, "44 49");
    assert_int_equal(rig.reply[3] << 8 | rig.reply[4], 0xFFFF);
}

/* Bit rate, node-ID, termination: one that cannot be, and all are as delivered. */
static void bus_parameters_that_cannot_be_are_as_delivered(void **state)
{
    static const struct {
        uint16_t at;
        uint8_t byte;
        bool good;
    } rows[] = {{0, 7, false}, {0, 9, false}, {1, 0, false}, {1, 128, false},
                {2, 2, false}, {2, 0, true},  {1, 7, true}};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        co_rig_start(&node);
        store_byte(&node.node.store, DG_CO_REGION_BUS, 0, 6); /* 500 kBd */
        store_byte(&node.node.store, DG_CO_REGION_BUS, rows[i].at, rows[i].byte);
        dg_co_power_off(&node.node);
        (void)co_rig_power_on(&node);
        assert_int_equal(node.kbaud, rows[i].good ? 500 : 250);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_serial_number_with_other_characters_is_none),
        cmocka_unit_test(a_memory_size_that_cannot_be_is_left_alone),
        cmocka_unit_test(analog_values_end_at_16_bits),
        cmocka_unit_test(bus_parameters_that_cannot_be_are_as_delivered),
    };
    return cmocka_run_group_tests_name("stored_nonsense", tests, NULL, NULL);
}

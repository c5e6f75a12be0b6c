/* SPDX-License-Identifier: MIT */
/*
 * An EEPROM that does not answer: at power-on, at run time, or in any single access of a command.
 * The answer is 05h (5.1.3.5), and what is stored is old or new as a whole. And memories that hold
 * no device at all.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"
#include "hiperface_private.h"

#define EVER UINT32_MAX

/* A request of every command that uses the EEPROM. */
static const char *const requests[] = {
    "43 01 23 45 67 55",
    "6A 01 23 45 67 55",
    "46",
    "47",
    "49 55",
    "4A 00 00 10 55",
    "4A FF 00 40 55",
    "4C 00",
    "4D 01 C9 55",
    "4D 00 CB 55",
    "4D 00 8A 55",
    "4D 00 4A 55",
    "4E",
    "4F 00 55 99",
    "52",
    "55 47 55",
    "56",
    "57 BD 55",
    "4B 00 00 05 55 01 02 03 04 05",
};
#define REQUESTS DG_COUNT(requests)

struct sight {
    size_t n;
    uint8_t bytes[512];
};

static struct hf_rig rig;
static struct hf_rig lived_in;
static struct sight before;
static struct sight after;
static struct sight seen;

static int set_up(void **state)
{
    (void)state;
    if (hf_rig_init(&rig, dg_hf_model_of(dg_device_find("s3684-rs485"))) != DG_OK ||
        hf_rig_power_on(&rig) != DG_OK || hf_rig_ask(&rig, "43 00 12 34 55 55") != 0 ||
        hf_rig_ask(&rig, "4D 00 CA 55") != 0 || hf_rig_ask(&rig, "47") != 0 ||
        hf_rig_ask(&rig, "55 47 55") != 0 || hf_rig_ask(&rig, "4F 01 55 77") != 0) {
        return -1;
    }
    lived_in = rig;
    return 0;
}

/* What can change, over the wire; by broadcast, to see the address, too. */
static void look_at_encoder(struct sight *sight)
{
    static const char *const looks[] = {"42",
                                        "46",
                                        "4E",
                                        "52",
                                        "4C 00",
                                        "4C 01",
                                        "50",
                                        "4A 00 00 10 55",
                                        "4A 00 00 10 99",
                                        "4A 01 00 10 55"};

    sight->n = 0;
    for (size_t i = 0; i < DG_COUNT(looks); i++) {
        uint8_t frame[16] = {DG_HF_ADDRESS_BROADCAST};
        const size_t n = 1 + hf_rig_hex(looks[i], &frame[1], sizeof frame - 2u);
        frame[n] = hf_rig_xor(frame, n);
        assert_true(hf_rig_send(&rig, frame, n + 1) > 0);
        assert_true(sight->n + rig.reply_length <= sizeof sight->bytes);
        memcpy(&sight->bytes[sight->n], rig.reply, rig.reply_length);
        sight->n += rig.reply_length;
    }
}

static bool same(const struct sight *a, const struct sight *b)
{
    return a->n == b->n && memcmp(a->bytes, b->bytes, a->n) == 0;
}

static void assert_old_or_new(void)
{
    look_at_encoder(&seen);
    assert_true(same(&seen, &before) || same(&seen, &after));
}

static void heal(void)
{
    rig.fail_count = 0;
    rig.nvm.no_acknowledge = false;
}

/* From access `nth` of this request on, `count` accesses fail. */
static void assert_failure(const char *request, uint32_t nth, uint32_t count)
{
    rig = lived_in;
    rig.fail_from = rig.accesses + nth;
    rig.fail_count = count;
    assert_int_equal(hf_rig_ask(&rig, request), DG_HF_I2C);
    /* The position does not need the EEPROM; a command that does goes on failing, or not. */
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
    assert_int_equal(hf_rig_ask(&rig, "46"), count == EVER ? DG_HF_I2C : 0);
    heal();
    assert_old_or_new();
    const bool shown = same(&seen, &after);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_old_or_new();
    assert_true(!shown || same(&seen, &after)); /* what has been shown is not taken back */
    if (same(&seen, &before)) {
        assert_int_equal(hf_rig_ask(&rig, request), 0);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        look_at_encoder(&seen);
        assert_true(same(&seen, &after));
    }
}

static void every_access_of_every_command_may_fail(void **state)
{
    (void)state;
    for (size_t i = 0; i < REQUESTS; i++) {
        rig = lived_in;
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        look_at_encoder(&before);
        rig = lived_in;
        assert_int_equal(hf_rig_ask(&rig, requests[i]), 0);
        const uint32_t accesses = rig.accesses - lived_in.accesses;
        assert_true(accesses > 0);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        look_at_encoder(&after);
        for (uint32_t nth = 0; nth < accesses; nth++) {
            assert_failure(requests[i], nth, 1);
            assert_failure(requests[i], nth, EVER);
        }
    }
}

/* @return how many accesses `request` takes */
static uint32_t accesses_of(const char *request)
{
    rig = lived_in;
    assert_int_equal(hf_rig_ask(&rig, request), 0);
    return rig.accesses - lived_in.accesses;
}

static void refuse_at(const char *request, uint32_t nth)
{
    rig = lived_in;
    rig.fail_from = rig.accesses + nth;
    rig.fail_count = 1;
    assert_int_equal(hf_rig_ask(&rig, request), DG_HF_I2C);
    heal();
}

/* The journal was whole already when the memory failed: what is read comes with the memory, what a
   start reads with the start. */
static void what_was_refused_may_come_with_the_memory(void **state)
{
    static const char save[] = "4B 00 00 05 55 01 02 03 04 05";
    static const char move[] = "55 4A 55";
    uint32_t came = 0;
    (void)state;
    const uint32_t saving = accesses_of(save);
    for (uint32_t nth = 0; nth < saving; nth++) {
        refuse_at(save, nth);
        assert_int_equal(hf_rig_ask(&rig, "4A 00 00 05 55"), 0);
        came += memcmp(&rig.reply[5], "\1\2\3\4\5", 5) == 0;
    }
    assert_in_range(came, 1, saving - 1);
    came = 0;
    const uint32_t moving = accesses_of(move);
    for (uint32_t nth = 0; nth < moving; nth++) {
        refuse_at(move, nth);
        assert_int_equal(hf_rig_ask(&rig, "46"), 0);
        assert_int_equal(rig.device.address, lived_in.device.address);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        came += rig.device.address == 0x4A;
    }
    assert_in_range(came, 1, moving - 1);
}

/* What answers without the EEPROM does not touch it. */
static void the_others_need_no_access(void **state)
{
    (void)state;
    rig.nvm.no_acknowledge = true;
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
    assert_int_equal(hf_rig_ask(&rig, "44 48"), 0);
    assert_int_equal(hf_rig_ask(&rig, "50"), 0);
    assert_int_equal(rig.reply[2], 0);
    assert_int_equal(rig.accesses, lived_in.accesses);
}

static void assert_all_answer_i2c(void)
{
    for (size_t i = 0; i < REQUESTS; i++) {
        assert_int_equal(hf_rig_ask(&rig, requests[i]), DG_HF_I2C);
    }
}

/* The world's cause, an I2C bus that is dead: the device does not even try. */
static void a_dead_bus_is_answered_and_heals(void **state)
{
    (void)state;
    look_at_encoder(&before);
    const uint32_t accesses = rig.accesses;
    rig.world.eeprom_acknowledges = false;
    assert_all_answer_i2c();
    assert_int_equal(rig.accesses, accesses);
    rig.world.eeprom_acknowledges = true;
    look_at_encoder(&seen);
    assert_true(same(&seen, &before));
}

/* 05h in the stack; position 02h, all that uses the EEPROM 05h, until the next start; and nothing
 * of what is stored is in force, not even when the memory has come back meanwhile. */
static void assert_started_without_memory(void)
{
    assert_int_equal(rig.device.address, DG_HF_ADDRESS_DEFAULT);
    assert_int_equal(rig.device.codes[1], DG_HF_CODE_DEFAULT);
    assert_int_equal(rig.device.offset, 0);
    assert_int_equal(hf_rig_ask(&rig, "50"), 0);
    assert_int_equal(rig.reply[2], DG_HF_I2C);
    assert_int_equal(hf_rig_ask(&rig, "50"), 0);
    assert_int_equal(rig.reply[2], DG_HF_NO_ERROR);
    assert_int_equal(hf_rig_ask(&rig, "42"), DG_HF_ANGLE_OFFSET);
    assert_int_equal(hf_rig_ask(&rig, "43 00 00 00 00 55"), DG_HF_ANGLE_OFFSET);
    for (size_t i = 2; i < REQUESTS; i++) {
        assert_int_equal(hf_rig_ask(&rig, requests[i]), DG_HF_I2C);
    }
}

static void a_bus_that_is_dead_at_power_on(void **state)
{
    (void)state;
    look_at_encoder(&before);
    rig.world.eeprom_acknowledges = false;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_started_without_memory();
    rig.world.eeprom_acknowledges = true;
    assert_int_equal(hf_rig_ask(&rig, "42"), DG_HF_ANGLE_OFFSET);
    assert_int_equal(hf_rig_ask(&rig, "53"), HF_RIG_SILENCE);
    look_at_encoder(&seen);
    assert_true(same(&seen, &before));
}

static void every_access_of_the_start_may_fail(void **state)
{
    (void)state;
    look_at_encoder(&before);
    rig = lived_in;
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    const uint32_t accesses = rig.accesses - lived_in.accesses;
    assert_in_range(accesses, 10, 1000);
    for (uint32_t nth = 0; nth < accesses; nth++) {
        rig = lived_in;
        rig.fail_from = rig.accesses + nth;
        rig.fail_count = 1;
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        assert_started_without_memory();
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        look_at_encoder(&seen);
        assert_true(same(&seen, &before));
    }
}

/* Memories that hold something else, or nothing. */

static void assert_stays_off(int expected)
{
    static uint8_t image[RAM_NVM_MAX];
    static const uint8_t frame[] = {0x40, 0x42, 0x02};

    memcpy(image, rig.nvm.bytes, sizeof image);
    assert_int_equal(hf_rig_power_on(&rig), expected);
    assert_int_equal(rig.device.line, DG_HF_OFF);
    assert_int_equal(hf_rig_send(&rig, frame, sizeof frame), 0);
    assert_memory_equal(rig.nvm.bytes, image, sizeof image);
}

/* A model is checked before anything of it is written. */
static void models_that_cannot_be(void **state)
{
    static const struct {
        struct dg_hf_model model;
        bool good;
    } rows[] = {
        {{.memory_blocks = 1}, true},
        {{.memory_blocks = 112, .implemented_blocks = 128, .init = DG_HF_INIT_MAX}, true},
        {{.memory_blocks = 16, .implemented_blocks = 16}, true},
        {{.memory_blocks = 16, .implemented_blocks = 15}, false},
        {{.memory_blocks = 16, .implemented_blocks = 129}, false},
        {{.memory_blocks = 0}, false},
        {{.memory_blocks = 113}, false},
        {{.memory_blocks = 16, .init = DG_HF_INIT_MAX + 1u}, false},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_hf_model model = *rig.device.setup.model;
        model.memory_blocks = rows[i].model.memory_blocks;
        model.implemented_blocks = rows[i].model.implemented_blocks;
        model.init = rows[i].model.init;
        assert_int_equal(dg_hf_model_check(&model), rows[i].good ? DG_OK : DG_ERR_ARGUMENT);
    }
}

static void a_blank_memory_is_no_device(void **state)
{
    (void)state;
    memset(rig.nvm.bytes, 0xFF, sizeof rig.nvm.bytes);
    assert_stays_off(DG_ERR_BLANK);
    const struct dg_hf_setup *setup = &rig.device.setup;
    assert_int_equal(dg_hf_format(setup->model, setup->nvm), DG_OK);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_int_equal(hf_rig_ask(&rig, "42"), 0);
}

static void a_foreign_memory_is_left_alone(void **state)
{
    (void)state;
    memset(rig.nvm.bytes, 0x00, sizeof rig.nvm.bytes);
    assert_stays_off(DG_ERR_FOREIGN);
    for (size_t i = 0; i < sizeof rig.nvm.bytes; i++) {
        rig.nvm.bytes[i] = (uint8_t)(i * 31u);
    }
    assert_stays_off(DG_ERR_FOREIGN);
}

/* Formatting stops at any failing access; what is left is no device, and formatting again works. */
static void every_access_of_formatting_may_fail(void **state)
{
    const struct dg_hf_setup setup = rig.device.setup;

    (void)state;
    const uint32_t begin = rig.accesses;
    assert_int_equal(dg_hf_format(setup.model, setup.nvm), DG_OK);
    const uint32_t accesses = rig.accesses - begin;
    for (uint32_t nth = 0; nth < accesses; nth++) {
        memset(rig.nvm.bytes, 0xFF, sizeof rig.nvm.bytes);
        rig.fail_from = rig.accesses + nth;
        rig.fail_count = EVER;
        assert_int_equal(dg_hf_format(setup.model, setup.nvm), DG_ERR_IO);
        heal();
        const int result = dg_hf_power_on(&rig.device, rig.now);
        /* Behind the first header, at its sync, everything is there already. */
        assert_int_equal(result, nth + 3 < accesses ? DG_ERR_BLANK : DG_OK);
        assert_int_equal(dg_hf_format(setup.model, setup.nvm), DG_OK);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        assert_int_equal(hf_rig_ask(&rig, "50"), 0);
        assert_int_equal(rig.reply[2], DG_HF_NO_ERROR);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(every_access_of_every_command_may_fail, set_up),
        cmocka_unit_test_setup(what_was_refused_may_come_with_the_memory, set_up),
        cmocka_unit_test_setup(the_others_need_no_access, set_up),
        cmocka_unit_test_setup(a_dead_bus_is_answered_and_heals, set_up),
        cmocka_unit_test_setup(a_bus_that_is_dead_at_power_on, set_up),
        cmocka_unit_test_setup(every_access_of_the_start_may_fail, set_up),
        cmocka_unit_test_setup(models_that_cannot_be, set_up),
        cmocka_unit_test_setup(a_blank_memory_is_no_device, set_up),
        cmocka_unit_test_setup(a_foreign_memory_is_left_alone, set_up),
        cmocka_unit_test_setup(every_access_of_formatting_may_fail, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

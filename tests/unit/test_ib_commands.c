/* SPDX-License-Identifier: MIT */
/*
 * Every command word of chapter 9 in every mode, every read-out item, every error, and what holds
 * and ends an answer.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "ib_rig.h"
#include "interbus_private.h"

enum mode { POSITION, SPEED, CAM, MODES };

static const uint32_t enter[MODES] = {0x20400000, 0x20400001, 0x20800002};

static struct ib_rig rig;

static int set_up(void **state)
{
    (void)state;
    if (ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k3"))) != DG_OK) {
        return -1;
    }
    ib_rig_turn_to(&rig, 1000);
    return ib_rig_power_on(&rig) == DG_OK ? 0 : -1;
}

static void start_in(enum mode mode)
{
    assert_int_equal(set_up(NULL), 0);
    (void)ib_rig_send(&rig, enter[mode]);
    (void)ib_rig_release(&rig);
}

/* What a word is answered with; 0: nothing, IN is what it is in operation. */
struct word {
    uint32_t out;
    uint32_t in[MODES];
};

/* clang-format off */
static const struct word words[] = {
    /*            position    speed       cam */
    {0x00123456, {0,          0,          0}},
    {0x01FFFFFF, {0,          0,          0}},
    {0x80000000, {0,          0,          0}},
    {0x02000001, {0xC2000001, 0xC2000001, 0xC2000001}},
    {0x02001000, {0xC2001000, 0xC2001000, 0xC2001000}},
    {0x02000000, {0x82000000, 0x82000000, 0x82000000}},
    {0x02001001, {0xC2001001, 0xC2001001, 0xC2001001}},
    {0x03FFFFFF, {0xC3FFFFFF, 0xC3FFFFFF, 0xC3FFFFFF}},
    {0x04000001, {0xC4000001, 0xC4000001, 0xC4000001}},
    {0x04001000, {0xC4001000, 0xC4001000, 0xC4001000}},
    {0x04000000, {0x82000000, 0x82000000, 0x82000000}},
    {0x04001001, {0x82000000, 0x82000000, 0x82000000}},
    {0x06000003, {0xC6000003, 0xC6000003, 0xC6000003}},
    {0x06000004, {0xC6000004, 0xC6000004, 0xC6000004}},
    {0x06000000, {0x82000000, 0x82000000, 0x82000000}},
    {0x06000002, {0x82000000, 0x82000000, 0x82000000}},
    {0x06000005, {0x82000000, 0x82000000, 0x82000000}},
    {0x07000003, {0x82000000, 0x82000000, 0x82000000}},
    {0x08000000, {0xC8000000, 0xC8000000, 0xC8000000}},
    {0x08FFFFFF, {0xC8FFFFFF, 0xC8FFFFFF, 0xC8FFFFFF}},
    {0x09000000, {0x82000000, 0x82000000, 0x82000000}},
    {0x0A000000, {0xCA000000, 0xCA000000, 0xCA000000}},
    {0x0AFFFFFF, {0xCAFFFFFF, 0xCAFFFFFF, 0xCAFFFFFF}},
    {0x0B000000, {0x82000000, 0x82000000, 0x82000000}},
    {0x0C000000, {0x84000000, 0x84000000, 0x84000000}},
    {0x0E000000, {0xCE000000, 0xCE000000, 0xCE000000}},
    {0x0E000001, {0x82000000, 0x82000000, 0x82000000}},
    {0x10000000, {0x84000000, 0x84000000, 0x84000000}},
    {0x1E000000, {0x84000000, 0x84000000, 0x84000000}},
    {0x20000000, {0x84000000, 0x84000000, 0x84000000}},
    {0x20400000, {0xE0400000, 0xE0400000, 0xE0400000}},
    {0x20400001, {0xE0400001, 0xE0400001, 0xE0400001}},
    {0x20400002, {0x84000000, 0x84000000, 0xE0400002}},
    {0x204000FF, {0x84000000, 0x84000000, 0xE04000FF}},
    {0x20400100, {0x84000000, 0x84000000, 0x84000000}},
    {0x20408000, {0x84000000, 0x84000000, 0x84000000}},
    {0x20800000, {0xE0800000, 0xE0800000, 0xE0800000}},
    {0x20800001, {0xE0800001, 0xE0800001, 0xE0800001}},
    {0x20800008, {0xE0800008, 0xE0800008, 0xE0800008}},
    {0x20800009, {0x84000000, 0x84000000, 0x84000000}},
    {0x2080000F, {0x84000000, 0x84000000, 0x84000000}},
    {0x20800010, {0x84000000, 0x84000000, 0x84000000}},
    {0x20100000, {0xE0100000, 0xE0100000, 0xE0100000}},
    {0x20100019, {0xE0100019, 0xE0100019, 0xE0100019}},
    {0x2010001A, {0x82000000, 0x82000000, 0x82000000}},
    {0x201000FF, {0x82000000, 0x82000000, 0x82000000}},
    {0x20100100, {0x84000000, 0x84000000, 0x84000000}},
    {0x20200000, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20200010, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20200017, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20200018, {0x84000000, 0x84000000, 0x84000000}},
    {0x20200027, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20200028, {0x84000000, 0x84000000, 0x84000000}},
    {0x20200030, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20200040, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20200041, {0x84000000, 0x84000000, 0x84000000}},
    {0x20210000, {0xA012D687, 0xA012D687, 0xA012D687}},
    {0x20210001, {0xA0001000, 0xA0001000, 0xA0001000}},
    {0x20210002, {0xA0000001, 0xA0000001, 0xA0000001}},
    {0x20210003, {0xA0000003, 0xA0000003, 0xA0000003}},
    {0x20210004, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20210005, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20210006, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20210007, {0xA0000110, 0xA0000110, 0xA0000110}},
    {0x20210008, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x20210009, {0xA0000001, 0xA0000002, 0xA0000004}},
    {0x2021000A, {0xA0000002, 0xA0000002, 0xA0000002}},
    {0x2021000B, {0xA421000B, 0xA421000B, 0xA421000B}},
    {0x2021000C, {0xA0000172, 0xA0000172, 0xA0000172}},
    {0x2021000D, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x202100CD, {0xA0000037, 0xA0000037, 0xA0000037}},
    {0x202100FD, {0xA0000000, 0xA0000000, 0xA0000000}},
    {0x2021000E, {0xA421000E, 0xA421000E, 0xA421000E}},
    {0x20210010, {0xA4210010, 0xA4210010, 0xA4210010}},
    {0x2021010D, {0xA421010D, 0xA421010D, 0xA421010D}},
    {0x2021FFFF, {0xA421FFFF, 0xA421FFFF, 0xA421FFFF}},
    {0x20220000, {0x84000000, 0x84000000, 0x84000000}},
    {0x22000000, {0x84000000, 0x84000000, 0x84000000}},
    {0x40000000, {0,          0,          0xC0000000}},
    {0x40000001, {0x84000000, 0x84000000, 0xC0000001}},
    {0x4E000015, {0x84000000, 0x84000000, 0xCE000015}},
    {0x50000015, {0x84000000, 0x84000000, 0x84000000}},
    {0x5E000015, {0x84000000, 0x84000000, 0x84000000}},
    {0x40FFFFFF, {0x84000000, 0x84000000, 0xC0FFFFFF}},
    {0x41000000, {0x84000000, 0x84000000, 0x98000004}},
    {0x60000000, {0,          0,          0xE0000000}},
    {0x60000001, {0x84000000, 0x84000000, 0xE0000001}},
    {0x6EFFFFFF, {0x84000000, 0x84000000, 0xEEFFFFFF}},
    {0x6FFFFFFF, {0x84000000, 0x84000000, 0x98000004}},
    {0x70000000, {0x84000000, 0x84000000, 0x84000000}},
    {0x80000001, {0x84000000, 0x84000000, 0x84000000}},
    {0xA0000000, {0x84000000, 0x84000000, 0x84000000}},
    {0xC20000FF, {0x84000000, 0x84000000, 0x84000000}},
    {0xFFFFFFFF, {0x84000000, 0x84000000, 0x84000000}},
};
/* clang-format on */
#define WORDS DG_COUNT(words)

static void every_word_in_every_mode(void **state)
{
    (void)state;
    for (size_t i = 0; i < WORDS; i++) {
        for (int mode = 0; mode < MODES; mode++) {
            start_in((enum mode)mode);
            /* The FRABA preset answers with the preset, 0, as the position; so does standstill. */
            const uint32_t operation = words[i].out == 0x60000000 ? 0 : rig.in;
            const uint32_t expected = words[i].in[mode] != 0 ? words[i].in[mode] : operation;
            uint32_t in = ib_rig_send(&rig, words[i].out);
            if (in != expected) {
                fail_msg("%08X in mode %d: %08X, not %08X", (unsigned)words[i].out, mode,
                         (unsigned)in, (unsigned)expected);
            }
            assert_int_equal(ib_rig_send(&rig, words[i].out), in); /* and it stays */
        }
    }
}

/* A refused word changes nothing, not even after a restart, and is no trap: the release ends it. */
static void refused_words_change_nothing(void **state)
{
    (void)state;
    for (size_t i = 0; i < WORDS; i++) {
        for (int mode = 0; mode < MODES; mode++) {
            const uint32_t expected = words[i].in[mode];
            if (expected >> 29 != 4 && expected >> 24 != 0xA4) {
                continue;
            }
            start_in((enum mode)mode);
            const uint32_t operation = rig.in;
            const struct dg_ib before = rig.device;
            (void)ib_rig_send(&rig, words[i].out);
            assert_int_equal(rig.device.last_error, expected);
            assert_int_equal(rig.device.counters.refused, before.counters.refused + 1);
            assert_int_equal(rig.device.counters.commands, before.counters.commands);
            (void)ib_rig_cycle(&rig, 0);
            assert_int_equal(ib_rig_release(&rig), operation);
            assert_int_equal(rig.device.steps, before.steps);
            assert_int_equal(rig.device.mode, before.mode);
            assert_memory_equal(&rig.device.program, &before.program, sizeof before.program);
            assert_int_equal(ib_rig_power_on(&rig), DG_OK);
            assert_int_equal(ib_rig_cycle(&rig, 0), operation);
        }
    }
}

/* I3: an error is held until a valid command, which need not have an answer of its own. */
static void errors_are_held(void **state)
{
    (void)state;
    assert_int_equal(ib_rig_send(&rig, 0x0C000000), 0x84000000);
    assert_int_equal(ib_rig_send(&rig, 0x00000000), 0x84000000);
    assert_int_equal(ib_rig_send(&rig, 0x40000000), 0x84000000); /* no preset was set */
    assert_int_equal(ib_rig_send(&rig, 0x02000000), 0x82000000);
    assert_int_equal(ib_rig_send(&rig, 0x08000007), 0xC8000007);
    assert_int_equal(ib_rig_send(&rig, 0x0C000000), 0x84000000);
    assert_int_equal(ib_rig_send(&rig, 0x40000000), 7);
    assert_int_equal(ib_rig_send(&rig, 0x0C000000), 0x84000000);
    assert_int_equal(ib_rig_send(&rig, 0x20210001), 0xA0001000);
    assert_int_equal(ib_rig_send(&rig, 0x00000000), 7);
}

/* I3, also when nothing stood on the bus before. */
static void the_first_word_is_a_command(void **state)
{
    static const uint32_t words_of_masters[] = {0x04000000, 0x20200018, 0x8FFFFFFF, 0xFFFFFFFF};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(words_of_masters); i++) {
        assert_int_equal(dg_ib_power_on(&rig.device, rig.now), DG_OK);
        rig.now = rig.device.ready_at;
        assert_int_equal(ib_rig_send(&rig, words_of_masters[i]), i == 0 ? 0x82000000 : 0x84000000);
    }
}

/* Words in operation are no commands: the state tells of the last one that was. */
static void words_in_operation_are_no_commands(void **state)
{
    (void)state;
    (void)ib_rig_send(&rig, 0x08000007);
    (void)ib_rig_send(&rig, 0x00123456);
    assert_int_equal(rig.device.last_command, 0x08000007);
}

/* I12. The parameter answer that stood before shows again. */
static void bit_16_ends_the_read_out(void **state)
{
    (void)state;
    assert_int_equal(ib_rig_send(&rig, 0x20210001), 0xA0001000);
    assert_int_equal(ib_rig_cycle(&rig, 0x00010000), 0xA0001000);
    assert_int_equal(ib_rig_send(&rig, 0x00010000), 0xA0001000);
    assert_int_equal(ib_rig_cycle(&rig, 0x00000000), 0xA0001000);
    assert_int_equal(ib_rig_cycle(&rig, 0x00000000), 1000);
    assert_int_equal(ib_rig_send(&rig, 0x08000007), 0xC8000007);
    assert_int_equal(ib_rig_send(&rig, 0x20210004), 0xA0000007);
    assert_int_equal(ib_rig_send(&rig, 0x20210006), 0xA0000001);
    assert_int_equal(ib_rig_send(&rig, 0x00000000), 0xC8000007);
    assert_int_equal(ib_rig_send(&rig, 0x2021000B), 0xA421000B);
    assert_int_equal(ib_rig_send(&rig, 0x00000000), 0xC8000007);
    assert_int_equal(ib_rig_send(&rig, 0x20210006), 0xA0000001);
    assert_int_equal(ib_rig_send(&rig, 0x0801FFFF), 0xC801FFFF); /* bit 16 set, but a command */
    assert_int_equal(ib_rig_release(&rig), 1000);
}

static void items_are_read_in_every_cycle(void **state)
{
    static const struct {
        int32_t mdegc;
        uint32_t in;
    } temperatures[] = {
        {37000, 0xA0000172}, {0, 0xA0000000},   {49, 0xA0000000},     {50, 0xA0000001},
        {-50, 0xA1FFFFFF},   {-49, 0xA0000000}, {-40000, 0xA1FFFE70}, {85150, 0xA0000354},
    };

    (void)state;
    (void)ib_rig_send(&rig, 0x2021000C);
    for (size_t i = 0; i < DG_COUNT(temperatures); i++) {
        rig.world.temperature_mdegc = temperatures[i].mdegc;
        assert_int_equal(ib_rig_cycle(&rig, 0x2021000C), temperatures[i].in);
    }
    (void)ib_rig_send(&rig, 0x2021005D);
    rig.device.opc[5] = 0xA5;
    assert_int_equal(ib_rig_cycle(&rig, 0x2021005D), 0xA00000A5);
    (void)ib_rig_send(&rig, 0x20210008);
    rig.now = DG_S(600) - DG_MS(2);
    assert_int_equal(ib_rig_cycle(&rig, 0x20210008), 0xA0000000);
    assert_int_equal(ib_rig_cycle(&rig, 0x20210008), 0xA0000001);
    rig.now += DG_S(1800);
    assert_int_equal(ib_rig_cycle(&rig, 0x20210008), 0xA0000004);
    rig.now += DG_S(900);
    assert_int_equal(ib_rig_cycle(&rig, 0x20210008), 0xA0000005);
    rig.now += DG_S(300); /* the half that was over counts */
    assert_int_equal(ib_rig_cycle(&rig, 0x20210008), 0xA0000006);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    assert_int_equal(ib_rig_send(&rig, 0x20210008), 0xA0000006);
}

static void the_model_shows_in_the_items(void **state)
{
    struct dg_ib_model model = *dg_ib_model_of(dg_device_find("ocd-ib-k3"));

    (void)state;
    model.steps_minus_one = true;
    model.turns = 1;
    model.temperature_sensor = false;
    model.loop = true;
    model.serial = 0x1FFFFFF;
    assert_int_equal(ib_rig_init(&rig, &model), DG_OK);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    assert_int_equal(ib_rig_send(&rig, 0x20210000), 0xA1FFFFFF);
    assert_int_equal(ib_rig_send(&rig, 0x20210001), 0xA0000FFF);
    assert_int_equal(ib_rig_send(&rig, 0x2021000A), 0xA0000001);
    assert_int_equal(ib_rig_send(&rig, 0x2021000C), 0xA421000C);
    assert_int_equal(ib_rig_send(&rig, 0x202100CD), 0xA00000B3);
}

/* Every mode is the start-up mode (I10), with its number and without a release. */
static void modes_survive(void **state)
{
    (void)state;
    for (uint32_t p = 0; p <= 8; p++) {
        assert_int_equal(set_up(NULL), 0);
        assert_int_equal(ib_rig_send(&rig, 0x20800000 + p), 0xE0800000 + p);
        assert_int_equal(ib_rig_power_on(&rig), DG_OK);
        assert_int_equal(ib_rig_cycle(&rig, 0), p == 0 ? 1000 : 1000 << 8);
        assert_int_equal(ib_rig_send(&rig, 0x20210009), 0xA0000000 + (p == 0 ? 1 : 2 + p));
    }
    assert_int_equal(ib_rig_send(&rig, 0x20800000), 0xE0800000);
    assert_int_equal(ib_rig_send(&rig, 0x20400001), 0xE0400001);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
    assert_int_equal(ib_rig_send(&rig, 0x20210009), 0xA0000002);
}

/* No row hides another one, in no mode. */
static void rows_of_the_table_do_not_overlap(void **state)
{
    (void)state;
    assert_true(dg_ib_command_count > 0);
    for (uint8_t i = 0; i < dg_ib_command_count; i++) {
        const struct ib_command *a = &dg_ib_commands[i];
        assert_true((a->value & ~a->mask) == 0);
        assert_true(a->modes != 0 && a->handler != NULL);
        for (uint8_t k = 0; k < i; k++) {
            const struct ib_command *b = &dg_ib_commands[k];
            uint32_t common = a->mask & b->mask;
            assert_true((a->modes & b->modes) == 0 || (a->value & common) != (b->value & common));
        }
    }
}

static void models_are_checked(void **state)
{
    const struct dg_ib_model good = *dg_ib_model_of(dg_device_find("ocd-ib-k3"));
    struct dg_ib_model bad[12];

    (void)state;
    for (size_t i = 0; i < 12; i++) {
        bad[i] = good;
    }
    bad[0].profile = DG_IB_PROFILE_COUNT;
    bad[1].steps = 0;
    bad[2].steps = 8193;
    bad[3].turns = 0;
    bad[4].turns = 4097;
    bad[5].param_cycles = 0;
    bad[6].serial = 0x2000000;
    bad[7].version = 0x2000000;
    bad[8].self_test = DG_S(1) + 1;
    bad[9].profile = DG_IB_K1;
    bad[10].steps = 1;
    bad[10].steps_minus_one = true;
    bad[11].serial = 0x1FFFFFF; /* these are the largest */
    bad[11].version = 0x1FFFFFF;
    for (size_t i = 0; i < 12; i++) {
        assert_int_equal(ib_rig_init(&rig, &bad[i]), i < 11 ? DG_ERR_ARGUMENT : DG_OK);
        const struct dg_ib_setup setup = {&bad[i], &rig.world, ram_nvm_port(&rig.nvm)};
        assert_int_equal(dg_ib_init(&rig.device, &setup), i < 11 ? DG_ERR_ARGUMENT : DG_OK);
    }
    struct dg_ib_setup setup = {&good, &rig.world, {NULL, NULL}};
    assert_int_equal(dg_ib_init(&rig.device, &setup), DG_ERR_ARGUMENT);
    setup = (struct dg_ib_setup){NULL, &rig.world, ram_nvm_port(&rig.nvm)};
    assert_int_equal(dg_ib_init(&rig.device, &setup), DG_ERR_ARGUMENT);
    setup = (struct dg_ib_setup){&good, NULL, ram_nvm_port(&rig.nvm)};
    assert_int_equal(dg_ib_init(&rig.device, &setup), DG_ERR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_word_in_every_mode),
        cmocka_unit_test(refused_words_change_nothing),
        cmocka_unit_test_setup(errors_are_held, set_up),
        cmocka_unit_test_setup(the_first_word_is_a_command, set_up),
        cmocka_unit_test_setup(words_in_operation_are_no_commands, set_up),
        cmocka_unit_test_setup(bit_16_ends_the_read_out, set_up),
        cmocka_unit_test_setup(items_are_read_in_every_cycle, set_up),
        cmocka_unit_test(the_model_shows_in_the_items),
        cmocka_unit_test(modes_survive),
        cmocka_unit_test(rows_of_the_table_do_not_overlap),
        cmocka_unit_test(models_are_checked),
    };
    return cmocka_run_group_tests_name("commands of an OCD INTERBUS", tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The manual's own examples: chapter 5.3, row by row, its activation of the preset, and the cam
 * of chapter 5.4.4. And what time has to do with an answer.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "ib_rig.h"

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

/* One row of the manual: OUT, and IN after so many cycles. */
struct row {
    uint32_t out;
    uint32_t in;
    int cycles;
};

static void replay(const struct row *rows, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < rows[i].cycles; k++) {
            if (ib_rig_cycle(&rig, rows[i].out) != rows[i].in) {
                fail_msg("row %zu, cycle %d: IN is %08X", i, k, (unsigned)rig.in);
            }
        }
    }
}

/* 255 steps a turn, 1 revolution, clockwise, preset 0. Step 1000 of 4096 is 62 of 255. */
static const struct row parametrisation[] = {
    {0x00000000, 1000, 1}, /* 1: position */
    {0x020000FF, 1000, 3}, /* 2 to 5: not yet */
    {0x020000FF, 0xC20000FF, 1}, {0x04000001, 0xC20000FF, 3}, {0x04000001, 0xC4000001, 1},
    {0x06000003, 0xC4000001, 3}, {0x06000003, 0xC6000003, 1}, {0x08000000, 0xC6000003, 3},
    {0x08000000, 0xC8000000, 1}, {0x80000000, 0xC8000000, 1}, /* 16: no reaction yet */
    {0x80000000, 62, 1},         {0x00000000, 62, 2},
};

static void chapter_5_3(void **state)
{
    static const struct row preset[] = {
        {0x00000000, 62, 1},
        {0x40000000, 62, 1},
        {0x40000000, 0, 1},
        {0x00000000, 0, 2},
    };

    (void)state;
    replay(parametrisation, DG_COUNT(parametrisation));
    replay(preset, DG_COUNT(preset));
    ib_rig_turn_to(&rig, 1000 + 2048); /* half a turn on */
    assert_int_equal(ib_rig_cycle(&rig, 0), 127);
}

static void chapter_5_4_4(void **state)
{
    static const struct row cam[] = {
        {0x20800001, 1000, 3},       {0x20800001, 0xE0800001, 1}, {0x46000015, 0xE0800001, 3},
        {0x46000015, 0xC6000015, 1}, {0x66000213, 0xC6000015, 3}, {0x66000213, 0xE6000213, 1},
        {0x20400008, 0xE6000213, 3}, {0x20400008, 0xE0400008, 1}, {0x80000000, 0xE0400008, 1},
    };

    (void)state;
    replay(cam, DG_COUNT(cam));
    for (uint32_t p = 0; p < 0x300; p++) {
        ib_rig_turn_to(&rig, p);
        uint32_t expected = p << 8 | (p >= 0x15 && p < 0x213 ? 8u : 0u);
        assert_int_equal(ib_rig_cycle(&rig, 0), expected);
    }
}

/* A command has to stand for param_cycles; whatever param_cycles is. */
static void answers_take_param_cycles(void **state)
{
    struct dg_ib_model model = *dg_ib_model_of(dg_device_find("ocd-ib-k3"));

    (void)state;
    for (uint8_t cycles = 1; cycles != 0; cycles++) {
        model.param_cycles = cycles;
        assert_int_equal(ib_rig_init(&rig, &model), DG_OK);
        assert_int_equal(ib_rig_power_on(&rig), DG_OK);
        for (int i = 0; i < cycles; i++) {
            assert_int_equal(ib_rig_cycle(&rig, 0x08000007), 0);
        }
        assert_int_equal(ib_rig_cycle(&rig, 0x08000007), 0xC8000007);
        assert_int_equal(ib_rig_release(&rig), 0);
    }
}

static void a_command_that_does_not_stand_is_dropped(void **state)
{
    (void)state;
    (void)ib_rig_cycle(&rig, 0x08000007);
    (void)ib_rig_cycle(&rig, 0x08000007);
    (void)ib_rig_cycle(&rig, 0x08000007);
    (void)ib_rig_cycle(&rig, 0x00000000); /* handled here: it stood for three cycles */
    assert_int_equal(rig.in, 0xC8000007);
    assert_int_equal(rig.device.preset, 7);
    (void)ib_rig_cycle(&rig, 0x08000009);
    (void)ib_rig_cycle(&rig, 0x08000009);
    assert_int_equal(ib_rig_send(&rig, 0), 0xC8000007);
    assert_int_equal(rig.device.preset, 7);
    assert_int_equal(rig.device.counters.dropped, 1);
    assert_int_equal(rig.device.counters.commands, 1);
}

/* The same word is executed again only after another one. */
static void a_standing_word_is_one_command(void **state)
{
    (void)state;
    for (int i = 0; i < 20; i++) {
        (void)ib_rig_cycle(&rig, 0x08000007);
    }
    assert_int_equal(rig.device.counters.commands, 1);
    (void)ib_rig_send(&rig, 0x00000000);
    (void)ib_rig_send(&rig, 0x08000007);
    assert_int_equal(rig.device.counters.commands, 2);
}

/* I2: only the edge of bit 31 releases. */
static void a_level_releases_nothing(void **state)
{
    (void)state;
    assert_int_equal(ib_rig_send(&rig, 0x08000007), 0xC8000007);
    assert_int_equal(ib_rig_send(&rig, 0x88000000), 0x84000000);
    assert_int_equal(ib_rig_send(&rig, 0x80000000), 0x84000000);
    assert_int_equal(rig.device.counters.releases_stale, 1);
    (void)ib_rig_cycle(&rig, 0);
    (void)ib_rig_cycle(&rig, 0x80000000);
    assert_int_equal(ib_rig_cycle(&rig, 0x80000000), 1000);
}

/* The command of a master that was faster than the self-test counts when that is over. */
static void a_release_that_stands_since_the_start_is_none(void **state)
{
    (void)state;
    assert_int_equal(dg_ib_power_on(&rig.device, rig.now), DG_OK);
    for (int i = 0; i < 99; i++) {
        assert_int_equal(ib_rig_cycle(&rig, 0x80000000), 0xA0000000);
    }
    assert_int_equal(ib_rig_cycle(&rig, 0x80000000), 1000);
    assert_int_equal(ib_rig_cycle(&rig, 0x80000000), 1000);
    assert_int_equal(rig.device.counters.releases_stale, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(chapter_5_3, set_up),
        cmocka_unit_test_setup(chapter_5_4_4, set_up),
        cmocka_unit_test(answers_take_param_cycles),
        cmocka_unit_test_setup(a_command_that_does_not_stand_is_dropped, set_up),
        cmocka_unit_test_setup(a_standing_word_is_one_command, set_up),
        cmocka_unit_test_setup(a_level_releases_nothing, set_up),
        cmocka_unit_test_setup(a_release_that_stands_since_the_start_is_none, set_up),
    };
    return cmocka_run_group_tests_name("the manual's examples", tests, NULL, NULL);
}

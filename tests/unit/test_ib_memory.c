/* SPDX-License-Identifier: MIT */
/*
 * The EEPROM: damage of every region, a memory that does not answer, and the power failing in
 * every write of every command that stores something.
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

#define IMAGE_MAX 1024u

/* Everything that is stored. */
struct sight {
    uint32_t lost;
    uint32_t in;
    uint8_t bytes[IMAGE_MAX];
};

static struct ib_rig rig;
static struct ib_rig lived_in;
static struct sight before;
static struct sight after;
static struct sight seen;

/* A device with a history, in cam mode, nothing as delivered. */
static int set_up(void **state)
{
    static const uint32_t history[] = {
        0x04000010, 0x02001234, 0x06000004, 0x0A000111, 0x08000222, 0x20800003,
        0x46000015, 0x66000213, 0x20400008, 0x20100004, 0x0A000333,
    };

    (void)state;
    if (ib_rig_init(&rig, dg_ib_model_of(dg_device_find("ocd-ib-k3"))) != DG_OK ||
        ib_rig_power_on(&rig) != DG_OK) {
        return -1;
    }
    ib_rig_turn_to(&rig, 123456);
    for (size_t i = 0; i < DG_COUNT(history); i++) {
        if (ib_rig_send(&rig, history[i]) >> 30 != 3) {
            return -1;
        }
    }
    (void)ib_rig_release(&rig);
    lived_in = rig;
    return 0;
}

static void look_at_encoder(struct sight *sight)
{
    uint16_t at = 0;

    memset(sight, 0, sizeof *sight);
    for (uint8_t i = 0; i < dg_ib_layout.region_count; i++) {
        const uint16_t size = dg_ib_layout.regions[i].size;
        assert_true(at + size <= IMAGE_MAX);
        assert_int_equal(dg_store_read(&rig.device.store, i, 0, &sight->bytes[at], size), DG_OK);
        at = (uint16_t)(at + size);
    }
    sight->lost = rig.device.lost;
    sight->in = ib_rig_cycle(&rig, 0);
}

static void restart(void)
{
    ram_nvm_restore(&rig.nvm);
    assert_int_equal(ib_rig_power_on(&rig), DG_OK);
}

static void layout_fits(void **state)
{
    uint32_t journal = 0;

    (void)state;
    assert_true(dg_store_size(&dg_ib_layout) <= RAM_NVM_MAX);
    for (uint8_t i = 0; i < dg_ib_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_ib_layout.regions[i];
        assert_true(region->size <= DG_STORE_CHECKED_MAX && region->check == DG_STORE_CHECKED);
        assert_int_equal(dg_store_find(&dg_ib_layout, region->name), i);
        assert_int_equal(region->startup_code, i == DG_IB_REGION_TIME ? 0 : 0x86);
        journal += i == DG_IB_REGION_TIME ? 0 : 6u + region->size;
    }
    assert_int_equal(dg_ib_layout.journal_size, journal);
}

/* Every default fills its region to the last byte and not beyond, whatever was there. */
static void defaults_fill_their_regions(void **state)
{
    (void)state;
    for (uint8_t i = 0; i < dg_ib_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_ib_layout.regions[i];
        uint8_t low[DG_STORE_CHECKED_MAX + 8];
        uint8_t high[DG_STORE_CHECKED_MAX + 8];
        memset(low, 0x00, sizeof low);
        memset(high, 0xFF, sizeof high);
        region->defaults(&rig.model, low);
        region->defaults(&rig.model, high);
        assert_memory_equal(low, high, region->size);
        for (size_t k = region->size; k < sizeof low; k++) {
            assert_true(low[k] == 0x00 && high[k] == 0xFF);
        }
    }
}

static void everything_survives(void **state)
{
    (void)state;
    look_at_encoder(&before);
    restart();
    look_at_encoder(&after);
    assert_memory_equal(&after, &before, sizeof before);
    assert_int_equal(ib_rig_send(&rig, 0x20210001), 0xA0001234);
    assert_int_equal(ib_rig_send(&rig, 0x20210002), 0xA0000010);
    assert_int_equal(ib_rig_send(&rig, 0x20210003), 0xA0000004);
    assert_int_equal(ib_rig_send(&rig, 0x20210004), 0xA0000222);
    assert_int_equal(ib_rig_send(&rig, 0x20210005), 0xA0000333);
    assert_int_equal(ib_rig_send(&rig, 0x20210006), 0xA0000001);
    assert_int_equal(ib_rig_send(&rig, 0x20210009), 0xA0000005);
}

static void damage(uint8_t region, uint32_t bit)
{
    rig.nvm.bytes[dg_store_address(&dg_ib_layout, region) + bit / 8] ^= (uint8_t)(1u << bit % 8);
}

/* I17: the words that set a lost region again; a cam program has to be entered first. */
static void send_again(uint8_t region)
{
    static const uint32_t words[] = {
        [DG_IB_REGION_STEPS] = 0x02001234,     [DG_IB_REGION_REVOLUTIONS] = 0x04000010,
        [DG_IB_REGION_DIRECTION] = 0x06000004, [DG_IB_REGION_PRESET] = 0x08000222,
        [DG_IB_REGION_SHIFT] = 0x0A000333,     [DG_IB_REGION_MODE] = 0x20800003,
        [DG_IB_REGION_SHIFT_IW] = 0x20100004,
    };

    if (region == DG_IB_REGION_SHIFT_IW) {
        (void)ib_rig_send(&rig, 0x20800003);
    }
    if (region >= DG_IB_REGION_CAMS) {
        (void)ib_rig_send(&rig, 0x20800001u + region - DG_IB_REGION_CAMS);
        assert_int_equal(ib_rig_send(&rig, 0x20200000), 0xA0000000); /* it is empty */
        assert_int_equal(ib_rig_send(&rig, 0x46000015), 0xC6000015);
        return;
    }
    assert_int_equal(ib_rig_send(&rig, words[region]), words[region] | 0xC0000000);
    (void)ib_rig_release(&rig); /* a pair waits for it */
}

static void damage_is_told_until_mended(void **state)
{
    (void)state;
    for (uint8_t region = 0; region < DG_IB_REGION_TIME; region++) {
        const uint32_t bits = 8u * (dg_ib_layout.regions[region].size + 2u); /* the sum, too */
        for (uint32_t bit = 0; bit < bits; bit++) {
            rig = lived_in;
            damage(region, bit);
            restart();
            assert_int_equal(rig.device.lost >> region & 1, 1);
            assert_int_equal(ib_rig_cycle(&rig, 0), 0x86000000);
            assert_int_equal(ib_rig_release(&rig), 0x86000000);
            if (bit % 2 == 0) {
                assert_int_equal(ib_rig_send(&rig, 0x0E000000), 0xCE000000);
            } else {
                send_again(region);
                if (rig.device.lost != 0) { /* steps that do not fit lost revolutions */
                    assert_int_equal(region, DG_IB_REGION_REVOLUTIONS);
                    send_again(DG_IB_REGION_STEPS);
                }
            }
            assert_int_equal(rig.device.lost, 0);
            assert_int_not_equal(ib_rig_release(&rig), 0x86000000);
            restart();
            assert_int_equal(rig.device.lost, 0);
        }
    }
}

static void several_lost_ones_all_have_to_be_sent(void **state)
{
    (void)state;
    damage(DG_IB_REGION_STEPS, 0);
    damage(DG_IB_REGION_SHIFT, 0);
    damage(DG_IB_REGION_PRESET, 0);
    restart();
    send_again(DG_IB_REGION_PRESET);
    assert_int_equal(ib_rig_release(&rig), 0x86000000);
    send_again(DG_IB_REGION_STEPS);
    assert_int_equal(ib_rig_release(&rig), 0x86000000);
    send_again(DG_IB_REGION_SHIFT);
    assert_int_not_equal(ib_rig_release(&rig), 0x86000000);
}

/* Defaults are the profile's: cams and mode stay, unless they were lost. */
static void defaults(void **state)
{
    (void)state;
    assert_int_equal(ib_rig_send(&rig, 0x0E000000), 0xCE000000);
    assert_int_equal(rig.device.mode, DG_IB_CAM + 3);
    assert_int_equal(rig.device.program.on[3], 0x15);
    assert_int_equal(rig.device.shift_iw, 4);
    assert_int_equal(ib_rig_send(&rig, 0x20800000), 0xE0800000);
    assert_int_equal(ib_rig_release(&rig), 123456);
    assert_int_equal(ib_rig_send(&rig, 0x20210006), 0xA0000000);
}

/* The operating time cannot be sent again: it begins anew, and nothing is said. */
static void a_damaged_time_is_no_error(void **state)
{
    (void)state;
    const uint32_t in = ib_rig_cycle(&rig, 0);
    damage(DG_IB_REGION_TIME, 3);
    restart();
    assert_int_equal(ib_rig_cycle(&rig, 0), in);
}

/* Bytes that have their sum but that no command stores. */
static void impossible_values_are_lost(void **state)
{
    static const struct {
        uint8_t region;
        uint8_t n;
        uint8_t bytes[4];
    } values[] = {
        {DG_IB_REGION_STEPS, 4, {0, 0, 0, 0}}, /* with steps-1 it would be one */
        {DG_IB_REGION_STEPS, 4, {0, 1, 0, 1}},
        {DG_IB_REGION_REVOLUTIONS, 4, {0, 0, 0, 0}},
        {DG_IB_REGION_REVOLUTIONS, 4, {0, 0, 16, 1}},
        {DG_IB_REGION_DIRECTION, 1, {2}},
        {DG_IB_REGION_DIRECTION, 1, {5}},
        {DG_IB_REGION_MODE, 1, {0}},
        {DG_IB_REGION_MODE, 1, {11}},
        {DG_IB_REGION_SHIFT_IW, 1, {26}},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(values); i++) {
        rig = lived_in;
        rig.model.steps_minus_one = i == 0;
        assert_int_equal(
            dg_store_put(&rig.device.store, values[i].region, 0, values[i].bytes, values[i].n),
            DG_OK);
        restart();
        assert_int_equal(rig.device.lost >> values[i].region & 1, 1);
        assert_int_equal(ib_rig_cycle(&rig, 0), 0x86000000);
    }
}

/* Every command that stores; the presets act in position mode, the release on what waits for it. */
static uint32_t commands[] = {
    0x80000000, 0x06000003, 0x08000005, 0x0A000005, 0x0E000000, 0x20800000, 0x20800005,
    0x204000FF, 0x20100000, 0x40000000, 0x6E000123, 0x40000001, 0x60000000,
};
#define COMMANDS DG_COUNT(commands)

static bool in_position_mode(uint32_t word)
{
    return word == 0x40000000 || word == 0x60000000;
}

static void enter_mode_of(uint32_t word)
{
    rig = lived_in;
    if (in_position_mode(word)) {
        (void)ib_rig_send(&rig, 0x20800000);
        (void)ib_rig_release(&rig);
    }
}

/* I22: nothing of this is stored before the release. */
static void prepare(uint32_t word)
{
    static const uint32_t waiting[] = {0x02000005, 0x04000011, 0x08000005, 0x0A000007};
    const uint32_t writes = rig.nvm.writes;

    for (size_t i = 0; word == 0x80000000 && i < DG_COUNT(waiting); i++) {
        assert_int_equal(ib_rig_send(&rig, waiting[i]), waiting[i] | 0xC0000000);
    }
    assert_int_equal(rig.nvm.writes, writes);
}

/* Whether the device said that it was done. */
static bool done(uint32_t word)
{
    const uint32_t in = ib_rig_send(&rig, word);

    if (word == 0x80000000) {
        return in >> 31 == 0;
    }
    return in_position_mode(word) ? in == 0x222 : in == (word | 0xC0000000);
}

static void a_silent_memory(void **state)
{
    (void)state;
    for (size_t i = 0; i < COMMANDS; i++) {
        for (int how = 0; how < 2; how++) {
            enter_mode_of(commands[i]);
            look_at_encoder(&before);
            prepare(commands[i]);
            rig.nvm.no_acknowledge = how == 0;
            rig.world.eeprom_acknowledges = how == 0;
            assert_int_equal(ib_rig_send(&rig, commands[i]), 0x86000000);
            assert_int_equal(rig.device.last_error, 0x86000000);
            rig.nvm.no_acknowledge = false;
            rig.world.eeprom_acknowledges = true;
            assert_int_equal(ib_rig_cycle(&rig, 0), 0x86000000);
            assert_int_equal(ib_rig_release(&rig), before.in); /* the old values are in force */
            look_at_encoder(&after);
            assert_memory_equal(&after, &before, sizeof before);
        }
    }
}

static void a_memory_that_is_silent_at_power_on(void **state)
{
    (void)state;
    look_at_encoder(&before);
    for (int how = 0; how < 2; how++) {
        rig.nvm.no_acknowledge = how == 0;
        rig.world.eeprom_acknowledges = how == 0;
        assert_int_equal(ib_rig_power_on(&rig), DG_OK);
        assert_int_equal(ib_rig_cycle(&rig, 0), 0x86000000);
        rig.nvm.no_acknowledge = false;
        rig.world.eeprom_acknowledges = true;
        assert_int_equal(ib_rig_send(&rig, 0x0E000000), 0x86000000);
        restart();
        look_at_encoder(&after);
        assert_memory_equal(&after, &before, sizeof before);
    }
}

/* What moved while 60000000h stood could not be stored when it ended. */
static void a_preset_that_cannot_be_kept(void **state)
{
    (void)state;
    enter_mode_of(0x60000000);
    (void)ib_rig_send(&rig, 0x60000000);
    rig.world.eeprom_acknowledges = false;
    assert_int_equal(rig.device.last_error, 0);
    (void)ib_rig_cycle(&rig, 0);
    assert_int_equal(ib_rig_cycle(&rig, 0), 0x86000000);
    assert_int_equal(rig.device.last_error, 0x86000000);
    assert_int_equal(rig.device.counters.refused, 1);
}

static void foreign_memories(void **state)
{
    (void)state;
    memset(rig.nvm.bytes, 0xFF, sizeof rig.nvm.bytes);
    assert_int_equal(dg_ib_power_on(&rig.device, 0), DG_ERR_BLANK);
    assert_false(rig.device.powered);
    memset(rig.nvm.bytes, 0x5A, sizeof rig.nvm.bytes);
    assert_int_equal(dg_ib_power_on(&rig.device, 0), DG_ERR_FOREIGN);
    assert_false(rig.device.powered);
}

static void cut(uint32_t word, uint32_t write, enum ram_nvm_tear tear, uint32_t tear_at)
{
    enter_mode_of(word);
    prepare(word);
    ram_nvm_cut(&rig.nvm, write, tear, tear_at);
    const bool answered = done(word);
    assert_true(rig.nvm.dead);
    restart();
    look_at_encoder(&seen);
    const struct sight *expected = memcmp(&seen, &after, sizeof seen) == 0 ? &after : &before;
    assert_memory_equal(&seen, expected, sizeof seen);
    assert_true(!answered || expected == &after);
}

static void is_stored_whole_or_not_at_all(void **state)
{
    static const uint32_t tears[] = {0, 1, 2, 5, 9, 31, 64};
    const uint32_t word = *(const uint32_t *)*state;

    enter_mode_of(word);
    restart();
    look_at_encoder(&before);
    enter_mode_of(word);
    prepare(word);
    const uint32_t writes_before = rig.nvm.writes;
    assert_true(done(word));
    const uint32_t writes = rig.nvm.writes - writes_before;
    assert_true(writes > 0);
    restart();
    look_at_encoder(&after);
    assert_memory_not_equal(&after, &before, sizeof before);
    for (uint32_t write = 0; write < writes; write++) {
        for (int tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
            for (size_t i = 0; i < DG_COUNT(tears); i++) {
                cut(word, write, (enum ram_nvm_tear)tear, tears[i]);
            }
        }
    }
}

/* Padding, too, or a device is not the same bytes twice. */
static void a_program_is_all_its_bytes(void **state)
{
    struct dg_ib_program programs[2];
    (void)state;

    memset(&programs[0], 0x55, sizeof programs[0]);
    memset(&programs[1], 0xAA, sizeof programs[1]);
    dg_ib_load_program(&rig.device, 3, &programs[0]);
    dg_ib_load_program(&rig.device, 3, &programs[1]);
    assert_memory_equal(&programs[0], &programs[1], sizeof programs[0]);
}

/* 0E000000h that failed leaves nothing behind for the next one. */
static void defaults_after_a_failure(void **state)
{
    (void)state;
    assert_int_equal(ib_rig_send(&rig, 0x0E000000), 0xCE000000);
    look_at_encoder(&after);
    rig = lived_in;
    for (int times = 0; times < 3; times++) {
        rig.nvm.no_acknowledge = true;
        assert_int_equal(ib_rig_send(&rig, 0x0E000000), 0x86000000);
        rig.nvm.no_acknowledge = false;
        (void)ib_rig_release(&rig);
    }
    assert_int_equal(ib_rig_send(&rig, 0x0E000000), 0xCE000000);
    look_at_encoder(&seen);
    assert_memory_equal(seen.bytes, after.bytes, sizeof after.bytes);
    restart();
    look_at_encoder(&seen);
    assert_memory_equal(seen.bytes, after.bytes, sizeof after.bytes);
}

/* 80000000h likewise. */
static void release_after_a_failure(void **state)
{
    (void)state;
    enter_mode_of(0x80000000);
    for (int times = 0; times < 3; times++) {
        prepare(0x80000000);
        rig.nvm.no_acknowledge = true;
        assert_int_equal(ib_rig_send(&rig, 0x80000000), 0x86000000);
        rig.nvm.no_acknowledge = false;
        (void)ib_rig_release(&rig);
    }
    prepare(0x80000000);
    assert_true(done(0x80000000));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layout_fits),
        cmocka_unit_test_setup(defaults_fill_their_regions, set_up),
        cmocka_unit_test_setup(everything_survives, set_up),
        cmocka_unit_test_setup(damage_is_told_until_mended, set_up),
        cmocka_unit_test_setup(several_lost_ones_all_have_to_be_sent, set_up),
        cmocka_unit_test_setup(defaults, set_up),
        cmocka_unit_test_setup(a_damaged_time_is_no_error, set_up),
        cmocka_unit_test_setup(impossible_values_are_lost, set_up),
        cmocka_unit_test_setup(a_silent_memory, set_up),
        cmocka_unit_test_setup(a_memory_that_is_silent_at_power_on, set_up),
        cmocka_unit_test_setup(a_preset_that_cannot_be_kept, set_up),
        cmocka_unit_test_setup(foreign_memories, set_up),
        cmocka_unit_test_setup(a_program_is_all_its_bytes, set_up),
        cmocka_unit_test_setup(defaults_after_a_failure, set_up),
        cmocka_unit_test_setup(release_after_a_failure, set_up),
    };
    struct CMUnitTest sweep[COMMANDS];
    char names[COMMANDS][9];

    for (size_t i = 0; i < COMMANDS; i++) {
        for (size_t k = 0; k < 8; k++) {
            names[i][k] = "0123456789ABCDEF"[commands[i] >> (28 - 4 * k) & 0xF];
        }
        names[i][8] = '\0';
        sweep[i] = (struct CMUnitTest){.name = names[i],
                                       .test_func = is_stored_whole_or_not_at_all,
                                       .initial_state = &commands[i]};
    }
    const int failed = cmocka_run_group_tests_name("memory of an OCD INTERBUS", tests, NULL, NULL);
    return failed + cmocka_run_group_tests_name("power cut in", sweep, set_up, NULL);
}

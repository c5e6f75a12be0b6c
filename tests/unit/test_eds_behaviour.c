/* SPDX-License-Identifier: MIT */
/*
 * Encoders of EDS files behave as the encoder profile (CiA 406) has it: one with the objects of an
 * f3668 and another vendor-ID answers as an f3668 does, and one with other figures by these.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "eds_rig.h"

#define TPDO1 0x1BF
#define START 0x01
#define SAVE 0x65766173u

static struct eds_rig rig;
static struct co_rig kuebler;

/* ------------------------------------------------------------ a twin of another maker */

static struct {
    char text[65536];
    size_t n;
} file;

static void append(void *ctx, const char *text, size_t n)
{
    (void)ctx;
    assert_true(n < sizeof file.text - file.n);
    memcpy(&file.text[file.n], text, n);
    file.n += n;
    file.text[file.n] = '\0';
}

/* The EDS file of an f3668 with vendor-ID 14h in place of 13h. */
static void start_both(void)
{
    file.n = 0;
    dg_co_eds(dg_cia406_sheet_of(&dg_f3668), append, NULL);
    char *at = strstr(file.text, "[1018sub1]");
    assert_non_null(at);
    at = strstr(at, "DefaultValue=0x13");
    assert_non_null(at);
    at[strlen("DefaultValue=0x1")] = '4';
    eds_rig_start(&rig, file.text);
    co_rig_start(&kuebler);
    assert_ptr_not_equal(rig.file.file.base, kuebler.model->device);
}

static void move_both(const struct dg_motion *motion)
{
    rig.co.motion = *motion;
    kuebler.motion = *motion;
}

static void run_both(dg_ns span)
{
    co_rig_run(&rig.co, span);
    co_rig_run(&kuebler, span);
}

static void expect_alike(unsigned step)
{
    static const uint32_t keys[] = {
        DG_CO_KEY(0x6000, 0), DG_CO_KEY(0x6001, 0), DG_CO_KEY(0x6002, 0), DG_CO_KEY(0x6003, 0),
        DG_CO_KEY(0x6004, 0), DG_CO_KEY(0x6030, 1), DG_CO_KEY(0x6031, 1), DG_CO_KEY(0x6031, 2),
        DG_CO_KEY(0x6031, 3), DG_CO_KEY(0x6031, 4), DG_CO_KEY(0x6040, 1), DG_CO_KEY(0x6200, 0),
        DG_CO_KEY(0x6400, 1), DG_CO_KEY(0x6401, 1), DG_CO_KEY(0x6401, 2), DG_CO_KEY(0x6402, 1),
        DG_CO_KEY(0x6402, 2), DG_CO_KEY(0x6500, 0), DG_CO_KEY(0x6501, 0), DG_CO_KEY(0x6502, 0),
        DG_CO_KEY(0x6503, 0), DG_CO_KEY(0x6504, 0), DG_CO_KEY(0x6505, 0), DG_CO_KEY(0x6508, 0),
        DG_CO_KEY(0x6509, 0), DG_CO_KEY(0x650B, 0), DG_CO_KEY(0x1800, 5), DG_CO_KEY(0x1001, 0),
    };

    for (size_t i = 0; i < DG_COUNT(keys); i++) {
        const uint16_t index = (uint16_t)(keys[i] >> 16);
        const uint8_t sub = (uint8_t)(keys[i] >> 8);
        const uint32_t got = co_rig_get(&rig.co, index, sub);
        const uint32_t wanted = co_rig_get(&kuebler, index, sub);
        if (got != wanted) {
            fail_msg("step %u: %04X:%u is %08X, and %08X of an f3668", step, (unsigned)index,
                     (unsigned)sub, (unsigned)got, (unsigned)wanted);
        }
    }
}

static const struct {
    uint16_t index;
    uint8_t sub;
    uint8_t size;
    uint32_t value;
} requests[] = {
    {0x6003, 0, 4, 1000},       {0x6401, 1, 4, 500},     {0x6402, 1, 4, 2000},
    {0x6401, 2, 4, 300000},     {0x6402, 2, 4, 400000},  {0x6003, 0, 4, 350000},
    {0x6003, 0, 4, 0x10000000}, {0x6002, 0, 4, 36000},   {0x6001, 0, 4, 3600},
    {0x6000, 0, 2, 4},          {0x6003, 0, 4, 35999},   {0x6003, 0, 4, 36000},
    {0x6000, 0, 2, 5},          {0x6003, 0, 4, 20000},   {0x6031, 2, 2, 10},
    {0x6031, 2, 2, 0},          {0x6031, 2, 2, 200},     {0x6031, 1, 2, 1},
    {0x6031, 3, 2, 7},          {0x6031, 4, 2, 3},       {0x6200, 0, 2, 20},
    {0x1800, 5, 2, 30},         {0x6000, 0, 2, 1},       {0x6003, 0, 4, 5},
    {0x6000, 0, 2, 0},          {0x6004, 0, 4, 0},       {0x6509, 0, 4, 0},
    {0x6500, 0, 2, 0},          {0x6001, 0, 4, 0x20000}, {0x6002, 0, 4, 0x20000000},
};

/* The shaft turns while a master sets up all that the profile has. */
static void it_answers_as_an_f3668_does(void **state)
{
    const struct dg_motion motion = {
        .kind = DG_MOTION_SPEED, .start = DG_S(1), .from = DG_TURN / 3, .mrpm = 1234567};
    (void)state;
    start_both();
    move_both(&motion);
    for (unsigned i = 0; i < DG_COUNT(requests); i++) {
        const uint16_t index = requests[i].index;
        const uint8_t sub = requests[i].sub;
        run_both(DG_MS(50));
        const uint32_t got = co_rig_write(&rig.co, index, sub, requests[i].value, requests[i].size);
        const uint32_t wanted =
            co_rig_write(&kuebler, index, sub, requests[i].value, requests[i].size);
        if (got != wanted) {
            fail_msg("request %u: %08X, and %08X of an f3668", i, (unsigned)got, (unsigned)wanted);
        }
        expect_alike(i);
    }
}

/* Counterclockwise the first position of all is 0, too. */
static void standing_at_its_zero_it_says_so_in_both_directions(void **state)
{
    const struct dg_motion still = {.kind = DG_MOTION_STANDSTILL};
    (void)state;
    start_both();
    move_both(&still);
    for (uint32_t direction = 0; direction <= 1; direction++) {
        co_rig_put(&rig.co, 0x6000, 0, direction, 2);
        assert_int_equal(co_rig_get(&rig.co, 0x6004, 0), 0);
    }
}

static void its_areas_end_where_those_of_an_f3668_end(void **state)
{
    static const int64_t positions[] = {499, 500, 2000, 2001, 299999, 300000, 400000, 400001};
    static const uint32_t limits[4] = {500, 2000, 300000, 400000};
    struct dg_motion motion = {.kind = DG_MOTION_STANDSTILL};
    (void)state;
    start_both();
    for (uint8_t i = 0; i < 4; i++) {
        const uint16_t index = i % 2u == 0 ? 0x6401 : 0x6402;
        co_rig_put(&rig.co, index, i / 2u + 1u, limits[i], 4);
        co_rig_put(&kuebler, index, i / 2u + 1u, limits[i], 4);
    }
    for (unsigned i = 0; i < DG_COUNT(positions); i++) {
        motion.from = dg_angle_of_counts(positions[i], DG_CIA406_STEPS);
        move_both(&motion);
        assert_int_equal(co_rig_get(&rig.co, 0x6004, 0), positions[i]);
        expect_alike(i);
    }
}

/* 6200h and 1800h:5 are one timer: TPDO1 comes as often as the later one of them says. */
static void its_timer_sends_when_that_of_an_f3668_does(void **state)
{
    const struct dg_motion motion = {.kind = DG_MOTION_SPEED, .start = DG_S(1), .mrpm = 60000};
    (void)state;
    start_both();
    move_both(&motion);
    for (unsigned i = 0; i < 2; i++) {
        struct co_rig *self = i == 0 ? &rig.co : &kuebler;
        co_rig_put(self, 0x1800, 2, 254, 1);
        co_rig_put(self, 0x1800, 5, 70, 2);
        co_rig_put(self, 0x6200, 0, 20, 2);
        assert_int_equal(co_rig_get(self, 0x1800, 5), 20);
        co_rig_nmt(self, START);
        co_rig_run(self, DG_MS(90));
        co_rig_forget(self);
        co_rig_run(self, DG_MS(100));
        assert_int_equal(self->count, 5);
    }
    for (uint32_t i = 0; i < kuebler.count; i++) {
        assert_int_equal(rig.co.frame[i].id, TPDO1);
        assert_true(rig.co.at[i] == kuebler.at[i]);
        assert_memory_equal(rig.co.frame[i].data, kuebler.frame[i].data, 8);
    }
}

/* Alarms and warnings, but for the temperature, whose limits are Kuebler's own objects. */
static void its_alarms_and_warnings_are_those_of_an_f3668(void **state)
{
    const struct dg_motion fast = {.kind = DG_MOTION_SPEED, .start = DG_S(1), .mrpm = 12200000};
    static struct dg_world broken[4];
    (void)state;
    start_both();
    for (size_t i = 0; i < DG_COUNT(broken); i++) {
        broken[i] = kuebler.world;
    }
    broken[0].singleturn_ok = false;
    broken[1].battery_mv = 2000;
    broken[2].watchdog_fired = true;
    broken[3].multiturn_sync_ok = false;
    for (unsigned i = 0; i < DG_COUNT(broken); i++) {
        struct dg_world *worlds[] = {&rig.co.world, &kuebler.world};
        for (unsigned j = 0; j < 2; j++) {
            worlds[j]->singleturn_ok = broken[i].singleturn_ok;
            worlds[j]->battery_mv = broken[i].battery_mv;
            worlds[j]->watchdog_fired = broken[i].watchdog_fired;
            worlds[j]->multiturn_sync_ok = broken[i].multiturn_sync_ok;
        }
        run_both(DG_MS(200));
        expect_alike(i);
        assert_true(co_rig_get(&rig.co, 0x6503, 0) + co_rig_get(&rig.co, 0x6505, 0) != 0);
    }
    move_both(&fast);
    run_both(DG_S(1));
    expect_alike(99);
}

static void its_operating_time_goes_on_after_a_power_cycle(void **state)
{
    (void)state;
    start_both();
    rig.co.now += DG_S(720);
    kuebler.now += DG_S(720);
    run_both(DG_MS(1));
    assert_int_equal(co_rig_get(&rig.co, 0x6508, 0), 2);
    expect_alike(0);
    eds_rig_power_cycle(&rig);
    assert_int_equal(co_rig_get(&rig.co, 0x6508, 0), 2);
}

/* 6000h is as it was written, also the bits of other makers, which do nothing here; so is 6500h. */
static void bits_of_a_manufacturer_are_kept(void **state)
{
    (void)state;
    start_both();
    co_rig_put(&rig.co, 0x6000, 0, 0xF000, 2);
    assert_int_equal(co_rig_get(&rig.co, 0x6000, 0), 0xF000);
    assert_int_equal(co_rig_get(&rig.co, 0x6500, 0), 0xF000);
    co_rig_put(&rig.co, 0x1010, 1, SAVE, 4);
    eds_rig_power_cycle(&rig);
    assert_int_equal(co_rig_get(&rig.co, 0x6500, 0), 0xF000);
    co_rig_run(&rig.co, DG_S(1));
    assert_int_equal(rig.co.node.state, DG_CO_PRE_OPERATIONAL); /* bit 14 is Kuebler's */
}

/* ------------------------------------------------------------ speed and acceleration */

/* 3600 steps, 4096 turns; speed in 32 bits, windows up to 1 s. */
#define TYPE "[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x20196\n"
#define OBJECTS                                                                                    \
    "[6000]\nDataType=6\nAccessType=rw\nDefaultValue=0\n"                                          \
    "[6004]\nDataType=7\nAccessType=ro\n"                                                          \
    "[6030]\nObjectType=8\n[6030sub1]\nDataType=4\nAccessType=ro\n"                                \
    "[6040]\nObjectType=8\n[6040sub1]\nDataType=3\nAccessType=ro\n"                                \
    "[6502]\nDataType=7\nAccessType=ro\nDefaultValue=256\n"
#define WINDOW(ms)                                                                                 \
    "[6031]\nObjectType=8\n[6031sub2]\nDataType=6\nAccessType=rw\nDefaultValue=" ms "\n"
#define STEPS(n) "[6501]\nDataType=7\nAccessType=ro\nDefaultValue=" n "\n"

static void turn_at(int32_t mrpm)
{
    const struct dg_motion motion = {.kind = DG_MOTION_SPEED, .start = rig.co.now, .mrpm = mrpm};

    rig.co.motion = motion;
    co_rig_run(&rig.co, DG_S(3));
}

static void speed_in_32_bits_is_steps_a_second(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE OBJECTS STEPS("3600") WINDOW("100"));
    turn_at(60000);
    assert_in_range(co_rig_get(&rig.co, 0x6030, 1), 3599, 3601);
    turn_at(-60000);
    assert_in_range(0u - co_rig_get(&rig.co, 0x6030, 1), 3599, 3601);
    co_rig_put(&rig.co, 0x6000, 0, DG_CIA406_CCW, 2);
    assert_in_range(co_rig_get(&rig.co, 0x6030, 1), 3599, 3601);
}

/* A window of 0 ms would have no speed: it counts as 1 ms, so that a millisecond tells all. */
static void a_window_of_nothing_is_one_millisecond(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE OBJECTS STEPS("65536") WINDOW("0"));
    turn_at(0);
    const struct dg_motion motion = {
        .kind = DG_MOTION_SPEED, .start = rig.co.now, .from = DG_TURN / 3, .mrpm = 60000};
    rig.co.motion = motion;
    co_rig_run(&rig.co, DG_MS(3) / 2);
    assert_in_range(co_rig_get(&rig.co, 0x6030, 1), 65000, 66000);
}

/* 2^24 steps at 1000 turns/s are more than 2^31 a second. */
static void speed_that_does_not_fit_is_the_highest_one(void **state)
{
    static const int32_t speeds[] = {60000000, DG_MOTION_SPEED_MAX_MRPM};
    (void)state;
    eds_rig_start(&rig, TYPE OBJECTS STEPS("16777216") WINDOW("1000"));
    for (size_t i = 0; i < DG_COUNT(speeds); i++) {
        turn_at(speeds[i]);
        assert_int_equal(co_rig_get(&rig.co, 0x6030, 1), INT32_MAX);
        turn_at(-speeds[i]);
        assert_int_equal(co_rig_get(&rig.co, 0x6030, 1), (uint32_t)INT32_MIN);
    }
}

/* A jump by more turns than a shaft can make in a window. */
static void a_jump_is_the_highest_speed(void **state)
{
    static const struct dg_motion_point forth[] = {{0, 0}, {1, 100000 * DG_TURN}};
    static const struct dg_motion_point back[] = {{0, 0}, {1, -100000 * DG_TURN}};
    (void)state;
    eds_rig_start(&rig, TYPE OBJECTS STEPS("16777216") WINDOW("1000"));
    for (size_t i = 0; i < 2; i++) {
        rig.co.motion = (struct dg_motion){.kind = DG_MOTION_REPLAY,
                                           .start = rig.co.now,
                                           .points = i == 0 ? forth : back,
                                           .point_count = 2};
        co_rig_run(&rig.co, DG_MS(10));
        assert_int_equal(co_rig_get(&rig.co, 0x6030, 1),
                         (uint32_t)(i == 0 ? INT32_MAX : INT32_MIN));
        co_rig_run(&rig.co, DG_S(2));
        assert_int_equal(co_rig_get(&rig.co, 0x6030, 1), 0);
    }
}

static void windows_are_1_to_1000_ms(void **state)
{
    static const uint16_t refused[] = {0, 1001, 65535};
    (void)state;
    eds_rig_start(&rig, TYPE OBJECTS STEPS("3600") WINDOW("1000"));
    for (size_t i = 0; i < DG_COUNT(refused); i++) {
        assert_int_equal(co_rig_write(&rig.co, 0x6031, 2, refused[i], 2), DG_CO_RANGE);
    }
    co_rig_put(&rig.co, 0x6031, 2, 1, 2);
    co_rig_put(&rig.co, 0x6031, 2, 1000, 2);
    assert_int_equal(co_rig_get(&rig.co, 0x6031, 2), 1000);
}

/* Some files say 0, for as short as it can be. */
static void a_window_of_0_ms_in_the_file_is_one_of_1_ms(void **state)
{
    (void)state;
    eds_rig_start(&rig, TYPE OBJECTS STEPS("65536") WINDOW("0"));
    turn_at(60000);
    assert_int_equal(co_rig_get(&rig.co, 0x6031, 2), 0);
    assert_in_range(co_rig_get(&rig.co, 0x6030, 1), 65000, 66000);
}

/* From rest to 600 rpm within 10 s: 60 rpm/s, whatever the window. */
static void acceleration_is_the_same_in_every_window(void **state)
{
    static const uint16_t windows_ms[] = {100, 255, 256, 500, 1000};
    (void)state;
    eds_rig_start(&rig, TYPE OBJECTS STEPS("3600") WINDOW("100"));
    rig.co.motion = (struct dg_motion){.kind = DG_MOTION_RAMP,
                                       .start = rig.co.now,
                                       .mrpm = 600000,
                                       .accel = DG_S(10),
                                       .hold = DG_NEVER};
    co_rig_run(&rig.co, DG_S(5));
    for (size_t i = 0; i < DG_COUNT(windows_ms); i++) {
        co_rig_put(&rig.co, 0x6031, 2, windows_ms[i], 2);
        assert_in_range(co_rig_get(&rig.co, 0x6040, 1), 59, 61);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_answers_as_an_f3668_does),
        cmocka_unit_test(standing_at_its_zero_it_says_so_in_both_directions),
        cmocka_unit_test(its_areas_end_where_those_of_an_f3668_end),
        cmocka_unit_test(its_timer_sends_when_that_of_an_f3668_does),
        cmocka_unit_test(its_alarms_and_warnings_are_those_of_an_f3668),
        cmocka_unit_test(its_operating_time_goes_on_after_a_power_cycle),
        cmocka_unit_test(bits_of_a_manufacturer_are_kept),
        cmocka_unit_test(speed_in_32_bits_is_steps_a_second),
        cmocka_unit_test(a_window_of_nothing_is_one_millisecond),
        cmocka_unit_test(speed_that_does_not_fit_is_the_highest_one),
        cmocka_unit_test(a_jump_is_the_highest_speed),
        cmocka_unit_test(windows_are_1_to_1000_ms),
        cmocka_unit_test(a_window_of_0_ms_in_the_file_is_one_of_1_ms),
        cmocka_unit_test(acceleration_is_the_same_in_every_window),
    };
    return cmocka_run_group_tests_name("eds_behaviour", tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * Universal scaling function (manual chapters 20-26; C26): 6004h is floor(x * MUR / 65536) mod TMR,
 * x counted since the preset without bound, whatever the shaft does.
 *
 * By default a sample of the walks; with --full 10^9 turns.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "co_rig.h"
#include "drehgeber/bits.h"

#define CCW 0x0001u
#define SCALING 0x0004u
#define USF 0x1000u
#define UNITS_PER_S 0x2000u
#define LED_FLASH DG_S(3)
#define SAVE 0x65766173u
#define EMCY 0x0BF
#define RESET_NODE 0x81
#define LOOK DG_MS(100)
#define TURNS 4096
#define STEPS ((int64_t)DG_CIA406_STEPS)
#define QUARTER (TURNS / 4 * STEPS)
#define SAMPLE_TURNS 30000000
#define FULL_TURNS 1000000000

/* x * MUR has no type of the language for every x. */
__extension__ typedef __int128 wide;

static struct co_rig rig;
static uint64_t noise;
static int64_t walk_turns = SAMPLE_TURNS;

/* The line the position must follow: y0 / 65536 units where the shaft was at c0. */
static struct {
    wide y0;
    int64_t c0;
    int64_t c; /* where the shaft is */
    uint32_t parameters;
    uint32_t mur;
    uint32_t tmr;
} line;

static uint64_t any(void)
{
    noise ^= noise << 13;
    noise ^= noise >> 7;
    noise ^= noise << 17;
    return noise;
}

static int64_t any_in(int64_t first, int64_t last)
{
    return first + (int64_t)(any() % (uint64_t)(last - first + 1));
}

static void turn_to(int64_t counts)
{
    line.c = counts;
    /* Anywhere inside of the count. */
    rig.motion.from = dg_angle_of_counts(counts, DG_CIA406_STEPS) + any_in(0, DG_TURN / STEPS - 1);
}

static int setup(void **state)
{
    (void)state;
    noise = 0x9E3779B97F4A7C15u;
    memset(&line, 0, sizeof line);
    co_rig_start(&rig);
    return 0;
}

/* ------------------------------------------------------------ the model */

static wide y_of(int64_t counts)
{
    int64_t way = counts - line.c0;

    return line.y0 + (wide)((line.parameters & CCW) != 0 ? -way : way) * line.mur;
}

static uint32_t wanted(void)
{
    wide range = (wide)line.tmr * DG_CIA406_STEPS;
    wide y = y_of(line.c) % range;

    return (uint32_t)((y < 0 ? y + range : y) / DG_CIA406_STEPS);
}

static void check(void)
{
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), wanted());
}

/* The line goes on from here with other settings. */
static void rebase(void)
{
    line.y0 = y_of(line.c);
    line.c0 = line.c;
}

/* Chapter 22: scaling, 6000h, preset; kept by 1010h. */
static void activate(uint32_t mur, uint32_t tmr, uint32_t preset, uint32_t parameters)
{
    co_rig_put(&rig, 0x6000, 0, 0, 2);
    co_rig_put(&rig, 0x6001, 0, mur, 4);
    co_rig_put(&rig, 0x6002, 0, tmr, 4);
    co_rig_put(&rig, 0x6000, 0, USF | SCALING | parameters, 2);
    co_rig_put(&rig, 0x6003, 0, preset, 4);
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    line.y0 = (wide)preset * DG_CIA406_STEPS;
    line.c0 = line.c;
    line.parameters = USF | SCALING | parameters;
    line.mur = mur;
    line.tmr = tmr;
    check();
}

/* What chapter 22 allows; TMR * 65536 / MUR is whole for one in four. */
static void activate_any(void)
{
    uint32_t mur = 1u + (uint32_t)(any() % DG_CIA406_STEPS);
    uint64_t below = (uint64_t)TURNS * mur; /* four times TMR stays below it */
    uint32_t most = (uint32_t)((below - 1) / 4);
    uint32_t tmr = 1u + (uint32_t)(any() % most);

    if (any() % 4 == 0) {
        mur = 1u << any() % 17u;
        tmr = mur * (uint32_t)(1u + any() % (TURNS / 4 - 1));
    }
    activate(mur, tmr, (uint32_t)(any() % tmr), any() % 2 != 0 ? CCW : 0);
}

/* ------------------------------------------------------------ what happens on the way */

static void power_cycle(int64_t moved_meanwhile)
{
    dg_co_power_off(&rig.node);
    turn_to(line.c + moved_meanwhile);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
}

/* Any way the shaft can go between two looks of the supervision; turns gone. */
static int64_t jump(int64_t bias)
{
    int64_t way = any_in(-QUARTER + 1, QUARTER - 1);

    if (any() % 8 == 0) {
        way = any_in(-3, 3);
    } else if (any() % 8 != 0 && bias != 0) {
        way = bias * (way < 0 ? -way : way);
    }
    turn_to(line.c + way);
    return (way < 0 ? -way : way) / STEPS;
}

static void interfere(void)
{
    switch (any() % 64) {
    case 0:
        power_cycle(any_in(-QUARTER + 1, QUARTER - 1));
        break;
    case 1:
        co_rig_nmt(&rig, RESET_NODE);
        break;
    case 2: /* kept by 1010h, so that a power cycle does not take it back */
        rebase();
        line.parameters ^= any() % 2 != 0 ? CCW : UNITS_PER_S;
        co_rig_put(&rig, 0x6000, 0, line.parameters, 2);
        co_rig_put(&rig, 0x1010, 1, SAVE, 4);
        break;
    case 3:
        co_rig_put(&rig, 0x6003, 0, wanted(), 4);
        line.y0 = (wide)wanted() * DG_CIA406_STEPS;
        line.c0 = line.c;
        break;
    default:
        return;
    }
    check();
    co_rig_run(&rig, LOOK);
}

static int64_t walk(uint32_t steps)
{
    int64_t bias = any_in(-1, 1);
    int64_t turns = 0;

    activate_any();
    for (uint32_t i = 0; i < steps; i++) {
        turns += jump(bias);
        check();
        co_rig_run(&rig, LOOK);
        check();
        interfere();
    }
    return turns;
}

static void the_position_never_deviates(void **state)
{
    int64_t turns = 0;
    (void)state;
    while (turns < walk_turns) {
        setup(NULL);
        noise += (uint64_t)turns;
        for (unsigned i = 0; i < 4; i++) {
            turns += walk(4000);
        }
        assert_int_equal(rig.node.active_causes, 0);
    }
    print_message("%lld turns\n", (long long)turns);
}

/* Every count on the way over the physical overflow, both ways. */
static void step_by_step_over_the_overflow(void **state)
{
    static const uint32_t sequences[] = {0, CCW};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(sequences); i++) {
        turn_to(TURNS * STEPS - 200);
        activate(65000, 65000u * 1000u, 64999999, sequences[i]);
        for (int64_t way = 0; way < 800; way++) {
            turn_to(TURNS * STEPS + (way < 400 ? way - 200 : 600 - way));
            check();
        }
    }
}

/* The manual's example (chapter 20): the error appears without USF, at the physical overflow. */
static void without_usf_the_overflow_shows(void **state)
{
    (void)state;
    activate(65000, 65000000, 0, 0);
    co_rig_put(&rig, 0x6000, 0, SCALING, 2);
    turn_to(TURNS * STEPS);
    assert_int_not_equal(co_rig_get(&rig, 0x6004, 0), wanted());
}

/* ------------------------------------------------------------ while somebody is busy */

/* 60 s at 12 000 rpm while a TPDO reads the warnings every 10 ms. */
static void reading_warnings_does_not_starve_the_supervision(void **state)
{
    (void)state;
    activate(1000, 999999, 0, 0);
    co_rig_put(&rig, 0x1800, 1, 0x800001BF, 4);
    co_rig_put(&rig, 0x1A00, 0, 0, 1);
    co_rig_put(&rig, 0x1A00, 2, 0x65050010, 4);
    co_rig_put(&rig, 0x1A00, 0, 2, 1);
    co_rig_put(&rig, 0x1800, 5, 10, 2);
    co_rig_put(&rig, 0x1800, 1, 0x000001BF, 4);
    co_rig_nmt(&rig, 0x01);
    rig.motion = (struct dg_motion){.kind = DG_MOTION_SPEED, .start = rig.now, .mrpm = 12000000};
    for (int i = 1; i <= 60; i++) {
        co_rig_run(&rig, DG_S(1));
        line.c = 200 * STEPS * i;
        check();
    }
}

/* Without a node-ID nothing can be said, but the shaft turns all the same. */
static void an_unconfigured_node_keeps_its_position(void **state)
{
    (void)state;
    activate(1000, 999999, 0, 0);
    co_rig_rx(&rig, 0x7E5, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, 0x7E5, "11 FF 00 00 00 00 00 00");
    co_rig_rx(&rig, 0x7E5, "04 00 00 00 00 00 00 00");
    assert_int_equal(rig.node.id, DG_CO_UNCONFIGURED);
    for (int i = 0; i < 10; i++) {
        turn_to(line.c + QUARTER - 1);
        co_rig_run(&rig, LOOK);
    }
    co_rig_rx(&rig, 0x7E5, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, 0x7E5, "11 3F 00 00 00 00 00 00");
    co_rig_rx(&rig, 0x7E5, "04 00 00 00 00 00 00 00");
    check();
}

/* A singleturn's range is one turn: its zero moves all the time. 4000 rpm, 1 s. */
static void a_singleturn_counts_turns_with_usf(void **state)
{
    static const struct dg_cia406_model f3658 = {.turns = 1, .device = &dg_cia406_singleturn};
    (void)state;
    co_rig_start_model(&rig, &f3658);
    activate(1000, 249, 7, 0);
    rig.motion = (struct dg_motion){.kind = DG_MOTION_SPEED, .start = rig.now, .mrpm = 4000000};
    for (int64_t ms = 7; ms < 1000; ms += 7) {
        co_rig_run(&rig, DG_MS(7));
        line.c = ms * 4000 * STEPS / 60000;
        check();
    }
}

/* ------------------------------------------------------------ 6200h */

static void the_correction_says_6200h_and_then_0000h(void **state)
{
    (void)state;
    activate(1000, 100000, 0, 0);
    co_rig_run(&rig, LED_FLASH + LOOK);
    co_rig_forget(&rig);
    turn_to(QUARTER - 1);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 0);
    assert_int_equal(dg_cia406_leds(&rig.node).err_pattern, DG_CIA406_LAMP_OFF);
    turn_to(QUARTER);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 2);
    co_rig_expect(&rig, 0, EMCY, "00 62 01 00 00 00 04 00");
    co_rig_expect(&rig, 1, EMCY, "00 00 00 00 00 00 00 00");
    assert_int_equal(dg_cia406_leds(&rig.node).err_pattern, DG_CIA406_LAMP_BLINK);
    /* The other way an eighth is enough. */
    turn_to(QUARTER - QUARTER / 2 + 1);
    co_rig_forget(&rig);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 0);
    turn_to(QUARTER - QUARTER / 2);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 2);
    co_rig_expect(&rig, 0, EMCY, "00 62 01 00 00 00 02 00");
    check();
}

/* ------------------------------------------------------------ power cuts while the zero is stored
 */

/* A correction whose nth write loses power; false when it has fewer writes. */
static bool cut_during_correction(uint32_t nth, enum ram_nvm_tear tear, uint32_t tear_at)
{
    int64_t way = any() % 2 != 0 ? QUARTER + 5 : -QUARTER / 2 - 5;

    ram_nvm_cut(&rig.nvm, nth, tear, tear_at);
    turn_to(line.c + way);
    co_rig_run(&rig, LOOK);
    bool cut = rig.nvm.dead;
    ram_nvm_restore(&rig.nvm);
    power_cycle(any_in(-QUARTER + 6, QUARTER - 6));
    co_rig_forget(&rig);
    check();
    assert_false(rig.encoder.usf_lost);
    co_rig_run(&rig, LOOK);
    check();
    return cut;
}

static void power_cuts_while_the_zero_is_stored(void **state)
{
    static const uint32_t tears[] = {0, 1, 3, 8, 20};
    (void)state;
    for (int tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
        for (size_t i = 0; i < DG_COUNT(tears); i++) {
            uint32_t writes = 0;
            activate_any();
            while (cut_during_correction(writes, (enum ram_nvm_tear)tear, tears[i])) {
                writes++;
                activate_any();
            }
            assert_true(writes >= 3);
        }
    }
}

/* A preset that was interrupted is there or not; a position in between is not. */
static void power_cuts_during_a_preset(void **state)
{
    (void)state;
    for (int tear = 0; tear < RAM_NVM_TEAR_COUNT; tear++) {
        for (uint32_t nth = 0;; nth++) {
            activate(3600, 36000, 1000, 0);
            turn_to(line.c + STEPS);
            ram_nvm_cut(&rig.nvm, nth, (enum ram_nvm_tear)tear, 7);
            uint32_t abort = co_rig_write(&rig, 0x6003, 0, 20000, 4);
            bool cut = rig.nvm.dead;
            uint32_t now = co_rig_get(&rig, 0x6004, 0);
            assert_int_equal(now, abort == 0 ? 20000 : 4600);
            ram_nvm_restore(&rig.nvm);
            power_cycle(0);
            uint32_t after = co_rig_get(&rig, 0x6004, 0);
            assert_true(after == 20000 || (abort != 0 && after == 4600));
            if (!cut) {
                assert_true(nth >= 3);
                break;
            }
        }
    }
}

/* ------------------------------------------------------------ chapter 25 */

/* Whether an EMCY of class `high`, the high byte of its code, was sent. */
static bool sent(uint8_t high)
{
    for (uint32_t i = 0; i < rig.count && i < CO_RIG_FRAMES; i++) {
        if (rig.frame[i].id == EMCY && rig.frame[i].data[1] == high) {
            return true;
        }
    }
    return false;
}

static void damage_the_stored_zero(void)
{
    const struct dg_store_layout *layout = rig.model->device->layout;
    int region = dg_store_find(layout, "usf");

    assert_true(region >= 0);
    rig.nvm.bytes[dg_store_address(layout, (uint8_t)region) + 5] ^= 0x10;
}

static void a_damaged_zero_says_6200h_until_a_preset(void **state)
{
    (void)state;
    activate(3600, 36000, 0, 0);
    damage_the_stored_zero();
    power_cycle(0);
    co_rig_forget(&rig);
    co_rig_run(&rig, 0);
    assert_true(sent(0x62));
    assert_false(sent(0x51)); /* the memory itself works (chapter 25) */
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0x01);
    co_rig_put(&rig, 0x6003, 0, 500, 4);
    assert_true(sent(0x00));
    co_rig_forget(&rig);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 0);
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0x00);
    assert_int_equal(dg_cia406_leds(&rig.node).err_pattern, DG_CIA406_LAMP_BLINK);
    co_rig_run(&rig, LED_FLASH);
    assert_int_equal(dg_cia406_leds(&rig.node).err_pattern, DG_CIA406_LAMP_OFF);
    power_cycle(STEPS);
    co_rig_forget(&rig);
    co_rig_run(&rig, LOOK);
    co_rig_expect_count(&rig, 0);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 4100);
}

/* Until then it counts from where the shaft was at the start, wherever it had gone meanwhile. */
static void a_lost_zero_is_where_the_encoder_starts(void **state)
{
    (void)state;
    activate(3600, 36000, 500, 0);
    damage_the_stored_zero();
    power_cycle(3 * STEPS + 12345);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 0);
    turn_to(line.c + STEPS);
    co_rig_run(&rig, LOOK);
    assert_int_equal(co_rig_get(&rig, 0x6004, 0), 3600);
}

/* Neither a correction nor another setting makes a lost zero a good one. */
static void only_a_preset_finds_a_lost_zero_again(void **state)
{
    (void)state;
    activate(3600, 36000, 0, 0);
    damage_the_stored_zero();
    power_cycle(0);
    co_rig_run(&rig, LOOK);
    turn_to(line.c + QUARTER + 1);
    co_rig_run(&rig, LOOK);
    co_rig_put(&rig, 0x6000, 0, USF | SCALING | CCW, 2);
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    power_cycle(0);
    co_rig_forget(&rig);
    co_rig_run(&rig, LED_FLASH + LOOK);
    assert_true(sent(0x62));
    assert_int_equal(dg_cia406_leds(&rig.node).err_pattern, DG_CIA406_LAMP_BLINK);
    co_rig_put(&rig, 0x6003, 0, 0, 4);
    power_cycle(0);
    co_rig_forget(&rig);
    co_rig_run(&rig, LOOK);
    assert_false(sent(0x62));
}

/* The zero belongs to MUR and TMR; unsaved ones are gone at power-on, and the zero with them. */
static void a_zero_of_other_settings_does_not_count(void **state)
{
    (void)state;
    activate(3600, 36000, 0, 0);
    co_rig_put(&rig, 0x6001, 0, 1800, 4);
    power_cycle(0);
    co_rig_forget(&rig);
    co_rig_run(&rig, 0);
    assert_true(sent(0x62));
}

/* Nor does one whose position is outside of the range, as no encoder stores it. */
static void a_zero_beyond_the_range_does_not_count(void **state)
{
    const struct dg_store_layout *layout = rig.model->device->layout;
    const uint8_t region = (uint8_t)dg_store_find(layout, "usf");
    struct dg_store store;
    uint8_t bytes[21];
    (void)state;

    for (uint32_t whole = 35999; whole <= 36000; whole++) {
        co_rig_start(&rig);
        activate(3600, 36000, 0, 0);
        assert_int_equal(dg_store_mount(&store, layout, ram_nvm_port(&rig.nvm)), DG_OK);
        assert_int_equal(dg_store_read(&store, region, 0, bytes, sizeof bytes), DG_OK);
        dg_store_le32(&bytes[5], whole << 16);
        dg_store_le32(&bytes[9], whole >> 16);
        assert_int_equal(dg_store_put(&store, region, 0, bytes, sizeof bytes), DG_OK);
        co_rig_put(&rig, 0x1010, 1, SAVE, 4);
        power_cycle(0);
        co_rig_forget(&rig);
        co_rig_run(&rig, 0);
        assert_int_equal(sent(0x62), whole == 36000);
    }
}

/* So does its direction. */
static void a_zero_of_the_other_code_sequence_does_not_count(void **state)
{
    (void)state;
    for (uint32_t saved = 0; saved <= CCW; saved++) {
        activate(3600, 36000, 0, saved);
        co_rig_put(&rig, 0x6000, 0, USF | SCALING | (saved ^ CCW), 2);
        turn_to(line.c + 50 * STEPS);
        power_cycle(0);
        co_rig_forget(&rig);
        co_rig_run(&rig, 0);
        assert_true(sent(0x62));
    }
}

/* The memory does not answer on its bus, or takes nothing. */
static void fail_memory(bool silent, bool fails)
{
    rig.world.eeprom_acknowledges = !(silent && fails);
    rig.nvm.no_acknowledge = !silent && fails;
}

/* Nobody follows the shaft while USF is off, so the zero of before is no good any more. */
static void a_zero_from_before_usf_was_off_does_not_count(void **state)
{
    (void)state;
    activate(3600, 36000, 0, 0);
    co_rig_put(&rig, 0x6000, 0, SCALING, 2);
    turn_to(line.c + TURNS * STEPS); /* looks as if nothing had happened */
    power_cycle(0);
    co_rig_forget(&rig);
    co_rig_run(&rig, 0);
    assert_true(sent(0x62));
}

/* The same when the memory learns later that USF is off. */
static void what_must_not_be_kept_is_forgotten_as_soon_as_possible(void **state)
{
    (void)state;
    activate(3600, 36000, 0, 0);
    fail_memory(false, true);
    co_rig_put(&rig, 0x6000, 0, SCALING, 2);
    co_rig_run(&rig, LOOK);
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0x01);
    fail_memory(false, false);
    co_rig_run(&rig, LOOK);
    assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0x00);
    power_cycle(0);
    co_rig_forget(&rig);
    co_rig_run(&rig, 0);
    assert_true(sent(0x62));
}

static void a_failing_memory_says_5100h_as_long_as_it_lasts(void **state)
{
    (void)state;
    for (unsigned silent = 0; silent < 2; silent++) {
        activate(3600, 36001, 0, 0);
        co_rig_run(&rig, LOOK);
        fail_memory(silent != 0, true);
        turn_to(line.c + QUARTER);
        co_rig_forget(&rig);
        co_rig_run(&rig, LOOK);
        assert_true(sent(0x51));
        assert_false(sent(0x62));
        check();
        /* Three quarters on: only the zero in RAM knows how. */
        for (int i = 0; i < 3; i++) {
            turn_to(line.c + QUARTER - 1);
            co_rig_run(&rig, LOOK);
            check();
        }
        assert_int_equal(dg_cia406_leds(&rig.node).bus_pattern, DG_CIA406_LAMP_FAST);
        assert_int_equal(dg_cia406_leds(&rig.node).err_pattern, DG_CIA406_LAMP_FAST_OTHER);
        assert_int_equal(co_rig_write(&rig, 0x6003, 0, 12345, 4), DG_CO_HARDWARE);
        check();
        assert_int_equal(co_rig_get(&rig, 0x6003, 0), 0);
        fail_memory(silent != 0, false);
        co_rig_forget(&rig);
        co_rig_run(&rig, 2 * LOOK);
        assert_true(sent(0x62));
        assert_int_equal(co_rig_get(&rig, 0x1001, 0), 0);
        power_cycle(QUARTER - 1);
        check();
    }
}

/* What the memory has is older than what the reset took from RAM. */
static void a_reset_before_the_zero_could_be_stored_loses_it(void **state)
{
    (void)state;
    activate(3600, 36000, 0, 0);
    fail_memory(false, true);
    turn_to(line.c + QUARTER);
    co_rig_run(&rig, LOOK);
    fail_memory(false, false);
    co_rig_nmt(&rig, RESET_NODE);
    assert_true(rig.encoder.usf_lost);
    co_rig_put(&rig, 0x6003, 0, 0, 4);
    co_rig_nmt(&rig, RESET_NODE);
    assert_false(rig.encoder.usf_lost);
}

/* ------------------------------------------------------------ activation (chapters 22, 26; C26) */

static void what_does_not_fit_usf_is_refused(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x6001, 0, 65000, 4);
    co_rig_put(&rig, 0x6002, 0, 65000u * 1024u, 4); /* TMR/MUR is just a quarter of the turns */
    assert_int_equal(co_rig_write(&rig, 0x6000, 0, USF, 2), DG_CO_INCOMPATIBLE);
    assert_int_equal(co_rig_write(&rig, 0x6000, 0, USF | SCALING, 2), DG_CO_INCOMPATIBLE);
    assert_int_equal(co_rig_get(&rig, 0x6000, 0), 0);
    co_rig_put(&rig, 0x6002, 0, 65000u * 1024u - 1u, 4);
    assert_int_equal(co_rig_write(&rig, 0x6000, 0, USF, 2), DG_CO_INCOMPATIBLE);
    co_rig_put(&rig, 0x6000, 0, USF | SCALING, 2);
    /* And while it is on. */
    assert_int_equal(co_rig_write(&rig, 0x6000, 0, USF, 2), DG_CO_INCOMPATIBLE);
    assert_int_equal(co_rig_write(&rig, 0x6002, 0, 65000u * 1024u, 4), DG_CO_INCOMPATIBLE);
    assert_int_equal(co_rig_write(&rig, 0x6001, 0, 64999, 4), DG_CO_INCOMPATIBLE);
    assert_int_equal(co_rig_get(&rig, 0x6000, 0), USF | SCALING);
    assert_int_equal(co_rig_get(&rig, 0x6001, 0), 65000);
    assert_int_equal(co_rig_get(&rig, 0x6002, 0), 65000u * 1024u - 1u);
    assert_int_equal(co_rig_write(&rig, 0x6003, 0, 65000u * 1024u - 1u, 4), DG_CO_RANGE);
    co_rig_put(&rig, 0x6003, 0, 65000u * 1024u - 2u, 4);
}

/* New settings carry the position on, fractions of a unit included. */
static void settings_can_change_while_usf_is_active(void **state)
{
    (void)state;
    activate(7, 1000, 3, 0);
    for (int i = 0; i < 1000; i++) {
        turn_to(line.c + any_in(-100 * STEPS, 100 * STEPS));
        rebase();
        line.mur = 7u + (uint32_t)(any() % 1000u);
        co_rig_put(&rig, 0x6001, 0, line.mur, 4);
        check();
        co_rig_run(&rig, LOOK);
        turn_to(line.c + any_in(-100 * STEPS, 100 * STEPS));
        rebase();
        line.parameters ^= UNITS_PER_S;
        co_rig_put(&rig, 0x6000, 0, line.parameters, 2);
        check();
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(the_position_never_deviates, setup),
        cmocka_unit_test_setup(step_by_step_over_the_overflow, setup),
        cmocka_unit_test_setup(without_usf_the_overflow_shows, setup),
        cmocka_unit_test_setup(reading_warnings_does_not_starve_the_supervision, setup),
        cmocka_unit_test_setup(an_unconfigured_node_keeps_its_position, setup),
        cmocka_unit_test_setup(a_singleturn_counts_turns_with_usf, setup),
        cmocka_unit_test_setup(the_correction_says_6200h_and_then_0000h, setup),
        cmocka_unit_test_setup(power_cuts_while_the_zero_is_stored, setup),
        cmocka_unit_test_setup(power_cuts_during_a_preset, setup),
        cmocka_unit_test_setup(a_damaged_zero_says_6200h_until_a_preset, setup),
        cmocka_unit_test_setup(a_lost_zero_is_where_the_encoder_starts, setup),
        cmocka_unit_test_setup(only_a_preset_finds_a_lost_zero_again, setup),
        cmocka_unit_test_setup(a_zero_of_other_settings_does_not_count, setup),
        cmocka_unit_test_setup(a_zero_beyond_the_range_does_not_count, setup),
        cmocka_unit_test_setup(a_zero_of_the_other_code_sequence_does_not_count, setup),
        cmocka_unit_test_setup(a_zero_from_before_usf_was_off_does_not_count, setup),
        cmocka_unit_test_setup(what_must_not_be_kept_is_forgotten_as_soon_as_possible, setup),
        cmocka_unit_test_setup(a_failing_memory_says_5100h_as_long_as_it_lasts, setup),
        cmocka_unit_test_setup(a_reset_before_the_zero_could_be_stored_loses_it, setup),
        cmocka_unit_test_setup(what_does_not_fit_usf_is_refused, setup),
        cmocka_unit_test_setup(settings_can_change_while_usf_is_active, setup),
    };

    if (argc == 2 && strcmp(argv[1], "--full") == 0) {
        walk_turns = FULL_TURNS;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The F36x8's other objects: working areas, customer memory, raw position, serial number, start-up
 * and event mode, cyclic timer, LEDs (manual chapters 12, 26, 29; C4, C5, C20, C24, C25, C28, C29).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cia406_private.h"
#include "co_od.h"
#include "co_rig.h"

#define TPDO1 0x1BF
#define TPDO2 0x2BF
#define TPDO4 0x4BF
#define HEARTBEAT 0x73F
#define START 0x01
#define STOP 0x02
#define RESET_NODE 0x81
#define SAVE 0x65766173u
#define STEPS 65536
#define PASSWORD 0xC0FFEE11u
#define OPERATIONAL 0x4000u
#define EVENT_MODE 0x8000u

static const struct dg_cia406_model model = {
    .turns = 4096, .device = &dg_cia406_multiturn, .password = PASSWORD};
static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start_model(&rig, &model);
    return 0;
}

static void turn_to(int64_t counts)
{
    rig.motion = (struct dg_motion){.from = dg_angle_of_counts(counts, STEPS)};
}

static void power_cycle(void)
{
    dg_co_power_off(&rig.node);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
}

/* ------------------------------------------------------------ working areas (C20) */

static void working_areas_at_every_boundary(void **state)
{
    static const struct {
        uint32_t low[2];
        uint32_t high[2];
        uint32_t position;
        uint32_t bits;
    } rows[] = {
        {{1000, 0}, {35000, 0x0FFFFFFF}, 999, 0x05},
        {{1000, 0}, {35000, 0x0FFFFFFF}, 1000, 0x00},
        {{1000, 0}, {35000, 0x0FFFFFFF}, 35000, 0x00},
        {{1000, 0}, {35000, 0x0FFFFFFF}, 35001, 0x03},
        {{0, 1000}, {0x0FFFFFFF, 35000}, 999, 0x28},
        {{0, 1000}, {0x0FFFFFFF, 35000}, 1000, 0x00},
        {{0, 1000}, {0x0FFFFFFF, 35000}, 35000, 0x00},
        {{0, 1000}, {0x0FFFFFFF, 35000}, 35001, 0x18},
        {{10, 20}, {19, 29}, 9, 0x2D},
        {{10, 20}, {19, 29}, 10, 0x28},
        {{10, 20}, {19, 29}, 20, 0x03},
        {{10, 20}, {19, 29}, 30, 0x1B},
        {{5, 5}, {5, 5}, 5, 0x00},
        {{0x0FFFFFFF, 0}, {0x0FFFFFFF, 0x0FFFFFFE}, 0x0FFFFFFF, 0x18},
        {{0, 0}, {0x0FFFFFFF, 0x0FFFFFFF}, 0x0FFFFFFF, 0x00},
        /* crossed: no position is inside (C42) */
        {{1000, 0}, {500, 0x0FFFFFFF}, 500, 0x05},
        {{1000, 0}, {500, 0x0FFFFFFF}, 501, 0x07},
        {{1000, 0}, {500, 0x0FFFFFFF}, 999, 0x07},
        {{1000, 0}, {500, 0x0FFFFFFF}, 1000, 0x03},
        {{0, 1000}, {0x0FFFFFFF, 500}, 700, 0x38},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        for (uint8_t n = 0; n < 2; n++) {
            co_rig_put(&rig, 0x6402, (uint8_t)(n + 1u), rows[i].high[n], 4);
            co_rig_put(&rig, 0x6401, (uint8_t)(n + 1u), rows[i].low[n], 4);
        }
        turn_to(rows[i].position);
        assert_int_equal(co_rig_get(&rig, 0x6400, 1), rows[i].bits);
    }
}

static void working_area_limits_lie_in_the_range(void **state)
{
    (void)state;
    for (uint8_t sub = 1; sub <= 2; sub++) {
        assert_int_equal(co_rig_write(&rig, 0x6401, sub, 0x10000000, 4), DG_CO_RANGE);
        assert_int_equal(co_rig_write(&rig, 0x6402, sub, 0x10000000, 4), DG_CO_RANGE);
        assert_int_equal(co_rig_get(&rig, 0x6401, sub), 0);
        assert_int_equal(co_rig_get(&rig, 0x6402, sub), 0x0FFFFFFF);
    }
    assert_int_equal(co_rig_write(&rig, 0x6400, 1, 0, 1), DG_CO_READ_ONLY);
    for (uint8_t sub = 1; sub <= 2; sub++) {
        co_rig_put(&rig, 0x6401, sub, 0x0FFFFFFF, 4);
        co_rig_put(&rig, 0x6402, sub, 0, 4);
    }
    assert_int_equal(co_rig_write(&rig, 0x6401, 3, 0, 4), DG_CO_NO_SUB);
    /* The scaling has no part in it (C42). */
    co_rig_put(&rig, 0x6002, 0, 3600, 4);
    co_rig_put(&rig, 0x6000, 0, 4, 2);
    assert_int_equal(co_rig_get(&rig, 0x6401, 1), 0x0FFFFFFF);
    co_rig_put(&rig, 0x6402, 1, 0x0FFFFFFF, 4);
}

/* ------------------------------------------------------------ all that can be set, read and
 * written */

#define OBJECTS_MAX 128u

struct entry {
    uint16_t index;
    uint8_t sub;
    uint8_t size;
    uint32_t value;
};

/* All that can be read and written, as it is now. Left out is what does something when it is
 * written (C40), and the mappings, which have their five steps (C6). */
static uint32_t read_all(struct entry *to)
{
    struct dg_co_object object = dg_co_first();
    uint32_t n = 0;

    do {
        if (!co_is(&object, DG_CO_RW) || co_is(&object, DG_CO_ACTION) ||
            object.index >> 8 == 0x1A) {
            continue;
        }
        assert_true(n < OBJECTS_MAX);
        to[n++] = (struct entry){object.index, object.sub, co_size(&object),
                                 co_rig_get(&rig, object.index, object.sub)};
    } while (dg_co_next(rig.model->device, &object));
    return n;
}

static void write_all_back(bool reverse)
{
    struct entry entries[OBJECTS_MAX];
    const uint32_t n = read_all(entries);

    assert_true(n > 40);
    for (uint32_t i = 0; i < n; i++) {
        const struct entry *entry = &entries[reverse ? n - 1 - i : i];
        co_rig_put(&rig, entry->index, entry->sub, entry->value, entry->size);
    }
    for (uint32_t i = 0; i < n; i++) {
        if (entries[i].index != 0x1013) { /* counts on */
            assert_int_equal(co_rig_get(&rig, entries[i].index, entries[i].sub), entries[i].value);
        }
    }
}

/* Crossed limits, moved COB-IDs, scaling with USF. */
static void configure_all(void)
{
    static const struct entry wanted[] = {
        {0x1016, 1, 4, 0x00110064}, {0x1029, 1, 1, 2},    {0x1800, 1, 4, 0x800001BF},
        {0x1800, 1, 4, 0x2BF}, /* TPDO2's, too */
        {0x1803, 1, 4, 0x80000000}, {0x2120, 2, 1, 0x60}, {0x2120, 3, 1, 0x50},
        {0x6001, 0, 4, 3600},       {0x6402, 1, 4, 500},  {0x6401, 1, 4, 1000},
        {0x6401, 2, 4, 65535},      {0x6402, 2, 4, 0},    {0x6002, 0, 4, 3600},
        {0x6000, 0, 2, 0x0004},
    };
    for (size_t i = 0; i < DG_COUNT(wanted); i++) {
        const struct entry *at = &wanted[i];
        co_rig_put(&rig, at->index, at->sub, at->value, at->size);
    }
}

/* As a tool does that copies a device's configuration (C42). */
static void what_is_read_can_be_written_in_any_order(void **state)
{
    static const struct dg_cia406_model singleturn = {
        .turns = 1, .device = &dg_cia406_singleturn, .password = PASSWORD};
    const struct dg_cia406_model *const models[] = {&model, &singleturn};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(models); i++) {
        co_rig_start_model(&rig, models[i]);
        write_all_back(false);
        write_all_back(true);
        configure_all();
        write_all_back(false);
        write_all_back(true);
        co_rig_put(&rig, 0x1010, 1, SAVE, 4);
        power_cycle();
        assert_int_equal(co_rig_get(&rig, 0x6401, 1), 1000);
        assert_int_equal(co_rig_get(&rig, 0x6402, 1), 500);
        write_all_back(false);
        write_all_back(true);
    }
}

/* ------------------------------------------------------------ 2140h, 2160h-2162h (C24) */

static void customer_memory_is_kept_by_save(void **state)
{
    static const uint32_t words[4] = {0x11223344, 0xFFFFFFFF, 0, 0x8A7A6A5A};
    (void)state;
    for (uint8_t i = 0; i < 4; i++) {
        co_rig_put(&rig, 0x2140, (uint8_t)(i + 1u), words[i], 4);
    }
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x2140, 1), 0);
    for (uint8_t i = 0; i < 4; i++) {
        co_rig_put(&rig, 0x2140, (uint8_t)(i + 1u), words[i], 4);
    }
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    power_cycle();
    for (uint8_t i = 0; i < 4; i++) {
        assert_int_equal(co_rig_get(&rig, 0x2140, (uint8_t)(i + 1u)), words[i]);
    }
    assert_int_equal(co_rig_write(&rig, 0x2140, 5, 0, 4), DG_CO_NO_SUB);
}

/* The manual's position and the CRC of C24; raw means without preset and scaling. */
static void raw_position_inverted_and_crc(void **state)
{
    (void)state;
    turn_to(0x017F3A15);
    co_rig_put(&rig, 0x6003, 0, 77, 4);
    assert_int_equal(co_rig_get(&rig, 0x2160, 0), 0x017F3A15);
    assert_int_equal(co_rig_get(&rig, 0x2161, 0), 0xFE80C5EA);
    assert_int_equal(co_rig_get(&rig, 0x2162, 0), 0x2900);
    co_rig_nmt(&rig, START);
    co_rig_rtr(&rig, TPDO4);
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, TPDO4, "15 3A 7F 01 00 29");
}

/* ------------------------------------------------------------ 300Ah, 300Bh (C25) */

static uint32_t password(uint32_t value)
{
    return co_rig_write(&rig, 0x300A, 0, value, 4);
}

static void the_password_opens_the_serial_number_for_one_write(void **state)
{
    uint32_t value;
    (void)state;
    assert_int_equal(co_rig_read(&rig, 0x300A, 0, &value), DG_CO_WRITE_ONLY);
    assert_int_equal(co_rig_write(&rig, 0x300B, 0, 42, 4), DG_CO_STATE);
    assert_int_equal(co_rig_get(&rig, 0x300B, 0), 1234567890);
    assert_int_equal(password(PASSWORD), 0);
    co_rig_put(&rig, 0x300B, 0, 42, 4);
    assert_int_equal(co_rig_write(&rig, 0x300B, 0, 43, 4), DG_CO_STATE);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(co_rig_get(&rig, 0x300B, 0), 42);
        assert_int_equal(co_rig_get(&rig, 0x650B, 0), 42);
        assert_int_equal(co_rig_get(&rig, 0x1018, 4), 42);
        power_cycle();
    }
    assert_int_equal(co_rig_write(&rig, 0x650B, 0, 43, 4), DG_CO_READ_ONLY);
}

static void a_wrong_password_makes_the_next_one_wait_longer(void **state)
{
    (void)state;
    assert_int_equal(password(PASSWORD + 1), DG_CO_STORE);
    assert_int_equal(co_rig_write(&rig, 0x300B, 0, 42, 4), DG_CO_STATE);
    for (unsigned seconds = 1; seconds <= 256; seconds *= 2) {
        co_rig_run(&rig, DG_S(seconds) - 1);
        assert_int_equal(password(PASSWORD), DG_CO_STORE);
    }
    co_rig_run(&rig, DG_S(256));
    assert_int_equal(password(PASSWORD), 0);
    assert_int_equal(password(0), DG_CO_STORE); /* and closes it again */
    assert_int_equal(co_rig_write(&rig, 0x300B, 0, 42, 4), DG_CO_STATE);
    co_rig_run(&rig, DG_S(1));
    assert_int_equal(password(PASSWORD), 0);
    co_rig_nmt(&rig, RESET_NODE);
    assert_int_equal(co_rig_write(&rig, 0x300B, 0, 42, 4), DG_CO_STATE);
}

static void a_serial_number_that_is_not_stored_is_not_taken(void **state)
{
    (void)state;
    assert_int_equal(password(PASSWORD), 0);
    rig.world.eeprom_acknowledges = false;
    assert_int_equal(co_rig_write(&rig, 0x300B, 0, 42, 4), DG_CO_HARDWARE);
    assert_int_equal(co_rig_get(&rig, 0x1018, 4), 1234567890);
    rig.world.eeprom_acknowledges = true;
    rig.nvm.no_acknowledge = true;
    assert_int_equal(co_rig_write(&rig, 0x300B, 0, 42, 4), DG_CO_HARDWARE);
    assert_int_equal(co_rig_get(&rig, 0x1018, 4), 1234567890);
    rig.nvm.no_acknowledge = false;
    co_rig_put(&rig, 0x300B, 0, 43, 4);
    assert_int_equal(co_rig_get(&rig, 0x1018, 4), 43);
}

/* ------------------------------------------------------------ 6000h bits 14 and 15, 6200h */

static void bit_14_boots_into_operational(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x6000, 0, OPERATIONAL, 2);
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL);
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    turn_to(0x01020304);
    co_rig_forget(&rig);
    power_cycle();
    assert_int_equal(rig.node.state, DG_CO_OPERATIONAL);
    co_rig_expect(&rig, 0, HEARTBEAT, "00");
    co_rig_expect(&rig, 1, TPDO1, "04 03 02 01");
    co_rig_nmt(&rig, 0x82);
    assert_int_equal(rig.node.state, DG_CO_OPERATIONAL);
    co_rig_nmt(&rig, STOP);
    co_rig_nmt(&rig, RESET_NODE);
    assert_int_equal(rig.node.state, DG_CO_OPERATIONAL);
}

static uint32_t count_of(uint16_t id)
{
    uint32_t count = 0;

    assert_true(rig.count <= CO_RIG_FRAMES);
    for (uint32_t i = 0; i < rig.count; i++) {
        count += rig.frame[i].id == id;
    }
    return count;
}

static void bit_15_sends_every_change(void **state)
{
    (void)state;
    co_rig_nmt(&rig, START);
    co_rig_run(&rig, DG_S(1));
    co_rig_forget(&rig);
    turn_to(1);
    co_rig_run(&rig, DG_MS(100));
    co_rig_expect_count(&rig, 0); /* not without the bit */
    co_rig_put(&rig, 0x6000, 0, EVENT_MODE, 2);
    co_rig_run(&rig, DG_MS(2));
    co_rig_forget(&rig);
    co_rig_run(&rig, DG_MS(100));
    co_rig_expect_count(&rig, 0);
    for (uint8_t position = 2; position < 10; position++) {
        turn_to(position);
        co_rig_run(&rig, DG_MS(1));
        assert_int_equal(count_of(TPDO1), position - 1u);
        assert_int_equal(rig.frame[rig.count - 1].id, TPDO4); /* raw, and no speed to speak of */
        assert_int_equal(rig.frame[rig.count - 1].data[0], position);
    }
    assert_int_equal(count_of(TPDO2), 0); /* type 1 */
}

/* An event inside the inhibit time is deferred, not lost, and carries the latest value. */
static void the_inhibit_time_bounds_event_mode(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x1800, 1, 0x800001BF, 4);
    co_rig_put(&rig, 0x1800, 3, 50, 2); /* 5 ms */
    co_rig_put(&rig, 0x1800, 1, 0x000001BF, 4);
    co_rig_put(&rig, 0x1803, 1, 0x800004BF, 4);
    co_rig_put(&rig, 0x6000, 0, EVENT_MODE, 2);
    co_rig_nmt(&rig, START);
    co_rig_run(&rig, DG_MS(20));
    co_rig_forget(&rig);
    turn_to(1);
    co_rig_run(&rig, DG_MS(1));
    co_rig_expect_count(&rig, 1);
    dg_ns first = rig.at[0];
    turn_to(2);
    co_rig_run(&rig, DG_MS(2));
    turn_to(3);
    co_rig_run(&rig, DG_MS(20));
    co_rig_expect_count(&rig, 2);
    co_rig_expect(&rig, 0, TPDO1, "01 00 00 00");
    co_rig_expect(&rig, 1, TPDO1, "03 00 00 00");
    assert_int_equal(rig.at[1] - first, DG_MS(5));
    co_rig_forget(&rig);
    rig.motion = (struct dg_motion){
        .kind = DG_MOTION_SPEED, .start = rig.now, .from = DG_TURN, .mrpm = 600000};
    co_rig_run(&rig, DG_MS(101));
    assert_in_range(count_of(TPDO1), 20, 21);
}

static void the_cyclic_timer_is_tpdo1s_event_timer(void **state)
{
    (void)state;
    co_rig_nmt(&rig, START);
    co_rig_put(&rig, 0x6200, 0, 20, 2);
    assert_int_equal(co_rig_get(&rig, 0x1800, 5), 20);
    co_rig_forget(&rig);
    co_rig_run(&rig, DG_MS(100));
    assert_int_equal(count_of(TPDO1), 5);
    assert_int_equal(rig.at[1] - rig.at[0], DG_MS(20));
    co_rig_put(&rig, 0x1800, 5, 30, 2);
    assert_int_equal(co_rig_get(&rig, 0x6200, 0), 30);
    co_rig_put(&rig, 0x1010, 1, SAVE, 4);
    power_cycle();
    assert_int_equal(co_rig_get(&rig, 0x6200, 0), 30);
    co_rig_put(&rig, 0x6200, 0, 0, 2);
    co_rig_nmt(&rig, START);
    co_rig_run(&rig, DG_S(1));
    assert_int_equal(count_of(TPDO1), 0);
}

/* ------------------------------------------------------------ LEDs (chapter 29) */

static void expect_leds(enum dg_cia406_lamp bus, enum dg_cia406_lamp err)
{
    struct dg_cia406_leds leds = dg_cia406_leds(&rig.node);

    assert_int_equal(leds.bus_pattern, bus);
    assert_int_equal(leds.err_pattern, err);
}

static void leds_show_states_and_errors(void **state)
{
    (void)state;
    expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    co_rig_nmt(&rig, STOP);
    expect_leds(DG_CIA406_LAMP_SLOW, DG_CIA406_LAMP_OFF);
    co_rig_nmt(&rig, START);
    expect_leds(DG_CIA406_LAMP_ON, DG_CIA406_LAMP_OFF);
    /* link to the master lost; 1029h:1 leads to pre-operational */
    co_rig_put(&rig, 0x1016, 1, 0x00070064, 4);
    co_rig_rx(&rig, 0x707, "05");
    co_rig_run(&rig, DG_MS(101));
    expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_BLINK);
    co_rig_rx(&rig, 0x707, "05");
    expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    co_rig_put(&rig, 0x1016, 1, 0, 4);
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_OFF);
    expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_ON);
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_ACTIVE);
    expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    /* temperature: the red one blinks for 3 s */
    rig.world.temperature_mdegc = 120000;
    co_rig_run(&rig, DG_MS(100));
    expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_BLINK);
    co_rig_run(&rig, DG_S(3));
    expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    rig.world.temperature_mdegc = 37000;
    rig.world.singleturn_ok = false;
    co_rig_run(&rig, DG_S(5));
    expect_leds(DG_CIA406_LAMP_FAST, DG_CIA406_LAMP_FAST_OTHER);
    rig.world.watchdog_fired = true;
    expect_leds(DG_CIA406_LAMP_300, DG_CIA406_LAMP_300);
    co_rig_rx(&rig, 0x7E5, "04 01 00 00 00 00 00 00");
    expect_leds(DG_CIA406_LAMP_FAST, DG_CIA406_LAMP_FAST);
    dg_co_power_off(&rig.node);
    expect_leds(DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
    assert_false(dg_cia406_leds(&rig.node).bus);
}

/* Told without power, or when the boot-up has not been acknowledged. */
static void leds_without_a_bus(void **state)
{
    (void)state;
    for (int told = 0; told < 2; told++) {
        dg_co_power_off(&rig.node);
        if (told == 0) {
            assert_int_equal(dg_co_bus(&rig.node, rig.now, DG_CO_BUS_ABSENT), DG_NEVER);
        }
        assert_int_equal(dg_co_power_on(&rig.node, rig.now), DG_OK);
        if (told == 1) {
            (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_ABSENT);
        }
        expect_leds(DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_BLINK);
        co_rig_run(&rig, DG_S(1));
        expect_leds(DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_BLINK);
        (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_PRESENT);
        expect_leds(DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
        (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_ABSENT);
        expect_leds(DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
        (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_PRESENT);
    }
    /* Nothing else has happened to the node. */
    assert_int_equal(rig.node.history_count, 0);
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL);
}

/* Lit and dark times by chapter 29, sampled every millisecond of 2.4 s. */
static void expect_period(unsigned half_ms, bool opposite)
{
    bool was = dg_cia406_leds(&rig.node).bus;
    unsigned since = 0;
    unsigned changes = 0;

    for (unsigned ms = 1; ms <= 2400; ms++) {
        co_rig_run(&rig, DG_MS(1));
        struct dg_cia406_leds leds = dg_cia406_leds(&rig.node);
        assert_int_equal(leds.err, opposite ? !leds.bus : leds.bus);
        if (leds.bus == was) {
            continue;
        }
        assert_true(changes == 0 || ms - since == half_ms);
        since = ms;
        was = leds.bus;
        changes++;
    }
    assert_in_range(changes, 2400 / half_ms - 1, 2400 / half_ms + 1);
}

/* The host steps the node at its deadlines; the phase is that of node->now. */
static void patterns_have_their_phase(void **state)
{
    (void)state;
    co_rig_put(&rig, 0x6000, 0, EVENT_MODE, 2); /* steps every millisecond in operational */
    co_rig_nmt(&rig, START);
    rig.world.singleturn_ok = false;
    co_rig_run(&rig, DG_MS(100));
    expect_period(50, true);
    rig.world.watchdog_fired = true;
    expect_period(300, false);
}

static void blinking_and_slow_blinking(void **state)
{
    static const struct {
        uint8_t command;
        unsigned half_ms;
    } rows[] = {{0x80, 250}, {STOP, 1000}};
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        co_rig_nmt(&rig, rows[i].command);
        for (unsigned ms = 0; ms < 4000; ms += 5) {
            rig.node.now = DG_S(10) + DG_MS(ms);
            assert_int_equal(dg_cia406_leds(&rig.node).bus, ms / rows[i].half_ms % 2 == 0);
            assert_false(dg_cia406_leds(&rig.node).err);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(working_areas_at_every_boundary, setup),
        cmocka_unit_test_setup(working_area_limits_lie_in_the_range, setup),
        cmocka_unit_test_setup(what_is_read_can_be_written_in_any_order, setup),
        cmocka_unit_test_setup(customer_memory_is_kept_by_save, setup),
        cmocka_unit_test_setup(raw_position_inverted_and_crc, setup),
        cmocka_unit_test_setup(the_password_opens_the_serial_number_for_one_write, setup),
        cmocka_unit_test_setup(a_wrong_password_makes_the_next_one_wait_longer, setup),
        cmocka_unit_test_setup(a_serial_number_that_is_not_stored_is_not_taken, setup),
        cmocka_unit_test_setup(bit_14_boots_into_operational, setup),
        cmocka_unit_test_setup(bit_15_sends_every_change, setup),
        cmocka_unit_test_setup(the_inhibit_time_bounds_event_mode, setup),
        cmocka_unit_test_setup(the_cyclic_timer_is_tpdo1s_event_timer, setup),
        cmocka_unit_test_setup(leds_show_states_and_errors, setup),
        cmocka_unit_test_setup(leds_without_a_bus, setup),
        cmocka_unit_test_setup(patterns_have_their_phase, setup),
        cmocka_unit_test_setup(blinking_and_slow_blinking, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

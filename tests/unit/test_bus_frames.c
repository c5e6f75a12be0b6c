/* SPDX-License-Identifier: MIT */
/*
 * Encoders on a bus of frames in virtual time hear each other, wait for each other, for the wire
 * and for their memories, and share what breaks.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"
#include "frames_rig.h"

/* ------------------------------------------------------------ several */

/* All of them answer one SYNC, in the order of their places, or of their identifiers. */
static void order_at_one_moment(void **state)
{
    static const uint16_t ids[FRAMES_RIG_ENCODERS] = {0x1F0, 0x182, 0x1E0, 0x18F};
    static const uint16_t in_order[FRAMES_RIG_ENCODERS] = {0x182, 0x18F, 0x1E0, 0x1F0};
    static const uint8_t go[2] = {1, 0};

    (void)state;
    for (int arbitrate = 0; arbitrate < 2; arbitrate++) {
        frames_rig_begin((struct dg_bus_frames_setup){.arbitrate = arbitrate != 0},
                         FRAMES_RIG_ENCODERS);
        for (size_t i = 0; i < FRAMES_RIG_ENCODERS; i++) {
            (void)frames_rig_write(DG_S(2), i, 0x1800, 1, 0x80000000u | ids[i], 4);
            (void)frames_rig_write(DG_S(2), i, 0x1800, 2, 1, 1);
            (void)frames_rig_write(DG_S(2), i, 0x1800, 1, ids[i], 4);
            (void)frames_rig_write(DG_S(2), i, 0x1801, 1, 0x80000280u, 4);
        }
        (void)frames_rig_send(DG_S(3), 0, sizeof go, go);
        (void)dg_bus_step(frames_rig.bus, DG_S(4));
        frames_rig.count = 0;
        (void)frames_rig_send(DG_S(5), 0x80, 0, go);
        assert_int_equal(frames_rig.count, FRAMES_RIG_ENCODERS);
        for (size_t i = 0; i < FRAMES_RIG_ENCODERS; i++) {
            const uint16_t id = arbitrate != 0 ? in_order[i] : ids[i];
            assert_int_equal(frames_rig.sent[i].event.frame.id, id);
            assert_int_equal(frames_rig.sent[i].event.at, DG_S(5));
        }
    }
}

static uint32_t count_heard(size_t i)
{
    const struct dg_cia406_device *device = dg_host_line_of(frames_rig.host[i])->device;

    return device->node.counters.rx;
}

/* Encoder 2 watches the heartbeat of encoder 1; at one moment, and not the other way round. */
static void they_hear_each_other(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 3);
    const unsigned before = frames_rig.filters;
    frames_rig.wanted = 0x707;
    (void)frames_rig_write(DG_S(2), 1, 0x1016, 2, 7u << 16 | 250u, 4);
    assert_true(frames_rig.open_before); /* the filter was open before the answer was out */
    assert_int_equal(frames_rig.filters, before + 1u);
    (void)frames_rig_write(DG_S(2), 1, 0x1016, 1, 1u << 16 | 250u, 4);
    (void)frames_rig_write(DG_S(2), 0, 0x1017, 0, 100, 2);
    const uint32_t heard = count_heard(0);
    (void)dg_bus_step(frames_rig.bus, DG_S(4));
    assert_int_equal(count_heard(0), heard);               /* nobody hears itself */
    assert_int_equal(frames_rig_count(HEARTBEAT + 1), 21); /* the first one at once */
    assert_int_equal(frames_rig_count(EMCY + 2), 0);
    frames_rig_bend(0, "wire_drop", true, 0, DG_S(4));
    (void)dg_bus_step(frames_rig.bus, DG_S(5));
    assert_int_equal(frames_rig_count(EMCY + 2), 1);
    assert_int_equal(frames_rig.sent[frames_rig.count - 1].event.at, DG_S(4) + DG_MS(250));
    frames_rig_bend(0, "wire_drop", false, 0, DG_S(5));
    (void)dg_bus_step(frames_rig.bus, DG_S(6));
    assert_int_equal(frames_rig_count(EMCY + 2), 2);
    frames_rig_bend(1, "wire_deaf", true, 0, DG_S(6));
    (void)dg_bus_step(frames_rig.bus, DG_S(7));
    assert_int_equal(frames_rig_count(EMCY + 2), 3);
    assert_int_equal(frames_rig_count(EMCY + 3), 0);
}

/* ------------------------------------------------------------ the wire */

static void those_of_another_bit_rate_are_deaf_and_mute(void **state)
{
    struct dg_bus_frames_line line = {.bit_rate = 125000, .company = DG_BUS_SOMEBODY};

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 2);
    assert_int_equal(frames_rig.retuned[1], 250000);
    assert_int_equal(dg_bus_frames_bit_rate(frames_rig.bus), 250000);
    (void)frames_rig_write(DG_S(2), 0, 0x1017, 0, 100, 2);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_int_equal(frames_rig_count(HEARTBEAT + 1), 11);
    dg_bus_frames_set_line(frames_rig.bus, &line);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_false(dg_bus_frames_hears(frames_rig.bus, 0));
    assert_false(dg_bus_frames_listens(frames_rig.bus, 0x601));
    frames_rig.count = 0;
    (void)frames_rig_ask(DG_S(3), 0);
    (void)dg_bus_step(frames_rig.bus, DG_S(4));
    assert_int_equal(frames_rig.count, 0);
    line.tolerant = true;
    dg_bus_frames_set_line(frames_rig.bus, &line);
    (void)frames_rig_ask(DG_S(4), 0);
    assert_int_equal(frames_rig_count(SDO + 1), 1);
    line = (struct dg_bus_frames_line){.closed = true};
    dg_bus_frames_set_line(frames_rig.bus, &line);
    (void)dg_bus_step(frames_rig.bus, DG_S(5));
    frames_rig.count = 0;
    (void)frames_rig_ask(DG_S(5), 0);
    (void)dg_bus_step(frames_rig.bus, DG_S(6));
    assert_int_equal(frames_rig.count, 0);
}

/* A wire that has none has that of the slowest encoder that hears it. */
static void the_slowest_bit_rate(void **state)
{
    static const uint8_t reset[2] = {0x81, 1};
    const struct dg_bus_frames_line line = {.bit_rate = 250000};

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 2);
    (void)frames_rig_write(DG_S(2), 0, 0x2100, 0, 3, 1);
    (void)frames_rig_write(DG_S(2), 0, 0x2105, 0, 0x65766173u, 4); /* "save" */
    (void)frames_rig_send(DG_S(3), 0, sizeof reset, reset);
    assert_int_equal(frames_rig.retuned[0], 100000);
    assert_int_equal(dg_bus_frames_bit_rate(frames_rig.bus), 100000);
    assert_int_equal(frames_rig_count(HEARTBEAT + 1), 1); /* the wire has none */
    dg_bus_frames_set_line(frames_rig.bus, &line);
    (void)dg_bus_step(frames_rig.bus, DG_S(4));
    assert_int_equal(dg_bus_frames_bit_rate(frames_rig.bus), 250000);
    assert_false(dg_bus_frames_hears(frames_rig.bus, 0));
    assert_true(dg_bus_frames_hears(frames_rig.bus, 1));
}

static enum dg_cia406_lamp lamp_of(size_t i)
{
    return dg_cia406_leds(dg_host_line_of(frames_rig.host[i])->device).bus_pattern;
}

/* As they feel it, C38. */
static void a_bus_is_there_or_not(void **state)
{
    struct dg_bus_frames_line line = {.company = DG_BUS_NOBODY};

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.line = line}, 1);
    assert_int_equal(lamp_of(0), DG_CIA406_LAMP_OFF);
    line.company = DG_BUS_SOMEBODY;
    dg_bus_frames_set_line(frames_rig.bus, &line);
    (void)dg_bus_step(frames_rig.bus, DG_S(2));
    assert_int_equal(lamp_of(0), DG_CIA406_LAMP_BLINK);
    line.company = DG_BUS_NOBODY;
    dg_bus_frames_set_line(frames_rig.bus, &line);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_int_equal(lamp_of(0), DG_CIA406_LAMP_OFF);
}

/* 8 bytes at 250 kBd: 135 bits of 4 us; the first frame at once. */
static void frames_have_their_time(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = true}, FRAMES_RIG_ENCODERS);
    const uint64_t bits = dg_bus_frames_bits(frames_rig.bus);
    for (size_t i = 0; i < FRAMES_RIG_ENCODERS; i++) {
        (void)frames_rig_ask(DG_S(2), i);
    }
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_int_equal(frames_rig.count, FRAMES_RIG_ENCODERS);
    /* Of the master's four, which came at once, the present one counts. */
    for (size_t i = 1; i < FRAMES_RIG_ENCODERS; i++) {
        assert_int_equal(frames_rig.sent[i].event.at - DG_S(2), (i + 1) * DG_US(540));
    }
    assert_int_equal(dg_bus_frames_bits(frames_rig.bus) - bits, 8u * 135u);
    assert_int_equal(dg_bus_frames_counters(frames_rig.bus)->stalls, 0);
}

/* A flood of the master's does not add up to silence. */
static void a_flood_is_over_at_once(void **state)
{
    static const uint8_t none[8] = {0};

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = true}, 1);
    (void)frames_rig_ask(DG_S(2), 0);
    for (unsigned i = 0; i < 1000; i++) {
        (void)frames_rig_send(DG_S(2), 0x555, sizeof none, none);
    }
    dg_bus_frames_count(frames_rig.bus, DG_S(2), DG_CAN_EXTENDED_BITS(1u, 8u));
    (void)frames_rig_ask(DG_S(2), 0);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_int_equal(frames_rig.count, 2);
    assert_int_equal(frames_rig.sent[1].event.at, DG_S(2) + 2 * DG_US(540));
}

/* More than fits the time: the encoders wait, and nothing is lost. */
static void too_much_makes_them_wait(void **state)
{
    (void)state;
    frames_rig_begin(
        (struct dg_bus_frames_setup){.pace = true, .line = {.bit_rate = 10000, .tolerant = true}},
        1);
    for (unsigned i = 0; i < DG_BUS_FRAMES_PACED + 1u; i++) {
        assert_false(dg_bus_frames_waits(frames_rig.bus));
        (void)frames_rig_ask(DG_S(2), 0);
    }
    assert_true(dg_bus_frames_waits(frames_rig.bus));
    assert_int_equal(dg_bus_frames_counters(frames_rig.bus)->stalls, 1);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_int_equal(frames_rig.count, DG_BUS_FRAMES_PACED + 1u);
    assert_false(dg_bus_frames_waits(frames_rig.bus));
    assert_int_equal(dg_bus_frames_counters(frames_rig.bus)->lost, 0);
}

/* A late host: what has waited is made up for, 5 ms of it at most. */
static void a_late_host(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = true, .real_time = true}, 1);
    (void)frames_rig_write(DG_S(2), 0, 0x1017, 0, 100, 2);
    frames_rig.count = 0;
    (void)dg_bus_step(frames_rig.bus, DG_S(3) + DG_MS(42));
    assert_int_equal(frames_rig_count(HEARTBEAT + 1), 1); /* what was missed is left out */
    assert_int_equal(frames_rig.sent[0].event.at, DG_S(3) + DG_MS(42));
    (void)dg_bus_step(frames_rig.bus, DG_S(3) + DG_MS(142));
    assert_int_equal(frames_rig_count(HEARTBEAT + 1), 2);
    for (unsigned i = 0; i < 30; i++) {
        (void)frames_rig_ask(DG_S(4), 0);
    }
    frames_rig.count = 0;
    (void)dg_bus_step(frames_rig.bus, DG_S(5));
    assert_int_equal(frames_rig_count(SDO + 1), 10); /* of 540 us each */
}

static void a_port_without_room(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 1);
    (void)frames_rig_write(DG_S(2), 0, 0x1017, 0, 100, 2);
    dg_bus_frames_stall(frames_rig.bus, true);
    frames_rig.count = 0;
    assert_int_equal(dg_bus_step(frames_rig.bus, DG_S(3)), DG_NEVER);
    assert_int_equal(frames_rig.count, 0);
    dg_bus_frames_stall(frames_rig.bus, false);
    assert_int_not_equal(dg_bus_step(frames_rig.bus, DG_S(3)), DG_NEVER);
    assert_int_equal(frames_rig.count, 1);
}

/* ------------------------------------------------------------ memories */

static void answers_wait_for_the_memory(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 1);
    frames_rig.answer = DG_BUS_KEEP;
    (void)frames_rig_write(DG_S(2), 0, 0x1017, 0, 100, 2);
    (void)frames_rig_ask(DG_S(2), 0);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_int_equal(frames_rig_count(SDO + 1), 0);
    assert_int_equal(frames_rig_count(HEARTBEAT + 1), 11); /* nothing else waits */
    (void)dg_bus_durable(frames_rig.bus, 0, DG_S(3));
    assert_int_equal(frames_rig_count(SDO + 1), 0);
    frames_rig.answer = DG_BUS_SAY;
    (void)dg_bus_durable(frames_rig.bus, 0, DG_S(3));
    assert_int_equal(frames_rig_count(SDO + 1), 2);
    assert_int_equal(frames_rig.sent[frames_rig.count - 2].event.frame.data[0],
                     0x60); /* in their order */
    frames_rig.answer = DG_BUS_KEEP;
    (void)frames_rig_ask(DG_S(4), 0);
    frames_rig.answer = DG_BUS_DROP;
    (void)dg_bus_durable(frames_rig.bus, 0, DG_S(4));
    frames_rig.answer = DG_BUS_KEEP;
    (void)frames_rig_ask(DG_S(5), 0);
    dg_host_power(frames_rig.host[0], DG_S(5), false);
    (void)dg_bus_changed(frames_rig.bus, 0, DG_S(5));
    frames_rig.answer = DG_BUS_SAY;
    (void)dg_bus_durable(frames_rig.bus, 0, DG_S(5));
    assert_int_equal(frames_rig_count(SDO + 1), 2);
    assert_int_equal(dg_bus_frames_counters(frames_rig.bus)->lost, 0);
}

/* Whoever brings no memory loses frames, and they are counted. */
static void what_finds_no_room_is_lost(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.rooms = 3}, 1);
    frames_rig.answer = DG_BUS_KEEP;
    for (unsigned i = 0; i < 5; i++) {
        (void)frames_rig_ask(DG_S(2), 0);
    }
    assert_int_equal(dg_bus_frames_counters(frames_rig.bus)->lost, 2);
    frames_rig.answer = DG_BUS_SAY;
    (void)dg_bus_durable(frames_rig.bus, 0, DG_S(3));
    assert_int_equal(frames_rig_count(SDO + 1), 3);
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 1);
    frames_rig.answer = DG_BUS_KEEP;
    for (unsigned i = 0; i < DG_BUS_FRAMES_ANSWERS + 1u; i++) {
        (void)frames_rig_ask(DG_S(2), 0);
    }
    assert_int_equal(dg_bus_frames_counters(frames_rig.bus)->lost, 1);
}

/* ------------------------------------------------------------ faults */

static void late_and_twice(void **state)
{
    const dg_ns delay = (dg_ns)dg_fault_wire_value(&dg_cia406_instrument, DG_WIRE_DELAY);

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 2);
    frames_rig_bend(0, "wire_delay", true, 1, DG_S(2));
    (void)frames_rig_ask(DG_S(2), 0);
    (void)frames_rig_ask(DG_S(2) + 5, 0); /* behind the one that is late */
    (void)frames_rig_ask(DG_S(2) + 6, 1);
    (void)dg_bus_step(frames_rig.bus, DG_S(4));
    assert_int_equal(frames_rig.count, 3);
    assert_int_equal(frames_rig.sent[0].event.frame.id, SDO + 2);
    for (size_t i = 1; i < 3; i++) {
        assert_int_equal(frames_rig.sent[i].event.frame.id, SDO + 1);
        assert_int_equal(frames_rig.sent[i].event.at, DG_S(2) + delay);
    }
    frames_rig_bend(0, "wire_duplicate", true, 1, DG_S(5));
    (void)frames_rig_ask(DG_S(5), 0);
    assert_int_equal(frames_rig_count(SDO + 1), 4);
    frames_rig_bend(0, "wire_damage", true, 1, DG_S(6));
    (void)frames_rig_ask(DG_S(6), 0);
    const struct dg_can_frame *good = &frames_rig.sent[frames_rig.count - 2].event.frame;
    const struct dg_can_frame *bad = &frames_rig.sent[frames_rig.count - 1].event.frame;
    unsigned flipped = 0;
    for (size_t n = 0; n < 8; n++) {
        flipped += (unsigned)__builtin_popcount((unsigned)(bad->data[n] ^ good->data[n]));
    }
    assert_int_equal(flipped, 1);
}

/* Each one's own, and the worse one of the wire's and the fault's. */
static void controllers(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 2);
    frames_rig_bend(0, "bus_off", true, 0, DG_S(2));
    (void)frames_rig_ask(DG_S(2), 0);
    (void)frames_rig_ask(DG_S(2), 1);
    assert_int_equal(frames_rig.count, 1);
    frames_rig_bend(0, "error_passive", true, 0, DG_S(3));
    frames_rig_bend(0, "bus_off", false, 0, DG_S(4));
    assert_int_equal(frames_rig_count(EMCY + 1), 3);
    assert_int_equal(frames_rig_code(1), 0x8140);
    assert_int_equal(frames_rig_code(3), 0x8120);
    (void)dg_bus_frames_controller(frames_rig.bus, DG_S(5), DG_HOST_BUS_PASSIVE);
    assert_int_equal(frames_rig_count(EMCY + 1), 3);
    assert_int_equal(frames_rig_count(EMCY + 2), 1);
    (void)dg_bus_frames_controller(frames_rig.bus, DG_S(6), DG_HOST_BUS_OFF);
    (void)dg_bus_frames_controller(frames_rig.bus, DG_S(6), DG_HOST_BUS_PASSIVE); /* it stays off */
    frames_rig.count = 0;
    (void)frames_rig_ask(DG_S(6), 1);
    assert_int_equal(frames_rig.count, 0);
    (void)dg_bus_frames_controller(frames_rig.bus, DG_S(7), DG_HOST_BUS_ACTIVE);
    assert_int_equal(frames_rig_count(EMCY + 2), 2); /* 8140h, 0000h */
    frames_rig_bend(1, "overrun", true, 1, DG_S(8));
    frames_rig.count = 0;
    (void)frames_rig_ask(DG_S(8), 1);
    assert_int_equal(frames_rig_code(0), 0x8110);
    assert_int_equal(frames_rig_count(SDO + 2), 0);
    (void)frames_rig_ask(DG_S(9), 1);
    assert_int_equal(frames_rig_count(SDO + 2), 1);
}

/* A power cycle does not heal the bus. */
static void a_controller_outlives_the_power(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 1);
    frames_rig_bend(0, "bus_off", true, 0, DG_S(2));
    dg_bus_look(frames_rig.bus, DG_S(3));
    assert_int_equal(dg_encoder_power(&frames_rig.control[0], DG_S(3), false), 0);
    (void)dg_bus_changed(frames_rig.bus, 0, DG_S(3));
    assert_false(dg_bus_frames_listens(frames_rig.bus, 0x601));
    assert_int_equal(dg_encoder_power(&frames_rig.control[0], DG_S(3), true), 0);
    (void)dg_bus_changed(frames_rig.bus, 0, DG_S(3));
    assert_int_equal(frames_rig.count, 0);
    (void)frames_rig_ask(DG_S(4), 0);
    assert_int_equal(frames_rig.count, 0);
    frames_rig_bend(0, "bus_off", false, 0, DG_S(5));
    assert_int_equal(frames_rig_code(0), 0x8140);
}

/* The state may be one of another encoder, which has changed what it listens to as often. */
static void a_restored_one_is_followed(void **state)
{
    static uint8_t saved[sizeof frames_rig.places[0]];

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 2);
    assert_int_equal(dg_host_save(frames_rig.host[0], saved, sizeof saved), DG_HOST_OK);
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 2);
    assert_int_equal(dg_host_power(frames_rig.host[0], DG_S(1), false), DG_HOST_OK);
    (void)dg_bus_changed(frames_rig.bus, 0, DG_S(1));
    dg_bus_look(frames_rig.bus, DG_S(2));
    assert_int_equal(dg_host_restore(frames_rig.host[1], saved, sizeof saved), DG_HOST_OK);
    (void)dg_bus_changed(frames_rig.bus, 1, DG_S(2));
    assert_true(dg_bus_frames_listens(frames_rig.bus, ASK + 1));
    assert_false(dg_bus_frames_listens(frames_rig.bus, ASK + 2));
    (void)frames_rig_ask(DG_S(2), 0);
    assert_int_equal(frames_rig_count(SDO + 1), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_at_one_moment),
        cmocka_unit_test(they_hear_each_other),
        cmocka_unit_test(those_of_another_bit_rate_are_deaf_and_mute),
        cmocka_unit_test(the_slowest_bit_rate),
        cmocka_unit_test(a_bus_is_there_or_not),
        cmocka_unit_test(frames_have_their_time),
        cmocka_unit_test(a_flood_is_over_at_once),
        cmocka_unit_test(too_much_makes_them_wait),
        cmocka_unit_test(a_late_host),
        cmocka_unit_test(a_port_without_room),
        cmocka_unit_test(answers_wait_for_the_memory),
        cmocka_unit_test(what_finds_no_room_is_lost),
        cmocka_unit_test(late_and_twice),
        cmocka_unit_test(controllers),
        cmocka_unit_test(a_controller_outlives_the_power),
        cmocka_unit_test(a_restored_one_is_followed),
    };
    return cmocka_run_group_tests_name("a bus of frames", tests, NULL, NULL);
}

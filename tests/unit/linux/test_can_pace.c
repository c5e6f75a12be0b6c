/* SPDX-License-Identifier: MIT */
/* Frames that take their time on the wire (pace=1), and the load of a bus. In real time: only what
 * a busy machine cannot spoil is asked for, so no upper bounds. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "can_rig.h"

static void set(struct can_rig *self, const char *assignment)
{
    assert_int_equal(lx_plan_add_assignment(&self->wire.settings, assignment, 9, &self->error), 0);
}

static void forget_settings(struct can_rig *self)
{
    lx_plan_free_settings(&self->wire.settings);
}

/* A bus of one encoder whose boot-up is through; NULL: nothing is set. */
static struct can_wire *open_bus(struct can_rig *self, const char *assignment)
{
    can_rig_plan(self, 1);
    if (assignment != NULL) {
        set(self, assignment);
    }
    can_rig_open(self, 1);
    struct can_wire *wire = can_rig_wire(self);
    can_rig_run(self, DG_MS(2));
    wire->count = 0;
    return wire;
}

static int tear_down(void **state)
{
    forget_settings(*state);
    return can_rig_tear_down(state);
}

static struct dg_bus *bus_of(const struct can_rig *self)
{
    return self->bus->core;
}

/* The encoder answers so many requests that come at once, by 8 bytes each: the CAN-IDs of its
   objects, in this order. */
static void ask(struct can_wire *wire, uint8_t first, size_t count)
{
    const struct lx_can_setup *setup = &wire->can.setup;
    for (size_t i = 0; i < count; i++) {
        const struct dg_can_frame frame = {
            .id = 0x601, .dlc = 8, .data = {0x40, 0x00, 0x10, 0, (uint8_t)(first + i)}};
        setup->rx(setup->ctx, lx_now(), &frame);
    }
    setup->settle(setup->ctx, lx_now());
}

static void wait_for(struct can_rig *self, size_t count)
{
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    while (can_rig_wire(self)->count < count && lx_now() < end) {
        can_rig_turn(self);
    }
    assert_int_equal(can_rig_wire(self)->count, count);
}

/* Frames of the test's with the CAN-IDs from `first` on, past the bus. */
static void send_frames(struct can_wire *wire, uint16_t first, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct dg_can_frame frame = {.id = (uint16_t)(first + i), .dlc = 8};
        lx_can_send(&wire->can, &frame);
    }
}

static void expect_in_order(const struct can_wire *wire, uint16_t first, size_t count)
{
    assert_int_equal(wire->count, count);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(wire->frame[i].id, first + i);
    }
}

static void unless_it_is_set_nothing_waits(void **state)
{
    static const char *const rows[] = {NULL, "pace=0"};
    struct can_rig *self = *state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct can_wire *wire = open_bus(self, rows[i]);
        ask(wire, 0, 2 * DG_BUS_FRAMES_PACED);
        assert_int_equal(wire->count, 2 * DG_BUS_FRAMES_PACED);
        assert_false(lx_can_is_paused(&wire->can));
        can_rig_shut(self);
    }
}

static void plans_that_cannot_be(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    self->plan.file = "rig.ini";
    set(self, "pace=2");
    assert_int_equal(can_rig_make_slcan(self, 1), -1);
    assert_string_equal(lx_error_line(&self->error).text, "rig.ini:9: pace=2: expected 0 or 1");
    self->plan.file = NULL; /* the command line */
    assert_int_equal(can_rig_make_slcan(self, 1), -1);
    assert_string_equal(lx_error_line(&self->error).text, "pace=2: expected 0 or 1");
}

/* Not before the one before it is through. The wire's own bit rate comes before the encoder's. */
static void each_frame_has_its_time(void **state)
{
    struct can_rig *self = *state;
    struct can_wire *wire = open_bus(self, "pace=1");
    assert_int_equal(dg_bus_frames_bit_rate(bus_of(self)), 250000);
    wire->bit_rate = 100000;
    wire->can.setup.settle(wire->can.setup.ctx, lx_now());
    assert_int_equal(dg_bus_frames_bit_rate(bus_of(self)), 100000);
    const dg_ns begin = lx_now();
    ask(wire, 0, 10);
    assert_true(wire->count < 10);
    wait_for(self, 10);
    for (size_t i = 1; i < 10; i++) {
        assert_true(dg_elapsed(wire->at[i], begin) >= i * DG_US(1350)); /* 135 bits */
    }
    assert_int_equal(wire->can.counters.stalls, 0);
    assert_int_equal(wire->can.counters.lost, 0);
}

/* Too much makes the encoders wait, and what comes in: it is not read until half of it is gone. */
static void a_full_queue_holds_the_encoders(void **state)
{
    struct can_rig *self = *state;
    struct can_wire *wire = open_bus(self, "pace=1");
    ask(wire, 0, DG_BUS_FRAMES_PACED / 2u);
    assert_false(wire->paused);
    ask(wire, 0, DG_BUS_FRAMES_PACED);
    assert_true(lx_can_is_paused(&wire->can));
    assert_true(wire->paused);
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    while (lx_can_is_paused(&wire->can)) {
        assert_true(lx_now() < end);
        can_rig_turn(self);
    }
    assert_false(wire->paused);
    wait_for(self, DG_BUS_FRAMES_PACED + DG_BUS_FRAMES_PACED / 2u);
    assert_int_equal(dg_bus_frames_counters(bus_of(self))->stalls, 1);
    assert_int_equal(dg_bus_frames_counters(bus_of(self))->lost, 0);
    assert_int_equal(self->bus->late, 0);
}

/* A wire without room, and time that has passed meanwhile. */
static void a_wire_without_room(void **state)
{
    struct can_rig *self = *state;
    struct can_wire *wire = open_bus(self, NULL);
    wire->full = true;
    send_frames(wire, 0x100, 3);
    assert_true(wire->can.stalled);
    assert_true(wire->paused);
    can_rig_run(self, DG_MS(20));
    assert_int_equal(wire->count, 0);
    assert_int_equal(wire->can.count, 3);
    wire->full = false;
    wait_for(self, 3);
    expect_in_order(wire, 0x100, 3);
    can_rig_run(self, DG_MS(5));
    assert_false(wire->can.stalled);
    assert_false(wire->paused);
    /* What waits for nobody is forgotten, and the timer finds nothing. */
    wire->full = true;
    send_frames(wire, 0x103, 2);
    lx_can_discard(&wire->can);
    wire->full = false;
    can_rig_run(self, DG_MS(5));
    assert_int_equal(wire->count, 3);
    assert_int_equal(wire->can.counters.lost, 2);
    assert_int_equal(wire->can.counters.stalls, 2);
}

/* Frames come as fast as they go: the queue goes on in the same memory. */
static void a_queue_that_never_empties(void **state)
{
    struct can_rig *self = *state;
    struct can_wire *wire = open_bus(self, NULL);
    wire->full = true;
    send_frames(wire, 0x100, 64);
    wire->full = false;
    wait_for(self, 64);
    wire->full = true;
    send_frames(wire, 0x140, 64);
    wire->full = false;
    wait_for(self, 128);
    expect_in_order(wire, 0x100, 128);
    assert_true(wire->can.capacity <= 64);
}

/* An encoder that wants to send more than its bus carries: each frame of it in its time, and it
   still answers. */
static void an_event_timer_below_the_bus_time(void **state)
{
    struct can_rig *self = *state;
    struct can_wire *wire = open_bus(self, "pace=1");
    const struct dg_can_frame start = {.id = 0, .dlc = 2, .data = {1, 1}};
    wire->bit_rate = 20000; /* 4.75 ms for 4 bytes */
    can_rig_write(self, 0, 0x1800, 5, 1, 2);
    wire->can.setup.rx(wire->can.setup.ctx, lx_now(), &start);
    wire->can.setup.settle(wire->can.setup.ctx, lx_now());
    const dg_ns begin = lx_now();
    do { /* a machine that stands still wants less */
        can_rig_run(self, DG_MS(300));
    } while (dg_bus_frames_counters(bus_of(self))->stalls == 0 &&
             dg_elapsed(lx_now(), begin) < CAN_RIG_PATIENCE);
    const dg_ns span = dg_elapsed(lx_now(), begin);
    assert_true(can_rig_sent(self, 0x181) <= 1 + span / DG_US(4750));
    assert_true(can_rig_sent(self, 0x181) > 10);
    assert_true(dg_bus_frames_counters(bus_of(self))->stalls > 0);
    assert_int_equal(wire->can.counters.lost, 0);
}

/* --- load --- */

static uint32_t load_of(struct can_rig *self)
{
    return ((const struct lx_can_bus *)self->bus)->load.permille;
}

/* A second passes for the bus. */
static void next_window(struct can_rig *self)
{
    struct lx_can_bus *bus = (struct lx_can_bus *)self->bus;
    const struct lx_can_setup *setup = &bus->can->setup;
    setup->settle(setup->ctx, bus->load.since + DG_BUS_LOAD_WINDOW);
}

static void what_is_sent_and_received_is_load(void **state)
{
    struct can_rig *self = *state;
    struct can_wire *wire = open_bus(self, NULL);
    const struct lx_can_setup *setup = &wire->can.setup;
    const struct dg_can_frame strange = {.id = 0x555, .dlc = 8};
    const struct dg_can_frame request = {.id = 0x555, .rtr = true, .dlc = 8};
    next_window(self);
    next_window(self);
    assert_int_equal(load_of(self), 0);
    ask(wire, 0, 50); /* which are answered */
    for (int i = 0; i < 100; i++) {
        setup->rx(setup->ctx, lx_now(), &strange);
    }
    for (int i = 0; i < 100; i++) {
        setup->rx(setup->ctx, lx_now(), &request);
    }
    next_window(self); /* 100 * (135 + 135 + 55) bits at 250 kBd */
    assert_int_equal(load_of(self), 130);
    wire->bit_rate = 50000;
    setup->settle(setup->ctx, lx_now());
    ask(wire, 0, 250);
    assert_false(((const struct lx_can_bus *)self->bus)->load.overloaded);
    next_window(self);
    assert_int_equal(load_of(self), 1350);
    assert_true(((const struct lx_can_bus *)self->bus)->load.overloaded);
    next_window(self);
    assert_int_equal(load_of(self), 0);
    assert_false(((const struct lx_can_bus *)self->bus)->load.overloaded);
}

/* On the bus of an adapter: extended frames take their time, too; its bit rate is the channel's. */
static void load_of_an_adapter(void **state)
{
    static const char lines[] = "T00000185411223344\rR000001854\rt5552AABB\rr6812\rt5559\r";
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    set(self, "pace=1");
    can_rig_open_slcan(self, 1);
    can_rig_connect(self); /* at 250 kBd */
    const struct dg_bus *bus = bus_of(self);
    assert_int_equal(dg_bus_frames_bit_rate(bus), 250000);
    uint64_t before = dg_bus_frames_bits(bus);
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    assert_int_equal(write(self->client, lines, sizeof lines - 1), sizeof lines - 1);
    while (dg_bus_frames_bits(bus) - before < (80 + 40) + 80 + (55 + 20) + 55 && lx_now() < end) {
        can_rig_turn(self);
    }
    can_rig_run(self, CAN_RIG_QUIET);
    assert_int_equal(dg_bus_frames_bits(bus) - before, (80 + 40) + 80 + (55 + 20) + 55);
    before = dg_bus_frames_bits(bus);
    assert_true(can_rig_answers(self, 1));
    assert_int_equal(dg_bus_frames_bits(bus) - before, 2 * 135);
    can_rig_say(self, "C\rS1\rO\r");
    assert_int_equal(dg_bus_frames_bit_rate(bus), 20000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(unless_it_is_set_nothing_waits, can_rig_set_up, tear_down),
        cmocka_unit_test_setup_teardown(plans_that_cannot_be, can_rig_set_up, tear_down),
        cmocka_unit_test_setup_teardown(each_frame_has_its_time, can_rig_set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_full_queue_holds_the_encoders, can_rig_set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_queue_that_never_empties, can_rig_set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_wire_without_room, can_rig_set_up, tear_down),
        cmocka_unit_test_setup_teardown(an_event_timer_below_the_bus_time, can_rig_set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(load_of_an_adapter, can_rig_set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_is_sent_and_received_is_load, can_rig_set_up,
                                        tear_down),
    };
    return cmocka_run_group_tests_name("pace and load of a CAN bus", tests, NULL, NULL);
}

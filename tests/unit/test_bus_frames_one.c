/* SPDX-License-Identifier: MIT */
/*
 * One encoder on a bus of frames in virtual time behaves as its handle, with all faults of its
 * wire: the same frames at the same moments, the same deadlines.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"
#include "frames_rig.h"

static uint32_t chance;

static uint32_t pick(uint32_t n)
{
    chance = chance * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)chance * n >> 32);
}

static const struct {
    uint16_t id;
    uint8_t dlc;
    uint8_t data[8];
} said[] = {
    {0x000, 2, {1, 0}},
    {0x000, 2, {0x80, 0}},
    {0x000, 2, {0x82, 1}},
    {0x080, 0, {0}},
    {0x601, 8, {0x40, 0x04, 0x60}},
    {0x601, 8, {0x2B, 0x17, 0x10, 0, 30}},
    {0x601, 8, {0x2B, 0x00, 0x18, 5, 7}},
    {0x601, 8, {0x2F, 0x00, 0x18, 2, 1}},
    {0x601, 8, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}},
    {0x601, 8, {0xA0, 0x08, 0x10, 0, 21}},
    {0x601, 8, {0xA3}},
    {0x602, 8, {0x40, 0x04, 0x60}},
    {0x601, 5, {0x40, 0x04, 0x60}},
    {0x181, 0, {0}},
    {0x701, 0, {0}},
    {0x7E5, 8, {0x04, 1}},
    {0x7E5, 8, {0x5E}},
};

static struct dg_host *bare;
static struct host_rig_place bare_place;
static struct dg_host_panel *panel;
static struct host_rig_place panel_place;

/* What the handle has said of moments to come: a frame that a fault has made late. */
static struct dg_host_event early[2u * DG_HOST_QUEUE];
static size_t early_count;

static void fetch_bare(void)
{
    while (dg_host_receive(bare, &early[early_count]) == 1) {
        early_count++;
        assert_true(early_count < DG_COUNT(early));
    }
}

/* What the handle has sent up to `now` is what the bus has: the same frames at the same moments. */
static void compare(dg_ns now)
{
    size_t done = 0;

    fetch_bare();
    while (done < early_count && early[done].at <= now) {
        assert_true(done < frames_rig.count);
        const struct dg_host_event *event = &early[done];
        const struct dg_tap_event *other = &frames_rig.sent[done++].event;
        assert_int_equal(event->at, other->at);
        assert_int_equal(event->id, other->frame.id);
        assert_int_equal(event->flags, 0);
        assert_int_equal(event->length, other->frame.dlc);
        assert_memory_equal(event->data, other->frame.data, event->length);
    }
    assert_int_equal(done, frames_rig.count);
    frames_rig.count = 0;
    early_count -= done;
    memmove(early, early + done, early_count * sizeof early[0]);
}

static void say_to_both(dg_ns now, unsigned row, bool remote)
{
    struct dg_host_event event = {.at = now,
                                  .id = said[row].id,
                                  .flags = remote ? DG_HOST_REMOTE : 0,
                                  .kind = DG_HOST_CAN,
                                  .length = said[row].dlc};
    struct dg_tap_event other = {.at = now,
                                 .kind = DG_TAP_FRAME,
                                 .frame = {.id = said[row].id, .rtr = remote, .dlc = event.length}};

    memcpy(event.data, said[row].data, sizeof said[row].data);
    memcpy(other.frame.data, said[row].data, sizeof said[row].data);
    assert_int_equal(dg_host_send(bare, &event), DG_HOST_OK);
    (void)dg_host_step(bare, now);
    (void)dg_bus_rx(frames_rig.bus, &other);
}

static uint32_t state_of_both;

static void tell_bare(dg_ns now, uint32_t what)
{
    const struct dg_host_event event = {.at = now, .id = what, .kind = DG_HOST_BUS};

    assert_int_equal(dg_host_send(bare, &event), DG_HOST_OK);
    (void)dg_host_step(bare, now);
}

/* A bus says again what the controller is, as a reset forgets it. */
static void warm_both(dg_ns now)
{
    const int64_t value = 1000 * (int64_t)pick(120);

    tell_bare(now, state_of_both);
    assert_int_equal(dg_host_world_set(bare, now, "temperature", value), DG_HOST_OK);
    (void)dg_host_step(bare, now);
    dg_bus_look(frames_rig.bus, now);
    dg_host_world(frames_rig.host[0])->temperature_mdegc = (int32_t)value;
    (void)dg_bus_changed(frames_rig.bus, 0, now);
}

/* The state of a wire's controller outlasts that. */
static void switch_both(dg_ns now)
{
    state_of_both = DG_HOST_BUS_ACTIVE;
    tell_bare(now, state_of_both);
    (void)dg_bus_frames_controller(frames_rig.bus, now, DG_HOST_BUS_ACTIVE);
    for (int on = 0; on < 2; on++) {
        assert_int_equal(dg_host_power(bare, now, on != 0), DG_HOST_OK);
        dg_bus_look(frames_rig.bus, now);
        assert_int_equal(dg_host_power(frames_rig.host[0], now, on != 0), DG_HOST_OK);
        (void)dg_bus_changed(frames_rig.bus, 0, now);
    }
}

/* Until it is cleared or, where it happens to single frames, to some of them. */
static void bend_both(dg_ns now)
{
    static const struct {
        const char *name;
        bool single;
    } rows[] = {
        {"wire_drop", true},      {"wire_deaf", true},      {"wire_delay", true},
        {"wire_damage", true},    {"wire_duplicate", true}, {"overrun", true},
        {"error_passive", false}, {"bus_off", false},
    };
    const size_t i = pick(DG_COUNT(rows));
    const uint32_t count = rows[i].single ? pick(4) : 0;
    const bool on = pick(3) != 0;
    char line[64];
    char answer[64];

    if (count > 0 && on) {
        (void)snprintf(line, sizeof line, "FAUL:SET %s,COUN %u", rows[i].name, (unsigned)count);
        assert_int_equal(dg_host_scpi(panel, now, line, answer, sizeof answer), 0);
    } else {
        assert_int_equal(dg_host_fault_set(panel, now, rows[i].name, on), DG_HOST_OK);
    }
    tell_bare(now, state_of_both);
    frames_rig_bend(0, rows[i].name, on, count, now);
}

static void do_to_both(dg_ns now)
{
    const uint32_t what = pick(panel != NULL ? 24 : 20);
    const uint32_t state = pick(3);

    if (what == 0) {
        warm_both(now);
    } else if (what == 1 && (state_of_both != DG_HOST_BUS_OFF || state == DG_HOST_BUS_ACTIVE)) {
        /* Bus-off of a wire lasts until it is active, that of a handle as its host says. */
        state_of_both = state;
        tell_bare(now, state);
        (void)dg_bus_frames_controller(frames_rig.bus, now, (enum dg_host_bus)state);
    } else if (what == 2) {
        tell_bare(now, DG_HOST_BUS_OVERRUN);
        (void)dg_bus_frames_controller(frames_rig.bus, now, DG_HOST_BUS_OVERRUN);
    } else if (what == 20) {
        switch_both(now);
    } else if (what > 20) {
        bend_both(now);
    } else {
        say_to_both(now, pick(DG_COUNT(said)), pick(8) == 0);
    }
}

static void begin_both(uint32_t seed, bool faults)
{
    chance = seed;
    state_of_both = DG_HOST_BUS_ACTIVE;
    early_count = 0;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 1);
    bare = host_rig_make(&bare_place, "f3668");
    assert_int_equal(dg_host_set(bare, "node", "1"), DG_HOST_OK);
    assert_int_equal(dg_host_power(bare, 0, true), DG_HOST_OK);
    (void)dg_host_step(bare, DG_S(1));
    host_rig_drain(bare);
    panel = faults ? dg_host_panel_make(&panel_place, sizeof panel_place, bare) : NULL;
    assert_true(panel != NULL || !faults);
}

static void compare_lives(uint32_t seed, bool faults)
{
    dg_ns now = DG_S(1);

    begin_both(seed, faults);
    for (unsigned i = 0; i < 100; i++) {
        now += pick(4) == 0 ? 0 : pick(40000000);
        (void)dg_host_step(bare, now);
        (void)dg_bus_step(frames_rig.bus, now);
        do_to_both(now);
        compare(now);
        /* Many deadlines at once, each at its own moment. */
        now += DG_MS(20);
        const dg_ns next = dg_bus_step(frames_rig.bus, now);
        const dg_ns own = dg_host_step(bare, now);
        compare(now);
        assert_true(early_count > 0 || own == next);
    }
}

static void a_bus_of_one_is_its_handle(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 20; seed++) {
        compare_lives(seed, false);
    }
}

static void a_bus_of_one_is_its_handle_with_faults(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 60; seed++) {
        compare_lives(seed, true);
    }
}

static void sizes(void **state)
{
    struct dg_bus_frames_setup wire = {.rooms = UINT16_MAX};

    (void)state;
    assert_true(dg_host_size_with_port(&dg_f3668, &dg_cia406_side) <= 2000);
    assert_int_equal(dg_bus_size(&dg_bus_frames, 0), 0);
    assert_int_equal(dg_bus_size(&dg_bus_frames, DG_BUS_FRAMES_ENCODERS + 1u), 0);
    assert_true(dg_bus_size(&dg_bus_frames, DG_BUS_FRAMES_ENCODERS) <=
                (size_t)DG_BUS_FRAMES_ENCODERS * 256u + 5000u);
    assert_null(frames_rig_make_bus(&wire, 1));
    wire.rooms = 1;
    assert_non_null(frames_rig_make_bus(&wire, 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bus_of_one_is_its_handle),
        cmocka_unit_test(a_bus_of_one_is_its_handle_with_faults),
        cmocka_unit_test(sizes),
    };
    return cmocka_run_group_tests_name("one encoder on a bus of frames", tests, NULL, NULL);
}

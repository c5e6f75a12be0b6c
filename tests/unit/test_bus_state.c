/* SPDX-License-Identifier: MIT */
/*
 * States of buses of each medium, saved at any moment of a scene: what goes on from them in other,
 * dirty memory is what would have gone on, byte for byte and nanosecond for nanosecond. What is not
 * such a state, or not of this bus, is refused and changes nothing.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus_scenes.h"
#include "drehgeber/bus_characters.h"
#include "drehgeber/bus_edges.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/crc.h"
#include "drehgeber/devices.h"
#include "effort.h"

#define STATE_MAX 32768u
#define FRAME_EDGES 160u

static struct bus_world worlds[2];
static uint8_t of_bus[STATE_MAX];
static uint8_t of_hosts[BUS_SCENE_ENCODERS][HOST_RIG_MEMORY_MAX];
static size_t sizes[1 + BUS_SCENE_ENCODERS];
static struct bus_told expected[BUS_SCENE_TOLD_MAX];

/* ------------------------------------------------------------ there and back */

static int save(struct bus_world *world)
{
    for (size_t i = 0; i < dg_bus_count(world->bus); i++) {
        sizes[1 + i] = dg_host_state_size(world->hosts[i]);
        assert_in_range(sizes[1 + i], 1, sizeof of_hosts[i]);
        assert_int_equal(dg_host_save(world->hosts[i], of_hosts[i], sizes[1 + i]), DG_HOST_OK);
    }
    sizes[0] = dg_bus_state_size(world->bus);
    assert_in_range(sizes[0], 1, sizeof of_bus);
    return dg_bus_save(world->bus, of_bus, sizes[0]);
}

static void restore_hosts(struct bus_world *world)
{
    for (size_t i = 0; i < dg_bus_count(world->bus); i++) {
        assert_int_equal(dg_host_restore(world->hosts[i], of_hosts[i], sizes[1 + i]), DG_HOST_OK);
    }
}

/* What is the host's, and not in a state. */
static void hand_over(const struct bus_world *from, struct bus_world *to)
{
    for (size_t i = 0; i < BUS_SCENE_ENCODERS; i++) {
        to->control[i].faults = from->control[i].faults;
    }
    to->answer = from->answer;
    to->ticket = from->ticket;
    to->now = from->now;
}

/* In other memory, and what was in the first one is gone. */
static void go_on_elsewhere(const struct bus_scene *scene)
{
    const size_t told = bus_told_count;

    assert_int_equal(save(&worlds[0]), DG_HOST_OK);
    bus_scene_make(scene, &worlds[1]);
    hand_over(&worlds[0], &worlds[1]);
    memset(&worlds[0], 0x5A, sizeof worlds[0]);
    restore_hosts(&worlds[1]);
    assert_int_equal(dg_bus_restore(worlds[1].bus, of_bus, sizes[0]), DG_HOST_OK);
    bus_told_count = told;
}

static void compare_with_expected(const struct bus_scene *scene, size_t count, unsigned i)
{
    for (size_t n = 0; n < count && n < bus_told_count; n++) {
        if (memcmp(&bus_told[n], &expected[n], sizeof expected[n]) != 0) {
            fail_msg(
                "%s, saved behind operation %u: event %zu is %llu %x %x %x %x, not %llu %x %x %x %x",
                scene->name, i, n, (unsigned long long)bus_told[n].at, bus_told[n].what[0],
                bus_told[n].what[1], bus_told[n].what[2], bus_told[n].what[3],
                (unsigned long long)expected[n].at, expected[n].what[0], expected[n].what[1],
                expected[n].what[2], expected[n].what[3]);
        }
    }
    assert_int_equal(bus_told_count, count);
}

/* The moment `part` of 4 between operation `i` and the next one. */
static dg_ns between(const struct bus_scene *scene, unsigned i, unsigned part)
{
    const dg_ns at = bus_scene_moment(scene, i);

    return at + (bus_scene_moment(scene, i + 1u) - at) * part / 4u;
}

static void save_everywhere(const struct bus_scene *scene)
{
    const uint32_t step = effort(9, 1);

    bus_scene_begin(scene, &worlds[0]);
    bus_scene_play(scene, &worlds[0], 0, BUS_SCENE_OPERATIONS);
    const size_t count = bus_told_count;
    const dg_ns next = dg_bus_next(worlds[0].bus);
    memcpy(expected, bus_told, count * sizeof expected[0]);
    assert_true(count / 4u > BUS_SCENE_OPERATIONS);
    for (unsigned i = 0; i < 4u * (BUS_SCENE_OPERATIONS - 1u); i += step) {
        bus_scene_begin(scene, &worlds[0]);
        bus_scene_play(scene, &worlds[0], 0, i / 4u + 1u);
        if (i % 4u != 0) {
            bus_scene_pass_to(&worlds[0], between(scene, i / 4u, i % 4u));
        }
        go_on_elsewhere(scene);
        bus_scene_play(scene, &worlds[1], i / 4u + 1u, BUS_SCENE_OPERATIONS);
        compare_with_expected(scene, count, i / 4u);
        assert_int_equal(dg_bus_next(worlds[1].bus), next);
    }
}

static const struct bus_scene *scene_of(const char *name)
{
    size_t i = 0;

    while (strcmp(bus_scenes[i].name, name) != 0) {
        i++;
    }
    return &bus_scenes[i];
}

static void bend_once(struct bus_world *world, size_t place, enum dg_wire_fault fault)
{
    struct dg_faults *faults = &world->control[place].faults;

    faults->wire |= 1u << fault;
    faults->slot[fault] = (uint8_t)fault;
    faults->fault[fault] =
        (struct dg_fault){.active = true, .left = 1, .probability_ppm = 1000000, .until = DG_NEVER};
}

/* For its position. */
static void ask_line(struct bus_world *world, uint8_t address)
{
    const uint8_t request[] = {address, 0x42, (uint8_t)(address ^ 0x42u)};

    for (size_t i = 0; i < sizeof request; i++) {
        const struct dg_tap_event event = {.at = world->now,
                                           .kind = DG_TAP_CHARACTER,
                                           .character = {9600, 'E', request[i], false}};
        (void)dg_bus_rx(world->bus, &event);
    }
}

static void what_goes_on_is_the_same(void **state)
{
    (void)state;
    for (size_t i = 0; i < bus_scene_count; i++) {
        save_everywhere(&bus_scenes[i]);
    }
}

/* Characters that overlap by less than one: what is told of the one is lost in the other. */
static void replies_that_overlap(void **state)
{
    const struct bus_scene *scene = scene_of("characters");
    const dg_ns character = dg_bit_times_ns(11, 9600);
    const dg_ns late = 300 * MS; /* wire_delay */
    size_t count = 0;

    (void)state;
    for (unsigned quarter = 0; quarter < 120; quarter++) {
        struct bus_world *world = &worlds[0];
        bus_scene_begin(scene, world);
        bend_once(world, 1, DG_WIRE_DELAY);
        ask_line(world, 0x41);
        bus_scene_pass_to(world, READY + late + character * 2u / 5u);
        ask_line(world, 0x40);
        if (quarter > 0) {
            bus_scene_pass_to(world, world->now + quarter * character / 4u);
            go_on_elsewhere(scene);
            world = &worlds[1];
        }
        bus_scene_pass_to(world, READY + SECOND);
        if (quarter == 0) {
            count = bus_told_count;
            memcpy(expected, bus_told, count * sizeof expected[0]);
        }
        compare_with_expected(scene, count, quarter);
    }
}

/* A frame of so many clocks, saved behind edge `edge` of it; 0: not at all. */
static void clock_bent_frame(const struct bus_scene *scene, enum dg_wire_fault fault, unsigned edge)
{
    struct bus_world *world = &worlds[0];

    bus_scene_begin(scene, world);
    bend_once(world, 0, fault);
    for (unsigned n = 1; n <= FRAME_EDGES; n++) {
        world->now += 500;
        (void)dg_bus_edge(world->bus, world->now, n % 2u == 0);
        if (n == edge) {
            go_on_elsewhere(scene);
            world = &worlds[1];
        }
    }
    bus_scene_pass_to(world, world->now + MS);
}

/* What a fault does to a frame it does to the end of it. */
static void frames_that_are_bent(void **state)
{
    static const char *const scenes[] = {"chain", "line of one"};
    static const enum dg_wire_fault faults[] = {DG_WIRE_DELAY, DG_WIRE_DAMAGE, DG_WIRE_DROP};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(scenes) * DG_COUNT(faults); i++) {
        const struct bus_scene *scene = scene_of(scenes[i % DG_COUNT(scenes)]);
        const enum dg_wire_fault fault = faults[i / DG_COUNT(scenes)];
        clock_bent_frame(scene, fault, 0);
        const size_t count = bus_told_count;
        memcpy(expected, bus_told, count * sizeof expected[0]);
        for (unsigned edge = 1; edge <= FRAME_EDGES; edge++) {
            clock_bent_frame(scene, fault, edge);
            compare_with_expected(scene, count, edge);
        }
    }
}

/* The same bus goes back to where it was, as often as one likes. */
static void a_bus_may_go_back(void **state)
{
    (void)state;
    for (size_t i = 0; i < bus_scene_count; i++) {
        const struct bus_scene *scene = &bus_scenes[i];
        bus_scene_begin(scene, &worlds[0]);
        bus_scene_play(scene, &worlds[0], 0, 40);
        assert_int_equal(save(&worlds[0]), DG_HOST_OK);
        hand_over(&worlds[0], &worlds[1]);
        const dg_ns next = dg_bus_next(worlds[0].bus);
        size_t count = 0;
        for (unsigned turn = 0; turn < 3; turn++) {
            bus_told_count = 0;
            bus_scene_play(scene, &worlds[0], 40, 60);
            if (turn == 0) {
                count = bus_told_count;
                memcpy(expected, bus_told, count * sizeof expected[0]);
            }
            compare_with_expected(scene, count, 40);
            restore_hosts(&worlds[0]);
            assert_int_equal(dg_bus_restore(worlds[0].bus, of_bus, sizes[0]), DG_HOST_OK);
            hand_over(&worlds[1], &worlds[0]);
            assert_int_equal(dg_bus_next(worlds[0].bus), next);
        }
    }
}

/* Wherever it is: there is no pointer in it, and nothing that nobody has set. */
static void a_state_says_the_same_anywhere(void **state)
{
    static uint8_t first[STATE_MAX];

    (void)state;
    for (size_t i = 0; i < bus_scene_count; i++) {
        for (size_t n = 0; n < 2; n++) {
            bus_scene_begin(&bus_scenes[i], &worlds[n]);
            bus_scene_play(&bus_scenes[i], &worlds[n], 0, 50);
            assert_int_equal(save(&worlds[n]), DG_HOST_OK);
            if (n == 0) {
                memcpy(first, of_bus, sizes[0]);
            }
        }
        assert_memory_equal(of_bus, first, sizes[0]);
        assert_memory_equal(of_bus, "DGBUSST\1", 8);
    }
}

/* ------------------------------------------------------------ what is refused */

/* A state of `scene`, in a world that can go on from it. */
static void save_one(const struct bus_scene *scene, unsigned operations)
{
    bus_scene_begin(scene, &worlds[0]);
    bus_scene_play(scene, &worlds[0], 0, operations);
    assert_int_equal(save(&worlds[0]), DG_HOST_OK);
    bus_scene_make(scene, &worlds[1]);
    hand_over(&worlds[0], &worlds[1]);
    restore_hosts(&worlds[1]);
}

static uint8_t untouched[BUS_SCENE_BUS_MAX];

static void assert_refused(int result, size_t n)
{
    memcpy(untouched, worlds[1].memory, sizeof untouched);
    assert_int_equal(dg_bus_restore(worlds[1].bus, of_bus, n), result);
    assert_memory_equal(untouched, worlds[1].memory, sizeof untouched);
}

static void what_is_damaged_is_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < bus_scene_count; i++) {
        save_one(&bus_scenes[i], 30);
        for (size_t at = 0; at < sizes[0]; at++) {
            of_bus[at] ^= 0x10u;
            memcpy(untouched, worlds[1].memory, sizeof untouched);
            assert_true(dg_bus_restore(worlds[1].bus, of_bus, sizes[0]) < 0);
            assert_memory_equal(untouched, worlds[1].memory, sizeof untouched);
            of_bus[at] ^= 0x10u;
        }
        for (size_t n = 0; n < sizes[0]; n++) {
            assert_refused(DG_HOST_ERR_SPACE, n);
        }
        assert_int_equal(dg_bus_save(worlds[0].bus, of_bus, sizes[0] - 1u), DG_HOST_ERR_SPACE);
        assert_int_equal(dg_bus_restore(worlds[1].bus, of_bus, sizes[0]), DG_HOST_OK);
    }
}

static void what_is_of_another_bus_is_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < bus_scene_count; i++) {
        save_one(&bus_scenes[i], 30);
        for (size_t other = 0; other < bus_scene_count; other++) {
            if (bus_scenes[other].medium != bus_scenes[i].medium) {
                bus_scene_begin(&bus_scenes[other], &worlds[1]);
                assert_refused(DG_HOST_ERR_OTHER, sizes[0]);
            }
        }
        bus_scene_make(&bus_scenes[i], &worlds[1]);
        restore_hosts(&worlds[1]);
        (void)dg_bus_detach(worlds[1].bus, 0, 0);
        assert_refused(DG_HOST_ERR_OTHER, sizes[0]);
    }
}

/* Encoders that wait for other moments than the state says would not go on as they did. */
static void what_does_not_go_with_its_encoders_is_refused(void **state)
{
    const struct bus_scene *scene = scene_of("characters");

    (void)state;
    save_one(scene, 30);
    (void)dg_host_step(worlds[1].hosts[0], worlds[0].now + SECOND);
    bus_scene_begin(scene, &worlds[0]);
    for (unsigned i = 0; i < 30; i++) {
        bus_scene_play(scene, &worlds[0], i, i + 1u);
        const bool waits = dg_host_next(worlds[0].hosts[0]) != DG_NEVER;
        if (waits) {
            assert_int_equal(save(&worlds[0]), DG_HOST_OK);
            assert_refused(DG_HOST_ERR_DAMAGED, sizes[0]);
            return;
        }
    }
    fail();
}

static void a_bus_with_less_room_for_frames(void **state)
{
    const struct bus_scene *scene = scene_of("frames in pace");

    (void)state;
    save_one(scene, 0);
    static const uint8_t upload[8] = {0x40, 0x00, 0x10};
    struct dg_tap_event event = {
        .at = worlds[0].now, .kind = DG_TAP_FRAME, .frame = {.id = 0x603, .dlc = 8}};
    memcpy(event.frame.data, upload, sizeof upload);
    for (unsigned n = 0; n < 8; n++) {
        (void)dg_bus_rx(worlds[0].bus, &event);
    }
    assert_int_equal(save(&worlds[0]), DG_HOST_OK);
    const struct dg_bus_frames_setup small = {
        .size = sizeof small, .room = worlds[1].rooms, .rooms = 3};
    const struct dg_bus_ops ops = {
        .tx = (void (*)(void *, size_t, const struct dg_tap_event *))abort};
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = &dg_bus_frames,
                                       .encoders = BUS_SCENE_ENCODERS,
                                       .wire = &small,
                                       .ops = &ops};
    worlds[1].bus = dg_bus_init(worlds[1].memory, sizeof worlds[1].memory, &setup);
    for (size_t i = 0; i < BUS_SCENE_ENCODERS; i++) {
        assert_int_equal(dg_bus_attach(worlds[1].bus, worlds[1].hosts[i], NULL), (int)i);
    }
    restore_hosts(&worlds[1]);
    assert_refused(DG_HOST_ERR_DAMAGED, sizes[0]);
}

/* Not before what is due was done, and told. */
static void a_bus_that_is_behind_is_not_saved(void **state)
{
    const struct bus_scene *scene = scene_of("characters");

    (void)state;
    save_one(scene, 10);
    assert_int_equal(dg_host_power(worlds[0].hosts[0], worlds[0].now, false), DG_HOST_OK);
    assert_int_equal(dg_host_power(worlds[0].hosts[0], worlds[0].now, true), DG_HOST_OK);
    assert_int_equal(save(&worlds[0]), DG_HOST_ERR_STATE);
    (void)dg_bus_changed(worlds[0].bus, 0, worlds[0].now);
    assert_int_equal(save(&worlds[0]), DG_HOST_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_goes_on_is_the_same),
        cmocka_unit_test(replies_that_overlap),
        cmocka_unit_test(frames_that_are_bent),
        cmocka_unit_test(a_bus_may_go_back),
        cmocka_unit_test(a_state_says_the_same_anywhere),
        cmocka_unit_test(what_is_damaged_is_refused),
        cmocka_unit_test(what_is_of_another_bus_is_refused),
        cmocka_unit_test(what_does_not_go_with_its_encoders_is_refused),
        cmocka_unit_test(a_bus_with_less_room_for_frames),
        cmocka_unit_test(a_bus_that_is_behind_is_not_saved),
    };
    return cmocka_run_group_tests_name("states of buses", tests, NULL, NULL);
}

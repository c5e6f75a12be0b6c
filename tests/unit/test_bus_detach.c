/* SPDX-License-Identifier: MIT */
/*
 * A plug is pulled: what an encoder was sending ends there, those behind it move up, and on another
 * bus it is an encoder like any other.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "character_rig.h"
#include "drehgeber/biss.h"
#include "drehgeber/interbus.h"
#include "edges_rig.h"
#include "frames_rig.h"
#include "ring_rig.h"

static struct host_rig_place other_memory;

/* ------------------------------------------------------------ characters */

static struct character_rig line;

static void a_reply_ends_in_its_character(void **state)
{
    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    const dg_ns begin = line.now + 3 * (dg_ns)CHARACTER + ANSWER;
    const uint32_t damaged = character_rig_device(&line, 0)->counters.damaged;

    character_rig_say(&line, "41 42 03");
    character_rig_pass_to(&line, begin + 7 * (dg_ns)CHARACTER / 2);
    assert_int_equal(line.count, 3);
    (void)dg_bus_detach(line.bus, 1, line.now);
    assert_int_equal(dg_bus_count(line.bus), 1);
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 3);
    assert_int_equal(character_rig_device(&line, 0)->counters.damaged, damaged);
    character_rig_expect_silence(&line, "41 42 03");
    character_rig_expect_answer(&line, "40 42 02", 0);
}

/* With their faults; and what was kept for a memory is of nobody else. */
static void those_behind_move_up_on_a_line(void **state)
{
    (void)state;
    character_rig_make(&line, &character_rig_paced, 3);
    character_rig_bend(&line, 2, DG_WIRE_DROP, 1);
    line.answer = DG_BUS_KEEP;
    character_rig_expect_silence(&line, "40 42 02");
    (void)dg_bus_detach(line.bus, 0, line.now);
    line.answer = DG_BUS_SAY;
    (void)dg_bus_durable(line.bus, 0, line.now);
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 0);
    assert_ptr_equal(dg_bus_encoder(line.bus, 1), line.hosts[2]);
    character_rig_expect_answer(&line, "41 42 03", 0);
    character_rig_expect_silence(&line, "42 42 00");
    character_rig_expect_answer(&line, "42 42 00", 1);
    (void)dg_bus_detach(line.bus, 1, line.now);
    (void)dg_bus_detach(line.bus, 0, line.now);
    character_rig_expect_silence(&line, "41 42 03");
    assert_int_equal(dg_bus_step(line.bus, line.now), DG_NEVER);
}

/* The handle is alone in between: what it says is in its queue. */
static void it_may_go_to_another_line(void **state)
{
    static struct character_rig other;
    const struct dg_host_event request = {
        .kind = DG_HOST_BYTES, .at = 2 * READY, .length = 3, .data = {0x41, 0x42, 0x03}};
    struct dg_host_event reply;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    character_rig_make(&other, &character_rig_paced, 1);
    (void)dg_bus_detach(line.bus, 1, line.now);
    assert_int_equal(dg_host_send(line.hosts[1], &request), DG_HOST_OK);
    (void)dg_host_step(line.hosts[1], 3 * READY);
    assert_int_equal(dg_host_receive(line.hosts[1], &reply), 1);
    assert_int_equal(reply.data[0], 0x41);
    host_rig_drain(line.hosts[1]);
    assert_int_equal(dg_bus_attach(other.bus, line.hosts[1], NULL), 1);
    other.now = 3 * READY;
    character_rig_expect_answer(&other, "41 42 03", 1);
    assert_int_equal(dg_host_receive(line.hosts[1], &reply), 0);
}

/* ------------------------------------------------------------ frames */

static void ask(size_t node, unsigned answers)
{
    frames_rig.count = 0;
    (void)frames_rig_ask(DG_S(10), node);
    assert_int_equal(frames_rig_count((uint16_t)(SDO + node + 1u)), answers);
}

static void those_behind_move_up_on_a_bus_of_frames(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 4);
    (void)frames_rig_write(DG_S(2), 3, 0x1016, 1, 3u << 16 | 250u, 4); /* hears node 3 */
    (void)frames_rig_write(DG_S(2), 2, 0x1017, 0, 100, 2);
    (void)frames_rig_write(DG_S(2), 1, 0x1017, 0, 100, 2);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    const unsigned filters = frames_rig.filters;
    (void)dg_bus_detach(frames_rig.bus, 1, DG_S(3));
    assert_true(frames_rig.filters > filters);
    assert_false(dg_bus_frames_listens(frames_rig.bus, 0x602));
    assert_true(dg_bus_frames_listens(frames_rig.bus, 0x603));
    const unsigned heartbeats = frames_rig_count(HEARTBEAT + 2);
    assert_int_equal(heartbeats, 11);
    (void)dg_bus_step(frames_rig.bus, DG_S(5));
    assert_int_equal(frames_rig_count(HEARTBEAT + 2), heartbeats);
    assert_int_equal(frames_rig_count(HEARTBEAT + 3), 31);
    assert_int_equal(frames_rig_count(EMCY + 4), 0); /* node 4 still hears it */
    (void)dg_bus_detach(frames_rig.bus, 1, DG_S(6));
    (void)dg_bus_step(frames_rig.bus, DG_S(7));
    assert_int_equal(frames_rig_count(EMCY + 4), 1); /* and now it does not */
    ask(0, 1);
    assert_int_equal(frames_rig.sent[0].place, 0);
    ask(1, 0);
    ask(2, 0);
    ask(3, 1);
    assert_int_equal(frames_rig.sent[0].place, 1);
    for (size_t left = 2; left > 0; left--) {
        const unsigned told = frames_rig.filters;
        (void)dg_bus_detach(frames_rig.bus, 0, DG_S(11));
        assert_true(frames_rig.filters > told);
    }
    assert_int_equal(dg_bus_next(frames_rig.bus), DG_NEVER);
}

/* Kept answers leave their room to others. */
static void it_leaves_its_room(void **state)
{
    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.rooms = 4}, 2);
    frames_rig.answer = DG_BUS_KEEP;
    for (size_t i = 0; i < 2; i++) {
        for (unsigned n = 0; n < 4; n++) {
            (void)frames_rig_ask(DG_S(2), i);
        }
        assert_int_equal(frames_rig.count, 0);
        if (i == 0) {
            (void)dg_bus_detach(frames_rig.bus, 0, DG_S(2));
        }
    }
    assert_int_equal(dg_bus_frames_counters(frames_rig.bus)->lost, 0);
    frames_rig.answer = DG_BUS_SAY;
    (void)dg_bus_durable(frames_rig.bus, 0, DG_S(3));
    assert_int_equal(frames_rig_count(SDO + 2), 4);
}

/* A wire that has no bit rate of its own has that of the slowest one that is left. */
static void a_bus_without_its_slowest(void **state)
{
    static const uint8_t reset[2] = {0x81, 1};

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 2);
    (void)frames_rig_write(DG_S(2), 0, 0x2100, 0, 3, 1);
    (void)frames_rig_write(DG_S(2), 0, 0x2105, 0, 0x65766173u, 4); /* "save" */
    (void)frames_rig_send(DG_S(3), 0, sizeof reset, reset);
    assert_int_equal(dg_bus_frames_bit_rate(frames_rig.bus), 100000);
    (void)dg_bus_detach(frames_rig.bus, 0, DG_S(4));
    assert_int_equal(dg_bus_frames_bit_rate(frames_rig.bus), 250000);
}

/* Late frames, those that wait for their time, answers: of the others they stay. */
static void what_it_has_not_sent_goes_with_it(void **state)
{
    (void)state;
    for (size_t gone = 0; gone < 3; gone++) {
        frames_rig_begin((struct dg_bus_frames_setup){.pace = gone != 0, .arbitrate = gone == 2},
                         3);
        for (size_t i = 0; i < 3; i++) {
            if (gone == 0) {
                frames_rig_bend(i, "wire_delay", true, 1, DG_S(2));
            }
            (void)frames_rig_ask(DG_S(2), i);
        }
        const size_t before = frames_rig.count;
        assert_in_range(before, 0, 1);
        (void)dg_bus_detach(frames_rig.bus, 1, DG_S(2));
        (void)dg_bus_step(frames_rig.bus, DG_S(3));
        assert_int_equal(frames_rig_count(SDO + 1), 1);
        assert_int_equal(frames_rig_count(SDO + 2), 0);
        assert_int_equal(frames_rig_count(SDO + 3), 1);
        assert_int_equal(frames_rig.sent[frames_rig.count - 1u].place, 1);
    }
}

/* When too much of it waits for its time, the others need not wait for that any more. */
static void a_wire_is_free_without_it(void **state)
{
    const struct dg_bus_frames_line slow = {.bit_rate = 10000, .tolerant = true};

    (void)state;
    frames_rig_begin((struct dg_bus_frames_setup){.pace = true, .line = slow}, 2);
    for (unsigned i = 0; i < 2 * DG_BUS_FRAMES_PACED; i++) {
        (void)frames_rig_ask(DG_S(2), 0);
    }
    assert_true(dg_bus_frames_waits(frames_rig.bus));
    (void)dg_bus_detach(frames_rig.bus, 0, DG_S(2));
    assert_false(dg_bus_frames_waits(frames_rig.bus));
    frames_rig.count = 0;
    (void)frames_rig_ask(DG_S(2), 1);
    (void)dg_bus_step(frames_rig.bus, DG_S(4));
    assert_int_equal(frames_rig.count, 1);
    assert_int_equal(frames_rig.sent[0].place, 0);
}

/* What it has said already others hear, though they have to wait for the port before: also the one
 * that has got its place, and also when others leave. */
static void what_was_on_the_wire_is_heard(void **state)
{
    static uint8_t saved[4096];

    (void)state;
    for (size_t others = 0; others < 2; others++) {
        frames_rig_begin((struct dg_bus_frames_setup){.pace = false}, 3);
        (void)frames_rig_write(DG_S(2), 2, 0x1016, 1, 2u << 16 | 600u, 4); /* node 3 hears node 2 */
        (void)frames_rig_write(DG_S(2), 1, 0x1017, 0, 500, 2);
        (void)dg_bus_step(frames_rig.bus, DG_S(2) + DG_MS(499));
        frames_rig.stall_at = HEARTBEAT + 2;
        (void)dg_bus_step(frames_rig.bus, DG_S(2) + DG_MS(500));
        (void)dg_bus_detach(frames_rig.bus, 1, DG_S(2) + DG_MS(510));
        if (others == 1) {
            (void)dg_bus_detach(frames_rig.bus, 0, DG_S(2) + DG_MS(510));
        }
        assert_int_equal(dg_bus_save(frames_rig.bus, saved, sizeof saved), DG_HOST_OK);
        dg_bus_frames_stall(frames_rig.bus, false);
        (void)dg_bus_step(frames_rig.bus, DG_S(2) + DG_MS(550));
        frames_rig.count = 0;
        (void)dg_bus_step(frames_rig.bus, DG_S(4));
        assert_int_equal(frames_rig_count(EMCY + 3), 1);
        assert_int_equal(frames_rig.sent[0].event.at, DG_S(2) + DG_MS(510 + 600));
    }
}

/* It finds that there is no bus, and on another one that there is. */
static void it_may_go_to_another_bus_of_frames(void **state)
{
    struct dg_bus_frames_setup wire = {.line.company = DG_BUS_SOMEBODY};

    (void)state;
    frames_rig_begin(wire, 2);
    struct dg_host *host = frames_rig.host[1];
    const struct dg_host_controller *ask_it = dg_host_side_at(host)->controller;
    const void *device = dg_host_line_of(host)->device;
    assert_false(ask_it->is_news(device, DG_HOST_BUS_PRESENT));
    (void)dg_bus_frames_controller(frames_rig.bus, DG_S(2), DG_HOST_BUS_OFF);
    (void)dg_bus_detach(frames_rig.bus, 1, DG_S(2));
    assert_true(ask_it->is_news(device, DG_HOST_BUS_PRESENT));
    assert_false(ask_it->is_news(device, DG_HOST_BUS_ABSENT));
    frames_rig.bus = frames_rig_make_bus(&wire, 1);
    (void)dg_bus_step(frames_rig.bus, DG_S(3));
    assert_int_equal(dg_bus_attach(frames_rig.bus, host, NULL), 0);
    (void)dg_bus_changed(frames_rig.bus, 0, DG_S(3));
    assert_false(ask_it->is_news(device, DG_HOST_BUS_PRESENT));
    ask(1, 1);
}

/* ------------------------------------------------------------ edges */

#define CHAIN_BITS 200u

static void begin_chain(const unsigned *angles, size_t count)
{
    edges_rig_begin(NULL, EDGES_RIG_ENCODERS);
    for (size_t i = 0; i < count; i++) {
        struct dg_host *host = edges_rig_model(i, angles[i] == 2 ? "s3674-biss" : "s3684-biss");
        (void)dg_host_set(host, "lc", "0");
        (void)dg_host_set(host, "busy_jitter_us", "0");
        edges_rig_attach(i);
        edges_rig_power(i, true);
        dg_host_shaft(host, 0, angles[i] * TURN / 8, 0);
    }
    edges_rig.now = READY;
    (void)dg_bus_step(edges_rig.bus, edges_rig.now);
}

static void take_levels(uint8_t levels[CHAIN_BITS])
{
    for (size_t i = 0; i < CHAIN_BITS; i++) {
        levels[i] = edges_rig_clock();
    }
    edges_rig_rest();
}

/* Each of three: a chain of those that are left is one that never had it. */
static void a_chain_closes(void **state)
{
    static const unsigned all[3] = {1, 2, 3};
    static const unsigned left[3][2] = {{2, 3}, {1, 3}, {1, 2}};
    uint8_t expected[CHAIN_BITS];
    uint8_t seen[CHAIN_BITS];

    (void)state;
    for (size_t gone = 0; gone < 3; gone++) {
        begin_chain(left[gone], 2);
        take_levels(expected);
        begin_chain(all, 3);
        take_levels(seen);
        assert_memory_not_equal(seen, expected, sizeof seen);
        (void)dg_bus_detach(edges_rig.bus, gone, edges_rig.now);
        assert_false(dg_host_line_of(edges_rig.place[gone].host)->behind);
        assert_false(dg_host_line_of(edges_rig.place[gone < 2 ? 2 : 1].host)->chained);
        take_levels(seen);
        assert_memory_equal(seen, expected, sizeof seen);
        assert_int_equal(dg_bus_count(edges_rig.bus), 2);
    }
}

static void the_last_one_of_a_line_leaves_it_low(void **state)
{
    static const unsigned one[1] = {5};
    uint8_t seen[CHAIN_BITS];

    (void)state;
    begin_chain(one, 1);
    take_levels(seen);
    memset(seen, 1, sizeof seen);
    edges_rig.heard_count = 0;
    assert_true(dg_bus_edges_data(edges_rig.bus, edges_rig.now));
    const dg_ns next = dg_bus_detach(edges_rig.bus, 0, edges_rig.now);
    assert_int_equal(next, DG_NEVER);
    assert_int_equal(edges_rig.heard_count, 1);
    assert_int_equal(edges_rig.heard[0].at, edges_rig.now);
    assert_false(edges_rig.heard[0].levels.data);
    take_levels(seen);
    for (size_t i = 0; i < CHAIN_BITS; i++) {
        assert_false(seen[i]);
    }
}

/* It is the last of no chain any more, and answers by itself. */
static void it_may_go_to_another_clocked_line(void **state)
{
    static const unsigned all[3] = {1, 2, 3};
    static const unsigned alone[1] = {1};
    uint8_t expected[CHAIN_BITS];
    uint8_t seen[CHAIN_BITS];
    const struct dg_bus_setup setup = {
        .size = sizeof setup, .medium = &dg_bus_edges, .encoders = 1, .ops = &edges_rig.ops};

    (void)state;
    begin_chain(alone, 1);
    take_levels(expected);
    begin_chain(all, 3);
    (void)edges_rig_take(20);
    (void)dg_bus_detach(edges_rig.bus, 0, edges_rig.now);
    assert_false(dg_host_line_of(edges_rig.place[0].host)->chained);
    assert_true(dg_host_line_of(edges_rig.place[1].host)->chained);
    assert_in_range(dg_host_next(edges_rig.place[0].host), edges_rig.now,
                    edges_rig.now + DG_US(50));
    (void)dg_host_step(edges_rig.place[0].host, edges_rig.now + DG_MS(1));
    edges_rig.now += DG_MS(1);
    edges_rig.bus = dg_bus_init(&other_memory, sizeof other_memory, &setup);
    assert_int_equal(dg_bus_attach(edges_rig.bus, edges_rig.place[0].host, NULL), 0);
    take_levels(seen);
    assert_memory_equal(seen, expected, sizeof seen);
}

/* ------------------------------------------------------------ words */

static struct ring_rig ring;

static void open_ring(void)
{
    static const char *const models[RING_RIG_ENCODERS] = {"ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2",
                                                          "ocd-ib-k3"};

    ring_rig_init(&ring);
    for (size_t i = 0; i < RING_RIG_ENCODERS; i++) {
        struct dg_host *host = ring_rig_add(&ring, models[i]);
        (void)dg_host_set(host, "self_test_ms", "0");
        dg_host_shaft(host, 0, 0x100 * ((int64_t)i + 1) * (TURN / 4096) + TURN / 8192, 0);
    }
    ring_rig_open(&ring);
    ring.now = DG_S(1);
    assert_int_equal(ring_rig_identify(&ring), RING_RIG_ENCODERS);
    assert_int_equal(ring_rig_cycle(&ring), DG_RING_OK);
}

/* IN words hold until the ring is identified, each encoder's at its new place. */
static void a_ring_closes(void **state)
{
    static const uint16_t before[7] = {0x100, 0, 0x200, 0, 0x300, 0, 0x400};
    static const uint16_t after[7] = {0x100, 0, 0x300, 0, 0x400, 0, 0};

    (void)state;
    open_ring();
    assert_memory_equal(ring.in, before, sizeof before);
    (void)dg_bus_detach(ring.bus, 1, ring.now);
    assert_int_equal(dg_ring_state(ring.bus)->words, 5);
    assert_memory_equal(ring.in, after, sizeof after);
    assert_int_equal(ring_rig_cycle(&ring), DG_RING_IDENTIFY);
    assert_memory_equal(ring.in, after, sizeof after);
    assert_int_equal(ring_rig_identify(&ring), 3);
    assert_int_equal(dg_ring_id_word(ring.bus, 1), 0x0236);
    memset(ring.in, 0xFF, sizeof ring.in);
    assert_int_equal(ring_rig_cycle(&ring), DG_RING_OK);
    assert_memory_equal(ring.in, after, 5 * sizeof after[0]);
    assert_int_equal(ring.in[5], 0xFFFF);
    for (size_t left = 3; left > 0; left--) {
        (void)dg_bus_detach(ring.bus, 0, ring.now);
    }
    assert_int_equal(dg_ring_state(ring.bus)->words, 0);
    assert_int_equal(dg_bus_next(ring.bus), DG_NEVER);
}

/* A cut is of the ring and stays where it was; a transmission error is of an encoder. */
static void what_is_said_of_places_moves_with_them(void **state)
{
    (void)state;
    open_ring();
    dg_ring_cut(ring.bus, 3);
    (void)dg_bus_detach(ring.bus, 0, ring.now);
    assert_int_equal(ring_rig_identify(&ring), 2);
    (void)dg_bus_detach(ring.bus, 2, ring.now);
    assert_int_equal(ring_rig_identify(&ring), 2);
    open_ring();
    dg_ring_spoil(ring.bus, 3);
    (void)dg_bus_detach(ring.bus, 0, ring.now);
    (void)ring_rig_identify(&ring);
    assert_int_equal(ring_rig_cycle(&ring), DG_RING_CRC);
    assert_int_equal(((const struct dg_ib *)ring_rig_device(&ring, 3))->counters.crc_errors, 1);
    open_ring();
    dg_ring_spoil(ring.bus, 1);
    (void)dg_bus_detach(ring.bus, 1, ring.now);
    (void)ring_rig_identify(&ring);
    assert_int_equal(ring_rig_cycle(&ring), DG_RING_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_reply_ends_in_its_character),
        cmocka_unit_test(those_behind_move_up_on_a_line),
        cmocka_unit_test(it_may_go_to_another_line),
        cmocka_unit_test(those_behind_move_up_on_a_bus_of_frames),
        cmocka_unit_test(what_it_has_not_sent_goes_with_it),
        cmocka_unit_test(it_leaves_its_room),
        cmocka_unit_test(a_bus_without_its_slowest),
        cmocka_unit_test(a_wire_is_free_without_it),
        cmocka_unit_test(what_was_on_the_wire_is_heard),
        cmocka_unit_test(it_may_go_to_another_bus_of_frames),
        cmocka_unit_test(a_chain_closes),
        cmocka_unit_test(the_last_one_of_a_line_leaves_it_low),
        cmocka_unit_test(it_may_go_to_another_clocked_line),
        cmocka_unit_test(a_ring_closes),
        cmocka_unit_test(what_is_said_of_places_moves_with_them),
    };
    return cmocka_run_group_tests_name("encoders that leave a bus", tests, NULL, NULL);
}

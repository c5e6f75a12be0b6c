/* SPDX-License-Identifier: MIT */
/*
 * A bus whose host reads what was told instead of being called, as bindings of other languages do,
 * and what the panels of its encoders do there.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/bus_characters.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/bus_queue.h"
#include "drehgeber/host_wire.h"
#include "host_rig.h"

#define ENCODERS 2u
#define ROOM 32u
#define CHARACTER 1145834u
#define HEARTBEAT 0x700u
#define ASK 0x600u
#define ANSWER 0x580u

static struct {
    struct host_rig_place places[ENCODERS];
    struct host_rig_place panel;
    struct dg_host *hosts[ENCODERS];
    alignas(DG_HOST_ALIGN) uint8_t memory[32768];
    struct dg_bus_told told[ROOM];
    struct dg_bus_queue queue;
    struct dg_bus *bus;
} rig;

/* Encoders that were on before anybody listened, with addresses of their own. */
static void put_on_bus(const struct dg_bus_medium *medium, const void *wire, const char *model,
                       const char *const addresses[ENCODERS])
{
    rig.queue = (struct dg_bus_queue){.told = rig.told, .room = ROOM};
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = medium,
                                       .encoders = ENCODERS,
                                       .wire = wire,
                                       .ops = &dg_bus_queue_ops,
                                       .ctx = &rig.queue};

    assert_true(dg_bus_size(medium, ENCODERS) <= sizeof rig.memory);
    rig.bus = dg_bus_init(rig.memory, sizeof rig.memory, &setup);
    assert_non_null(rig.bus);
    dg_bus_watch(rig.bus, false);
    for (size_t i = 0; i < ENCODERS; i++) {
        rig.hosts[i] = host_rig_make(&rig.places[i], model);
        const char *key = dg_host_address_key(rig.hosts[i]);
        assert_int_equal(dg_host_set(rig.hosts[i], key, addresses[i]), DG_HOST_OK);
        assert_int_equal(dg_host_power(rig.hosts[i], 0, true), DG_HOST_OK);
        (void)dg_host_step(rig.hosts[i], SECOND);
        host_rig_drain(rig.hosts[i]);
        assert_int_equal(dg_bus_attach(rig.bus, rig.hosts[i], NULL), i);
    }
}

static void send_frame(dg_ns at, uint16_t id, const uint8_t *data)
{
    struct dg_tap_event event = {.at = at, .kind = DG_TAP_FRAME, .frame = {.id = id, .dlc = 8}};

    for (size_t i = 0; i < 8; i++) {
        event.frame.data[i] = data[i];
    }
    (void)dg_bus_rx(rig.bus, &event);
}

static void upload(dg_ns at)
{
    static const uint8_t data[8] = {0x40, 0x04, 0x60};

    send_frame(at, ASK + 1u, data);
}

static void make_frames(void)
{
    static const char *const nodes[ENCODERS] = {"1", "2"};
    static struct dg_bus_frames_room rooms[64];
    const struct dg_bus_frames_setup wire = {
        .size = sizeof wire, .room = rooms, .rooms = DG_COUNT(rooms)};

    put_on_bus(&dg_bus_frames, &wire, "f3668", nodes);
}

/* Heartbeats of both, each 100 ms: they begin at once. */
static void begin_heartbeats(void)
{
    static const uint8_t every[8] = {0x2B, 0x17, 0x10, 0, 100};

    for (uint16_t node = 1; node <= ENCODERS; node++) {
        send_frame(SECOND, (uint16_t)(ASK + node), every);
    }
    rig.queue.count = 0;
}

/* ------------------------------------------------------------ what waits */

static void all_of_it_comes_in_pieces(void **state)
{
    unsigned pieces = 0;
    unsigned frames = 0;

    (void)state;
    make_frames();
    begin_heartbeats();
    for (dg_ns next = 0; next <= 3 * SECOND; pieces++) {
        next = dg_bus_step_queued(rig.bus, &rig.queue, 3 * SECOND, 5);
        assert_true(rig.queue.count <= 6);
        for (uint32_t i = 0; i < rig.queue.count; i++, frames++) {
            const struct dg_bus_told *told = &rig.told[i];
            assert_int_equal(told->event.at, SECOND + (frames / ENCODERS + 1) * 100 * MS);
            assert_int_equal(told->place, frames % ENCODERS);
            assert_int_equal(told->event.frame.id, HEARTBEAT + 1u + told->place);
            assert_false(told->looked);
        }
        rig.queue.count = 0;
    }
    assert_int_equal(frames, 20 * ENCODERS);
    assert_in_range(pieces, 7, 8); /* of six frames */
    assert_int_equal(dg_bus_next(rig.bus), 3 * SECOND + 100 * MS);
    assert_int_equal(rig.queue.lost, 0);
}

static void what_has_no_room_is_counted(void **state)
{
    (void)state;
    make_frames();
    begin_heartbeats();
    (void)dg_bus_step(rig.bus, 3 * SECOND);
    assert_int_equal(rig.queue.count, ROOM);
    assert_int_equal(rig.queue.lost, 20 * ENCODERS - ROOM);
}

static void who_looks_sees_both_directions(void **state)
{
    (void)state;
    make_frames();
    dg_bus_watch(rig.bus, true);
    upload(SECOND);
    assert_int_equal(rig.queue.count, 3);
    assert_true(rig.told[0].looked && !rig.told[0].event.ours);
    assert_true(rig.told[1].looked && rig.told[1].event.ours);
    assert_false(rig.told[2].looked);
    assert_int_equal(rig.told[2].event.frame.id, ANSWER + 1u);
}

static void a_burst_is_a_reply(void **state)
{
    static const char *const addresses[ENCODERS] = {"0x40", "0x41"};
    static const uint8_t ask[] = {0x40, 0x42, 0x02};
    const struct dg_characters_setup wire = {.size = sizeof wire, .paced = true};
    struct dg_tap_event event = {
        .at = SECOND, .kind = DG_TAP_CHARACTER, .character = {.baud = DG_BAUD_ANY}};

    (void)state;
    put_on_bus(&dg_bus_characters, &wire, "s3684-rs485", addresses);
    for (size_t i = 0; i < sizeof ask; i++) {
        event.character.byte = ask[i];
        (void)dg_bus_rx(rig.bus, &event);
    }
    const dg_ns end = dg_bus_step_burst(rig.bus, &rig.queue, 2 * SECOND, CHARACTER);
    assert_int_equal(rig.queue.count, 7);
    assert_int_equal(rig.told[6].event.at, end);
    assert_true(end < SECOND + 20 * MS);
    rig.queue.count = 0;
    assert_true(dg_bus_step_burst(rig.bus, &rig.queue, 2 * SECOND, CHARACTER) <= 2 * SECOND);
    assert_int_equal(rig.queue.count, 0);
}

/* ------------------------------------------------------------ panels */

static struct dg_host_panel *make_panel(void)
{
    struct dg_host_panel *panel = dg_host_panel_make(&rig.panel, sizeof rig.panel, rig.hosts[0]);

    assert_non_null(panel);
    dg_bus_control(rig.bus, 0, dg_host_panel_encoder(panel));
    return panel;
}

static void set_wire_fault(struct dg_host_panel *panel, dg_ns now, const char *name, bool on)
{
    dg_bus_look(rig.bus, now);
    assert_int_equal(dg_host_fault_set(panel, now, name, on), DG_HOST_OK);
    (void)dg_bus_changed(rig.bus, 0, now);
}

/* By the bus, and not by the handle as well. */
static void a_fault_happens_once(void **state)
{
    (void)state;
    make_frames();
    struct dg_host_panel *panel = make_panel();
    set_wire_fault(panel, SECOND, "wire_duplicate", true);
    upload(SECOND + MS);
    assert_int_equal(rig.queue.count, 2);
    set_wire_fault(panel, SECOND + 2 * MS, "wire_duplicate", false);
    set_wire_fault(panel, SECOND + 2 * MS, "wire_delay", true);
    rig.queue.count = 0;
    upload(SECOND + 3 * MS);
    assert_int_equal(rig.queue.count, 0);
    (void)dg_bus_step_queued(rig.bus, &rig.queue, 2 * SECOND, 1);
    assert_int_equal(rig.queue.count, 1);
    assert_true(rig.told[0].event.at > SECOND + 3 * MS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_of_it_comes_in_pieces),
        cmocka_unit_test(what_has_no_room_is_counted),
        cmocka_unit_test(who_looks_sees_both_directions),
        cmocka_unit_test(a_burst_is_a_reply),
        cmocka_unit_test(a_fault_happens_once),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

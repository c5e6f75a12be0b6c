/* SPDX-License-Identifier: MIT */
/*
 * 127 encoders on one bus in virtual time: a frame reaches those that listen to its CAN-ID and no
 * other, each node keeps its own deadlines, and filters follow what the nodes are told.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/host_wire.h"

#define NODES DG_BUS_FRAMES_ENCODERS
#define SENT_MAX 4096u
#define LSS_RX 0x7E5
#define LSS_TX 0x7E4
#define SERIAL 1000000u /* of node 0; the others count on */

/* The encoder without its supervision: deadlines are those of the communication alone. */
static struct dg_co_device device;

/* Encoder i has node-ID i + 1. */
static struct seat {
    _Alignas(DG_HOST_ALIGN) uint8_t memory[2304];
    struct dg_host *host;
    struct dg_co_node *node;
} seats[NODES];

/* What an encoder has sent. */
struct sent {
    const struct seat *seat;
    struct dg_can_frame frame;
    dg_ns at;
};

static _Alignas(DG_HOST_ALIGN) uint8_t memory[40000];
static struct dg_bus_frames_room rooms[NODES];
static struct dg_bus *bus;
static dg_ns now;
static uint32_t count;
static struct sent sent[SENT_MAX];

static void keep(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    assert_true(count < SENT_MAX);
    sent[count++] = (struct sent){&seats[place], event->frame, event->at};
}

static const struct dg_bus_ops ops = {.tx = keep};

static dg_ns rx(dg_ns at, const struct dg_can_frame *frame)
{
    const struct dg_tap_event event = {.at = at, .kind = DG_TAP_FRAME, .frame = *frame};

    return dg_bus_rx(bus, &event);
}

static void receive(uint16_t id, uint8_t dlc, uint64_t data)
{
    struct dg_can_frame frame = {.id = id, .dlc = dlc};

    dg_store_le32(&frame.data[0], (uint32_t)data);
    dg_store_le32(&frame.data[4], (uint32_t)(data >> 32));
    count = 0;
    (void)rx(now, &frame);
}

static void request(uint16_t id)
{
    const struct dg_can_frame frame = {.id = id, .rtr = true};

    count = 0;
    (void)rx(now, &frame);
}

static void nmt(uint8_t command)
{
    receive(0, 2, command);
}

/* Time passes, deadlines are served exactly; returns how many. */
static unsigned run(dg_ns span)
{
    const dg_ns end = now + span;
    unsigned steps = 0;

    for (dg_ns due = dg_bus_step(bus, now); due <= end; due = dg_bus_step(bus, now)) {
        assert_true(due > now);
        now = due;
        steps++;
    }
    now = end;
    return steps;
}

static void make_encoder(uint8_t i)
{
    struct seat *seat = &seats[i];
    char text[16];

    seat->host = dg_host_init_on_bus(seat->memory, sizeof seat->memory, &dg_f3668, &dg_cia406_side);
    assert_non_null(seat->host);
    (void)snprintf(text, sizeof text, "%u", i + 1u);
    assert_int_equal(dg_host_set(seat->host, "node", text), DG_HOST_OK);
    (void)snprintf(text, sizeof text, "%u", SERIAL + i);
    assert_int_equal(dg_host_set(seat->host, "serial", text), DG_HOST_OK);
    assert_int_equal(dg_bus_attach(bus, seat->host, NULL), i);
    assert_int_equal(dg_host_power(seat->host, now, true), DG_HOST_OK);
    seat->node = &((struct dg_cia406_device *)dg_host_line_of(seat->host)->device)->node;
    seat->node->setup.device = &device;
    (void)dg_bus_changed(bus, i, now);
}

static int setup(void **state)
{
    const struct dg_bus_frames_setup wire = {
        .size = sizeof wire, .room = rooms, .rooms = DG_COUNT(rooms)};
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = &dg_bus_frames,
                                       .encoders = NODES,
                                       .wire = &wire,
                                       .ops = &ops};

    (void)state;
    now = DG_S(1);
    count = 0;
    device = dg_cia406_multiturn;
    device.step = NULL;
    bus = dg_bus_init(memory, sizeof memory, &setup);
    assert_non_null(bus);
    (void)dg_bus_step(bus, now);
    for (uint8_t i = 0; i < NODES; i++) {
        make_encoder(i);
    }
    (void)run(0);
    count = 0;
    return 0;
}

/* Frames node i was offered since forget_rx(). */
static uint32_t offered(uint8_t i)
{
    return seats[i].node->counters.rx;
}

static void forget_rx(void)
{
    for (uint8_t i = 0; i < NODES; i++) {
        seats[i].node->counters.rx = 0;
    }
}

static void assert_offered_to(int only)
{
    for (uint8_t i = 0; i < NODES; i++) {
        assert_int_equal(offered(i), i == only ? 1 : 0);
    }
}

/* Expedited download that must be confirmed. */
static void write_ok(uint8_t i, uint16_t index, uint8_t sub, uint32_t value, uint8_t size)
{
    const uint32_t command = 0x23u | (4u - size) << 2;
    const uint32_t head = command | (uint32_t)index << 8 | (uint32_t)sub << 24;

    receive((uint16_t)(0x601 + i), 8, (uint64_t)value << 32 | head);
    for (uint32_t n = 0; n < count; n++) {
        if (sent[n].frame.id == 0x581 + i && sent[n].frame.data[0] == 0x60) {
            return;
        }
    }
    fail_msg("node %u does not take %04Xh:%u", i + 1u, index, sub);
}

/* ------------------------------------------------------------ dispatch */

static void a_bus_takes_127_encoders(void **state)
{
    (void)state;
    assert_int_equal(dg_bus_attach(bus, seats[0].host, NULL), DG_ERR_SPACE);
    assert_int_equal(dg_bus_count(bus), NODES);
}

static void each_answers_its_own_sdo_only(void **state)
{
    (void)state;
    for (uint8_t i = 0; i < NODES; i++) {
        forget_rx();
        receive((uint16_t)(0x601 + i), 8, 0x00100B40); /* 100Bh: its node-ID */
        assert_int_equal(count, 1);
        assert_ptr_equal(sent[0].seat, &seats[i]);
        assert_int_equal(sent[0].frame.id, 0x581 + i);
        assert_int_equal(dg_load_le32(&sent[0].frame.data[4]), i + 1);
        assert_offered_to(i);
    }
}

static void sync_reaches_all(void **state)
{
    (void)state;
    nmt(0x01);
    forget_rx();
    const struct dg_tap_event note = {.at = now, .kind = DG_TAP_NOTE};
    (void)dg_bus_rx(bus, &note); /* no frame, and below one that is too long: nobody answers */
    receive(0x80, 9, 0);
    assert_int_equal(count, 0);
    receive(0x80, 0, 0);
    assert_int_equal(count, NODES);
    for (uint8_t i = 0; i < NODES; i++) {
        assert_int_equal(sent[i].frame.id, 0x281 + i);
        assert_int_equal(offered(i), 1);
    }
}

static void a_remote_frame_reaches_the_one_it_asks(void **state)
{
    (void)state;
    nmt(0x01);
    for (uint8_t i = 0; i < NODES; i++) {
        static const uint16_t bases[] = {0x181, 0x281, 0x381, 0x481, 0x701};
        for (size_t k = 0; k < DG_COUNT(bases); k++) {
            forget_rx();
            request((uint16_t)(bases[k] + i));
            assert_int_equal(count, 1);
            assert_int_equal(sent[0].frame.id, bases[k] + i);
            assert_offered_to(i);
        }
    }
}

static void nobody_sees_what_nobody_listens_to(void **state)
{
    unsigned unheard = 0;
    (void)state;

    forget_rx();
    for (uint16_t id = 0; id <= 0x7FF; id++) {
        if (!dg_bus_frames_listens(bus, id)) {
            receive(id, 8, 0);
            assert_int_equal(count, 0);
            unheard++;
        }
    }
    assert_offered_to(-1);
    /* 127 each of 4 TPDOs, SDO and guarding, then NMT, SYNC, LSS. */
    assert_int_equal(unheard, 0x800 - 6 * NODES - 3);
}

static void a_second_node_with_the_same_id_answers_as_well(void **state)
{
    (void)state;
    receive(LSS_RX, 8, 0x0104); /* by LSS, as it happens in the field */
    for (uint8_t i = 0; i < 2; i++) {
        const struct dg_can_frame node_id = {.id = LSS_RX, .dlc = 8, .data = {0x11, 77}};
        (void)dg_co_rx(seats[i].node, now, &node_id);
    }
    receive(LSS_RX, 8, 0x0004);
    receive(0x64D, 8, 0x00100040);
    assert_int_equal(count, 3);
    for (uint8_t i = 0; i < 3; i++) {
        assert_int_equal(sent[i].frame.id, 0x5CD);
        assert_memory_equal(sent[i].frame.data, sent[0].frame.data, 8);
    }
}

/* ------------------------------------------------------------ deadlines */

static void each_heartbeat_keeps_its_own_period(void **state)
{
    dg_ns begin[NODES];
    uint32_t beats[NODES] = {0};
    (void)state;

    for (uint8_t i = 0; i < NODES; i++) {
        begin[i] = now;
        write_ok(i, 0x1017, 0, 100u + i, 2);
        (void)run(DG_US(10));
    }
    count = 0;
    const dg_ns first = now;
    assert_true(run(DG_S(1)) <= 1000u / 100u * NODES);
    for (uint32_t n = 0; n < count; n++) {
        const uint8_t i = (uint8_t)(sent[n].frame.id - 0x701);
        assert_ptr_equal(sent[n].seat, &seats[i]);
        beats[i]++;
        assert_true(sent[n].at == begin[i] + DG_MS((100u + i) * beats[i]));
    }
    for (uint8_t i = 0; i < NODES; i++) {
        assert_int_equal(beats[i], (first + DG_S(1) - begin[i]) / DG_MS(100u + i));
    }
}

static void the_deadline_is_the_earliest_of_all(void **state)
{
    (void)state;
    assert_true(dg_bus_step(bus, now) == DG_NEVER);
    write_ok(90, 0x1017, 0, 500, 2);
    write_ok(5, 0x1017, 0, 300, 2);
    write_ok(126, 0x1017, 0, 400, 2);
    assert_true(dg_bus_step(bus, now) == now + DG_MS(300));
    write_ok(5, 0x1017, 0, 0, 2);
    assert_true(dg_bus_step(bus, now) == now + DG_MS(400));
}

static void the_bus_is_everybodys(void **state)
{
    (void)state;
    assert_true(dg_bus_frames_controller(bus, now, DG_HOST_BUS_PASSIVE) == DG_NEVER);
    assert_int_equal(count, NODES);
    for (uint8_t i = 0; i < NODES; i++) {
        assert_int_equal(sent[i].frame.id, 0x081 + i);
        assert_int_equal(dg_load_le16(sent[i].frame.data), 0x8120);
    }
    write_ok(3, 0x1015, 0, 50, 2); /* 5 ms from the next EMCY to the one after */
    (void)dg_bus_frames_controller(bus, now, DG_HOST_BUS_ACTIVE);
    count = 0;
    assert_true(dg_bus_frames_controller(bus, now, DG_HOST_BUS_PASSIVE) == now + DG_MS(5));
    assert_int_equal(count, NODES - 1);
    (void)run(DG_MS(5));
    assert_int_equal(count, NODES);
    assert_int_equal(sent[NODES - 1].frame.id, 0x084);
}

/* ------------------------------------------------------------ filters follow */

static void another_sync_is_followed(void **state)
{
    (void)state;
    nmt(0x01);
    assert_false(dg_bus_frames_listens(bus, 0x90));
    write_ok(4, 0x1005, 0, 0x90, 4);
    assert_true(dg_bus_frames_listens(bus, 0x90));
    receive(0x80, 0, 0);
    assert_int_equal(count, NODES - 1);
    forget_rx();
    receive(0x90, 0, 0);
    assert_int_equal(count, 1);
    assert_int_equal(sent[0].frame.id, 0x285);
    assert_offered_to(4);
}

static void time_stamps_are_for_those_that_consume_them(void **state)
{
    (void)state;
    forget_rx();
    receive(0x100, 6, 0x000100000002);
    assert_offered_to(-1);
    write_ok(3, 0x1012, 0, 0x80000100, 4);
    forget_rx();
    receive(0x100, 6, 0x123400000002);
    assert_offered_to(3);
    assert_int_equal(seats[3].node->time_ms, 2);
    assert_int_equal(seats[3].node->time_days, 0x1234);
}

static void a_time_stamp_has_six_bytes(void **state)
{
    (void)state;
    write_ok(3, 0x1012, 0, 0x80000100, 4);
    receive(0x100, 6, 0x123400000002);
    for (uint8_t dlc = 0; dlc <= 8; dlc++) {
        if (dlc != 6) {
            receive(0x100, dlc, 0x567800000003);
        }
    }
    assert_int_equal(seats[3].node->time_ms, 2);
    assert_int_equal(seats[3].node->time_days, 0x1234);
    assert_int_equal(seats[3].node->counters.malformed, 8);
}

/* What a host sets its timer to: the earliest of all nodes, old and new. */
static void receiving_tells_the_next_deadline(void **state)
{
    static const struct dg_can_frame segmented = {
        .id = 0x605, .dlc = 8, .data = {0x40, 0x08, 0x10}};
    static const struct dg_can_frame heartbeat = {
        .id = 0x67F, .dlc = 8, .data = {0x2B, 0x17, 0x10, 0, 250}};
    static const struct dg_can_frame nobody = {.id = 0x7FF};
    (void)state;
    assert_int_equal(rx(now, &nobody), DG_NEVER);
    assert_int_equal(rx(now, &segmented), now + DG_S(1));
    assert_int_equal(rx(now + DG_MS(5), &nobody), now + DG_S(1));
    assert_int_equal(rx(now + DG_MS(5), &heartbeat), now + DG_MS(255));
    assert_int_equal(rx(now + DG_MS(6), &nobody), now + DG_MS(255));
}

static void a_tpdo_is_requested_where_it_has_gone(void **state)
{
    (void)state;
    nmt(0x01);
    write_ok(9, 0x1800, 1, 0x8000018A, 4);
    assert_false(dg_bus_frames_listens(bus, 0x18A));
    write_ok(9, 0x1800, 1, 0x00000222, 4);
    forget_rx();
    request(0x222);
    assert_int_equal(count, 1);
    assert_offered_to(9);
    write_ok(9, 0x1800, 1, 0x80000222, 4);
    write_ok(9, 0x1800, 1, 0x40000222, 4); /* no RTR */
    assert_false(dg_bus_frames_listens(bus, 0x222));
}

static void heartbeats_reach_their_consumers(void **state)
{
    (void)state;
    write_ok(0, 0x1016, 2, 0x00400064, 4); /* node 64, 100 ms */
    write_ok(8, 0x1016, 1, 0x00400032, 4); /* node 64, 50 ms */
    forget_rx();
    receive(0x740, 1, 0x05);
    for (uint8_t i = 0; i < NODES; i++) {
        assert_int_equal(offered(i), i == 0 || i == 8 || i == 63 ? 1 : 0);
    }
    count = 0;
    (void)run(DG_MS(75));
    assert_int_equal(count, 1);
    assert_int_equal(sent[0].frame.id, 0x089);
    (void)run(DG_MS(75));
    assert_int_equal(count, 2);
    assert_int_equal(sent[1].frame.id, 0x081);
    write_ok(0, 0x1016, 2, 0, 4);
    forget_rx();
    receive(0x740, 1, 0x05);
    assert_int_equal(offered(0), 0);
    assert_int_equal(offered(8), 1);
}

static void a_new_node_id_is_followed(void **state)
{
    (void)state;
    write_ok(126, 0x2101, 0, 20, 1);
    receive(0x67F, 8, 0x6576617300210523); /* 2105h "save" */
    (void)run(DG_MS(14));
    assert_int_equal(count, 1);
    receive(0, 2, 0x7F81);
    assert_int_equal(count, 1);
    assert_int_equal(sent[0].frame.id, 0x714);
    assert_false(dg_bus_frames_listens(bus, 0x67F));
    receive(0x614, 8, 0x00100040);
    assert_int_equal(count, 2); /* node 20 and the new one */
}

/* The host switches the power of an encoder, and then says so. */
static void power_off_and_on_is_followed(void **state)
{
    (void)state;
    write_ok(6, 0x1017, 0, 100, 2);
    dg_co_power_off(seats[6].node);
    assert_true(dg_bus_changed(bus, 6, now) == DG_NEVER);
    assert_false(dg_bus_frames_listens(bus, 0x607));
    assert_int_equal(dg_co_power_on(seats[6].node, now), DG_OK);
    (void)dg_bus_changed(bus, 6, now);
    forget_rx();
    receive(0x607, 8, 0x00100040);
    assert_int_equal(count, 1);
    assert_offered_to(6);
}

/* ------------------------------------------------------------ LSS */

static void lss_global_is_for_all(void **state)
{
    (void)state;
    receive(LSS_RX, 8, 0x0104);
    assert_int_equal(count, 0);
    receive(LSS_RX, 8, 0x5E);
    assert_int_equal(count, NODES);
    for (uint8_t i = 0; i < NODES; i++) {
        assert_int_equal(sent[i].frame.id, LSS_TX);
        assert_int_equal(sent[i].frame.data[1], i + 1);
    }
    receive(LSS_RX, 8, 0x0004);
    receive(LSS_RX, 8, 0x5E);
    assert_int_equal(count, 0);
}

static void lss_selective_is_for_one(void **state)
{
    static const uint32_t identity[] = {0x13, 0x56682001, 108, SERIAL + 41};
    (void)state;

    for (uint8_t part = 0; part < 4; part++) {
        receive(LSS_RX, 8, (uint64_t)identity[part] << 8 | (0x40u + part));
        assert_int_equal(count, part == 3 ? 1 : 0);
    }
    assert_ptr_equal(sent[0].seat, &seats[41]);
    assert_int_equal(sent[0].frame.data[0], 0x44);
    receive(LSS_RX, 8, 0x5E);
    assert_int_equal(count, 1);
    assert_int_equal(sent[0].frame.data[1], 42);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_bus_takes_127_encoders, setup),
        cmocka_unit_test_setup(each_answers_its_own_sdo_only, setup),
        cmocka_unit_test_setup(sync_reaches_all, setup),
        cmocka_unit_test_setup(a_remote_frame_reaches_the_one_it_asks, setup),
        cmocka_unit_test_setup(nobody_sees_what_nobody_listens_to, setup),
        cmocka_unit_test_setup(a_second_node_with_the_same_id_answers_as_well, setup),
        cmocka_unit_test_setup(each_heartbeat_keeps_its_own_period, setup),
        cmocka_unit_test_setup(the_deadline_is_the_earliest_of_all, setup),
        cmocka_unit_test_setup(the_bus_is_everybodys, setup),
        cmocka_unit_test_setup(another_sync_is_followed, setup),
        cmocka_unit_test_setup(time_stamps_are_for_those_that_consume_them, setup),
        cmocka_unit_test_setup(a_time_stamp_has_six_bytes, setup),
        cmocka_unit_test_setup(receiving_tells_the_next_deadline, setup),
        cmocka_unit_test_setup(a_tpdo_is_requested_where_it_has_gone, setup),
        cmocka_unit_test_setup(heartbeats_reach_their_consumers, setup),
        cmocka_unit_test_setup(a_new_node_id_is_followed, setup),
        cmocka_unit_test_setup(power_off_and_on_is_followed, setup),
        cmocka_unit_test_setup(lss_global_is_for_all, setup),
        cmocka_unit_test_setup(lss_selective_is_for_one, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

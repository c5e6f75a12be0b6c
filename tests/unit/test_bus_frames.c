/* SPDX-License-Identifier: MIT */
/*
 * A bus of frames in virtual time: one encoder on it behaves as its handle; several hear each
 * other, wait for each other, for the wire and for their memories, and share what breaks.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bus_frames.h"
#include "drehgeber/cia406.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/instruments.h"
#include "host_rig.h"

#define ENCODERS 4u
#define SENT_MAX 512u
#define ROOMS 300u
#define HEARTBEAT 0x700u
#define EMCY 0x80u
#define SDO 0x580u
#define ASK 0x600u

struct sent {
    size_t place;
    struct dg_tap_event event;
};

/* All there is; `dg_encoder` is what faults happen to. */
static struct rig {
    _Alignas(DG_HOST_ALIGN) uint8_t memory[32768];
    struct host_rig_place places[ENCODERS];
    struct dg_host *host[ENCODERS];
    struct dg_encoder control[ENCODERS];
    struct dg_bus_frames_room rooms[ROOMS];
    struct dg_bus *bus;
    struct sent sent[SENT_MAX];
    size_t count;
    size_t tapped;
    enum dg_bus_answer answer;
    unsigned filters;
    uint32_t retuned[ENCODERS];
    bool open_before; /* what is sent now may be answered: an identifier that has to be open */
    uint16_t wanted;
} rig;

/* ------------------------------------------------------------ the door */

static void tx(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    assert_true(rig.count < SENT_MAX && event->ours && event->kind == DG_TAP_FRAME);
    rig.sent[rig.count++] = (struct sent){place, *event};
    rig.open_before = dg_bus_frames_listens(rig.bus, rig.wanted);
}

static void tap(void *ctx, const struct dg_tap_event *event)
{
    static dg_ns latest;

    (void)ctx;
    rig.tapped++;
    assert_true(event->at >= latest || rig.tapped == 1);
    latest = event->at;
}

static enum dg_bus_answer answer(void *ctx, size_t place)
{
    (void)ctx;
    (void)place;
    return rig.answer;
}

static void filter(void *ctx)
{
    (void)ctx;
    rig.filters++;
}

static void retuned(void *ctx, size_t place, uint32_t bit_rate)
{
    (void)ctx;
    rig.retuned[place] = bit_rate;
}

static const struct dg_bus_ops ops = {.tx = tx, .tap = tap, .answer = answer};
static const struct dg_bus_frames_ops frames_ops = {.filter = filter, .retuned = retuned};

static struct dg_bus *make_bus(struct dg_bus_frames_setup *wire, size_t encoders)
{
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = &dg_bus_frames,
                                       .encoders = encoders,
                                       .wire = wire,
                                       .ops = &ops};

    wire->size = sizeof *wire;
    wire->ops = &frames_ops;
    wire->room = rig.rooms;
    wire->rooms = wire->rooms == 0 ? ROOMS : wire->rooms;
    return dg_bus_init(rig.memory, sizeof rig.memory, &setup);
}

static void make_encoder(size_t i, const char *node)
{
    struct host_rig_place *place = &rig.places[i];
    const size_t size = dg_host_size_on_bus(&dg_f3668, &dg_cia406_wire);

    assert_true(size != 0 && size <= sizeof *place);
    rig.host[i] = dg_host_init_on_bus(place, size, &dg_f3668, &dg_cia406_wire);
    assert_non_null(rig.host[i]);
    assert_int_equal(dg_host_set(rig.host[i], "node", node), DG_HOST_OK);
    rig.control[i] = (struct dg_encoder){.name = "e",
                                         .model = &dg_f3668,
                                         .instrument = &dg_cia406_instrument,
                                         .device = dg_host_line_of(rig.host[i])->device,
                                         .world = dg_host_world(rig.host[i])};
    assert_int_equal(dg_bus_attach(rig.bus, rig.host[i], &rig.control[i]), (int)i);
}

/* Encoders with the node-IDs 1, 2, ...; their boot-ups are through and forgotten. */
static void begin(struct dg_bus_frames_setup wire, size_t encoders)
{
    static const char *const nodes[ENCODERS] = {"1", "2", "3", "4"};

    memset(&rig, 0, sizeof rig);
    rig.bus = make_bus(&wire, encoders);
    assert_non_null(rig.bus);
    for (size_t i = 0; i < encoders; i++) {
        make_encoder(i, nodes[i]);
        assert_int_equal(dg_host_power(rig.host[i], 0, true), DG_HOST_OK);
        (void)dg_bus_changed(rig.bus, i, 0);
    }
    (void)dg_bus_step(rig.bus, DG_S(1));
    rig.count = 0;
}

static dg_ns send_frame(dg_ns at, uint16_t id, uint8_t dlc, const uint8_t *data)
{
    struct dg_tap_event event = {.at = at, .kind = DG_TAP_FRAME, .frame = {.id = id, .dlc = dlc}};

    memcpy(event.frame.data, data, dlc);
    return dg_bus_rx(rig.bus, &event);
}

/* An expedited download of a number to node i + 1. */
static dg_ns write_object(dg_ns at, size_t i, uint16_t index, uint8_t sub, uint32_t value,
                          uint8_t size)
{
    const uint8_t data[8] = {(uint8_t)(0x23u | (4u - size) << 2),
                             (uint8_t)index,
                             (uint8_t)(index >> 8),
                             sub,
                             (uint8_t)value,
                             (uint8_t)(value >> 8),
                             (uint8_t)(value >> 16),
                             (uint8_t)(value >> 24)};

    return send_frame(at, (uint16_t)(ASK + i + 1u), sizeof data, data);
}

static dg_ns ask(dg_ns at, size_t i)
{
    static const uint8_t upload[8] = {0x40, 0x00, 0x10};

    return send_frame(at, (uint16_t)(ASK + i + 1u), sizeof upload, upload);
}

/* Frames with this identifier so far. */
static unsigned count_of(uint16_t id)
{
    unsigned n = 0;

    for (size_t i = 0; i < rig.count; i++) {
        n += rig.sent[i].event.frame.id == id ? 1u : 0u;
    }
    return n;
}

static uint16_t code_of(size_t i)
{
    const uint8_t *data = rig.sent[i].event.frame.data;

    return (uint16_t)(data[0] | data[1] << 8);
}

static void bend(size_t i, const char *name, bool on, uint32_t count, dg_ns now)
{
    const struct dg_fault_limits limits = {
        .count = count, .probability_ppm = 1000000, .duration = DG_NEVER};
    const struct dg_fault_target target = dg_encoder_target(&rig.control[i]);
    const int index = dg_fault_find(&target, name);

    assert_true(index >= 0);
    dg_bus_look(rig.bus, now);
    assert_int_equal(on ? dg_fault_set(&rig.control[i].faults, &target, (size_t)index, now, &limits)
                        : dg_fault_clear(&rig.control[i].faults, &target, (size_t)index),
                     0);
    (void)dg_bus_changed(rig.bus, i, now);
}

/* ------------------------------------------------------------ one encoder */

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

/* What the handle has sent is what the bus has: the same frames at the same moments. */
static size_t compare(size_t done)
{
    struct dg_host_event event;

    while (dg_host_receive(bare, &event) == 1) {
        assert_true(done < rig.count);
        const struct dg_tap_event *other = &rig.sent[done++].event;
        assert_int_equal(event.at, other->at);
        assert_int_equal(event.id, other->frame.id);
        assert_int_equal(event.flags, 0);
        assert_int_equal(event.length, other->frame.dlc);
        assert_memory_equal(event.data, other->frame.data, event.length);
    }
    assert_int_equal(done, rig.count);
    return done;
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
    (void)dg_bus_rx(rig.bus, &other);
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
    dg_bus_look(rig.bus, now);
    dg_host_world(rig.host[0])->temperature_mdegc = (int32_t)value;
    (void)dg_bus_changed(rig.bus, 0, now);
}

static void do_to_both(dg_ns now)
{
    const uint32_t what = pick(20);
    const uint32_t state = pick(3);

    if (what == 0) {
        warm_both(now);
    } else if (what == 1 && (state_of_both != DG_HOST_BUS_OFF || state == DG_HOST_BUS_ACTIVE)) {
        /* Bus-off of a wire lasts until it is active, that of a handle as its host says. */
        state_of_both = state;
        tell_bare(now, state);
        (void)dg_bus_frames_controller(rig.bus, now, (enum dg_host_bus)state);
    } else if (what == 2) {
        tell_bare(now, DG_HOST_BUS_OVERRUN);
        (void)dg_bus_frames_controller(rig.bus, now, DG_HOST_BUS_OVERRUN);
    } else {
        say_to_both(now, pick(DG_COUNT(said)), pick(8) == 0);
    }
}

static void a_bus_of_one_is_its_handle(void **state)
{
    (void)state;
    for (uint32_t seed = 1; seed <= 20; seed++) {
        dg_ns now = DG_S(1);
        size_t done = 0;
        chance = seed;
        state_of_both = DG_HOST_BUS_ACTIVE;
        begin((struct dg_bus_frames_setup){.pace = false}, 1);
        bare = host_rig_make(&bare_place, "f3668");
        assert_int_equal(dg_host_set(bare, "node", "1"), DG_HOST_OK);
        assert_int_equal(dg_host_power(bare, 0, true), DG_HOST_OK);
        (void)dg_host_step(bare, now);
        struct dg_host_event event;
        while (dg_host_receive(bare, &event) == 1) {
        }
        for (unsigned i = 0; i < 100; i++) {
            now += pick(4) == 0 ? 0 : pick(40000000);
            rig.count -= done;
            memmove(rig.sent, rig.sent + done, rig.count * sizeof rig.sent[0]);
            done = 0;
            do_to_both(now);
            done = compare(done);
            /* Many deadlines at once, each at its own moment. */
            const dg_ns next = dg_bus_step(rig.bus, now + DG_MS(20));
            assert_int_equal(dg_host_step(bare, now + DG_MS(20)), next);
            now += DG_MS(20);
            done = compare(done);
        }
    }
}

static void sizes(void **state)
{
    struct dg_bus_frames_setup wire = {.rooms = UINT16_MAX};

    (void)state;
    assert_true(dg_host_size_with_port(&dg_f3668, &dg_cia406_wire) <= 2000);
    assert_int_equal(dg_bus_size(&dg_bus_frames, 0), 0);
    assert_int_equal(dg_bus_size(&dg_bus_frames, DG_BUS_FRAMES_ENCODERS + 1u), 0);
    assert_true(dg_bus_size(&dg_bus_frames, DG_BUS_FRAMES_ENCODERS) <=
                (size_t)DG_BUS_FRAMES_ENCODERS * 256u + 5000u);
    assert_null(make_bus(&wire, 1));
    wire.rooms = 1;
    assert_non_null(make_bus(&wire, 1));
}

/* ------------------------------------------------------------ several */

/* All of them answer one SYNC, in the order of their places, or of their identifiers. */
static void order_at_one_moment(void **state)
{
    static const uint16_t ids[ENCODERS] = {0x1F0, 0x182, 0x1E0, 0x18F};
    static const uint16_t in_order[ENCODERS] = {0x182, 0x18F, 0x1E0, 0x1F0};
    static const uint8_t go[2] = {1, 0};

    (void)state;
    for (int arbitrate = 0; arbitrate < 2; arbitrate++) {
        begin((struct dg_bus_frames_setup){.arbitrate = arbitrate != 0}, ENCODERS);
        for (size_t i = 0; i < ENCODERS; i++) {
            (void)write_object(DG_S(2), i, 0x1800, 1, 0x80000000u | ids[i], 4);
            (void)write_object(DG_S(2), i, 0x1800, 2, 1, 1);
            (void)write_object(DG_S(2), i, 0x1800, 1, ids[i], 4);
            (void)write_object(DG_S(2), i, 0x1801, 1, 0x80000280u, 4);
        }
        (void)send_frame(DG_S(3), 0, sizeof go, go);
        (void)dg_bus_step(rig.bus, DG_S(4));
        rig.count = 0;
        (void)send_frame(DG_S(5), 0x80, 0, go);
        assert_int_equal(rig.count, ENCODERS);
        for (size_t i = 0; i < ENCODERS; i++) {
            const uint16_t id = arbitrate != 0 ? in_order[i] : ids[i];
            assert_int_equal(rig.sent[i].event.frame.id, id);
            assert_int_equal(rig.sent[i].event.at, DG_S(5));
        }
    }
}

/* Encoder 2 watches the heartbeat of encoder 1; at one moment, and not the other way round. */
static void they_hear_each_other(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.pace = false}, 3);
    const unsigned before = rig.filters;
    rig.wanted = 0x701;
    (void)write_object(DG_S(2), 1, 0x1016, 1, 1u << 16 | 250u, 4);
    assert_true(rig.open_before); /* the filter was open before the answer was out */
    assert_int_equal(rig.filters, before + 1u);
    (void)write_object(DG_S(2), 0, 0x1017, 0, 100, 2);
    (void)dg_bus_step(rig.bus, DG_S(4));
    assert_int_equal(count_of(HEARTBEAT + 1), 21); /* the first one at once */
    assert_int_equal(count_of(EMCY + 2), 0);
    bend(0, "wire_drop", true, 0, DG_S(4));
    (void)dg_bus_step(rig.bus, DG_S(5));
    assert_int_equal(count_of(EMCY + 2), 1);
    assert_int_equal(rig.sent[rig.count - 1].event.at, DG_S(4) + DG_MS(250));
    bend(0, "wire_drop", false, 0, DG_S(5));
    (void)dg_bus_step(rig.bus, DG_S(6));
    assert_int_equal(count_of(EMCY + 2), 2);
    bend(1, "wire_deaf", true, 0, DG_S(6));
    (void)dg_bus_step(rig.bus, DG_S(7));
    assert_int_equal(count_of(EMCY + 2), 3);
    assert_int_equal(count_of(EMCY + 3), 0);
}

/* ------------------------------------------------------------ the wire */

static void those_of_another_bit_rate_are_deaf_and_mute(void **state)
{
    struct dg_bus_frames_line line = {.bit_rate = 125000, .company = DG_BUS_SOMEBODY};

    (void)state;
    begin((struct dg_bus_frames_setup){.pace = false}, 2);
    assert_int_equal(rig.retuned[1], 250000);
    assert_int_equal(dg_bus_frames_bit_rate(rig.bus), 250000);
    (void)write_object(DG_S(2), 0, 0x1017, 0, 100, 2);
    (void)dg_bus_step(rig.bus, DG_S(3));
    assert_int_equal(count_of(HEARTBEAT + 1), 11);
    dg_bus_frames_set_line(rig.bus, &line);
    (void)dg_bus_step(rig.bus, DG_S(3));
    assert_false(dg_bus_frames_hears(rig.bus, 0));
    assert_false(dg_bus_frames_listens(rig.bus, 0x601));
    rig.count = 0;
    (void)ask(DG_S(3), 0);
    (void)dg_bus_step(rig.bus, DG_S(4));
    assert_int_equal(rig.count, 0);
    line.tolerant = true;
    dg_bus_frames_set_line(rig.bus, &line);
    (void)ask(DG_S(4) + DG_MS(1), 0); /* it is so from this call on */
    (void)ask(DG_S(4) + DG_MS(2), 0);
    assert_int_equal(count_of(SDO + 1), 1);
    line = (struct dg_bus_frames_line){.closed = true};
    dg_bus_frames_set_line(rig.bus, &line);
    (void)dg_bus_step(rig.bus, DG_S(5));
    rig.count = 0;
    (void)ask(DG_S(5), 0);
    (void)dg_bus_step(rig.bus, DG_S(6));
    assert_int_equal(rig.count, 0);
}

static enum dg_cia406_lamp lamp_of(size_t i)
{
    return dg_cia406_leds(dg_host_line_of(rig.host[i])->device).bus_pattern;
}

/* As they feel it, C38. */
static void a_bus_is_there_or_not(void **state)
{
    struct dg_bus_frames_line line = {.company = DG_BUS_NOBODY};

    (void)state;
    begin((struct dg_bus_frames_setup){.line = line}, 1);
    assert_int_equal(lamp_of(0), DG_CIA406_LAMP_OFF);
    line.company = DG_BUS_SOMEBODY;
    dg_bus_frames_set_line(rig.bus, &line);
    (void)dg_bus_step(rig.bus, DG_S(2));
    assert_int_equal(lamp_of(0), DG_CIA406_LAMP_BLINK);
    line.company = DG_BUS_NOBODY;
    dg_bus_frames_set_line(rig.bus, &line);
    (void)dg_bus_step(rig.bus, DG_S(3));
    assert_int_equal(lamp_of(0), DG_CIA406_LAMP_OFF);
}

/* 8 bytes at 250 kBd: 135 bits of 4 us; the first frame at once. */
static void frames_have_their_time(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.pace = true}, ENCODERS);
    const uint64_t bits = dg_bus_frames_bits(rig.bus);
    for (size_t i = 0; i < ENCODERS; i++) {
        (void)ask(DG_S(2), i);
    }
    (void)dg_bus_step(rig.bus, DG_S(3));
    assert_int_equal(rig.count, ENCODERS);
    /* Of the master's four, which came at once, the present one counts. */
    for (size_t i = 1; i < ENCODERS; i++) {
        assert_int_equal(rig.sent[i].event.at - DG_S(2), (i + 1) * DG_US(540));
    }
    assert_int_equal(dg_bus_frames_bits(rig.bus) - bits, 8u * 135u);
    assert_int_equal(dg_bus_frames_counters(rig.bus)->stalls, 0);
}

/* More than fits the time: the encoders wait, and nothing is lost. */
static void too_much_makes_them_wait(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.pace = true, .line = {.bit_rate = 10000, .tolerant = true}},
          1);
    for (unsigned i = 0; i < DG_BUS_FRAMES_PACED + 1u; i++) {
        assert_false(dg_bus_frames_waits(rig.bus));
        (void)ask(DG_S(2), 0);
    }
    assert_true(dg_bus_frames_waits(rig.bus));
    assert_int_equal(dg_bus_frames_counters(rig.bus)->stalls, 1);
    (void)dg_bus_step(rig.bus, DG_S(3));
    assert_int_equal(rig.count, DG_BUS_FRAMES_PACED + 1u);
    assert_false(dg_bus_frames_waits(rig.bus));
    assert_int_equal(dg_bus_frames_counters(rig.bus)->lost, 0);
}

/* A late host: what has waited is made up for, 5 ms of it at most. */
static void a_late_host(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.pace = true, .real_time = true}, 1);
    (void)write_object(DG_S(2), 0, 0x1017, 0, 100, 2);
    rig.count = 0;
    (void)dg_bus_step(rig.bus, DG_S(3) + DG_MS(42));
    assert_int_equal(count_of(HEARTBEAT + 1), 1); /* what was missed is left out */
    assert_int_equal(rig.sent[0].event.at, DG_S(3) + DG_MS(42));
    (void)dg_bus_step(rig.bus, DG_S(3) + DG_MS(142));
    assert_int_equal(count_of(HEARTBEAT + 1), 2);
    for (unsigned i = 0; i < 30; i++) {
        (void)ask(DG_S(4), 0);
    }
    rig.count = 0;
    (void)dg_bus_step(rig.bus, DG_S(5));
    assert_int_equal(count_of(SDO + 1), 10); /* of 540 us each */
}

static void a_port_without_room(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.pace = false}, 1);
    (void)write_object(DG_S(2), 0, 0x1017, 0, 100, 2);
    dg_bus_frames_stall(rig.bus, true);
    rig.count = 0;
    assert_int_equal(dg_bus_step(rig.bus, DG_S(3)), DG_NEVER);
    assert_int_equal(rig.count, 0);
    dg_bus_frames_stall(rig.bus, false);
    assert_int_not_equal(dg_bus_step(rig.bus, DG_S(3)), DG_NEVER);
    assert_int_equal(rig.count, 1);
}

/* ------------------------------------------------------------ memories */

static void answers_wait_for_the_memory(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.pace = false}, 1);
    rig.answer = DG_BUS_KEEP;
    (void)write_object(DG_S(2), 0, 0x1017, 0, 100, 2);
    (void)ask(DG_S(2), 0);
    (void)dg_bus_step(rig.bus, DG_S(3));
    assert_int_equal(count_of(SDO + 1), 0);
    assert_int_equal(count_of(HEARTBEAT + 1), 11); /* nothing else waits */
    (void)dg_bus_durable(rig.bus, 0, DG_S(3));
    assert_int_equal(count_of(SDO + 1), 0);
    rig.answer = DG_BUS_SAY;
    (void)dg_bus_durable(rig.bus, 0, DG_S(3));
    assert_int_equal(count_of(SDO + 1), 2);
    assert_int_equal(rig.sent[rig.count - 2].event.frame.data[0], 0x60); /* in their order */
    rig.answer = DG_BUS_KEEP;
    (void)ask(DG_S(4), 0);
    rig.answer = DG_BUS_DROP;
    (void)dg_bus_durable(rig.bus, 0, DG_S(4));
    rig.answer = DG_BUS_KEEP;
    (void)ask(DG_S(5), 0);
    dg_host_power(rig.host[0], DG_S(5), false);
    (void)dg_bus_changed(rig.bus, 0, DG_S(5));
    rig.answer = DG_BUS_SAY;
    (void)dg_bus_durable(rig.bus, 0, DG_S(5));
    assert_int_equal(count_of(SDO + 1), 2);
    assert_int_equal(dg_bus_frames_counters(rig.bus)->lost, 0);
}

/* Whoever brings no memory loses frames, and they are counted. */
static void what_finds_no_room_is_lost(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.rooms = 3}, 1);
    rig.answer = DG_BUS_KEEP;
    for (unsigned i = 0; i < 5; i++) {
        (void)ask(DG_S(2), 0);
    }
    assert_int_equal(dg_bus_frames_counters(rig.bus)->lost, 2);
    rig.answer = DG_BUS_SAY;
    (void)dg_bus_durable(rig.bus, 0, DG_S(3));
    assert_int_equal(count_of(SDO + 1), 3);
}

/* ------------------------------------------------------------ faults */

static void late_and_twice(void **state)
{
    const dg_ns delay = (dg_ns)dg_fault_wire_value(&dg_cia406_instrument, DG_WIRE_DELAY);

    (void)state;
    begin((struct dg_bus_frames_setup){.pace = false}, 2);
    bend(0, "wire_delay", true, 1, DG_S(2));
    (void)ask(DG_S(2), 0);
    (void)ask(DG_S(2) + 5, 0); /* behind the one that is late */
    (void)ask(DG_S(2) + 6, 1);
    (void)dg_bus_step(rig.bus, DG_S(4));
    assert_int_equal(rig.count, 3);
    assert_int_equal(rig.sent[0].event.frame.id, SDO + 2);
    for (size_t i = 1; i < 3; i++) {
        assert_int_equal(rig.sent[i].event.frame.id, SDO + 1);
        assert_int_equal(rig.sent[i].event.at, DG_S(2) + delay);
    }
    bend(0, "wire_duplicate", true, 1, DG_S(5));
    (void)ask(DG_S(5), 0);
    assert_int_equal(count_of(SDO + 1), 4);
    bend(0, "wire_damage", true, 1, DG_S(6));
    (void)ask(DG_S(6), 0);
    const struct dg_can_frame *good = &rig.sent[rig.count - 2].event.frame;
    const struct dg_can_frame *bad = &rig.sent[rig.count - 1].event.frame;
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
    begin((struct dg_bus_frames_setup){.pace = false}, 2);
    bend(0, "bus_off", true, 0, DG_S(2));
    (void)ask(DG_S(2), 0);
    (void)ask(DG_S(2), 1);
    assert_int_equal(rig.count, 1);
    bend(0, "error_passive", true, 0, DG_S(3));
    bend(0, "bus_off", false, 0, DG_S(4));
    assert_int_equal(count_of(EMCY + 1), 3);
    assert_int_equal(code_of(1), 0x8140);
    assert_int_equal(code_of(3), 0x8120);
    (void)dg_bus_frames_controller(rig.bus, DG_S(5), DG_HOST_BUS_PASSIVE);
    assert_int_equal(count_of(EMCY + 1), 3);
    assert_int_equal(count_of(EMCY + 2), 1);
    (void)dg_bus_frames_controller(rig.bus, DG_S(6), DG_HOST_BUS_OFF);
    (void)dg_bus_frames_controller(rig.bus, DG_S(6), DG_HOST_BUS_PASSIVE); /* it stays off */
    rig.count = 0;
    (void)ask(DG_S(6), 1);
    assert_int_equal(rig.count, 0);
    (void)dg_bus_frames_controller(rig.bus, DG_S(7), DG_HOST_BUS_ACTIVE);
    assert_int_equal(count_of(EMCY + 2), 2); /* 8140h, 0000h */
    bend(1, "overrun", true, 1, DG_S(8));
    rig.count = 0;
    (void)ask(DG_S(8), 1);
    assert_int_equal(code_of(0), 0x8110);
    assert_int_equal(count_of(SDO + 2), 0);
    (void)ask(DG_S(9), 1);
    assert_int_equal(count_of(SDO + 2), 1);
}

/* A power cycle does not heal the bus. */
static void a_controller_outlives_the_power(void **state)
{
    (void)state;
    begin((struct dg_bus_frames_setup){.pace = false}, 1);
    bend(0, "bus_off", true, 0, DG_S(2));
    dg_bus_look(rig.bus, DG_S(3));
    assert_int_equal(dg_encoder_power(&rig.control[0], DG_S(3), false), 0);
    (void)dg_bus_changed(rig.bus, 0, DG_S(3));
    assert_false(dg_bus_frames_listens(rig.bus, 0x601));
    assert_int_equal(dg_encoder_power(&rig.control[0], DG_S(3), true), 0);
    (void)dg_bus_changed(rig.bus, 0, DG_S(3));
    assert_int_equal(rig.count, 0);
    (void)ask(DG_S(4), 0);
    assert_int_equal(rig.count, 0);
    bend(0, "bus_off", false, 0, DG_S(5));
    assert_int_equal(code_of(0), 0x8140);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bus_of_one_is_its_handle),
        cmocka_unit_test(sizes),
        cmocka_unit_test(order_at_one_moment),
        cmocka_unit_test(they_hear_each_other),
        cmocka_unit_test(those_of_another_bit_rate_are_deaf_and_mute),
        cmocka_unit_test(a_bus_is_there_or_not),
        cmocka_unit_test(frames_have_their_time),
        cmocka_unit_test(too_much_makes_them_wait),
        cmocka_unit_test(a_late_host),
        cmocka_unit_test(a_port_without_room),
        cmocka_unit_test(answers_wait_for_the_memory),
        cmocka_unit_test(what_finds_no_room_is_lost),
        cmocka_unit_test(late_and_twice),
        cmocka_unit_test(controllers),
        cmocka_unit_test(a_controller_outlives_the_power),
    };
    return cmocka_run_group_tests_name("a bus of frames", tests, NULL, NULL);
}

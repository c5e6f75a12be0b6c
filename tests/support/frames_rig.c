/* SPDX-License-Identifier: MIT */
#include "frames_rig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/instruments.h"

struct frames_rig frames_rig;

/* ------------------------------------------------------------ the door */

static void tx(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    assert_true(frames_rig.count < FRAMES_RIG_SENT_MAX && event->ours &&
                event->kind == DG_TAP_FRAME);
    frames_rig.sent[frames_rig.count++] = (struct frames_rig_sent){place, *event};
    frames_rig.open_before = dg_bus_frames_listens(frames_rig.bus, frames_rig.wanted);
    if (frames_rig.stall_at != 0 && event->frame.id == frames_rig.stall_at) {
        dg_bus_frames_stall(frames_rig.bus, true);
    }
}

static void tap(void *ctx, const struct dg_tap_event *event)
{
    static dg_ns latest;

    (void)ctx;
    frames_rig.tapped++;
    assert_true(event->at >= latest || frames_rig.tapped == 1);
    latest = event->at;
}

static enum dg_bus_answer answer(void *ctx, size_t place)
{
    (void)ctx;
    (void)place;
    return frames_rig.answer;
}

static void filter(void *ctx)
{
    (void)ctx;
    frames_rig.filters++;
}

static void retuned(void *ctx, size_t place, uint32_t bit_rate)
{
    (void)ctx;
    frames_rig.retuned[place] = bit_rate;
}

static const struct dg_bus_ops ops = {.tx = tx, .tap = tap, .answer = answer};
static const struct dg_bus_frames_ops frames_ops = {.filter = filter, .retuned = retuned};

struct dg_bus *frames_rig_make_bus(struct dg_bus_frames_setup *wire, size_t encoders)
{
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = &dg_bus_frames,
                                       .encoders = encoders,
                                       .wire = wire,
                                       .ops = &ops};

    wire->size = sizeof *wire;
    wire->ops = &frames_ops;
    wire->room = frames_rig.rooms;
    wire->rooms = wire->rooms == 0 ? FRAMES_RIG_ROOMS : wire->rooms;
    return dg_bus_init(frames_rig.memory, sizeof frames_rig.memory, &setup);
}

static void make_encoder(size_t i, const char *node)
{
    struct host_rig_place *place = &frames_rig.places[i];
    const size_t size = dg_host_size_on_bus(&dg_f3668, &dg_cia406_side);

    assert_true(size != 0 && size <= sizeof *place);
    frames_rig.host[i] = dg_host_init_on_bus(place, size, &dg_f3668, &dg_cia406_side);
    assert_non_null(frames_rig.host[i]);
    assert_int_equal(dg_host_set(frames_rig.host[i], "node", node), DG_HOST_OK);
    frames_rig.control[i] =
        (struct dg_encoder){.name = "e",
                            .model = &dg_f3668,
                            .instrument = &dg_cia406_instrument,
                            .device = dg_host_line_of(frames_rig.host[i])->device,
                            .world = dg_host_world(frames_rig.host[i])};
    assert_int_equal(dg_bus_attach(frames_rig.bus, frames_rig.host[i], &frames_rig.control[i]),
                     (int)i);
}

/* Encoders with the node-IDs 1, 2, ...; their boot-ups are through and forgotten. */
void frames_rig_begin(struct dg_bus_frames_setup wire, size_t encoders)
{
    static const char *const nodes[FRAMES_RIG_ENCODERS] = {"1", "2", "3", "4"};

    memset(&frames_rig, 0, sizeof frames_rig);
    frames_rig.bus = frames_rig_make_bus(&wire, encoders);
    assert_non_null(frames_rig.bus);
    for (size_t i = 0; i < encoders; i++) {
        make_encoder(i, nodes[i]);
        assert_int_equal(dg_host_power(frames_rig.host[i], 0, true), DG_HOST_OK);
        (void)dg_bus_changed(frames_rig.bus, i, 0);
    }
    (void)dg_bus_step(frames_rig.bus, DG_S(1));
    frames_rig.count = 0;
}

dg_ns frames_rig_send(dg_ns at, uint16_t id, uint8_t dlc, const uint8_t *data)
{
    struct dg_tap_event event = {.at = at, .kind = DG_TAP_FRAME, .frame = {.id = id, .dlc = dlc}};

    memcpy(event.frame.data, data, dlc);
    return dg_bus_rx(frames_rig.bus, &event);
}

/* An expedited download of a number to node i + 1. */
dg_ns frames_rig_write(dg_ns at, size_t i, uint16_t index, uint8_t sub, uint32_t value,
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

    return frames_rig_send(at, (uint16_t)(ASK + i + 1u), sizeof data, data);
}

dg_ns frames_rig_ask(dg_ns at, size_t i)
{
    static const uint8_t upload[8] = {0x40, 0x00, 0x10};

    return frames_rig_send(at, (uint16_t)(ASK + i + 1u), sizeof upload, upload);
}

/* Frames with this identifier so far. */
unsigned frames_rig_count(uint16_t id)
{
    unsigned n = 0;

    for (size_t i = 0; i < frames_rig.count; i++) {
        n += frames_rig.sent[i].event.frame.id == id ? 1u : 0u;
    }
    return n;
}

uint16_t frames_rig_code(size_t i)
{
    const uint8_t *data = frames_rig.sent[i].event.frame.data;

    return (uint16_t)(data[0] | data[1] << 8);
}

void frames_rig_bend(size_t i, const char *name, bool on, uint32_t count, dg_ns now)
{
    const struct dg_fault_limits limits = {
        .count = count, .probability_ppm = 1000000, .duration = DG_NEVER};
    const struct dg_fault_target target = dg_encoder_target(&frames_rig.control[i]);
    const int index = dg_fault_find(&target, name);

    assert_true(index >= 0);
    dg_bus_look(frames_rig.bus, now);
    assert_int_equal(
        on ? dg_fault_set(&frames_rig.control[i].faults, &target, (size_t)index, now, &limits)
           : dg_fault_clear(&frames_rig.control[i].faults, &target, (size_t)index),
        0);
    (void)dg_bus_changed(frames_rig.bus, i, now);
}

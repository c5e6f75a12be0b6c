/* SPDX-License-Identifier: MIT */
/*
 * A line of characters is nobody's own: a made-up protocol on it, of which the library knows
 * nothing. One character asks, eleven without parity at 2.5 MBd answer: what was asked, a position
 * of 24 bits, a status, five zeros, and their CRC. Its figures are those of no device.
 *
 *   master  |02|
 *   encoder     3 us |02 p p p s 0 0 0 0 0 c|
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/angle.h"
#include "drehgeber/bus_characters.h"
#include "drehgeber/control.h"
#include "drehgeber/devices.h"
#include "drehgeber/host_wire.h"
#include "host_rig.h"

#define BAUD 2500000u
#define CHARACTER 4000u
#define REACTION 3000u
#define REPLY 11u
#define EVENTS_MAX 64u

/* ------------------------------------------------------------ the protocol */

struct other {
    struct dg_host_line *line;
    const struct dg_world *world;
    bool on;
    dg_ns due;
    uint8_t asked;
};

static const struct dg_store_layout *layout(const void *model)
{
    (void)model;
    return NULL;
}

static bool senses_multiturn(const void *model)
{
    (void)model;
    return false;
}

static int format(const struct dg_stack_setup *setup)
{
    (void)setup;
    return DG_OK;
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct other *device = self;

    device->line = setup != NULL ? setup->ctx : NULL;
    device->world = setup != NULL ? setup->world : NULL;
}

static int init(void *self, const struct dg_stack_setup *setup)
{
    memset(self, 0, sizeof(struct other));
    attach(self, setup);
    return DG_OK;
}

static int power_on(void *self, dg_ns now)
{
    struct other *device = self;

    (void)now;
    device->on = true;
    device->due = DG_NEVER;
    return DG_OK;
}

static void power_off(void *self)
{
    struct other *device = self;

    device->on = false;
    device->due = DG_NEVER;
}

static bool powered(const void *self)
{
    return ((const struct other *)self)->on;
}

static uint64_t position(const void *self, dg_ns now)
{
    const struct other *device = self;

    return (uint64_t)device->world->angle(device->world->angle_ctx, now) >> 8 & 0xFFFFFFu;
}

static uint8_t crc_of(const uint8_t *bytes, size_t n)
{
    uint8_t crc = 0;

    for (size_t i = 0; i < n; i++) {
        crc ^= bytes[i]; /* x^8 + 1 */
    }
    return crc;
}

static dg_ns step(void *self, dg_ns now)
{
    struct other *device = self;

    if (device->on && device->due <= now) {
        const uint64_t counts = position(self, now);
        struct dg_host_event event = {.at = now,
                                      .kind = DG_HOST_BYTES,
                                      .id = CHARACTER,
                                      .length = REPLY,
                                      .data = {device->asked, (uint8_t)counts,
                                               (uint8_t)(counts >> 8), (uint8_t)(counts >> 16)}};
        event.data[REPLY - 1] = crc_of(event.data, REPLY - 1);
        device->due = DG_NEVER;
        dg_host_emit(device->line, &event);
    }
    return device->due;
}

static const void *model(const void *self)
{
    return self;
}

static const struct dg_stack stack = {
    .name = "other",
    .medium = DG_MEDIUM_CHARACTERS,
    .device_size = sizeof(struct other),
    DG_STACK_OPERATIONS,
};

static const uint8_t figures[8];
static const struct dg_device device_row = {"other", "characters", "24 bits", &stack, figures};

static int check(const struct dg_host_event *event)
{
    return event->kind == DG_HOST_BYTES ? DG_HOST_OK : DG_HOST_ERR_WIRE;
}

static bool take(struct dg_host_line *line, const struct dg_host_event *event)
{
    struct other *device = line->device;

    if ((event->flags & (DG_HOST_START | DG_HOST_DAMAGED)) == 0) {
        device->asked = event->data[0];
        device->due = line->now + REACTION;
    }
    return true;
}

static void tell_uart(const struct dg_host_line *line, bool stored, struct dg_host_uart *to)
{
    (void)line;
    (void)stored;
    *to = (struct dg_host_uart){.baud = BAUD, .parity = 'N', .timeout_bits = 10};
}

static const struct dg_keys no_keys;
static const struct dg_host_wire wire = {
    .stack = &stack,
    .keys = &no_keys,
    .settings_size = sizeof figures,
    .check = check,
    .take = take,
    .uart = tell_uart,
};

/* ------------------------------------------------------------ the line */

struct line {
    struct host_rig_place places[2];
    alignas(DG_HOST_ALIGN) uint8_t memory[16384];
    struct dg_bus *bus;
    struct dg_tap_event sent[EVENTS_MAX];
    size_t count;
};

static void keep_sent(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct line *self = ctx;

    assert_int_equal(place, 0);
    assert_true(self->count < EVENTS_MAX);
    self->sent[self->count++] = *event;
}

static void make_line(struct line *self, struct dg_encoder *control)
{
    static const struct dg_bus_ops ops = {.tx = keep_sent};
    const struct dg_characters_setup paced = {.size = sizeof paced, .paced = true};
    const struct dg_bus_setup setup = {.size = sizeof setup,
                                       .medium = &dg_bus_characters,
                                       .encoders = 2,
                                       .wire = &paced,
                                       .ops = &ops,
                                       .ctx = self};
    const size_t size = dg_host_size(&device_row, &wire);
    struct dg_host *host = dg_host_init(self->places[0].bytes, size, &device_row, &wire);

    self->count = 0;
    self->bus = dg_bus_init(self->memory, sizeof self->memory, &setup);
    assert_non_null(host);
    assert_non_null(self->bus);
    dg_host_shaft(host, 0, INT64_C(0x12345600), 0);
    assert_int_equal(dg_host_power(host, 0, true), DG_HOST_OK);
    assert_int_equal(dg_bus_attach(self->bus, host, control), 0);
}

static void say(struct line *self, dg_ns at, uint32_t baud, uint8_t byte)
{
    const struct dg_tap_event event = {
        .at = at, .kind = DG_TAP_CHARACTER, .character = {baud, 'N', byte, false}};

    self->count = 0;
    (void)dg_bus_rx(self->bus, &event);
    (void)dg_bus_step(self->bus, at + MS);
}

static const uint8_t expected[REPLY] = {0x02, 0x56, 0x34, 0x12, 0, 0, 0, 0, 0, 0, 0x72};

static void it_answers_with_its_own_frame(void **state)
{
    static struct line line;

    (void)state;
    make_line(&line, NULL);
    say(&line, READY, BAUD, 0x02);
    assert_int_equal(line.count, REPLY);
    for (size_t i = 0; i < REPLY; i++) {
        assert_int_equal(line.sent[i].character.byte, expected[i]);
        assert_int_equal(line.sent[i].at - READY, CHARACTER + REACTION + (i + 1) * CHARACTER);
        assert_int_equal(line.sent[i].character.baud, BAUD);
        assert_int_equal(line.sent[i].character.parity, 'N');
    }
    say(&line, 2 * READY, 9600, 0x02);
    assert_int_equal(line.count, 0);
}

/* It has no addresses: each request is for it. */
static void it_may_be_deaf(void **state)
{
    struct dg_encoder control = {.name = "other"};
    static struct line line;

    (void)state;
    make_line(&line, &control);
    control.faults.wire = 1u << DG_WIRE_DEAF;
    control.faults.fault[0] =
        (struct dg_fault){.active = true, .left = 1, .probability_ppm = 1000000, .until = DG_NEVER};
    say(&line, READY, BAUD, 0x02);
    assert_int_equal(line.count, 0);
    say(&line, 2 * READY, BAUD, 0x02);
    assert_int_equal(line.count, REPLY);
}

/* An S36 beside it reads nothing of what it says, and does not answer. */
static void it_may_be_beside_another_protocol(void **state)
{
    static struct line line;
    struct dg_host *neighbour = host_rig_make(&line.places[1], "s3684-rs485");

    (void)state;
    make_line(&line, NULL);
    assert_int_equal(dg_host_power(neighbour, 0, true), DG_HOST_OK);
    assert_int_equal(dg_bus_attach(line.bus, neighbour, NULL), 1);
    say(&line, READY, BAUD, 0x02);
    assert_int_equal(line.count, REPLY);
    assert_memory_equal(&line.sent[0].character.byte, &expected[0], 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_answers_with_its_own_frame),
        cmocka_unit_test(it_may_be_deaf),
        cmocka_unit_test(it_may_be_beside_another_protocol),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

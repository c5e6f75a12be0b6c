/* SPDX-License-Identifier: MIT */
/*
 * A line of characters is nobody's own: a made-up protocol on it (drehgeber/eleven.h), of which the
 * library knows nothing, alone and beside an S36.
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
#include "drehgeber/eleven.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/host_wire.h"
#include "host_rig.h"

#define REACTION 3000u
#define EVENTS_MAX 64u

/* ------------------------------------------------------------ the line */

struct line {
    struct host_rig_place places[2];
    alignas(DG_HOST_ALIGN) uint8_t memory[16384];
    struct dg_host *host;
    struct dg_bus *bus;
    struct dg_tap_event sent[EVENTS_MAX];
    size_t count;
};

static void keep_sent(void *ctx, size_t place, const struct dg_tap_event *event)
{
    struct line *self = ctx;

    (void)place;
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
    const size_t size = dg_host_size_on_bus(&dg_eleven_24, &dg_eleven_side);
    struct dg_host *host =
        dg_host_init_on_bus(self->places[0].bytes, size, &dg_eleven_24, &dg_eleven_side);

    self->count = 0;
    self->host = host;
    self->bus = dg_bus_init(self->memory, sizeof self->memory, &setup);
    assert_non_null(host);
    assert_non_null(self->bus);
    dg_host_shaft(host, 0, INT64_C(0x12345600), 0);
    assert_int_equal(dg_host_power(host, 0, true), DG_HOST_OK);
    assert_int_equal(dg_bus_attach(self->bus, host, control), 0);
}

static void send_character(struct line *self, dg_ns at, uint32_t baud, char parity, uint8_t byte)
{
    const struct dg_tap_event event = {
        .at = at, .kind = DG_TAP_CHARACTER, .character = {baud, parity, byte, false}};

    self->count = 0;
    (void)dg_bus_rx(self->bus, &event);
    (void)dg_bus_step(self->bus, at + MS);
}

static const uint8_t expected[DG_ELEVEN_REPLY] = {0x02, 0x56, 0x34, 0x12, 0, 0, 0, 0, 0, 0, 0x72};

static void it_answers_with_its_own_frame(void **state)
{
    static struct line line;

    (void)state;
    make_line(&line, NULL);
    send_character(&line, READY, DG_ELEVEN_BAUD, 'N', 0x02);
    assert_int_equal(line.count, DG_ELEVEN_REPLY);
    for (size_t i = 0; i < DG_ELEVEN_REPLY; i++) {
        assert_int_equal(line.sent[i].character.byte, expected[i]);
        assert_int_equal(line.sent[i].at - READY,
                         DG_ELEVEN_CHARACTER_NS + REACTION + (i + 1) * DG_ELEVEN_CHARACTER_NS);
        assert_int_equal(line.sent[i].character.baud, DG_ELEVEN_BAUD);
        assert_int_equal(line.sent[i].character.parity, 'N');
    }
    send_character(&line, 2 * READY, 9600, 'N', 0x02);
    assert_int_equal(line.count, 0);
}

static void it_may_be_deaf(void **state)
{
    struct dg_encoder control = {.name = "foreign"};
    static struct line line;

    (void)state;
    make_line(&line, &control);
    control.faults.wire = 1u << DG_WIRE_DEAF;
    control.faults.fault[0] =
        (struct dg_fault){.active = true, .left = 1, .probability_ppm = 1000000, .until = DG_NEVER};
    send_character(&line, READY, DG_ELEVEN_BAUD, 'N', 0x8A); /* for slot 1: not its loss */
    send_character(&line, READY + MS, DG_ELEVEN_BAUD, 'N', 0x02);
    assert_int_equal(line.count, 0);
    send_character(&line, 2 * READY, DG_ELEVEN_BAUD, 'N', 0x02);
    assert_int_equal(line.count, DG_ELEVEN_REPLY);
}

/* Each answers its own requests, and hears those and the replies of the other, at the wrong data
 * rate. */
static void it_may_be_beside_another_protocol(void **state)
{
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    static struct line line;
    struct dg_host *neighbour = host_rig_make(&line.places[1], "s3684-rs485");

    (void)state;
    make_line(&line, NULL);
    assert_int_equal(dg_host_power(neighbour, 0, true), DG_HOST_OK);
    assert_int_equal(dg_bus_attach(line.bus, neighbour, NULL), 1);
    const struct dg_eleven *eleven = dg_host_line_of(line.host)->device;
    const struct dg_hf *s36 = dg_host_line_of(neighbour)->device;
    send_character(&line, READY, DG_ELEVEN_BAUD, 'N', 0x02);
    assert_int_equal(line.count, DG_ELEVEN_REPLY);
    assert_int_equal(line.sent[0].character.byte, expected[0]);
    (void)dg_bus_step(line.bus, 2 * READY);
    assert_int_equal(s36->counters.frames, 0);
    assert_true(s36->counters.damaged > 0);
    for (unsigned i = 0; i < sizeof request; i++) {
        send_character(&line, 2 * READY + (i + 1) * 2 * MS, 9600, 'E', request[i]);
    }
    (void)dg_bus_step(line.bus, 3 * READY);
    assert_int_equal(line.count, 7);
    assert_int_equal(line.sent[0].character.byte, 0x40);
    assert_int_equal(line.sent[0].character.baud, 9600);
    assert_int_equal(eleven->counters.replies, 1);
    assert_int_equal(eleven->counters.damaged, sizeof request + 7);
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

/* SPDX-License-Identifier: MIT */
/*
 * DG_NEVER is no moment on a bus, whatever its medium: it does not run on to the end of time, which
 * an encoder that looks after itself again and again never comes to.
 */
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/bus_characters.h"
#include "drehgeber/bus_edges.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/devices.h"
#include "drehgeber/host_wire.h"

#define ROOM 65536u
#define NOW DG_S(1)

static alignas(DG_HOST_ALIGN) uint8_t of_encoder[ROOM];
static alignas(DG_HOST_ALIGN) uint8_t of_bus[ROOM];
static uint16_t in[DG_RING_WORDS_MAX];
static struct dg_bus_frames_room frames[8];

static const struct dg_bus_words_setup ring = {sizeof ring, in, DG_COUNT(in), true};
static const struct dg_bus_frames_setup can = {
    .size = sizeof can, .room = frames, .rooms = DG_COUNT(frames)};

/* `stirs`: it has a deadline whatever happens. */
static const struct row {
    const char *model;
    const struct dg_bus_medium *medium;
    const void *wire;
    enum dg_tap_kind kind;
    bool stirs;
} rows[] = {
    {"s3684-rs485", &dg_bus_characters, NULL, DG_TAP_CHARACTER, false},
    {"f3668", &dg_bus_frames, &can, DG_TAP_FRAME, true},
    {"s3684-biss", &dg_bus_edges, NULL, DG_TAP_LEVELS, false},
    {"ocd-ib-k3", &dg_bus_words, &ring, DG_TAP_WORDS, false},
};

static void ignore_event(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    (void)event;
}

/* A bus of one encoder that has been on for a second. */
static struct dg_bus *start_bus(const struct row *row)
{
    static const struct dg_bus_ops ops = {.tx = ignore_event};
    const struct dg_bus_setup setup = {sizeof setup, row->medium, 1, row->wire, &ops, NULL};
    struct dg_bus *bus = dg_bus_init(of_bus, sizeof of_bus, &setup);
    const struct dg_device *model = dg_device_find(row->model);
    struct dg_host *encoder =
        dg_host_init_on_bus(of_encoder, sizeof of_encoder, model, dg_bus_side_of(model));

    assert_non_null(bus);
    assert_int_equal(dg_host_power(encoder, 0, true), DG_HOST_OK);
    assert_int_equal(dg_bus_attach(bus, encoder, NULL), 0);
    (void)dg_bus_changed(bus, 0, 0);
    (void)dg_bus_step(bus, NOW);
    return bus;
}

static void a_step_to_it_is_none(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_bus *bus = start_bus(&rows[i]);
        const dg_ns next = dg_bus_next(bus);

        assert_true(next > NOW && (next != DG_NEVER) == rows[i].stirs);
        assert_int_equal(dg_bus_step(bus, DG_NEVER), next);
        dg_bus_look(bus, DG_NEVER);
        assert_int_equal(dg_bus_changed(bus, 0, DG_NEVER), next);
        assert_int_equal(dg_bus_durable(bus, 0, DG_NEVER), next);
        assert_true(dg_host_line_of(dg_bus_encoder(bus, 0))->now <= NOW);
    }
}

/* What comes then comes at the latest moment. */
static void what_comes_then_comes_now(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_bus *bus = start_bus(&rows[i]);
        const struct dg_tap_event event = {.at = DG_NEVER, .kind = rows[i].kind};

        (void)dg_bus_rx(bus, &event);
        assert_true(dg_host_line_of(dg_bus_encoder(bus, 0))->now <= NOW);
        (void)dg_bus_step(bus, 2 * NOW);
        assert_true(dg_host_line_of(dg_bus_encoder(bus, 0))->now <= 2 * NOW);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_to_it_is_none),
        cmocka_unit_test(what_comes_then_comes_now),
    };
    return cmocka_run_group_tests_name("never on a bus", tests, NULL, NULL);
}

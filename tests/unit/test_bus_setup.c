/* SPDX-License-Identifier: MIT */
/*
 * What a bus is not made of, and what it does not take: setups of another version, too little
 * memory, encoders and events of other media. Nothing is written then.
 */
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bus_characters.h"
#include "drehgeber/bus_edges.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/hal.h"
#include "drehgeber/host.h"
#include "drehgeber/host_wire.h"

#define ROOM 65536u

static alignas(DG_HOST_ALIGN) uint8_t of_encoder[ROOM];
static alignas(DG_HOST_ALIGN) uint8_t of_bus[ROOM + 1u];
static unsigned said;

static void count_event(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    (void)event;
    said++;
}

static const struct dg_bus_ops ops = {.tx = count_event};
static const struct dg_bus_ops no_tx;

static struct dg_bus *make(const struct dg_bus_setup *setup, size_t size, size_t offset)
{
    return dg_bus_init(&of_bus[offset], size, setup);
}

static void refused_setups(void **state)
{
    struct dg_bus_setup good = {sizeof good, &dg_bus_characters, 1, NULL, &ops, NULL};
    const size_t needed = dg_bus_size(good.medium, good.encoders);
    struct dg_bus_setup bad = good;

    (void)state;
    assert_non_null(make(&good, needed, 0));
    memset(of_bus, 0xA5, sizeof of_bus);
    assert_null(dg_bus_init(NULL, needed, &good));
    assert_null(make(&good, needed - 1u, 0));
    assert_null(make(&good, needed, 1));
    bad.size--;
    assert_null(make(&bad, needed, 0));
    bad = good;
    bad.ops = NULL;
    assert_null(make(&bad, needed, 0));
    bad.ops = &no_tx;
    assert_null(make(&bad, needed, 0));
    bad = good;
    bad.encoders = SIZE_MAX;
    assert_null(make(&bad, needed, 0));
    for (size_t i = 0; i < sizeof of_bus; i++) {
        assert_int_equal(of_bus[i], 0xA5);
    }
}

static void refused_frames(void **state)
{
    static struct dg_bus_frames_room rooms[2];
    struct dg_bus_frames_setup wire = {.size = sizeof wire};
    const struct dg_bus_setup setup = {sizeof setup, &dg_bus_frames, 1, &wire, &ops, NULL};
    const struct dg_bus_setup usual = {sizeof setup, &dg_bus_frames, 1, NULL, &ops, NULL};

    (void)state;
    assert_non_null(make(&setup, ROOM, 0));
    assert_non_null(make(&usual, ROOM, 0));
    wire.rooms = 2;
    assert_null(make(&setup, ROOM, 0));
    wire.room = rooms;
    assert_non_null(make(&setup, ROOM, 0));
    wire.rooms = UINT16_MAX;
    assert_null(make(&setup, ROOM, 0));
    wire.rooms = 2;
    wire.size++;
    assert_null(make(&setup, ROOM, 0));
}

static const struct row {
    const char *model;
    const struct dg_bus_medium *medium;
    enum dg_tap_kind kind; /* that it takes */
} rows[] = {
    {"s3684-rs485", &dg_bus_characters, DG_TAP_CHARACTER},
    {"f3668", &dg_bus_frames, DG_TAP_FRAME},
    {"s3684-biss", &dg_bus_edges, DG_TAP_LEVELS},
};

static struct dg_host *make_encoder(const char *model)
{
    struct dg_host *encoder = dg_host_make(of_encoder, sizeof of_encoder, model);

    assert_non_null(encoder);
    return encoder;
}

/* An encoder goes on no bus of another medium. */
static void encoders_of_other_media(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_bus_setup setup = {sizeof setup, rows[i].medium, 2, NULL, &ops, NULL};
        for (size_t j = 0; j < DG_COUNT(rows); j++) {
            struct dg_bus *bus = make(&setup, ROOM, 0);
            assert_non_null(bus);
            assert_int_equal(dg_bus_attach(bus, make_encoder(rows[j].model), NULL),
                             i == j ? 0 : DG_ERR_ARGUMENT);
            assert_int_equal(dg_bus_count(bus), i == j ? 1 : 0);
        }
    }
}

/* Events of other media, and frames that are too long, go by; time passes all the same. */
static void events_of_other_media(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_bus_setup setup = {sizeof setup, rows[i].medium, 1, NULL, &ops, NULL};
        struct dg_bus *bus = make(&setup, ROOM, 0);
        said = 0;
        assert_non_null(bus);
        assert_int_equal(dg_bus_attach(bus, make_encoder(rows[i].model), NULL), 0);
        for (size_t j = 0; j < DG_COUNT(rows); j++) {
            struct dg_tap_event event = {.at = DG_S(1) + j, .kind = rows[j].kind};
            if (j != i) {
                (void)dg_bus_rx(bus, &event);
            }
        }
        struct dg_tap_event late = {.at = DG_S(2), .kind = DG_TAP_FRAME};
        late.frame.dlc = 9;
        (void)dg_bus_rx(bus, &late);
        dg_bus_watch(bus, true); /* there is no tap */
        assert_true(dg_bus_step(bus, DG_S(3)) > DG_S(3));
        assert_int_equal(said, 0);
    }
}

/* The position of S36 number 64 is asked for; node 63 gets "start", then SYNC; two clocks. */
static void exchange(struct dg_bus *bus, enum dg_tap_kind kind, dg_ns now)
{
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    static const struct dg_can_frame frames[] = {{.id = 0, .dlc = 2, .data = {1, 0}}, {.id = 0x80}};
    struct dg_tap_event event = {.at = now, .kind = kind};

    for (size_t i = 0; kind == DG_TAP_CHARACTER && i < sizeof request; i++) {
        event.at += DG_US(1200);
        event.character.baud = 9600;
        event.character.parity = 'E';
        event.character.byte = request[i];
        (void)dg_bus_rx(bus, &event);
    }
    for (size_t i = 0; kind == DG_TAP_FRAME && i < DG_COUNT(frames); i++) {
        event.frame = frames[i];
        (void)dg_bus_rx(bus, &event);
    }
    for (unsigned i = 0; kind == DG_TAP_LEVELS && i < 4u; i++) {
        event.at += 500u;
        (void)dg_bus_edge(bus, event.at, i % 2u != 0);
    }
    (void)dg_bus_step(bus, now + DG_MS(500));
}

/* On a bus faults are the bus's: the panel bends nothing a second time. */
static void a_panel_on_a_bus(void **state)
{
    static alignas(DG_HOST_ALIGN) uint8_t of_panel[ROOM];

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_bus_setup setup = {sizeof setup, rows[i].medium, 1, NULL, &ops, NULL};
        struct dg_bus *bus = make(&setup, ROOM, 0);
        struct dg_host *encoder = make_encoder(rows[i].model);
        assert_int_equal(dg_host_power(encoder, 0, true), DG_HOST_OK);
        struct dg_host_panel *panel = dg_host_panel_make(of_panel, sizeof of_panel, encoder);
        assert_non_null(panel);
        assert_int_equal(dg_bus_attach(bus, encoder, dg_host_panel_encoder(panel)), 0);
        (void)dg_bus_changed(bus, 0, 0);
        (void)dg_bus_step(bus, DG_S(1));
        said = 0;
        exchange(bus, rows[i].kind, DG_S(1));
        assert_int_equal(said != 0, true);
        dg_bus_look(bus, DG_S(2));
        assert_int_equal(dg_host_fault_set(panel, DG_S(2), "wire_damage", true), DG_HOST_OK);
        (void)dg_bus_changed(bus, 0, DG_S(2));
        said = 0;
        exchange(bus, rows[i].kind, DG_S(3));
        assert_int_equal(said != 0, true);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(refused_setups),          cmocka_unit_test(refused_frames),
        cmocka_unit_test(encoders_of_other_media), cmocka_unit_test(events_of_other_media),
        cmocka_unit_test(a_panel_on_a_bus),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

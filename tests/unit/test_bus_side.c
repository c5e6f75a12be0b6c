/* SPDX-License-Identifier: MIT */
/*
 * A handle that names its wire alone: it goes on no bus before it has its protocol's side, and
 * until then faults of the wire happen to whatever comes.
 */
#include <setjmp.h>
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
#include "host_rig.h"

static struct host_rig_place of_bus;
static uint16_t in[DG_RING_WORDS_MAX];
static struct dg_bus_frames_room frames[8];
static const struct dg_bus_words_setup ring = {sizeof ring, in, DG_COUNT(in), true};
static const struct dg_bus_frames_setup can = {
    .size = sizeof can, .room = frames, .rooms = DG_COUNT(frames)};

static struct dg_host *make_alone(const char *name)
{
    struct dg_host *self = dg_host_init(&host_rig_here, sizeof host_rig_here, dg_device_find(name),
                                        host_rig_model(name)->wire);

    assert_non_null(self);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    host_rig_drain(self);
    return self;
}

static void drop(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    (void)event;
}

static void it_goes_on_a_bus_with_a_side_only(void **state)
{
    static const struct dg_bus_ops ops = {.tx = drop};
    static const struct {
        const char *model;
        const struct dg_bus_medium *medium;
        const void *wire;
    } rows[] = {
        {"s3684-rs485", &dg_bus_characters, NULL}, {"f3668", &dg_bus_frames, &can},
        {"s3684-biss", &dg_bus_edges, NULL},       {"ssi-25", &dg_bus_edges, NULL},
        {"ocd-ib-k3", &dg_bus_words, &ring},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_bus_setup setup = {sizeof setup, rows[i].medium, 1,
                                           rows[i].wire, &ops,           NULL};
        struct dg_bus *bus = dg_bus_init(&of_bus, sizeof of_bus, &setup);
        struct dg_host *encoder = make_alone(rows[i].model);
        const struct dg_bus_side *side = dg_bus_side_of(dg_device_find(rows[i].model));
        assert_non_null(bus);
        assert_null(dg_host_side_at(encoder));
        assert_int_equal(dg_bus_attach(bus, encoder, NULL), DG_ERR_ARGUMENT);
        assert_int_equal(dg_bus_count(bus), 0);
        assert_ptr_equal(side->wire, dg_host_wire_at(encoder));
        dg_host_take_side(encoder, side);
        assert_int_equal(dg_bus_attach(bus, encoder, NULL), 0);
    }
}

/* Of the fault that may happen once, what is left behind an event that is not for the encoder. */
static uint64_t count_left(struct dg_host *self, const char *fault,
                           const struct dg_host_event *event)
{
    static struct host_rig_place of_panel;
    struct dg_host_panel *panel = dg_host_panel_make(&of_panel, sizeof of_panel, self);
    struct dg_host_fault is;
    char answer[8];
    char line[48] = "FAUL:SET ";

    assert_non_null(panel);
    for (size_t i = 0; fault[i] != '\0'; i++) {
        line[9 + i] = fault[i];
        line[10 + i] = '\0';
    }
    assert_int_equal(dg_host_scpi(panel, READY, line, answer, sizeof answer), 0);
    assert_int_equal(dg_host_send(self, event), DG_HOST_OK);
    (void)dg_host_step(self, event->at + 100 * MS);
    for (size_t i = 0; dg_host_fault(panel, i, &is) == DG_HOST_OK; i++) {
        if (is.active) {
            return 1;
        }
    }
    return 0;
}

static void faults_go_by_what_it_listens_to_with_a_side_only(void **state)
{
    static const struct {
        const char *model;
        struct dg_host_event event;
    } rows[] = {
        {"s3684-rs485",
         {.at = READY, .kind = DG_HOST_BYTES, .length = 3, .data = {0x41, 0x42, 0x03}}},
        {"f3668", {.at = READY, .kind = DG_HOST_CAN, .id = 0x123, .length = 1}},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_host *self = make_alone(rows[i].model);
        assert_int_equal(count_left(self, "wire_deaf,COUN,1", &rows[i].event), 0);
        self = make_alone(rows[i].model);
        dg_host_take_side(self, dg_bus_side_of(dg_device_find(rows[i].model)));
        assert_int_equal(count_left(self, "wire_deaf,COUN,1", &rows[i].event), 1);
    }
}

/* Nobody counts an error that a ring would have found; the cycle is lost all the same. */
static void a_cycle_is_damaged_without_a_side(void **state)
{
    struct dg_host *self = make_alone("ocd-ib-k3");
    const struct dg_host_event cycle = {.at = READY, .kind = DG_HOST_WORDS};
    struct dg_host_event back;

    (void)state;
    assert_int_equal(count_left(self, "wire_damage,COUN,1", &cycle), 0);
    assert_int_equal(dg_host_receive(self, &back), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_goes_on_a_bus_with_a_side_only),
        cmocka_unit_test(faults_go_by_what_it_listens_to_with_a_side_only),
        cmocka_unit_test(a_cycle_is_damaged_without_a_side),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * A handle's panel: faults by name, of the world, the EEPROM and the wire, and lines of SCPI.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/quantity.h"
#include "host_rig.h"

/* ------------------------------------------------------------ faults and SCPI */

static struct host_rig_place panel_place;

static struct dg_host_panel *panel(struct dg_host *self)
{
    assert_true(dg_host_panel_size() <= sizeof panel_place);
    memset(&panel_place, 0xA5, sizeof panel_place);
    return dg_host_panel_make(&panel_place, sizeof panel_place, self);
}

static void a_panel_needs_an_encoder_that_was_on(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "f3668");

    (void)state;
    assert_null(panel(self));
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_null(dg_host_panel_make(&panel_place, dg_host_panel_size() - 1u, self));
    assert_null(dg_host_panel_make(panel_place.bytes + 8, dg_host_panel_size(), self));
    assert_null(dg_host_panel_make(NULL, dg_host_panel_size(), self));
    assert_null(dg_host_panel_init(&panel_place, sizeof panel_place, self, NULL));
    assert_null(dg_host_panel_init(&panel_place, sizeof panel_place, self, &dg_biss_instrument));
    assert_non_null(panel(self));
}

/* Every fault of every model comes and goes. */
static void faults_come_and_go_by_name(void **state)
{
    (void)state;
    for (size_t i = 0; i < host_rig_model_count; i++) {
        struct dg_host *self = host_rig_start(&host_rig_here, host_rig_models[i].name);
        struct dg_host_panel *board = panel(self);
        struct dg_host_fault fault;
        unsigned set = 0;
        for (size_t n = 0; dg_host_fault(board, n, &fault) == DG_HOST_OK; n++) {
            assert_true(fault.active == 0 && fault.cause[0] != '\0' && fault.effect[0] != '\0');
            assert_int_equal(dg_host_fault_set(board, READY, fault.name, true), DG_HOST_OK);
            assert_int_equal(dg_host_fault(board, n, &fault), DG_HOST_OK);
            assert_int_equal(fault.active, 1);
            set++;
            assert_int_equal(dg_host_fault_set(board, READY + MS, fault.name, false), DG_HOST_OK);
            assert_int_equal(dg_host_fault(board, n, &fault), DG_HOST_OK);
            assert_int_equal(fault.active, 0);
        }
        assert_true(set >= 2);
        assert_int_equal(dg_host_fault_set(board, READY, "no_such_fault", true), DG_HOST_ERR_NAME);
    }
}

/* 42h while something is wrong with the wire. */
static int ask_hiperface(struct dg_host *self, uint64_t at, struct dg_host_event *event)
{
    const struct dg_host_event request = {
        .at = at, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x42, 0x02}};
    int n = 0;

    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, at + 900 * MS);
    while (dg_host_receive(self, event) == 1) {
        n++;
    }
    return n;
}

static void faults_of_the_wire_happen_in_the_queues(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_panel *board = panel(self);
    static const struct {
        const char *name;
        int replies;
        uint64_t late; /* of the last one */
        bool damaged;
    } faults[] = {
        {"wire_drop", 0, 0, false},
        {"wire_deaf", 0, 0, false},
        {"wire_delay", 1, 300 * MS, false},
        {"wire_damage", 1, 0, true},
        {"wire_duplicate", 2, UINT64_C(8020834), false}, /* 7 characters of 11 bits behind */
    };
    struct dg_host_event healthy;
    struct dg_host_event event;
    uint64_t now = 2 * SECOND;

    (void)state;
    assert_int_equal(ask_hiperface(self, now, &healthy), 1);
    healthy.at -= now;
    for (size_t i = 0; i < DG_COUNT(faults); i++) {
        now += SECOND;
        assert_int_equal(dg_host_fault_set(board, now, faults[i].name, true), DG_HOST_OK);
        assert_int_equal(ask_hiperface(self, now, &event), faults[i].replies);
        if (faults[i].replies > 0) {
            assert_int_equal(event.at - now - healthy.at, faults[i].late);
            assert_int_equal(memcmp(event.data, healthy.data, sizeof event.data) != 0,
                             faults[i].damaged);
        }
        assert_int_equal(dg_host_fault_set(board, now, faults[i].name, false), DG_HOST_OK);
    }
    assert_int_equal(ask_hiperface(self, now + SECOND, &event), 1);
}

/* 56h is answered by three events, and is one reply to all faults: none of it, all of it twice, all
 * of it late, one bit of it. */
static void a_long_reply_has_a_fault_as_a_whole(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_panel *board = panel(self);
    static const struct {
        const char *name;
        unsigned events;
        unsigned damaged;
    } faults[] = {{"wire_drop", 0, 0}, {"wire_duplicate", 6, 0}, {"wire_damage", 3, 1}};
    struct dg_host_event request = {
        .at = READY, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x56, 0x16}};
    struct dg_host_event healthy[3];
    struct dg_host_event event;

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, READY + 100 * MS);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(dg_host_receive(self, &healthy[i]), 1);
    }
    for (size_t i = 0; i < DG_COUNT(faults); i++) {
        unsigned events = 0;
        unsigned damaged = 0;
        request.at += SECOND;
        assert_int_equal(dg_host_fault_set(board, request.at, faults[i].name, true), DG_HOST_OK);
        assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
        (void)dg_host_step(self, request.at + 100 * MS);
        while (dg_host_receive(self, &event) == 1) {
            const struct dg_host_event *like = &healthy[events++ % 3u];
            damaged += memcmp(event.data, like->data, sizeof event.data) != 0 ? 1u : 0u;
        }
        assert_int_equal(events, faults[i].events);
        assert_int_equal(damaged, faults[i].damaged);
        assert_int_equal(dg_host_fault_set(board, request.at, faults[i].name, false), DG_HOST_OK);
    }
}

/* How often 1001h is answered. */
static int ask_canopen(struct dg_host *self, uint64_t at)
{
    const struct dg_host_event read = {
        .at = at, .kind = DG_HOST_CAN, .id = 0x63F, .length = 8, .data = {0x40, 0x01, 0x10}};
    struct dg_host_event event;
    int n = 0;

    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &read), DG_HOST_OK);
    (void)dg_host_step(self, at + MS);
    while (dg_host_receive(self, &event) == 1) {
        n += event.id == 0x5BF ? 1 : 0;
    }
    return n;
}

static void a_controller_that_is_off_is_silent(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host_panel *board = panel(self);

    (void)state;
    assert_int_equal(dg_host_fault_set(board, READY, "bus_off", true), DG_HOST_OK);
    assert_int_equal(ask_canopen(self, READY), 0);
    assert_int_equal(dg_host_fault_set(board, READY + 2 * MS, "bus_off", false), DG_HOST_OK);
    assert_int_equal(ask_canopen(self, READY + 3 * MS), 1);
}

/* What the handle has said up to `at`: answers to SDO requests and codes of EMCYs, in order. */
static void expect_said(struct dg_host_panel *board, struct dg_host *self, uint64_t at,
                        const char *wanted)
{
    struct dg_host_event event;
    char said[128] = "";
    size_t n = 0;

    (void)dg_host_panel_step(board, at);
    while (dg_host_receive(self, &event) == 1) {
        const unsigned code = (unsigned)event.data[1] << 8 | event.data[0];
        assert_true(n < sizeof said - 16u);
        if (event.id == 0x0BF) {
            n += (size_t)snprintf(said + n, sizeof said - n, "%04X ", code);
        } else {
            n += (size_t)snprintf(said + n, sizeof said - n, "%s ",
                                  event.id == 0x5BF ? "answer" : "boot");
        }
    }
    assert_string_equal(said, wanted);
}

static void request_canopen(struct dg_host *self, uint64_t at)
{
    const struct dg_host_event read = {
        .at = at, .kind = DG_HOST_CAN, .id = 0x63F, .length = 8, .data = {0x40, 0x01, 0x10}};

    assert_int_equal(dg_host_send(self, &read), DG_HOST_OK);
}

static void command(struct dg_host_panel *board, uint64_t at, const char *line)
{
    char answer[64];

    assert_int_equal(dg_host_scpi(board, at, line, answer, sizeof answer), 0);
    assert_true(dg_host_scpi(board, at, "SYST:ERR?", answer, sizeof answer) > 0);
    assert_memory_equal(answer, "0,", 2);
}

/* A fault of the controller: by name, which has no duration, or by SCPI. */
static void begin(struct dg_host_panel *board, uint64_t at, const char *name, bool scpi)
{
    char line[64];

    if (!scpi) {
        assert_int_equal(dg_host_fault_set(board, at, name, true), DG_HOST_OK);
        return;
    }
    (void)snprintf(line, sizeof line, "FAUL:SET %s", name);
    command(board, at, line);
}

static void end(struct dg_host_panel *board, uint64_t at, const char *name, bool scpi)
{
    if (scpi) {
        command(board, at, "FAUL:CLE");
    } else {
        assert_int_equal(dg_host_fault_set(board, at, name, false), DG_HOST_OK);
    }
}

/* C44. A row: what is said to a request while it lasts, to another one behind its end. */
static const struct {
    const char *name;
    const char *during;
    const char *behind;
} controller_rows[] = {
    {"bus_off", "", "8140 0000 answer "},
    {"error_passive", "8120 answer ", "0000 answer "},
    {"overrun", "8110 0000 ", "answer "},
};

static void faults_of_the_controller_act_and_end_by_all_ways(void **state)
{
    (void)state;
    for (unsigned ways = 0; ways < 4; ways++) {
        struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
        struct dg_host_panel *board = panel(self);
        uint64_t at = READY;
        host_rig_drain(self);
        for (size_t i = 0; i < DG_COUNT(controller_rows); i++) {
            begin(board, at, controller_rows[i].name, (ways & 1u) != 0);
            request_canopen(self, at + MS);
            expect_said(board, self, at + 2 * MS, controller_rows[i].during);
            end(board, at + 3 * MS, controller_rows[i].name, (ways & 2u) != 0);
            request_canopen(self, at + 4 * MS);
            expect_said(board, self, at + 5 * MS, controller_rows[i].behind);
            at += SECOND;
        }
    }
}

static void timed_faults_of_the_controller_end_by_themselves(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host_panel *board = panel(self);
    uint64_t at = READY;
    char line[64];

    (void)state;
    host_rig_drain(self);
    for (size_t i = 0; i < DG_COUNT(controller_rows); i++) {
        assert_int_equal(dg_host_fault_set(board, at, controller_rows[i].name, true), DG_HOST_OK);
        (void)snprintf(line, sizeof line, "FAUL:SET %s,DUR 100 MS", controller_rows[i].name);
        command(board, at, line);
        request_canopen(self, at + 99 * MS);
        expect_said(board, self, at + 99 * MS, controller_rows[i].during);
        request_canopen(self, at + 101 * MS);
        expect_said(board, self, at + SECOND, controller_rows[i].behind);
        at += 2 * SECOND;
    }
}

/* A power cycle is no cure, and a controller that is off by itself is not cured by the end of a
 * fault. */
static void a_controller_is_never_better_than_its_fault(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host_panel *board = panel(self);
    struct dg_host_event own = {.at = READY + 10 * MS, .kind = DG_HOST_BUS, .id = DG_HOST_BUS_OFF};

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_bus_state(self), DG_HOST_BUS_ACTIVE);
    command(board, READY, "FAUL:SET bus_off");
    assert_int_equal(dg_host_bus_state(self), DG_HOST_BUS_OFF);
    command(board, READY + MS, "POW CYCL");
    request_canopen(self, READY + 2 * MS);
    expect_said(board, self, READY + 3 * MS, "");
    dg_host_power(self, READY + 4 * MS, false);
    dg_host_power(self, READY + 5 * MS, true);
    request_canopen(self, READY + 6 * MS);
    expect_said(board, self, READY + 7 * MS, "");
    command(board, READY + 8 * MS, "FAUL:CLE");
    expect_said(board, self, READY + 9 * MS, "8140 0000 ");
    assert_int_equal(dg_host_send(self, &own), DG_HOST_OK);
    expect_said(board, self, READY + 11 * MS, "");
    command(board, READY + 12 * MS, "FAUL:SET error_passive;:FAUL:CLE;:FAUL:SET bus_off");
    command(board, READY + 13 * MS, "FAUL:CLE");
    request_canopen(self, READY + 14 * MS);
    expect_said(board, self, READY + 15 * MS, "");
    own = (struct dg_host_event){.at = READY + 16 * MS, .kind = DG_HOST_BUS};
    assert_int_equal(dg_host_send(self, &own), DG_HOST_OK);
    request_canopen(self, READY + 17 * MS);
    expect_said(board, self, READY + 18 * MS, "8140 0000 answer ");
}

/* NMT has the identifier 0, which is also the number of error active: it cures nobody. */
static void a_frame_does_not_say_what_a_controller_is(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host_panel *board = panel(self);
    const struct dg_host_event own = {
        .at = READY + MS, .kind = DG_HOST_BUS, .id = DG_HOST_BUS_PASSIVE};
    const struct dg_host_event go = {
        .at = READY + 2 * MS, .kind = DG_HOST_CAN, .length = 2, .data = {1, 0}};

    (void)state;
    assert_int_equal(dg_host_send(self, &own), DG_HOST_OK);
    assert_int_equal(dg_host_send(self, &go), DG_HOST_OK);
    (void)dg_host_panel_step(board, READY + 3 * MS);
    assert_int_equal(dg_host_bus_state(self), DG_HOST_BUS_PASSIVE);
    command(board, READY + 4 * MS, "FAUL:SET bus_off");
    assert_int_equal(dg_host_bus_state(self), DG_HOST_BUS_OFF);
    command(board, READY + 5 * MS, "FAUL:CLE");
    assert_int_equal(dg_host_bus_state(self), DG_HOST_BUS_PASSIVE);
}

/* It is off by itself and by a fault, and first the one and then the other is over. */
static void a_controller_is_good_when_both_causes_are_over(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host_panel *board = panel(self);
    struct dg_host_event own = {.at = READY + MS, .kind = DG_HOST_BUS, .id = DG_HOST_BUS_OFF};

    (void)state;
    host_rig_drain(self);
    command(board, READY, "FAUL:SET bus_off");
    assert_int_equal(dg_host_send(self, &own), DG_HOST_OK);
    expect_said(board, self, READY + 2 * MS, "");
    command(board, READY + 3 * MS, "WORL:TEMP 20");
    own = (struct dg_host_event){.at = READY + 4 * MS, .kind = DG_HOST_BUS};
    assert_int_equal(dg_host_send(self, &own), DG_HOST_OK);
    expect_said(board, self, READY + 5 * MS, "");
    command(board, READY + 6 * MS, "FAUL:CLE");
    request_canopen(self, READY + 7 * MS);
    expect_said(board, self, READY + 8 * MS, "8140 0000 answer ");
}

static void a_line_of_scpi_is_answered(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    struct dg_host_frame frame;
    char answer[64];
    int64_t value = 0;

    (void)state;
    assert_int_equal(dg_host_scpi(board, READY, "SHAF:POS?", answer, sizeof answer), 11);
    assert_string_equal(answer, "1170.000000");
    assert_int_equal(dg_host_scpi(board, READY, "WORL:TEMP 50;:SHAF:POS 90", answer, sizeof answer),
                     0);
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 50000);
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_OK);
    assert_int_equal(frame.position, 1u << 19);
    assert_int_equal(dg_host_scpi(board, frame.end, "*IDN?", answer, 8), DG_HOST_ERR_SPACE);
    assert_string_equal(answer, "drehgeb");
    assert_int_equal(dg_host_scpi(board, frame.end, "NONS", answer, sizeof answer), 0);
    assert_true(dg_host_scpi(board, frame.end, "SYST:ERR?", answer, sizeof answer) > 0);
    assert_memory_equal(answer, "-113", 4);
    assert_int_equal(dg_host_scpi(board, frame.end, "POW OFF", answer, sizeof answer), 0);
    assert_false(dg_host_powered(self));
    assert_int_equal(dg_host_scpi(board, frame.end, "", answer, sizeof answer), 0);
}

static void expect_error(struct dg_host_panel *board, const char *number)
{
    char answer[128];

    assert_true(dg_host_scpi(board, READY, "SYST:ERR?", answer, sizeof answer) > 0);
    assert_memory_equal(answer, number, strlen(number));
}

/* 512 characters are a line; of a longer one nothing is done. */
static void a_line_that_is_too_long_is_not_begun(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    static char line[700];
    char answer[64];
    int64_t value = 0;

    (void)state;
    memset(line, ' ', sizeof line - 1u);
    memcpy(line, "WORL:TEMP 50", 12);
    line[513] = '\0';
    assert_int_equal(dg_host_scpi(board, READY, line, answer, sizeof answer), 0);
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 37000);
    expect_error(board, "-363");
    line[513] = ' ';
    assert_int_equal(dg_host_scpi(board, READY, line, answer, sizeof answer), 0);
    expect_error(board, "-363");
    line[512] = '\0';
    assert_int_equal(dg_host_scpi(board, READY, line, answer, sizeof answer), 0);
    expect_error(board, "0,");
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 50000);
}

/* While a command waits no other line is begun; it answers in a later call. */
static void a_command_that_waits_keeps_others_out(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    char answer[64];

    (void)state;
    assert_int_equal(dg_host_scpi(board, READY, "SHAF:POS 0;MOVE 360;*OPC?", answer, sizeof answer),
                     0);
    assert_int_equal(dg_host_scpi(board, READY, "SHAF:POS 90", answer, sizeof answer),
                     DG_HOST_ERR_SPACE);
    assert_string_equal(answer, "");
    assert_int_equal(dg_host_scpi(board, READY + 2 * SECOND, "", answer, sizeof answer), 1);
    assert_string_equal(answer, "1");
    assert_int_equal(dg_host_angle(self, READY + 2 * SECOND), TURN);
    /* Two lines are not one: the second one has not begun, and its end was not taken. */
    assert_int_equal(
        dg_host_scpi(board, READY + 2 * SECOND, "SHAF:MOVE 720;*WAI\n", answer, sizeof answer),
        DG_HOST_ERR_SPACE);
}

/* Half of the requests come while it lasts, and the steps are as long as they like to be. */
static void a_fault_ends_in_the_middle_of_a_step(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    struct dg_host_panel *board = panel(self);
    struct dg_host_event event = {
        .kind = DG_HOST_CAN, .id = 0x63F, .length = 8, .data = {0x40, 0x01, 0x10}};
    char answer[64];
    unsigned n = 0;

    (void)state;
    host_rig_drain(self);
    assert_int_equal(
        dg_host_scpi(board, READY, "FAUL:SET wire_drop,DUR 100 MS", answer, sizeof answer), 0);
    for (unsigned i = 0; i < 20; i++) {
        event.at = READY + 5 * MS + i * 10 * MS;
        assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    }
    (void)dg_host_panel_step(board, READY + SECOND);
    while (dg_host_receive(self, &event) == 1) {
        assert_int_equal(event.at, READY + 105 * MS + n * 10 * MS);
        n++;
    }
    assert_int_equal(n, 10);
    expect_error(board, "0,");
}

/* Data of an encoder without power is low: nobody has to step for that. */
static void what_a_command_does_is_told_at_once(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-25");
    struct dg_host_panel *board = panel(self);
    struct dg_host_event event;
    char answer[64];

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_scpi(board, READY + MS, "POW OFF", answer, sizeof answer), 0);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.kind, DG_HOST_EDGE);
    assert_int_equal(event.data[0], 0);
    assert_int_equal(event.at, READY + MS);
}

static void a_line_ends_with_its_zero(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    char answer[64];

    (void)state;
    assert_int_equal(dg_host_scpi(board, READY, "\0NONSENSE", answer, sizeof answer), 0);
    expect_error(board, "0,");
    assert_int_equal(dg_host_scpi(board, READY, "?", answer, sizeof answer), 0);
    expect_error(board, "-1");
    assert_true(dg_host_scpi(board, READY, "SHAF:NAME?", answer, sizeof answer) > 0);
    assert_string_equal(answer, "\"shaft\"");
}

static void an_answer_needs_room_for_its_zero(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    char answer[8] = "before";

    (void)state;
    assert_int_equal(dg_host_scpi(board, READY, "WORL:TEMP 50", answer, 0), DG_HOST_ERR_SPACE);
    assert_string_equal(answer, "before");
    assert_int_equal(dg_host_scpi(board, READY, "INST:WIRE?", answer, 1), DG_HOST_ERR_SPACE);
    assert_string_equal(answer, "");
    assert_int_equal(dg_host_scpi(board, READY, "INST:WIRE?", answer, 7), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_scpi(board, READY, "INST:WIRE?", answer, 8), 6);
    assert_string_equal(answer, "\"host\"");
}

static void a_fault_with_a_time_ends(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    char answer[64];
    int64_t value = 0;

    (void)state;
    assert_int_equal(
        dg_host_scpi(board, READY, "FAUL:SET temperature_high;:SYST:ERR?", answer, sizeof answer),
        12);
    assert_string_equal(answer, "0,\"No error\"");
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_true(value > 120000);
    assert_true(dg_host_panel_step(board, READY + MS) > READY + MS);
    assert_int_equal(dg_host_fault_set(board, READY, "temperature_high", false), DG_HOST_OK);
    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    assert_int_equal(value, 37000);
}

/* Also when it has the value that the fault gave it. */
static void a_quantity_that_the_host_sets_ends_its_fault(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    char answer[64];
    int64_t value = 0;

    (void)state;
    assert_int_equal(dg_host_fault_set(board, READY, "singleturn_lost", true), DG_HOST_OK);
    assert_int_equal(dg_host_world_set(self, READY, "singleturn_ok", 0), DG_HOST_OK);
    assert_int_equal(dg_host_scpi(board, READY, "FAUL:ACT?", answer, sizeof answer), 2);
    assert_string_equal(answer, "\"\"");
    assert_int_equal(dg_host_fault_set(board, READY, "singleturn_lost", false), DG_HOST_OK);
    assert_int_equal(dg_host_world_get(self, "singleturn_ok", &value), DG_HOST_OK);
    assert_int_equal(value, 0);
}

static int64_t temperature_of(const struct dg_host *self)
{
    int64_t value = 0;

    assert_int_equal(dg_host_world_get(self, "temperature", &value), DG_HOST_OK);
    return value;
}

/* A fault stays in front of it. */
static void a_course_goes_on_by_the_panel(void **state)
{
    static const struct dg_course_point points[] = {{0, 20000}, {10 * SECOND, 30000}};
    struct dg_rig_course course = {.course = {.points = points, .count = 2},
                                   .quantity = DG_QUANTITY_TEMPERATURE};
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host_panel *board = panel(self);
    struct dg_encoder *encoder = dg_host_panel_encoder(board);

    (void)state;
    assert_int_equal(dg_rig_follow(dg_host_panel_rig(board), encoder, &course, READY), DG_OK);
    assert_int_equal(temperature_of(self), 20000);
    (void)dg_host_panel_step(board, READY + 5 * SECOND);
    assert_int_equal(temperature_of(self), 25000);
    assert_int_equal(dg_host_fault_set(board, READY + 5 * SECOND, "temperature_high", true),
                     DG_HOST_OK);
    (void)dg_host_panel_step(board, READY + 6 * SECOND);
    assert_true(temperature_of(self) > 120000);
    assert_int_equal(dg_host_fault_set(board, READY + 6 * SECOND, "temperature_high", false),
                     DG_HOST_OK);
    assert_int_equal(temperature_of(self), 26000);
    dg_rig_unfollow(dg_host_panel_rig(board), encoder, DG_QUANTITY_TEMPERATURE);
    (void)dg_host_panel_step(board, READY + 9 * SECOND);
    assert_int_equal(temperature_of(self), 26000);
}

/* Turned by SCPI, it turns the others as well. */
static void others_sit_on_the_shaft_of_a_panel(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    struct dg_host *other = host_rig_start(&host_rig_there, "f3668");
    struct dg_host_panel *board = panel(self);
    char answer[64];

    (void)state;
    assert_non_null(dg_host_panel_shaft(board));
    dg_host_shaft_of(other, dg_host_panel_shaft(board));
    assert_int_equal(dg_host_angle(other, READY), 13 * TURN / 4);
    assert_int_equal(dg_host_scpi(board, READY, "SHAF:POS 90 DEG", answer, sizeof answer), 0);
    assert_int_equal(dg_host_angle(other, READY), TURN / 4);
    assert_int_equal(dg_host_angle(self, READY), TURN / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_panel_needs_an_encoder_that_was_on),
        cmocka_unit_test(faults_come_and_go_by_name),
        cmocka_unit_test(faults_of_the_wire_happen_in_the_queues),
        cmocka_unit_test(a_long_reply_has_a_fault_as_a_whole),
        cmocka_unit_test(a_controller_that_is_off_is_silent),
        cmocka_unit_test(faults_of_the_controller_act_and_end_by_all_ways),
        cmocka_unit_test(timed_faults_of_the_controller_end_by_themselves),
        cmocka_unit_test(a_controller_is_never_better_than_its_fault),
        cmocka_unit_test(a_frame_does_not_say_what_a_controller_is),
        cmocka_unit_test(a_controller_is_good_when_both_causes_are_over),
        cmocka_unit_test(a_line_of_scpi_is_answered),
        cmocka_unit_test(a_line_that_is_too_long_is_not_begun),
        cmocka_unit_test(a_command_that_waits_keeps_others_out),
        cmocka_unit_test(a_fault_ends_in_the_middle_of_a_step),
        cmocka_unit_test(what_a_command_does_is_told_at_once),
        cmocka_unit_test(a_line_ends_with_its_zero),
        cmocka_unit_test(an_answer_needs_room_for_its_zero),
        cmocka_unit_test(a_fault_with_a_time_ends),
        cmocka_unit_test(a_quantity_that_the_host_sets_ends_its_fault),
        cmocka_unit_test(a_course_goes_on_by_the_panel),
        cmocka_unit_test(others_sit_on_the_shaft_of_a_panel),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

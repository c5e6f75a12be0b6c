/* SPDX-License-Identifier: MIT */
/* Faults of the wire behind a handle's panel, while characters come one by one and power goes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "host_rig.h"

/* 11 bits at 9600 Bd, rounded up. */
#define CHARACTER UINT64_C(1145834)

static struct host_rig_place panel_place;
static struct dg_host *host;
static struct dg_host_panel *board;

static void start_encoder(const char *model)
{
    host = host_rig_start(&host_rig_here, model);
    board = dg_host_panel_make(&panel_place, sizeof panel_place, host);
    assert_non_null(board);
    host_rig_drain(host);
}

static void send_line(uint64_t at, const char *line)
{
    char answer[64];

    assert_int_equal(dg_host_scpi(board, at, line, answer, sizeof answer), 0);
    assert_true(dg_host_scpi(board, at, "SYST:ERR?", answer, sizeof answer) > 0);
    assert_string_equal(answer, "0,\"No error\"");
}

static unsigned count_events(void)
{
    struct dg_host_event event;
    unsigned n = 0;

    while (dg_host_receive(host, &event) == 1) {
        n++;
    }
    return n;
}

/* 42h of the encoder with address 40h, character by character, as a port reads it. */
static unsigned ask_in_pieces(uint64_t at, uint64_t character)
{
    static const uint8_t request[] = {0x40, 0x42, 0x02};

    for (size_t i = 0; i < sizeof request; i++) {
        const struct dg_host_event piece = {.at = at + i * CHARACTER,
                                            .id = (uint32_t)character,
                                            .kind = DG_HOST_BYTES,
                                            .length = 1,
                                            .data = {request[i]}};
        assert_int_equal(dg_host_send(host, &piece), DG_HOST_OK);
        (void)dg_host_step(host, piece.at);
    }
    (void)dg_host_step(host, at + 900 * MS);
    return count_events();
}

/* To a fault that happens once it is one request, whoever says how long a character takes. */
static void a_request_in_pieces_is_one_request(void **state)
{
    static const uint64_t characters[] = {0, CHARACTER};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        start_encoder("s3684-rs485");
        assert_int_equal(ask_in_pieces(2 * SECOND, characters[i]), 1);
        send_line(3 * SECOND, "FAUL:SET wire_deaf,COUN 1");
        assert_int_equal(ask_in_pieces(4 * SECOND, characters[i]), 0);
        assert_int_equal(ask_in_pieces(5 * SECOND, characters[i]), 1);
    }
}

/* A character that begins is not heard either; behind a power cycle everything is. */
static void a_power_cycle_ends_a_request_that_was_not_heard(void **state)
{
    struct dg_host_event begins = {
        .at = 3 * SECOND, .kind = DG_HOST_BYTES, .flags = DG_HOST_START, .length = 0};
    const struct dg_host_event first = {
        .at = 3 * SECOND, .kind = DG_HOST_BYTES, .length = 1, .data = {0x40}};
    (void)state;
    start_encoder("s3684-rs485");
    send_line(3 * SECOND, "FAUL:SET wire_deaf,COUN 1");
    assert_int_equal(dg_host_send(host, &first), DG_HOST_OK);
    (void)dg_host_step(host, first.at);
    for (unsigned i = 1; i <= 2; i++) {
        begins.at += CHARACTER;
        assert_int_equal(dg_host_send(host, &begins), DG_HOST_OK);
        (void)dg_host_step(host, begins.at);
        send_line(begins.at, "POW OFF");
    }
    send_line(begins.at, "POW ON");
    assert_int_equal(ask_in_pieces(5 * SECOND, 0), 1);
}

static unsigned run_cycle(uint64_t at)
{
    const struct dg_host_event cycle = {.at = at, .kind = DG_HOST_WORDS};

    host_rig_drain(host);
    assert_int_equal(dg_host_send(host, &cycle), DG_HOST_OK);
    (void)dg_host_step(host, at + MS);
    return count_events();
}

/* Nobody loses a cycle of an encoder without power: the fault waits until there is one to lose. */
static void a_fault_waits_for_a_cycle_that_there_is(void **state)
{
    (void)state;
    start_encoder("ocd-ib-k2");
    const unsigned healthy = run_cycle(2 * SECOND);
    assert_int_equal(healthy, 1);
    send_line(3 * SECOND, "POW OFF;:FAUL:SET wire_drop,COUN 1");
    const unsigned off = run_cycle(4 * SECOND);
    send_line(5 * SECOND, "POW ON");
    (void)dg_host_step(host, 7 * SECOND);
    assert_int_equal(run_cycle(7 * SECOND), 0);
    assert_int_equal(run_cycle(8 * SECOND), healthy);
    assert_int_equal(off, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_request_in_pieces_is_one_request),
        cmocka_unit_test(a_power_cycle_ends_a_request_that_was_not_heard),
        cmocka_unit_test(a_fault_waits_for_a_cycle_that_there_is),
    };
    return cmocka_run_group_tests_name("panel_wires", tests, NULL, NULL);
}

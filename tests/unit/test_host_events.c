/* SPDX-License-Identifier: MIT */
/*
 * Events: which a wire takes, and what becomes of characters, frames and words. Times of
 * characters are counted by hand: 11 bits at 9600 baud, or 10 without parity.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "host_rig.h"

/* ------------------------------------------------------------ refused */

static void what_cannot_be_an_event_is_refused(void **state)
{
    static const struct {
        const char *model;
        struct dg_host_event event;
        int result;
    } rows[] = {
        {"s3684-rs485", {.kind = DG_HOST_BYTES, .length = 16}, DG_HOST_OK},
        {"s3684-rs485", {.kind = DG_HOST_BYTES, .length = 17}, DG_HOST_ERR_ARGUMENT},
        {"s3684-rs485", {.kind = DG_HOST_BYTES, .length = 0}, DG_HOST_ERR_ARGUMENT},
        {"s3684-rs485", {.kind = DG_HOST_BYTES, .flags = DG_HOST_START}, DG_HOST_OK},
        {"f3668", {.kind = DG_HOST_CAN, .id = 0x7FF, .length = 8}, DG_HOST_OK},
        {"f3668", {.kind = DG_HOST_CAN, .id = 0x800, .length = 8}, DG_HOST_ERR_ARGUMENT},
        {"f3668", {.kind = DG_HOST_CAN, .id = 0x7FF, .length = 9}, DG_HOST_ERR_ARGUMENT},
        {"f3668", {.kind = DG_HOST_BUS, .id = DG_HOST_BUS_PRESENT}, DG_HOST_OK},
        {"f3668", {.kind = DG_HOST_BUS, .id = DG_HOST_BUS_PRESENT + 1}, DG_HOST_ERR_ARGUMENT},
        {"ssi-25", {.kind = DG_HOST_EDGE, .length = 1, .data = {1}}, DG_HOST_OK},
        {"ssi-25", {.kind = DG_HOST_EDGE, .length = 0}, DG_HOST_ERR_ARGUMENT},
        {"ssi-25", {.kind = DG_HOST_EDGE, .length = 2}, DG_HOST_ERR_ARGUMENT},
        {"ssi-25", {.kind = DG_HOST_EDGE, .length = 1, .data = {2}}, DG_HOST_ERR_ARGUMENT},
        {"ocd-ib-k2", {.kind = DG_HOST_WORDS, .length = 16}, DG_HOST_OK},
        {"ocd-ib-k2", {.kind = DG_HOST_WORDS, .length = 17}, DG_HOST_ERR_ARGUMENT},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, rows[i].model);
        const int never_on = rows[i].result == DG_HOST_OK ? DG_HOST_ERR_STATE : rows[i].result;
        assert_int_equal(dg_host_send(self, &rows[i].event), never_on);
        self = host_rig_start(&host_rig_here, rows[i].model);
        assert_int_equal(dg_host_send(self, &rows[i].event), rows[i].result);
    }
}

static void what_a_wire_does_not_have_is_told(void **state)
{
    uint16_t ids[DG_HOST_FILTERS];
    struct dg_host_frame frame;
    struct dg_host_uart uart;
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");

    (void)state;
    assert_int_equal(dg_host_frame(self, READY, &frame), DG_HOST_ERR_WIRE);
    assert_int_equal(dg_host_uart(self, &uart), DG_HOST_ERR_WIRE);
    self = host_rig_start(&host_rig_here, "s3684-rs485");
    assert_int_equal(dg_host_bit_rate(self), DG_HOST_ERR_WIRE);
    assert_int_equal(dg_host_bus_state(self), DG_HOST_ERR_WIRE);
    assert_int_equal(dg_host_filters(self, ids), DG_HOST_ERR_WIRE);
    assert_true(dg_host_answer_at(self) == DG_HOST_NEVER);
}

/* "save" takes 14 ms (line 778). */
static void an_answer_that_takes_its_time_is_known_before(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    const struct dg_host_event save = {.at = READY,
                                       .kind = DG_HOST_CAN,
                                       .id = 0x63F,
                                       .length = 8,
                                       .data = {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}};
    struct dg_host_event event;

    (void)state;
    host_rig_drain(self);
    assert_true(dg_host_answer_at(self) == DG_HOST_NEVER);
    assert_int_equal(dg_host_send(self, &save), DG_HOST_OK);
    (void)dg_host_step(self, READY);
    assert_int_equal(dg_host_answer_at(self), READY + 14 * MS);
    (void)dg_host_step(self, READY + 14 * MS);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.id, 0x5BF);
    assert_true(dg_host_answer_at(self) == DG_HOST_NEVER);
}

static void nothing_is_seen_without_power(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_uart uart;
    uint64_t counts = 0;
    uint16_t ids[DG_HOST_FILTERS];
    int32_t uv[4];

    (void)state;
    assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
    assert_int_equal(dg_host_uart(self, &uart), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_sincos(self, READY, uv), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_position(self, READY, &counts), DG_HOST_ERR_STATE);
    self = host_rig_start(&host_rig_here, "f3668");
    assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
    assert_int_equal(dg_host_bit_rate(self), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_bus_state(self), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_filters(self, ids), DG_HOST_ERR_STATE);
    self = host_rig_make(&host_rig_here, "s3684-rs485");
    assert_int_equal(dg_host_position(self, READY, &counts), DG_HOST_ERR_STATE);
}

/* ------------------------------------------------------------ characters */

static int ask(struct dg_host *self, struct dg_host_event request, struct dg_host_event *reply)
{
    int n = 0;

    host_rig_drain(self);
    request.kind = DG_HOST_BYTES;
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, request.at + 200 * MS);
    while (n < 4 && dg_host_receive(self, &reply[n]) == 1) {
        n++;
    }
    return n;
}

/* 56h: 40 characters are three runs, one behind the other without a pause. */
static void a_long_reply_is_several_runs(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_event reply[4];

    (void)state;
    assert_int_equal(
        ask(self, (struct dg_host_event){.at = READY, .length = 3, .data = {0x40, 0x56, 0x16}},
            reply),
        3);
    assert_int_equal(reply[0].length, 16);
    assert_int_equal(reply[1].length, 16);
    assert_int_equal(reply[2].length, 8);
    assert_int_equal(reply[1].at - reply[0].at, 18333334); /* 176 bits */
    assert_int_equal(reply[2].at - reply[0].at, 36666667); /* 352 bits */
    assert_true(reply[0].data[0] == 0x40 && reply[0].data[1] == 0x56);
    assert_int_equal(reply[2].data[8], 0); /* behind them there is nothing */
}

/* While that is on the line, the encoder does not hear. */
static void half_duplex_means_deaf_while_it_speaks(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_event request = {
        .at = READY, .kind = DG_HOST_BYTES, .length = 3, .data = {0x40, 0x56, 0x16}};
    struct dg_host_event reply[4];

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    request.at += 25 * MS; /* the reply began after 10 ms and takes 46 */
    assert_int_equal(dg_host_send(self, &request), DG_HOST_OK);
    (void)dg_host_step(self, READY + SECOND);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(dg_host_receive(self, &reply[i]), 1);
    }
    assert_int_equal(dg_host_receive(self, &reply[3]), 0);
}

/* A host that sees only whole characters, and one that says how long they took. */
static void characters_may_be_told_when_they_end(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_event request = {.at = READY, .length = 3, .data = {0x40, 0x42, 0x02}};
    struct dg_host_event by_start[4];
    struct dg_host_event by_end[4];

    (void)state;
    assert_int_equal(ask(self, request, by_start), 1);
    request.at += SECOND + 1145834; /* of the first character's end */
    request.flags = DG_HOST_ENDED;
    assert_int_equal(ask(self, request, by_end), 1);
    assert_memory_equal(by_start[0].data, by_end[0].data, 7);
    assert_in_range(by_end[0].at - SECOND - by_start[0].at, 0, 2);
    /* With 2 ms a character the end of the frame, and the reply, come later. */
    request.at += SECOND;
    request.id = 2 * MS;
    assert_int_equal(ask(self, request, by_start), 1);
    assert_in_range(by_start[0].at - SECOND - by_end[0].at, 1708331, 1708333);
    /* A pause as long as the timeout, between two of them, is the end: that was no 42h. */
    request.at += SECOND;
    request.id = 6 * MS;
    (void)ask(self, request, by_end);
    assert_int_not_equal(by_end[0].data[1], 0x42);
}

/* The edge of a start bit keeps a frame open; the character it begins comes in an own event. */
static void a_start_bit_keeps_a_frame_open(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    const struct dg_host_event events[] = {
        {.at = READY,
         .kind = DG_HOST_BYTES,
         .flags = DG_HOST_ENDED,
         .length = 2,
         .data = {0x40, 0x42}},
        {.at = READY + 5 * MS, .kind = DG_HOST_BYTES, .flags = DG_HOST_START},
        {.at = READY + 6 * MS + MS / 2,
         .kind = DG_HOST_BYTES,
         .flags = DG_HOST_ENDED,
         .length = 1,
         .data = {0x02}},
    };
    struct dg_host_event reply;

    (void)state;
    for (unsigned with = 0; with < 2; with++) {
        unsigned positions = 0;
        host_rig_drain(self);
        for (size_t i = 0; i < DG_COUNT(events); i++) {
            struct dg_host_event event = events[i];
            event.at += with * SECOND;
            if (i != 1 || with == 1) {
                assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
            }
        }
        (void)dg_host_step(self, READY + (1u + with) * SECOND - MS);
        while (dg_host_receive(self, &reply) == 1) {
            positions += reply.data[1] == 0x42 ? 1u : 0u;
        }
        assert_int_equal(positions, with);
    }
}

static void a_damaged_character_is_no_request(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_event reply[4];
    const struct dg_host_event request = {
        .at = READY, .flags = DG_HOST_DAMAGED, .length = 3, .data = {0x40, 0x42, 0x02}};

    (void)state;
    const int n = ask(self, request, reply);
    /* 5.1.3.6: a parity error is answered with 50h's code 09h, or not at all. */
    assert_true(n == 0 || reply[0].data[1] != 0x42);
}

/* 57h C4: 8N1; in force after 53h. */
static void a_character_without_parity_is_shorter(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-rs485");
    struct dg_host_event reply[4];
    struct dg_host_uart uart;

    (void)state;
    assert_int_equal(ask(self,
                         (struct dg_host_event){
                             .at = READY, .length = 5, .data = {0x40, 0x57, 0xC4, 0x55, 0x86}},
                         reply),
                     1);
    assert_int_equal(reply[0].data[1], 0x57);
    (void)ask(self,
              (struct dg_host_event){.at = READY + SECOND, .length = 3, .data = {0x40, 0x53, 0x13}},
              reply);
    (void)dg_host_step(self, READY + 3 * SECOND);
    assert_int_equal(dg_host_uart(self, &uart), DG_HOST_OK);
    assert_int_equal(uart.parity, 'N');
    assert_int_equal(ask(self,
                         (struct dg_host_event){
                             .at = READY + 4 * SECOND, .length = 3, .data = {0x40, 0x42, 0x02}},
                         reply),
                     1);
    assert_int_equal(reply[0].id, 1041667);
}

/* ------------------------------------------------------------ CAN */

static int answers(struct dg_host *self, uint64_t at, uint16_t flags)
{
    const struct dg_host_event read = {.at = at,
                                       .kind = DG_HOST_CAN,
                                       .id = 0x63F,
                                       .flags = flags,
                                       .length = 8,
                                       .data = {0x40, 0x01, 0x10}};
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

static void a_node_that_is_off_takes_no_frames(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    const struct dg_host_event off = {
        .at = READY + 20 * MS, .kind = DG_HOST_BUS, .id = DG_HOST_BUS_OFF};

    (void)state;
    assert_int_equal(answers(self, READY, 0), 1);
    assert_int_equal(answers(self, READY + 5 * MS, DG_HOST_REMOTE), 0);
    assert_int_equal(dg_host_power(self, READY + 10 * MS, false), DG_HOST_OK);
    assert_int_equal(answers(self, READY + 11 * MS, 0), 0);
    assert_int_equal(dg_host_power(self, READY + 15 * MS, true), DG_HOST_OK);
    assert_int_equal(dg_host_send(self, &off), DG_HOST_OK);
    assert_int_equal(answers(self, READY + SECOND, 0), 0);
}

/* ------------------------------------------------------------ edges */

/* The word of an SSI encoder by edges in the queue, and its line by edges out of it, whatever the
 * steps are: each at the moment of the clock's edge, and the rest at the end of the monoflop. */
static void edges_are_told_when_the_line_moves(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-13");
    const unsigned word = 2048u ^ 1024u; /* 2048 in Gray code */
    struct dg_host_event event = {.kind = DG_HOST_EDGE, .length = 1};
    bool level = true;

    (void)state;
    host_rig_drain(self);
    for (unsigned i = 0; i < 2u * 13u; i++) {
        event.at = READY + (i + 1u) * 500u;
        event.data[0] = i % 2u;
        assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    }
    (void)dg_host_step(self, READY + MS);
    for (unsigned i = 0; i < 13; i++) {
        const bool bit = (word >> (12u - i) & 1u) != 0;
        if (bit != level) {
            assert_int_equal(dg_host_receive(self, &event), 1);
            assert_int_equal(event.kind, DG_HOST_EDGE);
            assert_int_equal(event.at, READY + (2u * i + 2u) * 500u);
            assert_int_equal(event.length, 1);
            assert_int_equal(event.data[0], bit);
            level = bit;
        }
    }
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.at, READY + 25u * 500u + 20000u); /* behind the last falling edge */
    assert_int_equal(event.data[0], 1);
    assert_int_equal(dg_host_receive(self, &event), 0);
}

/* By calls it is the same: the edge is told beside the answer, and what is due is done. */
static void an_edge_by_call_is_told_as_well(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-13");
    struct dg_host_event event;

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_clock(self, READY, false), 1);
    assert_int_equal(dg_host_clock(self, READY + 500, true), 0);
    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.at, READY + 500);
    assert_int_equal(event.data[0], 0);
    assert_int_equal(dg_host_next(self), READY + 20000u);
}

/* ------------------------------------------------------------ queues */

/* As long as nobody knows of the gap, nothing gets behind it, whatever room there is. */
static void what_comes_behind_a_gap_is_lost_too(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ocd-ib-k2");
    struct dg_host_event event = {.at = READY, .kind = DG_HOST_WORDS};
    unsigned n = 0;

    (void)state;
    host_rig_drain(self);
    for (unsigned i = 0; i < DG_HOST_QUEUE + 2u; i++) {
        event.at++;
        assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
        (void)dg_host_step(self, event.at);
    }
    assert_int_equal(dg_host_lost(self), 2);
    assert_int_equal(dg_host_receive(self, &event), 1); /* room for one, before the gap */
    assert_int_equal(event.at, READY + 1);
    event = (struct dg_host_event){.at = READY + SECOND, .kind = DG_HOST_WORDS};
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    (void)dg_host_step(self, READY + SECOND);
    assert_int_equal(dg_host_lost(self), 3);
    while (dg_host_receive(self, &event) == 1) {
        n++;
    }
    assert_int_equal(n, DG_HOST_QUEUE - 1u);
}

/* As before the latest moment: what has come until then is taken, and time does not go on. */
static void never_is_no_moment(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ocd-ib-k2");
    struct dg_host_event event = {.at = 5, .kind = DG_HOST_WORDS};

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_step(self, DG_HOST_NEVER), DG_HOST_NEVER);
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    assert_int_equal(dg_host_step(self, DG_HOST_NEVER), DG_HOST_NEVER);
    assert_int_equal(dg_host_receive(self, &event), 1);
    event.at = READY + SECOND;
    assert_int_equal(dg_host_send(self, &event), DG_HOST_OK);
    assert_int_equal(dg_host_step(self, DG_HOST_NEVER), READY + SECOND);
    assert_int_equal(dg_host_receive(self, &event), 0);
}

/* One that looks after itself ten times a second would be asked for 584 years. */
static void a_node_is_not_run_for_ever(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "f3668");
    const uint64_t next = dg_host_step(self, READY);

    (void)state;
    assert_true(next > READY && next < READY + SECOND);
    assert_int_equal(dg_host_step(self, DG_HOST_NEVER), next);
    assert_true(dg_host_step(self, next) > next);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_cannot_be_an_event_is_refused),
        cmocka_unit_test(what_a_wire_does_not_have_is_told),
        cmocka_unit_test(an_answer_that_takes_its_time_is_known_before),
        cmocka_unit_test(nothing_is_seen_without_power),
        cmocka_unit_test(a_long_reply_is_several_runs),
        cmocka_unit_test(half_duplex_means_deaf_while_it_speaks),
        cmocka_unit_test(characters_may_be_told_when_they_end),
        cmocka_unit_test(a_start_bit_keeps_a_frame_open),
        cmocka_unit_test(a_damaged_character_is_no_request),
        cmocka_unit_test(a_character_without_parity_is_shorter),
        cmocka_unit_test(a_node_that_is_off_takes_no_frames),
        cmocka_unit_test(edges_are_told_when_the_line_moves),
        cmocka_unit_test(an_edge_by_call_is_told_as_well),
        cmocka_unit_test(what_comes_behind_a_gap_is_lost_too),
        cmocka_unit_test(never_is_no_moment),
        cmocka_unit_test(a_node_is_not_run_for_ever),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

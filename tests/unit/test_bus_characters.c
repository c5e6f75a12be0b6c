/* SPDX-License-Identifier: MIT */
/*
 * A line of characters in virtual time: one encoder on it is as its handle alone, several hear and
 * disturb each other. Moments are counted by hand, at 9600 Bd with even parity: 11 bits a
 * character, 44 of silence, 1 ms of reaction.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "character_rig.h"
#include "drehgeber/host_wire.h"
#include "hf_rig.h"

/* ------------------------------------------------------------ one encoder is its handle */

static uint32_t chance;

static uint32_t draw(uint32_t below)
{
    chance ^= chance << 13;
    chance ^= chance >> 17;
    chance ^= chance << 5;
    return chance % below;
}

/* What the bare handle has said since: where it began, and all its characters. */
static size_t fetch(struct dg_host *host, dg_ns *begin, uint8_t *bytes)
{
    struct dg_host_event event;
    size_t n = 0;

    while (dg_host_receive(host, &event) > 0) {
        *begin = n == 0 ? event.at : *begin;
        memcpy(bytes + n, event.data, event.length);
        n += event.length;
    }
    return n;
}

static size_t make_request(uint8_t *bytes)
{
    static const char *const requests[] = {
        "40 42",       "40 56",       "FF 42", "40 4A 00 00 04", "40 50", "41 42", "40 57 E5 55",
        "40 57 C2 55", "40 57 E4 55", "40 53", "40 46",          "40 47", "40 52", "40 44 48",
    };
    size_t n = hf_rig_hex(requests[draw(DG_COUNT(requests))], bytes, 8);

    bytes[n] = (uint8_t)(hf_rig_xor(bytes, n) ^ (draw(16) == 0 ? 1 : 0));
    return n + 1;
}

/* The same at the same moments to both, characters with pauses that end a frame or do not. */
static void send_to_both(struct character_rig *self, struct dg_host *bare)
{
    uint8_t bytes[16];
    const size_t n = make_request(bytes);
    struct dg_host_uart uart;

    assert_int_equal(dg_host_uart(bare, &uart), DG_HOST_OK);
    const dg_ns one = dg_bit_times_ns(uart.parity == 'N' ? 10 : 11, uart.baud);
    for (size_t i = 0; i < n; i++) {
        const bool damaged = draw(60) == 0;
        const struct dg_tap_event event = {
            .at = self->now,
            .kind = DG_TAP_CHARACTER,
            .character = {uart.baud, (char)uart.parity, bytes[i], damaged}};
        const struct dg_host_event same = {.at = self->now,
                                           .kind = DG_HOST_BYTES,
                                           .flags = damaged ? DG_HOST_DAMAGED : 0,
                                           .length = 1,
                                           .data = {bytes[i]}};
        (void)dg_bus_rx(self->bus, &event);
        assert_int_equal(dg_host_send(bare, &same), DG_HOST_OK);
        self->now += one + (draw(30) == 0 ? draw(6000000) : 0);
    }
}

static void switch_both(struct character_rig *self, struct dg_host *bare)
{
    character_rig_pass_to(self, self->now);
    (void)dg_host_step(bare, self->now);
    for (int on = 0; on < 2; on++) {
        assert_int_equal(dg_host_power(bare, self->now, on != 0), DG_HOST_OK);
        assert_int_equal(dg_host_power(self->hosts[0], self->now, on != 0), DG_HOST_OK);
        (void)dg_bus_changed(self->bus, 0, self->now);
    }
}

/* Each fault until it is cleared, or so often. */
static void bend_both(struct character_rig *self, struct dg_host_panel *panel)
{
    static const char *const names[] = {"wire_drop", "wire_deaf", "wire_delay", "wire_damage",
                                        "wire_duplicate"};
    const char *name = names[draw(DG_COUNT(names))];
    const struct dg_fault_limits limits = {
        .count = draw(4), .probability_ppm = 1000000, .duration = DG_NEVER};
    struct dg_encoder *const both[] = {dg_host_panel_encoder(panel), &self->control[0]};
    const bool on = draw(3) != 0;

    for (size_t i = 0; i < DG_COUNT(both); i++) {
        const struct dg_fault_target target = dg_encoder_target(both[0]);
        const size_t index = (size_t)dg_fault_find(&target, name);
        assert_int_equal(on ? dg_fault_set(&both[i]->faults, &target, index, self->now, &limits)
                            : dg_fault_clear(&both[i]->faults, &target, index),
                         0);
    }
}

/* @return replies */
static unsigned compare_lives(struct character_rig *line, struct dg_host_panel *panel,
                              struct dg_host *bare)
{
    unsigned replies = 0;

    for (unsigned i = 0; i < 2000; i++) {
        uint8_t bytes[4 * DG_REPLY_MAX];
        dg_ns begin = 0;
        line->whole_count = 0;
        send_to_both(line, bare);
        line->seen_count = 0;
        /* With faults all is over: a handle says ahead what is late. */
        const dg_ns pause = draw(8) == 0 ? draw(20000000) : 300 * MS;
        character_rig_pass_to(line, line->now + (panel != NULL ? 700 * MS : pause));
        (void)dg_host_step(bare, line->now);
        const size_t n = fetch(bare, &begin, bytes);
        assert_int_equal(line->whole_count, n);
        assert_memory_equal(line->whole, bytes, n);
        assert_true(n == 0 || line->whole_at == begin);
        replies += n > 0;
        if (panel != NULL && draw(4) == 0) {
            bend_both(line, panel);
        }
        if (draw(20) == 0) {
            switch_both(line, bare);
        }
        const struct dg_hf *alone = dg_host_line_of(bare)->device;
        assert_memory_equal(&character_rig_device(line, 0)->counters, &alone->counters,
                            sizeof alone->counters);
        assert_true(character_rig_device(line, 0)->deadline == alone->deadline);
    }
    return replies;
}

static void one_encoder_is_as_its_handle(void **state)
{
    static const struct dg_characters_setup whole = {
        .size = sizeof whole, .paced = true, .whole = character_rig_whole};
    static struct character_rig line;

    (void)state;
    for (unsigned faults = 0; faults < 2; faults++) {
        struct dg_host *bare = host_rig_make(&host_rig_here, "s3684-rs485");
        struct dg_host_panel *panel = NULL;
        chance = 1;
        assert_int_equal(dg_host_power(bare, 0, true), DG_HOST_OK);
        character_rig_make(&line, &whole, 1);
        (void)dg_host_step(bare, line.now);
        if (faults != 0) {
            panel = dg_host_panel_make(&host_rig_there, sizeof host_rig_there, bare);
            assert_non_null(panel);
        }
        assert_in_range(compare_lives(&line, panel, bare), 700, 2000);
    }
}

/* The end of each character is counted from the start of the reply, at every setting. */
static void ends_are_counted_from_the_start(void **state)
{
    static struct character_rig line;

    (void)state;
    for (unsigned setting = 0; setting < 256; setting++) {
        struct dg_hf_uart uart;
        if (dg_hf_uart_decode((uint8_t)setting, &uart) != DG_OK) {
            continue;
        }
        character_rig_make(&line, &character_rig_paced, 0);
        line.hosts[0] = host_rig_make(&line.places[0], "s3684-rs485");
        assert_int_equal(dg_host_power(line.hosts[0], 0, true), DG_HOST_OK);
        ((struct dg_hf *)dg_host_line_of(line.hosts[0])->device)->uart_next = (uint8_t)setting;
        assert_int_equal(dg_bus_attach(line.bus, line.hosts[0], NULL), 0);
        character_rig_pass_to(&line, 2 * READY);
        line.count = 0;
        character_rig_say_at(&line, uart.baud, uart.parity, "40 56 16");
        character_rig_pass_to(&line, 4 * READY);
        assert_int_equal(line.count, 40);
        const uint32_t bits = uart.parity == 'N' ? 10 : 11;
        const dg_ns begin = line.sent[0].event.at - dg_bit_times_ns(bits, uart.baud);
        for (uint32_t i = 0; i < 40; i++) {
            assert_int_equal(line.sent[i].event.at - begin,
                             dg_bit_times_ns((i + 1) * bits, uart.baud));
            assert_int_equal(line.sent[i].event.character.baud, uart.baud);
            assert_int_equal(line.sent[i].event.character.parity, uart.parity);
        }
    }
}

/* ------------------------------------------------------------ several */

static void each_answers_for_itself(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 3);
    character_rig_expect_answer(&line, "40 42 02", 0);
    character_rig_expect_answer(&line, "41 42 03", 1);
    character_rig_expect_answer(&line, "42 42 00", 2);
    character_rig_expect_silence(&line, "43 42 01");
}

/* 40h & 41h & 42h; positions are 0 on the shafts at 0, check sums 02h, 03h and 00h. */
static void two_at_once_are_their_and(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 3);
    const dg_ns begin = line.now + 3 * CHARACTER + ANSWER;
    character_rig_say(&line, "FF 42 BD");
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 7);
    for (size_t i = 0; i < 7; i++) {
        assert_true(line.sent[i].event.character.damaged);
    }
    character_rig_expect_sent(&line, 0, begin, 0, "40 42 00 00 00 00 00");
    character_rig_expect_answer(&line, "41 42 03", 1);
}

/* Who hears a reply of another one waits for a silence; who has replied has heard nothing. */
static void a_request_right_behind_a_reply(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    for (size_t i = 0; i < 2; i++) {
        character_rig_say(&line, "40 42 02");
        character_rig_pass_to(&line, line.now + 3 * CHARACTER + ANSWER + dg_bit_times_ns(77, 9600));
        character_rig_say(&line, i == 0 ? "40 42 02" : "41 42 03");
        character_rig_pass_to(&line, line.now + REST);
        assert_int_equal(line.count, i == 0 ? 7 : 0);
    }
}

static void a_request_into_a_reply_collides(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    character_rig_say(&line, "40 56 16");
    character_rig_pass_to(&line, line.now + 3 * CHARACTER + ANSWER + 10 * CHARACTER);
    character_rig_say(&line, "41 42 03");
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(dg_bus_characters_counters(line.bus).collided, 3);
    assert_int_equal(character_rig_device(&line, 0)->counters.damaged, 0);
    assert_int_equal(character_rig_device(&line, 1)->counters.damaged, 3);
}

/* ------------------------------------------------------------ settings */

static void another_setting_arrives_damaged(void **state)
{
    static const struct {
        uint32_t baud;
        char parity;
        bool fits;
    } rows[] = {
        {9600, 'E', true},      {9600, 0, true},          {9600, 'O', false}, {9600, 'N', false},
        {4800, 'E', false},     {4800, 0, false},         {0, 0, false},      {0, 'E', false},
        {DG_BAUD_ANY, 0, true}, {DG_BAUD_ANY, 'O', true},
    };
    const struct dg_characters_end any = {.any_line = true};
    static struct character_rig line;

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        character_rig_make(&line, &character_rig_paced, 1);
        assert_int_equal(dg_bus_characters_fits(line.bus, 0, rows[i].baud, rows[i].parity),
                         rows[i].fits);
        character_rig_say_at(&line, rows[i].baud, rows[i].parity, "40 42 02");
        character_rig_pass_to(&line, line.now + REST);
        assert_int_equal(line.count, rows[i].fits ? 7 : 0);
        dg_bus_characters_set(line.bus, 0, &any);
        character_rig_say_at(&line, rows[i].baud, rows[i].parity, "40 42 02");
        line.count = 0;
        character_rig_pass_to(&line, line.now + REST);
        assert_int_equal(line.count, 7);
        assert_true(line.sent[0].event.character.baud == DG_BAUD_ANY);
        assert_int_equal(line.sent[0].event.character.parity, 0);
    }
}

/* One at 19200 Bd hears the other one's reply damaged. */
static void neighbours_may_have_other_settings(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    character_rig_say(&line, "41 57 E5 55 A6");
    character_rig_pass_to(&line, line.now + REST);
    character_rig_say(&line, "41 53 12");
    character_rig_pass_to(&line, line.now + READY);
    assert_int_equal(dg_bus_characters_uart(line.bus, 1).baud, 19200);
    const uint32_t damaged = character_rig_device(&line, 1)->counters.damaged;
    character_rig_expect_answer(&line, "40 42 02", 0);
    assert_int_equal(character_rig_device(&line, 1)->counters.damaged, damaged + 3 + 7);
}

/* ------------------------------------------------------------ forms */

/* A host may learn it when its port is open. */
static void a_line_may_turn_out_to_have_a_uart(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 1);
    dg_bus_characters_whole(line.bus, character_rig_whole);
    character_rig_say(&line, "40 42 02");
    const dg_ns begin = line.now + ANSWER;
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 0);
    assert_int_equal(line.whole_count, 7);
    assert_true(line.whole_at == begin); /* the request took no time */
}

/* Without pacing a character is over when it comes; start bits may be told. */
static void a_line_with_a_uart(void **state)
{
    static const struct dg_characters_setup plain = {.size = sizeof plain};
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &plain, 1);
    character_rig_say(&line, "40");
    line.now += SILENCE;
    (void)dg_bus_characters_start(line.bus, line.now);
    line.now += CHARACTER;
    character_rig_say(&line, "42 02");
    const dg_ns begin = line.now + ANSWER;
    character_rig_pass_to(&line, line.now + REST);
    character_rig_expect_sent(&line, 0, begin, 0, "40 42");
    assert_int_equal(line.count, 7);
}

static void a_reply_that_takes_no_time(void **state)
{
    const struct dg_characters_end at_once = {.at_once = true};
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, NULL, 1);
    dg_bus_characters_set(line.bus, 0, &at_once);
    character_rig_say(&line, "40 42 02");
    const dg_ns begin = line.now + ANSWER;
    character_rig_pass_to(&line, begin);
    assert_int_equal(line.count, 7);
    assert_int_equal(line.sent[0].event.at, begin);
    assert_int_equal(line.sent[6].event.at, begin);
    character_rig_say(&line, "40 42 02");
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 7);
}

/* In real time a call is late: the reply begins with it and is not squeezed. It is counted once,
 * though two deadlines have passed: the silence, and the reaction time. */
static void a_late_call_does_not_squeeze_a_reply(void **state)
{
    static const struct dg_characters_setup live = {
        .size = sizeof live, .paced = true, .live = true, .late = 5 * MS};
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &live, 1);
    const uint64_t counted = dg_bus_characters_counters(line.bus).late;
    character_rig_say(&line, "40 42 02");
    const dg_ns late = line.now + REST;
    assert_int_equal(dg_bus_step(line.bus, late), late + CHARACTER);
    assert_int_equal(line.count, 0);
    character_rig_pass_to(&line, late + REST);
    character_rig_expect_sent(&line, 0, late, 0, "40 42");
    assert_int_equal(dg_bus_characters_counters(line.bus).late, counted + 1);
    character_rig_expect_answer(&line, "40 42 02", 0);
    assert_int_equal(dg_bus_characters_counters(line.bus).late, counted + 1);
}

/* The position in it is that of the moment it is said at. A quarter of a turn in 100 ms. */
static void a_late_reply_is_of_its_own_moment(void **state)
{
    static const struct dg_characters_setup live = {
        .size = sizeof live, .paced = true, .live = true};
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &live, 1);
    struct dg_host *host = dg_bus_encoder(line.bus, 0);
    dg_host_shaft(host, line.now, 0, (int64_t)5 << 31);
    character_rig_say(&line, "40 42 02");
    const dg_ns late = line.now + 100 * MS;
    uint64_t position = 0;
    assert_int_equal(dg_host_position(host, late, &position), DG_HOST_OK);
    (void)dg_bus_step(line.bus, late);
    character_rig_pass_to(&line, late + REST);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(line.sent[2 + i].event.character.byte,
                         (uint8_t)(position >> (24 - 8 * i)));
    }
    assert_true(position > 0);
}

/* Nobody looks: one call for a request of three characters, and one for each that is said. */
static void an_unwatched_line_asks_for_fewer_calls(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 1);
    for (int watched = 1; watched >= 0; watched--) {
        dg_bus_watch(line.bus, watched != 0);
        character_rig_say(&line, "40 42 02");
        assert_int_equal(dg_bus_next(line.bus) - line.now,
                         watched != 0 ? CHARACTER : 3 * CHARACTER);
        character_rig_pass_to(&line, line.now + REST);
        assert_int_equal(line.count, 7);
        assert_int_equal(line.seen_count, watched != 0 ? 10 : 0);
    }
}

static void too_many_characters_are_lost(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 1);
    for (size_t i = 0; i < DG_COMING_MAX + 5u; i++) {
        character_rig_say_at(&line, 9600, 'E', "41");
    }
    assert_int_equal(dg_bus_characters_counters(line.bus).overrun, 5);
    character_rig_pass_to(&line, line.now + READY);
    assert_int_equal(character_rig_device(&line, 0)->counters.others, 1);
    character_rig_expect_answer(&line, "40 42 02", 0);
}

/* ------------------------------------------------------------ refused */

static void ignore_sent(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    (void)event;
}

static void what_is_no_such_line_is_refused(void **state)
{
    const struct dg_bus_ops ops = {.tx = ignore_sent};
    const struct dg_characters_setup other = {.size = sizeof other - 1u};
    static struct character_rig line;
    struct dg_bus_setup setup = {.size = sizeof setup,
                                 .medium = &dg_bus_characters,
                                 .encoders = 1,
                                 .wire = &other,
                                 .ops = &ops};

    (void)state;
    assert_int_equal(dg_bus_size(&dg_bus_characters, 0), 0);
    assert_int_not_equal(dg_bus_size(&dg_bus_characters, 32), 0);
    assert_int_equal(dg_bus_size(&dg_bus_characters, 33), 0);
    assert_null(dg_bus_init(line.memory, sizeof line.memory, &setup));
    setup.wire = NULL;
    struct dg_bus *bus = dg_bus_init(line.memory, sizeof line.memory, &setup);
    assert_non_null(bus);
    assert_int_equal(dg_bus_attach(bus, host_rig_make(&line.places[0], "f3668"), NULL),
                     DG_ERR_ARGUMENT);
    assert_int_equal(dg_bus_attach(bus, host_rig_make(&line.places[0], "s3684-rs485"), NULL), 0);
    assert_int_equal(dg_bus_attach(bus, host_rig_make(&line.places[1], "s3684-rs485"), NULL),
                     DG_ERR_SPACE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_encoder_is_as_its_handle),
        cmocka_unit_test(ends_are_counted_from_the_start),
        cmocka_unit_test(each_answers_for_itself),
        cmocka_unit_test(two_at_once_are_their_and),
        cmocka_unit_test(a_request_right_behind_a_reply),
        cmocka_unit_test(a_request_into_a_reply_collides),
        cmocka_unit_test(another_setting_arrives_damaged),
        cmocka_unit_test(neighbours_may_have_other_settings),
        cmocka_unit_test(a_line_may_turn_out_to_have_a_uart),
        cmocka_unit_test(a_line_with_a_uart),
        cmocka_unit_test(a_reply_that_takes_no_time),
        cmocka_unit_test(a_late_call_does_not_squeeze_a_reply),
        cmocka_unit_test(a_late_reply_is_of_its_own_moment),
        cmocka_unit_test(an_unwatched_line_asks_for_fewer_calls),
        cmocka_unit_test(too_many_characters_are_lost),
        cmocka_unit_test(what_is_no_such_line_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

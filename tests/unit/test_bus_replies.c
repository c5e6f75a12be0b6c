/* SPDX-License-Identifier: MIT */
/*
 * Replies on a line of characters that do not come as usual: kept until a memory is through, cut
 * off by the power, bent by faults.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "character_rig.h"

/* ------------------------------------------------------------ kept replies, power */

static void a_kept_reply_waits(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    line.answer = DG_BUS_KEEP;
    character_rig_expect_silence(&line, "40 42 02");
    const struct dg_hf_counters heard = character_rig_device(&line, 0)->counters;
    character_rig_expect_answer(&line, "41 42 03", 1);
    character_rig_expect_silence(&line, "40 42 02");
    assert_memory_equal(&heard, &character_rig_device(&line, 0)->counters, sizeof heard);
    (void)dg_bus_durable(line.bus, 0, line.now);
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 0);
    line.answer = DG_BUS_SAY;
    const dg_ns begin = line.now;
    (void)dg_bus_durable(line.bus, 0, line.now);
    character_rig_pass_to(&line, line.now + REST);
    character_rig_expect_sent(&line, 0, begin, 0, "40 42");
    assert_int_equal(line.count, 7);
}

static void a_lost_reply_is_not_said(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 1);
    line.answer = DG_BUS_KEEP;
    character_rig_expect_silence(&line, "40 42 02");
    line.answer = DG_BUS_DROP;
    (void)dg_bus_durable(line.bus, 0, line.now);
    character_rig_expect_silence(&line, "40 42 02");
    line.answer = DG_BUS_SAY;
    character_rig_expect_answer(&line, "40 42 02", 0);
}

static void a_reply_ends_with_the_power(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 1);
    for (int kept = 0; kept < 2; kept++) {
        line.answer = kept != 0 ? DG_BUS_KEEP : DG_BUS_SAY;
        character_rig_say(&line, "40 42 02");
        character_rig_pass_to(&line, line.now + 3 * CHARACTER + ANSWER + 2 * CHARACTER);
        assert_int_equal(dg_host_power(line.hosts[0], line.now, false), DG_HOST_OK);
        (void)dg_bus_changed(line.bus, 0, line.now);
        line.answer = DG_BUS_SAY;
        (void)dg_bus_durable(line.bus, 0, line.now);
        character_rig_pass_to(&line, line.now + REST);
        assert_int_equal(line.count, kept != 0 ? 0 : 2);
        assert_int_equal(dg_host_power(line.hosts[0], line.now, true), DG_HOST_OK);
        (void)dg_bus_changed(line.bus, 0, line.now);
        character_rig_pass_to(&line, line.now + READY);
        character_rig_expect_answer(&line, "40 42 02", 0);
    }
}

/* ------------------------------------------------------------ faults */

static void faults_of_replies(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    character_rig_bend(&line, 0, DG_WIRE_DROP, 1);
    character_rig_expect_silence(&line, "40 42 02");
    character_rig_bend(&line, 0, DG_WIRE_DUPLICATE, 1);
    const dg_ns begin = line.now + 3 * CHARACTER + ANSWER;
    character_rig_say(&line, "40 42 02");
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 14);
    character_rig_expect_sent(&line, 7, begin + dg_bit_times_ns(77, 9600), 0, "40 42");
    character_rig_bend(&line, 0, DG_WIRE_DAMAGE, 1);
    character_rig_say(&line, "40 42 02");
    character_rig_pass_to(&line, line.now + REST);
    size_t damaged = 0;
    for (size_t i = 0; i < 7; i++) {
        damaged += line.sent[i].event.character.damaged;
    }
    assert_int_equal(damaged, 1);
    character_rig_bend(&line, 0, DG_WIRE_DELAY, 1);
    const dg_ns late = line.now + 3 * CHARACTER + ANSWER + DELAY;
    character_rig_say(&line, "40 42 02");
    character_rig_pass_to(&line, line.now + REST);
    character_rig_expect_answer(&line, "41 42 03", 1);
    character_rig_pass_to(&line, line.now + DELAY);
    character_rig_expect_sent(&line, 7, late, 0, "40 42");
    character_rig_expect_answer(&line, "40 42 02", 0);
}

/* One that takes no time hears requests while its reply is late. What is late goes out, unless a
 * newer reply does. */
static void a_late_reply_outlives_one_that_is_dropped(void **state)
{
    static const struct dg_characters_end at_once = {.at_once = true};
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 1);
    dg_bus_characters_set(line.bus, 0, &at_once);
    for (unsigned lost = 0; lost < 2; lost++) {
        const dg_ns late = line.now + 3 * CHARACTER + ANSWER + DELAY;
        character_rig_bend(&line, 0, DG_WIRE_DELAY, 1);
        character_rig_expect_silence(&line, "40 42 02");
        if (lost == 0) {
            character_rig_bend(&line, 0, DG_WIRE_DROP, 1);
        }
        line.answer = lost == 0 ? DG_BUS_SAY : DG_BUS_DROP;
        character_rig_expect_silence(&line, "40 50 10");
        line.answer = DG_BUS_SAY;
        character_rig_pass_to(&line, late + REST);
        assert_int_equal(line.count, 7);
        assert_int_equal(line.sent[0].event.at, late);
        assert_int_equal(line.sent[1].event.character.byte, 0x42);
        assert_false(line.sent[1].event.character.damaged);
    }
    character_rig_bend(&line, 0, DG_WIRE_DELAY, 1);
    character_rig_expect_silence(&line, "40 42 02");
    character_rig_say(&line, "40 50 10");
    character_rig_pass_to(&line, line.now + 2 * DELAY);
    assert_int_equal(line.count, 4);
    assert_int_equal(line.sent[1].event.character.byte, 0x50);
}

/* Counted are requests for it, by their first character. */
static void a_deaf_one_misses_what_is_for_it(void **state)
{
    static struct character_rig line;

    (void)state;
    character_rig_make(&line, &character_rig_paced, 2);
    character_rig_bend(&line, 0, DG_WIRE_DEAF, 1);
    character_rig_expect_answer(&line, "41 42 03", 1);
    character_rig_expect_silence(&line, "40 42 02");
    character_rig_expect_answer(&line, "40 42 02", 0);
    character_rig_bend(&line, 0, DG_WIRE_DEAF, 1);
    character_rig_say(&line, "FF 42 BD");
    character_rig_pass_to(&line, line.now + REST);
    assert_int_equal(line.count, 7);
    assert_false(line.sent[0].event.character.damaged);
    assert_int_equal(line.sent[0].place, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_kept_reply_waits),
        cmocka_unit_test(a_lost_reply_is_not_said),
        cmocka_unit_test(a_reply_ends_with_the_power),
        cmocka_unit_test(faults_of_replies),
        cmocka_unit_test(a_late_reply_outlives_one_that_is_dropped),
        cmocka_unit_test(a_deaf_one_misses_what_is_for_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

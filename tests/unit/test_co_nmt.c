/* SPDX-License-Identifier: MIT */
/*
 * NMT, heartbeat, guarding and emergencies in virtual time (CiA 301; manual chapters 14-17, 27,
 * 28). Golden frames are written by hand from there.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "co_rig.h"

#define HEARTBEAT 0x73F
#define EMCY 0x0BF
#define START 0x01
#define STOP 0x02
#define PRE_OPERATIONAL 0x80
#define RESET_NODE 0x81
#define RESET_COMMUNICATION 0x82

static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    return 0;
}

static void write_ok(uint16_t index, uint8_t sub, uint32_t value, uint8_t size)
{
    assert_int_equal(co_rig_write(&rig, index, sub, value, size), 0);
    co_rig_forget(&rig);
}

static void boot_up_is_sent_once_and_leads_to_pre_operational(void **state)
{
    (void)state;
    dg_co_power_off(&rig.node);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, HEARTBEAT, "00");
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL);
}

static void commands_change_the_state(void **state)
{
    static const struct {
        uint8_t command;
        enum dg_co_state state;
    } rows[] = {
        {START, DG_CO_OPERATIONAL},
        {STOP, DG_CO_STOPPED},
        {PRE_OPERATIONAL, DG_CO_PRE_OPERATIONAL},
        {STOP, DG_CO_STOPPED},
        {START, DG_CO_OPERATIONAL},
        {RESET_NODE, DG_CO_PRE_OPERATIONAL},
        {STOP, DG_CO_STOPPED},
        {RESET_COMMUNICATION, DG_CO_PRE_OPERATIONAL},
    };
    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        co_rig_nmt(&rig, rows[i].command);
        assert_int_equal(rig.node.state, rows[i].state);
    }
}

static void commands_for_others_and_malformed_ones_do_nothing(void **state)
{
    (void)state;
    co_rig_rx(&rig, 0, "01 3E"); /* another node */
    co_rig_rx(&rig, 0, "01");    /* too short */
    co_rig_rx(&rig, 0, "01 3F 00");
    co_rig_rx(&rig, 0, "33 3F"); /* no such command */
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL);
    assert_int_equal(rig.node.counters.malformed, 2);
    co_rig_rx(&rig, 0, "01 3F");
    assert_int_equal(rig.node.state, DG_CO_OPERATIONAL);
}

static void reset_communication_leaves_the_application(void **state)
{
    uint32_t value;
    (void)state;
    write_ok(0x100C, 0, 77, 2);
    write_ok(0x2102, 0, 0, 1);
    co_rig_nmt(&rig, RESET_COMMUNICATION);
    assert_int_equal(co_rig_read(&rig, 0x100C, 0, &value), 0);
    assert_int_equal(value, 0);
    assert_int_equal(co_rig_read(&rig, 0x2102, 0, &value), 0);
    assert_int_equal(value, 0);
}

static void stopped_answers_no_sdo(void **state)
{
    (void)state;
    co_rig_nmt(&rig, STOP);
    co_rig_rx(&rig, 0x63F, "40 00 10 00");
    co_rig_run(&rig, DG_S(2));
    co_rig_expect_count(&rig, 0);
    co_rig_nmt(&rig, PRE_OPERATIONAL);
    co_rig_rx(&rig, 0x63F, "40 00 10 00");
    co_rig_expect(&rig, 0, 0x5BF, "43 00 10 00 96 01 02 00");
}

static void heartbeats_come_at_once_and_every_period(void **state)
{
    (void)state;
    dg_ns begin = rig.now;
    (void)co_rig_write(&rig, 0x1017, 0, 500, 2);
    co_rig_expect_count(&rig, 2); /* the answer and the first heartbeat */
    co_rig_forget(&rig);
    co_rig_run(&rig, DG_MS(1600));
    co_rig_expect_count(&rig, 3);
    for (uint32_t i = 0; i < 3; i++) {
        co_rig_expect(&rig, i, HEARTBEAT, "7F");
        assert_int_equal(rig.at[i] - begin, DG_MS(500) * (i + 1));
    }
    co_rig_forget(&rig);
    co_rig_rx(&rig, 0, "01 00");
    co_rig_expect(&rig, 0, HEARTBEAT, "05");
}

static void a_late_host_gets_one_heartbeat_for_many_periods(void **state)
{
    (void)state;
    write_ok(0x1017, 0, 10, 2);
    rig.now += DG_MS(95);
    dg_ns next = dg_co_step(&rig.node, rig.now);
    co_rig_expect_count(&rig, 1);
    assert_true(next > rig.now && next <= rig.now + DG_MS(10));
}

static void guarding_toggles_and_starts_at_0_after_a_reset(void **state)
{
    static const char *const answers[] = {"7F", "FF", "7F", "FF"};
    (void)state;
    for (uint32_t i = 0; i < 4; i++) {
        co_rig_rtr(&rig, HEARTBEAT);
        co_rig_expect(&rig, i, HEARTBEAT, answers[i]);
    }
    co_rig_rtr(&rig, HEARTBEAT);
    co_rig_nmt(&rig, RESET_COMMUNICATION);
    co_rig_rtr(&rig, HEARTBEAT);
    co_rig_expect(&rig, 0, HEARTBEAT, "7F");
}

static void guarding_is_silent_while_heartbeat_is_on(void **state)
{
    (void)state;
    write_ok(0x1017, 0, 1000, 2);
    co_rig_rtr(&rig, HEARTBEAT);
    co_rig_expect_count(&rig, 0);
}

static void life_guarding_raises_8130_and_ends_with_the_next_request(void **state)
{
    (void)state;
    write_ok(0x100C, 0, 100, 2);
    write_ok(0x100D, 0, 3, 1);
    co_rig_run(&rig, DG_S(1));
    co_rig_expect_count(&rig, 0); /* runs from the first request on */
    co_rig_nmt(&rig, START);
    co_rig_rtr(&rig, HEARTBEAT);
    co_rig_forget(&rig);
    co_rig_run(&rig, DG_MS(299));
    co_rig_expect_count(&rig, 0);
    co_rig_run(&rig, DG_MS(1));
    co_rig_expect(&rig, 0, EMCY, "30 81 11 00 00 00 00 00");
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL); /* 1029h:1 = 0 */
    co_rig_forget(&rig);
    co_rig_rtr(&rig, HEARTBEAT);
    co_rig_expect(&rig, 1, EMCY, "00 00 00 00 00 00 00 00");
}

static void a_silent_node_raises_8130_after_its_first_heartbeat(void **state)
{
    (void)state;
    write_ok(0x1016, 1, 0x000701F4, 4); /* node 7, 500 ms: the manual's example */
    write_ok(0x1029, 1, 2, 1);          /* stop on communication errors */
    co_rig_run(&rig, DG_S(2));
    co_rig_expect_count(&rig, 0);
    co_rig_rx(&rig, 0x707, "05");
    co_rig_run(&rig, DG_MS(400));
    co_rig_rx(&rig, 0x707, "05");
    co_rig_run(&rig, DG_MS(499));
    co_rig_expect_count(&rig, 0);
    co_rig_run(&rig, DG_MS(1));
    co_rig_expect(&rig, 0, EMCY, "30 81 11 00 00 00 00 00");
    assert_int_equal(rig.node.state, DG_CO_STOPPED);
    co_rig_nmt(&rig, PRE_OPERATIONAL);
    co_rig_rx(&rig, 0x707, "05");
    co_rig_expect(&rig, 0, EMCY, "00 00 00 00 00 00 00 00");
}

static void consumer_entries_are_checked(void **state)
{
    (void)state;
    write_ok(0x1016, 1, 0x00070064, 4);
    assert_int_equal(co_rig_write(&rig, 0x1016, 2, 0x000700C8, 4), 0x06040043);
    assert_int_equal(co_rig_write(&rig, 0x1016, 1, 0x00080064, 4), 0x06040043);
    assert_int_equal(co_rig_write(&rig, 0x1016, 2, 0x00800064, 4), 0x06090030);
    write_ok(0x1016, 1, 0, 4);
    write_ok(0x1016, 1, 0x00080064, 4);
    write_ok(0x1016, 2, 0x00070064, 4);
    write_ok(0x1016, 1, 0, 4);
    assert_int_equal(co_rig_write(&rig, 0x1016, 1, 0x000700C8, 4), 0x06040043); /* 2 then 1 */
    write_ok(0x1016, 1, 0x00090064, 4);
}

static void the_inhibit_time_keeps_emergencies_apart_and_loses_none(void **state)
{
    (void)state;
    write_ok(0x1015, 0, 100, 2); /* 10 ms */
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_OVERRUN);
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_PASSIVE);
    co_rig_expect_count(&rig, 1);
    co_rig_expect(&rig, 0, EMCY, "10 81 11 00 00 00 00 00");
    dg_ns begin = rig.now;
    co_rig_run(&rig, DG_MS(100));
    co_rig_expect_count(&rig, 3);
    co_rig_expect(&rig, 1, EMCY, "00 00 00 00 00 00 00 00");
    co_rig_expect(&rig, 2, EMCY, "20 81 11 00 00 00 00 00");
    assert_int_equal(rig.at[1] - begin, DG_MS(10));
    assert_int_equal(rig.at[2] - begin, DG_MS(20));
}

static void the_history_has_eight_entries_newest_first(void **state)
{
    uint32_t value;
    (void)state;
    assert_int_equal(co_rig_read(&rig, 0x1003, 1, &value), 0x08000024);
    for (int i = 0; i < 9; i++) {
        (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_OVERRUN);
    }
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_PASSIVE);
    assert_int_equal(co_rig_read(&rig, 0x1003, 0, &value), 0);
    assert_int_equal(value, 8);
    assert_int_equal(co_rig_read(&rig, 0x1003, 1, &value), 0);
    assert_int_equal(value, 0x8120);
    assert_int_equal(co_rig_read(&rig, 0x1003, 8, &value), 0);
    assert_int_equal(value, 0x8110);
    assert_int_equal(co_rig_read(&rig, 0x1001, 0, &value), 0);
    assert_int_equal(value, 0x11);
    assert_int_equal(co_rig_write(&rig, 0x1003, 0, 1, 1), 0x06090030);
    write_ok(0x1003, 0, 0, 1);
    assert_int_equal(co_rig_read(&rig, 0x1003, 1, &value), 0x08000024);
}

static void bus_off_reacts_at_once_and_is_told_when_it_is_over(void **state)
{
    (void)state;
    co_rig_nmt(&rig, START);
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_OFF);
    assert_int_equal(rig.node.state, DG_CO_PRE_OPERATIONAL);
    co_rig_forget(&rig);
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_ACTIVE);
    co_rig_expect(&rig, 0, EMCY, "40 81 11 00 00 00 00 00");
    co_rig_expect(&rig, 1, EMCY, "00 00 00 00 00 00 00 00");
    co_rig_expect_count(&rig, 2);
}

static void emergencies_wait_while_stopped(void **state)
{
    (void)state;
    co_rig_nmt(&rig, STOP);
    (void)dg_co_bus(&rig.node, rig.now, DG_CO_BUS_PASSIVE);
    co_rig_expect_count(&rig, 0);
    co_rig_rx(&rig, 0, "80 00");
    co_rig_expect(&rig, 0, EMCY, "20 81 11 00 00 00 00 00");
}

static void time_is_taken_over_only_when_consumed(void **state)
{
    (void)state;
    co_rig_rx(&rig, 0x100, "01 00 00 00 02 00");
    assert_int_equal(rig.node.time_days, 0);
    write_ok(0x1012, 0, 0x80000100, 4);
    co_rig_rx(&rig, 0x100, "78 56 34 F2 39 30");
    assert_int_equal(rig.node.time_ms, 0x02345678);
    assert_int_equal(rig.node.time_days, 0x3039);
    assert_int_equal(co_rig_write(&rig, 0x1012, 0, 0x80000601, 4), 0x06090030);
}

static void a_powered_off_node_is_dead(void **state)
{
    (void)state;
    dg_co_power_off(&rig.node);
    co_rig_rx(&rig, 0, "01 00");
    co_rig_rtr(&rig, HEARTBEAT);
    assert_true(dg_co_step(&rig.node, rig.now) == DG_NEVER);
    assert_true(dg_co_bus(&rig.node, rig.now, DG_CO_BUS_OFF) == DG_NEVER);
    co_rig_expect_count(&rig, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(boot_up_is_sent_once_and_leads_to_pre_operational, setup),
        cmocka_unit_test_setup(commands_change_the_state, setup),
        cmocka_unit_test_setup(commands_for_others_and_malformed_ones_do_nothing, setup),
        cmocka_unit_test_setup(reset_communication_leaves_the_application, setup),
        cmocka_unit_test_setup(stopped_answers_no_sdo, setup),
        cmocka_unit_test_setup(heartbeats_come_at_once_and_every_period, setup),
        cmocka_unit_test_setup(a_late_host_gets_one_heartbeat_for_many_periods, setup),
        cmocka_unit_test_setup(guarding_toggles_and_starts_at_0_after_a_reset, setup),
        cmocka_unit_test_setup(guarding_is_silent_while_heartbeat_is_on, setup),
        cmocka_unit_test_setup(life_guarding_raises_8130_and_ends_with_the_next_request, setup),
        cmocka_unit_test_setup(a_silent_node_raises_8130_after_its_first_heartbeat, setup),
        cmocka_unit_test_setup(consumer_entries_are_checked, setup),
        cmocka_unit_test_setup(the_inhibit_time_keeps_emergencies_apart_and_loses_none, setup),
        cmocka_unit_test_setup(the_history_has_eight_entries_newest_first, setup),
        cmocka_unit_test_setup(bus_off_reacts_at_once_and_is_told_when_it_is_over, setup),
        cmocka_unit_test_setup(emergencies_wait_while_stopped, setup),
        cmocka_unit_test_setup(time_is_taken_over_only_when_consumed, setup),
        cmocka_unit_test_setup(a_powered_off_node_is_dead, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

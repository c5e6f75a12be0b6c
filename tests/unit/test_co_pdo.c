/* SPDX-License-Identifier: MIT */
/*
 * TPDOs at work: SYNC, RTR, event timer, events (CiA 301; manual chapters 3, 11; C2-C5).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "pdo_rig.h"

/* ------------------------------------------------------------ golden frames */

/* Chapter 3's table of default mappings; TPDO4 with the CRC of C24. */
static void entering_operational_sends_the_event_driven_ones(void **state)
{
    static const uint8_t position[] = {0x04, 0x03, 0x02, 0x01};
    static const uint8_t speed[] = {0x85, 0xFF};
    static const uint8_t raw[] = {0x15, 0x3A, 0x7F, 0x01, 0x00, 0x29};

    (void)state;
    pdo_nmt(START);
    assert_int_equal(pdo_rig.count, 3);
    pdo_expect(0, TPDO1, position, sizeof position);
    pdo_expect(1, TPDO3, speed, sizeof speed);
    pdo_expect(2, TPDO4, raw, sizeof raw);
    pdo_forget();
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect(0, TPDO2, position, sizeof position);
}

static void two_tpdos_can_swap_their_can_ids(void **state)
{
    static const uint8_t speed[] = {0x85, 0xFF};

    (void)state;
    assert_int_equal(pdo_put(0x1800, 1, TPDO3, 4), 0x06090030);
    pdo_disable(0);
    pdo_put_ok(0x1800, 1, TPDO3, 4);
    pdo_disable(2);
    pdo_put_ok(0x1802, 1, TPDO1, 4);
    pdo_put_type(0, 253);
    pdo_put_type(2, 253);
    pdo_nmt(START);
    pdo_forget();
    pdo_request(TPDO1);
    pdo_request(TPDO3);
    assert_int_equal(pdo_rig.count, 2);
    pdo_expect(0, TPDO1, speed, sizeof speed);
    pdo_expect_u32(1, TPDO3, 0x01020304);
}

static void nothing_is_sent_outside_operational(void **state)
{
    static const uint8_t others[] = {PRE_OPERATIONAL, STOP, RESET_NODE};

    (void)state;
    pdo_put_ok(0x1800, 5, 10, 2);
    for (uint8_t i = 0; i < sizeof others; i++) {
        pdo_nmt(START);
        pdo_nmt(others[i]);
        pdo_forget();
        pdo_sync();
        pdo_request(TPDO1);
        pdo_change(i);
        pdo_run_ms(100);
        assert_int_equal(pdo_rig.count, 0);
        assert_int_equal(pdo_rig.samples, 0);
    }
}

/* ------------------------------------------------------------ SYNC */

static void type_4_fires_at_sync_4_8_12(void **state)
{
    (void)state;
    pdo_only_tpdo2(4);
    for (uint32_t i = 1; i <= 13; i++) {
        pdo_rig.live = i;
        pdo_sync();
        assert_int_equal(pdo_rig.count, i / 4);
    }
    pdo_expect_u32(0, TPDO2, 4);
    pdo_expect_u32(1, TPDO2, 8);
    pdo_expect_u32(2, TPDO2, 12);
}

static void every_cyclic_type_fires_at_its_multiples(void **state)
{
    (void)state;
    pdo_only_tpdo2(1);
    for (uint32_t type = 1; type <= 240; type++) {
        pdo_put_type(1, (uint8_t)type); /* counted from the write */
        pdo_forget();
        for (uint32_t i = 1; i <= 2 * type; i++) {
            pdo_sync();
            assert_int_equal(pdo_rig.count, i / type);
        }
    }
}

static void the_phase_begins_with_operational(void **state)
{
    (void)state;
    pdo_only_tpdo2(3);
    pdo_sync();
    pdo_sync();
    pdo_nmt(PRE_OPERATIONAL);
    pdo_sync();
    pdo_nmt(START);
    pdo_sync();
    pdo_sync();
    assert_int_equal(pdo_rig.count, 0);
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
    pdo_request(TPDO2); /* a remote frame leaves the phase alone */
    pdo_sync();
    pdo_sync();
    assert_int_equal(pdo_rig.count, 2);
    pdo_sync();
    assert_int_equal(pdo_rig.count, 3);
}

static void type_0_waits_for_an_event_and_a_sync(void **state)
{
    (void)state;
    pdo_only_tpdo2(0);
    pdo_sync(); /* entering Operational was one */
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
    pdo_forget();
    pdo_change(1);
    pdo_change(2);
    pdo_run_ms(50);
    assert_int_equal(pdo_rig.count, 0);
    pdo_rig.live = 3;
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect_u32(0, TPDO2, 3);
    pdo_sync();
    pdo_change(3); /* no change */
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
    pdo_change(4);
    pdo_sync();
    assert_int_equal(pdo_rig.count, 2);
    pdo_expect_u32(1, TPDO2, 4);
}

static void a_sync_of_the_wrong_length_is_an_error_and_no_sync(void **state)
{
    static const uint8_t emcy[] = {0x40, 0x82, 0x11, 0, 0, 0, 0, 0};
    static const uint8_t over[] = {0, 0, 0, 0, 0, 0, 0, 0};

    (void)state;
    pdo_only_tpdo2(1);
    pdo_sync_counted(1);
    pdo_sync_counted(2);
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect(0, EMCY, emcy, sizeof emcy);
    assert_int_equal(pdo_rig.node.counters.malformed, 2);
    pdo_sync();
    assert_int_equal(pdo_rig.count, 3);
    pdo_expect_u32(1, TPDO2, 0x01020304);
    pdo_expect(2, EMCY, over, sizeof over);
}

/* The host hands a SYNC over after it has stepped the node to a later moment. */
static void late_sync(uint32_t late_us)
{
    const struct dg_can_frame frame = {.id = 0x80};
    dg_ns arrived = pdo_rig.now;

    pdo_rig.now += DG_US(late_us);
    (void)dg_co_step(&pdo_rig.node, pdo_rig.now);
    (void)dg_co_rx(&pdo_rig.node, arrived, &frame);
}

static void a_synchronous_tpdo_is_given_up_after_the_window(void **state)
{
    (void)state;
    pdo_put_ok(0x1007, 0, 500, 4);
    pdo_only_tpdo2(2);
    pdo_sync();
    late_sync(501);
    assert_int_equal(pdo_rig.count, 0);
    assert_int_equal(pdo_rig.node.counters.late_sync, 1);
    pdo_sync(); /* the phase goes on */
    late_sync(500);
    assert_int_equal(pdo_rig.count, 1);
    assert_int_equal(pdo_rig.node.counters.late_sync, 1);
}

static void an_event_outlives_a_missed_window(void **state)
{
    (void)state;
    pdo_put_ok(0x1007, 0, 500, 4);
    pdo_only_tpdo2(0);
    late_sync(501); /* that of entering Operational */
    assert_int_equal(pdo_rig.count, 0);
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
}

static void without_a_window_no_sync_is_late(void **state)
{
    (void)state;
    pdo_only_tpdo2(1);
    late_sync(1000000);
    assert_int_equal(pdo_rig.count, 1);
    assert_int_equal(pdo_rig.node.counters.late_sync, 0);
}

/* ------------------------------------------------------------ RTR */

static void every_type_answers_a_remote_frame_at_once(void **state)
{
    static const uint8_t types[] = {0, 1, 2, 240, 252, 253, 254, 255};

    (void)state;
    pdo_only_tpdo2(1);
    for (uint8_t i = 0; i < sizeof types; i++) {
        pdo_put_type(1, types[i]);
        pdo_rig.live = 0x100u + i;
        pdo_forget();
        pdo_request(TPDO2);
        assert_int_equal(pdo_rig.count, 1);
        assert_int_equal(pdo_rig.samples, 1);
        pdo_expect_u32(0, TPDO2, 0x100u + i);
    }
    pdo_request(TPDO1); /* not valid */
    assert_int_equal(pdo_rig.count, 1);
}

static void bit_30_forbids_remote_frames(void **state)
{
    (void)state;
    pdo_only_tpdo2(253);
    pdo_put_ok(0x1801, 1, NO_RTR | TPDO2, 4); /* bit 30 may change while valid */
    pdo_request(TPDO2);
    assert_int_equal(pdo_rig.count, 0);
    assert_int_equal(pdo_get(0x1801, 1), NO_RTR | TPDO2);
    pdo_put_ok(0x1801, 1, TPDO2, 4);
    pdo_request(TPDO2);
    assert_int_equal(pdo_rig.count, 1);
}

static void type_252_is_sampled_at_sync(void **state)
{
    (void)state;
    pdo_only_tpdo2(252);
    pdo_rig.live = 1;
    pdo_request(TPDO2); /* no SYNC yet */
    pdo_rig.live = 2;
    pdo_request(TPDO2);
    pdo_sync();
    pdo_rig.live = 3;
    pdo_run_ms(5);
    pdo_request(TPDO2);
    pdo_request(TPDO2);
    pdo_sync();
    pdo_request(TPDO2);
    pdo_put_type(1, 252); /* forgets the sample */
    pdo_rig.live = 4;
    pdo_request(TPDO2);
    assert_int_equal(pdo_rig.count, 6);
    pdo_expect_u32(0, TPDO2, 1);
    pdo_expect_u32(1, TPDO2, 2);
    pdo_expect_u32(2, TPDO2, 2);
    pdo_expect_u32(3, TPDO2, 2);
    pdo_expect_u32(4, TPDO2, 3);
    pdo_expect_u32(5, TPDO2, 4);
}

static void type_253_is_sampled_at_the_request(void **state)
{
    (void)state;
    pdo_only_tpdo2(253);
    pdo_sync();
    pdo_rig.live = 9;
    pdo_request(TPDO2);
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect_u32(0, TPDO2, 9);
}

/* ------------------------------------------------------------ samples */

static void one_sample_serves_all_tpdos_of_a_moment(void **state)
{
    (void)state;
    pdo_nmt(START);
    assert_int_equal(pdo_rig.count, 3);
    assert_int_equal(pdo_rig.samples, 1);
    pdo_put_type(0, 1);
    pdo_put_type(2, 1);
    pdo_forget();
    pdo_sync();
    assert_int_equal(pdo_rig.count, 3);
    assert_int_equal(pdo_rig.samples, 1);
    pdo_forget();
    pdo_request(TPDO4);
    assert_int_equal(pdo_rig.samples, 1);
    pdo_run_ms(100); /* time alone takes none */
    assert_int_equal(pdo_rig.samples, 1);
}

static void a_sample_that_ends_operational_sends_nothing(void **state)
{
    (void)state;
    pdo_put_ok(0x1029, 2, 0, 1);
    pdo_put_type(1, 1);
    pdo_nmt(START);
    pdo_forget();
    pdo_rig.fault = true;
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
    assert_int_equal(pdo_rig.sent[0].frame.id, EMCY);
    assert_int_equal(pdo_rig.node.state, DG_CO_PRE_OPERATIONAL);
}

static void a_request_whose_sample_ends_operational_is_not_answered(void **state)
{
    (void)state;
    pdo_put_ok(0x1029, 2, 0, 1);
    pdo_only_tpdo2(253);
    pdo_rig.fault = true;
    pdo_request(TPDO2);
    assert_int_equal(pdo_rig.count, 1);
    assert_int_equal(pdo_rig.sent[0].frame.id, EMCY);
}

/* ------------------------------------------------------------ events */

static void the_event_timer_sends_with_its_period(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(10, 0);
    entered = pdo_rig.now;
    for (uint32_t i = 1; i <= 3; i++) {
        pdo_rig.live = i;
        pdo_run_until(entered + DG_MS(10 * i));
    }
    pdo_run_ms(9);
    assert_int_equal(pdo_rig.count, 3);
    for (uint32_t i = 0; i < 3; i++) {
        pdo_expect_at_ms(i, entered, 10 * (i + 1));
        pdo_expect_u32(i, TPDO1, i + 1);
    }
}

static void a_late_host_keeps_the_period(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(10, 0);
    entered = pdo_rig.now;
    pdo_rig.now = entered + DG_MS(13);
    assert_int_equal(dg_co_step(&pdo_rig.node, pdo_rig.now), entered + DG_MS(20));
    pdo_rig.now = entered + DG_MS(45); /* more than a period is not caught up */
    assert_int_equal(dg_co_step(&pdo_rig.node, pdo_rig.now), entered + DG_MS(55));
    assert_int_equal(pdo_rig.count, 2);
}

static void the_event_timer_restarts_from_a_write(void **state)
{
    dg_ns written;

    (void)state;
    pdo_only_tpdo1(10, 0);
    pdo_run_ms(7);
    pdo_put_ok(0x1800, 5, 20, 2);
    written = pdo_rig.now;
    pdo_run_ms(45);
    assert_int_equal(pdo_rig.count, 2);
    pdo_expect_at_ms(0, written, 20);
    pdo_expect_at_ms(1, written, 40);
    pdo_put_ok(0x1800, 5, 0, 2);
    pdo_run_ms(1000);
    assert_int_equal(pdo_rig.count, 2);
}

static void an_event_whose_sample_ends_operational_sends_nothing(void **state)
{
    (void)state;
    pdo_put_ok(0x1029, 2, 0, 1);
    pdo_only_tpdo1(10, 0);
    pdo_rig.fault = true;
    pdo_run_ms(100);
    assert_int_equal(pdo_rig.count, 1);
    assert_int_equal(pdo_rig.sent[0].frame.id, EMCY);
    assert_int_equal(pdo_rig.node.state, DG_CO_PRE_OPERATIONAL);
}

static void another_object_can_write_the_event_timer(void **state)
{
    dg_ns written;

    (void)state;
    pdo_only_tpdo1(0, 0);
    pdo_run_ms(7);
    pdo_put_ok(0x6200, 0, 20, 2);
    written = pdo_rig.now;
    assert_int_equal(pdo_get(0x1800, 5), 20);
    pdo_run_ms(45);
    assert_int_equal(pdo_rig.count, 2);
    pdo_expect_at_ms(0, written, 20);
    pdo_put_ok(0x1800, 5, 30, 2);
    assert_int_equal(pdo_get(0x6200, 0), 30);
}

static void a_transmission_restarts_the_event_timer(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(10, 0);
    entered = pdo_rig.now;
    pdo_run_ms(6);
    pdo_request(TPDO1);
    pdo_run_ms(8);
    pdo_change(7);
    pdo_run_ms(10);
    assert_int_equal(pdo_rig.count, 3);
    pdo_expect_at_ms(0, entered, 6);
    pdo_expect_at_ms(1, entered, 14);
    pdo_expect_at_ms(2, entered, 24);
}

static void the_event_timer_is_for_types_254_and_255(void **state)
{
    static const uint8_t types[] = {0, 1, 252, 253};

    (void)state;
    pdo_only_tpdo1(10, 0);
    for (uint8_t i = 0; i < sizeof types; i++) {
        pdo_put_type(0, types[i]);
        pdo_run_ms(50);
        assert_int_equal(pdo_rig.count, 0);
    }
    pdo_put_type(0, 254); /* restarts from this write */
    pdo_run_ms(9);
    assert_int_equal(pdo_rig.count, 0);
    pdo_run_ms(1);
    assert_int_equal(pdo_rig.count, 1);
}

/* The speed is read at 1, 2, ... here, the position stays: objects without DG_CO_EVENT, 2004h:1 and
 * 6030h:1, neither send nor keep from sending. */
static void only_objects_that_are_events_send(void **state)
{
    static const uint8_t first[] = {0x85, 0xFF, 0x04, 0xFE};
    static const uint8_t second[] = {0x85, 0xFF, 0x05, 0xFE};

    (void)state;
    pdo_disable(0);
    pdo_put_ok(0x1A00, 0, 0, 1);
    pdo_put_ok(0x1A00, 1, 0x60300110, 4);
    pdo_put_ok(0x1A00, 2, 0x20010008, 4);
    pdo_put_ok(0x1A00, 3, 0x20040108, 4);
    pdo_put_ok(0x1A00, 0, 3, 1);
    pdo_enable(0);
    pdo_nmt(START);
    pdo_expect(0, TPDO1, first, sizeof first);
    pdo_forget();
    pdo_rig.node.tpdo[0].last[0] ^= 1; /* as if another speed had been sent */
    pdo_rig.node.tpdo[0].last[3] ^= 1;
    pdo_rig.node.tpdo[2].last[0] ^= 1;
    pdo_change(0x01020304);
    assert_int_equal(pdo_rig.count, 0);
    pdo_change(0x01020305);
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect(0, TPDO1, second, sizeof second);
    pdo_disable(2);
    pdo_enable(2);
    pdo_change(0x01020305); /* nor does a first value */
    assert_int_equal(pdo_rig.count, 1);
}

static void only_a_change_of_a_mapped_value_is_sent(void **state)
{
    (void)state;
    pdo_nmt(START);
    pdo_forget();
    pdo_change(5);
    assert_int_equal(pdo_rig.count, 1); /* speed and raw position have not changed */
    pdo_expect_u32(0, TPDO1, 5);
    pdo_change(5);
    assert_int_equal(pdo_rig.count, 1);
    pdo_change(6);
    assert_int_equal(pdo_rig.count, 2);
    assert_int_equal(pdo_rig.samples, 3);
}

static void an_event_within_the_inhibit_time_is_deferred(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(0, 20); /* entering Operational was a transmission */
    entered = pdo_rig.now;
    pdo_run_ms(5);
    pdo_change(1);
    pdo_run_ms(5);
    pdo_change(2);
    pdo_rig.live = 3;
    pdo_run_ms(9);
    assert_int_equal(pdo_rig.count, 0);
    pdo_run_ms(1);
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect_at_ms(0, entered, 20);
    pdo_expect_u32(0, TPDO1, 3);
    pdo_run_ms(25);
    assert_int_equal(pdo_rig.count, 1);
    pdo_change(4); /* the inhibit time is over */
    assert_int_equal(pdo_rig.count, 2);
    pdo_expect_at_ms(1, entered, 45);
}

static void the_host_is_told_when_a_deferred_event_is_due(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(0, 20);
    entered = pdo_rig.now;
    pdo_run_ms(5);
    pdo_rig.live = 1;
    pdo_rig.event = true;
    assert_int_equal(dg_co_step(&pdo_rig.node, pdo_rig.now), entered + DG_MS(20));
}

static void the_inhibit_time_bounds_the_event_timer(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(5, 12);
    entered = pdo_rig.now;
    pdo_run_ms(40);
    assert_int_equal(pdo_rig.count, 3);
    pdo_expect_at_ms(0, entered, 12);
    pdo_expect_at_ms(1, entered, 24);
    pdo_expect_at_ms(2, entered, 36);
}

static void the_inhibit_time_holds_across_operational(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(0, 20);
    entered = pdo_rig.now;
    pdo_run_ms(5);
    pdo_nmt(PRE_OPERATIONAL);
    pdo_nmt(START);
    assert_int_equal(pdo_rig.count, 0);
    pdo_run_ms(30);
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect_at_ms(0, entered, 20);
}

static void the_inhibit_time_does_not_delay_requests(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(0, 20);
    entered = pdo_rig.now;
    pdo_run_ms(5);
    pdo_change(1);
    pdo_request(TPDO1);
    pdo_run_ms(5);
    pdo_request(TPDO1);
    assert_int_equal(pdo_rig.count, 2);
    pdo_run_ms(20);
    assert_int_equal(pdo_rig.count, 3); /* the event is sent, and when it would have been */
    pdo_expect_at_ms(2, entered, 20);
}

static void the_inhibit_time_does_not_delay_synchronous_tpdos(void **state)
{
    (void)state;
    pdo_only_tpdo1(0, 1000);
    pdo_put_type(0, 1);
    pdo_sync();
    pdo_sync();
    assert_int_equal(pdo_rig.count, 2);
    pdo_put_type(0, 0);
    pdo_change(1);
    pdo_sync();
    pdo_change(2);
    pdo_sync();
    assert_int_equal(pdo_rig.count, 4);
}

static void an_event_waits_across_a_write_of_the_type(void **state)
{
    (void)state;
    pdo_only_tpdo1(0, 20);
    pdo_change(1);
    pdo_put_type(0, 254);
    pdo_run_ms(20);
    assert_int_equal(pdo_rig.count, 1);
    pdo_change(2);
    pdo_put_type(0, 1); /* has no events */
    pdo_put_type(0, 255);
    pdo_run_ms(30);
    assert_int_equal(pdo_rig.count, 1);
}

static void an_event_waits_across_a_write_of_the_cob_id(void **state)
{
    (void)state;
    pdo_only_tpdo1(0, 20);
    pdo_change(1);
    pdo_put_ok(0x1800, 1, NO_RTR | TPDO1, 4);
    assert_int_equal(pdo_rig.count, 0);
    pdo_run_ms(20);
    assert_int_equal(pdo_rig.count, 1);
}

static void a_new_tpdo_is_not_an_event_but_its_first_value_is_a_change(void **state)
{
    (void)state;
    pdo_only_tpdo1(0, 0);
    pdo_disable(0);
    pdo_enable(0);
    pdo_run_ms(10);
    assert_int_equal(pdo_rig.count, 0);
    pdo_change(0);
    assert_int_equal(pdo_rig.count, 1);
    pdo_change(0);
    assert_int_equal(pdo_rig.count, 1);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(entering_operational_sends_the_event_driven_ones, pdo_set_up),
        cmocka_unit_test_setup(two_tpdos_can_swap_their_can_ids, pdo_set_up),
        cmocka_unit_test_setup(nothing_is_sent_outside_operational, pdo_set_up),
        cmocka_unit_test_setup(type_4_fires_at_sync_4_8_12, pdo_set_up),
        cmocka_unit_test_setup(every_cyclic_type_fires_at_its_multiples, pdo_set_up),
        cmocka_unit_test_setup(the_phase_begins_with_operational, pdo_set_up),
        cmocka_unit_test_setup(type_0_waits_for_an_event_and_a_sync, pdo_set_up),
        cmocka_unit_test_setup(a_sync_of_the_wrong_length_is_an_error_and_no_sync, pdo_set_up),
        cmocka_unit_test_setup(a_synchronous_tpdo_is_given_up_after_the_window, pdo_set_up),
        cmocka_unit_test_setup(an_event_outlives_a_missed_window, pdo_set_up),
        cmocka_unit_test_setup(without_a_window_no_sync_is_late, pdo_set_up),
        cmocka_unit_test_setup(every_type_answers_a_remote_frame_at_once, pdo_set_up),
        cmocka_unit_test_setup(bit_30_forbids_remote_frames, pdo_set_up),
        cmocka_unit_test_setup(type_252_is_sampled_at_sync, pdo_set_up),
        cmocka_unit_test_setup(type_253_is_sampled_at_the_request, pdo_set_up),
        cmocka_unit_test_setup(one_sample_serves_all_tpdos_of_a_moment, pdo_set_up),
        cmocka_unit_test_setup(a_sample_that_ends_operational_sends_nothing, pdo_set_up),
        cmocka_unit_test_setup(the_event_timer_sends_with_its_period, pdo_set_up),
        cmocka_unit_test_setup(a_late_host_keeps_the_period, pdo_set_up),
        cmocka_unit_test_setup(the_event_timer_restarts_from_a_write, pdo_set_up),
        cmocka_unit_test_setup(another_object_can_write_the_event_timer, pdo_set_up),
        cmocka_unit_test_setup(a_transmission_restarts_the_event_timer, pdo_set_up),
        cmocka_unit_test_setup(the_event_timer_is_for_types_254_and_255, pdo_set_up),
        cmocka_unit_test_setup(only_a_change_of_a_mapped_value_is_sent, pdo_set_up),
        cmocka_unit_test_setup(only_objects_that_are_events_send, pdo_set_up),
        cmocka_unit_test_setup(an_event_whose_sample_ends_operational_sends_nothing, pdo_set_up),
        cmocka_unit_test_setup(an_event_within_the_inhibit_time_is_deferred, pdo_set_up),
        cmocka_unit_test_setup(the_host_is_told_when_a_deferred_event_is_due, pdo_set_up),
        cmocka_unit_test_setup(the_inhibit_time_bounds_the_event_timer, pdo_set_up),
        cmocka_unit_test_setup(the_inhibit_time_holds_across_operational, pdo_set_up),
        cmocka_unit_test_setup(the_inhibit_time_does_not_delay_requests, pdo_set_up),
        cmocka_unit_test_setup(the_inhibit_time_does_not_delay_synchronous_tpdos, pdo_set_up),
        cmocka_unit_test_setup(an_event_waits_across_a_write_of_the_type, pdo_set_up),
        cmocka_unit_test_setup(an_event_waits_across_a_write_of_the_cob_id, pdo_set_up),
        cmocka_unit_test_setup(a_request_whose_sample_ends_operational_is_not_answered, pdo_set_up),
        cmocka_unit_test_setup(a_new_tpdo_is_not_an_event_but_its_first_value_is_a_change,
                               pdo_set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

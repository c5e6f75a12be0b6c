/* SPDX-License-Identifier: MIT */
/*
 * The line of a clocked encoder at its other end: what the supply does to it, and levels that last
 * no time at all.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "host_rig.h"

static void expect_edge(struct dg_host *self, uint64_t at, uint8_t level)
{
    struct dg_host_event event;

    assert_int_equal(dg_host_receive(self, &event), 1);
    assert_int_equal(event.kind, DG_HOST_EDGE);
    assert_int_equal(event.at, at);
    assert_int_equal(event.length, 1);
    assert_int_equal(event.data[0], level);
}

static void expect_nothing(struct dg_host *self)
{
    struct dg_host_event event;

    assert_int_equal(dg_host_receive(self, &event), 0);
}

/* SSI without supply drives nothing, which is low; ready after 100 ms, it rests high. */
static void the_line_of_ssi_goes_with_the_power(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-25");
    const uint64_t on = READY + 10 * MS;

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
    expect_edge(self, READY, 0);
    assert_int_equal(dg_host_power(self, on, true), DG_HOST_OK);
    expect_nothing(self);
    assert_int_equal(dg_host_next(self), on + 100 * MS);
    (void)dg_host_step(self, on + 200 * MS);
    expect_edge(self, on + 100 * MS, 1);
    expect_nothing(self);
}

/* One that needs no time is there with the call that switches it on. */
static void an_ssi_without_initialisation_is_there_at_once(void **state)
{
    struct dg_host *self = host_rig_make(&host_rig_here, "ssi-25");

    (void)state;
    assert_int_equal(dg_host_set(self, "init_ms", "0"), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    host_rig_drain(self);
    assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
    expect_edge(self, READY, 0);
    assert_int_equal(dg_host_power(self, READY + MS, true), DG_HOST_OK);
    expect_edge(self, READY + MS, 1);
    expect_nothing(self);
}

/* SLO is low until the first pulse of MA, which nobody sends here; without power it is high. */
static void slo_goes_with_the_power(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");

    (void)state;
    host_rig_drain(self);
    assert_int_equal(dg_host_power(self, READY, false), DG_HOST_OK);
    expect_edge(self, READY, 1);
    assert_int_equal(dg_host_power(self, READY + MS, true), DG_HOST_OK);
    expect_edge(self, READY + MS, 0);
    assert_int_equal(dg_host_power(self, READY + 2 * MS, false), DG_HOST_OK);
    expect_edge(self, READY + 2 * MS, 1);
    expect_nothing(self);
}

/* 3.25 turns are 0100 0000 0000 0 of 13 bits, 0110 in Gray code: low, high, and low again behind
   the fourth clock, all at one moment, and each is told. */
static void a_level_may_last_no_time(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "ssi-13");
    struct dg_host_event edge = {.at = READY, .kind = DG_HOST_EDGE, .length = 1};

    (void)state;
    host_rig_drain(self);
    for (unsigned i = 0; i < 8; i++) {
        edge.data[0] = i % 2u;
        assert_int_equal(dg_host_send(self, &edge), DG_HOST_OK);
    }
    (void)dg_host_step(self, READY);
    expect_edge(self, READY, 0);
    expect_edge(self, READY, 1);
    expect_edge(self, READY, 0);
    expect_nothing(self);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_line_of_ssi_goes_with_the_power),
        cmocka_unit_test(an_ssi_without_initialisation_is_there_at_once),
        cmocka_unit_test(slo_goes_with_the_power),
        cmocka_unit_test(a_level_may_last_no_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The hint: SL stays zero before the first pulse of MA (BiSS C protocol description Rev C6, 'Bus
 * reset', page 5), and somebody has waited for long.
 */
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"
#include "drehgeber/host.h"

#define HINT DG_MS(100)
#define SOFT_RESET 3u

static struct biss_rig rig;
static dg_ns due;

static void begin(struct dg_biss_model model, uint8_t count)
{
    assert_int_equal(biss_rig_init(&rig, &model, count), DG_OK);
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
}

static struct dg_biss_model usual(void)
{
    return *dg_biss_model_of(&dg_s3684_biss);
}

static bool hints(dg_ns now)
{
    return dg_biss_hint(&rig.slave[0], now, &due);
}

/* The time begins when it is asked for first. */
static void it_comes_once_and_not_before_its_time(void **state)
{
    (void)state;
    begin(usual(), 1);
    assert_false(hints(rig.now));
    assert_true(due == rig.now + HINT);
    assert_false(hints(rig.now + HINT - 1u));
    assert_true(due == rig.now + HINT);
    assert_true(hints(rig.now + HINT));
    assert_true(due == DG_NEVER);
    assert_false(hints(rig.now + 2u * HINT));
    assert_false(hints(DG_NEVER));
    assert_true(due == DG_NEVER);
}

static void a_pulse_is_what_is_waited_for(void **state)
{
    (void)state;
    begin(usual(), 1);
    assert_false(hints(rig.now));
    /* MA that only falls is no pulse, nor is its return behind a timeout. */
    (void)biss_rig_edge(&rig, false);
    assert_false(hints(rig.now));
    assert_true(due != DG_NEVER);
    rig.now += DG_US(20);
    (void)dg_biss_step(&rig.slave[0], rig.now);
    (void)biss_rig_edge(&rig, true);
    assert_false(hints(rig.now));
    assert_true(due != DG_NEVER);
    (void)biss_rig_frame(&rig, false);
    assert_false(hints(rig.now + HINT));
    assert_false(hints(DG_NEVER));
    assert_true(due == DG_NEVER);
}

static void each_start_arms_it(void **state)
{
    (void)state;
    begin(usual(), 1);
    assert_false(hints(rig.now));
    assert_true(hints(rig.now + HINT));
    assert_int_equal(biss_rig_power_on(&rig), DG_OK);
    assert_false(hints(rig.now));
    assert_true(hints(rig.now + HINT));
    /* Whoever fetches the stop bit has clocked again behind the reset. */
    assert_int_equal(biss_rig_put(&rig, 0x60, SOFT_RESET), 1);
    assert_false(hints(rig.now) || rig.slave[0].line.hinted);
    assert_true(due == DG_NEVER);
}

static void whoever_does_not_want_it_hears_nothing(void **state)
{
    struct dg_biss_model never = usual();
    struct dg_biss_model high = usual();

    (void)state;
    never.hint = 0;
    high.sl_low_at_start = false;
    begin(never, 1);
    assert_false(hints(rig.now) || hints(rig.now + HINT) || hints(DG_NEVER));
    begin(high, 1);
    assert_false(hints(rig.now) || hints(rig.now + HINT) || hints(DG_NEVER));
    begin(usual(), 1);
    dg_biss_power_off(&rig.slave[0]);
    assert_false(hints(rig.now) || hints(rig.now + HINT) || hints(DG_NEVER));
}

static void a_chain_has_one(void **state)
{
    struct dg_biss_model soon = usual();

    (void)state;
    begin(usual(), 3);
    struct dg_biss_chain chain = {{&rig.slave[0], &rig.slave[1], &rig.slave[2]}, .count = 3};
    assert_false(dg_biss_chain_hint(&chain, rig.now, &due));
    assert_true(due == rig.now + HINT);
    assert_true(dg_biss_chain_hint(&chain, rig.now + HINT, &due));
    assert_false(dg_biss_chain_hint(&chain, rig.now + 2u * HINT, &due));
    /* The shortest time counts. */
    begin(usual(), 3);
    soon.hint = DG_MS(1);
    rig.slave[2].setup.model = &soon;
    assert_false(dg_biss_chain_hint(&chain, rig.now, &due));
    assert_true(due == rig.now + DG_MS(1));
    assert_true(dg_biss_chain_hint(&chain, rig.now + DG_MS(1), &due));
    assert_true(due == DG_NEVER);
    assert_false(dg_biss_chain_hint(&chain, rig.now + HINT, &due));
}

/* ------------------------------------------------------------ behind a handle */

static alignas(DG_HOST_ALIGN) unsigned char memory[2][32768];

static struct dg_host *make(unsigned place, const char *model)
{
    struct dg_host *self = dg_host_make(memory[place], sizeof memory[place], model);

    assert_non_null(self);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    return self;
}

static void a_handle_has_the_words(void **state)
{
    struct dg_host *self = dg_host_make(memory[0], sizeof memory[0], "s3684-biss");
    char text[16];

    (void)state;
    assert_true(dg_host_get(self, "hint_us", text, sizeof text) >= 0);
    assert_string_equal(text, "100000");
    assert_int_equal(dg_host_set(self, "hint_us", "250"), DG_HOST_OK);
    assert_null(dg_host_hint(self, DG_S(1), &due)); /* never on */
    assert_int_equal(dg_host_power(self, DG_S(1), true), DG_HOST_OK);
    assert_null(dg_host_hint(self, DG_S(1), &due));
    assert_true(due == DG_S(1) + DG_US(250));
    assert_string_equal(dg_host_hint(self, due, &due),
                        "SLO is low until the first MA pulse (BiSS C6, Bus reset); a master that "
                        "waits for SLO = 1 hangs here: send a pulse, or set sl_low_at_start=0");
    assert_null(dg_host_hint(self, DG_HOST_NEVER, &due));
    self = make(0, "ssi-25");
    assert_null(dg_host_hint(self, DG_HOST_NEVER, &due));
    assert_true(due == DG_HOST_NEVER);
}

/* The last one speaks for a chain; one whose neighbour does not wait speaks for itself. */
static void the_last_handle_of_a_chain_speaks(void **state)
{
    struct dg_host *near = make(0, "s3684-biss");
    struct dg_host *far = make(1, "s3684-biss");

    (void)state;
    (void)dg_host_behind(near, 0, false);
    assert_null(dg_host_hint(near, 0, &due));
    assert_true(due == DG_HOST_NEVER);
    assert_null(dg_host_hint(near, DG_HOST_NEVER, &due));
    assert_null(dg_host_hint(far, 0, &due));
    assert_true(due == HINT);
    assert_non_null(dg_host_hint(far, HINT, &due));
    (void)dg_host_behind(near, HINT, true);
    assert_non_null(dg_host_hint(near, DG_HOST_NEVER, &due));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_comes_once_and_not_before_its_time),
        cmocka_unit_test(a_pulse_is_what_is_waited_for),
        cmocka_unit_test(each_start_arms_it),
        cmocka_unit_test(whoever_does_not_want_it_hears_nothing),
        cmocka_unit_test(a_chain_has_one),
        cmocka_unit_test(a_handle_has_the_words),
        cmocka_unit_test(the_last_handle_of_a_chain_speaks),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

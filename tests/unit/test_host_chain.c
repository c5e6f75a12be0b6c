/* SPDX-License-Identifier: MIT */
/*
 * Handles on a line of several, and what the latest frame has.
 */
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/host.h"

#define PERIOD 1000u

static alignas(DG_HOST_ALIGN) unsigned char memory[2][32768];

static struct dg_host *make(unsigned place, const char *model, int64_t angle)
{
    struct dg_host *self = dg_host_make(memory[place], sizeof memory[place], model);

    assert_non_null(self);
    (void)dg_host_set(self, "init_ms", "0");
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    dg_host_shaft(self, 0, angle, 0);
    return self;
}

/* A clock for both. @return level of the near one behind the rising edge */
static bool clock_both(struct dg_host *near, struct dg_host *far, uint64_t *now)
{
    for (unsigned high = 0; high < 2; high++) {
        *now += PERIOD / 2u;
        (void)dg_host_clock(near, *now, high != 0);
        (void)dg_host_behind(near, *now, dg_host_clock(far, *now, high != 0) > 0);
    }
    return dg_host_behind(near, *now, dg_host_clock(far, *now, true) > 0) > 0;
}

static uint64_t take_frame(struct dg_host *near, struct dg_host *far, uint64_t *now, unsigned n)
{
    uint64_t bits = 0;

    while (n-- > 0) {
        bits = bits << 1 | clock_both(near, far, now);
    }
    return bits;
}

static void a_chain_of_handles_is_a_chain(void **state)
{
    struct dg_host *near = make(0, "s3674-biss", INT64_C(1) << 30);
    struct dg_host *far = make(1, "s3684-biss", INT64_C(5) << 31);
    const struct dg_biss_model *models[] = {dg_biss_model_of(&dg_s3674_biss),
                                            dg_biss_model_of(&dg_s3684_biss)};
    struct dg_biss_data data;
    uint64_t counts;
    uint64_t at;
    uint64_t now = 1000;

    (void)state;
    assert_int_equal(dg_host_latched(near, &at, &counts), DG_HOST_ERR_STATE);
    assert_true(clock_both(near, far, &now));
    assert_false(clock_both(near, far, &now));
    while (!clock_both(near, far, &now)) {
        assert_true(now < 100000);
    }
    (void)take_frame(near, far, &now, 1); /* CDS */
    dg_biss_frame_decode(models[0], take_frame(near, far, &now, dg_biss_frame_bits(models[0])),
                         &data);
    assert_true(data.crc_ok);
    assert_int_equal(dg_host_latched(near, &at, &counts), DG_HOST_OK);
    assert_int_equal(at, 2000);
    assert_int_equal(data.position, counts);
    assert_int_equal(data.singleturn, 1u << (models[0]->singleturn_bits - 2u));
    dg_biss_frame_decode(models[1], take_frame(near, far, &now, dg_biss_frame_bits(models[1])),
                         &data);
    assert_true(data.crc_ok);
    assert_int_equal(dg_host_latched(far, &at, &counts), DG_HOST_OK);
    assert_int_equal(data.position, counts);
    assert_int_equal(data.multiturn, 2);
}

/* At rest the line behind goes through. */
static void a_line_behind_is_an_edge_of_its_own(void **state)
{
    struct dg_host *far = make(1, "s3674-biss", 0);
    struct dg_host *near = make(0, "s3674-biss", 0);
    struct dg_host_event event;
    uint64_t now = 1000;

    (void)state;
    (void)take_frame(near, far, &now, 100);
    assert_int_equal(dg_host_step(near, now + 20000), DG_HOST_NEVER);
    while (dg_host_receive(near, &event) > 0) {
    }
    for (uint8_t high = 1; high < 2; high--) {
        now += 21000;
        assert_int_equal(dg_host_behind(near, now, high != 0), high);
        assert_int_equal(dg_host_receive(near, &event), 1);
        assert_int_equal(event.at, now);
        assert_int_equal(event.data[0], high);
    }
    assert_int_equal(dg_host_receive(near, &event), 0);
}

static void other_wires_have_none(void **state)
{
    struct dg_host *self = make(0, "ssi-25", INT64_C(1) << 30);
    struct dg_host_frame frame;
    uint64_t counts;
    uint64_t at;

    (void)state;
    assert_int_equal(dg_host_behind(self, 0, true), DG_HOST_ERR_WIRE);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_frame(self, 100000, &frame), DG_HOST_OK);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_OK);
    assert_int_equal(at, 100000);
    assert_int_equal(counts, frame.position);
    assert_int_equal(dg_host_clock(self, 300000, false), 1);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_OK);
    assert_int_equal(at, 300000);
    self = make(0, "f3668", 0);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_ERR_WIRE);
    self = dg_host_make(memory[0], sizeof memory[0], "s3674-biss");
    assert_int_equal(dg_host_behind(self, 0, true), DG_HOST_ERR_STATE);
    assert_int_equal(dg_host_latched(self, &at, &counts), DG_HOST_ERR_STATE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_chain_of_handles_is_a_chain),
        cmocka_unit_test(a_line_behind_is_an_edge_of_its_own),
        cmocka_unit_test(other_wires_have_none),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

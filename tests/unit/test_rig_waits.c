/* SPDX-License-Identifier: MIT */
/* Many encoders of a rig wait for the end of a fault: each ends at its moment, and those that do
   not wait are not looked at. */
#include "drehgeber/control.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/instruments.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "hf_rig.h"

#define COUNT 200u
#define ROUNDS 4000u

static struct {
    struct hf_rig device; /* all share it: faults bend worlds */
    struct dg_world worlds[COUNT];
    struct dg_encoder encoder[COUNT];
    struct dg_encoder *encoders[COUNT];
    struct dg_rig rig;
    unsigned changes;
    unsigned looks;
    uint32_t random;
} all;

static uint32_t pick(uint32_t n)
{
    all.random = all.random * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)all.random * n >> 32);
}

static void changed(struct dg_rig *rig, struct dg_encoder *encoder, dg_ns now)
{
    (void)rig;
    (void)now;
    assert_true(all.looks > all.changes); /* it was what it had come to, before */
    assert_non_null(encoder);
    all.changes++;
}

static void look_at_encoder(struct dg_rig *rig, struct dg_encoder *encoder, dg_ns now)
{
    (void)rig;
    (void)now;
    assert_non_null(encoder);
    all.looks++;
}

static int setup(void **state)
{
    static const struct dg_rig_ops ops = {.changed = changed, .look = look_at_encoder};
    const struct dg_device *model = dg_device_find("s3684-rs485");
    (void)state;
    memset(&all, 0, sizeof all);
    assert_int_equal(hf_rig_init(&all.device, dg_hf_model_of(model)), DG_OK);
    for (size_t i = 0; i < COUNT; i++) {
        dg_world_init(&all.worlds[i]);
        all.encoder[i] = (struct dg_encoder){
            .name = "e",
            .model = model,
            .instrument = dg_instrument_of(model->stack),
            .device = &all.device.device,
            .world = &all.worlds[i],
        };
    }
    /* No pointer to any: whoever walks the encoders ends here. */
    all.rig = (struct dg_rig){.encoders = all.encoders, .encoder_count = COUNT, .ops = &ops};
    return 0;
}

static size_t fault_of(const struct dg_encoder *encoder, const char *name)
{
    const struct dg_fault_target target = dg_encoder_target(encoder);
    const int index = dg_fault_find(&target, name);
    assert_true(index >= 0);
    return (size_t)index;
}

static void set(size_t i, dg_ns now, dg_ns duration)
{
    struct dg_encoder *encoder = &all.encoder[i];
    const struct dg_fault_target target = dg_encoder_target(encoder);
    const struct dg_fault_limits limits = {.probability_ppm = 1000000, .duration = duration};
    const size_t fault = fault_of(encoder, "temperature_high");
    assert_int_equal(dg_fault_set(&encoder->faults, &target, fault, now, &limits), DG_OK);
    dg_rig_watch(&all.rig, encoder);
}

static void clear(size_t i)
{
    struct dg_encoder *encoder = &all.encoder[i];
    const struct dg_fault_target target = dg_encoder_target(encoder);
    const size_t fault = fault_of(encoder, "temperature_high");
    assert_int_equal(dg_fault_clear(&encoder->faults, &target, fault), DG_OK);
    dg_rig_watch(&all.rig, encoder);
}

static void nobody_waits(void **state)
{
    (void)state;
    assert_int_equal(dg_rig_step(&all.rig, DG_S(1)), DG_NEVER);
    set(3, DG_S(1), DG_NEVER); /* for good */
    assert_int_equal(dg_rig_step(&all.rig, DG_S(100)), DG_NEVER);
    assert_int_equal(all.changes, 0);
}

static void each_in_its_turn(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT; i++) {
        set(i, 0, DG_S(1 + i * 7 % COUNT)); /* 7 and 200 have no common divisor */
    }
    for (dg_ns second = 1; second <= COUNT; second++) {
        assert_int_equal(dg_rig_step(&all.rig, DG_S(second) - 1), DG_S(second));
        assert_int_equal(all.changes, second - 1);
        (void)dg_rig_step(&all.rig, DG_S(second));
        assert_int_equal(all.changes, second);
    }
    assert_int_equal(dg_rig_step(&all.rig, DG_S(COUNT)), DG_NEVER);
}

/* Sooner, later, not at all: against a walk over all of them. */
static void whatever_is_set_anew(void **state)
{
    dg_ns until[COUNT];
    dg_ns now = 0;
    (void)state;
    for (size_t i = 0; i < COUNT; i++) {
        until[i] = DG_NEVER;
    }
    for (unsigned round = 0; round < ROUNDS; round++) {
        const size_t i = pick(COUNT);
        dg_ns next = DG_NEVER;
        now += pick(50);
        const bool sets = pick(4) != 0;
        until[i] = sets ? now + 1u + pick(5000) : DG_NEVER;
        if (sets) {
            set(i, now, until[i] - now);
        } else {
            clear(i);
        }
        for (size_t k = 0; k < COUNT; k++) {
            until[k] = until[k] <= now ? DG_NEVER : until[k];
            next = dg_earliest(next, until[k]);
        }
        assert_int_equal(dg_rig_step(&all.rig, now), next);
        for (size_t k = 0; k < COUNT; k++) {
            assert_int_equal(all.worlds[k].temperature_mdegc > 100000, until[k] != DG_NEVER);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(nobody_waits, setup),
        cmocka_unit_test_setup(each_in_its_turn, setup),
        cmocka_unit_test_setup(whatever_is_set_anew, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

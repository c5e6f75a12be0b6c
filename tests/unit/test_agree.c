/* SPDX-License-Identifier: MIT */
/* All four kinds of encoders on one turning shaft, latched at the same moment, tell one angle. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "co_rig.h"
#include "drehgeber/devices.h"
#include "drehgeber/shaft.h"
#include "hf_rig.h"
#include "ib_rig.h"

#define TURNS 4096
#define HF_STEPS 65536
#define BISS_STEPS (1 << 21)
#define CO_STEPS 65536
#define IB_STEPS 4096
#define ROUNDS 200

struct fixture {
    struct dg_shaft shaft;
    struct hf_rig hf;
    struct biss_rig biss;
    struct co_rig co;
    struct ib_rig ib[3]; /* K1, K2, K3 */
};

static void sit_on(struct dg_world *world, struct dg_shaft *shaft)
{
    world->angle = dg_shaft_angle;
    world->angle_ctx = shaft;
}

static void start_encoders(struct fixture *self)
{
    static const char *const rings[] = {"ocd-ib-k1", "ocd-ib-k2", "ocd-ib-k3"};

    memset(self, 0, sizeof *self);
    dg_shaft_init(&self->shaft);
    assert_int_equal(hf_rig_init(&self->hf, dg_hf_model_of(dg_device_find("s3684-rs485"))), DG_OK);
    assert_int_equal(biss_rig_init(&self->biss, dg_biss_model_of(dg_device_find("s3684-biss")), 1),
                     DG_OK);
    co_rig_start(&self->co);
    sit_on(&self->hf.world, &self->shaft);
    sit_on(&self->biss.world, &self->shaft);
    sit_on(&self->co.world, &self->shaft);
    for (unsigned i = 0; i < 3; i++) {
        assert_int_equal(ib_rig_init(&self->ib[i], dg_ib_model_of(dg_device_find(rings[i]))),
                         DG_OK);
        sit_on(&self->ib[i].world, &self->shaft);
        assert_int_equal(ib_rig_power_on(&self->ib[i]), DG_OK);
    }
    assert_int_equal(hf_rig_power_on(&self->hf), DG_OK);
    assert_int_equal(biss_rig_power_on(&self->biss), DG_OK);
    self->hf.now = self->co.now; /* the latest of them; nothing is due */
}

/* 42h; the latch is the reply's first moment. */
static uint32_t ask_hf(struct fixture *self, dg_ns *latch)
{
    assert_int_equal(hf_rig_ask(&self->hf, "42"), 0);
    *latch = self->hf.reply_at;
    const uint8_t *data = &self->hf.reply[2];
    return (uint32_t)data[0] << 24 | (uint32_t)data[1] << 16 | (uint32_t)data[2] << 8 | data[3];
}

/* A frame whose first rising edge is at `latch`. */
static uint64_t ask_biss(struct fixture *self, dg_ns latch)
{
    self->biss.now = latch - 2 * self->biss.half_ns;
    (void)biss_rig_frame(&self->biss, false);
    return self->biss.bits >> 14 & (((uint64_t)1 << 33) - 1); /* nERR, nWARN, LC, CRC behind it */
}

static uint32_t ask_co(struct fixture *self, dg_ns latch)
{
    co_rig_run(&self->co, latch - self->co.now);
    co_rig_forget(&self->co);
    return co_rig_get(&self->co, 0x6004, 0);
}

static uint32_t ask_ib(struct fixture *self, unsigned i, dg_ns latch)
{
    self->ib[i].now = latch - IB_RIG_CYCLE;
    return ib_rig_cycle(&self->ib[i], 0);
}

/* floor(angle * steps) modulo `turns` turns, worked out here. */
static uint64_t counts(dg_angle angle, int64_t steps, int64_t turns)
{
    const int64_t whole = angle >> 32;
    const int64_t part = (int64_t)(((uint64_t)angle & UINT32_MAX) * (uint64_t)steps >> 32);
    const int64_t turn = (whole % turns + turns) % turns;

    return (uint64_t)(turn * steps + part);
}

static void expect_agreement(struct fixture *self)
{
    dg_ns latch;
    const uint32_t hf = ask_hf(self, &latch);
    const dg_angle angle = dg_shaft_angle(&self->shaft, latch);

    assert_int_equal(hf, counts(angle, HF_STEPS, TURNS));
    const uint64_t biss = ask_biss(self, latch);
    assert_int_equal(biss, counts(angle, BISS_STEPS, TURNS));
    assert_int_equal(biss >> 5, hf);
    assert_int_equal(ask_co(self, latch), hf);
    assert_int_equal(ask_ib(self, 0, latch), hf >> 4 & (IB_STEPS - 1));
    assert_int_equal(ask_ib(self, 1, latch), hf >> 4);
    assert_int_equal(ask_ib(self, 2, latch), hf >> 4);
}

static void test_at_rest(void **state)
{
    static const dg_angle angles[] = {0,
                                      1,
                                      -1,
                                      DG_TURN,
                                      -DG_TURN,
                                      DG_TURN / 2,
                                      TURNS * DG_TURN,
                                      TURNS * DG_TURN - 1,
                                      -TURNS * DG_TURN - 1,
                                      12345 * DG_TURN + 987654321,
                                      -98765 * DG_TURN + 4242,
                                      INT64_MAX,
                                      INT64_MIN};
    static struct fixture fixture;

    (void)state;
    start_encoders(&fixture);
    for (unsigned i = 0; i < DG_COUNT(angles); i++) {
        assert_int_equal(dg_shaft_set_position(&fixture.shaft, fixture.hf.now, angles[i]), DG_OK);
        expect_agreement(&fixture);
    }
}

static void test_turning(void **state)
{
    static const int32_t speeds[] = {1, 60000, -60000, 1234567, -9876543, 3999999};
    static struct fixture fixture;

    (void)state;
    start_encoders(&fixture);
    for (unsigned i = 0; i < DG_COUNT(speeds); i++) {
        assert_int_equal(dg_shaft_set_velocity(&fixture.shaft, fixture.hf.now, speeds[i]), DG_OK);
        for (unsigned round = 0; round < ROUNDS; round++) {
            expect_agreement(&fixture);
        }
    }
}

static void test_on_the_way(void **state)
{
    static struct fixture fixture;

    (void)state;
    start_encoders(&fixture);
    assert_int_equal(dg_shaft_set_acceleration(&fixture.shaft, 3000000), DG_OK);
    for (unsigned round = 0; round < ROUNDS; round++) {
        const dg_angle target = (round % 2 == 0 ? 1 : -1) * 5 * DG_TURN;
        if (round % 50 == 0) {
            assert_int_equal(dg_shaft_move(&fixture.shaft, fixture.hf.now, target, 2000000), DG_OK);
        }
        expect_agreement(&fixture);
    }
}

static void test_behind_gears(void **state)
{
    static struct dg_shaft motor;
    static struct fixture fixture;

    (void)state;
    dg_shaft_init(&motor);
    start_encoders(&fixture);
    assert_int_equal(dg_shaft_couple(&fixture.shaft, &motor, -7, 3), DG_OK);
    assert_int_equal(dg_shaft_set_velocity(&motor, fixture.hf.now, 1234567), DG_OK);
    for (unsigned round = 0; round < ROUNDS; round++) {
        expect_agreement(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_at_rest),
        cmocka_unit_test(test_turning),
        cmocka_unit_test(test_on_the_way),
        cmocka_unit_test(test_behind_gears),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

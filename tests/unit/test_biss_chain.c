/* SPDX-License-Identifier: MIT */
/*
 * A chain whose link changes nothing is looked at slave by slave at every edge; one without a link
 * shifts as one register where it can. Both are the same, whatever a master does.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "biss_rig.h"
#include "drehgeber/devices.h"
#include "effort.h"
#include "motion_model.h"

static struct biss_rig rig[2];

static bool wire(void *ctx, uint8_t index, bool slo, bool clocked)
{
    (void)ctx;
    (void)index;
    (void)clocked;
    return slo;
}

static struct dg_biss_chain chain_of(struct biss_rig *self, uint8_t count)
{
    struct dg_biss_chain chain = {.count = count};

    for (uint8_t i = 0; i < count; i++) {
        chain.slave[i] = &self->slave[i];
    }
    return chain;
}

static void check_same(uint8_t count)
{
    for (uint8_t i = 0; i < count; i++) {
        const struct dg_biss *a = &rig[0].slave[i];
        const struct dg_biss *b = &rig[1].slave[i];

        assert_memory_equal(&a->counters, &b->counters, sizeof a->counters);
        assert_memory_equal(&a->line, &b->line, sizeof a->line);
        assert_memory_equal(&a->control, &b->control, sizeof a->control);
        assert_true(a->position == b->position);
    }
}

/* Half a period, mostly; now and then nothing, back, a long while, or the end of time. */
static dg_ns random_moment(dg_ns now, uint64_t *seed)
{
    switch (random_bits(seed) % 400u) {
    case 0:
        return now;
    case 1:
        return now - 30;
    case 2:
        return now + 12000 + random_bits(seed) % 2000u;
    case 3:
        return now + 100000;
    default:
        return now + 50 + random_bits(seed) % 20u;
    }
}

static void start_chain(uint8_t count, uint64_t *seed)
{
    struct dg_biss_model model = *dg_biss_model_of(dg_device_find("s3684-biss"));

    model.busy = random_bits(seed) % 300u;
    model.busy_jitter = random_bits(seed) % 300u;
    model.sl_low_at_start = (random_bits(seed) & 1u) != 0;
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(biss_rig_init(&rig[i], &model, count), DG_OK);
        assert_int_equal(biss_rig_power_on(&rig[i]), DG_OK);
        rig[i].angle_per_us = DG_TURN / 20000;
    }
}

static void run(uint8_t count, uint32_t edges, uint64_t *seed)
{
    start_chain(count, seed);
    struct dg_biss_chain plain = chain_of(&rig[0], count);
    struct dg_biss_chain linked = chain_of(&rig[1], count);
    dg_ns now = rig[0].now;
    bool level = true;

    linked.link = wire;
    for (uint32_t i = 0; i < edges; i++) {
        now = random_moment(now, seed);
        level = random_bits(seed) % 200u == 0 ? level : !level;
        assert_int_equal(dg_biss_chain_ma(&plain, now, level),
                         dg_biss_chain_ma(&linked, now, level));
        check_same(count);
        if (random_bits(seed) % 50u == 0) {
            assert_true(dg_biss_chain_step(&plain, now) == dg_biss_chain_step(&linked, now));
        }
        assert_int_equal(dg_biss_chain_slo(&plain), dg_biss_chain_slo(&linked));
    }
    assert_true(rig[0].slave[count - 1u].counters.frames > edges / 2000u);
}

static void a_chain_shifts_as_its_slaves_do(void **state)
{
    const uint32_t edges = effort(20000, 400000);
    uint64_t seed = 1;

    (void)state;
    for (uint8_t count = 1; count <= 8; count++) {
        run(count, edges, &seed);
    }
}

static void a_chain_without_slaves_is_low(void **state)
{
    struct dg_biss_chain none = {.count = 0};

    (void)state;
    assert_false(dg_biss_chain_ma(&none, 1, true));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_chain_shifts_as_its_slaves_do),
        cmocka_unit_test(a_chain_without_slaves_is_low),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * The SSI models as they are delivered, behind the seam of all protocols.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/devices.h"
#include "ssi_rig.h"

static const struct dg_stack *const stack = &dg_ssi_stack;
static struct dg_world world;
static struct dg_ssi device;

/* 3.25 turns. */
static dg_angle turns(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return 3 * DG_TURN + DG_TURN / 4;
}

static int setup(void **state)
{
    (void)state;
    dg_world_init(&world);
    world.angle = turns;
    return 0;
}

static void models_as_delivered(void **state)
{
    static const struct {
        const struct dg_device *device;
        const char *name;
        const char *resolution;
        bool senses_multiturn;
        uint64_t position;
        uint8_t bits;
        uint64_t word; /* by hand */
    } rows[] = {
        /* 2048: 0100000000000, in Gray 0110000000000 */
        {&dg_ssi_13, "ssi-13", "13 bit Gray, singleturn", false, 2048, 13, 0x0C00},
        /* turn 3 in front of it: 11 0100000000000, in Gray 10 1110000000000 */
        {&dg_ssi_25, "ssi-25", "13 bit Gray, 4096 turns", true, 3 * 8192 + 2048, 25, 0x5C00},
        /* turn 3, 16384, no error; three ones: parity 1 */
        {&dg_ssi_28, "ssi-28", "16 bit, 4096 turns, error bit, parity", true, 3 * 65536 + 16384, 30,
         (uint64_t)0x34000 << 2 | 1u},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct dg_device *row = rows[i].device;
        const struct dg_stack_setup made = {.model = row->model, .world = &world};
        uint64_t word = 0;

        assert_string_equal(row->name, rows[i].name);
        assert_string_equal(row->resolution, rows[i].resolution);
        assert_ptr_equal(row->stack, stack);
        assert_ptr_equal(dg_ssi_model_of(row), row->model);
        assert_int_equal(stack->senses_multiturn(row->model), rows[i].senses_multiturn);
        assert_null(stack->layout(row->model));
        assert_int_equal(stack->format(&made), DG_OK);
        assert_int_equal(stack->init(&device, &made), DG_OK);
        assert_false(stack->powered(&device));
        assert_int_equal(stack->power_on(&device, 0), DG_OK);
        assert_int_equal(stack->step(&device, 0), DG_MS(100));
        assert_int_equal(stack->position(&device, DG_MS(100)), rows[i].position);
        assert_int_equal(dg_ssi_frame(&device, DG_MS(100), &word), rows[i].bits);
        assert_int_equal(word, rows[i].word);
    }
    assert_null(dg_ssi_model_of(NULL));
    assert_null(dg_ssi_model_of(&dg_s3674_biss));
}

static void no_position_without_power_or_while_starting(void **state)
{
    const struct dg_stack_setup made = {.model = dg_ssi_13.model, .world = &world};

    (void)state;
    assert_int_equal(stack->init(&device, &made), DG_OK);
    assert_int_equal(stack->position(&device, DG_S(1)), 0);
    assert_int_equal(stack->power_on(&device, DG_S(1)), DG_OK);
    assert_true(stack->powered(&device));
    assert_int_equal(stack->position(&device, DG_S(1) + DG_MS(100) - 1u), 0);
    assert_int_equal(stack->position(&device, DG_S(1) + DG_MS(100)), 2048); /* not stepped yet */
    assert_true(stack->step(&device, DG_S(2)) == DG_NEVER);
    assert_int_equal(stack->position(&device, DG_S(2)), 2048);
    stack->power_off(&device);
    assert_int_equal(stack->position(&device, DG_S(3)), 0);
    assert_false(stack->powered(&device));
}

static void figures_out_of_range(void **state)
{
    struct dg_ssi_model model = *dg_ssi_model_of(&dg_ssi_13);
    const struct dg_stack_setup made = {.model = &model, .world = &world};

    (void)state;
    model.singleturn_bits = 9;
    assert_int_equal(stack->format(&made), DG_ERR_ARGUMENT);
    assert_int_equal(stack->init(&device, &made), DG_ERR_ARGUMENT);
}

static void pointers_come_and_go(void **state)
{
    const struct dg_stack_setup made = {.model = dg_ssi_25.model, .world = &world};
    static const struct dg_ssi_setup none;

    (void)state;
    assert_int_equal(stack->init(&device, &made), DG_OK);
    assert_int_equal(stack->power_on(&device, 0), DG_OK);
    stack->attach(&device, NULL);
    assert_memory_equal(&device.setup, &none, sizeof none);
    stack->attach(&device, &made);
    assert_ptr_equal(stack->model(&device), dg_ssi_25.model);
    assert_int_equal(stack->position(&device, DG_S(1)), 3 * 8192 + 2048);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(models_as_delivered, setup),
        cmocka_unit_test_setup(no_position_without_power_or_while_starting, setup),
        cmocka_unit_test_setup(figures_out_of_range, setup),
        cmocka_unit_test_setup(pointers_come_and_go, setup),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

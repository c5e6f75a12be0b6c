/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/quantity.h"

#define NAME(id, member, name, ...) name,
#define HEALTHY(id, member, name, header, unit, healthy, ...) healthy,

static const char *const names[] = {DG_QUANTITIES(NAME)};
static const int64_t healthy[] = {DG_QUANTITIES(HEALTHY)};

static void a_new_world_has_the_healthy_values(void **state)
{
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    for (size_t i = 0; i < DG_QUANTITY_COUNT; i++) {
        const struct dg_quantity *row = &dg_quantities[i];
        assert_int_equal(dg_quantity_get(row, &world), healthy[i]);
        assert_true(row->min <= healthy[i] && healthy[i] <= row->max);
        assert_true(row->unit < DG_UNIT_COUNT);
    }
}

/* Each reaches its own member and no other one. */
static void limits_reach_their_place(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_QUANTITY_COUNT; i++) {
        const struct dg_quantity *row = &dg_quantities[i];
        const int64_t limits[] = {row->min, row->max};
        for (size_t j = 0; j < 2; j++) {
            struct dg_world world;
            struct dg_world other;
            dg_world_init(&world);
            other = world;
            dg_quantity_set(row, &world, limits[j]);
            assert_int_equal(dg_quantity_get(row, &world), limits[j]);
            memcpy((uint8_t *)&other + row->offset, (uint8_t *)&world + row->offset, row->size);
            assert_memory_equal(&world, &other, sizeof world);
        }
    }
}

static void rows_are_of_different_things(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_QUANTITY_COUNT; i++) {
        assert_ptr_equal(dg_quantity_at(dg_quantities[i].offset), &dg_quantities[i]);
        for (size_t j = 0; j < i; j++) {
            assert_string_not_equal(names[i], names[j]);
        }
    }
    assert_null(dg_quantity_at(offsetof(struct dg_world, angle)));
}

/* As a member is written, not only as the table reads it. */
static void members_are_what_they_are_called(void **state)
{
    struct dg_world world;

    (void)state;
    dg_world_init(&world);
    world.temperature_mdegc = -40000;
    world.cos_offset_permille = -7;
    world.eeprom_acknowledges = false;
    assert_int_equal(dg_quantity_get(&dg_quantities[DG_QUANTITY_TEMPERATURE], &world), -40000);
    assert_int_equal(dg_quantity_get(&dg_quantities[DG_QUANTITY_COS_OFFSET], &world), -7);
    assert_int_equal(dg_quantity_get(&dg_quantities[DG_QUANTITY_EEPROM], &world), 0);
    assert_true(dg_quantities[DG_QUANTITY_BATTERY].multiturn);
    assert_false(dg_quantities[DG_QUANTITY_SINGLETURN].multiturn);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_new_world_has_the_healthy_values),
        cmocka_unit_test(limits_reach_their_place),
        cmocka_unit_test(rows_are_of_different_things),
        cmocka_unit_test(members_are_what_they_are_called),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

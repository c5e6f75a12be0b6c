/* SPDX-License-Identifier: MIT */
/* Handles that are made for a bus: what they need, and what they take before they have power. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/host_wire.h"
#include "host_rig.h"

static void a_side_is_of_one_protocol(void **state)
{
    (void)state;
    assert_int_equal(dg_host_size_on_bus(&dg_f3668, dg_bus_side_of(&dg_s3684_rs485)), 0);
    assert_int_equal(dg_host_size_with_port(&dg_f3668, dg_bus_side_of(&dg_s3684_rs485)), 0);
    assert_true(dg_host_size_on_bus(&dg_f3668, dg_bus_side_of(&dg_f3668)) > 0);
}

/* With a memory of its own, or with one of the host's; less is none. */
static void too_little_memory_makes_none(void **state)
{
    const struct dg_bus_side *side = dg_bus_side_of(&dg_f3668);
    const size_t least = dg_host_size_with_port(&dg_f3668, side);
    (void)state;
    assert_true(least < dg_host_size_on_bus(&dg_f3668, side));
    assert_null(dg_host_init_on_bus(&host_rig_here, least - 1u, &dg_f3668, side));
    assert_non_null(dg_host_init_on_bus(&host_rig_here, least, &dg_f3668, side));
    assert_int_equal(
        dg_host_memory_size(dg_host_init_on_bus(&host_rig_here, least, &dg_f3668, side)),
        dg_host_memory_size(host_rig_make(&host_rig_there, "f3668")));
}

/* As a bus feeds it, before anybody has switched it on. */
static void without_power_nothing_is_heard(void **state)
{
    static const char *const models[] = {"s3684-rs485", "f3668"};
    static const struct dg_host_event events[] = {
        {.at = READY, .kind = DG_HOST_BYTES, .length = 1, .data = {0x40}},
        {.at = READY, .kind = DG_HOST_CAN, .id = 0x63F, .length = 8, .data = {0x40, 0, 0x10}},
    };
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        struct dg_host *self = host_rig_make(&host_rig_here, models[i]);
        struct dg_host_event event;
        assert_true(dg_host_feed(self, &events[i]) > READY);
        dg_host_tell_controller(self, DG_HOST_BUS_OVERRUN);
        assert_int_equal(dg_host_receive(self, &event), 0);
        assert_false(dg_host_powered(self));
        assert_int_equal(dg_host_power(self, READY, true), DG_HOST_OK);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_side_is_of_one_protocol),
        cmocka_unit_test(too_little_memory_makes_none),
        cmocka_unit_test(without_power_nothing_is_heard),
    };
    return cmocka_run_group_tests_name("host_sides", tests, NULL, NULL);
}

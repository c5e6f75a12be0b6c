/* SPDX-License-Identifier: MIT */
/* Faults of a CAN wire, one encoder at a time, and what encoders hear of each other. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "can_rig.h"
#include "drehgeber/bits.h"
#include "drehgeber/instruments.h"

#define HEARTBEAT 0x700u
#define EMCY 0x80u
#define DELAY_MIN DG_MS(10)

/* --- faults --- */

static void drop_and_deaf(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 2);
    can_rig_open_slcan(self, 2);
    can_rig_connect(self);
    can_rig_bend(self, 0, DG_WIRE_DROP, 2);
    assert_true(can_rig_is_silent(self, 1));
    assert_true(can_rig_answers(self, 2));
    assert_true(can_rig_is_silent(self, 1));
    assert_true(can_rig_answers(self, 1)); /* two frames, and it is over */

    can_rig_bend(self, 0, DG_WIRE_DEAF, 0);
    const uint32_t heard = can_rig_device(self, 0)->counters.rx;
    assert_true(can_rig_is_silent(self, 1));
    assert_true(can_rig_answers(self, 2));
    assert_int_equal(can_rig_device(self, 0)->counters.rx, heard);
    can_rig_mend(self, 0, DG_WIRE_DEAF);
    assert_true(can_rig_answers(self, 1));
}

static void damage_and_duplicate(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open_slcan(self, 1);
    can_rig_connect(self);
    can_rig_ask(self, 1, 0x1000);
    const struct dg_can_frame good = *can_rig_next(self, 0x581, CAN_RIG_PATIENCE);
    for (int i = 0; i < 20; i++) {
        can_rig_bend(self, 0, DG_WIRE_DAMAGE, 1);
        can_rig_ask(self, 1, 0x1000);
        const struct dg_can_frame bad = *can_rig_next(self, 0x581, CAN_RIG_PATIENCE);
        unsigned flipped = 0;
        for (size_t n = 0; n < 8; n++) {
            flipped += (unsigned)__builtin_popcount((unsigned)(bad.data[n] ^ good.data[n]));
        }
        assert_int_equal(flipped, 1);
    }
    can_rig_bend(self, 0, DG_WIRE_DUPLICATE, 1);
    can_rig_ask(self, 1, 0x1000);
    for (int i = 0; i < 2; i++) {
        const struct dg_can_frame *frame = can_rig_next(self, 0x581, CAN_RIG_PATIENCE);
        assert_non_null(frame);
        assert_memory_equal(frame->data, good.data, sizeof good.data);
    }
    assert_null(can_rig_next(self, 0x581, CAN_RIG_QUIET));
}

/* Its place in the catalogue. */
static size_t delay_of(const struct can_rig *self)
{
    return self->station[0].control->faults.slot[DG_WIRE_DELAY];
}

/* In order, also what comes when the delay is over already. */
static void delay(void **state)
{
    struct can_rig *self = *state;
    const dg_ns span = (dg_ns)dg_fault_wire_value(&dg_cia406_instrument, DG_WIRE_DELAY);
    assert_true(span >= DELAY_MIN && span < CAN_RIG_PATIENCE);
    can_rig_plan(self, 2);
    can_rig_open_slcan(self, 2);
    can_rig_connect(self);
    can_rig_bend(self, 0, DG_WIRE_DELAY, 0);
    const dg_ns begin = lx_now();
    can_rig_ask(self, 1, 0x1000);
    while (self->station[0].control->faults.fault[delay_of(self)].happened == 0) {
        assert_true(dg_elapsed(lx_now(), begin) < CAN_RIG_PATIENCE);
        can_rig_turn(self);
    }
    can_rig_mend(self, 0, DG_WIRE_DELAY);
    can_rig_ask(self, 1, 0x1018); /* sub 0: one byte */
    const size_t before = self->taken;
    assert_true(can_rig_answers(self, 2));
    self->taken = before;
    const struct dg_can_frame *frame = can_rig_next(self, 0x581, CAN_RIG_PATIENCE);
    assert_non_null(frame);
    const dg_ns took = dg_elapsed(lx_now(), begin);
    assert_true(took >= span);
    /* Not twice, unless this process stood still, which the bus counts. When exactly is in
     * golden/traces. */
    assert_true(took < 2 * span || self->bus->late + self->bus->stalls > 0);
    assert_int_equal(frame->data[1], 0x00);
    frame = can_rig_next(self, 0x581, CAN_RIG_PATIENCE);
    assert_non_null(frame);
    assert_int_equal(frame->data[1], 0x18);
    assert_true(can_rig_answers(self, 1));
}

static uint16_t code_of(const struct dg_can_frame *frame)
{
    return frame == NULL ? 0 : dg_load_le16(frame->data);
}

static void states_of_the_controller(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 2);
    can_rig_open_slcan(self, 2);
    can_rig_connect(self);
    can_rig_bend(self, 0, DG_WIRE_BUS_OFF, 0);
    assert_true(can_rig_device(self, 0)->bus_off);
    assert_false(can_rig_device(self, 1)->bus_off);
    const uint32_t heard = can_rig_device(self, 0)->counters.rx;
    assert_true(can_rig_is_silent(self, 1));
    assert_int_equal(can_rig_device(self, 0)->counters.rx, heard);
    can_rig_bend(self, 0, DG_WIRE_PASSIVE, 0); /* bus-off is worse */
    assert_true(can_rig_device(self, 0)->bus_off);
    can_rig_mend(self, 0, DG_WIRE_BUS_OFF);
    assert_int_equal(code_of(can_rig_next(self, EMCY + 1, CAN_RIG_PATIENCE)), 0x8140);
    assert_int_equal(code_of(can_rig_next(self, EMCY + 1, CAN_RIG_PATIENCE)), 0x0000);
    assert_int_equal(code_of(can_rig_next(self, EMCY + 1, CAN_RIG_PATIENCE)), 0x8120);
    assert_true(can_rig_answers(self, 1));
    can_rig_mend(self, 0, DG_WIRE_PASSIVE);
    assert_int_equal(code_of(can_rig_next(self, EMCY + 1, CAN_RIG_PATIENCE)), 0x0000);

    /* A power cycle between two looks does not heal the bus. */
    can_rig_bend(self, 0, DG_WIRE_BUS_OFF, 0);
    dg_co_power_off(can_rig_device(self, 0));
    assert_int_equal(dg_co_power_on(can_rig_device(self, 0), lx_now()), DG_OK);
    assert_false(can_rig_device(self, 0)->bus_off);
    can_rig_changed(self, 0);
    assert_true(can_rig_device(self, 0)->bus_off);
    assert_null(can_rig_next(self, HEARTBEAT + 1, CAN_RIG_QUIET));
}

static void an_overrun_loses_a_frame(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 2);
    can_rig_open_slcan(self, 2);
    can_rig_connect(self);
    can_rig_bend(self, 0, DG_WIRE_OVERRUN, 2);
    assert_null(can_rig_next(self, EMCY + 1, CAN_RIG_QUIET)); /* no frame, none lost */
    for (int i = 0; i < 2; i++) {
        const uint32_t heard = can_rig_device(self, 0)->counters.rx;
        can_rig_ask(self, 1, 0x1000);
        assert_int_equal(code_of(can_rig_next(self, EMCY + 1, CAN_RIG_PATIENCE)), 0x8110);
        assert_int_equal(code_of(can_rig_next(self, EMCY + 1, CAN_RIG_PATIENCE)), 0x0000);
        assert_int_equal(can_rig_device(self, 0)->counters.rx, heard);
        assert_true(can_rig_answers(self, 2));
    }
    assert_int_equal(self->station[0].control->faults.wire, 0);
    assert_true(can_rig_answers(self, 1));
    assert_int_equal(can_rig_device(self, 1)->history_count, 0);
}

/* --- nodes among themselves --- */

/* A node that is there is heard, but when the machine stands still for 250 ms. @return how often it
   was missed in time */
static unsigned hear_for_a_while(struct can_rig *self)
{
    unsigned missed = 0;
    unsigned before = 0;
    int attempts = 10;
    do {
        assert_true(attempts-- > 0);
        before = can_rig_sent(self, HEARTBEAT + 1);
        missed = can_rig_sent(self, EMCY + 2);
        can_rig_run(self, DG_MS(400));
    } while (can_rig_sent(self, HEARTBEAT + 1) <= before + 5 ||
             can_rig_sent(self, EMCY + 2) > missed);
    return missed;
}

static void wait_for_frames(struct can_rig *self, uint16_t id, unsigned count)
{
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    while (can_rig_sent(self, id) < count) {
        assert_true(lx_now() < end);
        can_rig_turn(self);
    }
    assert_int_equal(can_rig_sent(self, id), count);
}

/* Node 2 consumes the heartbeat of node 1, which is in the same process. */
static void they_hear_each_other(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 2);
    can_rig_open(self, 2);
    can_rig_write(self, 0, 0x1017, 0, 10, 2);
    can_rig_write(self, 1, 0x1016, 1, 1u << 16 | 250u, 4);
    const unsigned before = hear_for_a_while(self);
    can_rig_bend(self, 0, DG_WIRE_DROP, 0);
    wait_for_frames(self, EMCY + 2, before + 1);
    can_rig_mend(self, 0, DG_WIRE_DROP);
    wait_for_frames(self, EMCY + 2, before + 2); /* 0000h */
    can_rig_bend(self, 1, DG_WIRE_DEAF, 0);
    wait_for_frames(self, EMCY + 2, before + 3);
}

static void a_real_controller_has_states_too(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 2);
    can_rig_open(self, 2);
    const struct lx_can_setup *setup = &can_rig_wire(self)->can.setup;
    setup->bus(setup->ctx, lx_now(), DG_HOST_BUS_PASSIVE);
    setup->bus(setup->ctx, lx_now(), DG_HOST_BUS_PASSIVE);
    assert_int_equal(can_rig_sent(self, EMCY + 1), 1);
    assert_int_equal(can_rig_sent(self, EMCY + 2), 1);
    setup->bus(setup->ctx, lx_now(), DG_HOST_BUS_OFF);
    setup->bus(setup->ctx, lx_now(), DG_HOST_BUS_PASSIVE);
    assert_true(can_rig_device(self, 0)->bus_off && can_rig_device(self, 1)->bus_off);
    can_rig_bend(self, 0, DG_WIRE_BUS_OFF, 0);
    setup->bus(setup->ctx, lx_now(), DG_HOST_BUS_ACTIVE);
    assert_true(can_rig_device(self, 0)->bus_off);
    assert_false(can_rig_device(self, 1)->bus_off);
    setup->bus(setup->ctx, lx_now(), DG_HOST_BUS_OVERRUN);
    assert_int_equal(code_of(&can_rig_wire(self)->frame[can_rig_wire(self)->count - 2]), 0x8110);
    can_rig_mend(self, 0, DG_WIRE_BUS_OFF);
    assert_false(can_rig_device(self, 0)->bus_off);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(drop_and_deaf, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(damage_and_duplicate, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(delay, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(states_of_the_controller, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(an_overrun_loses_a_frame, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(they_hear_each_other, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(a_real_controller_has_states_too, can_rig_set_up,
                                        can_rig_tear_down),
    };
    return cmocka_run_group_tests_name("faults of a CAN wire", tests, NULL, NULL);
}

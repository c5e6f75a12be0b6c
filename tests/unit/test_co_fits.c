/* SPDX-License-Identifier: MIT */
/*
 * Which nodes somebody else may hand over: those that an encoder can be, and none that a number of
 * leads out of its memory.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "sdo_rig.h"

static struct sdo_rig rig;

static int set_up(void **state)
{
    (void)state;
    sdo_rig_init(&rig);
    return 0;
}

/* The node as it is fits, and does not with one number changed. */
#define REFUSED(member, wrong)                                                                     \
    do {                                                                                           \
        const struct dg_co_node before = rig.node;                                                 \
        assert_true(dg_co_fits(&rig.node));                                                        \
        rig.node.member = (wrong);                                                                 \
        assert_false(dg_co_fits(&rig.node));                                                       \
        rig.node = before;                                                                         \
    } while (0)

static void numbers_of_a_node(void **state)
{
    (void)state;
    REFUSED(state, (enum dg_co_state)200);
    REFUSED(now, DG_NEVER);
    REFUSED(bit_rate, 7);
    REFUSED(lss.bit_rate, 200);
    REFUSED(value[SDO_RIG_I8], 101);
    REFUSED(active_causes, 1u << 31);
    REFUSED(sync_mask, 1u << DG_CO_TPDOS);
    REFUSED(sync_mask, 1u); /* of a TPDO that is not valid */
    REFUSED(sdo.deadline, rig.now);
    rig.node.state = DG_CO_OFF; /* nothing of it is looked at before it is switched on */
    rig.node.now = DG_NEVER;
    assert_true(dg_co_fits(&rig.node));
}

static void transfers(void **state)
{
    (void)state;
    sdo_rig_ask(&rig, "21 06 20 00 04 00 00 00", "60 06 20 00 00 00 00 00");
    REFUSED(sdo.object.slot, SDO_RIG_U16);
    REFUSED(sdo.object.index, 0x3000);
    REFUSED(sdo.object.index, 0x2000); /* read-only */
    REFUSED(sdo.length, 200);
    sdo_rig_ask(&rig, "40 17 20 00 00 00 00 00", "41 17 20 00 20 00 00 00");
    REFUSED(sdo.length, DG_CO_STRING_MAX + 1u);
    REFUSED(sdo.done, 200);
    sdo_rig_ask(&rig, "A4 17 20 00 02 00 00 00", "C6 17 20 00 20 00 00 00");
    sdo_rig_ask(&rig, "A3 00 00 00 00 00 00 00",
                "01 30 31 32 33 34 35 36 / 02 37 38 39 41 42 43 44");
    REFUSED(sdo.done, 32);
}

static void mappings(void **state)
{
    (void)state;
    sdo_rig_ask(&rig, "23 00 18 01 BF 01 00 80", "60 00 18 01 00 00 00 00");
    sdo_rig_ask(&rig, "2F 00 1A 00 00 00 00 00", "60 00 1A 00 00 00 00 00");
    sdo_rig_ask(&rig, "23 00 1A 01 08 00 01 10", "60 00 1A 01 00 00 00 00");
    sdo_rig_ask(&rig, "2F 00 1A 00 01 00 00 00", "60 00 1A 00 00 00 00 00");
    sdo_rig_ask(&rig, "23 00 18 01 BF 01 00 00", "60 00 18 01 00 00 00 00");
    assert_true(rig.node.tpdo[0].valid);
    REFUSED(tpdo[0].length, 2);
    REFUSED(tpdo[0].mapped_count, DG_CO_MAPPED_MAX + 1u);
    REFUSED(tpdo[0].mapped[0], 0x7FFF); /* no such row */
    REFUSED(tpdo[0].mapped[0], 0xFFFF);
    REFUSED(tpdo[0].mapped[0], 0); /* 1000h, which is not mappable */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(numbers_of_a_node, set_up),
        cmocka_unit_test_setup(transfers, set_up),
        cmocka_unit_test_setup(mappings, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

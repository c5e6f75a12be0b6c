/* SPDX-License-Identifier: MIT */
/*
 * Memories of earlier releases, and COB-IDs that follow the node-ID (C33, C36, C43).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "co_od.h"
#include "co_rig.h"

#define LSS 0x7E5
#define RESET_NODE 0x81
#define SAVE 0x65766173u /* "save" */

static struct co_rig rig;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    return 0;
}

static void write_ok(uint16_t index, uint8_t sub, uint32_t value, uint8_t size)
{
    assert_int_equal(co_rig_write(&rig, index, sub, value, size), 0);
}

static uint32_t read_ok(uint16_t index, uint8_t sub)
{
    return co_rig_get(&rig, index, sub);
}

static void power_cycle(void)
{
    dg_co_power_off(&rig.node);
    assert_int_equal(co_rig_power_on(&rig), DG_OK);
}

/* An earlier release's memory. */
static void store_cob_ids(const uint32_t absolute[DG_CO_TPDOS])
{
    co_rig_store_cob_ids(&rig, absolute);
    power_cycle();
}

/* What releases stored that had 1019h (here 10) and 1800h:6 (3). */
static const uint8_t saved[1] = {1};
static const uint8_t communication[35] = {
    0xB0, 0,    0, 0,    /* 1005h */
    0x10, 0x27, 0, 0,    /* 1006h */
    0xE8, 0x03, 0, 0,    /* 1007h */
    0x64, 0,             /* 100Ch */
    3,                   /* 100Dh */
    0,    1,    0, 0x80, /* 1012h */
    0x0A, 0,             /* 1015h */
    0x64, 0,    7, 0,    /* 1016h:1 */
    0xC8, 0,    8, 0,    /* 1016h:2 */
    0xF4, 1,             /* 1017h */
    10,                  /* 1019h */
    1,    2,    0,       /* 1029h */
};
static const uint8_t tpdo2[43] = {
    0x22, 2,    0,    0x40, /* COB-ID */
    7,                      /* type */
    5,    0,                /* inhibit time */
    0x21, 0,                /* event timer */
    3,                      /* SYNC start value */
    2,                      /* entries */
    0x20, 0,    0x04, 0x60, /* 6004h */
    0x10, 0x01, 0x30, 0x60, /* 6030h:1 */
};

/* Both objects have gone, the others stand where they stood. */
static void memories_with_rows_that_have_gone_still_fit(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t sub;
        uint32_t value;
    } expected[] = {
        {0x1005, 0, 0xB0},       {0x1006, 0, 10000},      {0x1007, 0, 1000},
        {0x100C, 0, 100},        {0x100D, 0, 3},          {0x1012, 0, 0x80000100},
        {0x1015, 0, 10},         {0x1016, 1, 0x00070064}, {0x1016, 2, 0x000800C8},
        {0x1017, 0, 500},        {0x1029, 1, 1},          {0x1029, 2, 2},
        {0x1029, 3, 0},          {0x1801, 1, 0x40000222}, {0x1801, 2, 7},
        {0x1801, 3, 5},          {0x1801, 5, 33},         {0x1A01, 0, 2},
        {0x1A01, 1, 0x60040020}, {0x1A01, 2, 0x60300110}, {0x1A01, 8, 0},
    };
    struct dg_store *const store = &rig.node.store;
    (void)state;

    dg_store_begin(store);
    (void)dg_store_stage(store, DG_CO_REGION_SAVED, 0, saved, sizeof saved);
    (void)dg_store_stage(store, DG_CO_REGION_COMMUNICATION, 0, communication, sizeof communication);
    (void)dg_store_stage(store, DG_CO_REGION_TPDO2, 0, tpdo2, sizeof tpdo2);
    assert_int_equal(dg_store_commit(store), DG_OK);
    power_cycle();
    for (unsigned round = 0; round < 2; round++) {
        for (size_t i = 0; i < DG_COUNT(expected); i++) {
            assert_int_equal(read_ok(expected[i].index, expected[i].sub), expected[i].value);
        }
        write_ok(0x1010, 1, SAVE, 4); /* as this release stores them */
        power_cycle();
    }
}

/* ------------------------------------------------------------ COB-IDs and the node-ID (C33) */

/* Another node-ID, kept and in force. */
static void move_to(uint8_t node_id)
{
    write_ok(0x2101, 0, node_id, 1);
    write_ok(0x2105, 0, SAVE, 4);
    power_cycle();
    assert_int_equal(rig.node.id, node_id);
}

static void expect_cob_ids(uint32_t first, uint32_t second, uint32_t third, uint32_t fourth)
{
    assert_int_equal(read_ok(0x1800, 1), first);
    assert_int_equal(read_ok(0x1801, 1), second);
    assert_int_equal(read_ok(0x1802, 1), third);
    assert_int_equal(read_ok(0x1803, 1), fourth);
}

static void defaults_follow_the_node_id_and_others_stay(void **state)
{
    (void)state;
    write_ok(0x1800, 1, 0x400001BF, 4); /* the default, without RTR */
    write_ok(0x1801, 1, 0x800002BF, 4);
    write_ok(0x1801, 1, 0x222, 4);
    write_ok(0x1803, 1, 0x800004BF, 4); /* the default, switched off */
    write_ok(0x1010, 1, SAVE, 4);
    power_cycle();
    expect_cob_ids(0x400001BF, 0x222, 0x3BF, 0x800004BF);
    move_to(9);
    expect_cob_ids(0x40000189, 0x222, 0x389, 0x80000489);
    move_to(0x7F);
    expect_cob_ids(0x400001FF, 0x222, 0x3FF, 0x800004FF);
    co_rig_nmt(&rig, RESET_NODE);
    expect_cob_ids(0x400001FF, 0x222, 0x3FF, 0x800004FF);
}

/* By LSS, and without "store": the memory still has the other node-ID. */
static void defaults_follow_a_node_id_that_is_not_kept(void **state)
{
    (void)state;
    write_ok(0x1010, 1, SAVE, 4);
    co_rig_rx(&rig, LSS, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "11 09 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "04 00 00 00 00 00 00 00");
    expect_cob_ids(0x189, 0x289, 0x389, 0x489);
    power_cycle();
    expect_cob_ids(0x1BF, 0x2BF, 0x3BF, 0x4BF);
}

/* 80000000h is how masters switch a TPDO off. */
static void a_can_id_of_0_is_kept(void **state)
{
    (void)state;
    write_ok(0x1800, 1, 0x80000000, 4);
    write_ok(0x1010, 1, SAVE, 4);
    move_to(9);
    expect_cob_ids(0x80000000, 0x289, 0x389, 0x489);
}

/* What was accepted stays, whatever else another node-ID brings to the same CAN-ID (C43). */
static void a_moved_can_id_stays_beside_a_default(void **state)
{
    (void)state;
    write_ok(0x1800, 1, 0x800001BF, 4);
    write_ok(0x1800, 1, 0x289, 4); /* TPDO2's on node 9 */
    write_ok(0x1802, 1, 0x800003BF, 4);
    write_ok(0x1802, 1, 0x89, 4);  /* EMCY's on node 9 */
    write_ok(0x1005, 0, 0x489, 4); /* TPDO4's on node 9 */
    write_ok(0x1010, 1, SAVE, 4);
    power_cycle();
    expect_cob_ids(0x289, 0x2BF, 0x89, 0x4BF);
    move_to(9);
    expect_cob_ids(0x289, 0x289, 0x89, 0x489);
    assert_int_equal(read_ok(0x1005, 0), 0x489);
    move_to(0x3F);
    expect_cob_ids(0x289, 0x2BF, 0x89, 0x4BF);
}

/* Two TPDOs on one CAN-ID, SYNC's. */
static void a_shared_can_id_is_kept(void **state)
{
    (void)state;
    write_ok(0x1800, 1, 0x80000222, 4);
    write_ok(0x1800, 1, 0x222, 4);
    write_ok(0x1803, 1, 0x80000222, 4);
    write_ok(0x1803, 1, 0x40000222, 4);
    write_ok(0x1005, 0, 0x222, 4);
    write_ok(0x1010, 1, SAVE, 4);
    power_cycle();
    expect_cob_ids(0x222, 0x2BF, 0x3BF, 0x40000222);
    move_to(9);
    expect_cob_ids(0x222, 0x289, 0x389, 0x40000222);
    assert_int_equal(read_ok(0x1005, 0), 0x222);
}

static void earlier_releases_defaults_follow_from_now_on(void **state)
{
    static const uint32_t absolute[] = {0x400001BF, 0x222, 0x3BF, 0x80000000};
    (void)state;
    store_cob_ids(absolute);
    expect_cob_ids(0x400001BF, 0x222, 0x3BF, 0x80000000);
    move_to(9);
    expect_cob_ids(0x40000189, 0x222, 0x389, 0x80000000);
    move_to(10);
    expect_cob_ids(0x4000018A, 0x222, 0x38A, 0x80000000);
}

/* Saved as node 3Fh, then made node 9 by the earlier release itself: they stay where it had them.
 */
static void earlier_releases_values_stay(void **state)
{
    static const uint32_t absolute[] = {0x1BF, 0x2BF, 0x3BF, 0x4BF};
    (void)state;
    move_to(9);
    store_cob_ids(absolute);
    expect_cob_ids(0x1BF, 0x2BF, 0x3BF, 0x4BF);
    move_to(10);
    expect_cob_ids(0x1BF, 0x2BF, 0x3BF, 0x4BF);
}

/* An earlier release's memory whose node-ID is only changed in force, not in the memory. */
static void earlier_releases_defaults_follow_lss(void **state)
{
    static const uint32_t absolute[] = {0x1BF, 0x2BF, 0x333, 0x4BF};
    (void)state;
    store_cob_ids(absolute);
    co_rig_rx(&rig, LSS, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "11 0A 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "04 00 00 00 00 00 00 00");
    expect_cob_ids(0x18A, 0x28A, 0x333, 0x48A);
    co_rig_rx(&rig, LSS, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "11 09 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "17 00 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "04 00 00 00 00 00 00 00");
    expect_cob_ids(0x189, 0x289, 0x333, 0x489);
    power_cycle();
    expect_cob_ids(0x189, 0x289, 0x333, 0x489);
}

/* A region that fails its sum is not written: it has to be reported until it is saved anew. */
static void a_damaged_region_is_not_marked(void **state)
{
    static const uint32_t absolute[] = {0x1BF, 0x2BF, 0x3BF, 0x4BF};
    (void)state;
    store_cob_ids(absolute);
    rig.nvm.bytes[dg_store_address(rig.model->device->layout, DG_CO_REGION_TPDO2) + 8] ^= 1;
    power_cycle();
    move_to(9);
    assert_int_equal(rig.node.active_causes, 1u << DG_CO_CAUSE_MEMORY);
    expect_cob_ids(0x189, 0x289, 0x389, 0x489);
}

/* A node-ID that only LSS gave is in force, but not stored: what is saved with it follows the one
 * that is in force at the next start (C33). */
static void cob_ids_saved_under_an_unsaved_node_id_follow_the_stored_one(void **state)
{
    (void)state;
    co_rig_rx(&rig, LSS, "04 01 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "11 20 00 00 00 00 00 00");
    co_rig_rx(&rig, LSS, "04 00 00 00 00 00 00 00");
    co_rig_nmt(&rig, RESET_NODE);
    assert_int_equal(rig.node.id, 0x20);
    write_ok(0x1010, 1, SAVE, 4);
    power_cycle();
    assert_int_equal(rig.node.id, 0x3F);
    assert_int_equal(read_ok(0x1800, 1) & 0x7FF, 0x180 + 0x3F);
    assert_int_equal(read_ok(0x1801, 1) & 0x7FF, 0x280 + 0x3F);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(memories_with_rows_that_have_gone_still_fit, setup),
        cmocka_unit_test_setup(defaults_follow_the_node_id_and_others_stay, setup),
        cmocka_unit_test_setup(defaults_follow_a_node_id_that_is_not_kept, setup),
        cmocka_unit_test_setup(a_can_id_of_0_is_kept, setup),
        cmocka_unit_test_setup(a_moved_can_id_stays_beside_a_default, setup),
        cmocka_unit_test_setup(a_shared_can_id_is_kept, setup),
        cmocka_unit_test_setup(earlier_releases_defaults_follow_from_now_on, setup),
        cmocka_unit_test_setup(earlier_releases_values_stay, setup),
        cmocka_unit_test_setup(earlier_releases_defaults_follow_lss, setup),
        cmocka_unit_test_setup(a_damaged_region_is_not_marked, setup),
        cmocka_unit_test_setup(cob_ids_saved_under_an_unsaved_node_id_follow_the_stored_one, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

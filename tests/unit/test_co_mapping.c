/* SPDX-License-Identifier: MIT */
/*
 * Parameters of TPDOs: what is refused, and what memory brings (CiA 301; manual chapters 11, 12;
 * C6).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "pdo_rig.h"

static void a_remapped_tpdo1_carries_the_new_objects(void **state)
{
    static const uint8_t all[] = {0x34, 0xFE, 0x34, 0x12, 0x11, 0x22, 0x33, 0x44};

    (void)state;
    pdo_rig.live = 0x00001234;
    pdo_disable(0);
    pdo_put_ok(0x1A00, 0, 0, 1);
    pdo_put_ok(0x1A00, 1, 0x20010008, 4);
    pdo_put_ok(0x1A00, 2, 0x20040108, 4);
    pdo_put_ok(0x1A00, 3, 0x20020010, 4);
    pdo_put_ok(0x1A00, 4, 0x20080020, 4);
    pdo_put_ok(0x1A00, 0, 4, 1);
    pdo_enable(0);
    pdo_nmt(START);
    pdo_expect(0, TPDO1, all, sizeof all);
}

static void eight_bytes_can_be_mapped_one_by_one(void **state)
{
    static const uint8_t all[] = {0xFE, 0xFE, 0xFE, 0xFE, 0xFE, 0xFE, 0xFE, 0xEE};

    (void)state;
    pdo_rig.live = 0xFFFFFFEE;
    pdo_disable(0);
    pdo_put_ok(0x1A00, 0, 0, 1);
    for (uint8_t i = 1; i < 8; i++) {
        pdo_put_ok(0x1A00, i, 0x20040108, 4);
    }
    pdo_put_ok(0x1A00, 8, 0x20010008, 4);
    pdo_put_ok(0x1A00, 0, 8, 1);
    pdo_enable(0);
    pdo_nmt(START);
    pdo_expect(0, TPDO1, all, sizeof all);
}

/* ------------------------------------------------------------ aborts */

struct attempt {
    uint16_t index;
    uint8_t sub;
    uint8_t size;
    uint32_t value;
    uint32_t abort;
};

static void attempt_all(const struct attempt *attempts, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct attempt *a = &attempts[i];
        uint32_t before = pdo_get(a->index, a->sub);
        assert_int_equal(pdo_put(a->index, a->sub, a->value, a->size), a->abort);
        assert_int_equal(pdo_get(a->index, a->sub), a->abort == 0 ? a->value : before);
    }
}

static void what_a_valid_tpdo_refuses(void **state)
{
    static const struct attempt attempts[] = {
        {0x1800, 1, 4, 0x1C0, 0x06090030},
        {0x1800, 1, 4, 0x200001BF, 0x06090030},
        {0x1800, 1, 4, 0x000009BF, 0x06090030},
        {0x1800, 1, 4, 0x100001BF, 0x06090030},
        {0x1800, 1, 4, 0x000001BF, 0},
        {0x1800, 1, 4, 0x400001BF, 0},
        {0x1800, 2, 1, 240, 0},
        {0x1800, 2, 1, 241, 0x06090030},
        {0x1800, 2, 1, 251, 0x06090030},
        {0x1800, 2, 1, 252, 0},
        {0x1800, 2, 1, 253, 0},
        {0x1800, 2, 1, 254, 0},
        {0x1800, 2, 1, 0, 0},
        {0x1800, 2, 1, 255, 0},
        {0x1800, 3, 2, 1, 0x06090030},
        {0x1800, 3, 2, 0, 0},
        {0x1800, 5, 2, 65535, 0},
        {0x1A00, 0, 1, 0, 0x06010000},
        {0x1A00, 0, 1, 1, 0x06010000},
        {0x1A00, 1, 4, 0x60040020, 0x06010000},
        {0x1A00, 2, 4, 0, 0x06010000},
        {0x1800, 1, 4, 0x80000000, 0},
    };

    (void)state;
    attempt_all(attempts, DG_COUNT(attempts));
    assert_int_equal(pdo_put(0x1800, 4, 0, 1), 0x06090011);
    assert_int_equal(pdo_put(0x1800, 6, 0, 1), 0x06090011);
    assert_int_equal(pdo_put(0x1800, 0, 5, 1), 0x06010002);
}

static void what_mapping_refuses(void **state)
{
    static const struct attempt attempts[] = {
        {0x1A00, 1, 4, 0x60040020, 0x06010000}, /* sub 0 is not 0 yet */
        {0x1A00, 0, 1, 0, 0},
        {0x1A00, 1, 4, 0x20050020, 0x06040041}, /* not mappable */
        {0x1A00, 1, 4, 0x20060020, 0x06040041}, /* write-only */
        {0x1A00, 1, 4, 0x20070008, 0x06040041}, /* a string */
        {0x1A00, 1, 4, 0x18000120, 0x06040041}, /* of the stack, not mappable */
        {0x1A00, 1, 4, 0x20090020, 0x06020000}, /* no such object */
        {0x1A00, 1, 4, 0x00050008, 0x06020000}, /* no dummies */
        {0x1A00, 1, 4, 0x20080120, 0x06090011}, /* no such sub-index */
        {0x1A00, 1, 4, 0x60040010, 0x06040043}, /* shorter than the object */
        {0x1A00, 1, 4, 0x60040040, 0x06040043}, /* longer */
        {0x1A00, 1, 4, 0x20010000, 0x06040043},
        {0x1A00, 1, 4, 0x10010008, 0},
        {0x1A00, 1, 4, 0x10020020, 0},
        {0x1A00, 2, 4, 0x60040020, 0},
        {0x1A00, 3, 4, 0x20010008, 0},
        {0x1800, 1, 4, 0x1BF, 0x06090030}, /* nothing is mapped */
        {0x1A00, 0, 1, 3, 0x06040042},     /* 72 bits */
        {0x1A00, 0, 1, 9, 0x06040042},     /* no such entry */
        {0x1A00, 0, 1, 255, 0x06040042},
        {0x1A00, 3, 4, 0, 0},
        {0x1A00, 0, 1, 3, 0}, /* an unused one */
        {0x1A00, 2, 4, 0x60040020, 0x06010000},
        {0x1A00, 0, 1, 1, 0},
        {0x1800, 1, 4, 0x1BF, 0},
    };

    (void)state;
    pdo_disable(0);
    attempt_all(attempts, DG_COUNT(attempts));
}

static void unused_entries_leave_no_gap(void **state)
{
    static const uint8_t data[] = {0x04, 0xFE, 0x04, 0x03};

    (void)state;
    pdo_disable(0);
    pdo_put_ok(0x1A00, 0, 0, 1);
    pdo_put_ok(0x1A00, 1, 0, 4);
    pdo_put_ok(0x1A00, 0, 1, 1); /* nothing but unused ones: no PDO */
    assert_int_equal(pdo_put(0x1800, 1, TPDO1, 4), 0x06090030);
    pdo_put_ok(0x1A00, 0, 0, 1);
    pdo_put_ok(0x1A00, 2, 0x20010008, 4);
    pdo_put_ok(0x1A00, 4, 0x20040108, 4);
    pdo_put_ok(0x1A00, 8, 0x20020010, 4);
    pdo_put_ok(0x1A00, 0, 8, 1);
    pdo_enable(0);
    assert_int_equal(pdo_get(0x1A00, 0), 8);
    assert_int_equal(pdo_get(0x1A00, 3), 0);
    pdo_nmt(START);
    pdo_expect(0, TPDO1, data, sizeof data);
}

static void restricted_can_ids_are_refused(void **state)
{
    static const uint16_t ends[][2] = {
        {0x001, 0x07F}, {0x101, 0x180}, {0x581, 0x5FF}, {0x601, 0x67F},
        {0x6E0, 0x6FF}, {0x701, 0x77F}, {0x780, 0x7FF},
    };
    static const uint16_t allowed[] = {0x081, 0x100, 0x181, 0x580, 0x600, 0x680, 0x6DF, 0x700};

    (void)state;
    pdo_disable(0);
    assert_int_equal(pdo_put(0x1800, 1, 0, 4), 0x06090030);
    for (uint8_t i = 0; i < DG_COUNT(ends); i++) {
        for (uint8_t j = 0; j < 2; j++) {
            assert_int_equal(pdo_put(0x1800, 1, ends[i][j], 4), 0x06090030);
            assert_int_equal(pdo_put(0x1800, 1, NOT_VALID | ends[i][j], 4), 0x06090030);
        }
    }
    for (uint8_t i = 0; i < DG_COUNT(allowed); i++) {
        pdo_put_ok(0x1800, 1, NOT_VALID | allowed[i], 4);
        pdo_put_ok(0x1800, 1, allowed[i], 4);
        pdo_put_ok(0x1800, 1, NOT_VALID, 4);
    }
}

static void expect_shared(uint8_t count, uint16_t first, uint16_t second)
{
    uint16_t ids[DG_CO_SHARED_MAX];

    assert_int_equal(dg_co_shared_ids(&pdo_rig.node, ids), count);
    assert_true(count < 1 || ids[0] == first);
    assert_true(count < 2 || ids[1] == second);
}

/* CiA 301: a valid TPDO keeps its CAN-ID. Which one it gets is the master's business (C43). */
static void services_may_share_a_can_id(void **state)
{
    static const struct attempt attempts[] = {
        {0x1800, 1, 4, TPDO2, 0x06090030}, /* valid before and after */
        {0x1800, 1, 4, 0x40000000 | TPDO2, 0x06090030},
        {0x1800, 1, 4, NOT_VALID | TPDO2, 0}, /* both ways to get there */
        {0x1800, 1, 4, TPDO2, 0},
        {0x1801, 1, 4, NOT_VALID | 0x080, 0},
        {0x1801, 1, 4, 0x080, 0}, /* SYNC's */
        {0x1802, 1, 4, NOT_VALID, 0},
        {0x1802, 1, 4, EMCY, 0},
        {0x1014, 0, 4, NOT_VALID | EMCY, 0x06010002},
    };

    (void)state;
    expect_shared(0, 0, 0);
    attempt_all(attempts, DG_COUNT(attempts));
    expect_shared(2, 0x080, EMCY);
    pdo_put_ok(0x1803, 1, NOT_VALID, 4);
    pdo_put_ok(0x1803, 1, TPDO2, 4);
    expect_shared(3, 0x080, EMCY);
    dg_co_power_off(&pdo_rig.node);
    expect_shared(0, 0, 0);
}

static void sync_and_time_change_at_any_time(void **state)
{
    static const struct attempt attempts[] = {
        {0x1005, 0, 4, TPDO2, 0},
        {0x1005, 0, 4, EMCY, 0},
        {0x1005, 0, 4, 0x180, 0x06090030},
        {0x1005, 0, 4, 0x1FFFF081, 0x06090030},
        {0x1012, 0, 4, 0x100, 0},
        {0x1012, 0, 4, NOT_VALID | EMCY, 0},
        {0x1012, 0, 4, NOT_VALID | TPDO4, 0},
        {0x1012, 0, 4, NOT_VALID | 0x581, 0x06090030},
        {0x1012, 0, 4, 0x20000100, 0x06090030},
    };

    (void)state;
    attempt_all(attempts, DG_COUNT(attempts));
    expect_shared(2, EMCY, TPDO4);
    pdo_put_ok(0x1012, 0, TPDO4, 4); /* not consumed any more */
    expect_shared(1, EMCY, 0);
}

/* Both send, and both answer a remote frame; the filter of the shared identifier stands once. */
static void what_shares_a_can_id_sends(void **state)
{
    uint16_t ids[DG_CO_FILTERS_MAX];
    uint32_t found = 0;

    (void)state;
    pdo_disable(0);
    pdo_put_ok(0x1800, 1, TPDO2, 4);
    pdo_put_ok(0x1800, 2, 254, 1);
    pdo_put_ok(0x1801, 2, 254, 1);
    pdo_forget();
    pdo_nmt(START);
    for (uint32_t i = 0; i < pdo_rig.count; i++) {
        found += pdo_rig.sent[i].frame.id == TPDO2 ? 1u : 0u;
    }
    assert_int_equal(found, 2);
    pdo_forget();
    pdo_request(TPDO2);
    assert_int_equal(pdo_rig.count, 2);
    found = 0;
    for (uint8_t n = dg_co_filters(&pdo_rig.node, ids); n > 0; n--) {
        found += ids[n - 1u] == TPDO2 ? 1u : 0u;
    }
    assert_int_equal(found, 1);
}

static void an_invalid_tpdo_takes_another_inhibit_time(void **state)
{
    (void)state;
    pdo_disable(0);
    pdo_put_ok(0x1800, 3, 65535, 2);
    assert_int_equal(pdo_get(0x1800, 3), 65535);
}

static void reading_parameters_leaves_the_timers_alone(void **state)
{
    dg_ns entered;

    (void)state;
    pdo_only_tpdo1(10, 0);
    entered = pdo_rig.now;
    pdo_run_ms(7);
    assert_int_equal(pdo_get(0x1800, 5), 10);
    assert_int_equal(pdo_get(0x1800, 2), 255);
    assert_int_equal(pdo_get(0x1800, 1), TPDO1);
    pdo_run_ms(5);
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect_at_ms(0, entered, 10);
    pdo_enable(1);
    pdo_only_tpdo2(3);
    pdo_sync();
    pdo_sync();
    assert_int_equal(pdo_get(0x1801, 2), 3); /* nor the phase */
    pdo_sync();
    assert_int_equal(pdo_rig.count, 1);
}

static void a_new_can_id_is_listened_to(void **state)
{
    uint16_t ids[DG_CO_FILTERS_MAX];
    uint8_t version = pdo_rig.node.filter_version;
    uint8_t count;
    bool listened = false;

    (void)state;
    pdo_disable(0);
    pdo_put_ok(0x1800, 1, 0x222, 4);
    assert_int_not_equal(pdo_rig.node.filter_version, version);
    count = dg_co_filters(&pdo_rig.node, ids);
    for (uint8_t i = 0; i < count; i++) {
        assert_int_not_equal(ids[i], TPDO1);
        listened = listened || ids[i] == 0x222;
    }
    assert_true(listened);
}

/* ------------------------------------------------------------ memory */

static void saved_parameters_work_after_power_off(void **state)
{
    static const uint8_t data[] = {0x04, 0x04, 0x03};

    (void)state;
    pdo_disable(0);
    pdo_put_ok(0x1A00, 0, 0, 1);
    pdo_put_ok(0x1A00, 1, 0x20010008, 4);
    pdo_put_ok(0x1A00, 2, 0x20020010, 4);
    pdo_put_ok(0x1A00, 0, 2, 1);
    pdo_put_ok(0x1800, 1, 0x222, 4);
    pdo_put_ok(0x1800, 2, 253, 1);
    pdo_receive((struct dg_can_frame){
        .id = 0x63F, .dlc = 8, .data = {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}});
    pdo_run_ms(20);
    pdo_power_on(&pdo_rig_device);
    pdo_nmt(START);
    pdo_forget();
    pdo_request(0x222);
    assert_int_equal(pdo_rig.count, 1);
    pdo_expect(0, 0x222, data, sizeof data);

    pdo_power_on(&pdo_rig_smaller_device); /* which cannot map what was saved */
    assert_int_equal(pdo_get(0x1800, 1), NOT_VALID | 0x222);
    pdo_nmt(START);
    pdo_forget();
    pdo_request(0x222);
    assert_int_equal(pdo_rig.count, 0);
    assert_int_equal(pdo_put(0x1800, 1, 0x222, 4), 0x06090030);
}

/* Parameters no client could have written. */
static void foreign_parameters_leave_the_tpdo_off(void **state)
{
    static const struct {
        uint8_t offset; /* in the region: COB-ID 0, type 4, entries' count 10 */
        uint8_t byte;
    } damages[] = {{0, 0x00}, {2, 0x01}, {3, 0x30}, {4, 241}, {10, 0}, {10, 9}, {13, 0x05}};
    uint8_t good[43];
    uint8_t bad[43];
    struct dg_store store;

    (void)state;
    pdo_receive((struct dg_can_frame){
        .id = 0x63F, .dlc = 8, .data = {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}});
    pdo_run_ms(20);
    assert_int_equal(dg_store_mount(&store, &pdo_rig_layout, ram_nvm_port(&pdo_rig.nvm)), DG_OK);
    assert_int_equal(dg_store_read(&store, DG_CO_REGION_TPDO1, 0, good, sizeof good), DG_OK);
    for (uint8_t i = 0; i < DG_COUNT(damages); i++) {
        memcpy(bad, good, sizeof good);
        assert_int_not_equal(bad[damages[i].offset], damages[i].byte);
        bad[damages[i].offset] = damages[i].byte;
        if (damages[i].offset == 0) {
            memset(bad, 0, 4); /* CAN-ID 000h */
        }
        assert_int_equal(dg_store_put(&store, DG_CO_REGION_TPDO1, 0, bad, sizeof bad), DG_OK);
        pdo_power_on(&pdo_rig_device);
        assert_true((pdo_get(0x1800, 1) & NOT_VALID) != 0);
        assert_in_range(pdo_get(0x1A00, 0), 0, 8);
        pdo_nmt(START);
        assert_int_equal(pdo_rig.count, 2);
        pdo_expect(0, TPDO3, (const uint8_t[]){0x85, 0xFF}, 2);
    }
    assert_int_equal(dg_store_put(&store, DG_CO_REGION_TPDO1, 0, good, sizeof good), DG_OK);
    pdo_power_on(&pdo_rig_device);
    pdo_nmt(START);
    assert_int_equal(pdo_rig.count, 3);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_remapped_tpdo1_carries_the_new_objects, pdo_set_up),
        cmocka_unit_test_setup(eight_bytes_can_be_mapped_one_by_one, pdo_set_up),
        cmocka_unit_test_setup(what_a_valid_tpdo_refuses, pdo_set_up),
        cmocka_unit_test_setup(what_mapping_refuses, pdo_set_up),
        cmocka_unit_test_setup(unused_entries_leave_no_gap, pdo_set_up),
        cmocka_unit_test_setup(restricted_can_ids_are_refused, pdo_set_up),
        cmocka_unit_test_setup(services_may_share_a_can_id, pdo_set_up),
        cmocka_unit_test_setup(sync_and_time_change_at_any_time, pdo_set_up),
        cmocka_unit_test_setup(what_shares_a_can_id_sends, pdo_set_up),
        cmocka_unit_test_setup(an_invalid_tpdo_takes_another_inhibit_time, pdo_set_up),
        cmocka_unit_test_setup(reading_parameters_leaves_the_timers_alone, pdo_set_up),
        cmocka_unit_test_setup(a_new_can_id_is_listened_to, pdo_set_up),
        cmocka_unit_test_setup(saved_parameters_work_after_power_off, pdo_set_up),
        cmocka_unit_test_setup(foreign_parameters_leave_the_tpdo_off, pdo_set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

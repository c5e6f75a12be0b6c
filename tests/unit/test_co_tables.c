/* SPDX-License-Identifier: MIT */
/*
 * The tables of the CANopen node: both halves of the dictionary, the regions of the memory, the
 * causes of emergencies, the restricted CAN-IDs; and every saved row driven through the memory.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "co_od.h"
#include "co_rig.h"

#define SAVE 0x65766173u /* "save" */
#define FLAGS                                                                                      \
    (DG_CO_RW | DG_CO_MAP | DG_CO_ID | DG_CO_SAVE | DG_CO_SLOT | DG_CO_CONST | DG_CO_GAP |         \
     DG_CO_EVENT | DG_CO_ACTION | DG_CO_LIVE | DG_CO_FIGURE)

static struct co_rig rig;
static const struct dg_co_device *const device = &dg_cia406_multiturn;

static int setup(void **state)
{
    (void)state;
    co_rig_start(&rig);
    return 0;
}

static struct dg_co_object all[256];
static size_t row_count;

static int list_rows(void **state)
{
    struct dg_co_object object = dg_co_first();
    (void)state;

    do {
        all[row_count++] = object;
    } while (row_count < DG_COUNT(all) && dg_co_next(device, &object));
    return 0;
}

static size_t rows(void)
{
    return row_count;
}

/* Both halves as one table. */
static const struct dg_co_object *row(size_t i)
{
    return &all[i];
}

static uint32_t key(const struct dg_co_object *object)
{
    return (uint32_t)object->index << 8 | object->sub;
}

static bool is_signed(const struct dg_co_object *object)
{
    return co_type(object) == DG_CO_I8 || co_type(object) == DG_CO_I16 ||
           co_type(object) == DG_CO_I32;
}

static bool inside(const struct dg_co_object *object, uint32_t value)
{
    const struct dg_co_limits limits = dg_co_limits_of(object);

    if (is_signed(object)) {
        return (int32_t)limits.min <= (int32_t)value && (int32_t)value <= (int32_t)limits.max;
    }
    return limits.min <= value && value <= limits.max;
}

/* What is left of a value in the bytes of the type. */
static uint32_t cut(const struct dg_co_object *object, uint32_t value)
{
    const uint8_t bits = (uint8_t)(8u * co_size(object));
    const uint32_t kept = bits == 32 ? value : value & ((1u << bits) - 1u);

    return dg_co_extend(object, kept);
}

/* ------------------------------------------------------------ dictionary */

static void rows_are_sorted_and_unique(void **state)
{
    (void)state;
    assert_in_range(rows(), 111, DG_COUNT(all) - 1);
    assert_true(row(0)->index == 0x1000 && row(rows() - 1)->index == 0x650E);
    for (size_t i = 0; i < rows(); i++) {
        if (i > 0) {
            assert_true(key(row(i - 1)) < key(row(i)));
        }
    }
}

/* Every index and, where there is one, every sub-index: found exactly when there is a row. */
static void rows_are_found_and_nothing_else(void **state)
{
    size_t next = 0;
    (void)state;

    for (uint32_t index = 0; index <= 0xFFFF; index++) {
        const bool known = next < rows() && row(next)->index == index;
        for (unsigned sub = 0; sub <= (known ? 0xFFu : 1u); sub++) {
            const bool there = next < rows() && key(row(next)) == (index << 8 | sub);
            struct dg_co_object found = {0};
            const enum dg_co_abort abort = dg_co_find(device, DG_CO_KEY(index, sub), &found);
            assert_true(!there || (found.row == row(next)->row && found.slot == row(next)->slot));
            assert_true(!there || (found.index == index && found.sub == sub));
            assert_int_equal(abort, there ? DG_CO_OK : known ? DG_CO_NO_SUB : DG_CO_NO_OBJECT);
            next += there;
        }
    }
    assert_int_equal(next, rows());
}

/* Sub 0 of an array or record; a constant one says the highest sub-index. */
static void arrays_and_records_have_a_sub_0(void **state)
{
    size_t first = 0;
    (void)state;

    for (size_t i = 0; i < rows(); i++) {
        first = row(first)->index == row(i)->index ? first : i;
        const bool last = i + 1 == rows() || row(i + 1)->index != row(i)->index;
        if (!last || i == first) {
            continue;
        }
        assert_int_equal(row(first)->sub, 0);
        assert_int_equal(co_type(row(first)), DG_CO_U8);
        if (co_is(row(first), DG_CO_CONST)) {
            assert_int_equal(dg_co_default(device, row(first)), row(i)->sub);
        }
    }
}

static void defaults_and_limits_fit_their_type(void **state)
{
    (void)state;
    for (size_t i = 0; i < rows(); i++) {
        const struct dg_co_object *object = row(i);
        if (co_type(object) == DG_CO_STRING) {
            assert_in_range(strlen(device->strings[object->row->initial]), 1, DG_CO_STRING_MAX);
            continue;
        }
        const struct dg_co_limits limits = dg_co_limits_of(object);
        assert_int_equal(cut(object, limits.min), limits.min);
        assert_int_equal(cut(object, limits.max), limits.max);
        assert_true(co_is(object, DG_CO_ID) || inside(object, dg_co_default(device, object)));
        if (co_is(object, DG_CO_ID)) {
            const uint32_t initial = dg_co_default(device, object);
            assert_in_range(initial & 0x7Fu, 0, 0); /* the node-ID has its place */
            assert_true(inside(object, initial + 1) && inside(object, initial + 127));
        }
    }
}

/* Figures of all models are those of rows that have some; each such row of the device has its. */
static void figures_belong_to_rows(void **state)
{
    static const struct dg_co_device *const devices[] = {
        &dg_cia406_singleturn, &dg_cia406_multiturn, &dg_cia406_multiturn_32};
    (void)state;

    for (size_t d = 0; d < DG_COUNT(devices); d++) {
        uint8_t next = 0;
        for (size_t i = 0; i < rows(); i++) {
            const bool may = co_is(row(i), DG_CO_FIGURE);
            const bool there =
                next < devices[d]->figure_count &&
                devices[d]->figures[next].key == DG_CO_KEY(row(i)->index, row(i)->sub);
            assert_true(may || !there);
            assert_true(!may || there || row(i)->index < 0x2000);
            next += there;
        }
        assert_int_equal(next, devices[d]->figure_count); /* sorted, none twice */
    }
    for (uint16_t i = 0; i < dg_co_common_dictionary.count;
         i++) { /* a second device needs no edit here */
        const uint16_t flags = dg_co_common_dictionary.rows[i].flags;
        const bool free = (flags & DG_CO_SAVE) != 0 && (flags & DG_CO_ID) == 0;
        assert_int_equal((flags & DG_CO_FIGURE) != 0, free);
    }
}

static void slots_belong_to_one_row(void **state)
{
    bool taken[DG_CO_VALUES_MAX] = {false};
    (void)state;

    for (size_t i = 0; i < rows(); i++) {
        const struct dg_co_object *object = row(i);
        if (!co_is(object, DG_CO_SLOT)) {
            assert_int_equal(object->row->slot, 0);
            continue;
        }
        assert_in_range(object->slot, 0, DG_CO_VALUES_MAX - 1);
        assert_false(taken[object->slot]);
        assert_int_equal(object->slot < DG_CO_SLOT_BIT_RATE, object->index < 0x2000);
        taken[object->slot] = true;
    }
    assert_true(taken[dg_co_slot_event_timer]);
}

static void flags_are_consistent(void **state)
{
    (void)state;
    for (size_t i = 0; i < rows(); i++) {
        const struct dg_co_object *object = row(i);
        const uint16_t flags = object->row->flags & 0xFFFu;
        assert_int_equal(flags & ~FLAGS, 0);
        assert_true((flags & DG_CO_RW) != 0);
        /* What is kept and cannot be written is the device's own to change. */
        assert_true((flags & DG_CO_SAVE) == 0 || (flags & DG_CO_RW) == DG_CO_RW ||
                    ((flags & DG_CO_R) != 0 && co_hook(object) != NULL));
        assert_true((flags & DG_CO_SAVE) == 0 || (flags & DG_CO_SLOT) != 0);
        assert_true((flags & DG_CO_EVENT) == 0 || (flags & DG_CO_MAP) != 0);
        assert_true((flags & DG_CO_GAP) == 0 || (flags & DG_CO_SAVE) != 0);
        assert_true((flags & DG_CO_MAP) == 0 || (flags & DG_CO_R) != 0);
        assert_true((flags & DG_CO_MAP) == 0 || co_size(object) != 0);
        assert_true((flags & DG_CO_MAP) == 0 || (object->row->key & 0xFu) == 0);
        assert_true((flags & DG_CO_CONST) == 0 || (flags & DG_CO_W) == 0);
        assert_true((flags & (DG_CO_ID | DG_CO_FIGURE)) == 0 || (flags & DG_CO_SLOT) != 0);
        /* What can be written is kept somewhere, or somebody looks at it. */
        assert_true((flags & DG_CO_W) == 0 || (flags & DG_CO_SLOT) != 0 || co_hook(object) != NULL);
    }
}

/* ------------------------------------------------------------ memory */

static bool is_parameters(uint8_t region)
{
    return region >= DG_CO_REGION_COMMUNICATION && region <= DG_CO_REGION_APPLICATION &&
           region != DG_CO_REGION_SERIAL;
}

static void regions_hold_exactly_their_rows(void **state)
{
    uint32_t size[DG_STORE_REGIONS_MAX] = {0};
    uint32_t journal = 6u + device->layout->regions[DG_CO_REGION_SAVED].size;
    (void)state;

    assert_in_range(device->layout->region_count, DG_CO_REGION_APPLICATION, DG_STORE_REGIONS_MAX);
    for (size_t i = 0; i < rows(); i++) {
        if (co_is(row(i), DG_CO_SAVE)) {
            assert_true(is_parameters(dg_co_region_of(row(i))));
            assert_true(dg_co_region_of(row(i)) < device->layout->region_count);
            size[dg_co_region_of(row(i))] += co_size(row(i)) + (co_is(row(i), DG_CO_GAP) ? 1u : 0u);
        }
    }
    for (uint8_t region = 0; region < device->layout->region_count; region++) {
        const struct dg_store_region *kept = &device->layout->regions[region];
        assert_int_equal(kept->check, DG_STORE_CHECKED);
        assert_in_range(kept->size, 1, DG_STORE_CHECKED_MAX);
        assert_int_equal(dg_store_find(device->layout, kept->name), region);
        assert_int_equal(kept->defaults == NULL, is_parameters(region));
        if (is_parameters(region)) {
            assert_int_equal(kept->size, size[region]);
            journal += 6u + kept->size;
        }
    }
    assert_true(journal <= device->layout->journal_size);
    assert_in_range(device->layout->regions[DG_CO_REGION_BUS].size, 3, 3);
}

/* The TPDO of a row of 1800h-1803h or 1A00h-1A03h is made ready for changes. */
static void unlock(const struct dg_co_object *object)
{
    const uint16_t n = object->index & 0xFFu;

    if (object->index < 0x1800 || object->index >= 0x2000) {
        return;
    }
    assert_int_equal(co_rig_write(&rig, (uint16_t)(0x1800 + n), 1, 0x80000000u, 4), 0);
    if (object->index >= 0x1A00) {
        assert_int_equal(co_rig_write(&rig, (uint16_t)(0x1A00 + n), 0, 0, 1), 0);
    }
}

/* Write something the row accepts and does not have; returns what. 6509h cannot be written: a
 * preset at position 0 brings it. */
static uint32_t change(const struct dg_co_object *object)
{
    static const uint32_t candidates[] = {0xC0000181u, 0x80000123u, 0x00120064u, 0x81u,
                                          0x60040020u, 0x21600020u, 2u,          1u};
    const uint32_t before = rig.node.value[object->slot];

    if (object->index == 0x6509) {
        assert_int_equal(co_rig_write(&rig, 0x6003, 0, 500, 4), 0);
        return 500;
    }
    for (size_t i = 0; i < DG_COUNT(candidates); i++) {
        const uint32_t wanted = cut(object, candidates[i]);
        if (wanted != before &&
            co_rig_write(&rig, object->index, object->sub, wanted, co_size(object)) == 0) {
            return wanted;
        }
    }
    fail_msg("%04Xh:%u takes nothing", object->index, object->sub);
    return 0;
}

static void every_saved_row_comes_back(void **state)
{
    uint32_t before[DG_CO_VALUES_MAX];
    unsigned saved = 0;
    (void)state;

    for (size_t i = 0; i < rows(); i++) {
        const struct dg_co_object *object = row(i);
        if (!co_is(object, DG_CO_SAVE)) {
            continue;
        }
        co_rig_start(&rig);
        unlock(object);
        const uint32_t wanted = change(object);
        memcpy(before, rig.node.value, sizeof before);
        assert_int_equal(co_rig_write(&rig, 0x1010, 1, SAVE, 4), 0);
        assert_int_equal(co_rig_power_on(&rig), DG_OK);
        assert_int_equal(rig.node.value[object->slot], wanted);
        for (size_t n = 0; n < rows(); n++) {
            /* Of what is measured nothing is kept. */
            if (co_is(row(n), DG_CO_SLOT) && !co_is(row(n), DG_CO_LIVE)) {
                assert_int_equal(rig.node.value[row(n)->slot], before[row(n)->slot]);
            }
        }
        saved++;
    }
    assert_true(saved > 80);
}

/* ------------------------------------------------------------ causes, CAN-IDs */

/* EMCY code, error register (chapter 15, C15; 8140h and 8240h: CiA 301), class of 1029h. */
static const struct {
    uint8_t cause;
    uint16_t code;
    uint8_t reg;
    uint8_t class_of;
} causes[] = {
    {DG_CO_CAUSE_OVERRUN, 0x8110, 0x11, 0},     {DG_CO_CAUSE_PASSIVE, 0x8120, 0x11, 0},
    {DG_CO_CAUSE_BUS_OFF, 0x8140, 0x11, 0},     {DG_CO_CAUSE_LIFE, 0x8130, 0x11, 1},
    {DG_CO_CAUSE_HEARTBEAT, 0x8130, 0x11, 1},   {DG_CO_CAUSE_HEARTBEAT_2, 0x8130, 0x11, 1},
    {DG_CO_CAUSE_SYNC_LENGTH, 0x8240, 0x11, 0}, {DG_CO_CAUSE_MEMORY, 0x5100, 0x01, 3},
};

static void causes_have_their_code_register_and_class(void **state)
{
    static const uint8_t details[5] = {1, 2, 3, 4, 5};
    (void)state;

    assert_int_equal(DG_COUNT(causes), DG_CO_CAUSES);
    assert_true(DG_CO_CAUSES + device->cause_count <= 32); /* active_causes */
    for (size_t i = 0; i < DG_COUNT(causes); i++) {
        co_rig_start(&rig);
        for (uint8_t sub = 1; sub <= 3; sub++) {
            const uint32_t behaviour = sub == causes[i].class_of ? 2 : 1;
            assert_int_equal(co_rig_write(&rig, 0x1029, sub, behaviour, 1), 0);
        }
        co_rig_forget(&rig);
        dg_co_raise(&rig.node, causes[i].cause, details);
        co_rig_expect_count(&rig, 1);
        assert_int_equal(rig.frame[0].id, 0xBF);
        const uint8_t wanted[8] = {
            (uint8_t)causes[i].code, (uint8_t)(causes[i].code >> 8), causes[i].reg, 1, 2, 3, 4, 5};
        assert_memory_equal(rig.frame[0].data, wanted, sizeof wanted);
        assert_int_equal(rig.node.state,
                         causes[i].class_of != 0 ? DG_CO_STOPPED : DG_CO_PRE_OPERATIONAL);
    }
}

/* CiA 301's restricted CAN-IDs. */
static bool restricted(uint32_t id)
{
    static const uint16_t ranges[][2] = {{0x000, 0x000}, {0x001, 0x07F}, {0x101, 0x180},
                                         {0x581, 0x5FF}, {0x601, 0x67F}, {0x6E0, 0x6FF},
                                         {0x701, 0x77F}, {0x780, 0x7FF}};

    for (size_t i = 0; i < DG_COUNT(ranges); i++) {
        if (id >= ranges[i][0] && id <= ranges[i][1]) {
            return true;
        }
    }
    return false;
}

/* And no others: which services share one is the master's business (C43). */
static void restricted_can_ids_are_refused(void **state)
{
    (void)state;
    co_rig_write(&rig, 0x1800, 1, 0x80000000u, 4);
    for (uint32_t id = 0; id <= 0x7FF; id++) {
        const uint32_t wanted = restricted(id) ? DG_CO_RANGE : DG_CO_OK;
        assert_int_equal(co_rig_write(&rig, 0x1005, 0, id, 4), wanted);
        assert_int_equal(co_rig_write(&rig, 0x1012, 0, id, 4), wanted);
        assert_int_equal(co_rig_write(&rig, 0x1012, 0, 0x80000000u | id, 4), wanted);
        assert_int_equal(co_rig_write(&rig, 0x1800, 1, id, 4), wanted);
        if (!restricted(id)) {
            assert_int_equal(co_rig_write(&rig, 0x1800, 1, 0x80000000u | id, 4), 0);
        }
    }
    assert_int_equal(co_rig_write(&rig, 0x1005, 0, 0x80, 4), 0);
    for (uint32_t bit = 0x800; bit != 0; bit <<= 1) { /* 29 bit CAN-IDs, reserved bits */
        assert_int_equal(co_rig_write(&rig, 0x1005, 0, bit | 0x80, 4), DG_CO_RANGE);
        assert_true(dg_co_restricted(bit | 0x80));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_are_sorted_and_unique),
        cmocka_unit_test_setup(rows_are_found_and_nothing_else, setup),
        cmocka_unit_test(arrays_and_records_have_a_sub_0),
        cmocka_unit_test(defaults_and_limits_fit_their_type),
        cmocka_unit_test(figures_belong_to_rows),
        cmocka_unit_test(slots_belong_to_one_row),
        cmocka_unit_test(flags_are_consistent),
        cmocka_unit_test(regions_hold_exactly_their_rows),
        cmocka_unit_test(every_saved_row_comes_back),
        cmocka_unit_test(causes_have_their_code_register_and_class),
        cmocka_unit_test_setup(restricted_can_ids_are_refused, setup),
    };
    return cmocka_run_group_tests(tests, list_rows, NULL);
}

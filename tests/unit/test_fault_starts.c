/* SPDX-License-Identifier: MIT */
/*
 * Faults that devices find when they start: a silent EEPROM, and a flipped bit in every checked
 * region, seen on the wire, then cleared.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "fault_rig.h"

#define SAVE 0x65766173u

/* ------------------------------------------------------------ silent when it starts */

static void power_co(void)
{
    dg_co_power_off(&fault_rig.co.node);
    co_rig_forget(&fault_rig.co);
    assert_int_equal(dg_co_power_on(&fault_rig.co.node, fault_rig.co.now), DG_OK);
}

static void test_rs485_that_starts_with_a_silent_memory(void **state)
{
    (void)state;
    fault_rig_start_hf();
    fault_rig_set("eeprom_silent");
    assert_int_equal(hf_rig_power_on(&fault_rig.hf), DG_OK);
    assert_int_equal(fault_rig_oldest(), 0x05);
    fault_rig_clear("eeprom_silent");
    assert_int_equal(hf_rig_ask(&fault_rig.hf, "42"), 0x02);
    assert_int_equal(hf_rig_ask(&fault_rig.hf, "43 00 00 00 00 55"), 0x02);
    assert_int_equal(hf_rig_ask(&fault_rig.hf, "6A 00 00 00 00 55"), 0x02);
    assert_int_equal(hf_rig_ask(&fault_rig.hf, "46"), 0x05);
    assert_int_equal(hf_rig_power_on(&fault_rig.hf), DG_OK);
    assert_int_equal(hf_rig_ask(&fault_rig.hf, "42"), 0);
    assert_int_equal(hf_rig_ask(&fault_rig.hf, "46"), 0);
}

static void test_slave_that_starts_with_a_silent_memory(void **state)
{
    (void)state;
    fault_rig_start_biss();
    fault_rig_set("eeprom_silent");
    assert_int_equal(biss_rig_power_on(&fault_rig.biss), DG_OK);
    fault_rig_clear("eeprom_silent");
    assert_int_equal(fault_rig_errors(), 0x10);
    assert_int_equal(biss_rig_put(&fault_rig.biss, 0x60, DG_BISS_CHECK), 1);
    fault_rig.biss.now += fault_rig.biss.model.eeprom_write;
    assert_int_equal(fault_rig_errors(), 0);
}

static void test_node_that_starts_with_a_silent_memory(void **state)
{
    (void)state;
    fault_rig_start_co();
    fault_rig_set("eeprom_silent");
    power_co();
    assert_int_equal(fault_rig_emcy(), 0x51001000);
    fault_rig_clear("eeprom_silent");
    (void)fault_rig_emcy();
    assert_int_equal(co_rig_get(&fault_rig.co, 0x1002, 0), 1u << DG_CO_CAUSE_MEMORY);
    power_co();
    assert_int_equal(fault_rig_emcy(), 0);
}

static void test_k3_that_starts_with_a_silent_memory(void **state)
{
    (void)state;
    fault_rig_start_k3();
    fault_rig_set("eeprom_silent");
    assert_int_equal(ib_rig_power_on(&fault_rig.ib), DG_OK);
    assert_int_equal(ib_rig_cycle(&fault_rig.ib, 0), DG_IB_LOST);
    fault_rig_clear("eeprom_silent");
    assert_int_equal(ib_rig_cycle(&fault_rig.ib, 0), DG_IB_LOST);
    assert_int_equal(ib_rig_power_on(&fault_rig.ib), DG_OK);
    assert_int_equal(ib_rig_cycle(&fault_rig.ib, 0), 0);
}

/* ------------------------------------------------------------ the memory */

/* What a device says after a start; `code` is the region's. */
static uint32_t start_up_hf(const struct dg_fault_entry *entry)
{
    uint32_t codes = 0;

    assert_int_equal(hf_rig_power_on(&fault_rig.hf), DG_OK);
    for (unsigned i = 0; i < DG_HF_STACK_DEPTH; i++) {
        assert_int_equal(hf_rig_ask(&fault_rig.hf, "50"), 0);
        codes = fault_rig.hf.reply[2] != 0 ? codes << 8 | fault_rig.hf.reply[2] : codes;
    }
    return codes == ((uint32_t)entry->code << 8 | DG_HF_CHECKSUM_INTERNAL) ? 1 : codes;
}

static uint32_t start_up_biss(const struct dg_fault_entry *entry)
{
    assert_int_equal(biss_rig_power_on(&fault_rig.biss), DG_OK);
    assert_int_equal(entry->code, DG_BISS_CONFIGURATION);
    return fault_rig_errors() == entry->code && fault_rig_states() == 1 ? 1 : fault_rig_errors();
}

static uint32_t start_up_co(const struct dg_fault_entry *entry)
{
    const uint32_t wanted = strcmp(entry->name, "eeprom_usf") == 0 ? 0x6200 : 0x5100;

    power_co();
    const uint32_t seen = fault_rig_emcy();
    return seen == wanted ? 1 : seen;
}

static uint32_t start_up_ib(const struct dg_fault_entry *entry)
{
    const bool counts = strcmp(entry->name, "eeprom_time") == 0;

    assert_int_equal(ib_rig_power_on(&fault_rig.ib), DG_OK);
    const uint32_t in = ib_rig_cycle(&fault_rig.ib, 0);
    if (counts) { /* a bit of it was flipped: it is not 0 unless it began anew */
        assert_int_equal(fault_rig.ib.device.time_10min, 0);
        assert_int_equal(in, 0);
        return dg_store_damaged(&fault_rig.ib.device.store, entry->region);
    }
    return in == DG_IB_LOST ? 1 : in;
}

/* The scaling function has to be on for its region to mean anything. */
static void start_co_usf(void)
{
    fault_rig_start_co();
    co_rig_put(&fault_rig.co, 0x6002, 0, 1000, 4);
    co_rig_put(&fault_rig.co, 0x6000, 0, DG_CIA406_SCALING | DG_CIA406_USF, 2);
    co_rig_put(&fault_rig.co, 0x6003, 0, 0, 4);
    co_rig_put(&fault_rig.co, 0x1010, 1, SAVE, 4);
    co_rig_run(&fault_rig.co, DG_S(1));
    co_rig_forget(&fault_rig.co);
}

static const struct memory {
    void (*start)(void);
    uint32_t (*start_up)(const struct dg_fault_entry *entry);
    size_t regions;
} memories[] = {
    {fault_rig_start_hf, start_up_hf, 13},
    {fault_rig_start_biss, start_up_biss, DG_BISS_REGION_COUNT},
    {start_co_usf, start_up_co, 11},
    {fault_rig_start_k3, start_up_ib, DG_IB_REGION_COUNT},
};

static size_t damage_every_region(const struct memory *memory)
{
    struct dg_fault_entry entry;
    size_t count = 0;

    memory->start();
    for (size_t i = 0; dg_fault_entry(&fault_rig.target, i, &entry); i++) {
        if (entry.kind != DG_FAULT_MEMORY) {
            continue;
        }
        const uint32_t before = memory->start_up(&entry);
        assert_int_equal(before, 0);
        assert_int_equal(
            dg_fault_set(&fault_rig.faults, &fault_rig.target, i, 0, &fault_rig_forever), DG_OK);
        const uint32_t seen = memory->start_up(&entry);
        if (seen != 1) {
            fail_msg("%s: %Xh", entry.name, seen);
        }
        assert_int_equal(dg_fault_clear(&fault_rig.faults, &fault_rig.target, i), DG_OK);
        assert_int_equal(memory->start_up(&entry), 0);
        count++;
    }
    return count;
}

static void test_every_checked_region(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(memories); i++) {
        assert_int_equal(damage_every_region(&memories[i]), memories[i].regions);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rs485_that_starts_with_a_silent_memory),
        cmocka_unit_test(test_slave_that_starts_with_a_silent_memory),
        cmocka_unit_test(test_node_that_starts_with_a_silent_memory),
        cmocka_unit_test(test_k3_that_starts_with_a_silent_memory),
        cmocka_unit_test(test_every_checked_region),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}

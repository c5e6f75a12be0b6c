/* SPDX-License-Identifier: MIT */
/*
 * Words that nobody looks at leave behind what they would have left behind: n of them counted are
 * n of them clocked. A word of all four kinds of trouble: too fast, begun again, and broken off.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "ssi_rig.h"

static struct ssi_rig clocked;
static struct ssi_rig skipped;

/* A word and a half at 4 MHz, or one that is whole; the shaft is at rest. */
static void read_words(struct ssi_rig *rig, bool troubled)
{
    rig->low_ns = rig->high_ns = troubled ? 125 : 500;
    (void)ssi_rig_take(rig, troubled ? 40 : 25);
    (void)ssi_rig_wait(rig, DG_US(100));
}

static void start_encoder(struct ssi_rig *rig, bool troubled)
{
    assert_int_equal(ssi_rig_init(rig, dg_ssi_model_of(dg_device_find("ssi-25"))), DG_OK);
    ssi_rig_power_on(rig);
    read_words(rig, troubled);
}

static void skip_and_compare(uint64_t n, bool troubled)
{
    start_encoder(&clocked, troubled);
    start_encoder(&skipped, troubled);
    const struct dg_ssi_counters each = skipped.device.counters;
    for (uint64_t i = 0; i < n; i++) {
        read_words(&clocked, troubled);
    }
    const struct dg_ssi before = skipped.device;
    dg_ssi_skip(&skipped.device, &each, n);
    assert_memory_equal(&skipped.device.counters, &clocked.device.counters, sizeof each);
    assert_int_equal(skipped.device.word, clocked.device.word);
    /* Nothing else changes: the next word is read as ever. */
    skipped.device.counters = before.counters;
    assert_memory_equal(&skipped.device, &before, sizeof before);
}

static void whole_words_are_counted(void **state)
{
    (void)state;
    for (uint64_t n = 0; n < 20; n++) {
        skip_and_compare(n, false);
        assert_int_equal(skipped.device.counters.frames, clocked.device.counters.frames - n);
    }
    assert_int_equal(clocked.device.counters.frames, 20);
    assert_int_equal(clocked.device.counters.repeats + clocked.device.counters.aborted, 0);
}

static void what_was_wrong_with_each_is_counted(void **state)
{
    (void)state;
    skip_and_compare(1000, true);
    assert_int_equal(clocked.device.counters.frames, 1001);
    assert_int_equal(clocked.device.counters.repeats, 1001);
    assert_int_equal(clocked.device.counters.aborted, 1001);
    assert_int_equal(clocked.device.counters.fast, 39 * 1001);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_words_are_counted),
        cmocka_unit_test(what_was_wrong_with_each_is_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

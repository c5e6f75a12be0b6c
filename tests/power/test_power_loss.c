/* SPDX-License-Identifier: MIT */
/*
 * Every state in which a power cut may leave the memory of each device, and what the store makes of
 * it: the model of src/core/README.md. DREHGEBER_POWER_LIMIT: states for each moment of a change.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
#include "model.h"

#define LIMIT_USUAL 1000u
#define SMALL_MORE 90 /* and for the small layout so many times as many */
#define STATES_LEAST 3000000u
#define TRIES 40
#define ERRORS_MAX 6u
#define DEVICES 5u

/* --- layouts --- */

static void small_defaults(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memcpy(out, "abc", 3);
}

/* So small that every combination of every fate can be looked at. */
/* clang-format off */
static const struct dg_store_region small_regions[] = {
    {"count", 3, DG_STORE_CHECKED, 0x05, small_defaults},
    {"notes", 9, DG_STORE_RAW,     0,    NULL},
    {"limit", 2, DG_STORE_CHECKED, 0x12, NULL},
};
/* clang-format on */
static const struct dg_store_layout small_layout = {0x4C4C4D53, 24, 3, small_regions};

static const uint32_t serial = 12345678;

struct device {
    const char *name;
    const struct dg_store_layout *layout;
    const void *ctx;
    uint8_t step; /* every so many changes are tried with errors, and so many older releases */
};
static struct device devices[DEVICES];
static unsigned long long all_states, all_recovery_states;

static struct model model;
static struct lossy_nvm nvm;
static struct dg_store store;
static struct lossy_nvm start_nvm; /* where a change begins */
static struct dg_store start_store;

static uint64_t limit(void)
{
    const char *text = getenv("DREHGEBER_POWER_LIMIT");
    return text == NULL || text[0] == '\0' ? LIMIT_USUAL : strtoull(text, NULL, 10);
}

/* --- changes --- */

static uint32_t journalled(const struct model_change *change)
{
    uint32_t n = 0;
    for (uint8_t p = 0; p < change->count; p++) {
        n += 6u + change->part[p].n;
    }
    return n;
}

/* All of a checked region; up to `most` bytes of another one, at either end. */
static void add(struct model_change *change, uint8_t region, uint32_t most)
{
    const struct dg_store_region *row = &model.layout->regions[region];
    const uint32_t room = model.layout->journal_size - journalled(change);
    uint32_t n = row->size;
    if (row->check == DG_STORE_RAW && n > most) {
        n = most;
    }
    if (room < 6 + n || n == 0 || change->count == MODEL_PARTS) {
        return;
    }
    change->part[change->count].region = region;
    change->part[change->count].offset = change->seed % 2 == 0 ? 0 : (uint16_t)(row->size - n);
    change->part[change->count++].n = (uint16_t)n;
}

/* Number `nth`: each region alone, each with the next one, each twice, and all that fit. */
static bool make_change(struct model_change *change, uint32_t nth)
{
    const uint8_t count = model.layout->region_count;
    const uint8_t region = (uint8_t)(nth % count);
    const uint32_t journal = model.layout->journal_size;
    const uint32_t half = (journal - 12) / 2;
    *change = (struct model_change){.seed = (uint8_t)(nth + 1)};
    if (nth == 3u * count) {
        for (uint8_t i = 0; i < count; i++) {
            add(change, i, half);
        }
    } else if (nth < count) {
        add(change, region, journal - 6);
    } else {
        add(change, region, half);
        const unsigned other = nth < 2u * count ? (region + 1u) % count : region;
        add(change, (uint8_t)other, half);
    }
    return nth <= 3u * count;
}

/* --- one change --- */

static struct model_run begin(const struct model_change *again)
{
    nvm = start_nvm;
    store = start_store;
    nvm.calls = 0;
    return (struct model_run){&model, &nvm,
                              model_start(&model, nvm.bytes, model.layout->region_count), 0, again};
}

static void cut_in(const struct model_change *change)
{
    struct model_run run = begin(change);
    assert_int_equal(model_commit(&run, &store, change), DG_OK);
}

/* The process ends before one operation, another one takes over; then the power is cut. */
static void end_process_in(const struct model_change *change)
{
    for (uint32_t nth = 0;; nth++) {
        struct model_run run = begin(NULL);
        nvm.die_at = nth;
        if (model_commit(&run, &store, change) == DG_OK && nvm.calls <= nth) {
            break;
        }
        nvm.die_at = LOSSY_NVM_NEVER;
        assert_int_equal(model_take_over(&run, &store), DG_OK);
    }
}

/* Try until it works: what a command of the wire and the next one do. */
static void persist(struct model_run *run, const struct model_change *change)
{
    int result = DG_ERR_IO;
    for (int i = 0; result != DG_OK; i++) {
        assert_true(i < TRIES);
        (void)model_read(run, &store);
        result = model_commit(run, &store, change);
    }
}

/* One to six operations fail, from each one on. */
static void fail_in(const struct model_change *change)
{
    for (uint32_t i = 0;; i++) {
        const uint32_t from = i / ERRORS_MAX;
        struct model_run run = begin(NULL);
        nvm.through = (enum lossy_nvm_through)(i % LOSSY_NVM_THROUGHS);
        nvm.fail_from = from;
        nvm.fail_to = from + 1 + i % ERRORS_MAX;
        const int result = model_commit(&run, &store, change);
        if (nvm.calls <= from) {
            assert_int_equal(result, DG_OK);
            break;
        }
        persist(&run, change);
    }
}

static uint32_t calls_of(const struct model_change *change)
{
    (void)begin(NULL);
    assert_int_equal(model_stage(&store, change), DG_OK);
    assert_int_equal(dg_store_commit(&store), DG_OK);
    return nvm.calls;
}

/* Errors in a start, after a process that ended while the change was put in place. */
static void fail_while_starting_in(const struct model_change *change)
{
    const uint32_t die_at = calls_of(change) * 2 / 3;
    uint32_t calls = LOSSY_NVM_NEVER;
    for (uint32_t i = 0; i / ERRORS_MAX < calls; i++) {
        struct model_run run = begin(NULL);
        nvm.die_at = die_at;
        (void)model_commit(&run, &store, change);
        nvm.die_at = LOSSY_NVM_NEVER;
        nvm.calls = 0;
        nvm.through = (enum lossy_nvm_through)(i % LOSSY_NVM_THROUGHS);
        nvm.fail_from = i / ERRORS_MAX;
        nvm.fail_to = nvm.fail_from + 1 + i % ERRORS_MAX;
        int result = DG_ERR_IO;
        for (int attempt = 0; attempt < TRIES && result == DG_ERR_IO; attempt++) {
            result = model_take_over(&run, &store);
        }
        assert_int_equal(result, DG_OK);
        calls = nvm.calls;
    }
}

/* --- a device --- */

static void set_up(const struct device *device)
{
    const uint64_t more = device == devices ? SMALL_MORE : 1;
    assert_int_equal(model_init(&model, device->name, device->layout, device->ctx, more * limit()),
                     DG_OK);
    lossy_nvm_init(&nvm, model.delivered, dg_store_size(model.layout));
    assert_int_equal(dg_store_mount(&store, model.layout, lossy_nvm_port(&nvm)), DG_OK);
    start_nvm = nvm;
    start_store = store;
}

static void assert_right(const char *what)
{
    print_message("%s, %s: %llu states, %llu of them inside a recovery; %llu different images; "
                  "every combination in %llu of %llu moments\n",
                  model.name, what, (unsigned long long)model.states,
                  (unsigned long long)model.recovery_states, (unsigned long long)model.images,
                  (unsigned long long)model.whole_moments, (unsigned long long)model.moments);
    all_states += model.states;
    all_recovery_states += model.recovery_states;
    if (model.violations != 0) {
        fail_msg("%llu violations; %s", (unsigned long long)model.violations, model.first);
    }
    model_free(&model);
}

/* The next change begins where this one has ended, its last write not synced. */
static void go_on(const struct model_change *change)
{
    nvm = start_nvm;
    store = start_store;
    assert_int_equal(model_stage(&store, change), DG_OK);
    assert_int_equal(dg_store_commit(&store), DG_OK);
    start_nvm = nvm;
    start_store = store;
}

static void cut_everywhere(void)
{
    struct model_change change;
    for (uint32_t nth = 0; make_change(&change, nth); nth++) {
        cut_in(&change);
        go_on(&change);
    }
}

/* A process that ends, or operations that fail, and then the power cut. */
static void fail_everywhere(uint32_t step)
{
    struct model_change change;
    for (uint32_t nth = 0; make_change(&change, nth); nth++) {
        end_process_in(&change);
        if (nth % (2 * step) == 1) {
            fail_in(&change);
            fail_while_starting_in(&change);
        }
        go_on(&change);
    }
}

static void grow_everything(uint8_t step)
{
    for (uint8_t old = 1; old < model.layout->region_count; old = (uint8_t)(old + step)) {
        struct dg_store_layout layout = *model.layout;
        uint8_t image[LOSSY_NVM_MAX];
        layout.region_count = old;
        memset(image, 0x5A, sizeof image);
        lossy_nvm_init(&nvm, image, dg_store_size(model.layout));
        assert_int_equal(dg_store_format(&layout, lossy_nvm_port(&nvm), model.ctx), DG_OK);
        struct model_run run = {&model, &nvm, model_start(&model, nvm.bytes, old), 0, NULL};
        assert_int_equal(model_take_over(&run, &store), DG_OK);
        assert_int_equal(store.region_count, model.layout->region_count);
    }
}

static void format_everything(void)
{
    struct model_change change;
    for (uint32_t nth = 0; nth < 3 && make_change(&change, nth); nth++) {
        go_on(&change);
        struct model_run run = begin(NULL);
        assert_int_equal(model_format(&run), DG_OK);
    }
}

/* --- tests --- */

static void a_change_is_there_or_not_wherever_the_power_is_cut(void **state)
{
    set_up(*state);
    cut_everywhere();
    assert_right("cut");
}

static void also_behind_errors_and_ended_processes(void **state)
{
    const struct device *device = *state;
    set_up(device);
    model.limit = limit() / 30;
    model.cuts = 1;
    fail_everywhere(device->step);
    assert_right("errors and cut");
}

static void an_older_image_stays_or_grows(void **state)
{
    const struct device *device = *state;
    set_up(device);
    grow_everything(device->step);
    assert_right("growing");
}

static void a_format_leaves_the_old_image_or_none_or_the_new_one(void **state)
{
    set_up(*state);
    format_everything();
    assert_right("formatting");
}

/* Each sync of the store is one that it cannot do without. Left out are the last ones of growing
   and formatting: the header in front is durable then, and a lost copy of it is repaired. */
static void the_model_notices_a_sync_that_is_missing(void **state)
{
    (void)state;
    static const struct {
        enum model_operation operation;
        uint32_t sync;
    } missing[] = {
        {MODEL_COMMIT, 0}, {MODEL_COMMIT, 1}, {MODEL_MOUNT, 0},  {MODEL_MOUNT, 1},
        {MODEL_GROW, 0},   {MODEL_GROW, 1},   {MODEL_FORMAT, 0}, {MODEL_FORMAT, 1},
        {MODEL_FORMAT, 2}, {MODEL_FORMAT, 3},
    };
    for (size_t i = 0; i < DG_COUNT(missing); i++) {
        set_up(devices);
        model.broken = missing[i].operation;
        /* Both marks torn, with a cleared journal under way: two differences from all that is
         * there. */
        model.limit = model.broken == MODEL_FORMAT ? 10 * LIMIT_USUAL : LIMIT_USUAL;
        model.skip = missing[i].sync;
        if (model.broken == MODEL_GROW) {
            grow_everything(1);
        } else if (model.broken == MODEL_FORMAT) {
            format_everything();
        } else {
            cut_everywhere();
            fail_everywhere(1);
        }
        print_message("without sync %u of operation %d: %llu violations; %s\n", missing[i].sync,
                      (int)missing[i].operation, (unsigned long long)model.violations, model.first);
        assert_true(model.violations > 0);
        model_free(&model);
    }
}

static int print_total(void **state)
{
    (void)state;
    print_message("power loss: %llu states, %llu of them inside a recovery\n", all_states,
                  all_recovery_states);
    return all_states >= STATES_LEAST ? 0 : -1;
}

static int list_devices(void **state)
{
    (void)state;
    devices[0] = (struct device){"small", &small_layout, NULL, 1};
    devices[1] = (struct device){"HIPERFACE", &dg_hf_layout,
                                 dg_hf_model_of(dg_device_find("s3684-rs485")), 4};
    devices[2] = (struct device){"BiSS", &dg_biss_layout, NULL, 12};
    devices[3] = (struct device){
        "CANopen", dg_cia406_model_of(dg_device_find("f3668"))->device->layout, &serial, 2};
    devices[4] =
        (struct device){"INTERBUS", &dg_ib_layout, dg_ib_model_of(dg_device_find("ocd-ib-k3")), 7};
    return 0;
}

int main(void)
{
    static const CMUnitTestFunction functions[] = {
        a_change_is_there_or_not_wherever_the_power_is_cut,
        also_behind_errors_and_ended_processes,
        an_older_image_stays_or_grows,
        a_format_leaves_the_old_image_or_none_or_the_new_one,
    };
    static const char *const names[] = {"a change", "errors", "growing", "formatting"};
    struct CMUnitTest tests[4 * DEVICES + 1];
    for (size_t i = 0; i < 4 * DEVICES; i++) {
        tests[i] = (struct CMUnitTest){.name = names[i / DEVICES],
                                       .test_func = functions[i / DEVICES],
                                       .initial_state = &devices[i % DEVICES]};
    }
    tests[4 * DEVICES] =
        (struct CMUnitTest)cmocka_unit_test(the_model_notices_a_sync_that_is_missing);
    return cmocka_run_group_tests_name("power loss", tests, list_devices, print_total);
}

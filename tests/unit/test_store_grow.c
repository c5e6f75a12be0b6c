/* SPDX-License-Identifier: MIT */
/*
 * A layout that has grown takes over the images of its predecessors: of each length, with the power
 * failing in each write, after each operation that fails, and with a journal left behind.
 *
 * The regions end where the headers of two of them, torn into each other, are the header of a third
 * one: 0110h and 0130h, 01F0h and 0210h.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/store.h"
#include "effort.h"
#include "ram_nvm.h"

enum region { SERIAL, LIMITS, NOTES, SUMS, USER, LABEL, REGIONS };

enum { COPY = 12, JOURNAL = 24, CHANGES = 32, BEHIND = 16, SIZE = 0x340 };

static const char *const ctx = "Fourteen bytes, and more";

static void fives(const void *unused, uint8_t *out)
{
    (void)unused;
    memset(out, 5, 30);
}

static void text14(const void *from, uint8_t *out)
{
    memcpy(out, from, 14);
}

static void text14_in_32(const void *from, uint8_t *out)
{
    memset(out, '.', 32);
    memcpy(out, from, 14);
}

/* clang-format off */
static const struct dg_store_region regions[REGIONS] = {
    /* name     size check             code  defaults       ends at */
    {"serial",  94,  DG_STORE_CHECKED, 0x05, NULL},         /* 0110h */
    {"limits",  30,  DG_STORE_CHECKED, 0x06, fives},        /* 0130h */
    {"notes",   192, DG_STORE_RAW,     0,    NULL},         /* 01F0h */
    {"sums",    32,  DG_STORE_RAW,     0,    text14_in_32}, /* 0210h */
    {"user",    288, DG_STORE_RAW,     0,    NULL},         /* 0330h */
    {"label",   14,  DG_STORE_CHECKED, 0x07, text14},       /* 0340h */
};
static const uint32_t ends[REGIONS + 1] = {0xB0, 0x110, 0x130, 0x1F0, 0x210, 0x330, SIZE};
/* clang-format on */

#define LAYOUT(count)                                                                              \
    {                                                                                              \
        0x57475344, 144, (count), regions                                                          \
    }

/* The table of each release: the one with n regions, and the one of today. */
static const struct dg_store_layout layouts[REGIONS + 1] = {
    LAYOUT(0), LAYOUT(1), LAYOUT(2), LAYOUT(3), LAYOUT(4), LAYOUT(5), LAYOUT(6),
};

static struct ram_nvm ram;
static struct dg_store store;
static uint32_t calls, fail_at; /* so far; the one that fails */
static size_t length;           /* of the last write */

/* Writes since the last sync. */
static struct {
    uint32_t address;
    size_t n;
} pending[64];
static size_t pending_count;

/* Bytes as they were; most of the memory is not in use. */
static void rewind_to(const struct ram_nvm *start)
{
    memcpy(&ram, start, offsetof(struct ram_nvm, bytes) + SIZE + BEHIND);
    memcpy(ram.synced, start->synced, SIZE + BEHIND);
}

static bool fails(void)
{
    return calls++ == fail_at;
}

static int test_read(void *to, uint32_t address, void *bytes, size_t n)
{
    return fails() ? DG_ERR_IO : ram_nvm_port(to).ops->read(to, address, bytes, n);
}

static int test_write(void *to, uint32_t address, const void *bytes, size_t n)
{
    length = n;
    assert_true(pending_count < DG_COUNT(pending));
    pending[pending_count].address = address;
    pending[pending_count++].n = n;
    return fails() ? DG_ERR_IO : ram_nvm_port(to).ops->write(to, address, bytes, n);
}

static int test_sync(void *to)
{
    pending_count = 0;
    return fails() ? DG_ERR_IO : ram_nvm_port(to).ops->sync(to);
}

static const struct dg_nvm_ops ops = {test_read, test_write, test_sync};
static const struct dg_nvm nvm = {&ops, &ram};

static int mount(uint8_t count)
{
    return dg_store_mount(&store, &layouts[count], nvm);
}

/* As the devices start. */
static int take_over(uint8_t count)
{
    const int result = mount(count);
    return result == DG_ERR_OLDER ? dg_store_grow(&store, ctx) : result;
}

/* What an owner puts into a region, its first 100 bytes at most: never what is delivered. */
static uint16_t fill(uint8_t region, char version, uint8_t *bytes)
{
    const uint16_t n = regions[region].size < 100 ? regions[region].size : 100;
    for (uint16_t i = 0; i < n; i++) {
        bytes[i] = (uint8_t)(version + region + i);
    }
    return n;
}

static int put_version(uint8_t region, char version)
{
    uint8_t bytes[100];
    const uint16_t n = fill(region, version, bytes);
    return dg_store_put(&store, region, 0, bytes, n);
}

/* All of its regions have been put; behind it is something else. */
static void make_image(uint8_t count)
{
    ram_nvm_init(&ram, SIZE + BEHIND);
    memset(ram.bytes, 0x5A, ram.size);
    calls = 0;
    fail_at = UINT32_MAX;
    assert_int_equal(dg_store_format(&layouts[count], nvm, ctx), DG_OK);
    assert_int_equal(mount(count), DG_OK);
    for (uint8_t region = 0; region < count; region++) {
        assert_int_equal(put_version(region, 'a'), DG_OK);
    }
    assert_int_equal(mount(count), DG_OK);
}

static bool has_defaults(uint8_t region)
{
    uint8_t found[288];
    uint8_t right[288];
    memset(right, 0xFF, sizeof right);
    if (regions[region].defaults != NULL) {
        regions[region].defaults(ctx, right);
    }
    return dg_store_read(&store, region, 0, found, regions[region].size) == DG_OK &&
           memcmp(found, right, regions[region].size) == 0;
}

static bool has(uint8_t region, char version)
{
    uint8_t found[288];
    uint8_t right[288];
    memset(right, 0xFF, sizeof right);
    (void)fill(region, version, right);
    return dg_store_read(&store, region, 0, found, regions[region].size) == DG_OK &&
           memcmp(found, right, regions[region].size) == 0;
}

/* The first `old` regions hold what was put there, the next ones up to `count` are as delivered. */
static void assert_taken_over(uint8_t old, uint8_t count)
{
    assert_int_equal(store.region_count, count);
    assert_int_equal(store.damaged, 0);
    for (uint8_t region = 0; region < count; region++) {
        assert_true(region < old ? has(region, 'a') : has_defaults(region));
    }
}

/* Both headers are those of `count` regions, and nothing behind them was touched. */
static void assert_image(uint8_t count)
{
    const uint8_t header[COPY] = {
        'd', 'g', 'e', '1', 'D', 'S', 'G', 'W', (uint8_t)ends[count], (uint8_t)(ends[count] >> 8)};
    assert_memory_equal(ram.bytes, header, COPY);
    assert_memory_equal(ram.bytes + COPY, header, COPY);
    for (uint32_t i = ends[count]; i < ram.size; i++) {
        assert_int_equal(ram.bytes[i], 0x5A);
    }
}

static void the_regions_end_where_it_is_said(void **state)
{
    (void)state;
    for (uint8_t count = 1; count <= REGIONS; count++) {
        assert_int_equal(dg_store_size(&layouts[count]), ends[count]);
    }
}

static void an_older_image_keeps_its_values_and_gets_defaults_for_what_is_new(void **state)
{
    (void)state;
    for (uint8_t count = 2; count <= REGIONS; count++) {
        for (uint8_t old = 1; old < count; old++) {
            make_image(old);
            assert_int_equal(take_over(count), DG_OK);
            assert_taken_over(old, count);
            assert_image(count);
            assert_memory_equal(ram.synced, ram.bytes, ram.size);
            const uint32_t writes = ram.writes;
            assert_int_equal(mount(count), DG_OK);
            assert_taken_over(old, count);
            assert_int_equal(ram.writes, writes);
            assert_int_equal(store.repairs + store.replays + store.failures, 0);
        }
    }
}

static void until_it_has_grown_only_old_regions_are_there(void **state)
{
    uint8_t byte = 0;
    (void)state;
    make_image(3);
    const uint32_t writes = ram.writes;
    assert_int_equal(mount(REGIONS), DG_ERR_OLDER);
    assert_int_equal(store.region_count, 3);
    assert_int_equal(store.failures, 0);
    assert_true(has(LIMITS, 'a') && has(NOTES, 'a'));
    assert_int_equal(dg_store_read(&store, SUMS, 0, &byte, 1), DG_ERR_ARGUMENT);
    assert_int_equal(dg_store_put(&store, SUMS, 0, &byte, 1), DG_ERR_ARGUMENT);
    assert_int_equal(ram.writes, writes);
    assert_image(3);
    assert_int_equal(dg_store_grow(&store, ctx), DG_OK);
    assert_int_equal(put_version(SUMS, 'b'), DG_OK);
    assert_int_equal(put_version(LABEL, 'b'), DG_OK);
    assert_int_equal(mount(REGIONS), DG_OK);
    assert_true(has(NOTES, 'a') && has(SUMS, 'b') && has(LABEL, 'b'));
}

/* Damage is the device's to report; a longer image is a later release's. */
static void damage_stays_and_later_images_are_foreign(void **state)
{
    (void)state;
    make_image(2);
    ram.bytes[ends[1]] ^= 1; /* of "limits" */
    assert_int_equal(take_over(REGIONS), DG_OK);
    assert_int_equal(store.damaged, 1u << LIMITS);
    assert_int_equal(mount(REGIONS), DG_OK);
    assert_int_equal(store.damaged, 1u << LIMITS);
    const uint32_t writes = ram.writes;
    for (uint8_t count = 1; count < REGIONS; count++) {
        assert_int_equal(mount(count), DG_ERR_FOREIGN);
    }
    struct dg_store_layout other = layouts[REGIONS];
    other.id++;
    assert_int_equal(dg_store_mount(&store, &other, nvm), DG_ERR_FOREIGN);
    memset(ram.bytes, 0xFF, 24); /* both headers: formatting was not begun */
    assert_int_equal(mount(REGIONS), DG_ERR_BLANK);
    assert_false(dg_store_unfinished(&layouts[REGIONS], nvm));
    /* A byte where the headers are is somebody's; what stands behind them may be left of anything.
     */
    for (uint32_t at = 0; at <= JOURNAL; at++) {
        memset(ram.bytes, 0xFF, sizeof ram.bytes);
        ram.bytes[at] = 0;
        assert_int_equal(mount(REGIONS), at < JOURNAL ? DG_ERR_FOREIGN : DG_ERR_BLANK);
    }
    assert_int_equal(ram.writes, writes);
}

/* One header rotten, or torn into another one that would be right, too: the copy knows better. */
static void a_damaged_header_does_not_shorten_the_image(void **state)
{
    const uint32_t step = effort(7, 1); /* 255 is no multiple of it: other values in each byte */
    (void)state;
    make_image(3);
    const struct ram_nvm start = ram;
    for (uint32_t i = 0; i < 24u * 255u; i += step) {
        rewind_to(&start);
        ram.bytes[i / 255] ^= (uint8_t)(i % 255 + 1);
        assert_int_equal(mount(4), DG_ERR_OLDER);
        assert_int_equal(store.repairs, 1);
        assert_int_equal(store.region_count, 3);
        assert_int_equal(dg_store_grow(&store, ctx), DG_OK);
        assert_taken_over(3, 4);
        assert_image(4);
    }
    make_image(3);
    ram.bytes[8] = 0x10; /* 0110h: "serial" alone */
    assert_int_equal(mount(4), DG_ERR_OLDER);
    assert_int_equal(store.region_count, 3);
    assert_image(3);
}

/* --- the power fails --- */

/* In which write, how, after how many bytes, and which writes overtake. */
struct cut {
    enum ram_nvm_tear tear;
    uint32_t nth, tear_at, parity;
};

static void next_cut(struct cut *cut)
{
    if (cut->tear != RAM_NVM_UNSYNCED && cut->tear_at < length) {
        const uint32_t next = cut->tear_at + effort(3, 1);
        cut->tear_at = next < length ? next : (uint32_t)length;
        return;
    }
    cut->tear_at = 0;
    cut->parity = cut->tear == RAM_NVM_REORDERED ? 1 - cut->parity : 0;
    cut->tear += cut->parity == 0;
    if (cut->tear == RAM_NVM_TEAR_COUNT) {
        *cut = (struct cut){RAM_NVM_ORDERED, cut->nth + 1, 0, 0};
    }
}

/* What is left is an image of the older release or of this one; either is taken over. */
static void assert_either(uint8_t old, uint8_t count)
{
    const int result = mount(count);
    assert_true(result == DG_OK || result == DG_ERR_OLDER);
    assert_in_range(store.region_count, old, count);
    assert_taken_over(old, store.region_count);
}

/* Take over with a cut in every write; what the cuts leave is taken over with cuts again. */
static uint32_t cut_everywhere(uint8_t old, uint8_t count, uint32_t depth)
{
    const struct ram_nvm start = ram;
    struct cut cut = {RAM_NVM_ORDERED, 0, 0, 0};
    uint32_t cuts = 0;
    while (true) {
        rewind_to(&start);
        ram.writes = cut.parity;
        ram_nvm_cut(&ram, cut.nth, cut.tear, cut.tear_at);
        const int result = take_over(count);
        if (!ram.dead) {
            assert_int_equal(result, DG_OK);
            break;
        }
        assert_int_equal(result, DG_ERR_IO);
        const struct cut done = cut;
        next_cut(&cut);
        ram_nvm_restore(&ram);
        if (depth > 0 && done.tear_at % 9 == 0) {
            cuts += cut_everywhere(old, count, depth - 1);
            ram_nvm_restore(&ram);
        }
        assert_either(old, count);
        assert_int_equal(take_over(count), DG_OK);
        assert_taken_over(old, count);
        assert_image(count);
        cuts++;
    }
    assert_taken_over(old, count);
    return cuts;
}

static void a_power_cut_leaves_the_older_image_or_the_grown_one(void **state)
{
    (void)state;
    for (uint8_t old = 1; old < REGIONS; old++) {
        make_image(old);
        assert_true(cut_everywhere(old, REGIONS, 0) > effort(40, 100));
    }
    make_image(3); /* the headers torn into each other: 0110h */
    assert_true(cut_everywhere(3, 4, 1) > 1000);
    make_image(1); /* and 0130h */
    assert_true(cut_everywhere(1, 4, 1) > 1000);
}

static void an_operation_that_fails_leaves_either(void **state)
{
    (void)state;
    for (uint8_t old = 1; old < REGIONS; old++) {
        uint32_t nth = 0;
        while (true) {
            make_image(old);
            fail_at = calls + nth++;
            const int result = take_over(REGIONS);
            if (calls <= fail_at) {
                assert_int_equal(result, DG_OK);
                break;
            }
            assert_int_equal(result, DG_ERR_IO);
            assert_int_equal(store.failures, 1);
            assert_either(old, REGIONS);
            assert_int_equal(take_over(REGIONS), DG_OK);
            assert_taken_over(old, REGIONS);
            assert_image(REGIONS);
        }
        assert_true(nth > 10);
    }
}

/* On a medium where the power cut tears all that was not synced, not only the last write. */
static void writes_torn_together_leave_either(void **state)
{
    (void)state;
    make_image(3);
    assert_int_equal(test_sync(&ram), DG_OK);
    const struct ram_nvm start = ram;
    for (uint32_t nth = 0;; nth++) {
        rewind_to(&start);
        ram_nvm_cut(&ram, nth, RAM_NVM_ORDERED, 1);
        if (take_over(REGIONS) == DG_OK) {
            assert_true(nth > 5);
            break;
        }
        ram_nvm_restore(&ram);
        for (size_t i = 0; i < pending_count; i++) {
            ram.bytes[pending[i].address + pending[i].n - 1] ^= 0x55;
        }
        pending_count = 0;
        assert_either(3, REGIONS);
        assert_int_equal(take_over(REGIONS), DG_OK);
        assert_taken_over(3, REGIONS);
    }
}

/* Once both headers are durably marks an old image is a blank memory, whatever else is left of it.
 */
static void a_format_over_an_image_that_is_cut_leaves_it_blank(void **state)
{
    uint32_t nth = 0;
    (void)state;
    while (true) {
        make_image(3);
        ram_nvm_cut(&ram, nth, RAM_NVM_UNSYNCED, 0);
        if (dg_store_format(&layouts[REGIONS], nvm, ctx) == DG_OK) {
            break;
        }
        ram_nvm_restore(&ram);
        const int result = mount(3);
        assert_int_equal(dg_store_unfinished(&layouts[3], nvm), result == DG_ERR_BLANK);
        assert_int_equal(result, nth < 2 ? DG_OK : DG_ERR_BLANK);
        nth++;
    }
    assert_true(nth > 5);
    assert_int_equal(mount(REGIONS), DG_OK);
    assert_taken_over(0, REGIONS);
}

/* --- a journal of the older release --- */

/* Two changes, committed and durable, none of them in place. */
static void leave_journal(uint8_t old)
{
    uint8_t bytes[100];
    make_image(old);
    dg_store_begin(&store);
    const uint16_t n = fill(LIMITS, 'j', bytes);
    assert_int_equal(dg_store_stage(&store, LIMITS, 0, bytes, n), DG_OK);
    assert_int_equal(dg_store_stage(&store, NOTES, 0, "journal", 7), DG_OK);
    ram_nvm_cut(&ram, 1, RAM_NVM_UNSYNCED, 0); /* the head goes through, the first change not */
    assert_int_equal(dg_store_commit(&store), DG_ERR_IO);
    ram_nvm_restore(&ram);
    assert_memory_equal(ram.bytes + JOURNAL, "\x31\0\xCE\xFF", 4);
}

static void assert_journal_completed(void)
{
    uint8_t bytes[8] = {0};
    assert_true(has(LIMITS, 'j'));
    assert_int_equal(dg_store_read(&store, NOTES, 0, bytes, 7), DG_OK);
    assert_memory_equal(bytes, "journal", 7);
    assert_true(store.region_count < REGIONS || has_defaults(LABEL));
    assert_int_equal(store.damaged, 0);
}

static void a_journal_left_behind_is_completed(void **state)
{
    struct cut cut = {RAM_NVM_ORDERED, 0, 0, 0};
    (void)state;
    leave_journal(3);
    const struct ram_nvm start = ram;
    assert_int_equal(take_over(REGIONS), DG_OK);
    assert_journal_completed();
    assert_int_equal(store.replays, 1);
    assert_int_equal(mount(REGIONS), DG_OK);
    assert_int_equal(store.replays, 0);
    while (true) {
        rewind_to(&start);
        ram.writes = cut.parity;
        ram_nvm_cut(&ram, cut.nth, cut.tear, cut.tear_at);
        const int result = take_over(REGIONS);
        if (!ram.dead) {
            assert_int_equal(result, DG_OK);
            break;
        }
        next_cut(&cut);
        ram_nvm_restore(&ram);
        assert_int_equal(take_over(REGIONS), DG_OK);
        assert_journal_completed();
    }
}

/* A change of a region that the older release did not have was not written by it. */
static void a_journal_reaches_no_region_the_image_lacks(void **state)
{
    (void)state;
    make_image(REGIONS);
    dg_store_begin(&store);
    assert_int_equal(dg_store_stage(&store, NOTES, 0, "a", 1), DG_OK);
    assert_int_equal(dg_store_stage(&store, USER, 0, "forged", 6), DG_OK);
    ram_nvm_cut(&ram, 1, RAM_NVM_UNSYNCED, 0);
    assert_int_equal(dg_store_commit(&store), DG_ERR_IO);
    ram_nvm_restore(&ram);
    dg_store_le32(ram.bytes + 8, ends[3]);
    dg_store_le32(ram.bytes + COPY + 8, ends[3]);
    memset(ram.bytes + ends[3], 0x5A, ram.size - ends[3]);
    assert_int_equal(mount(REGIONS), DG_ERR_OLDER);
    for (uint32_t i = ends[3]; i < ram.size; i++) {
        assert_int_equal(ram.bytes[i], 0x5A);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_regions_end_where_it_is_said),
        cmocka_unit_test(an_older_image_keeps_its_values_and_gets_defaults_for_what_is_new),
        cmocka_unit_test(until_it_has_grown_only_old_regions_are_there),
        cmocka_unit_test(damage_stays_and_later_images_are_foreign),
        cmocka_unit_test(a_damaged_header_does_not_shorten_the_image),
        cmocka_unit_test(a_power_cut_leaves_the_older_image_or_the_grown_one),
        cmocka_unit_test(an_operation_that_fails_leaves_either),
        cmocka_unit_test(writes_torn_together_leave_either),
        cmocka_unit_test(a_format_over_an_image_that_is_cut_leaves_it_blank),
        cmocka_unit_test(a_journal_left_behind_is_completed),
        cmocka_unit_test(a_journal_reaches_no_region_the_image_lacks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

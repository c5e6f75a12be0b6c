/* SPDX-License-Identifier: MIT */
/*
 * The journalled store on an EEPROM in RAM: layout, arguments, and what is left after the power
 * fails in every write, after every operation that fails, and after every byte that rots.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/crc.h"
#include "drehgeber/store.h"
#include "ram_nvm.h"

#define FF8 "\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF"

enum region { SERIAL, NOTES, LIMITS, SUMS, REGIONS };

/* Addresses, by hand: header 12, copy 12, journal 8, changes 48, then the regions. */
enum {
    AT_COPY = 12,
    AT_JOURNAL = 24,
    AT_CHANGES = 32,
    AT_SERIAL = 80,  /* 9 bytes and their sum */
    AT_NOTES = 91,   /* 40 bytes */
    AT_LIMITS = 131, /* 4 bytes and their sum */
    AT_SUMS = 137,   /* 6 bytes */
    SIZE = 143
};

static void serial_defaults(const void *ctx, uint8_t *out)
{
    memcpy(out, ctx, 9);
}

static void sums_defaults(const void *ctx, uint8_t *out)
{
    (void)ctx;
    memcpy(out, "(sums)", 6);
}

/* clang-format off */
static const struct dg_store_region regions[REGIONS] = {
    /* name     size check             code  defaults */
    {"serial",  9,   DG_STORE_CHECKED, 0x05, serial_defaults},
    {"notes",   40,  DG_STORE_RAW,     0,    NULL},
    {"limits",  4,   DG_STORE_CHECKED, 0x12, NULL},
    {"sums",    6,   DG_STORE_RAW,     0,    sums_defaults},
};
static const struct dg_store_layout layout = {0x31545344, 48, REGIONS, regions};

static const uint8_t delivered[SIZE] =
    "dge1DST1\x8F\0\0\0" "dge1DST1\x8F\0\0\0" FF8 FF8 FF8 FF8 FF8 FF8 FF8
    "123456789\x29\xB1" FF8 FF8 FF8 FF8 FF8 "\xFF\xFF\xFF\xFF\x1D\x0F" "(sums)";
/* clang-format on */

static struct bench {
    struct dg_store store;
    uint32_t calls, fail_from, fail_to; /* so far; the first that fails, that works again */
    bool half;                          /* the first half of a failing write gets through */
    size_t length;                      /* of the last write */
    struct ram_nvm ram;                 /* at the end, as most of it is not in use */
} bench;
static struct ram_nvm *const ram = &bench.ram;
static struct dg_store *const store = &bench.store;

static bool fails(void)
{
    const uint32_t call = bench.calls++;
    return call >= bench.fail_from && call < bench.fail_to;
}

static int bench_read(void *ctx, uint32_t address, void *to, size_t n)
{
    return fails() ? DG_ERR_IO : ram_nvm_port(ctx).ops->read(ctx, address, to, n);
}

static int bench_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    const bool failing = fails();
    const size_t through = failing && bench.half ? n / 2 : 0;
    const int result = ram_nvm_port(ctx).ops->write(ctx, address, from, failing ? through : n);
    bench.length = n;
    return failing ? DG_ERR_IO : result;
}

static int bench_sync(void *ctx)
{
    return fails() ? DG_ERR_IO : ram_nvm_port(ctx).ops->sync(ctx);
}

static const struct dg_nvm_ops bench_ops = {bench_read, bench_write, bench_sync};
static const struct dg_nvm nvm = {&bench_ops, &bench.ram};

static int format(void)
{
    return dg_store_format(&layout, nvm, "123456789");
}

static int mount(void)
{
    return dg_store_mount(store, &layout, nvm);
}

static int set_up(void **state)
{
    (void)state;
    memset(&bench, 0, sizeof bench);
    ram_nvm_init(ram, SIZE);
    return format() == DG_OK && mount() == DG_OK ? 0 : -1;
}

static void power_cycle(void)
{
    ram_nvm_restore(ram);
    assert_int_equal(mount(), DG_OK);
}

static void the_layout_is_where_it_is_said_to_be(void **state)
{
    static const uint32_t addresses[REGIONS] = {AT_SERIAL, AT_NOTES, AT_LIMITS, AT_SUMS};
    (void)state;
    assert_int_equal(dg_store_size(&layout), SIZE);
    for (uint8_t region = 0; region < REGIONS; region++) {
        assert_int_equal(dg_store_address(&layout, region), addresses[region]);
        assert_int_equal(dg_store_find(&layout, regions[region].name), region);
    }
    assert_int_equal(dg_store_find(&layout, "note"), DG_ERR_ARGUMENT);
    assert_int_equal(dg_store_find(&layout, "notes2"), DG_ERR_ARGUMENT);
}

static void format_writes_the_delivery_state(void **state)
{
    const struct dg_store_region large = {"large", 129, DG_STORE_RAW, 0, serial_defaults};
    const struct dg_store_layout wrong = {1, 8, 1, &large};
    (void)state;
    ram_nvm_init(ram, 32 + 8 + 129);
    assert_int_equal(dg_store_format(&wrong, nvm, "123456789"), DG_ERR_ARGUMENT);
    assert_int_equal(dg_store_mount(store, &wrong, nvm), DG_ERR_BLANK);
    memset(ram->bytes, 0x5A, SIZE);
    assert_int_equal(format(), DG_OK);
    assert_memory_equal(ram->bytes, delivered, SIZE);
    assert_memory_equal(ram->synced, delivered, SIZE);
    assert_int_equal(mount(), DG_OK);
    assert_int_equal(store->damaged + store->replays + store->repairs, 0);
}

/* CRC-16: check value 29B1h; CRC-32 of "0F 00 F0 FF 00 00 29 B1 09 00 123456789": zlib. */
static void the_journal_is_what_the_source_says(void **state)
{
    static const char journal[] = "\x0F\0\xF0\xFF\x76\x24\xCE\xC7\0\0\x29\xB1\x09\0"
                                  "123456789";
    (void)state;
    assert_int_equal(dg_store_put(store, SERIAL, 0, "987654321", 9), DG_OK);
    ram_nvm_cut(ram, 3, RAM_NVM_UNSYNCED, 0);
    assert_int_equal(dg_store_put(store, SERIAL, 0, "123456789", 9), DG_ERR_IO);
    ram_nvm_restore(ram);
    assert_memory_equal(ram->bytes + AT_JOURNAL, journal, sizeof journal - 1);
    assert_memory_equal(ram->bytes + AT_SERIAL, "987654321", 9);
    assert_int_equal(mount(), DG_OK);
    assert_memory_equal(ram->bytes + AT_SERIAL, "123456789\x29\xB1", 11);
}

/* Calls and their results, one after the other on one store. */

enum call { BEGIN, STAGE, COMMIT, PUT, READ, SILENCE };

struct step {
    enum call call;
    uint8_t region;
    uint16_t offset, n; /* n of SILENCE: 1 on, 0 off */
    const char *bytes;  /* to write, NULL: 'n's; expected from READ, NULL: anything */
    int result;
};

/* clang-format off */
static const struct step steps[] = {
    /* any part of a raw region, all of a checked one */
    {PUT,     NOTES,   0,     40,    NULL,        DG_OK},
    {PUT,     NOTES,   39,    1,     "!",         DG_OK},
    {PUT,     NOTES,   40,    0,     NULL,        DG_OK},
    {READ,    NOTES,   38,    2,     "n!",        DG_OK},
    {PUT,     SERIAL,  0,     9,     "serial  1", DG_OK},
    /* arguments */
    {READ,    NOTES,   40,    1,     NULL,        DG_ERR_ARGUMENT},
    {PUT,     NOTES,   65535, 40,    NULL,        DG_ERR_ARGUMENT},
    {PUT,     NOTES,   1,     65535, NULL,        DG_ERR_ARGUMENT},
    {PUT,     SERIAL,  0,     8,     NULL,        DG_ERR_ARGUMENT},
    {PUT,     SERIAL,  0,     0,     NULL,        DG_ERR_ARGUMENT},
    {READ,    REGIONS, 0,     0,     NULL,        DG_ERR_ARGUMENT},
    {PUT,     255,     0,     1,     NULL,        DG_ERR_ARGUMENT},
    /* a put changed nothing else */
    {READ,    SERIAL,  0,     9,     "serial  1", DG_OK},
    {READ,    SUMS,    0,     6,     "(sums)",    DG_OK},
    /* later changes of a commit win, and none shows before it */
    {BEGIN,   0,       0,     0,     NULL,        DG_OK},
    {STAGE,   SERIAL,  0,     9,     "aaaaaaaaa", DG_OK},
    {STAGE,   SERIAL,  0,     9,     "bbbbbbbbb", DG_OK},
    {STAGE,   SUMS,    0,     4,     "xxxx",      DG_OK},
    {STAGE,   SUMS,    2,     1,     "y",         DG_OK},
    {READ,    SERIAL,  0,     9,     "serial  1", DG_OK},
    {COMMIT,  0,       0,     0,     NULL,        DG_OK},
    {READ,    SERIAL,  0,     9,     "bbbbbbbbb", DG_OK},
    {READ,    SUMS,    0,     6,     "xxyxs)",    DG_OK},
    /* begin forgets; commit without a change is one */
    {STAGE,   SUMS,    0,     6,     "forget",    DG_OK},
    {BEGIN,   0,       0,     0,     NULL,        DG_OK},
    {COMMIT,  0,       0,     0,     NULL,        DG_OK},
    {READ,    SUMS,    0,     6,     "xxyxs)",    DG_OK},
    /* a full journal: 6 + 9 + 6 + 27 fill it */
    {STAGE,   SERIAL,  0,     9,     "ccccccccc", DG_OK},
    {STAGE,   NOTES,   0,     28,    NULL,        DG_ERR_SPACE},
    {COMMIT,  0,       0,     0,     NULL,        DG_ERR_SPACE},
    {READ,    SERIAL,  0,     9,     "bbbbbbbbb", DG_OK},
    {BEGIN,   0,       0,     0,     NULL,        DG_OK},
    {STAGE,   SERIAL,  0,     9,     "ddddddddd", DG_OK},
    {STAGE,   NOTES,   0,     27,    NULL,        DG_OK},
    {COMMIT,  0,       0,     0,     NULL,        DG_OK},
    {READ,    SERIAL,  0,     9,     "ddddddddd", DG_OK},
    /* commit refuses with what stage failed with */
    {STAGE,   SERIAL,  1,     1,     "x",         DG_ERR_ARGUMENT},
    {STAGE,   SUMS,    0,     1,     "x",         DG_ERR_ARGUMENT},
    {COMMIT,  0,       0,     0,     NULL,        DG_ERR_ARGUMENT},
    {BEGIN,   0,       0,     0,     NULL,        DG_OK},
    {SILENCE, 0,       0,     1,     NULL,        DG_OK},
    {READ,    SUMS,    0,     1,     NULL,        DG_ERR_IO},
    {STAGE,   SUMS,    0,     1,     "x",         DG_ERR_IO},
    {SILENCE, 0,       0,     0,     NULL,        DG_OK},
    {COMMIT,  0,       0,     0,     NULL,        DG_ERR_IO},
    {READ,    SUMS,    0,     6,     "xxyxs)",    DG_OK},
};
/* clang-format on */

static int take_step(const struct step *step)
{
    uint8_t bytes[64];
    const void *from = step->bytes == NULL ? (const void *)bytes : step->bytes;
    int result = DG_OK;
    memset(bytes, 'n', sizeof bytes);
    if (step->call == BEGIN) {
        dg_store_begin(store);
    } else if (step->call == STAGE) {
        result = dg_store_stage(store, step->region, step->offset, from, step->n);
    } else if (step->call == COMMIT) {
        result = dg_store_commit(store);
    } else if (step->call == PUT) {
        result = dg_store_put(store, step->region, step->offset, from, step->n);
    } else if (step->call == READ) {
        result = dg_store_read(store, step->region, step->offset, bytes, step->n);
        assert_memory_equal(bytes, from, step->bytes == NULL ? 0 : step->n);
    } else {
        ram->no_acknowledge = step->n != 0;
    }
    return result;
}

static void every_call_has_its_result(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(steps); i++) {
        assert_int_equal(take_step(&steps[i]), steps[i].result);
    }
    assert_int_equal(store->failures, 3);
    assert_false(dg_store_damaged(store, REGIONS) || dg_store_damaged(store, 255));
}

static void two_stores_live_side_by_side_one_without_sync(void **state)
{
    static struct ram_nvm memory;
    const struct dg_nvm synced = ram_nvm_port(&memory);
    const struct dg_nvm_ops ops = {synced.ops->read, synced.ops->write, NULL};
    const struct dg_nvm unsynced = {&ops, &memory};
    struct dg_store other;
    (void)state;
    ram_nvm_init(&memory, SIZE);
    assert_int_equal(dg_store_format(&layout, unsynced, "987654321"), DG_OK);
    assert_int_equal(dg_store_mount(&other, &layout, unsynced), DG_OK);
    assert_int_equal(dg_store_stage(&other, SUMS, 0, "other!", 6), DG_OK);
    assert_int_equal(dg_store_put(store, SUMS, 0, "bench!", 6), DG_OK);
    assert_int_equal(dg_store_commit(&other), DG_OK);
    assert_memory_equal(memory.bytes + AT_SUMS, "other!", 6);
    assert_memory_equal(ram->bytes + AT_SUMS, "bench!", 6);
}

/* Scenarios for power cuts and failing operations: what is there, and what is then done to it. */

struct values {
    char serial[9], notes[40], limits[4];
};

/* clang-format off */
static const struct values delivery   = {"123456789", FF8 FF8 FF8 FF8 FF8, "\xFF\xFF\xFF\xFF"};
static const struct values old_values = {"old 56789", "old notes of forty characters in a row..", "oldL"};
static const struct values new_notes  = {"old 56789", "NEW notes of forty characters IN A ROW!!", "oldL"};
static const struct values new_values = {"NEW 56789", "old notes of forty charactSIXTEEN CHARS.", "NEWL"};
/* clang-format on */

static int put_notes(void)
{
    return dg_store_put(store, NOTES, 0, new_notes.notes, 40);
}

static int commit_three(void)
{
    dg_store_begin(store);
    (void)dg_store_stage(store, SERIAL, 0, new_values.serial, 9);
    (void)dg_store_stage(store, NOTES, 24, new_values.notes + 24, 16);
    (void)dg_store_stage(store, LIMITS, 0, new_values.limits, 4);
    return dg_store_commit(store);
}

static int retry(void)
{
    return dg_store_commit(store);
}

/* The old values, acknowledged: the journal was cleared, but not synced since. */
static void prepare_old(void)
{
    ram_nvm_init(ram, SIZE);
    assert_true(format() == DG_OK && mount() == DG_OK);
    assert_int_equal(dg_store_put(store, NOTES, 0, old_values.notes, 40), DG_OK);
    assert_int_equal(dg_store_put(store, SERIAL, 0, old_values.serial, 9), DG_OK);
    assert_int_equal(dg_store_put(store, LIMITS, 0, old_values.limits, 4), DG_OK);
}

/* A whole and durable journal of three changes, none of them in place. */
static void prepare_journal(void)
{
    prepare_old();
    ram_nvm_cut(ram, 7, RAM_NVM_UNSYNCED, 0);
    assert_int_equal(commit_three(), DG_ERR_IO);
    ram_nvm_restore(ram);
}

/* The same, not durable: the process died before its sync, and the power stayed. */
static void prepare_unsynced_journal(void)
{
    prepare_journal();
    memset(ram->synced + AT_JOURNAL, 0xFF, AT_SERIAL - AT_JOURNAL);
}

/* A header that mounting repairs in front of it; its copy is whole. */
static void prepare_damaged_header(void)
{
    prepare_journal();
    ram->bytes[5] = ram->synced[5] ^= 0x40;
}

struct scenario {
    void (*prepare)(void);
    int (*act)(void);
    const struct values *before; /* what an act that was not acknowledged may leave; or no image */
    const struct values *after;
};

/* clang-format off */
static const struct scenario scenarios[] = {
    /* prepare                 act           before       after */
    {prepare_old,              put_notes,    &old_values, &new_notes},
    {prepare_old,              commit_three, &old_values, &new_values},
    {prepare_journal,          mount,        &new_values, &new_values},
    {prepare_unsynced_journal, mount,        &old_values, &new_values},
    {prepare_damaged_header,   mount,        &new_values, &new_values},
    {prepare_old,              format,       &old_values, &delivery},
};
/* clang-format on */

static bool holds(const struct values *values)
{
    struct values found;
    return dg_store_read(store, SERIAL, 0, found.serial, 9) == DG_OK &&
           dg_store_read(store, NOTES, 0, found.notes, 40) == DG_OK &&
           dg_store_read(store, LIMITS, 0, found.limits, 4) == DG_OK &&
           memcmp(&found, values, sizeof found) == 0;
}

/* Mounted: one of the two, nothing damaged; once acknowledged, the second. */
static void assert_settled(const struct scenario *scenario, bool acknowledged)
{
    if (!holds(scenario->after)) {
        assert_false(acknowledged);
        assert_true(holds(scenario->before));
    }
    assert_int_equal(store->damaged, 0);
    assert_memory_equal(ram->bytes + AT_SUMS, "(sums)", 6);
}

/* What is shown cannot go away any more, and the mount after the next has nothing to do. */
static void assert_at_rest(const struct scenario *scenario)
{
    const bool after = holds(scenario->after);
    ram_nvm_cut(ram, 0, RAM_NVM_UNSYNCED, 0);
    assert_int_equal(dg_store_put(store, SUMS, 0, "staged", 6), DG_ERR_IO);
    power_cycle();
    assert_settled(scenario, after);
    const uint32_t writes = ram->writes;
    power_cycle();
    assert_int_equal(store->replays + store->repairs, 0);
    assert_int_equal(ram->writes, writes);
    assert_memory_equal(ram->bytes, delivered, AT_JOURNAL);
}

static bool no_image(const struct scenario *scenario)
{
    const int result = scenario->act == format ? mount() : DG_OK;
    assert_true(result == DG_OK || (result == DG_ERR_BLANK && dg_store_unfinished(&layout, nvm)));
    return result != DG_OK;
}

/* In which write the power fails, how, after how many bytes, and which writes overtake. */
struct cut {
    enum ram_nvm_tear tear;
    uint32_t nth, tear_at, parity;
};

/* The next cut in a write of `n` bytes; false when there is none. */
static bool next_cut(struct cut *cut, size_t n)
{
    if (cut->tear != RAM_NVM_UNSYNCED && cut->tear_at < n) {
        cut->tear_at++;
        return true;
    }
    cut->tear_at = 0;
    cut->parity = cut->tear == RAM_NVM_REORDERED ? 1 - cut->parity : 0;
    cut->tear += cut->parity == 0;
    return cut->tear < RAM_NVM_TEAR_COUNT;
}

/*
 * Act with the power failing in each write, in every way. What the first cuts leave is mounted
 * with a second cut in each of that mount's writes. Returns how many cuts there were.
 */
static uint32_t cut_everywhere(const struct scenario *scenario, bool first)
{
    const struct scenario recovery = {NULL, mount, scenario->before, scenario->after};
    struct bench *start = test_malloc(sizeof *start);
    struct cut cut = {RAM_NVM_ORDERED, 0, 0, 0};
    uint32_t cuts = 0;
    *start = bench;
    while (true) {
        memcpy(&bench, start, offsetof(struct bench, ram.bytes) + SIZE);
        memcpy(ram->synced, start->ram.synced, SIZE);
        ram->writes = cut.parity;
        ram_nvm_cut(ram, cut.nth, cut.tear, cut.tear_at);
        const int result = scenario->act();
        if (!ram->dead) {
            assert_int_equal(result, DG_OK);
            break;
        }
        const size_t length = bench.length;
        assert_int_equal(result, DG_ERR_IO);
        ram_nvm_restore(ram);
        if (!no_image(scenario)) {
            cuts += first ? cut_everywhere(&recovery, false) : 0;
            power_cycle();
            assert_settled(scenario, false);
        }
        cuts++;
        if (!next_cut(&cut, length)) {
            cut = (struct cut){RAM_NVM_ORDERED, cut.nth + 1, 0, 0};
        }
    }
    assert_false(no_image(scenario));
    assert_settled(scenario, first);
    assert_at_rest(scenario);
    test_free(start);
    return cuts;
}

static void a_power_cut_leaves_old_or_new(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(scenarios); i++) {
        scenarios[i].prepare();
        assert_true(cut_everywhere(&scenarios[i], true) > 100);
    }
}

enum { FAULT_KINDS = 4, CONTINUATIONS = 5 }; /* once or for good, without or with half a write */

/* After an act that failed the next read shows what is there to stay ... */
static void go_on(const struct scenario *scenario, uint32_t how)
{
    const struct scenario next = {NULL, mount, scenario->before, scenario->after};
    const struct scenario again = {NULL, retry, scenario->before, scenario->after};
    if (scenario->act == mount && how % 2 == 0) {
        assert_int_equal(mount(), DG_OK);
    } else if (scenario->act != mount && how == 1) { /* ... or all of it is tried again ... */
        assert_int_equal(scenario->act(), DG_OK);
        assert_settled(&next, true);
    }
    if (how == 2) { /* ... or something else is put ... */
        assert_int_equal(dg_store_put(store, SUMS, 0, "(sums)", 6), DG_OK);
    } else if (how == 3) { /* ... or the power fails, and again while mounting ... */
        ram_nvm_restore(ram);
        (void)cut_everywhere(&next, false);
    } else if (how == 4 && store->failed == DG_OK) { /* ... or while the commit is tried again. */
        (void)cut_everywhere(&again, false);
        assert_settled(&next, true);
    }
    assert_settled(&next, false);
    assert_at_rest(&next);
}

/* Act with call `nth` failing, see `kind`; false when the act makes fewer calls. */
static bool act_with_fault(const struct scenario *scenario, uint32_t nth, uint32_t kind)
{
    scenario->prepare();
    store->failures = 0;
    bench.fail_from = bench.calls + nth;
    bench.fail_to = kind % 2 != 0 ? UINT32_MAX : bench.fail_from + 1;
    bench.half = kind / 2 != 0;
    const int result = scenario->act();
    const bool failed = bench.calls > bench.fail_from;
    bench.fail_from = bench.fail_to = 0;
    assert_int_equal(result, failed ? DG_ERR_IO : DG_OK);
    assert_true(scenario->act == format || (store->failures > 0) == failed);
    return failed;
}

static void a_failing_operation_leaves_old_or_new(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < DG_COUNT(scenarios) * FAULT_KINDS * CONTINUATIONS; i++) {
        const struct scenario *scenario = &scenarios[i / CONTINUATIONS / FAULT_KINDS];
        uint32_t nth = 0;
        while (act_with_fault(scenario, nth, i / CONTINUATIONS % FAULT_KINDS)) {
            if (scenario->act != format) {
                go_on(scenario, i % CONTINUATIONS);
            } else if (!no_image(scenario)) {
                assert_settled(scenario, false);
            }
            nth++;
        }
        assert_true(nth > 10 && !no_image(scenario));
        assert_settled(scenario, true);
    }
}

static void a_retry_that_completes_a_put_clears_the_damage(void **state)
{
    char text[9];
    (void)state;
    ram->bytes[AT_SERIAL] ^= 1;
    ram->bytes[AT_LIMITS + 4] ^= 1; /* its sum */
    power_cycle();
    assert_true(dg_store_damaged(store, SERIAL) && dg_store_damaged(store, LIMITS));
    assert_int_equal(dg_store_read(store, SERIAL, 0, text, 9), DG_OK);
    assert_memory_equal(text, "023456789", 9);
    ram_nvm_cut(ram, 3, RAM_NVM_ORDERED, 4); /* the first write in place */
    assert_int_equal(dg_store_put(store, SERIAL, 0, "abcdefghi", 9), DG_ERR_IO);
    assert_int_equal(dg_store_read(store, NOTES, 0, text, 1), DG_ERR_IO);
    assert_true(store->unapplied && dg_store_damaged(store, SERIAL));
    assert_int_equal(store->failures, 2);
    ram_nvm_restore(ram);
    assert_int_equal(dg_store_read(store, NOTES, 0, text, 1), DG_OK);
    assert_true(!store->unapplied && store->damaged == 1u << LIMITS);
    assert_memory_equal(ram->bytes + AT_SERIAL, "abcdefghi", 9);
    assert_int_equal(dg_store_put(store, LIMITS, 0, "1234", 4), DG_OK);
    assert_int_equal(store->damaged, 0);
}

/* Each byte of `image` in each of its wrong values, mounted; `check` gets its address. */
static void rot(void (*check)(uint32_t address))
{
    uint8_t image[SIZE];
    memcpy(image, ram->bytes, SIZE);
    for (uint32_t i = 0; i < SIZE * 255u; i++) {
        memcpy(ram->bytes, image, SIZE);
        ram->bytes[i / 255] ^= (uint8_t)(i % 255 + 1);
        power_cycle();
        assert_memory_equal(ram->synced, delivered, AT_JOURNAL);
        assert_int_equal(store->repairs, i / 255 < AT_JOURNAL);
        check(i / 255);
    }
}

static void check_reported(uint32_t address)
{
    const bool serial = address >= AT_SERIAL && address < AT_NOTES;
    const bool limits = address >= AT_LIMITS && address < AT_SUMS;
    assert_int_equal(store->damaged, (uint32_t)serial << SERIAL | (uint32_t)limits << LIMITS);
    assert_int_equal(store->replays, 0);
    assert_true(address >= AT_SERIAL || holds(&old_values));
}

/* Dropping is synced, or the same changes staged again would make it whole without a commit. */
static void check_dropped(uint32_t address)
{
    const bool rotten = address >= AT_JOURNAL && address < AT_CHANGES + 47;
    assert_int_equal(store->replays, !rotten);
    assert_memory_equal(ram->synced + AT_JOURNAL, delivered + AT_JOURNAL, rotten ? 8 : 0);
    assert_true(address >= AT_SERIAL || holds(rotten ? &old_values : &new_values));
}

static void a_rotten_byte_is_repaired_harmless_or_reported(void **state)
{
    (void)state;
    prepare_old();
    rot(check_reported);
    prepare_journal();
    rot(check_dropped);
}

static void blank_foreign_and_silent_memories_are_told_apart(void **state)
{
    struct dg_store_layout other = layout;
    const uint32_t writes = ram->writes;
    (void)state;
    other.id++;
    assert_int_equal(dg_store_mount(store, &other, nvm), DG_ERR_FOREIGN);
    other = (struct dg_store_layout){layout.id, 48, REGIONS - 1, regions};
    assert_int_equal(dg_store_mount(store, &other, nvm), DG_ERR_FOREIGN);
    memset(ram->bytes, 0xFF, AT_JOURNAL);
    assert_int_equal(mount(), DG_ERR_BLANK);
    ram->bytes[AT_JOURNAL - 1] = 0xFE;
    assert_int_equal(mount(), DG_ERR_FOREIGN);
    for (uint32_t i = 0; i < 12u * 12u; i++) { /* both headers damaged */
        memcpy(ram->bytes, delivered, SIZE);
        ram->bytes[i / 12] ^= 0x10;
        ram->bytes[AT_COPY + i % 12] ^= 0x01;
        assert_int_equal(mount(), DG_ERR_FOREIGN);
    }
    assert_true(ram->writes == writes && store->failures == 0);
    ram->no_acknowledge = true;
    assert_int_equal(mount(), DG_ERR_IO);
    assert_int_equal(store->failures, 1);
}

/* Journals with a right sum that no commit writes. */

struct forged_row {
    uint8_t length;
    char changes[17];
    const char *sums; /* content of "sums" afterwards */
};

/* clang-format off */
static const struct forged_row forged_rows[] = {
    {8,  "\x03\0\x01\0\x02\0" "xy",                                "(xyms)"}, /* a good one */
    {5,  "\x03\0\x01\0\x02\0" "xy",                                "(sums)"}, /* no whole head */
    {7,  "\x03\0\x01\0\x02\0" "xy",                                "(sums)"}, /* n beyond the end */
    {8,  "\x04\0\0\0\x02\0" "xy",                                  "(sums)"}, /* no such region */
    {8,  "\x03\0\x05\0\x02\0" "xy",                                "(sums)"}, /* leaves its region */
    {8,  "\x03\0\xFF\xFF\x02\0" "xy",                              "(sums)"},
    {8,  "\x02\0\0\0\x02\0" "xy",                                  "(sums)"}, /* part of a checked one */
    {16, "\x03\0\x01\0\x02\0" "xy" "\x02\0\0\0\x02\0" "xy",        "(xyms)"}, /* ends at the bad one */
};
/* clang-format on */

static void forge(const struct forged_row *row)
{
    uint8_t *head = ram->bytes + AT_JOURNAL;
    memcpy(ram->bytes, delivered, SIZE);
    memcpy(ram->bytes + AT_CHANGES, row->changes, sizeof row->changes);
    dg_store_le16(head, row->length);
    dg_store_le16(head + 2, (uint16_t)~row->length);
    const uint32_t sum = dg_crc32(0, head, 4);
    dg_store_le32(head + 4, dg_crc32(sum, head + 8, row->length));
}

static void a_forged_journal_stays_inside_its_regions(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(forged_rows); i++) {
        forge(&forged_rows[i]);
        assert_int_equal(mount(), DG_OK);
        assert_true(store->replays == 1 && store->damaged == 0);
        assert_memory_equal(ram->bytes, delivered, AT_CHANGES);
        assert_memory_equal(ram->bytes + AT_SERIAL, delivered + AT_SERIAL, AT_SUMS - AT_SERIAL);
        assert_memory_equal(ram->bytes + AT_SUMS, forged_rows[i].sums, 6);
    }
    memcpy(ram->bytes + AT_JOURNAL, "\x31\0\xCE\xFF", 4); /* longer than its place */
    assert_int_equal(mount(), DG_OK);
    assert_int_equal(store->replays, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(the_layout_is_where_it_is_said_to_be, set_up),
        cmocka_unit_test_setup(format_writes_the_delivery_state, set_up),
        cmocka_unit_test_setup(the_journal_is_what_the_source_says, set_up),
        cmocka_unit_test_setup(every_call_has_its_result, set_up),
        cmocka_unit_test_setup(two_stores_live_side_by_side_one_without_sync, set_up),
        cmocka_unit_test_setup(a_power_cut_leaves_old_or_new, set_up),
        cmocka_unit_test_setup(a_failing_operation_leaves_old_or_new, set_up),
        cmocka_unit_test_setup(a_retry_that_completes_a_put_clears_the_damage, set_up),
        cmocka_unit_test_setup(a_rotten_byte_is_repaired_harmless_or_reported, set_up),
        cmocka_unit_test_setup(blank_foreign_and_silent_memories_are_told_apart, set_up),
        cmocka_unit_test_setup(a_forged_journal_stays_inside_its_regions, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * EEPROM contents that changed by themselves: every bit alone, and every combination of damaged
 * regions. What a region's damage does stands in 5.1.3; what is not a region does nothing.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"

#define CHECKED 13u
#define SUM_SIZE 2u

/* What locks a command; the answer is the first one in this order (R8). 03h has four causes: damage
 * of the table of data fields or the memory size (D), the UART settings (U), the access codes (K)
 * (R25), and a damaged data field that was found in operation (W, R24). */
enum { P = 1, D = 2, U = 4, K = 8, W = 16, E = 32, S = 64 };
static const struct {
    uint8_t lock;
    uint8_t status;
} locks[] = {{P, 0x02}, {D | U | K | W, 0x03}, {E, 0x05}, {S, 0x06}};

/* The checked regions in the order they are checked: start-up error and lock (5.1.3). */
static const struct {
    const char *name;
    uint8_t code;
    uint8_t lock;
} regions[CHECKED] = {
    {"resolution", 0x01, P},  {"calibration", 0x01, P}, {"offset", 0x02, P}, {"sync", 0x02, P},
    {"uart", 0x03, U},        {"memory", 0x03, D},      {"codes", 0x03, K},  {"fields", 0x03, D},
    {"type", 0x05, E},        {"counter", 0x08, 0},     {"label", 0x12, P},  {"steps", 0x01, P},
    {"implemented", 0x03, D},
};
#define LABEL 10u
#define UART 4u

/* A request of every command and what locks it: the error conditions of its table in 5.1.2; 57h by
 * 5.1.3.6, 46h 47h 49h also by 5.1.3.15, 03h by R24 and R25. The label as a data field has its own
 * row: 5.1.3.14. */
static const struct {
    const char *request;
    uint8_t locks;
} commands[] = {
    {"42", P},
    {"43 00 01 02 03 55", P | W | E | S},
    {"6A 00 01 02 03 55", P | W | E | S},
    {"44 48", 0},
    {"46", E | S},
    {"47", W | E | S},
    {"49 55", W | E | S},
    {"4A 00 00 20 55", D | E},
    {"4B 00 00 02 55 AB CD", D | W | E | S},
    {"4C 01", D | E},
    {"4D 02 C8 55", D | W | E | S},
    {"4E", D | E | S},
    {"4F 01 55 66", K | W | E | S},
    {"50", 0},
    {"52", E},
    {"55 40 55", U | W | E | S},
    {"56", E},
    {"57 E4 55", U | W | E | S},
};
#define COMMANDS DG_COUNT(commands)

static struct hf_rig rig;
static struct hf_rig lived_in;

static uint32_t address_of(const char *region)
{
    const int index = dg_store_find(&dg_hf_layout, region);

    assert_true(index >= 0);
    return dg_store_address(&dg_hf_layout, (uint8_t)index);
}

static uint32_t size_of(const char *region)
{
    return dg_hf_layout.regions[dg_store_find(&dg_hf_layout, region)].size;
}

static void assert_replies(const char *request, const char *reply)
{
    uint8_t bytes[DG_HF_FRAME_MAX];
    const size_t n = hf_rig_hex(reply, bytes, sizeof bytes);

    (void)hf_rig_ask(&rig, request);
    assert_int_equal(rig.reply_length, n + 1u);
    assert_memory_equal(rig.reply, bytes, n);
}

/* The queue of 5.1.2.13: depth 4, the oldest gives way, no code twice. */
struct queue {
    size_t n;
    uint8_t codes[DG_HF_STACK_DEPTH];
};

static void enter(struct queue *queue, uint8_t code)
{
    for (size_t i = 0; i < queue->n; i++) {
        if (queue->codes[i] == code) {
            return;
        }
    }
    if (queue->n == DG_HF_STACK_DEPTH) {
        memmove(queue->codes, &queue->codes[1], DG_HF_STACK_DEPTH - 1u);
        queue->n = DG_HF_STACK_DEPTH - 1u;
    }
    queue->codes[queue->n++] = code;
}

/* Read the error stack to its end; the warning bit says when that is (R10). */
static void assert_queue(const struct queue *expected)
{
    for (size_t i = 0; i <= expected->n; i++) {
        assert_int_equal(hf_rig_ask(&rig, "50"), 0);
        assert_int_equal(rig.reply[1], i + 1u < expected->n ? 0xD0 : 0x50);
        assert_int_equal(rig.reply[2], i < expected->n ? expected->codes[i] : 0);
    }
}

/* What a command with these locks answers when `locked` are in force. */
static int answer(uint8_t may_lock, uint8_t locked)
{
    for (size_t i = 0; i < DG_COUNT(locks); i++) {
        if ((may_lock & locked & locks[i].lock) != 0) {
            return locks[i].status;
        }
    }
    return 0;
}

static void assert_locked(uint8_t locked)
{
    for (size_t i = 0; i < COMMANDS; i++) {
        const uint32_t writes = rig.nvm.writes;
        const int expected = answer(commands[i].locks, locked);
        assert_int_equal(hf_rig_ask(&rig, commands[i].request), expected);
        assert_true(expected == 0 || rig.nvm.writes == writes);
    }
}

static void assert_label(bool damaged, uint8_t locked)
{
    const int lock = answer(D | E, locked);

    assert_int_equal(hf_rig_ask(&rig, "4C FF"), lock != 0 ? lock : damaged ? 0x12 : 0);
    assert_int_equal(hf_rig_ask(&rig, "4A FF 00 40 00"), lock != 0 ? lock : damaged ? 0x12 : 0);
}

/* Start with region n damaged for every bit n of `set`. */
static void assert_damage(uint32_t set)
{
    struct queue queue = {0};
    uint8_t locked = 0;

    for (uint32_t i = 0; i < CHECKED; i++) {
        if ((set >> i & 1u) != 0) {
            enter(&queue, regions[i].code);
            enter(&queue, 0x06);
            locked = (uint8_t)(locked | regions[i].lock | S);
        }
    }
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    /* Damaged UART settings or address: the delivery state answers. */
    assert_int_equal(rig.device.address, (set >> UART & 1u) != 0 ? 0x40 : 0x42);
    assert_queue(&queue);
    assert_label((set >> LABEL & 1u) != 0, locked);
    assert_locked(locked);
    assert_queue(&(struct queue){0});
}

static void flip(uint32_t address, unsigned bit)
{
    rig = lived_in;
    rig.nvm.bytes[address] ^= (uint8_t)(1u << bit);
}

static void every_bit_of_a_checked_region(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < CHECKED; i++) {
        const uint32_t address = address_of(regions[i].name);
        for (uint32_t at = 0; at < size_of(regions[i].name) + SUM_SIZE; at++) {
            for (unsigned bit = 0; bit < 8; bit++) {
                flip(address + at, bit);
                assert_damage(1u << i);
            }
        }
    }
}

/* Everything as it was, over the wire. */
static void assert_unharmed(void)
{
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_replies("50", "42 50 00");
    assert_replies("42", "42 42 00 12 34 55");
    assert_replies("46", "42 46 00 00 03");
    assert_replies("4E", "42 4E 66 02");
    assert_replies("52", "42 52 E4 27 70 00");
    assert_replies("4A 00 0F 02 55", "42 4A 00 0F 02 AA BB");
    assert_replies("4A 01 7F 01 55", "42 4A 01 7F 01 CC");
    assert_replies("44 49", "42 44 49 00 0C");
}

/* Headers and journal: repaired, dropped, or not looked at. */
static void every_bit_before_the_regions(void **state)
{
    const uint32_t end = address_of("resolution");

    (void)state;
    for (uint32_t address = 0; address < end; address++) {
        for (unsigned bit = 0; bit < 8; bit++) {
            flip(address, bit);
            assert_unharmed();
            /* And it is in order again: writing works, and the next start finds nothing. */
            assert_int_equal(hf_rig_ask(&rig, "47"), 0);
            assert_int_equal(hf_rig_power_on(&rig), DG_OK);
            assert_int_equal(rig.device.store.repairs, 0);
            assert_int_equal(rig.device.store.replays, 0);
            assert_replies("46", "42 46 00 00 04");
        }
    }
}

/* They come from the disc, 2048 periods a turn, 0.25 V around 2.5 V (4.1.3). */
static void sines_do_not_need_the_stored_resolution(void **state)
{
    const struct dg_hf_model *model = dg_hf_model_of(dg_device_find("s3684-rs485"));
    struct dg_hf_sincos out;

    (void)state;
    flip(address_of("resolution"), 0);
    const struct dg_hf_setup setup = hf_rig_setup(&rig, model);
    assert_int_equal(dg_hf_init(&rig.device, &setup), DG_OK);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    rig.angle = DG_TURN / 2048 / 4;
    dg_hf_sincos(&rig.device, rig.now, &out);
    assert_in_range(out.sin_plus_uv, 2749998, 2750002);
    assert_in_range(out.sin_minus_uv, 2249998, 2250002);
    assert_in_range(out.cos_plus_uv, 2499998, 2500002);
}

/* Headers damaged beyond repair are somebody else's memory: it stays as it is. */
static void both_headers_are_not_repaired(void **state)
{
    (void)state;
    rig = lived_in;
    rig.nvm.bytes[0] ^= 1u;
    rig.nvm.bytes[12] ^= 1u;
    const uint32_t writes = rig.nvm.writes;
    assert_int_equal(hf_rig_power_on(&rig), DG_ERR_FOREIGN);
    assert_int_equal(rig.device.line, DG_HF_OFF);
    assert_int_equal(rig.nvm.writes, writes);
}

/* Field 0 is 32 bytes, field 1 is 128; the rest of the user memory belongs to nobody. */
static int owner_of(uint32_t at, uint32_t first, uint32_t second)
{
    return at < first ? 0 : at < second ? 1 : -1;
}

/* Damaged content shows on access to that field only (R8); from then on writing is locked until the
 * next start (R24, 5.1.3.4). `reads`: found by 4Ah or by 4Bh. */
static void assert_content_damaged(int field, bool reads)
{
    static const struct queue found = {.n = 2, .codes = {0x03, 0x06}};
    const uint8_t locked = field >= 0 ? W : 0;

    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_replies("50", "42 50 00");
    if (reads) {
        assert_int_equal(hf_rig_ask(&rig, "4A 00 00 01 55"), field == 0 ? 0x03 : 0);
        assert_int_equal(hf_rig_ask(&rig, "4A 01 7F 01 55"), field == 1 ? 0x03 : 0);
    } else {
        assert_int_equal(hf_rig_ask(&rig, "4B 01 00 01 55 01"), field == 1 ? 0x03 : 0);
        assert_int_equal(hf_rig_ask(&rig, "4B 00 1F 01 55 01"), field >= 0 ? 0x03 : 0);
    }
    assert_queue(field >= 0 ? &found : &(struct queue){0});
    for (size_t i = 0; field >= 0 && i < COMMANDS; i++) {
        const int expected = answer(commands[i].locks, locked);
        if (expected != 0) {
            assert_int_equal(hf_rig_ask(&rig, commands[i].request), expected);
        }
    }
    assert_replies("4C 00", "42 4C 00 C9");
    assert_replies("4C 01", "42 4C 01 CF");
    assert_replies("42", "42 42 00 12 34 55");
    assert_replies("50", "42 50 00");
    /* After the next start the last field can be erased and created anew, and is as new. */
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_int_equal(hf_rig_ask(&rig, "4D 01 4F 55"), 0);
    assert_int_equal(hf_rig_ask(&rig, "4D 01 CF 55"), 0);
    assert_replies("4A 01 00 02 55", "42 4A 01 00 02 FF FF");
}

static void every_bit_of_the_data_fields(void **state)
{
    const uint32_t sums = address_of("field-sums");
    const uint32_t user = address_of("user");

    (void)state;
    for (unsigned bit = 0; bit < 8; bit++) {
        for (uint32_t at = 0; at < size_of("field-sums"); at++) {
            flip(sums + at, bit);
            assert_content_damaged(owner_of(at, 2, 4), at % 2u == 0);
        }
        for (uint32_t at = 0; at < size_of("user"); at++) {
            flip(user + at, bit);
            assert_content_damaged(owner_of(at, 32, 160), at % 2u == 0);
        }
    }
}

/* All 2^13 combinations: one bit in each region, somewhere else every time. */
static void every_set_of_damaged_regions(void **state)
{
    (void)state;
    for (uint32_t set = 0; set < 1u << CHECKED; set++) {
        rig = lived_in;
        for (uint32_t i = 0; i < CHECKED; i++) {
            const uint32_t at = (set * 7u + i) % (size_of(regions[i].name) + SUM_SIZE);
            if ((set >> i & 1u) != 0) {
                rig.nvm.bytes[address_of(regions[i].name) + at] ^= (uint8_t)(1u << (set % 8u));
            }
        }
        assert_damage(set);
    }
}

/* A table with a right sum that cannot be true: 03h on every access, and nothing is read beyond it
 * or written by it. */
static void a_forged_table_is_refused(void **state)
{
    static const struct {
        uint8_t count;
        uint8_t status;
    } forged[] = {{113, 0x80}, {255, 0x80}, {15, 0xCF}, {112, 0xFF}};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(forged); i++) {
        uint8_t table[DG_STORE_CHECKED_MAX];
        const uint16_t size = (uint16_t)size_of("fields");
        rig = lived_in;
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        memset(table, forged[i].status, sizeof table);
        table[0] = forged[i].count;
        assert_int_equal(dg_store_put(&rig.device.store, DG_HF_REGION_FIELDS, 0, table, size),
                         DG_OK);
        assert_int_equal(hf_rig_power_on(&rig), DG_OK);
        const uint32_t writes = rig.nvm.writes;
        assert_int_equal(hf_rig_ask(&rig, "4A 00 00 01 55"), 0x03);
        assert_int_equal(hf_rig_ask(&rig, "4B 00 00 01 55 00"), 0x03);
        assert_int_equal(hf_rig_ask(&rig, "4C 00"), 0x03);
        assert_int_equal(hf_rig_ask(&rig, "4D 00 00 55"), 0x03);
        assert_int_equal(hf_rig_ask(&rig, "4E"), 0x03);
        assert_int_equal(rig.nvm.writes, writes);
        assert_int_equal(hf_rig_ask(&rig, "4A FF 00 40 00"), 0);
    }
}

/* 53h starts anew: the errors are entered again; and nothing was healed meanwhile. */
static void a_reset_finds_the_damage_again(void **state)
{
    static const struct queue queue = {.n = 2, .codes = {0x08, 0x06}};

    (void)state;
    flip(address_of("counter"), 0);
    assert_int_equal(hf_rig_power_on(&rig), DG_OK);
    assert_queue(&queue);
    assert_int_equal(hf_rig_ask(&rig, "53"), HF_RIG_SILENCE);
    assert_queue(&queue);
    assert_int_equal(hf_rig_ask(&rig, "46"), 0x06);
}

/* The layout has no checked region that this file does not know. */
static void all_regions_are_known(void **state)
{
    uint32_t checked = 0;

    (void)state;
    for (uint8_t i = 0; i < dg_hf_layout.region_count; i++) {
        checked += dg_hf_layout.regions[i].check == DG_STORE_CHECKED;
    }
    assert_int_equal(checked, CHECKED);
    for (uint32_t i = 1; i < CHECKED; i++) {
        assert_true(dg_store_find(&dg_hf_layout, regions[i - 1].name) <
                    dg_store_find(&dg_hf_layout, regions[i].name));
    }
}

/* Address 42h, position 00123455h, counter 3, two fields. */
static int live(void **state)
{
    static const char *const history[] = {
        "55 42 55",
        "43 00 12 34 55 55",
        "47",
        "47",
        "47",
        "4D 00 C9 55",
        "4D 01 CF 55",
        "4B 00 0F 02 55 AA BB",
        "4B 01 7F 01 55 CC",
    };

    (void)state;
    if (hf_rig_init(&rig, dg_hf_model_of(dg_device_find("s3684-rs485"))) != DG_OK ||
        hf_rig_power_on(&rig) != DG_OK) {
        return -1;
    }
    for (size_t i = 0; i < DG_COUNT(history); i++) {
        if (hf_rig_ask(&rig, history[i]) != 0) {
            return -1;
        }
    }
    dg_hf_power_off(&rig.device);
    lived_in = rig;
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_regions_are_known),
        cmocka_unit_test(every_bit_of_a_checked_region),
        cmocka_unit_test(sines_do_not_need_the_stored_resolution),
        cmocka_unit_test(every_bit_before_the_regions),
        cmocka_unit_test(both_headers_are_not_repaired),
        cmocka_unit_test(every_bit_of_the_data_fields),
        cmocka_unit_test(every_set_of_damaged_regions),
        cmocka_unit_test(a_forged_table_is_refused),
        cmocka_unit_test(a_reset_finds_the_damage_again),
    };
    return cmocka_run_group_tests(tests, live, NULL);
}

/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"

/* One byte in front, so that every access is at an odd address. */
static const uint8_t BYTES[] = {0x00, 0x81, 0x92, 0xA3, 0xB4};

static void loads(void **state)
{
    (void)state;
    assert_int_equal(dg_load_be16(BYTES + 1), 0x8192);
    assert_int_equal(dg_load_be24(BYTES + 1), 0x8192A3);
    assert_int_equal(dg_load_be32(BYTES + 1), 0x8192A3B4);
    assert_int_equal(dg_load_le16(BYTES + 1), 0x9281);
    assert_int_equal(dg_load_le32(BYTES + 1), 0xB4A39281);
}

/** After a store into six bytes of EEh, starting at the second. */
static void assert_stored(const uint8_t *at, const uint8_t *wanted, size_t n)
{
    uint8_t expected[6];

    memset(expected, 0xEE, sizeof expected);
    memcpy(expected + 1, wanted, n);
    assert_memory_equal(at, expected, sizeof expected);
}

static void stores_touch_only_their_bytes(void **state)
{
    uint8_t to[6];

    (void)state;
    memset(to, 0xEE, sizeof to);
    dg_store_be16(to + 1, 0x8192);
    assert_stored(to, (const uint8_t[]){0x81, 0x92}, 2);
    memset(to, 0xEE, sizeof to);
    dg_store_be24(to + 1, 0xFF8192A3); /* the highest byte has no place */
    assert_stored(to, (const uint8_t[]){0x81, 0x92, 0xA3}, 3);
    memset(to, 0xEE, sizeof to);
    dg_store_be32(to + 1, 0x8192A3B4);
    assert_stored(to, (const uint8_t[]){0x81, 0x92, 0xA3, 0xB4}, 4);
    memset(to, 0xEE, sizeof to);
    dg_store_le16(to + 1, 0x8192);
    assert_stored(to, (const uint8_t[]){0x92, 0x81}, 2);
    memset(to, 0xEE, sizeof to);
    dg_store_le32(to + 1, 0x8192A3B4);
    assert_stored(to, (const uint8_t[]){0xB4, 0xA3, 0x92, 0x81}, 4);
}

static void reader_reads_in_order(void **state)
{
    static const uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7};
    struct dg_reader r = dg_reader(bytes, sizeof bytes);

    (void)state;
    assert_int_equal(dg_read_u8(&r), 0x01);
    assert_int_equal(dg_read_be16(&r), 0x0203);
    assert_int_equal(dg_read_be32(&r), 0x04050607);
    assert_ptr_equal(r.at, r.end);
    assert_false(r.overrun);
    assert_int_equal(dg_read_u8(&r), 0);
    assert_true(r.overrun);
}

/* Every value width against every length that is too short for it. */
static void reader_gives_zero_past_the_end(void **state)
{
    static const uint8_t bytes[] = {0xFF, 0xFF, 0xFF, 0xFF};

    (void)state;
    for (size_t n = 0; n < 4; n++) {
        struct dg_reader r = dg_reader(bytes, n);

        assert_int_equal(dg_read_be32(&r), 0);
        assert_true(r.overrun);
        assert_int_equal(dg_read_u8(&r), 0); /* nothing of the missing value is left over */
        assert_ptr_equal(r.at, bytes + n);
    }
    for (size_t n = 0; n < 2; n++) {
        struct dg_reader r = dg_reader(bytes, n);

        assert_int_equal(dg_read_be16(&r), 0);
        assert_true(r.overrun);
    }
}

static void reader_of_nothing(void **state)
{
    struct dg_reader r = dg_reader(NULL, 0);

    (void)state;
    assert_false(r.overrun);
    assert_int_equal(dg_read_u8(&r), 0);
    assert_true(r.overrun);
}

static void writer_writes_in_order(void **state)
{
    static const uint8_t wanted[] = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06,
                                     0x07, 0x08, 0x09, 0x0A, 0x0B, 0x0C};
    uint8_t to[sizeof wanted];
    struct dg_writer w = dg_writer(to, sizeof to);

    (void)state;
    dg_write_u8(&w, 0x01);
    dg_write_be16(&w, 0x0203);
    dg_write_be24(&w, 0x040506);
    dg_write_be32(&w, 0x0708090A);
    dg_write_bytes(&w, (const uint8_t[]){0x0B, 0x0C}, 2);
    assert_false(w.overrun);
    assert_ptr_equal(w.at, w.end);
    assert_memory_equal(to, wanted, sizeof wanted);
}

static void write_nth(struct dg_writer *w, int width)
{
    switch (width) {
    case 1:
        dg_write_u8(w, 0x11);
        return;
    case 2:
        dg_write_be16(w, 0x1111);
        return;
    case 3:
        dg_write_be24(w, 0x111111);
        return;
    case 4:
        dg_write_be32(w, 0x11111111);
        return;
    case 5:
        dg_write_bytes(w, (const uint8_t[]){0x11, 0x11, 0x11, 0x11, 0x11}, 5);
        return;
    default:
        fail();
    }
}

/* Every width against every capacity below it: dropped whole, and everything after it as well. */
static void writer_drops_what_does_not_fit(void **state)
{
    (void)state;
    for (int width = 1; width <= 5; width++) {
        for (size_t capacity = 0; capacity < (size_t)width; capacity++) {
            uint8_t to[8];
            uint8_t untouched[8];
            struct dg_writer w = dg_writer(to, capacity);

            memset(to, 0xEE, sizeof to);
            memset(untouched, 0xEE, sizeof untouched);
            write_nth(&w, width);
            assert_true(w.overrun);
            dg_write_u8(&w, 0x22);
            assert_true(w.overrun);
            assert_ptr_equal(w.at, to);
            assert_memory_equal(to, untouched, sizeof to);
        }
    }
}

static void writer_takes_nothing(void **state)
{
    uint8_t byte = 0xEE;
    struct dg_writer none = dg_writer(NULL, 0);
    struct dg_writer w = dg_writer(&byte, 1);

    (void)state;
    dg_write_bytes(&none, NULL, 0);
    assert_false(none.overrun);
    dg_write_u8(&none, 1);
    assert_true(none.overrun);
    dg_write_bytes(&w, NULL, 0);
    assert_false(w.overrun);
    assert_ptr_equal(w.at, &byte);
    assert_int_equal(byte, 0xEE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loads),
        cmocka_unit_test(stores_touch_only_their_bytes),
        cmocka_unit_test(reader_reads_in_order),
        cmocka_unit_test(reader_gives_zero_past_the_end),
        cmocka_unit_test(reader_of_nothing),
        cmocka_unit_test(writer_writes_in_order),
        cmocka_unit_test(writer_drops_what_does_not_fit),
        cmocka_unit_test(writer_takes_nothing),
    };

    return cmocka_run_group_tests_name("bits", tests, NULL, NULL);
}

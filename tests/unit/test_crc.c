/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drehgeber/crc.h"

static const uint8_t DIGITS[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};

/* The definitions, a bit at a time. */

static uint16_t crc16_by_bits(uint16_t crc, const uint8_t *bytes, size_t n)
{
    for (size_t bit = 0; bit < n * 8; bit++) {
        unsigned in = ((unsigned)bytes[bit / 8] >> (7 - bit % 8)) & 1u;
        unsigned out = ((unsigned)crc >> 15) & 1u;

        crc = (uint16_t)(((uint32_t)crc << 1) ^ (in != out ? 0x1021u : 0u));
    }
    return crc;
}

static uint32_t crc32_by_bits(uint32_t crc, const uint8_t *bytes, size_t n)
{
    crc = ~crc;
    for (size_t bit = 0; bit < n * 8; bit++) {
        unsigned in = ((unsigned)bytes[bit / 8] >> (bit % 8)) & 1u;

        crc = (crc >> 1) ^ (in != (crc & 1u) ? 0xEDB88320u : 0u); /* 04C11DB7h reflected */
    }
    return ~crc;
}

/* Catalogue of parametrised CRC algorithms: IBM-3740, XMODEM, ISO-HDLC. */
static void check_values(void **state)
{
    (void)state;
    assert_int_equal(dg_crc16(0xFFFF, DIGITS, sizeof DIGITS), 0x29B1);
    assert_int_equal(dg_crc16(0, DIGITS, sizeof DIGITS), 0x31C3);
    assert_int_equal(dg_crc32(0, DIGITS, sizeof DIGITS), 0xCBF43926);
}

/* Frames of real encoders: the last byte is the XOR of the others. */
static void xor_of_real_frames(void **state)
{
    static const uint8_t position[] = {0x40, 0x42, 0x00, 0x27, 0x25, 0x51, 0x51};
    static const uint8_t status[] = {0x40, 0x52, 0xE4, 0xFF, 0x80, 0x01, 0x88};

    (void)state;
    assert_int_equal(dg_xor8(0, position, sizeof position - 1), 0x51);
    assert_int_equal(dg_xor8(0, status, sizeof status - 1), 0x88);
    assert_int_equal(dg_xor8(0, position, sizeof position), 0);
    assert_int_equal(dg_xor8(0xA5, position, 1), 0xE5);
}

static void nothing_changes_nothing(void **state)
{
    (void)state;
    assert_int_equal(dg_xor8(0x5A, NULL, 0), 0x5A);
    assert_int_equal(dg_crc16(0x1234, NULL, 0), 0x1234);
    assert_int_equal(dg_crc32(0x12345678, NULL, 0), 0x12345678);
}

/* All values of a byte from several seeds against the definition: every table row is used. */
static void every_byte_agrees_with_the_definition(void **state)
{
    static const uint32_t seeds[] = {0, 0xFFFFFFFF, 0x8000, 0xA5C3F00F, 1};

    (void)state;
    for (unsigned value = 0; value < 256; value++) {
        uint8_t byte = (uint8_t)value;

        for (size_t i = 0; i < DG_COUNT(seeds); i++) {
            uint16_t seed16 = (uint16_t)seeds[i];

            assert_int_equal(dg_crc16(seed16, &byte, 1), crc16_by_bits(seed16, &byte, 1));
            assert_int_equal(dg_crc32(seeds[i], &byte, 1), crc32_by_bits(seeds[i], &byte, 1));
        }
    }
}

static void pieces_give_the_whole(void **state)
{
    uint8_t bytes[256];

    (void)state;
    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)(i * 167 + 13);
    }
    for (size_t cut = 0; cut <= sizeof bytes; cut++) {
        size_t rest = sizeof bytes - cut;

        assert_int_equal(dg_xor8(dg_xor8(7, bytes, cut), bytes + cut, rest),
                         dg_xor8(7, bytes, sizeof bytes));
        assert_int_equal(dg_crc16(dg_crc16(0xFFFF, bytes, cut), bytes + cut, rest),
                         crc16_by_bits(0xFFFF, bytes, sizeof bytes));
        assert_int_equal(dg_crc32(dg_crc32(0, bytes, cut), bytes + cut, rest),
                         crc32_by_bits(0, bytes, sizeof bytes));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(check_values),
        cmocka_unit_test(xor_of_real_frames),
        cmocka_unit_test(nothing_changes_nothing),
        cmocka_unit_test(every_byte_agrees_with_the_definition),
        cmocka_unit_test(pieces_give_the_whole),
    };

    return cmocka_run_group_tests_name("crc", tests, NULL, NULL);
}

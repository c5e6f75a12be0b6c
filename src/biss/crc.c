/* SPDX-License-Identifier: MIT */
/*
 * The CRCs of BiSS are short and not over bytes: they go over the bits of a word, and are sent
 * inverted.
 */
#include "drehgeber/biss.h"

/* The remainders of 0..63 times x^6: six bits in one go. */
static const uint8_t remainders[64] = {
    0x00, 0x03, 0x06, 0x05, 0x0C, 0x0F, 0x0A, 0x09, 0x18, 0x1B, 0x1E, 0x1D, 0x14, 0x17, 0x12, 0x11,
    0x30, 0x33, 0x36, 0x35, 0x3C, 0x3F, 0x3A, 0x39, 0x28, 0x2B, 0x2E, 0x2D, 0x24, 0x27, 0x22, 0x21,
    0x23, 0x20, 0x25, 0x26, 0x2F, 0x2C, 0x29, 0x2A, 0x3B, 0x38, 0x3D, 0x3E, 0x37, 0x34, 0x31, 0x32,
    0x13, 0x10, 0x15, 0x16, 0x1F, 0x1C, 0x19, 0x1A, 0x0B, 0x08, 0x0D, 0x0E, 0x07, 0x04, 0x01, 0x02};

/* Words of 32 bits: small processors shift 64 in a call. @param n a multiple of 6 */
static uint32_t crc6_of(uint32_t crc, uint32_t bits, uint32_t n)
{
    while (n > 0) {
        n -= 6u;
        crc = remainders[crc ^ (bits >> n & 0x3Fu)];
    }
    return crc;
}

uint8_t dg_biss_crc6(uint64_t bits, uint8_t n)
{
    uint32_t crc = 0;

    bits = n < 64 ? bits & (((uint64_t)1 << n) - 1u) : bits;
    /* Zeros in front change nothing while the start value is 0. */
    if (n > 60u) {
        crc = crc6_of(crc, (uint32_t)(bits >> 60), 6);
    }
    if (n > 30u) {
        crc = crc6_of(crc, (uint32_t)(bits >> 30), 30);
    }
    return (uint8_t)(crc6_of(crc, (uint32_t)bits, 30) ^ 0x3Fu);
}

uint8_t dg_biss_crc4(uint64_t bits, uint8_t n)
{
    uint8_t crc = 0;

    for (uint8_t i = n; i > 0; i--) {
        const uint64_t carry = ((uint64_t)crc >> 3 ^ bits >> (i - 1u)) & 1u;
        crc = (uint8_t)((crc & 0x07u) << 1 ^ (carry != 0 ? 0x03u : 0u));
    }
    return (uint8_t)(crc ^ 0x0Fu);
}

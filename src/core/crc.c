/* SPDX-License-Identifier: MIT */
#include "drehgeber/crc.h"

uint8_t dg_xor8(uint8_t seed, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        seed ^= bytes[i];
    }
    return seed;
}

/* A byte's remainder put together from shifts of it, as the polynomial x^16 + x^12 + x^5 + 1
 * allows: neither a table nor a loop over bits. */
uint16_t dg_crc16(uint16_t seed, const uint8_t *bytes, size_t n)
{
    uint32_t crc = seed;

    for (size_t i = 0; i < n; i++) {
        uint32_t top = (crc >> 8 & 0xFFu) ^ bytes[i];
        top ^= top >> 4;
        crc = crc << 8 ^ top << 12 ^ top << 5 ^ top;
    }
    return (uint16_t)crc;
}

/*
 * A nibble at a time: a table of 16 words is the smallest that still avoids the loop over bits,
 * which counts on a Cortex-M0+ without a hardware CRC.
 */
static const uint32_t CRC32_OF_NIBBLE[16] = {
    0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
    0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
};

static uint32_t crc32_nibble(uint32_t crc, uint8_t nibble)
{
    return crc >> 4 ^ CRC32_OF_NIBBLE[(crc ^ nibble) & 0x0F];
}

uint32_t dg_crc32(uint32_t seed, const uint8_t *bytes, size_t n)
{
    uint32_t crc = ~seed;

    for (size_t i = 0; i < n; i++) {
        crc = crc32_nibble(crc, bytes[i] & 0x0F); /* reflected: low nibble first */
        crc = crc32_nibble(crc, bytes[i] >> 4);
    }
    return ~crc;
}

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Check sums. All of them work on a running value, so that data can come in pieces.
 */
#ifndef DREHGEBER_CRC_H
#define DREHGEBER_CRC_H

#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/** XOR of all bytes, from `seed` (0 to start). RS485 frames and the extended type label. */
DG_API uint8_t dg_xor8(uint8_t seed, const uint8_t *bytes, size_t n);

/**
 * CRC-16, polynomial 1021h, most significant bit first, no reflection, no final XOR.
 * Check value over "123456789": 29B1h from seed FFFFh, 31C3h from seed 0.
 */
DG_API uint16_t dg_crc16(uint16_t seed, const uint8_t *bytes, size_t n);

/**
 * CRC-32 as in IEEE 802.3 (reflected, polynomial 04C11DB7h). Start with 0 and feed the result of
 * one piece into the next. Check value over "123456789": CBF43926h.
 */
DG_API uint32_t dg_crc32(uint32_t seed, const uint8_t *bytes, size_t n);

#ifdef __cplusplus
}
#endif

#endif

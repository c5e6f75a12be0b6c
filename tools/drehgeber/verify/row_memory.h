/* SPDX-License-Identifier: MIT */
/** The EEPROM of an encoder that rows are run against: in RAM, until the next row. */
#ifndef DREHGEBER_VERIFY_ROW_MEMORY_H
#define DREHGEBER_VERIFY_ROW_MEMORY_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/hal.h"

/** Capacity; reads and writes beyond `size` fail. */
#define CF_MEMORY_MAX 16384u

struct cf_memory {
    uint32_t size; /**< bytes in use */
    bool silent;   /**< every operation returns DG_ERR_IO until cleared */
    uint8_t bytes[CF_MEMORY_MAX];
};

/** All FFh, `size` bytes, at most CF_MEMORY_MAX. */
void cf_memory_init(struct cf_memory *self, uint32_t size);

/** The operations on `self`. */
struct dg_nvm cf_memory_port(struct cf_memory *self);

#endif

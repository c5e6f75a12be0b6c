/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An EEPROM in memory: for encoders that forget, and to look at an image without touching its file.
 */
#ifndef DREHGEBER_LINUX_NVM_MEMORY_H
#define DREHGEBER_LINUX_NVM_MEMORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/hal.h"

/** Plain bytes. */
struct lx_nvm_memory {
    uint8_t *bytes; /**< owned */
    uint32_t size;
};

/** Whether `n` bytes at `address` are all in a memory of `size` bytes. */
static inline bool lx_nvm_inside(uint32_t size, uint32_t address, size_t n)
{
    return address <= size && n <= size - address;
}

/** Read `n` bytes at `address` of a memory that `bytes` hold. @return DG_OK, or DG_ERR_IO: they are
 * not all in it */
static inline int lx_nvm_read(const uint8_t *bytes, uint32_t size, uint32_t address, void *to,
                              size_t n)
{
    if (!lx_nvm_inside(size, address, n)) {
        return DG_ERR_IO;
    }
    memcpy(to, bytes + address, n);
    return DG_OK;
}

/** `size` bytes, all FFh. @return 0, or -1 without memory */
int lx_nvm_memory_init(struct lx_nvm_memory *self, uint32_t size);

/** Give the bytes back; also when there are none. */
void lx_nvm_memory_free(struct lx_nvm_memory *self);

/** The operations on `self`. */
struct dg_nvm lx_nvm_memory_port(struct lx_nvm_memory *self);

#endif

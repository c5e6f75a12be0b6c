/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An EEPROM in memory: for encoders that forget, and to look at an image without touching its file.
 */
#ifndef DREHGEBER_LINUX_NVM_MEMORY_H
#define DREHGEBER_LINUX_NVM_MEMORY_H

#include <stdint.h>

#include "drehgeber/hal.h"

/** Plain bytes. */
struct lx_nvm_memory {
    uint8_t *bytes; /**< owned */
    uint32_t size;
};

/** `size` bytes, all FFh. @return 0, or -1 without memory */
int lx_nvm_memory_init(struct lx_nvm_memory *self, uint32_t size);

/** Give the bytes back; also when there are none. */
void lx_nvm_memory_free(struct lx_nvm_memory *self);

/** The operations on `self`. */
struct dg_nvm lx_nvm_memory_port(struct lx_nvm_memory *self);

#endif

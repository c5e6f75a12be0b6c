/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The seam between the core and its host: result codes and the non-volatile memory.
 *
 * A port is one const struct of operations and a `void *ctx`, handed over at initialisation and
 * alive as long as the object it was handed to. The wire's operations stand with each stack
 * (dg_hf_ops in hiperface.h, ...).
 */
#ifndef DREHGEBER_HAL_H
#define DREHGEBER_HAL_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * What a function of this library returns: 0 is success, negative is one of these, positive is a
 * count where the function says so. Never to be mixed up with the codes a device puts on its wire.
 */
enum dg_result {
    DG_OK = 0,
    DG_ERR_ARGUMENT = -1, /**< an argument is outside its documented range; nothing was changed */
    DG_ERR_IO = -2,       /**< the memory did not acknowledge; old or new value, never mixed */
    DG_ERR_SPACE = -3,    /**< does not fit; nothing was changed */
    DG_ERR_DAMAGED = -4,  /**< the stored bytes fail their check sum */
    DG_ERR_BLANK = -5,    /**< the memory holds no image (reads FFh throughout its header) */
    DG_ERR_FOREIGN = -6,  /**< the memory holds something else; nothing was written */
    DG_ERR_OLDER = -7,    /**< the memory is of an earlier release, see dg_store_grow() */
};

/**
 * Non-volatile memory (EEPROM, FRAM, flash emulation, a file). All three operations may block.
 * They return 0 or DG_ERR_IO and must not call back into the device.
 */
struct dg_nvm_ops {
    /** Read `n` bytes at `address` into `to`. All `n` bytes or DG_ERR_IO. */
    int (*read)(void *ctx, uint32_t address, void *to, size_t n);
    /** Write `n` bytes. May reach the medium in any order and in part until `sync` returns 0. */
    int (*write)(void *ctx, uint32_t address, const void *from, size_t n);
    /** Everything written before is durable when this returns 0. NULL: writes are durable. */
    int (*sync)(void *ctx);
};

/** A memory: operations and what they work on. */
struct dg_nvm {
    const struct dg_nvm_ops *ops;
    void *ctx;
};

#ifdef __cplusplus
}
#endif

#endif

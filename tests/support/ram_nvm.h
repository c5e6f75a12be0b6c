/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An EEPROM in RAM for tests: counts writes, loses power in the middle of any of them, tears the
 * write it happens in, rots bits, stops acknowledging. Enters through struct dg_nvm only.
 */
#ifndef TESTS_SUPPORT_RAM_NVM_H
#define TESTS_SUPPORT_RAM_NVM_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/hal.h"

/** Capacity; reads and writes beyond `size` fail. */
#define RAM_NVM_MAX 16384u

/** What becomes of writes since the last sync when the power fails. */
enum ram_nvm_tear {
    RAM_NVM_ORDERED,   /**< earlier writes are there, the one it happened in is cut after byte
                            `tear_at`, later ones are lost */
    RAM_NVM_UNSYNCED,  /**< every write since the last sync is lost */
    RAM_NVM_REORDERED, /**< writes since the last sync: odd ones are there, even ones lost */
    RAM_NVM_GARBLED,   /**< like ORDERED, and the rest of the torn write reads as noise */
    RAM_NVM_TEAR_COUNT
};

struct ram_nvm {
    uint32_t size;        /**< bytes in use, at most RAM_NVM_MAX */
    uint32_t writes;      /**< write calls since ram_nvm_init() */
    uint32_t syncs;       /**< sync calls since ram_nvm_init() */
    int64_t cut_at_write; /**< power fails in this write call (0 = the next one); -1: never */
    uint32_t tear_at;     /**< bytes of that write that still get through */
    enum ram_nvm_tear tear;
    bool dead;           /**< the power has failed: every operation returns DG_ERR_IO */
    bool no_acknowledge; /**< every operation returns DG_ERR_IO until cleared */
    uint8_t bytes[RAM_NVM_MAX];
    uint8_t synced[RAM_NVM_MAX]; /**< content at the last sync */
};

/** All FFh, `size` bytes, healthy. */
void ram_nvm_init(struct ram_nvm *self, uint32_t size);

/** The operations on `self`. */
struct dg_nvm ram_nvm_port(struct ram_nvm *self);

/** The power fails in the nth write from now (0 = the next). */
void ram_nvm_cut(struct ram_nvm *self, uint32_t nth, enum ram_nvm_tear tear, uint32_t tear_at);

/** Power is back: what survived can be read, nothing is cut any more. */
void ram_nvm_restore(struct ram_nvm *self);

#endif

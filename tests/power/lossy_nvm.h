/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A memory that may lose, keep or tear each write it has not synced, independently of the others,
 * and every image it can leave behind. Enters through struct dg_nvm only.
 */
#ifndef TESTS_POWER_LOSSY_NVM_H
#define TESTS_POWER_LOSSY_NVM_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/hal.h"

#define LOSSY_NVM_MAX 3072u    /**< bytes of memory */
#define LOSSY_NVM_PENDING 200u /**< writes between two syncs */
#define LOSSY_NVM_LOG 4096u    /**< bytes of these writes */
#define LOSSY_NVM_NEVER UINT32_MAX

/** How much of a write that fails gets through. */
enum lossy_nvm_through { LOSSY_NVM_NOTHING, LOSSY_NVM_HALF, LOSSY_NVM_ALL, LOSSY_NVM_THROUGHS };

/** A write whose fate is open until the next sync. */
struct lossy_nvm_write {
    uint32_t address;
    uint32_t at; /**< of its bytes in `log` */
    uint16_t n;
};

/** Plain data: a copy is the same memory at another moment. */
struct lossy_nvm {
    uint32_t size;
    uint32_t calls;              /**< operations so far */
    uint32_t fail_from, fail_to; /**< those in between fail; dead from `die_at` on: */
    uint32_t die_at;             /**< the process has ended, nothing reaches the memory any more */
    enum lossy_nvm_through through;
    uint32_t syncs;                 /**< sync operations so far */
    uint32_t skip;                  /**< this one acknowledges and does nothing */
    void (*before_sync)(void *ctx); /**< while every pending write is still open */
    void *ctx;
    uint32_t pending_count, log_length;
    struct lossy_nvm_write pending[LOSSY_NVM_PENDING];
    uint8_t log[LOSSY_NVM_LOG];
    uint8_t bytes[LOSSY_NVM_MAX];   /**< what a read sees */
    uint8_t durable[LOSSY_NVM_MAX]; /**< what a power cut leaves for certain, below the pending */
};

/** `size` bytes as in `image`, all durable; healthy. */
void lossy_nvm_init(struct lossy_nvm *self, const uint8_t *image, uint32_t size);

/** The operations on `self`. */
struct dg_nvm lossy_nvm_port(struct lossy_nvm *self);

/** What was found out about the images of one moment. */
struct lossy_nvm_count {
    uint64_t images;
    bool
        all; /**< every combination of every fate; else those of bounded distance, see the source */
};

/**
 * Call `see` with every image that a power cut at this moment may leave, some of them twice. Every
 * combination if that is at most `limit`. Else from "the first n writes are there and the others
 * are not", for each n, every way in which as many writes as the limit allows have another fate; at
 * least write n has each of its fates, and each write is lost, or kept, alone.
 */
struct lossy_nvm_count lossy_nvm_cut(const struct lossy_nvm *self, uint64_t limit,
                                     void (*see)(void *ctx, const uint8_t *image), void *ctx);

#endif

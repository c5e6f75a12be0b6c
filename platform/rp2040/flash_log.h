/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EEPROM of the encoder in the last 64 KiB of a flash of 2 MiB: a copy in SRAM, and a log of
 * the pieces of it that have changed. A piece is a page of flash with its CRC, what was written
 * before a sync is a group of pages, and a group counts when all of it is there. A power cut leaves
 * the memory as it was before a sync or as it is behind it.
 *
 * The log has two halves of 8 sectors. When one is full, the other one begins with all pieces; what
 * is behind it is erased when the encoder has nothing else to do.
 */
#ifndef FLASH_LOG_H
#define FLASH_LOG_H

#include <stdbool.h>

#include "drehgeber/hal.h"
#include "drehgeber/store.h"
#include "drehgeber/time.h"

/** Things nobody has to act on; they only count up. */
struct flash_log_counters {
    uint32_t pages;   /**< programmed */
    uint32_t sectors; /**< erased */
    uint32_t late;    /**< ... while somebody waited for it */
    uint32_t bad;     /**< pages that did not read as they were written */
};
extern struct flash_log_counters flash_log_counters;

/** Whether a sync returns before its pages are written, and flash_log_loop() writes them: for ports
 * that must not wait. Each port says so. */
extern const bool flash_log_behind;

/** Read the log. @return the memory; none for NULL as layout */
struct dg_nvm flash_log_open(const struct dg_store_layout *layout);

/** From the main loop. A sector of the other half may be erased, for which the processor waits for
 * 45 ms, at most 400 (W25Q16JV): whenever `idle`, as nothing is wanted of the encoder for some
 * time; and in a `pause` when so little is left of this half that the other one would not be empty
 * in time. @return as port_loop() */
dg_ns flash_log_loop(bool idle, bool pause);

#endif

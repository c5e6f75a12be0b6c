/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EEPROM of an RS485 encoder on Linux: in memory, or in a file that belongs to this encoder.
 */
#ifndef DREHGEBER_LINUX_EEPROM_H
#define DREHGEBER_LINUX_EEPROM_H

#include "hf_settings.h"
#include "nvm_file.h"
#include "nvm_memory.h"

/** Where the bytes are. Not to be moved while `nvm` is in use. */
struct lx_eeprom {
    struct lx_nvm_memory memory; /**< the delivery state; the EEPROM itself without a file */
    struct lx_nvm_file file;
    struct dg_nvm nvm; /**< for the device */
};

/**
 * The EEPROM of the encoder that `settings` describe. `path` NULL: in memory. A new file gets the
 * delivery state with the address of `settings`. An existing one must hold an image of this kind of
 * device, with the same factory figures; serial number (unless it was asked for), firmware version
 * and date may be its own; another address than the one of `settings` is noted. A cut-off image is
 * taken: the device reports what is damaged. So is one of an earlier release: it grows when the
 * device starts.
 * @return 0, or -1 with one line in `error`, an existing file untouched
 */
int lx_eeprom_open(struct lx_eeprom *self, const char *path, const struct lx_hf_settings *settings,
                   const struct lx_say *say, struct lx_error *error);

/** Close the file, free the memory; also after a failed open. */
void lx_eeprom_close(struct lx_eeprom *self);

#endif

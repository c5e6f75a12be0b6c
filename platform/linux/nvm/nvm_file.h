/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An EEPROM in a file: of one encoder at a time, durable when sync returns.
 */
#ifndef DREHGEBER_LINUX_NVM_FILE_H
#define DREHGEBER_LINUX_NVM_FILE_H

#include <stdbool.h>
#include <stdint.h>

#include "drehgeber/hal.h"
#include "say.h"

/**
 * An open file. The path is borrowed. Read once, when it is opened: from then on the file is this
 * process's, and what others do to it meanwhile changes nothing of what the device reads. A sync
 * finds it deleted, moved or replaced by another: then writes are refused until it is back. Cut
 * off, it is written again whole.
 */
struct lx_nvm_file {
    const char *path;
    const char *answer; /**< as in lx_nvm_image */
    int fd;             /**< holds the advisory lock; -1: not open */
    uint8_t *bytes;     /**< owned: what it holds, `size` bytes */
    uint32_t size;      /**< bytes of the memory */
    uint32_t length;    /**< bytes the file has; what is missing up to `size` reads FFh */
    bool created;       /**< it did not exist before */
    bool failing;       /**< the last write or sync failed, and the user has been told */
    bool suspect;       /**< the medium may hold something else than `bytes` */
};

/** What a new file holds, and whose it is. */
struct lx_nvm_image {
    const uint8_t *bytes;
    uint32_t size;
    /** What the device does with what it cannot store, for the user who is told that the file
     * fails: "the encoder answers 05h". Borrowed, as the path. */
    const char *answer;
};

/**
 * Open `path` and lock it; make it (mode 0600, complete or not at all) when it does not exist. The
 * content of an existing file is not touched.
 * @return 0, or -1 with one line in `error`: no such folder, not a regular file, longer than the
 *         image, in use by another encoder or process, ...
 */
int lx_nvm_file_open(struct lx_nvm_file *self, const char *path, const struct lx_nvm_image *image,
                     struct lx_error *error);

/**
 * Tell the user of an existing file that is cut off, or that an earlier release has written.
 * @param image  bytes of the memory images in it, as their headers say
 */
void lx_nvm_file_tell(const struct lx_nvm_file *self, uint32_t image, const struct lx_say *say);

/**
 * Another content, `self->size` bytes, all of it or none: for images that would have to be moved.
 * The file stays open and locked; other names (hard links) keep the content it had.
 * @return 0, or -1 with one line in `error`, the file as it was
 */
int lx_nvm_file_replace(struct lx_nvm_file *self, const uint8_t *bytes, struct lx_error *error);

/** Remove its name again if lx_nvm_file_open() has made it and nobody has put another file there:
 * whoever wanted it is refused. Then close. Also when it is not open, or was there before. */
void lx_nvm_file_unmake(struct lx_nvm_file *self);

/** Close and unlock; also when it is not open. */
void lx_nvm_file_close(struct lx_nvm_file *self);

/** The operations on `self`. */
struct dg_nvm lx_nvm_file_port(struct lx_nvm_file *self);

#endif

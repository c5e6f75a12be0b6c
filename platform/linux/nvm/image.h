/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EEPROM of an encoder, or of several that share a file: made, opened, looked at and owned in
 * one way, whatever the encoders speak. Where the bytes of what are is the core's business.
 */
#ifndef DREHGEBER_LINUX_IMAGE_H
#define DREHGEBER_LINUX_IMAGE_H

#include <stddef.h>

#include "drehgeber/stack.h"
#include "nvm_file.h"
#include "nvm_memory.h"
#include "nvm_writer.h"
#include "say.h"

struct lx_image;

/** The part of an image that belongs to one encoder. Not to be moved while the image is open. */
struct lx_image_part {
    const struct dg_stack *stack;
    /** Model, serial number and address are to be set; lx_image_open() adds the memory. World and
     * port are not looked at. */
    struct dg_stack_setup device;
    bool serial_given; /**< asked for, not left to the model: a file with another is not its own */
    size_t place;      /**< of the encoder on its wire, for messages */
    const char *right; /**< figures that make an encoder, in words; NULL: nothing to say */
    /* the image's */
    struct lx_image *image;
    uint32_t base;
    uint32_t size;   /**< 0: the model has no EEPROM */
    uint32_t found;  /**< bytes that it has in the file: fewer in one of an earlier release */
    uint64_t ticket; /**< of its last sync that said yes, see lx_nvm_queue_state() */
};

/** What an image is made of. What is pointed to must outlive it. */
struct lx_image_setup {
    const char *path;   /**< of its file; NULL: in memory, what is in it is lost at the end */
    const char *answer; /**< as in lx_nvm_image */
    struct lx_image_part *parts;
    size_t count;
    const struct lx_say *say;
    struct lx_nvm_writer *writer; /**< of the file; NULL: it is written where one stands */
    /** As in lx_nvm_queue_setup. */
    void (*settled)(void *ctx, dg_ns now);
    void *ctx;
};

/** An image. All zero: not open. Not to be moved while it is. */
struct lx_image {
    struct lx_image_setup setup;
    /** The delivery state; a copy of what the file held when it was opened; without a file, the
     * EEPROM itself. */
    struct lx_nvm_memory memory;
    struct lx_nvm_file file;
    struct lx_nvm_queue queue; /**< in front of it */
    struct dg_nvm nvm;         /**< what the parts are parts of */
    bool finished;             /**< a part was unfinished and is not any more: to be written */
};

/**
 * Make the delivery state, and open the file. A new one gets it. An existing one must hold images
 * of these kinds of encoders, with the same figures from the factory; a cut-off one is taken, for
 * the encoder reports what is damaged, and so is one of an earlier release; a part that NVM:ERASe
 * has begun to erase becomes as delivered. It is looked at in a copy: one that is refused stays as
 * it is.
 * @return 0, or -1 with one line in `error`; then close
 */
int lx_image_open(struct lx_image *self, const struct lx_image_setup *setup,
                  struct lx_error *error);

/**
 * The encoders work on the file from here on. In one of an earlier release that several share their
 * images are moved apart first, and what was unfinished is written, all of it or nothing.
 * @return 0, or -1 with one line in `error`; then close
 */
int lx_image_start(struct lx_image *self, struct lx_error *error);

/** What its writer has for it; NULL: no file, or no writer. */
const struct lx_nvm_queue *lx_image_queue(const struct lx_image *self);

/** Wait until all is written, close; also after a failed open, or when it is not open. A file that
 * was made for it goes again if the writer is still on trial. */
void lx_image_close(struct lx_image *self);

#endif

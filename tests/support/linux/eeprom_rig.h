/* SPDX-License-Identifier: MIT */
/* EEPROM files of RS485 encoders, in a folder of their own. */
#ifndef EEPROM_RIG_H
#define EEPROM_RIG_H

#include <sys/types.h>

#include "drehgeber/hiperface.h"
#include "image.h"

extern const struct lx_say eeprom_quiet;

/* A folder and a file name in it for each test, and whose the file is. */
struct eeprom_place {
    char folder[32];
    char path[64];
    struct dg_hf_model model;
    uint32_t serial; /* counts when it is given */
    bool serial_given;
    bool loud; /* what there is to note of it is said */
};

/* For cmocka: *state is a place, with the figures of an s3684-rs485. The end fails when a test
   leaves anything but its file behind. */
int eeprom_place_set_up(void **state);
int eeprom_place_tear_down(void **state);

/* The EEPROM of an encoder. */
struct eeprom {
    struct lx_image image;
    struct lx_image_part part;
};

/* As lx_image_open() and lx_image_start(). */
int eeprom_open(struct eeprom *self, const char *path, const struct eeprom_place *place,
                struct lx_error *error);
void eeprom_close(struct eeprom *self);

/* Make the file of the place. */
void eeprom_make(struct eeprom_place *place);

/* Opening the file is refused with a line that says so, and leaves every byte as it was. */
void eeprom_refused(struct eeprom_place *place, const char *says);

void eeprom_write_bytes(const char *path, const uint8_t *bytes, size_t n);
off_t eeprom_length_of(const char *path);

#endif

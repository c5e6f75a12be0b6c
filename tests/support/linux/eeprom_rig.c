/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "eeprom_rig.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/devices.h"

const struct lx_say eeprom_quiet = {.quiet = true};

int eeprom_place_set_up(void **state)
{
    struct eeprom_place *self = calloc(1, sizeof *self);
    assert_non_null(self);
    (void)strcpy(self->folder, "/tmp/test_eeprom.XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    (void)snprintf(self->path, sizeof self->path, "%s/nvm", self->folder);
    self->model = *dg_hf_model_of(&dg_s3684_rs485);
    *state = self;
    return 0;
}

int eeprom_place_tear_down(void **state)
{
    struct eeprom_place *self = *state;
    (void)unlink(self->path);
    const int result = rmdir(self->folder);
    free(self);
    return result;
}

int eeprom_open(struct eeprom *self, const char *path, const struct eeprom_place *place,
                struct lx_error *error)
{
    static const struct lx_say loud = {.quiet = false};
    const struct lx_image_setup setup = {
        .path = path,
        .answer = "the encoder answers 05h",
        .parts = &self->part,
        .count = 1,
        .say = place->loud ? &loud : &eeprom_quiet,
    };
    self->part = (struct lx_image_part){
        .stack = &dg_hf_stack,
        .device = {.model = &place->model, .serial = place->serial},
        .serial_given = place->serial_given,
    };
    return lx_image_open(&self->image, &setup, error) != 0 ? -1
                                                           : lx_image_start(&self->image, error);
}

void eeprom_close(struct eeprom *self)
{
    lx_image_close(&self->image);
}

off_t eeprom_length_of(const char *path)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    return info.st_size;
}

void eeprom_make(struct eeprom_place *place)
{
    struct eeprom eeprom;
    struct lx_error error;
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), 0);
    eeprom_close(&eeprom);
}

void eeprom_refused(struct eeprom_place *place, const char *says)
{
    uint8_t before[8192];
    uint8_t after[8192];
    struct eeprom eeprom;
    struct lx_error error = {.right = ""};
    int fd = open(place->path, O_RDONLY);
    const ssize_t n = read(fd, before, sizeof before);
    (void)close(fd);
    assert_int_equal(eeprom_open(&eeprom, place->path, place, &error), -1);
    eeprom_close(&eeprom);
    assert_non_null(strstr(lx_error_line(&error).text, says));
    assert_non_null(strstr(lx_error_line(&error).text, place->path));
    fd = open(place->path, O_RDONLY);
    assert_int_equal(read(fd, after, sizeof after), n);
    (void)close(fd);
    assert_memory_equal(before, after, (size_t)n);
}

void eeprom_write_bytes(const char *path, const uint8_t *bytes, size_t n)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, bytes, n), (ssize_t)n);
    (void)close(fd);
}

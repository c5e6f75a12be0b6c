/* SPDX-License-Identifier: MIT */
/* Where GPIO lines are, and the words for why they cannot be had. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <linux/gpio.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "drehgeber/figure.h"
#include "gpio_lines.h"

#define FOLDER "/dev/"
#define CHIPS FOLDER "gpiochip*"
#define RIGHT "expected CHIP:CLOCK,DATA with two offsets, e.g. gpiochip0:4,5"

/* `n` characters of decimal digits. */
static bool parse_offset(const char *text, size_t n, unsigned *offset)
{
    char digits[8] = "";
    uint64_t value = 0;

    if (n == 0 || n >= sizeof digits || strspn(text, "0123456789") < n) {
        return false;
    }
    memcpy(digits, text, n);
    if (!dg_unsigned_parse(digits, &value) || value > LX_GPIO_OFFSET_MAX) {
        return false;
    }
    *offset = (unsigned)value;
    return true;
}

int lx_gpio_address_parse(struct lx_gpio_address *self, const char *text, struct lx_error *error)
{
    const char *colon = strrchr(text, ':');
    const char *comma = colon == NULL ? NULL : strchr(colon, ',');

    *self = (struct lx_gpio_address){.clock = 0};
    if (comma == NULL || colon == text || strlen(text) >= sizeof self->text ||
        !parse_offset(colon + 1, (size_t)(comma - colon - 1), &self->clock) ||
        !parse_offset(comma + 1, strlen(comma + 1), &self->data)) {
        return lx_refuse(error, RIGHT, "%s", "");
    }
    if (self->clock == self->data) {
        return lx_refuse(error, RIGHT, "both are the same line");
    }
    const int length = (int)(colon - text);
    const char *folder = memchr(text, '/', (size_t)length) == NULL ? FOLDER : "";
    (void)snprintf(self->text, sizeof self->text, "%s", text);
    (void)snprintf(self->path, sizeof self->path, "%s%.*s", folder, length, text);
    return 0;
}

static bool has_label(const char *path, const char *label)
{
    struct gpiochip_info info = {.lines = 0};
    const int fd = open(path, O_RDWR | O_CLOEXEC);
    const bool known = fd >= 0 && ioctl(fd, GPIO_GET_CHIPINFO_IOCTL, &info) == 0;
    if (fd >= 0) {
        (void)close(fd);
    }
    return known && strncmp(info.label, label, sizeof info.label) == 0;
}

void lx_gpio_find(const struct lx_gpio_address *self, char path[LX_GPIO_PATH_MAX])
{
    const char *label = self->path + strlen(FOLDER);
    glob_t chips;
    (void)snprintf(path, LX_GPIO_PATH_MAX, "%s", self->path);
    if (access(path, F_OK) == 0 || glob(CHIPS, 0, NULL, &chips) != 0) {
        return;
    }
    size_t i = 0;
    while (i < chips.gl_pathc && !has_label(chips.gl_pathv[i], label)) {
        i++;
    }
    if (i < chips.gl_pathc) {
        (void)snprintf(path, LX_GPIO_PATH_MAX, "%s", chips.gl_pathv[i]);
    }
    globfree(&chips);
}

int lx_gpio_no_chip(const struct lx_gpio_address *self, int reason, struct lx_error *error)
{
    switch (reason) {
    case ENOENT:
        return lx_refuse(error, "'gpiodetect' lists the chips",
                         "there is no %s and no chip with that label", self->path);
    case EACCES:
    case EPERM:
        return lx_refuse(error,
                         "expected a user who may read and write it, e.g. root or one of the group "
                         "gpio",
                         "no permission for %s", self->path);
    case ENOTTY:
    case ENODEV:
        return lx_refuse(error, "'gpiodetect' lists them", "%s is no GPIO chip", self->path);
    default:
        return lx_fail(error, "cannot use %s: %s", self->path, strerror(reason));
    }
}

int lx_gpio_no_line(const struct lx_gpio_address *self, unsigned offset, int reason,
                    struct lx_error *error)
{
    if (reason == EBUSY) {
        return lx_refuse(error, "'gpioinfo' shows free ones", "line %u is in use", offset);
    }
    return lx_refuse(error, offset == self->clock ? "an encoder needs edge detection there" : NULL,
                     "cannot use line %u: %s", offset, strerror(reason));
}

int lx_gpio_check_offsets(const struct lx_gpio_address *self, unsigned count,
                          struct lx_error *error)
{
    if (self->clock < count && self->data < count) {
        return 0;
    }
    return lx_refuse(error, "expected offsets below that", "%s has %u lines", self->path, count);
}

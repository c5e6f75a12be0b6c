/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Clock and data on a GPIO chip: an encoder takes edges of the clock and drives data, a master drives
 * the clock and looks at data. libgpiod has two incompatible interfaces, so there are two
 * implementations, of which a program has one: gpio_lines_v1.c for libgpiod 1.x, gpio_lines_v2.c for
 * 2.x.
 */
#ifndef DREHGEBER_LINUX_GPIO_LINES_H
#define DREHGEBER_LINUX_GPIO_LINES_H

#include <stdbool.h>
#include <stddef.h>

#include "drehgeber/time.h"
#include "say.h"

/** Longest CHIP:CLOCK,DATA, and longest path of a chip. */
#define LX_GPIO_ADDRESS_MAX 256u
#define LX_GPIO_PATH_MAX (LX_GPIO_ADDRESS_MAX + 8u)
/** Largest offset of a line that is taken. */
#define LX_GPIO_OFFSET_MAX 65535u
/** Who uses the lines, as gpioinfo shows it. */
#define LX_GPIO_CONSUMER "drehgeber"

/** Where the lines are. */
struct lx_gpio_address {
    char text[LX_GPIO_ADDRESS_MAX]; /**< as it was written */
    char path[LX_GPIO_PATH_MAX];    /**< of the chip */
    unsigned clock;                 /**< offsets */
    unsigned data;
};

/** Understand CHIP:CLOCK,DATA; CHIP is a name in /dev, a path, or a label, which a chip keeps when
 * it comes back with another number. @return 0, or -1 with `error` */
int lx_gpio_address_parse(struct lx_gpio_address *self, const char *text, struct lx_error *error);

/** An edge of the clock. */
struct lx_gpio_edge {
    dg_ns at;   /**< when the kernel saw it, in lx_now()'s clock */
    bool level; /**< after it */
    bool gap;   /**< next to this one the kernel had no room for others */
};

struct lx_gpio_lines;

/** What an implementation does. Nothing blocks. */
struct lx_gpio_lines_ops {
    /** Take up to `n` edges of the clock out of the queue; an encoder's only. @return how many, or a
     * negative errno */
    int (*read)(struct lx_gpio_lines *self, struct lx_gpio_edge *edges, size_t n);
    /** @return the level of the line that the other side drives, or a negative errno */
    int (*get_input)(struct lx_gpio_lines *self);
    /** Set the own line. @return 0 or a negative errno */
    int (*set_output)(struct lx_gpio_lines *self, bool level);
    /** Give back lines and memory. */
    void (*close)(struct lx_gpio_lines *self);
};

/** Both lines; first member of an implementation. */
struct lx_gpio_lines {
    const struct lx_gpio_lines_ops *ops;
    int fd; /**< readable while edges are queued; -1: a master's */
};

/** Take the lines for an encoder: the clock with both edges, data as an output that begins with
 * level `data`. @return NULL with one line in `error` */
struct lx_gpio_lines *lx_gpio_lines_open(const struct lx_gpio_address *address, bool data,
                                         struct lx_error *error);

/** Take the lines for a master: the clock as an output that begins high, data as an input.
 * @return NULL with one line in `error` */
struct lx_gpio_lines *lx_gpio_lines_open_master(const struct lx_gpio_address *address,
                                                struct lx_error *error);

/** Version of the library behind them. */
const char *lx_gpio_library(void);

/** For the implementations: the path of the chip now; where no file is called so, of the one with
 * this label. */
void lx_gpio_find(const struct lx_gpio_address *self, char path[LX_GPIO_PATH_MAX]);

/** For the implementations: the chip cannot be used, by errno. @return -1 */
int lx_gpio_no_chip(const struct lx_gpio_address *self, int reason, struct lx_error *error);

/** For the implementations: line `offset` cannot be had, by errno. @return -1 */
int lx_gpio_no_line(const struct lx_gpio_address *self, unsigned offset, int reason,
                    struct lx_error *error);

/** For the implementations: whether a chip with `count` lines has both. @return 0, or -1 */
int lx_gpio_check_offsets(const struct lx_gpio_address *self, unsigned count,
                          struct lx_error *error);

#endif

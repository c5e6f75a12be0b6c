/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An encoder on two GPIO lines, on the event loop. Each edge of the clock goes to it with the
 * kernel's time of it, so that a late host delays data and nothing else. Edges that queued are
 * caught up with at once: of the levels of the data line only the last is still worth setting.
 */
#ifndef DREHGEBER_LINUX_GPIO_H
#define DREHGEBER_LINUX_GPIO_H

#include <systemd/sd-event.h>

#include "clocked.h"
#include "gpio_lines.h"
#include "gpio_rate.h"
#include "timer.h"

/** What it is made of. Everything pointed to must outlive it. */
struct lx_gpio_setup {
    sd_event *event;
    const struct lx_say *say;
    struct lx_clocked *line;     /**< connected; its encoder has its power */
    const char *name;            /**< of the lines, for messages */
    struct lx_gpio_lines *lines; /**< data is as the encoder has it */
    /** The chip has gone, and the user has been told; close, but not in this call. */
    void (*gone)(void *ctx);
    void *ctx;
};

/** The period of a clock that user space can follow, for faults that take whole clocks. */
#define LX_GPIO_PERIOD DG_MS(1)

/** They only count up. */
struct lx_gpio_counters {
    uint64_t edges; /**< of the clock */
    uint64_t late;  /**< answers to rising edges that came behind the next edge, half a period on */
    uint64_t lost;  /**< places where edges are missing */
};

/** A running encoder. Not to be moved. */
struct lx_gpio {
    struct lx_gpio_setup setup;
    sd_event_source *io;
    struct lx_timer timeout; /**< the line's deadline, or earlier */
    struct lx_timer watch;   /**< looks after the chip, and reports */
    struct lx_gpio_rate rate;
    struct lx_gpio_counters counters;
    struct lx_gpio_counters seen; /**< the counters at the last look */
    dg_ns asked;                  /**< the first rising edge without an answer */
    dg_ns answered;               /**< when data was set after a rising edge last */
    dg_ns trouble;                /**< when edges were late or lost last; 0: never */
    uint32_t waiting;             /**< rising edges without an answer */
    bool due;                     /**< the next edge tells whether the latest answer is late */
    bool data;                    /**< as it is */
    bool doubtful;                /**< the clock was not as its edges say at the last look */
    uint8_t rate_told;            /**< how often */
    bool has_gone;
};

/**
 * Begin. The lines are its own from then on.
 * @return 0, or -1 with `error`, then close
 */
int lx_gpio_open(struct lx_gpio *self, const struct lx_gpio_setup *setup, struct lx_error *error);

/** Faults may have changed, or the supply: data is at its level when this returns. */
void lx_gpio_changed(struct lx_gpio *self);

/** Give back the lines; also after a failed open, or when never opened. */
void lx_gpio_close(struct lx_gpio *self);

#endif

/* SPDX-License-Identifier: MIT */
/* GPIO lines by libgpiod 1.x. */
#include <errno.h>
#include <fcntl.h>
#include <gpiod.h>
#include <stdlib.h>

#include "gpio_lines.h"

/* Edges the kernel keeps for a line; what comes then is dropped without a word, so a full queue is
   taken for one that was too short. */
#define QUEUE 16

struct lines {
    struct lx_gpio_lines base;
    struct gpiod_chip *chip;
    struct gpiod_line *input;
    struct gpiod_line *output;
};

static struct lines *v1_lines_of(struct lx_gpio_lines *base)
{
    return (struct lines *)base;
}

static int read_edges(struct lx_gpio_lines *base, struct lx_gpio_edge *edges, size_t n)
{
    struct gpiod_line_event events[QUEUE];
    const int count =
        gpiod_line_event_read_fd_multiple(base->fd, events, (unsigned)(n < QUEUE ? n : QUEUE));
    if (count < 0) {
        return errno == EAGAIN ? 0 : -errno;
    }
    for (int i = 0; i < count; i++) {
        edges[i] = (struct lx_gpio_edge){
            .at = DG_S(events[i].ts.tv_sec) + (dg_ns)events[i].ts.tv_nsec,
            .level = events[i].event_type == GPIOD_LINE_EVENT_RISING_EDGE,
            .gap = i + 1 == QUEUE,
        };
    }
    return count;
}

static int get_input(struct lx_gpio_lines *base)
{
    const int level = gpiod_line_get_value(v1_lines_of(base)->input);
    return level < 0 ? -errno : level;
}

static int set_output(struct lx_gpio_lines *base, bool level)
{
    return gpiod_line_set_value(v1_lines_of(base)->output, level) < 0 ? -errno : 0;
}

static void close_lines(struct lx_gpio_lines *base)
{
    struct lines *self = v1_lines_of(base);
    if (self->chip != NULL) {
        gpiod_chip_close(self->chip); /* its lines as well */
    }
    free(self);
}

static const struct lx_gpio_lines_ops ops = {
    .read = read_edges,
    .get_input = get_input,
    .set_output = set_output,
    .close = close_lines,
};

static int open_chip(struct lines *self, const struct lx_gpio_address *address,
                     struct lx_error *error)
{
    char path[LX_GPIO_PATH_MAX];
    lx_gpio_find(address, path);
    self->chip = gpiod_chip_open(path);
    if (self->chip == NULL) {
        return lx_gpio_no_chip(address, errno, error);
    }
    return lx_gpio_check_offsets(address, gpiod_chip_num_lines(self->chip), error);
}

static int request_own_line(struct lines *self, const struct lx_gpio_address *address,
                            unsigned offset, bool level, struct lx_error *error)
{
    self->output = gpiod_chip_get_line(self->chip, offset);
    return self->output != NULL &&
                   gpiod_line_request_output(self->output, LX_GPIO_CONSUMER, level) == 0
               ? 0
               : lx_gpio_no_line(address, offset, errno, error);
}

/* For an encoder, of whose clock every edge counts. */
static int request_edges(struct lines *self, const struct lx_gpio_address *address,
                         struct lx_error *error)
{
    self->input = gpiod_chip_get_line(self->chip, address->clock);
    if (self->input == NULL ||
        gpiod_line_request_both_edges_events(self->input, LX_GPIO_CONSUMER) != 0) {
        return lx_gpio_no_line(address, address->clock, errno, error);
    }
    self->base.fd = gpiod_line_event_get_fd(self->input);
    if (self->base.fd < 0 || fcntl(self->base.fd, F_SETFL, O_NONBLOCK) != 0) {
        return lx_gpio_no_line(address, address->clock, errno, error);
    }
    return 0;
}

struct lx_gpio_lines *lx_gpio_lines_open(const struct lx_gpio_address *address, bool data,
                                         struct lx_error *error)
{
    struct lines *self = lx_allocate(sizeof *self, "lines", error);
    if (self == NULL) {
        return NULL;
    }
    self->base.ops = &ops;
    if (open_chip(self, address, error) != 0 ||
        request_own_line(self, address, address->data, data, error) != 0 ||
        request_edges(self, address, error) != 0) {
        close_lines(&self->base);
        return NULL;
    }
    return &self->base;
}

static int request_other_line(struct lines *self, const struct lx_gpio_address *address,
                              struct lx_error *error)
{
    self->base.fd = -1;
    self->input = gpiod_chip_get_line(self->chip, address->data);
    return self->input != NULL && gpiod_line_request_input(self->input, LX_GPIO_CONSUMER) == 0
               ? 0
               : lx_gpio_no_line(address, address->data, errno, error);
}

struct lx_gpio_lines *lx_gpio_lines_open_master(const struct lx_gpio_address *address,
                                                struct lx_error *error)
{
    struct lines *self = lx_allocate(sizeof *self, "lines", error);
    if (self == NULL) {
        return NULL;
    }
    self->base.ops = &ops;
    if (open_chip(self, address, error) != 0 ||
        request_own_line(self, address, address->clock, true, error) != 0 ||
        request_other_line(self, address, error) != 0) {
        close_lines(&self->base);
        return NULL;
    }
    return &self->base;
}

const char *lx_gpio_library(void)
{
    return gpiod_version_string();
}

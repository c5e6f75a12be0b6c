/* SPDX-License-Identifier: MIT */
/* GPIO lines by libgpiod 2.x. */
#include <errno.h>
#include <fcntl.h>
#include <gpiod.h>
#include <stdlib.h>

#include "gpio_lines.h"

/* Edges the kernel keeps, the most it allows; then the oldest go. */
#define QUEUE 1024u
/* Edges taken at once. */
#define BATCH 64u

struct lines {
    struct lx_gpio_lines base;
    struct gpiod_chip *chip;
    struct gpiod_line_request *input;
    struct gpiod_line_request *output;
    struct gpiod_edge_event_buffer *events; /* an encoder's */
    unsigned input_offset;
    unsigned output_offset;
    unsigned long number; /* of the latest edge */
};

static struct lines *lines_of(struct lx_gpio_lines *base)
{
    return (struct lines *)base;
}

static int read_edges(struct lx_gpio_lines *base, struct lx_gpio_edge *edges, size_t n)
{
    struct lines *self = lines_of(base);
    const int count =
        gpiod_line_request_read_edge_events(self->input, self->events, n < BATCH ? n : BATCH);
    if (count < 0) {
        return errno == EAGAIN ? 0 : -errno;
    }
    for (int i = 0; i < count; i++) {
        struct gpiod_edge_event *event =
            gpiod_edge_event_buffer_get_event(self->events, (unsigned long)i);
        const unsigned long number = gpiod_edge_event_get_line_seqno(event);
        edges[i] = (struct lx_gpio_edge){
            .at = gpiod_edge_event_get_timestamp_ns(event),
            .level = gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
            .gap = number != self->number + 1,
        };
        self->number = number;
    }
    return count;
}

static int get_input(struct lx_gpio_lines *base)
{
    struct lines *self = lines_of(base);
    const enum gpiod_line_value level =
        gpiod_line_request_get_value(self->input, self->input_offset);
    return level == GPIOD_LINE_VALUE_ERROR ? -errno : level == GPIOD_LINE_VALUE_ACTIVE;
}

static int set_output(struct lx_gpio_lines *base, bool level)
{
    struct lines *self = lines_of(base);
    const enum gpiod_line_value value = level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    return gpiod_line_request_set_value(self->output, self->output_offset, value) < 0 ? -errno : 0;
}

static void close_lines(struct lx_gpio_lines *base)
{
    struct lines *self = lines_of(base);
    if (self->input != NULL) {
        gpiod_line_request_release(self->input);
    }
    if (self->output != NULL) {
        gpiod_line_request_release(self->output);
    }
    if (self->chip != NULL) {
        gpiod_chip_close(self->chip);
    }
    gpiod_edge_event_buffer_free(self->events);
    free(self);
}

static const struct lx_gpio_lines_ops ops = {
    .read = read_edges,
    .get_input = get_input,
    .set_output = set_output,
    .close = close_lines,
};

/* One line with these settings. @return NULL with errno */
static struct gpiod_line_request *request_line(struct gpiod_chip *chip, unsigned offset,
                                               struct gpiod_line_settings *settings)
{
    struct gpiod_line_request *line = NULL;
    struct gpiod_request_config *request = gpiod_request_config_new();
    struct gpiod_line_config *config = gpiod_line_config_new();
    if (request != NULL && config != NULL &&
        gpiod_line_config_add_line_settings(config, &offset, 1, settings) == 0) {
        gpiod_request_config_set_consumer(request, LX_GPIO_CONSUMER);
        gpiod_request_config_set_event_buffer_size(request, QUEUE);
        line = gpiod_chip_request_lines(chip, request, config);
    }
    const int reason = errno;
    gpiod_line_config_free(config);
    gpiod_request_config_free(request);
    errno = reason;
    return line;
}

static struct gpiod_line_request *request_output(const struct lines *self, bool level)
{
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    if (settings == NULL) {
        return NULL;
    }
    (void)gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT);
    (void)gpiod_line_settings_set_output_value(settings, level ? GPIOD_LINE_VALUE_ACTIVE
                                                               : GPIOD_LINE_VALUE_INACTIVE);
    struct gpiod_line_request *line = request_line(self->chip, self->output_offset, settings);
    gpiod_line_settings_free(settings);
    return line;
}

/* Edges have the monotonic clock unless another one is asked for. */
static struct gpiod_line_request *request_input(const struct lines *self, bool edges)
{
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    if (settings == NULL) {
        return NULL;
    }
    (void)gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT);
    if (edges) {
        (void)gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH);
    }
    struct gpiod_line_request *line = request_line(self->chip, self->input_offset, settings);
    gpiod_line_settings_free(settings);
    return line;
}

static int check_chip(const struct lines *self, const struct lx_gpio_address *address,
                      struct lx_error *error)
{
    struct gpiod_chip_info *info = gpiod_chip_get_info(self->chip);
    if (info == NULL) {
        return lx_gpio_no_chip(address, errno, error);
    }
    const size_t count = gpiod_chip_info_get_num_lines(info);
    gpiod_chip_info_free(info);
    return lx_gpio_check_offsets(address, (unsigned)count, error);
}

/* The chip, the own line with this level, the other side's, with edges or without. */
static int request_lines(struct lines *self, const struct lx_gpio_address *address, bool level,
                         bool edges, struct lx_error *error)
{
    char path[LX_GPIO_PATH_MAX];
    lx_gpio_find(address, path);
    self->chip = gpiod_chip_open(path);
    if (self->chip == NULL) {
        return lx_gpio_no_chip(address, errno, error);
    }
    if (check_chip(self, address, error) != 0) {
        return -1;
    }
    self->output = request_output(self, level);
    if (self->output == NULL) {
        return lx_gpio_no_line(address, self->output_offset, errno, error);
    }
    self->input = request_input(self, edges);
    return self->input != NULL ? 0 : lx_gpio_no_line(address, self->input_offset, errno, error);
}

static int queue_edges(struct lines *self, const struct lx_gpio_address *address,
                       struct lx_error *error)
{
    self->events = gpiod_edge_event_buffer_new(BATCH);
    self->base.fd = gpiod_line_request_get_fd(self->input);
    return self->events != NULL && fcntl(self->base.fd, F_SETFL, O_NONBLOCK) == 0
               ? 0
               : lx_gpio_no_line(address, self->input_offset, errno, error);
}

struct lx_gpio_lines *lx_gpio_lines_open(const struct lx_gpio_address *address, bool data,
                                         struct lx_error *error)
{
    struct lines *self = lx_allocate(sizeof *self, "lines", error);
    if (self == NULL) {
        return NULL;
    }
    self->base.ops = &ops;
    self->input_offset = address->clock;
    self->output_offset = address->data;
    if (request_lines(self, address, data, true, error) != 0 ||
        queue_edges(self, address, error) != 0) {
        close_lines(&self->base);
        return NULL;
    }
    return &self->base;
}

struct lx_gpio_lines *lx_gpio_lines_open_master(const struct lx_gpio_address *address,
                                                struct lx_error *error)
{
    struct lines *self = lx_allocate(sizeof *self, "lines", error);
    if (self == NULL) {
        return NULL;
    }
    self->base.ops = &ops;
    self->base.fd = -1;
    self->input_offset = address->data;
    self->output_offset = address->clock;
    if (request_lines(self, address, true, false, error) != 0) {
        close_lines(&self->base);
        return NULL;
    }
    return &self->base;
}

const char *lx_gpio_library(void)
{
    return gpiod_api_version();
}

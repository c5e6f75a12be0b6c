/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "biss_gpio.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "biss_session.h"
#include "gpio.h"
#include "run.h"

/* Everything a running encoder consists of. */
struct post {
    const struct options *options;
    struct lx_gpio_address address;
    struct biss_session session;
    struct lx_gpio gpio;
    struct lx_timer ready; /* end of the initialisation */
    sd_event *event;
};

bool biss_on_gpio(const struct options *options)
{
    return options->wire != NULL && strcmp(options->wire->name, "gpio") == 0;
}

static void announce(void *ctx, dg_ns now)
{
    struct post *self = ctx;
    struct lx_error error;
    (void)now;
    if (run_announce(self->options->model, "gpio", self->address.text, &error) != 0) {
        (void)sd_event_exit(self->event, run_complain(&error, EXIT_OTHER));
    }
}

static int switch_on(struct post *self, dg_ns now, struct lx_error *error)
{
    const struct lx_gpio_setup setup = {
        .event = self->event,
        .say = &self->options->say,
        .device = &self->session.device,
        .name = self->address.text,
        .lines = lx_gpio_lines_open(&self->address, error),
    };
    if (setup.lines == NULL || lx_gpio_open(&self->gpio, &setup, error) != 0) {
        return -1;
    }
    lx_note(&self->options->say, "%s: libgpiod %s", self->address.text, lx_gpio_library());
    const int result = lx_timer_open(&self->ready, self->event, announce, self);
    if (result < 0) {
        return lx_fail(error, "no timer: %s", strerror(-result));
    }
    lx_timer_at(&self->ready, dg_after(now, self->session.model.init));
    /* Code that had to be fetched from the disk first would cost the first frame. Fine to miss. */
    (void)mlockall(MCL_CURRENT);
    return 0;
}

static int live(struct post *self, struct lx_error *error)
{
    const dg_ns now = lx_now();
    if (run_make_loop(&self->event, error) != 0) {
        return run_complain(error, EXIT_OTHER);
    }
    const int status = biss_session_open(&self->session, self->options, now, error);
    if (status != 0) {
        return run_complain(error, status);
    }
    if (switch_on(self, now, error) != 0) {
        return run_complain(error, EXIT_OTHER);
    }
    return run_loop(self->event, error);
}

int biss_gpio_run(const struct options *options)
{
    struct lx_error error;
    struct post *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(&error, "no memory");
        return run_complain(&error, EXIT_OTHER);
    }
    self->options = options;
    self->session.file.fd = -1;
    int status = EXIT_USAGE;
    if (lx_gpio_address_parse(&self->address, options->where, &error) != 0) {
        status = run_complain(&error, EXIT_USAGE);
    } else if (options->trace != NULL) {
        (void)lx_fail(&error, "--trace %s: only with --sim", options->trace);
        status = run_complain(&error, EXIT_USAGE);
    } else {
        status = live(self, &error);
    }
    lx_timer_close(&self->ready);
    lx_gpio_close(&self->gpio);
    (void)biss_session_close(&self->session, &error);
    self->event = sd_event_unref(self->event);
    free(self);
    return status;
}

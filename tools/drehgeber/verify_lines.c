/* SPDX-License-Identifier: MIT */
#include "verify_lines.h"

#include "timer.h"
#include "verify_stream.h"

/* Looks at data that say how long this host takes for one. */
#define PROBES 200u
/* Shorter half periods are for no encoder. */
#define HALF_MIN DG_US(1)
/* How much slower the next clock is. */
#define SLOWER 4u
/* What is farther ahead is slept for, up to this time before it. */
#define SPIN DG_US(200)

static void wait_until(dg_ns at)
{
    if (at > lx_real_now() + SPIN) {
        verify_stream_sleep(at - SPIN);
    }
    while (lx_real_now() < at) {
    }
}

bool verify_lines_data(struct verify_lines *self, dg_ns at)
{
    wait_until(at);
    const int level = self->gone ? 0 : self->gpio->ops->get_input(self->gpio);
    self->gone = self->gone || level < 0;
    self->now = lx_real_now();
    return level > 0;
}

void verify_lines_clock(struct verify_lines *self, dg_ns at, bool level)
{
    wait_until(at);
    self->gone = self->gone || self->gpio->ops->set_output(self->gpio, level) < 0;
    self->now = lx_real_now();
    self->edge = self->now;
    self->late = dg_elapsed(self->now, at) > self->late ? dg_elapsed(self->now, at) : self->late;
}

void verify_lines_begin(struct verify_lines *self)
{
    self->now = lx_real_now();
    self->edge = self->now;
    self->late = 0;
}

/* With the half period that it was late for it has to be within the shortest timeout, 10 us; a slow
   clock has an encoder whose timeout is many of its periods. */
bool verify_lines_torn(const struct verify_lines *self)
{
    return self->late > (self->half <= VERIFY_HALF_FAST ? VERIFY_HALF_FAST : self->half);
}

bool verify_lines_rest(struct verify_lines *self)
{
    const dg_ns until = lx_real_now() + VERIFY_REST_MAX;
    const dg_ns look = self->half;
    while (!verify_lines_data(self, lx_real_now() + look)) {
        if (self->now > until) {
            return false;
        }
    }
    return true;
}

bool verify_lines_slow_down(struct verify_lines *self)
{
    self->half *= SLOWER;
    return self->half <= VERIFY_HALF_MAX;
}

void verify_lines_settle(struct verify_lines *self)
{
    self->half *= self->half > VERIFY_HALF_FAST ? 2u : 1u;
}

/* A look and an edge have to fit into half a period, with some room. */
static void measure_host(struct verify_lines *self)
{
    const dg_ns from = lx_real_now();
    for (unsigned i = 0; i < PROBES; i++) {
        (void)verify_lines_data(self, 0);
        verify_lines_clock(self, 0, true);
    }
    const dg_ns each = (lx_real_now() - from) / PROBES;
    self->half = 2u * each > HALF_MIN ? 2u * each : HALF_MIN;
}

int verify_lines_open(struct verify_lines *self, const char *where, struct lx_error *error)
{
    struct lx_gpio_address address;
    *self = (struct verify_lines){.gpio = NULL};
    if (lx_gpio_address_parse(&address, where, error) == 0) {
        self->gpio = lx_gpio_lines_open_master(&address, error);
    }
    if (self->gpio == NULL) {
        return lx_about(error, LX_ABOUT_WIRE, "gpio", where);
    }
    measure_host(self);
    verify_stream_sleep(lx_real_now() + VERIFY_REST_MAX); /* the clock may have been low before */
    return 0;
}

void verify_lines_close(struct verify_lines *self)
{
    if (self->gpio != NULL) {
        self->gpio->ops->close(self->gpio);
    }
    self->gpio = NULL;
}

/* SPDX-License-Identifier: MIT */
/* An encoder on GPIO lines as a wire of a rig. Only one: chains need a line for each neighbour. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

#include "bus.h"
#include "gpio.h"
#include "timer.h"

/* How often a chip that has gone is looked for. */
#define RETRY DG_S(1)

struct gpio_bus {
    struct lx_bus bus;
    struct lx_gpio_address address;
    struct lx_clocked *line;
    struct lx_gpio gpio;
    struct lx_timer retry;
    bool up;
};

static struct gpio_bus *gpio_of(struct lx_bus *bus)
{
    return (struct gpio_bus *)bus;
}

/* --- the lines --- */

static void on_gone(void *ctx)
{
    struct gpio_bus *self = ctx;
    self->up = false;
    /* Soon: as long as its lines are held, another chip cannot have its number. */
    lx_timer_at(&self->retry, lx_now());
}

static int take_lines(struct gpio_bus *self, struct lx_error *error)
{
    const struct lx_gpio_setup setup = {
        .event = self->bus.setup.event,
        .say = self->bus.setup.say,
        .line = self->line,
        .name = self->address.text,
        .lines = lx_gpio_lines_open(&self->address, self->line->data, error),
        .gone = on_gone,
        .ctx = self,
    };
    self->up = setup.lines != NULL && lx_gpio_open(&self->gpio, &setup, error) == 0;
    return self->up ? 0 : -1;
}

/* The chip has gone; it may be back by now. */
static void on_retry(void *ctx, dg_ns now)
{
    struct gpio_bus *self = ctx;
    struct lx_error ignored; /* it has been said that it is gone */
    lx_gpio_close(&self->gpio);
    if (take_lines(self, &ignored) == 0) {
        lx_note(self->bus.setup.say, "%s: back", self->address.text);
        return;
    }
    lx_gpio_close(&self->gpio);
    lx_timer_at(&self->retry, dg_after(now, RETRY));
}

/* --- the operations --- */

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct gpio_bus *self = gpio_of(bus);
    /* The encoder got its power early enough to answer when it is announced. */
    const dg_ns early = dg_elapsed(now, lx_clocked_init(self->line));
    if (lx_timer_make(&self->retry, bus->setup.event, on_retry, self, error) != 0 ||
        lx_clocked_open(self->line, &bus->setup, bus->core, &bus->tap, early, error) != 0 ||
        take_lines(self, error) != 0) {
        return -1;
    }
    lx_note(bus->setup.say, "%s: libgpiod %s", self->address.text, lx_gpio_library());
    /* Code that had to be fetched from the disk first would cost the first frame. Fine to miss. */
    (void)mlockall(MCL_CURRENT);
    return 0;
}

static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    const struct gpio_bus *self = (const struct gpio_bus *)bus;
    (void)station;
    (void)snprintf(to, size, "%s", self->address.text);
}

static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct gpio_bus *self = gpio_of(bus);
    (void)station;
    (void)now;
    if (self->up) {
        lx_gpio_changed(&self->gpio);
    }
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct gpio_bus *self = (const struct gpio_bus *)bus;
    (void)station;
    dg_state_number(to, "wire_up", self->up);
    dg_state_number(to, "wire_late", self->gpio.counters.late);
    dg_state_number(to, "wire_edges", self->gpio.counters.edges);
    dg_state_number(to, "wire_lost", self->gpio.counters.lost);
    dg_state_number(to, "wire_hz",
                    lx_gpio_rate_known(&self->gpio.rate) ? lx_gpio_rate_hz(&self->gpio.rate) : 0u);
}

static void close_bus(struct lx_bus *bus)
{
    struct gpio_bus *self = gpio_of(bus);
    lx_gpio_close(&self->gpio);
    lx_clocked_close(self->line);
    lx_timer_close(&self->retry);
    free(self);
}

static int check(struct lx_bus *bus, struct lx_station *station, struct lx_error *error)
{
    return lx_clocked_check(gpio_of(bus)->line, &bus->setup, station, error);
}

static const struct lx_bus_ops ops = {LX_BUS_OPERATIONS, .check = check};

/* --- from the plan --- */

static int prepare_line(struct gpio_bus *self, struct dg_engine_wire *to, struct lx_error *error)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    if (lx_gpio_address_parse(&self->address, setup->wire->where, error) != 0) {
        return -1;
    }
    self->line = lx_clocked_make(setup, to, LX_CLOCKED_THERE, error);
    to->edges.period_ns = LX_GPIO_PERIOD;
    return self->line == NULL ? -1 : 0;
}

struct lx_bus *lx_gpio_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                                struct lx_error *error)
{
    struct gpio_bus *self = lx_bus_allocate(sizeof *self, &ops, setup, error);
    if (self == NULL) {
        return NULL;
    }
    if (prepare_line(self, to, error) != 0) {
        free(self);
        return NULL;
    }
    return &self->bus;
}

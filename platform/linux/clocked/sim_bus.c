/* SPDX-License-Identifier: MIT */
/*
 * Encoders on a simulated clocked wire, with a master in this process that reads positions by the
 * rig's clock. Which frames are read, and which ones need not even wake the process, is the
 * library's (drehgeber/bus_reader.h). Whatever the clock does, each frame is read at its own moment:
 * no deadline can be missed here.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/bus_reader.h"
#include "sim_bus.h"
#include "sim_silkit.h"
#include "timer.h"

struct sim_bus {
    struct lx_bus bus;
    struct lx_clocked *line;
    struct dg_bus_reader reader;
    struct lx_timer timer;
    struct lx_sim_silkit silkit; /* driven: says when a frame is read */
};

static struct sim_bus *sim_of(struct lx_bus *bus)
{
    return (struct sim_bus *)bus;
}

static const struct dg_plan_timing *timing_of(const struct lx_bus *bus)
{
    return &dg_engine_wire_of(bus->setup.engine, bus->setup.index)->line.timing;
}

/* --- the master --- */

/* Sleep until the next frame, unless nobody could notice it, or until there may be something to
   tell the user. */
static void sleep_until_frame(struct sim_bus *self)
{
    const struct lx_bus_setup *setup = &self->bus.setup;
    if (self->bus.setup.door->driven) {
        return;
    }
    const dg_ns hint = lx_clocked_hint(self->line, setup->say, setup->stations[0]->control->name,
                                       lx_clock_now(setup->clock));
    const dg_ns due = dg_earliest(hint, dg_bus_reader_next(&self->reader));
    lx_timer_at(&self->timer, due != DG_NEVER ? lx_clock_real(setup->clock, due) : DG_NEVER);
}

static void catch_up_frames(struct sim_bus *self)
{
    dg_bus_reader_watch(&self->reader, lx_tap_on(&self->bus.tap));
    if (!self->bus.setup.door->driven) {
        dg_bus_reader_run(&self->reader, lx_clock_now(self->bus.setup.clock));
        sleep_until_frame(self);
    }
}

static void on_time(void *ctx, dg_ns now)
{
    (void)now;
    catch_up_frames(ctx);
}

/* --- what the control plane asks for --- */

struct dg_bus_master_setup lx_sim_bus_master(const struct lx_bus *bus)
{
    const struct dg_plan_timing *timing = timing_of(bus);
    return (struct dg_bus_master_setup){
        .size = sizeof(struct dg_bus_master_setup),
        .bus = bus->core,
        .protocol = ((const struct sim_bus *)bus)->line->protocol->master,
        .clock_hz = timing->clock_hz,
        .line_delay_ns = timing->line_delay_ns,
        .compensates = timing->compensate,
    };
}

struct lx_clocked *lx_sim_bus_line(struct lx_bus *bus)
{
    return sim_of(bus)->line;
}

struct dg_bus_master *lx_sim_bus_begin(struct lx_bus *bus)
{
    struct sim_bus *self = sim_of(bus);
    catch_up_frames(self);
    dg_bus_master_pause(&self->reader.master, lx_clock_now(bus->setup.clock));
    return &self->reader.master;
}

void lx_sim_bus_read(struct lx_bus *bus)
{
    dg_bus_reader_read(&sim_of(bus)->reader);
}

void lx_sim_bus_end(struct lx_bus *bus)
{
    struct sim_bus *self = sim_of(bus);
    dg_bus_reader_stir(&self->reader, lx_clock_now(bus->setup.clock));
    sleep_until_frame(self);
}

const struct dg_bus_master *lx_sim_bus_ask(struct lx_bus *bus, char *detail)
{
    const struct dg_bus_master *master = lx_sim_bus_begin(bus);
    lx_sim_bus_read(bus);
    lx_sim_bus_end(bus);
    if (!master->answered) {
        (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "no answer");
        return NULL;
    }
    return master;
}

static bool read_one(struct lx_bus *bus, struct lx_station *station, char *text, size_t size)
{
    struct dg_text to = dg_text_in(text, size);
    lx_sim_bus_begin(bus);
    lx_sim_bus_read(bus);
    lx_sim_bus_end(bus);
    const struct dg_bus_master *master = &sim_of(bus)->reader.master;
    if (master->setup.protocol->judge(master, station->place) == DG_MASTER_SILENT) {
        return false;
    }
    master->setup.protocol->line(master, station->place, &to);
    return true;
}

/* --- the operations --- */

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct sim_bus *self = sim_of(bus);
    const struct lx_bus_setup *setup = &bus->setup;
    if (lx_clocked_open(self->line, setup, bus->core, &bus->tap, now, error) != 0) {
        return -1;
    }
    const struct dg_bus_master_setup master = lx_sim_bus_master(bus);
    dg_bus_reader_init(&self->reader, &master, lx_clocked_init(self->line), now);
    for (size_t i = 0; i < setup->count; i++) {
        setup->stations[i]->ready = setup->door->driven ? DG_NEVER : self->reader.due;
    }
    if (lx_timer_make(&self->timer, setup->event, on_time, self, error) != 0) {
        return -1;
    }
    catch_up_frames(self);
    return setup->door->driven ? lx_sim_silkit_open(&self->silkit, bus, error) : 0;
}

/* Outside a simulation there is nothing to connect to. */
static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    (void)station;
    (void)snprintf(to, size, "%s", ((const struct sim_bus *)bus)->silkit.where.ready);
}

static void look_at_line(struct lx_bus *bus, dg_ns now)
{
    (void)now;
    catch_up_frames(sim_of(bus));
}

/* The clock may have been stepped, or run at another rate: that alone changes no frame. */
static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    struct sim_bus *self = sim_of(bus);
    if (station != NULL) {
        dg_bus_reader_stir(&self->reader, now);
    }
    catch_up_frames(self);
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct sim_bus *self = (const struct sim_bus *)bus;
    (void)station;
    dg_state_number(to, "wire_up", 1);
    dg_state_number(to, "wire_late", bus->late);
    dg_state_number(to, "wire_frames", self->reader.counters.frames);
    dg_state_number(to, "wire_silent", self->reader.master.silent);
    dg_state_number(to, "wire_wrong", self->reader.counters.wrong);
}

static void close_bus(struct lx_bus *bus)
{
    struct sim_bus *self = sim_of(bus);
    lx_clocked_close(self->line);
    lx_timer_close(&self->timer);
    free(self);
}

/* --- what is right --- */

/* A bit is looked at half a period behind the edge that it belongs to. */
static int check_timing(const struct dg_plan_timing *timing, struct lx_error *error)
{
    const uint64_t back_ns = (uint64_t)2u * timing->line_delay_ns;
    struct lx_words right = {""};
    if (timing->compensate || 2u * back_ns * timing->clock_hz <= DG_S(1)) {
        return 0;
    }
    lx_words_add(&right, "expected clock_hz up to %u", (unsigned)(DG_S(1) / (2u * back_ns)));
    return lx_refuse(error, right.text,
                     "the way there and back, %u ns, is longer than half a period of %u Hz",
                     (unsigned)back_ns, timing->clock_hz);
}

/* By itself it is right: somebody has set it. */
static int refuse_wire_key(const struct dg_plan *plan, const struct dg_plan_wire *wire,
                           const char *key, struct lx_error *error)
{
    const struct dg_plan_setting *row = wire->settings.list;
    while (strcmp(row->key, key) != 0) {
        row++;
    }
    return lx_plan_refuse_setting(plan, row, error);
}

static int check_wire(const struct lx_bus_setup *setup, const struct lx_clocked *line,
                      struct lx_error *error)
{
    const struct dg_plan_timing *timing =
        &dg_engine_wire_of(setup->engine, setup->index)->line.timing;
    if (check_timing(timing, error) != 0) {
        return refuse_wire_key(setup->plan, setup->wire, "compensate", error);
    }
    return lx_clocked_check_rate(line, timing->clock_hz, error) == 0
               ? 0
               : refuse_wire_key(setup->plan, setup->wire, "clock_hz", error);
}

/* A simulation has a clock of its own, which suits all. */
static int check(struct lx_bus *bus, struct lx_station *station, struct lx_error *error)
{
    const struct sim_bus *self = sim_of(bus);
    const struct lx_bus_setup *setup = &bus->setup;
    if (lx_clocked_check(self->line, setup, station, error) != 0) {
        return -1;
    }
    const bool last = station->place + 1u == setup->count;
    return last && !setup->door->driven ? check_wire(setup, self->line, error) : 0;
}

static const struct lx_bus_ops ops = {
    LX_BUS_OPERATIONS,
    .check = check,
    .look = look_at_line,
    .read = read_one,
};

/* --- from the plan --- */

struct lx_bus *lx_sim_bus_make(const struct lx_bus_setup *setup, struct dg_engine_wire *to,
                               struct lx_error *error)
{
    struct sim_bus *self = lx_bus_allocate(sizeof *self, &ops, setup, error);
    if (self == NULL) {
        return NULL;
    }
    self->line = lx_clocked_make(setup, to, LX_CLOCKED_HERE, error);
    if (self->line == NULL) {
        free(self);
        return NULL;
    }
    const struct dg_bus_master_setup master = lx_sim_bus_master(&self->bus);
    to->edges = dg_bus_master_wire(&master);
    return &self->bus;
}

/* SPDX-License-Identifier: MIT */
/*
 * BiSS encoders on a simulated wire, with a master in this process that reads positions by the
 * rig's clock. A frame takes its time on the wire, which may run ahead of the clock by it; then the
 * next one waits:
 *
 *   clock  0        100 ms     200 ms
 *   wire   |frame|  |frame|registers.......|frame|
 *
 * Whatever the clock does, each frame is read at its own moment: no deadline can be missed here.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "biss_settings.h"
#include "bus.h"
#include "sim_master.h"
#include "sim_settings.h"
#include "timer.h"

/* How often the master reads. */
#define READ_EVERY DG_MS(100)
/* Frames that are caught up with after a step or a pause of this process; older ones are left out.
 */
#define READS_MAX 1000u

/* An encoder. */
struct slave {
    struct lx_station *station;
    struct lx_biss_settings settings;
    struct lx_biss_eeprom eeprom;
    struct dg_biss device;
};

struct sim_bus {
    struct lx_bus bus;
    struct lx_biss_timing timing;
    struct lx_sim_master master;
    struct lx_timer timer;
    dg_ns due;       /* the next frame, by the rig's clock */
    uint64_t frames; /* read */
    uint64_t wrong;  /* positions with a wrong CRC */
    size_t count;
    struct slave slave[];
};

static struct sim_bus *sim_of(struct lx_bus *bus)
{
    return (struct sim_bus *)bus;
}

/* --- the master --- */

static void read_frame(struct sim_bus *self, dg_ns at)
{
    const struct lx_biss_wire *wire = &self->master.wire;
    lx_sim_master_pause(&self->master, at);
    lx_sim_master_frame(&self->master);
    self->frames++;
    for (uint8_t i = 0; i < wire->chain.count; i++) {
        self->wrong += wire->answered && !lx_biss_wire_data(wire, i).crc_ok;
    }
}

/* Not before the wire is free. */
static dg_ns next_read(const struct sim_bus *self)
{
    return self->due > self->master.wire.now ? self->due : self->master.wire.now;
}

static void catch_up(struct sim_bus *self)
{
    const struct lx_clock *clock = self->bus.setup.clock;
    const dg_ns now = lx_clock_now(clock);
    const dg_ns behind = dg_elapsed(now, self->due) / READ_EVERY;
    if (behind > READS_MAX) {
        self->due += (behind - READS_MAX) * READ_EVERY;
    }
    while (next_read(self) <= now) {
        read_frame(self, next_read(self));
        self->due += READ_EVERY;
    }
    lx_timer_at(&self->timer, lx_clock_real(clock, next_read(self)));
}

static void on_time(void *ctx, dg_ns now)
{
    (void)now;
    catch_up(ctx);
}

/* --- what the control plane asks for --- */

static struct sim_bus *at_present(struct lx_bus *bus)
{
    struct sim_bus *self = sim_of(bus);
    lx_sim_master_pause(&self->master, lx_clock_now(bus->setup.clock));
    return self;
}

static int biss_frame(struct lx_bus *bus, struct lx_station *station, uint64_t *bits,
                      uint8_t *count, char *detail)
{
    struct sim_bus *self = at_present(bus);
    const struct lx_biss_wire *wire = &self->master.wire;
    const struct lx_biss_slave *slave = &wire->slave[station->place];
    read_frame(self, wire->now);
    lx_timer_at(&self->timer, lx_clock_real(bus->setup.clock, next_read(self)));
    if (!wire->answered) {
        (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "%s", lx_biss_failure_text(LX_BISS_SILENT));
        return DG_SCPI_HARDWARE;
    }
    *bits = (uint64_t)wire->cds << slave->data_bits | slave->bits;
    *count = (uint8_t)(slave->data_bits + 1u);
    return DG_SCPI_NO_ERROR;
}

/* The end of an access: `result` is what that to `address` ended in. */
static int finish(struct sim_bus *self, const struct lx_station *station, uint8_t address,
                  int result, char *detail)
{
    lx_timer_at(&self->timer, lx_clock_real(self->bus.setup.clock, next_read(self)));
    if (result >= 0) {
        return DG_SCPI_NO_ERROR;
    }
    lx_sim_master_explain(&self->master, (uint8_t)station->place, address, result, detail,
                          DG_SCPI_DETAIL_MAX + 1u);
    return DG_SCPI_HARDWARE;
}

static int biss_read(struct lx_bus *bus, struct lx_station *station, uint8_t address,
                     uint8_t *bytes, size_t n, char *detail)
{
    struct sim_bus *self = at_present(bus);
    size_t done = 0;
    const int result =
        lx_sim_master_read(&self->master, (uint8_t)station->place, address, bytes, n, &done);
    return finish(self, station, (uint8_t)(address + done), result, detail);
}

static int biss_write(struct lx_bus *bus, struct lx_station *station, uint8_t address,
                      const uint8_t *bytes, size_t n, char *detail)
{
    struct sim_bus *self = at_present(bus);
    size_t done = 0;
    const int result =
        lx_sim_master_write(&self->master, (uint8_t)station->place, address, bytes, n, &done);
    return finish(self, station, (uint8_t)(address + done), result, detail);
}

/* --- the operations --- */

static int switch_on(struct slave *slave, const struct lx_bus_setup *setup, dg_ns now,
                     struct lx_error *error)
{
    const char *nvm = slave->station->plan->nvm;
    if (lx_biss_eeprom_open(&slave->eeprom, nvm, error) != 0 ||
        lx_biss_eeprom_defer(&slave->eeprom, setup->writer, error) != 0) {
        return lx_plan_fail(setup->plan, slave->station->plan->nvm_line, error, "%s", error->text);
    }
    slave->station->control.nvm = slave->eeprom.nvm;
    slave->station->queue = nvm == NULL ? NULL : &slave->eeprom.queue;
    const struct dg_biss_setup device = {&slave->settings.model, &slave->station->world,
                                         slave->eeprom.nvm};
    return lx_biss_switch_on(&slave->device, &device, now, nvm, error);
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct sim_bus *self = sim_of(bus);
    dg_ns init = 0;
    lx_sim_master_init(&self->master, &bus->tap, &self->timing, now);
    for (size_t i = 0; i < self->count; i++) {
        struct slave *slave = &self->slave[i];
        if (switch_on(slave, &bus->setup, now, error) != 0) {
            return -1;
        }
        lx_sim_master_add(&self->master, &slave->device, &slave->station->control.faults,
                          slave->station->control.name);
        init = slave->settings.model.init > init ? slave->settings.model.init : init;
    }
    const int result = lx_timer_open(&self->timer, bus->setup.event, on_time, self);
    if (result < 0) {
        return lx_fail(error, "no timer: %s", strerror(-result));
    }
    self->due = dg_after(now, init);
    catch_up(self);
    return 0;
}

/* There is nothing to connect to. */
static void address(const struct lx_bus *bus, const struct lx_station *station, char *to,
                    size_t size)
{
    (void)bus;
    (void)station;
    (void)snprintf(to, size, "%s", "");
}

/* The clock may have been stepped, or run at another rate. */
static void changed(struct lx_bus *bus, struct lx_station *station, dg_ns now)
{
    (void)station;
    (void)now;
    catch_up(sim_of(bus));
}

static void counters(const struct lx_bus *bus, const struct lx_station *station, struct dg_scpi *to)
{
    const struct sim_bus *self = (const struct sim_bus *)bus;
    const struct lx_count rows[] = {
        {"wire_up", 1},
        {"wire_late", bus->late},
        {"wire_frames", self->frames},
        {"wire_silent", self->master.wire.silent},
        {"wire_wrong", self->wrong},
    };
    (void)station;
    lx_bus_count(to, rows, sizeof rows / sizeof rows[0]);
}

static void close_bus(struct lx_bus *bus)
{
    struct sim_bus *self = sim_of(bus);
    for (size_t i = 0; i < self->count; i++) {
        dg_biss_power_off(&self->slave[i].device);
        lx_biss_eeprom_close(&self->slave[i].eeprom);
    }
    lx_timer_close(&self->timer);
    free(self);
}

static const struct lx_bus_ops ops = {
    .open = open_bus,
    .address = address,
    .changed = changed,
    .counters = counters,
    .biss_frame = biss_frame,
    .biss_read = biss_read,
    .biss_write = biss_write,
    .close = close_bus,
};

/* --- from the plan --- */

static int place(struct sim_bus *self, size_t index, struct lx_error *error)
{
    struct lx_station *station = self->bus.setup.stations[index];
    struct slave *slave = &self->slave[index];
    slave->station = station;
    slave->eeprom.file.fd = -1;
    if (lx_biss_settings_plan(&slave->settings, self->bus.setup.plan, station->plan, error) != 0) {
        return -1;
    }
    if (slave->settings.model.timeout != 0) {
        return lx_plan_fail(
            self->bus.setup.plan, station->plan->line, error,
            "timeout_us: only with --gpio; the simulated wire has the encoder's own "
            "timeout");
    }
    lx_settings_world(&slave->settings.common, &station->world);
    station->control.device = &slave->device;
    station->control.serial = slave->settings.model.serial;
    station->own = slave;
    return 0;
}

struct lx_bus *lx_sim_bus_make(const struct lx_bus_setup *setup, struct lx_error *error)
{
    struct sim_bus *self = calloc(1, sizeof *self + setup->count * sizeof self->slave[0]);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %zu encoders", setup->count);
        return NULL;
    }
    self->bus = (struct lx_bus){.ops = &ops, .setup = *setup};
    self->count = setup->count;
    int result = lx_sim_settings_plan(&self->timing, setup->plan, setup->wire, error);
    for (size_t i = 0; i < self->count && result == 0; i++) {
        result = place(self, i, error);
    }
    if (result != 0) {
        free(self);
        return NULL;
    }
    return &self->bus;
}

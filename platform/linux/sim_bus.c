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
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "biss_settings.h"
#include "biss_wire.h"
#include "bus.h"
#include "timer.h"

/* How often the master reads. */
#define READ_EVERY DG_MS(100)
/* Frames that are caught up with after a step or a pause of this process; older ones are left out.
 */
#define READS_MAX 1000u
/* A start bit later than this is worth a word. */
#define START_MAX DG_BISS_BUSY_S_MAX_NS
/* Room for a note: 64 registers. */
#define NOTE_MAX 240u

/* An encoder. */
struct slave {
    struct lx_station *station;
    struct lx_biss_settings settings;
    struct lx_biss_eeprom eeprom;
    struct dg_biss device;
};

struct sim_bus {
    struct lx_bus bus;
    struct lx_biss_wire wire;
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

/* --- the tap --- */

static void tell_levels(void *ctx, dg_ns at, bool ma, bool slo)
{
    const struct sim_bus *self = ctx;
    const struct lx_tap_event event = {.at = at, .kind = LX_TAP_LEVELS, .levels = {ma, slo}};
    lx_tap_tell(&self->bus.tap, &event);
}

/* Edges cost most of the time of a frame: they are only told while somebody listens. */
static void look_for_listeners(struct sim_bus *self)
{
    self->wire.levels = lx_tap_on(&self->bus.tap) ? tell_levels : NULL;
    self->wire.ctx = self;
}

/* Which encoder, where there are several. */
static int begin_note(const struct sim_bus *self, size_t place, char *text, size_t size)
{
    return self->count == 1
               ? 0
               : snprintf(text, size, "%.32s: ", self->slave[place].station->control.name);
}

static void tell_note(const struct sim_bus *self, bool ours, const char *text)
{
    const struct lx_tap_event event = {
        .at = self->wire.now, .kind = LX_TAP_NOTE, .ours = ours, .note = text};
    lx_tap_tell(&self->bus.tap, &event);
}

static void note_position(const struct sim_bus *self, size_t place)
{
    char text[NOTE_MAX];
    const size_t size = sizeof text;
    const struct lx_biss_position p = lx_biss_wire_position(&self->wire, (uint8_t)place);
    const uint8_t st_bits = self->slave[place].settings.model.singleturn_bits;
    int n = begin_note(self, place, text, size);
    if (!self->wire.answered) {
        (void)snprintf(text + n, size - (size_t)n, "no answer");
        tell_note(self, true, text);
        return;
    }
    n += snprintf(text + n, size - (size_t)n,
                  "position %" PRIu64 ":%" PRIu64 " nERR %d nWARN %d LC %u CRC %s",
                  p.position >> st_bits, p.position & (((uint64_t)1 << st_bits) - 1u), p.n_err,
                  p.n_warn, p.life, p.crc_ok ? "ok" : "wrong");
    if (self->wire.start > START_MAX) {
        (void)snprintf(text + n, size - (size_t)n, ", start bit after %" PRIu64 " us",
                       self->wire.start / DG_US(1));
    }
    tell_note(self, true, text);
}

/* "register 78h = 04 00" */
static void note_registers(const struct sim_bus *self, size_t place, uint8_t address,
                           const uint8_t *bytes, size_t n)
{
    char text[NOTE_MAX];
    int used = begin_note(self, place, text, sizeof text);
    used += snprintf(text + used, sizeof text - (size_t)used, "register %02Xh =", address);
    for (size_t i = 0; i < n && (size_t)used + 4u < sizeof text; i++) {
        used += snprintf(text + used, sizeof text - (size_t)used, " %02X", bytes[i]);
    }
    tell_note(self, true, text);
}

/* --- the master --- */

static void read_frame(struct sim_bus *self, dg_ns at)
{
    look_for_listeners(self);
    lx_biss_wire_pause(&self->wire, at);
    lx_biss_wire_frame(&self->wire);
    self->frames++;
    for (size_t i = 0; i < self->count; i++) {
        const struct lx_biss_position p = lx_biss_wire_position(&self->wire, (uint8_t)i);
        self->wrong += self->wire.answered && !p.crc_ok;
        if (lx_tap_on(&self->bus.tap)) {
            note_position(self, i);
        }
    }
}

/* Not before the wire is free. */
static dg_ns next_read(const struct sim_bus *self)
{
    return self->due > self->wire.now ? self->due : self->wire.now;
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

static int complain(const char *what, char *detail)
{
    (void)snprintf(detail, DG_SCPI_DETAIL_MAX + 1u, "%s", what);
    return DG_SCPI_HARDWARE;
}

static struct sim_bus *at_present(struct lx_bus *bus)
{
    struct sim_bus *self = sim_of(bus);
    look_for_listeners(self);
    lx_biss_wire_pause(&self->wire, lx_clock_now(bus->setup.clock));
    return self;
}

static int biss_frame(struct lx_bus *bus, struct lx_station *station, uint64_t *bits,
                      uint8_t *count, char *detail)
{
    struct sim_bus *self = at_present(bus);
    const struct lx_biss_slave *slave = &self->wire.slave[station->place];
    read_frame(self, self->wire.now);
    lx_timer_at(&self->timer, lx_clock_real(bus->setup.clock, next_read(self)));
    if (!self->wire.answered) {
        return complain(lx_biss_failure_text(LX_BISS_SILENT), detail);
    }
    *bits = (uint64_t)self->wire.cds << slave->data_bits | slave->bits;
    *count = (uint8_t)(slave->data_bits + 1u);
    return DG_SCPI_NO_ERROR;
}

/* The end of an access to `address`: `result` is what the last control frame ended in. */
static int finish(struct sim_bus *self, const struct lx_station *station, uint8_t address,
                  int result, char *detail)
{
    lx_timer_at(&self->timer, lx_clock_real(self->bus.setup.clock, next_read(self)));
    if (result >= 0) {
        return DG_SCPI_NO_ERROR;
    }
    char text[DG_SCPI_DETAIL_MAX + 1u];
    const int n = begin_note(self, station->place, text, sizeof text);
    (void)snprintf(text + n, sizeof text - (size_t)n, "register %02Xh: %s", address,
                   lx_biss_failure_text(result));
    tell_note(self, true, text);
    return complain(text, detail);
}

/* Both: as many control frames as it takes, a sequence ends where the next register is refused. */
static int biss_read(struct lx_bus *bus, struct lx_station *station, uint8_t address,
                     uint8_t *bytes, size_t n, char *detail)
{
    struct sim_bus *self = at_present(bus);
    size_t done = 0;
    int result = 0;
    while (result >= 0 && done < n) {
        result = lx_biss_wire_read(&self->wire, (uint8_t)station->place, (uint8_t)(address + done),
                                   bytes + done, n - done);
        done += result > 0 ? (size_t)result : 0;
    }
    if (done > 0) {
        note_registers(self, station->place, address, bytes, done);
    }
    return finish(self, station, (uint8_t)(address + done), result, detail);
}

static int biss_write(struct lx_bus *bus, struct lx_station *station, uint8_t address,
                      const uint8_t *bytes, size_t n, char *detail)
{
    struct sim_bus *self = at_present(bus);
    size_t done = 0;
    int result = 0;
    while (result >= 0 && done < n) {
        result = lx_biss_wire_write(&self->wire, (uint8_t)station->place, (uint8_t)(address + done),
                                    bytes + done, n - done);
        done += result > 0 ? (size_t)result : 0;
    }
    if (done > 0) {
        note_registers(self, station->place, address, bytes, done);
    }
    return finish(self, station, (uint8_t)(address + done), result, detail);
}

/* --- the operations --- */

static int switch_on(struct slave *slave, dg_ns now, struct lx_error *error)
{
    const char *nvm = slave->station->plan->nvm;
    if (lx_biss_eeprom_open(&slave->eeprom, nvm, error) != 0) {
        return -1;
    }
    slave->station->control.nvm = slave->eeprom.nvm;
    const struct dg_biss_setup setup = {&slave->settings.model, &slave->station->world,
                                        slave->eeprom.nvm};
    if (dg_biss_init(&slave->device, &setup) != DG_OK) {
        return lx_fail(error, "these factory figures make no encoder");
    }
    if (dg_biss_power_on(&slave->device, now) != DG_OK) {
        return lx_fail(error, "--nvm %s: not the EEPROM of a BiSS encoder; another name is right",
                       nvm == NULL ? "" : nvm);
    }
    return 0;
}

static int open_bus(struct lx_bus *bus, dg_ns now, struct lx_error *error)
{
    struct sim_bus *self = sim_of(bus);
    dg_ns init = 0;
    lx_biss_wire_init(&self->wire, now);
    for (size_t i = 0; i < self->count; i++) {
        struct slave *slave = &self->slave[i];
        if (switch_on(slave, now, error) != 0) {
            return -1;
        }
        lx_biss_wire_add(&self->wire, &slave->device, &slave->station->control.faults);
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
    const struct {
        const char *name;
        uint64_t value;
    } rows[] = {
        {"wire_up", 1},
        {"wire_late", bus->late},
        {"wire_frames", self->frames},
        {"wire_silent", self->wire.silent},
        {"wire_wrong", self->wrong},
    };
    (void)station;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[64];
        (void)snprintf(text, sizeof text, "%s=%" PRIu64, rows[i].name, rows[i].value);
        dg_scpi_put_word(to, text);
    }
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
    const struct lx_plan_settings *settings = &setup->wire->settings;
    if (settings->count > 0) {
        (void)lx_plan_fail(setup->plan, settings->list[0].line, error,
                           "%s: a simulated wire has no settings; each encoder has its own",
                           settings->list[0].key);
        return NULL;
    }
    struct sim_bus *self = calloc(1, sizeof *self + setup->count * sizeof self->slave[0]);
    if (self == NULL) {
        (void)lx_fail(error, "no memory for %zu encoders", setup->count);
        return NULL;
    }
    self->bus = (struct lx_bus){.ops = &ops, .setup = *setup};
    self->count = setup->count;
    for (size_t i = 0; i < self->count; i++) {
        if (place(self, i, error) != 0) {
            free(self);
            return NULL;
        }
    }
    return &self->bus;
}

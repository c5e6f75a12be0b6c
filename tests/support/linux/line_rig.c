/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "line_rig.h"

#include <setjmp.h>
#include <stdarg.h>

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "hf_rig.h"
#include "serial.h"
#include "station_rig.h"
#include "timer.h"

#define MODEL "s3684-rs485"
/* The pause that ends a frame at 9600 Bd, with room. */
#define PAUSE DG_MS(12)

static void on_event(void *ctx, const struct dg_tap_event *event)
{
    struct line_heard *self = ctx;
    assert_int_equal(event->kind, DG_TAP_CHARACTER);
    self->disordered = self->disordered || event->at < self->last;
    self->last = event->at;
    self->ours += event->ours;
    self->damaged += event->character.damaged;
    if (self->count < sizeof self->bytes) {
        self->bytes[self->count++] = event->character.byte;
    }
}

/* --- the loop and the master --- */

static void run_until(struct line_rig *self, dg_ns end)
{
    for (dg_ns now = lx_now(); now < end; now = lx_now()) {
        assert_true(sd_event_run(self->event, (end - now) / 1000u + 1u) >= 0);
    }
}

void line_rig_run(struct line_rig *self, dg_ns span)
{
    run_until(self, lx_now() + span);
}

static void pump_master(struct line_rig *self)
{
    const ssize_t n =
        read(self->master, self->reply + self->length, sizeof self->reply - self->length);
    self->length += n > 0 ? (size_t)n : 0u;
}

/* Until nothing has been to do for the pause that ends a frame. A machine that stands still takes a
   time from the encoder as from the test: then less has happened in it than there was time for. */
static void settle_line(struct line_rig *self)
{
    const dg_ns end = lx_now() + LINE_PATIENCE;
    while (sd_event_run(self->event, PAUSE / 1000u) > 0 && lx_now() < end) {
    }
}

/* Wait for `n` characters of replies. @return how many came */
size_t line_rig_receive(struct line_rig *self, size_t n, dg_ns patience)
{
    const dg_ns end = lx_now() + patience;
    pump_master(self);
    while (self->length < n && lx_now() < end) {
        assert_true(sd_event_run(self->event, 1000u) >= 0);
        pump_master(self);
    }
    if (self->length < n) {
        settle_line(self);
        pump_master(self);
    }
    return self->length;
}

/* A request; the check sum is added. */
void line_rig_request(struct line_rig *self, uint8_t address, const char *command)
{
    uint8_t frame[DG_HF_FRAME_MAX] = {address};
    const size_t n = 1 + hf_rig_hex(command, frame + 1, sizeof frame - 2);
    frame[n] = hf_rig_xor(frame, n);
    settle_line(self);
    pump_master(self);
    self->length = 0;
    assert_int_equal(write(self->master, frame, n + 1), (ssize_t)(n + 1));
}

/* @return the reply's length, 0 for none; its address and check sum are right */
size_t line_rig_ask(struct line_rig *self, uint8_t address, const char *command, size_t length)
{
    line_rig_request(self, address, command);
    const size_t n = line_rig_receive(self, length, LINE_PATIENCE);
    assert_int_equal(n, length);
    assert_int_equal(self->reply[0], address);
    assert_int_equal(hf_rig_xor(self->reply, n), 0);
    return n;
}

void line_rig_answers(struct line_rig *self, uint8_t address)
{
    (void)line_rig_ask(self, address, LINE_READ_POSITION, 7);
    assert_int_equal(self->reply[1], 0x42);
}

void line_rig_silent(struct line_rig *self, uint8_t address)
{
    line_rig_request(self, address, LINE_READ_POSITION);
    assert_int_equal(line_rig_receive(self, 1, LINE_SILENCE), 0);
}

/* --- the bus --- */

static void open_master(struct line_rig *self)
{
    char path[LX_BUS_ADDRESS_MAX];
    self->bus->ops->address(self->bus, self->station, path, sizeof path);
    self->master = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    assert_true(self->master >= 0);
}

/* A plan of `count` encoders, the first one at 40h, the next at 41h ... */
void line_rig_plan(struct line_rig *self, size_t count, const char *where)
{
    *self = (struct line_rig){.say = {.quiet = true}, .master = -1, .clock = {.permille = 1000}};
    plan_rig_begin(&self->plan, "line", dg_plan_find_kind("pty", 3), where);
    for (size_t i = 0; i < count; i++) {
        char name[24];
        (void)snprintf(name, sizeof name, "e%zu", i);
        assert_int_equal(dg_plan_add_encoder(&self->plan, name, dg_device_find(MODEL), 0, 0),
                         (int)i);
        self->plan.encoders[i].address = 0x40 + (int)i;
    }
}

void line_rig_set(struct line_rig *self, size_t index, const char *assignment)
{
    struct lx_error error;
    assert_int_equal(
        lx_plan_add_assignment(&self->plan.encoders[index].settings, assignment, 0, &error), 0);
}

void line_rig_prepare(struct line_rig *self)
{
    assert_true(sd_event_new(&self->event) >= 0);
    self->setup = station_setup(&self->plan, self->event, &self->clock);
    self->setup.bus.say = &self->say;
}

const struct lx_wire line_rig_pty = {.make = lx_line_bus_make, .open_port = lx_pty_open};

void line_rig_make(struct line_rig *self, const struct lx_wire *door)
{
    struct lx_error error = {.right = ""};
    self->setup.door = door;
    assert_int_equal(lx_engine_make(&self->engine, &self->setup, &error), 0);
    self->bus = self->engine.wires[0].bus;
    self->station = self->engine.stations;
    for (size_t i = 0; i < self->plan.encoder_count; i++) {
        station_turn(&self->station[i], &self->shaft);
    }
}

struct lx_words line_rig_refused(struct line_rig *self)
{
    struct lx_error error = {.right = ""};
    assert_int_equal(lx_engine_make(&self->engine, &self->setup, &error), -1);
    lx_engine_close(&self->engine);
    return lx_error_line(&error);
}

/* On, with the start-up window (100 ms) over. */
void line_rig_open(struct line_rig *self, const struct lx_wire *door)
{
    struct lx_error error = {.right = ""};
    line_rig_prepare(self);
    line_rig_make(self, door);
    const int result = self->bus->ops->open(self->bus, lx_now(), &error);
    assert_string_equal(lx_error_line(&error).text, "");
    assert_int_equal(result, 0);
    self->heard.listener = (struct lx_tap_listener){.event = on_event, .ctx = &self->heard};
}

void line_rig_open_made(struct line_rig *self, const struct lx_wire *door)
{
    line_rig_open(self, door);
    open_master(self);
    line_rig_run(self, DG_MS(110));
}

void line_rig_open_pty(struct line_rig *self)
{
    line_rig_open_made(self, &line_rig_pty);
}

void line_rig_close(struct line_rig *self)
{
    station_close(&self->engine);
    if (self->master >= 0) {
        (void)close(self->master);
    }
    self->event = sd_event_unref(self->event);
    plan_rig_free(&self->plan);
}

struct dg_hf *line_rig_device(struct line_rig *self, size_t index)
{
    return self->station[index].control->device;
}

void line_rig_changed(struct line_rig *self, size_t index)
{
    self->bus->ops->changed(self->bus, &self->station[index], lx_now());
}

void line_rig_bend(struct line_rig *self, size_t index, enum dg_wire_fault fault, uint32_t count)
{
    station_bend(&self->station[index], lx_now(), fault, count);
    line_rig_changed(self, index);
}

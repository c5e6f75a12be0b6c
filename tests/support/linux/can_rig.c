/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "can_rig.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "station_rig.h"

#define TURN_US 1000u

/* --- the wire of the test's --- */

static bool wire_write(struct lx_can *can, const struct dg_can_frame *frame)
{
    struct can_wire *self = (struct can_wire *)can;
    if (self->full) {
        return false;
    }
    assert_true(self->count < CAN_RIG_FRAMES_MAX);
    self->at[self->count] = lx_now();
    self->open[self->count] = self->seen_all || self->lets[self->asked];
    self->frame[self->count++] = *frame;
    return true;
}

static void wire_pause(struct lx_can *can, bool paused)
{
    ((struct can_wire *)can)->paused = paused;
}

static void wire_filter(struct lx_can *can, const struct dg_bus *bus)
{
    struct can_wire *self = (struct can_wire *)can;
    self->seen_all = bus == NULL;
    for (uint16_t id = 0; bus != NULL && id < 0x800; id++) {
        self->lets[id] = dg_bus_frames_listens(bus, id);
    }
}

static void wire_expect(struct lx_can *can, uint16_t kbaud)
{
    (void)can;
    (void)kbaud;
}

static uint32_t wire_bit_rate(const struct lx_can *can)
{
    return ((const struct can_wire *)can)->bit_rate;
}

static bool wire_up(const struct lx_can *can)
{
    return !((const struct can_wire *)can)->down;
}

static void wire_close(struct lx_can *can)
{
    (void)can;
}

static int wire_start(struct lx_can *can, struct lx_error *error)
{
    (void)can;
    (void)error;
    return 0;
}

static struct lx_can *wire_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    static const struct lx_can_ops ops = {
        .write = wire_write,
        .pause = wire_pause,
        .filter = wire_filter,
        .expect = wire_expect,
        .bit_rate = wire_bit_rate,
        .up = wire_up,
        .close = wire_close,
    };
    static const struct lx_can_kind kind = {sizeof(struct can_wire), &ops, wire_start, NULL};
    struct lx_can *self = lx_can_make(&kind, setup, error);
    assert_non_null(self);
    return self;
}

struct can_wire *can_rig_wire(const struct can_rig *self)
{
    return (struct can_wire *)((struct lx_can_bus *)self->bus)->can;
}

/* --- the bench --- */

int can_rig_set_up(void **state)
{
    struct can_rig *self = calloc(1, sizeof *self);
    assert_non_null(self);
    (void)strcpy(self->folder, "/tmp/test_can_bus.XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    (void)snprintf(self->link, sizeof self->link, "%s/can", self->folder);
    assert_true(sd_event_new(&self->event) >= 0);
    self->client = -1;
    self->clock.permille = 1000;
    *state = self;
    return 0;
}

void can_rig_shut(struct can_rig *self)
{
    if (self->bus != NULL) {
        station_close(&self->engine);
    }
    self->bus = NULL;
    if (self->client >= 0) {
        (void)close(self->client);
    }
    self->client = -1;
    self->length = 0;
    self->taken = 0;
    self->count = 0;
}

/* rmdir() fails when the bus leaves anything but EEPROMs behind. */
int can_rig_tear_down(void **state)
{
    struct can_rig *self = *state;
    can_rig_shut(self);
    for (size_t i = 0; i < CAN_RIG_NODES_MAX; i++) {
        if (self->nvm[i][0] != '\0') {
            (void)unlink(self->nvm[i]);
        }
    }
    lx_plan_free(&self->plan);
    self->event = sd_event_unref(self->event);
    const int result = rmdir(self->folder);
    free(self);
    return result;
}

/* Encoders with the node-IDs 1, 2, ..., of both models in turn. */
void can_rig_plan(struct can_rig *self, size_t count)
{
    self->wire = (struct dg_plan_wire){
        .name = "can0", .kind = dg_plan_find_kind("slcan", 5), .where = self->link};
    self->plan.encoder_count = 0;
    for (size_t i = 0; i < count; i++) {
        struct dg_plan_encoder *encoder = &self->encoder[i];
        (void)snprintf(self->name[i], sizeof self->name[i], "e%zu", i);
        *encoder = (struct dg_plan_encoder){
            .name = self->name[i],
            .model = dg_device_find(i % 2 == 0 ? "f3668" : "f3658"),
            .address = (int)i + 1,
        };
    }
}

static int make(struct can_rig *self, size_t count, const struct lx_wire *door)
{
    struct lx_engine_setup setup = station_setup(&self->plan, self->event, &self->clock);
    setup.door = door;
    self->shaft = (struct dg_plan_shaft){.name = "shaft", .driver = -1};
    self->wire.stack = self->encoder[0].model->stack;
    self->wire.encoder_count = count;
    self->plan.shafts = &self->shaft;
    self->plan.shaft_count = 1;
    self->plan.wires = &self->wire;
    self->plan.wire_count = 1;
    self->plan.encoders = self->encoder;
    self->plan.encoder_count = count;
    if (lx_engine_make(&self->engine, &setup, &self->error) != 0) {
        lx_engine_close(&self->engine);
        return -1;
    }
    self->bus = self->engine.wires[0].bus;
    self->station = self->engine.stations;
    for (size_t i = 0; i < count; i++) {
        station_turn(&self->station[i], &self->angle[i]);
    }
    return 0;
}

int can_rig_make_slcan(struct can_rig *self, size_t count)
{
    static const struct lx_wire slcan = {.make = lx_can_bus_make, .open_can = lx_slcan_open};
    return make(self, count, &slcan);
}

void can_rig_open_slcan(struct can_rig *self, size_t count)
{
    if (can_rig_make_slcan(self, count) != 0 ||
        self->bus->ops->open(self->bus, lx_now(), &self->error) != 0) {
        fail_msg("%s", lx_error_line(&self->error).text);
    }
}

void can_rig_open(struct can_rig *self, size_t count)
{
    static const struct lx_wire door = {.make = lx_can_bus_make, .open_can = wire_open};
    assert_int_equal(make(self, count, &door), 0);
    assert_int_equal(self->bus->ops->open(self->bus, lx_now(), &self->error), 0);
}

struct dg_co_node *can_rig_device(struct can_rig *self, size_t i)
{
    return self->station[i].control->device;
}

void can_rig_changed(struct can_rig *self, size_t i)
{
    self->bus->ops->changed(self->bus, &self->station[i], lx_now());
}

/* --- faults, by what they do --- */

void can_rig_bend(struct can_rig *self, size_t i, enum dg_wire_fault fault, uint32_t count)
{
    station_bend(&self->station[i], lx_now(), fault, count);
    can_rig_changed(self, i);
}

void can_rig_mend(struct can_rig *self, size_t i, enum dg_wire_fault fault)
{
    station_mend(&self->station[i], fault);
    can_rig_changed(self, i);
}

/* --- the client --- */

static uint8_t hex(const char *text)
{
    const char two[] = {text[0], text[1], '\0'};
    return (uint8_t)strtoul(two, NULL, 16);
}

/* A line of the adapter; only frames are kept. */
static void take_line(struct can_rig *self)
{
    struct dg_can_frame *frame = &self->frame[self->count];
    const char id[] = {self->line[1], self->line[2], self->line[3], '\0'};
    if (self->line[0] != 't') {
        return;
    }
    assert_true(self->count < CAN_RIG_FRAMES_MAX);
    *frame = (struct dg_can_frame){.id = (uint16_t)strtoul(id, NULL, 16)};
    frame->dlc = (uint8_t)(self->line[4] - '0');
    for (size_t i = 0; i < frame->dlc; i++) {
        frame->data[i] = hex(&self->line[5 + 2 * i]);
    }
    self->count++;
}

static void read_client(struct can_rig *self)
{
    char byte = 0;
    while (self->client >= 0 && read(self->client, &byte, 1) == 1) {
        if (byte != '\r' && byte != '\a') {
            self->line[self->length++] = byte;
            assert_true(self->length < sizeof self->line);
        } else {
            self->line[self->length] = '\0';
            self->answered += self->length == 0;
            take_line(self);
            self->length = 0;
        }
    }
}

void can_rig_turn(struct can_rig *self)
{
    assert_true(sd_event_run(self->event, TURN_US) >= 0);
    read_client(self);
}

void can_rig_run(struct can_rig *self, dg_ns span)
{
    const dg_ns end = dg_after(lx_now(), span);
    while (lx_now() < end) {
        can_rig_turn(self);
    }
}

static void write_client(struct can_rig *self, const char *text)
{
    assert_int_equal(write(self->client, text, strlen(text)), strlen(text));
}

void can_rig_say(struct can_rig *self, const char *commands)
{
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    size_t wanted = self->answered;
    for (const char *at = commands; *at != '\0'; at++) {
        wanted += *at == '\r';
    }
    write_client(self, commands);
    while (self->answered < wanted && lx_now() < end) {
        can_rig_turn(self);
    }
    assert_int_equal(self->answered, wanted);
}

void can_rig_connect(struct can_rig *self)
{
    self->client = open(self->link, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    assert_true(self->client >= 0);
    can_rig_say(self, "S5\rO\r");
    can_rig_run(self, CAN_RIG_QUIET);
    self->taken = self->count;
}

void can_rig_send(struct can_rig *self, uint16_t id, const uint8_t *data, size_t n)
{
    char text[40];
    int length = snprintf(text, sizeof text, "t%03X%zu", id, n);
    for (size_t i = 0; i < n; i++) {
        length += snprintf(text + length, sizeof text - (size_t)length, "%02X", data[i]);
    }
    text[length] = '\r';
    text[length + 1] = '\0';
    write_client(self, text);
}

/* The next frame with this CAN-ID; NULL when there is none within `patience`. */
const struct dg_can_frame *can_rig_next(struct can_rig *self, uint16_t id, dg_ns patience)
{
    const dg_ns end = dg_after(lx_now(), patience);
    do {
        while (self->taken < self->count) {
            if (self->frame[self->taken++].id == id) {
                return &self->frame[self->taken - 1];
            }
        }
        can_rig_turn(self);
    } while (lx_now() < end);
    return NULL;
}

void can_rig_ask(struct can_rig *self, uint8_t id, uint16_t index)
{
    const uint8_t upload[8] = {0x40, (uint8_t)index, (uint8_t)(index >> 8)};
    can_rig_send(self, 0x600u + id, upload, sizeof upload);
}

static uint32_t value_of(const struct dg_can_frame *frame)
{
    return (uint32_t)frame->data[4] | (uint32_t)frame->data[5] << 8 |
           (uint32_t)frame->data[6] << 16 | (uint32_t)frame->data[7] << 24;
}

/* An expedited SDO upload. */
uint32_t can_rig_upload(struct can_rig *self, uint8_t id, uint16_t index)
{
    can_rig_ask(self, id, index);
    const struct dg_can_frame *frame =
        can_rig_next(self, (uint16_t)(0x580u + id), CAN_RIG_PATIENCE);
    if (frame == NULL) {
        fail_msg("node %u does not answer", id);
        return 0;
    }
    return value_of(frame);
}

bool can_rig_answers(struct can_rig *self, uint8_t id)
{
    can_rig_ask(self, id, 0x1000);
    return can_rig_next(self, (uint16_t)(0x580u + id), CAN_RIG_PATIENCE) != NULL;
}

bool can_rig_is_silent(struct can_rig *self, uint8_t id)
{
    can_rig_ask(self, id, 0x1000);
    return can_rig_next(self, (uint16_t)(0x580u + id), CAN_RIG_QUIET) == NULL;
}

void can_rig_write(struct can_rig *self, size_t i, uint16_t index, uint8_t sub, uint32_t value,
                   uint8_t size)
{
    struct dg_can_frame frame = {.id = (uint16_t)(0x600u + i + 1), .dlc = 8};
    const struct lx_can_setup *setup = &can_rig_wire(self)->can.setup;
    frame.data[0] = (uint8_t)(0x23 | (4 - size) << 2);
    frame.data[1] = (uint8_t)index;
    frame.data[2] = (uint8_t)(index >> 8);
    frame.data[3] = sub;
    memcpy(&frame.data[4], &value, sizeof value);
    setup->rx(setup->ctx, lx_now(), &frame);
    setup->settle(setup->ctx, lx_now());
}

unsigned can_rig_sent(const struct can_rig *self, uint16_t id)
{
    const struct can_wire *wire = can_rig_wire(self);
    unsigned n = 0;
    for (size_t i = 0; i < wire->count; i++) {
        n += wire->frame[i].id == id ? 1u : 0u;
    }
    return n;
}

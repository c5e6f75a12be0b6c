/* SPDX-License-Identifier: MIT */
/*
 * INTERBUS encoders in a ring behind a coupler, as a bus: on a loop of its own, with libmodbus as
 * the client.
 */
#define _GNU_SOURCE
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus.h"
#include "descriptors.h"
#include "drehgeber/bits.h"
#include "drehgeber/devices.h"
#include "modbus.h"
#include "station_rig.h"

#define DEVICES_MAX 3u
#define PATIENCE DG_S(5)
#define TURN_US 1000u
#define STEP ((dg_angle)1 << 20) /* of 4096 a turn */
#define STATUS 0x100Cu
#define SETTINGS_LINE 9u

/* What the tap told. */
struct ears {
    struct lx_tap_listener listener;
    unsigned valid;
    unsigned invalid;
    char notes[512];
};

struct bench {
    char folder[32];
    char nvm[DEVICES_MAX][64];
    char name[DEVICES_MAX][24];
    sd_event *event;
    struct dg_plan plan;
    struct dg_plan_shaft shaft;
    struct dg_plan_wire wire;
    struct dg_plan_encoder encoder[DEVICES_MAX];
    struct lx_engine engine;
    struct lx_station *station;
    dg_angle angle[DEVICES_MAX];
    struct lx_clock clock;
    size_t count;
    struct lx_bus *bus;
    struct lx_error error;
    modbus_t *client;
    struct ears ears;
};

static void set(struct dg_plan_settings *settings, const char *assignment)
{
    struct lx_error error;
    assert_int_equal(lx_plan_add_assignment(settings, assignment, SETTINGS_LINE, &error), 0);
}

static int set_up(void **state)
{
    struct bench *self = calloc(1, sizeof *self);
    assert_non_null(self);
    (void)strcpy(self->folder, "/tmp/test_ring_bus.XXXXXX");
    assert_non_null(mkdtemp(self->folder));
    assert_true(sd_event_new(&self->event) >= 0);
    self->clock.permille = 1000;
    *state = self;
    return 0;
}

static void shut(struct bench *self)
{
    if (self->client != NULL) {
        modbus_close(self->client);
        modbus_free(self->client);
    }
    self->client = NULL;
    if (self->bus != NULL) {
        station_close(&self->engine);
    }
    self->bus = NULL;
}

static void forget_plan(struct bench *self)
{
    lx_plan_free_settings(&self->wire.settings);
    for (size_t i = 0; i < DEVICES_MAX; i++) {
        lx_plan_free_settings(&self->encoder[i].settings);
    }
}

static int tear_down(void **state)
{
    struct bench *self = *state;
    shut(self);
    forget_plan(self);
    for (size_t i = 0; i < DEVICES_MAX; i++) {
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

/* A ring of these models, without self-tests. */
static void plan_ring(struct bench *self, const char *const *models, size_t count)
{
    static char where[] = "127.0.0.1:0";
    forget_plan(self);
    self->count = count;
    self->wire = (struct dg_plan_wire){
        .name = "ring",
        .kind = dg_plan_find_kind("modbus", strlen("modbus")),
        .where = where,
        .line = 4,
    };
    for (size_t i = 0; i < count; i++) {
        struct dg_plan_encoder *encoder = &self->encoder[i];
        (void)snprintf(self->name[i], sizeof self->name[i], "e%zu", i);
        *encoder = (struct dg_plan_encoder){
            .name = self->name[i],
            .model = dg_device_find(models[i]),
            .serial_line = 8,
        };
        set(&encoder->settings, "self_test_ms=0");
    }
}

static const char *const mixed[] = {"ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2"};

static struct lx_bus *make(struct bench *self)
{
    const struct lx_engine_setup setup = station_setup(&self->plan, self->event, &self->clock);
    self->shaft = (struct dg_plan_shaft){.name = "shaft", .driver = -1};
    self->wire.stack = self->encoder[0].model->stack;
    self->wire.encoder_count = self->count;
    self->plan.shafts = &self->shaft;
    self->plan.shaft_count = 1;
    self->plan.wires = &self->wire;
    self->plan.wire_count = 1;
    self->plan.encoders = self->encoder;
    self->plan.encoder_count = self->count;
    if (lx_engine_make(&self->engine, &setup, &self->error) != 0) {
        lx_engine_close(&self->engine);
        return NULL;
    }
    self->station = self->engine.stations;
    for (size_t i = 0; i < self->count; i++) {
        station_turn(&self->station[i], &self->angle[i]);
    }
    return self->engine.wires[0].bus;
}

static void connect_client(struct bench *self)
{
    char address[LX_BUS_ADDRESS_MAX];
    self->bus->ops->address(self->bus, &self->station[0], address, sizeof address);
    char *slash = strrchr(address, '/');
    assert_non_null(slash);
    assert_string_equal(slash, "/0");
    *slash = '\0';
    const char *port = strrchr(address, ':');
    assert_non_null(port);
    self->client = modbus_new_tcp("127.0.0.1", atoi(port + 1));
    assert_non_null(self->client);
    assert_int_equal(modbus_connect(self->client), 0);
}

static void open_ring(struct bench *self)
{
    self->bus = make(self);
    if (self->bus == NULL || self->bus->ops->open(self->bus, lx_now(), &self->error) != 0) {
        fail_msg("%s", lx_error_line(&self->error).text);
    }
    connect_client(self);
}

static struct dg_ib *device(struct bench *self, size_t i)
{
    return self->station[i].control->device;
}

static void turn_loop(struct bench *self)
{
    assert_true(sd_event_run(self->event, TURN_US) >= 0);
}

/* Registers, as a client reads them. */
static void read_registers(struct bench *self, uint16_t first, uint16_t count, uint16_t *to)
{
    const uint8_t request[] = {
        0xFF,           MODBUS_FC_READ_INPUT_REGISTERS, (uint8_t)(first >> 8),
        (uint8_t)first, (uint8_t)(count >> 8),          (uint8_t)count};
    uint8_t answer[MODBUS_TCP_MAX_ADU_LENGTH];
    struct pollfd socket = {.fd = modbus_get_socket(self->client), .events = POLLIN};
    const dg_ns end = dg_after(lx_now(), PATIENCE);
    assert_true(modbus_send_raw_request(self->client, request, sizeof request) > 0);
    while (poll(&socket, 1, 0) == 0) {
        assert_true(lx_now() < end);
        turn_loop(self);
    }
    assert_int_equal(modbus_receive_confirmation(self->client, answer), 9 + 2 * count);
    for (uint16_t i = 0; i < count; i++) {
        to[i] = dg_load_be16(&answer[9 + 2 * i]);
    }
}

static uint16_t get(struct bench *self, uint16_t address)
{
    uint16_t value = 0;
    read_registers(self, address, 1, &value);
    return value;
}

static void wait_for(struct bench *self, uint16_t address, uint16_t value)
{
    const dg_ns end = dg_after(lx_now(), PATIENCE);
    while (get(self, address) != value) {
        assert_true(lx_now() < end);
    }
}

static void wait_for_status(struct bench *self, uint16_t status)
{
    wait_for(self, STATUS, status);
}

/* One of each profile, and cycles run. */
static struct bench *running(void **state)
{
    struct bench *self = *state;
    plan_ring(self, mixed, 3);
    open_ring(self);
    wait_for_status(self, 1);
    return self;
}

/* As the rig does before it reads or changes anything. */
static void look_at_ring(struct bench *self)
{
    self->bus->ops->look(self->bus, lx_now());
}

static uint32_t cycles_of_first(struct bench *self)
{
    look_at_ring(self);
    return device(self, 0)->counters.cycles;
}

static void wait_for_cycles(struct bench *self, uint32_t count)
{
    const dg_ns end = dg_after(lx_now(), PATIENCE);
    const uint32_t first = cycles_of_first(self);
    while (cycles_of_first(self) - first < count) {
        assert_true(lx_now() < end);
        turn_loop(self);
    }
}

static void changed(struct bench *self, size_t i)
{
    self->bus->ops->changed(self->bus, &self->station[i], lx_now());
}

static void set_wire_fault(struct bench *self, size_t i, enum dg_wire_fault fault, uint32_t count)
{
    look_at_ring(self);
    station_bend(&self->station[i], lx_now(), fault, count);
    changed(self, i);
}

static void mend(struct bench *self, size_t i, enum dg_wire_fault fault)
{
    look_at_ring(self);
    station_mend(&self->station[i], fault);
    changed(self, i);
}

static void keep_event(void *ctx, const struct dg_tap_event *event)
{
    struct ears *self = ctx;
    if (event->kind == DG_TAP_NOTE) {
        const size_t used = strlen(self->notes);
        (void)snprintf(self->notes + used, sizeof self->notes - used, "%s|", event->note);
        return;
    }
    assert_int_equal(event->kind, DG_TAP_WORDS);
    assert_int_equal(event->words.count, 5);
    assert_non_null(event->words.in);
    assert_non_null(event->words.out);
    self->valid += event->words.valid ? 1u : 0u;
    self->invalid += event->words.valid ? 0u : 1u;
}

static void listen_to(struct bench *self)
{
    self->ears = (struct ears){.listener = {.event = keep_event, .ctx = &self->ears}};
    look_at_ring(self);
    lx_tap_add(&self->bus->tap, &self->ears.listener);
    self->bus->ops->changed(self->bus, NULL, lx_now());
}

/* Until nothing has been to do for many cycles. */
static void settle_ring(struct bench *self)
{
    for (int i = 0; i < 10000 && sd_event_run(self->event, 20u * TURN_US) > 0; i++) {
    }
}

/* Turns of the loop in `ms` that something had to be done in, up to one more than `most`. */
static unsigned wakes_in(struct bench *self, unsigned ms, unsigned most)
{
    const dg_ns end = dg_after(lx_now(), DG_MS(ms));
    unsigned wakes = 0;
    for (dg_ns now = lx_now(); now < end && wakes <= most; now = lx_now()) {
        const int result = sd_event_run(self->event, (end - now) / 1000u + 1u);
        assert_true(result >= 0);
        wakes += result > 0 ? 1u : 0u;
    }
    return wakes;
}

/* --- the plan --- */

static void plans_that_cannot_be(void **state)
{
    static const struct {
        const char *where;
        const char *serial;
        const char *of_ring;
        const char *of_encoder;
        const char *text;
    } rows[] = {
        {"host", NULL, NULL, NULL,
         "rig.ini:4: modbus:host: expected HOST:PORT, e.g. 127.0.0.1:5020; beyond loopback "
         "HOST:PORT,open"},
        {NULL, "x", NULL, NULL, "rig.ini:8: serial x: expected a number in 0..33554431"},
        {NULL, NULL, "cycle=1", NULL, "rig.ini:9: cycle=1: expected a number in 250..50000 us"},
        {NULL, NULL, "steps=1", NULL, "rig.ini:9: steps=1: the wire has no such key; leave it out"},
        {NULL, NULL, NULL, "clock_hz=1000000",
         "rig.ini:9: clock_hz=1000000: only a sim wire has it; leave it out"},
        {NULL, NULL, NULL, "turns=0", "rig.ini:9: turns=0: expected a number in 1..4096"},
        {NULL, NULL, NULL, "eeprom_acknowledges=2",
         "rig.ini:9: eeprom_acknowledges=2: expected 0 or 1"},
    };
    struct bench *self = *state;
    self->plan.file = "rig.ini";
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        char where[16] = "";
        char serial[16] = "";
        plan_ring(self, mixed, 3);
        if (rows[i].where != NULL) {
            (void)snprintf(where, sizeof where, "%s", rows[i].where);
            self->wire.where = where;
        }
        if (rows[i].serial != NULL) {
            (void)snprintf(serial, sizeof serial, "%s", rows[i].serial);
            self->encoder[1].serial = serial;
        }
        if (rows[i].of_ring != NULL) {
            set(&self->wire.settings, rows[i].of_ring);
        }
        if (rows[i].of_encoder != NULL) {
            set(&self->encoder[2].settings, rows[i].of_encoder);
        }
        assert_null(make(self));
        assert_string_equal(lx_error_line(&self->error).text, rows[i].text);
    }
}

static void figures_that_make_no_encoder(void **state)
{
    struct bench *self = *state;
    plan_ring(self, mixed, 2);
    set(&self->encoder[1].settings, "steps=1");
    set(&self->encoder[1].settings, "steps_minus_one=1");
    self->bus = make(self);
    assert_non_null(self->bus);
    assert_int_equal(self->bus->ops->open(self->bus, lx_now(), &self->error), -1);
    assert_non_null(strstr(lx_error_line(&self->error).text, "device 1: these factory figures"));
}

static void each_is_its_own(void **state)
{
    static char serial[] = "4711";
    uint16_t in[5];
    struct bench *self = *state;
    plan_ring(self, mixed, 3);
    set(&self->encoder[1].settings, "steps=2048");
    set(&self->encoder[1].settings, "param_cycles=7");
    set(&self->encoder[2].settings, "temperature=20");
    self->encoder[1].serial = serial;
    self->angle[0] = 5 * STEP;
    self->angle[1] = (dg_angle)0x23456 * 2 * STEP;
    self->angle[2] = (dg_angle)0x34567 * STEP;
    open_ring(self);
    wait_for_status(self, 1);
    read_registers(self, 0, 5, in);
    assert_int_equal(in[0], 5);
    assert_int_equal(in[1], 2);
    assert_int_equal(in[2], 0x3456);
    assert_int_equal(in[3], 3);
    assert_int_equal(in[4], 0x4567);
    assert_int_equal(self->station[1].control->world->temperature_mdegc, 37000);
    assert_int_equal(self->station[2].control->world->temperature_mdegc, 20000);
    assert_int_equal(self->station[1].control->serial, 4711);
    assert_int_equal(device(self, 1)->setup.model->serial, 4711);
    assert_int_equal(device(self, 1)->setup.model->param_cycles, 7);
    assert_int_equal(device(self, 2)->setup.model->param_cycles,
                     dg_ib_model_of(dg_device_find("ocd-ib-k2"))->param_cycles);
    assert_int_equal(device(self, 2)->setup.model->serial,
                     dg_ib_model_of(dg_device_find("ocd-ib-k2"))->serial + 2);
    assert_null(self->station[0].control->nvm.ops);
    assert_non_null(self->station[1].control->nvm.ops);
}

/* A zero shift, to the K3 whose OUT is at this address. */
static void shift(struct bench *self, uint16_t address, uint8_t steps)
{
    const uint8_t request[] = {0xFF,
                               MODBUS_FC_WRITE_MULTIPLE_REGISTERS,
                               (uint8_t)(address >> 8),
                               (uint8_t)address,
                               0,
                               2,
                               4,
                               0x0A,
                               0,
                               0,
                               steps};
    assert_true(modbus_send_raw_request(self->client, request, sizeof request) > 0);
}

/* The zero shift 55h, to the second of two K3. */
static void shift_second(struct bench *self)
{
    const dg_ns end = dg_after(lx_now(), PATIENCE);
    shift(self, 0x0802, 0x55);
    while (device(self, 1)->last_command != 0x0A000055) {
        assert_true(lx_now() < end);
        turn_loop(self);
    }
    assert_int_equal(device(self, 1)->shift, 0x55);
}

/* A file for each, or one for both: what one stores is its own. */
static void files(void **state)
{
    static const char *const two[] = {"ocd-ib-k3", "ocd-ib-k3"};
    const uint32_t image = dg_store_size(&dg_ib_layout);
    struct bench *self = *state;
    for (size_t i = 0; i < DEVICES_MAX; i++) {
        (void)snprintf(self->nvm[i], sizeof self->nvm[i], "%s/%zu", self->folder, i);
    }
    for (int round = 0; round < 4; round++) {
        const bool shared = round >= 2;
        plan_ring(self, two, 2);
        self->encoder[0].nvm = self->nvm[shared ? 2 : 0];
        self->encoder[1].nvm = self->nvm[shared ? 2 : 1];
        open_ring(self);
        wait_for_status(self, 1);
        assert_int_equal(device(self, 0)->shift, 0);
        assert_int_equal(device(self, 1)->shift, round % 2 == 0 ? 0 : 0x55);
        shift_second(self);
        shut(self);
    }
    for (size_t i = 0; i < DEVICES_MAX; i++) {
        struct stat info;
        assert_int_equal(stat(self->nvm[i], &info), 0);
        assert_int_equal(info.st_size, i == 2 ? 2 * image : image);
    }
}

static void no_file_for_those_without_a_memory(void **state)
{
    struct bench *self = *state;
    plan_ring(self, mixed, 3);
    (void)snprintf(self->nvm[0], sizeof self->nvm[0], "%s/k1", self->folder);
    self->encoder[0].nvm = self->nvm[0];
    self->bus = make(self);
    assert_non_null(self->bus);
    assert_int_equal(self->bus->ops->open(self->bus, lx_now(), &self->error), -1);
    assert_non_null(strstr(lx_error_line(&self->error).text, "K1 and K2 have no EEPROM"));
}

/* --- the bus --- */

static void power_off_interrupts_the_ring(void **state)
{
    struct bench *self = running(state);
    listen_to(self);
    wait_for_cycles(self, 2);
    look_at_ring(self);
    dg_ib_power_off(device(self, 1));
    changed(self, 1);
    wait_for_status(self, 2 | 8);
    assert_int_equal(get(self, 0x2000), 0x0136);
    assert_int_equal(get(self, 0x2010), 0);
    look_at_ring(self);
    assert_int_equal(dg_ib_power_on(device(self, 1), lx_now()), DG_OK);
    changed(self, 1);
    wait_for_status(self, 1);
    assert_true(self->ears.valid > 0 && self->ears.invalid > 0);
    assert_string_equal(self->ears.notes, "ID cycle: 1 of 3 devices, interrupted before device 1|"
                                          "ID cycle: 3 of 3 devices|");
}

/* The first break counts, of a fault or as set. */
static void breaks(void **state)
{
    struct bench *self = *state;
    plan_ring(self, mixed, 3);
    set(&self->wire.settings, "break_at=2");
    open_ring(self);
    wait_for_status(self, 2 | 8);
    wait_for(self, 0x2010, 0x0237);
    assert_int_equal(get(self, 0x2020), 0);
    set_wire_fault(self, 1, DG_WIRE_BREAK, 0);
    wait_for(self, 0x2010, 0);
    assert_int_equal(get(self, 0x2000), 0x0136);
    set_wire_fault(self, 0, DG_WIRE_BREAK, 0);
    mend(self, 1, DG_WIRE_BREAK);
    wait_for(self, 0x2000, 0);
    mend(self, 0, DG_WIRE_BREAK);
    wait_for(self, 0x2010, 0x0237);
    assert_int_equal(get(self, 0x2020), 0);
}

static void dropped_cycles(void **state)
{
    struct bench *self = running(state);
    listen_to(self);
    set_wire_fault(self, 1, DG_WIRE_DROP, 0);
    const uint32_t cycles = device(self, 0)->counters.cycles;
    while (self->ears.invalid < 20) {
        turn_loop(self);
    }
    assert_int_equal(device(self, 0)->counters.cycles, cycles);
    assert_int_equal(self->ears.valid, 0);
    mend(self, 1, DG_WIRE_DROP);
    wait_for_cycles(self, 5);
    set_wire_fault(self, 2, DG_WIRE_DROP, 3);
    self->ears.invalid = 0;
    wait_for_cycles(self, 5);
    assert_int_equal(self->ears.invalid, 3);
}

static void transmission_errors(void **state)
{
    struct bench *self = running(state);
    listen_to(self);
    set_wire_fault(self, 1, DG_WIRE_DAMAGE, 2);
    wait_for_cycles(self, 20);
    assert_int_equal(device(self, 0)->counters.crc_errors, 0);
    assert_int_equal(device(self, 1)->counters.crc_errors, 2);
    assert_int_equal(self->ears.invalid, 2 * (1 + DG_RING_DEAD_CYCLES));
    assert_string_equal(self->ears.notes, "transmission error|transmission error|");
}

/* A position, then another one: in between the halves of both. */
static void torn_words(void **state)
{
    uint16_t in[5];
    struct bench *self = running(state);
    look_at_ring(self);
    self->angle[0] = 0x123 * STEP;
    self->angle[1] = 0x12345 * STEP;
    self->angle[2] = 0x12345 * STEP;
    wait_for_cycles(self, 3);
    set_wire_fault(self, 0, DG_WIRE_TEAR, 1);
    set_wire_fault(self, 1, DG_WIRE_TEAR, 1);
    self->angle[0] = 0x456 * STEP;
    self->angle[1] = 0x23456 * STEP;
    self->angle[2] = 0x23456 * STEP;
    /* Stop the ring in the cycle that was torn. */
    wait_for_cycles(self, 1);
    set_wire_fault(self, 0, DG_WIRE_DROP, 0);
    read_registers(self, 0, 5, in);
    assert_int_equal(in[0], 0x156);
    assert_int_equal(in[1], 0x0001);
    assert_int_equal(in[2], 0x3456);
    assert_int_equal(in[3], 0x0002);
    assert_int_equal(in[4], 0x3456);
    mend(self, 0, DG_WIRE_DROP);
    wait_for_cycles(self, 1);
    read_registers(self, 0, 5, in);
    assert_int_equal(in[0], 0x456);
    assert_int_equal(in[1], 0x0002);
}

/* Cycles are counted all the same; who listens hears each of them. */
static void a_ring_sleeps_until_it_is_needed(void **state)
{
    struct bench *self = running(state);
    wait_for_cycles(self, 10);
    settle_ring(self);
    for (int i = 0; i < 3; i++) {
        const uint32_t before = cycles_of_first(self);
        assert_int_equal(wakes_in(self, 100, 0), 0);
        assert_true(cycles_of_first(self) - before >= 100);
    }
    shift(self, 0x0801, 0x66);
    while (device(self, 1)->shift != 0x66) { /* nobody looks */
        turn_loop(self);
    }
    settle_ring(self);
    assert_int_equal(wakes_in(self, 100, 0), 0);
    listen_to(self);
    assert_true(wakes_in(self, 2000, 20) > 20);
    look_at_ring(self);
    lx_tap_remove(&self->bus->tap, &self->ears.listener);
    self->bus->ops->changed(self->bus, NULL, lx_now());
    settle_ring(self);
    assert_int_equal(wakes_in(self, 100, 0), 0);
    set_wire_fault(self, 2, DG_WIRE_DAMAGE, 0);
    assert_true(wakes_in(self, 2000, 20) > 20);
    mend(self, 2, DG_WIRE_DAMAGE);
    settle_ring(self);
    assert_int_equal(wakes_in(self, 100, 0), 0);
}

/* Nobody mends it, and nobody says that it is over. */
static void a_ring_sleeps_again_when_its_fault_is_used_up(void **state)
{
    static const enum dg_wire_fault each[] = {DG_WIRE_DROP, DG_WIRE_DAMAGE, DG_WIRE_TEAR};
    struct bench *self = running(state);
    for (size_t i = 0; i < DG_COUNT(each); i++) {
        set_wire_fault(self, 2, each[i], 2);
        wait_for_cycles(self, 10);
        settle_ring(self);
        assert_int_equal(wakes_in(self, 100, 0), 0);
    }
}

static void late_are_missed_cycles(void **state)
{
    struct bench *self = *state;
    plan_ring(self, mixed, 3);
    set(&self->wire.settings, "cycle=50000");
    open_ring(self);
    listen_to(self);
    (void)usleep(120000); /* the loop has not begun */
    const dg_ns begin = lx_now();
    turn_loop(self);
    wait_for_cycles(self, 1);
    const uint64_t before = self->bus->late; /* none, unless the machine stood still since */
    assert_true(before * DG_MS(50) <= dg_elapsed(lx_now(), begin));
    (void)usleep(160000);
    wait_for_cycles(self, 2);
    assert_true(self->bus->late >= before + 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(plans_that_cannot_be, set_up, tear_down),
        cmocka_unit_test_setup_teardown(figures_that_make_no_encoder, set_up, tear_down),
        cmocka_unit_test_setup_teardown(each_is_its_own, set_up, tear_down),
        cmocka_unit_test_setup_teardown(files, set_up, tear_down),
        cmocka_unit_test_setup_teardown(no_file_for_those_without_a_memory, set_up, tear_down),
        cmocka_unit_test_setup_teardown(power_off_interrupts_the_ring, set_up, tear_down),
        cmocka_unit_test_setup_teardown(breaks, set_up, tear_down),
        cmocka_unit_test_setup_teardown(dropped_cycles, set_up, tear_down),
        cmocka_unit_test_setup_teardown(transmission_errors, set_up, tear_down),
        cmocka_unit_test_setup_teardown(torn_words, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_ring_sleeps_until_it_is_needed, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_ring_sleeps_again_when_its_fault_is_used_up, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(late_are_missed_cycles, set_up, tear_down),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests_name("INTERBUS encoders in a ring", tests, descriptors_note,
                                       NULL);
}

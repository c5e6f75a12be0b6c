/* SPDX-License-Identifier: MIT */
/* CANopen encoders on a bus: the plan, power, the tap, lateness, a pty that goes. */
#define _GNU_SOURCE
#include <dirent.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmocka.h>

#include "can_rig.h"
#include "descriptors.h"

#define HEARTBEAT 0x700u

/* --- the plan --- */

static void refuse(struct can_rig *self, const char *text)
{
    assert_int_equal(can_rig_make_slcan(self, 2), -1);
    assert_string_equal(lx_error_line(&self->error).text, text);
}

static void set(struct dg_plan_encoder *encoder, const char *assignment)
{
    struct lx_error error;
    lx_plan_free_settings(&encoder->settings);
    if (assignment != NULL) {
        assert_int_equal(lx_plan_add_assignment(&encoder->settings, assignment, 9, &error), 0);
    }
}

static void plans_that_cannot_be(void **state)
{
    static const struct {
        const char *serial;
        const char *setting;
        const char *text;
    } rows[] = {
        {"4294967296", NULL, "rig.ini:8: serial 4294967296: expected a number in 0..4294967295"},
        {"x", NULL, "rig.ini:8: serial x: expected a number in 0..4294967295"},
        {NULL, "mt_bits=16",
         "rig.ini:9: mt_bits: no such key; valid: temperature led_current_ua "
         "supply_mv battery_mv sin_amplitude_permille cos_amplitude_permille "
         "sin_offset_permille cos_offset_permille singleturn_ok "
         "multiturn_amplitude_ok multiturn_sync_ok multiturn_vector_ok "
         "eeprom_acknowledges watchdog_fired; of the wire: pace"},
        {NULL, "eeprom_acknowledges=2", "rig.ini:9: eeprom_acknowledges=2: expected 0 or 1"},
    };
    struct can_rig *self = *state;
    self->plan.file = "rig.ini";
    can_rig_plan(self, 2);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        struct dg_plan_encoder *encoder = &self->encoder[1]; /* an f3658 */
        char *serial = rows[i].serial == NULL ? NULL : strdup(rows[i].serial);
        encoder->serial = serial;
        encoder->serial_line = 8;
        set(encoder, rows[i].setting);
        refuse(self, rows[i].text);
        free(serial);
    }
    set(&self->encoder[1], NULL);
    self->encoder[1].serial = NULL;
    set(&self->encoder[0], "mt_bits=13");
    refuse(self, "rig.ini:9: mt_bits=13: expected 12 or 16");
    set(&self->encoder[0], NULL);
}

/* Different models, node-IDs, serial numbers, worlds, on one bus. */
static void each_is_its_own(void **state)
{
    static char serial[] = "42";
    struct can_rig *self = *state;
    can_rig_plan(self, 3);
    set(&self->encoder[0], "mt_bits=16");
    set(&self->encoder[1], "temperature=20.5");
    self->encoder[2].serial = serial;
    can_rig_open_slcan(self, 3);
    can_rig_connect(self);
    self->angle[0] = DG_TURN / 4;
    self->angle[1] = DG_TURN / 2;
    self->angle[2] = -DG_TURN / 4;
    assert_int_equal(can_rig_device(self, 0)->setup.device, &dg_cia406_multiturn_32);
    assert_int_equal(can_rig_device(self, 1)->setup.device, &dg_cia406_singleturn);
    assert_int_equal(can_rig_device(self, 2)->setup.device, &dg_cia406_multiturn);
    assert_int_equal(self->station[0].control->world->temperature_mdegc, 37000);
    assert_int_equal(self->station[1].control->world->temperature_mdegc, 20500);
    assert_ptr_equal(self->station[1].control->world->angle_ctx, &self->angle[1]);
    assert_int_equal(can_rig_upload(self, 1, 0x6004), 0x4000);
    assert_int_equal(can_rig_upload(self, 2, 0x6004), 0x8000);
    assert_int_equal(can_rig_upload(self, 3, 0x6004), 0xFFFC000);
    assert_int_equal(can_rig_device(self, 0)->serial, 1234567890);
    assert_int_equal(can_rig_device(self, 1)->serial, 1234567891);
    assert_int_equal(can_rig_device(self, 2)->serial, 42);
    for (size_t i = 0; i < 3; i++) {
        char address[LX_BUS_ADDRESS_MAX];
        char pty[64] = "";
        assert_true(readlink(self->link, pty, sizeof pty - 1) > 0);
        (void)snprintf(pty + strlen(pty), sizeof pty - strlen(pty), "/%zu", i + 1);
        self->bus->ops->address(self->bus, &self->station[i], address, sizeof address);
        assert_string_equal(address, pty);
        set(&self->encoder[i], NULL);
    }
}

static void a_file_for_each(void **state)
{
    static char other[] = "7";
    struct can_rig *self = *state;
    const uint8_t node_id[8] = {0x2F, 0x01, 0x21, 0x00, 0x21};
    const uint8_t save[8] = {0x23, 0x05, 0x21, 0x00, 's', 'a', 'v', 'e'};
    for (int round = 0; round < 2; round++) {
        can_rig_plan(self, 2);
        for (size_t i = 0; i < 2; i++) {
            (void)snprintf(self->nvm[i], sizeof self->nvm[i], "%s/%zu.nvm", self->folder, i);
            self->encoder[i].nvm = self->nvm[i];
        }
        can_rig_open_slcan(self, 2);
        can_rig_connect(self);
        if (round == 0) {
            can_rig_send(self, 0x601, node_id, sizeof node_id);
            assert_int_equal(can_rig_next(self, 0x581, CAN_RIG_PATIENCE)->data[0], 0x60);
            can_rig_send(self, 0x601, save, sizeof save);
            assert_int_equal(can_rig_next(self, 0x581, CAN_RIG_PATIENCE)->data[0], 0x60);
            can_rig_shut(self);
        }
    }
    assert_int_equal(can_rig_device(self, 0)->id, 0x21);
    assert_int_equal(can_rig_device(self, 1)->id, 2);
    can_rig_shut(self);

    /* A file of another encoder. */
    self->plan.file = "rig.ini";
    self->encoder[0].serial = other;
    self->encoder[0].nvm_line = 5;
    assert_int_equal(can_rig_make_slcan(self, 2), 0);
    assert_int_equal(self->bus->ops->open(self->bus, lx_now(), &self->error), -1);
    assert_non_null(strstr(lx_error_line(&self->error).text, "rig.ini:5: "));
    assert_non_null(
        strstr(lx_error_line(&self->error).text, "belongs to serial number 1234567890"));
}

/* A file as the last release would have left it, had its table been shorter. @return bytes */
static long make_older_file(const char *path, const struct dg_store_layout *layout)
{
    struct dg_store_layout older = *layout;
    struct lx_nvm_memory memory;
    const uint32_t serial = 1234567890;
    older.region_count--;
    assert_int_equal(lx_nvm_memory_init(&memory, dg_store_size(&older)), 0);
    assert_int_equal(dg_store_format(&older, lx_nvm_memory_port(&memory), &serial), DG_OK);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fwrite(memory.bytes, 1, memory.size, file), memory.size);
    assert_int_equal(fclose(file), 0);
    lx_nvm_memory_free(&memory);
    return (long)dg_store_size(&older);
}

static long length_of(const char *path)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    return (long)info.st_size;
}

/* Refused, it stays as it is; taken, it has today's length. */
static void a_file_of_an_earlier_release_grows(void **state)
{
    static char other[] = "7";
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    const struct dg_store_layout *layout =
        dg_cia406_model_of(self->encoder[0].model)->device->layout;
    (void)snprintf(self->nvm[0], sizeof self->nvm[0], "%s/0.nvm", self->folder);
    self->encoder[0].nvm = self->nvm[0];
    self->encoder[0].serial = other;
    const long length = make_older_file(self->nvm[0], layout);
    assert_int_equal(can_rig_make_slcan(self, 1), 0);
    assert_int_equal(self->bus->ops->open(self->bus, lx_now(), &self->error), -1);
    assert_non_null(
        strstr(lx_error_line(&self->error).text, "belongs to serial number 1234567890"));
    can_rig_shut(self);
    assert_int_equal(length_of(self->nvm[0]), length);

    self->encoder[0].serial = NULL;
    can_rig_open_slcan(self, 1);
    assert_int_equal(can_rig_device(self, 0)->serial, 1234567890);
    assert_true(can_rig_device(self, 0)->mounted);
    assert_int_equal(length_of(self->nvm[0]), dg_store_size(layout));
}

/* --- power --- */

static void power_is_each_ones_own(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 2);
    can_rig_open_slcan(self, 2);
    can_rig_connect(self);
    dg_co_power_off(can_rig_device(self, 0));
    can_rig_changed(self, 0);
    assert_true(can_rig_is_silent(self, 1));
    assert_true(can_rig_answers(self, 2));
    assert_false(dg_bus_frames_listens(self->bus->core, 0x601));
    assert_int_equal(dg_co_power_on(can_rig_device(self, 0), lx_now()), DG_OK);
    can_rig_changed(self, 0);
    const struct dg_can_frame *frame = can_rig_next(self, HEARTBEAT + 1, CAN_RIG_PATIENCE);
    assert_non_null(frame);
    assert_int_equal(frame->data[0], 0);
    assert_true(can_rig_answers(self, 1));
}

/* --- the tap, lateness --- */

struct ears {
    struct lx_tap_listener listener;
    unsigned ours;
    unsigned theirs;
};

static void count_event(void *ctx, const struct dg_tap_event *event)
{
    struct ears *self = ctx;
    assert_int_equal(event->kind, DG_TAP_FRAME);
    assert_true(event->at <= lx_now());
    self->ours += event->ours ? 1u : 0u;
    self->theirs += event->ours ? 0u : 1u;
}

static void the_tap_sees_everything(void **state)
{
    const struct dg_can_frame strange = {.id = 0x555, .dlc = 1};
    struct can_rig *self = *state;
    struct ears ears = {.listener = {.event = count_event, .ctx = &ears}};
    can_rig_plan(self, 1);
    can_rig_open(self, 1);
    assert_false(can_rig_wire(self)->seen_all);
    lx_tap_add(&self->bus->tap, &ears.listener);
    const struct lx_can_setup *setup = &can_rig_wire(self)->can.setup;
    can_rig_write(self, 0, 0x1017, 0, 0, 2);
    assert_int_equal(ears.theirs, 1);
    assert_int_equal(ears.ours, 1);
    assert_true(can_rig_wire(self)->seen_all);
    setup->rx(setup->ctx, lx_now(), &strange);
    assert_int_equal(ears.theirs, 2);
    lx_tap_remove(&self->bus->tap, &ears.listener);
    can_rig_write(self, 0, 0x1017, 0, 0, 2);
    assert_int_equal(ears.theirs, 2);
    assert_false(can_rig_wire(self)->seen_all);
}

/* A master may answer what an encoder sends before the loop has gone on. */
static void filters_are_open_before_the_answer(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t sub;
        uint32_t value;
        uint8_t size;
        uint16_t can_id;
    } rows[] = {
        {0x1016, 1, 7u << 16 | 100u, 4, 0x707}, /* heartbeats of node 7 */
        {0x1016, 1, 0, 4, 0x601},
        {0x1005, 0, 0x90, 4, 0x090}, /* SYNC */
    };
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open(self, 1);
    struct can_wire *wire = can_rig_wire(self);
    assert_int_equal(wire->frame[0].id, HEARTBEAT + 1);
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        wire->asked = rows[i].can_id;
        can_rig_write(self, 0, rows[i].index, rows[i].sub, rows[i].value, rows[i].size);
        assert_int_equal(wire->frame[wire->count - 1].id, 0x581);
        assert_true(wire->open[wire->count - 1]);
        assert_false(wire->seen_all);
    }
    dg_co_power_off(can_rig_device(self, 0));
    can_rig_changed(self, 0);
    wire->asked = 0x601;
    assert_false(wire->lets[wire->asked]);
    assert_int_equal(dg_co_power_on(can_rig_device(self, 0), lx_now()), DG_OK);
    assert_int_equal(wire->frame[wire->count - 1].id, HEARTBEAT + 1);
    assert_true(wire->open[wire->count - 1]);
}

/* In a time of the test's: the loop does not run. */
static void late_is_more_than_5_ms(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open(self, 1);
    const struct lx_can_bus *bus = (const struct lx_can_bus *)self->bus;
    const struct lx_can_setup *setup = &can_rig_wire(self)->can.setup;
    setup->settle(setup->ctx, lx_now() + DG_S(1)); /* the loop had not begun */
    assert_int_equal(self->bus->late, 0);
    setup->settle(setup->ctx, bus->promised + LX_BUS_LATE);
    assert_int_equal(self->bus->late, 0);
    setup->settle(setup->ctx, bus->promised + LX_BUS_LATE + 1);
    assert_int_equal(self->bus->late, 1);

    /* A stalled wire is not the bus's fault. */
    const dg_ns now = bus->promised;
    can_rig_wire(self)->full = true;
    dg_co_power_off(can_rig_device(self, 0));
    assert_int_equal(dg_co_power_on(can_rig_device(self, 0), now), DG_OK);
    self->bus->ops->changed(self->bus, &self->station[0], now);
    assert_true(can_rig_wire(self)->can.stalled);
    setup->settle(setup->ctx, now + DG_S(1));
    assert_int_equal(bus->promised, DG_NEVER);
    assert_int_equal(self->bus->late, 1);
    can_rig_wire(self)->full = false;
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    while (can_rig_wire(self)->can.stalled && lx_now() < end) {
        can_rig_turn(self);
    }
    assert_false(can_rig_wire(self)->can.stalled);
    assert_int_not_equal(bus->promised, DG_NEVER);
}

/* --- whether there is a bus (C38) --- */

static void expect_leds(struct can_rig *self, enum dg_cia406_lamp bus, enum dg_cia406_lamp err)
{
    const struct dg_cia406_leds leds = dg_cia406_leds(can_rig_device(self, 0));
    assert_int_equal(leds.bus_pattern, bus);
    assert_int_equal(leds.err_pattern, err);
}

static void power_cycle(struct can_rig *self)
{
    dg_co_power_off(can_rig_device(self, 0));
    can_rig_changed(self, 0);
    assert_int_equal(dg_co_power_on(can_rig_device(self, 0), lx_now()), DG_OK);
    can_rig_changed(self, 0);
}

/* The channel of the adapter is the bus. */
static void a_closed_channel_is_no_bus(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open_slcan(self, 1);
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_BLINK);
    can_rig_connect(self);
    expect_leds(self, DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    can_rig_say(self, "C\r");
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
    power_cycle(self);
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_BLINK);
    can_rig_say(self, "O\r");
    expect_leds(self, DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    /* Nothing has been sent to it since: the open channel was the bus. */
    power_cycle(self);
    can_rig_say(self, "C\r");
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
}

/* Chapter 29 counts it among the causes. */
static void another_bit_rate_is_no_bus(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open_slcan(self, 1);
    can_rig_connect(self);
    can_rig_say(self, "C\rS6\rO\r");
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
    power_cycle(self);
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_BLINK);
    can_rig_say(self, "C\rS5\rL\r");
    expect_leds(self, DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
}

/* A wire that knows of nobody, until it hears somebody, or until nobody acknowledges. */
static void nobody_acknowledges(void **state)
{
    const struct dg_can_frame stop = {.id = 0, .dlc = 2, .data = {2, 0}};
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open(self, 1);
    struct lx_can *can = &can_rig_wire(self)->can;
    can->company = DG_BUS_UNKNOWN;
    power_cycle(self);
    expect_leds(self, DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    can->company = DG_BUS_NOBODY;
    can->setup.settle(can->setup.ctx, lx_now());
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_BLINK);
    can->company = DG_BUS_UNKNOWN;
    power_cycle(self);
    can->setup.rx(can->setup.ctx, lx_now(), &stop);
    can->company = DG_BUS_NOBODY;
    can->setup.settle(can->setup.ctx, lx_now());
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
    can->company = DG_BUS_SOMEBODY;
    can->setup.settle(can->setup.ctx, lx_now());
    expect_leds(self, DG_CIA406_LAMP_SLOW, DG_CIA406_LAMP_OFF);
    can_rig_wire(self)->down = true;
    can->setup.settle(can->setup.ctx, lx_now());
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
}

/* A bus that comes while an encoder has no power. */
static void found_without_power(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open_slcan(self, 1);
    dg_co_power_off(can_rig_device(self, 0));
    can_rig_changed(self, 0);
    can_rig_connect(self);
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
    power_cycle(self);
    expect_leds(self, DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    can_rig_say(self, "C\r");
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
}

/* --- a pty that goes --- */

/* Let every descriptor of the slave side lead elsewhere: to the other side a hang-up. */
static void tear_off(const char *pty)
{
    const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
    DIR *folder = opendir("/proc/self/fd");
    assert_non_null(folder);
    for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        char target[64] = "";
        const ssize_t n = readlinkat(dirfd(folder), entry->d_name, target, sizeof target - 1);
        if (n > 0 && strcmp(target, pty) == 0) {
            assert_true(dup2(nowhere, atoi(entry->d_name)) >= 0);
        }
    }
    (void)closedir(folder);
    (void)close(nowhere);
}

static void a_lost_pty_comes_back(void **state)
{
    struct can_rig *self = *state;
    char pty[64] = "";
    can_rig_plan(self, 1);
    can_rig_open_slcan(self, 1);
    can_rig_connect(self);
    assert_true(can_rig_answers(self, 1));
    assert_true(readlink(self->link, pty, sizeof pty - 1) > 0);
    tear_off(pty);
    (void)close(self->client);
    self->client = -1;
    const struct lx_can *can = ((const struct lx_can_bus *)self->bus)->can;
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    while (lx_can_is_up(can) && lx_now() < end) {
        can_rig_turn(self);
    }
    assert_int_equal(access(self->link, F_OK), -1);
    while (access(self->link, F_OK) != 0 && lx_now() < end) {
        can_rig_turn(self);
    }
    expect_leds(self, DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF);
    can_rig_connect(self);
    expect_leds(self, DG_CIA406_LAMP_BLINK, DG_CIA406_LAMP_OFF);
    assert_true(can_rig_answers(self, 1));
    assert_int_equal(can_rig_upload(self, 1, 0x6004), 0);
}

/* --- all of them --- */

/* Instead of the C library's: those of frames are counted. */
static struct {
    int client; /* who does not count */
    unsigned count;
} writes;

ssize_t counted_write(int fd, const void *bytes, size_t n) __asm__("write");

ssize_t counted_write(int fd, const void *bytes, size_t n)
{
    writes.count += fd != writes.client && memchr(bytes, 't', n) != NULL;
    return syscall(SYS_write, fd, bytes, n);
}

static enum dg_calm calm;

static enum dg_calm look_how_calm(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return calm;
}

static bool sleeps(const struct can_rig *self)
{
    return ((const struct lx_can_bus *)self->bus)->due > dg_after(lx_now(), DG_S(1));
}

/* Else it would find out after minutes that its shaft turns too fast. */
static void an_encoder_wakes_when_its_shaft_begins_to_turn(void **state)
{
    struct can_rig *self = *state;
    const dg_ns end = dg_after(lx_now(), CAN_RIG_PATIENCE);
    can_rig_plan(self, 2);
    can_rig_open(self, 2);
    calm = DG_CALM_STANDS;
    for (size_t i = 0; i < 2; i++) {
        self->station[i].control->world->calm = look_how_calm;
    }
    while (!sleeps(self) && lx_now() < end) {
        can_rig_turn(self);
    }
    self->bus->ops->turns(self->bus, lx_now());
    self->bus->ops->changed(self->bus, NULL, lx_now());
    assert_true(sleeps(self)); /* another shaft's matter */
    self->bus->ops->turns(self->bus, lx_now());
    calm = DG_CALM_UNKNOWN;
    self->bus->ops->changed(self->bus, NULL, lx_now());
    assert_false(sleeps(self));
}

/* Z1: milliseconds behind each frame, which begin again every minute. */
static void frames_have_the_time_when_they_were_sent(void **state)
{
    const uint64_t minute = 60000;
    struct can_rig *self = *state;
    can_rig_plan(self, 1);
    can_rig_open_slcan(self, 1);
    can_rig_connect(self);
    can_rig_say(self, "C\rZ1\rO\r");
    const uint64_t begin = lx_now() / DG_MS(1);
    (void)can_rig_upload(self, 1, 0x1000);
    const uint64_t end = lx_now() / DG_MS(1);
    assert_int_equal(strlen(self->line), strlen("t5818") + 16u + 4u);
    const uint64_t stamp = strtoul(&self->line[strlen("t5818") + 16u], NULL, 16);
    assert_true((stamp + minute - begin % minute) % minute <= end - begin);
}

/* A reset makes all of them send at once, two of them in one piece make them send twice. */
static void what_a_moment_makes_is_one_write(void **state)
{
    static const uint8_t reset[] = {0x82, 0};
    static const char twice[] = "t00028200\rt00028200\r";
    struct can_rig *self = *state;
    can_rig_plan(self, CAN_RIG_NODES_MAX);
    can_rig_open_slcan(self, CAN_RIG_NODES_MAX);
    can_rig_connect(self);
    writes.client = self->client;
    writes.count = 0;
    can_rig_send(self, 0, reset, sizeof reset);
    for (uint16_t i = 1; i <= CAN_RIG_NODES_MAX; i++) {
        assert_non_null(can_rig_next(self, 0x700 + i, CAN_RIG_PATIENCE));
    }
    assert_int_equal(writes.count, 1);
    writes.count = 0;
    assert_int_equal(write(self->client, twice, sizeof twice - 1u), sizeof twice - 1u);
    for (uint16_t i = 1; i <= 2 * CAN_RIG_NODES_MAX; i++) {
        const uint16_t id = (uint16_t)(0x701 + (i - 1) % CAN_RIG_NODES_MAX);
        assert_non_null(can_rig_next(self, id, CAN_RIG_PATIENCE));
    }
    assert_int_equal(writes.count, 1);
}

static void hundred_and_twenty_seven(void **state)
{
    struct can_rig *self = *state;
    can_rig_plan(self, CAN_RIG_NODES_MAX);
    can_rig_open_slcan(self, CAN_RIG_NODES_MAX);
    can_rig_connect(self);
    for (uint8_t id = 1; id <= CAN_RIG_NODES_MAX; id++) {
        assert_int_equal(can_rig_upload(self, id, 0x100B), id);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(plans_that_cannot_be, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(each_is_its_own, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(a_file_for_each, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(a_file_of_an_earlier_release_grows, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(power_is_each_ones_own, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(the_tap_sees_everything, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(filters_are_open_before_the_answer, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(late_is_more_than_5_ms, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(a_closed_channel_is_no_bus, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(another_bit_rate_is_no_bus, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(nobody_acknowledges, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(found_without_power, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(a_lost_pty_comes_back, can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(an_encoder_wakes_when_its_shaft_begins_to_turn,
                                        can_rig_set_up, can_rig_tear_down),
        cmocka_unit_test_setup_teardown(frames_have_the_time_when_they_were_sent, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(what_a_moment_makes_is_one_write, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test_setup_teardown(hundred_and_twenty_seven, can_rig_set_up,
                                        can_rig_tear_down),
        cmocka_unit_test(no_descriptor_is_left),
    };
    return cmocka_run_group_tests_name("CANopen encoders on a bus", tests, descriptors_note, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * Supervision of an F36x8 that is left out while nothing can have changed. Two nodes live through
 * the same, one of which knows of its shaft how calm it is: they say the same at the same
 * moments, and the one that knows asks to be called far less.
 */
#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "drehgeber/host_wire.h"
#include "drehgeber/shaft.h"

#define ROOM 16384u
#define FRAMES_MAX 1024u
#define ROUNDS 4000u
#define LOOK DG_MS(100)

struct said {
    dg_ns at;
    struct dg_host_event event;
};

static struct twin {
    alignas(DG_HOST_ALIGN) uint8_t memory[ROOM];
    struct dg_host *host;
    struct said said[FRAMES_MAX]; /* since it was compared last */
    size_t count;
    unsigned called;
} rests, looks;

static struct dg_shaft shaft;
static dg_ns now;
static uint32_t seed;

static uint32_t random_below(uint32_t n)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)seed * n >> 32);
}

static void keep_event(void *ctx, const struct dg_host_event *event)
{
    struct twin *self = ctx;

    assert_true(self->count < FRAMES_MAX);
    self->said[self->count] = (struct said){event->at, *event};
    self->count++;
}

static void start_twin(struct twin *self, bool knows)
{
    const struct dg_device *model = dg_device_find("f3668");

    self->host =
        dg_host_init_on_bus(self->memory, sizeof self->memory, model, dg_bus_side_of(model));
    struct dg_world *world = dg_host_world(self->host);
    world->angle = dg_shaft_angle;
    world->angle_ctx = &shaft;
    world->calm = knows ? dg_shaft_calm : NULL;
    dg_host_join_bus(self->host, keep_event, self);
    assert_int_equal(dg_host_power(self->host, now, true), DG_HOST_OK);
    (void)dg_host_step(self->host, now);
    self->count = 0;
    self->called = 0;
}

static int set_up(void **state)
{
    (void)state;
    now = 0;
    seed = 1;
    dg_shaft_init(&shaft);
    start_twin(&rests, true);
    start_twin(&looks, false);
    return 0;
}

/* When it asks for it, and no more. */
static void run_twin(struct twin *self)
{
    dg_ns next = dg_host_next(self->host);

    while (next <= now) {
        self->called++;
        next = dg_host_step(self->host, next);
    }
}

static void compare(void)
{
    assert_int_equal(rests.count, looks.count);
    for (size_t i = 0; i < rests.count; i++) {
        assert_int_equal(rests.said[i].at, looks.said[i].at);
        assert_memory_equal(&rests.said[i].event, &looks.said[i].event, sizeof looks.said[i].event);
    }
    rests.count = 0;
    looks.count = 0;
}

static void run_both(dg_ns until)
{
    now = until;
    run_twin(&rests);
    run_twin(&looks);
    compare();
}

/* As a host does that sets dg_world.calm, behind what it has changed. */
static void wake_both(void)
{
    (void)dg_host_step(rests.host, now);
    (void)dg_host_step(looks.host, now);
    compare();
}

static enum dg_calm calm_before;

static void begin_command(void)
{
    calm_before = dg_shaft_calm(&shaft, now);
}

/* Who only knows that the shaft is slow does not hear of another speed. */
static void end_command(void)
{
    if (dg_shaft_calm(&shaft, now) < calm_before) {
        wake_both();
    }
}

static void turn_at(int32_t mrpm)
{
    begin_command();
    assert_int_equal(dg_shaft_set_velocity(&shaft, now, mrpm), DG_OK);
    end_command();
}

static void send_frame(uint32_t id, const uint8_t *data, uint8_t length)
{
    struct dg_host_event event = {.at = now, .kind = DG_HOST_CAN, .id = id, .length = length};

    memcpy(event.data, data, length);
    (void)dg_host_feed(rests.host, &event);
    (void)dg_host_feed(looks.host, &event);
}

static void download(uint16_t index, uint8_t sub, uint8_t size, uint32_t value)
{
    const uint8_t request[8] = {(uint8_t)(0x23u | (4u - size) << 2),
                                (uint8_t)index,
                                (uint8_t)(index >> 8),
                                sub,
                                (uint8_t)value,
                                (uint8_t)(value >> 8),
                                (uint8_t)(value >> 16),
                                (uint8_t)(value >> 24)};

    send_frame(0x63F, request, sizeof request);
}

static void bend_worlds(void)
{
    struct dg_world *const worlds[] = {dg_host_world(rests.host), dg_host_world(looks.host)};
    const uint32_t what = random_below(4);
    const bool sick = random_below(2) != 0;

    for (size_t i = 0; i < DG_COUNT(worlds); i++) {
        if (what == 0) {
            worlds[i]->temperature_mdegc = sick ? 99000 : 37000;
        } else if (what == 1) {
            worlds[i]->battery_mv = sick ? 2000 : 3610;
        } else if (what == 2) {
            worlds[i]->eeprom_acknowledges = !sick;
        } else {
            worlds[i]->singleturn_ok = !sick;
        }
    }
}

static void turn_shaft(void)
{
    static const int32_t mrpm[] = {60000, -3900000, 3900001, 13000000, -25000000};

    begin_command();
    switch (random_below(6)) {
    case 0:
    case 1:
    case 2:
        (void)dg_shaft_set_velocity(&shaft, now, mrpm[random_below(DG_COUNT(mrpm))]);
        break;
    case 3:
        (void)dg_shaft_set_acceleration(&shaft, random_below(2) != 0 ? 60000000 : 0);
        break;
    case 4:
        (void)dg_shaft_set_position(&shaft, now, (dg_angle)random_below(1000) * DG_TURN / 7);
        break;
    default:
        (void)dg_shaft_set_velocity(&shaft, now, 0);
        break;
    }
    end_command();
}

/* What speed and zero are looked after by. */
static void set_up_position(void)
{
    static const uint8_t windows_ms[] = {1, 10, 100, 200};

    switch (random_below(3)) {
    case 0:
        download(0x6031, 2, 2, windows_ms[random_below(DG_COUNT(windows_ms))]);
        break;
    case 1:
        download(0x6002, 0, 4, 1000000);
        break;
    default:
        download(0x6000, 0, 2, random_below(2) * (DG_CIA406_USF | DG_CIA406_SCALING));
        break;
    }
}

static void talk(void)
{
    static const uint8_t operational[2] = {0x01, 0x3F};
    static const uint8_t reset[2] = {0x81, 0x3F};

    switch (random_below(8)) {
    case 0:
        send_frame(0x000, reset, sizeof reset);
        break;
    case 1:
        send_frame(0x000, operational, sizeof operational);
        break;
    case 2:
        download(0x1010, 1, 4, 0x65766173u);
        break;
    case 3:
        download(0x1017, 0, 2, random_below(2) * 250u);
        break;
    case 4:
        download(0x2120, 2, 1, random_below(2) != 0 ? 0x20 : 0x70); /* limits of the temperature */
        break;
    case 5:
        set_up_position();
        break;
    default:
        download(0x6200, 0, 2, random_below(2) * 70u);
        break;
    }
}

/* Often on the grid of supervision, or within a millisecond of it. */
static dg_ns choose_moment(void)
{
    const dg_ns rough = now + DG_MS(1) * random_below(random_below(4) == 0 ? 5000u : 150u);

    switch (random_below(3)) {
    case 0:
        return rough / LOOK * LOOK + LOOK;
    case 1:
        return rough / LOOK * LOOK + LOOK + random_below(2000000);
    default:
        return rough;
    }
}

static void both_say_the_same(void **state)
{
    (void)state;
    for (unsigned i = 0; i < ROUNDS; i++) {
        run_both(choose_moment());
        const uint32_t what = random_below(3);
        if (what == 0) {
            bend_worlds();
            wake_both();
        } else if (what == 1) {
            turn_shaft();
        } else {
            talk();
        }
        run_both(now);
    }
    assert_true(rests.called < looks.called);
}

static void nobody_is_called_while_nothing_happens(void **state)
{
    (void)state;
    run_both(DG_S(300));
    assert_true(rests.called < 5 && looks.called > 2900);
    run_both(DG_S(36000)); /* the operating time is stored every 360 s */
    assert_true(rests.called < 3 * 100 + 5);
}

/* Who had to look while the shaft turned fast sees that it stands, and rests again. */
static void it_rests_again(void **state)
{
    (void)state;
    run_both(DG_S(10));
    turn_at(4000000);
    const unsigned before = rests.called;
    run_both(DG_S(20));
    assert_true(rests.called - before > 90);
    turn_at(0);
    const unsigned turned = rests.called;
    run_both(DG_S(300));
    assert_true(rests.called - turned < 5);
}

/* Ten other speeds a second, none of which a limit is near to: it hears of the first one. */
static void it_rests_while_the_shaft_turns_slowly(void **state)
{
    (void)state;
    run_both(DG_S(10));
    const unsigned before = rests.called;
    for (unsigned i = 0; i < 600u; i++) {
        turn_at(i % 2u == 0 ? 3900000 : -60000);
        run_both(now + DG_MS(100));
    }
    assert_true(rests.called - before < 5);
    begin_command();
    (void)dg_shaft_set_position(&shaft, now, 40 * DG_TURN); /* in a millisecond: 24 000 rpm */
    end_command();
    const unsigned jumped = rests.called;
    run_both(now + DG_MS(100));
    assert_true(rests.called > jumped);
}

/* Over 200 ms it was too fast when it was looked at last, and was not any more afterwards. */
static void it_rests_when_the_speed_is_forgotten(void **state)
{
    (void)state;
    download(0x6031, 2, 2, 200);
    run_both(DG_S(10) + DG_MS(50));
    turn_at(25000000);
    run_both(DG_S(15) - DG_MS(1));
    turn_at(0);
    run_both(DG_S(20)); /* the EMCY that ends it */
}

/* Forth and back is slow enough over 200 ms, back alone is not, and at both looks the shaft stands. */
static void it_rests_when_the_window_has_passed(void **state)
{
    (void)state;
    download(0x6031, 2, 2, 200);
    run_both(DG_S(10));
    (void)dg_shaft_set_acceleration(&shaft, DG_SHAFT_ACCELERATION_MAX);
    turn_at(-11000000);
    run_both(DG_S(15) - DG_MS(112));
    begin_command();
    const dg_angle target = dg_shaft_angle(&shaft, now) + 45 * DG_TURN;
    assert_int_equal(dg_shaft_move(&shaft, now, target, 25000000), DG_OK); /* 108 ms */
    end_command();
    run_both(DG_S(20));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(both_say_the_same, set_up),
        cmocka_unit_test_setup(nobody_is_called_while_nothing_happens, set_up),
        cmocka_unit_test_setup(it_rests_again, set_up),
        cmocka_unit_test_setup(it_rests_while_the_shaft_turns_slowly, set_up),
        cmocka_unit_test_setup(it_rests_when_the_speed_is_forgotten, set_up),
        cmocka_unit_test_setup(it_rests_when_the_window_has_passed, set_up),
    };
    return cmocka_run_group_tests_name("supervision that is left out", tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/*
 * States of buses that somebody has made: bytes of a saved one are changed, its check sum is made
 * right. It is refused and changes nothing, or the bus lives with it: no index leaves its table
 * (the sanitizers see it) and time goes on (a count of deadlines and an alarm see it).
 */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus_scenes.h"
#include "drehgeber/crc.h"
#include "effort.h"

#define STATES 150
#define STATES_THOROUGH 4000
/* Operations that a bus lives through behind such a state. */
#define LIFE 25u
/* Nothing here takes a second; a machine under load may make it some. */
#define PATIENCE_S 30
#define STATE_MAX 32768u
#define SUM_SIZE sizeof(uint32_t)
/* Of the header: what stands before size and sum of the rest. */
#define HEADER_SIZE 64u

static struct bus_world world;
static struct bus_world before;
static uint8_t healthy[STATE_MAX];
static uint8_t forged[STATE_MAX];
static uint8_t of_hosts[BUS_SCENE_ENCODERS][HOST_RIG_MEMORY_MAX];
static uint32_t noise;
static char doing[96];

static void on_alarm(int signal_number)
{
    (void)signal_number;
    (void)!write(STDERR_FILENO, "time stands: ", 13);
    (void)!write(STDERR_FILENO, doing, strlen(doing));
    (void)!write(STDERR_FILENO, "\n", 1);
    _exit(1);
}

/* xorshift32: the same states in every run. */
static uint32_t any(uint32_t below)
{
    noise ^= noise << 13;
    noise ^= noise >> 17;
    noise ^= noise << 5;
    return noise % below;
}

/* What a field may hold that nobody meant: one bit, ends of ranges, a moment far away, noise. */
static void change(uint8_t *at, size_t n)
{
    static const uint8_t ends[] = {0x00, 0x01, 0x02, 0x7F, 0x80, 0xFE, 0xFF};
    const uint32_t how = any(4);
    const uint8_t end = ends[any(sizeof ends)];

    for (size_t i = 0; i < n; i++) {
        if (how == 0) {
            at[i] = end;
        } else if (how == 1) {
            at[i] = (uint8_t)any(256);
        } else if (how == 2) {
            at[i] = i == 0 ? end : 0;
        } else {
            at[i] = (uint8_t)(at[i] ^ (i == 0 ? 1u << any(8) : 0u));
        }
    }
}

/* The sum is the last number of the header, and of all behind it. */
static void sign(uint8_t *state, size_t n)
{
    const uint32_t sum = dg_crc32(0, state + HEADER_SIZE, n - HEADER_SIZE);

    memcpy(state + HEADER_SIZE - SUM_SIZE, &sum, SUM_SIZE);
}

/* Members stand one behind the other at any address. */
static void forge(size_t n)
{
    memcpy(forged, healthy, n);
    for (uint32_t changes = 1 + any(3); changes > 0; changes--) {
        const size_t width = (size_t)1u << any(4);
        const size_t at = HEADER_SIZE + any((uint32_t)(n - HEADER_SIZE));
        change(forged + at, at + width <= n ? width : n - at);
    }
    sign(forged, n);
}

static size_t save_at(const struct bus_scene *scene, unsigned operations)
{
    bus_scene_begin(scene, &world);
    bus_scene_play(scene, &world, 0, operations);
    for (size_t i = 0; i < dg_bus_count(world.bus); i++) {
        assert_int_equal(dg_host_save(world.hosts[i], of_hosts[i], sizeof of_hosts[i]), 0);
    }
    const size_t n = dg_bus_state_size(world.bus);
    assert_in_range(n, HEADER_SIZE + 1u, sizeof healthy);
    assert_int_equal(dg_bus_save(world.bus, healthy, n), DG_HOST_OK);
    /* It is signed as the library does it. */
    memcpy(forged, healthy, n);
    sign(forged, n);
    assert_memory_equal(forged, healthy, n);
    return n;
}

/* @return whether the bus has taken the state */
static bool live_with_forged(const struct bus_scene *scene, size_t n, unsigned from)
{
    bus_scene_make(scene, &world);
    for (size_t i = 0; i < dg_bus_count(world.bus); i++) {
        assert_int_equal(dg_host_restore(world.hosts[i], of_hosts[i], sizeof of_hosts[i]), 0);
    }
    memcpy(&before, &world, sizeof before);
    const int result = dg_bus_restore(world.bus, forged, n);
    if (result != DG_HOST_OK) {
        assert_int_equal(result, DG_HOST_ERR_DAMAGED);
        assert_memory_equal(&before, &world, sizeof before);
        return false;
    }
    bus_scene_play(scene, &world, from, from + LIFE);
    const size_t again = dg_bus_state_size(world.bus);
    assert_in_range(again, HEADER_SIZE + 1u, sizeof forged);
    (void)dg_bus_save(world.bus, forged, again);
    (void)dg_bus_detach(world.bus, 0, world.now + MS);
    bus_scene_pass_to(&world, world.now + SECOND);
    return true;
}

static void forged_states(void **state)
{
    const uint32_t states = effort(STATES, STATES_THOROUGH);
    unsigned taken = 0;
    unsigned refused = 0;

    (void)state;
    (void)signal(SIGALRM, on_alarm);
    for (size_t i = 0; i < bus_scene_count; i++) {
        const struct bus_scene *scene = &bus_scenes[i];
        size_t n = 0;
        unsigned operations = 0;
        noise = 0x1234567u + (uint32_t)i;
        for (uint32_t k = 0; k < states; k++) {
            if (k % 10u == 0) {
                operations = any(BUS_SCENE_OPERATIONS - LIFE);
                n = save_at(scene, operations);
            }
            (void)snprintf(doing, sizeof doing, "%s, state %u", scene->name, (unsigned)k);
            forge(n);
            (void)alarm(PATIENCE_S);
            const bool was_taken = live_with_forged(scene, n, operations);
            (void)alarm(0);
            taken += was_taken ? 1u : 0u;
            refused += was_taken ? 0u : 1u;
        }
    }
    /* Both happen all the time. */
    assert_true(taken > states && refused > states);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forged_states),
    };
    return cmocka_run_group_tests_name("forged states of buses", tests, NULL, NULL);
}

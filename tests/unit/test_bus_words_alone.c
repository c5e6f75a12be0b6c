/* SPDX-License-Identifier: MIT */
/*
 * A ring of one encoder, and the same encoder alone behind its handle: commands, worlds, power and
 * time by chance happen to both, and each word is the same.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "effort.h"
#include "host_rig.h"
#include "ring_rig.h"

static struct ring_rig rig;
static uint32_t noise;

static uint32_t draw(void)
{
    noise = noise * 1664525u + 1013904223u;
    return noise >> 8;
}

static void change_both(struct dg_host *alone)
{
    static const char *const senses[] = {"singleturn_ok", "multiturn_sync_ok",
                                         "eeprom_acknowledges"};
    const char *name = senses[draw() % DG_COUNT(senses)];
    const int64_t angle = (int64_t)draw() << 10;
    const int64_t rate = ((int64_t)(draw() % 4000u) - 2000) * (1 << 24);
    const bool on = draw() % 3u != 0;
    struct dg_host *const both[] = {alone, rig.encoders[0]};

    for (size_t i = 0; i < 2; i++) {
        dg_host_shaft(both[i], rig.now, angle, rate);
        assert_int_equal(dg_host_world_set(both[i], rig.now, name, on), DG_HOST_OK);
        if (!on) {
            assert_int_equal(dg_host_power(both[i], rig.now, false), DG_HOST_OK);
            assert_int_equal(dg_host_power(both[i], rig.now, true), DG_HOST_OK);
        }
    }
    (void)dg_bus_changed(rig.bus, 0, rig.now);
}

/* A command that exists; its data by chance. */
static uint32_t draw_word(void)
{
    static const uint32_t rows[][2] = {
        {0x00000000, 0},    {0x80000000, 0},      {0x40000000, 0},    {0x60000000, 0},
        {0x02000000, 4095}, {0x04000000, 15},     {0x06000000, 7},    {0x08000000, 0xFFFFFF},
        {0x0A000000, 9999}, {0x0E000000, 0},      {0x20400000, 1},    {0x20800000, 15},
        {0x20210000, 15},   {0x40000000, 0xE0FF}, {0xFFFFFFFF, 0xFF},
    };
    const uint32_t *row = rows[draw() % DG_COUNT(rows)];

    return row[0] | (draw() & row[1]);
}

static void exchange_with_both(struct dg_host *alone, uint32_t word, bool id)
{
    struct dg_host_event event = {
        .at = rig.now, .kind = DG_HOST_WORDS, .id = word, .flags = id ? DG_HOST_IDENTIFY : 0};

    assert_int_equal(dg_host_send(alone, &event), DG_HOST_OK);
    (void)dg_host_step(alone, rig.now);
    assert_int_equal(dg_host_receive(alone, &event), 1);
    assert_int_equal(event.at, rig.now);
    if (id) {
        assert_int_equal(ring_rig_identify(&rig), 1);
        assert_int_equal(dg_ring_id_word(rig.bus, 0), event.id);
        return;
    }
    rig.out[0] = (uint16_t)(word >> 16);
    rig.out[1] = (uint16_t)word;
    assert_int_equal(ring_rig_cycle(&rig), DG_RING_OK);
    assert_int_equal((uint32_t)rig.in[0] << 16 | rig.in[1], event.id);
}

static void live_both(const char *model, uint32_t seed)
{
    static uint8_t memory[2][RING_RIG_MEMORY];

    noise = seed;
    ring_rig_init(&rig);
    struct dg_host *alone = host_rig_make(&host_rig_here, model);
    (void)ring_rig_add(&rig, model);
    assert_int_equal(dg_host_power(alone, 0, true), DG_HOST_OK);
    ring_rig_open(&rig);
    exchange_with_both(alone, 0, true);
    for (int i = 0; i < 400; i++) {
        rig.now += 1u + draw() % (draw() % 20u == 0 ? DG_S(300) : DG_MS(3));
        if (draw() % 16u == 0) {
            change_both(alone);
            exchange_with_both(alone, 0, true); /* it may have been off */
        }
        const uint32_t word = draw_word();
        for (uint32_t n = draw() % 6u; n > 0; n--) {
            rig.now += DG_MS(1);
            exchange_with_both(alone, word, draw() % 32u == 0);
        }
    }
    const size_t size = dg_host_memory_size(alone);
    assert_int_equal(dg_host_memory_copy(alone, memory[0], size), DG_HOST_OK);
    assert_int_equal(dg_host_memory_copy(rig.encoders[0], memory[1], size), DG_HOST_OK);
    assert_memory_equal(memory[0], memory[1], size);
}

/* Byte for byte and ns for ns; an ID cycle first is all that a ring wants more. */
static void a_ring_of_one_is_as_an_encoder_alone(void **state)
{
    const uint32_t seeds = effort(20, 500);

    (void)state;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        live_both("ocd-ib-k3", seed);
        live_both("ocd-ib-k2", seed);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ring_of_one_is_as_an_encoder_alone),
    };
    return cmocka_run_group_tests_name("a ring of one", tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT */
/* The ring: images, ID cycles, transmission errors, breaks, LEDs, cycle times. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "ib_rig.h"

#define DEVICES 4u

/* K1, K3, K2, K3: words 0, 1-2, 3-4, 5-6. */
static const char *const names[DEVICES] = {"ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2", "ocd-ib-k3"};

static struct ib_rig rigs[DEVICES]; /* their worlds and memories; the devices are in the ring */
static struct dg_ib devices[DEVICES];
static struct dg_ib_ring ring;
static uint16_t out[7];
static uint16_t in[7];
static uint16_t ids[DEVICES];
static dg_ns now;

static int set_up(void **state)
{
    (void)state;
    memset(out, 0, sizeof out);
    memset(in, 0, sizeof in);
    now = DG_S(1);
    for (uint32_t i = 0; i < DEVICES; i++) {
        if (ib_rig_init(&rigs[i], dg_ib_model_of(dg_device_find(names[i]))) != DG_OK) {
            return -1;
        }
        ib_rig_turn_to(&rigs[i], 0x100 * (i + 1));
        devices[i] = rigs[i].device;
        if (dg_ib_power_on(&devices[i], 0) != DG_OK) {
            return -1;
        }
    }
    return dg_ib_ring_init(&ring, devices, DEVICES) == DG_OK ? 0 : -1;
}

static enum dg_ib_ring_result cycle(void)
{
    now += DG_MS(1);
    return dg_ib_ring_cycle(&ring, now, out, in);
}

static void images(void **state)
{
    static const uint16_t positions[7] = {0x100, 0, 0x200, 0, 0x300, 0, 0x400};

    (void)state;
    assert_int_equal(ring.words, 7);
    assert_int_equal(cycle(), DG_IB_RING_IDENTIFY);
    assert_int_equal(dg_ib_ring_id(&ring, now, ids), DEVICES);
    assert_int_equal(cycle(), DG_IB_RING_OK);
    assert_memory_equal(in, positions, sizeof in);
    out[1] = 0x0800;
    out[2] = 0x0007;
    out[3] = 0x0800; /* a K2 does not look */
    out[5] = 0x2021;
    out[6] = 0x0001;
    for (int i = 0; i < 4; i++) {
        assert_int_equal(cycle(), DG_IB_RING_OK);
    }
    static const uint16_t answers[7] = {0x100, 0xC800, 7, 0, 0x300, 0xA000, 0x1000};
    assert_memory_equal(in, answers, sizeof in);
}

static void id_words(void **state)
{
    static const uint16_t expected[DEVICES] = {0x0136, 0x0237, 0x0236, 0x0237};
    struct dg_ib_model loop = *dg_ib_model_of(dg_device_find("ocd-ib-k3"));

    (void)state;
    assert_int_equal(dg_ib_ring_id(&ring, now, ids), DEVICES);
    assert_memory_equal(ids, expected, sizeof ids);
    loop.loop = true;
    assert_int_equal(dg_ib_id_word(&loop), 0x02B3);
    loop.profile = DG_IB_K2;
    assert_int_equal(dg_ib_id_word(&loop), 0x02B2);
    loop.profile = DG_IB_K1;
    assert_int_equal(dg_ib_id_word(&loop), 0x01B2);

    devices[1].reconfigure = true;
    rigs[0].world.singleturn_ok = false;
    rigs[1].world.singleturn_ok = false; /* a K3 says it in IN */
    assert_int_equal(dg_ib_ring_id(&ring, now, ids), DEVICES);
    assert_int_equal(ids[0], 0x2136);
    assert_int_equal(ids[1], 0x8237);
    assert_int_equal(dg_ib_ring_module_error(&ring), 0);
    rigs[0].world.singleturn_ok = true;
    rigs[2].world.multiturn_sync_ok = false;
    assert_int_equal(cycle(), DG_IB_RING_OK);
    assert_int_equal(dg_ib_ring_module_error(&ring), 2);
    rigs[2].world.multiturn_sync_ok = true;
    assert_int_equal(cycle(), DG_IB_RING_OK);
    assert_int_equal(dg_ib_ring_module_error(&ring), -1);
    assert_int_equal(dg_ib_ring_id(&ring, now, ids), DEVICES);
    assert_memory_equal(ids, expected, sizeof ids);
}

/* After a transmission error: five cycles without data, inputs held, no OUT taken. */
static void transmission_errors(void **state)
{
    (void)state;
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(cycle(), DG_IB_RING_OK);
    ib_rig_turn_to(&rigs[1], 0x777);
    ring.corrupt_at = 2;
    assert_int_equal(cycle(), DG_IB_RING_CRC);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(cycle(), DG_IB_RING_DEAD);
        assert_int_equal(in[2], 0x200);
    }
    assert_int_equal(devices[1].counters.cycles, 1);
    assert_int_equal(cycle(), DG_IB_RING_OK);
    assert_int_equal(in[2], 0x777);
    assert_int_equal(devices[2].counters.crc_errors, 1);
    assert_int_equal(devices[1].counters.crc_errors, 0);
    assert_int_equal(ring.counters.crc_errors, 1);
    assert_int_equal(ring.counters.dead, 5);
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(ids[2], 0x4236);
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(ids[2], 0x0236);

    ring.corrupt_at = 0;
    assert_int_equal(cycle(), DG_IB_RING_CRC);
    assert_int_equal(cycle(), DG_IB_RING_DEAD);
    ring.corrupt_at = 0; /* again, while dead: from the beginning */
    assert_int_equal(cycle(), DG_IB_RING_CRC);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(cycle(), DG_IB_RING_DEAD);
    }
    assert_int_equal(cycle(), DG_IB_RING_OK);
}

static void an_interrupted_ring(void **state)
{
    (void)state;
    for (uint16_t at = 0; at < DEVICES; at++) {
        (void)dg_ib_ring_id(&ring, now, ids);
        assert_int_equal(cycle(), DG_IB_RING_OK);
        in[0] = 0x5555;
        ring.broken_at = at;
        assert_int_equal(cycle(), DG_IB_RING_INTERRUPTED);
        assert_int_equal(dg_ib_ring_id(&ring, now, ids), at);
        for (uint16_t i = 0; i < at; i++) {
            assert_int_equal((dg_ib_leds(&devices[i], now) & DG_IB_LED_RD) != 0, i + 1 == at);
        }
        assert_int_equal(cycle(), DG_IB_RING_INTERRUPTED);
        assert_int_equal(in[0], 0x5555);
        ring.broken_at = DG_IB_RING_WHOLE;
        assert_int_equal(cycle(), DG_IB_RING_IDENTIFY);
        assert_int_equal(dg_ib_ring_id(&ring, now, ids), DEVICES);
        assert_int_equal(cycle(), DG_IB_RING_OK);
        for (uint16_t i = 0; i < DEVICES; i++) {
            assert_int_equal(dg_ib_leds(&devices[i], now) & DG_IB_LED_RD, 0);
        }
    }
}

/* The start after a break leaves no dead cycles behind. */
static void a_break_ends_dead_cycles(void **state)
{
    (void)state;
    (void)dg_ib_ring_id(&ring, now, ids);
    ring.corrupt_at = 1;
    assert_int_equal(cycle(), DG_IB_RING_CRC);
    ring.broken_at = 1;
    assert_int_equal(cycle(), DG_IB_RING_INTERRUPTED);
    ring.broken_at = DG_IB_RING_WHOLE;
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(cycle(), DG_IB_RING_OK);
}

/* A device that lost its power breaks the ring, and needs an ID cycle when it is back. */
static void a_device_without_power(void **state)
{
    (void)state;
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(cycle(), DG_IB_RING_OK);
    dg_ib_power_off(&devices[2]);
    assert_int_equal(cycle(), DG_IB_RING_INTERRUPTED);
    assert_int_equal(dg_ib_power_on(&devices[2], now), DG_OK);
    assert_int_equal(cycle(), DG_IB_RING_IDENTIFY);
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(cycle(), DG_IB_RING_OK);
    dg_ib_power_off(&devices[1]); /* off and on between two cycles */
    assert_int_equal(dg_ib_power_on(&devices[1], now), DG_OK);
    assert_int_equal(cycle(), DG_IB_RING_IDENTIFY);
}

/* 3.3, I20 */
static void leds(void **state)
{
    const struct dg_ib *device = &devices[1];

    (void)state;
    assert_int_equal(dg_ib_leds(device, now), DG_IB_LED_UL);
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(dg_ib_leds(device, now), DG_IB_LED_UL | DG_IB_LED_RC);
    (void)cycle();
    assert_int_equal(dg_ib_leds(device, now), DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA);
    assert_int_equal(dg_ib_leds(device, now + DG_IB_BUS_TIMEOUT),
                     DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA);
    assert_int_equal(dg_ib_leds(device, now + DG_IB_BUS_TIMEOUT + 1), DG_IB_LED_UL);
    now = DG_S(2);
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(dg_ib_leds(device, now),
                     DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA | DG_IB_LED_BA_BLINKS);
    now = DG_S(2) + DG_MS(500);
    (void)dg_ib_ring_id(&ring, now, ids);
    assert_int_equal(dg_ib_leds(device, now), DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA_BLINKS);
}

static void cycle_times(void **state)
{
    (void)state;
    assert_int_equal(dg_ib_bit_times(4, 1), 134);
    assert_int_equal(dg_ib_ring_init(&ring, &devices[1], 1), DG_OK);
    assert_int_equal(dg_ib_ring_cycle_time(&ring, 500000, 0), DG_US(268));
    assert_int_equal(dg_ib_ring_cycle_time(&ring, 2000000, 0), DG_US(67));
    assert_int_equal(dg_ib_ring_cycle_time(&ring, 2000000, DG_US(200)), DG_US(267));
    assert_int_equal(dg_ib_ring_init(&ring, devices, DEVICES), DG_OK);
    assert_int_equal(dg_ib_ring_cycle_time(&ring, 500000, 0), DG_US(2 * (13 * 20 + 16)));
    assert_int_equal(dg_ib_ring_init(&ring, devices, 0), DG_ERR_ARGUMENT);
    assert_int_equal(dg_ib_ring_init(&ring, devices, 513), DG_ERR_ARGUMENT);
    assert_int_equal(dg_ib_ring_init(&ring, NULL, 1), DG_ERR_ARGUMENT);
}

/* 2.1: the message is bits 13 to 15; the ID code below stays what the device has. */
static void a_message_leaves_the_id_code(void **state)
{
    static const uint16_t expected[DEVICES] = {0x8136, 0x8237, 0x8236, 0x8237};

    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        devices[i].reconfigure = true;
    }
    assert_int_equal(dg_ib_ring_id(&ring, now, ids), DEVICES);
    assert_memory_equal(ids, expected, sizeof ids);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(images, set_up),
        cmocka_unit_test_setup(id_words, set_up),
        cmocka_unit_test_setup(transmission_errors, set_up),
        cmocka_unit_test_setup(an_interrupted_ring, set_up),
        cmocka_unit_test_setup(a_break_ends_dead_cycles, set_up),
        cmocka_unit_test_setup(a_device_without_power, set_up),
        cmocka_unit_test_setup(leds, set_up),
        cmocka_unit_test_setup(cycle_times, set_up),
        cmocka_unit_test_setup(a_message_leaves_the_id_code, set_up),
    };
    return cmocka_run_group_tests_name("the INTERBUS ring", tests, NULL, NULL);
}

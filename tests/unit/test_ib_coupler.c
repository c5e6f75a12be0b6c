/* SPDX-License-Identifier: MIT */
/* The coupler of a ring: registers, whole words, watchdog, the map in words. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/bits.h"
#include "drehgeber/drehgeber.h"
#include "ring_rig.h"

#define START DG_S(1)
#define DEVICES 3u

static const char *const models[DEVICES] = {"ocd-ib-k1", "ocd-ib-k3", "ocd-ib-k2"};
static struct ring_rig rig; /* words 0, 1-2, 3-4 */
static struct dg_ring_master master;
static struct dg_ib_coupler map;

static void cycle(dg_ns now)
{
    assert_true(dg_ring_master_cycle(&master, now));
}

static int set_up(void **state)
{
    const struct dg_ring_master_setup setup = {sizeof setup, NULL, rig.out, 0};
    (void)state;
    ring_rig_init(&rig);
    rig.wire.identifies = true;
    rig.now = START;
    for (size_t i = 0; i < DEVICES; i++) {
        (void)dg_host_set(ring_rig_add(&rig, models[i]), "self_test_ms", "0");
    }
    ring_rig_open(&rig);
    dg_ring_master_init(&master, &setup);
    master.setup.bus = rig.bus;
    dg_ib_coupler_init(&map, &master, false);
    dg_ib_coupler_request(&map, START);
    cycle(START); /* the ID cycle */
    cycle(START);
    return 0;
}

static uint16_t get(uint16_t address)
{
    uint16_t value = 0;

    assert_true(dg_ib_coupler_readable(&map, (struct dg_ib_registers){address, 1}));
    dg_ib_coupler_read(&map, (struct dg_ib_registers){address, 1}, &value);
    return value;
}

static void put_register(uint16_t address, uint16_t value)
{
    assert_true(dg_ib_coupler_writable(&map, (struct dg_ib_registers){address, 1}));
    assert_true(dg_ib_coupler_write(&map, (struct dg_ib_registers){address, 1}, &value));
}

static void put_out(uint16_t high, uint16_t low)
{
    const uint16_t words[] = {high, low};

    assert_true(dg_ib_coupler_write(&map, (struct dg_ib_registers){0x0801, 2}, words));
}

static void existing_registers(void **state)
{
    static const struct {
        struct dg_ib_registers range;
        bool readable;
        bool writable;
    } ranges[] = {
        {{0x0000, 5}, true, false},  {{0x0000, 6}, false, false}, {{0x0004, 1}, true, false},
        {{0x07FF, 2}, false, false}, {{0x0800, 5}, true, true},   {{0x0805, 1}, false, false},
        {{0x0800, 1}, true, true},   {{0x0801, 1}, true, false},  {{0x0802, 1}, true, false},
        {{0x0801, 2}, true, true},   {{0x0800, 2}, true, false},  {{0x0802, 3}, true, false},
        {{0x0802, 2}, true, false},  {{0x0803, 2}, true, true},   {{0x0800, 3}, true, true},
        {{0x1000, 10}, true, false}, {{0x100A, 1}, false, false}, {{0x100C, 1}, true, false},
        {{0x1010, 6}, true, false},  {{0x1016, 1}, false, false}, {{0x1120, 4}, true, true},
        {{0x1020, 1}, true, false},  {{0x1124, 1}, false, false}, {{0x1FFF, 1}, false, false},
        {{0x2000, 48}, true, false}, {{0x2030, 1}, false, false}, {{0xFFFF, 2}, false, false},
    };

    (void)state;
    for (size_t i = 0; i < DG_COUNT(ranges); i++) {
        if (dg_ib_coupler_readable(&map, ranges[i].range) != ranges[i].readable ||
            dg_ib_coupler_writable(&map, ranges[i].range) != ranges[i].writable) {
            fail_msg("%04X, %u", (unsigned)ranges[i].range.first, (unsigned)ranges[i].range.count);
        }
    }
    map.tear = true;
    assert_true(dg_ib_coupler_writable(&map, (struct dg_ib_registers){0x0802, 1}));
}

static void images_and_states(void **state)
{
    (void)state;
    assert_int_equal(get(0x1010), 80);
    assert_int_equal(get(0x1011), 80);
    assert_int_equal(get(0x100C), 1);
    put_out(0x0800, 0x0007);
    for (int i = 0; i < 4; i++) {
        cycle(START);
    }
    assert_int_equal(get(0x0001), 0xC800);
    assert_int_equal(get(0x0002), 7);
    assert_int_equal(get(0x0802), 7);
    assert_int_equal(get(0x2000), 0x0136);
    assert_int_equal(get(0x2010), 0x0237);
    assert_int_equal(get(0x2020), 0x0236);
    assert_int_equal(get(0x2011), 1 | 4 | 32);
    assert_int_equal(get(0x2013), 5);
    assert_int_equal(get(0x2016), DG_IB_LED_UL | DG_IB_LED_RC | DG_IB_LED_BA);
    assert_int_equal(get(0x2017), 1);
    assert_int_equal(get(0x2018), 0x0800);
    assert_int_equal(get(0x2019), 7);
    put_out(0x0C00, 0);
    for (int i = 0; i < 4; i++) {
        cycle(START);
    }
    assert_int_equal(get(0x2011), 1 | 8 | 32);
    assert_int_equal(get(0x201A), 0x8400);
    for (size_t i = 0; i < 3; i++) {
        ring_rig_world(&rig, i)->singleturn_ok = false;
    }
    cycle(START);
    assert_int_equal(get(0x100C), 1 | 4);
    assert_int_equal(get(0x2001), 1 | 128);
    dg_ring_cut(rig.bus, 1);
    cycle(START);
    assert_int_equal(get(0x100C) & 0xB, 2 | 8);
    assert_int_equal(get(0x2000), 0x0136);
    assert_int_equal(get(0x2010), 0);
}

/* The watchdog sleeps until OUT is written, and fires one tick after its time. */
static void watchdog_zero_and_freeze(void **state)
{
    (void)state;
    put_register(0x1120, 100);
    cycle(START + DG_S(5));
    assert_int_equal(get(0x1121), 0);
    put_out(0x0800, 7);
    assert_int_equal(get(0x1020), 100);
    cycle(START + DG_MS(100));
    assert_int_equal(get(0x1121), 0);
    dg_ib_coupler_request(&map, START + DG_MS(60)); /* any request feeds it */
    assert_int_equal(get(0x1020), 100);
    cycle(START + DG_MS(160));
    assert_int_equal(get(0x1121), 0);
    cycle(START + DG_MS(160) + 1);
    assert_int_equal(get(0x1121), 1);
    assert_int_equal(get(0x1020), 0);
    assert_int_equal(get(0x0801), 0);
    put_out(0x0800, 8);
    assert_int_equal(get(0x1121), 0);

    put_register(0x1123, DG_RING_FALLBACK_FREEZE);
    put_register(0x1122, 0);
    dg_ib_coupler_request(&map, START + DG_MS(150)); /* only writes of OUT do now */
    cycle(START + DG_MS(170));
    assert_int_equal(get(0x1121), 1);
    assert_int_equal(get(0x0802), 8);
    assert_false(master.stopped);
}

static void watchdog_stop(void **state)
{
    const uint16_t bad = DG_RING_FALLBACK_COUNT;

    (void)state;
    assert_false(dg_ib_coupler_write(&map, (struct dg_ib_registers){0x1123, 1}, &bad));
    put_register(0x1120, 10);
    put_register(0x1123, DG_RING_FALLBACK_STOP);
    put_out(0, 0);
    const uint16_t cycles = get(0x2013);
    cycle(START + DG_MS(11));
    cycle(START + DG_MS(300));
    assert_int_equal(get(0x2013), cycles);
    assert_int_equal(get(0x100C), 0);
    dg_ib_coupler_request(&map, START + DG_MS(300));
    assert_true((get(0x2016) & DG_IB_LED_BA_BLINKS) != 0);
    put_register(0x1121, 0xAFFE);
    put_register(0x1121, 0xBECF);
    assert_int_equal(get(0x1121), 1);
    put_register(0x1121, 0xAFFE);
    assert_int_equal(get(0x1121), 0);
    cycle(START + DG_S(9)); /* asleep again */
    assert_int_equal(get(0x2013), cycles + 1);
}

/* What `drehgeber map` prints of this ring: where a register is, what may be done with it. */
static const char *const printed[] = {
    "Modbus registers, addresses from 0 in hex. Read: functions 3, 4, 23; write: 6, 16, 23.",
    "0000-0004  r   input image",
    "0800-0804  rw  output image",
    "1000-1009  r   identification",
    "100C       r   coupler status",
    "1010       r   output image, bits",
    "1011       r   input image, bits",
    "1012-1013  r   digital",
    "1014-1015  r   missed cycles",
    "1020       r   watchdog: ms left",
    "1120       rw  watchdog: time",
    "1121       rw  watchdog: 1: has fired",
    "1122       rw  watchdog: fed by",
    "1123       rw  fallback",
    "Device 0: K1, ID word 0136h",
    "0000       r   IN",
    "2000       r   ID word",
    "2001       r   state",
    "2002-2003  r   data cycles",
    "2004-2005  r   CRC errors",
    "2006       r   LEDs",
    "2007       r   mode",
    "2008-2009  r   last command",
    "200A-200B  r   last error",
    "Device 1: K3, ID word 0237h",
    "0001-0002  r   IN",
    "0801-0802  rw  OUT",
    "2010       r   ID word",
    "2011       r   state",
    "2012-2013  r   data cycles",
    "2014-2015  r   CRC errors",
    "2016       r   LEDs",
    "2017       r   mode",
    "2018-2019  r   last command",
    "201A-201B  r   last error",
    "Device 2: K2, ID word 0236h",
    "0003-0004  r   IN",
    "2020       r   ID word",
    "2021       r   state",
    "2022-2023  r   data cycles",
    "2024-2025  r   CRC errors",
    "2026       r   LEDs",
    "2027       r   mode",
    "2028-2029  r   last command",
    "202A-202B  r   last error",
};

/* What is said, line by line. */
struct ears {
    size_t next; /* of `printed` */
    size_t empty;
    size_t length; /* of the longest one */
};

static void keep_text(void *ctx, const char *text)
{
    struct ears *self = ctx;
    self->length = strlen(text) > self->length ? strlen(text) : self->length;
    if (text[0] == '\0') {
        self->empty++;
        return;
    }
    assert_true(self->next < DG_COUNT(printed));
    if (strncmp(text, printed[self->next], strlen(printed[self->next])) != 0) {
        fail_msg("\"%s\" for \"%s\"", text, printed[self->next]);
    }
    self->next++;
}

static void the_map_in_words(void **state)
{
    const struct dg_ib_model *figures[DEVICES];
    struct ears ears = {0};
    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        figures[i] = dg_ib_model_of(dg_device_find(models[i]));
    }
    dg_ib_coupler_describe(figures, DEVICES, keep_text, &ears);
    assert_int_equal(ears.next, DG_COUNT(printed));
    assert_int_equal(ears.empty, 1 + DEVICES);
    /* The state of a device, to its end. */
    assert_int_equal(ears.length, strlen("2001       r   state: b0 power, b1 self-test, "
                                         "b2 parameters, b3 error, b4 read-out, b5 preset set, "
                                         "b6 parameters lost, b7 position not valid"));
}

/* Its master runs cycles in virtual time: a request sees what the ring has come to by then, and what
   it writes goes out with the next cycle. */
static void requests_and_cycles(void **state)
{
    (void)state;
    master.setup.period = DG_MS(1);
    dg_ring_master_due(&master, START);
    assert_true(dg_ring_master_next(&master) > START + DG_S(1));
    const uint16_t before = get(0x2013);
    dg_ib_coupler_request(&map, START + DG_MS(100));
    assert_int_equal(get(0x2013), before + 100);
    put_out(0x0800, 7);
    assert_int_equal(dg_ring_master_next(&master), START + DG_MS(101));
    dg_ib_coupler_request(&map, START + DG_MS(103));
    assert_int_equal(get(0x0001), 0);
    dg_ib_coupler_request(&map, START + DG_MS(104)); /* three cycles later it is handled */
    assert_int_equal(get(0x0001), 0xC800);
    assert_int_equal(get(0x0002), 7);
    assert_int_equal(get(0x1014) | get(0x1015), 0);
}

static void identification(void **state)
{
    char text[21] = "";
    char expected[21] = "";
    (void)state;
    for (uint16_t i = 0; i < 10; i++) {
        dg_store_be16((uint8_t *)text + (size_t)2u * i, get((uint16_t)(0x1000 + i)));
    }
    (void)snprintf(expected, sizeof expected, "drehgeber IB %s", dg_version());
    assert_memory_equal(text, expected, 20);
    for (uint16_t i = 0; i < 2; i++) {
        assert_int_equal(get((uint16_t)(0x1012 + i)), 0);
    }
}

/* What other tests do not ask for. */
static void settings_and_missed_cycles(void **state)
{
    (void)state;
    master.missed = 0x12345;
    assert_int_equal(get(0x1014), 0x0001);
    assert_int_equal(get(0x1015), 0x2345);
    put_register(0x1120, 1234);
    assert_int_equal(get(0x1120), 1234);
    assert_int_equal(get(0x1122), 1);
    put_register(0x1122, 0);
    assert_int_equal(get(0x1122), 0);
    put_register(0x1123, DG_RING_FALLBACK_STOP);
    assert_int_equal(get(0x1123), DG_RING_FALLBACK_STOP);
}

/* A request that a host has not looked at first changes nothing. */
static void registers_that_are_not_there(void **state)
{
    static const struct dg_ib_registers ranges[] = {{0x100A, 1}, {0x100C, 1}, {0x1122, 3}};
    static const uint16_t values[] = {0, 0, 0};
    uint16_t value = 7;
    (void)state;
    for (size_t i = 0; i < DG_COUNT(ranges); i++) {
        assert_false(dg_ib_coupler_write(&map, ranges[i], values));
    }
    assert_int_equal(get(0x1122), 1);
    dg_ib_coupler_read(&map, (struct dg_ib_registers){0x100A, 1}, &value);
    assert_int_equal(value, 0);
}

static void registers_of_a_device(void **state)
{
    enum { SELF_TEST = 2, READ_OUT = 16, PARAMETERS_LOST = 64 };
    struct dg_ib *device = ring_rig_device(&rig, 1);
    (void)state;
    device->counters.cycles = 0x12345;
    device->counters.crc_errors = 0x56789;
    device->last_error = 0x84000077;
    assert_int_equal(get(0x2012), 0x0001);
    assert_int_equal(get(0x2013), 0x2345);
    assert_int_equal(get(0x2014), 0x0005);
    assert_int_equal(get(0x2015), 0x6789);
    assert_int_equal(get(0x201A), 0x8400);
    assert_int_equal(get(0x201B), 0x0077);
    assert_int_equal(get(0x2011) & (SELF_TEST | READ_OUT | PARAMETERS_LOST), 0);
    device->ready_at = START + 1;
    assert_int_equal(get(0x2011) & (SELF_TEST | READ_OUT | PARAMETERS_LOST), SELF_TEST);
    device->ready_at = START; /* the self-test is over */
    device->item = 1;
    assert_int_equal(get(0x2011) & (SELF_TEST | READ_OUT | PARAMETERS_LOST), READ_OUT);
    device->item = 0;
    device->lost = 1;
    assert_int_equal(get(0x2011) & (SELF_TEST | READ_OUT | PARAMETERS_LOST), PARAMETERS_LOST);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(existing_registers, set_up),
        cmocka_unit_test_setup(images_and_states, set_up),
        cmocka_unit_test_setup(watchdog_zero_and_freeze, set_up),
        cmocka_unit_test_setup(watchdog_stop, set_up),
        cmocka_unit_test_setup(the_map_in_words, set_up),
        cmocka_unit_test_setup(requests_and_cycles, set_up),
        cmocka_unit_test_setup(identification, set_up),
        cmocka_unit_test_setup(settings_and_missed_cycles, set_up),
        cmocka_unit_test_setup(registers_that_are_not_there, set_up),
        cmocka_unit_test_setup(registers_of_a_device, set_up),
    };
    return cmocka_run_group_tests_name("a ring's coupler", tests, NULL, NULL);
}

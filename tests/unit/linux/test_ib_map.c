/* SPDX-License-Identifier: MIT */
/* The coupler: memory of the ring, registers, whole words, watchdog. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "drehgeber/devices.h"
#include "modbus.h"
#include "modbus_rig.h"

#define START DG_S(1)

static const struct dg_device *models[3]; /* K1, K3, K2: words 0, 1-2, 3-4 */
static const char *steps;                 /* of all of them, less one; NULL: as delivered */
static struct modbus_rig rig;
static struct lx_ring *const ring = &rig.ring;
static struct lx_map map;
static struct lx_error error;
static char path[] = "/tmp/test_ib_map.XXXXXX";

/* All with one file. */
static int open_ring(const char *nvm, size_t count)
{
    modbus_rig_plan(&rig, models, count);
    for (size_t i = 0; i < count; i++) {
        rig.plan.encoders[i].nvm = nvm;
        modbus_rig_set(&rig, i, "self_test_ms=0");
        if (steps != NULL) {
            modbus_rig_set(&rig, i, steps);
            modbus_rig_set(&rig, i, "steps_minus_one=1");
        }
    }
    return modbus_rig_open(&rig, NULL, NULL, START, &error);
}

static int set_up(void **state)
{
    (void)state;
    models[0] = &dg_ocd_ib_k1;
    models[1] = &dg_ocd_ib_k3;
    models[2] = &dg_ocd_ib_k2;
    steps = NULL;
    memset(&error, 0, sizeof error);
    if (open_ring(NULL, 3) != 0) {
        return -1;
    }
    lx_map_init(&map, ring);
    lx_map_request(&map, START);
    (void)lx_ring_cycle(ring, START); /* the ID cycle */
    (void)lx_ring_cycle(ring, START);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    modbus_rig_close(&rig);
    return 0;
}

static uint16_t get(uint16_t address)
{
    uint16_t value = 0;

    assert_true(lx_map_readable(&map, (struct lx_range){address, 1}));
    lx_map_read(&map, (struct lx_range){address, 1}, &value);
    return value;
}

static void put(uint16_t address, uint16_t value)
{
    assert_true(lx_map_writable(&map, (struct lx_range){address, 1}));
    assert_true(lx_map_write(&map, (struct lx_range){address, 1}, &value));
}

static void put_out(uint16_t high, uint16_t low)
{
    const uint16_t words[] = {high, low};

    assert_true(lx_map_write(&map, (struct lx_range){0x0801, 2}, words));
}

static void existing_registers(void **state)
{
    static const struct {
        struct lx_range range;
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
        if (lx_map_readable(&map, ranges[i].range) != ranges[i].readable ||
            lx_map_writable(&map, ranges[i].range) != ranges[i].writable) {
            fail_msg("%04X, %u", (unsigned)ranges[i].range.first, (unsigned)ranges[i].range.count);
        }
    }
    map.tear = true;
    assert_true(lx_map_writable(&map, (struct lx_range){0x0802, 1}));
}

static void images_and_states(void **state)
{
    (void)state;
    assert_int_equal(get(0x1010), 80);
    assert_int_equal(get(0x1011), 80);
    assert_int_equal(get(0x100C), 1);
    put_out(0x0800, 0x0007);
    for (int i = 0; i < 4; i++) {
        (void)lx_ring_cycle(ring, START);
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
        (void)lx_ring_cycle(ring, START);
    }
    assert_int_equal(get(0x2011), 1 | 8 | 32);
    assert_int_equal(get(0x201A), 0x8400);
    for (size_t i = 0; i < 3; i++) {
        dg_host_world(ring->setup->stations[i]->host)->singleturn_ok = false;
    }
    (void)lx_ring_cycle(ring, START);
    assert_int_equal(get(0x100C), 1 | 4);
    assert_int_equal(get(0x2001), 1 | 128);
    dg_ring_cut(ring->bus, 1);
    (void)lx_ring_cycle(ring, START);
    assert_int_equal(get(0x100C) & 0xB, 2 | 8);
    assert_int_equal(get(0x2000), 0x0136);
    assert_int_equal(get(0x2010), 0);
}

/* The watchdog sleeps until OUT is written, and fires one tick after its time. */
static void watchdog_zero_and_freeze(void **state)
{
    (void)state;
    put(0x1120, 100);
    lx_map_tick(&map, START + DG_S(5));
    assert_int_equal(get(0x1121), 0);
    put_out(0x0800, 7);
    assert_int_equal(get(0x1020), 100);
    lx_map_tick(&map, START + DG_MS(100));
    assert_int_equal(get(0x1121), 0);
    lx_map_request(&map, START + DG_MS(60)); /* any request feeds it */
    assert_int_equal(get(0x1020), 100);
    lx_map_tick(&map, START + DG_MS(160));
    assert_int_equal(get(0x1121), 0);
    lx_map_tick(&map, START + DG_MS(160) + 1);
    assert_int_equal(get(0x1121), 1);
    assert_int_equal(get(0x1020), 0);
    assert_int_equal(get(0x0801), 0);
    put_out(0x0800, 8);
    assert_int_equal(get(0x1121), 0);

    put(0x1123, LX_FALLBACK_FREEZE);
    put(0x1122, 0);
    lx_map_request(&map, START + DG_MS(150)); /* only writes of OUT do now */
    lx_map_tick(&map, START + DG_MS(170));
    assert_int_equal(get(0x1121), 1);
    assert_int_equal(get(0x0802), 8);
    assert_false(ring->stopped);
}

static void watchdog_stop(void **state)
{
    const uint16_t bad = LX_FALLBACK_COUNT;

    (void)state;
    assert_false(lx_map_write(&map, (struct lx_range){0x1123, 1}, &bad));
    put(0x1120, 10);
    put(0x1123, LX_FALLBACK_STOP);
    put_out(0, 0);
    const uint16_t cycles = get(0x2013);
    lx_map_tick(&map, START + DG_MS(11));
    (void)lx_ring_cycle(ring, START + DG_MS(300));
    assert_int_equal(get(0x2013), cycles);
    assert_int_equal(get(0x100C), 0);
    lx_map_request(&map, START + DG_MS(300));
    assert_true((get(0x2016) & DG_IB_LED_BA_BLINKS) != 0);
    put(0x1121, 0xAFFE);
    put(0x1121, 0xBECF);
    assert_int_equal(get(0x1121), 1);
    put(0x1121, 0xAFFE);
    assert_int_equal(get(0x1121), 0);
    lx_map_tick(&map, START + DG_S(9)); /* asleep again */
    (void)lx_ring_cycle(ring, START + DG_S(9));
    assert_int_equal(get(0x2013), cycles + 1);
}

/* One file for the ring, an image for each K3. */
static void the_ring_has_one_file(void **state)
{
    const uint32_t image = dg_store_size(&dg_ib_layout);

    (void)state;
    modbus_rig_close(&rig);
    assert_int_equal(unlink(path), 0); /* only the name is wanted */
    assert_int_equal(open_ring(path, 3), 0);
    assert_int_equal(ring->store_count, 1);
    assert_int_equal(ring->stores[0].image.file.size, image);
    (void)lx_ring_cycle(ring, START);
    ring->out[1] = 0x0A00;
    ring->out[2] = 0x0055;
    for (int i = 0; i < 4; i++) {
        (void)lx_ring_cycle(ring, START);
    }
    modbus_rig_close(&rig);
    assert_int_equal(open_ring(path, 3), 0);
    assert_int_equal(lx_ring_device(ring, 1)->shift, 0x55);
    modbus_rig_close(&rig);

    models[0] = models[1]; /* two K3 find one image */
    assert_int_equal(open_ring(path, 2), -1);
    assert_non_null(strstr(lx_error_line(&error).text, path));
    modbus_rig_close(&rig);
    models[0] = models[2]; /* none finds a use for it */
    assert_int_equal(open_ring(path, 1), -1);
    assert_non_null(strstr(lx_error_line(&error).text, "nvm /"));
    modbus_rig_close(&rig);
    assert_int_equal(unlink(path), 0);
    steps = "steps=1";
    assert_int_equal(open_ring(NULL, 1), -1);
    assert_non_null(strstr(lx_error_line(&error).text, "factory"));
}

/* What `drehgeber map` prints of this ring: where a register is, what may be done with it. */
static const char *const printed[] = {
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

static void the_map_in_print(void **state)
{
    char *text = NULL;
    size_t size = 0;
    FILE *to = open_memstream(&text, &size);
    (void)state;
    assert_non_null(to);
    const struct dg_ib_model *figures[3];
    for (size_t i = 0; i < 3; i++) {
        figures[i] = dg_ib_model_of(models[i]);
    }
    lx_map_print(figures, 3, to);
    assert_int_equal(fclose(to), 0);
    char *rest = NULL;
    char *line = strtok_r(text, "\n", &rest); /* the heading */
    for (size_t i = 0; i < DG_COUNT(printed); i++) {
        line = strtok_r(NULL, "\n", &rest);
        assert_non_null(line);
        if (strncmp(line, printed[i], strlen(printed[i])) != 0) {
            fail_msg("\"%s\" for \"%s\"", line, printed[i]);
        }
    }
    assert_null(strtok_r(NULL, "\n", &rest));
    free(text);
}

static void addresses(void **state)
{
    static const char *const good[] = {"127.0.0.1:5020", "[::1]:0", "host:65535", "::1:502",
                                       "0.0.0.0:502,open"};
    static const char *const bad[] = {"",        ":",   "host", "host:",   ":502",
                                      "h:65536", "h:x", "[]:1", "h:1,bus", "h:1,bus,open"};

    (void)state;
    for (size_t i = 0; i < DG_COUNT(good); i++) {
        assert_int_equal(lx_modbus_check(good[i], &error), 0);
    }
    for (size_t i = 0; i < DG_COUNT(bad); i++) {
        assert_int_equal(lx_modbus_check(bad[i], &error), -1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(existing_registers, set_up, tear_down),
        cmocka_unit_test_setup_teardown(images_and_states, set_up, tear_down),
        cmocka_unit_test_setup_teardown(watchdog_zero_and_freeze, set_up, tear_down),
        cmocka_unit_test_setup_teardown(watchdog_stop, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_ring_has_one_file, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_map_in_print, set_up, tear_down),
        cmocka_unit_test(addresses),
    };
    const int file = mkstemp(path);
    if (file < 0) {
        return 1;
    }
    (void)close(file);
    const int failed = cmocka_run_group_tests_name("the INTERBUS coupler", tests, NULL, NULL);
    (void)unlink(path);
    return failed;
}

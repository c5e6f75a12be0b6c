/* SPDX-License-Identifier: MIT */
/* The memory of a ring, and the addresses of its coupler. */
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
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    modbus_rig_close(&rig);
    return 0;
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
    (void)dg_ring_master_cycle(&ring->master, START);
    ring->out[1] = 0x0A00;
    ring->out[2] = 0x0055;
    for (int i = 0; i < 4; i++) {
        (void)dg_ring_master_cycle(&ring->master, START);
    }
    modbus_rig_close(&rig);
    assert_int_equal(open_ring(path, 3), 0);
    assert_int_equal(((const struct dg_ib *)dg_bus_device(ring->bus, 1))->shift, 0x55);
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
        cmocka_unit_test_setup_teardown(the_ring_has_one_file, set_up, tear_down),
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

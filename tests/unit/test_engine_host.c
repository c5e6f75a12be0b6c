/* SPDX-License-Identifier: MIT */
/*
 * What a host with doors and rows of its own makes of an engine: wires that it refuses, rows in
 * place of an encoder's, EEPROMs that are its own, power one by one.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/host_wire.h"
#include "drehgeber/interbus.h"
#include "engine_rig.h"

#define BUS_OF "[bus vcan]\nwire = can\naddress = vcan0\n[encoder n]\nbus = vcan\nmodel = f3668\n"
#define NODES BUS_OF "node = 1..3\n"
#define CHAIN_OF "[bus c]\nwire = sim\n[encoder b]\nbus = c\nmodel = s3684-biss\n"

static struct engine_rig rig;
static struct dg_tap_event heard; /* the latest one */
static size_t heard_count;

static void hear_line(void *ctx, size_t place, const struct dg_tap_event *event)
{
    (void)ctx;
    (void)place;
    heard = *event;
    heard_count++;
}

static int open_door(void *ctx, size_t index, struct dg_engine_wire *to,
                     struct dg_plan_error *error)
{
    static const struct dg_bus_ops door = {.tx = hear_line};

    (void)ctx;
    (void)index;
    (void)error;
    to->ops = &door;
    return 0;
}

/* Before its encoders are looked at, and with what it is to be. */
static int refuse_slow(void *ctx, size_t index, struct dg_engine_wire *to,
                       struct dg_plan_error *error)
{
    (void)ctx;
    assert_int_equal(index, 0);
    assert_int_equal(to->line.timing.clock_hz, 50000);
    memset(error, 0, sizeof *error);
    (void)snprintf(error->what, sizeof error->what, "too slow");
    return -1;
}

static void the_host_may_refuse_a_wire(void **state)
{
    (void)state;
    engine_rig_read(&rig, "[bus c]\nwire = sim\nclock_hz = 50000\n[encoder b]\nbus = c\n"
                          "model = s3684-biss\nst = 0\n");
    rig.setup.wire = refuse_slow;
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_string_equal(rig.error.what, "too slow");
}

static void a_setting_that_the_wire_has_not_is_refused(void **state)
{
    static struct dg_plan_setting setting = {"tear", "1", 0};
    (void)state;
    engine_rig_read(&rig, BUS_OF);
    rig.plan.wires[0].settings = (struct dg_plan_settings){&setting, 1};
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_string_equal(rig.error.what, "the wire has no such key");
    assert_string_equal(rig.error.key, "tear");
}

/* A K1 has no turns; of a host that takes them, and leaves them, it has. */
static void *take_turns(void *ctx, size_t index, void *settings, struct dg_keys *rows)
{
    static struct dg_ib_model ignored;

    (void)ctx;
    (void)index;
    (void)settings;
    *rows = (struct dg_keys){dg_keys_find(&dg_ib_keys, "turns"), 1};
    return &ignored;
}

static void a_row_of_the_host_stands_where_the_encoders_is_missing(void **state)
{
    static const char k1[] = "[bus r]\nwire = modbus\n[encoder k]\nbus = r\nmodel = ocd-ib-k1\n"
                             "turns = 16\nnonsense = 1\n";
    (void)state;
    engine_rig_read(&rig, k1);
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_string_equal(rig.error.key, "turns");
    rig.setup.rows = take_turns;
    engine_rig_make(&rig);
    assert_null(rig.engine);
    assert_string_equal(rig.error.key, "nonsense");
    assert_non_null(strstr(rig.error.right, "valid: steps turns steps_minus_one"));
}

/* A file that a ring shares may be of one that has no EEPROM. */
static void which_encoders_have_an_eeprom_such_a_host_says(void **state)
{
    (void)state;
    engine_rig_read(&rig, CHAIN_OF
                    "[bus d]\nwire = sim\n[encoder s]\nbus = d\nmodel = ssi-25\nnvm = x\n");
    rig.setup.memory_is_host = true;
    engine_rig_make(&rig);
    assert_non_null(rig.engine);
}

static void encoders_may_get_their_power_one_by_one(void **state)
{
    (void)state;
    engine_rig_read(&rig, NODES);
    rig.setup.wire = open_door;
    engine_rig_make(&rig);
    assert_non_null(rig.engine);
    assert_int_equal(dg_engine_power_encoder(rig.engine, 1, DG_S(1), &rig.error), 0);
    for (size_t i = 0; i < rig.plan.encoder_count; i++) {
        assert_int_equal(dg_host_powered(dg_engine_encoder(rig.engine, i)), i == 1);
        assert_int_equal(dg_engine_control(rig.engine)->encoders[i]->device != NULL, i == 1);
    }
    (void)dg_bus_changed(dg_engine_bus(rig.engine, 0), 1, DG_S(1));
    (void)dg_engine_step(rig.engine, DG_S(2));
    assert_int_equal(heard_count, 1); /* its boot-up */
    assert_int_equal(heard.frame.id, 0x702);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_host_may_refuse_a_wire),
        cmocka_unit_test(a_setting_that_the_wire_has_not_is_refused),
        cmocka_unit_test(a_row_of_the_host_stands_where_the_encoders_is_missing),
        cmocka_unit_test(which_encoders_have_an_eeprom_such_a_host_says),
        cmocka_unit_test(encoders_may_get_their_power_one_by_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

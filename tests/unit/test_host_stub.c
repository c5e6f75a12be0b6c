/* SPDX-License-Identifier: MIT */
/*
 * A handle of a protocol of the test's own: what it does when a protocol misbehaves, and what it
 * leaves out when a protocol has no EEPROM, no settings of its own, no clock.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/host_wire.h"
#include "host_private.h"
#include "host_rig.h"
#include "ram_nvm.h"

/* ------------------------------------------------------------ the protocol */

struct model {
    int start; /* what `init` says */
    int power; /* what `power_on` says */
};

struct device {
    bool powered;
    unsigned steps;
    dg_ns asked; /* the moment of the last step */
};

DG_STACK_WITHOUT_MEMORY;

static bool senses_multiturn(const void *model)
{
    (void)model;
    return false;
}

static int format(const struct dg_stack_setup *setup)
{
    (void)setup;
    return DG_OK;
}

static const struct model *of_model;

static int init(void *self, const struct dg_stack_setup *setup)
{
    struct device *device = self;

    of_model = setup->model;
    *device = (struct device){.powered = false};
    return of_model->start;
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    (void)self;
    (void)setup;
}

static int power_on(void *self, dg_ns now)
{
    struct device *device = self;

    (void)now;
    device->powered = of_model->power == DG_OK;
    return of_model->power;
}

static void power_off(void *self)
{
    struct device *device = self;

    device->powered = false;
}

static bool powered(const void *self)
{
    const struct device *device = self;

    return device->powered;
}

/* It always asks for the present again. */
static dg_ns step(void *self, dg_ns now)
{
    struct device *device = self;

    device->steps++;
    device->asked = now;
    return now;
}

static const void *model(const void *self)
{
    (void)self;
    return of_model;
}

static uint64_t position(const void *self, dg_ns now)
{
    const struct device *device = self;

    return device->steps + now;
}

static const struct dg_stack stack = {
    .name = "stub", .device_size = sizeof(struct device), .mount = mount, DG_STACK_OPERATIONS};

static int check(const struct dg_host_event *event)
{
    (void)event;
    return DG_HOST_OK;
}

static bool take_event(struct dg_host_line *line, const struct dg_host_event *event)
{
    dg_host_emit(line, event);
    return true;
}

static const struct dg_keys no_keys;
static const struct dg_host_wire wire = {.stack = &stack,
                                         .keys = &no_keys,
                                         .settings_size = sizeof(struct model),
                                         .check = check,
                                         .take = take_event};
static struct model settings;
static const struct dg_device encoder = {"stub", "nothing", "none", &stack, &settings, 0};

static struct dg_host *make(int start, int power)
{
    settings = (struct model){.start = start, .power = power};
    memset(&host_rig_here, 0xA5, sizeof host_rig_here);
    struct dg_host *self = dg_host_init(&host_rig_here, sizeof host_rig_here, &encoder, &wire);
    assert_non_null(self);
    return self;
}

/* ------------------------------------------------------------ tests */

static void a_device_that_asks_for_the_present_does_not_stop_time(void **state)
{
    struct dg_host *self = make(DG_OK, DG_OK);
    uint64_t counts = 0;

    (void)state;
    assert_int_equal(dg_host_power(self, 1000, true), DG_HOST_OK);
    (void)dg_host_step(self, 1500); /* one by one */
    assert_int_equal(dg_host_position(self, 0, &counts), DG_HOST_OK);
    assert_in_range(counts, 500, 510);
    (void)dg_host_step(self, 1500);
    assert_int_equal(dg_host_position(self, 0, &counts), DG_HOST_OK);
    assert_in_range(counts, 500, 512);
}

static void what_init_or_power_say_is_told(void **state)
{
    struct dg_host *self = make(DG_ERR_ARGUMENT, DG_OK);

    (void)state;
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_ERR_ARGUMENT);
    assert_false(dg_host_powered(self));
    assert_int_equal(dg_host_step(self, READY), DG_HOST_NEVER); /* there is no device yet */
    self = make(DG_OK, DG_ERR_FOREIGN);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_ERR_FOREIGN);
    assert_false(dg_host_powered(self));
}

/* One without an EEPROM has an empty one: what does nothing is no error. */
static void an_encoder_without_an_eeprom_has_an_empty_one(void **state)
{
    static struct ram_nvm ram;
    struct dg_host *self = make(DG_OK, DG_OK);
    uint8_t byte = 0;

    (void)state;
    assert_int_equal(dg_host_memory_size(self), 0);
    assert_int_equal(dg_host_memory_copy(self, &byte, 0), DG_HOST_OK);
    assert_int_equal(dg_host_memory_load(self, &byte, 1), DG_HOST_ERR_SPACE);
    assert_int_equal(dg_host_memory_load(self, &byte, 0), DG_HOST_OK);
    ram_nvm_init(&ram, 64);
    const struct dg_nvm nvm = ram_nvm_port(&ram);
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_int_equal(ram.writes, 0);
    self = make(DG_OK, DG_OK);
    assert_int_equal(dg_host_memory_port(self, &nvm), DG_HOST_OK);
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK); /* as it comes, not loaded */
    assert_int_equal(ram.writes, 0);
}

/* The memory in a handle ends where its EEPROM does, as every struct dg_nvm. */
static void the_eeprom_of_a_handle_has_an_end(void **state)
{
    struct dg_host *self = host_rig_start(&host_rig_here, "s3684-biss");
    const struct dg_nvm nvm = dg_host_setup(self).nvm;
    const uint32_t size = self->memory_size;
    uint8_t bytes[4] = {1, 2, 3, 4};

    (void)state;
    assert_int_equal(nvm.ops->write(nvm.ctx, size - 4u, bytes, 4), DG_OK);
    assert_int_equal(nvm.ops->write(nvm.ctx, size - 3u, bytes, 4), DG_ERR_IO);
    assert_int_equal(nvm.ops->write(nvm.ctx, size + 1u, bytes, 1), DG_ERR_IO);
    memset(bytes, 0, sizeof bytes);
    assert_int_equal(nvm.ops->read(nvm.ctx, size - 4u, bytes, 4), DG_OK);
    assert_int_equal(bytes[3], 4);
    assert_int_equal(nvm.ops->read(nvm.ctx, size - 3u, bytes, 4), DG_ERR_IO);
    assert_int_equal(nvm.ops->read(nvm.ctx, UINT32_MAX, bytes, 4), DG_ERR_IO);
    assert_int_equal(bytes[0], 1); /* nothing was read */
}

static void a_panel_takes_no_instrument_of_another_protocol(void **state)
{
    static struct host_rig_place place;
    struct dg_host *self = make(DG_OK, DG_OK);

    (void)state;
    assert_int_equal(dg_host_power(self, 0, true), DG_HOST_OK);
    assert_null(dg_host_panel_make(&place, sizeof place, self));
    assert_null(dg_host_panel_init(&place, sizeof place, self, NULL));
}

/* A host has changed what the device senses: the device looks at once. */
static void another_shaft_is_looked_at(void **state)
{
    struct dg_host *self = make(DG_OK, DG_OK);
    struct dg_host *other = host_rig_start(&host_rig_there, "ssi-25");
    uint64_t before = 0;
    uint64_t after = 0;

    (void)state;
    assert_int_equal(dg_host_power(self, 1000, true), DG_HOST_OK);
    for (int on = 1; on >= 0; on--) {
        assert_int_equal(dg_host_position(self, 0, &before), DG_HOST_OK);
        assert_int_equal(dg_host_share(self, on != 0 ? other : NULL), DG_HOST_OK);
        assert_int_equal(dg_host_position(self, 0, &after), DG_HOST_OK);
        assert_int_equal(after, before + 1u);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_device_that_asks_for_the_present_does_not_stop_time),
        cmocka_unit_test(what_init_or_power_say_is_told),
        cmocka_unit_test(an_encoder_without_an_eeprom_has_an_empty_one),
        cmocka_unit_test(the_eeprom_of_a_handle_has_an_end),
        cmocka_unit_test(a_panel_takes_no_instrument_of_another_protocol),
        cmocka_unit_test(another_shaft_is_looked_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

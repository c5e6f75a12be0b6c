/* SPDX-License-Identifier: MIT */
/*
 * Each device on the memory of an earlier release, whose table was shorter: it starts, and its
 * memory is the one of a device delivered today. Cut to any length, as later releases will have it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "ram_nvm.h"

static struct ram_nvm ram;
static struct ram_nvm today; /* delivered by this release */
static struct dg_world world;

static dg_angle still(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return 0;
}

static void send_nothing(void *ctx, const uint8_t *bytes, size_t n)
{
    (void)ctx;
    (void)bytes;
    (void)n;
}

static void can_send_nothing(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    (void)frame;
}

/* --- one of each --- */

static int start_hiperface(const struct dg_device *device, struct dg_nvm nvm)
{
    static const struct dg_hf_ops ops = {.tx = send_nothing};
    static struct dg_hf self;
    const struct dg_hf_setup setup = {device->hiperface, &world, nvm, &ops, NULL};
    const int result = dg_hf_init(&self, &setup) == DG_OK ? dg_hf_power_on(&self, 0) : -100;
    return result == DG_OK && self.stack_count > 0 ? -100 : result; /* an error at start-up */
}

static int start_biss(const struct dg_device *device, struct dg_nvm nvm)
{
    static struct dg_biss self;
    const struct dg_biss_setup setup = {device->biss, &world, nvm};
    return dg_biss_init(&self, &setup) == DG_OK ? dg_biss_power_on(&self, 0) : -100;
}

static int start_canopen(const struct dg_device *device, struct dg_nvm nvm)
{
    static const struct dg_co_ops ops = {.send = can_send_nothing};
    static struct dg_co_node self;
    static struct dg_cia406 encoder;
    const struct dg_co_setup setup = {.device = device->cia406->device,
                                      .world = &world,
                                      .nvm = nvm,
                                      .ops = &ops,
                                      .application = &encoder};
    return dg_cia406_init(&encoder, device->cia406) == DG_OK && dg_co_init(&self, &setup) == DG_OK
               ? dg_co_power_on(&self, 0)
               : -100;
}

static int start_interbus(const struct dg_device *device, struct dg_nvm nvm)
{
    static struct dg_ib self;
    const struct dg_ib_setup setup = {device->interbus, &world, nvm};
    return dg_ib_init(&self, &setup) == DG_OK ? dg_ib_power_on(&self, 0) : -100;
}

static const struct dg_store_layout *layout_of(const struct dg_device *device)
{
    const struct dg_store_layout *const layouts[] = {
        [DG_STACK_HIPERFACE] = &dg_hf_layout,
        [DG_STACK_BISS] = &dg_biss_layout,
        [DG_STACK_CANOPEN] =
            device->stack == DG_STACK_CANOPEN ? device->cia406->device->layout : NULL,
        [DG_STACK_INTERBUS] = &dg_ib_layout,
    };
    return layouts[device->stack];
}

/* What the defaults of the device's regions are made from. */
static const void *ctx_of(const struct dg_device *device, const uint32_t *serial)
{
    const void *const ctx[] = {
        [DG_STACK_HIPERFACE] = device->hiperface,
        [DG_STACK_BISS] = NULL,
        [DG_STACK_CANOPEN] = serial,
        [DG_STACK_INTERBUS] = device->interbus,
    };
    return ctx[device->stack];
}

static int start(const struct dg_device *device)
{
    static int (*const starts[])(const struct dg_device *, struct dg_nvm) = {
        [DG_STACK_HIPERFACE] = start_hiperface,
        [DG_STACK_BISS] = start_biss,
        [DG_STACK_CANOPEN] = start_canopen,
        [DG_STACK_INTERBUS] = start_interbus,
    };
    return starts[device->stack](device, ram_nvm_port(&ram));
}

/* An encoder of each kind with a memory. */
static const char *const names[] = {"s3684-rs485", "s3684-biss", "f3668", "ocd-ib-k3"};

static void make(const struct dg_device *device, uint8_t count, struct ram_nvm *to)
{
    const uint32_t serial = 0x12345678;
    struct dg_store_layout older = *layout_of(device);
    older.region_count = count;
    ram_nvm_init(to, dg_store_size(layout_of(device)));
    assert_int_equal(dg_store_format(&older, ram_nvm_port(to), ctx_of(device, &serial)), DG_OK);
}

static void check(const struct dg_device *device, uint8_t count)
{
    make(device, count, &ram);
    assert_int_equal(start(device), DG_OK);
    assert_memory_equal(ram.bytes, today.bytes, today.size);
}

static void every_device_starts_on_an_image_of_an_earlier_release(void **state)
{
    (void)state;
    dg_world_init(&world);
    world.angle = still;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const struct dg_device *device = dg_device_find(names[i]);
        const uint8_t count = layout_of(device)->region_count;
        /* An image without a serial number cannot have kept it. */
        const uint8_t least = device->stack == DG_STACK_CANOPEN ? DG_CO_REGION_SERIAL + 1 : 1;
        make(device, count, &today);
        for (uint8_t older = least; older <= count; older++) {
            check(device, older);
        }
    }
}

/* A serial number that is lost is reported as damage is; what is new comes all the same. */
static void a_node_without_a_readable_serial_number_grows(void **state)
{
    const struct dg_device *device = dg_device_find("f3668");
    const struct dg_store_layout *layout = layout_of(device);
    struct dg_store store;
    (void)state;
    make(device, DG_CO_REGION_SERIAL + 1, &ram);
    ram.bytes[dg_store_address(layout, DG_CO_REGION_SERIAL)] ^= 1;
    assert_int_equal(start(device), DG_OK);
    assert_int_equal(dg_store_mount(&store, layout, ram_nvm_port(&ram)), DG_OK);
    assert_int_equal(store.damaged, 1u << DG_CO_REGION_SERIAL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_device_starts_on_an_image_of_an_earlier_release),
        cmocka_unit_test(a_node_without_a_readable_serial_number_grows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

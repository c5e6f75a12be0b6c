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
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"
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

/* The ports of those stacks that have one. */
static const void *port_of(const struct dg_stack *stack)
{
    static const struct dg_hf_ops hf = {.tx = send_nothing};
    static const struct dg_co_ops co = {.send = can_send_nothing};
    if (stack == &dg_hf_stack) {
        return &hf;
    }
    return stack == &dg_cia406_stack ? &co : NULL;
}

static const struct dg_store_layout *layout_of(const struct dg_device *device)
{
    return device->stack->layout(device->model);
}

/* What the defaults of the device's regions are made from. */
static const void *ctx_of(const struct dg_device *device, const uint32_t *serial)
{
    return device->stack == &dg_cia406_stack ? serial : device->model;
}

static int start_encoder(const struct dg_device *device)
{
    static union {
        max_align_t align;
        unsigned char bytes[sizeof(struct dg_cia406_device) + sizeof(struct dg_ib)];
    } self;
    const struct dg_stack *stack = device->stack;
    const struct dg_stack_setup setup = {
        .model = device->model, .world = &world, .nvm = ram_nvm_port(&ram), .port = port_of(stack)};
    assert_true(stack->device_size <= sizeof self);
    if (stack->init(&self, &setup) != DG_OK) {
        return -100;
    }
    const int result = stack->power_on(&self, 0);
    const struct dg_hf *hf = (const struct dg_hf *)(const void *)&self;
    /* An error at start-up. */
    return result == DG_OK && stack == &dg_hf_stack && hf->stack_count > 0 ? -100 : result;
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
    assert_int_equal(start_encoder(device), DG_OK);
    assert_memory_equal(ram.bytes, today.bytes, today.size);
}

static void every_device_starts_on_an_image_of_an_earlier_release(void **state)
{
    (void)state;
    dg_world_init(&world);
    world.angle = still;
    for (size_t i = 0; i < DG_COUNT(names); i++) {
        const struct dg_device *device = dg_device_find(names[i]);
        const uint8_t count = layout_of(device)->region_count;
        /* An image without a serial number cannot have kept it. */
        const uint8_t least = device->stack == &dg_cia406_stack ? DG_CO_REGION_SERIAL + 1 : 1;
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
    assert_int_equal(start_encoder(device), DG_OK);
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

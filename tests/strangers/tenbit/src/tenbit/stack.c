/* SPDX-License-Identifier: MIT */
/*
 * Words of ten bits behind the seam of all protocols.
 *
 *   clock  ¯¯|__|¯¯|__|¯¯ ... ¯|__|¯¯¯¯¯¯¯¯¯¯¯
 *   data   ¯¯¯¯¯|MSB  | ...       |LSB    |¯¯¯   the monoflop is over
 */
#include "drehgeber/tenbit.h"

DG_STACK_WITHOUT_MEMORY;

static bool senses_multiturn(const void *figures)
{
    (void)figures;
    return false;
}

static int format(const struct dg_stack_setup *setup)
{
    (void)setup;
    return DG_OK;
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct dg_tenbit *device = self;

    device->model = setup != NULL ? setup->model : NULL;
    device->world = setup != NULL ? setup->world : NULL;
}

static int init(void *self, const struct dg_stack_setup *setup)
{
    if (setup->model == NULL || setup->world == NULL || setup->world->angle == NULL) {
        return DG_ERR_ARGUMENT;
    }
    *(struct dg_tenbit *)self = (struct dg_tenbit){.deadline = DG_NEVER, .clock = true};
    attach(self, setup);
    return DG_OK;
}

static int power_on(void *self, dg_ns now)
{
    struct dg_tenbit *device = self;

    (void)now;
    device->powered = true;
    device->data = true;
    device->deadline = DG_NEVER;
    return DG_OK;
}

static void power_off(void *self)
{
    struct dg_tenbit *device = self;

    device->powered = false;
    device->data = false;
    device->deadline = DG_NEVER;
}

static bool powered(const void *self)
{
    return ((const struct dg_tenbit *)self)->powered;
}

static dg_ns step(void *self, dg_ns now)
{
    struct dg_tenbit *device = self;

    if (device->deadline <= now && device->deadline != DG_NEVER) {
        device->deadline = DG_NEVER;
        device->data = true;
    }
    return device->stuck ? now : device->deadline;
}

static const void *model(const void *self)
{
    return ((const struct dg_tenbit *)self)->model;
}

static uint32_t word_at(const struct dg_tenbit *self, dg_ns now)
{
    const uint64_t angle = (uint64_t)dg_world_angle(self->world, now);

    return (uint32_t)(angle >> (32u - DG_TENBIT_BITS)) & DG_TENBIT_ALL;
}

static uint64_t position(const void *self, dg_ns now)
{
    return powered(self) ? word_at(self, now) : 0;
}

static void shift(struct dg_tenbit *self)
{
    if (self->left == 0) {
        self->data = false;
        self->left = DG_TENBIT_BITS;
        return;
    }
    self->left--;
    self->data = (self->word >> self->left & 1u) != 0;
}

bool dg_tenbit_clock(struct dg_tenbit *self, dg_ns now, bool level)
{
    (void)step(self, now);
    if (self->powered && level != self->clock && !level) {
        if (self->deadline == DG_NEVER) {
            self->word = word_at(self, now);
            self->left = DG_TENBIT_BITS;
            self->frames++;
        }
        self->deadline = dg_after(now, DG_TENBIT_MONOFLOP);
    } else if (self->powered && level != self->clock) {
        shift(self);
    }
    self->clock = level;
    return self->data;
}

const struct dg_stack dg_tenbit_stack = {
    .name = "tenbit",
    .medium = DG_MEDIUM_EDGES,
    .device_size = sizeof(struct dg_tenbit),
    .mount = mount,
    DG_STACK_OPERATIONS,
};

/* --- states that somebody has made --- */

static const struct dg_stack_range ranges[] = {
    DG_STACK_RANGE(dg_tenbit, left, 0, DG_TENBIT_BITS),
    DG_STACK_BOOL(dg_tenbit, powered),
    DG_STACK_BOOL(dg_tenbit, clock),
    DG_STACK_BOOL(dg_tenbit, data),
    DG_STACK_BOOL(dg_tenbit, stuck),
};

static bool fits(const void *own, const void *settings, const void *device)
{
    (void)own;
    (void)settings;
    (void)device;
    return true;
}

const struct dg_stack_check dg_tenbit_state = {ranges, DG_COUNT(ranges), fits};

/* SPDX-License-Identifier: MIT */
#include "plain_encoder.h"

#include "drehgeber/key.h"
#include "drehgeber/world.h"

static unsigned word_at(const struct plain *self, dg_ns now)
{
    const uint64_t angle = (uint64_t)self->world->angle(self->world->angle_ctx, now);

    return (unsigned)(angle >> (32u - PLAIN_BITS)) & PLAIN_ALL;
}

/* --- the stack --- */

static const struct dg_store_layout *layout(const void *model)
{
    (void)model;
    return NULL;
}

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

static int mount(const struct dg_stack_setup *setup, struct dg_store *store)
{
    (void)setup;
    (void)store;
    return DG_ERR_ARGUMENT;
}

static int init(void *self, const struct dg_stack_setup *setup)
{
    *(struct plain *)self = (struct plain){
        .model = setup->model, .world = setup->world, .deadline = DG_NEVER, .clock = true};
    return DG_OK;
}

static void attach(void *self, const struct dg_stack_setup *setup)
{
    struct plain *device = self;

    device->model = setup != NULL ? setup->model : NULL;
    device->world = setup != NULL ? setup->world : NULL;
}

static int power_on(void *self, dg_ns now)
{
    struct plain *device = self;

    (void)now;
    device->powered = true;
    device->data = true;
    device->deadline = DG_NEVER;
    return DG_OK;
}

static void power_off(void *self)
{
    struct plain *device = self;

    device->powered = false;
    device->data = false;
    device->deadline = DG_NEVER;
}

static bool powered(const void *self)
{
    return ((const struct plain *)self)->powered;
}

static dg_ns step(void *self, dg_ns now)
{
    struct plain *device = self;

    if (device->deadline <= now && device->deadline != DG_NEVER) {
        device->deadline = DG_NEVER;
        device->data = true;
    }
    return device->stuck ? now : device->deadline;
}

static const void *model(const void *self)
{
    return ((const struct plain *)self)->model;
}

static uint64_t position(const void *self, dg_ns now)
{
    return powered(self) ? word_at(self, now) : 0;
}

static const struct dg_stack stack = {
    .name = "plain",
    .medium = DG_MEDIUM_EDGES,
    .device_size = sizeof(struct plain),
    .mount = mount,
    DG_STACK_OPERATIONS,
};

/* --- behind a handle --- */

static bool level(const struct dg_host_line *line)
{
    return ((const struct plain *)line->device)->data;
}

/* Whoever clocks on gets the word again, behind a 0. */
static void shift(struct plain *self)
{
    if (self->left == 0) {
        self->data = false;
        self->left = PLAIN_BITS;
        return;
    }
    self->left--;
    self->data = (self->word >> self->left & 1u) != 0;
}

static bool set_clock(struct dg_host_line *line, dg_ns now, bool high)
{
    struct plain *self = line->device;

    (void)step(self, now);
    if (self->powered && high != self->clock && !high) {
        if (self->deadline == DG_NEVER) {
            self->word = word_at(self, now);
            self->left = PLAIN_BITS;
            self->frames++;
            line->latched = now;
        }
        self->deadline = now + PLAIN_MONOFLOP;
    } else if (self->powered && high != self->clock) {
        shift(self);
    }
    self->clock = high;
    return self->data;
}

static uint64_t latched(const struct dg_host_line *line)
{
    return ((const struct plain *)line->device)->word;
}

static const struct dg_keys keys = {NULL, 0};

const struct dg_host_wire plain_wire = {
    .stack = &stack,
    .keys = &keys,
    .settings_size = sizeof(struct plain_model),
    .level = level,
    .clock = set_clock,
    .latched = latched,
};

static const struct plain_model low = {.open = false};
static const struct plain_model high = {.open = true};

const struct dg_device plain_low = {"plain-low", "plain", "1024 steps", &stack, &low};
const struct dg_device plain_high = {"plain-high", "plain", "1024 steps", &stack, &high};

/* --- as an instrument --- */

static const char *mode(const void *device, dg_ns now)
{
    (void)now;
    return powered(device) ? "normal" : "off";
}

static void state(const void *device, dg_ns now, struct dg_scpi *to)
{
    (void)device;
    (void)now;
    (void)to;
}

static void line_frame(const void *self, struct dg_line_frame *to)
{
    to->bits = PLAIN_BITS;
    to->open = ((const struct plain *)self)->model->open;
}

static bool clock_of(const void *self)
{
    return ((const struct plain *)self)->clock;
}

static const struct dg_fault_row faults[] = {
    {"wire_drop", DG_FAULT_ON_WIRE(DROP), 0, "a test", "a test", "-"},
    {"wire_delay", DG_FAULT_ON_WIRE(DELAY), (int64_t)DG_US(3), "a test", "a test", "-"},
    {"wire_damage", DG_FAULT_ON_WIRE(DAMAGE), 0, "a test", "a test", "-"},
    {"wire_break", DG_FAULT_ON_WIRE(BREAK), 0, "a test", "a test", "-"},
};

const struct dg_instrument plain_instrument = {
    .stack = &stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .mode = mode,
    .state = state,
    .line_frame = line_frame,
    .clock = clock_of,
};

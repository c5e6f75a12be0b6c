/* SPDX-License-Identifier: MIT */
/* An image: the encoder DEVICE with its INSTRUMENT, on the port that is linked. */
#include <string.h>

#include "board.h"
#include "console.h"
#include "drehgeber/drehgeber.h"
#include "drehgeber/instruments.h"
#include "flash_log.h"
#include "port.h"

#define DEVICE_MAX 2048u

static _Alignas(max_align_t) unsigned char memory[DEVICE_MAX];
void *const port_device = memory;

static struct dg_shaft port_shaft;
static struct dg_world world;

void port_turn(const struct dg_world *to, const struct dg_shaft *turning)
{
    board_lock();
    world = *to;
    world.angle = dg_shaft_angle;
    world.angle_ctx = &port_shaft;
    port_shaft = *turning;
    port_changed();
    board_unlock();
}

/* A flash that has nothing yet, or another model's, becomes this model's. */
static void power_on_device(const struct dg_stack_setup *setup)
{
    const struct dg_stack *stack = DEVICE.stack;
    int result = stack->power_on(memory, board_now());

    if (result == DG_ERR_BLANK || result == DG_ERR_FOREIGN) {
        (void)stack->format(setup);
        result = stack->power_on(memory, board_now());
    }
    (void)result; /* an encoder that does not start is silent, and the console says so */
}

int main(void)
{
    const struct dg_stack_setup setup = {.model = DEVICE.model,
                                         .world = &world,
                                         .nvm = flash_log_open(DEVICE.stack->layout(DEVICE.model)),
                                         .port = port_ops};

    board_start();
    dg_world_init(&world);
    dg_shaft_init(&port_shaft);
    world.angle = dg_shaft_angle;
    world.angle_ctx = &port_shaft;
    if (DEVICE.stack->device_size > sizeof memory || DEVICE.stack->init(memory, &setup) != DG_OK) {
        return 1;
    }
    power_on_device(&setup);
    console_start(&DEVICE, &INSTRUMENT, setup.nvm);
    port_start();
    for (;;) {
        const dg_ns due = dg_earliest(port_loop(), console_loop());
        board_sleep(dg_earliest(due, flash_log_loop(port_idle(), port_pause())));
    }
}

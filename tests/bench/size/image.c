/* SPDX-License-Identifier: MIT */
/* The least that has an encoder: DEVICE, named alone. What is linked with it is what it costs. */
#include "drehgeber/drehgeber.h"

/* So that nothing is known when it is compiled. */
extern struct dg_world image_world;
extern struct dg_nvm image_nvm;
extern const void *image_port;
extern unsigned char image_device[];

int main(void)
{
    const struct dg_stack *stack = DEVICE.stack;
    const struct dg_stack_setup setup = {.model = DEVICE.model,
                                         .world = &image_world,
                                         .nvm = image_nvm,
                                         .serial = 1,
                                         .port = image_port};

    dg_world_init(&image_world);
    if (stack->format(&setup) != DG_OK || stack->init(image_device, &setup) != DG_OK ||
        stack->power_on(image_device, 0) != DG_OK) {
        return 1;
    }
    return stack->step(image_device, DG_S(1)) != 0;
}

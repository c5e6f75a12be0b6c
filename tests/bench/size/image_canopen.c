/* SPDX-License-Identifier: MIT */
/* A CANopen node as firmware has it: a mailbox, a memory, a clock, and the device between them. */
#include "board.h"
#include "canopen_device.h"

static struct dg_co_node node;

static void send_frame(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    board_tx = *frame;
}

int main(void)
{
    static const struct dg_co_ops ops = {.send = send_frame};
    const struct dg_co_setup setup = {.device = device,
                                      .world = &board_world,
                                      .nvm = board_nvm,
                                      .ops = &ops,
                                      .application = device_start()};

    dg_world_init(&board_world);
    if (dg_co_init(&node, &setup) != DG_OK) {
        return 1;
    }
    while (dg_co_power_on(&node, board_now) != DG_OK) {
        (void)dg_co_format(device, board_nvm, 1);
    }
    for (;;) {
        const struct dg_can_frame frame = board_rx;
        (void)(board_received ? dg_co_rx(&node, board_now, &frame) : dg_co_step(&node, board_now));
    }
}

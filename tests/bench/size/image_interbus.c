/* SPDX-License-Identifier: MIT */
/* The OCD INTERBUS K3 as firmware has it: words of the protocol chip, a memory, a clock, the
 * device. */
#include "board.h"
#include "drehgeber/interbus.h"

static struct dg_ib device;

int main(void)
{
    const struct dg_ib_setup setup = {
        .model = dg_ocd_ib_k3.model, .world = &board_world, .nvm = board_nvm};
    uint32_t in = 0;

    dg_world_init(&board_world);
    if (dg_ib_init(&device, &setup) != DG_OK) {
        return 1;
    }
    while (dg_ib_power_on(&device, board_now) != DG_OK) {
        (void)dg_ib_format(setup.model, board_nvm);
    }
    board_out = dg_ib_id(&device, board_now);
    for (;;) {
        if (board_received) {
            dg_ib_cycle(&device, board_now, board_in, &in);
            board_out = in;
        }
    }
}

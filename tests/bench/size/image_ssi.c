/* SPDX-License-Identifier: MIT */
/* An SSI encoder as firmware has it: the lines of clock and data, a clock, and the device. */
#include "board.h"
#include "drehgeber/ssi.h"

static struct dg_ssi device;

int main(void)
{
    const struct dg_ssi_setup setup = {.model = dg_ssi_25.model, .world = &board_world};

    dg_world_init(&board_world);
    if (dg_ssi_init(&device, &setup) != DG_OK) {
        return 1;
    }
    dg_ssi_power_on(&device, board_now);
    for (;;) {
        if (board_received) {
            board_out = dg_ssi_clock(&device, board_now, board_in != 0);
        }
        (void)dg_ssi_step(&device, board_now);
    }
}

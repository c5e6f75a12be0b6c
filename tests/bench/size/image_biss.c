/* SPDX-License-Identifier: MIT */
/* The S3684 with BiSS as firmware has it: the lines MA and SLO, a memory, a clock, and the device.
 */
#include "board.h"
#include "drehgeber/biss.h"

static struct dg_biss device;

int main(void)
{
    const struct dg_biss_setup setup = {
        .model = dg_s3684_biss.model, .world = &board_world, .nvm = board_nvm};

    dg_world_init(&board_world);
    if (dg_biss_init(&device, &setup) != DG_OK) {
        return 1;
    }
    while (dg_biss_power_on(&device, board_now) != DG_OK) {
        (void)dg_biss_format(board_nvm);
    }
    for (;;) {
        if (board_received) {
            board_out = dg_biss_ma(&device, board_now, board_in != 0);
        }
        (void)dg_biss_step(&device, board_now);
    }
}

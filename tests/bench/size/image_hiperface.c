/* SPDX-License-Identifier: MIT */
/* The S3684 with RS485 as firmware has it: a UART, a memory, a clock, and the device between them.
 */
#include "board.h"
#include "drehgeber/hiperface.h"

static struct dg_hf device;

static void tx(void *ctx, const uint8_t *bytes, size_t n)
{
    (void)ctx;
    for (size_t i = 0; i < n; i++) {
        board_out = bytes[i];
    }
}

int main(void)
{
    static const struct dg_hf_ops ops = {.tx = tx};
    const struct dg_hf_setup setup = {
        .model = dg_s3684_rs485.model, .world = &board_world, .nvm = board_nvm, .ops = &ops};

    dg_world_init(&board_world);
    if (dg_hf_init(&device, &setup) != DG_OK) {
        return 1;
    }
    while (dg_hf_power_on(&device, board_now) != DG_OK) {
        (void)dg_hf_format(setup.model, board_nvm);
    }
    for (;;) {
        (void)(board_received ? dg_hf_rx(&device, board_now, (uint8_t)board_in, DG_HF_RX_OK)
                              : dg_hf_step(&device, board_now));
    }
}

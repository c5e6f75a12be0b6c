/* SPDX-License-Identifier: MIT */
#include "board.h"

#include "drehgeber/host.h"

volatile dg_ns board_now;
volatile bool board_received;
volatile uint32_t board_in, board_out;
volatile struct dg_can_frame board_rx, board_tx;
struct dg_nvm board_nvm;
struct dg_world board_world;
unsigned char board_device[BOARD_DEVICE_MAX];
_Alignas(DG_HOST_ALIGN) unsigned char board_handle[BOARD_HANDLE_MAX];
struct dg_encoder board_encoder;
struct dg_rig_shaft board_shaft;
struct dg_control board_control;
const struct dg_rig_ops board_ops = {0};

void board_write(void *ctx, const char *bytes, size_t n)
{
    (void)ctx;
    for (size_t i = 0; i < n; i++) {
        board_out = (uint32_t)bytes[i];
    }
}

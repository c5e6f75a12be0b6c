/* SPDX-License-Identifier: MIT */
/* The same with a control plane on a UART: DEVICE on a shaft, INSTRUMENT, one session. */
#include "board.h"
#include "drehgeber/drehgeber.h"
#include "drehgeber/instruments.h"

int main(void)
{
    static const struct dg_instrument *const instruments[] = {&INSTRUMENT};
    struct dg_encoder *encoders[] = {&board_encoder};
    struct dg_rig_shaft *shafts[] = {&board_shaft};
    struct dg_rig rig = {.encoders = encoders,
                         .encoder_count = 1,
                         .shafts = shafts,
                         .shaft_count = 1,
                         .instruments = instruments,
                         .instrument_count = 1,
                         .ops = &board_ops};

    dg_shaft_init(&board_shaft.shaft);
    board_encoder = (struct dg_encoder){.name = "e",
                                        .model = &DEVICE,
                                        .instrument = &INSTRUMENT,
                                        .device = board_device,
                                        .world = &board_world,
                                        .shaft = &board_shaft,
                                        .nvm = board_nvm};
    dg_control_init(&board_control, &rig, board_write, NULL);
    return dg_control_rx(&board_control, 0, "*IDN?\n", 6) != 6;
}

/* SPDX-License-Identifier: MIT */
/* The same with a control plane on a UART: DEVICE on a shaft, INSTRUMENT, one session. */
#include "drehgeber/control.h"
#include "drehgeber/drehgeber.h"
#include "drehgeber/instruments.h"

extern struct dg_world image_world;
extern struct dg_nvm image_nvm;
extern unsigned char image_device[];
extern struct dg_encoder image_encoder;
extern struct dg_rig_shaft image_shaft;
extern struct dg_control image_control;
extern const struct dg_rig_ops image_ops;
void image_write(void *ctx, const char *bytes, size_t n);

int main(void)
{
    static const struct dg_instrument *const instruments[] = {&INSTRUMENT};
    struct dg_encoder *encoders[] = {&image_encoder};
    struct dg_rig_shaft *shafts[] = {&image_shaft};
    struct dg_rig rig = {.encoders = encoders,
                         .encoder_count = 1,
                         .shafts = shafts,
                         .shaft_count = 1,
                         .instruments = instruments,
                         .instrument_count = 1,
                         .ops = &image_ops};

    dg_shaft_init(&image_shaft.shaft);
    image_encoder = (struct dg_encoder){.name = "e",
                                        .model = &DEVICE,
                                        .instrument = &INSTRUMENT,
                                        .device = image_device,
                                        .world = &image_world,
                                        .shaft = &image_shaft,
                                        .nvm = image_nvm};
    dg_control_init(&image_control, &rig, image_write, NULL);
    return dg_control_rx(&image_control, 0, "*IDN?\n", 6) != 6;
}

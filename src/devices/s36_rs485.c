/* SPDX-License-Identifier: MIT */
/*
 * S36 RS485 + SinCos. Identities are examples; the command line changes them.
 */
#include "drehgeber/devices.h"
#include "drehgeber/hiperface.h"

/* What both S36 share: manual 3.1, 5.1.1.2.2, 5.1.4; channels 49h and 4Ah and limits are chosen. */
#define S36_RS485                                                                                  \
    .periods_per_turn = 2048, .steps_per_period = 32, .option_code = 0x00, .memory_blocks = 0x70,  \
    .serial = "123456789", .version = "v1.0.8", .date = "12072019", .temperature_channel = 0x48,   \
    .led_channel = 0x49, .vector_channel = 0x4A, .temperature_min_degc = -40,                      \
    .temperature_max_degc = 120, .led_min_ma = 1, .led_max_ma = 30, .vector_min = 600,             \
    .vector_max = 1400, .speed_max_rpm = 12000, .acceleration_max_krad_s2 = 500,                   \
    .reaction = DG_MS(1), .init = DG_MS(100)

static const struct dg_hf_model s3674_rs485 = {
    S36_RS485,
    .turns = 1,
    .type_code = 0x22,
    .designation = "S3674 RS485+SinCos",
};

static const struct dg_hf_model s3684_rs485 = {
    S36_RS485,
    .turns = 4096,
    .type_code = 0x27,
    .designation = "S3684 RS485+SinCos",
};

/* clang-format off */
const struct dg_device dg_s3674_rs485 = {"s3674-rs485", "RS485 + SinCos (HIPERFACE-compatible)", "2048 periods x 32 steps, singleturn", &dg_hf_stack, &s3674_rs485, 0};
const struct dg_device dg_s3684_rs485 = {"s3684-rs485", "RS485 + SinCos (HIPERFACE-compatible)", "2048 periods x 32 steps, 4096 turns", &dg_hf_stack, &s3684_rs485, 0};
/* clang-format on */

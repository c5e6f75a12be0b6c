/* SPDX-License-Identifier: MIT */
#include "sincos.h"

#include "board.h"
#include "rp2040.h"

#define PIN_SIN 10u
#define PIN_COS 11u
#define SLICE 5u /* of both */
#define STEPS 1024u
#define TURNING_NS DG_US(50)
#define RESTING_NS DG_MS(1)
#define MIDDLE ((int32_t)STEPS / 2)
#define NOMINAL_UV 500000 /* between + and - */
#define NOMINAL_STEPS ((int32_t)STEPS * 2 / 5)

static uint32_t pwm_level_of(int32_t plus_uv, int32_t minus_uv)
{
    const int32_t level = MIDDLE + (plus_uv - minus_uv) / (NOMINAL_UV / NOMINAL_STEPS);

    return level < 0 ? 0 : level > (int32_t)STEPS ? STEPS : (uint32_t)level;
}

void sincos_start(void)
{
    board_pin(PIN_SIN, BOARD_PWM);
    board_pin(PIN_COS, BOARD_PWM);
    REG(PWM_TOP(SLICE)) = STEPS - 1u;
    REG(PWM_CC(SLICE)) = 0;
    REG(PWM_CSR(SLICE)) = 1u;
}

dg_ns sincos_follow(const struct dg_hf *device, dg_ns now)
{
    struct dg_hf_sincos is;

    dg_hf_sincos(device, now, &is);
    const uint32_t levels = pwm_level_of(is.cos_plus_uv, is.cos_minus_uv) << 16 |
                            pwm_level_of(is.sin_plus_uv, is.sin_minus_uv);
    if (levels == REG(PWM_CC(SLICE))) {
        return now + RESTING_NS;
    }
    REG(PWM_CC(SLICE)) = levels;
    return now + TURNING_NS;
}

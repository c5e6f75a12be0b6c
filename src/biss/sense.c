/* SPDX-License-Identifier: MIT */
/*
 * What the encoder senses: position (5.2.2.1, 5.2.2.2) and error register (5.2.3), and when: at the
 * latch (5.2.1.2).
 */
#include "biss_private.h"

/* Of an angle below whole turns. */
#define TURN_BITS 32u
#define LIFE_MAX 63u

/* OFFS_MT:OFFS_ST as an angle: OFFS_ST is left-aligned in 26 bits, and below these as a turn is in
 * an angle. */
static uint64_t offset_angle(const struct dg_biss *self)
{
    const uint8_t *config = self->config;
    const uint32_t st = (uint32_t)config[3] << 24 | (uint32_t)config[2] << 16 |
                        (uint32_t)config[1] << 8 | (config[0] & 0xC0u);
    const uint32_t mt = (uint32_t)config[6] << 16 | (uint32_t)config[5] << 8 | config[4];

    return (uint64_t)mt << TURN_BITS | st;
}

/* What is below a count is dropped from both, before one of them is subtracted. As many turns are
 * left as MT has bits for: an angle has more. */
uint64_t dg_biss_position(const struct dg_biss *self, dg_ns now)
{
    const struct dg_biss_model *model = self->setup.model;
    const uint32_t below = TURN_BITS - model->singleturn_bits;
    const uint32_t above = TURN_BITS - model->multiturn_bits;
    const uint64_t counted = ~(uint64_t)((UINT32_C(1) << below) - 1u);
    const uint64_t angle = (uint64_t)dg_world_angle(self->setup.world, now);
    const uint64_t position = (angle & counted) - (offset_angle(self) & counted);
    const bool reverse = (self->config[BISS_DIR] & BISS_DIR_BIT) != 0;

    return (reverse ? 0u - position : position) << above >> (above + below);
}

static const struct dg_signal_limits limits = {
    .amplitude_min_permille = DG_BISS_AMPLITUDE_MIN_PERMILLE,
    .amplitude_max_permille = DG_BISS_AMPLITUDE_MAX_PERMILLE,
    .offset_max_permille = DG_BISS_OFFSET_MAX_PERMILLE,
};

static bool temperature_ok(const struct dg_biss *self)
{
    const int32_t mdegc = self->setup.world->temperature_mdegc;
    const uint8_t monitored = self->config[BISS_EMASK] | self->config[BISS_WMASK];

    return (monitored & DG_BISS_TEMPERATURE) == 0 ||
           (mdegc >= DG_BISS_TEMPERATURE_MIN_MDEGC && mdegc <= DG_BISS_TEMPERATURE_MAX_MDEGC);
}

uint8_t dg_biss_errors(const struct dg_biss *self, dg_ns now)
{
    const struct dg_world *world = self->setup.world;
    const bool memory_ok =
        dg_biss_eeprom(self) && self->store.damaged == 0 && now >= self->checked_at;
    uint32_t errors = 0;

    errors |= world->led_current_ua <= DG_BISS_LED_MAX_UA ? 0u : DG_BISS_CONTROL;
    errors |= dg_world_signals_ok(world, &limits) ? 0u : DG_BISS_SIGNAL;
    errors |= temperature_ok(self) ? 0u : DG_BISS_TEMPERATURE;
    errors |= world->multiturn_sync_ok ? 0u : DG_BISS_SYNC;
    errors |= memory_ok ? 0u : DG_BISS_CONFIGURATION;
    errors |= world->singleturn_ok ? 0u : DG_BISS_INTERPOLATION;
    errors |= world->multiturn_amplitude_ok && world->multiturn_vector_ok ? 0u : DG_BISS_ABSOLUTE;
    errors |= world->watchdog_fired ? DG_BISS_SYSTEM : 0u;
    return (uint8_t)errors;
}

bool dg_biss_initialising(const struct dg_biss *self, dg_ns now)
{
    return now < self->ready_at;
}

uint8_t dg_biss_flags(const struct dg_biss *self, dg_ns now)
{
    const uint8_t errors = dg_biss_errors(self, now);
    const bool n_err = !self->simulated && (errors & self->config[BISS_EMASK]) == 0;
    const bool n_warn = (errors & self->config[BISS_WMASK]) == 0;

    return dg_biss_initialising(self, now) ? 0 : (uint8_t)((uint32_t)n_err << 1 | n_warn);
}

/* 0 only in the first frame after the start. */
static void count_life(struct dg_biss *self)
{
    if (self->started) {
        self->life = self->life == LIFE_MAX ? 1 : (uint8_t)(self->life + 1u);
    }
    self->started = true;
}

uint8_t dg_biss_latch(struct dg_biss *self, dg_ns now, uint64_t *bits)
{
    count_life(self);
    self->counters.frames++;
    self->position = dg_biss_initialising(self, now) ? 0 : dg_biss_position(self, now);
    if (self->channel_off) {
        *bits = 0;
        return 0;
    }
    return dg_biss_frame_encode(self, dg_biss_flags(self, now), bits);
}

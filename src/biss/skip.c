/* SPDX-License-Identifier: MIT */
/*
 * Frames that nobody looks at: what they would leave behind, however many, at once.
 */
#include "biss_private.h"

#define LIFE_MAX 63u
/* The generator of latch() in line.c. */
#define NOISE_FACTOR 1664525u
#define NOISE_STEP 1013904223u

/* x -> factor x + step, `n` times: doubled from bit to bit of n. */
static uint32_t noise_after(uint32_t noise, uint64_t n)
{
    uint32_t factor = NOISE_FACTOR;
    uint32_t step = NOISE_STEP;

    for (; n > 0; n >>= 1) {
        if ((n & 1u) != 0) {
            noise = noise * factor + step;
        }
        step = step * factor + step;
        factor *= factor;
    }
    return noise;
}

/* 0 is only in the first frame of all. */
static uint8_t life_after(uint8_t life, uint64_t n)
{
    return n == 0 ? life : (uint8_t)((life + n - 1u) % LIFE_MAX + 1u);
}

void dg_biss_skip(struct dg_biss *self, uint64_t n)
{
    if (self->line.state == DG_BISS_OFF || n == 0) {
        return;
    }
    self->life = life_after(self->life, self->started ? n : n - 1u);
    self->started = true;
    self->counters.frames += (uint32_t)n;
    self->noise = noise_after(self->noise, n);
    /* So many zeros end whatever the control automaton was at. */
    for (uint64_t i = 0; i < n && i < DG_BISS_ZEROS; i++) {
        dg_biss_cdm(self, self->line.last, false);
    }
}

/* SPDX-License-Identifier: MIT */
/*
 * Position and process channel: 42h, 43h, 6Ah (5.1.2.1, 5.1.2.2, 5.1.2.19) and the sine and cosine
 * signals (4.1.3).
 */
#include "hiperface_private.h"

/* The figure of 4.1.3: each line 2.5 V +- 0.25 V, +-0.5 V between the lines of a signal. */
#define SINCOS_PEAK_UV 500000
#define SINCOS_DC_UV 2500000

static uint32_t counts_per_turn(const struct dg_hf *self)
{
    return self->periods * self->steps;
}

static uint64_t range(const struct dg_hf *self)
{
    return (uint64_t)counts_per_turn(self) * self->turns;
}

/* Position without the offset: modulo the steps of a period it is the phase of the sine. */
static uint32_t raw_position(const struct dg_hf *self, dg_angle angle)
{
    return (uint32_t)dg_mod(dg_angle_counts(angle, counts_per_turn(self)), range(self));
}

/* a + b modulo the measuring range; both are inside it. */
static uint32_t add_in_range(const struct dg_hf *self, uint32_t a, uint32_t b)
{
    uint64_t sum = (uint64_t)a + b;

    return (uint32_t)(sum >= range(self) ? sum - range(self) : sum);
}

static uint32_t negate_position(const struct dg_hf *self, uint32_t a)
{
    return a == 0 ? 0 : (uint32_t)(range(self) - a);
}

uint32_t dg_hf_position(const struct dg_hf *self, dg_ns now)
{
    return add_in_range(self, raw_position(self, dg_world_angle(self->setup.world, now)),
                        self->offset);
}

/* Bit n: position fault 1Dh + n (5.1.2.1). 1Eh is a warning. */
static unsigned causes(const struct dg_hf *self, bool fast)
{
    const struct dg_world *world = self->setup.world;
    unsigned present = world->led_current_ua > self->led_max_ma * 1000u;

    present |= (unsigned)fast << (DG_HF_SPEED - DG_HF_LED_CURRENT);
    present |= (unsigned)!world->singleturn_ok << (DG_HF_SINGLETURN - DG_HF_LED_CURRENT);
    if (self->turns > 1) {
        present |= (unsigned)!world->multiturn_amplitude_ok
                   << (DG_HF_MULTITURN_AMPLITUDE - DG_HF_LED_CURRENT);
        present |= (unsigned)!world->multiturn_sync_ok
                   << (DG_HF_MULTITURN_SYNC - DG_HF_LED_CURRENT);
        present |= (unsigned)!world->multiturn_vector_ok
                   << (DG_HF_MULTITURN_VECTOR - DG_HF_LED_CURRENT);
    }
    return present;
}

/* The first fault is the answer, the others wait in the error stack (5.1.3 'Position').
   @param present as causes() has it */
static enum dg_hf_status faults(struct dg_hf *self, unsigned present)
{
    enum dg_hf_status first = DG_HF_NO_ERROR;
    unsigned status = DG_HF_LED_CURRENT;

    for (; present != 0; present >>= 1) {
        if ((present & 1u) != 0 && first == DG_HF_NO_ERROR) {
            first = (enum dg_hf_status)status;
        } else if ((present & 1u) != 0) {
            dg_hf_push(self, (enum dg_hf_status)status);
        }
        status++;
    }
    return first;
}

enum dg_hf_status dg_hf_read_position(struct dg_hf *self, struct hf_request *rq)
{
    const int32_t limit = self->speed_max_rpm * 1000;
    dg_angle angle;
    const int32_t mrpm = dg_world_moving(self->setup.world, rq->now, &angle);
    const enum dg_hf_status status = faults(self, causes(self, mrpm > limit || mrpm < -limit));

    dg_write_be32(&rq->reply, add_in_range(self, raw_position(self, angle), self->offset));
    return status;
}

static enum dg_hf_status store_offset(struct dg_hf *self, uint32_t offset)
{
    uint8_t bytes[4];

    dg_store_be32(bytes, offset);
    enum dg_hf_status status = dg_hf_put(self, DG_HF_REGION_OFFSET, bytes);
    if (status == DG_HF_NO_ERROR) {
        self->offset = offset;
    }
    return status;
}

/* Common to 43h and 6Ah: the offset that makes the position at `now` the preset. */
static enum dg_hf_status wanted_offset(struct dg_hf *self, const struct hf_request *rq,
                                       uint32_t *offset)
{
    uint32_t preset = dg_load_be32(rq->data);

    if (preset >= range(self)) {
        return DG_HF_ARGUMENT;
    }
    *offset = add_in_range(
        self, preset,
        negate_position(self, raw_position(self, dg_world_angle(self->setup.world, rq->now))));
    return faults(self, causes(self, false));
}

enum dg_hf_status dg_hf_set_position(struct dg_hf *self, struct hf_request *rq)
{
    uint32_t offset = 0;
    enum dg_hf_status status = wanted_offset(self, rq, &offset);

    return status == DG_HF_NO_ERROR ? store_offset(self, offset) : status;
}

enum dg_hf_status dg_hf_set_synchronous(struct dg_hf *self, struct hf_request *rq)
{
    uint32_t offset = 0;
    enum dg_hf_status status = wanted_offset(self, rq, &offset);

    if (status != DG_HF_NO_ERROR) {
        return status;
    }
    /* To whole periods, to the nearest, ties up (R18); the range is a whole number of periods. */
    uint64_t periods = ((uint64_t)offset + self->steps / 2u) / self->steps;
    offset = (uint32_t)(periods * self->steps % range(self));
    dg_write_be32(
        &rq->reply,
        add_in_range(self, raw_position(self, dg_world_angle(self->setup.world, rq->now)), offset));
    return store_offset(self, offset);
}

/* One signal: half of the differential voltage on either line. */
static int32_t half_uv(int32_t sine_q30, uint16_t amplitude_permille, int16_t offset_permille)
{
    int64_t peak_uv = (int64_t)SINCOS_PEAK_UV * amplitude_permille / 1000;
    int64_t offset_uv = (int64_t)SINCOS_PEAK_UV * offset_permille / 1000;

    return (int32_t)((peak_uv * sine_q30 / (1 << 30) + offset_uv) / 2);
}

void dg_hf_sincos(const struct dg_hf *self, dg_ns now, struct dg_hf_sincos *out)
{
    const struct dg_world *world = self->setup.world;
    /* Whole turns are whole periods: the lower half of the angle alone has the phase. */
    uint32_t phase = (uint32_t)(uint64_t)dg_world_angle(world, now) * self->periods;
    int32_t sin_uv =
        half_uv(dg_sin_q30(phase), world->sin_amplitude_permille, world->sin_offset_permille);
    int32_t cos_uv = half_uv(dg_sin_q30(phase + (1u << 30)), world->cos_amplitude_permille,
                             world->cos_offset_permille);

    out->sin_plus_uv = SINCOS_DC_UV + sin_uv;
    out->sin_minus_uv = SINCOS_DC_UV - sin_uv;
    out->cos_plus_uv = SINCOS_DC_UV + cos_uv;
    out->cos_minus_uv = SINCOS_DC_UV - cos_uv;
}

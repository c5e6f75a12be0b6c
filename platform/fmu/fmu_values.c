/* SPDX-License-Identifier: MIT */
/*
 * Variables by their numbers.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "encoder.h"

static struct fmu_value real(double value)
{
    return (struct fmu_value){.type = FMU_REAL, .real = value};
}

static struct fmu_value integer(uint64_t value, enum fmu_type type)
{
    return (struct fmu_value){.type = type, .real = (double)value, .integer = (int64_t)value};
}

static int get_turn(const struct fmu_turn *turn, uint32_t reference, struct fmu_value *to)
{
    *to = real((reference & 0xFFu) == FMU_ANGLE ? turn->angle : turn->speed);
    return DG_HOST_OK;
}

static int get_input(const struct fmu_encoder *encoder, uint32_t index, struct fmu_value *to)
{
    if (index != FMU_POWER) {
        return DG_HOST_ERR_NAME;
    }
    *to = integer(encoder->now.power, FMU_BOOL);
    return DG_HOST_OK;
}

/* Without power there is none, and nothing on the line: 0. */
static uint64_t encoder_position_of(const struct fmu *self, const struct fmu_encoder *encoder)
{
    uint64_t counts = 0;
    (void)dg_host_position(encoder->host, self->now, &counts);
    return counts;
}

static double volts(const struct fmu *self, const struct fmu_encoder *encoder, uint32_t index)
{
    int32_t uv[4] = {0};
    (void)dg_host_sincos(encoder->host, self->now, uv);
    return uv[index - FMU_SIN_PLUS] * 1e-6;
}

/* What the encoder has told last. */
static struct fmu_value told(const struct fmu_course *now, enum fmu_output output)
{
    const struct dg_host_frame *frame = &now->frame;
    const struct {
        enum fmu_type type;
        uint64_t value;
    } rows[FMU_OUTPUT_COUNT] = {
        [FMU_FRAME] = {FMU_INT, frame->bits},
        [FMU_FRAME_BITS] = {FMU_INT, frame->count},
        [FMU_FRAME_POSITION] = {FMU_INT, frame->position},
        [FMU_FRAME_GOOD] = {FMU_BOOL, frame->good},
        [FMU_NERR] = {FMU_BOOL, frame->error == 0},
        [FMU_NWARN] = {FMU_BOOL, frame->warning == 0},
        [FMU_ERROR_CODE] = {FMU_INT, now->error & 0xFFFFu},
        [FMU_ERROR_REGISTER] = {FMU_INT, now->error >> 16},
        [FMU_BUS_STATE] = {FMU_INT, now->bus},
    };
    return integer(rows[output].value, rows[output].type);
}

static int get_output(struct fmu *self, struct fmu_encoder *encoder, uint32_t index,
                      struct fmu_value *to)
{
    if (index >= FMU_FRAME) {
        fmu_latch_unread(self);
    }
    fmu_settle(self);
    fmu_latch(self);
    if (index >= FMU_OUTPUT_COUNT) {
        return DG_HOST_ERR_NAME;
    }
    if (index == FMU_POSITION) {
        *to = integer(encoder_position_of(self, encoder), FMU_INT);
    } else if (index <= FMU_COS_MINUS) {
        *to = real(volts(self, encoder, index));
    } else {
        *to = told(&encoder->now, (enum fmu_output)index);
    }
    return DG_HOST_OK;
}

/* Settings and the world are texts to the encoder. */
static int get_key(const struct fmu_encoder *encoder, uint32_t index, struct fmu_value *to)
{
    struct dg_host_key key;
    *to = (struct fmu_value){.type = FMU_TEXT};
    if (dg_host_key(encoder->host, index, &key) != DG_HOST_OK ||
        dg_host_get(encoder->host, key.name, to->text, sizeof to->text) < 0) {
        return DG_HOST_ERR_NAME;
    }
    to->real = strtod(to->text, NULL);
    to->integer = strtoll(to->text, NULL, 10);
    return DG_HOST_OK;
}

int fmu_get(struct fmu *self, uint32_t reference, struct fmu_value *to)
{
    const uint32_t index = reference & 0xFFu;
    const enum fmu_group group = (enum fmu_group)(reference >> 8 & 0xFFu);
    struct fmu_encoder *encoder = fmu_encoder_of(self, reference, group);
    const struct fmu_shaft *shaft = fmu_shaft_of(self, reference);
    if (shaft != NULL) {
        return get_turn(&shaft->now, reference, to);
    }
    if (encoder == NULL) {
        return DG_HOST_ERR_NAME;
    }
    switch (group) {
    case FMU_TIME:
        *to = real(self->start + (double)self->now * 1e-9);
        return DG_HOST_OK;
    case FMU_INPUT:
        return get_input(encoder, index, to);
    case FMU_PARAMETER:
    case FMU_WORLD:
        return get_key(encoder, index, to);
    case FMU_FAULT:
        *to = integer(index < 128u && (encoder->now.faults[index / 64u] >> index % 64u & 1u) != 0,
                      FMU_BOOL);
        return DG_HOST_OK;
    case FMU_OUTPUT:
        return get_output(self, encoder, index, to);
    case FMU_BUS:
        break;
    }
    return DG_HOST_ERR_NAME;
}

/* Numbers are all alike, as FMI 2 has no integers of 64 bits. */
static bool fits_variable(const struct fmu_value *value, enum fmu_type type)
{
    const enum fmu_type given = value->type == FMU_INT ? FMU_REAL : value->type;
    return given == (type == FMU_INT ? FMU_REAL : type);
}

static int set_power(struct fmu *self, struct fmu_encoder *encoder, bool on)
{
    const bool changes = on != encoder->now.power;
    encoder->now.power = on;
    if (!changes || !self->started) {
        return DG_HOST_OK;
    }
    const int result = self->ops->power(encoder, on);
    const bool counts = on && (encoder->has & FMU_HAS_FRAMES) != 0 && !encoder->shares;
    return counts && result == DG_HOST_OK ? wire_reset(encoder, self->now) : result;
}

static int set_turn(struct fmu_turn *turn, uint32_t reference, const struct fmu_value *value)
{
    if (!fits_variable(value, FMU_REAL) || !fmu_is_small(value->real, 1e300)) {
        return DG_HOST_ERR_ARGUMENT;
    }
    if ((reference & 0xFFu) == FMU_ANGLE) {
        turn->angle = value->real;
        turn->angle_new = true;
    } else {
        /* What it turned until now, it turned with the other one. */
        turn->speed_new = turn->speed_new || value->real != turn->speed;
        turn->speed = value->real;
    }
    return DG_HOST_OK;
}

static int set_input(struct fmu *self, struct fmu_encoder *encoder, uint32_t index,
                     const struct fmu_value *value)
{
    if (index != FMU_POWER) {
        return DG_HOST_ERR_NAME;
    }
    return fits_variable(value, FMU_BOOL) ? set_power(self, encoder, value->integer != 0)
                                          : DG_HOST_ERR_ARGUMENT;
}

static int set_world(struct fmu_encoder *encoder, const struct dg_host_key *key,
                     const struct fmu_value *value)
{
    double scaled = value->real;
    for (unsigned i = 0; i < key->places; i++) {
        scaled *= 10;
    }
    if (!fmu_is_small(scaled, 9e15)) {
        return DG_HOST_ERR_ARGUMENT;
    }
    return encoder->all->ops->sense(encoder, key->name, fmu_nearest(scaled));
}

static int set_key(struct fmu_encoder *encoder, uint32_t index, const struct fmu_value *value)
{
    struct dg_host_key key;
    char text[FMU_NAME_MAX];
    if (dg_host_key(encoder->host, index, &key) != DG_HOST_OK) {
        return DG_HOST_ERR_NAME;
    }
    if (!fits_variable(value, fmu_key_type(encoder->host, &key))) {
        return DG_HOST_ERR_ARGUMENT;
    }
    if (key.always) {
        return set_world(encoder, &key, value);
    }
    if (value->type == FMU_TEXT) {
        return dg_host_set(encoder->host, key.name, value->text);
    }
    if (value->type == FMU_REAL) {
        (void)snprintf(text, sizeof text, "%.*f", key.places, value->real);
    } else {
        (void)snprintf(text, sizeof text, "%lld", (long long)value->integer);
    }
    return dg_host_set(encoder->host, key.name, text);
}

int encoder_begin_fault(struct fmu_encoder *encoder, uint32_t index)
{
    const bool on = (encoder->now.faults[index / 64u] >> index % 64u & 1u) != 0;
    return on ? encoder->all->ops->fault(encoder, index, true) : DG_HOST_OK;
}

/* Before power those that are set wait for it. */
int encoder_set_fault(struct fmu_encoder *encoder, uint32_t index, bool on)
{
    if (index >= FMU_FAULTS_MAX) {
        return DG_HOST_ERR_NAME;
    }
    uint64_t *bits = &encoder->now.faults[index / 64u];
    const uint64_t bit = UINT64_C(1) << index % 64u;
    if (on == ((*bits & bit) != 0)) {
        return DG_HOST_OK;
    }
    const int result =
        encoder->all->started ? encoder->all->ops->fault(encoder, index, on) : DG_HOST_OK;
    if (result == DG_HOST_OK || !on) {
        *bits ^= bit;
    }
    return on ? result : DG_HOST_OK; /* what has happened at once is over already */
}

int fmu_set(struct fmu *self, uint32_t reference, const struct fmu_value *value)
{
    const uint32_t index = reference & 0xFFu;
    const enum fmu_group group = (enum fmu_group)(reference >> 8 & 0xFFu);
    struct fmu_encoder *encoder = fmu_encoder_of(self, reference, group);
    struct fmu_shaft *shaft = fmu_shaft_of(self, reference);
    if (shaft != NULL) {
        return set_turn(&shaft->now, reference, value); /* it begins later, with fmu_settle() */
    }
    if (encoder == NULL) {
        return DG_HOST_ERR_NAME;
    }
    fmu_latch_unread(self);
    switch (group) {
    case FMU_INPUT:
        return set_input(self, encoder, index, value);
    case FMU_PARAMETER:
    case FMU_WORLD:
        fmu_settle(self);
        return set_key(encoder, index, value);
    case FMU_FAULT:
        if (!fits_variable(value, FMU_BOOL)) {
            return DG_HOST_ERR_ARGUMENT;
        }
        fmu_settle(self);
        return encoder_set_fault(encoder, index, value->integer != 0);
    case FMU_TIME:
    case FMU_OUTPUT:
    case FMU_BUS:
        break;
    }
    return DG_HOST_ERR_NAME;
}

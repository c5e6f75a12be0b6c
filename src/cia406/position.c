/* SPDX-License-Identifier: MIT */
/*
 * Position: scaling, preset, code sequence, working areas, and the universal scaling function
 * (chapters 20-23, 26; C20, C21, C26).
 *
 * Without USF:  6004h = (floor(raw * MUR / 65536) + offset) mod TMR
 *
 * With USF the position is kept in 1/65536 unit, y = x * MUR, which is whole for every whole x:
 *
 *   y = (zero_y + d * MUR) mod (TMR * 65536),  6004h = floor(y / 65536)
 *
 * where d is the way from the internal zero to the raw position the short way round. Nothing is
 * ever rounded, so moving the zero (to where the shaft is, with the y it has there) changes
 * nothing that can be seen, however often it happens. The old zero and the new one describe the
 * same line: it does not matter which of them a power cut leaves in the memory.
 */
#include "cia406_private.h"

#include "drehgeber/bits.h"
#include "drehgeber/crc.h"

#define RAW_CRC_SEED 0xFFFFu
#define USF_STORED 1u
#define USF_STORED_CCW 2u
#define USF_SIZE 21u

/* A range of 2^32 is 0 in 32 bits; all that is modulo a range works for it, too. No 64 bits are
 * divided: where the machine cannot, that is a routine of its own. */
static uint32_t wrap_value(uint32_t value, uint32_t range)
{
    return range != 0 ? value % range : value;
}

/* `a` + `b` and `a` - `b` modulo `range`; both are inside it. */
static uint32_t add_modulo(uint32_t a, uint32_t b, uint32_t range)
{
    return a >= range - b ? a - (range - b) : a + b;
}

static uint32_t subtract_modulo(uint32_t a, uint32_t b, uint32_t range)
{
    return a >= b ? a - b : a - b + range;
}

/* The highest raw position; the range is a power of two. */
static uint32_t last_raw(const struct dg_co_node *node)
{
    return encoder_of(node)->model->turns * DG_CIA406_STEPS - 1u;
}

static uint32_t mur(const struct dg_co_node *node)
{
    return parameter(node, DG_CIA406_SCALING) ? node->value[SLOT_MUR] : DG_CIA406_STEPS;
}

/* FFFFFFFFh stands for 2^32 where the physical range is that long. */
static uint32_t as_range(const struct dg_co_node *node, uint32_t tmr)
{
    return tmr == 0xFFFFFFFFu ? last_raw(node) + 1u : tmr;
}

static uint32_t tmr(const struct dg_co_node *node)
{
    return parameter(node, DG_CIA406_SCALING) ? as_range(node, node->value[SLOT_TMR])
                                              : last_raw(node) + 1u;
}

int64_t dg_cia406_counts(const struct dg_co_node *node, dg_ns at)
{
    return dg_angle_counts(dg_world_angle(node->setup.world, at), DG_CIA406_STEPS);
}

/* As dg_cia406_counts(), modulo the range: a count is 2^16 of the 2^32 that a turn has. */
static void sample_raw(struct dg_co_node *node)
{
    uint64_t angle = (uint64_t)dg_world_angle(node->setup.world, node->now);

    encoder_of(node)->raw = (uint32_t)(angle >> 16) & last_raw(node);
}

/* Ascending as the code sequence says. */
static uint32_t in_sequence(const struct dg_co_node *node)
{
    uint32_t raw = encoder_of(node)->raw;

    return parameter(node, DG_CIA406_CCW) ? 0u - raw : raw;
}

/* Scaled, before preset and USF. */
static uint32_t scale_raw(const struct dg_co_node *node)
{
    uint64_t raw = in_sequence(node) & last_raw(node);

    return wrap_value((uint32_t)(raw * mur(node) / DG_CIA406_STEPS), tmr(node));
}

/* The short way from the internal zero, at most half the range. */
struct way {
    uint32_t counts;
    bool back;
};

static struct way from_zero(const struct dg_co_node *node)
{
    const struct dg_cia406 *self = encoder_of(node);
    uint32_t forward = (self->raw - self->zero) & last_raw(node);
    bool back = forward > last_raw(node) / 2u;

    return (struct way){back ? last_raw(node) + 1u - forward : forward, back};
}

static uint64_t usf_y(const struct dg_co_node *node)
{
    uint64_t zero_y = encoder_of(node)->zero_y;
    uint32_t range = tmr(node);
    struct way way = from_zero(node);
    uint64_t far = (uint64_t)way.counts * mur(node);
    uint32_t whole = wrap_value((uint32_t)(far / DG_CIA406_STEPS), range);
    uint32_t y = (uint32_t)(zero_y / DG_CIA406_STEPS);
    uint32_t part;

    if (way.back != parameter(node, DG_CIA406_CCW)) {
        part = (uint32_t)(zero_y % DG_CIA406_STEPS) - (uint32_t)(far % DG_CIA406_STEPS);
        y = subtract_modulo(y, whole, range);
        y = part >= DG_CIA406_STEPS ? subtract_modulo(y, 1, range) : y;
    } else {
        part = (uint32_t)(zero_y % DG_CIA406_STEPS) + (uint32_t)(far % DG_CIA406_STEPS);
        y = add_modulo(y, whole, range);
        y = part >= DG_CIA406_STEPS ? add_modulo(y, 1, range) : y;
    }
    return (uint64_t)y * DG_CIA406_STEPS + part % DG_CIA406_STEPS;
}

/* Unscaled the range is a power of two. */
static uint32_t scaled_position_of(const struct dg_co_node *node)
{
    if (!parameter(node, DG_CIA406_USF | DG_CIA406_SCALING)) {
        return (in_sequence(node) + node->value[SLOT_OFFSET]) & last_raw(node);
    }
    if (parameter(node, DG_CIA406_USF)) {
        return (uint32_t)(usf_y(node) / DG_CIA406_STEPS);
    }
    return add_modulo(scale_raw(node), wrap_value(node->value[SLOT_OFFSET], tmr(node)), tmr(node));
}

/* In 1/65536 unit: only USF knows parts of units. */
static uint64_t position_y(const struct dg_co_node *node)
{
    return parameter(node, DG_CIA406_USF) ? usf_y(node)
                                          : (uint64_t)scaled_position_of(node) * DG_CIA406_STEPS;
}

/* Bits 0-2 of area 1, 3-5 of area 2: outside, above, below. Crossed limits: never inside. */
static uint8_t areas(const struct dg_co_node *node, uint32_t at)
{
    uint8_t bits = 0;

    for (uint8_t i = 0; i < 2; i++) {
        bool above = at > node->value[SLOT_HIGH + i];
        bool below = at < node->value[SLOT_LOW + i];
        unsigned state = (above || below ? 1u : 0u) | (above ? 2u : 0u) | (below ? 4u : 0u);
        bits |= (uint8_t)(state << (3u * i));
    }
    return bits;
}

void dg_cia406_sample(struct dg_co_node *node)
{
    sample_raw(node);
    node->value[SLOT_POSITION] = scaled_position_of(node);
}

uint32_t dg_cia406_position(const struct dg_co_node *node, dg_ns now)
{
    /* A sample belongs to the bus: this one is a copy's. */
    struct dg_cia406 encoder = *encoder_of(node);
    struct dg_co_node at = *node;

    at.now = now;
    at.setup.application = &encoder;
    at.setup.device->sample(&at);
    return at.value[SLOT_POSITION];
}

/* The mark of a good record: which way the position ascends is part of the line it describes. */
static uint8_t usf_mark(const struct dg_co_node *node)
{
    return parameter(node, DG_CIA406_CCW) ? USF_STORED_CCW : USF_STORED;
}

/* Keep the internal zero: {mark or 0, zero, y, MUR, TMR}, all or nothing. A lost one stays lost. */
static bool store_zero(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);
    bool wanted = parameter(node, DG_CIA406_USF) && !self->usf_lost;
    uint8_t bytes[USF_SIZE] = {wanted ? usf_mark(node) : 0};

    dg_store_le32(&bytes[1], self->zero);
    dg_store_le32(&bytes[5], (uint32_t)self->zero_y);
    dg_store_le32(&bytes[9], (uint32_t)(self->zero_y >> 32));
    dg_store_le32(&bytes[13], node->value[SLOT_MUR]);
    dg_store_le32(&bytes[17], node->value[SLOT_TMR]);
    self->zero_unsaved = !node->setup.world->eeprom_acknowledges || !node->mounted ||
                         dg_store_put(&node->store, REGION_USF, 0, bytes, sizeof bytes) != DG_OK;
    return !self->zero_unsaved;
}

/* The internal zero comes to where the shaft is; the position there is `y`. What cannot be stored
 * is 5100h until it can. */
static bool move_zero(struct dg_co_node *node, uint64_t y)
{
    static const uint8_t none[5];
    struct dg_cia406 *self = encoder_of(node);

    self->zero = self->raw;
    self->zero_y = y;
    if (store_zero(node)) {
        self->flash_until = dg_cia406_in_ms(node, FLASH_MS);
        return true;
    }
    dg_co_raise(node, DG_CO_CAUSE_MEMORY, none);
    return false;
}

void dg_cia406_watch_zero(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);

    if (!parameter(node, DG_CIA406_USF)) {
        if (self->zero_unsaved) {
            (void)store_zero(node);
        }
        return;
    }
    sample_raw(node);
    uint32_t quarter = last_raw(node) / 4u + 1u;
    struct way way = from_zero(node);
    bool safe = way.counts < (way.back ? quarter / 2u : quarter);
    if ((safe && !self->zero_unsaved) || !move_zero(node, usf_y(node))) {
        return;
    }
    uint8_t details[5] = {0};
    dg_store_le32(details, self->zero);
    dg_co_raise(node, CAUSE_USF_MOVED, details);
    dg_co_clear(node, CAUSE_USF_MOVED);
}

void dg_cia406_restore_zero(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);
    uint8_t bytes[USF_SIZE] = {0};
    bool good = node->mounted && !self->zero_unsaved &&
                !dg_store_damaged(&node->store, REGION_USF) &&
                dg_store_read(&node->store, REGION_USF, 0, bytes, sizeof bytes) == DG_OK;

    const uint64_t y = (uint64_t)dg_load_le32(&bytes[9]) << 32 | dg_load_le32(&bytes[5]);
    good = good && bytes[0] == usf_mark(node) && y / DG_CIA406_STEPS <= tmr(node) - 1u &&
           dg_load_le32(&bytes[13]) == node->value[SLOT_MUR] &&
           dg_load_le32(&bytes[17]) == node->value[SLOT_TMR];
    self->usf_lost = parameter(node, DG_CIA406_USF) && !good;
    sample_raw(node);
    self->zero = good ? dg_load_le32(&bytes[1]) : self->raw;
    self->zero_y = good ? y : 0;
    self->zero_unsaved = false;
}

/* What 6000h-6002h may be together (chapters 22 and 26, C26). */
static enum dg_co_abort check_scaling(const struct dg_co_node *node, const uint32_t *wanted)
{
    uint32_t parameters = wanted[0];
    uint64_t turns = encoder_of(node)->model->turns;
    uint64_t range = (uint64_t)(as_range(node, wanted[2]) - 1u) + 1u;
    bool usf = (parameters & DG_CIA406_USF) != 0;

    if ((parameters & ~(uint32_t)DG_CIA406_WRITABLE) != 0) {
        return DG_CO_RANGE;
    }
    if (usf && (parameters & DG_CIA406_SCALING) == 0) {
        return DG_CO_INCOMPATIBLE;
    }
    if (usf && 4 * range >= turns * wanted[1]) {
        return DG_CO_INCOMPATIBLE;
    }
    return DG_CO_OK;
}

/* Without USF nobody follows the shaft: should the power fail before 6000h is saved, the zero in
 * the memory must not be taken for a good one. */
static void forget_zero(struct dg_co_node *node)
{
    uint8_t stored = 0;

    encoder_of(node)->usf_lost = false;
    if (node->mounted &&
        (dg_store_read(&node->store, REGION_USF, 0, &stored, 1) != DG_OK || stored != 0)) {
        (void)store_zero(node);
    }
}

/* 6000h, 6001h, 6002h: the position carries on from the value it shows, as far as that fits. */
enum dg_co_abort dg_cia406_hook_scaling(struct dg_co_node *node, const struct dg_co_object *object,
                                        enum dg_co_op op, uint32_t *value)
{
    uint32_t wanted[3] = {node->value[SLOT_PARAMETERS], node->value[SLOT_MUR],
                          node->value[SLOT_TMR]};

    if (op == DG_CO_WRITE) {
        wanted[object->slot - SLOT_PARAMETERS] = *value;
        sample_raw(node);
        encoder_of(node)->y = position_y(node);
        return check_scaling(node, wanted);
    }
    if (op == DG_CO_WRITTEN) {
        uint64_t y = encoder_of(node)->y;
        node->value[SLOT_OFFSET] = wrap_value(node->value[SLOT_OFFSET], tmr(node));
        if (parameter(node, DG_CIA406_USF)) {
            uint64_t whole = wrap_value((uint32_t)(y / DG_CIA406_STEPS), tmr(node));
            (void)move_zero(node, whole * DG_CIA406_STEPS + y % DG_CIA406_STEPS);
            encoder_of(node)->calm_ms = 0;
            encoder_of(node)->look_at = node->now; /* from now on at the pace of USF */
        } else {
            forget_zero(node);
        }
    }
    return DG_CO_OK;
}

/* 6003h: the position becomes the preset at once. */
enum dg_co_abort dg_cia406_hook_preset(struct dg_co_node *node, const struct dg_co_object *object,
                                       enum dg_co_op op, uint32_t *value)
{
    struct dg_cia406 *self = encoder_of(node);

    (void)object;
    if (op != DG_CO_WRITE) {
        return DG_CO_OK;
    }
    if (*value > tmr(node) - 1u) {
        return DG_CO_RANGE;
    }
    sample_raw(node);
    if (parameter(node, DG_CIA406_USF)) {
        const struct dg_cia406 before = *self;
        self->usf_lost = false;
        if (!move_zero(node, (uint64_t)*value * DG_CIA406_STEPS)) {
            self->zero = before.zero;
            self->zero_y = before.zero_y;
            self->usf_lost = before.usf_lost;
            return DG_CO_HARDWARE;
        }
        dg_co_clear(node, CAUSE_USF_LOST);
    }
    node->value[SLOT_OFFSET] = subtract_modulo(*value, scale_raw(node), tmr(node));
    return DG_CO_OK;
}

/* 6509h: preset minus scaled position, with its sign. */
enum dg_co_abort dg_cia406_hook_offset(struct dg_co_node *node, const struct dg_co_object *object,
                                       enum dg_co_op op, uint32_t *value)
{
    uint32_t range = tmr(node);
    uint32_t preset = node->value[SLOT_PRESET];

    (void)object;
    (void)op; /* it is read only */
    *value = preset - subtract_modulo(wrap_value(preset, range), wrap_value(*value, range), range);
    return DG_CO_OK;
}

/* 2160h raw, 2161h inverted, 2162h CRC over the bytes of 2160h as they stand on the wire (C24). */
enum dg_co_abort dg_cia406_hook_raw(struct dg_co_node *node, const struct dg_co_object *object,
                                    enum dg_co_op op, uint32_t *value)
{
    uint8_t bytes[4];

    (void)op;
    *value = encoder_of(node)->raw;
    if (object->index == 0x2161) {
        *value = ~*value;
    } else if (object->index == 0x2162) {
        dg_store_le32(bytes, *value);
        *value = dg_crc16(RAW_CRC_SEED, bytes, sizeof bytes);
    }
    return DG_CO_OK;
}

DG_CO_TELL(dg_cia406_hook_areas, areas(node, node->value[SLOT_POSITION]))

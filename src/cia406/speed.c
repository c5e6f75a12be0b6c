/* SPDX-License-Identifier: MIT */
/*
 * Speed and acceleration (chapters 13, 26; C17-C19): from unscaled positions at the ends of the
 * integration window, evaluated when they are asked for.
 */
#include "cia406_private.h"

#define RPM_MAX_SINGLETURN 4000
#define RPM_MAX_MULTITURN 15000
#define MOVED_MAX ((int64_t)1 << 32)

static int64_t saturate_speed(int64_t value, int64_t limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

/* To nearest, so that a constant speed reads constant (C34), and at most INT16_MAX, as all that is
 * shown: fifteen bits by subtraction, as no 64 bits are divided where the machine cannot. */
static int32_t divide_rounded(int64_t figure, uint64_t divisor)
{
    uint64_t rest = (figure < 0 ? 0u - (uint64_t)figure : (uint64_t)figure) + divisor / 2u;
    int32_t quotient = 0;

    for (int bit = 14; bit >= 0; bit--) {
        if (rest >= divisor << bit) {
            rest -= divisor << bit;
            quotient |= 1 << bit;
        }
    }
    return figure < 0 ? -quotient : quotient;
}

/* Counts the shaft has moved in the window that ended `windows` windows ago; limited where every
 * unit saturates anyway, so that what is computed from them fits. */
static int64_t moved(const struct dg_co_node *node, uint32_t windows)
{
    dg_ns window = DG_MS(node->value[SLOT_SPEED_WINDOW_MS]);
    dg_ns end = dg_elapsed(node->now, window * windows);
    int64_t counts = dg_cia406_counts(node, end) - dg_cia406_counts(node, dg_elapsed(end, window));

    counts = saturate_speed(counts, MOVED_MAX);
    return parameter(node, DG_CIA406_CCW) ? -counts : counts;
}

int32_t dg_cia406_rpm(const struct dg_co_node *node)
{
    return divide_rounded(moved(node, 0) * 60000,
                          (uint64_t)DG_CIA406_STEPS * node->value[SLOT_SPEED_WINDOW_MS]);
}

enum dg_co_abort dg_cia406_hook_speed(struct dg_co_node *node, const struct dg_co_object *object,
                                      enum dg_co_op op, uint32_t *value)
{
    bool multiturn = encoder_of(node)->model->turns > 1;

    (void)object;
    (void)op;
    if (parameter(node, DG_CIA406_UNITS_PER_S)) {
        uint32_t divisor = node->value[SLOT_SPEED_WINDOW_MS] * node->value[SLOT_SPEED_DIVISOR];
        *value = (uint32_t)divide_rounded(
            moved(node, 0) * 1000 * node->value[SLOT_SPEED_MULTIPLIER], divisor);
    } else {
        *value = (uint32_t)saturate_speed(dg_cia406_rpm(node),
                                          multiturn ? RPM_MAX_MULTITURN : RPM_MAX_SINGLETURN);
    }
    return DG_CO_OK;
}

/* Change of the speed over a window, per second; in the unit of the speed, without 6031h:3 and 4.
 */
enum dg_co_abort dg_cia406_hook_acceleration(struct dg_co_node *node,
                                             const struct dg_co_object *object, enum dg_co_op op,
                                             uint32_t *value)
{
    uint32_t window_ms = node->value[SLOT_SPEED_WINDOW_MS];
    int64_t change = (moved(node, 0) - moved(node, 1)) * 1000000;
    uint64_t divisor = (uint64_t)window_ms * window_ms; /* 1 s, 65536 steps: 36 bits */

    (void)object;
    (void)op;
    if (!parameter(node, DG_CIA406_UNITS_PER_S)) {
        change *= 60;
        divisor *= DG_CIA406_STEPS;
    }
    *value = (uint32_t)divide_rounded(change, divisor);
    return DG_CO_OK;
}

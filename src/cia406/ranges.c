/* SPDX-License-Identifier: MIT */
/*
 * Ranges of the position of encoders from EDS files, with a channel in each sub-index: work areas,
 * 6400h to 6402h, and eight cams each, 6300h to 6337h. What is set of them are cells of the file;
 * here is what they do. Cams:
 *
 *   position:       low          high
 *   inside      ------|############|------
 *   and on   --|--h-->|############|<--h--|--   as long as it was inside before
 *
 * 6300h has a bit for each that is enabled and inside, and that turned round where 6302h says so,
 * of those that are not enabled as well (Turck, BL20 CANopen, 4-195).
 */
#include "any.h"
#include "drehgeber/eds.h"

#define CAMS 8u
#define ENABLE 0x6301u
#define POLARITY 0x6302u
#define LOW 0x6310u
#define HIGH 0x6320u
#define HYSTERESIS 0x6330u

/* 6310h may lie behind 6320h: the cam goes over the zero of the range. */
static bool is_inside(const struct dg_co_node *node, uint8_t channel, uint32_t cam, bool before)
{
    const uint64_t range = dg_cia406_any_range(node);
    const uint64_t low = dg_co_value_of(node, DG_CO_KEY(LOW + cam, channel)) % range;
    const uint64_t high = dg_co_value_of(node, DG_CO_KEY(HIGH + cam, channel)) % range;
    const uint64_t wanted = dg_co_value_of(node, DG_CO_KEY(HYSTERESIS + cam, channel));
    const uint64_t width = (high + range - low) % range;
    const uint64_t more = !before ? 0 : wanted < range / 2u ? wanted : range / 2u;

    return (node->value[SLOT_POSITION] + more + range - low) % range <= width + 2u * more;
}

/* 6300h: hysteresis is about what was told last. */
enum dg_co_abort dg_cia406_hook_cams(struct dg_co_node *node, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    const uint8_t channel = object->sub;
    const uint32_t shift = CAMS * (channel - 1u);
    const uint32_t enabled = dg_co_value_of(node, DG_CO_KEY(ENABLE, channel));
    const uint32_t before = node->value[SLOT_CAMS] >> shift;
    uint32_t inside = 0;

    (void)op;
    for (uint32_t cam = 0; cam < CAMS; cam++) {
        const bool on =
            (enabled >> cam & 1u) != 0 && is_inside(node, channel, cam, (before >> cam & 1u) != 0);
        inside |= on ? 1u << cam : 0u;
    }
    node->value[SLOT_CAMS] = (node->value[SLOT_CAMS] & ~(0xFFu << shift)) | inside << shift;
    *value = (inside ^ dg_co_value_of(node, DG_CO_KEY(POLARITY, channel))) & 0xFFu;
    return DG_CO_OK;
}

/* Bits of 6400h. */
#define OUTSIDE 1u
#define ABOVE 2u
#define BELOW 4u
#define AREA_BITS 3u

/* Whether the position is less than an object; signed where that is. */
static bool is_less(const struct dg_co_node *node, uint32_t key)
{
    const uint32_t limit = dg_co_value_of(node, key);
    const uint32_t at = node->value[SLOT_POSITION];

    return dg_co_type_at(node->setup.device, key) == DG_CO_I32 ? (int32_t)at < (int32_t)limit
                                                               : at < limit;
}

/* A limit that is not in the file is none. */
static uint32_t look_at_area(const struct dg_co_node *node, uint8_t channel)
{
    const struct dg_co_device *device = node->setup.device;
    const uint32_t low = DG_CO_KEY(0x6401, channel);
    const uint32_t high = DG_CO_KEY(0x6402, channel);
    const bool below = dg_co_type_at(device, low) != DG_CO_TYPE_COUNT && is_less(node, low);
    const bool above = dg_co_type_at(device, high) != DG_CO_TYPE_COUNT && !is_less(node, high) &&
                       node->value[SLOT_POSITION] != dg_co_value_of(node, high);

    return (below || above ? OUTSIDE : 0u) | (above ? ABOVE : 0u) | (below ? BELOW : 0u);
}

/* 6400h: a channel each; where there is one only, it has the second area in its upper bits, as the
 * F36x8 has. */
enum dg_co_abort dg_cia406_hook_channel(struct dg_co_node *node, const struct dg_co_object *object,
                                        enum dg_co_op op, uint32_t *value)
{
    const bool alone = dg_co_type_at(node->setup.device, DG_CO_KEY(0x6400, 2)) == DG_CO_TYPE_COUNT;

    (void)op;
    *value = look_at_area(node, object->sub) | (alone ? look_at_area(node, 2) << AREA_BITS : 0u);
    return DG_CO_OK;
}

/* SPDX-License-Identifier: MIT */
/*
 * The two LEDs (chapter 29, C29, C38): which states light them how, as a table.
 */
#include "cia406_private.h"

static bool stopped(const struct dg_co_node *node)
{
    return node->state == DG_CO_STOPPED;
}

static bool pre_operational(const struct dg_co_node *node)
{
    return node->state == DG_CO_PRE_OPERATIONAL;
}

static bool operational(const struct dg_co_node *node)
{
    return node->state == DG_CO_OPERATIONAL;
}

static bool no_bus(const struct dg_co_node *node)
{
    return node->bus_absent;
}

static bool no_bus_yet(const struct dg_co_node *node)
{
    return node->bus_absent && !node->bus_found;
}

static bool cause(const struct dg_co_node *node, uint8_t which)
{
    return (node->active_causes >> which & 1u) != 0;
}

static bool link_lost(const struct dg_co_node *node)
{
    return cause(node, DG_CO_CAUSE_LIFE) || cause(node, DG_CO_CAUSE_HEARTBEAT) ||
           cause(node, DG_CO_CAUSE_HEARTBEAT_2);
}

static bool flash(const struct dg_co_node *node)
{
    return node->now < encoder_of(node)->flash_until;
}

static bool no_offset(const struct dg_co_node *node)
{
    return encoder_of(node)->usf_lost;
}

static bool bus_off(const struct dg_co_node *node)
{
    return node->bus_off;
}

static bool sensor_or_memory(const struct dg_co_node *node)
{
    return cause(node, CAUSE_POSITION) || cause(node, DG_CO_CAUSE_MEMORY);
}

static bool watchdog(const struct dg_co_node *node)
{
    return node->setup.world->watchdog_fired;
}

static bool lss(const struct dg_co_node *node)
{
    return node->lss.configuration;
}

#define KEEP 0xFFu

/* clang-format off */
/* Later rows win; KEEP leaves a LED to the rows above. */
static const struct {
    bool (*state)(const struct dg_co_node *node);
    uint8_t bus;
    uint8_t err;
} patterns[] = {
    {pre_operational,  DG_CIA406_LAMP_BLINK, KEEP},
    {stopped,          DG_CIA406_LAMP_SLOW,  KEEP},
    {operational,      DG_CIA406_LAMP_ON,    KEEP},
    {no_bus,           DG_CIA406_LAMP_OFF,   KEEP},
    {no_bus_yet,       KEEP,                 DG_CIA406_LAMP_BLINK},
    {link_lost,        KEEP,                 DG_CIA406_LAMP_BLINK},
    {flash,            KEEP,                 DG_CIA406_LAMP_BLINK},
    {no_offset,        KEEP,                 DG_CIA406_LAMP_BLINK},
    {bus_off,          KEEP,                 DG_CIA406_LAMP_ON},
    {sensor_or_memory, DG_CIA406_LAMP_FAST,  DG_CIA406_LAMP_FAST_OTHER},
    {watchdog,         DG_CIA406_LAMP_300,   DG_CIA406_LAMP_300},
    {lss,              DG_CIA406_LAMP_FAST,  DG_CIA406_LAMP_FAST},
};
/* clang-format on */

static bool lit(enum dg_cia406_lamp pattern, dg_ns now)
{
    static const uint16_t half_period_ms[DG_CIA406_LAMP_COUNT] = {
        [DG_CIA406_LAMP_BLINK] = 250,     [DG_CIA406_LAMP_SLOW] = 1000, [DG_CIA406_LAMP_FAST] = 50,
        [DG_CIA406_LAMP_FAST_OTHER] = 50, [DG_CIA406_LAMP_300] = 300,
    };

    if (pattern == DG_CIA406_LAMP_OFF || pattern == DG_CIA406_LAMP_ON) {
        return pattern == DG_CIA406_LAMP_ON;
    }
    bool first_half = now / DG_MS(half_period_ms[pattern]) % 2u == 0;
    return first_half != (pattern == DG_CIA406_LAMP_FAST_OTHER);
}

struct dg_cia406_leds dg_cia406_leds(const struct dg_co_node *node)
{
    struct dg_cia406_leds leds = {DG_CIA406_LAMP_OFF, DG_CIA406_LAMP_OFF, false, false};

    if (node->state == DG_CO_OFF) {
        return leds;
    }
    for (uint8_t i = 0; i < DG_COUNT(patterns); i++) {
        if (!patterns[i].state(node)) {
            continue;
        }
        if (patterns[i].bus != KEEP) {
            leds.bus_pattern = (enum dg_cia406_lamp)patterns[i].bus;
        }
        if (patterns[i].err != KEEP) {
            leds.err_pattern = (enum dg_cia406_lamp)patterns[i].err;
        }
    }
    leds.bus = lit(leds.bus_pattern, node->now);
    leds.err = lit(leds.err_pattern, node->now);
    return leds;
}

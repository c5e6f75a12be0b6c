/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the encoder profile: what its files share.
 */
#ifndef DREHGEBER_CIA406_PRIVATE_H
#define DREHGEBER_CIA406_PRIVATE_H

#include "drehgeber/cia406.h"

/** Slots of the profile's values in dg_co_node.value. */
enum profile_slot {
    SLOT_PARAMETERS = DG_CO_SLOT_APPLICATION, /* 6000h */
    SLOT_MUR,
    SLOT_TMR,
    SLOT_PRESET,
    SLOT_OFFSET, /* modulo the range; 6509h shows it with its sign */
    SLOT_SPEED_SOURCE,
    SLOT_SPEED_WINDOW_MS,
    SLOT_SPEED_MULTIPLIER,
    SLOT_SPEED_DIVISOR,
    SLOT_LOW, /* two of each */
    SLOT_HIGH = SLOT_LOW + 2,
    SLOT_TEMPERATURE_LOW = SLOT_HIGH + 2,
    SLOT_TEMPERATURE_HIGH,
    SLOT_CUSTOMER,                     /* four */
    SLOT_POSITION = SLOT_CUSTOMER + 4, /* of the latest sample */
    SLOT_TURN_BITS,                    /* what the model says, from here on */
    SLOT_TURNS,
    SLOT_LAST,
    SLOT_END,
};
_Static_assert(SLOT_END <= DG_CO_VALUES_MAX, "room for the profile's slots");
_Static_assert((int)SLOT_END == (int)DG_CIA406_VALUE_END &&
                   (int)SLOT_LOW == (int)DG_CIA406_VALUE_LOW_1 &&
                   (int)SLOT_CUSTOMER == (int)DG_CIA406_VALUE_CUSTOMER_1,
               "all have names in public");

/** Store regions of the profile. */
enum profile_region {
    REGION_PROFILE = DG_CO_REGION_APPLICATION, /* what 1010h keeps */
    REGION_USF,                                /* kept whenever the internal zero moves */
    REGION_TIME,                               /* operating time */
    REGION_COUNT,
};

/** Causes of EMCYs, as cause numbers of the node. */
enum profile_cause {
    CAUSE_TEMPERATURE = DG_CO_CAUSES,
    CAUSE_SPEED,
    CAUSE_BATTERY_LOW,
    CAUSE_BATTERY_CABLE,
    CAUSE_OPTICS,
    CAUSE_POSITION, /* alarm bit 0 */
    CAUSE_HARDWARE, /* alarm bit 1 */
    CAUSE_USF_MOVED,
    CAUSE_USF_LOST,
    CAUSE_END,
};
_Static_assert(CAUSE_END <= 32, "causes are bits of a 32-bit mask");
_Static_assert(CAUSE_END - DG_CO_CAUSES == DG_CIA406_CAUSES, "as many as there are");

/** As often a wrong password doubles the delay of the next one (C25). */
#define PASSWORD_DELAYS_MAX 8u

/** Bits of warnings 6505h and alarms 6503h; 6506h and 6504h say which there are. */
#define WARN_SPEED 0x0001u
#define WARN_WATCHDOG 0x0004u
#define WARN_TIME 0x0008u
#define WARN_BATTERY 0x0010u
#define WARN_TEMPERATURE 0x8000u
#define WARNINGS (WARN_SPEED | WARN_WATCHDOG | WARN_TIME | WARN_BATTERY | WARN_TEMPERATURE)
#define ALARM_POSITION 0x0001u
#define ALARM_HARDWARE 0x0002u
#define ALARMS (ALARM_POSITION | ALARM_HARDWARE)

static inline struct dg_cia406 *encoder_of(const struct dg_co_node *node)
{
    return node->setup.application;
}

static inline bool parameter(const struct dg_co_node *node, uint32_t bit)
{
    return (node->value[SLOT_PARAMETERS] & bit) != 0;
}

/** The error LED flashes that long after an event (chapter 29). */
#define FLASH_MS 3000u

/** `ms` from now on. */
dg_ns dg_cia406_in_ms(const struct dg_co_node *node, uint32_t ms);

/* cia406.c */
/** Supervision now and then; in event mode every millisecond whether a position has changed. */
dg_ns dg_cia406_step_node(struct dg_co_node *node);

/* position.c */
/** Physical counts of the shaft since angle 0, unbounded. */
int64_t dg_cia406_counts(const struct dg_co_node *node, dg_ns at);
void dg_cia406_sample(struct dg_co_node *node);
/** After a reset of the application: take up the stored internal zero. */
void dg_cia406_restore_zero(struct dg_co_node *node);
/** USF: move the internal zero when the position has reached the critical range. */
void dg_cia406_watch_zero(struct dg_co_node *node);

/* speed.c */
/** In rpm, by the integration window, with the sign of the code sequence, at most INT16_MAX. */
int32_t dg_cia406_rpm(const struct dg_co_node *node);

/* health.c */
void dg_cia406_health_start(struct dg_co_node *node);
void dg_cia406_health_look(struct dg_co_node *node);
/** When the operating time is to be stored next. */
dg_ns dg_cia406_health_next(const struct dg_cia406 *self);

/* Hooks, by file. */
dg_co_hook dg_cia406_hook_scaling, dg_cia406_hook_preset; /* position.c */
dg_co_hook dg_cia406_hook_offset, dg_cia406_hook_raw, dg_cia406_hook_areas;
dg_co_hook dg_cia406_hook_speed, dg_cia406_hook_acceleration;                    /* speed.c */
dg_co_hook dg_cia406_hook_health, dg_cia406_hook_sensor, dg_cia406_hook_battery; /* health.c */
dg_co_hook dg_cia406_hook_time;

#endif

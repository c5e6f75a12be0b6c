/* SPDX-License-Identifier: MIT */
/*
 * Supervision: warnings, alarms, temperature, battery, operating time (chapters 14, 15, 26; C15,
 * C16, C22, C23). Causes are found in the world; each has its EMCY and its bits.
 */
#include "cia406_private.h"

#include "drehgeber/bits.h"

#define TENTH_OF_AN_HOUR DG_S(360) /* 60 000 * 60 000 * 100 ns */

#define ICLG_STATUS 0x80u
#define ICLG_VERSION 0x2Eu
#define BATTERY_LOW_10MV 240u
#define BATTERY_NONE_10MV 10u
#define BATTERY_NONE 0x3FFu
#define BATTERY_MAX_10MV 500u
#define LED_MAX_UA 30000u
#define RPM_WARN_SINGLETURN 4000u
#define RPM_WARN_MULTITURN 12000u
#define TIME_WARN_10H 1000000u /* 100 000 h */

/* 2120h: 40h + degC. */
static uint8_t temperature_code(const struct dg_co_node *node)
{
    int32_t mdegc = node->setup.world->temperature_mdegc;
    uint32_t code = mdegc < -0x40 * 1000 ? 0 : ((uint32_t)mdegc + 0x40u * 1000u) / 1000u;

    return (uint8_t)(code > 0xFF ? 0xFF : code);
}

static uint16_t battery_10mv(const struct dg_co_node *node)
{
    uint32_t value = node->setup.world->battery_mv / 10u;

    return (uint16_t)(value > BATTERY_MAX_10MV ? BATTERY_MAX_10MV : value);
}

static bool too_hot_or_cold(const struct dg_co_node *node)
{
    uint8_t code = temperature_code(node);

    return code > node->value[SLOT_TEMPERATURE_HIGH] || code < node->value[SLOT_TEMPERATURE_LOW];
}

/* Once told it lasts until the speed is 1 % below the limit: one EMCY per event (C34). */
static bool too_fast(const struct dg_co_node *node)
{
    uint32_t limit = encoder_of(node)->model->turns > 1 ? RPM_WARN_MULTITURN : RPM_WARN_SINGLETURN;
    int32_t rpm = dg_cia406_rpm(node);

    if ((node->active_causes >> CAUSE_SPEED & 1u) != 0) {
        limit -= limit / 100u;
    }
    return (uint32_t)(rpm < 0 ? -rpm : rpm) > limit;
}

static bool has_battery(const struct dg_co_node *node)
{
    return encoder_of(node)->model->turns > 1;
}

static bool battery_low(const struct dg_co_node *node)
{
    return has_battery(node) && battery_10mv(node) < BATTERY_LOW_10MV &&
           battery_10mv(node) >= BATTERY_NONE_10MV;
}

static bool battery_missing(const struct dg_co_node *node)
{
    return has_battery(node) && battery_10mv(node) < BATTERY_NONE_10MV;
}

static bool optics_failed(const struct dg_co_node *node)
{
    return node->setup.world->led_current_ua > LED_MAX_UA;
}

static bool position_invalid(const struct dg_co_node *node)
{
    const struct dg_world *world = node->setup.world;
    bool multiturn =
        world->multiturn_amplitude_ok && world->multiturn_sync_ok && world->multiturn_vector_ok;

    return !world->singleturn_ok || (encoder_of(node)->model->turns > 1 && !multiturn);
}

static bool hardware_failed(const struct dg_co_node *node)
{
    return !node->setup.world->eeprom_acknowledges;
}

static bool memory_failed(const struct dg_co_node *node)
{
    return hardware_failed(node) || !node->mounted ||
           (node->store.damaged & ~(1u << REGION_USF)) != 0 || encoder_of(node)->zero_unsaved;
}

static bool offset_lost(const struct dg_co_node *node)
{
    return encoder_of(node)->usf_lost;
}

static bool watchdog(const struct dg_co_node *node)
{
    return node->setup.world->watchdog_fired;
}

static bool old(const struct dg_co_node *node)
{
    return encoder_of(node)->time_10h > TIME_WARN_10H;
}

/* Manufacturer bytes of the EMCYs (chapter 15; 4200h as in the example of chapter 14). */
static void sensor_details(const struct dg_co_node *node, uint8_t *details)
{
    details[0] = ICLG_STATUS;
    details[1] = temperature_code(node);
    details[2] = (uint8_t)node->value[SLOT_TEMPERATURE_LOW];
    details[3] = (uint8_t)node->value[SLOT_TEMPERATURE_HIGH];
    details[4] = ICLG_VERSION;
}

static void battery_details(const struct dg_co_node *node, uint8_t *details)
{
    details[0] = 0x02;
    dg_store_le16(&details[1], battery_10mv(node));
}

static void cable_details(const struct dg_co_node *node, uint8_t *details)
{
    (void)node;
    details[0] = 0x02;
    details[4] = 0xFF;
}

static void optics_details(const struct dg_co_node *node, uint8_t *details)
{
    (void)node;
    details[0] = 0x09;
    details[1] = 0x81; /* error mask register */
    details[2] = 0x45; /* error register */
}

#define NO_CAUSE 0

/* clang-format off */
static const struct {
    bool (*present)(const struct dg_co_node *node);
    void (*details)(const struct dg_co_node *node, uint8_t *details);
    uint16_t bit;   /* of 6503h, alarms, or 6505h, warnings */
    bool alarm;
    uint8_t cause;
} checks[] = {
    {too_fast,         sensor_details,  WARN_SPEED,       false, CAUSE_SPEED},
    {too_hot_or_cold,  sensor_details,  WARN_TEMPERATURE, false, CAUSE_TEMPERATURE},
    {battery_low,      battery_details, WARN_BATTERY,     false, CAUSE_BATTERY_LOW},
    {battery_missing,  cable_details,   WARN_BATTERY,     false, CAUSE_BATTERY_CABLE},
    {optics_failed,    optics_details,  0,                false, CAUSE_OPTICS},
    {position_invalid, NULL,            ALARM_POSITION,   true,  CAUSE_POSITION},
    {memory_failed,    NULL,            0,                false, DG_CO_CAUSE_MEMORY},
    {hardware_failed,  NULL,            ALARM_HARDWARE,   true,  CAUSE_HARDWARE},
    {offset_lost,      NULL,            0,                false, CAUSE_USF_LOST},
    {watchdog,         NULL,            WARN_WATCHDOG,    false, NO_CAUSE},
    {old,              NULL,            WARN_TIME,        false, NO_CAUSE},
};
/* clang-format on */

static void count_operating_time(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);
    dg_ns elapsed = dg_elapsed(node->now, self->time_from);
    uint8_t bytes[4];

    if (elapsed < TENTH_OF_AN_HOUR) {
        return;
    }
    dg_ns tenths = dg_divide_ns(dg_divide_ns(dg_divide_ns(elapsed, 60000), 60000), 100);
    self->time_from += tenths * TENTH_OF_AN_HOUR;
    self->time_10h += (uint32_t)tenths;
    dg_store_le32(bytes, self->time_10h);
    if (node->mounted && node->setup.world->eeprom_acknowledges) {
        /* A value that is lost costs six minutes of operating time, nothing else. */
        (void)dg_store_put(&node->store, REGION_TIME, 0, bytes, sizeof bytes);
    }
}

void dg_cia406_health_start(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);
    uint8_t bytes[4] = {0};

    if (node->mounted && !dg_store_damaged(&node->store, REGION_TIME) &&
        dg_store_read(&node->store, REGION_TIME, 0, bytes, sizeof bytes) == DG_OK) {
        self->time_10h = dg_load_le32(bytes);
    }
    self->time_from = node->now;
    self->look_at = node->now;
    self->calm_ms = 0;
}

dg_ns dg_cia406_health_next(const struct dg_cia406 *self)
{
    return dg_after(self->time_from, TENTH_OF_AN_HOUR);
}

void dg_cia406_health_look(struct dg_co_node *node)
{
    struct dg_cia406 *self = encoder_of(node);

    count_operating_time(node);
    for (uint8_t i = 0; i < DG_COUNT(checks); i++) {
        uint8_t details[5] = {0};
        if (!checks[i].present(node)) {
            if (checks[i].cause != NO_CAUSE) {
                dg_co_clear(node, checks[i].cause);
            }
            continue;
        }
        if (checks[i].cause == NO_CAUSE || (node->active_causes & 1u << checks[i].cause) != 0) {
            continue;
        }
        if (checks[i].details != NULL) {
            checks[i].details(node, details);
        }
        self->flash_until = dg_cia406_in_ms(node, FLASH_MS);
        dg_co_raise(node, checks[i].cause, details);
    }
}

/* A bit stands as long as its cause. The EMCY is the supervision's: its reaction (1029h) must not
 * happen while a TPDO is being built. */
enum dg_co_abort dg_cia406_hook_health(struct dg_co_node *node, const struct dg_co_object *object,
                                       enum dg_co_op op, uint32_t *value)
{
    const bool alarms = object->index == 0x6503;

    (void)op;
    *value = 0;
    for (uint8_t i = 0; i < DG_COUNT(checks); i++) {
        if (checks[i].alarm == alarms && checks[i].present(node)) {
            *value |= checks[i].bit;
        }
    }
    return DG_CO_OK;
}

enum dg_co_abort dg_cia406_hook_sensor(struct dg_co_node *node, const struct dg_co_object *object,
                                       enum dg_co_op op, uint32_t *value)
{
    bool error = too_hot_or_cold(node) || too_fast(node);

    (void)op;
    *value = object->sub == 4 ? temperature_code(node) : error ? ICLG_STATUS : 0u;
    return DG_CO_OK;
}

enum dg_co_abort dg_cia406_hook_battery(struct dg_co_node *node, const struct dg_co_object *object,
                                        enum dg_co_op op, uint32_t *value)
{
    bool none = !has_battery(node) || battery_missing(node);

    (void)object;
    (void)op;
    *value = none ? BATTERY_NONE : battery_10mv(node);
    return DG_CO_OK;
}

enum dg_co_abort dg_cia406_hook_time(struct dg_co_node *node, const struct dg_co_object *object,
                                     enum dg_co_op op, uint32_t *value)
{
    (void)object;
    (void)op;
    count_operating_time(node);
    *value = encoder_of(node)->time_10h;
    return DG_CO_OK;
}

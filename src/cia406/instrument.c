/* SPDX-License-Identifier: MIT */
/*
 * The F36x8 as an instrument. Causes of defects are looked for every 100 ms at least; where a limit
 * is configuration (2120h) a value may have to be chosen by WORLd instead.
 */
#include "drehgeber/cia406.h"
#include "drehgeber/instruments.h"

#define CODE_MASK 0xFFFFu

static const char *mode(const void *self, dg_ns now)
{
    const struct dg_cia406_device *device = self;

    (void)now;
    switch (device->node.state) {
    case DG_CO_BOOT:
        return "init";
    case DG_CO_STOPPED:
        return "stopped";
    case DG_CO_OPERATIONAL:
        return "operational";
    case DG_CO_PRE_OPERATIONAL:
        return "preoperational";
    case DG_CO_OFF:
        break;
    }
    return "off";
}

/* As they would be after a sample at `now`; a sample belongs to the bus, so this one is a copy's.
 */
static struct dg_cia406_leds leds_at(const struct dg_cia406_device *device, dg_ns now)
{
    struct dg_cia406_device at = *device;

    at.node.now = now;
    at.node.setup.application = &at.encoder;
    if (at.node.state != DG_CO_OFF) {
        at.node.setup.device->sample(&at.node);
    }
    return dg_cia406_leds(&at.node);
}

static void put_leds(struct dg_cia406_leds leds, struct dg_scpi *to)
{
    static const char *const names[] = {
        [DG_CIA406_LAMP_OFF] = "off",     [DG_CIA406_LAMP_ON] = "on",
        [DG_CIA406_LAMP_BLINK] = "blink", [DG_CIA406_LAMP_SLOW] = "slow",
        [DG_CIA406_LAMP_FAST] = "fast",   [DG_CIA406_LAMP_FAST_OTHER] = "fast-other",
        [DG_CIA406_LAMP_300] = "300ms",
    };
    _Static_assert(DG_COUNT(names) == DG_CIA406_LAMP_COUNT, "a name for each");

    dg_state_begin(to, "leds");
    dg_scpi_append(to, "bus:");
    dg_scpi_append(to, names[leds.bus_pattern]);
    dg_scpi_append(to, "/err:");
    dg_scpi_append(to, names[leds.err_pattern]);
}

/* 1003h, without the manufacturer's part. */
static void put_node_errors(const struct dg_co_node *node, struct dg_scpi *to)
{
    bool first = true;

    dg_state_begin(to, "errors");
    for (uint8_t i = 0; i < node->history_count; i++) {
        const uint32_t place = (node->history_newest + DG_CO_HISTORY - i) % DG_CO_HISTORY;
        dg_state_item(to, &first, node->history[place] & CODE_MASK, 4);
    }
    dg_state_end(to, first);
}

/* CAN-IDs that two services of the node have. */
static void put_shared(const struct dg_co_node *node, struct dg_scpi *to)
{
    uint16_t ids[DG_CO_SHARED_MAX];
    const uint8_t n = dg_co_shared_ids(node, ids);
    bool first = true;

    dg_state_begin(to, "shared_ids");
    for (uint8_t i = 0; i < n; i++) {
        dg_state_item(to, &first, ids[i], 3);
    }
    dg_state_end(to, first);
}

static void state(const void *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_cia406_device *device = self;
    const struct dg_co_node *node = &device->node;
    const struct dg_co_counters *counters = &node->counters;

    put_leds(leds_at(device, now), to);
    put_node_errors(node, to);
    dg_state_number(to, "frames", counters->rx);
    dg_state_number(to, "sent", counters->tx);
    dg_state_number(to, "malformed", counters->malformed);
    dg_state_number(to, "late_sync", counters->late_sync);
    dg_state_number(to, "node", node->id);
    dg_state_number(to, "bus_off", node->bus_off);
    dg_state_hex(to, "causes", node->active_causes, 8);
    put_shared(node, to);
}

/* clang-format off */
static const struct dg_fault_row faults[] = {
    {"led_current_high",    DG_FAULT_SENSES(led_current_ua),                      40000, DG_CAUSE_LED_WORN,  "EMCY 5200h, 1001h bit 0", "15; no. 6"},
    {"temperature_high",    DG_FAULT_SENSES(temperature_mdegc),                  125000, DG_CAUSE_HOT,       "EMCY 4200h, 1001h 09h, 6505h bit 15, 2120h:4 BDh", "14, 15, 26"},
    {"temperature_low",     DG_FAULT_SENSES(temperature_mdegc),                  -45000, DG_CAUSE_COLD,      "EMCY 4200h, 1001h 09h, 6505h bit 15, 2120h:4 13h", "14, 15, 26"},
    {"battery_low",         DG_FAULT_SENSES(battery_mv),                           2300, "the battery of the multiturn counter is run down", "multiturn: EMCY 3200h, 1001h 01h, 6505h bit 4", "15, 26; C23"},
    {"battery_missing",     DG_FAULT_SENSES(battery_mv),                              0, "the battery of the multiturn counter is not connected", "multiturn: EMCY 3200h, 1001h 05h, 6505h bit 4, 2125h 3FFh", "15, 26; C23"},
    {"singleturn_lost",     DG_FAULT_SENSES(singleturn_ok),                           0, DG_CAUSE_SCRATCH,   "EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"multiturn_amplitude", DG_FAULT_SENSES(multiturn_amplitude_ok),                  0, DG_CAUSE_MT_WEAK,   "multiturn: EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"multiturn_sync",      DG_FAULT_SENSES(multiturn_sync_ok),                       0, DG_CAUSE_MT_SYNC,   "multiturn: EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"multiturn_vector",    DG_FAULT_SENSES(multiturn_vector_ok),                     0, DG_CAUSE_MT_VECTOR, "multiturn: EMCY 1000h, 1001h bit 0, 6503h bit 0, both LEDs fast", "15, 26, 29"},
    {"eeprom_silent",       DG_FAULT_SENSES(eeprom_acknowledges),                     0, DG_CAUSE_SILENT,    "EMCY 5100h and 1000h, 6503h bit 1; 1010h, 1011h, 2105h abort 06060000h; if it is silent at a start, 5100h until the next start", "15, 26; no. 8"},
    {"watchdog_fired",      DG_FAULT_SENSES(watchdog_fired),                          1, DG_CAUSE_WATCHDOG,  "6505h bit 2, both LEDs 300 ms; no EMCY", "26, 29; no. 10"},
    {"wire_drop",           DG_FAULT_ON_WIRE(DROP),                                   0, "a bridge loses frames to the master", "what the node sends does not arrive", "CiA 301"},
    {"wire_deaf",           DG_FAULT_ON_WIRE(DEAF),                                   0, "a bridge loses frames from the master", "what the master sends does not arrive", "CiA 301"},
    {"wire_delay",          DG_FAULT_ON_WIRE(DELAY),                 (int64_t)DG_MS(50), "the bus is overloaded", "what the node sends comes 50 ms late", "CiA 301"},
    {"wire_damage",         DG_FAULT_ON_WIRE(DAMAGE),                                 0, "a bridge with a faulty memory", "one data bit is flipped and the CRC fits: a frame that is valid and wrong", "CiA 301"},
    {"wire_duplicate",      DG_FAULT_ON_WIRE(DUPLICATE),                              0, "a disturbance in the last bit: the controller repeats what was received already", "what the node sends comes twice", "CiA 301"},
    {"bus_off",             DG_FAULT_ON_WIRE(BUS_OFF),                                0, "the bus is short-circuited", "silence, 1029h:1 at once, error LED on; EMCY 8140h when the bus is back", "15, 29; CANopen no. 1"},
    {"error_passive",       DG_FAULT_ON_WIRE(PASSIVE),                                0, "many damaged frames", "EMCY 8120h, 1001h 11h", "15"},
    {"overrun",             DG_FAULT_ON_WIRE(OVERRUN),                                0, "the processor was too slow to take a frame", "the frame is lost, EMCY 8110h and 0000h", "15"},
};

static const struct dg_damage_row damage[] = {
    {"usf",  "from the next start on, with the universal scaling function: EMCY 6200h until a preset is set", "25"},
    {"time", "from the next start on: EMCY 5100h; 6508h starts again at 0", "15; F36x8 no. 9"},
    {NULL,   "from the next start on: EMCY 5100h, 1001h bit 0, defaults are used", "15; CANopen no. 4"},
};
/* clang-format on */

const struct dg_instrument dg_cia406_instrument = {
    .stack = &dg_cia406_stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .damage = damage,
    .mode = mode,
    .state = state,
};

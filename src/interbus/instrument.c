/* SPDX-License-Identifier: MIT */
/*
 * The OCD INTERBUS as an instrument. What is wrong a K3 says in IN, K1 and K2 as a module error in
 * the ID word.
 */
#include "drehgeber/instruments.h"
#include "drehgeber/interbus.h"

/* The message bit of K1's and K2's only error (I19). */
#define MODULE_ERROR 0x2000u

static bool is_k3(const struct dg_ib *device)
{
    return device->setup.model->profile == DG_IB_K3;
}

/* What a K3 shows in operation, when nothing lies over it. */
static const char *operation_name_of(const struct dg_ib *device)
{
    static const char *const modes[DG_IB_CAM + DG_IB_PROGRAMS + 1u] = {
        [DG_IB_POSITION_K2] = "position", [DG_IB_POSITION] = "position", [DG_IB_SPEED] = "speed",
        [DG_IB_CAM + 1] = "cam-1",        [DG_IB_CAM + 2] = "cam-2",     [DG_IB_CAM + 3] = "cam-3",
        [DG_IB_CAM + 4] = "cam-4",        [DG_IB_CAM + 5] = "cam-5",     [DG_IB_CAM + 6] = "cam-6",
        [DG_IB_CAM + 7] = "cam-7",        [DG_IB_CAM + 8] = "cam-8",
    };

    return device->lost != 0 ? "lost" : modes[device->mode];
}

static const char *mode(const void *self, dg_ns now)
{
    const struct dg_ib *device = self;

    if (!device->powered) {
        return "off";
    }
    if (now < device->ready_at) {
        return "self-test";
    }
    if (device->item != 0) {
        return "read-out";
    }
    return device->answer != 0 ? "parameter" : operation_name_of(device);
}

static void put_leds(uint8_t leds, struct dg_scpi *to)
{
    static const struct {
        const char *name;
        uint8_t bit;
    } all[] = {
        {"UL:", DG_IB_LED_UL},
        {"/RC:", DG_IB_LED_RC},
        {"/BA:", DG_IB_LED_BA},
        {"/RD:", DG_IB_LED_RD},
    };

    dg_state_begin(to, "leds");
    for (size_t i = 0; i < DG_COUNT(all); i++) {
        const bool blinks = all[i].bit == DG_IB_LED_BA && (leds & DG_IB_LED_BA_BLINKS) != 0;
        dg_scpi_append(to, all[i].name);
        dg_scpi_append(to, blinks ? "blink" : (leds & all[i].bit) != 0 ? "on" : "off");
    }
}

static void put_errors(const struct dg_ib *device, struct dg_scpi *to)
{
    if (is_k3(device) && device->last_error != 0) {
        dg_state_hex(to, "errors", device->last_error, 8);
    } else if (!is_k3(device) && device->invalid) {
        dg_state_hex(to, "errors", MODULE_ERROR, 4);
    } else {
        dg_state_word(to, "errors", "-");
    }
}

static void state(const void *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_ib *device = self;
    const struct dg_ib_counters *counters = &device->counters;
    const bool on = device->powered;

    put_leds(dg_ib_leds(device, now), to);
    put_errors(device, to);
    dg_state_number(to, "frames", counters->cycles);
    dg_state_number(to, "commands", counters->commands);
    dg_state_number(to, "refused", counters->refused);
    dg_state_number(to, "dropped", counters->dropped);
    dg_state_number(to, "presets_unset", counters->presets_unset);
    dg_state_number(to, "releases_stale", counters->releases_stale);
    dg_state_number(to, "crc_errors", counters->crc_errors);
    dg_state_number(to, "valid", on && !device->invalid);
    dg_state_hex(to, "last_command", device->last_command, 8);
}

/* clang-format off */
static const struct dg_fault_row faults[] = {
    {"singleturn_lost",     DG_FAULT_SENSES(singleturn_ok),          0, DG_CAUSE_SCRATCH,   "IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"multiturn_amplitude", DG_FAULT_SENSES(multiturn_amplitude_ok), 0, DG_CAUSE_MT_WEAK,   "multiturn: IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"multiturn_sync",      DG_FAULT_SENSES(multiturn_sync_ok),      0, DG_CAUSE_MT_SYNC,   "multiturn: IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"multiturn_vector",    DG_FAULT_SENSES(multiturn_vector_ok),    0, DG_CAUSE_MT_VECTOR, "multiturn: IN bit 31; K1, K2: ID bit 13", "9.3; I19"},
    {"eeprom_silent",       DG_FAULT_SENSES(eeprom_acknowledges),    0, DG_CAUSE_SILENT,    "K3: parameters answer 86000000h; if it is silent at a start, IN 86000000h until the next start", "9.4; no. 1"},
    {"wire_drop",           DG_FAULT_ON_WIRE(DROP),                  0, "a disturbance on the remote bus", "a cycle without data: IN as before", "2"},
    {"wire_damage",         DG_FAULT_ON_WIRE(DAMAGE),                0, "a disturbance on the incoming bus", "a transmission error at this device: no data in this cycle and five more, ID bit 14", "2; no. 5"},
    {"wire_tear",           DG_FAULT_ON_WIRE(TEAR),                  0, "a master that does not take the words of a device together", "IN is half of this cycle, half of the one before", "2; I21"},
    {"wire_break",          DG_FAULT_ON_WIRE(BREAK),                 0, "the incoming bus is cut", "the ring is interrupted here: no data, RD on at the device before; then an ID cycle comes first", "3.3; no. 6"},
};

static const struct dg_damage_row damage[] = {
    {"time", "from the next start on: the operating time starts again at 0; no error", "I17"},
    {NULL,   "from the next start on: IN 86000000h until it is sent again or 0E000000h is accepted", "9.4; I17"},
};
/* clang-format on */

const struct dg_instrument dg_ib_instrument = {
    .stack = &dg_ib_stack,
    .faults = faults,
    .fault_count = DG_COUNT(faults),
    .damage = damage,
    .mode = mode,
    .state = state,
};

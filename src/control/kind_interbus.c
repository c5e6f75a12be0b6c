/* SPDX-License-Identifier: MIT */
/*
 * The OCD INTERBUS as an instrument.
 */
#include "control_private.h"
#include "drehgeber/interbus.h"

/* The message bit of K1's and K2's only error (I19). */
#define MODULE_ERROR 0x2000u

static struct dg_ib *device_of(const struct dg_encoder *self)
{
    return self->device;
}

static bool is_k3(const struct dg_ib *device)
{
    return device->setup.model->profile == DG_IB_K3;
}

static const struct dg_store_layout *layout(const struct dg_encoder *self)
{
    return is_k3(device_of(self)) ? &dg_ib_layout : NULL;
}

static bool singleturn(const struct dg_encoder *self)
{
    return device_of(self)->setup.model->turns == 1;
}

static int format(const struct dg_encoder *self)
{
    return dg_ib_format(device_of(self)->setup.model, self->nvm);
}

static int power_on(struct dg_encoder *self, dg_ns now)
{
    return dg_ib_power_on(device_of(self), now);
}

static void power_off(struct dg_encoder *self)
{
    dg_ib_power_off(device_of(self));
}

static bool powered(const struct dg_encoder *self)
{
    return device_of(self)->powered;
}

/* What a K3 shows in operation, when nothing lies over it. */
static const char *operation(const struct dg_ib *device)
{
    static const char *const modes[DG_IB_CAM + DG_IB_PROGRAMS + 1u] = {
        [DG_IB_POSITION_K2] = "position", [DG_IB_POSITION] = "position", [DG_IB_SPEED] = "speed",
        [DG_IB_CAM + 1] = "cam-1",        [DG_IB_CAM + 2] = "cam-2",     [DG_IB_CAM + 3] = "cam-3",
        [DG_IB_CAM + 4] = "cam-4",        [DG_IB_CAM + 5] = "cam-5",     [DG_IB_CAM + 6] = "cam-6",
        [DG_IB_CAM + 7] = "cam-7",        [DG_IB_CAM + 8] = "cam-8",
    };

    return device->lost != 0 ? "lost" : modes[device->mode];
}

static const char *mode(const struct dg_ib *device, dg_ns now)
{
    if (!device->powered) {
        return "off";
    }
    if (now < device->ready_at) {
        return "self-test";
    }
    if (device->item != 0) {
        return "read-out";
    }
    return device->answer != 0 ? "parameter" : operation(device);
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

    control_state_begin(to, "leds");
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        const bool blinks = all[i].bit == DG_IB_LED_BA && (leds & DG_IB_LED_BA_BLINKS) != 0;
        dg_scpi_append(to, all[i].name);
        dg_scpi_append(to, blinks ? "blink" : (leds & all[i].bit) != 0 ? "on" : "off");
    }
}

static void put_errors(const struct dg_ib *device, struct dg_scpi *to)
{
    if (is_k3(device) && device->last_error != 0) {
        control_state_hex(to, "errors", device->last_error, 8);
    } else if (!is_k3(device) && device->invalid) {
        control_state_hex(to, "errors", MODULE_ERROR, 4);
    } else {
        control_state_word(to, "errors", "-");
    }
}

static void state(const struct dg_encoder *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_ib *device = device_of(self);
    const struct dg_ib_counters *counters = &device->counters;
    const bool on = device->powered;

    control_state_common(to, on, mode(device, now), on ? dg_ib_position(device, now) : 0);
    put_leds(dg_ib_leds(device, now), to);
    put_errors(device, to);
    control_state_number(to, "frames", counters->cycles);
    control_state_number(to, "commands", counters->commands);
    control_state_number(to, "refused", counters->refused);
    control_state_number(to, "dropped", counters->dropped);
    control_state_number(to, "presets_unset", counters->presets_unset);
    control_state_number(to, "releases_stale", counters->releases_stale);
    control_state_number(to, "crc_errors", counters->crc_errors);
    control_state_number(to, "valid", on && !device->invalid);
    control_state_hex(to, "last_command", device->last_command, 8);
}

const struct dg_encoder_kind dg_kind_interbus = {
    .stack = &dg_ib_stack,
    .layout = layout,
    .singleturn = singleturn,
    .format = format,
    .power_on = power_on,
    .power_off = power_off,
    .powered = powered,
    .state = state,
};

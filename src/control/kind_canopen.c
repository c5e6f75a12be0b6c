/* SPDX-License-Identifier: MIT */
/*
 * The F36x8 as an instrument.
 */
#include "control_private.h"
#include "drehgeber/cia406.h"

#define CODE_MASK 0xFFFFu

static struct dg_co_node *device_of(const struct dg_encoder *self)
{
    return self->device;
}

static const struct dg_store_layout *layout(const struct dg_encoder *self)
{
    return device_of(self)->setup.device->layout;
}

static bool singleturn(const struct dg_encoder *self)
{
    const struct dg_cia406 *encoder = device_of(self)->setup.application;

    return encoder->model->turns == 1;
}

static int format(const struct dg_encoder *self)
{
    return dg_co_format(device_of(self)->setup.device, self->nvm, self->serial);
}

static int power_on(struct dg_encoder *self, dg_ns now)
{
    return dg_co_power_on(device_of(self), now);
}

static void power_off(struct dg_encoder *self)
{
    dg_co_power_off(device_of(self));
}

static bool powered(const struct dg_encoder *self)
{
    return device_of(self)->state != DG_CO_OFF;
}

static const char *mode(const struct dg_co_node *device)
{
    switch (device->state) {
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

static void put_leds(const struct dg_co_node *at, struct dg_scpi *to)
{
    static const char *const names[] = {
        [DG_CIA406_LAMP_OFF] = "off",     [DG_CIA406_LAMP_ON] = "on",
        [DG_CIA406_LAMP_BLINK] = "blink", [DG_CIA406_LAMP_SLOW] = "slow",
        [DG_CIA406_LAMP_FAST] = "fast",   [DG_CIA406_LAMP_FAST_OTHER] = "fast-other",
        [DG_CIA406_LAMP_300] = "300ms",
    };
    const struct dg_cia406_leds leds = dg_cia406_leds(at);

    control_state_begin(to, "leds");
    dg_scpi_append(to, "bus:");
    dg_scpi_append(to, names[leds.bus_pattern]);
    dg_scpi_append(to, "/err:");
    dg_scpi_append(to, names[leds.err_pattern]);
}

/* 1003h, without the manufacturer's part. */
static void put_errors(const struct dg_co_node *device, struct dg_scpi *to)
{
    bool first = true;

    control_state_begin(to, "errors");
    for (uint8_t i = 0; i < device->history_count; i++) {
        control_state_item(to, &first, device->history[i] & CODE_MASK, 4);
    }
    if (first) {
        dg_scpi_append(to, "-");
    }
}

static void state(const struct dg_encoder *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_co_node *device = device_of(self);
    const struct dg_co_counters *counters = &device->counters;
    /* A sample belongs to the bus: this one is a copy's. */
    struct dg_cia406 encoder = *(const struct dg_cia406 *)device->setup.application;
    struct dg_co_node at = *device;

    at.now = now;
    at.setup.application = &encoder;
    if (powered(self)) {
        at.setup.device->sample(&at);
    }
    control_state_common(to, powered(self), mode(device), encoder.position);
    put_leds(&at, to);
    put_errors(device, to);
    control_state_number(to, "frames", counters->rx);
    control_state_number(to, "sent", counters->tx);
    control_state_number(to, "malformed", counters->malformed);
    control_state_number(to, "late_sync", counters->late_sync);
    control_state_number(to, "node", device->id);
    control_state_number(to, "bus_off", device->bus_off);
    control_state_hex(to, "causes", device->active_causes, 8);
}

const struct dg_encoder_kind dg_kind_canopen = {
    .stack = &dg_cia406_stack,
    .layout = layout,
    .singleturn = singleturn,
    .format = format,
    .power_on = power_on,
    .power_off = power_off,
    .powered = powered,
    .state = state,
};

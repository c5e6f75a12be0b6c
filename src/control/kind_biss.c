/* SPDX-License-Identifier: MIT */
/*
 * The S36 BiSS as an instrument.
 */
#include "control_private.h"
#include "drehgeber/biss.h"

static struct dg_biss *device_of(const struct dg_encoder *self)
{
    return self->device;
}

static const struct dg_store_layout *layout(const struct dg_encoder *self)
{
    (void)self;
    return &dg_biss_layout;
}

static bool singleturn(const struct dg_encoder *self)
{
    /* It monitors the sensor whatever its frame has room for. */
    (void)self;
    return false;
}

static int format(const struct dg_encoder *self)
{
    return dg_biss_format(self->nvm);
}

static int power_on(struct dg_encoder *self, dg_ns now)
{
    return dg_biss_power_on(device_of(self), now);
}

static void power_off(struct dg_encoder *self)
{
    dg_biss_power_off(device_of(self));
}

static bool powered(const struct dg_encoder *self)
{
    return device_of(self)->line.state != DG_BISS_OFF;
}

static const char *mode(const struct dg_biss *device, bool ready)
{
    if (device->line.state == DG_BISS_OFF) {
        return "off";
    }
    if (!ready) {
        return "initialising";
    }
    if (device->channel_off) {
        return "channel-off";
    }
    return device->control.state >= DG_BISS_CONTROL_ADDRESS ? "control" : "idle";
}

/* Bits of 69h, each as it reads alone. */
static void put_errors(uint8_t errors, struct dg_scpi *to)
{
    bool first = true;

    control_state_begin(to, "errors");
    for (unsigned bit = 1; bit <= UINT8_MAX; bit <<= 1) {
        if ((errors & bit) != 0) {
            control_state_item(to, &first, bit, 2);
        }
    }
    if (first) {
        dg_scpi_append(to, "-");
    }
}

static void state(const struct dg_encoder *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_biss *device = device_of(self);
    const struct dg_biss_counters *counters = &device->counters;
    const bool on = powered(self);
    const bool ready = now >= device->ready_at;
    const uint8_t flags = on ? dg_biss_flags(device, now) : 0;

    /* While it initialises a frame has position 0. */
    control_state_common(to, on, mode(device, ready), ready ? dg_biss_position(device, now) : 0);
    control_state_word(to, "leds", "-");
    put_errors(on ? dg_biss_errors(device, now) : 0, to);
    control_state_number(to, "frames", counters->frames);
    control_state_number(to, "reads", counters->reads);
    control_state_number(to, "writes", counters->writes);
    control_state_number(to, "refused", counters->refused);
    control_state_number(to, "damaged", counters->damaged);
    control_state_number(to, "commands", counters->commands);
    control_state_number(to, "nerr", flags >> 1);
    control_state_number(to, "nwarn", flags & 1u);
    control_state_number(to, "life", device->life);
    control_state_number(to, "bank", device->bank);
}

const struct dg_encoder_kind dg_kind_biss = {
    .stack = &dg_biss_stack,
    .layout = layout,
    .singleturn = singleturn,
    .format = format,
    .power_on = power_on,
    .power_off = power_off,
    .powered = powered,
    .state = state,
};

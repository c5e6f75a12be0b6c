/* SPDX-License-Identifier: MIT */
/*
 * The S36 RS485 as an instrument.
 */
#include "control_private.h"
#include "drehgeber/hiperface.h"

static struct dg_hf *device_of(const struct dg_encoder *self)
{
    return self->device;
}

static const struct dg_store_layout *layout(const struct dg_encoder *self)
{
    (void)self;
    return &dg_hf_layout;
}

static bool singleturn(const struct dg_encoder *self)
{
    return device_of(self)->setup.model->turns == 1;
}

static int format(const struct dg_encoder *self)
{
    return dg_hf_format(device_of(self)->setup.model, self->nvm);
}

static int power_on(struct dg_encoder *self, dg_ns now)
{
    return dg_hf_power_on(device_of(self), now);
}

static void power_off(struct dg_encoder *self)
{
    dg_hf_power_off(device_of(self));
}

static bool powered(const struct dg_encoder *self)
{
    return device_of(self)->line != DG_HF_OFF;
}

static const char *mode(const struct dg_hf *device)
{
    if (device->line == DG_HF_OFF) {
        return "off";
    }
    if (device->line == DG_HF_DEAF) {
        return "initialising";
    }
    return device->window_end != DG_NEVER ? "window" : "on";
}

static void put_errors(const struct dg_hf *device, struct dg_scpi *to)
{
    bool first = true;

    control_state_begin(to, "errors");
    for (uint8_t i = device->stack_count; i > 0; i--) {
        control_state_item(to, &first, device->stack[i - 1u], 2);
    }
    if (first) {
        dg_scpi_append(to, "-");
    }
}

/* The process channel at the moment of `position`; without power it has no level. */
static void put_sincos(const struct dg_hf *device, dg_ns now, bool on, struct dg_scpi *to)
{
    struct dg_hf_sincos lines = {0};

    dg_hf_sincos(device, now, &lines);
    const struct {
        const char *key;
        int32_t uv;
    } rows[] = {
        {"sin_plus_uv", lines.sin_plus_uv},
        {"sin_minus_uv", lines.sin_minus_uv},
        {"cos_plus_uv", lines.cos_plus_uv},
        {"cos_minus_uv", lines.cos_minus_uv},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        control_state_begin(to, rows[i].key);
        if (on) {
            dg_scpi_append_number(to, rows[i].uv, 0);
        } else {
            dg_scpi_append(to, "-");
        }
    }
}

static void state(const struct dg_encoder *self, dg_ns now, struct dg_scpi *to)
{
    const struct dg_hf *device = device_of(self);
    const struct dg_hf_counters *counters = &device->counters;
    const bool on = powered(self);
    const struct dg_hf_uart uart = dg_hf_uart(device);
    const char parity[2] = {uart.parity};

    control_state_common(to, on, mode(device), on ? dg_hf_position(device, now) : 0);
    control_state_word(to, "leds", "-");
    put_errors(device, to);
    control_state_number(to, "frames", counters->frames);
    control_state_number(to, "replies", counters->replies);
    control_state_number(to, "error_replies", counters->errors);
    control_state_number(to, "others", counters->others);
    control_state_number(to, "damaged", counters->damaged);
    control_state_number(to, "interrupted", counters->interrupted);
    control_state_number(to, "deaf", counters->deaf);
    control_state_hex(to, "address", device->address, 2);
    control_state_number(to, "baud", uart.baud);
    control_state_word(to, "parity", parity);
    control_state_hex(to, "locks", device->locks, 2);
    put_sincos(device, now, on, to);
}

const struct dg_encoder_kind dg_kind_hiperface = {
    .stack = &dg_hf_stack,
    .layout = layout,
    .singleturn = singleturn,
    .format = format,
    .power_on = power_on,
    .power_off = power_off,
    .powered = powered,
    .state = state,
};

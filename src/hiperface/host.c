/* SPDX-License-Identifier: MIT */
/*
 * An encoder with RS485 behind a handle: characters come in one by one, each with the edge of its
 * start bit and its end, and go out as runs without pauses.
 *
 *   event  |40|42|02|           part   0    1    2    3    4    5
 *          at                   is   start end start end start end
 */
#include "drehgeber/hiperface.h"
#include "drehgeber/host_wire.h"

#define RUN_MAX (sizeof((struct dg_host_event *)0)->data)

static void furnish(void *settings, const struct dg_device *device)
{
    struct dg_hf_settings *self = settings;

    self->model = *dg_hf_model_of(device);
    self->address = DG_HF_ADDRESS_DEFAULT;
}

/* ------------------------------------------------------------ setting */

/* A stored setting that cannot be decoded leaves the one in force. */
static void tell_uart(const struct dg_host_line *line, bool stored, struct dg_host_uart *to)
{
    const struct dg_hf *device = line->device;
    struct dg_hf_uart uart = dg_hf_uart(device);

    if (stored) {
        (void)dg_hf_uart_decode(device->uart_stored, &uart);
    }
    *to = (struct dg_host_uart){
        .baud = uart.baud, .parity = (uint8_t)uart.parity, .timeout_bits = uart.timeout_bits};
}

/* ------------------------------------------------------------ out */

static void send(void *ctx, const uint8_t *bytes, size_t n)
{
    dg_host_emit_reply(ctx, bytes, n);
}

static const struct dg_hf_ops ops = {.tx = send};

/* Which form the EEPROM has is the model's to say, and in no state. */
static void arrange(void *settings, struct dg_stack_setup *setup)
{
    struct dg_hf_settings *self = settings;
    const struct dg_hf_model *delivered = setup == NULL ? NULL : setup->model;

    self->model.layout = delivered == NULL ? NULL : delivered->layout;
    if (setup != NULL) {
        setup->address = self->address;
        setup->port = &ops;
    }
}

/* ------------------------------------------------------------ in */

static int check(const struct dg_host_event *event)
{
    const bool start = (event->flags & DG_HOST_START) != 0;

    if (event->kind != DG_HOST_BYTES) {
        return DG_HOST_ERR_WIRE;
    }
    return event->length > RUN_MAX || (event->length == 0 && !start) ? DG_HOST_ERR_ARGUMENT
                                                                     : DG_HOST_OK;
}

static bool only_start(const struct dg_host_event *event)
{
    return (event->flags & DG_HOST_START) != 0;
}

static dg_ns character_ns(const struct dg_host_line *line, const struct dg_host_event *event)
{
    return event->id != 0 ? event->id : dg_host_characters_ns(line, 1);
}

/* The end of the first character is where the start bits of the others are counted from. */
static dg_ns due(const struct dg_host_line *line, const struct dg_host_event *event)
{
    const dg_ns one = character_ns(line, event);

    if ((event->flags & DG_HOST_ENDED) != 0) {
        return dg_after(event->at, line->part * one);
    }
    return dg_after(event->at, (line->part + 1u) / 2u * one);
}

static void hear_byte(struct dg_host_line *line, uint8_t byte, unsigned flags)
{
    /* Half duplex: while its own reply is on the line an encoder hears nothing. */
    if (line->now >= line->until) {
        (void)dg_hf_rx(line->device, line->now, byte, (uint8_t)flags);
    }
}

static bool take(struct dg_host_line *line, const struct dg_host_event *event)
{
    const unsigned damaged = (event->flags & DG_HOST_DAMAGED) != 0 ? DG_HF_RX_DAMAGED : DG_HF_RX_OK;
    const bool ended = (event->flags & DG_HOST_ENDED) != 0;
    const uint32_t part = line->part++;
    const uint32_t last = ended ? event->length : 2u * event->length;

    if (only_start(event) || (!ended && part % 2u == 0)) {
        hear_byte(line, 0, DG_HF_RX_START);
    } else {
        hear_byte(line, event->data[ended ? part : part / 2u], damaged);
    }
    return only_start(event) || line->part == last;
}

/* A character, or a start bit: what it changes in an encoder is its deadline. */
static dg_ns feed(struct dg_host_line *line, const struct dg_host_event *event)
{
    const bool damaged = (event->flags & DG_HOST_DAMAGED) != 0;
    const unsigned ended = damaged ? DG_HF_RX_DAMAGED : DG_HF_RX_OK;
    const unsigned flags = only_start(event) ? DG_HF_RX_START : ended;
    dg_ns next = line->now;

    if (line->now >= line->until) {
        next = dg_hf_rx(line->device, line->now, event->data[0], (uint8_t)flags);
    }
    return next > line->now ? next : dg_hf_step(line->device, line->now);
}

const struct dg_host_wire dg_hf_wire = {
    .stack = &dg_hf_stack,
    .keys = &dg_hf_keys,
    .settings_size = sizeof(struct dg_hf_settings),
    .furnish = furnish,
    .arrange = arrange,
    .check = check,
    .due = due,
    .take = take,
    .feed = feed,
    .uart = tell_uart,
    .state = &dg_hf_check,
};

/* ------------------------------------------------------------ looks */

int dg_host_sincos(const struct dg_host *self, uint64_t at, int32_t to[4])
{
    int result;
    const struct dg_hf *device = dg_host_device(self, &dg_hf_wire, &result);

    if (device != NULL) {
        struct dg_hf_sincos levels;
        dg_hf_sincos(device, at, &levels);
        to[0] = levels.sin_plus_uv;
        to[1] = levels.sin_minus_uv;
        to[2] = levels.cos_plus_uv;
        to[3] = levels.cos_minus_uv;
    }
    return result;
}

/* SPDX-License-Identifier: MIT */
/*
 * The core says what is next, this file makes it happen:
 *
 *   serial -- on_character --> dg_hf_rx() --\
 *                                            > follow(): next deadline, UART setting
 *   timer --- on_deadline ---> dg_hf_step() /
 *                                 \-- send_reply --> serial
 */
#include "encoder.h"

#include <string.h>

/* After every call into the device: its next deadline, and the setting it may have changed. */
static void follow(struct lx_encoder *self, dg_ns deadline)
{
    lx_timer_at(&self->timer, deadline);
    const struct dg_hf_uart uart = dg_hf_uart(&self->device);
    if (uart.baud != self->uart.baud || uart.parity != self->uart.parity) {
        self->uart = uart;
        lx_serial_set(self->port, &uart);
    }
}

static void on_deadline(void *ctx, dg_ns now)
{
    struct lx_encoder *self = ctx;
    follow(self, dg_hf_step(&self->device, now));
}

static void on_character(void *ctx, dg_ns now, const struct lx_character *character)
{
    struct lx_encoder *self = ctx;
    follow(self, dg_hf_rx(&self->device, now, character->byte, character->flags));
}

/* Called inside dg_hf_step(), which may run late: the reply starts when it really does. */
static void send_reply(void *ctx, const uint8_t *bytes, size_t n)
{
    struct lx_encoder *self = ctx;
    lx_serial_send(self->port, lx_now(), bytes, n);
}

static const struct dg_hf_ops device_ops = {.tx = send_reply};

static int power_on(struct lx_encoder *self, const struct lx_encoder_setup *setup, dg_ns now,
                    struct lx_error *error)
{
    const struct dg_hf_setup device = {
        .model = &setup->settings->model,
        .world = &setup->settings->world,
        .nvm = setup->nvm,
        .ops = &device_ops,
        .ctx = self,
    };
    if (dg_hf_init(&self->device, &device) != DG_OK ||
        dg_hf_power_on(&self->device, now) != DG_OK) {
        return lx_fail(error, "the encoder does not start: not its EEPROM");
    }
    self->uart = dg_hf_uart(&self->device);
    return 0;
}

int lx_encoder_open(struct lx_encoder *self, const struct lx_encoder_setup *setup, dg_ns now,
                    struct lx_error *error)
{
    *self = (struct lx_encoder){.port = NULL};
    if (power_on(self, setup, now, error) != 0) {
        return -1;
    }
    struct lx_serial_setup line = {
        .event = setup->event,
        .say = setup->say,
        .where = setup->where,
        .uart = self->uart,
        .stored = self->uart,
        .pace = setup->settings->pace,
        .any_line = setup->settings->any_line,
        .rx = on_character,
        .ctx = self,
    };
    /* A stored setting that cannot be decoded leaves the one in force. */
    (void)dg_hf_uart_decode(self->device.uart_stored, &line.stored);
    const int result = lx_timer_open(&self->timer, setup->event, on_deadline, self);
    if (result < 0) {
        return lx_fail(error, "no timer: %s", strerror(-result));
    }
    self->port = setup->open(&line, error);
    if (self->port == NULL) {
        return -1;
    }
    /* The first deadline: the end of the start-up window. */
    follow(self, dg_hf_step(&self->device, now));
    return 0;
}

void lx_encoder_close(struct lx_encoder *self)
{
    dg_hf_power_off(&self->device);
    lx_serial_close(self->port);
    lx_timer_close(&self->timer);
    self->port = NULL;
}

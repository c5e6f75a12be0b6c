/* SPDX-License-Identifier: MIT */
/* An S3684 on the UART that the board's devicetree calls `encoder-uart`, one turn in ten seconds.
 */
#include <stdalign.h>

#include <drehgeber/drehgeber.h>
#include <zephyr/device.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>

static alignas(DG_HOST_ALIGN) uint8_t memory[8192];
static const struct device *const uart = DEVICE_DT_GET(DT_ALIAS(encoder_uart));

static uint64_t now_ns(void)
{
    return k_ticks_to_ns_floor64((uint64_t)k_uptime_ticks());
}

static void on_sent(void *ctx, const struct dg_host_event *event)
{
    (void)ctx;
    for (unsigned i = 0; i < event->length; i++) {
        uart_poll_out(uart, event->data[i]);
    }
}

int main(void)
{
    const struct uart_config setting = {
        .baudrate = 9600,
        .parity = UART_CFG_PARITY_EVEN,
        .stop_bits = UART_CFG_STOP_BITS_1,
        .data_bits = UART_CFG_DATA_BITS_8,
        .flow_ctrl = UART_CFG_FLOW_CTRL_NONE,
    };
    struct dg_host *encoder = dg_host_init(memory, sizeof memory, &dg_s3684_rs485, &dg_hf_wire);
    struct dg_host_event byte = {.kind = DG_HOST_BYTES, .flags = DG_HOST_ENDED, .length = 1};

    (void)uart_configure(uart, &setting);
    dg_host_listen(encoder, on_sent, NULL);
    (void)dg_host_power(encoder, now_ns(), true);
    dg_host_shaft(encoder, now_ns(), 0, DG_TURN / 10);
    for (;;) {
        while (uart_poll_in(uart, &byte.data[0]) == 0) {
            byte.at = now_ns();
            (void)dg_host_send(encoder, &byte);
        }
        (void)dg_host_step(encoder, now_ns());
        k_yield();
    }
}

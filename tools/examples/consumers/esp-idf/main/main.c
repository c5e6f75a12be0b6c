/* SPDX-License-Identifier: MIT */
/* An S3684 on UART 1, one turn in ten seconds; TX 17, RX 18 and RTS 16 for an RS485 transceiver. */
#include <stdalign.h>

#include <drehgeber/drehgeber.h>
#include <driver/uart.h>
#include <esp_timer.h>

#define BUFFER 256

static alignas(DG_HOST_ALIGN) uint8_t memory[8192];

static uint64_t now_ns(void)
{
    return (uint64_t)esp_timer_get_time() * 1000;
}

static void on_sent(void *ctx, const struct dg_host_event *event)
{
    (void)ctx;
    uart_write_bytes(UART_NUM_1, event->data, event->length);
}

static void open_port(void)
{
    const uart_config_t setting = {
        .baud_rate = 9600,
        .data_bits = UART_DATA_8_BITS,
        .parity = UART_PARITY_EVEN,
        .stop_bits = UART_STOP_BITS_1,
    };

    uart_driver_install(UART_NUM_1, BUFFER, 0, 0, NULL, 0);
    uart_param_config(UART_NUM_1, &setting);
    uart_set_pin(UART_NUM_1, 17, 18, 16, UART_PIN_NO_CHANGE);
    uart_set_mode(UART_NUM_1, UART_MODE_RS485_HALF_DUPLEX);
}

void app_main(void)
{
    struct dg_host *encoder = dg_host_init(memory, sizeof memory, &dg_s3684_rs485, &dg_hf_wire);
    struct dg_host_event byte = {.kind = DG_HOST_BYTES, .flags = DG_HOST_ENDED, .length = 1};

    open_port();
    dg_host_listen(encoder, on_sent, NULL);
    dg_host_power(encoder, now_ns(), true);
    dg_host_shaft(encoder, now_ns(), 0, DG_TURN / 10);
    for (;;) {
        if (uart_read_bytes(UART_NUM_1, byte.data, 1, 1) == 1) {
            byte.at = now_ns();
            dg_host_send(encoder, &byte);
        }
        dg_host_step(encoder, now_ns());
    }
}

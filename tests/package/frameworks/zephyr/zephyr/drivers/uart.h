/* SPDX-License-Identifier: MIT */
/* As much of Zephyr as the example calls. */
#ifndef ZEPHYR_DRIVERS_UART_H
#define ZEPHYR_DRIVERS_UART_H

#include <stdint.h>

#include <zephyr/device.h>

enum { UART_CFG_PARITY_EVEN = 2 };
enum { UART_CFG_STOP_BITS_1 = 1 };
enum { UART_CFG_DATA_BITS_8 = 3 };
enum { UART_CFG_FLOW_CTRL_NONE = 0 };
struct uart_config {
    uint32_t baudrate;
    uint8_t parity;
    uint8_t stop_bits;
    uint8_t data_bits;
    uint8_t flow_ctrl;
};

int uart_configure(const struct device *device, const struct uart_config *setting);
int uart_poll_in(const struct device *device, unsigned char *byte);
void uart_poll_out(const struct device *device, unsigned char byte);

#endif

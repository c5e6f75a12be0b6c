/* SPDX-License-Identifier: MIT */
/* As much of ESP-IDF as the example calls. */
#ifndef DRIVER_UART_H
#define DRIVER_UART_H

#include <stddef.h>
#include <stdint.h>

#define UART_PIN_NO_CHANGE (-1)

typedef enum { UART_NUM_0, UART_NUM_1 } uart_port_t;
typedef enum { UART_DATA_8_BITS = 3 } uart_word_length_t;
typedef enum { UART_PARITY_EVEN = 2 } uart_parity_t;
typedef enum { UART_STOP_BITS_1 = 1 } uart_stop_bits_t;
typedef enum { UART_MODE_RS485_HALF_DUPLEX = 1 } uart_mode_t;
typedef struct {
    int baud_rate;
    uart_word_length_t data_bits;
    uart_parity_t parity;
    uart_stop_bits_t stop_bits;
} uart_config_t;

int uart_driver_install(uart_port_t port, int rx, int tx, int events, void **queue, int flags);
int uart_param_config(uart_port_t port, const uart_config_t *setting);
int uart_set_pin(uart_port_t port, int tx, int rx, int rts, int cts);
int uart_set_mode(uart_port_t port, uart_mode_t mode);
int uart_read_bytes(uart_port_t port, void *bytes, uint32_t n, uint32_t ticks);
int uart_write_bytes(uart_port_t port, const void *bytes, size_t n);

#endif

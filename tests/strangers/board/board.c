/* SPDX-License-Identifier: MIT */
/* An S36 with RS485 on a microcontroller with a UART: all that a board has to add to the library. */
#include <string.h>

#include "drehgeber/drehgeber.h"
#include "mcu.h"

static uint8_t eeprom[MCU_FLASH_SIZE]; /* in front of flash */

static int read_eeprom(void *ctx, uint32_t address, void *to, size_t n)
{
    (void)ctx;
    memcpy(to, eeprom + address, n);
    return DG_OK;
}

static int write_eeprom(void *ctx, uint32_t address, const void *from, size_t n)
{
    (void)ctx;
    memcpy(eeprom + address, from, n);
    return DG_OK;
}

static int sync_eeprom(void *ctx)
{
    (void)ctx;
    return mcu_write_flash(eeprom) ? DG_OK : DG_ERR_IO;
}

static uint64_t read_clock(void)
{
    static uint64_t ticks;

    ticks += (uint32_t)(mcu_ticks() - (uint32_t)ticks);
    return ticks * (1000000000u / MCU_HZ);
}

int main(void)
{
    static _Alignas(DG_HOST_ALIGN) uint8_t memory[16384];
    static const struct dg_nvm_ops nvm = {read_eeprom, write_eeprom, sync_eeprom};
    struct dg_host *encoder = dg_host_init(memory, sizeof memory, &dg_s3684_rs485, &dg_hf_wire);
    struct dg_host_event in = {.kind = DG_HOST_BYTES, .flags = DG_HOST_ENDED, .length = 1};
    struct dg_host_event out = {.length = 0};
    struct dg_host_uart uart;
    uint8_t sent = 0;

    memcpy(eeprom, mcu_flash, sizeof eeprom);
    (void)dg_host_memory_port(encoder, &(const struct dg_nvm){&nvm, NULL});
    dg_host_shaft(encoder, 0, DG_TURN / 4, 0);
    (void)dg_host_power(encoder, read_clock(), true);
    while (dg_host_uart(encoder, &uart) == DG_HOST_OK) {
        if (MCU_UART.divider != MCU_HZ / uart.baud) {
            MCU_UART.divider = MCU_HZ / uart.baud;
        }
        if ((MCU_UART.state & MCU_RX_FILLED) != 0) {
            in.at = read_clock();
            in.data[0] = (uint8_t)MCU_UART.data;
            (void)dg_host_send(encoder, &in);
        }
        (void)dg_host_step(encoder, read_clock());
        if (sent < out.length && (MCU_UART.state & MCU_TX_FULL) == 0) {
            MCU_UART.data = out.data[sent++];
        } else if (sent == out.length && dg_host_receive(encoder, &out) > 0) {
            sent = 0;
        }
    }
    return 1;
}

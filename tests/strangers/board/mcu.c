/* SPDX-License-Identifier: MIT */
/* What a vendor gives: from reset to main(). QEMU's UART has neither parity nor a rate. */
#include "mcu.h"

#include <string.h>

#define REG(address) (*(volatile uint32_t *)(uintptr_t)(address))
#define TIMER 0x40000000u /* control, value, reload: it counts down */
#define TIMER_VALUE REG(TIMER + 4u)
#define ENABLE_RX_TX 3u
#define FASTEST 16u

extern uint32_t bss_begin[], bss_end[], stack_end[];
int main(void);
void reset(void);

static uint8_t page[MCU_FLASH_SIZE];
const uint8_t *const mcu_flash = page;

bool mcu_write_flash(const uint8_t from[MCU_FLASH_SIZE])
{
    memcpy(page, from, sizeof page);
    return true;
}

uint32_t mcu_ticks(void)
{
    return ~TIMER_VALUE;
}

void reset(void)
{
    for (volatile uint32_t *to = bss_begin; to != bss_end; to++) {
        *to = 0;
    }
    memset(page, 0xFF, sizeof page); /* a new chip each time */
    MCU_UART.divider = FASTEST;
    MCU_UART.control = ENABLE_RX_TX;
    REG(TIMER + 8u) = UINT32_MAX;
    TIMER_VALUE = UINT32_MAX;
    REG(TIMER) = 1u;
    (void)main();
    for (;;) {
    }
}

typedef void (*vector)(void);
__attribute__((section(".vectors"), used)) static const vector vectors[16] = {
    (vector)(uintptr_t)stack_end, reset};

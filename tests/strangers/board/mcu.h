/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a vendor gives with a microcontroller: registers, a clock, flash. This one is Arm's MPS2 with
 * the image AN385, a Cortex-M3, as QEMU has it; its flash is made up.
 */
#ifndef TESTS_STRANGERS_MCU_H
#define TESTS_STRANGERS_MCU_H

#include <stdbool.h>
#include <stdint.h>

#define MCU_HZ 25000000u
#define MCU_FLASH_SIZE 4096u

/** A UART. */
struct mcu_uart {
    uint32_t data;
    uint32_t state; /**< MCU_TX_FULL, MCU_RX_FILLED */
    uint32_t control;
    uint32_t interrupt;
    uint32_t divider; /**< of MCU_HZ, for a bit */
};
#define MCU_UART (*(volatile struct mcu_uart *)(uintptr_t)0x40004000u)
#define MCU_TX_FULL 1u
#define MCU_RX_FILLED 2u

/** Counts at MCU_HZ, and begins anew behind UINT32_MAX. */
uint32_t mcu_ticks(void);

/** A page that keeps its content without power. */
extern const uint8_t *const mcu_flash;
/** Erase it and write it. @return false: it is worn out */
bool mcu_write_flash(const uint8_t from[MCU_FLASH_SIZE]);

#endif

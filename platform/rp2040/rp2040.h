/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Registers of the RP2040 that are used here, with the names and addresses of its data sheet. A
 * register of a peripheral is also there to set and to clear single bits (2.1.2); not so those of
 * SIO and of the processor.
 */
#ifndef RP2040_H
#define RP2040_H

#include <stdint.h>

/** The register at an address. */
#define REG(address) (*(volatile uint32_t *)(uintptr_t)(address))
#define REG_SET(address) REG((address) + 0x2000u)
#define REG_CLR(address) REG((address) + 0x3000u)

/** Resets (2.14), clocks (2.15), crystal (2.16), PLL of the system clock (2.18). */
#define RESETS_RESET 0x4000C000u
#define RESETS_DONE 0x4000C008u
#define CLK_REF_CTRL 0x40008030u
#define CLK_REF_SELECTED 0x40008038u
#define CLK_SYS_CTRL 0x4000803Cu
#define CLK_SYS_SELECTED 0x40008044u
#define CLK_PERI_CTRL 0x40008048u
#define XOSC_CTRL 0x40024000u
#define XOSC_STATUS 0x40024004u
#define XOSC_STARTUP 0x4002400Cu
#define PLL_SYS_CS 0x40028000u
#define PLL_SYS_PWR 0x40028004u
#define PLL_SYS_FBDIV 0x40028008u
#define PLL_SYS_PRIM 0x4002800Cu

/** Timer (4.6); its tick comes from the watchdog (4.7). */
#define WATCHDOG_TICK 0x4005802Cu
#define TIMER_ALARM0 0x40054010u
#define TIMER_RAWH 0x40054024u
#define TIMER_RAWL 0x40054028u
#define TIMER_INTR 0x40054034u
#define TIMER_INTE 0x40054038u

/** Pins (2.19) and SIO (2.3.1). */
#define IO_CTRL(pin) (0x40014004u + 8u * (pin))
#define IO_INTR(pin) (0x400140F0u + 4u * ((pin) / 8u))
#define IO_INTE(pin) (0x40014100u + 4u * ((pin) / 8u))
#define IO_EDGE_LOW(pin) (1u << (4u * ((pin) % 8u) + 2u))
#define PAD(pin) (0x4001C004u + 4u * (pin))
#define PAD_PULL_DOWN (1u << 2)
#define SIO_IN 0xD0000004u
#define SIO_OUT_SET 0xD0000014u
#define SIO_OUT_CLR 0xD0000018u
#define SIO_OE_SET 0xD0000024u

/** UARTs (4.2); the offsets of their registers. */
#define UART0 0x40034000u
#define UART1 0x40038000u
#define UART_DR 0x00u
#define UART_FR 0x18u
#define UART_IBRD 0x24u
#define UART_FBRD 0x28u
#define UART_LCR_H 0x2Cu
#define UART_CR 0x30u
#define UART_IMSC 0x38u

/** PWM (4.5): registers of a slice. */
#define PWM_CSR(slice) (0x40050000u + 0x14u * (slice))
#define PWM_CC(slice) (0x4005000Cu + 0x14u * (slice))
#define PWM_TOP(slice) (0x40050010u + 0x14u * (slice))

/** SPI (4.4); the offsets of its registers. */
#define SPI0 0x4003C000u
#define SPI_CR0 0x00u
#define SPI_CR1 0x04u
#define SPI_DR 0x08u
#define SPI_SR 0x0Cu
#define SPI_CPSR 0x10u

/** PIO (3.7); the offsets of their registers, of those of a state machine for machine 0. */
#define PIO0 0x50200000u
#define PIO1 0x50300000u
#define PIO_CTRL 0x00u
#define PIO_FSTAT 0x04u
#define PIO_TXF(machine) (0x10u + 4u * (machine))
#define PIO_RXF(machine) (0x20u + 4u * (machine))
#define PIO_IRQ 0x30u
#define PIO_INSTR_MEM(at) (0x48u + 4u * (at))
#define PIO_SM(machine) (0xC8u + 0x18u * (machine))
#define PIO_SM_CLKDIV 0x00u
#define PIO_SM_EXECCTRL 0x04u
#define PIO_SM_SHIFTCTRL 0x08u
#define PIO_SM_ADDR 0x0Cu
#define PIO_SM_INSTR 0x10u
#define PIO_SM_PINCTRL 0x14u
#define PIO_IRQ0_INTE 0x12Cu

/** The processor (2.4): SysTick, interrupts, vectors. */
#define SYST_CSR 0xE000E010u
#define SYST_RVR 0xE000E014u
#define SYST_CVR 0xE000E018u
#define NVIC_ISER 0xE000E100u
#define NVIC_ICER 0xE000E180u
#define NVIC_IPR(irq) (0xE000E400u + ((irq) & ~3u))
#define SCB_ICSR 0xE000ED04u
#define SCB_VTOR 0xE000ED08u
#define SCB_SHPR3 0xE000ED20u

/** Interrupts (2.3.2). */
#define IRQ_TIMER_0 0u
#define IRQ_PIO0_0 7u
#define IRQ_PIO1_0 9u
#define IRQ_IO_BANK0 13u
#define IRQ_UART0 20u
#define IRQ_UART1 21u

#endif

/* SPDX-License-Identifier: MIT */
#include "board.h"

#include "rp2040.h"

/* IO_BANK0, PADS_BANK0, PIO0, PIO1, PLL_SYS, PWM, SPI0, TIMER, UART0, UART1 */
#define PERIPHERALS                                                                                \
    (1u << 5 | 1u << 8 | 1u << 10 | 1u << 11 | 1u << 12 | 1u << 14 | 1u << 16 | 1u << 21 |         \
     1u << 22 | 1u << 23)
#define CRYSTAL_MHZ 12u

static uint32_t cycles_at_zero; /* what SysTick has counted when the timer was at 0, modulo 2^24 */
static unsigned locks;

static void wait_for(uint32_t address, uint32_t bits)
{
    while ((REG(address) & bits) != bits) {
    }
}

/* 12 MHz * 125 / 6 / 2 = 125 MHz. */
static void start_clocks(void)
{
    REG(XOSC_CTRL) = 0xAA0u; /* 1 to 15 MHz */
    REG(XOSC_STARTUP) = 47u; /* 1 ms, in units of 256 cycles */
    REG_SET(XOSC_CTRL) = 0xFAB000u;
    wait_for(XOSC_STATUS, 1u << 31);
    REG(CLK_REF_CTRL) = 2u;
    wait_for(CLK_REF_SELECTED, 1u << 2);
    REG_CLR(RESETS_RESET) = PERIPHERALS;
    wait_for(RESETS_DONE, PERIPHERALS);
    REG(PLL_SYS_FBDIV) = 125u;
    REG_CLR(PLL_SYS_PWR) = 1u << 0 | 1u << 5;
    wait_for(PLL_SYS_CS, 1u << 31);
    REG(PLL_SYS_PRIM) = 6u << 16 | 2u << 12;
    REG_CLR(PLL_SYS_PWR) = 1u << 3;
    REG(CLK_SYS_CTRL) = 1u;
    wait_for(CLK_SYS_SELECTED, 1u << 1);
    REG(CLK_PERI_CTRL) = 1u << 11;
}

/* SysTick counts down. */
static uint32_t count_up_of(uint32_t count)
{
    return 0u - count;
}

static void start_time(void)
{
    REG(WATCHDOG_TICK) = 1u << 9 | CRYSTAL_MHZ;
    REG(SYST_RVR) = 0xFFFFFFu;
    REG(SYST_CVR) = 0;
    REG(SYST_CSR) = 1u << 2 | 1u << 0;
    /* Both come from the crystal: what is between them stays what it is. */
    const uint32_t before = REG(TIMER_RAWL);
    while (REG(TIMER_RAWL) == before) {
    }
    cycles_at_zero = count_up_of(REG(SYST_CVR)) - REG(TIMER_RAWL) * (BOARD_HZ / 1000000u);
}

void board_start(void)
{
    start_clocks();
    start_time();
    REG(TIMER_INTE) = 1u;
    board_interrupt(IRQ_TIMER_0, BOARD_LOW);
}

dg_ns board_at(uint32_t count)
{
    uint32_t high, low;

    do {
        high = REG(TIMER_RAWH);
        low = REG(TIMER_RAWL);
    } while (REG(TIMER_RAWH) != high);
    /* The timer says which microsecond it is, or is soon: SysTick, which goes round every 134 ms,
       by how many cycles it was another moment. */
    const uint32_t ahead = count_up_of(count) - cycles_at_zero - low * (BOARD_HZ / 1000000u);
    const int32_t cycles = (int32_t)(ahead << 8) >> 8;
    return ((dg_ns)high << 32) * 1000u + (dg_ns)low * 1000u +
           (dg_ns)(int64_t)(cycles * (int32_t)BOARD_CYCLE_NS);
}

dg_ns board_now(void)
{
    return board_at(REG(SYST_CVR));
}

#define SLEEP_LEAST DG_US(20)
#define SLEEP_MOST DG_S(1)

void on_timer(void);
void on_timer(void)
{
    REG(TIMER_INTR) = 1u;
}

void board_sleep(dg_ns until)
{
    const dg_ns span = dg_earliest(dg_elapsed(until, board_now()), SLEEP_MOST);

    if (span < SLEEP_LEAST) {
        return;
    }
    const uint32_t us = (uint32_t)span / 1000u - 10u;
    REG(TIMER_ALARM0) = REG(TIMER_RAWL) + us;
    __asm volatile("wfe"); /* not when there was one since the last time */
}

void board_pin(uint32_t pin, enum board_function function)
{
    REG(PAD(pin)) = 0x52u; /* input on, 4 mA, Schmitt trigger */
    REG(IO_CTRL(pin)) = (uint32_t)function;
}

void board_interrupt(uint32_t irq, enum board_priority priority)
{
    const uint32_t at = NVIC_IPR(irq), shift = 8u * (irq & 3u);

    REG(at) = (REG(at) & ~(0xFFu << shift)) | (uint32_t)priority << (shift + 6u);
    REG(NVIC_ISER) = 1u << irq;
}

void board_lock(void)
{
    __asm volatile("cpsid i" ::: "memory");
    locks++;
}

void board_unlock(void)
{
    if (--locks == 0) {
        __asm volatile("cpsie i" ::: "memory");
    }
}

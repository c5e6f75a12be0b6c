/* SPDX-License-Identifier: MIT */
/* From power-on to main(). */
#include "board.h"
#include "rp2040.h"

extern uint32_t ram_load[], ram_begin[], ram_end[], bss_begin[], bss_end[], stack_end[];
int main(void);
void start(void);

/* In flash: there is nothing in SRAM yet. */
__attribute__((section(".entry"), noreturn, used)) void start(void)
{
    const uint32_t *from = ram_load;

    for (volatile uint32_t *to = ram_begin; to != ram_end; to++) { /* no memcpy() is there yet */
        *to = *from++;
    }
    for (volatile uint32_t *to = bss_begin; to != bss_end; to++) {
        *to = 0;
    }
    REG(SCB_VTOR) = (uint32_t)(uintptr_t)ram_begin;
    (void)((int (*)(void))((uintptr_t)main | 1u))(); /* too far away for a branch */
    for (;;) {
    }
}

static void hang(void)
{
    for (;;) {
    }
}

/* Each image has those that it uses. */
#define VECTOR(name) void name(void) __attribute__((weak, alias("hang")))
VECTOR(on_pendsv);
VECTOR(on_timer);
VECTOR(on_pio0);
VECTOR(on_pio1);
VECTOR(on_pins);
VECTOR(on_uart0);
VECTOR(on_uart1);

typedef void (*vector)(void);

__attribute__((section(".vectors"), used)) static const vector vectors[48] = {
    [0] = (vector)(uintptr_t)stack_end,
    [1] = start,
    [2] = hang,
    [3] = hang,
    [14] = on_pendsv,
    [16 + IRQ_TIMER_0] = on_timer,
    [16 + IRQ_PIO0_0] = on_pio0,
    [16 + IRQ_PIO1_0] = on_pio1,
    [16 + IRQ_IO_BANK0] = on_pins,
    [16 + IRQ_UART0] = on_uart0,
    [16 + IRQ_UART1] = on_uart1,
};

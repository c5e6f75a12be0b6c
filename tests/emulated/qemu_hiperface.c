/* SPDX-License-Identifier: MIT */
/* The S36 with RS485 on QEMU's mps2-an385, at its first UART, for qemu.py. All of it is code of a
   Cortex-M0+; the board has a Cortex-M3, which runs that. */
#include <string.h>

#include "drehgeber/hiperface.h"

#define REG(address) (*(volatile uint32_t *)(uintptr_t)(address))
#define TIMER 0x40000000u /* counts down at 25 MHz */
#define UART 0x40004000u
#define TX_FULL 1u
#define RX_FILLED 2u

extern uint32_t bss_begin[], bss_end[], stack_end[];

static uint8_t eeprom[4096];
static struct dg_world world;
static struct dg_hf device;

static int nvm_read(void *ctx, uint32_t address, void *to, size_t n)
{
    (void)ctx;
    memcpy(to, eeprom + address, n);
    return DG_OK;
}

static int nvm_write(void *ctx, uint32_t address, const void *from, size_t n)
{
    (void)ctx;
    memcpy(eeprom + address, from, n);
    return DG_OK;
}

static void tx(void *ctx, const uint8_t *bytes, size_t n)
{
    (void)ctx;
    for (size_t i = 0; i < n; i++) {
        while ((REG(UART + 4u) & TX_FULL) != 0) {
        }
        REG(UART) = bytes[i];
    }
}

static dg_angle quarter(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return DG_TURN / 4;
}

static dg_ns now(void)
{
    static uint32_t last;
    static uint64_t rounds;
    const uint32_t count = ~REG(TIMER + 4u);

    rounds += count < last;
    last = count;
    return (rounds << 32 | count) * 40u;
}

static void run(void)
{
    static const struct dg_nvm_ops nvm = {.read = nvm_read, .write = nvm_write};
    static const struct dg_hf_ops ops = {.tx = tx};
    const struct dg_hf_setup setup = {.model = dg_hf_model_of(&dg_s3684_rs485),
                                      .world = &world,
                                      .nvm = {&nvm, NULL},
                                      .ops = &ops};

    REG(UART + 0x10u) = 16u; /* fastest */
    REG(UART + 0x08u) = 3u;
    REG(TIMER + 8u) = UINT32_MAX;
    REG(TIMER + 4u) = UINT32_MAX;
    REG(TIMER) = 1u;
    memset(eeprom, 0xFF, sizeof eeprom);
    dg_world_init(&world);
    world.angle = quarter;
    (void)dg_hf_format(setup.model, setup.nvm);
    (void)dg_hf_init(&device, &setup);
    (void)dg_hf_power_on(&device, now());
    for (;;) {
        if ((REG(UART + 4u) & RX_FILLED) != 0) {
            (void)dg_hf_rx(&device, now(), (uint8_t)REG(UART), DG_HF_RX_OK);
        }
        (void)dg_hf_step(&device, now());
    }
}

void reset(void);
void reset(void)
{
    for (volatile uint32_t *to = bss_begin; to != bss_end; to++) {
        *to = 0;
    }
    run();
}

typedef void (*vector)(void);
__attribute__((section(".vectors"), used)) static const vector vectors[16] = {
    (vector)(uintptr_t)stack_end, reset};

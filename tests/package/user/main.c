/* SPDX-License-Identifier: MIT */
/* A user's first program: an encoder in virtual time, asked once for its position. */
#include <stdio.h>
#include <string.h>

#include "drehgeber/drehgeber.h"

static uint8_t memory[16384];

static int read_memory(void *ctx, uint32_t address, void *to, size_t n)
{
    (void)ctx;
    memcpy(to, memory + address, n);
    return DG_OK;
}

static int write_memory(void *ctx, uint32_t address, const void *from, size_t n)
{
    (void)ctx;
    memcpy(memory + address, from, n);
    return DG_OK;
}

static void print_reply(void *ctx, const uint8_t *bytes, size_t n)
{
    (void)ctx;
    for (size_t i = 0; i < n; i++) {
        printf("%02X%s", bytes[i], i + 1 < n ? " " : "\n");
    }
}

int main(void)
{
    static const struct dg_nvm_ops nvm = {read_memory, write_memory, NULL};
    static const struct dg_hf_ops ops = {print_reply};
    static const uint8_t request[] = {0x40, 0x42, 0x02};
    const struct dg_device *device = dg_device_find("s3684-rs485");
    struct dg_world world;
    struct dg_hf encoder;
    dg_ns now = DG_S(1);

    dg_world_init(&world);
    struct dg_hf_setup setup = {dg_hf_model_of(device), &world, {&nvm, NULL}, &ops, NULL};
    if (dg_hf_format(setup.model, setup.nvm) || dg_hf_init(&encoder, &setup) ||
        dg_hf_power_on(&encoder, 0)) {
        return 1;
    }
    dg_hf_step(&encoder, now);
    for (size_t i = 0; i < sizeof request; i++) {
        now += dg_bit_times_ns(11, 9600);
        dg_hf_rx(&encoder, now, request[i], DG_HF_RX_OK);
    }
    for (now = dg_hf_step(&encoder, now); now != DG_NEVER;) {
        now = dg_hf_step(&encoder, now);
    }
    printf("drehgeber %s\n", dg_version());
    return 0;
}

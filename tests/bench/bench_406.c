/* SPDX-License-Identifier: MIT */
/*
 * What a position of the F36x8 with scaling and USF costs, in virtual time.
 *
 * bench_406                  samples and SDO reads per second, one figure a line
 * bench_406 --callgrind N    exactly N samples with the hook of 6004h and nothing measured: the
 *                            instructions of one are the difference of two runs, divided by the
 *                            difference of N
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "ram_nvm.h"

#define SECONDS_EACH 1.0
#define BATCH 10000u
#define NODE_ID 0x3Fu

static const struct dg_cia406_model model = {.turns = 4096, .device = &dg_cia406_multiturn};
static struct ram_nvm nvm;
static struct dg_world world;
static struct dg_cia406 encoder;
static struct dg_co_node node;
static struct dg_can_frame answer;
static dg_angle shaft;

static dg_angle angle(void *ctx, dg_ns now)
{
    (void)ctx;
    (void)now;
    return shaft;
}

static void send(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    answer = *frame;
}

static void ask(uint8_t command, uint16_t index, uint32_t value)
{
    struct dg_can_frame frame = {.id = 0x600u + NODE_ID, .dlc = 8, .data = {command}};

    dg_store_le16(&frame.data[1], index);
    dg_store_le32(&frame.data[4], value);
    answer.data[0] = 0x80;
    (void)dg_co_rx(&node, node.now, &frame);
    if (answer.data[0] == 0x80) {
        (void)fprintf(stderr, "%04Xh was refused\n", index);
        exit(1);
    }
}

static const struct dg_co_object *position_row(void)
{
    const struct dg_co_object *row = model.device->objects;

    while (row->index != 0x6004) {
        row++;
    }
    return row;
}

/* What a TPDO with the position does for it. */
static void sample(const struct dg_co_object *row)
{
    uint32_t value;

    shaft += DG_TURN / 7;
    node.setup.device->sample(&node);
    (void)row->hook(&node, row, DG_CO_READ, &value);
}

static void read_by_sdo(const struct dg_co_object *row)
{
    shaft += DG_TURN / 7;
    ask(0x40, row->index, 0);
}

static bool start(void)
{
    static const struct dg_co_ops ops = {.send = send};
    const struct dg_co_setup setup = {
        .device = model.device,
        .world = &world,
        .nvm = ram_nvm_port(&nvm),
        .ops = &ops,
        .application = &encoder,
    };

    dg_world_init(&world);
    world.angle = angle;
    ram_nvm_init(&nvm, dg_store_size(model.device->layout));
    return dg_co_format(model.device, ram_nvm_port(&nvm), 1) == DG_OK &&
           dg_cia406_init(&encoder, &model) == DG_OK && dg_co_init(&node, &setup) == DG_OK &&
           dg_co_power_on(&node, 0) == DG_OK;
}

static double now_s(void)
{
    struct timespec t;

    (void)timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void measure(const char *what, void (*act)(const struct dg_co_object *row))
{
    const struct dg_co_object *row = position_row();
    const double begin = now_s();
    uint64_t count = 0;
    double elapsed;

    do {
        for (unsigned i = 0; i < BATCH; i++) {
            act(row);
        }
        count += BATCH;
        elapsed = now_s() - begin;
    } while (elapsed < SECONDS_EACH);
    (void)printf("%-32s %10.0f\n", what, (double)count / elapsed);
}

int main(int argc, char **argv)
{
    const bool counted = argc == 3 && strcmp(argv[1], "--callgrind") == 0;

    if (argc != 1 && !counted) {
        (void)fprintf(stderr, "usage: bench_406 [--callgrind N]\n");
        return 2;
    }
    if (!start()) {
        return 1;
    }
    ask(0x23, 0x6001, 3600);
    ask(0x23, 0x6002, 36000);
    ask(0x2B, 0x6000, DG_CIA406_USF | DG_CIA406_SCALING | DG_CIA406_CCW);
    if (counted) {
        const struct dg_co_object *row = position_row();
        for (unsigned long n = strtoul(argv[2], NULL, 10); n > 0; n--) {
            sample(row);
        }
    } else {
        measure("6004h samples/s, scaling and USF", sample);
        measure("6004h SDO reads/s", read_by_sdo);
    }
    return 0;
}

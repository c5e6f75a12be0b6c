/* SPDX-License-Identifier: MIT */
/*
 * How fast a CANopen node of the F36x8 is in virtual time: expedited upload of 1000h, and SYNC
 * answered by a TPDO with one mapped U32 (6004h).
 *
 * bench_co                  nanoseconds per operation, bytes per node, one figure a line
 * bench_co --callgrind N    exactly N of each and nothing measured: the instructions of both
 *                           together are the difference of two runs, divided by that of N
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "ram_nvm.h"

#define ROUNDS 20
#define BATCH 100000u
#define PERIOD DG_US(100) /* from one frame to the next */
#define NODE_ID 0x3Fu     /* as delivered */
#define TPDO2 (0x280u + NODE_ID)
#define SDO_ANSWER (0x580u + NODE_ID)

static struct bench {
    struct ram_nvm nvm;
    struct dg_world world;
    struct dg_cia406 encoder;
    struct dg_co_node node;
    dg_ns now;
    uint64_t sent;
    uint16_t last_id;
} bench;

static void send(void *ctx, const struct dg_can_frame *frame)
{
    struct bench *self = ctx;

    self->sent++;
    self->last_id = frame->id;
}

/* A shaft at constant speed that costs nothing: the device is measured, not the motion. */
static dg_angle angle(void *ctx, dg_ns now)
{
    (void)ctx;
    return (dg_angle)now;
}

static const struct dg_co_ops ops = {.send = send};
static const struct dg_can_frame upload = {
    .id = 0x600u + NODE_ID, .dlc = 8, .data = {0x40, 0x00, 0x10, 0x00}};
static const struct dg_can_frame sync = {.id = 0x80};

static void receive(const struct dg_can_frame *frame)
{
    bench.now += PERIOD;
    (void)dg_co_rx(&bench.node, bench.now, frame);
}

static bool start(void)
{
    static const struct dg_can_frame operational = {.dlc = 2, .data = {0x01, NODE_ID}};
    const struct dg_cia406_model *model = dg_cia406_model_of(dg_device_find("f3668"));
    const struct dg_co_setup setup = {.device = model->device,
                                      .world = &bench.world,
                                      .nvm = ram_nvm_port(&bench.nvm),
                                      .ops = &ops,
                                      .ctx = &bench,
                                      .application = &bench.encoder};

    dg_world_init(&bench.world);
    bench.world.angle = angle;
    ram_nvm_init(&bench.nvm, dg_store_size(model->device->layout));
    if (dg_co_format(model->device, setup.nvm, 1) != DG_OK ||
        dg_cia406_init(&bench.encoder, model) != DG_OK ||
        dg_co_init(&bench.node, &setup) != DG_OK || dg_co_power_on(&bench.node, 0) != DG_OK) {
        return false;
    }
    receive(&operational);
    return bench.node.state == DG_CO_OPERATIONAL;
}

static double now_ns(void)
{
    struct timespec t;

    (void)timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

/* The fastest of some batches; the others were disturbed. */
static void measure(const char *what, const struct dg_can_frame *request, uint16_t answer)
{
    double best = 1e9;

    for (int round = 0; round < ROUNDS; round++) {
        const uint64_t before = bench.sent;
        const double begin = now_ns();
        for (unsigned i = 0; i < BATCH; i++) {
            receive(request);
        }
        const double each = (now_ns() - begin) / BATCH;
        if (bench.sent - before != BATCH || bench.last_id != answer) {
            (void)fprintf(stderr, "%s: not one answer per frame\n", what);
            exit(1);
        }
        best = each < best ? each : best;
    }
    (void)printf("%-32s %10.1f\n", what, best);
}

int main(int argc, char **argv)
{
    const bool counted = argc == 3 && strcmp(argv[1], "--callgrind") == 0;

    if (argc != 1 && !counted) {
        (void)fprintf(stderr, "usage: bench_co [--callgrind N]\n");
        return 2;
    }
    if (!start()) {
        return 1;
    }
    if (counted) {
        for (unsigned long n = strtoul(argv[2], NULL, 10); n > 0; n--) {
            receive(&upload);
            receive(&sync);
        }
        return 0;
    }
    measure("ns per SDO upload (aim: 34)", &upload, SDO_ANSWER);
    measure("ns per SYNC, TPDO (aim: 25.5)", &sync, TPDO2);
    (void)printf("%-32s %10zu\n", "bytes per CANopen node", sizeof(struct dg_co_node));
    return 0;
}

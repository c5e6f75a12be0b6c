/* SPDX-License-Identifier: MIT */
/*
 * How fast a CANopen node of the F36x8 is in virtual time: expedited upload of 1000h, and SYNC
 * answered by a TPDO with one mapped U32 (6004h).
 *
 * bench_co                  nanoseconds per operation, bytes per node, one figure a line
 * bench_co --exchange NAME  the exchange once to warm up and then once in bench_exchange(), for
 *                           callgrind --toggle-collect=bench_exchange; see instructions.sh
 * bench_co --bytes          bytes per node alone
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "drehgeber/cia406.h"
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
    bool aborted;
} bench;

static void send(void *ctx, const struct dg_can_frame *frame)
{
    struct bench *self = ctx;

    self->sent++;
    self->last_id = frame->id;
    self->aborted |= frame->id == SDO_ANSWER && frame->data[0] == 0x80;
}

/* A shaft at constant speed that costs nothing: the device is measured, not the motion. */
static dg_angle angle(void *ctx, dg_ns now)
{
    (void)ctx;
    return (dg_angle)now;
}

static const struct dg_co_ops ops = {.send = send};

/* clang-format off */
#define SYNC {.id = 0x80}
#define SDO(...) {.id = 0x600u + NODE_ID, .dlc = 8, .data = {__VA_ARGS__}}

static const struct dg_can_frame sync[] = {SYNC};
static const struct dg_can_frame first[] = {SDO(0x40, 0x00, 0x10, 0x00)};
static const struct dg_can_frame middle[] = {SDO(0x40, 0x03, 0x1A, 0x08)};
static const struct dg_can_frame last[] = {SDO(0x40, 0x0E, 0x65, 0x00)};
/* 1008h, 21 characters */
static const struct dg_can_frame segmented[] = {
    SDO(0x40, 0x08, 0x10, 0x00), SDO(0x60), SDO(0x70), SDO(0x60)};
static const struct dg_can_frame block[] = {
    SDO(0xA4, 0x08, 0x10, 0x00, 0x7F), SDO(0xA3), SDO(0xA2, 3, 0x7F), SDO(0xA1)};

static const struct exchange {
    const char *name;
    const struct dg_can_frame *frame;
    size_t count;
    uint64_t answers;
} exchanges[] = {
#define EXCHANGE(name, answers) {#name, name, sizeof name / sizeof name[0], answers}
    EXCHANGE(sync, 1),
    EXCHANGE(first, 1),
    EXCHANGE(middle, 1),
    EXCHANGE(last, 1),
    EXCHANGE(segmented, 4),
    EXCHANGE(block, 5),
};
/* clang-format on */

static void receive(const struct dg_can_frame *frame)
{
    bench.now += PERIOD;
    (void)dg_co_rx(&bench.node, bench.now, frame);
}

/* What callgrind counts; called by a pointer it does not see through, so that it stays a function.
 */
void bench_exchange(const struct exchange *exchange);
void bench_exchange(const struct exchange *exchange)
{
    for (size_t i = 0; i < exchange->count; i++) {
        receive(&exchange->frame[i]);
    }
}
static void (*volatile counted)(const struct exchange *exchange) = bench_exchange;

static bool start(void)
{
    static const struct dg_can_frame operational = {.dlc = 2, .data = {0x01, NODE_ID}};
    static const struct dg_cia406_model model = {.turns = 4096, .device = &dg_cia406_multiturn};
    const struct dg_co_setup setup = {.device = model.device,
                                      .world = &bench.world,
                                      .nvm = ram_nvm_port(&bench.nvm),
                                      .ops = &ops,
                                      .ctx = &bench,
                                      .application = &bench.encoder};

    dg_world_init(&bench.world);
    bench.world.angle = angle;
    ram_nvm_init(&bench.nvm, dg_store_size(model.device->layout));
    if (dg_co_format(model.device, setup.nvm, 1) != DG_OK ||
        dg_cia406_init(&bench.encoder, &model) != DG_OK ||
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

/* Twice, and both times as many frames and bytes come back, none of them an abort. */
static int count_one(const char *name)
{
    for (size_t i = 0; i < sizeof exchanges / sizeof exchanges[0]; i++) {
        const struct exchange *exchange = &exchanges[i];
        if (strcmp(exchange->name, name) != 0) {
            continue;
        }
        bench.sent = 0;
        for (size_t n = 0; n < exchange->count; n++) {
            receive(&exchange->frame[n]);
        }
        const bool warm = bench.sent == exchange->answers;
        counted(exchange);
        return warm && bench.sent == 2 * exchange->answers && !bench.aborted ? 0 : 1;
    }
    (void)fprintf(stderr, "no such exchange: %s\n", name);
    return 2;
}

int main(int argc, char **argv)
{
    const bool one = argc == 3 && strcmp(argv[1], "--exchange") == 0;

    if (argc == 2 && strcmp(argv[1], "--bytes") == 0) {
        (void)printf("%zu\n", sizeof(struct dg_co_node));
        return 0;
    }
    if (argc != 1 && !one) {
        (void)fprintf(stderr, "usage: bench_co [--exchange NAME | --bytes]\n");
        return 2;
    }
    if (!start()) {
        return 1;
    }
    if (one) {
        return count_one(argv[2]);
    }
    measure("ns per SDO upload (aim: 34)", first, SDO_ANSWER);
    measure("ns per SYNC, TPDO (aim: 25.5)", sync, TPDO2);
    (void)printf("%-32s %10zu\n", "bytes per CANopen node", sizeof(struct dg_co_node));
    return 0;
}

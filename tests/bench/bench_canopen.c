/* SPDX-License-Identifier: MIT */
/*
 * A CANopen node of the F3668: SYNC answered by a TPDO with one mapped U32 (6004h), the kinds of
 * SDO transfer, frames for others, time that passes; and a position with scaling and USF.
 */
#include "bench.h"
#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "ram_nvm.h"

#define PERIOD DG_US(100) /* from one frame to the next */
#define NODE_ID 0x3Fu     /* as delivered */
#define SDO_ANSWER (0x580u + NODE_ID)
#define SDO_ABORT 0x80u
/* What an abort counts for, so that none passes for an answer, and no answer for an abort. */
#define ABORT 1000u

static const struct dg_cia406_model model = {.turns = 4096, .device = &dg_cia406_multiturn};

struct subject {
    struct ram_nvm nvm;
    struct dg_world world;
    struct dg_cia406 encoder;
    struct dg_co_node node;
    dg_ns now;
};
static struct subject plain, scaled, stopped;
static uint64_t answered;

static void count_answer(void *ctx, const struct dg_can_frame *frame)
{
    (void)ctx;
    answered += frame->id == SDO_ANSWER && frame->data[0] == SDO_ABORT ? ABORT : 1u;
}

/* A shaft at constant speed that costs nothing: the device is measured, not the motion. */
static dg_angle angle(void *ctx, dg_ns at)
{
    (void)ctx;
    return (dg_angle)at;
}

/* An exchange: frames, one after the other. */
struct exchange {
    const struct dg_can_frame *frames;
    size_t count;
};

/* clang-format off */
#define SDO(...) {.id = 0x600u + NODE_ID, .dlc = 8, .data = {__VA_ARGS__}}
#define EXCHANGE(name, ...)                                                                        \
    static const struct dg_can_frame name##_frames[] = {__VA_ARGS__};                              \
    static const struct exchange name = {name##_frames, sizeof name##_frames / sizeof name##_frames[0]}

EXCHANGE(sync, {.id = 0x80});
EXCHANGE(upload_first, SDO(0x40, 0x00, 0x10, 0x00));
EXCHANGE(upload_middle, SDO(0x40, 0x03, 0x1A, 0x08));
EXCHANGE(upload_last, SDO(0x40, 0x0E, 0x65, 0x00));
EXCHANGE(upload_position, SDO(0x40, 0x04, 0x60, 0x00));
EXCHANGE(upload_nothing, SDO(0x40, 0x00, 0x50, 0x00));
EXCHANGE(download, SDO(0x2B, 0x17, 0x10, 0x00));
/* 1008h, 21 characters */
EXCHANGE(segmented, SDO(0x40, 0x08, 0x10, 0x00), SDO(0x60), SDO(0x70), SDO(0x60));
EXCHANGE(block, SDO(0xA4, 0x08, 0x10, 0x00, 0x7F), SDO(0xA3), SDO(0xA2, 3, 0x7F), SDO(0xA1));
EXCHANGE(foreign, {.id = 0x181, .dlc = 8});
/* Boot-up, and three TPDOs whose turn it is when it starts. */
EXCHANGE(restart, {.dlc = 2, .data = {0x81, NODE_ID}}, {.dlc = 2, .data = {0x01, NODE_ID}});
EXCHANGE(nmt, {.dlc = 2, .data = {0x02, NODE_ID}}, {.dlc = 2, .data = {0x80, NODE_ID}});
/* clang-format on */

static void exchange(struct subject *self, const struct exchange *frames)
{
    for (size_t i = 0; i < frames->count; i++) {
        self->now += PERIOD;
        (void)dg_co_rx(&self->node, self->now, &frames->frames[i]);
    }
}

static void receive(const void *what)
{
    exchange(&plain, what);
}

static void receive_scaled(const void *what)
{
    exchange(&scaled, what);
}

static void receive_stopped(const void *what)
{
    exchange(&stopped, what);
}

/* A second in which nobody says anything, and a host looks at its clock every millisecond. */
static void pass(const void *what)
{
    dg_ns due = plain.now;

    (void)what;
    for (unsigned ms = 0; ms < 1000; ms++) {
        plain.now += DG_MS(1);
        if (plain.now >= due) {
            due = dg_co_step(&plain.node, plain.now);
        }
    }
}

static bool make(struct subject *self)
{
    static const struct dg_can_frame operational = {.dlc = 2, .data = {0x01, NODE_ID}};
    static const struct dg_co_ops ops = {.send = count_answer};
    const struct dg_co_setup setup = {.device = model.device,
                                      .world = &self->world,
                                      .nvm = ram_nvm_port(&self->nvm),
                                      .ops = &ops,
                                      .application = &self->encoder};

    dg_world_init(&self->world);
    self->world.angle = angle;
    ram_nvm_init(&self->nvm, dg_store_size(model.device->layout));
    if (dg_co_format(model.device, setup.nvm, 1) != DG_OK ||
        dg_cia406_init(&self->encoder, &model) != DG_OK ||
        dg_co_init(&self->node, &setup) != DG_OK || dg_co_power_on(&self->node, 0) != DG_OK) {
        return false;
    }
    self->now = PERIOD;
    (void)dg_co_rx(&self->node, self->now, &operational);
    return self->node.state == DG_CO_OPERATIONAL;
}

static void write_object(struct subject *self, uint8_t command, uint16_t index, uint32_t value)
{
    struct dg_can_frame frame = {.id = 0x600u + NODE_ID, .dlc = 8, .data = {command}};

    dg_store_le16(&frame.data[1], index);
    dg_store_le32(&frame.data[4], value);
    (void)dg_co_rx(&self->node, self->now, &frame);
}

static const struct bench benches[] = {
    {"canopen.sync-to-tpdo", receive, &sync, 1, 1},
    {"canopen.sync-to-tpdo-scaled", receive_scaled, &sync, 1, 1},
    {"canopen.upload-first", receive, &upload_first, 1, 1},
    {"canopen.upload-middle", receive, &upload_middle, 1, 1},
    {"canopen.upload-last", receive, &upload_last, 1, 1},
    {"canopen.upload-position", receive, &upload_position, 1, 1},
    {"canopen.upload-nothing", receive, &upload_nothing, ABORT, 1},
    {"canopen.download", receive, &download, 1, 1},
    {"canopen.segmented-upload-21", receive, &segmented, 4, 1},
    {"canopen.block-upload-21", receive, &block, 5, 1},
    {"canopen.foreign-frame", receive, &foreign, 0, 1},
    {"canopen.millisecond", pass, NULL, 0, 1000},
    {"canopen.reset-and-start", receive, &restart, 4, 1},
    {"canopen.nmt", receive_stopped, &nmt, 0, 2},
};

static const struct bench_bytes bytes[] = {
    {"ram.dg_co_node", sizeof(struct dg_co_node)},
    {"ram.dg_cia406_device", sizeof(struct dg_cia406_device)},
};

static bool start_nodes(void)
{
    if (!make(&plain) || !make(&scaled) || !make(&stopped)) {
        return false;
    }
    answered = 0;
    write_object(&scaled, 0x23, 0x6001, 3600);
    write_object(&scaled, 0x23, 0x6002, 36000);
    write_object(&scaled, 0x2B, 0x6000, DG_CIA406_USF | DG_CIA406_SCALING | DG_CIA406_CCW);
    return answered == 3;
}

static uint64_t answers(void)
{
    return answered;
}

int main(int argc, char **argv)
{
    static const struct bench_set set = {.benches = benches,
                                         .count = DG_COUNT(benches),
                                         .bytes = bytes,
                                         .bytes_count = DG_COUNT(bytes),
                                         .start = start_nodes,
                                         .answers = answers};

    return bench_main(argc, argv, &set);
}

/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: an F36x8 whose every object is written, while the shaft moves, the world bends, the
 * EEPROM rots, fails or loses power. After each operation: a refused value is the old one, an
 * accepted one is in its range, the position lies in the range in force, the working areas agree
 * with it, and nothing is sent that the NMT state forbids.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "fuzz_input.h"
#include "ram_nvm.h"

#define SCALING DG_CIA406_SCALING
#define SDO_RX 0x600u
#define SDO_TX 0x580u

struct bench {
    struct ram_nvm nvm;
    struct dg_world world;
    struct dg_cia406_model model;
    struct dg_cia406 encoder;
    struct dg_co_node node;
    struct dg_can_frame answer; /* latest SDO answer */
    bool answered;
    dg_ns now;
    dg_angle angle; /* at time 0 */
    int64_t angle_per_us;
    dg_angle before; /* instead of `angle`, until the shaft jumps at `jump_at` */
    dg_ns jump_at;
};

/* ------------------------------------------------------------ the node and its surroundings */

/* Modulo 2^64, as an angle is. */
static dg_angle angle(void *ctx, dg_ns now)
{
    const struct bench *bench = ctx;
    uint64_t from = (uint64_t)(now < bench->jump_at ? bench->before : bench->angle);

    return (dg_angle)(from + (uint64_t)bench->angle_per_us * (now / 1000u));
}

/* CAN-IDs 181h-57Fh are nobody's but the TPDOs'. */
static void check_frame(void *ctx, const struct dg_can_frame *frame)
{
    struct bench *bench = ctx;
    const struct dg_co_node *node = &bench->node;

    fuzz_must(frame->dlc <= 8 && frame->id <= 0x7FF && !frame->rtr);
    fuzz_must(node->state != DG_CO_OFF);
    fuzz_must(frame->id <= 0x180 || frame->id >= 0x580 || node->state == DG_CO_OPERATIONAL);
    if (frame->id == SDO_TX + node->id) {
        bench->answer = *frame;
        bench->answered = true;
    }
}

static void power_on(struct bench *bench)
{
    static const struct dg_co_ops ops = {.send = check_frame};
    const struct dg_co_setup setup = {
        .device = bench->model.device,
        .world = &bench->world,
        .nvm = ram_nvm_port(&bench->nvm),
        .ops = &ops,
        .ctx = bench,
        .application = &bench->encoder,
    };

    fuzz_must(dg_cia406_init(&bench->encoder, &bench->model) == DG_OK);
    fuzz_must(dg_co_init(&bench->node, &setup) == DG_OK);
    int result = dg_co_power_on(&bench->node, bench->now);
    fuzz_must((result == DG_ERR_BLANK || result == DG_ERR_FOREIGN) ==
              (bench->node.state == DG_CO_OFF));
}

static bool rx(struct bench *bench, const struct dg_can_frame *frame)
{
    bench->answered = false;
    dg_ns deadline = dg_co_rx(&bench->node, bench->now, frame);
    fuzz_must(deadline > bench->now);
    return bench->answered;
}

/* One request; false without an answer (Stopped, off, "save"). */
static bool ask(struct bench *bench, uint8_t command, const struct dg_co_object *object,
                uint32_t value)
{
    struct dg_can_frame frame = {.id = (uint16_t)((SDO_RX + bench->node.id) & 0x7FFu), .dlc = 8};

    frame.data[0] = command;
    dg_store_le16(&frame.data[1], object->index);
    frame.data[3] = object->sub;
    dg_store_le32(&frame.data[4], value);
    return rx(bench, &frame) && bench->answer.data[0] != 0x80;
}

/* ------------------------------------------------------------ invariants */

/* The objects of a device, one for each sub-index. */
static struct dg_co_object objects[128];
static uint16_t object_count;

static void list_objects(const struct dg_co_dictionary *dictionary)
{
    object_count = 0;
    for (uint16_t i = 0; i < dictionary->count; i++) {
        const struct dg_co_row *row = &dictionary->rows[i];
        for (uint8_t nth = 0; nth <= (row->key & 0xFu); nth++) {
            objects[object_count++] = (struct dg_co_object){
                .row = row,
                .dictionary = dictionary,
                .index = (uint16_t)(row->key >> 16),
                .sub = (uint8_t)((row->key >> 8) + nth),
                .slot = (uint8_t)(row->slot + nth),
            };
        }
    }
}

static enum dg_co_type type_of(const struct dg_co_object *object)
{
    return (enum dg_co_type)(object->row->flags >> 12);
}

static const struct dg_co_object *row(uint16_t index, uint8_t sub)
{
    for (uint16_t i = 0; i < object_count; i++) {
        if (objects[i].index == index && objects[i].sub == sub) {
            return &objects[i];
        }
    }
    abort();
}

static uint32_t value_of(const struct bench *bench, uint16_t index, uint8_t sub)
{
    return bench->node.value[row(index, sub)->slot];
}

static uint64_t range(const struct bench *bench)
{
    uint64_t physical = (uint64_t)bench->model.turns * DG_CIA406_STEPS;
    uint32_t tmr = value_of(bench, 0x6002, 0);

    return (value_of(bench, 0x6000, 0) & SCALING) == 0 || tmr == UINT32_MAX ? physical : tmr;
}

/* Default and limits: the model's, or the row's own. */
struct figure {
    uint32_t initial, min, max;
};

static struct figure figure(const struct bench *bench, const struct dg_co_object *object)
{
    static const struct dg_co_limits of_types[] = {
        [DG_CO_I8] = {0xFFFFFF80u, 0x7F},
        [DG_CO_I16] = {0xFFFF8000u, 0x7FFF},
        [DG_CO_I32] = {0x80000000u, 0x7FFFFFFF},
        [DG_CO_U8] = {0, 0xFF},
        [DG_CO_U16] = {0, 0xFFFF},
        [DG_CO_U32] = {0, 0xFFFFFFFFu},
        [DG_CO_STRING] = {0, 0},
    };
    const struct dg_co_device *device = bench->model.device;
    const uint32_t number = object->row->key >> 4 & 0xFu;
    const struct dg_co_limits *limits =
        number != 0 ? &device->dictionary.limits[number] : &of_types[type_of(object)];
    struct figure own = {object->row->initial, limits->min, limits->max};

    for (uint8_t i = 0; i < device->figure_count; i++) {
        if (device->figures[i].key == DG_CO_KEY(object->index, object->sub)) {
            own.initial = device->figures[i].initial;
        }
    }
    return own;
}

static bool in_range(const struct bench *bench, const struct dg_co_object *object, uint32_t value)
{
    const struct figure own = figure(bench, object);

    return type_of(object) <= DG_CO_I32
               ? (int32_t)value >= (int32_t)own.min && (int32_t)value <= (int32_t)own.max
               : value >= own.min && value <= own.max;
}

/* The areas are found when they are read. */
static void check_position(struct bench *bench)
{
    const bool told = ask(bench, 0x40, row(0x6400, 1), 0);
    uint32_t position = value_of(bench, 0x6004, 0);
    uint8_t areas = 0;

    fuzz_must(position < range(bench));
    fuzz_must(bench->encoder.raw < (uint64_t)bench->model.turns * DG_CIA406_STEPS);
    for (uint8_t i = 0; i < 2; i++) {
        bool above = position > value_of(bench, 0x6402, (uint8_t)(i + 1u));
        bool below = position < value_of(bench, 0x6401, (uint8_t)(i + 1u));
        areas |= (uint8_t)((above || below ? 1u : 0u) << (3u * i));
        areas |= (uint8_t)((above ? 2u : 0u) << (3u * i));
        areas |= (uint8_t)((below ? 4u : 0u) << (3u * i));
    }
    fuzz_must(told && bench->answer.data[4] == areas);
}

static void check(struct bench *bench)
{
    uint32_t parameters;

    if (bench->node.state == DG_CO_OFF) {
        return;
    }
    for (uint16_t i = 0; i < object_count; i++) {
        const struct dg_co_object *object = &objects[i];
        if ((object->row->flags & DG_CO_SLOT) != 0 && object->index > 0x2102) {
            fuzz_must(in_range(bench, object, bench->node.value[object->slot]));
        }
    }
    parameters = value_of(bench, 0x6000, 0);
    fuzz_must((parameters & ~(uint32_t)DG_CIA406_WRITABLE) == 0);
    fuzz_must((parameters & DG_CIA406_USF) == 0 ||
              ((parameters & SCALING) != 0 &&
               4 * range(bench) < (uint64_t)bench->model.turns * value_of(bench, 0x6001, 0)));
    if (ask(bench, 0x40, row(0x6004, 0), 0)) {
        fuzz_must(dg_load_le32(&bench->answer.data[4]) == value_of(bench, 0x6004, 0));
        check_position(bench);
    }
    (void)dg_cia406_leds(&bench->node);
}

/* ------------------------------------------------------------ operations */

static void step_node(struct bench *bench)
{
    dg_ns deadline = dg_co_step(&bench->node, bench->now);

    fuzz_must(deadline > bench->now);
}

/* Values that stand at an edge are as likely as any. */
static uint32_t some_value(const struct bench *bench, struct fuzz_input *input,
                           const struct dg_co_object *object)
{
    const struct figure own = figure(bench, object);
    uint32_t random = fuzz_take32(input);
    uint8_t how = fuzz_take(input);
    const uint32_t edges[] = {
        own.min,     own.max,     own.initial, own.min - 1u, own.max + 1u,
        0x65766173u, 0x64616F6Cu, 0x1004u,     3600u,        36000u,
    };

    return how % 2 == 0 ? random : edges[how / 2u % (DG_COUNT(edges))];
}

static void op_write(struct bench *bench, struct fuzz_input *input)
{
    static const uint8_t sizes[] = {
        [DG_CO_I8] = 1,  [DG_CO_I16] = 2, [DG_CO_I32] = 4,    [DG_CO_U8] = 1,
        [DG_CO_U16] = 2, [DG_CO_U32] = 4, [DG_CO_STRING] = 4,
    };
    const struct dg_co_object *object = &objects[fuzz_take(input) % object_count];
    uint8_t size =
        fuzz_take(input) % 16 != 0 ? sizes[type_of(object)] : (uint8_t)(1 + fuzz_take(input) % 4);
    uint32_t value = some_value(bench, input, object);
    bool kept = (object->row->flags & (DG_CO_SLOT | DG_CO_LIVE)) == DG_CO_SLOT &&
                bench->node.state != DG_CO_OFF;
    uint32_t before = kept ? bench->node.value[object->slot] : 0;

    bool accepted = ask(bench, (uint8_t)(0x23u | (4u - size) << 2), object, value);
    if (!kept || bench->node.state == DG_CO_OFF) {
        return;
    }
    uint32_t after = bench->node.value[object->slot];
    if (accepted) {
        fuzz_must((object->row->flags & DG_CO_W) != 0 && size == sizes[type_of(object)]);
        fuzz_must(after == (size == 4 ? value : value & ((1u << 8 * size) - 1u)));
    } else {
        fuzz_must(after == before);
    }
}

static void op_read(struct bench *bench, struct fuzz_input *input)
{
    (void)ask(bench, 0x40, &objects[fuzz_take(input) % object_count], 0);
}

static void op_communication(struct bench *bench, struct fuzz_input *input)
{
    static const struct dg_co_object stack[] = {
        {.index = 0x1010, .sub = 1}, {.index = 0x1011, .sub = 1}, {.index = 0x1029, .sub = 1},
        {.index = 0x1029, .sub = 2}, {.index = 0x1029, .sub = 3}, {.index = 0x1800, .sub = 1},
        {.index = 0x1800, .sub = 2}, {.index = 0x1800, .sub = 3}, {.index = 0x1800, .sub = 5},
        {.index = 0x1A00, .sub = 0}, {.index = 0x1A00, .sub = 1}, {.index = 0x1A00, .sub = 2},
    };
    static const uint8_t sizes[] = {4, 4, 1, 1, 1, 4, 1, 2, 2, 1, 4, 4};
    static const uint32_t values[] = {0x65766173, 0x64616F6C, 0,          1,
                                      2,          255,        0x800001BF, 0x000001BF,
                                      0x65050010, 0x60040020, 0x64000108, 0x60300110};
    uint8_t which = fuzz_take(input) % sizeof sizes;
    uint32_t value = values[fuzz_take(input) % (DG_COUNT(values))];

    (void)ask(bench, (uint8_t)(0x23u | (4u - sizes[which]) << 2), &stack[which], value);
}

static void op_frame(struct bench *bench, struct fuzz_input *input)
{
    static const uint16_t ids[] = {0x000, 0x000, 0x080, 0x63F, 0x7E5, 0x1BF, 0x4BF, 0x73F, 0x701};
    uint8_t how = fuzz_take(input);
    struct dg_can_frame frame = {
        .id = ids[how % (DG_COUNT(ids))],
        .rtr = how / 16u % 8u == 0,
        .dlc = fuzz_take(input) % 9,
    };

    for (uint8_t i = 0; i < frame.dlc; i++) {
        frame.data[i] = fuzz_take(input);
    }
    (void)rx(bench, &frame);
}

static void op_nmt(struct bench *bench, struct fuzz_input *input)
{
    static const uint8_t commands[] = {0x01, 0x01, 0x02, 0x80, 0x81, 0x82};
    const struct dg_can_frame frame = {.dlc = 2,
                                       .data = {commands[fuzz_take(input) % sizeof commands]}};

    (void)rx(bench, &frame);
}

static void op_time(struct bench *bench, struct fuzz_input *input)
{
    uint8_t how = fuzz_take(input);

    bench->now = dg_after(bench->now, (uint64_t)fuzz_take(input) << (how % 48u));
    bench->now = bench->now < DG_NEVER / 2 ? bench->now : DG_NEVER / 2;
    step_node(bench);
}

/* A port that comes exactly at the deadlines. */
static void op_run(struct bench *bench, struct fuzz_input *input)
{
    for (uint8_t i = fuzz_take(input) % 32u; i > 0; i--) {
        dg_ns deadline = dg_co_step(&bench->node, bench->now);
        fuzz_must(deadline > bench->now);
        bench->now = deadline < DG_NEVER / 2 ? deadline : bench->now;
    }
    step_node(bench);
}

static void op_shaft(struct bench *bench, struct fuzz_input *input)
{
    bench->before = bench->angle;
    bench->jump_at = fuzz_take(input) % 2 != 0 ? bench->now : 0;
    bench->angle = (dg_angle)((uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input));
    bench->angle_per_us = (int64_t)(int32_t)fuzz_take32(input) * 16;
}

static void op_world(struct bench *bench, struct fuzz_input *input)
{
    uint8_t bits = fuzz_take(input);

    bench->world.temperature_mdegc = bits == 0 ? INT32_MIN : (int32_t)fuzz_take32(input);
    bench->world.battery_mv = fuzz_take32(input) >> bits % 32u;
    bench->world.led_current_ua = fuzz_take32(input) >> bits % 32u;
    bench->world.singleturn_ok = (bits & 1u) != 0;
    bench->world.multiturn_amplitude_ok = (bits & 2u) != 0;
    bench->world.multiturn_sync_ok = (bits & 4u) != 0;
    bench->world.multiturn_vector_ok = (bits & 8u) != 0;
    bench->world.eeprom_acknowledges = (bits & 0x30u) != 0;
    bench->world.watchdog_fired = (bits & 0xC0u) == 0;
}

/* Sums are verified at power-on (store.h), so the memory rots while the power is off. */
static void op_rot(struct bench *bench, struct fuzz_input *input)
{
    uint32_t where = fuzz_take32(input);

    ram_nvm_restore(&bench->nvm);
    bench->nvm.bytes[(where >> 3) % bench->nvm.size] ^= (uint8_t)(1u << (where & 7u));
    power_on(bench);
}

static void op_fail(struct bench *bench, struct fuzz_input *input)
{
    bench->nvm.no_acknowledge = fuzz_take(input) % 2 != 0;
}

static void op_power_cut(struct bench *bench, struct fuzz_input *input)
{
    uint8_t how = fuzz_take(input);

    ram_nvm_cut(&bench->nvm, how & 15u, (enum ram_nvm_tear)((how >> 4) % RAM_NVM_TEAR_COUNT),
                fuzz_take(input));
}

static void op_power(struct bench *bench, struct fuzz_input *input)
{
    uint8_t how = fuzz_take(input);

    ram_nvm_restore(&bench->nvm);
    if (how % 8 == 0) {
        dg_co_power_off(&bench->node);
    } else {
        power_on(bench);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    static void (*const operations[])(struct bench *, struct fuzz_input *) = {
        op_write, op_write, op_write, op_write, op_read, op_communication, op_frame,     op_nmt,
        op_time,  op_run,   op_shaft, op_world, op_rot,  op_fail,          op_power_cut, op_power,
    };
    static const struct dg_cia406_model models[] = {
        {.turns = 1, .device = &dg_cia406_singleturn, .password = 1},
        {.turns = 4096, .device = &dg_cia406_multiturn, .password = 1},
        {.turns = 65536, .device = &dg_cia406_multiturn_32, .password = 1},
    };
    static struct bench bench;
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    memset(&bench, 0, sizeof bench);
    bench.model = models[fuzz_take(&input) % (DG_COUNT(models))];
    list_objects(&bench.model.device->dictionary);
    dg_world_init(&bench.world);
    bench.world.angle = angle;
    bench.world.angle_ctx = &bench;
    ram_nvm_init(&bench.nvm, dg_store_size(bench.model.device->layout));
    fuzz_must(dg_co_format(bench.model.device, ram_nvm_port(&bench.nvm), 1) == DG_OK);
    power_on(&bench);
    while (input.at < input.end) {
        operations[fuzz_take(&input) % (DG_COUNT(operations))](&bench, &input);
        check(&bench);
    }
    return 0;
}

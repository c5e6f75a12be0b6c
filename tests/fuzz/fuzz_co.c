/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: a CANopen node of the F36x8 on a hostile bus. The input is a stream of operations:
 * frames, time, events of the bus, a turning shaft, a rotting, failing or powerless EEPROM. Every
 * frame that comes out must be one that the node may send in its state, every request has at most
 * one answer, no object leaves its range.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "drehgeber/crc.h"
#include "drehgeber/devices.h"
#include "fuzz_input.h"
#include "ram_nvm.h"

#define LSS_RX 0x7E5u
#define LSS_TX 0x7E4u
#define SEGMENTS_MAX 6u /* of a block upload: DG_CO_STRING_MAX bytes */

/* The node under test and what the observer knows about the bus. */
struct bench {
    struct ram_nvm nvm;
    struct dg_world world;
    struct dg_cia406 encoder;
    struct dg_co_node node;
    dg_ns now;
    dg_angle angle;
    int64_t angle_per_ms;
    struct dg_co_node *sender; /* the node that is being called */
    uint32_t sent;
    unsigned answers;         /* that the SDO server may still give */
    struct dg_can_frame last; /* frame sent */
};

static dg_angle angle(void *ctx, dg_ns now)
{
    const struct bench *bench = ctx;

    return (dg_angle)((uint64_t)bench->angle + (uint64_t)bench->angle_per_ms * (now / DG_MS(1)));
}

/* ------------------------------------------------------------ what the node may send */

static bool in_operation(const struct dg_co_node *node)
{
    return node->state == DG_CO_PRE_OPERATIONAL || node->state == DG_CO_OPERATIONAL;
}

/* One answer per request, but for the segments of a block and the abort after a timeout. */
static void count_answer(struct bench *bench, const uint8_t *data)
{
    const enum dg_co_sdo_state state = bench->sender->sdo.state;
    const bool block = state == DG_CO_SDO_BLOCK_UPLOAD_START || state == DG_CO_SDO_BLOCK_UPLOAD;
    const uint8_t seqno = data[0] & 0x7Fu;
    const bool segment = block && seqno >= 1 && seqno <= SEGMENTS_MAX;
    const bool timeout = data[0] == 0x80 && dg_load_le32(&data[4]) == DG_CO_TIMEOUT;

    if (!segment && !timeout) {
        fuzz_must(bench->answers > 0);
        bench->answers--;
    }
}

static bool is_tpdo(const struct dg_co_node *node, const struct dg_can_frame *frame)
{
    for (uint8_t i = 0; i < DG_CO_TPDOS; i++) {
        const struct dg_co_tpdo *tpdo = &node->tpdo[i];
        if (tpdo->valid && tpdo->can_id == frame->id && tpdo->length == frame->dlc) {
            return node->state == DG_CO_OPERATIONAL;
        }
    }
    return false;
}

static bool may_send(struct bench *bench, const struct dg_can_frame *frame)
{
    const struct dg_co_node *node = bench->sender;

    if (frame->id == LSS_TX) {
        return frame->dlc == 8 && node->state != DG_CO_OPERATIONAL;
    }
    if (node->id == DG_CO_UNCONFIGURED) {
        return false;
    }
    if (frame->id == 0x700u + node->id) {
        return frame->dlc == 1;
    }
    if (frame->id == 0x580u + node->id) {
        count_answer(bench, frame->data);
        return frame->dlc == 8 && in_operation(node);
    }
    if (frame->id == 0x080u + node->id && frame->dlc == 8 && in_operation(node)) {
        return true;
    }
    return is_tpdo(node, frame);
}

static void check_frame(void *ctx, const struct dg_can_frame *frame)
{
    struct bench *bench = ctx;
    const struct dg_co_node *node = bench->sender;

    fuzz_must(frame->id <= 0x7FF && !frame->rtr && frame->dlc <= 8);
    fuzz_must(node->state != DG_CO_OFF && node->now >= node->lss.silent_until);
    fuzz_must(may_send(bench, frame));
    bench->sent++;
    bench->last = *frame;
}

static void bit_rate(void *ctx, uint16_t kbaud)
{
    (void)ctx;
    fuzz_must(kbaud >= 10 && kbaud <= 1000);
}

static const struct dg_co_ops ops = {.send = check_frame, .bit_rate = bit_rate};

/* ------------------------------------------------------------ what must hold after every call */

/* Objects whose limits are narrower than their type (manual, chapters 10, 26; CiA 301). */
static const struct {
    uint16_t index;
    uint8_t sub;
    uint32_t min;
    uint32_t max;
} limits[] = {
    {0x1003, 0, 0, 8},     {0x1005, 0, 0x80, 0x700}, {0x1029, 1, 0, 2},   {0x1029, 2, 0, 2},
    {0x1029, 3, 0, 2},     {0x1A00, 0, 0, 8},        {0x1A01, 0, 0, 8},   {0x1A02, 0, 0, 8},
    {0x1A03, 0, 0, 8},     {0x2100, 0, 0, 8},        {0x2101, 0, 1, 127}, {0x2102, 0, 0, 1},
    {0x6502, 0, 1, 65535}, {0x1016, 0, 2, 2},        {0x100B, 0, 1, 127}, {0x1018, 1, 19, 19},
    {0x1001, 0, 0, 0x3F},
};

/* Upload by a copy of the node, so that nothing is disturbed. */
static uint32_t probe(struct bench *bench, struct dg_co_node *copy, uint16_t index, uint8_t sub)
{
    struct dg_can_frame frame = {.id = (uint16_t)(0x600u + copy->id), .dlc = 8, .data = {0x40}};

    dg_store_le16(&frame.data[1], index);
    frame.data[3] = sub;
    bench->answers = 2; /* one may be late */
    (void)dg_co_rx(copy, copy->now, &frame);
    fuzz_must(bench->last.id == 0x580u + copy->id && (bench->last.data[0] & 0xF3u) == 0x43u);
    return dg_load_le32(&bench->last.data[4]);
}

static void check_objects(struct bench *bench)
{
    struct dg_co_node copy = bench->node;
    const unsigned answers = bench->answers;
    const struct dg_cia406 encoder = bench->encoder;

    if (!in_operation(&copy) || copy.now < copy.lss.silent_until) {
        return;
    }
    bench->sender = &copy;
    for (size_t i = 0; i < DG_COUNT(limits); i++) {
        const uint32_t value = probe(bench, &copy, limits[i].index, limits[i].sub);
        fuzz_must(value >= limits[i].min && value <= limits[i].max);
    }
    fuzz_must(probe(bench, &copy, 0x6004, 0) < (uint64_t)encoder.model->turns * DG_CIA406_STEPS);
    bench->sender = &bench->node;
    bench->answers = answers;
    bench->encoder = encoder;
}

static void check(struct bench *bench, dg_ns deadline)
{
    const struct dg_co_node *node = &bench->node;
    uint16_t ids[DG_CO_FILTERS_MAX];

    fuzz_must(deadline > node->now);
    fuzz_must(node->emcy_count <= DG_CO_HISTORY && node->history_count <= DG_CO_HISTORY);
    fuzz_must((node->id >= 1 && node->id <= 127) || node->id == DG_CO_UNCONFIGURED);
    fuzz_must(dg_co_filters(node, ids) <= DG_CO_FILTERS_MAX);
    for (uint8_t i = 0; i < DG_CO_TPDOS; i++) {
        fuzz_must(!node->tpdo[i].valid ||
                  (node->tpdo[i].length <= 8 && node->tpdo[i].mapped_count <= DG_CO_MAPPED_MAX));
    }
    bench->answers = node->sdo.state == DG_CO_SDO_DELAYED ? 1 : 0;
}

static bool listens(const struct bench *bench, uint16_t id)
{
    uint16_t ids[DG_CO_FILTERS_MAX];
    bool found = false;

    for (uint8_t n = dg_co_filters(&bench->node, ids); n > 0; n--) {
        found = found || ids[n - 1u] == id;
    }
    return found;
}

/* ------------------------------------------------------------ calls */

static void step_node(struct bench *bench)
{
    const bool off = bench->node.state == DG_CO_OFF;
    const dg_ns deadline = dg_co_step(&bench->node, bench->now);

    fuzz_must(!off || deadline == DG_NEVER);
    check(bench, deadline);
}

/* What is due comes first, so that the rest is what the frame has done. */
static void receive(struct bench *bench, const struct dg_can_frame *frame)
{
    step_node(bench);
    const uint32_t before = bench->sent;
    const bool heard = listens(bench, frame->id);
    bench->answers += !frame->rtr && frame->id == 0x600u + bench->node.id ? 1 : 0;
    const dg_ns deadline = dg_co_rx(&bench->node, bench->now, frame);
    fuzz_must(heard || bench->sent == before);
    /* A step at the same moment finds nothing to do, and the same deadline. */
    const uint32_t sent = bench->sent;
    struct dg_co_node copy = bench->node;
    fuzz_must(dg_co_step(&copy, bench->now) == deadline && bench->sent == sent);
    check(bench, deadline);
}

static void pass(struct bench *bench, uint64_t ns)
{
    bench->now = dg_after(bench->now, ns);
}

static void fill(struct dg_can_frame *frame, struct fuzz_input *input, size_t from)
{
    for (size_t i = from; i < sizeof frame->data; i++) {
        frame->data[i] = fuzz_take(input);
    }
}

/* ------------------------------------------------------------ operations */

static void op_any_frame(struct bench *bench, struct fuzz_input *input)
{
    const uint32_t how = fuzz_take32(input);
    struct dg_can_frame frame = {.id = (uint16_t)(how & 0x7FFu),
                                 .rtr = (how >> 11 & 1u) != 0,
                                 .dlc = (uint8_t)((how >> 12) % 9u)};

    fill(&frame, input, 0);
    receive(bench, &frame);
}

/* CAN-IDs that mean something to this node. */
static void op_known_frame(struct bench *bench, struct fuzz_input *input)
{
    static const struct {
        uint16_t base;
        bool own;
        bool rtr;
        uint8_t dlc;
    } known[] = {
        {0x000, false, false, 2}, {0x080, false, false, 0}, {0x080, false, false, 1},
        {0x100, false, false, 6}, {0x180, true, true, 0},   {0x280, true, true, 0},
        {0x380, true, true, 0},   {0x480, true, true, 0},   {0x700, true, true, 0},
        {0x705, false, false, 1}, {0x706, false, false, 1},
    };
    const uint8_t which = fuzz_take(input) % DG_COUNT(known);
    struct dg_can_frame frame = {
        .id = known[which].base, .rtr = known[which].rtr, .dlc = known[which].dlc};

    frame.id = (uint16_t)(frame.id + (known[which].own ? bench->node.id & 0x7Fu : 0u));
    for (uint8_t i = 0; i < frame.dlc; i++) {
        frame.data[i] = fuzz_take(input);
    }
    receive(bench, &frame);
}

static void op_nmt(struct bench *bench, struct fuzz_input *input)
{
    static const uint8_t commands[] = {0x01, 0x02, 0x80, 0x81, 0x82};
    const struct dg_can_frame frame = {.dlc = 2,
                                       .data = {commands[fuzz_take(input) % DG_COUNT(commands)]}};

    receive(bench, &frame);
}

/* Objects that can be written, with their size. */
static const struct {
    uint16_t index;
    uint8_t sub;
    uint8_t size;
} objects[] = {
    {0x1005, 0, 4}, {0x1006, 0, 4}, {0x1007, 0, 4}, {0x100C, 0, 2}, {0x100D, 0, 1}, {0x1010, 1, 4},
    {0x1011, 1, 4}, {0x1012, 0, 4}, {0x1015, 0, 2}, {0x1016, 1, 4}, {0x1016, 2, 4}, {0x1017, 0, 2},
    {0x1029, 1, 1}, {0x1029, 3, 1}, {0x1800, 1, 4}, {0x1800, 2, 1}, {0x1800, 3, 2}, {0x1800, 5, 2},
    {0x1801, 1, 4}, {0x1801, 2, 1}, {0x1A00, 0, 1}, {0x1A00, 1, 4}, {0x1A00, 2, 4}, {0x1A00, 8, 4},
    {0x2100, 0, 1}, {0x2101, 0, 1}, {0x2105, 0, 4}, {0x6200, 0, 2}, {0x1008, 0, 0}, {0x1003, 0, 1},
    {0x6004, 0, 4}, {0x1000, 0, 4}, {0x1803, 3, 2}, {0x1014, 0, 4},
};

static void op_write(struct bench *bench, struct fuzz_input *input)
{
    static const uint32_t values[] = {
        0,          1,          2,          8,          0x80,       0x90,       0x65766173,
        0x64616F6C, 0x60040020, 0x21620010, 0x10010008, 0x60300110, 0x80000181, 0x00000222,
        0x000500FF, 0x000600FF, 0x80000100, 100,        240,        255,        0x400001BF,
    };
    const uint8_t which = fuzz_take(input) % DG_COUNT(objects);
    const uint8_t how = fuzz_take(input);
    const uint8_t size = objects[which].size == 0 ? 1 : objects[which].size;
    struct dg_can_frame frame = {.id = (uint16_t)(0x600u + (bench->node.id & 0x7Fu)), .dlc = 8};

    frame.data[0] = (uint8_t)(0x23u | (4u - size) << 2);
    dg_store_le16(&frame.data[1], objects[which].index);
    frame.data[3] = objects[which].sub;
    dg_store_le32(&frame.data[4], how < DG_COUNT(values) ? values[how] : fuzz_take32(input));
    receive(bench, &frame);
}

/* Any request of the SDO server, for a known object or with free data. */
static void op_sdo(struct bench *bench, struct fuzz_input *input)
{
    static const uint8_t commands[] = {0x40, 0x60, 0x70, 0x80, 0xA0, 0xA4, 0xA3, 0xA2, 0xA1,
                                       0xC0, 0xC2, 0xC6, 0xC1, 0x20, 0x21, 0x22, 0x00, 0x10,
                                       0x07, 0x0D, 0x1D, 0x01, 0x81, 0x82, 0xC5, 0xCD};
    const uint8_t command = fuzz_take(input);
    const uint8_t which = fuzz_take(input);
    struct dg_can_frame frame = {.id = (uint16_t)(0x600u + (bench->node.id & 0x7Fu)), .dlc = 8};
    size_t from = 1;

    frame.data[0] = command < DG_COUNT(commands) ? commands[command] : command;
    if (which < DG_COUNT(objects)) {
        dg_store_le16(&frame.data[1], objects[which].index);
        frame.data[3] = objects[which].sub;
        from = 4;
    }
    fill(&frame, input, from);
    receive(bench, &frame);
}

static void op_lss(struct bench *bench, struct fuzz_input *input)
{
    static const uint8_t services[] = {0x04, 0x04, 0x11, 0x13, 0x15, 0x17, 0x40, 0x41, 0x42, 0x43,
                                       0x46, 0x47, 0x48, 0x49, 0x4A, 0x4B, 0x4C, 0x51, 0x5A, 0x5E};
    struct dg_can_frame frame = {.id = LSS_RX, .dlc = 8};
    const uint8_t service = fuzz_take(input);

    frame.data[0] = service < DG_COUNT(services) ? services[service] : service;
    fill(&frame, input, 1);
    if (frame.data[0] == 0x15) {
        frame.data[2] = 0; /* not silent for the rest of the input */
    }
    receive(bench, &frame);
}

/* ------------------------------------------------------------ whole dialogues */

static void sdo(struct bench *bench, const uint8_t *data)
{
    struct dg_can_frame frame = {.id = (uint16_t)(0x600u + (bench->node.id & 0x7Fu)), .dlc = 8};

    memcpy(frame.data, data, sizeof frame.data);
    receive(bench, &frame);
}

/* The first frame of a transfer; the caller fills in what follows the object. */
static void name_object(uint8_t *data, uint8_t command, struct fuzz_input *input)
{
    const uint8_t which = fuzz_take(input) % DG_COUNT(objects);

    memset(data, 0, 8);
    data[0] = command;
    dg_store_le16(&data[1], objects[which].index);
    data[3] = objects[which].sub;
}

/* A block upload as a client does it, which loses segments now and then. */
static void op_block_upload(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    const struct dg_co_sdo *server = &bench->node.sdo;
    uint8_t data[8];

    name_object(data, (uint8_t)(0xA0u | (how & 4u)), input);
    data[4] = fuzz_take(input) % 130u;
    data[5] = (how & 1u) != 0 ? fuzz_take(input) : 0;
    sdo(bench, data);
    if (server->state == DG_CO_SDO_BLOCK_UPLOAD_START) {
        sdo(bench, (const uint8_t[8]){0xA3});
    }
    for (unsigned i = 0; i < 8 && server->state == DG_CO_SDO_BLOCK_UPLOAD; i++) {
        const uint8_t lost = (how & 2u) != 0 ? fuzz_take(input) : 0;
        sdo(bench, (const uint8_t[8]){0xA2, (uint8_t)(server->seqno - lost % 3u),
                                      (how & 8u) != 0 ? fuzz_take(input) : 127});
    }
    if (server->state == DG_CO_SDO_BLOCK_UPLOAD_END && (how & 0xF0u) != 0xF0u) {
        sdo(bench, (const uint8_t[8]){0xA1});
    }
}

/* A block download, with a wrong order, length or sum now and then. */
static void op_block_download(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    const struct dg_co_sdo *server = &bench->node.sdo;
    const uint8_t segments = (how & 0xF0u) == 0xF0u ? fuzz_take(input) % 8u : 1;
    uint8_t data[8];
    uint16_t crc = 0;

    name_object(data, (uint8_t)(0xC0u | (how & 6u)), input);
    const uint8_t length = fuzz_take(input) % 8u;
    dg_store_le32(&data[4], length);
    sdo(bench, data);
    for (uint8_t i = 1; i <= segments && server->state == DG_CO_SDO_BLOCK_DOWNLOAD; i++) {
        data[0] = (uint8_t)((i + ((how & 8u) != 0 ? fuzz_take(input) % 3u : 0u)) |
                            (i == segments ? 0x80u : 0u));
        dg_store_le32(&data[1], fuzz_take32(input));
        crc = dg_crc16(0, &data[1], length);
        sdo(bench, data);
    }
    if (server->state == DG_CO_SDO_BLOCK_DOWNLOAD_END) {
        data[0] = (uint8_t)(0xC1u | ((7u - length) & 7u) << 2);
        dg_store_le16(&data[1], (uint16_t)(crc ^ ((how & 1u) != 0 ? fuzz_take(input) : 0u)));
        sdo(bench, data);
    }
}

static void lss(struct bench *bench, uint8_t service, uint32_t value, uint32_t more)
{
    struct dg_can_frame frame = {.id = LSS_RX, .dlc = 8, .data = {service}};

    dg_store_le32(&frame.data[1], value);
    frame.data[5] = (uint8_t)more;
    frame.data[6] = (uint8_t)(more >> 8);
    frame.data[7] = (uint8_t)(more >> 16);
    receive(bench, &frame);
}

static uint32_t identity(const struct bench *bench, unsigned part)
{
    const struct dg_co_device *device = bench->node.setup.device;
    const uint32_t parts[] = {device->vendor_id, device->product_code, device->revision,
                              bench->node.serial};

    return parts[part];
}

/* Vendor, product, revision, serial number; one of them wrong when the input says so. */
static void op_lss_select(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    for (unsigned part = 0; part < 4; part++) {
        lss(bench, (uint8_t)(0x40u + part), identity(bench, part) + (how == part ? 1u : 0u), 0);
    }
}

/* Limits around revision and serial number. */
static void op_lss_identify(struct bench *bench, struct fuzz_input *input)
{
    static const uint8_t parts[] = {0, 1, 2, 2, 3, 3};
    static const uint8_t below[] = {0, 0, 1, 0, 1, 0};
    const uint8_t how = fuzz_take(input);

    for (unsigned i = 0; i < DG_COUNT(parts); i++) {
        const uint32_t wide = how == i ? 0xFFFFFFF0u : how & 7u;
        const uint32_t mine = identity(bench, parts[i]);
        lss(bench, (uint8_t)(0x46u + i),
            i < 2           ? mine
            : below[i] != 0 ? mine - wide
                            : mine + wide,
            0);
    }
}

/* What can be done in the configuration state; then it is left, or not. */
static void op_lss_configure(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    if ((how & 1u) != 0) {
        lss(bench, 0x04, 1, 0);
    }
    for (uint8_t n = how >> 5; n > 0; n--) {
        static const uint8_t services[] = {0x11, 0x13, 0x15, 0x17, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E};
        const uint8_t service = services[fuzz_take(input) % DG_COUNT(services)];
        const uint32_t value = fuzz_take(input);
        /* The table of bit rates is 0, then the rate; a pause is short. */
        lss(bench, service, service == 0x13 ? value % 10u << 8 : value, 0);
    }
    if ((how & 2u) != 0) {
        lss(bench, 0x04, 0, 0);
    }
}

/* One bit after the other of one part after the other, as a master without any idea does it. */
static void op_lss_fastscan(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    if ((how & 1u) != 0) { /* it has no node-ID */
        lss(bench, 0x04, 1, 0);
        lss(bench, 0x11, DG_CO_UNCONFIGURED, 0);
        lss(bench, 0x04, 0, 0);
        step_node(bench);
    }
    lss(bench, 0x4C, 0, 0);
    lss(bench, 0x51, 0, 0x80);
    for (uint32_t part = 0; part < 4; part++) {
        const uint32_t mine =
            identity(bench, part) ^ (how >> 4 == part + 1u ? fuzz_take32(input) : 0u);
        for (uint32_t bit = 32; bit-- > 0;) {
            lss(bench, 0x51, mine & 0xFFFFFFFFu << bit, bit | part << 8 | part << 16);
        }
        lss(bench, 0x51, mine, part << 8 | (part + 1u) % 4u << 16);
    }
}

/* ------------------------------------------------------------ the world */

/* Time passes in one jump, or deadline by deadline. */
static void op_time(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);
    const dg_ns end = dg_after(bench->now, (uint64_t)fuzz_take(input) << (how & 47u));

    for (int i = 0; i < 16 && (how & 128u) != 0 && bench->node.deadline < end; i++) {
        bench->now = bench->node.deadline > bench->now ? bench->node.deadline : bench->now;
        step_node(bench);
    }
    bench->now = end;
    if ((how & 64u) != 0) {
        step_node(bench);
    }
}

static void op_late_step(struct bench *bench, struct fuzz_input *input)
{
    const dg_ns now = bench->now;

    bench->now = dg_elapsed(now, (uint64_t)fuzz_take(input) << 20);
    step_node(bench);
    bench->now = now;
}

static void op_bus(struct bench *bench, struct fuzz_input *input)
{
    check(bench,
          dg_co_bus(&bench->node, bench->now, (enum dg_co_bus_event)(fuzz_take(input) % 6u)));
}

static void op_shaft(struct bench *bench, struct fuzz_input *input)
{
    bench->angle = (dg_angle)((uint64_t)fuzz_take32(input) << 32 | fuzz_take32(input));
    bench->angle_per_ms = (int64_t)(int32_t)fuzz_take32(input) * 256;
}

static void op_acknowledge(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t bits = fuzz_take(input);

    bench->world.eeprom_acknowledges = (bits & 1u) != 0;
    bench->nvm.no_acknowledge = (bits & 6u) == 6u;
}

static void op_rot(struct bench *bench, struct fuzz_input *input)
{
    const uint32_t where = fuzz_take32(input);

    bench->nvm.bytes[(where >> 3) % bench->nvm.size] ^= (uint8_t)(1u << (where & 7u));
}

static void op_power_cut(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    ram_nvm_cut(&bench->nvm, how & 63u, (enum ram_nvm_tear)((how >> 6) % RAM_NVM_TEAR_COUNT),
                fuzz_take(input));
}

static void op_power(struct bench *bench, struct fuzz_input *input)
{
    const uint8_t how = fuzz_take(input);

    if ((how & 1u) != 0) {
        ram_nvm_restore(&bench->nvm);
    }
    bench->answers = 0;
    if ((how & 6u) == 6u) {
        dg_co_power_off(&bench->node);
        return;
    }
    const int result = dg_co_power_on(&bench->node, bench->now);
    fuzz_must(result == DG_OK || result == DG_ERR_BLANK || result == DG_ERR_FOREIGN);
    fuzz_must((result != DG_OK) == (bench->node.state == DG_CO_OFF));
    step_node(bench);
}

static bool start_node(struct bench *bench, const struct dg_cia406_model *model)
{
    const struct dg_co_setup setup = {.device = model->device,
                                      .world = &bench->world,
                                      .nvm = ram_nvm_port(&bench->nvm),
                                      .ops = &ops,
                                      .ctx = bench,
                                      .application = &bench->encoder};

    dg_world_init(&bench->world);
    bench->world.angle = angle;
    bench->world.angle_ctx = bench;
    bench->sender = &bench->node;
    ram_nvm_init(&bench->nvm, dg_store_size(model->device->layout));
    return dg_co_format(model->device, setup.nvm, 1234567890u) == DG_OK &&
           dg_cia406_init(&bench->encoder, model) == DG_OK &&
           dg_co_init(&bench->node, &setup) == DG_OK && dg_co_power_on(&bench->node, 0) == DG_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t n)
{
    /* Some stand twice: they are what a bus is made of. */
    static void (*const operations[])(struct bench *, struct fuzz_input *) = {
        op_any_frame,  op_known_frame,  op_known_frame,   op_nmt,          op_write,
        op_write,      op_sdo,          op_sdo,           op_lss,          op_time,
        op_time,       op_late_step,    op_bus,           op_shaft,        op_acknowledge,
        op_power_cut,  op_rot,          op_power,         op_block_upload, op_block_download,
        op_lss_select, op_lss_identify, op_lss_configure, op_lss_fastscan,
    };
    static struct bench bench;
    struct fuzz_input input = {.at = bytes, .end = bytes + n};

    memset(&bench, 0, sizeof bench);
    fuzz_must(start_node(&bench, dg_cia406_model_of(dg_device_find(
                                     (fuzz_take(&input) & 1u) != 0 ? "f3658" : "f3668"))));
    while (input.at < input.end) {
        pass(&bench, DG_US(100));
        operations[fuzz_take(&input) % DG_COUNT(operations)](&bench, &input);
        check_objects(&bench);
    }
    return 0;
}

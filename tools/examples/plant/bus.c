/* SPDX-License-Identifier: MIT */
/*
 * A bus: what the master sends to its nodes, and whether they answer what they should.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "master.h"

#define SHAFT_TYPE "application/vnd.drehgeber.shaft.v1"
#define PACK_TYPE "application/vnd.drehgeber.can.v1"
#define TOPIC_MAX 64u

/* F3668 as delivered has 2^16 steps a turn, 2^28 in all. */
#define START 0x000u
#define SYNC 0x080u
#define TPDO2 0x280u
#define STEP_BITS 16u
#define STEPS_MASK 0x0FFFFFFFu
#define DATA_MAX 8u
#define MRPM_MAX 3000000
#define MRPM_PER_RPS 60000
#define TURN INT64_C(0x100000000)

/* --- little-endian numbers, and a hash --- */

static void store_number(uint8_t *to, uint64_t value, unsigned size)
{
    for (unsigned i = 0; i < size; i++) {
        to[i] = (uint8_t)(value >> 8u * i);
    }
}

static uint64_t load_bytes(const uint8_t *from, unsigned size)
{
    uint64_t value = 0;
    for (unsigned i = 0; i < size; i++) {
        value |= (uint64_t)from[i] << 8u * i;
    }
    return value;
}

/* FNV-1a. */
#define HASH_OF_NOTHING UINT64_C(0xCBF29CE484222325)

static uint64_t hash_bytes(uint64_t so_far, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        so_far = (so_far ^ bytes[i]) * UINT64_C(0x100000001B3);
    }
    return so_far;
}

static uint64_t hash_number(uint64_t so_far, uint64_t value, unsigned size)
{
    uint8_t bytes[8];
    store_number(bytes, value, size);
    return hash_bytes(so_far, bytes, size);
}

/* --- shafts --- */

/* How far `ns` at `mrpm` are: mrpm * ns * 2^32 / (60000 * 10^9), rounded down, is
   mrpm * ns * SCALE / BASE without the common factor. No product here has more than 63 bits. */
#define SCALE INT64_C(0x40000)
#define BASE INT64_C(3662109375)

static int64_t travel_of(int64_t mrpm, uint64_t ns)
{
    const int64_t whole = (int64_t)(ns / (uint64_t)BASE);
    const int64_t part = mrpm * (int64_t)(ns % (uint64_t)BASE);
    const int64_t rest = (part % BASE + BASE) % BASE;
    return (mrpm * whole + (part - rest) / BASE) * SCALE + rest * SCALE / BASE;
}

static int64_t measure_shaft(const struct shaft *self, uint64_t now)
{
    return self->angle + travel_of(self->mrpm, now - self->since);
}

/* splitmix64 */
static uint64_t draw_random(uint64_t *state)
{
    *state += UINT64_C(0x9E3779B97F4A7C15);
    uint64_t drawn = *state;
    drawn = (drawn ^ drawn >> 30u) * UINT64_C(0xBF58476D1CE4E5B9);
    drawn = (drawn ^ drawn >> 27u) * UINT64_C(0x94D049BB133111EB);
    return drawn ^ drawn >> 31u;
}

/* --- to the encoders --- */

static void send_to_nodes(struct bus *self, uint32_t id, const uint8_t *data, size_t n)
{
    struct master *master = self->master;
    const struct kit *kit = &master->kit;
    uint8_t message[PACK_HEAD + PACK_FRAME + DATA_MAX] = {0};
    if (!master->plant.packed) {
        master_demand(master, "CanController_SendFrame",
                      kit_send(kit, self->wire, id, (struct kit_bytes){data, n}));
        return;
    }
    store_number(message, master->now, 8);
    store_number(message + 8, 1, 2);
    store_number(message + PACK_HEAD + 4, id, 2);
    message[PACK_HEAD + 6] = (uint8_t)n;
    memcpy(message + PACK_HEAD + PACK_FRAME, data, n);
    master_demand(
        master, "DataPublisher_Publish",
        kit_publish(kit, self->wire, (struct kit_bytes){message, PACK_HEAD + PACK_FRAME + n}));
}

/* It goes on with another speed. */
static void change_speed(struct bus *self)
{
    struct master *master = self->master;
    struct shaft *shaft = &self->shaft;
    uint8_t message[16];
    shaft->angle = measure_shaft(shaft, master->now);
    shaft->since = master->now;
    shaft->mrpm = (int64_t)(draw_random(&shaft->random) % (2u * MRPM_MAX + 1u)) - MRPM_MAX;
    store_number(message, (uint64_t)shaft->angle, 8);
    store_number(message + 8, (uint64_t)(shaft->mrpm * TURN / MRPM_PER_RPS), 8);
    master_demand(
        master, "DataPublisher_Publish",
        kit_publish(&master->kit, self->turns, (struct kit_bytes){message, sizeof message}));
}

void bus_start(struct bus *self)
{
    static const uint8_t all[] = {1, 0};
    send_to_nodes(self, START, all, sizeof all);
}

void bus_count_missing(struct bus *self)
{
    for (unsigned node = 0; node < self->master->plant.nodes; node++) {
        if ((self->missing[node / 64u] >> node % 64u & 1u) != 0) {
            master_note_wrong(self->master, "bus%u: %03Xh is missing", self->number,
                              TPDO2 + 1u + node);
        }
    }
    memset(self->missing, 0, sizeof self->missing);
}

void bus_sync(struct bus *self)
{
    struct master *master = self->master;
    bus_count_missing(self);
    memcpy(self->missing, master->all, sizeof self->missing);
    self->asked = true;
    self->asked_at = master->now;
    const uint64_t angle = (uint64_t)measure_shaft(&self->shaft, master->now);
    store_number(self->position, angle >> STEP_BITS & STEPS_MASK, POSITION_SIZE);
    master->syncs++;
    send_to_nodes(self, SYNC, (const uint8_t *)"", 0);
    change_speed(self);
}

/* --- from the encoders --- */

/* Each node answers a SYNC once. */
static void check_answer(struct bus *self, uint32_t id, struct kit_bytes told, uint64_t at)
{
    struct master *master = self->master;
    const uint32_t node = id - TPDO2 - 1u;
    char hex[2u * DATA_MAX + 1u] = "";
    if (node >= master->plant.nodes || !self->asked) {
        return;
    }
    uint64_t *missing = &self->missing[node / 64u];
    const uint64_t bit = UINT64_C(1) << node % 64u;
    if ((*missing & bit) == 0) {
        master_note_wrong(master, "bus%u: %03Xh without SYNC", self->number, id);
        return;
    }
    *missing &= ~bit;
    master->checked++;
    if (told.size != POSITION_SIZE || memcmp(told.data, self->position, POSITION_SIZE) != 0) {
        for (size_t i = 0; i < told.size && i < DATA_MAX; i++) {
            (void)snprintf(hex + 2u * i, 3, "%02x", told.data[i]);
        }
        master_note_wrong(master, "bus%u: %03Xh tells %s, not %02x%02x%02x%02x", self->number, id,
                          hex, self->position[0], self->position[1], self->position[2],
                          self->position[3]);
    } else if (at != self->asked_at) {
        master_note_wrong(master, "bus%u: %03Xh is of %" PRIu64 " ns, not of %" PRIu64 " ns",
                          self->number, id, at, self->asked_at);
    }
}

/* A frame of a packed message. */
struct frame {
    uint64_t at;
    uint32_t id; /* with PACK_REMOTE */
    struct kit_bytes data;
};

/* The next one of `left`, which begins with it. @return false: there is no whole one */
static bool unpack_frame(struct kit_bytes *left, uint64_t begin, struct frame *frame)
{
    if (left->size < PACK_FRAME) {
        return false;
    }
    const uint8_t *from = left->data;
    *frame =
        (struct frame){.at = begin + load_bytes(from, 4), .id = (uint32_t)load_bytes(from + 4, 2)};
    frame->data.data = from + PACK_FRAME;
    frame->data.size = (frame->id & PACK_REMOTE) != 0 ? 0 : from[6];
    const size_t size = PACK_FRAME + frame->data.size;
    if (from[6] > DATA_MAX || left->size < size) {
        return false;
    }
    left->data += size;
    left->size -= size;
    return true;
}

/* Frames of the last steps may come or not, as the engine ends them: they are left out. */
static void hash_frame(struct bus *self, const struct frame *frame)
{
    const struct master *master = self->master;
    if (master->plant.hash && frame->at < master->ends * master->plant.step_us * 1000u) {
        self->hash = hash_number(self->hash, frame->at, 8);
        self->hash = hash_number(self->hash, frame->id, 2);
        self->hash = hash_bytes(self->hash, frame->data.data, frame->data.size);
    }
}

static void check_frames(struct bus *self, struct kit_bytes message)
{
    struct kit_bytes left = {message.data + PACK_HEAD, message.size - PACK_HEAD};
    struct frame frame;
    uint64_t count = load_bytes(message.data + 8, 2);
    const uint64_t begin = load_bytes(message.data, 8);
    for (; count > 0 && unpack_frame(&left, begin, &frame); count--) {
        self->master->frames++;
        hash_frame(self, &frame);
        check_answer(self, frame.id, frame.data, frame.at);
    }
    if (count != 0 || left.size != 0) {
        master_note_wrong(self->master, "bus%u: a message of %zu bytes is cut", self->number,
                          message.size);
    }
}

/* All positions of a bus in one message, in the order of the nodes: this is what a plant without
   faults sends, so it is compared as a whole. */
static bool is_usual_answer(const struct bus *self, struct kit_bytes message)
{
    struct master *master = self->master;
    if (!self->asked || master->plant.hash || message.size != master->usual_size ||
        memcmp(self->missing, master->all, sizeof self->missing) != 0) {
        return false;
    }
    uint8_t *answer = master->usual + PACK_HEAD + PACK_FRAME;
    store_number(master->usual, self->asked_at, 8);
    for (unsigned node = 0; node < master->plant.nodes; node++, answer += ANSWER_SIZE) {
        memcpy(answer, self->position, POSITION_SIZE);
    }
    return memcmp(message.data, master->usual, message.size) == 0;
}

static void check_message(struct bus *self, struct kit_bytes message)
{
    struct master *master = self->master;
    if (is_usual_answer(self, message)) {
        master->frames += master->plant.nodes;
        master->checked += master->plant.nodes;
        memset(self->missing, 0, sizeof self->missing);
    } else if (message.size < PACK_HEAD) {
        master_note_wrong(master, "bus%u: a message of %zu bytes is cut", self->number,
                          message.size);
    } else {
        check_frames(self, message);
    }
}

/* --- on the library's thread --- */

/* The moment of a CAN message is that of the rig's step. */
static void receive_can_frame(void *ctx, void *controller, const struct kit_frame_event *event)
{
    struct bus *self = ctx;
    (void)controller;
    if (!self->master->complete && !self->master->over) {
        self->master->frames++;
        check_answer(self, event->frame->id, event->frame->data, self->asked_at);
    }
}

static void on_message(void *ctx, void *subscriber, const struct kit_data_event *event)
{
    struct bus *self = ctx;
    (void)subscriber;
    if (!self->master->complete && !self->master->over) {
        check_message(self, event->data);
    }
}

/* --- life --- */

void bus_connect(struct master *master, unsigned number)
{
    struct bus *bus = &master->bus[number];
    char topic[TOPIC_MAX];
    *bus = (struct bus){.master = master, .number = number, .shaft = {.random = number}};
    bus->hash = hash_number(HASH_OF_NOTHING, number, 4);
    (void)snprintf(topic, sizeof topic, "plant-%u/shaft/s%u/turn", number / master->plant.buses,
                   number);
    bus->turns = kit_make_publisher(&master->kit, topic, SHAFT_TYPE);
    if (master->plant.packed) {
        (void)snprintf(topic, sizeof topic, "bus%u/frames", number);
        kit_subscribe(&master->kit, topic, PACK_TYPE, on_message, bus);
        (void)snprintf(topic, sizeof topic, "bus%u/frames/to", number);
        bus->wire = kit_make_publisher(&master->kit, topic, PACK_TYPE);
    } else {
        (void)snprintf(topic, sizeof topic, "bus%u", number);
        bus->wire = kit_make_controller(&master->kit, topic, receive_can_frame, bus);
    }
}

void bus_prepare(struct master *master)
{
    const uint32_t nodes = master->plant.nodes;
    master->usual_size = PACK_HEAD + (size_t)nodes * ANSWER_SIZE;
    store_number(master->usual + 8, nodes, 2);
    for (uint32_t node = 0; node < nodes; node++) {
        uint8_t *answer = master->usual + PACK_HEAD + (size_t)node * ANSWER_SIZE;
        store_number(answer + 4, TPDO2 + 1u + node, 2);
        answer[6] = POSITION_SIZE;
        master->all[node / 64u] |= UINT64_C(1) << node % 64u;
    }
}

uint64_t bus_hash_all(const struct master *master)
{
    uint64_t hash = HASH_OF_NOTHING;
    for (unsigned i = 0; i < master->buses; i++) {
        hash = hash_number(hash, master->bus[i].hash, 8);
    }
    return hash;
}

/* SPDX-License-Identifier: MIT */
/* A CANopen master: SYNC for all nodes, then an SDO upload from one of them. */
#define _GNU_SOURCE
#include "slcan.h"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define SYNC_PERIOD (20 * NS_PER_MS)
#define ID_NMT 0x000u
#define ID_SYNC 0x080u
#define ID_EMCY 0x080u
#define ID_TPDO2 0x280u
#define ID_SDO_ANSWER 0x580u
#define ID_SDO_REQUEST 0x600u
#define ID_BOOT_UP 0x700u
#define ID_SERVICE 0x780u
#define ID_NODE 0x07Fu
#define NMT_START 0x01u
#define EMCY_BUS_OFF_OVER 0x8140u
#define UPLOADED_FOUR 0x43u

/* What is on the way of a cycle. */
struct cycle {
    int64_t sync;   /* when it went out */
    int64_t upload; /* 0: none is on the way */
    struct device *asked;
    size_t missing;
};

/* A terminal has a path, an interface a name. */
static bool is_slcan(const struct master *self)
{
    return strchr(self->where, '/') != NULL;
}

static void send_frame(const struct master *self, uint32_t id, const uint8_t *data, uint8_t n)
{
    struct can_frame frame = {.can_id = id, .can_dlc = n};
    memcpy(frame.data, data, n);
    if (is_slcan(self)) {
        slcan_send(self, &frame);
    } else if (write(self->fd, &frame, sizeof frame) != (ssize_t)sizeof frame) {
        die(self->where);
    }
}

static void start_node(const struct master *self, uint8_t node)
{
    send_frame(self, ID_NMT, (const uint8_t[]){NMT_START, node}, 2);
}

static uint32_t little_endian(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static void take_tpdo(struct master *self, struct cycle *cycle, struct device *device,
                      const struct can_frame *frame)
{
    const bool right = check(self, device, little_endian(frame->data), cycle->sync);
    device->right = right && (device->right || device->answers == 0);
    if (device->answers == 0) {
        cycle->missing--;
        took(self, cycle->sync);
    }
    device->answers++;
}

static void take_upload(struct master *self, struct cycle *cycle, struct device *device,
                        const struct can_frame *frame)
{
    if (cycle->upload == 0 || device != cycle->asked) {
        return;
    }
    if (frame->data[0] != UPLOADED_FOUR) {
        garble(self, device);
    } else {
        took(self, cycle->upload);
        (void)check(self, device, little_endian(frame->data + 4), cycle->upload);
    }
    cycle->upload = 0;
}

/* A node that was away has to be started again. */
static void take_emergency(struct master *self, struct cycle *cycle, struct device *device,
                           const struct can_frame *frame)
{
    const uint32_t code = little_endian(frame->data) & 0xFFFFu;
    (void)cycle;
    say(device->name, "emcy %04Xh", code);
    if (code == EMCY_BUS_OFF_OVER) {
        start_node(self, (uint8_t)device->address);
    }
}

static void take_boot_up(struct master *self, struct cycle *cycle, struct device *device,
                         const struct can_frame *frame)
{
    (void)cycle;
    (void)frame;
    say(device->name, "boot-up");
    start_node(self, (uint8_t)device->address);
}

static const struct {
    uint32_t id;
    void (*take)(struct master *self, struct cycle *cycle, struct device *device,
                 const struct can_frame *frame);
} services[] = {
    {ID_EMCY, take_emergency},
    {ID_TPDO2, take_tpdo},
    {ID_SDO_ANSWER, take_upload},
    {ID_BOOT_UP, take_boot_up},
};

static void take_frame(struct master *self, struct cycle *cycle, const struct can_frame *frame)
{
    for (size_t i = 0; i < sizeof services / sizeof services[0]; i++) {
        for (size_t k = 0; (frame->can_id & ID_SERVICE) == services[i].id && k < self->count; k++) {
            if (self->device[k].address == (frame->can_id & ID_NODE)) {
                services[i].take(self, cycle, &self->device[k], frame);
            }
        }
    }
}

/* @return whether one came before `end` */
static bool next_frame(struct master *self, struct can_frame *frame, int64_t end)
{
    if (is_slcan(self)) {
        return slcan_take(self, frame, end);
    }
    if (!readable(self->fd, end)) {
        return false;
    }
    if (read(self->fd, frame, sizeof *frame) != (ssize_t)sizeof *frame) {
        die(self->where);
    }
    return true;
}

/* Frames until `end`, or until all are there that are waited for. */
static void take_frames(struct master *self, struct cycle *cycle, int64_t end, bool all)
{
    struct can_frame frame;
    while ((all || cycle->missing > 0 || cycle->upload != 0) && next_frame(self, &frame, end)) {
        take_frame(self, cycle, &frame);
    }
}

static void judge(struct master *self, struct device *device)
{
    if (device->answers == 0) {
        lose(self, device);
    } else if (device->answers > 1) {
        become(device, "twice");
    } else if (device->right) {
        become(device, "ok");
    }
    device->answers = 0;
}

/* Whoever did not answer to SYNC is not asked by SDO. */
static void ask_sdo(struct master *self, struct cycle *cycle, struct device *device)
{
    if (device->answers == 0) {
        return;
    }
    cycle->asked = device;
    cycle->upload = now_ns();
    send_frame(self, ID_SDO_REQUEST + device->address, (const uint8_t[8]){0x40, 0x04, 0x60}, 8);
    take_frames(self, cycle, cycle->upload + self->patience, false);
    if (cycle->upload != 0) {
        lose(self, device);
    }
}

static void open_interface(struct master *self)
{
    struct sockaddr_can address = {.can_family = AF_CAN};
    address.can_ifindex = (int)if_nametoindex(self->where);
    self->fd = socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    if (self->fd < 0 || bind(self->fd, (struct sockaddr *)&address, sizeof address) != 0) {
        die(self->where);
    }
}

void run_can(struct master *self)
{
    struct cycle cycle = {0};
    const int64_t period = self->most == 0 ? SYNC_PERIOD : 0;
    if (is_slcan(self)) {
        slcan_open(self);
    } else {
        open_interface(self);
    }
    start_node(self, 0);
    for (unsigned i = 0; goes_on(self) && self->count > 0; i++) {
        cycle = (struct cycle){.sync = now_ns(), .missing = self->count};
        send_frame(self, ID_SYNC, (const uint8_t[]){0}, 0);
        take_frames(self, &cycle, cycle.sync + self->patience, false);
        ask_sdo(self, &cycle, &self->device[i % self->count]);
        take_frames(self, &cycle, cycle.sync + period, true);
        for (size_t k = 0; k < self->count; k++) {
            judge(self, &self->device[k]);
        }
    }
}

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders on a bus of frames in virtual time, a door that keeps what they send, and their faults.
 * There is one such rig.
 */
#ifndef TESTS_SUPPORT_FRAMES_RIG_H
#define TESTS_SUPPORT_FRAMES_RIG_H

#include "drehgeber/bus_frames.h"
#include "drehgeber/control.h"
#include "drehgeber/host_wire.h"
#include "host_rig.h"

#define FRAMES_RIG_ENCODERS 4u
#define FRAMES_RIG_SENT_MAX 512u
#define FRAMES_RIG_ROOMS 300u
#define HEARTBEAT 0x700u
#define EMCY 0x80u
#define SDO 0x580u
#define ASK 0x600u

/** A frame that came out. */
struct frames_rig_sent {
    size_t place;
    struct dg_tap_event event;
};

/** All there is; `control` is what faults happen to. */
extern struct frames_rig {
    _Alignas(DG_HOST_ALIGN) uint8_t memory[32768];
    struct host_rig_place places[FRAMES_RIG_ENCODERS];
    struct dg_host *host[FRAMES_RIG_ENCODERS];
    struct dg_encoder control[FRAMES_RIG_ENCODERS];
    struct dg_bus_frames_room rooms[FRAMES_RIG_ROOMS];
    struct dg_bus *bus;
    struct frames_rig_sent sent[FRAMES_RIG_SENT_MAX];
    size_t count;
    size_t tapped;
    enum dg_bus_answer answer;
    unsigned filters;
    uint32_t retuned[FRAMES_RIG_ENCODERS];
    bool open_before; /* what is sent now may be answered: an identifier that has to be open */
    uint16_t wanted;
    uint16_t stall_at; /* a frame behind which the port has no room; 0: none */
} frames_rig;

/** A bus that is made of `wire`, with the rig's door and room. NULL: it is refused. */
struct dg_bus *frames_rig_make_bus(struct dg_bus_frames_setup *wire, size_t encoders);

/** Encoders with the node-IDs 1, 2, ...; it is 1 s, their boot-ups are through and forgotten. */
void frames_rig_begin(struct dg_bus_frames_setup wire, size_t encoders);

/** The master sends. @return as dg_bus_rx() */
dg_ns frames_rig_send(dg_ns at, uint16_t id, uint8_t dlc, const uint8_t *data);
/** An expedited download of a number to node i + 1; an upload of 1000h. */
dg_ns frames_rig_write(dg_ns at, size_t i, uint16_t index, uint8_t sub, uint32_t value,
                       uint8_t size);
dg_ns frames_rig_ask(dg_ns at, size_t i);

/** Frames with this identifier that came out; the first two bytes of frame `i` of all. */
unsigned frames_rig_count(uint16_t id);
uint16_t frames_rig_code(size_t i);

/** A fault of encoder `i` is set for `count` frames (0: no limit), or cleared. */
void frames_rig_bend(size_t i, const char *name, bool on, uint32_t count, dg_ns now);

#endif

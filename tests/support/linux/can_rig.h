/* SPDX-License-Identifier: MIT */
/**
 * @file
 * CANopen encoders on a bus of the event loop: behind an SLCAN adapter with a client on its pty, or
 * on a wire of the test's. Every wait in here has an end.
 */
#ifndef TESTS_SUPPORT_CAN_RIG_H
#define TESTS_SUPPORT_CAN_RIG_H

#include "can_bus.h"
#include "drehgeber/cia406.h"
#include "engine.h"

#define CAN_RIG_NODES_MAX 127u
#define CAN_RIG_FRAMES_MAX 4096u
/** For what should happen at once, on a busy machine. */
#define CAN_RIG_PATIENCE DG_S(5)
/** For what should not happen. */
#define CAN_RIG_QUIET DG_MS(60)

/** A wire of the test's: it takes everything, unless it is full. */
struct can_wire {
    struct lx_can can;
    struct dg_can_frame frame[CAN_RIG_FRAMES_MAX];
    dg_ns at[CAN_RIG_FRAMES_MAX]; /**< when it was sent */
    size_t count;
    bool full;
    bool down;
    bool paused;
    uint32_t bit_rate; /**< 0: it has none of its own */
    bool seen_all;     /**< filter() was told that everything is wanted */
    bool lets[0x800];  /**< ... or which CAN-IDs */
    uint16_t asked;    /**< whether it let this one through when a frame was sent: */
    bool open[CAN_RIG_FRAMES_MAX];
};

/** A rig of one bus. */
struct can_rig {
    char folder[32];
    char link[64];
    char nvm[CAN_RIG_NODES_MAX][64]; /**< files that are removed at the end */
    char name[CAN_RIG_NODES_MAX][24];
    sd_event *event;
    struct dg_plan plan; /**< of the next three */
    struct dg_plan_shaft shaft;
    struct dg_plan_wire wire;
    struct dg_plan_encoder encoder[CAN_RIG_NODES_MAX];
    struct lx_engine engine;
    struct lx_station *station; /**< the engine's */
    dg_angle angle[CAN_RIG_NODES_MAX];
    struct lx_clock clock;
    struct lx_bus *bus;
    struct lx_error error;

    int client; /**< descriptor of the pty; -1: none */
    char line[64];
    size_t length;
    size_t answered;                               /**< commands of the client, with CR or BELL */
    struct dg_can_frame frame[CAN_RIG_FRAMES_MAX]; /**< that came to the client */
    size_t taken;                                  /**< frames the test has looked at */
    size_t count;
};

/** For cmocka: `*state` is a rig without a bus. */
int can_rig_set_up(void **state);
int can_rig_tear_down(void **state);

/** Encoders e0, e1, ... with the node-IDs 1, 2, ..., f3668 and f3658 in turn. */
void can_rig_plan(struct can_rig *self, size_t count);
/** Make a bus of the first `count` encoders, as can_rig_open_slcan(), and do not open it.
 * @return as lx_engine_make(), with self->error */
int can_rig_make_slcan(struct can_rig *self, size_t count);
/** Open a bus of the first `count` encoders: behind an adapter, on a wire of the test's. */
void can_rig_open_slcan(struct can_rig *self, size_t count);
void can_rig_open(struct can_rig *self, size_t count);
/** Close the bus and the client. */
void can_rig_shut(struct can_rig *self);

struct can_wire *can_rig_wire(const struct can_rig *self);
struct dg_co_node *can_rig_device(struct can_rig *self, size_t i);
/** Tell the bus that encoder `i` has changed. */
void can_rig_changed(struct can_rig *self, size_t i);
/** Let a fault happen to `count` frames (0: no limit), and end it. */
void can_rig_bend(struct can_rig *self, size_t i, enum dg_wire_fault fault, uint32_t count);
void can_rig_mend(struct can_rig *self, size_t i, enum dg_wire_fault fault);

/** A turn of the loop; turns for a time. */
void can_rig_turn(struct can_rig *self);
void can_rig_run(struct can_rig *self, dg_ns span);

/** Open the adapter's channel at 250 kBd; what came before is forgotten. */
void can_rig_connect(struct can_rig *self);
/** The client sends. */
/** Commands of the client to the adapter, each with its CR; until all are answered. */
void can_rig_say(struct can_rig *self, const char *commands);
void can_rig_send(struct can_rig *self, uint16_t id, const uint8_t *data, size_t n);
/** The next frame with this CAN-ID; NULL when there is none within `patience`. */
const struct dg_can_frame *can_rig_next(struct can_rig *self, uint16_t id, dg_ns patience);
/** Ask for an object; the same, and its value. */
void can_rig_ask(struct can_rig *self, uint8_t id, uint16_t index);
uint32_t can_rig_upload(struct can_rig *self, uint8_t id, uint16_t index);
/** Whether a node answers, and whether it does not. */
bool can_rig_answers(struct can_rig *self, uint8_t id);
bool can_rig_is_silent(struct can_rig *self, uint8_t id);

/** On the wire of the test's: write an object of encoder `i`; frames sent with a CAN-ID. */
void can_rig_write(struct can_rig *self, size_t i, uint16_t index, uint8_t sub, uint32_t value,
                   uint8_t size);
unsigned can_rig_sent(const struct can_rig *self, uint16_t id);

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * RS485 encoders on one pty, on an event loop, with a master in the same process that opens the
 * slave side. Every wait has an end; what goes wrong fails the test.
 */
#ifndef TESTS_SUPPORT_LINE_RIG_H
#define TESTS_SUPPORT_LINE_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/hiperface.h"
#include "engine.h"
#include "plan_rig.h"

/** Encoders on a line. */
#define LINE_STATIONS_MAX 32u
/** 42h. */
#define LINE_READ_POSITION "42"
/** How long a reply may take that has to come, and how long one is waited for that must not. */
#define LINE_PATIENCE DG_S(5)
#define LINE_SILENCE DG_MS(60)

/** Characters as the tap told them. */
struct line_heard {
    struct lx_tap_listener listener;
    size_t count;
    size_t ours;
    size_t damaged;
    dg_ns last;
    bool disordered;
    uint8_t bytes[256];
};

/** The line, its encoders and its master. Not to be moved while open. */
struct line_rig {
    struct dg_plan plan;
    struct lx_say say;
    sd_event *event;
    struct lx_clock clock;
    struct lx_engine_setup setup;
    struct lx_engine engine;
    struct lx_station *station; /**< the engine's, as is the bus */
    struct lx_bus *bus;
    dg_angle shaft; /**< of all */
    struct line_heard heard;
    int master;
    uint8_t reply[2 * DG_HF_FRAME_MAX];
    size_t length;
};

/** A plan of `count` encoders, the first one at 40h, the next at 41h ... */
void line_rig_plan(struct line_rig *self, size_t count, const char *where);

/** KEY=VALUE for one of them. */
void line_rig_set(struct line_rig *self, size_t index, const char *assignment);

/** Loop and line_rig.setup. */
void line_rig_prepare(struct line_rig *self);

/** The door of a pty. */
extern const struct lx_wire line_rig_pty;

/** Make what the plan says, and open nothing; it is right. */
void line_rig_make(struct line_rig *self, const struct lx_wire *door);

/** What is not right about the plan. @return in one line */
struct lx_words line_rig_refused(struct line_rig *self);

/** That, and the power on. The other two also have the master, and the start-up window over. */
void line_rig_open(struct line_rig *self, const struct lx_wire *door);
void line_rig_open_made(struct line_rig *self, const struct lx_wire *door);
void line_rig_open_pty(struct line_rig *self);

/** Everything off and free. */
void line_rig_close(struct line_rig *self);

/** An encoder's device. */
struct dg_hf *line_rig_device(struct line_rig *self, size_t index);

/** Its power or its faults have changed. */
void line_rig_changed(struct line_rig *self, size_t index);

/** Let the loop run. */
void line_rig_run(struct line_rig *self, dg_ns span);

/** Wait for `n` characters of replies. @return how many there are */
size_t line_rig_receive(struct line_rig *self, size_t n, dg_ns patience);

/** After a pause, a request; the check sum is added. What came before is forgotten. */
void line_rig_request(struct line_rig *self, uint8_t address, const char *command);

/** The same, and a reply of `length` characters, with the right address and check sum.
 * @return its length */
size_t line_rig_ask(struct line_rig *self, uint8_t address, const char *command, size_t length);

/** 42h is answered; 42h is not answered. */
void line_rig_answers(struct line_rig *self, uint8_t address);
void line_rig_silent(struct line_rig *self, uint8_t address);

/** Let a fault happen to `count` frames (0: until mended). */
void line_rig_bend(struct line_rig *self, size_t index, enum dg_wire_fault fault, uint32_t count);

#endif

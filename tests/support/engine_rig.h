/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A rig of a text in virtual time, with a client of its control plane.
 */
#ifndef TESTS_SUPPORT_ENGINE_RIG_H
#define TESTS_SUPPORT_ENGINE_RIG_H

#include "drehgeber/hal.h"
#include "drehgeber/instruments.h"
#include "drehgeber/rig_engine.h"

#define ENGINE_RIG_PLAN 65536u
#define ENGINE_RIG_MEMORY ((size_t)1u << 20u)
#define ENGINE_RIG_ANSWER 8192u
/** Power is on since then. */
#define ENGINE_RIG_ON DG_S(1)

struct engine_rig {
    _Alignas(16) unsigned char plan_memory[ENGINE_RIG_PLAN];
    _Alignas(16) unsigned char memory[ENGINE_RIG_MEMORY];
    struct dg_plan plan;
    struct dg_engine_setup setup; /**< may be changed before the rig is made */
    struct dg_engine *engine;     /**< NULL: it was refused */
    struct dg_plan_error error;
    struct dg_control client;
    char answer[ENGINE_RIG_ANSWER];
};

/** The plan is that of `text`, a rig file, which can be read (cmocka assertion); the setup has all
 * instruments, and nothing else of a host. */
void engine_rig_read(struct engine_rig *self, const char *text);
/** Make what was read. */
void engine_rig_make(struct engine_rig *self);
/** Make it, which must succeed, switch it on and connect the client. */
void engine_rig_power(struct engine_rig *self);
/** Connect a new client to what was made. */
void engine_rig_connect(struct engine_rig *self);
/** Read, make, power. */
void engine_rig_start(struct engine_rig *self, const char *text);
/** What the client is told, without the newline. */
const char *engine_rig_ask(struct engine_rig *self, dg_ns now, const char *line);
/** The same of a line that is refused: the error's number and words. */
const char *engine_rig_refusal(struct engine_rig *self, dg_ns now, const char *line);

#endif

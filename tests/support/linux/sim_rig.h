/* SPDX-License-Identifier: MIT */
/**
 * @file
 * BiSS encoders (s3684-biss) on the simulated wire, in a clock that stands still until the test
 * steps it. What goes wrong in here fails the test.
 */
#ifndef TESTS_SUPPORT_SIM_RIG_H
#define TESTS_SUPPORT_SIM_RIG_H

#include "drehgeber/biss.h"
#include "engine.h"
#include "plan_rig.h"

#define SIM_RIG_ENCODERS_MAX 8u
#define SIM_RIG_POWER_ON DG_S(1)
/** Initialisation, and a bit. */
#define SIM_RIG_READY (SIM_RIG_POWER_ON + DG_MS(101))
#define SIM_RIG_COUNTS_PER_TURN (1u << 21)
/** Behind CDS. */
#define SIM_RIG_DATA_BITS 47u
#define SIM_RIG_LEVELS_MAX 1024u

/** What the tap told. */
struct sim_heard {
    struct lx_tap_listener listener;
    unsigned edges; /**< of MA */
    unsigned notes;
    dg_ns last;
    bool disordered; /**< something came with an earlier time than what was before it */
    bool ma;
    char note[256]; /**< the latest */
    size_t count;   /**< of levels kept; set it to 0 to begin anew */
    struct {
        dg_ns at;
        bool ma;
        bool slo;
    } level[SIM_RIG_LEVELS_MAX];
};

/** A rig of one wire. */
struct sim_rig {
    struct dg_plan plan;
    struct lx_say say;
    sd_event *event;
    struct lx_clock clock;
    dg_angle shaft[SIM_RIG_ENCODERS_MAX];
    struct lx_engine_setup setup;
    struct lx_engine engine;
    struct lx_station *station; /**< the engine's, as is the bus */
    struct lx_bus *bus;
    struct sim_heard heard;
    uint64_t bits; /**< of the last frame */
    uint8_t count; /**< of them */
    char detail[DG_SCPI_DETAIL_MAX + 1];
};

/** Encoders b0, b1, ... on a wire; their settings may be added then. */
void sim_rig_plan(struct sim_rig *self, size_t count);

/** Loop and self->setup. */
void sim_rig_prepare(struct sim_rig *self);

/** Make what the plan says, and open nothing; it is right. */
void sim_rig_make(struct sim_rig *self);

/** What is not right about the plan. @return in one line */
struct lx_words sim_rig_refused(struct sim_rig *self);

/** Make the wire of the plan, and let it initialise: it is SIM_RIG_READY. */
void sim_rig_open(struct sim_rig *self);

/** The end; nothing was disordered or late. */
void sim_rig_close(struct sim_rig *self);

/** The clock steps to `now`. */
void sim_rig_step_to(struct sim_rig *self, dg_ns now);

/** BISS:FRAMe? of encoder `place`. @return a DG_SCPI code */
int sim_rig_frame(struct sim_rig *self, size_t place);

/** MT:ST of the last frame, and whether its CRC is right. */
uint64_t sim_rig_position(const struct sim_rig *self);
bool sim_rig_crc_ok(const struct sim_rig *self);

/** BISS:READ?. @return a DG_SCPI code */
int sim_rig_read(struct sim_rig *self, size_t place, uint8_t address, uint8_t *bytes, size_t n);
int sim_rig_write(struct sim_rig *self, size_t place, uint8_t address, const uint8_t *bytes,
                  size_t n);

/** Let a fault happen to `count` frames (0: it stays). */
void sim_rig_bend(struct sim_rig *self, size_t place, enum dg_wire_fault fault, uint32_t count);

#endif

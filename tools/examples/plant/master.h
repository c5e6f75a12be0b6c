/* SPDX-License-Identifier: MIT */
/*
 * The master of a plant, for the files that make it: master.c takes its steps and prints what came
 * of them, bus.c does what there is to do on a bus.
 */
#ifndef PLANT_MASTER_H
#define PLANT_MASTER_H

#include <semaphore.h>
#include <stdatomic.h>
#include <time.h>

#include "kit.h"

#define COMPLAINTS 10u
#define COMPLAINT_MAX 160u
#define NODES_MAX 127u

/** A packed message: the moment of its first frame, number of frames, 0. Then of each frame: ns
 * behind that moment, identifier, DLC, 0, and the data, which a remote one does not have. */
#define PACK_HEAD 12u
#define PACK_FRAME 8u
#define PACK_REMOTE 0x8000u

/** F3668 as delivered: TPDO2 has the position. */
#define POSITION_SIZE 4u
#define ANSWER_SIZE (PACK_FRAME + POSITION_SIZE)

/** What is asked for, by the names of the command line. */
struct plant {
    uint32_t processes;
    uint32_t buses; /**< of a process */
    uint32_t nodes; /**< of a bus */
    uint32_t ms;    /**< virtual time, from the first SYNC on */
    uint32_t step_us;
    uint32_t sync_ms;
    uint32_t aggregate;
    uint32_t packed; /**< 0: each frame is a CAN message */
    uint32_t hash;   /**< is wanted */
};

/** Angles are in 2^-32 turns. */
struct shaft {
    int64_t angle; /**< at the moment `since` */
    int64_t mrpm;
    uint64_t since;
    uint64_t random; /**< state of the generator of its speeds */
};

/** A bus with its shaft. */
struct bus {
    struct master *master;
    unsigned number;
    void *wire;  /**< its controller, or the publisher of packed frames */
    void *turns; /**< the publisher that turns its shaft */
    struct shaft shaft;
    bool asked;
    uint64_t asked_at;
    uint8_t position[POSITION_SIZE]; /**< which each node has to answer */
    uint64_t missing[2];             /**< a bit for each node that has not answered yet */
    uint64_t hash;                   /**< of the frames so far */
};

/** All of it. Members behind `step` belong to the library's thread until the simulation is over. */
struct master {
    struct kit kit;
    struct plant plant;
    struct bus *bus; /**< owned list */
    unsigned buses;
    uint64_t period;  /**< of SYNC, in steps */
    uint64_t booted;  /**< the step from which on nodes are started, */
    uint64_t started; /**< get SYNC, */
    uint64_t ends;    /**< and get nothing any more */
    uint64_t whole;   /**< number of steps */
    uint64_t all[2];  /**< the nodes of a bus, as `missing` has them */
    uint8_t usual[PACK_HEAD + NODES_MAX * ANSWER_SIZE]; /**< the message of a bus without faults */
    size_t usual_size;

    uint64_t step;
    uint64_t now;
    uint64_t frames, syncs, checked, wrong;
    struct timespec begin, end;
    bool complete; /**< all steps are done */
    bool over;     /**< the simulation */
    char complaint[COMPLAINTS][COMPLAINT_MAX];
    unsigned complaints;

    atomic_bool joined; /**< these are of both threads */
    atomic_bool leaves;
    atomic_ulong step_told, checked_told, wrong_told;
    sem_t answered;
    int wakes[2]; /**< a pipe: it is over */
};

/** Count something that is wrong, and keep the first ten of them, printf style. */
void master_note_wrong(struct master *self, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/** A call of the library has returned `code`: if it failed, the simulation is over. */
void master_demand(struct master *self, const char *function, int32_t code);

/** What is alike for all buses, before the first one is connected. */
void bus_prepare(struct master *master);

/** Make a bus with its wire and shaft, before the simulation begins. */
void bus_connect(struct master *master, unsigned number);

/** Start its nodes. */
void bus_start(struct bus *self);

/** Ask its nodes for their positions, and turn its shaft from there on with another speed. */
void bus_sync(struct bus *self);

/** Those that have not answered the last SYNC are wrong. */
void bus_count_missing(struct bus *self);

/** FNV-1a of the hashes of all buses, by their numbers. */
uint64_t bus_hash_all(const struct master *master);

#endif

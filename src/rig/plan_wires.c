/* SPDX-License-Identifier: MIT */
/* A row for each kind of wire, and one for each setting of a wire itself. */
#include "rig_private.h"

#include <stddef.h>

#include "drehgeber/bus_edges.h"
#include "drehgeber/bus_frames.h"
#include "drehgeber/bus_words.h"
#include "drehgeber/hal.h"

/* ---------------------------------------------------------------- settings */

#define STEP_MAX_US 1000000

#define OF_TIMING(field) offsetof(struct dg_plan_timing, field)
#define OF_RING(field) offsetof(struct dg_plan_ring, field)
#define OF_SIMULATION(field) offsetof(struct dg_plan_simulation, field)

static const char *const times[] = {
    [DG_PLAN_COORDINATED] = "coordinated",
    [DG_PLAN_AUTONOMOUS] = "autonomous",
    [DG_PLAN_REAL] = "real",
};
_Static_assert(DG_COUNT(times) == DG_PLAN_TIME_COUNT, "a word for each");

static const char *const frames[] = {
    [DG_PLAN_FRAMES_CAN] = "can",
    [DG_PLAN_FRAMES_PACKED] = "packed",
};
_Static_assert(DG_COUNT(frames) == DG_PLAN_FRAMES_COUNT, "a word for each");

/* clang-format off */
static const struct dg_key pace_rows[] = {
    {"pace",          "",   0,                        DG_KEY_FLAG, 0, 1, 0, 1, dg_key_no_yes,
     "1: each frame takes as long as at the real bit rate"},
};
static const struct dg_key timing_rows[] = {
    {"clock_hz",      "Hz", OF_TIMING(clock_hz),      DG_KEY_U32,  0, 1, DG_PLAN_CLOCK_MIN_HZ, DG_PLAN_CLOCK_MAX_HZ,
     NULL,
     "clock of the simulated master"},
    {"line_delay_ns", "ns", OF_TIMING(line_delay_ns), DG_KEY_U32,  0, 1, 0, DG_BUS_CABLE_MAX_NS, NULL,
     "delay of the simulated cable in each direction; 5 ns are a metre"},
    {"compensate",    "",   OF_TIMING(compensate),    DG_KEY_FLAG, 0, 1, 0, 1, dg_key_no_yes,
     "1: the simulated master samples later, by the delay there and back"},
};
static const struct dg_key ring_rows[] = {
    {"cycle",         "us", OF_RING(cycle_us),        DG_KEY_U32,  0, 1, 250, 50000, NULL,
     "time from one data cycle of the ring to the next"},
    {"tear",          "",   OF_RING(tear),            DG_KEY_FLAG, 0, 1, 0, 1, dg_key_no_yes,
     "1: the ring takes only half of an OUT word from a request (fault)"},
    {"break_at",      "",   OF_RING(break_at),        DG_KEY_U16,  0, 1, 0, DG_RING_MAX - 1, NULL,
     "the bus is cut in front of this device; 0 is the first one (fault)"},
};
static const struct dg_key simulation_rows[] = {
    {"time",          "",   OF_SIMULATION(time),      DG_KEY_WORD, 0, 1, 0, DG_PLAN_TIME_COUNT - 1, times,
     "time of the SIL Kit simulation: virtual, started and stopped with all participants; virtual, "
     "started at once; or real, without steps"},
    {"step_us",       "us", OF_SIMULATION(step_us),   DG_KEY_U32,  0, 1, 1, STEP_MAX_US, NULL,
     "length of a step of SIL Kit's virtual time"},
    {"aggregate",     "",   OF_SIMULATION(aggregate), DG_KEY_FLAG, 0, 1, 0, 1, dg_key_no_yes,
     "in virtual time, 1: what the rig sends in a step goes out together, at its end"},
    {"frames",        "",   OF_SIMULATION(frames),    DG_KEY_WORD, 0, 1, 0, DG_PLAN_FRAMES_COUNT - 1, frames,
     "of a CAN bus: each by itself on its CAN network, or those of a step in one message of a topic"},
};
/* clang-format on */

static const struct dg_keys pace_keys = {.rows = pace_rows, .count = DG_COUNT(pace_rows)};
static const struct dg_keys timing_keys = {.rows = timing_rows, .count = DG_COUNT(timing_rows)};
static const struct dg_keys ring_keys = {.rows = ring_rows, .count = DG_COUNT(ring_rows)};
static const struct dg_keys simulation_keys = {
    .rows = simulation_rows,
    .count = DG_COUNT(simulation_rows),
};

const bool dg_plan_pace_usual = false;
const struct dg_plan_timing dg_plan_timing_usual = {
    .clock_hz = DG_PLAN_CLOCK_HZ,
    .compensate = true,
};
const struct dg_plan_ring dg_plan_ring_usual = {
    .cycle_us = 1000,
    .break_at = DG_RING_WHOLE,
};
const struct dg_plan_simulation dg_plan_simulation_usual = {
    .time = DG_PLAN_COORDINATED,
    .step_us = 1000,
    .aggregate = true,
};

/* ---------------------------------------------------------------- kinds */

#define LINE_STATIONS_MAX 32u

const struct dg_plan_wire_kind dg_plan_wires[] = {
    {
        .name = "pty",
        .stations_max = LINE_STATIONS_MAX,
        .media = DG_PLAN_CARRIES(CHARACTERS),
        .where = "LINK",
        .where_is_path = true,
        .mixed = true,
    },
    {
        .name = "tty",
        .stations_max = LINE_STATIONS_MAX,
        .media = DG_PLAN_CARRIES(CHARACTERS),
        .where = "DEV",
        .where_needed = true,
        .where_is_path = true,
    },
    {
        .name = "rs485",
        .stations_max = LINE_STATIONS_MAX,
        .media = DG_PLAN_CARRIES(CHARACTERS),
        .where = "KIND:HOST:PORT",
        .usual = "rfc2217:127.0.0.1:2217",
        .mixed = true,
    },
    {
        .name = "sim",
        .stations_max = DG_BUS_CHAIN_MAX,
        .media = DG_PLAN_CARRIES(EDGES),
        .keys = &timing_keys,
        .settings = &dg_plan_timing_usual,
    },
    {
        .name = "gpio",
        .stations_max = 1,
        .media = DG_PLAN_CARRIES(EDGES),
        .where = "CHIP:CLOCK,DATA",
        .where_needed = true,
    },
    {
        .name = "can",
        .stations_max = DG_BUS_FRAMES_ENCODERS,
        .media = DG_PLAN_CARRIES(FRAMES),
        .where = "IFNAME",
        .keys = &pace_keys,
        .settings = &dg_plan_pace_usual,
        .where_needed = true,
    },
    {
        .name = "slcan",
        .stations_max = DG_BUS_FRAMES_ENCODERS,
        .media = DG_PLAN_CARRIES(FRAMES),
        .where = "LINK|tcp:HOST:PORT",
        .keys = &pace_keys,
        .settings = &dg_plan_pace_usual,
        .where_is_path = true,
        .where_may_be_tcp = true,
    },
    {
        .name = "socketcand",
        .stations_max = DG_BUS_FRAMES_ENCODERS,
        .media = DG_PLAN_CARRIES(FRAMES),
        .where = "HOST:PORT[,BUS]",
        .usual = "127.0.0.1:29536",
        .keys = &pace_keys,
        .settings = &dg_plan_pace_usual,
    },
    {
        .name = "silkit",
        .stations_max = DG_RING_MAX,
        .media = DG_PLAN_CARRIES_ALL,
        .where = "silkit://HOST:PORT,NETWORK",
        .keys = &simulation_keys,
        .settings = &dg_plan_simulation_usual,
        .where_needed = true,
    },
    {
        .name = "modbus",
        .stations_max = DG_RING_MAX,
        .media = DG_PLAN_CARRIES(WORDS),
        .where = "HOST:PORT",
        .usual = "127.0.0.1:5020",
        .keys = &ring_keys,
        .settings = &dg_plan_ring_usual,
    },
};
const size_t dg_plan_wire_count = DG_COUNT(dg_plan_wires);

const struct dg_plan_wire_kind *dg_plan_find_kind(const char *name, size_t n)
{
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        const char *known = dg_plan_wires[i].name;
        if (dg_plan_length(known) == n && dg_text_same(known, name, n, NULL)) {
            return &dg_plan_wires[i];
        }
    }
    return NULL;
}

bool dg_plan_wire_has(const struct dg_plan_wire_kind *kind, const char *key)
{
    return kind->keys != NULL && dg_keys_find(kind->keys, key) != NULL;
}

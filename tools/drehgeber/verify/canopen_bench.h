/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The bench of the F36x8, and the steps that have a file of their own.
 */
#ifndef DREHGEBER_VERIFY_CANOPEN_BENCH_H
#define DREHGEBER_VERIFY_CANOPEN_BENCH_H

#include "canopen_steps.h"
#include "drehgeber/devices.h"
#include "drehgeber/store.h"
#include "row_memory.h"

/** Most frames a row lets the node send. */
#define CANOPEN_QUEUE_MAX 600u

/** What the steps work with. */
struct canopen_bench {
    dg_ns now, deadline;
    int64_t from; /**< the shaft: angle at `since`, and its speed */
    dg_ns since;
    int64_t rpm, ramp; /**< the latter in rpm/s */
    const struct dg_device *device;
    struct dg_cia406_model model;
    struct dg_world world;
    struct cf_memory nvm;
    struct dg_cia406 encoder;
    struct dg_co_node node;
    bool ready;      /**< `given` has been */
    bool stuck;      /**< the node returned a deadline that does not lie ahead */
    uint8_t node_id; /**< whom `read` and `write` talk to */
    uint16_t kbaud;  /**< last bit rate the node reported */
    dg_ns late;      /**< the next frame is delivered so long after it came in */
    uint8_t filter_version, filter_count;
    uint16_t filters[DG_CO_FILTERS_MAX];
    struct dg_can_frame sent[CANOPEN_QUEUE_MAX];
    dg_ns sent_at[CANOPEN_QUEUE_MAX];
    size_t sent_count, seen; /**< the latter: expected so far */
    dg_ns earliest, latest;  /**< of the frame that is expected next; 0: the row does not say */
};

/** A deadline counts from the end of the call that returned it, as a port's timer does. */
void canopen_note_deadline(struct canopen_bench *b, dg_ns deadline);
/** Let the node do what is due until `until`, or until it has sent something. */
void canopen_run_until(struct canopen_bench *b, dg_ns until, bool stop_at_frame);
/** "5ms", "300us", "1s"; 0 when it is none of them. `*end` is what follows. */
dg_ns canopen_span(const char *word, const char **end);

/** Send a request, and expect the next frame of the node to be in this relation to it. @return false
 * after cf_fail() */
bool canopen_ask(struct canopen_bench *b, const struct dg_can_frame *request,
                 const struct cf_relation *relation, struct cf_report *report);
/** Take "1018:1" apart into an SDO request. @return false after cf_fail() */
bool canopen_parse_object(const char *word, struct dg_can_frame *to, struct cf_report *report);

/** upload INDEX:SUB there|write-only | size N | is BYTES | delivered BYTES | within LOW HIGH [signed] */
bool canopen_step_upload(void *ctx, char **words, size_t n, struct cf_report *report);
/** world QUANTITY N: a cause, in the unit of dg_world; bits are 0 and 1 */
bool canopen_step_world(void *ctx, char **words, size_t n, struct cf_report *report);
/** bus off|active|passive|overrun|absent|present: what the CAN controller reports */
bool canopen_step_bus(void *ctx, char **words, size_t n, struct cf_report *report);
/** led bus|err on|off|T: lit, dark, or T lit and T dark */
bool canopen_step_led(void *ctx, char **words, size_t n, struct cf_report *report);
/** leds together|apart: both in the same phase, or in opposite phase, for half a second */
bool canopen_step_leds(void *ctx, char **words, size_t n, struct cf_report *report);

/** damage REGION OFFSET [MASK]: bytes that change by themselves */
bool canopen_damage(struct cf_memory *nvm, const struct dg_store_layout *layout, char **words,
                    size_t n, struct cf_report *report);
/** stored REGION OFFSET BYTES: what an earlier release has left there, with its sum */
bool canopen_stored(struct cf_memory *nvm, const struct dg_store_layout *layout, char **words,
                    size_t n, struct cf_report *report);
/** eds SECTION KEY VALUE|none: a line of the model's EDS file */
bool canopen_eds(const struct dg_device *device, char **words, size_t n, struct cf_report *report);

#endif

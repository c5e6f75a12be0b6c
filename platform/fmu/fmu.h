/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Encoders as a co-simulator sees them: variables with numbers, steps, clocks. It knows nothing of
 * a version of FMI; fmi3.c and fmi2.c do, and describe.c writes what they are told of it.
 *
 * What encoders there are stands in a text, the token of the FMU. One encoder by itself:
 *   drehgeber VERSION =MODEL[,KEY=VALUE]...
 * MODEL is the name of one that is built in; or of a text, with what it is:
 *   NAME:BASE[;-HEIRLOOM]...[;FIGURE=VALUE]...
 * or a file that the FMU has, called by the CRC of its bytes: 89ABCDEF.eds. What is no letter,
 * digit, '.', '_' or '-' in NAME and VALUE is %XX. A rig is such a file:
 *   drehgeber VERSION 89ABCDEF.rig
 * with all that a rig file and those that it names say, one part behind the other, each with its
 * head as a line and so many bytes:
 *   file BYTES NAME      a text that dg_plan_read() reads: first the rig file, then what it includes,
 *                        by the path that leads there from its folder
 *   model BYTES NAME     a model that is neither built in nor of these texts: MODEL, as above
 *   motion BYTES LINE    the points of the motion in this line of the plan: AT ANGLE, a line each
 *   course BYTES LINE    likewise of a course: AT VALUE
 */
#ifndef DREHGEBER_FMU_H
#define DREHGEBER_FMU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/host.h"

/** Longest names, with their zero. */
#define FMU_NAME_MAX 96u
/** Bytes that wait for the importer at most, for each encoder on a wire, as LS-BUS says its maxSize.
 */
#define FMU_WIRE_MAX 2048u
/** Seconds that a simulation may last, and begin before or behind 0: 285 years. */
#define FMU_TIME_MAX 9e9
/** More entries no catalogue of faults has. */
#define FMU_FAULTS_MAX 96u

/** What a variable is; the number of one is encoder << 16 | group << 8 | index; of FMU_ANGLE and
 * FMU_SPEED it is the shaft's << 16. */
enum fmu_group {
    FMU_TIME,      /**< the independent one, of encoder 0 */
    FMU_INPUT,     /**< enum fmu_input */
    FMU_PARAMETER, /**< index of the key */
    FMU_WORLD,     /**< likewise */
    FMU_FAULT,     /**< index in the catalogue */
    FMU_OUTPUT,    /**< enum fmu_output */
    FMU_BUS,       /**< enum fmu_bus */
};

/** What is done to the encoder. */
enum fmu_input { FMU_ANGLE, FMU_SPEED, FMU_POWER };

/** What it shows. Those of a frame are of the one that was latched last. */
enum fmu_output {
    FMU_POSITION,
    FMU_SIN_PLUS,
    FMU_SIN_MINUS,
    FMU_COS_PLUS,
    FMU_COS_MINUS,
    FMU_FRAME,
    FMU_FRAME_BITS,
    FMU_FRAME_POSITION,
    FMU_FRAME_GOOD,
    FMU_NERR,
    FMU_NWARN,
    FMU_ERROR_CODE,
    FMU_ERROR_REGISTER,
    FMU_BUS_STATE,
    FMU_OUTPUT_COUNT
};

/** Its wire: bytes with a clock each way, or the clock of a master. */
enum fmu_bus { FMU_RX, FMU_TX, FMU_RX_CLOCK, FMU_TX_CLOCK, FMU_MA };

/** Kinds of values. */
enum fmu_type { FMU_REAL, FMU_INT, FMU_BOOL, FMU_TEXT, FMU_BINARY, FMU_CLOCK, FMU_TYPE_COUNT };

/** A variable as it is described. */
struct fmu_variable {
    uint32_t reference;
    enum fmu_type type;
    bool input;     /**< or parameter; else an output */
    bool parameter; /**< fixed before the simulation begins */
    bool continuous;
    uint8_t wire; /**< BINARY: 'c' CAN, 's' serial */
    size_t room;  /**< BINARY: most bytes of it */
    char name[FMU_NAME_MAX];
    char start[FMU_NAME_MAX]; /**< of inputs and parameters */
    const char *unit;         /**< of FMI's table in describe.c, "" without */
    char help[256];
    int64_t min, max; /**< of an INT; both 0: any */
};

/** A value. Only the member of its type counts. */
struct fmu_value {
    enum fmu_type type;
    double real;
    int64_t integer; /**< also of a BOOL */
    char text[FMU_NAME_MAX];
};

struct dg_plan_error;

/** Encoders that go on together. */
struct fmu;

/** Files of the FMU. */
struct fmu_files {
    /** The bytes of one, to be freed; NULL: there is none. */
    char *(*read)(void *ctx, const char *name, size_t *n);
    void *ctx;
    struct dg_plan_error *error; /**< why a rig is none, without its file; NULL: nobody asks */
};

/** Make them of a token; NULL: it is of another version, of no known model or
 * medium, or no memory. */
struct fmu *fmu_make(const char *token);
/** The same, of which a model may be a file; `files` is asked for it before this returns. */
struct fmu *fmu_make_with(const char *token, const struct fmu_files *files);
void fmu_free(struct fmu *self);
/** Whether an FMU can have this encoder, which was never on: its medium has to be known here, and a
 * CAN node has to tell its bit rate. */
bool fmu_can_have(struct dg_host *host);
/** As fmu_make() left them. @return 0, or -1 without memory */
int fmu_reset(struct fmu *self);

/** How many there are. */
size_t fmu_count(const struct fmu *self);
/** Of one: the handle, and what its variables' names begin with: "" or "NAME.". */
struct dg_host *fmu_host(const struct fmu *self, size_t encoder);
const char *fmu_prefix(const struct fmu *self, size_t encoder);
/** What the names of its wire begin with; NULL: another encoder is the first one on it. */
const char *fmu_wire_prefix(const struct fmu *self, size_t encoder);

/** Variable `index` of all; what is shown of faults switches its encoders on: describe an instance
 * of its own. @return whether there is one */
bool fmu_variable(struct fmu *self, size_t index, struct fmu_variable *to);

/** Frames of clocked wires are latched by MA; else at the end of a step, if somebody reads them. */
void fmu_use_events(struct fmu *self, bool events);

/** Settings are complete: power, if it is on, from `start` seconds on, of at most FMU_TIME_MAX.
 * @return 0, or a result of host.h */
int fmu_start(struct fmu *self, double start);
bool fmu_started(const struct fmu *self);

/** A value of another kind than the variable's is refused; an INT and a REAL are both numbers.
 * @return 0, or a result of host.h */
int fmu_get(struct fmu *self, uint32_t reference, struct fmu_value *to);
int fmu_set(struct fmu *self, uint32_t reference, const struct fmu_value *value);

/** The latest moment that a step has reached, in s; fmu_start()'s before the first one. */
double fmu_time(const struct fmu *self);
/** Whether there is a step from `now` on for `span` seconds: none before fmu_start(), none from
 * elsewhere than fmu_time() (1 us or, where that is more, 4 times the distance of two doubles
 * there are allowed for what importers add up), none beyond FMU_TIME_MAX. */
bool fmu_may_step(const struct fmu *self, double now, double span);
/** Such a step, or, if `early`, until something waits for the importer. @return the time it is now,
 * `now` or later */
double fmu_step(struct fmu *self, double now, double span, bool early);

/** Whether any clock of an output ticks. */
bool fmu_ticks(const struct fmu *self);
/** Set and get a clock. @return 0 or DG_HOST_ERR_NAME */
int fmu_clock_set(struct fmu *self, uint32_t reference, bool on);
int fmu_clock_get(struct fmu *self, uint32_t reference, bool *on);
/** What a wire tells while its clock ticks; lasts until the next call. */
int fmu_binary_get(struct fmu *self, uint32_t reference, const uint8_t **bytes, size_t *n);
int fmu_binary_set(struct fmu *self, uint32_t reference, const uint8_t *bytes, size_t n);
/** This moment's clocks are over. */
void fmu_clocks_end(struct fmu *self);

/** Bytes of a state; save; go on from one, of the same token and build. */
size_t fmu_state_size(struct fmu *self);
int fmu_save(struct fmu *self, void *to, size_t n);
int fmu_restore(struct fmu *self, const void *from, size_t n);

#endif

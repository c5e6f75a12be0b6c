/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The same for languages without pointers, see hdl_names.c: instances have names, which are unique
 * in a process, and numbers. A moment is `us` microseconds and `ps` picoseconds, 0..999999.
 */
#ifndef DREHGEBER_HDL_NAMES_H
#define DREHGEBER_HDL_NAMES_H

#include <stdint.h>

#include "hdl.h"

/** What dg_hdl_steer() does: as the function of hdl.h of that name. */
enum dg_hdl_steering {
    DG_HDL_TURN,
    DG_HDL_SPEED,
    DG_HDL_MOTION,
    DG_HDL_WORLD,
    DG_HDL_FAULT,
    DG_HDL_POWER,
    DG_HDL_COMMAND
};

/** What dg_hdl_real() tells. */
enum dg_hdl_look {
    DG_HDL_POSITION,
    DG_HDL_LATCHED,
    DG_HDL_LATCHED_AT_US,
    DG_HDL_SINE,  /**< sin+ - sin- in volts */
    DG_HDL_COSINE /**< cos+ - cos- */
};

/** What dg_hdl_character() reads. */
enum dg_hdl_text {
    DG_HDL_ANSWER, /**< to the latest command */
    DG_HDL_ERROR,  /**< dg_hdl_error() */
    DG_HDL_NOTE    /**< dg_hdl_hint() behind the name of the instance */
};

/** dg_hdl_open(). What instances have to tell at the end of the simulation is printed when the
 * process ends. @return its number, with an error to be looked at; -1: no memory; -2: there is one
 * of that name */
DG_HDL_API int32_t dg_hdl_make(const char *name, const char *model, const char *settings,
                               const char *motion, const char *memory);
/** Close all of them. */
DG_HDL_API void dg_hdl_make_none(void);
/** @return the number of an instance; -1: there is none of that name */
DG_HDL_API int32_t dg_hdl_find(const char *name);
/** dg_hdl_wires() */
DG_HDL_API int32_t dg_hdl_look(int32_t id, int32_t us, int32_t ps, int32_t inputs);
/** ps from this moment to dg_hdl_next(), at most `most` */
DG_HDL_API int32_t dg_hdl_rest(int32_t id, int32_t us, int32_t ps, int32_t most);
/** Steer; what `what` has no use for is not looked at. @return 0, or less with an error */
DG_HDL_API int32_t dg_hdl_steer(int32_t id, int32_t us, int32_t ps, int32_t what, const char *name,
                                double value);
/** Character `index` of a text, enum dg_hdl_text; 0 behind it */
DG_HDL_API int32_t dg_hdl_character(int32_t id, int32_t which, int32_t index);
/** Look at it. Positions are whole numbers, below 2^53. */
DG_HDL_API double dg_hdl_real(int32_t id, int32_t us, int32_t ps, int32_t what);

#endif

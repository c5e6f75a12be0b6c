/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What the functions of all versions of FMI have in common: an instance, values of the types that
 * both versions know, states. Results are fmi2Status and fmi3Status, which have the same numbers;
 * what goes wrong is told to the importer first. Nothing here may be NULL unless it is said, but
 * for the instance: without one a function is an error, and nobody is told.
 */
#ifndef DREHGEBER_FMI_H
#define DREHGEBER_FMI_H

#include "fmu.h"

/** What makes a name one that a shared object exports. */
#if defined(_WIN32)
#define FMI_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI_EXPORT __attribute__((visibility("default")))
#else
#define FMI_EXPORT
#endif
/** The head of a function that an importer finds by its name only. */
#define FMI_FUNCTION(type, name, arguments)                                                        \
    FMI_EXPORT type name arguments;                                                                \
    type name arguments
/** One that has nothing to do here. */
#define FMI_NOTHING(name, arguments)                                                               \
    FMI_FUNCTION(int, name, arguments)                                                             \
    {                                                                                              \
        return of != NULL ? FMI_OK : FMI_ERROR;                                                    \
    }
/** One of what an encoder has not; the first argument is `of`. */
#define FMI_NOT_HERE(name, arguments)                                                              \
    FMI_FUNCTION(int, name, arguments)                                                             \
    {                                                                                              \
        return fmi_failed(of, #name, DG_HOST_ERR_NAME);                                            \
    }

/** The functions for states, by their names. */
#define FMI_STATES(get, set, release, size, pack, unpack)                                          \
    FMI_FUNCTION(int, get, (void *of, void **to))                                                  \
    {                                                                                              \
        return fmi_state_get(of, to);                                                              \
    }                                                                                              \
    FMI_FUNCTION(int, set, (void *of, void *from))                                                 \
    {                                                                                              \
        return fmi_state_set(of, from);                                                            \
    }                                                                                              \
    FMI_FUNCTION(int, release, (void *of, void **state))                                           \
    {                                                                                              \
        return fmi_state_free(state);                                                              \
    }                                                                                              \
    FMI_FUNCTION(int, size, (void *of, void *state, size_t *n))                                    \
    {                                                                                              \
        return fmi_state_size(of, state, n);                                                       \
    }                                                                                              \
    FMI_FUNCTION(int, pack, (void *of, void *from, uint8_t bytes[], size_t n))                     \
    {                                                                                              \
        return fmi_state_pack(of, from, bytes, n);                                                 \
    }                                                                                              \
    FMI_FUNCTION(int, unpack, (void *of, const uint8_t bytes[], size_t n, void **to))              \
    {                                                                                              \
        return fmi_state_unpack(bytes, n, to);                                                     \
    }

/** What functions return. */
enum fmi_status { FMI_OK, FMI_WARNING, FMI_DISCARD, FMI_ERROR, FMI_FATAL };

/** The first member of what a version calls an instance, so that a pointer to one is one to it. */
struct fmi {
    struct fmu *fmu;
    /** Tell the importer, for the category logStatusError; set before fmi_begin(). */
    void (*tell)(const struct fmi *self, const char *text);
    double start; /**< of the simulation, in s */
    bool initializing, terminated;
    char (*texts)[FMU_NAME_MAX]; /**< owned: those that were got last */
};

/** `self` is of calloc(), and is released if the token is of no use. @param resources where the FMU
 * has its files, as a path or a URI; NULL: not said. @return `self`, or NULL */
void *fmi_begin(struct fmi *self, const char *token, const char *resources);
/** Release it; NULL is nothing. */
void fmi_end(struct fmi *self);
/** Initialization begins, or is over: power. Refused where there is none to begin or to end. */
int fmi_initialize(struct fmi *self);
int fmi_initialized(struct fmi *self);
int fmi_terminate(struct fmi *self);
/** Whether a step may be done from `now` on for `span` seconds. @return FMI_OK or FMI_ERROR */
int fmi_may_step(struct fmi *self, double now, double span);
/** As it was instantiated. */
int fmi_reset(struct fmi *self);

/** What was the matter, `result` of host.h. @return FMI_ERROR */
int fmi_failed(const struct fmi *self, const char *what, int result);
/** An argument was not right. @return FMI_ERROR */
int fmi_refused(const struct fmi *self, const char *what);

/** A value; while initializing the first that is got switches the encoders on. */
int fmi_get(struct fmi *self, uint32_t reference, struct fmu_value *to);
int fmi_set_integer(struct fmi *self, uint32_t reference, enum fmu_type type, int64_t value);

/** `n` variables at once, `room` values: refused if that is less. */
int fmi_get_reals(struct fmi *self, const uint32_t references[], size_t n, double values[],
                  size_t room);
int fmi_set_reals(struct fmi *self, const uint32_t references[], size_t n, const double values[],
                  size_t room);
/** get_NAME() and set_NAME() of a version for another C type, likewise; `read` is what an importer
 * gets of the struct fmu_value `value`. */
#define FMI_VALUES(name, c_type, fmu_type, read)                                                   \
    static int get_##name(struct fmi *self, const uint32_t references[], size_t n,                 \
                          c_type values[], size_t room)                                            \
    {                                                                                              \
        struct fmu_value value;                                                                    \
        if (room < n) {                                                                            \
            return fmi_refused(self, "room for values");                                           \
        }                                                                                          \
        for (size_t i = 0; i < n; i++) {                                                           \
            if (fmi_get(self, references[i], &value) != FMI_OK) {                                  \
                return FMI_ERROR;                                                                  \
            }                                                                                      \
            values[i] = (read);                                                                    \
        }                                                                                          \
        return FMI_OK;                                                                             \
    }                                                                                              \
    static int set_##name(struct fmi *self, const uint32_t references[], size_t n,                 \
                          const c_type values[], size_t room)                                      \
    {                                                                                              \
        if (room < n) {                                                                            \
            return fmi_refused(self, "fewer values than variables");                               \
        }                                                                                          \
        for (size_t i = 0; i < n; i++) {                                                           \
            if (fmi_set_integer(self, references[i], fmu_type, values[i]) != FMI_OK) {             \
                return FMI_ERROR;                                                                  \
            }                                                                                      \
        }                                                                                          \
        return FMI_OK;                                                                             \
    }
/** The texts last until the next call. */
int fmi_get_texts(struct fmi *self, const uint32_t references[], size_t n, const char *values[],
                  size_t room);
int fmi_set_texts(struct fmi *self, const uint32_t references[], size_t n,
                  const char *const values[], size_t room);

/** States: one of `to` is used again, NULL there makes one; bytes are the same in every process.
 * A state is refused if it is NULL, but for fmi_state_free(). */
int fmi_state_get(struct fmi *self, void **to);
int fmi_state_set(struct fmi *self, const void *from);
int fmi_state_free(void **state);
int fmi_state_size(struct fmi *self, const void *state, size_t *n);
int fmi_state_pack(struct fmi *self, const void *state, uint8_t bytes[], size_t n);
int fmi_state_unpack(const uint8_t bytes[], size_t n, void **to);

#endif

/* SPDX-License-Identifier: MIT */
/*
 * The functions of FMI 3.0, co-simulation. Names, types and values are those of the standard; each
 * is declared where it is defined, as an importer finds it by its name only.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmu.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif
#define FMI3(type, name, arguments)                                                                \
    EXPORT type name arguments;                                                                    \
    type name arguments

/* fmi3Status */
enum status { OK, WARNING, DISCARD, ERROR, FATAL };

typedef void log_message(void *environment, int status, const char *category, const char *message);

struct instance {
    struct fmu *fmu;
    log_message *log;
    void *environment;
    bool events, early, initializing;
    double start;
    char (*texts)[FMU_NAME_MAX]; /* owned: those that were got last */
};

struct state {
    size_t n;
    uint8_t bytes[];
};

static int failed(struct instance *self, const char *what, int result)
{
    char text[128];
    (void)snprintf(text, sizeof text, "%s: %s", what, dg_host_result_text(result));
    if (self->log != NULL) {
        self->log(self->environment, ERROR, "logStatusError", text);
    }
    return ERROR;
}

static int refused(void *of, const char *what)
{
    return failed(of, what, DG_HOST_ERR_ARGUMENT);
}

/* The standard lays down what a function is given, used or not. */
/* NOLINTBEGIN(misc-unused-parameters) */

/* --- life --- */

FMI3(const char *, fmi3GetVersion, (void))
{
    return "3.0";
}

FMI3(int, fmi3SetDebugLogging, (void *of, bool on, size_t n, const char *const categories[]))
{
    return OK;
}

FMI3(void *, fmi3InstantiateCoSimulation,
     (const char *name, const char *token, const char *resources, bool visible, bool logging,
      bool events, bool early, const uint32_t intermediate[], size_t n, void *environment,
      log_message *log, void (*update)(void)))
{
    struct instance *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->log = log;
    self->environment = environment;
    self->events = events;
    self->early = early && events;
    self->fmu = fmu_make(token);
    if (self->fmu == NULL) {
        (void)failed(self, "the token of the model description is another build's",
                     DG_HOST_ERR_OTHER);
        free(self);
        return NULL;
    }
    fmu_use_events(self->fmu, events);
    return self;
}

FMI3(void *, fmi3InstantiateModelExchange,
     (const char *name, const char *token, const char *resources, bool visible, bool logging,
      void *environment, log_message *log))
{
    return NULL;
}

FMI3(void *, fmi3InstantiateScheduledExecution,
     (const char *name, const char *token, const char *resources, bool visible, bool logging,
      void *environment, log_message *log, void (*update)(void), void (*lock)(void),
      void (*unlock)(void)))
{
    return NULL;
}

FMI3(void, fmi3FreeInstance, (void *of))
{
    struct instance *self = of;
    if (self != NULL) {
        fmu_free(self->fmu);
        free(self->texts);
        free(self);
    }
}

FMI3(int, fmi3EnterInitializationMode,
     (void *of, bool has_tolerance, double tolerance, double start, bool has_stop, double stop))
{
    struct instance *self = of;
    self->initializing = true;
    self->start = start;
    return OK;
}

static int begin(struct instance *self)
{
    const int result = fmu_start(self->fmu, self->start);
    return result == DG_HOST_OK ? OK : failed(self, "power-on", result);
}

FMI3(int, fmi3ExitInitializationMode, (void *of))
{
    struct instance *self = of;
    self->initializing = false;
    return begin(self);
}

FMI3(int, fmi3EnterEventMode, (void *of))
{
    return OK;
}

FMI3(int, fmi3EnterStepMode, (void *of))
{
    return OK;
}

FMI3(int, fmi3EnterConfigurationMode, (void *of))
{
    return OK;
}

FMI3(int, fmi3ExitConfigurationMode, (void *of))
{
    return OK;
}

FMI3(int, fmi3Terminate, (void *of))
{
    return OK;
}

FMI3(int, fmi3Reset, (void *of))
{
    struct instance *self = of;
    self->initializing = false;
    return fmu_reset(self->fmu) == 0 ? OK : ERROR;
}

/* --- time --- */

FMI3(int, fmi3DoStep,
     (void *of, double now, double span, bool no_state, bool *event, bool *end, bool *early,
      double *last))
{
    struct instance *self = of;
    if (!(span >= 0)) {
        return refused(self, "communicationStepSize");
    }
    *last = fmu_step(self->fmu, now, span, self->early);
    *early = *last < now + span;
    *event = self->events && fmu_ticks(self->fmu);
    *end = false;
    return OK;
}

FMI3(int, fmi3EvaluateDiscreteStates, (void *of))
{
    return OK;
}

FMI3(int, fmi3UpdateDiscreteStates,
     (void *of, bool *more, bool *end, bool *nominals, bool *values, bool *has_next, double *next))
{
    struct instance *self = of;
    fmu_clocks_end(self->fmu);
    *more = *end = *nominals = *values = *has_next = false;
    *next = 0;
    return OK;
}

/* --- values --- */

static int get(struct instance *self, uint32_t reference, enum fmu_type type, struct fmu_value *to)
{
    int result = self->initializing ? begin(self) : OK;
    if (result != OK) {
        return result;
    }
    result = fmu_get(self->fmu, reference, to);
    to->type = type;
    return result == DG_HOST_OK ? OK : failed(self, "get", result);
}

static int set(struct instance *self, uint32_t reference, struct fmu_value *value)
{
    const int result = fmu_set(self->fmu, reference, value);
    return result == DG_HOST_OK ? OK : failed(self, "set", result);
}

FMI3(int, fmi3GetFloat64,
     (void *of, const uint32_t references[], size_t n, double values[], size_t n_values))
{
    struct fmu_value value;
    for (size_t i = 0; i < n; i++) {
        if (i >= n_values || get(of, references[i], FMU_REAL, &value) != OK) {
            return ERROR;
        }
        values[i] = value.real;
    }
    return OK;
}

FMI3(int, fmi3SetFloat64,
     (void *of, const uint32_t references[], size_t n, const double values[], size_t n_values))
{
    for (size_t i = 0; i < n; i++) {
        struct fmu_value value = {.type = FMU_REAL};
        value.real = i < n_values ? values[i] : 0;
        if (i >= n_values || set(of, references[i], &value) != OK) {
            return ERROR;
        }
    }
    return OK;
}

FMI3(int, fmi3GetInt64,
     (void *of, const uint32_t references[], size_t n, int64_t values[], size_t n_values))
{
    struct fmu_value value;
    for (size_t i = 0; i < n; i++) {
        if (i >= n_values || get(of, references[i], FMU_INT, &value) != OK) {
            return ERROR;
        }
        values[i] = value.integer;
    }
    return OK;
}

FMI3(int, fmi3SetInt64,
     (void *of, const uint32_t references[], size_t n, const int64_t values[], size_t n_values))
{
    for (size_t i = 0; i < n; i++) {
        struct fmu_value value = {.type = FMU_INT};
        value.integer = i < n_values ? values[i] : 0;
        value.real = (double)value.integer;
        if (i >= n_values || set(of, references[i], &value) != OK) {
            return ERROR;
        }
    }
    return OK;
}

FMI3(int, fmi3GetBoolean,
     (void *of, const uint32_t references[], size_t n, bool values[], size_t n_values))
{
    struct fmu_value value;
    for (size_t i = 0; i < n; i++) {
        if (i >= n_values || get(of, references[i], FMU_BOOL, &value) != OK) {
            return ERROR;
        }
        values[i] = value.integer != 0;
    }
    return OK;
}

FMI3(int, fmi3SetBoolean,
     (void *of, const uint32_t references[], size_t n, const bool values[], size_t n_values))
{
    for (size_t i = 0; i < n; i++) {
        struct fmu_value value = {.type = FMU_BOOL};
        value.integer = i < n_values && values[i] ? 1 : 0;
        value.real = (double)value.integer;
        if (i >= n_values || set(of, references[i], &value) != OK) {
            return ERROR;
        }
    }
    return OK;
}

/* They last until the next call. */
FMI3(int, fmi3GetString,
     (void *of, const uint32_t references[], size_t n, const char *values[], size_t n_values))
{
    struct instance *self = of;
    struct fmu_value value;
    char(*texts)[FMU_NAME_MAX] = n == 0 ? NULL : calloc(n, sizeof *texts);
    free(self->texts);
    self->texts = texts;
    if (n_values < n || (n > 0 && texts == NULL)) {
        return refused(of, "Strings");
    }
    for (size_t i = 0; i < n; i++) {
        if (get(self, references[i], FMU_TEXT, &value) != OK) {
            return ERROR;
        }
        memcpy(texts[i], value.text, sizeof texts[i]);
        values[i] = texts[i];
    }
    return OK;
}

FMI3(int, fmi3SetString,
     (void *of, const uint32_t references[], size_t n, const char *const values[], size_t n_values))
{
    for (size_t i = 0; i < n; i++) {
        struct fmu_value value = {.type = FMU_TEXT};
        if (i >= n_values || strlen(values[i]) >= sizeof value.text) {
            return refused(of, "a String");
        }
        memcpy(value.text, values[i], strlen(values[i]) + 1);
        if (set(of, references[i], &value) != OK) {
            return ERROR;
        }
    }
    return OK;
}

FMI3(int, fmi3GetBinary,
     (void *of, const uint32_t references[], size_t n, size_t sizes[], const uint8_t *values[],
      size_t n_values))
{
    struct instance *self = of;
    for (size_t i = 0; i < n; i++) {
        if (i >= n_values ||
            fmu_binary_get(self->fmu, references[i], &values[i], &sizes[i]) != DG_HOST_OK) {
            return refused(self, "a Binary");
        }
    }
    return OK;
}

FMI3(int, fmi3SetBinary,
     (void *of, const uint32_t references[], size_t n, const size_t sizes[],
      const uint8_t *const values[], size_t n_values))
{
    struct instance *self = of;
    for (size_t i = 0; i < n; i++) {
        const int result = i >= n_values
                               ? DG_HOST_ERR_ARGUMENT
                               : fmu_binary_set(self->fmu, references[i], values[i], sizes[i]);
        if (result != DG_HOST_OK) {
            return failed(self, "a Binary", result);
        }
    }
    return OK;
}

FMI3(int, fmi3GetClock, (void *of, const uint32_t references[], size_t n, bool values[]))
{
    struct instance *self = of;
    for (size_t i = 0; i < n; i++) {
        if (fmu_clock_get(self->fmu, references[i], &values[i]) != DG_HOST_OK) {
            return refused(self, "a Clock");
        }
    }
    return OK;
}

FMI3(int, fmi3SetClock, (void *of, const uint32_t references[], size_t n, const bool values[]))
{
    struct instance *self = of;
    for (size_t i = 0; i < n; i++) {
        if (fmu_clock_set(self->fmu, references[i], values[i]) != DG_HOST_OK) {
            return refused(self, "a Clock");
        }
    }
    return OK;
}

/* Types that no variable has. */
#define NO_VALUES(name, type)                                                                      \
    FMI3(int, fmi3Get##name,                                                                       \
         (void *of, const uint32_t references[], size_t n, type values[], size_t n_values))        \
    {                                                                                              \
        return n == 0 ? OK : refused(of, "no " #name " here");                                     \
    }                                                                                              \
    FMI3(int, fmi3Set##name,                                                                       \
         (void *of, const uint32_t references[], size_t n, const type values[], size_t n_values))  \
    {                                                                                              \
        return n == 0 ? OK : refused(of, "no " #name " here");                                     \
    }
NO_VALUES(Float32, float)
NO_VALUES(Int8, int8_t)
NO_VALUES(UInt8, uint8_t)
NO_VALUES(Int16, int16_t)
NO_VALUES(UInt16, uint16_t)
NO_VALUES(Int32, int32_t)
NO_VALUES(UInt32, uint32_t)
NO_VALUES(UInt64, uint64_t)

/* --- states --- */

FMI3(int, fmi3GetFMUState, (void *of, void **to))
{
    struct instance *self = of;
    const size_t n = fmu_state_size(self->fmu);
    struct state *state = *to != NULL ? *to : malloc(sizeof *state + n);
    if (state == NULL) {
        return ERROR;
    }
    state->n = n;
    *to = state;
    const int result = fmu_save(self->fmu, state->bytes, n);
    return result == DG_HOST_OK ? OK : failed(self, "a state", result);
}

FMI3(int, fmi3SetFMUState, (void *of, void *from))
{
    struct instance *self = of;
    const struct state *state = from;
    const int result = fmu_restore(self->fmu, state->bytes, state->n);
    return result == DG_HOST_OK ? OK : failed(self, "a state", result);
}

FMI3(int, fmi3FreeFMUState, (void *of, void **state))
{
    free(*state);
    *state = NULL;
    return OK;
}

FMI3(int, fmi3SerializedFMUStateSize, (void *of, void *state, size_t *n))
{
    *n = ((const struct state *)state)->n;
    return OK;
}

FMI3(int, fmi3SerializeFMUState, (void *of, void *from, uint8_t bytes[], size_t n))
{
    const struct state *state = from;
    if (n < state->n) {
        return refused(of, "too few bytes");
    }
    memcpy(bytes, state->bytes, state->n);
    return OK;
}

FMI3(int, fmi3DeserializeFMUState, (void *of, const uint8_t bytes[], size_t n, void **to))
{
    struct state *state = malloc(sizeof *state + n);
    if (state == NULL) {
        return ERROR;
    }
    free(*to);
    state->n = n;
    memcpy(state->bytes, bytes, n);
    *to = state;
    return OK;
}

/* --- what an encoder has not --- */

#define NOT_HERE(name, arguments)                                                                  \
    FMI3(int, name, arguments)                                                                     \
    {                                                                                              \
        return refused(of, #name);                                                                 \
    }
NOT_HERE(fmi3GetNumberOfVariableDependencies, (void *of, uint32_t reference, size_t *n))
NOT_HERE(fmi3GetVariableDependencies,
         (void *of, uint32_t dependent, size_t elements[], uint32_t independents[],
          size_t of_independents[], int kinds[], size_t n))
NOT_HERE(fmi3GetDirectionalDerivative,
         (void *of, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],
          size_t n_knowns, const double seed[], size_t n_seed, double to[], size_t n))
NOT_HERE(fmi3GetAdjointDerivative,
         (void *of, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],
          size_t n_knowns, const double seed[], size_t n_seed, double to[], size_t n))
NOT_HERE(fmi3GetIntervalDecimal,
         (void *of, const uint32_t references[], size_t n, double intervals[], int qualifiers[]))
NOT_HERE(fmi3GetIntervalFraction, (void *of, const uint32_t references[], size_t n,
                                   uint64_t counters[], uint64_t resolutions[], int qualifiers[]))
NOT_HERE(fmi3GetShiftDecimal, (void *of, const uint32_t references[], size_t n, double shifts[]))
NOT_HERE(fmi3GetShiftFraction, (void *of, const uint32_t references[], size_t n,
                                uint64_t counters[], uint64_t resolutions[]))
NOT_HERE(fmi3SetIntervalDecimal,
         (void *of, const uint32_t references[], size_t n, const double intervals[]))
NOT_HERE(fmi3SetIntervalFraction, (void *of, const uint32_t references[], size_t n,
                                   const uint64_t counters[], const uint64_t resolutions[]))
NOT_HERE(fmi3SetShiftDecimal,
         (void *of, const uint32_t references[], size_t n, const double shifts[]))
NOT_HERE(fmi3SetShiftFraction, (void *of, const uint32_t references[], size_t n,
                                const uint64_t counters[], const uint64_t resolutions[]))
NOT_HERE(fmi3EnterContinuousTimeMode, (void *of))
NOT_HERE(fmi3CompletedIntegratorStep, (void *of, bool no_state, bool *event, bool *end))
NOT_HERE(fmi3SetTime, (void *of, double time))
NOT_HERE(fmi3SetContinuousStates, (void *of, const double states[], size_t n))
NOT_HERE(fmi3GetContinuousStateDerivatives, (void *of, double derivatives[], size_t n))
NOT_HERE(fmi3GetEventIndicators, (void *of, double indicators[], size_t n))
NOT_HERE(fmi3GetContinuousStates, (void *of, double states[], size_t n))
NOT_HERE(fmi3GetNominalsOfContinuousStates, (void *of, double nominals[], size_t n))
NOT_HERE(fmi3GetNumberOfEventIndicators, (void *of, size_t *n))
NOT_HERE(fmi3GetNumberOfContinuousStates, (void *of, size_t *n))
NOT_HERE(fmi3GetOutputDerivatives, (void *of, const uint32_t references[], size_t n,
                                    const int32_t orders[], double values[], size_t n_values))
NOT_HERE(fmi3ActivateModelPartition, (void *of, uint32_t clock, double time))

/* NOLINTEND(misc-unused-parameters) */

/* SPDX-License-Identifier: MIT */
/*
 * The functions of FMI 3.0, co-simulation. Names, types and values are those of the standard; each
 * is declared where it is defined, as an importer finds it by its name only.
 */
#include "fmi.h"

#include <stdlib.h>

typedef void log_message(void *environment, int status, const char *category, const char *message);

struct instance {
    struct fmi fmi;
    log_message *log;
    void *environment;
    bool events, early;
};

static void log_text(const struct fmi *of, const char *text)
{
    const struct instance *self = (const struct instance *)of;
    if (self->log != NULL) {
        self->log(self->environment, FMI_ERROR, "logStatusError", text);
    }
}

/* The standard lays down what a function is given, used or not. */
/* NOLINTBEGIN(misc-unused-parameters) */

/* --- life --- */

FMI_FUNCTION(const char *, fmi3GetVersion, (void))
{
    return "3.0";
}

FMI_NOTHING(fmi3SetDebugLogging, (void *of, bool on, size_t n, const char *const categories[]))

FMI_FUNCTION(void *, fmi3InstantiateCoSimulation,
             (const char *name, const char *token, const char *resources, bool visible,
              bool logging, bool events, bool early, const uint32_t intermediate[], size_t n,
              void *environment, log_message *log, void (*update)(void)))
{
    struct instance *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->log = log;
    self->environment = environment;
    self->events = events;
    self->early = early && events;
    self->fmi.tell = log_text;
    if (fmi_begin(&self->fmi, token, resources) == NULL) {
        return NULL;
    }
    fmu_use_events(self->fmi.fmu, events);
    return self;
}

FMI_FUNCTION(void *, fmi3InstantiateModelExchange,
             (const char *name, const char *token, const char *resources, bool visible,
              bool logging, void *environment, log_message *log))
{
    return NULL;
}

FMI_FUNCTION(void *, fmi3InstantiateScheduledExecution,
             (const char *name, const char *token, const char *resources, bool visible,
              bool logging, void *environment, log_message *log, void (*update)(void),
              void (*lock)(void), void (*unlock)(void)))
{
    return NULL;
}

FMI_FUNCTION(void, fmi3FreeInstance, (void *of))
{
    fmi_end(of);
}

FMI_FUNCTION(int, fmi3EnterInitializationMode,
             (void *of, bool has_tolerance, double tolerance, double start, bool has_stop,
              double stop))
{
    struct fmi *self = of;
    const int result = fmi_initialize(self);
    if (result == FMI_OK) {
        self->start = start;
    }
    return result;
}

FMI_FUNCTION(int, fmi3ExitInitializationMode, (void *of))
{
    return fmi_initialized(of);
}

FMI_NOTHING(fmi3EnterEventMode, (void *of))
FMI_NOTHING(fmi3EnterStepMode, (void *of))
FMI_NOTHING(fmi3EnterConfigurationMode, (void *of))
FMI_NOTHING(fmi3ExitConfigurationMode, (void *of))

FMI_FUNCTION(int, fmi3Terminate, (void *of))
{
    return fmi_terminate(of);
}

FMI_FUNCTION(int, fmi3Reset, (void *of))
{
    return fmi_reset(of);
}

/* --- time --- */

FMI_FUNCTION(int, fmi3DoStep,
             (void *of, double now, double span, bool no_state, bool *event, bool *end, bool *early,
              double *last))
{
    struct instance *self = of;
    if (fmi_may_step(of, now, span) != FMI_OK) {
        return FMI_ERROR;
    }
    *last = fmu_step(self->fmi.fmu, now, span, self->early);
    *early = *last < now + span;
    *event = self->events && fmu_ticks(self->fmi.fmu);
    *end = false;
    return FMI_OK;
}

FMI_NOTHING(fmi3EvaluateDiscreteStates, (void *of))

FMI_FUNCTION(int, fmi3UpdateDiscreteStates,
             (void *of, bool *more, bool *end, bool *nominals, bool *values, bool *has_next,
              double *next))
{
    struct fmi *self = of;
    if (self == NULL) {
        return FMI_ERROR;
    }
    fmu_clocks_end(self->fmu);
    *more = *end = *nominals = *values = *has_next = false;
    *next = 0;
    return FMI_OK;
}

/* --- values --- */

FMI_VALUES(integers, int64_t, FMU_INT, value.integer)
FMI_VALUES(booleans, bool, FMU_BOOL, value.integer != 0)

FMI_FUNCTION(int, fmi3GetFloat64,
             (void *of, const uint32_t references[], size_t n, double values[], size_t n_values))
{
    return fmi_get_reals(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3SetFloat64,
             (void *of, const uint32_t references[], size_t n, const double values[],
              size_t n_values))
{
    return fmi_set_reals(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3GetInt64,
             (void *of, const uint32_t references[], size_t n, int64_t values[], size_t n_values))
{
    return get_integers(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3SetInt64,
             (void *of, const uint32_t references[], size_t n, const int64_t values[],
              size_t n_values))
{
    return set_integers(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3GetBoolean,
             (void *of, const uint32_t references[], size_t n, bool values[], size_t n_values))
{
    return get_booleans(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3SetBoolean,
             (void *of, const uint32_t references[], size_t n, const bool values[],
              size_t n_values))
{
    return set_booleans(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3GetString,
             (void *of, const uint32_t references[], size_t n, const char *values[],
              size_t n_values))
{
    return fmi_get_texts(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3SetString,
             (void *of, const uint32_t references[], size_t n, const char *const values[],
              size_t n_values))
{
    return fmi_set_texts(of, references, n, values, n_values);
}

FMI_FUNCTION(int, fmi3GetBinary,
             (void *of, const uint32_t references[], size_t n, size_t sizes[],
              const uint8_t *values[], size_t n_values))
{
    struct fmi *self = of;
    for (size_t i = 0; i < n; i++) {
        if (self == NULL || i >= n_values ||
            fmu_binary_get(self->fmu, references[i], &values[i], &sizes[i]) != DG_HOST_OK) {
            return fmi_refused(self, "a Binary");
        }
    }
    return FMI_OK;
}

FMI_FUNCTION(int, fmi3SetBinary,
             (void *of, const uint32_t references[], size_t n, const size_t sizes[],
              const uint8_t *const values[], size_t n_values))
{
    struct fmi *self = of;
    for (size_t i = 0; i < n; i++) {
        const int result = self == NULL || i >= n_values
                               ? DG_HOST_ERR_ARGUMENT
                               : fmu_binary_set(self->fmu, references[i], values[i], sizes[i]);
        if (result != DG_HOST_OK) {
            return fmi_failed(self, "a Binary", result);
        }
    }
    return FMI_OK;
}

FMI_FUNCTION(int, fmi3GetClock, (void *of, const uint32_t references[], size_t n, bool values[]))
{
    struct fmi *self = of;
    for (size_t i = 0; i < n; i++) {
        if (self == NULL || fmu_clock_get(self->fmu, references[i], &values[i]) != DG_HOST_OK) {
            return fmi_refused(self, "a Clock");
        }
    }
    return FMI_OK;
}

FMI_FUNCTION(int, fmi3SetClock,
             (void *of, const uint32_t references[], size_t n, const bool values[]))
{
    struct fmi *self = of;
    for (size_t i = 0; i < n; i++) {
        if (self == NULL || fmu_clock_set(self->fmu, references[i], values[i]) != DG_HOST_OK) {
            return fmi_refused(self, "a Clock");
        }
    }
    return FMI_OK;
}

/* Types that no variable has. */
#define NO_VALUES(name, type)                                                                      \
    FMI_FUNCTION(                                                                                  \
        int, fmi3Get##name,                                                                        \
        (void *of, const uint32_t references[], size_t n, type values[], size_t n_values))         \
    {                                                                                              \
        return n == 0 ? FMI_OK : fmi_refused(of, "no " #name " here");                             \
    }                                                                                              \
    FMI_FUNCTION(                                                                                  \
        int, fmi3Set##name,                                                                        \
        (void *of, const uint32_t references[], size_t n, const type values[], size_t n_values))   \
    {                                                                                              \
        return n == 0 ? FMI_OK : fmi_refused(of, "no " #name " here");                             \
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

FMI_STATES(fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState, fmi3SerializedFMUStateSize,
           fmi3SerializeFMUState, fmi3DeserializeFMUState)

/* --- what an encoder has not --- */

FMI_NOT_HERE(fmi3GetNumberOfVariableDependencies, (void *of, uint32_t reference, size_t *n))
FMI_NOT_HERE(fmi3GetVariableDependencies,
             (void *of, uint32_t dependent, size_t elements[], uint32_t independents[],
              size_t of_independents[], int kinds[], size_t n))
FMI_NOT_HERE(fmi3GetDirectionalDerivative,
             (void *of, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],
              size_t n_knowns, const double seed[], size_t n_seed, double to[], size_t n))
FMI_NOT_HERE(fmi3GetAdjointDerivative,
             (void *of, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],
              size_t n_knowns, const double seed[], size_t n_seed, double to[], size_t n))
FMI_NOT_HERE(fmi3GetIntervalDecimal, (void *of, const uint32_t references[], size_t n,
                                      double intervals[], int qualifiers[]))
FMI_NOT_HERE(fmi3GetIntervalFraction,
             (void *of, const uint32_t references[], size_t n, uint64_t counters[],
              uint64_t resolutions[], int qualifiers[]))
FMI_NOT_HERE(fmi3GetShiftDecimal,
             (void *of, const uint32_t references[], size_t n, double shifts[]))
FMI_NOT_HERE(fmi3GetShiftFraction, (void *of, const uint32_t references[], size_t n,
                                    uint64_t counters[], uint64_t resolutions[]))
FMI_NOT_HERE(fmi3SetIntervalDecimal,
             (void *of, const uint32_t references[], size_t n, const double intervals[]))
FMI_NOT_HERE(fmi3SetIntervalFraction, (void *of, const uint32_t references[], size_t n,
                                       const uint64_t counters[], const uint64_t resolutions[]))
FMI_NOT_HERE(fmi3SetShiftDecimal,
             (void *of, const uint32_t references[], size_t n, const double shifts[]))
FMI_NOT_HERE(fmi3SetShiftFraction, (void *of, const uint32_t references[], size_t n,
                                    const uint64_t counters[], const uint64_t resolutions[]))
FMI_NOT_HERE(fmi3EnterContinuousTimeMode, (void *of))
FMI_NOT_HERE(fmi3CompletedIntegratorStep, (void *of, bool no_state, bool *event, bool *end))
FMI_NOT_HERE(fmi3SetTime, (void *of, double time))
FMI_NOT_HERE(fmi3SetContinuousStates, (void *of, const double states[], size_t n))
FMI_NOT_HERE(fmi3GetContinuousStateDerivatives, (void *of, double derivatives[], size_t n))
FMI_NOT_HERE(fmi3GetEventIndicators, (void *of, double indicators[], size_t n))
FMI_NOT_HERE(fmi3GetContinuousStates, (void *of, double states[], size_t n))
FMI_NOT_HERE(fmi3GetNominalsOfContinuousStates, (void *of, double nominals[], size_t n))
FMI_NOT_HERE(fmi3GetNumberOfEventIndicators, (void *of, size_t *n))
FMI_NOT_HERE(fmi3GetNumberOfContinuousStates, (void *of, size_t *n))
FMI_NOT_HERE(fmi3GetOutputDerivatives, (void *of, const uint32_t references[], size_t n,
                                        const int32_t orders[], double values[], size_t n_values))
FMI_NOT_HERE(fmi3ActivateModelPartition, (void *of, uint32_t clock, double time))

/* NOLINTEND(misc-unused-parameters) */

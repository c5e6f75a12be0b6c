/* SPDX-License-Identifier: MIT */
/*
 * The functions of FMI 2.0, co-simulation: signals without wires. Names, types and values are those
 * of the standard; each is declared where it is defined, as an importer finds it by its name only.
 */
#include "fmi.h"

#include <stdlib.h>

enum { CO_SIMULATION = 1 };

struct callbacks {
    void (*log)(void *environment, const char *name, int status, const char *category,
                const char *message, ...);
    void *(*allocate)(size_t n, size_t size);
    void (*release)(void *memory);
    void (*finished)(void *environment, int status);
    void *environment;
};

struct instance {
    struct fmi fmi;
    const struct callbacks *callbacks;
};

static void log_text(const struct fmi *of, const char *text)
{
    const struct instance *self = (const struct instance *)of;
    if (self->callbacks != NULL && self->callbacks->log != NULL) {
        self->callbacks->log(self->callbacks->environment, "drehgeber", FMI_ERROR, "logStatusError",
                             "%s", text);
    }
}

/* The standard lays down what a function is given, used or not. */
/* NOLINTBEGIN(misc-unused-parameters) */

/* --- life --- */

FMI_FUNCTION(const char *, fmi2GetTypesPlatform, (void))
{
    return "default";
}

FMI_FUNCTION(const char *, fmi2GetVersion, (void))
{
    return "2.0";
}

FMI_NOTHING(fmi2SetDebugLogging, (void *of, int on, size_t n, const char *const categories[]))

FMI_FUNCTION(void *, fmi2Instantiate,
             (const char *name, int type, const char *token, const char *resources,
              const struct callbacks *callbacks, int visible, int logging))
{
    struct instance *self = type == CO_SIMULATION ? calloc(1, sizeof *self) : NULL;
    if (self == NULL) {
        return NULL;
    }
    self->callbacks = callbacks;
    self->fmi.tell = log_text;
    return fmi_begin(&self->fmi, token, resources);
}

FMI_FUNCTION(void, fmi2FreeInstance, (void *of))
{
    fmi_end(of);
}

FMI_FUNCTION(int, fmi2SetupExperiment,
             (void *of, int has_tolerance, double tolerance, double start, int has_stop,
              double stop))
{
    struct fmi *self = of;
    if (self == NULL) {
        return FMI_ERROR;
    }
    self->start = start;
    return FMI_OK;
}

FMI_FUNCTION(int, fmi2EnterInitializationMode, (void *of))
{
    return fmi_initialize(of);
}

FMI_FUNCTION(int, fmi2ExitInitializationMode, (void *of))
{
    return fmi_initialized(of);
}

FMI_FUNCTION(int, fmi2Terminate, (void *of))
{
    return fmi_terminate(of);
}

FMI_FUNCTION(int, fmi2Reset, (void *of))
{
    return fmi_reset(of);
}

FMI_FUNCTION(int, fmi2DoStep, (void *of, double now, double span, int no_state))
{
    struct fmi *self = of;
    if (fmi_may_step(self, now, span) != FMI_OK) {
        return FMI_ERROR;
    }
    (void)fmu_step(self->fmu, now, span, false);
    return FMI_OK;
}

/* --- values --- */

FMI_VALUES(integers, int32_t, FMU_INT, (int32_t)value.integer)
FMI_VALUES(booleans, int, FMU_BOOL, value.integer != 0)

FMI_FUNCTION(int, fmi2GetReal, (void *of, const uint32_t references[], size_t n, double values[]))
{
    return fmi_get_reals(of, references, n, values, n);
}

FMI_FUNCTION(int, fmi2SetReal,
             (void *of, const uint32_t references[], size_t n, const double values[]))
{
    return fmi_set_reals(of, references, n, values, n);
}

FMI_FUNCTION(int, fmi2GetInteger,
             (void *of, const uint32_t references[], size_t n, int32_t values[]))
{
    return get_integers(of, references, n, values, n);
}

FMI_FUNCTION(int, fmi2SetInteger,
             (void *of, const uint32_t references[], size_t n, const int32_t values[]))
{
    return set_integers(of, references, n, values, n);
}

FMI_FUNCTION(int, fmi2GetBoolean, (void *of, const uint32_t references[], size_t n, int values[]))
{
    return get_booleans(of, references, n, values, n);
}

FMI_FUNCTION(int, fmi2SetBoolean,
             (void *of, const uint32_t references[], size_t n, const int values[]))
{
    return set_booleans(of, references, n, values, n);
}

FMI_FUNCTION(int, fmi2GetString,
             (void *of, const uint32_t references[], size_t n, const char *values[]))
{
    return fmi_get_texts(of, references, n, values, n);
}

FMI_FUNCTION(int, fmi2SetString,
             (void *of, const uint32_t references[], size_t n, const char *const values[]))
{
    return fmi_set_texts(of, references, n, values, n);
}

/* --- states --- */

FMI_STATES(fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate, fmi2SerializedFMUstateSize,
           fmi2SerializeFMUstate, fmi2DeSerializeFMUstate)

/* --- what an encoder has not --- */

FMI_NOT_HERE(fmi2GetDirectionalDerivative,
             (void *of, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],
              size_t n_knowns, const double seed[], double to[]))
FMI_NOT_HERE(fmi2SetRealInputDerivatives, (void *of, const uint32_t references[], size_t n,
                                           const int orders[], const double values[]))
FMI_NOT_HERE(fmi2GetRealOutputDerivatives,
             (void *of, const uint32_t references[], size_t n, const int orders[], double values[]))
FMI_NOT_HERE(fmi2CancelStep, (void *of))
FMI_NOT_HERE(fmi2GetStatus, (void *of, int kind, int *value))
FMI_NOT_HERE(fmi2GetRealStatus, (void *of, int kind, double *value))
FMI_NOT_HERE(fmi2GetIntegerStatus, (void *of, int kind, int *value))
FMI_NOT_HERE(fmi2GetBooleanStatus, (void *of, int kind, int *value))
FMI_NOT_HERE(fmi2GetStringStatus, (void *of, int kind, const char **value))

/* NOLINTEND(misc-unused-parameters) */

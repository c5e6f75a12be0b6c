/* SPDX-License-Identifier: MIT */
/*
 * The functions of FMI 2.0, co-simulation: signals without wires. Names, types and values are those
 * of the standard; each is declared where it is defined, as an importer finds it by its name only.
 */
#include <stddef.h>
#include <stdint.h>
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
#define FMI2(type, name, arguments)                                                                \
    EXPORT type name arguments;                                                                    \
    type name arguments

/* fmi2Status, fmi2Type */
enum status { OK, WARNING, DISCARD, ERROR, FATAL };
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
    struct fmu *fmu;
    const struct callbacks *callbacks;
    double start;
    int initializing;
    char (*texts)[FMU_NAME_MAX]; /* owned: those that were got last */
};

struct state {
    size_t n;
    uint8_t bytes[];
};

static int failed(const struct instance *self, const char *what, int result)
{
    if (self->callbacks != NULL && self->callbacks->log != NULL) {
        self->callbacks->log(self->callbacks->environment, "drehgeber", ERROR, "logStatusError",
                             "%s: %s", what, dg_host_result_text(result));
    }
    return ERROR;
}

/* The standard lays down what a function is given, used or not. */
/* NOLINTBEGIN(misc-unused-parameters) */

/* --- life --- */

FMI2(const char *, fmi2GetTypesPlatform, (void))
{
    return "default";
}

FMI2(const char *, fmi2GetVersion, (void))
{
    return "2.0";
}

FMI2(int, fmi2SetDebugLogging, (void *of, int on, size_t n, const char *const categories[]))
{
    return OK;
}

FMI2(void *, fmi2Instantiate,
     (const char *name, int type, const char *token, const char *resources,
      const struct callbacks *callbacks, int visible, int logging))
{
    struct instance *self = type == CO_SIMULATION ? calloc(1, sizeof *self) : NULL;
    if (self == NULL) {
        return NULL;
    }
    self->callbacks = callbacks;
    self->fmu = fmu_make(token);
    if (self->fmu == NULL) {
        (void)failed(self, "the guid of the model description is another build's",
                     DG_HOST_ERR_OTHER);
        free(self);
        return NULL;
    }
    return self;
}

FMI2(void, fmi2FreeInstance, (void *of))
{
    struct instance *self = of;
    if (self != NULL) {
        fmu_free(self->fmu);
        free(self->texts);
        free(self);
    }
}

FMI2(int, fmi2SetupExperiment,
     (void *of, int has_tolerance, double tolerance, double start, int has_stop, double stop))
{
    struct instance *self = of;
    self->start = start;
    return OK;
}

FMI2(int, fmi2EnterInitializationMode, (void *of))
{
    struct instance *self = of;
    self->initializing = 1;
    return OK;
}

static int begin(struct instance *self)
{
    const int result = fmu_start(self->fmu, self->start);
    return result == DG_HOST_OK ? OK : failed(self, "power-on", result);
}

FMI2(int, fmi2ExitInitializationMode, (void *of))
{
    struct instance *self = of;
    self->initializing = 0;
    return begin(self);
}

FMI2(int, fmi2Terminate, (void *of))
{
    return OK;
}

FMI2(int, fmi2Reset, (void *of))
{
    struct instance *self = of;
    self->initializing = 0;
    return fmu_reset(self->fmu) == 0 ? OK : ERROR;
}

FMI2(int, fmi2DoStep, (void *of, double now, double span, int no_state))
{
    struct instance *self = of;
    if (!(span >= 0)) {
        return failed(self, "communicationStepSize", DG_HOST_ERR_ARGUMENT);
    }
    (void)fmu_step(self->fmu, now, span, false);
    fmu_clocks_end(self->fmu);
    return OK;
}

/* --- values --- */

static int get(struct instance *self, uint32_t reference, struct fmu_value *to)
{
    const int begun = self->initializing ? begin(self) : OK;
    const int result = begun == OK ? fmu_get(self->fmu, reference, to) : DG_HOST_ERR_STATE;
    return result == DG_HOST_OK ? OK : failed(self, "get", result);
}

static int set(struct instance *self, uint32_t reference, const struct fmu_value *value)
{
    const int result = fmu_set(self->fmu, reference, value);
    return result == DG_HOST_OK ? OK : failed(self, "set", result);
}

FMI2(int, fmi2GetReal, (void *of, const uint32_t references[], size_t n, double values[]))
{
    struct fmu_value value;
    for (size_t i = 0; i < n; i++) {
        if (get(of, references[i], &value) != OK) {
            return ERROR;
        }
        values[i] = value.real;
    }
    return OK;
}

FMI2(int, fmi2SetReal, (void *of, const uint32_t references[], size_t n, const double values[]))
{
    for (size_t i = 0; i < n; i++) {
        const struct fmu_value value = {.type = FMU_REAL, .real = values[i]};
        if (set(of, references[i], &value) != OK) {
            return ERROR;
        }
    }
    return OK;
}

FMI2(int, fmi2GetInteger, (void *of, const uint32_t references[], size_t n, int32_t values[]))
{
    struct fmu_value value;
    for (size_t i = 0; i < n; i++) {
        if (get(of, references[i], &value) != OK) {
            return ERROR;
        }
        values[i] = (int32_t)value.integer;
    }
    return OK;
}

static int set_integers(struct instance *self, const uint32_t references[], size_t n,
                        const int32_t values[], enum fmu_type type)
{
    for (size_t i = 0; i < n; i++) {
        const struct fmu_value value = {.type = type, .real = values[i], .integer = values[i]};
        if (set(self, references[i], &value) != OK) {
            return ERROR;
        }
    }
    return OK;
}

FMI2(int, fmi2SetInteger, (void *of, const uint32_t references[], size_t n, const int32_t values[]))
{
    return set_integers(of, references, n, values, FMU_INT);
}

FMI2(int, fmi2GetBoolean, (void *of, const uint32_t references[], size_t n, int values[]))
{
    struct fmu_value value;
    for (size_t i = 0; i < n; i++) {
        if (get(of, references[i], &value) != OK) {
            return ERROR;
        }
        values[i] = value.integer != 0;
    }
    return OK;
}

FMI2(int, fmi2SetBoolean, (void *of, const uint32_t references[], size_t n, const int values[]))
{
    return set_integers(of, references, n, values, FMU_BOOL);
}

/* They last until the next call. */
FMI2(int, fmi2GetString, (void *of, const uint32_t references[], size_t n, const char *values[]))
{
    struct instance *self = of;
    struct fmu_value value;
    char(*texts)[FMU_NAME_MAX] = n == 0 ? NULL : calloc(n, sizeof *texts);
    free(self->texts);
    self->texts = texts;
    if (n > 0 && texts == NULL) {
        return failed(self, "Strings", DG_HOST_ERR_SPACE);
    }
    for (size_t i = 0; i < n; i++) {
        if (get(self, references[i], &value) != OK) {
            return ERROR;
        }
        memcpy(texts[i], value.text, sizeof texts[i]);
        values[i] = texts[i];
    }
    return OK;
}

FMI2(int, fmi2SetString,
     (void *of, const uint32_t references[], size_t n, const char *const values[]))
{
    for (size_t i = 0; i < n; i++) {
        struct fmu_value value = {.type = FMU_TEXT};
        if (strlen(values[i]) >= sizeof value.text) {
            return failed(of, "a String", DG_HOST_ERR_SPACE);
        }
        memcpy(value.text, values[i], strlen(values[i]) + 1);
        if (set(of, references[i], &value) != OK) {
            return ERROR;
        }
    }
    return OK;
}

/* --- states --- */

FMI2(int, fmi2GetFMUstate, (void *of, void **to))
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

FMI2(int, fmi2SetFMUstate, (void *of, void *from))
{
    struct instance *self = of;
    const struct state *state = from;
    const int result = fmu_restore(self->fmu, state->bytes, state->n);
    return result == DG_HOST_OK ? OK : failed(self, "a state", result);
}

FMI2(int, fmi2FreeFMUstate, (void *of, void **state))
{
    free(*state);
    *state = NULL;
    return OK;
}

FMI2(int, fmi2SerializedFMUstateSize, (void *of, void *state, size_t *n))
{
    *n = ((const struct state *)state)->n;
    return OK;
}

FMI2(int, fmi2SerializeFMUstate, (void *of, void *from, uint8_t bytes[], size_t n))
{
    const struct state *state = from;
    if (n < state->n) {
        return failed(of, "a state", DG_HOST_ERR_SPACE);
    }
    memcpy(bytes, state->bytes, state->n);
    return OK;
}

FMI2(int, fmi2DeSerializeFMUstate, (void *of, const uint8_t bytes[], size_t n, void **to))
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
    FMI2(int, name, arguments)                                                                     \
    {                                                                                              \
        return failed(of, #name, DG_HOST_ERR_NAME);                                                \
    }
NOT_HERE(fmi2GetDirectionalDerivative,
         (void *of, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],
          size_t n_knowns, const double seed[], double to[]))
NOT_HERE(fmi2SetRealInputDerivatives, (void *of, const uint32_t references[], size_t n,
                                       const int orders[], const double values[]))
NOT_HERE(fmi2GetRealOutputDerivatives,
         (void *of, const uint32_t references[], size_t n, const int orders[], double values[]))
NOT_HERE(fmi2CancelStep, (void *of))
NOT_HERE(fmi2GetStatus, (void *of, int kind, int *value))
NOT_HERE(fmi2GetRealStatus, (void *of, int kind, double *value))
NOT_HERE(fmi2GetIntegerStatus, (void *of, int kind, int *value))
NOT_HERE(fmi2GetBooleanStatus, (void *of, int kind, int *value))
NOT_HERE(fmi2GetStringStatus, (void *of, int kind, const char **value))

/* NOLINTEND(misc-unused-parameters) */

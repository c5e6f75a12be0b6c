/* SPDX-License-Identifier: MIT */
/*
 * The functions of FMI 2.0 and 3.0 as an importer in C calls them: each in its turn and out of it,
 * with what is wrong, and without memory. What goes wrong is told in words, and nothing is left of
 * an instance that is freed.
 *
 * The calls for memory of both come here (the linker's --wrap).
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fmu_rig.h"

/* Of both standards: fmi2Status and fmi3Status. */
enum { OK = 0, ERROR = 3 };

static const uint32_t none = UINT32_C(9) << 16 | VARIABLE(FMU_INPUT, FMU_ANGLE);
static const uint32_t now = VARIABLE(FMU_TIME, 0);
static const uint32_t speed = VARIABLE(FMU_INPUT, FMU_SPEED);
static const uint32_t node = VARIABLE(FMU_PARAMETER, 0);
static const uint32_t fault = VARIABLE(FMU_FAULT, 1); /* temperature_high */
static const uint32_t position = VARIABLE(FMU_OUTPUT, FMU_POSITION);

/* --- FMI 3.0 --- */

typedef void log_3(void *environment, int status, const char *category, const char *message);
void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                  bool visible, bool logging, bool events, bool early,
                                  const uint32_t intermediate[], size_t n, void *environment,
                                  log_3 *log, void (*update)(void));
void fmi3FreeInstance(void *of);
int fmi3EnterInitializationMode(void *of, bool has_tolerance, double tolerance, double start,
                                bool has_stop, double stop);
int fmi3ExitInitializationMode(void *of);
int fmi3Terminate(void *of);
int fmi3Reset(void *of);
int fmi3DoStep(void *of, double at, double span, bool no_state, bool *event, bool *end, bool *early,
               double *last);
int fmi3UpdateDiscreteStates(void *of, bool *more, bool *end, bool *nominals, bool *values,
                             bool *has_next, double *next);
int fmi3GetFloat64(void *of, const uint32_t references[], size_t n, double values[], size_t room);
int fmi3SetFloat64(void *of, const uint32_t references[], size_t n, const double values[],
                   size_t room);
int fmi3GetInt64(void *of, const uint32_t references[], size_t n, int64_t values[], size_t room);
int fmi3SetInt64(void *of, const uint32_t references[], size_t n, const int64_t values[],
                 size_t room);
int fmi3GetBoolean(void *of, const uint32_t references[], size_t n, bool values[], size_t room);
int fmi3SetBoolean(void *of, const uint32_t references[], size_t n, const bool values[],
                   size_t room);
int fmi3GetString(void *of, const uint32_t references[], size_t n, const char *values[],
                  size_t room);
int fmi3SetString(void *of, const uint32_t references[], size_t n, const char *const values[],
                  size_t room);
int fmi3GetBinary(void *of, const uint32_t references[], size_t n, size_t sizes[],
                  const uint8_t *values[], size_t room);
int fmi3SetBinary(void *of, const uint32_t references[], size_t n, const size_t sizes[],
                  const uint8_t *const values[], size_t room);
int fmi3GetClock(void *of, const uint32_t references[], size_t n, bool values[]);
int fmi3SetClock(void *of, const uint32_t references[], size_t n, const bool values[]);
int fmi3GetInt8(void *of, const uint32_t references[], size_t n, int8_t values[], size_t room);
int fmi3SetTime(void *of, double time);
int fmi3GetFMUState(void *of, void **to);
int fmi3SetFMUState(void *of, void *from);
int fmi3FreeFMUState(void *of, void **state);
int fmi3SerializedFMUStateSize(void *of, void *state, size_t *n);
int fmi3SerializeFMUState(void *of, void *state, uint8_t bytes[], size_t n);
int fmi3DeserializeFMUState(void *of, const uint8_t bytes[], size_t n, void **to);

/* --- FMI 2.0 --- */

typedef void log_2(void *environment, const char *name, int status, const char *category,
                   const char *message, ...);
struct callbacks {
    log_2 *log;
    void *(*allocate)(size_t n, size_t size);
    void (*release)(void *memory);
    void (*finished)(void *environment, int status);
    void *environment;
};
void *fmi2Instantiate(const char *name, int type, const char *token, const char *resources,
                      const struct callbacks *callbacks, int visible, int logging);
void fmi2FreeInstance(void *of);
int fmi2SetupExperiment(void *of, int has_tolerance, double tolerance, double start, int has_stop,
                        double stop);
int fmi2EnterInitializationMode(void *of);
int fmi2ExitInitializationMode(void *of);
int fmi2Terminate(void *of);
int fmi2Reset(void *of);
int fmi2DoStep(void *of, double at, double span, int no_state);
int fmi2GetReal(void *of, const uint32_t references[], size_t n, double values[]);
int fmi2SetReal(void *of, const uint32_t references[], size_t n, const double values[]);
int fmi2GetInteger(void *of, const uint32_t references[], size_t n, int32_t values[]);
int fmi2SetInteger(void *of, const uint32_t references[], size_t n, const int32_t values[]);
int fmi2GetBoolean(void *of, const uint32_t references[], size_t n, int values[]);
int fmi2SetBoolean(void *of, const uint32_t references[], size_t n, const int values[]);
int fmi2GetString(void *of, const uint32_t references[], size_t n, const char *values[]);
int fmi2SetString(void *of, const uint32_t references[], size_t n, const char *const values[]);
int fmi2CancelStep(void *of);
int fmi2GetFMUstate(void *of, void **to);
int fmi2SetFMUstate(void *of, void *from);
int fmi2FreeFMUstate(void *of, void **state);

/* --- what both are asked for --- */

/* What was told, and how often. */
static struct {
    unsigned times;
    int status;
    const void *environment;
    char category[32];
    char text[160];
} heard;

static void hear_log(void *environment, int status, const char *category, const char *message)
{
    heard.times++;
    heard.status = status;
    heard.environment = environment;
    (void)snprintf(heard.category, sizeof heard.category, "%s", category);
    (void)snprintf(heard.text, sizeof heard.text, "%s", message);
}

static void hear_2(void *environment, const char *name, int status, const char *category,
                   const char *message, ...)
{
    char text[160];
    va_list arguments;
    va_start(arguments, message);
    (void)vsnprintf(text, sizeof text, message, arguments);
    va_end(arguments);
    assert_string_equal(name, "drehgeber");
    hear_log(environment, status, category, text);
}

static const struct callbacks callbacks = {.log = hear_2, .environment = &heard};

/* Of the instances to come; NULL: they have none. */
static const char *resources;

static void *make_3(const char *token)
{
    return fmi3InstantiateCoSimulation("it", token, resources, false, false, true, false, NULL, 0,
                                       &heard, hear_log, NULL);
}

static void *make_2(const char *token)
{
    return fmi2Instantiate("it", 1, token, resources, &callbacks, 0, 0);
}

static int enter_3(void *of, double start)
{
    return fmi3EnterInitializationMode(of, false, 0, start, false, 0);
}

static int enter_2(void *of, double start)
{
    const int result = fmi2SetupExperiment(of, 0, 0, start, 0, 0);
    return result == OK ? fmi2EnterInitializationMode(of) : result;
}

static int step_3(void *of, double at, double span)
{
    bool event, end, early;
    double last;
    return fmi3DoStep(of, at, span, true, &event, &end, &early, &last);
}

static int step_2(void *of, double at, double span)
{
    return fmi2DoStep(of, at, span, 1);
}

static int get_3(void *of, uint32_t reference, double *value)
{
    return fmi3GetFloat64(of, &reference, 1, value, 1);
}

static int get_2(void *of, uint32_t reference, double *value)
{
    return fmi2GetReal(of, &reference, 1, value);
}

static int set_3(void *of, uint32_t reference, double value)
{
    return fmi3SetFloat64(of, &reference, 1, &value, 1);
}

static int set_2(void *of, uint32_t reference, double value)
{
    return fmi2SetReal(of, &reference, 1, &value);
}

static int texts_3(void *of, const uint32_t references[], size_t n, const char *texts[])
{
    return fmi3GetString(of, references, n, texts, n);
}

static const struct version {
    void *(*make)(const char *token);
    void (*end)(void *of);
    int (*enter)(void *of, double start);
    int (*leave)(void *of);
    int (*step)(void *of, double at, double span);
    int (*terminate)(void *of);
    int (*reset)(void *of);
    int (*get)(void *of, uint32_t reference, double *value);
    int (*set)(void *of, uint32_t reference, double value);
    int (*texts)(void *of, const uint32_t references[], size_t n, const char *texts[]);
    int (*save)(void *of, void **to);
    int (*restore)(void *of, void *from);
    int (*release)(void *of, void **state);
} versions[] = {
    {make_3, fmi3FreeInstance, enter_3, fmi3ExitInitializationMode, step_3, fmi3Terminate,
     fmi3Reset, get_3, set_3, texts_3, fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState},
    {make_2, fmi2FreeInstance, enter_2, fmi2ExitInitializationMode, step_2, fmi2Terminate,
     fmi2Reset, get_2, set_2, fmi2GetString, fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate},
};

/* The call was an error, and the importer has heard why, once. */
static void refused(int status, const char *what, int result)
{
    char text[160];
    (void)snprintf(text, sizeof text, "%s: %s", what, dg_host_result_text(result));
    assert_int_equal(status, ERROR);
    assert_string_equal(heard.text, text);
    assert_int_equal(heard.times, 1);
    assert_int_equal(heard.status, ERROR);
    assert_string_equal(heard.category, "logStatusError");
    assert_ptr_equal(heard.environment, &heard);
    memset(&heard, 0, sizeof heard);
}

static void *begin(const struct version *fmi, const char *token, double start)
{
    void *of = fmi->make(token);
    assert_non_null(of);
    assert_int_equal(fmi->enter(of, start), OK);
    return of;
}

static double value_of(const struct version *fmi, void *of, uint32_t reference)
{
    double value = (double)NAN;
    assert_int_equal(fmi->get(of, reference, &value), OK);
    return value;
}

static void errors_are_told_in_words(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(versions); i++) {
        const struct version *fmi = &versions[i];
        double value;
        assert_null(fmi->make("drehgeber 0.0.0 =f3668"));
        refused(ERROR, "the token (guid) of the model description is another build's",
                DG_HOST_ERR_OTHER);
        void *of = fmi->make(TOKEN " =f3668");
        assert_non_null(of);
        refused(fmi->leave(of), "ExitInitializationMode", DG_HOST_ERR_STATE);
        refused(fmi->step(of, 0, 1), "DoStep", DG_HOST_ERR_STATE);
        assert_int_equal(fmi->enter(of, 0), OK);
        refused(fmi->enter(of, 0), "EnterInitializationMode", DG_HOST_ERR_STATE);
        assert_int_equal(fmi->leave(of), OK);
        refused(fmi->enter(of, 0), "EnterInitializationMode", DG_HOST_ERR_STATE);
        refused(fmi->leave(of), "ExitInitializationMode", DG_HOST_ERR_STATE);
        refused(fmi->get(of, none, &value), "get", DG_HOST_ERR_NAME);
        refused(fmi->set(of, none, 0), "set", DG_HOST_ERR_NAME);
        refused(fmi->set(of, node, 5), "set", DG_HOST_ERR_STATE);
        refused(fmi->step(of, 5, 0.25), "DoStep from 5 s for 0.25 s, the FMU is at 0 s",
                DG_HOST_ERR_ARGUMENT);
        refused(fmi->restore(of, NULL), "a state", DG_HOST_ERR_ARGUMENT);
        assert_int_equal(fmi->terminate(of), OK);
        refused(fmi->step(of, 0, 1), "DoStep", DG_HOST_ERR_STATE);
        assert_int_equal(heard.times, 0);
        fmi->end(of);
        of = begin(fmi, TOKEN " =f3668", 1e300);
        refused(fmi->get(of, position, &value), "power-on", DG_HOST_ERR_ARGUMENT);
        refused(fmi->leave(of), "power-on", DG_HOST_ERR_ARGUMENT);
        fmi->end(of);
    }
}

/* A call for more variables than there is room for, and for one that there is not. */
static void arrays_that_do_not_fit_are_told(void **state)
{
    const uint32_t speeds[2] = {speed, speed};
    const uint8_t *bytes[2] = {NULL, NULL};
    const char *texts[2] = {"12", "12"};
    const char *longer = "0123456789012345678901234567890123456789012345678901234567890123456789"
                         "01234567890123456789012345";
    double reals[2] = {0};
    int64_t integers[2] = {0};
    bool truths[2] = {false};
    size_t sizes[2] = {0};
    int8_t small;

    (void)state;
    void *of = begin(&versions[0], TOKEN " =f3668", 0);
    refused(fmi3GetFloat64(of, speeds, 2, reals, 1), "room for values", DG_HOST_ERR_ARGUMENT);
    refused(fmi3GetInt64(of, speeds, 2, integers, 1), "room for values", DG_HOST_ERR_ARGUMENT);
    refused(fmi3GetBoolean(of, speeds, 2, truths, 1), "room for values", DG_HOST_ERR_ARGUMENT);
    refused(fmi3GetString(of, speeds, 2, texts, 1), "Strings", DG_HOST_ERR_SPACE);
    refused(fmi3SetFloat64(of, speeds, 2, reals, 1), "fewer values than variables",
            DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetInt64(of, speeds, 2, integers, 1), "fewer values than variables",
            DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetBoolean(of, speeds, 2, truths, 1), "fewer values than variables",
            DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetString(of, speeds, 1, texts, 0), "a String", DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetString(of, speeds, 1, &longer, 1), "a String", DG_HOST_ERR_ARGUMENT);
    texts[0] = NULL;
    refused(fmi3SetString(of, speeds, 1, texts, 1), "a String", DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetString(of, speeds, 1, &texts[1], 1), "set", DG_HOST_ERR_ARGUMENT);
    refused(fmi3GetBinary(of, &none, 1, sizes, bytes, 1), "a Binary", DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetBinary(of, &none, 1, sizes, bytes, 1), "a Binary", DG_HOST_ERR_NAME);
    refused(fmi3SetBinary(of, &none, 1, sizes, bytes, 0), "a Binary", DG_HOST_ERR_ARGUMENT);
    refused(fmi3GetClock(of, &none, 1, truths), "a Clock", DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetClock(of, &none, 1, truths), "a Clock", DG_HOST_ERR_ARGUMENT);
    refused(fmi3GetInt8(of, speeds, 1, &small, 1), "no Int8 here", DG_HOST_ERR_ARGUMENT);
    refused(fmi3SetTime(of, 0), "fmi3SetTime", DG_HOST_ERR_NAME);
    fmi3FreeInstance(of);
    of = begin(&versions[1], TOKEN " =f3668", 0);
    refused(fmi2CancelStep(of), "fmi2CancelStep", DG_HOST_ERR_NAME);
    fmi2FreeInstance(of);
}

/* What stands behind the count is not looked at: there is no such variable, and it would be an
 * error. */
static void calls_end_with_their_count(void **state)
{
    const uint32_t numbers[] = {node, none};
    const uint32_t reals[] = {speed, none};
    const uint32_t truths[] = {fault, none};
    const uint32_t words[] = {VARIABLE(FMU_PARAMETER, 2), none};
    const uint32_t wires[] = {VARIABLE(FMU_BUS, FMU_TX), none};
    const uint32_t clocks[] = {VARIABLE(FMU_BUS, FMU_RX_CLOCK), none};
    const uint32_t in[] = {VARIABLE(FMU_BUS, FMU_RX), none};
    int64_t wide[2] = {9, 77};
    int32_t narrow[2] = {8, 77};
    double real[2] = {1, 77};
    bool truth[2] = {true, false};
    int flags[2] = {1, 77};
    const char *texts[2] = {"16", "77"};
    const uint8_t *bytes[2] = {NULL, NULL};
    size_t sizes[2] = {0, 77};

    (void)state;
    void *of = begin(&versions[0], TOKEN " =f3668", 0);
    assert_int_equal(fmi3SetInt64(of, numbers, 1, wide, 2), OK);
    assert_int_equal(fmi3SetFloat64(of, reals, 1, real, 2), OK);
    assert_int_equal(fmi3SetBoolean(of, truths, 1, truth, 2), OK);
    assert_int_equal(fmi3SetString(of, words, 1, texts, 2), OK);
    assert_int_equal(fmi3SetClock(of, clocks, 1, truth), OK);
    assert_int_equal(fmi3SetBinary(of, in, 1, sizes, bytes, 2), OK);
    assert_int_equal(fmi3GetInt64(of, numbers, 1, wide, 2), OK);
    assert_int_equal(fmi3GetFloat64(of, reals, 1, real, 2), OK);
    assert_int_equal(fmi3GetBoolean(of, truths, 1, truth, 2), OK);
    assert_int_equal(fmi3GetString(of, words, 1, texts, 2), OK);
    assert_int_equal(fmi3GetClock(of, clocks, 1, truth), OK);
    assert_int_equal(fmi3GetBinary(of, wires, 1, sizes, bytes, 2), OK);
    assert_true(wide[0] == 9 && wide[1] == 77 && real[0] == 1 && sizes[1] == 77);
    assert_string_equal(texts[0], "16");
    fmi3FreeInstance(of);
    of = begin(&versions[1], TOKEN " =f3668", 0);
    texts[0] = "12";
    assert_int_equal(fmi2SetInteger(of, numbers, 1, narrow), OK);
    assert_int_equal(fmi2SetReal(of, reals, 1, real), OK);
    assert_int_equal(fmi2SetBoolean(of, truths, 1, flags), OK);
    assert_int_equal(fmi2SetString(of, words, 1, texts), OK);
    narrow[0] = flags[0] = 55;
    assert_int_equal(fmi2GetInteger(of, numbers, 1, narrow), OK);
    assert_int_equal(fmi2GetReal(of, reals, 1, real), OK);
    assert_int_equal(fmi2GetBoolean(of, truths, 1, flags), OK);
    assert_int_equal(fmi2GetString(of, words, 1, texts), OK);
    assert_true(narrow[0] == 8 && narrow[1] == 77 && flags[0] == 1 && flags[1] == 77);
    fmi2FreeInstance(of);
    assert_int_equal(heard.times, 0);
}

/* Whoever wants to hear nothing. */
static void silent_importers_get_the_same_answers(void **state)
{
    static const struct callbacks deaf = {.environment = &heard};

    (void)state;
    void *of = fmi3InstantiateCoSimulation("it", TOKEN " =f3668", NULL, false, true, true, true,
                                           NULL, 0, &heard, NULL, NULL);
    assert_int_equal(fmi3ExitInitializationMode(of), ERROR);
    fmi3FreeInstance(of);
    of = fmi2Instantiate("it", 1, TOKEN " =f3668", NULL, NULL, 0, 1);
    assert_int_equal(fmi2ExitInitializationMode(of), ERROR);
    fmi2FreeInstance(of);
    of = fmi2Instantiate("it", 1, TOKEN " =f3668", NULL, &deaf, 0, 1);
    assert_int_equal(fmi2ExitInitializationMode(of), ERROR);
    fmi2FreeInstance(of);
    fmi2FreeInstance(NULL);
    fmi3FreeInstance(NULL);
    assert_int_equal(heard.times, 0);
}

/* FMI 3.0, 2.3.1, and 2.0, 4.2.4: from every mode, and as often as an importer likes. */
static void a_reset_begins_anew(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(versions); i++) {
        const struct version *fmi = &versions[i];
        void *of = begin(fmi, TOKEN " =s3684-biss", 7.5);
        assert_int_equal(fmi->set(of, speed, 6.283185307179586), OK);
        assert_int_equal(fmi->leave(of), OK);
        assert_true(value_of(fmi, of, now) == 7.5);
        assert_int_equal(fmi->step(of, 7.5, 0.5), OK);
        assert_true(value_of(fmi, of, now) == 8.0);
        assert_true(value_of(fmi, of, position) == 1 << 20);
        assert_int_equal(fmi->terminate(of), OK);
        assert_int_equal(fmi->reset(of), OK);
        refused(fmi->step(of, 8, 1), "DoStep", DG_HOST_ERR_STATE);
        assert_int_equal(fmi->enter(of, 0), OK);
        assert_int_equal(fmi->reset(of), OK);
        assert_int_equal(fmi->enter(of, -1), OK);
        assert_int_equal(fmi->leave(of), OK);
        assert_true(value_of(fmi, of, now) == -1.0);
        assert_int_equal(fmi->step(of, -1, 0.5), OK);
        assert_true(value_of(fmi, of, now) == -0.5);
        assert_true(value_of(fmi, of, position) == 0);
        fmi->end(of);
    }
}

/* Whoever looks at an output while initializing has made the encoder, and its settings are fixed.
 */
static void an_output_ends_the_settings(void **state)
{
    (void)state;
    for (size_t i = 0; i < DG_COUNT(versions); i++) {
        const struct version *fmi = &versions[i];
        void *of = begin(fmi, TOKEN " =f3668", 0);
        assert_int_equal(fmi->set(of, node, 9), OK);
        assert_true(value_of(fmi, of, position) == 0);
        refused(fmi->set(of, node, 10), "set", DG_HOST_ERR_STATE);
        assert_true(value_of(fmi, of, node) == 9);
        assert_int_equal(fmi->leave(of), OK);
        assert_int_equal(fmi->step(of, 0, 1), OK);
        fmi->end(of);
    }
}

/* 42h to address 40h, which asks for the position, and its check sum, as README.md has it. */
static void ask_for_position(void *of)
{
    static const uint8_t request[] = {0, 0, 0, 0, 0, 0, 0,    0,    0, 0,
                                      0, 0, 3, 0, 0, 0, 0x40, 0x42, 2};
    const uint32_t clock = VARIABLE(FMU_BUS, FMU_RX_CLOCK);
    const uint32_t data = VARIABLE(FMU_BUS, FMU_RX);
    const uint8_t *bytes = request;
    const size_t size = sizeof request;
    const bool ticks = true;
    assert_int_equal(fmi3SetClock(of, &clock, 1, &ticks), OK);
    assert_int_equal(fmi3SetBinary(of, &data, 1, &size, &bytes, 1), OK);
}

static void end_of_event(void *of)
{
    bool more = true, end = true, nominals = true, values = true, has_next = true;
    double next = 5;
    assert_int_equal(
        fmi3UpdateDiscreteStates(of, &more, &end, &nominals, &values, &has_next, &next), OK);
    assert_false(more || end || nominals || values || has_next);
    assert_true(next == 0);
}

/* FMI 3.0, fmi3DoStep: an event and an early end only for importers that know them. */
static void a_step_says_how_it_ended(void **state)
{
    static const struct {
        bool events, early, event, ends_early;
    } rows[] = {{false, false, false, false},
                {false, true, false, false},
                {true, false, true, false},
                {true, true, true, true}};
    const uint32_t clock = VARIABLE(FMU_BUS, FMU_TX_CLOCK);
    const uint32_t data = VARIABLE(FMU_BUS, FMU_TX);

    (void)state;
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        bool event = true, end = true, early = true, ticks = false;
        const uint8_t *bytes = NULL;
        size_t size = 0;
        double last = 0;
        void *of =
            fmi3InstantiateCoSimulation("it", TOKEN " =s3684-rs485", NULL, false, false,
                                        rows[i].events, rows[i].early, NULL, 0, NULL, NULL, NULL);
        assert_int_equal(enter_3(of, 0), OK);
        assert_int_equal(fmi3ExitInitializationMode(of), OK);
        assert_int_equal(fmi3DoStep(of, 0, 0.25, true, &event, &end, &early, &last), OK);
        assert_false(event || end || early);
        assert_true(last == 0.25);
        ask_for_position(of);
        end_of_event(of);
        event = early = !rows[i].event;
        end = true;
        assert_int_equal(fmi3DoStep(of, 0.25, 0.5, true, &event, &end, &early, &last), OK);
        assert_false(end);
        assert_int_equal(event, rows[i].event);
        assert_int_equal(early, rows[i].ends_early);
        assert_true(early ? last > 0.25 && last < 0.3 : last == 0.75);
        assert_int_equal(fmi3GetClock(of, &clock, 1, &ticks), OK);
        assert_true(ticks);
        assert_int_equal(fmi3GetBinary(of, &data, 1, &size, &bytes, 1), OK);
        assert_true(size > 16);
        end_of_event(of);
        assert_int_equal(fmi3GetClock(of, &clock, 1, &ticks), OK);
        assert_false(ticks);
        fmi3FreeInstance(of);
    }
}

/* One that is handed in again is used again, and bytes are those of the state that they name. */
static void states_are_taken_again_and_packed(void **state)
{
    const struct version *fmi = &versions[0];
    static uint8_t bytes[1 << 17];
    void *saved = NULL;
    void *unpacked = NULL;
    size_t n = 0;

    (void)state;
    void *of = begin(fmi, TOKEN " =s3684-biss", 2);
    void *other = begin(fmi, TOKEN " =s3684-biss", 0);
    assert_int_equal(fmi->set(of, speed, 6.283185307179586), OK);
    assert_int_equal(fmi->leave(of), OK);
    assert_int_equal(fmi->save(of, &saved), OK);
    assert_int_equal(fmi->step(of, 2, 0.5), OK);
    assert_int_equal(fmi->save(of, &saved), OK);
    assert_int_equal(fmi3SerializedFMUStateSize(of, saved, &n), OK);
    assert_true(n > 0 && n <= sizeof bytes);
    assert_int_equal(fmi3SerializeFMUState(of, saved, bytes, n), OK);
    refused(fmi3SerializeFMUState(of, saved, bytes, n - 1), "a state", DG_HOST_ERR_SPACE);
    refused(fmi3SerializeFMUState(of, NULL, bytes, n), "a state", DG_HOST_ERR_SPACE);
    refused(fmi3SerializedFMUStateSize(of, NULL, &n), "a state", DG_HOST_ERR_ARGUMENT);
    assert_int_equal(fmi3DeserializeFMUState(of, bytes, n, &unpacked), OK);
    assert_int_equal(fmi3DeserializeFMUState(of, bytes, n, &unpacked), OK);
    assert_int_equal(fmi->step(of, 2.5, 1), OK);
    assert_int_equal(fmi->restore(other, unpacked), OK);
    assert_true(value_of(fmi, other, now) == 2.5);
    assert_true(value_of(fmi, other, position) == 1 << 20);
    assert_int_equal(fmi->step(other, 2.5, 0.5), OK);
    assert_true(value_of(fmi, other, position) == 1 << 21);
    assert_int_equal(fmi->release(of, &saved), OK);
    assert_null(saved);
    assert_int_equal(fmi->release(of, &saved), OK);
    assert_int_equal(fmi->release(of, NULL), OK);
    assert_int_equal(fmi->release(of, &unpacked), OK);
    fmi->end(of);
    fmi->end(other);
}

/* --- memory --- */

static struct {
    unsigned left; /* calls until the one that is refused; 0: none is */
    bool refused;
    int live; /* what is in use */
} memory;

/* What a call for memory gets, of what it would get. */
static void *taken(void *got, bool is_new)
{
    memory.live += got != NULL && is_new ? 1 : 0;
    return got;
}

static bool refuses(void)
{
    const bool is = memory.left == 1;
    memory.left -= memory.left > 0 ? 1u : 0u;
    memory.refused = memory.refused || is;
    return is;
}

void *__real_malloc(size_t n);
void *__wrap_malloc(size_t n);
void *__wrap_malloc(size_t n)
{
    return refuses() ? NULL : taken(__real_malloc(n), true);
}

void *__real_calloc(size_t count, size_t n);
void *__wrap_calloc(size_t count, size_t n);
void *__wrap_calloc(size_t count, size_t n)
{
    return refuses() ? NULL : taken(__real_calloc(count, n), true);
}

void *__real_realloc(void *old, size_t n);
void *__wrap_realloc(void *old, size_t n);
void *__wrap_realloc(void *old, size_t n)
{
    return refuses() ? NULL : taken(__real_realloc(old, n), old == NULL);
}

void __real_free(void *old);
void __wrap_free(void *old);
void __wrap_free(void *old)
{
    memory.live -= old != NULL ? 1 : 0;
    __real_free(old);
}

/* Whatever takes memory, up to what is refused. @return the status of that */
static int use(const struct version *fmi, void *of, void **saved)
{
    const uint32_t references[] = {VARIABLE(FMU_PARAMETER, 2), VARIABLE(FMU_PARAMETER, 2)};
    const char *texts[2];
    const bool yes = true;
    int result = OK;
    for (int times = 0; times < 2 && result == OK; times++) {
        result = fmi->enter(of, 0);
        if (result == OK && fmi == &versions[0]) {
            result = fmi3SetBoolean(of, &fault, 1, &yes, 1);
        }
        result = result == OK ? fmi->leave(of) : result;
        result = result == OK ? fmi->texts(of, references, 2, texts) : result;
        result = result == OK ? fmi->texts(of, references, 1, texts) : result;
        result = result == OK ? fmi->step(of, 0, 0.1) : result;
        result = result == OK ? fmi->save(of, saved) : result;
        result = result == OK ? fmi->save(of, saved) : result;
        result = result == OK ? fmi->restore(of, *saved) : result;
        result = result == OK ? fmi->reset(of) : result;
    }
    return result;
}

/* Of all that an instance asks for, one is refused: that call is an error, and nothing is left. */
static void refuse_each_call(const struct version *fmi, const char *token)
{
    unsigned calls = 0;
    do {
        void *saved = NULL;
        const int before = memory.live;
        memory.refused = false;
        memory.left = ++calls;
        void *of = fmi->make(token);
        const int result = of == NULL ? ERROR : use(fmi, of, &saved);
        assert_int_equal(result, memory.refused ? ERROR : OK);
        memory.left = 0;
        assert_int_equal(fmi->release(of, &saved), OK);
        fmi->end(of);
        assert_int_equal(memory.live, before);
    } while (memory.refused);
    assert_true(calls > 15);
    memset(&heard, 0, sizeof heard);
}

/* The file of a rig is where the importer says that resources are. */
static void without_memory_there_is_an_error_and_no_leak(void **state)
{
    static const char bundle[] =
        "file 163 r.ini\n[shaft m]\nmotion = m.csv\n[bus b]\nwire = slcan\n[bus l]\nwire = pty\n"
        "[encoder a]\nmodel = f3668\nbus = b\nnode = 1..2\ntemperature = t.csv\n"
        "[encoder c]\nmodel = own\nbus = l\nmodel 15 own\nown:s3684-rs485"
        "motion 17 2\n0 0\n1000000000 1\ncourse 8 11\n0 37000\n";
    char folder[FMU_FOLDER_MAX];
    char token[RIG_TOKEN_MAX];

    (void)state;
    fmu_bundle_write(bundle, folder, token);
    for (size_t i = 0; i < DG_COUNT(versions); i++) {
        refuse_each_call(&versions[i], TOKEN " =f3668");
        resources = folder;
        refuse_each_call(&versions[i], token);
        resources = NULL;
    }
    fmu_bundle_remove(folder, token);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_are_told_in_words),
        cmocka_unit_test(arrays_that_do_not_fit_are_told),
        cmocka_unit_test(calls_end_with_their_count),
        cmocka_unit_test(silent_importers_get_the_same_answers),
        cmocka_unit_test(a_reset_begins_anew),
        cmocka_unit_test(an_output_ends_the_settings),
        cmocka_unit_test(a_step_says_how_it_ended),
        cmocka_unit_test(states_are_taken_again_and_packed),
        cmocka_unit_test(without_memory_there_is_an_error_and_no_leak),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

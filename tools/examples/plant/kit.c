/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "kit.h"

#include <dlfcn.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define VARIABLE "DREHGEBER_SILKIT_LIBRARY"
#define USUAL "libSilKit.so"
#define CONFIGURATION_MAX 384u
#define COORDINATED 10
#define RECEIVED 2u

/* "SK", service, type and version of a struct. */
#define HEADER(service, type, number)                                                              \
    {                                                                                              \
        .version = (uint64_t)'S' << 56u | (uint64_t)'K' << 48u | (uint64_t)(service) << 40u |      \
                   (uint64_t)(type) << 32u | (uint64_t)(number) << 24u                             \
    }

/* Where the address of each function goes. */
#define AT(member) offsetof(struct kit_calls, member)
static const struct {
    size_t at;
    const char *name;
} functions[] = {
    /* clang-format off */
    {AT(configure),        "SilKit_ParticipantConfiguration_FromString"},
    {AT(discard),          "SilKit_ParticipantConfiguration_Destroy"},
    {AT(join),             "SilKit_Participant_Create"},
    {AT(leave),            "SilKit_Participant_Destroy"},
    {AT(coordinate),       "SilKit_Experimental_SystemController_Create"},
    {AT(require),          "SilKit_Experimental_SystemController_SetWorkflowConfiguration"},
    {AT(live),             "SilKit_LifecycleService_Create"},
    {AT(on_ready),         "SilKit_LifecycleService_SetCommunicationReadyHandler"},
    {AT(on_shutdown),      "SilKit_LifecycleService_SetShutdownHandler"},
    {AT(on_abort),         "SilKit_LifecycleService_SetAbortHandler"},
    {AT(start),            "SilKit_LifecycleService_StartLifecycle"},
    {AT(stop),             "SilKit_LifecycleService_Stop"},
    {AT(synchronise),      "SilKit_TimeSyncService_Create"},
    {AT(on_step),          "SilKit_TimeSyncService_SetSimulationStepHandler"},
    {AT(control),          "SilKit_CanController_Create"},
    {AT(on_frame),         "SilKit_CanController_AddFrameHandler"},
    {AT(start_controller), "SilKit_CanController_Start"},
    {AT(send),             "SilKit_CanController_SendFrame"},
    {AT(offer),            "SilKit_DataPublisher_Create"},
    {AT(publish),          "SilKit_DataPublisher_Publish"},
    {AT(subscribe),        "SilKit_DataSubscriber_Create"},
    {AT(last_error),       "SilKit_GetLastErrorString"},
    /* clang-format on */
};
#define FUNCTIONS (sizeof functions / sizeof functions[0])
_Static_assert(sizeof(struct kit_calls) == FUNCTIONS * sizeof(void (*)(void)),
               "a row for each function");
_Static_assert(sizeof(void *) == sizeof(void (*)(void)), "POSIX: a function's address is one");

/* No destructors: threads of the library may be in the middle of something. */
static _Noreturn void refuse_kit(const char *what, const char *why)
{
    (void)fprintf(stderr, "plant: %s: %s\n", what, why);
    (void)fflush(stderr);
    _exit(KIT_REFUSED);
}

static void demand_success(const struct kit *self, const char *what, int32_t code)
{
    char words[96];
    if (code != 0) {
        (void)snprintf(words, sizeof words, "SIL Kit: %s", what);
        refuse_kit(words, self->call.last_error());
    }
}

void kit_load(struct kit *self)
{
    const char *given = getenv(VARIABLE);
    const char *file = given == NULL || given[0] == '\0' ? USUAL : given;
    void *library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        const char *why = dlerror();
        refuse_kit("no SIL Kit library", why == NULL ? file : why);
    }
    for (size_t i = 0; i < FUNCTIONS; i++) {
        const void *found = dlsym(library, functions[i].name);
        if (found == NULL) {
            refuse_kit(file, functions[i].name);
        }
        memcpy((char *)&self->call + functions[i].at, &found, sizeof found);
    }
}

static bool is_on_loopback(const char *registry)
{
    static const char *const begins[] = {"silkit://127.", "silkit://localhost:", "silkit://[::1]:"};
    for (size_t i = 0; i < sizeof begins / sizeof begins[0]; i++) {
        if (strncmp(registry, begins[i], strlen(begins[i])) == 0) {
            return true;
        }
    }
    return false;
}

/* Functions tell their errors, so the library's log is not wanted. A socket's path has 107
   characters at most, so it is in /tmp, whatever the environment's temporary folder is. */
static void print_configuration(char to[CONFIGURATION_MAX], const char *name, bool loopback,
                                bool aggregate)
{
    struct timespec now;
    char ports[192] = "";
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    if (loopback) {
        (void)snprintf(
            ports, sizeof ports,
            ",\"Middleware\":{\"AcceptorUris\":[\"local:///tmp/%.32s-%ld-%lld.%09ld.silkit\","
            "\"tcp://127.0.0.1:0\"]}",
            name, (long)getpid(), (long long)now.tv_sec, now.tv_nsec);
    }
    (void)snprintf(to, CONFIGURATION_MAX, "{\"Logging\":{\"Sinks\":[]}%s%s}", ports,
                   aggregate ? ",\"Experimental\":{\"TimeSynchronization\":"
                               "{\"EnableMessageAggregation\":\"On\"}}"
                             : "");
}

void kit_join(struct kit *self, const char *name, const char *registry, bool aggregate)
{
    char text[CONFIGURATION_MAX];
    void *configuration = NULL;
    print_configuration(text, name, is_on_loopback(registry), aggregate);
    demand_success(self, "ParticipantConfiguration_FromString",
                   self->call.configure(&configuration, text));
    demand_success(self, "Participant_Create",
                   self->call.join(&self->participant, configuration, name, registry));
    (void)self->call.discard(configuration);
}

void kit_coordinate(struct kit *self, const char *const *names, size_t count)
{
    const struct kit_strings required = {.count = count, .strings = names};
    const struct kit_workflow workflow = {.header = HEADER(7, 3, 3), .required = &required};
    void *coordinator = NULL;
    demand_success(self, "Experimental_SystemController_Create",
                   self->call.coordinate(&coordinator, self->participant));
    demand_success(self, "Experimental_SystemController_SetWorkflowConfiguration",
                   self->call.require(coordinator, &workflow));
}

void kit_live(struct kit *self, const struct kit_handlers *handlers, void *ctx, uint64_t step_ns)
{
    const struct kit_lifecycle setup = {.header = HEADER(7, 2, 1), .mode = COORDINATED};
    void *clock = NULL;
    demand_success(self, "LifecycleService_Create",
                   self->call.live(&self->life, self->participant, &setup));
    demand_success(self, "LifecycleService_SetCommunicationReadyHandler",
                   self->call.on_ready(self->life, ctx, handlers->ready));
    demand_success(self, "LifecycleService_SetShutdownHandler",
                   self->call.on_shutdown(self->life, ctx, handlers->shutdown));
    demand_success(self, "LifecycleService_SetAbortHandler",
                   self->call.on_abort(self->life, ctx, handlers->abort));
    demand_success(self, "TimeSyncService_Create", self->call.synchronise(&clock, self->life));
    demand_success(self, "TimeSyncService_SetSimulationStepHandler",
                   self->call.on_step(clock, ctx, handlers->step, step_ns));
}

void *kit_make_controller(struct kit *self, const char *network, kit_on_frame *handler, void *ctx)
{
    void *made = NULL;
    uint64_t id = 0;
    demand_success(self, "CanController_Create",
                   self->call.control(&made, self->participant, network, network));
    demand_success(self, "CanController_AddFrameHandler",
                   self->call.on_frame(made, ctx, handler, RECEIVED, &id));
    return made;
}

void *kit_make_publisher(struct kit *self, const char *topic, const char *media_type)
{
    const struct kit_spec spec = {
        .header = HEADER(5, 2, 1), .topic = topic, .media_type = media_type};
    void *made = NULL;
    demand_success(self, "DataPublisher_Create",
                   self->call.offer(&made, self->participant, topic, &spec, 0));
    return made;
}

void kit_subscribe(struct kit *self, const char *topic, const char *media_type,
                   kit_on_data *handler, void *ctx)
{
    const struct kit_spec spec = {
        .header = HEADER(5, 2, 1), .topic = topic, .media_type = media_type};
    void *made = NULL;
    demand_success(self, "DataSubscriber_Create",
                   self->call.subscribe(&made, self->participant, topic, &spec, ctx, handler));
}

void kit_start(struct kit *self)
{
    demand_success(self, "LifecycleService_StartLifecycle", self->call.start(self->life));
}

int32_t kit_send(const struct kit *self, void *controller, uint32_t id, struct kit_bytes data)
{
    const struct kit_frame frame = {
        .header = HEADER(1, 1, 1), .id = id, .dlc = (uint16_t)data.size, .data = data};
    return self->call.send(controller, &frame, NULL);
}

int32_t kit_publish(const struct kit *self, void *publisher, struct kit_bytes data)
{
    return self->call.publish(publisher, &data);
}

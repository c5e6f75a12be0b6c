/* SPDX-License-Identifier: MIT */
#include "silkit_library.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "drehgeber/api.h"

#define VARIABLE "DREHGEBER_SILKIT_LIBRARY"
#define USUAL "libSilKit.so"
#define RIGHT                                                                                      \
    "expected a libSilKit.so of SIL Kit 5, named by " VARIABLE " or where the dynamic linker looks"

/* Where the address of each function goes. */
#define AT(member) offsetof(struct lx_silkit_library, member)
static const struct {
    const char *name;
    size_t at;
} functions[] = {
    /* clang-format off */
    {"SilKit_ParticipantConfiguration_FromString",             AT(config_new)},
    {"SilKit_ParticipantConfiguration_Destroy",                AT(config_free)},
    {"SilKit_Participant_Create",                              AT(join)},
    {"SilKit_Participant_Destroy",                             AT(leave)},
    {"SilKit_LifecycleService_Create",                         AT(lifecycle_new)},
    {"SilKit_LifecycleService_SetCommunicationReadyHandler",   AT(on_ready)},
    {"SilKit_LifecycleService_SetStopHandler",                 AT(on_stop)},
    {"SilKit_LifecycleService_SetShutdownHandler",             AT(on_shutdown)},
    {"SilKit_LifecycleService_SetAbortHandler",                AT(on_abort)},
    {"SilKit_LifecycleService_StartLifecycle",                 AT(start)},
    {"SilKit_LifecycleService_Stop",                           AT(stop)},
    {"SilKit_LifecycleService_WaitForLifecycleToComplete",     AT(over)},
    {"SilKit_TimeSyncService_Create",                          AT(time_new)},
    {"SilKit_TimeSyncService_SetSimulationStepHandlerAsync",   AT(on_step)},
    {"SilKit_TimeSyncService_CompleteSimulationStep",          AT(complete)},
    {"SilKit_SystemMonitor_Create",                            AT(monitor_new)},
    {"SilKit_SystemMonitor_SetParticipantDisconnectedHandler", AT(on_peer_gone)},
    {"SilKit_CanController_Create",                            AT(can_new)},
    {"SilKit_CanController_AddFrameHandler",                   AT(can_on_frame)},
    {"SilKit_CanController_AddFrameTransmitHandler",           AT(can_on_transmit)},
    {"SilKit_CanController_AddErrorStateChangeHandler",        AT(can_on_error)},
    {"SilKit_CanController_SetBaudRate",                       AT(can_baud_rate)},
    {"SilKit_CanController_Start",                             AT(can_start)},
    {"SilKit_CanController_SendFrame",                         AT(can_send)},
    {"SilKit_DataPublisher_Create",                            AT(publisher_new)},
    {"SilKit_DataPublisher_Publish",                           AT(publish)},
    {"SilKit_DataSubscriber_Create",                           AT(subscriber_new)},
    {"SilKit_GetLastErrorString",                              AT(last_error)},
    /* clang-format on */
};

_Static_assert(sizeof(struct lx_silkit_library) == DG_COUNT(functions) * sizeof(void (*)(void)),
               "a row for each function");
_Static_assert(sizeof(void *) == sizeof(void (*)(void)), "POSIX: a function's address is one");

int lx_silkit_load(struct lx_silkit_library *self, struct lx_error *error)
{
    const char *given = getenv(VARIABLE);
    const char *file = given == NULL || given[0] == '\0' ? USUAL : given;
    void *library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        const char *why = dlerror();
        return lx_refuse(error, RIGHT, "no SIL Kit library: %s", why == NULL ? file : why);
    }
    for (size_t i = 0; i < DG_COUNT(functions); i++) {
        const void *found = dlsym(library, functions[i].name);
        if (found == NULL) {
            (void)lx_refuse(error, RIGHT, "%s has no %s", file, functions[i].name);
            (void)dlclose(library);
            return -1;
        }
        memcpy((char *)self + functions[i].at, &found, sizeof found);
    }
    return 0;
}

/* SPDX-License-Identifier: MIT */
/* A library with the names of SIL Kit's that does nothing by itself. */
#include "fake.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

__attribute__((visibility("default"))) struct fake_silkit fake_silkit;

static int32_t may(const char *function)
{
    if (fake_silkit.hangs != NULL && strcmp(fake_silkit.hangs, function) == 0) {
        for (;;) {
            (void)pause();
        }
    }
    return fake_silkit.refuses != NULL && strcmp(fake_silkit.refuses, function) == 0 ? 1 : 0;
}

#define MAKES(name, type, ...)                                                                     \
    __attribute__((visibility("default"))) int32_t SilKit_##name(struct type **out, __VA_ARGS__);  \
    int32_t SilKit_##name(struct type **out, __VA_ARGS__)
#define DOES(name, ...)                                                                            \
    __attribute__((visibility("default"))) int32_t SilKit_##name(__VA_ARGS__);                     \
    int32_t SilKit_##name(__VA_ARGS__)

MAKES(ParticipantConfiguration_FromString, lx_sk_config, const char *text)
{
    (void)snprintf(fake_silkit.config, sizeof fake_silkit.config, "%s", text);
    fake_silkit.configs += may("config") == 0 ? 1u : 0u;
    *out = (void *)&fake_silkit;
    return may("config");
}

DOES(ParticipantConfiguration_Destroy, struct lx_sk_config *self)
{
    (void)self;
    fake_silkit.configs--;
    return 0;
}

MAKES(Participant_Create, lx_sk_participant, struct lx_sk_config *config, const char *name,
      const char *registry)
{
    (void)config;
    (void)snprintf(fake_silkit.participant, sizeof fake_silkit.participant, "%s", name);
    (void)snprintf(fake_silkit.registry, sizeof fake_silkit.registry, "%s", registry);
    *out = (void *)&fake_silkit;
    return may("join");
}

DOES(Participant_Destroy, struct lx_sk_participant *self)
{
    (void)self;
    fake_silkit.left++;
    return 0;
}

MAKES(LifecycleService_Create, lx_sk_lifecycle, struct lx_sk_participant *participant,
      const struct lx_sk_lifecycle_setup *setup)
{
    (void)participant;
    fake_silkit.mode = setup->mode;
    *out = (void *)&fake_silkit;
    return may("lifecycle");
}

DOES(LifecycleService_SetCommunicationReadyHandler, struct lx_sk_lifecycle *self, void *ctx,
     lx_sk_on_lifecycle *handler)
{
    (void)self;
    fake_silkit.ctx = ctx;
    fake_silkit.ready = handler;
    return 0;
}

DOES(LifecycleService_SetStopHandler, struct lx_sk_lifecycle *self, void *ctx,
     lx_sk_on_lifecycle *handler)
{
    (void)self;
    (void)ctx;
    fake_silkit.stop = handler;
    return 0;
}

DOES(LifecycleService_SetShutdownHandler, struct lx_sk_lifecycle *self, void *ctx,
     lx_sk_on_lifecycle *handler)
{
    (void)self;
    (void)ctx;
    fake_silkit.shutdown = handler;
    return 0;
}

DOES(LifecycleService_SetAbortHandler, struct lx_sk_lifecycle *self, void *ctx,
     lx_sk_on_abort *handler)
{
    (void)self;
    (void)ctx;
    fake_silkit.abort = handler;
    return 0;
}

DOES(LifecycleService_StartLifecycle, struct lx_sk_lifecycle *self)
{
    (void)self;
    return may("start");
}

/* As the real one, which calls from another thread. */
DOES(LifecycleService_Stop, struct lx_sk_lifecycle *self, const char *reason)
{
    (void)reason;
    fake_silkit.stopped++;
    fake_silkit.stop(fake_silkit.ctx, self);
    fake_silkit.shutdown(fake_silkit.ctx, self);
    return 0;
}

DOES(LifecycleService_WaitForLifecycleToComplete, struct lx_sk_lifecycle *self, int16_t *state)
{
    (void)self;
    *state = 0;
    return 0;
}

MAKES(TimeSyncService_Create, lx_sk_time, struct lx_sk_lifecycle *lifecycle)
{
    (void)lifecycle;
    *out = (void *)&fake_silkit;
    return may("time");
}

DOES(TimeSyncService_SetSimulationStepHandlerAsync, struct lx_sk_time *self, void *ctx,
     lx_sk_on_step *handler, uint64_t step)
{
    (void)self;
    (void)ctx;
    fake_silkit.duration = step;
    fake_silkit.step = handler;
    return 0;
}

DOES(TimeSyncService_CompleteSimulationStep, struct lx_sk_time *self)
{
    (void)self;
    fake_silkit.completed++;
    return may("complete");
}

MAKES(SystemMonitor_Create, lx_sk_monitor, struct lx_sk_participant *participant)
{
    (void)participant;
    *out = (void *)&fake_silkit;
    return 0;
}

DOES(SystemMonitor_SetParticipantDisconnectedHandler, struct lx_sk_monitor *self, void *ctx,
     lx_sk_on_peer *handler)
{
    (void)self;
    (void)ctx;
    fake_silkit.gone = handler;
    return 0;
}

MAKES(CanController_Create, lx_sk_can, struct lx_sk_participant *participant, const char *name,
      const char *network)
{
    (void)participant;
    (void)name;
    (void)snprintf(fake_silkit.network, sizeof fake_silkit.network, "%s", network);
    *out = (void *)&fake_silkit;
    return may("can");
}

DOES(CanController_AddFrameHandler, struct lx_sk_can *self, void *ctx, lx_sk_on_frame *handler,
     uint8_t directions, uint64_t *id)
{
    (void)self;
    (void)directions;
    (void)id;
    fake_silkit.can_ctx = ctx;
    fake_silkit.frame = handler;
    return 0;
}

DOES(CanController_AddFrameTransmitHandler, struct lx_sk_can *self, void *ctx,
     lx_sk_on_transmit *handler, int32_t statuses, uint64_t *id)
{
    (void)self;
    (void)ctx;
    (void)statuses;
    (void)id;
    fake_silkit.transmit = handler;
    return 0;
}

DOES(CanController_AddErrorStateChangeHandler, struct lx_sk_can *self, void *ctx,
     lx_sk_on_error *handler, uint64_t *id)
{
    (void)self;
    (void)ctx;
    (void)id;
    fake_silkit.error = handler;
    return 0;
}

DOES(CanController_SetBaudRate, struct lx_sk_can *self, uint32_t rate, uint32_t fd, uint32_t xl)
{
    (void)self;
    fake_silkit.baud = rate;
    (void)fd;
    (void)xl;
    return may("baud");
}

DOES(CanController_Start, struct lx_sk_can *self)
{
    (void)self;
    fake_silkit.started++;
    return 0;
}

DOES(CanController_SendFrame, struct lx_sk_can *self, struct lx_sk_frame *frame, void *user)
{
    (void)self;
    (void)user;
    if (fake_silkit.frames < FAKE_FRAMES) {
        fake_silkit.sent[fake_silkit.frames].id = frame->id;
        fake_silkit.sent[fake_silkit.frames].flags = frame->flags;
        fake_silkit.sent[fake_silkit.frames].dlc = frame->dlc;
        fake_silkit.sent[fake_silkit.frames].size = frame->data.size;
        memcpy(fake_silkit.sent[fake_silkit.frames++].bytes, frame->data.data, frame->data.size);
    }
    return may("send");
}

/* FNV-1a. */
static uint64_t hash(uint64_t so_far, const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        so_far = (so_far ^ bytes[i]) * UINT64_C(0x100000001B3);
    }
    return so_far;
}

static struct fake_topic *topic_of(const struct lx_sk_spec *spec)
{
    struct fake_topic *topic = &fake_silkit.topic[fake_silkit.topics++];
    topic->topic = spec->topic;
    (void)snprintf(topic->media_type, sizeof topic->media_type, "%s", spec->media_type);
    return topic;
}

MAKES(DataPublisher_Create, lx_sk_publisher, struct lx_sk_participant *participant,
      const char *name, struct lx_sk_spec *spec, uint8_t history)
{
    (void)participant;
    (void)name;
    (void)history;
    *out = (void *)topic_of(spec);
    return may("publisher");
}

DOES(DataPublisher_Publish, struct lx_sk_publisher *self, const struct lx_sk_bytes *data)
{
    struct fake_topic *topic = (void *)self;
    topic->size = data->size < sizeof topic->bytes ? data->size : sizeof topic->bytes;
    memcpy(topic->bytes, data->data, topic->size);
    topic->count++;
    topic->hash = hash(topic->hash ^ data->size, data->data, data->size);
    return may("publish");
}

__attribute__((visibility("default"))) int32_t
SilKit_DataSubscriber_Create(struct lx_sk_subscriber **out, struct lx_sk_participant *participant,
                             const char *name, struct lx_sk_spec *spec, void *ctx,
                             lx_sk_on_data *handler);
int32_t SilKit_DataSubscriber_Create(struct lx_sk_subscriber **out,
                                     struct lx_sk_participant *participant, const char *name,
                                     struct lx_sk_spec *spec, void *ctx, lx_sk_on_data *handler)
{
    struct fake_topic *topic = topic_of(spec);
    (void)participant;
    (void)name;
    topic->ctx = ctx;
    topic->handler = handler;
    *out = (void *)topic;
    return may("subscriber");
}

__attribute__((visibility("default"))) const char *SilKit_GetLastErrorString(void);
const char *SilKit_GetLastErrorString(void)
{
    return fake_silkit.why == NULL ? "no luck" : fake_silkit.why;
}

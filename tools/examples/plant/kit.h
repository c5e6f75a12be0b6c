/* SPDX-License-Identifier: MIT */
/*
 * SIL Kit, as much of its C API (version 5, as its public headers silkit/capi have it) as the
 * plant's master uses. The library is found at run time, so the master is built without it.
 *
 * Handlers are called one after the other, on a thread of the library. What its functions return
 * is 0, or a code that `last_error` of the same thread has words for. A function that makes
 * something or prepares the simulation ends the program if the library refuses, with a line on
 * stderr and status KIT_REFUSED.
 */
#ifndef PLANT_KIT_H
#define PLANT_KIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Status of a program that cannot begin. */
#define KIT_REFUSED 2

/** What each struct of the library begins with. */
struct kit_header {
    uint64_t version;
    uint64_t reserved[3];
};

/** Bytes of somebody else. */
struct kit_bytes {
    const uint8_t *data;
    size_t size;
};

/** A CAN frame. */
struct kit_frame {
    struct kit_header header;
    uint32_t id;
    uint32_t flags;
    uint16_t dlc;
    uint8_t xl[6]; /**< of CAN XL */
    struct kit_bytes data;
};

/** ... that was received. */
struct kit_frame_event {
    struct kit_header header;
    uint64_t timestamp;
    const struct kit_frame *frame;
    uint8_t direction;
    void *user;
};

/** A message of a topic that was received. */
struct kit_data_event {
    struct kit_header header;
    uint64_t timestamp;
    struct kit_bytes data;
};

/** A topic. No labels are used. */
struct kit_spec {
    struct kit_header header;
    const char *topic;
    const char *media_type;
    size_t label_count;
    void *labels;
};

/** How a participant lives. */
struct kit_lifecycle {
    struct kit_header header;
    int8_t mode;
};

/** Names. */
struct kit_strings {
    size_t count;
    const char *const *strings;
};

/** Without whom the simulation does not begin. */
struct kit_workflow {
    struct kit_header header;
    const struct kit_strings *required;
};

/** What the library calls, with what it was given. */
typedef void kit_on_life(void *ctx, void *life);
typedef void kit_on_abort(void *ctx, void *life, int16_t before);
typedef void kit_on_step(void *ctx, void *clock, uint64_t now, uint64_t duration);
typedef void kit_on_frame(void *ctx, void *controller, const struct kit_frame_event *event);
typedef void kit_on_data(void *ctx, void *subscriber, const struct kit_data_event *event);

/** The library's functions; kit.c has their names. */
struct kit_calls {
    int32_t (*configure)(void **out, const char *text);
    int32_t (*discard)(void *configuration);
    int32_t (*join)(void **out, void *configuration, const char *name, const char *registry);
    int32_t (*leave)(void *participant);
    int32_t (*coordinate)(void **out, void *participant);
    int32_t (*require)(void *coordinator, const struct kit_workflow *workflow);
    int32_t (*live)(void **out, void *participant, const struct kit_lifecycle *setup);
    int32_t (*on_ready)(void *life, void *ctx, kit_on_life *handler);
    int32_t (*on_shutdown)(void *life, void *ctx, kit_on_life *handler);
    int32_t (*on_abort)(void *life, void *ctx, kit_on_abort *handler);
    int32_t (*start)(void *life);
    int32_t (*stop)(void *life, const char *reason);
    int32_t (*synchronise)(void **out, void *life);
    int32_t (*on_step)(void *clock, void *ctx, kit_on_step *handler, uint64_t step);
    int32_t (*control)(void **out, void *participant, const char *name, const char *network);
    int32_t (*on_frame)(void *controller, void *ctx, kit_on_frame *handler, uint8_t directions,
                        uint64_t *id);
    int32_t (*start_controller)(void *controller);
    int32_t (*send)(void *controller, const struct kit_frame *frame, void *user);
    int32_t (*offer)(void **out, void *participant, const char *name, const struct kit_spec *spec,
                     uint8_t history);
    int32_t (*publish)(void *publisher, const struct kit_bytes *data);
    int32_t (*subscribe)(void **out, void *participant, const char *name,
                         const struct kit_spec *spec, void *ctx, kit_on_data *handler);
    const char *(*last_error)(void);
};

/** The library, and the participant of this process. */
struct kit {
    struct kit_calls call;
    void *participant;
    void *life;
};

/** Who is told about the life of the participant. */
struct kit_handlers {
    kit_on_life *ready; /**< all have joined; controllers are to be started */
    kit_on_step *step;
    kit_on_life *shutdown; /**< this one or `abort` is the last one */
    kit_on_abort *abort;
};

/** Load $DREHGEBER_SILKIT_LIBRARY, or else libSilKit.so where the dynamic linker looks. */
void kit_load(struct kit *self);

/** Join the simulation of a registry as `name`. With one on loopback, others meet the participant
 * there, too, and otherwise on all interfaces. `aggregate`: what is sent in a step goes out
 * together. */
void kit_join(struct kit *self, const char *name, const char *registry, bool aggregate);

/** Be the system controller: the simulation begins when all `names` have joined. */
void kit_coordinate(struct kit *self, const char *const *names, size_t count);

/** Take part in virtual time, in steps of so many ns. */
void kit_live(struct kit *self, const struct kit_handlers *handlers, void *ctx, uint64_t step_ns);

/** A controller on a CAN network; `handler` is told what it receives. */
void *kit_make_controller(struct kit *self, const char *network, kit_on_frame *handler, void *ctx);

/** A publisher of a topic. */
void *kit_make_publisher(struct kit *self, const char *topic, const char *media_type);

/** Receive what is published on a topic. */
void kit_subscribe(struct kit *self, const char *topic, const char *media_type,
                   kit_on_data *handler, void *ctx);

/** Begin to live, when all is made. */
void kit_start(struct kit *self);

/** Send a frame of at most 8 bytes. @return 0, or the library's code */
int32_t kit_send(const struct kit *self, void *controller, uint32_t id, struct kit_bytes data);

/** Publish a message. @return 0, or the library's code */
int32_t kit_publish(const struct kit *self, void *publisher, struct kit_bytes data);

#endif

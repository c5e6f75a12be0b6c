/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The part of SIL Kit's C API (version 5, as its public headers silkit/capi have it) that the rig
 * uses: what its structs look like in memory, and a table of its functions, found at run time.
 * Nothing here needs its headers or its library to be built.
 *
 * Handlers are called on a thread of the library. What its functions return is 0, or a code that
 * `last_error` has words for.
 */
#ifndef DREHGEBER_LINUX_SILKIT_LIBRARY_H
#define DREHGEBER_LINUX_SILKIT_LIBRARY_H

#include <stddef.h>
#include <stdint.h>

#include "error.h"

/** What every struct begins with: "SK", service, type and version of the struct in one number. */
struct lx_sk_header {
    uint64_t version;
    uint64_t reserved[3];
};
#define LX_SK_VERSION(service, type, version)                                                      \
    ((uint64_t)'S' << 56u | (uint64_t)'K' << 48u | (uint64_t)(service) << 40u |                    \
     (uint64_t)(type) << 32u | (uint64_t)(version) << 24u)
#define LX_SK_CAN_FRAME LX_SK_VERSION(1, 1, 1)
#define LX_SK_DATA_SPEC LX_SK_VERSION(5, 2, 1)
#define LX_SK_LIFECYCLE LX_SK_VERSION(7, 2, 1)

/** Bytes of somebody else. */
struct lx_sk_bytes {
    const uint8_t *data;
    size_t size;
};

/** Flags of a frame: what is neither of the first two is none of CAN 2.0. */
#define LX_SK_FRAME_EXTENDED 0x0200u
#define LX_SK_FRAME_REMOTE 0x0010u

/** A CAN frame. */
struct lx_sk_frame {
    struct lx_sk_header header;
    uint32_t id;
    uint32_t flags;
    uint16_t dlc;
    uint8_t sdt; /**< CAN XL, likewise the next two */
    uint8_t vcid;
    uint32_t af;
    struct lx_sk_bytes data;
};

/** ... that came. */
struct lx_sk_frame_event {
    struct lx_sk_header header;
    uint64_t timestamp; /**< ns, of the sender */
    struct lx_sk_frame *frame;
    uint8_t direction;
    void *user;
};

/** Directions and results that handlers are wanted for. */
#define LX_SK_RECEIVED 2u
#define LX_SK_NOT_TRANSMITTED 6 /**< cancelled, or no room */

/** What became of a frame that was sent. */
struct lx_sk_transmit_event {
    struct lx_sk_header header;
    void *user;
    uint64_t timestamp;
    int32_t status;
    uint32_t id;
};

/** Of a controller. */
enum lx_sk_error_state {
    LX_SK_ERROR_UNKNOWN,
    LX_SK_ERROR_ACTIVE,
    LX_SK_ERROR_PASSIVE,
    LX_SK_BUS_OFF,
};

/** ... and that it has changed. */
struct lx_sk_error_event {
    struct lx_sk_header header;
    uint64_t timestamp;
    int32_t state; /**< enum lx_sk_error_state */
};

/** A topic. No labels are used. */
struct lx_sk_spec {
    struct lx_sk_header header;
    const char *topic;
    const char *media_type;
    size_t label_count;
    void *labels;
};

/** What was published. */
struct lx_sk_data_event {
    struct lx_sk_header header;
    uint64_t timestamp;
    struct lx_sk_bytes data;
};

/** How life begins: with all others, or when it can. */
#define LX_SK_COORDINATED 10
#define LX_SK_AUTONOMOUS 20

/** ... as it is told to the library. */
struct lx_sk_lifecycle_setup {
    struct lx_sk_header header;
    int8_t mode;
};

/** Another participant. */
struct lx_sk_connection {
    struct lx_sk_header header;
    const char *name;
};

/** What the library makes. */
struct lx_sk_config;
struct lx_sk_participant;
struct lx_sk_lifecycle;
struct lx_sk_time;
struct lx_sk_can;
struct lx_sk_publisher;
struct lx_sk_subscriber;
struct lx_sk_monitor;

/** Handlers. */
typedef void lx_sk_on_lifecycle(void *ctx, struct lx_sk_lifecycle *self);
typedef void lx_sk_on_abort(void *ctx, struct lx_sk_lifecycle *self, int16_t before);
typedef void lx_sk_on_step(void *ctx, struct lx_sk_time *self, uint64_t now, uint64_t duration);
typedef void lx_sk_on_frame(void *ctx, struct lx_sk_can *self, struct lx_sk_frame_event *event);
typedef void lx_sk_on_transmit(void *ctx, struct lx_sk_can *self,
                               struct lx_sk_transmit_event *event);
typedef void lx_sk_on_error(void *ctx, struct lx_sk_can *self, struct lx_sk_error_event *event);
typedef void lx_sk_on_data(void *ctx, struct lx_sk_subscriber *self,
                           const struct lx_sk_data_event *event);
typedef void lx_sk_on_peer(void *ctx, struct lx_sk_monitor *self,
                           const struct lx_sk_connection *peer);

/** The library: its functions that return a code. */
struct lx_silkit_library {
    int32_t (*config_new)(struct lx_sk_config **out, const char *text);
    int32_t (*config_free)(struct lx_sk_config *self);
    int32_t (*join)(struct lx_sk_participant **out, struct lx_sk_config *config, const char *name,
                    const char *registry);
    int32_t (*leave)(struct lx_sk_participant *self);
    int32_t (*lifecycle_new)(struct lx_sk_lifecycle **out, struct lx_sk_participant *participant,
                             const struct lx_sk_lifecycle_setup *setup);
    int32_t (*on_ready)(struct lx_sk_lifecycle *self, void *ctx, lx_sk_on_lifecycle *handler);
    int32_t (*on_stop)(struct lx_sk_lifecycle *self, void *ctx, lx_sk_on_lifecycle *handler);
    int32_t (*on_shutdown)(struct lx_sk_lifecycle *self, void *ctx, lx_sk_on_lifecycle *handler);
    int32_t (*on_abort)(struct lx_sk_lifecycle *self, void *ctx, lx_sk_on_abort *handler);
    int32_t (*start)(struct lx_sk_lifecycle *self);
    int32_t (*stop)(struct lx_sk_lifecycle *self, const char *reason);
    int32_t (*over)(struct lx_sk_lifecycle *self, int16_t *state);
    int32_t (*time_new)(struct lx_sk_time **out, struct lx_sk_lifecycle *lifecycle);
    int32_t (*on_step)(struct lx_sk_time *self, void *ctx, lx_sk_on_step *handler, uint64_t step);
    int32_t (*complete)(struct lx_sk_time *self);
    int32_t (*monitor_new)(struct lx_sk_monitor **out, struct lx_sk_participant *participant);
    int32_t (*on_peer_gone)(struct lx_sk_monitor *self, void *ctx, lx_sk_on_peer *handler);
    int32_t (*can_new)(struct lx_sk_can **out, struct lx_sk_participant *participant,
                       const char *name, const char *network);
    int32_t (*can_on_frame)(struct lx_sk_can *self, void *ctx, lx_sk_on_frame *handler,
                            uint8_t directions, uint64_t *id);
    int32_t (*can_on_transmit)(struct lx_sk_can *self, void *ctx, lx_sk_on_transmit *handler,
                               int32_t statuses, uint64_t *id);
    int32_t (*can_on_error)(struct lx_sk_can *self, void *ctx, lx_sk_on_error *handler,
                            uint64_t *id);
    int32_t (*can_baud_rate)(struct lx_sk_can *self, uint32_t rate, uint32_t fd, uint32_t xl);
    int32_t (*can_start)(struct lx_sk_can *self);
    int32_t (*can_send)(struct lx_sk_can *self, struct lx_sk_frame *frame, void *user);
    int32_t (*publisher_new)(struct lx_sk_publisher **out, struct lx_sk_participant *participant,
                             const char *name, struct lx_sk_spec *spec, uint8_t history);
    int32_t (*publish)(struct lx_sk_publisher *self, const struct lx_sk_bytes *data);
    int32_t (*subscriber_new)(struct lx_sk_subscriber **out, struct lx_sk_participant *participant,
                              const char *name, struct lx_sk_spec *spec, void *ctx,
                              lx_sk_on_data *handler);
    const char *(*last_error)(void); /**< of the calling thread */
};

/** Load it: $DREHGEBER_SILKIT_LIBRARY, else libSilKit.so where the dynamic linker looks. It stays
 * until the process ends. @return 0, or -1 with one line in `error` */
int lx_silkit_load(struct lx_silkit_library *self, struct lx_error *error);

#endif

/* SPDX-License-Identifier: MIT */
/*
 * What a participant sends and receives. A handler on the library's threads copies what it was
 * told and says which port it is for; the loop sorts and hands over.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "silkit_pack.h"
#include "silkit_parts.h"

#define FRAME_BYTES_MAX 8u

/* --- on the library's threads --- */

/* Put what a handler was told into the inbox. A thread that was left behind may still call handlers
   when the port is gone. */
static void put_message(struct lx_silkit_port *port, struct lx_silkit_message message,
                        const void *bytes, size_t n)
{
    message.port = port;
    if (!lx_silkit_is_left_behind()) {
        lx_silkit_inbox_put(&port->all->inbox, &message, bytes, n);
    }
}

static void on_frame(void *ctx, struct lx_sk_can *can, struct lx_sk_frame_event *event)
{
    const struct lx_sk_frame *frame = event->frame;
    const bool fits = frame->data.size <= FRAME_BYTES_MAX;
    const struct lx_silkit_message message = {
        .kind = fits ? LX_SILKIT_FRAME : LX_SILKIT_REFUSED,
        .time = event->timestamp,
        .id = frame->id,
        .flags = frame->flags,
        .dlc = frame->dlc,
    };
    (void)can;
    put_message(ctx, message, frame->data.data, fits ? frame->data.size : 0);
}

static void on_transmit(void *ctx, struct lx_sk_can *can, struct lx_sk_transmit_event *event)
{
    const struct lx_silkit_message message = {.kind = LX_SILKIT_LOST, .time = event->timestamp};
    (void)can;
    put_message(ctx, message, NULL, 0);
}

static void on_error(void *ctx, struct lx_sk_can *can, struct lx_sk_error_event *event)
{
    const struct lx_silkit_message message = {
        .kind = LX_SILKIT_STATE,
        .time = event->timestamp,
        .id = (uint32_t)event->state,
    };
    (void)can;
    put_message(ctx, message, NULL, 0);
}

static void on_data(void *ctx, struct lx_sk_subscriber *subscriber,
                    const struct lx_sk_data_event *event)
{
    struct lx_silkit_port *port = ctx;
    if (lx_silkit_is_left_behind()) {
        return;
    }
    const size_t n = event->data.size;
    const bool fits = n >= port->length_min && n <= port->length_max;
    const struct lx_silkit_message message = {
        .kind = fits ? LX_SILKIT_DATA : LX_SILKIT_REFUSED,
        .time = event->timestamp,
        .id = fits             ? 0
              : n < UINT32_MAX ? (uint32_t)n
                               : UINT32_MAX,
    };
    (void)subscriber;
    put_message(port, message, event->data.data, fits ? n : 0);
}

/* Each frame is a message by itself, as if it had come on a CAN network. */
static void on_pack(void *ctx, struct lx_sk_subscriber *subscriber,
                    const struct lx_sk_data_event *event)
{
    struct lx_silkit_message message = {.kind = LX_SILKIT_FRAME, .time = event->timestamp};
    const size_t n = event->data.size;
    struct dg_can_frame frame;
    size_t at = LX_SILKIT_PACK_HEAD;
    (void)subscriber;
    if (n > LX_SILKIT_PACK_MAX || !lx_silkit_pack_is_good(event->data.data, n)) {
        message.kind = LX_SILKIT_REFUSED;
        message.id = n < UINT32_MAX ? (uint32_t)n : UINT32_MAX;
        put_message(ctx, message, NULL, 0);
        return;
    }
    while (lx_silkit_pack_next(event->data.data, n, &at, &frame)) {
        message.id = frame.id;
        message.flags = frame.rtr ? LX_SK_FRAME_REMOTE : 0;
        message.dlc = frame.dlc;
        put_message(ctx, message, frame.data, frame.rtr ? 0 : frame.dlc);
    }
}

/* --- order --- */

static int compare_messages(const void *a, const void *b)
{
    const struct lx_silkit_message *one = a;
    const struct lx_silkit_message *other = b;
    if (one->time != other->time) {
        return one->time < other->time ? -1 : 1;
    }
    if (one->port != other->port) {
        return one->port->place < other->port->place ? -1 : 1;
    }
    if (one->id != other->id) {
        return one->id < other->id ? -1 : 1;
    }
    return one->order < other->order ? -1 : 1;
}

void lx_silkit_sort(struct lx_silkit_list *list)
{
    if (list->count - list->first > 1u) {
        qsort(list->at + list->first, list->count - list->first, sizeof *list->at,
              compare_messages);
    }
}

/* Of topics; frames of CAN FD and XL are nobody's fault. */
static void note_refused(struct lx_silkit_port *self, const struct lx_silkit_message *message)
{
    struct lx_words right = {"packed frames"};
    if (self->refused++ > 0 || self->can != NULL) {
        return;
    }
    if (!self->packed) {
        const bool one = self->length_min == self->length_max;
        (void)snprintf(right.text, sizeof right.text, "%s%zu", one ? "" : "at most ",
                       self->length_max);
    }
    lx_complain("SIL Kit: %s: a message of %lu bytes is ignored, and so are all others of a wrong "
                "length; expected %s",
                self->topic, (unsigned long)message->id, right.text);
}

void lx_silkit_deliver(const struct lx_silkit *self, struct lx_silkit_list *list, dg_ns now,
                       uint64_t end)
{
    const struct lx_silkit_message message = list->at[list->first++];
    const struct lx_silkit_message *next =
        list->first < list->count ? &list->at[list->first] : NULL;
    const bool last = next == NULL || next->port != message.port ||
                      (self->clock != NULL && next->time != message.time) || next->time >= end;
    struct lx_silkit_port *port = message.port;
    if (message.kind == LX_SILKIT_REFUSED) {
        note_refused(port, &message);
    }
    if (message.kind != LX_SILKIT_REFUSED || port->can != NULL || port->packed) {
        port->receive(port->ctx, now, &message, last);
    }
    free(message.bytes);
}

/* --- making --- */

void lx_silkit_name_topic(struct lx_silkit_port *port, const char *name, const char *last)
{
    (void)snprintf(port->topic, sizeof port->topic, "%s/%s", name, last);
}

/* @return false without memory */
static bool add_port(struct lx_silkit *self, struct lx_silkit_port *port)
{
    struct lx_silkit_port **list =
        reallocarray(self->port, self->count + 1u, sizeof(struct lx_silkit_port *));
    if (list == NULL) {
        return false;
    }
    self->port = list;
    port->all = self;
    port->place = self->count;
    list[self->count++] = port;
    return true;
}

/* A name that only the participant itself has to tell from its others. */
static const char *topic_name_of(const struct lx_silkit_port *port, char to[32])
{
    (void)snprintf(to, 32, "port%zu", port->place);
    return to;
}

static int make_can(struct lx_silkit_call *call, struct lx_error *error)
{
    const struct lx_silkit *self = call->all;
    char name[32];
    return self->lib.can_new(&call->can, self->participant, topic_name_of(call->port, name),
                             call->name) != 0
               ? lx_silkit_refused(self, call->name, error)
               : 0;
}

int lx_silkit_open_can(struct lx_silkit *self, struct lx_silkit_port *port, const char *network,
                       struct lx_error *error)
{
    struct lx_silkit_call call = {.make = make_can, .all = self, .port = port};
    uint64_t id = 0;
    if (!add_port(self, port)) {
        return lx_fail(error, "no memory for a bus");
    }
    (void)snprintf(call.name, sizeof call.name, "%s", network);
    if (lx_silkit_wait(&call, error) != 0) {
        return -1;
    }
    port->can = call.can;
    const struct lx_silkit_library *lib = &self->lib;
    if (lib->can_on_frame(port->can, port, on_frame, LX_SK_RECEIVED, &id) != 0 ||
        lib->can_on_transmit(port->can, port, on_transmit, LX_SK_NOT_TRANSMITTED, &id) != 0 ||
        lib->can_on_error(port->can, port, on_error, &id) != 0) {
        return lx_silkit_refused(self, network, error);
    }
    return 0;
}

static struct lx_sk_spec spec_of(const struct lx_silkit_call *call)
{
    return (struct lx_sk_spec){.header = {.version = LX_SK_DATA_SPEC},
                               .topic = call->port->topic,
                               .media_type = call->media_type};
}

static int make_subscriber(struct lx_silkit_call *call, struct lx_error *error)
{
    const struct lx_silkit *self = call->all;
    struct lx_sk_subscriber *subscriber = NULL;
    struct lx_sk_spec spec = spec_of(call);
    char name[32];
    return self->lib.subscriber_new(&subscriber, self->participant, topic_name_of(call->port, name),
                                    &spec, call->port, call->port->packed ? on_pack : on_data) != 0
               ? lx_silkit_refused(self, call->name, error)
               : 0;
}

static int make_publisher(struct lx_silkit_call *call, struct lx_error *error)
{
    const struct lx_silkit *self = call->all;
    struct lx_sk_spec spec = spec_of(call);
    char name[32];
    return self->lib.publisher_new(&call->publisher, self->participant,
                                   topic_name_of(call->port, name), &spec, 0) != 0
               ? lx_silkit_refused(self, call->name, error)
               : 0;
}

static int open_topic(struct lx_silkit_call *call, struct lx_error *error)
{
    if (!add_port(call->all, call->port)) {
        return lx_fail(error, "no memory for a topic");
    }
    memcpy(call->name, call->port->topic, sizeof call->name);
    return lx_silkit_wait(call, error);
}

int lx_silkit_subscribe(struct lx_silkit *self, struct lx_silkit_port *port, const char *media_type,
                        struct lx_error *error)
{
    struct lx_silkit_call call = {
        .make = make_subscriber, .all = self, .port = port, .media_type = media_type};
    return open_topic(&call, error);
}

int lx_silkit_offer(struct lx_silkit *self, struct lx_silkit_port *port, const char *media_type,
                    struct lx_error *error)
{
    struct lx_silkit_call call = {
        .make = make_publisher, .all = self, .port = port, .media_type = media_type};
    if (open_topic(&call, error) != 0) {
        return -1;
    }
    port->publisher = call.publisher;
    return 0;
}

/* --- sending --- */

/* The participant has left, and the rig is being taken down. */
static bool is_alone(const struct lx_silkit_port *port)
{
    return port->all == NULL || port->all->participant == NULL;
}

void lx_silkit_baud_rate(struct lx_silkit_port *port, uint32_t rate)
{
    if (!is_alone(port) && port->all->lib.can_baud_rate(port->can, rate, 0, 0) != 0) {
        lx_silkit_complain(port->all, "no such bit rate");
    }
}

void lx_silkit_publish(struct lx_silkit_port *port, const void *bytes, size_t n)
{
    const struct lx_sk_bytes data = {.data = bytes, .size = n};
    if (!is_alone(port) && port->all->lib.publish(port->publisher, &data) != 0) {
        lx_silkit_complain(port->all, "a topic cannot be published");
    }
}

void lx_silkit_send(struct lx_silkit_port *port, uint16_t id, bool remote, const uint8_t *bytes,
                    uint8_t n)
{
    struct lx_sk_frame frame = {
        .header = {.version = LX_SK_CAN_FRAME},
        .id = id,
        .flags = remote ? LX_SK_FRAME_REMOTE : 0,
        .dlc = n,
        .data = {.data = bytes, .size = remote ? 0 : n},
    };
    if (!is_alone(port) && port->all->lib.can_send(port->can, &frame, NULL) != 0) {
        lx_silkit_complain(port->all, "a frame cannot be sent");
    }
}

/* SPDX-License-Identifier: MIT */
/*
 * A CAN bus in UDP datagrams: a frame in each, identifier (high byte first), number of bytes, bytes.
 * The encoders answer whoever has spoken last.
 */
#define _GNU_SOURCE
#include "udp_can.h"

#include <errno.h>
#include <netdb.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "clock.h"
#include "endpoint.h"

#define HEAD 3u
#define FRAME_MAX (HEAD + 8u)

struct udp_can {
    struct lx_can can;
    int fd;
    sd_event_source *io;
    struct sockaddr_storage peer;
    socklen_t peer_size; /* 0: nobody has spoken yet */
};

static struct udp_can *udp_of(struct lx_can *can)
{
    return (struct udp_can *)can;
}

static bool send_datagram(struct lx_can *can, const struct dg_can_frame *frame)
{
    struct udp_can *self = udp_of(can);
    uint8_t bytes[FRAME_MAX] = {(uint8_t)(frame->id >> 8), (uint8_t)frame->id, frame->dlc};
    memcpy(bytes + HEAD, frame->data, frame->dlc);
    if (self->peer_size == 0 || sendto(self->fd, bytes, HEAD + frame->dlc, 0,
                                       (struct sockaddr *)&self->peer, self->peer_size) < 0) {
        can->counters.lost++;
    }
    return true;
}

static int take_datagram(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct udp_can *self = ctx;
    const struct lx_can_setup *setup = &self->can.setup;
    struct sockaddr_storage from;
    socklen_t from_size = sizeof from;
    uint8_t bytes[FRAME_MAX];
    (void)source;
    (void)events;
    const ssize_t n = recvfrom(fd, bytes, sizeof bytes, 0, (struct sockaddr *)&from, &from_size);
    if (n < (ssize_t)HEAD || bytes[0] > 7 || n != (ssize_t)HEAD + bytes[2]) {
        return 0;
    }
    struct dg_can_frame frame = {.id = (uint16_t)(bytes[0] << 8 | bytes[1]), .dlc = bytes[2]};
    memcpy(frame.data, bytes + HEAD, frame.dlc);
    self->peer = from;
    self->peer_size = from_size;
    setup->rx(setup->ctx, lx_now(), &frame);
    setup->settle(setup->ctx, lx_now());
    return 0;
}

static void pause_reading(struct lx_can *can, bool paused)
{
    (void)sd_event_source_set_enabled(udp_of(can)->io, paused ? SD_EVENT_OFF : SD_EVENT_ON);
}

/* Datagrams have no bit rate. */
static void expect(struct lx_can *can, uint16_t kbaud)
{
    (void)can;
    (void)kbaud;
}

static void close_udp(struct lx_can *can)
{
    struct udp_can *self = udp_of(can);
    (void)sd_event_source_disable_unref(self->io);
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
}

static const struct lx_can_ops udp_ops = {
    .write = send_datagram, .pause = pause_reading, .expect = expect, .close = close_udp};

static int start_udp(struct lx_can *can, struct lx_error *error)
{
    struct udp_can *self = udp_of(can);
    const struct addrinfo hints = {.ai_socktype = SOCK_DGRAM, .ai_flags = AI_PASSIVE};
    struct addrinfo *found = NULL;
    struct lx_host_port at;
    self->fd = -1;
    if (!lx_host_port_split(can->setup.where, &at) ||
        getaddrinfo(at.host, at.port, &hints, &found) != 0) {
        return lx_refuse(error, "expected HOST:PORT", "%s", "");
    }
    self->fd = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    int result = self->fd < 0 ? -1 : bind(self->fd, found->ai_addr, found->ai_addrlen);
    result = result < 0 ? -errno
                        : sd_event_add_io(can->setup.event, &self->io, self->fd, EPOLLIN,
                                          take_datagram, self);
    freeaddrinfo(found);
    if (result < 0) {
        return lx_fail(error, "cannot listen there: %s", strerror(-result));
    }
    lx_host_port_real(&at, self->fd);
    lx_host_port_print(&at, can->address, sizeof can->address);
    return 0;
}

static const struct lx_can_kind kind = {sizeof(struct udp_can), &udp_ops, start_udp, NULL};

struct lx_can *lx_udp_can_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    return lx_can_make(&kind, setup, error);
}

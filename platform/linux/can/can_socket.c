/* SPDX-License-Identifier: MIT */
/*
 * SocketCAN: one raw socket for all encoders on an interface. The kernel filters what nobody
 * listens to; what the controller reports comes as error frames; an interface that is down or gone
 * is waited for, and meanwhile frames are lost as on a bus that is not there.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "can.h"

/* Frames taken at once; between such pieces of a flood deadlines get their turn. */
#define BATCH 64u
/* How often an interface that has gone is looked for. */
#define REOPEN DG_S(1)
/* The kernel takes 512 filters and walks through them for each frame. */
#define FILTERS_MAX 500u
/* Frames lost in the socket are reported not more often than this: every report makes an encoder
   send, which must not be what overruns it again. */
#define OVERRUN_PAUSE DG_MS(100)
#define RECEIVE_BUFFER (1 << 20)

struct can_socket {
    struct lx_can can;
    int fd; /* -1 while the interface is down or gone */
    unsigned index;
    sd_event_source *io;
    struct lx_timer reopen;
    uint32_t bit_rate;   /* of the interface, see lx_can_link */
    bool passive;        /* so the controller has said last */
    dg_ns latest;        /* moment of the frame that came in last */
    uint32_t dropped;    /* frames the socket has lost, as the kernel counts */
    dg_ns overrun_until; /* no further report before */
    uint16_t told_kbaud; /* the user knows what this rate means here */
    struct can_filter filters[FILTERS_MAX];
    size_t filter_count;
};

static struct can_socket *socket_of(struct lx_can *can)
{
    return (struct can_socket *)can;
}

static dg_ns of_timespec(const struct timespec *time)
{
    return DG_S(time->tv_sec) + (dg_ns)time->tv_nsec;
}

/* --- the interface --- */

static void close_descriptor(struct can_socket *self)
{
    self->io = sd_event_source_disable_unref(self->io);
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
}

static void close_gone_socket(struct can_socket *self, int reason)
{
    close_descriptor(self);
    lx_complain("%s: %s; looking for it once a second", self->can.address,
                reason == ENETDOWN ? "the interface is down" : "the interface is gone");
    lx_timer_at(&self->reopen, dg_after(lx_now(), REOPEN));
}

/* Nothing is received until the first filter() says what. */
static int configure_socket(int fd)
{
    const int on = 1;
    const int size = RECEIVE_BUFFER;
    const can_err_mask_t errors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_ACK;
    (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &size, sizeof size); /* what it may have is fine */
    if (setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0) != 0 ||
        setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 ||
        setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0 ||
        setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) != 0) {
        return -errno;
    }
    return 0;
}

/* Bind to the interface by its name of today. @return 0 or a negative errno */
static int bind_to(struct can_socket *self)
{
    struct sockaddr_can address = {.can_family = AF_CAN};
    struct lx_can_link link;
    self->index = if_nametoindex(self->can.address);
    if (self->index == 0) {
        return -ENODEV;
    }
    address.can_ifindex = (int)self->index;
    if (bind(self->fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        return errno == ENODEV ? -EMEDIUMTYPE : -errno;
    }
    const int result = lx_can_link_read(self->index, &link);
    if (result < 0) {
        return result;
    }
    self->passive = false;
    self->bit_rate = link.bitrate;
    /* On a virtual bus nobody has to acknowledge. */
    self->can.company = link.is_virtual ? DG_BUS_SOMEBODY : DG_BUS_UNKNOWN;
    return link.up ? 0 : -ENETDOWN;
}

static int on_readable(sd_event_source *source, int fd, uint32_t events, void *ctx);

static int open_socket(struct can_socket *self)
{
    self->fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (self->fd < 0) {
        return -errno;
    }
    int result = configure_socket(self->fd);
    if (result == 0) {
        result = bind_to(self);
    }
    if (result == 0) {
        result =
            sd_event_add_io(self->can.setup.event, &self->io, self->fd, EPOLLIN, on_readable, self);
    }
    self->dropped = 0;
    return result < 0 ? result : 0;
}

static void apply_filters(const struct can_socket *self)
{
    const size_t size = self->filter_count * sizeof self->filters[0];
    if (self->fd >= 0 &&
        setsockopt(self->fd, SOL_CAN_RAW, CAN_RAW_FILTER, self->filters, (socklen_t)size) != 0) {
        lx_complain("%s: cannot set filters: %s", self->can.address, strerror(errno));
    }
}

static void look_for_it(void *ctx, dg_ns now)
{
    struct can_socket *self = ctx;
    if (open_socket(self) != 0) {
        close_descriptor(self);
        lx_timer_at(&self->reopen, dg_after(now, REOPEN));
        return;
    }
    lx_complain("%s: back", self->can.address);
    apply_filters(self);
    if (lx_can_is_paused(&self->can)) {
        (void)sd_event_source_set_enabled(self->io, SD_EVENT_OFF);
    }
    self->can.setup.settle(self->can.setup.ctx, now);
}

/* --- frames in --- */

/*
 * The moment a frame came in, on the monotonic clock. Its stamp is of the wall clock, which may
 * have been set meanwhile: whatever that gives, a frame came in after the one before it and before
 * now.
 */
static dg_ns moment(struct can_socket *self, const struct timespec *stamp)
{
    struct timespec wall;
    /* Before the monotonic one: what happens between the two makes a frame younger, never older. */
    const bool stamped = stamp != NULL && clock_gettime(CLOCK_REALTIME, &wall) == 0;
    const dg_ns now = lx_now();
    dg_ns at = now;
    if (stamped) {
        const dg_ns age = dg_elapsed(of_timespec(&wall), of_timespec(stamp));
        at = age < now ? now - age : 0;
    }
    self->latest = at > self->latest ? at : self->latest;
    return self->latest;
}

/*
 * Who does not get an acknowledgement has nobody there. The first one that comes lets the counter
 * of a passive controller fall, and with it its state; so does a restored one, and a frame of
 * somebody else says the same.
 */
static void take_company(struct can_socket *self, const struct can_frame *frame)
{
    const bool counts = (frame->can_id & CAN_ERR_CRTL) != 0;
    const uint8_t passive = CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE;
    const uint8_t warning = CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING;
    const bool fell = (frame->data[1] & CAN_ERR_CRTL_ACTIVE) != 0 ||
                      (self->passive && (frame->data[1] & warning) != 0);
    if ((frame->can_id & CAN_ERR_ACK) != 0) {
        self->can.company = DG_BUS_NOBODY;
    } else if (counts && fell) {
        self->can.company = DG_BUS_SOMEBODY;
    }
    if (counts && (frame->data[1] & (passive | warning | CAN_ERR_CRTL_ACTIVE)) != 0) {
        self->passive = (frame->data[1] & passive) != 0;
    }
}

/* What a controller's error frame means. */
static void take_error_frame(struct can_socket *self, dg_ns now, const struct can_frame *frame)
{
    /* In this order: a lost frame first, then the worst state. A controller whose counters fall
       below 128 says 'warning' first; that already is error active. */
    static const struct {
        uint32_t class_of;
        uint8_t status; /* any of these in data[1]; 0: the class says it all */
        enum dg_host_bus event;
    } rows[] = {
        {CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW, DG_HOST_BUS_OVERRUN},
        {CAN_ERR_BUSOFF, 0, DG_HOST_BUS_OFF},
        {CAN_ERR_RESTARTED, 0, DG_HOST_BUS_ACTIVE},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE, DG_HOST_BUS_PASSIVE},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_ACTIVE,
         DG_HOST_BUS_ACTIVE},
    };
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        if ((frame->can_id & rows[i].class_of) == 0 ||
            (rows[i].status != 0 && (frame->data[1] & rows[i].status) == 0)) {
            continue;
        }
        self->can.setup.bus(self->can.setup.ctx, now, rows[i].event);
        if (rows[i].event != DG_HOST_BUS_OVERRUN) {
            return;
        }
    }
}

static void take_frame(struct can_socket *self, dg_ns now, const struct can_frame *frame)
{
    struct dg_can_frame out = {.rtr = (frame->can_id & CAN_RTR_FLAG) != 0};
    if ((frame->can_id & CAN_ERR_FLAG) != 0) {
        take_company(self, frame);
        take_error_frame(self, now, frame);
        return;
    }
    self->can.company = DG_BUS_SOMEBODY;
    if ((frame->can_id & CAN_EFF_FLAG) != 0 || frame->can_dlc > sizeof out.data) {
        return;
    }
    out.id = (uint16_t)(frame->can_id & CAN_SFF_MASK);
    out.dlc = frame->can_dlc;
    memcpy(out.data, frame->data, sizeof out.data);
    self->can.setup.rx(self->can.setup.ctx, now, &out);
}

/* The socket's buffer was full: to the encoder that is its controller's overrun. */
static void take_dropped(struct can_socket *self, dg_ns now, uint32_t dropped)
{
    if (dropped == self->dropped || now < self->overrun_until) {
        return;
    }
    self->dropped = dropped;
    self->overrun_until = dg_after(now, OVERRUN_PAUSE);
    self->can.setup.bus(self->can.setup.ctx, now, DG_HOST_BUS_OVERRUN);
}

/* One frame with what the kernel says about it. @return 1, 0 when there is none, or -errno */
static int receive_frame(struct can_socket *self)
{
    struct can_frame frame;
    union {
        struct cmsghdr aligned;
        char bytes[CMSG_SPACE(sizeof(struct timespec)) + CMSG_SPACE(sizeof(uint32_t))];
    } control;
    struct iovec data = {&frame, sizeof frame};
    struct msghdr message = {.msg_iov = &data,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = sizeof control};
    struct timespec stamp;
    bool stamped = false;
    uint32_t dropped = self->dropped;
    const ssize_t n = recvmsg(self->fd, &message, 0);
    if (n < 0) {
        return errno == EAGAIN || errno == EINTR ? 0 : -errno;
    }
    for (struct cmsghdr *c = CMSG_FIRSTHDR(&message); c != NULL; c = CMSG_NXTHDR(&message, c)) {
        if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_TIMESTAMPNS) {
            memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
            stamped = true;
        } else if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SO_RXQ_OVFL) {
            memcpy(&dropped, CMSG_DATA(c), sizeof dropped);
        }
    }
    const dg_ns now = moment(self, stamped ? &stamp : NULL);
    take_dropped(self, now, dropped);
    if ((size_t)n == sizeof frame) { /* no CAN FD */
        take_frame(self, now, &frame);
    }
    return 1;
}

static int on_readable(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct can_socket *self = ctx;
    int result = 1;
    (void)source;
    (void)fd;
    (void)events;
    /* A frame can make an encoder send, which can stall the bus, or find it gone. */
    for (unsigned i = 0; i < BATCH && result > 0 && !lx_can_is_paused(&self->can) && self->fd >= 0;
         i++) {
        result = receive_frame(self);
    }
    if (result < 0 && self->fd >= 0) {
        close_gone_socket(self, -result);
    }
    self->can.setup.settle(self->can.setup.ctx, lx_now());
    return 0;
}

/* --- the operations --- */

static bool write_frame(struct lx_can *can, const struct dg_can_frame *frame)
{
    struct can_socket *self = socket_of(can);
    struct can_frame out = {.can_id = frame->id, .can_dlc = frame->dlc};
    ssize_t done = -1;
    if (self->fd < 0) {
        can->counters.lost++;
        return true;
    }
    out.can_id |= frame->rtr ? CAN_RTR_FLAG : 0u;
    memcpy(out.data, frame->data, sizeof out.data);
    do {
        done = send(self->fd, &out, sizeof out, 0);
    } while (done < 0 && errno == EINTR);
    if (done >= 0) {
        return true;
    }
    if (errno == ENOBUFS || errno == EAGAIN) {
        return false;
    }
    can->counters.lost++;
    close_gone_socket(self, errno);
    return true;
}

static void pause_reading(struct lx_can *can, bool paused)
{
    const struct can_socket *self = socket_of(can);
    if (self->io != NULL) {
        (void)sd_event_source_set_enabled(self->io, paused ? SD_EVENT_OFF : SD_EVENT_ON);
    }
}

static size_t all_filters(struct can_filter *filters)
{
    filters[0] = (struct can_filter){0, CAN_EFF_FLAG};
    return 1;
}

/* Data and remote frames of the CAN-IDs that somebody listens to; of too many, all 11-bit ones. */
static size_t wanted_filters(const struct dg_bus *bus, struct can_filter *filters)
{
    size_t n = 0;
    for (uint16_t id = 0; id <= CAN_SFF_MASK; id++) {
        if (!dg_bus_frames_listens(bus, id)) {
            continue;
        }
        if (n == FILTERS_MAX) {
            return all_filters(filters);
        }
        filters[n++] = (struct can_filter){id, CAN_EFF_FLAG | CAN_SFF_MASK};
    }
    return n;
}

static void filter(struct lx_can *can, const struct dg_bus *bus)
{
    struct can_socket *self = socket_of(can);
    struct can_filter wanted[FILTERS_MAX];
    const size_t n = bus == NULL ? all_filters(wanted) : wanted_filters(bus, wanted);
    const size_t size = n * sizeof wanted[0];
    if (n == self->filter_count && memcmp(wanted, self->filters, size) == 0) {
        return;
    }
    memcpy(self->filters, wanted, size);
    self->filter_count = n;
    apply_filters(self);
}

/* The rate of an interface is its administrator's business, so this can only be told. */
static void expect(struct lx_can *can, uint16_t kbaud)
{
    struct can_socket *self = socket_of(can);
    struct lx_can_link link;
    if (self->fd < 0 || kbaud == self->told_kbaud || lx_can_link_read(self->index, &link) != 0) {
        return;
    }
    if (link.is_virtual && self->told_kbaud == 0) {
        lx_note(can->setup.say, "%s: a virtual bus, bit rates mean nothing here", can->address);
    } else if (!link.is_virtual && link.bitrate != 0 && link.bitrate != 1000u * kbaud) {
        lx_note(can->setup.say,
                "%s: runs at %lu bit/s, the encoder at %u000; 'ip link set %s type can bitrate "
                "%u000' while it is down makes them agree",
                can->address, (unsigned long)link.bitrate, kbaud, can->address, kbaud);
    }
    self->told_kbaud = kbaud;
}

static uint32_t bit_rate(const struct lx_can *can)
{
    return ((const struct can_socket *)can)->bit_rate;
}

/* The kernel counts what its filters keep back, too. It does not tell identifiers apart: 29-bit
   ones count like the others. */
static uint64_t bits(const struct lx_can *can)
{
    struct lx_can_link link = {.frames = 0};
    (void)lx_can_link_read(((const struct can_socket *)can)->index, &link);
    return DG_CAN_BITS(link.frames, link.bytes);
}

static bool up(const struct lx_can *can)
{
    return ((const struct can_socket *)can)->fd >= 0;
}

static void close_socket(struct lx_can *can)
{
    struct can_socket *self = socket_of(can);
    close_descriptor(self);
    lx_timer_close(&self->reopen);
}

static const struct lx_can_ops socket_ops = {
    .write = write_frame,
    .pause = pause_reading,
    .filter = filter,
    .expect = expect,
    .bit_rate = bit_rate,
    .bits = bits,
    .up = up,
    .close = close_socket,
};

bool lx_can_in_kernel(void)
{
    const int fd = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
    if (fd < 0) {
        return false;
    }
    (void)close(fd);
    return true;
}

static int explain_failure(int reason, const char *where, struct lx_error *error)
{
    struct lx_words right = {""};
    switch (reason) {
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
        return lx_refuse(error, "slcan works without", "this kernel has no CAN");
    case ENODEV:
        return lx_refuse(error, "expected a CAN interface that 'ip link' shows",
                         "no such interface");
    case EMEDIUMTYPE:
        return lx_refuse(error, "expected a CAN interface such as can0", "not a CAN interface");
    case ENETDOWN:
        lx_words_add(&right, "run 'ip link set %s up'", where);
        return lx_refuse(error, right.text, "the interface is down");
    default:
        return lx_refuse(error, lx_more_of(reason), "cannot use it: %s", strerror(reason));
    }
}

static int start_socket(struct lx_can *can, struct lx_error *error)
{
    struct can_socket *self = socket_of(can);
    const char *where = can->setup.where;
    self->fd = -1;
    if (strlen(where) >= IFNAMSIZ) {
        return explain_failure(ENODEV, where, error);
    }
    (void)snprintf(can->address, sizeof can->address, "%s", where);
    int result = lx_timer_open(&self->reopen, can->setup.event, look_for_it, self);
    if (result >= 0) {
        result = open_socket(self);
    }
    return result < 0 ? explain_failure(-result, where, error) : 0;
}

static const struct lx_can_kind kind = {sizeof(struct can_socket), &socket_ops, start_socket, NULL};

struct lx_can *lx_can_socket_open(const struct lx_can_setup *setup, struct lx_error *error)
{
    return lx_can_make(&kind, setup, error);
}

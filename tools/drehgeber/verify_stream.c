/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "verify_stream.h"

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "endpoint.h"
#include "timer.h"
#include "tty_open.h"
#include "verify_silkit.h"

/* How long a wire may take what is sent. */
#define SEND_LIMIT_MS 1000
/* Bytes that are sent at once to a port behind telnet. */
#define PIECE_MAX 128u
/* Pieces without data that are read before nothing has come. */
#define PIECES_MAX 100u

/* Telnet (RFC 854), and its COM port option (RFC 2217). */
enum { SE = 240, SB = 250, WILL, WONT, DO, DONT, IAC };
enum { BINARY = 0, COM_PORT = 44 };
enum { SET_BAUDRATE = 1, SET_DATASIZE, SET_PARITY, SET_STOPSIZE };
enum { DATA, COMMAND, OPTION, SUB, SUB_COMMAND };

/* Eight bits both ways, and the setting of the port; no byte of it is FFh. */
static int tell_setting(struct verify_stream *self, const struct lx_uart *uart)
{
    const uint8_t text[] = {
        /* clang-format off */
        IAC, WILL, BINARY, IAC, DO, BINARY, IAC, WILL, COM_PORT,
        IAC, SB, COM_PORT, SET_BAUDRATE, (uint8_t)(uart->baud >> 24), (uint8_t)(uart->baud >> 16),
                                         (uint8_t)(uart->baud >> 8), (uint8_t)uart->baud, IAC, SE,
        IAC, SB, COM_PORT, SET_DATASIZE, 8, IAC, SE,
        IAC, SB, COM_PORT, SET_PARITY, uart->parity == 'E' ? 3 : 1, IAC, SE,
        IAC, SB, COM_PORT, SET_STOPSIZE, 1, IAC, SE,
        /* clang-format on */
    };
    const bool telnet = self->telnet;
    self->telnet = false; /* none of it is data */
    const int result = verify_stream_send(self, text, sizeof text);
    self->telnet = telnet;
    return result;
}

int verify_stream_open(struct verify_stream *self, const char *where, const struct lx_uart *uart,
                       struct lx_error *error)
{
    static const char serial[] = "rfc2217:";
    static const int yes = 1;
    char address[300];
    *self = (struct verify_stream){.fd = -1};
    self->telnet = strncmp(where, serial, sizeof serial - 1u) == 0;
    if (!self->telnet && strncmp(where, "tcp:", 4) != 0) {
        self->fd = tty_open(where, uart);
        return self->fd >= 0 ? 0 : lx_fail(error, "%s: %s", where, strerror(errno));
    }
    self->network = true;
    (void)snprintf(address, sizeof address, "tcp:%s", strchr(where, ':') + 1);
    self->fd = lx_endpoint_connect(address, error);
    if (self->fd < 0) {
        return -1;
    }
    (void)fcntl(self->fd, F_SETFL, O_NONBLOCK);
    (void)setsockopt(self->fd, IPPROTO_TCP, TCP_NODELAY, &yes,
                     sizeof yes); /* requests are short, and timed */
    return !self->telnet || tell_setting(self, uart) == 0
               ? 0
               : lx_fail(error, "%s: the port accepts no data", where);
}

int verify_stream_join(struct verify_stream *self, const struct options *options,
                       struct lx_error *error)
{
    *self = (struct verify_stream){.fd = -1, .network = true};
    self->silkit = verify_silkit_open(options, error);
    return self->silkit != NULL ? 0 : -1;
}

bool verify_stream_explain(const struct verify_stream *self, struct lx_error *error)
{
    return self->silkit != NULL && verify_silkit_explain(self->silkit, error);
}

static bool wait_for(int fd, short events, int limit_ms)
{
    struct pollfd ready = {.fd = fd, .events = events};
    int result;
    do {
        result = poll(&ready, 1, limit_ms);
    } while (result < 0 && errno == EINTR);
    return result > 0;
}

/* Nobody at the other end of a network is an error, not the end of the command. */
static ssize_t send_some(int fd, const char *from, size_t n)
{
    const ssize_t sent = send(fd, from, n, MSG_NOSIGNAL);
    return sent < 0 && errno == ENOTSOCK ? write(fd, from, n) : sent;
}

static int send_all(int fd, const char *from, size_t n)
{
    while (n > 0) {
        const ssize_t sent = send_some(fd, from, n);
        if (sent > 0) {
            from += sent;
            n -= (size_t)sent;
        } else if (errno != EAGAIN || !wait_for(fd, POLLOUT, SEND_LIMIT_MS)) {
            return -1;
        }
    }
    return 0;
}

int verify_stream_send(struct verify_stream *self, const void *bytes, size_t n)
{
    const uint8_t *from = bytes;
    char doubled[2 * PIECE_MAX];
    if (self->silkit != NULL) {
        return verify_silkit_send(self->silkit, bytes, n);
    }
    int result = self->telnet ? 0 : send_all(self->fd, bytes, n);
    while (self->telnet && result == 0 && n > 0) {
        size_t length = 0;
        for (size_t i = 0; i < PIECE_MAX && n > 0; i++, from++, n--) {
            doubled[length++] = (char)*from;
            if (*from == IAC) {
                doubled[length++] = (char)*from;
            }
        }
        result = send_all(self->fd, doubled, length);
    }
    return result;
}

/* The port does eight bits and the COM port option; what else it wants or offers is declined. */
static void decline_option(struct verify_stream *self, uint8_t option)
{
    const char answer[] = {(char)IAC, (char)(self->verb == DO ? WONT : DONT), (char)option};
    if ((self->verb == DO || self->verb == WILL) && option != BINARY && option != COM_PORT) {
        (void)send_all(self->fd, answer, sizeof answer);
    }
}

/* @return whether the byte is data */
static bool feed_telnet(struct verify_stream *self, uint8_t byte)
{
    switch (self->state) {
    case DATA:
        self->state = byte == IAC ? COMMAND : DATA;
        return byte != IAC;
    case COMMAND:
        self->verb = byte;
        self->state = byte == SB ? SUB : byte >= WILL && byte <= DONT ? OPTION : DATA;
        return byte == IAC;
    case OPTION:
        decline_option(self, byte);
        self->state = DATA;
        return false;
    case SUB:
        self->state = byte == IAC ? SUB_COMMAND : SUB;
        return false;
    default: /* SUB_COMMAND */
        self->state = byte == SE ? DATA : SUB;
        return false;
    }
}

/* @return how many of the bytes are data, which are the first ones then */
static long strip_telnet(struct verify_stream *self, uint8_t *bytes, long n)
{
    long kept = 0;
    for (long i = 0; i < n; i++) {
        if (feed_telnet(self, bytes[i])) {
            bytes[kept++] = bytes[i];
        }
    }
    return kept;
}

static long receive_some(int fd, dg_ns until, void *to, size_t size)
{
    const dg_ns now = lx_real_now();
    const dg_ns left = until > now ? until - now : 0;
    const struct timespec limit = {
        .tv_sec = (time_t)(left / DG_S(1)),
        .tv_nsec = (long)(left % DG_S(1)),
    };
    struct pollfd ready = {.fd = fd, .events = POLLIN};
    if (ppoll(&ready, 1, &limit, NULL) <= 0) {
        return 0;
    }
    const ssize_t n = read(fd, to, size);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return 0;
    }
    return n > 0 ? n : -1;
}

long verify_stream_receive(struct verify_stream *self, dg_ns until, void *to, size_t size)
{
    if (self->silkit != NULL) {
        return verify_silkit_receive(self->silkit, until, to, size);
    }
    long n = receive_some(self->fd, until, to, size);
    if (!self->telnet || n <= 0) {
        return n;
    }
    n = strip_telnet(self, to, n);
    /* What was no data has not been awaited. */
    for (unsigned i = 0; n == 0 && i < PIECES_MAX && lx_real_now() < until; i++) {
        n = receive_some(self->fd, until, to, size);
        n = n > 0 ? strip_telnet(self, to, n) : n;
    }
    return n;
}

void verify_stream_close(struct verify_stream *self)
{
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
    verify_silkit_close(self->silkit);
    self->silkit = NULL;
}

void verify_stream_wait(struct verify_stream *self, dg_ns until)
{
    if (self != NULL && self->silkit != NULL) {
        verify_silkit_wait(self->silkit, until);
    } else {
        verify_stream_sleep(until);
    }
}

void verify_stream_sleep(dg_ns until)
{
    const dg_ns now = lx_real_now();
    const dg_ns left = until > now ? until - now : 0;
    const struct timespec span = {(time_t)(left / DG_S(1)), (long)(left % DG_S(1))};
    (void)nanosleep(&span, NULL);
}

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "verify_stream.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "endpoint.h"
#include "timer.h"
#include "tty_open.h"

/* How long a wire may take what is sent. */
#define SEND_LIMIT_MS 1000

int verify_stream_open(const char *where, const struct lx_uart *uart, struct lx_error *error)
{
    if (strncmp(where, "tcp:", 4) == 0) {
        const int fd = lx_endpoint_connect(where, error);
        if (fd >= 0) {
            (void)fcntl(fd, F_SETFL, O_NONBLOCK);
        }
        return fd;
    }
    const int fd = tty_open(where, uart);
    return fd >= 0 ? fd : lx_fail(error, "%s: %s", where, strerror(errno));
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

int verify_stream_send(int fd, const void *bytes, size_t n)
{
    const char *from = bytes;
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

long verify_stream_receive(int fd, dg_ns until, void *to, size_t size)
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

void verify_stream_sleep(dg_ns until)
{
    const dg_ns now = lx_real_now();
    const dg_ns left = until > now ? until - now : 0;
    const struct timespec span = {(time_t)(left / DG_S(1)), (long)(left % DG_S(1))};
    (void)nanosleep(&span, NULL);
}

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "endpoint.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "drehgeber/api.h"
#include "drehgeber/figure.h"
#include "unix_listen.h"

/* Connections are accepted up to so often in a time. */
#define CALM_US 100000u
#define CALM_ACCEPTS 100u
#define UNIX_PREFIX "unix:"
#define TCP_PREFIX "tcp:"
#define BACKLOG 16
/* A TCP client whose machine is gone is noticed after a minute of silence and three questions. */
#define KEEP_IDLE_S 60
#define KEEP_INTERVAL_S 10
#define KEEP_QUESTIONS 3

/* What is behind the prefix, or NULL. */
static const char *skip_prefix(const char *where, const char *prefix)
{
    const size_t n = strlen(prefix);
    return strncmp(where, prefix, n) == 0 && where[n] != '\0' ? where + n : NULL;
}

bool lx_host_port_split(const char *text, struct lx_host_port *out)
{
    const char *colon = strrchr(text, ':');
    size_t n = colon == NULL ? 0 : (size_t)(colon - text);
    uint64_t port = 0;
    if (n == 0 || n >= sizeof out->host || strlen(colon + 1) >= sizeof out->port ||
        colon[1 + strspn(colon + 1, "0123456789")] != '\0' ||
        !dg_unsigned_parse(colon + 1, &port) || port > UINT16_MAX) {
        return false;
    }
    if (text[0] == '[' && text[n - 1] == ']') {
        text++;
        n -= 2;
    }
    memcpy(out->host, text, n);
    out->host[n] = '\0';
    (void)snprintf(out->port, sizeof out->port, "%lu", (unsigned long)port);
    return n > 0;
}

void lx_host_port_print(const struct lx_host_port *self, char *to, size_t size)
{
    const bool six = strchr(self->host, ':') != NULL;
    (void)snprintf(to, size, six ? "[%s]:%s" : "%s:%s", self->host, self->port);
}

/* unix:PATH; or, with `path` NULL, tcp:HOST:PORT. */
static int split_endpoint(const char *where, const char **path, struct lx_host_port *tcp,
                          struct lx_error *error)
{
    const char *host = skip_prefix(where, TCP_PREFIX);
    *path = skip_prefix(where, UNIX_PREFIX);
    if (*path != NULL && strlen(*path) >= LX_UNIX_PATH_SIZE) {
        return lx_fail(error, "%s: expected a path of at most %lu characters", where,
                       (unsigned long)LX_UNIX_PATH_SIZE - 1);
    }
    if (*path != NULL || (host != NULL && lx_host_port_split(host, tcp))) {
        return 0;
    }
    return lx_fail(error, "%s: expected unix:PATH or tcp:HOST:PORT", where);
}

/* A socket for the first of the host's addresses that `use` succeeds with. */
static int open_tcp(const struct lx_host_port *tcp, int flags, int type,
                    int (*use)(int fd, const struct sockaddr *address, socklen_t size))
{
    const struct addrinfo hints = {
        .ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM, .ai_flags = flags};
    struct addrinfo *list = NULL;
    int fd = -1;
    if (getaddrinfo(tcp->host, tcp->port, &hints, &list) != 0) {
        errno = EADDRNOTAVAIL;
        return -1;
    }
    for (const struct addrinfo *at = list; at != NULL && fd < 0; at = at->ai_next) {
        fd = socket(at->ai_family, type, at->ai_protocol);
        if (fd >= 0 && use(fd, at->ai_addr, at->ai_addrlen) != 0) {
            const int reason = errno;
            (void)close(fd);
            errno = reason;
            fd = -1;
        }
    }
    freeaddrinfo(list);
    return fd;
}

/* 127.0.0.0/8 and ::1. */
static bool is_loopback(const struct sockaddr *address)
{
    if (address->sa_family == AF_INET6) {
        const struct in6_addr *six =
            &((const struct sockaddr_in6 *)(const void *)address)->sin6_addr;
        return IN6_IS_ADDR_LOOPBACK(six);
    }
    const struct sockaddr_in *four = (const struct sockaddr_in *)(const void *)address;
    return address->sa_family == AF_UNIX ||
           (address->sa_family == AF_INET &&
            ntohl(four->sin_addr.s_addr) >> IN_CLASSA_NSHIFT == IN_LOOPBACKNET);
}

bool lx_endpoint_is_loopback(int fd)
{
    struct sockaddr_storage bound = {.ss_family = AF_UNSPEC};
    socklen_t size = sizeof bound;
    return getsockname(fd, (struct sockaddr *)&bound, &size) == 0 &&
           is_loopback((const struct sockaddr *)&bound);
}

static int bind_and_listen(int fd, const struct sockaddr *address, socklen_t size)
{
    const int on = 1;
    (void)setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    return bind(fd, address, size) != 0 ? -1 : listen(fd, BACKLOG);
}

static int bind_loopback(int fd, const struct sockaddr *address, socklen_t size)
{
    if (!is_loopback(address)) {
        errno = EPERM;
        return -1;
    }
    return bind_and_listen(fd, address, size);
}

int lx_tcp_listen(const struct lx_host_port *where, enum lx_endpoint_reach reach)
{
    return open_tcp(where, AI_PASSIVE, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK,
                    reach == LX_ENDPOINT_ANY ? bind_and_listen : bind_loopback);
}

void lx_endpoint_keep_alive(int fd)
{
    const int rows[][3] = {
        {SOL_SOCKET, SO_KEEPALIVE, 1},
        {IPPROTO_TCP, TCP_KEEPIDLE, KEEP_IDLE_S},
        {IPPROTO_TCP, TCP_KEEPINTVL, KEEP_INTERVAL_S},
        {IPPROTO_TCP, TCP_KEEPCNT, KEEP_QUESTIONS},
    };
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        (void)setsockopt(fd, rows[i][0], rows[i][1], &rows[i][2], sizeof rows[i][2]);
    }
}

void lx_host_port_real(struct lx_host_port *self, int fd)
{
    struct sockaddr_storage bound;
    socklen_t size = sizeof bound;
    if (getsockname(fd, (struct sockaddr *)&bound, &size) == 0) {
        (void)getnameinfo((struct sockaddr *)&bound, size, NULL, 0, self->port, sizeof self->port,
                          NI_NUMERICSERV);
    }
}

const char *lx_port_right(int reason)
{
    return reason == EACCES ? "expected a port from 1024 on, or the privilege CAP_NET_BIND_SERVICE"
                            : lx_more_of(reason);
}

static int refuse_listening(const char *where, int reason, struct lx_error *error)
{
    return reason == EPERM ? lx_fail(error,
                                     "%s: beyond loopback, where anybody could control it; use "
                                     "%s,open if you want that",
                                     where, where)
                           : lx_refuse(error, lx_port_right(reason), "%s: cannot listen there: %s",
                                       where, strerror(reason));
}

int lx_endpoint_listen(const char *where, enum lx_endpoint_reach reach, char *address, size_t size,
                       struct lx_error *error)
{
    struct lx_host_port tcp;
    const char *path = NULL;
    if (split_endpoint(where, &path, &tcp, error) != 0) {
        return -1;
    }
    if (path != NULL) {
        (void)snprintf(address, size, "%s", where);
        return lx_unix_listen(path, error);
    }
    const int fd = lx_tcp_listen(&tcp, reach);
    if (fd < 0) {
        return refuse_listening(where, errno, error);
    }
    lx_host_port_real(&tcp, fd);
    const int host = (int)(strrchr(where, ':') - where);
    (void)snprintf(address, size, "%.*s:%s", host, where, tcp.port);
    return fd;
}

int lx_endpoint_watch(int listener, sd_event *event, sd_event_source **io,
                      sd_event_io_handler_t connected, void *ctx)
{
    const int result = sd_event_add_io(event, io, listener, EPOLLIN, connected, ctx);
    return result < 0 ? result : sd_event_source_set_ratelimit(*io, CALM_US, CALM_ACCEPTS);
}

static int connect_unix(const char *path)
{
    const struct sockaddr_un address = lx_unix_address(path);
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        const int reason = errno;
        (void)close(fd);
        errno = reason;
        return -1;
    }
    return fd;
}

int lx_endpoint_connect(const char *where, struct lx_error *error)
{
    struct lx_host_port tcp;
    const char *path = NULL;
    if (split_endpoint(where, &path, &tcp, error) != 0) {
        return -1;
    }
    const int fd =
        path != NULL ? connect_unix(path) : open_tcp(&tcp, 0, SOCK_STREAM | SOCK_CLOEXEC, connect);
    return fd >= 0 ? fd
                   : lx_fail(error, "%s: no connection: %s; is a drehgeber running there?", where,
                             strerror(errno));
}

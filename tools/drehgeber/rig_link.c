/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "rig_link.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/un.h>
#include <unistd.h>

#define UNIX_PREFIX "unix:"

/* The kernel knows where the first connection led to, so that no name has to be looked up again. A
   socket file is known there by the path that its server used, which may start elsewhere. */
static int remember_peer(struct rig_link *self, const char *where)
{
    struct sockaddr_un *file = (struct sockaddr_un *)&self->peer;
    self->peer_size = sizeof self->peer;
    if (strncmp(where, UNIX_PREFIX, strlen(UNIX_PREFIX)) != 0) {
        return getpeername(self->fd, (struct sockaddr *)&self->peer, &self->peer_size);
    }
    file->sun_family = AF_UNIX; /* it fits, as it has led there */
    const size_t n = strnlen(where + strlen(UNIX_PREFIX), sizeof file->sun_path - 1u);
    memcpy(file->sun_path, where + strlen(UNIX_PREFIX), n);
    file->sun_path[n] = '\0';
    self->peer_size = sizeof *file;
    return 0;
}

static void greet_rig(struct rig_link *self)
{
    self->output_length = strlen(self->greeting);
    memcpy(self->output, self->greeting, self->output_length);
}

int rig_link_open(struct rig_link *self, const char *where, struct lx_error *error)
{
    struct lx_access access;
    if (lx_access_parse(where, &access, error) != 0) {
        return -1;
    }
    self->fd = lx_access_connect(where, self->greeting, error);
    if (self->fd < 0) {
        return -1;
    }
    greet_rig(self);
    if (remember_peer(self, access.where) != 0 || fcntl(self->fd, F_SETFL, O_NONBLOCK) != 0) {
        (void)lx_fail(error, "%s: the connection broke: %s", where, strerror(errno));
        rig_link_close(self);
        return -1;
    }
    return 0;
}

int rig_link_again(struct rig_link *self)
{
    rig_link_close(self);
    self->fd = socket(self->peer.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (self->fd < 0) {
        return -errno;
    }
    if (connect(self->fd, (const struct sockaddr *)&self->peer, self->peer_size) != 0 &&
        errno != EINPROGRESS) {
        const int reason = errno;
        rig_link_close(self);
        return -reason;
    }
    greet_rig(self);
    return 0;
}

bool rig_link_say(struct rig_link *self, const char *line)
{
    const size_t n = strlen(line);
    if (self->fd < 0 || n + 1 > sizeof self->output - self->output_length) {
        return false;
    }
    memcpy(self->output + self->output_length, line, n);
    self->output_length += n;
    self->output[self->output_length++] = '\n';
    return true;
}

uint32_t rig_link_events(const struct rig_link *self)
{
    return self->output_length > 0 ? EPOLLIN | EPOLLOUT : EPOLLIN;
}

/* Not possible now, but later: also while the connection is being made. */
static bool later(int reason)
{
    return reason == EAGAIN || reason == EINTR;
}

static int send_some(struct rig_link *self)
{
    const ssize_t n =
        send(self->fd, self->output, self->output_length, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0) {
        return later(errno) ? 0 : -errno;
    }
    self->output_length -= (size_t)n;
    memmove(self->output, self->output + n, self->output_length);
    return 0;
}

/* Room for more. @return 0 or a negative errno */
static int make_room(struct rig_link *self)
{
    if (self->input_length < self->input_size) {
        return 0;
    }
    const size_t size = self->input_size == 0 ? RIG_INPUT_FIRST : 2 * self->input_size;
    char *input = size > RIG_INPUT_MAX ? NULL : realloc(self->input, size);
    if (input == NULL) {
        return -EMSGSIZE;
    }
    self->input = input;
    self->input_size = size;
    return 0;
}

static int receive_some(struct rig_link *self)
{
    self->input_length -= self->taken;
    if (self->taken > 0) {
        memmove(self->input, self->input + self->taken, self->input_length);
    }
    self->taken = 0;
    const int result = make_room(self);
    if (result != 0) {
        return result;
    }
    const ssize_t n = recv(self->fd, self->input + self->input_length,
                           self->input_size - self->input_length, MSG_DONTWAIT);
    if (n < 0) {
        return later(errno) ? 0 : -errno;
    }
    self->input_length += (size_t)n;
    return n == 0 ? -ECONNRESET : 0;
}

int rig_link_serve(struct rig_link *self)
{
    const int result = self->output_length > 0 ? send_some(self) : 0;
    return result == 0 ? receive_some(self) : result;
}

char *rig_link_line(struct rig_link *self)
{
    if (self->input_length == self->taken) {
        return NULL;
    }
    char *line = self->input + self->taken;
    char *end = memchr(line, '\n', self->input_length - self->taken);
    if (end == NULL) {
        return NULL;
    }
    *end = '\0';
    self->taken = (size_t)(end + 1 - self->input);
    return line;
}

void rig_link_close(struct rig_link *self)
{
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
    self->taken = 0;
    self->input_length = 0;
    self->output_length = 0;
}

void rig_link_end(struct rig_link *self)
{
    rig_link_close(self);
    free(self->input);
    self->input = NULL;
    self->input_size = 0;
}

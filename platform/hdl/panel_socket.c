/* SPDX-License-Identifier: MIT */
/*
 * The panel on a socket, in the simulator's time: lines come in, answers go out, and neither ever
 * blocks. The panel has one session, which is the test bench's own, too: one client at a time has
 * it, the next one waits, and finds it empty.
 *
 *   accept --> *CLS --> line, answer, line, answer ... --> end of the stream, all is answered --\
 *      ^-----------------------------------------------------------------------------------------/
 */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "hdl_private.h"
#include "unix_listen.h"

#define PREFIX "unix:"
#define POLL_NS INT64_C(1000000)
#define INPUT_MAX 1024u /* a line of SCPI is 512 at most */
#define OUTPUT_MAX 65536u

struct hdl_control {
    int listener;
    int client; /* -1: nobody */
    int64_t polled;
    bool begun; /* what others have left in the session is gone */
    bool ended; /* the client sends no more */
    size_t input_length;
    size_t output_length;
    const char *path; /* of the settings */
    char input[INPUT_MAX];
    char output[OUTPUT_MAX]; /* and the LF behind it */
};

int hdl_control_open(struct dg_hdl *self)
{
    const char *where = self->settings.control;
    const char *path = where + strlen(PREFIX);
    struct lx_error error = {.what = ""};

    if (where[0] == '\0') {
        return DG_HOST_OK;
    }
    if (strncmp(where, PREFIX, strlen(PREFIX)) != 0 || path[0] == '\0' ||
        strlen(path) >= LX_UNIX_PATH_SIZE) {
        return hdl_fail(self, DG_HOST_ERR_ARGUMENT, "control=%s: expected unix:PATH", where);
    }
    self->control = calloc(1, sizeof *self->control);
    if (self->control == NULL) {
        return hdl_fail(self, DG_HOST_ERR_SPACE, "no memory for a control socket");
    }
    self->control->client = -1;
    self->control->path = path;
    self->control->listener = lx_unix_listen(path, &error);
    return self->control->listener >= 0
               ? DG_HOST_OK
               : hdl_fail(self, DG_HOST_ERR_IO, "%s", lx_error_line(&error).text);
}

static void drop_client(struct hdl_control *self)
{
    (void)close(self->client);
    self->client = -1;
}

void hdl_control_close(struct hdl_control *self)
{
    if (self == NULL) {
        return;
    }
    if (self->client >= 0) {
        drop_client(self);
    }
    if (self->listener >= 0) {
        (void)close(self->listener);
        (void)unlink(self->path);
    }
    free(self);
}

static void accept_client(struct hdl_control *self)
{
    self->client = accept4(self->listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    self->begun = false;
    self->ended = false;
    self->input_length = 0;
    self->output_length = 0;
}

/* A line for the session. @return false: an earlier command still waits, and has not answered */
static bool execute_line(struct dg_hdl *hdl, const char *line)
{
    struct hdl_control *self = hdl->control;
    const uint64_t now = (uint64_t)(hdl->now / HDL_PS_PER_NS);
    const int n = dg_host_scpi(hdl->panel, now, line, self->output, OUTPUT_MAX - 1u);

    hdl_look(hdl);
    self->output_length = strlen(self->output);
    if (self->output_length > 0) {
        self->output[self->output_length++] = '\n';
    }
    return n >= 0 || self->output_length > 0;
}

/* What was answered goes first. @return whether all of it has gone */
static bool send_all(struct hdl_control *self)
{
    if (self->output_length == 0) {
        return true;
    }
    const ssize_t n =
        send(self->client, self->output, self->output_length, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0 && errno != EAGAIN && errno != EINTR) {
        drop_client(self);
        return false;
    }
    self->output_length -= n > 0 ? (size_t)n : 0;
    memmove(self->output, self->output + (n > 0 ? n : 0), self->output_length);
    return self->output_length == 0;
}

/* Without a line a command that waited may answer. @return whether something was done */
static bool take_session_line(struct dg_hdl *hdl)
{
    struct hdl_control *self = hdl->control;
    char *end = memchr(self->input, '\n', self->input_length);

    if (end == NULL) {
        (void)execute_line(hdl, "");
        return self->output_length > 0;
    }
    const size_t n = (size_t)(end + 1 - self->input);
    *end = '\0';
    if (!execute_line(hdl, self->input)) {
        *end = '\n';
        return false;
    }
    self->input_length -= n;
    memmove(self->input, end + 1, self->input_length);
    return true;
}

static void receive_input(struct hdl_control *self)
{
    const size_t room = INPUT_MAX - self->input_length;
    const ssize_t n = recv(self->client, self->input + self->input_length, room, MSG_DONTWAIT);

    /* CR ends a line, too: each is a call of its own. */
    for (ssize_t i = 0; i < n; i++) {
        char *byte = &self->input[self->input_length + (size_t)i];
        if (*byte == '\r') {
            *byte = '\n';
        }
    }
    if (n > 0) {
        self->input_length += (size_t)n;
    } else if (n == 0) {
        self->ended = room > 0;
    } else if (errno != EAGAIN && errno != EINTR) {
        self->ended = true;
    }
}

/* A line that does not fit is none of SCPI's. */
static bool is_over(const struct hdl_control *self)
{
    const bool line = memchr(self->input, '\n', self->input_length) != NULL;

    return !line && (self->ended || self->input_length == INPUT_MAX);
}

static void serve_client(struct dg_hdl *hdl)
{
    struct hdl_control *self = hdl->control;

    if (!self->begun) {
        self->begun = execute_line(hdl, "*CLS");
        self->output_length = 0;
    }
    receive_input(self);
    while (self->begun && send_all(self) && take_session_line(hdl)) {
    }
    if (self->client >= 0 && self->begun && self->output_length == 0 && is_over(self) &&
        execute_line(hdl, "*CLS") && send_all(self)) {
        drop_client(self);
    }
}

void hdl_control_poll(struct dg_hdl *self)
{
    struct hdl_control *control = self->control;
    struct timespec clock;

    (void)clock_gettime(CLOCK_MONOTONIC, &clock);
    const int64_t now = (int64_t)clock.tv_sec * INT64_C(1000000000) + clock.tv_nsec;
    if (now - control->polled < POLL_NS) {
        return;
    }
    control->polled = now;
    if (control->client < 0) {
        accept_client(control);
    }
    if (control->client >= 0) {
        serve_client(self);
    }
}

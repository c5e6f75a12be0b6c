/* SPDX-License-Identifier: MIT */
/*
 * Everything is sent, then the question for errors, then the end of the stream. The other side
 * answers all of it before it closes, so the last line that comes in is the list of errors and all
 * others are answers: no guessing which command has one, no time limit. A serial line has no end:
 * there the question begins with another one, whose answer nobody else gets.
 */
#define _GNU_SOURCE
#include "ctl.h"

#include <dirent.h>
#include <errno.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "access.h"
#include "endpoint.h"
#include "run.h"
#include "server.h"

#define CHUNK 4096u
#define ERRORS "\nSYSTem:ERRor:ALL?\n"
#define MARKED_ERRORS "\nSYSTem:VERSion?;VERSion?;VERSion?;ERRor:ALL?\n"
#define MARK "1999.0;1999.0;1999.0;"
#define NO_ERROR "0,"

/* Sockets of the folder that somebody listens at. */
struct found {
    char first[LX_SERVER_ADDRESS_MAX];
    char names[sizeof((struct lx_error *)0)->right / 2];
    size_t count;
};

static void look_at(struct found *self, const char *folder, const char *name)
{
    struct lx_error ignored;
    char where[LX_SERVER_ADDRESS_MAX];
    const int n = snprintf(where, sizeof where, "unix:%s/%s", folder, name);
    const int fd = n > 0 && (size_t)n < sizeof where ? lx_endpoint_connect(where, &ignored) : -1;
    if (fd < 0) {
        return;
    }
    (void)close(fd);
    if (self->count++ == 0) {
        memcpy(self->first, where, sizeof where);
    }
    const size_t used = strlen(self->names);
    (void)snprintf(self->names + used, sizeof self->names - used, " %s", where);
}

static int is_socket(const struct dirent *entry)
{
    const size_t n = strlen(entry->d_name);
    return n > 5 && strcmp(entry->d_name + n - 5, ".sock") == 0;
}

int ctl_find(const char *wanted, char *to, size_t size, struct lx_error *error)
{
    char folder[LX_SERVER_ADDRESS_MAX];
    struct found found = {.count = 0};
    struct dirent **list = NULL;
    if (wanted != NULL) {
        struct lx_access access;
        (void)snprintf(to, size, "%s", wanted);
        if (lx_endpoint_is_serial(wanted)) {
            return 0;
        }
        return lx_access_parse(wanted, &access, error);
    }
    if (lx_server_folder(folder, sizeof folder) != 0) {
        return lx_fail(error,
                       "RUNTIME_DIRECTORY or XDG_RUNTIME_DIR is too long; --control ADDR is right");
    }
    const int count = scandir(folder, &list, is_socket, alphasort);
    for (int i = 0; i < count; i++) {
        look_at(&found, folder, list[i]->d_name);
        free(list[i]);
    }
    free(list);
    if (found.count > 1) {
        return lx_fail(error, "several are running; --control with one of:%s", found.names);
    }
    if (found.count == 0) {
        return lx_fail(error,
                       "nothing is running at %s; start one with 'drehgeber run', or give "
                       "--control ADDR",
                       folder);
    }
    (void)snprintf(to, size, "%s", found.first);
    return 0;
}

/* What is to be sent, and what has come back. */
struct talk {
    int fd;
    bool serial;     /* not a socket */
    bool from_stdin; /* there may be more to send */
    bool spoken;     /* there was something to say */
    char *output;    /* owned */
    size_t output_length;
    char *input; /* owned; the lines that were not printed yet */
    size_t input_length;
    bool failed; /* the connection broke */
};

static bool append(char **to, size_t *length, const char *bytes, size_t n)
{
    char *more = realloc(*to, *length + n + 1);
    if (more == NULL) {
        return false;
    }
    memcpy(more + *length, bytes, n);
    *to = more;
    *length += n;
    more[*length] = '\0';
    return true;
}

static bool say(struct talk *self, const char *text)
{
    return append(&self->output, &self->output_length, text, strlen(text));
}

static bool ask_for_errors(struct talk *self)
{
    return say(self, self->serial ? MARKED_ERRORS : ERRORS);
}

/* Another piece of stdin; at its end the question for errors. */
static void take_stdin(struct talk *self)
{
    char bytes[CHUNK];
    const ssize_t n = read(STDIN_FILENO, bytes, sizeof bytes);
    self->from_stdin = n > 0;
    self->spoken = self->spoken || n > 0;
    if (n > 0) {
        self->failed = !append(&self->output, &self->output_length, bytes, (size_t)n);
    } else {
        self->failed = !ask_for_errors(self);
    }
}

static void send_some(struct talk *self)
{
    if (self->output == NULL) {
        return;
    }
    const ssize_t n = self->serial ? write(self->fd, self->output, self->output_length)
                                   : send(self->fd, self->output, self->output_length,
                                          MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0) {
        self->failed = errno != EAGAIN && errno != EINTR;
        return;
    }
    self->output_length -= (size_t)n;
    memmove(self->output, self->output + n, self->output_length);
    if (self->output_length == 0 && !self->from_stdin && !self->serial) {
        (void)shutdown(self->fd, SHUT_WR);
    }
}

/* Print all lines but the last one, which may be the list of errors. */
static void print_answers(struct talk *self)
{
    size_t done = 0;
    for (;;) {
        const char *line = self->input + done;
        const char *end = memchr(line, '\n', self->input_length - done);
        if (end == NULL || (size_t)(end + 1 - self->input) == self->input_length) {
            break;
        }
        done = (size_t)(end + 1 - self->input);
        (void)fwrite(line, 1, (size_t)(end + 1 - line), stdout);
    }
    (void)fflush(stdout);
    self->input_length -= done;
    memmove(self->input, self->input + done, self->input_length + 1);
}

/* Whether the last line of a serial one has come; it is left without its mark. */
static bool marked(struct talk *self)
{
    const size_t n = strlen(MARK);
    if (!self->serial || self->input_length <= n || strncmp(self->input, MARK, n) != 0 ||
        self->input[self->input_length - 1] != '\n') {
        return false;
    }
    self->input_length -= n;
    memmove(self->input, self->input + n, self->input_length + 1);
    return true;
}

/* @return false at the end */
static bool receive_some(struct talk *self)
{
    char bytes[CHUNK];
    const ssize_t n = self->serial ? read(self->fd, bytes, sizeof bytes)
                                   : recv(self->fd, bytes, sizeof bytes, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return true;
    }
    self->failed = n < 0;
    if (n <= 0 || !append(&self->input, &self->input_length, bytes, (size_t)n)) {
        return false;
    }
    print_answers(self);
    return !marked(self);
}

static void exchange(struct talk *self)
{
    bool open = true;
    while (open && !self->failed) {
        struct pollfd fds[2] = {
            {.fd = self->fd, .events = self->output_length > 0 ? POLLIN | POLLOUT : POLLIN},
            {.fd = self->from_stdin ? STDIN_FILENO : -1, .events = POLLIN},
        };
        if (poll(fds, 2, -1) < 0) {
            self->failed = errno != EINTR;
            continue;
        }
        if (fds[1].revents != 0) {
            take_stdin(self);
        }
        if ((fds[0].revents & POLLOUT) != 0 && !self->failed) {
            send_some(self);
        }
        if ((fds[0].revents & (POLLIN | POLLHUP | POLLERR)) != 0 && !self->failed) {
            open = receive_some(self);
        }
    }
}

/* The last line says what went wrong. */
static int conclude(struct talk *self, const char *where)
{
    char *line = self->input;
    if (self->failed || line == NULL || self->input_length == 0) {
        lx_complain("%s: the connection broke", where);
        return EXIT_OTHER;
    }
    line[strcspn(line, "\n")] = '\0';
    if (!self->spoken) {
        lx_complain("no command, and none on stdin; 'drehgeber ctl SYST:HELP?' lists them");
        return EXIT_USAGE;
    }
    if (strncmp(line, NO_ERROR, strlen(NO_ERROR)) == 0) {
        return EXIT_OK;
    }
    lx_complain("%s", line);
    return EXIT_OTHER;
}

int ctl_command(const char *wanted, char *const *words, size_t count)
{
    char where[LX_SERVER_ADDRESS_MAX];
    char greeting[LX_ACCESS_GREETING_MAX];
    struct lx_error error;
    struct talk self = {.from_stdin = count == 0, .spoken = count > 0};
    greeting[0] = '\0';
    if (ctl_find(wanted, where, sizeof where, &error) != 0) {
        return complain(&error, wanted == NULL ? EXIT_OTHER : EXIT_USAGE);
    }
    self.serial = lx_endpoint_is_serial(where);
    self.fd = self.serial ? lx_endpoint_open_serial(where, &error)
                          : lx_access_connect(where, greeting, &error);
    if (self.fd < 0) {
        return complain(&error, EXIT_OTHER);
    }
    self.failed = !say(&self, greeting);
    for (size_t i = 0; i < count && !self.failed; i++) {
        self.failed =
            !say(&self, words[i]) || !(i + 1 < count ? say(&self, "\n") : ask_for_errors(&self));
    }
    exchange(&self);
    const int status = conclude(&self, where);
    (void)close(self.fd);
    free(self.output);
    free(self.input);
    return status;
}

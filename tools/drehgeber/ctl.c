/* SPDX-License-Identifier: MIT */
/*
 * Everything is sent, then the question for errors, then the end of the stream. The other side
 * answers all of it before it closes, so the last line that comes in is the list of errors and all
 * others are answers: no guessing which command has one. A serial line has no end:
 * there the question begins with another one, whose answer nobody else gets.
 *
 * The other side may be stopped, or no rig at all. ctl says so when nothing has come for a while,
 * and ends later. It does neither when *OPC? or *WAI was sent, as their answer takes as long as the
 * motion, unless the user has given a limit.
 */
#define _GNU_SOURCE
#include "ctl.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

#include "access.h"
#include "endpoint.h"
#include "run.h"
#include "server.h"
#include "timer.h"
#include "tty_open.h"
#include "virtual_time.h"

#define CHUNK 4096u
#define ERRORS "\nSYSTem:ERRor:ALL?\n"
#define MARKED_ERRORS "\nSYSTem:VERSion?;VERSion?;VERSion?;ERRor:ALL?\n"
#define MARK "1999.0;1999.0;1999.0;"
#define NO_ERROR "0,"
/* A silence that the user is told of, and one that ends ctl. */
#define SILENCE DG_S(5)
#define LIMIT "60S"
#define CONSOLE "tty:"

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

/* tty:PATH, the console of a board, which one can open but not listen at. */
static bool is_console(const char *where)
{
    const size_t n = strlen(CONSOLE);
    return strncmp(where, CONSOLE, n) == 0 && where[n] != '\0';
}

static int open_console(const char *where, struct lx_error *error)
{
    static const struct lx_uart uart = {.baud = 115200, .parity = 'N'};
    const int fd = tty_open(where + strlen(CONSOLE), &uart);
    return fd >= 0 ? fd
                   : lx_fail(error, "%s: cannot open it: %s; expected the serial port of a board",
                             where, strerror(errno));
}

int ctl_find(const char *wanted, char *to, size_t size, struct lx_error *error)
{
    char folder[LX_SERVER_ADDRESS_MAX];
    struct found found = {.count = 0};
    struct dirent **list = NULL;
    if (wanted != NULL) {
        struct lx_access access;
        (void)snprintf(to, size, "%s", wanted);
        if (is_console(wanted)) {
            return 0;
        }
        return lx_access_parse(wanted, &access, error);
    }
    if (lx_server_folder(folder, sizeof folder) != 0) {
        return lx_fail(error,
                       "RUNTIME_DIRECTORY or XDG_RUNTIME_DIR is too long; expected --control ADDR");
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
    const char *where;
    const char *limit_text;
    dg_ns limit;                 /* of a silence; DG_NEVER: none */
    bool limited;                /* by the user */
    bool asked;                  /* stdin has had a '?' since the last answer */
    bool silent;                 /* for too long */
    bool told;                   /* of the silence since */
    dg_ns alive;                 /* when the other side has said or taken something, or was asked */
    char recent[sizeof "*OPC?"]; /* the last characters that are to be sent */
};

static void note_life(struct talk *self)
{
    self->alive = lx_real_now();
    self->told = false;
}

static bool append_bytes(char **to, size_t *length, const char *bytes, size_t n)
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

/* Two pieces of stdin may have a part each of what is looked for. */
static void look_for_waits(struct talk *self, const char *bytes, size_t n)
{
    const size_t last = sizeof self->recent - 2u;
    for (size_t i = 0; i < n; i++) {
        memmove(self->recent, self->recent + 1, last);
        self->recent[last] = bytes[i];
        if (!self->limited &&
            (strcasecmp(self->recent, "*OPC?") == 0 || strcasecmp(self->recent + 1, "*WAI") == 0)) {
            self->limit = DG_NEVER;
        }
    }
}

static bool say_bytes(struct talk *self, const char *bytes, size_t n)
{
    look_for_waits(self, bytes, n);
    return append_bytes(&self->output, &self->output_length, bytes, n);
}

static bool say_text(struct talk *self, const char *text)
{
    return say_bytes(self, text, strlen(text));
}

static bool ask_for_errors(struct talk *self)
{
    return say_text(self, self->serial ? MARKED_ERRORS : ERRORS);
}

/* Whether the other side is to do something. While the user only types nothing is to come. */
static bool is_owed(const struct talk *self)
{
    return !self->from_stdin || self->asked || self->output_length > 0;
}

/* Another piece of stdin; at its end the question for errors. */
static void take_stdin(struct talk *self)
{
    char bytes[CHUNK];
    const ssize_t n = read(STDIN_FILENO, bytes, sizeof bytes);
    if (!is_owed(self)) {
        note_life(self);
    }
    self->from_stdin = n > 0;
    self->spoken = self->spoken || n > 0;
    if (n > 0) {
        self->asked = self->asked || memchr(bytes, '?', (size_t)n) != NULL;
        self->failed = !say_bytes(self, bytes, (size_t)n);
    } else {
        self->failed = !ask_for_errors(self);
    }
}

static void send_talk(struct talk *self)
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
    note_life(self);
    self->output_length -= (size_t)n;
    memmove(self->output, self->output + n, self->output_length);
    if (self->output_length == 0 && !self->from_stdin && !self->serial) {
        (void)shutdown(self->fd, SHUT_WR);
    }
}

/* Whoever answers shall not move the cursor, or give the terminal orders: on one whatever is no
   printable ASCII is shown as \xNN. Programs get the bytes as they came. */
static void print_line(const char *line, size_t n, bool shown, FILE *to)
{
    for (size_t i = 0; i < n; i++) {
        const unsigned char c = (unsigned char)line[i];
        if (shown && c != '\n' && (c < ' ' || c > '~')) {
            (void)fprintf(to, "\\x%02X", c);
        } else {
            (void)fputc(c, to);
        }
    }
}

/* Print all lines but the last one, which may be the list of errors. */
static void print_answers(struct talk *self)
{
    const bool shown = isatty(fileno(stdout)) == 1;
    size_t done = 0;
    for (;;) {
        const char *line = self->input + done;
        const char *end = memchr(line, '\n', self->input_length - done);
        if (end == NULL || (size_t)(end + 1 - self->input) == self->input_length) {
            break;
        }
        done = (size_t)(end + 1 - self->input);
        print_line(line, (size_t)(end + 1 - line), shown, stdout);
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
static bool receive_talk(struct talk *self)
{
    char bytes[CHUNK];
    const ssize_t n = self->serial ? read(self->fd, bytes, sizeof bytes)
                                   : recv(self->fd, bytes, sizeof bytes, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
        return true;
    }
    self->failed = n < 0;
    if (n <= 0 || !append_bytes(&self->input, &self->input_length, bytes, (size_t)n)) {
        return false;
    }
    note_life(self);
    self->asked = false;
    print_answers(self);
    return !marked(self);
}

/* Milliseconds until bear_silence() is to be called; -1: never. */
static int time_of_silence(const struct talk *self)
{
    if (!is_owed(self) || self->limit == DG_NEVER) {
        return -1;
    }
    const dg_ns now = lx_real_now();
    const dg_ns told = self->told ? DG_NEVER : dg_after(self->alive, SILENCE);
    const dg_ns until = dg_earliest(told, dg_after(self->alive, self->limit));
    const dg_ns left = until > now ? (until - now) / DG_MS(1) + 1u : 0;
    return left < INT_MAX ? (int)left : INT_MAX;
}

/* @return false when it has been too long */
static bool bear_silence(struct talk *self)
{
    if (time_of_silence(self) != 0) {
        return true;
    }
    if (lx_real_now() - self->alive >= self->limit) {
        lx_complain("%s: no answer for %s", self->where, self->limit_text);
        self->silent = true;
        return false;
    }
    lx_complain("%s: no answer for 5 s; ctl waits for %s, --timeout SPAN changes that", self->where,
                self->limit_text);
    self->told = true;
    return true;
}

static void exchange_lines(struct talk *self)
{
    bool open = true;
    note_life(self);
    while (open && !self->failed && bear_silence(self)) {
        struct pollfd fds[2] = {
            {.fd = self->fd, .events = self->output_length > 0 ? POLLIN | POLLOUT : POLLIN},
            {.fd = self->from_stdin ? STDIN_FILENO : -1, .events = POLLIN},
        };
        if (poll(fds, 2, time_of_silence(self)) < 0) {
            self->failed = errno != EINTR;
            continue;
        }
        if (fds[1].revents != 0) {
            take_stdin(self);
        }
        if ((fds[0].revents & POLLOUT) != 0 && !self->failed) {
            send_talk(self);
        }
        if ((fds[0].revents & (POLLIN | POLLHUP | POLLERR)) != 0 && !self->failed) {
            open = receive_talk(self);
        }
    }
}

/* What the other side says stands in a message of ours. */
static void complain_of(const char *line)
{
    char *shown = NULL;
    size_t n = 0;
    FILE *to = open_memstream(&shown, &n);
    if (to != NULL) {
        print_line(line, strlen(line), true, to);
        (void)fclose(to);
    }
    lx_complain("%s", shown == NULL ? "no memory" : shown);
    free(shown);
}

/* The last line says what went wrong. */
static int conclude_talk(const struct talk *self)
{
    char *line = self->input;
    if (self->silent) {
        return EXIT_OTHER;
    }
    if (self->failed || line == NULL || self->input_length == 0) {
        lx_complain("%s: the connection broke", self->where);
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
    complain_of(line);
    return EXIT_OTHER;
}

/* How long a silence may be. */
static int take_limit(struct talk *self, const char *text, struct lx_error *error)
{
    self->limited = text != NULL;
    self->limit_text = self->limited ? text : LIMIT;
    if (virtual_time_span(self->limit_text, &self->limit) == 0) {
        return 0;
    }
    (void)lx_refuse(error, "expected a span such as 10S, 5MIN or 1H; up to 8760H", "%s", "");
    return lx_about(error, LX_ABOUT_KEY, "timeout", text);
}

int ctl_command(const struct ctl_wanted *wanted, char *const *words, size_t count)
{
    char where[LX_SERVER_ADDRESS_MAX];
    char greeting[LX_ACCESS_GREETING_MAX] = "";
    struct lx_error error;
    struct talk self = {
        .from_stdin = count == 0, .spoken = count > 0, .where = where, .recent = "     "};
    if (take_limit(&self, wanted->timeout, &error) != 0) {
        return complain(&error, EXIT_USAGE);
    }
    if (ctl_find(wanted->address, where, sizeof where, &error) != 0) {
        return complain(&error, wanted->address == NULL ? EXIT_OTHER : EXIT_USAGE);
    }
    self.serial = is_console(where);
    self.fd =
        self.serial ? open_console(where, &error) : lx_access_connect(where, greeting, &error);
    if (self.fd < 0) {
        return complain(&error, EXIT_OTHER);
    }
    self.failed = !say_text(&self, greeting);
    for (size_t i = 0; i < count && !self.failed; i++) {
        self.failed = !say_text(&self, words[i]) ||
                      !(i + 1 < count ? say_text(&self, "\n") : ask_for_errors(&self));
    }
    exchange_lines(&self);
    const int status = conclude_talk(&self);
    (void)close(self.fd);
    free(self.output);
    free(self.input);
    return status;
}

/* SPDX-License-Identifier: MIT */
/*
 * The core says what is next, this file makes it happen:
 *
 *   client -- on_event -> input -- feed_session() -> dg_control_rx() -> keep() -> output -> client
 *   timer  -- on_time --> dg_control_step(), then what waited in `input`
 *
 * A session that waits (*WAI, *OPC?) takes no bytes; they stay in `input`, and the client is not
 * read from until there is room again. So it is behind a line that has written to an EEPROM file,
 * until that is on the disk, and its answers stay in `output`.
 */
#define _GNU_SOURCE
#include "server.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "endpoint.h"
#include "timer.h"

#define INPUT_MAX 1024u
/* Answers a client may leave lying before the rest of its commands waits. */
#define OUTPUT_FULL ((size_t)64 * 1024)
/* ... and with those of the line it was at: so much, and the names of all encoders. */
#define OUTPUT_MAX ((size_t)2 * 1024 * 1024)
#define NAME_MAX_BYTES 40u
#define FOLDER_MODE 0700

/* A connection. */
struct client {
    struct lx_server *server;
    int fd; /* -1: free */
    sd_event_source *io;
    struct dg_control control;
    struct lx_guard guard;
    dg_ns heard; /* when it said something last, real time */
    char input[INPUT_MAX];
    size_t input_length;
    char *output; /* owned */
    size_t output_length;
    size_t output_size;
    uint64_t written_after; /* waits for the writer: for tickets behind this one, */
    uint64_t written;       /* ... up to this one; 0: does not */
    bool ended;             /* no more bytes will come */
    bool broken;            /* to be closed */
};

struct lx_server {
    struct lx_server_setup setup;
    int listener;
    sd_event_source *io;
    struct lx_timer timer;
    bool woken; /* what a client waits for may have come sooner */
    struct client clients[LX_SERVER_CLIENTS_MAX];
    bool tcp;                             /* clients come over TCP */
    char token[LX_ACCESS_TOKEN_MAX + 1u]; /* "": none is asked for */
    dev_t device;                         /* of the socket file, to remove no other one */
    ino_t inode;
    char where[LX_ACCESS_WHERE_MAX]; /* as bound */
    char address[LX_SERVER_ADDRESS_MAX];
};

/* --- output --- */

static bool make_output_room(struct client *client, size_t n)
{
    const size_t names = NAME_MAX_BYTES * client->server->setup.rig->encoder_count;
    const size_t wanted = client->output_length + n;
    if (wanted <= client->output_size) {
        return true;
    }
    char *output = wanted > OUTPUT_MAX + names ? NULL : realloc(client->output, 2 * wanted);
    if (output == NULL) {
        return false;
    }
    client->output = output;
    client->output_size = 2 * wanted;
    return true;
}

/* Called inside the core. A client that does not take its answers is cut off. */
static void keep(void *ctx, const char *bytes, size_t n)
{
    struct client *client = ctx;
    if (client->broken || !make_output_room(client, n)) {
        client->broken = true;
        return;
    }
    memcpy(client->output + client->output_length, bytes, n);
    client->output_length += n;
}

static void send_client_output(struct client *client)
{
    while (client->output_length > 0 && !client->broken && client->written == 0) {
        const ssize_t n =
            send(client->fd, client->output, client->output_length, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n < 0) {
            client->broken = errno != EAGAIN;
            return;
        }
        client->output_length -= (size_t)n;
        memmove(client->output, client->output + n, client->output_length);
    }
}

/* --- what is written --- */

/* What is lost is told as an error; an answer of the same line may say something else, and the end
   of the connection says that. */
static void await_writer(struct client *client)
{
    if (client->written == 0) {
        return;
    }
    const enum lx_nvm_state state =
        lx_nvm_writer_state(client->server->setup.writer, client->written_after, client->written);
    if (state == LX_NVM_PENDING) {
        return;
    }
    client->written = 0;
    if (state == LX_NVM_LOST) {
        client->broken = client->output_length > 0;
        dg_scpi_raise(&client->control.session, DG_SCPI_STORAGE, "EEPROM file");
    }
}

/* The client has done something. `before`: the last ticket before that. */
static void look_what_is_written(struct client *client, uint64_t before)
{
    const uint64_t last = lx_nvm_writer_ticket(client->server->setup.writer);
    if (last == before) {
        return;
    }
    if (client->written == 0) {
        client->written_after = before;
    }
    client->written = last;
    await_writer(client);
}

/* --- clients --- */

static void drop_session(struct client *client)
{
    client->io = sd_event_source_disable_unref(client->io);
    if (client->fd >= 0) {
        dg_scpi_leave(&client->control.session);
        (void)close(client->fd);
    }
    free(client->output);
    client->output = NULL;
    client->fd = -1;
}

/* Up to the end of its first line; 0: the end has not come yet. A line that fills the buffer is
   taken in pieces, and what a client leaves unfinished when it goes is nothing. */
static size_t line_length(const struct client *client, size_t taken)
{
    const char *text = client->input + taken;
    const size_t n = client->input_length - taken;
    for (size_t i = 0; i < n; i++) {
        if (text[i] == '\n' || text[i] == '\r') {
            return i + 1u;
        }
    }
    return client->ended || n == sizeof client->input ? n : 0u;
}

/* @return how much of the line is done with */
static size_t take_guarded(struct client *client, dg_ns now, const char *line, size_t n)
{
    static const char no_token[] = "-203,\"Command protected;SYSTem:TOKen \"\"...\"\" first\"\n";
    switch (lx_guard_line(&client->guard, line, n)) {
    case LX_GUARD_PASS:
        return dg_control_rx(&client->control, now, line, n);
    case LX_GUARD_SKIP:
        return n;
    case LX_GUARD_TELL:
        (void)send(client->fd, no_token, sizeof no_token - 1, MSG_DONTWAIT | MSG_NOSIGNAL);
        break;
    case LX_GUARD_CLOSE:
        break;
    }
    client->broken = true;
    return n;
}

static size_t take_client_line(struct client *client, dg_ns now, const char *line, size_t n)
{
    const uint64_t before = lx_nvm_writer_ticket(client->server->setup.writer);
    const size_t taken = take_guarded(client, now, line, n);
    look_what_is_written(client, before);
    return taken;
}

/* What the session has waited for may be over. @return when to call again */
static dg_ns continue_session(struct client *client, dg_ns now)
{
    const uint64_t before = lx_nvm_writer_ticket(client->server->setup.writer);
    const dg_ns next = dg_control_step(&client->control, now);
    look_what_is_written(client, before);
    return next;
}

/* What the client has sent, as far as its session takes it, and it takes the answers. */
static void feed_session(struct client *client, dg_ns now)
{
    size_t taken = 0;
    size_t n = line_length(client, 0);
    while (n > 0 && !client->broken && !client->control.session.executing && client->written == 0 &&
           client->output_length < OUTPUT_FULL) {
        taken += take_client_line(client, now, client->input + taken, n);
        n = line_length(client, taken);
    }
    client->input_length -= taken;
    memmove(client->input, client->input + taken, client->input_length);
}

/* Read while there is room for it; write while there is something to write. */
static void watch_client(struct client *client)
{
    const bool done = client->ended && client->input_length == 0 && client->output_length == 0 &&
                      !client->control.session.waiting && !client->control.session.executing &&
                      client->written == 0;
    if (client->broken || done) {
        drop_session(client);
        return;
    }
    uint32_t events = client->output_length > 0 && client->written == 0 ? EPOLLOUT : 0u;
    if (!client->ended && client->input_length < sizeof client->input) {
        events |= EPOLLIN;
    }
    (void)sd_event_source_set_io_events(client->io, events);
}

/* All that the client has sent and that can be done now. @return when there is more to do */
static dg_ns serve_session(struct client *client)
{
    const struct lx_clock *clock = client->server->setup.clock;
    bool more = true;
    dg_ns next = DG_NEVER;
    client->server->setup.enter(client->server->setup.ctx, client->server->tcp);
    do {
        const dg_ns now = lx_clock_now(clock); /* the client before may have let time pass */
        const size_t before = client->input_length;
        await_writer(client);
        send_client_output(client);
        (void)continue_session(client, now);
        feed_session(client, now);
        const bool held = client->control.session.executing;
        next = continue_session(client, now);
        send_client_output(client);
        /* A command that has just ended has held back what stands behind it. */
        more = client->input_length < before || (held && !client->control.session.executing);
    } while (!client->broken && client->input_length > 0 && more);
    return next;
}

/* What one client did may be what another one waits for, which has had its turn: another round
   then. */
static void settle_clients(struct lx_server *self)
{
    dg_ns next = DG_NEVER;
    self->woken = false;
    for (size_t i = 0; i < LX_SERVER_CLIENTS_MAX; i++) {
        struct client *client = &self->clients[i];
        if (client->fd >= 0) {
            next = dg_earliest(next, serve_session(client));
            self->woken = self->woken || client->control.session.poll != NULL;
            watch_client(client);
        }
    }
    lx_timer_at(&self->timer, self->woken ? lx_now() : lx_clock_real(self->setup.clock, next));
    self->setup.settle(self->setup.ctx, lx_clock_now(self->setup.clock));
}

static void on_time(void *ctx, dg_ns now)
{
    (void)now;
    settle_clients(ctx);
}

static int on_event(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct client *client = ctx;
    (void)source;
    if ((events & (EPOLLIN | EPOLLHUP | EPOLLERR)) != 0 && !client->ended) {
        const size_t room = sizeof client->input - client->input_length;
        const ssize_t n = recv(fd, client->input + client->input_length, room, MSG_DONTWAIT);
        client->ended = n == 0;
        client->heard = lx_now();
        client->broken = n < 0 && errno != EAGAIN && errno != EINTR;
        client->input_length += n > 0 ? (size_t)n : 0u;
    } else if ((events & (EPOLLHUP | EPOLLERR)) != 0 && client->control.session.poll == NULL) {
        client->broken = true; /* what it has begun is not over before */
    }
    settle_clients(client->server);
    return 0;
}

/* Who goes last: first those who have not named the token, then those that wait for nothing. */
static unsigned standing(const struct client *client)
{
    const struct dg_scpi *session = &client->control.session;
    const bool known = client->guard.token == NULL || client->guard.named;
    const bool waits =
        session->waiting || session->opc || session->executing || client->written != 0;
    return known ? 1u + (unsigned)waits : 0u;
}

static bool goes_before(const struct client *a, const struct client *b)
{
    const unsigned standing_a = standing(a);
    const unsigned standing_b = standing(b);
    return standing_a != standing_b ? standing_a < standing_b : a->heard < b->heard;
}

/* A free place, or that of the client which has been silent for the longest time. */
static struct client *find_session_place(struct lx_server *self)
{
    struct client *last = &self->clients[0];
    for (size_t i = 0; i < LX_SERVER_CLIENTS_MAX; i++) {
        struct client *client = &self->clients[i];
        if (client->fd < 0) {
            return client;
        }
        last = goes_before(client, last) ? client : last;
    }
    drop_session(last);
    return last;
}

static int on_connection(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct lx_server *self = ctx;
    (void)source;
    (void)events;
    const int socket = accept4(fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
        return 0; /* it has gone again, or there is no descriptor for it */
    }
    struct client *client = find_session_place(self);
    *client = (struct client){.server = self, .fd = socket, .heard = lx_now()};
    client->guard =
        (struct lx_guard){.tcp = self->tcp, .token = self->token[0] == '\0' ? NULL : self->token};
    if (self->tcp) {
        lx_endpoint_keep_alive(socket);
    }
    dg_control_init(&client->control, self->setup.rig, keep, client);
    if (sd_event_add_io(self->setup.event, &client->io, socket, EPOLLIN, on_event, client) < 0) {
        drop_session(client);
    }
    return 0;
}

/* --- the server --- */

/* To remove no other socket than our own in the end. */
static void remember_file(struct lx_server *self)
{
    struct stat info;
    const char *path = strchr(self->where, ':') + 1;
    if (strncmp(self->where, "unix:", 5) == 0 && stat(path, &info) == 0) {
        self->device = info.st_dev;
        self->inode = info.st_ino;
    }
}

static void remove_file(const struct lx_server *self)
{
    struct stat info;
    const char *path = strchr(self->where, ':') + 1;
    if (self->inode != 0 && lstat(path, &info) == 0 && info.st_ino == self->inode &&
        info.st_dev == self->device) {
        (void)unlink(path);
    }
}

/* Where to listen and who may come in. The address that is told leads a client there as it is. */
static int listen_there(struct lx_server *self, const struct dg_plan_control *at,
                        struct lx_error *error)
{
    const char *file = at->token_file;
    if (file != NULL && lx_access_token(file, self->token, error) != 0) {
        return -1;
    }
    const enum lx_endpoint_reach reach = at->open ? LX_ENDPOINT_ANY : LX_ENDPOINT_LOOPBACK;
    self->tcp = at->tcp;
    self->listener = lx_endpoint_listen(at->where, reach, self->where, sizeof self->where, error);
    if (self->listener < 0) {
        return -1;
    }
    remember_file(self);
    (void)snprintf(self->address, sizeof self->address, "%s%s%s", self->where,
                   file == NULL ? "" : ",token=", file == NULL ? "" : file);
    return 0;
}

static int start_server(struct lx_server *self, const struct dg_plan_control *at,
                        struct lx_error *error)
{
    if (listen_there(self, at, error) != 0) {
        return -1;
    }
    int result = lx_timer_open(&self->timer, self->setup.event, on_time, self);
    if (result >= 0) {
        result =
            lx_endpoint_watch(self->listener, self->setup.event, &self->io, on_connection, self);
    }
    return result < 0 ? lx_fail(error, "%s: no event loop: %s", at->where, strerror(-result)) : 0;
}

struct lx_server *lx_server_open(const struct dg_plan_control *at,
                                 const struct lx_server_setup *setup, struct lx_error *error)
{
    struct lx_server *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory", at->where);
        return NULL;
    }
    self->setup = *setup;
    self->listener = -1;
    for (size_t i = 0; i < LX_SERVER_CLIENTS_MAX; i++) {
        self->clients[i].fd = -1;
    }
    if (start_server(self, at, error) != 0) {
        lx_server_close(self);
        return NULL;
    }
    return self;
}

/* Whoever waits is looked at when the loop comes round, not inside of what has changed. */
void lx_server_wake(struct lx_server *self)
{
    bool waits = false;
    for (size_t i = 0; self != NULL && i < LX_SERVER_CLIENTS_MAX; i++) {
        const struct client *client = &self->clients[i];
        const struct dg_scpi *session = &client->control.session;
        waits = waits ||
                (client->fd >= 0 && (session->waiting || session->opc || client->written != 0));
    }
    if (waits) {
        self->woken = true;
        lx_timer_at(&self->timer, lx_now());
    }
}

void lx_server_warn(const struct lx_server *self)
{
    if (self != NULL && !lx_endpoint_is_loopback(self->listener)) {
        lx_complain("%s: beyond loopback; %s controls this rig", self->where,
                    self->token[0] == '\0' ? "every machine that reaches it"
                                           : "every client that knows the token, which is sent "
                                             "as plain text,");
    }
}

const char *lx_server_address(const struct lx_server *self)
{
    return self->address;
}

void lx_server_close(struct lx_server *self)
{
    if (self == NULL) {
        return;
    }
    for (size_t i = 0; i < LX_SERVER_CLIENTS_MAX; i++) {
        drop_session(&self->clients[i]);
    }
    self->io = sd_event_source_disable_unref(self->io);
    lx_timer_close(&self->timer);
    if (self->listener >= 0) {
        remove_file(self);
        (void)close(self->listener);
    }
    free(self);
}

/* --- default addresses --- */

/* That of a systemd service; of several (RuntimeDirectory=A B) the first one. */
static int service_folder(const char *folders, char *to, size_t size)
{
    const int n = snprintf(to, size, "%.*s", (int)strcspn(folders, ":"), folders);
    return n > 0 && (size_t)n < size ? 0 : -1;
}

int lx_server_folder(char *to, size_t size)
{
    const char *service = getenv("RUNTIME_DIRECTORY");
    if (service != NULL && service[0] == '/') {
        return service_folder(service, to, size);
    }
    const char *run = getenv("XDG_RUNTIME_DIR");
    const char *tmp = getenv("TMPDIR");
    const bool known = run != NULL && run[0] == '/';
    tmp = tmp != NULL && tmp[0] == '/' ? tmp : "/tmp";
    const int n = known ? snprintf(to, size, "%s/drehgeber", run)
                        : snprintf(to, size, "%s/drehgeber-%lu", tmp, (unsigned long)getuid());
    return n > 0 && (size_t)n < size ? 0 : -1;
}

int lx_server_default(const char *name, char *to, size_t size, struct lx_error *error)
{
    char folder[LX_SERVER_ADDRESS_MAX];
    struct stat info;
    if (lx_server_folder(folder, sizeof folder) != 0) {
        return lx_fail(
            error,
            "RUNTIME_DIRECTORY or XDG_RUNTIME_DIR is too long; expected control = unix:PATH");
    }
    if (mkdir(folder, FOLDER_MODE) != 0 && errno != EEXIST) {
        return lx_fail(error, "%s: cannot make the folder: %s; expected control = unix:PATH",
                       folder, strerror(errno));
    }
    if (lstat(folder, &info) != 0 || !S_ISDIR(info.st_mode) || info.st_uid != getuid() ||
        (info.st_mode & 0022) != 0) {
        return lx_fail(error,
                       "%s: not a folder that only you can write to; expected control = unix:PATH",
                       folder);
    }
    const int n = snprintf(to, size, "unix:%s/%s.sock", folder, name);
    return n > 0 && (size_t)n < size ? 0 : lx_fail(error, "%s: name too long", name);
}

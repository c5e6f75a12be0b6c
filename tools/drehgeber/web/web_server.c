/* SPDX-License-Identifier: MIT */
/*
 *   browser -- GET --> file
 *   browser <-- WebSocket --> connection <-- link --> the rig
 *
 * A connection is one that was accepted, whatever it says. It has WEB_PATIENCE to name the token;
 * only then there is a link for it. Lines go both ways as they are, each in a message; while one
 * waits for the browser no more is read from the rig, and so there is no queue.
 */
#define _GNU_SOURCE
#include "web_server.h"

#include <errno.h>
#include <libwebsockets.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/random.h>
#include <unistd.h>

#include "endpoint.h"
#include "gate.h"
#include "rig_link.h"
#include "timer.h"
#include "web_http.h"

#define WEB_PATIENCE DG_S(10)
#define SWEEP_EVERY DG_S(1)
/* Lines to the rig from sweep to sweep. */
#define LINES_MAX 500u
#define TOKEN_BYTES 16u
/* Why a page is sent away, for it to know what to do; RFC 6455 7.4.2 leaves these to programs. */
#define CLOSE_TOKEN 4001
#define CLOSE_RIG 4002
#define CLOSE_LINE 4003

struct connection {
    struct web_server *server;
    struct lws *wsi; /* NULL: free */
    dg_ns deadline;  /* gone by then; DG_NEVER: a page that has named the token */
    struct lx_guard guard;
    struct web_http http;
    size_t length; /* of `line` */
    char line[WEB_LINE_MAX + 1u];
    unsigned allowance; /* lines it may say until the next sweep */
    bool greeted;       /* it has been told that it may ask */
    char *answer;       /* line of the link that waits for the browser; NULL */
    int ended;          /* code; 0: goes on */
    const char *why;
    struct rig_link link;
    sd_event_source *io; /* of the link */
};

struct web_server {
    struct web_setup setup;
    struct lws_context *context;
    struct lws_vhost *host;
    struct lws *loop; /* the inner one */
    int listener;
    sd_event_source *io;
    struct lx_timer sweep;
    char address[sizeof(struct lx_host_port)];
    struct rig_link first; /* where the rig is */
    struct connection connections[WEB_CONNECTIONS_MAX];
};

int web_token_make(char to[LX_ACCESS_TOKEN_MAX + 1u], struct lx_error *error)
{
    unsigned char bytes[TOKEN_BYTES];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) {
        return lx_fail(error, "no random numbers: %s", strerror(errno));
    }
    for (size_t i = 0; i < sizeof bytes; i++) {
        (void)snprintf(to + 2u * i, 3, "%02x", bytes[i]);
    }
    return 0;
}

/* --- the link to the rig --- */

static void unlink_rig(struct connection *self)
{
    self->io = sd_event_source_disable_unref(self->io);
    self->answer = NULL;
    rig_link_end(&self->link);
}

/* Say why, once the browser listens, and close. */
static void end_connection(struct connection *self, int code, const char *why)
{
    unlink_rig(self);
    self->ended = code;
    self->why = why;
    self->deadline = dg_after(lx_now(), WEB_PATIENCE);
    (void)lws_callback_on_writable(self->wsi);
}

/* While an answer waits for the browser nothing goes to the rig either: it would overwrite it. */
static void watch_rig(struct connection *self)
{
    (void)sd_event_source_set_io_events(self->io, rig_link_events(&self->link));
    (void)sd_event_source_set_enabled(self->io, self->answer == NULL ? SD_EVENT_ON : SD_EVENT_OFF);
}

static void take_answer(struct connection *self)
{
    if (self->answer == NULL) {
        self->answer = rig_link_line(&self->link);
    }
    if (self->answer != NULL) {
        (void)lws_callback_on_writable(self->wsi);
    }
    watch_rig(self);
}

static int on_rig(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct connection *self = ctx;
    (void)source;
    (void)fd;
    (void)events;
    if (rig_link_serve(&self->link) != 0) {
        end_connection(self, CLOSE_RIG, "the rig is gone");
        return 0;
    }
    take_answer(self);
    return 0;
}

/* When the rig has no place in its queue at this moment, the next sweep tries again. */
static void link_rig(struct connection *self)
{
    struct web_server *server = self->server;
    self->link.peer = server->first.peer;
    self->link.peer_size = server->first.peer_size;
    memcpy(self->link.greeting, server->first.greeting, sizeof self->link.greeting);
    int result = rig_link_again(&self->link);
    if (result == -EAGAIN) {
        return;
    }
    if (result == 0) {
        result = sd_event_add_io(server->setup.event, &self->io, self->link.fd, EPOLLIN | EPOLLOUT,
                                 on_rig, self);
    }
    if (result < 0) {
        end_connection(self, CLOSE_RIG, "the rig is gone");
        return;
    }
    (void)lws_callback_on_writable(self->wsi); /* for the greeting */
}

/* --- what a page says --- */

/* Whoever says more than a page does is heard again after the next sweep. */
static void count_line(struct connection *self)
{
    self->allowance--;
    if (self->allowance == 0) {
        (void)lws_rx_flow_control(self->wsi, 0);
    }
}

static unsigned count_pages(const struct web_server *self)
{
    unsigned n = 0;
    for (size_t i = 0; i < WEB_CONNECTIONS_MAX; i++) {
        const struct connection *one = &self->connections[i];
        n += one->wsi != NULL && one->guard.named && one->ended == 0 ? 1 : 0;
    }
    return n;
}

/* The token comes first, and once. */
static void take_guard_line(struct connection *self)
{
    if (lx_guard_line(&self->guard, self->line, self->length) != LX_GUARD_SKIP) {
        end_connection(self, CLOSE_TOKEN, "that is not the token");
        return;
    }
    if (count_pages(self->server) > WEB_PAGES_MAX) {
        end_connection(self, CLOSE_RIG, WEB_TOO_MANY);
        return;
    }
    self->deadline = DG_NEVER;
    link_rig(self);
}

static void take_browser_line(struct connection *self)
{
    if (!gate_line(self->line, self->length)) {
        end_connection(self, CLOSE_LINE, "a message is a line of SCPI");
    } else if (!self->guard.named) {
        self->line[self->length++] = '\n';
        take_guard_line(self);
    } else if (self->server->setup.watch && !gate_watches(self->line)) {
        end_connection(self, CLOSE_LINE, "this panel only watches");
    } else if (!rig_link_say(&self->link, self->line)) {
        end_connection(self, CLOSE_RIG, "the rig does not take what it is told");
    } else {
        count_line(self);
        watch_rig(self);
    }
}

static void receive_bytes(struct connection *self, const char *bytes, size_t n)
{
    if (self->ended != 0) {
        return;
    }
    self->length = lws_is_first_fragment(self->wsi) != 0 ? 0 : self->length;
    if (n >= WEB_LINE_MAX - self->length || lws_frame_is_binary(self->wsi) != 0) {
        end_connection(self, CLOSE_LINE, "a message is a line of SCPI");
        return;
    }
    memcpy(self->line + self->length, bytes, n);
    self->length += n;
    self->line[self->length] = '\0';
    if (lws_is_final_fragment(self->wsi) != 0) {
        take_browser_line(self);
    }
}

static int say_to_rig(struct connection *self, const char *text)
{
    const size_t n = strlen(text);
    unsigned char *message = malloc(LWS_PRE + n);
    if (message == NULL) {
        return -1;
    }
    memcpy(message + LWS_PRE, text, n);
    for (size_t i = LWS_PRE; i < LWS_PRE + n; i++) { /* a message is UTF-8 */
        message[i] = message[i] < ' ' || message[i] > '~' ? '?' : message[i];
    }
    const int sent = lws_write(self->wsi, message + LWS_PRE, n, LWS_WRITE_TEXT);
    free(message);
    return sent < 0 ? -1 : 0;
}

/* The browser takes a message. @return -1: close it */
static int send_to_browser(struct connection *self)
{
    if (self->ended != 0) {
        char why[64]; /* lws takes no const */
        const int n = snprintf(why, sizeof why, "%s", self->why);
        lws_close_reason(self->wsi, (enum lws_close_status)self->ended, (unsigned char *)why,
                         (size_t)n);
        return -1;
    }
    if (self->link.fd < 0) {
        return 0;
    }
    if (!self->greeted) {
        self->greeted = true;
        (void)lws_callback_on_writable(self->wsi);
        return say_to_rig(self, self->server->setup.watch ? "ready watch" : "ready");
    }
    if (self->answer == NULL) {
        return 0;
    }
    const int result = say_to_rig(self, self->answer);
    self->answer = NULL;
    take_answer(self);
    return result;
}

/* --- libwebsockets --- */

static void forget_connection(struct connection *self)
{
    unlink_rig(self);
    self->wsi = NULL;
}

static int on_http(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in,
                   size_t n)
{
    struct connection *self = lws_get_opaque_user_data(wsi);
    (void)user;
    (void)n;
    if (self == NULL) {
        return 0;
    }
    if (reason == LWS_CALLBACK_HTTP) {
        return web_http_request(&self->http, wsi, in);
    }
    if (reason == LWS_CALLBACK_HTTP_CONFIRM_UPGRADE) {
        return web_http_upgrade(wsi, in);
    }
    if (reason == LWS_CALLBACK_HTTP_WRITEABLE) {
        return web_http_send(&self->http, wsi);
    }
    if (reason == LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION) {
        return web_http_admit(&self->http, wsi, in, count_pages(self->server) < WEB_PAGES_MAX);
    }
    if (reason == LWS_CALLBACK_WSI_DESTROY) {
        forget_connection(self);
    }
    return 0;
}

static int on_socket(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in,
                     size_t n)
{
    struct connection *self = lws_get_opaque_user_data(wsi);
    if (self != NULL && reason == LWS_CALLBACK_RECEIVE) {
        receive_bytes(self, in, n);
        return 0;
    }
    if (self != NULL && reason == LWS_CALLBACK_SERVER_WRITEABLE) {
        return send_to_browser(self);
    }
    return on_http(wsi, reason, user, in, n);
}

/* Protocols that a page must not ask for refuse it likewise. */
static const struct lws_protocols protocols[] = {
    {.name = "http", .callback = on_http},
    {.name = WEB_PROTOCOL, .callback = on_socket, .rx_buffer_size = WEB_LINE_MAX},
    {.name = "loop", .callback = on_http},
    {.name = NULL},
};

static int open_context(struct web_server *self, struct lx_error *error)
{
    const struct lws_context_creation_info info = {
        .port = CONTEXT_PORT_NO_LISTEN,
        .protocols = protocols,
        .fd_limit_per_thread = WEB_CONNECTIONS_MAX + 16u,
        .max_http_header_pool = WEB_CONNECTIONS_MAX,
        .max_http_header_data = WEB_HEADERS_MAX,
        .timeout_secs = 5,
        .keepalive_timeout = 5,
        .options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS,
    };
    lws_set_log_level(0, NULL);
    self->context = lws_create_context(&info);
    self->host = self->context == NULL ? NULL : lws_create_vhost(self->context, &info);
    if (self->host == NULL) {
        return lx_fail(error, "libwebsockets does not start");
    }
    /* lws closes what it has adopted. */
    const lws_sock_file_fd_type fd = {.filefd = dup(sd_event_get_fd(self->setup.event))};
    self->loop = lws_adopt_descriptor_vhost(self->host, LWS_ADOPT_RAW_FILE_DESC, fd, "loop", NULL);
    return self->loop == NULL ? lx_fail(error, "libwebsockets takes no event loop") : 0;
}

/* --- connections --- */

static void cut_connection(struct connection *self)
{
    lws_set_timeout(self->wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_SYNC);
}

static void sweep_connection(struct connection *self, dg_ns now)
{
    if (self->deadline <= now) {
        cut_connection(self);
        return;
    }
    if (self->allowance == 0) {
        (void)lws_rx_flow_control(self->wsi, 1);
    }
    self->allowance = LINES_MAX;
    if (self->guard.named && self->ended == 0 && self->link.fd < 0) {
        link_rig(self);
    }
}

static void on_sweep(void *ctx, dg_ns now)
{
    struct web_server *self = ctx;
    for (size_t i = 0; i < WEB_CONNECTIONS_MAX; i++) {
        if (self->connections[i].wsi != NULL) {
            sweep_connection(&self->connections[i], now);
        }
    }
    lx_timer_at(&self->sweep, dg_after(now, SWEEP_EVERY));
}

/* A free place, or that of the one which has been there for longest without naming the token. Pages
   are fewer than places. */
static struct connection *find_connection(struct web_server *self)
{
    struct connection *oldest = NULL;
    for (size_t i = 0; i < WEB_CONNECTIONS_MAX; i++) {
        struct connection *one = &self->connections[i];
        if (one->wsi == NULL) {
            return one;
        }
        if (oldest == NULL || one->deadline < oldest->deadline) {
            oldest = one;
        }
    }
    cut_connection(oldest);
    return oldest;
}

static int on_connection(sd_event_source *source, int fd, uint32_t events, void *ctx)
{
    struct web_server *self = ctx;
    (void)source;
    (void)events;
    const lws_sock_file_fd_type socket = {
        .sockfd = accept4(fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC)};
    if (socket.sockfd < 0) {
        return 0; /* it has gone again, or there is no descriptor for it */
    }
    struct connection *connection = find_connection(self);
    *connection = (struct connection){
        .server = self,
        .http = {.where = &self->setup.where},
        .deadline = dg_after(lx_now(), WEB_PATIENCE),
        .allowance = LINES_MAX,
        .guard = {.tcp = true, .token = self->setup.token},
        .link = {.fd = -1},
    };
    lx_endpoint_keep_alive(socket.sockfd);
    struct lws *wsi = lws_adopt_descriptor_vhost(self->host, LWS_ADOPT_HTTP | LWS_ADOPT_SOCKET,
                                                 socket, NULL, NULL);
    if (wsi != NULL) { /* else lws has closed it */
        connection->wsi = wsi;
        lws_set_opaque_user_data(wsi, connection);
    }
    return 0;
}

/* --- the whole --- */

static int start_listening(struct web_server *self, struct lx_error *error)
{
    struct lx_host_port at = self->setup.where.at;
    char text[sizeof self->address];
    lx_host_port_print(&at, text, sizeof text);
    self->listener =
        lx_tcp_listen(&at, self->setup.where.open ? LX_ENDPOINT_ANY : LX_ENDPOINT_LOOPBACK);
    if (self->listener < 0 && errno == EPERM) {
        return lx_fail(
            error,
            "--listen %s: beyond loopback, where anybody could try to connect; use %s,open "
            "if you want that",
            text, text);
    }
    if (self->listener < 0) {
        return lx_fail(error, "--listen %s: cannot listen there: %s%s", text, strerror(errno),
                       errno == EADDRINUSE ? "; port 0 is any free one" : "");
    }
    (void)listen(self->listener, WEB_CONNECTIONS_MAX); /* a page comes with many at once */
    lx_host_port_real(&at, self->listener);
    lx_host_port_print(&at, self->address, sizeof self->address);
    return 0;
}

static int start_server(struct web_server *self, const char *control, struct lx_error *error)
{
    if (rig_link_open(&self->first, control, error) != 0) {
        return -1;
    }
    rig_link_close(&self->first); /* it was there; each page has one of its own */
    if (start_listening(self, error) != 0 || open_context(self, error) != 0) {
        return -1;
    }
    int result = lx_timer_open(&self->sweep, self->setup.event, on_sweep, self);
    if (result >= 0) {
        result =
            lx_endpoint_watch(self->listener, self->setup.event, &self->io, on_connection, self);
    }
    lx_timer_at(&self->sweep, dg_after(lx_now(), SWEEP_EVERY));
    return result < 0 ? lx_fail(error, "no event loop: %s", strerror(-result)) : 0;
}

struct web_server *web_server_open(const char *control, const struct web_setup *setup,
                                   struct lx_error *error)
{
    struct web_server *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "no memory");
        return NULL;
    }
    self->setup = *setup;
    self->listener = -1;
    self->first.fd = -1;
    if (start_server(self, control, error) != 0) {
        web_server_close(self);
        return NULL;
    }
    return self;
}

const char *web_server_address(const struct web_server *self)
{
    return self->address;
}

bool web_server_is_open(const struct web_server *self)
{
    return !lx_endpoint_is_loopback(self->listener);
}

bool web_server_watches(const struct web_server *self)
{
    return self->setup.watch;
}

/* Whatever is ready in the inner loop; the outer one waits. */
int web_server_run(struct web_server *self)
{
    sd_event *event = self->setup.event;
    int result = 0;
    while (result >= 0 && sd_event_get_state(event) != SD_EVENT_FINISHED) {
        result = sd_event_prepare(event);
        if (result == 0) {
            (void)lws_service(self->context, 0);
            result = sd_event_wait(event, 0);
        }
        if (result > 0) {
            result = sd_event_dispatch(event);
        }
    }
    return result < 0 ? result : 0;
}

void web_server_close(struct web_server *self)
{
    if (self == NULL) {
        return;
    }
    self->io = sd_event_source_disable_unref(self->io);
    lx_timer_close(&self->sweep);
    if (self->context != NULL) {
        lws_context_destroy(self->context);
    }
    if (self->listener >= 0) {
        (void)close(self->listener);
    }
    rig_link_end(&self->first);
    free(self);
}

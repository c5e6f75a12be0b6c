/* SPDX-License-Identifier: MIT */
/* What a request is answered with, and which one may become a WebSocket. All of it returns as
   callbacks of libwebsockets do: not 0 ends the connection. */
#ifndef DREHGEBER_WEB_HTTP_H
#define DREHGEBER_WEB_HTTP_H

#include <libwebsockets.h>
#include <stdbool.h>
#include <stddef.h>

/* Of a request, and of an answer. */
#define WEB_HEADERS_MAX 4096u
/* What a WebSocket speaks. */
#define WEB_PROTOCOL "drehgeber"
#define WEB_TOO_MANY "too many pages are open"

struct lx_peers_where;
struct web_file;

/* Of one connection. */
struct web_http {
    const struct lx_peers_where *where; /* the server listens */
    const struct web_file *file;        /* that goes out; NULL: none */
    size_t sent;                        /* of it */
};

/* A request for `path`: begin to answer it with the file, or refuse it. */
int web_http_request(struct web_http *self, struct lws *wsi, const char *path);

/* The browser takes more of the file. */
int web_http_send(struct web_http *self, struct lws *wsi);

/* A request to go on with the protocol `to`. */
int web_http_upgrade(struct lws *wsi, const char *to);

/* A handshake of WebSockets. `room`: there is a place for one more. @return 0: it may go on */
int web_http_admit(const struct web_http *self, struct lws *wsi, const char *protocol, bool room);

#endif

/* SPDX-License-Identifier: MIT */
/* HTTP and WebSockets: the files of the page for everybody, and for each page that names the token
   a connection to the control plane, line by line. */
#ifndef DREHGEBER_WEB_SERVER_H
#define DREHGEBER_WEB_SERVER_H

#include <stdbool.h>
#include <systemd/sd-event.h>

#include "access.h"
#include "peers.h"
#include "say.h"

/* WebSockets that have named the token (a page has two), and connections with those that fetch
 * files or have not named the token. */
#define WEB_PAGES_MAX 24u
#define WEB_CONNECTIONS_MAX 64u
/* Longest line to the rig; the control plane takes no longer one in one piece. */
#define WEB_LINE_MAX 1024u

struct web_setup {
    sd_event *event;
    struct lx_peers_where where; /* `word` is not used */
    bool watch;                  /* only what leaves the rig as it is */
    char token[LX_ACCESS_TOKEN_MAX + 1u];
};

struct web_server;

/* A token of 128 random bits. @return 0, or -1 with `error` */
int web_token_make(char to[LX_ACCESS_TOKEN_MAX + 1u], struct lx_error *error);

/* Listen; the control plane at `control` has to be there. NULL with one line in `error`. */
struct web_server *web_server_open(const char *control, const struct web_setup *setup,
                                   struct lx_error *error);

/* HOST:PORT, the port as the kernel chose it. */
const char *web_server_address(const struct web_server *self);

/* Whether others than this machine reach it. */
bool web_server_is_open(const struct web_server *self);

bool web_server_watches(const struct web_server *self);

/* Until the event loop is told to end. @return 0 or a negative errno */
int web_server_run(struct web_server *self);

/* NULL is fine. */
void web_server_close(struct web_server *self);

#endif

/* SPDX-License-Identifier: MIT */
/*
 *   GET /      --> is_ours() --> the file, in chunks
 *   GET /rig   --> is_ours(), from a page --> a WebSocket
 *
 * Every request is looked at the same way, before anything is done; whatever is wrong with it is
 * answered with a status and the end of the connection.
 */
#define _GNU_SOURCE
#include "web_http.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "files.h"
#include "gate.h"
#include "peers.h"

#define CHUNK 4096u
#define SOCKET_PATH "/rig"
/* Of the WebSocket protocol; a client of another one is told. */
#define VERSION "13"
#define UPGRADE_REQUIRED 426u

static bool header(struct lws *wsi, enum lws_token_indexes which, char *to, size_t size)
{
    return lws_hdr_copy(wsi, to, (int)size, which) > 0;
}

/* A name of this machine, and no page of another site; the page's own name in `host`. Browsers
   leave the origin out where they ask for a page or a file of it. */
static bool is_ours(const struct web_http *self, struct lws *wsi, char host[GATE_HOST_MAX])
{
    const struct lx_peers_where *where = self->where;
    char origin[GATE_HOST_MAX];
    if (!header(wsi, WSI_TOKEN_HOST, host, GATE_HOST_MAX) ||
        !gate_host(host, where->at.host, where->open)) {
        return false;
    }
    return lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) == 0 ||
           (header(wsi, WSI_TOKEN_ORIGIN, origin, sizeof origin) && gate_origin(origin, host));
}

static const struct web_file *find_file(const char *path)
{
    for (size_t i = 0; i < web_file_count; i++) {
        if (strcmp(web_files[i].path, path) == 0) {
            return &web_files[i];
        }
    }
    return NULL;
}

struct answer {
    unsigned char bytes[LWS_PRE + WEB_HEADERS_MAX];
    unsigned char *at;
};

static bool add_header(struct lws *wsi, struct answer *to, const char *name, const char *value)
{
    return lws_add_http_header_by_name(wsi, (const unsigned char *)name,
                                       (const unsigned char *)value, (int)strlen(value), &to->at,
                                       to->bytes + sizeof to->bytes) == 0;
}

/* Not every browser takes 'self' for WebSockets, too. `host` is that of a name or an address. */
static bool add_headers(struct lws *wsi, struct answer *to, const char *host)
{
    char policy[GATE_HOST_MAX + 256u];
    (void)snprintf(policy, sizeof policy,
                   "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; "
                   "connect-src 'self' ws://%s; base-uri 'none'; form-action 'none'; "
                   "frame-ancestors 'none'",
                   host);
    const char *const rows[][2] = {
        {"content-security-policy:", policy},
        {"x-content-type-options:", "nosniff"},
        {"cache-control:", "no-store"},
        {"referrer-policy:", "no-referrer"},
        {"cross-origin-resource-policy:", "same-origin"},
        {"cross-origin-opener-policy:", "same-origin"},
    };
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        if (!add_header(wsi, to, rows[i][0], rows[i][1])) {
            return false;
        }
    }
    return true;
}

static bool is_head(struct lws *wsi)
{
    return lws_hdr_total_length(wsi, WSI_TOKEN_HEAD_URI) > 0;
}

static int answer_file(struct web_http *self, struct lws *wsi, const char *host)
{
    struct answer answer = {.at = answer.bytes + LWS_PRE};
    unsigned char *end = answer.bytes + sizeof answer.bytes;
    if (lws_add_http_common_headers(wsi, HTTP_STATUS_OK, self->file->type, self->file->size,
                                    &answer.at, end) != 0 ||
        !add_headers(wsi, &answer, host) ||
        lws_finalize_write_http_header(wsi, answer.bytes + LWS_PRE, &answer.at, end) != 0) {
        return -1;
    }
    if (is_head(wsi)) {
        self->file = NULL;
        return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
    }
    return lws_callback_on_writable(wsi) < 0 ? -1 : 0;
}

static int refuse_request(struct lws *wsi, unsigned status, const char *why)
{
    (void)lws_return_http_status(wsi, status, why);
    return -1;
}

int web_http_request(struct web_http *self, struct lws *wsi, const char *path)
{
    char host[GATE_HOST_MAX];
    self->file = find_file(path);
    self->sent = 0;
    if (!is_ours(self, wsi, host)) {
        return refuse_request(
            wsi, HTTP_STATUS_FORBIDDEN,
            "This is not a name of this machine, or it is a page of another site; use an "
            "address");
    }
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) == 0 && !is_head(wsi)) {
        return refuse_request(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED, "expected GET");
    }
    return self->file == NULL ? refuse_request(wsi, HTTP_STATUS_NOT_FOUND, NULL)
                              : answer_file(self, wsi, host);
}

int web_http_send(struct web_http *self, struct lws *wsi)
{
    unsigned char chunk[LWS_PRE + CHUNK];
    if (self->file == NULL) {
        return 0;
    }
    const size_t left = self->file->size - self->sent;
    const size_t n = left < CHUNK ? left : CHUNK;
    memcpy(chunk + LWS_PRE, self->file->bytes + self->sent, n);
    const bool last = n == left;
    if (lws_write(wsi, chunk + LWS_PRE, n, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0) {
        return -1;
    }
    self->sent += n;
    if (!last) {
        return lws_callback_on_writable(wsi) < 0 ? -1 : 0;
    }
    self->file = NULL;
    return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
}

/* HTTP/2 would come in past web_http_admit(), and Host and Origin are called otherwise there. */
int web_http_upgrade(struct lws *wsi, const char *to)
{
    return strcasecmp(to, "websocket") == 0
               ? 0
               : refuse_request(wsi, HTTP_STATUS_BAD_REQUEST, "websocket is the only upgrade here");
}

/* RFC 6455, 4.4. */
static int refuse_version(struct lws *wsi)
{
    struct answer answer = {.at = answer.bytes + LWS_PRE};
    unsigned char *end = answer.bytes + sizeof answer.bytes;
    if (lws_add_http_common_headers(wsi, UPGRADE_REQUIRED, NULL, 0, &answer.at, end) != 0 ||
        !add_header(wsi, &answer, "sec-websocket-version:", VERSION)) {
        return -1;
    }
    const int sent = lws_finalize_write_http_header(wsi, answer.bytes + LWS_PRE, &answer.at, end);
    return sent < 0 ? sent : -1;
}

int web_http_admit(const struct web_http *self, struct lws *wsi, const char *protocol, bool room)
{
    char host[GATE_HOST_MAX];
    char version[sizeof VERSION + 1u];
    char path[sizeof SOCKET_PATH + 1u];
    if (!is_ours(self, wsi, host) || lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) == 0) {
        return refuse_request(wsi, HTTP_STATUS_FORBIDDEN, "Only for the page from here");
    }
    if (!header(wsi, WSI_TOKEN_GET_URI, path, sizeof path) || strcmp(path, SOCKET_PATH) != 0 ||
        protocol == NULL || strcmp(protocol, WEB_PROTOCOL) != 0) {
        return refuse_request(wsi, HTTP_STATUS_NOT_FOUND, NULL);
    }
    if (!header(wsi, WSI_TOKEN_VERSION, version, sizeof version) || strcmp(version, VERSION) != 0) {
        return refuse_version(wsi);
    }
    return room ? 0 : refuse_request(wsi, HTTP_STATUS_SERVICE_UNAVAILABLE, WEB_TOO_MANY);
}

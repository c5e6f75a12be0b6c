/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "access.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "drehgeber/api.h"
#include "drehgeber/hal.h"
#include "drehgeber/rig.h"
#include "endpoint.h"

#define OTHERS 0077

/* --- the address --- */

int lx_access_parse(const char *text, struct lx_access *out, struct lx_error *error)
{
    struct dg_access_words words;
    struct dg_plan_error wrong;
    if (dg_access_read(text, &words, &wrong) != DG_OK) {
        (void)lx_error_take(error, &wrong);
        return -1;
    }
    const char *token = words.token == NULL ? "" : words.token;
    *out = (struct lx_access){.tcp = words.tcp, .open = words.open};
    memcpy(out->where, text, words.where);
    const int length = snprintf(out->token_file, sizeof out->token_file, "%s", token);
    return (size_t)length < sizeof out->token_file
               ? 0
               : lx_fail(error, "%s: expected ADDRESS, ADDRESS,open, ADDRESS,token=FILE or both",
                         text);
}

/* --- the token --- */

static int check_token(const char *path, char *token, size_t n, struct lx_error *error)
{
    bool good = true;
    n -= n > 0 && token[n - 1] == '\n' ? 1u : 0u;
    token[n] = '\0'; /* one in the text is no printable character */
    for (size_t i = 0; i < n; i++) {
        good = good && isgraph((unsigned char)token[i]) != 0 && token[i] != '"' && token[i] != '\'';
    }
    return good && n >= LX_ACCESS_TOKEN_MIN && n <= LX_ACCESS_TOKEN_MAX
               ? 0
               : lx_fail(error,
                         "%s: no token; expected one line of %u to %u printable characters without "
                         "blanks and quotes",
                         path, LX_ACCESS_TOKEN_MIN, LX_ACCESS_TOKEN_MAX);
}

static int check_owner(int fd, const char *path, struct lx_error *error)
{
    struct stat info;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        return lx_fail(error, "%s: not a regular file; expected a file with a token", path);
    }
    return info.st_uid == geteuid() && (info.st_mode & OTHERS) == 0
               ? 0
               : lx_fail(error, "%s: others may read this token; run chmod 600", path);
}

int lx_access_token(const char *path, char to[LX_ACCESS_TOKEN_MAX + 1u], struct lx_error *error)
{
    char text[LX_ACCESS_TOKEN_MAX + 3u];
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) {
        return lx_fail(error, "%s: cannot open the token: %s", path, strerror(errno));
    }
    int result = check_owner(fd, path, error);
    if (result == 0) {
        const ssize_t n = read(fd, text, sizeof text - 1u);
        result = check_token(path, text, n > 0 ? (size_t)n : 0u, error);
    }
    (void)close(fd);
    if (result == 0) {
        memcpy(to, text, strlen(text) + 1u);
    }
    return result;
}

int lx_access_connect(const char *text, char greeting[LX_ACCESS_GREETING_MAX],
                      struct lx_error *error)
{
    struct lx_access access;
    char token[LX_ACCESS_TOKEN_MAX + 1u];
    greeting[0] = '\0';
    if (lx_access_parse(text, &access, error) != 0) {
        return -1;
    }
    if (access.token_file[0] != '\0') {
        if (lx_access_token(access.token_file, token, error) != 0) {
            return -1;
        }
        (void)snprintf(greeting, LX_ACCESS_GREETING_MAX, "SYST:TOK \"%s\"\n", token);
    }
    return lx_endpoint_connect(access.where, error);
}

/* --- the guard --- */

static size_t skip_header_blanks(const char *line, size_t n)
{
    size_t at = 0;
    while (at < n && (line[at] == ' ' || line[at] == '\t')) {
        at++;
    }
    return at;
}

static size_t without_end(const char *line, size_t n)
{
    while (n > 0 && (line[n - 1] == '\n' || line[n - 1] == '\r')) {
        n--;
    }
    return n;
}

/* RFC 9110 chapter 9, RFC 5789, RFC 9113 ("PRI"); TLS: a handshake record (RFC 8446 5.1). */
static const char *const methods[] = {"GET ",     "HEAD ",  "POST ",  "PUT ", "DELETE ",
                                      "CONNECT ", "TRACE ", "PATCH ", "PRI ", "OPTIONS "};
static const char handshake = 0x16;
static const char handshake_version = 0x03;

/* The length of the method and the blank that a line begins with, 0: with none. */
static size_t method_length(const char *line, size_t n)
{
    for (size_t i = 0; i < DG_COUNT(methods); i++) {
        const size_t length = strlen(methods[i]);
        if (n >= length && strncasecmp(line, methods[i], length) == 0) {
            return length;
        }
    }
    return 0;
}

static bool is_foreign_protocol(const char *line, size_t n)
{
    static const char version[] = " HTTP/";
    return method_length(line, n) > 0 ||
           (n > 0 && (line[0] == handshake || memmem(line, n, version, strlen(version)) != NULL));
}

/* What a page in a browser can ask for is a path, or everything ("*"). */
bool lx_begins_foreign(const uint8_t *bytes, size_t n)
{
    const char *text = (const char *)bytes;
    const size_t method = method_length(text, n);
    return (n >= 2 && text[0] == handshake && text[1] == handshake_version) ||
           (method > 0 && method < n && (text[method] == '/' || text[method] == '*'));
}

static bool is_header_character(char c)
{
    return isalnum((unsigned char)c) != 0 || c == '_';
}

/* Whether a line begins with a program header (IEEE 488.2 7.6.1): what it means is the session's
   business. "Host:" and "Content-Type:" are none. */
static bool is_scpi(const char *line, size_t n)
{
    size_t at = n > 0 && (line[0] == ':' || line[0] == '*') ? 1u : 0u;
    bool more = true;
    while (more) {
        if (at == n || isalpha((unsigned char)line[at]) == 0) {
            return false;
        }
        while (at < n && is_header_character(line[at])) {
            at++;
        }
        more = at < n && line[at] == ':';
        at += more ? 1u : 0u;
    }
    at += at < n && line[at] == '?' ? 1u : 0u;
    return at == n || line[at] == ' ' || line[at] == '\t' || line[at] == ';';
}

/* How long it takes says nothing about where the difference is. */
static bool same_token(const char *right, const char *text, size_t n)
{
    const size_t length = strlen(right);
    unsigned difference = length != n;
    for (size_t i = 0; i < n; i++) {
        difference |= (unsigned char)text[i] ^ (unsigned char)right[i % length];
    }
    return difference == 0;
}

/* The header SYSTem:TOKen and a blank; 0: another line. */
static size_t token_header(const char *line, size_t n)
{
    static const char *const forms[] = {"SYSTEM:TOKEN ", "SYST:TOK ", "SYST:TOKEN ", "SYSTEM:TOK "};
    const size_t at = n > 0 && line[0] == ':' ? 1u : 0u;
    for (size_t i = 0; i < DG_COUNT(forms); i++) {
        const size_t form = strlen(forms[i]);
        if (n - at >= form && strncasecmp(line + at, forms[i], form) == 0) {
            return at + form;
        }
    }
    return 0;
}

/* What stands in the quotes of SYSTem:TOKen "..." or '...'; NULL: another line. */
static const char *token_of(const char *line, size_t n, size_t *length)
{
    const size_t header = token_header(line, n);
    const char *text = line + header + skip_header_blanks(line + header, n - header);
    const size_t left = (size_t)(line + n - text);
    if (header == 0 || left < 2u || (text[0] != '"' && text[0] != '\'') ||
        text[left - 1u] != text[0]) {
        return NULL;
    }
    *length = left - 2u;
    return text + 1;
}

static enum lx_guard_verdict judge_line(struct lx_guard *self, const char *line, size_t n)
{
    size_t length = 0;
    if (is_foreign_protocol(line, n) || self->strange) {
        return LX_GUARD_CLOSE;
    }
    const char *token = token_of(line, n, &length);
    if (self->token != NULL && !self->named) {
        self->named = token != NULL && same_token(self->token, token, length);
        return self->named ? LX_GUARD_SKIP : LX_GUARD_TELL;
    }
    if (token != NULL) {
        return LX_GUARD_SKIP; /* a client that always says it */
    }
    self->strange = !self->begun && !is_scpi(line, n);
    self->begun = true;
    return LX_GUARD_PASS;
}

enum lx_guard_verdict lx_guard_line(struct lx_guard *self, const char *line, size_t n)
{
    const size_t blanks = skip_header_blanks(line, n);
    const size_t end = without_end(line, n);
    const bool inside = self->inside;
    self->inside = end == n;
    if ((!self->tcp && self->token == NULL) || inside) {
        return LX_GUARD_PASS;
    }
    /* A first line without an end in sight is no command, also when it begins with blanks. */
    if (end == n && !self->begun) {
        return LX_GUARD_CLOSE;
    }
    if (blanks >= end) {
        return LX_GUARD_PASS;
    }
    return judge_line(self, line + blanks, end - blanks);
}

/* SPDX-License-Identifier: MIT */
/*
 * A control address: unix:PATH or tcp:HOST:PORT, then ",open", then ",token=FILE".
 */
#include "rig_private.h"

#include "drehgeber/figure.h"
#include "drehgeber/hal.h"

#define OPEN_WORD ",open"
#define TOKEN_WORD ",token="
/* What sockets and files take at most. */
#define ADDRESS_MAX 299u
#define PATH_MAX 107u
#define HOST_MAX 255u
#define PORT_MAX 7u

/* Whether the word ends there: otherwise it is part of a name. */
static bool is_end(char c)
{
    return c == '\0' || c == ',';
}

/* Where the first of the words begins: a path may have commas of its own. */
static size_t address_length(const char *text)
{
    const char *token = dg_plan_find(text, TOKEN_WORD);
    const char *open = dg_plan_find(text, OPEN_WORD);
    const char *end = token != NULL ? token : text + dg_plan_length(text);

    if (open != NULL && open < end && is_end(open[dg_plan_length(OPEN_WORD)])) {
        end = open;
    }
    return (size_t)(end - text);
}

/* @return false: they are no such words */
static bool take_access_words(const char *words, struct dg_access_words *to)
{
    if (dg_plan_begins(words, OPEN_WORD)) {
        to->open = true;
        words += dg_plan_length(OPEN_WORD);
    }
    if (dg_plan_begins(words, TOKEN_WORD)) {
        to->token = words + dg_plan_length(TOKEN_WORD);
        return to->token[0] != '\0';
    }
    return words[0] == '\0';
}

/* HOST:PORT or [HOST]:PORT, of `n` characters. */
static bool is_host_port(const char *text, size_t n)
{
    size_t host = n;
    char port[PORT_MAX + 1u];
    struct dg_text digits = dg_text_in(port, sizeof port);
    uint64_t number = 0;

    while (host > 0 && text[host - 1u] != ':') {
        host--;
    }
    if (host < 2u || host - 1u > HOST_MAX || n - host > PORT_MAX) {
        return false;
    }
    dg_text_add_n(&digits, text + host, n - host);
    for (size_t i = 0; port[i] != '\0'; i++) {
        if (port[i] < '0' || port[i] > '9') {
            return false;
        }
    }
    const bool empty = host == 3u && text[0] == '[' && text[1] == ']';
    return dg_unsigned_parse(port, &number) && number <= UINT16_MAX && !empty;
}

/* What is behind the prefix, with its length; 0: nothing, or another prefix. */
static size_t length_after(const char *text, size_t n, const char *prefix)
{
    const size_t length = dg_plan_length(prefix);

    return n > length && dg_plan_begins(text, prefix) ? n - length : 0;
}

static int check_access(const char *text, size_t n, struct dg_plan_error *error)
{
    const size_t path = length_after(text, n, "unix:");
    const size_t host = length_after(text, n, "tcp:");
    const struct rig_cut where = dg_plan_cut(text, n);

    if (path > PATH_MAX) {
        return dg_plan_refuse(error, NULL,
                              RIG_SAY(where.text, ": expected a path of at most ",
                                      dg_plan_number(PATH_MAX).text, " characters"));
    }
    if (path > 0 || (host > 0 && is_host_port(text + n - host, host))) {
        return 0;
    }
    return dg_plan_refuse(error, NULL,
                          RIG_SAY(where.text, ": expected unix:PATH or tcp:HOST:PORT"));
}

int dg_access_read(const char *text, struct dg_access_words *to, struct dg_plan_error *error)
{
    const size_t n = address_length(text);

    *to = (struct dg_access_words){.where = n, .tcp = dg_plan_begins(text, "tcp:")};
    if (n > ADDRESS_MAX || !take_access_words(text + n, to)) {
        (void)dg_plan_refuse(
            error, NULL,
            RIG_SAY(text, ": expected ADDRESS, ADDRESS,open, ADDRESS,token=FILE or both"));
        return DG_ERR_ARGUMENT;
    }
    if (check_access(text, n, error) != 0) {
        return DG_ERR_ARGUMENT;
    }
    if (to->open && !to->tcp) {
        (void)dg_plan_refuse(error, NULL,
                             RIG_SAY(text,
                                     ": only tcp:HOST:PORT can be open; a socket file has its "
                                     "mode"));
        return DG_ERR_ARGUMENT;
    }
    return DG_OK;
}

/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "gate.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "drehgeber/api.h"

#define ORIGIN_PREFIX "http://"

/* The name without port and brackets. @return false: it is none */
static bool split_host(const char *host, char name[GATE_HOST_MAX])
{
    const bool six = host[0] == '[';
    const char *begin = host + (six ? 1 : 0);
    const size_t n = strcspn(begin, six ? "]" : ":");
    const char *port = begin + n + (six && begin[n] == ']' ? 1 : 0);
    if (n == 0 || n >= GATE_HOST_MAX || (six && begin[n] != ']')) {
        return false;
    }
    memcpy(name, begin, n);
    name[n] = '\0';
    return port[0] == '\0' ||
           (port[0] == ':' && port[1] != '\0' && port[1 + strspn(port + 1, "0123456789")] == '\0');
}

static bool is_address(const char *name)
{
    unsigned char bytes[sizeof(struct in6_addr)];
    return inet_pton(AF_INET, name, bytes) == 1 || inet_pton(AF_INET6, name, bytes) == 1;
}

/* Its own name, also with the domain behind it that the machine has for itself. */
static bool is_machine(const char *name)
{
    char own[GATE_HOST_MAX];
    if (gethostname(own, sizeof own) != 0) {
        return false;
    }
    own[sizeof own - 1u] = '\0';
    const size_t n = strlen(own);
    return n > 0 && strncasecmp(name, own, n) == 0 &&
           (name[n] == '\0' || strcasecmp(name + n, ".local") == 0);
}

bool gate_host(const char *host, const char *at, bool open)
{
    char name[GATE_HOST_MAX];
    if (!split_host(host, name)) {
        return false;
    }
    return is_address(name) || strcasecmp(name, "localhost") == 0 || strcasecmp(name, at) == 0 ||
           (open && is_machine(name));
}

bool gate_origin(const char *origin, const char *host)
{
    const size_t n = strlen(ORIGIN_PREFIX);
    return strncmp(origin, ORIGIN_PREFIX, n) == 0 && strcasecmp(origin + n, host) == 0;
}

bool gate_line(const char *line, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (line[i] < ' ' || line[i] > '~') {
            return false;
        }
    }
    return n > 0;
}

static bool is_one_of(const char *header, size_t n, const char *const *forms, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (strlen(forms[i]) == n && strncasecmp(header, forms[i], n) == 0) {
            return true;
        }
    }
    return false;
}

static bool watches(const char *command)
{
    static const char *const chooses[] = {"INST:SEL", "INSTRUMENT:SELECT", "INST:SELECT",
                                          "INSTRUMENT:SEL"};
    const char *header = command + strspn(command, " ");
    header += *header == ':' ? 1 : 0;
    const size_t n = strcspn(header, " ;");
    if (n == 0 || strncasecmp(header, "BISS:", strlen("BISS:")) == 0) {
        return n == 0;
    }
    return header[n - 1u] == '?' || is_one_of(header, n, chooses, DG_COUNT(chooses));
}

/* Every command stands at the beginning or behind a semicolon. That one may also be part of a text
   in quotes is left aside: no query needs it. */
bool gate_watches(const char *line)
{
    bool good = watches(line);
    const char *end = strchr(line, ';');
    while (good && end != NULL) {
        good = watches(end + 1);
        end = strchr(end + 1, ';');
    }
    return good;
}

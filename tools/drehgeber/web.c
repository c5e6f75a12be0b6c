/* SPDX-License-Identifier: MIT */
/*
 * The page is served by a program of its own, which has libwebsockets, so that this one is there
 * without.
 */
#define _GNU_SOURCE
#include "web.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "ctl.h"
#include "run.h"
#include "server.h"

#define PROGRAM "drehgeber-web"
#define LISTEN "127.0.0.1:8080"

/* Beside this program in a build tree, else where it is installed. */
static int find_program(char *to, size_t size, struct lx_error *error)
{
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    if (n < 0) {
        return lx_fail(error, "cannot find out where this program is: %s", strerror(errno));
    }
    self[n] = '\0';
    const char *folder = dirname(self);
    (void)snprintf(to, size, "%s/" PROGRAM, folder);
    if (access(to, X_OK) == 0) {
        return 0;
    }
    (void)snprintf(to, size, "%s/" DREHGEBER_WEB_FOLDER "/" PROGRAM, folder);
    return access(to, X_OK) == 0
               ? 0
               : lx_refuse(error,
                           "Debian's package " PROGRAM " has it, and a build with "
                           "libwebsockets-dev",
                           PROGRAM " is not installed");
}

static char *writable(const char *text)
{
    char *result;
    memcpy(&result, &text, sizeof result); /* execv() does not write to them */
    return result;
}

int web_command(const struct options *options)
{
    const char *wanted = options->control_count > 0 ? options->controls[0] : options->model;
    char where[LX_SERVER_ADDRESS_MAX];
    char program[PATH_MAX + sizeof PROGRAM + sizeof DREHGEBER_WEB_FOLDER + 2u];
    struct lx_error error;
    if (find_program(program, sizeof program, &error) != 0) {
        return complain(&error, EXIT_OTHER);
    }
    if (ctl_find(wanted, where, sizeof where, &error) != 0) {
        return complain(&error, wanted == NULL ? EXIT_OTHER : EXIT_USAGE);
    }
    char *const arguments[] = {
        writable(PROGRAM),
        where,
        writable(options->listen == NULL ? LISTEN : options->listen),
        writable(options->token == NULL ? "" : options->token),
        writable(options->watch ? "watch" : ""),
        NULL,
    };
    (void)execv(program, arguments);
    lx_complain("cannot start %s: %s", program, strerror(errno));
    return EXIT_OTHER;
}

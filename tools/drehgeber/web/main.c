/* SPDX-License-Identifier: MIT */
/*
 * drehgeber-web: the page of a rig that runs. `drehgeber web` starts it, in its own place; the
 * command does not need libwebsockets so. Arguments: the control address, HOST:PORT[,open], the
 * file of a token or "", "watch" or "".
 *
 * libwebsockets has the outer loop and knows of the inner one, which has all the rest, a single
 * descriptor.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <systemd/sd-event.h>

#include "access.h"
#include "complain.h"
#include "drehgeber/api.h"
#include "endpoint.h"
#include "run.h"
#include "web_server.h"

#define ARGUMENTS 5

static int add_signals(sd_event *event)
{
    static const int ends[] = {SIGTERM, SIGINT, SIGHUP};
    sigset_t blocked;
    (void)sigemptyset(&blocked);
    for (size_t i = 0; i < DG_COUNT(ends); i++) {
        (void)sigaddset(&blocked, ends[i]);
    }
    int result = sigprocmask(SIG_BLOCK, &blocked, NULL) == 0 ? 0 : -errno;
    for (size_t i = 0; i < DG_COUNT(ends) && result >= 0; i++) {
        result = sd_event_add_signal(event, NULL, ends[i], NULL, NULL); /* ends it with 0 */
    }
    return result;
}

/* Prints where the page is; who has brought a token knows it. */
static int tell_address(const struct web_server *server, const char *token)
{
    const bool open = web_server_is_open(server);
    if (open) {
        lx_complain("%s: beyond loopback; every client that knows the token, which is sent as "
                    "plain text, %s this rig",
                    web_server_address(server), web_server_watches(server) ? "sees" : "controls");
    }
    (void)printf("ready web http://%s/%s%s\n", web_server_address(server),
                 token == NULL ? "" : "#token=", token == NULL ? "" : token);
    if (fflush(stdout) == 0) {
        return EXIT_OK;
    }
    lx_complain("cannot write to stdout");
    return EXIT_OTHER;
}

static int serve_page(sd_event *event, char **arguments)
{
    struct web_setup setup = {.event = event, .watch = arguments[4][0] != '\0'};
    struct lx_error error;
    const bool own = arguments[3][0] == '\0';
    (void)signal(SIGPIPE, SIG_IGN);
    int result = add_signals(event);
    if (result < 0) {
        (void)lx_fail(&error, "no event loop: %s", strerror(-result));
        return complain(&error, EXIT_OTHER);
    }
    if (!lx_peers_split(arguments[2], &setup.where) || setup.where.word[0] != '\0') {
        lx_complain("--listen %s: expected HOST:PORT, e.g. 127.0.0.1:8080, or HOST:PORT,open "
                    "beyond loopback",
                    arguments[2]);
        return EXIT_USAGE;
    }
    if ((own ? web_token_make(setup.token, &error)
             : lx_access_token(arguments[3], setup.token, &error)) != 0) {
        return complain(&error, EXIT_OTHER);
    }
    struct web_server *server = web_server_open(arguments[1], &setup, &error);
    if (server == NULL) {
        return complain(&error, EXIT_OTHER);
    }
    int status = tell_address(server, own ? setup.token : NULL);
    if (status == EXIT_OK && web_server_run(server) != 0) {
        lx_complain("the event loop ended");
        status = EXIT_OTHER;
    }
    web_server_close(server);
    return status;
}

int main(int argc, char **argv)
{
    sd_event *event = NULL;
    if (argc != ARGUMENTS) {
        lx_complain("drehgeber-web is started by 'drehgeber web'");
        return EXIT_USAGE;
    }
    if (sd_event_new(&event) < 0) {
        lx_complain("no event loop");
        return EXIT_OTHER;
    }
    const int status = serve_page(event, argv);
    (void)sd_event_unref(event);
    return status;
}

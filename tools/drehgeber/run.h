/* SPDX-License-Identifier: MIT */
/* The `run` command. */
#ifndef DREHGEBER_TOOL_RUN_H
#define DREHGEBER_TOOL_RUN_H

#include <systemd/sd-event.h>

#include "options.h"

/* How the program ends. */
enum {
    EXIT_OK = 0,
    EXIT_OTHER = 1, /* anything but the user's words */
    EXIT_USAGE = 2, /* the command line */
};

/* Be that encoder until SIGINT or SIGTERM. Prints its own errors, returns how the program ends. */
int run_encoder(const struct options *options);

/* For every kind of encoder: print an error and pass on `status`. */
int run_complain(const struct lx_error *error, int status);

/* A loop that SIGINT and SIGTERM end. 0, or -1 with `error`. */
int run_make_loop(sd_event **event, struct lx_error *error);

/* The ready line: "ready MODEL WIRE:ADDRESS". 0, or -1 with `error`. */
int run_announce(const char *model, const char *wire, const char *address, struct lx_error *error);

/* Until the loop ends. Prints its own error, returns how the program ends. */
int run_loop(sd_event *event, struct lx_error *error);

#endif

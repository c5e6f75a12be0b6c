/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The control plane on sockets: unix:PATH (mode 0600) and tcp:HOST:PORT. Each connection is a
 * session of its own; access.h says who may have one. A slow or dead client never delays anybody:
 * when it does not take its answers the rest of its commands waits. One whose line has more answers
 * than can wait is cut off.
 */
#ifndef DREHGEBER_LINUX_SERVER_H
#define DREHGEBER_LINUX_SERVER_H

#include <stdbool.h>
#include <systemd/sd-event.h>

#include "access.h"
#include "bus.h"
#include "drehgeber/control.h"
#include "drehgeber/rig.h"
#include "nvm_writer.h"
#include "say.h"

/** Clients at once; one more takes the place of the one that has been silent for longest: of those
 * who have not named the token, if there are any, else of those who wait for no answer. */
#define LX_SERVER_CLIENTS_MAX 32u

/** Longest address as it is told, with the name of the token's file. */
#define LX_SERVER_ADDRESS_MAX (LX_ACCESS_WHERE_MAX + PATH_MAX + 8u)

/** What a server is made of. Everything pointed to must outlive it. */
struct lx_server_setup {
    sd_event *event;
    const struct lx_say *say;
    struct dg_rig *rig;
    const struct lx_clock *clock;
    /** Of the EEPROM files: what a client has written is not acknowledged before it is there; NULL:
     * there are none. */
    struct lx_nvm_writer *writer;
    /** A client is served from here on: one over TCP, or one over a socket file. */
    void (*enter)(void *ctx, bool tcp);
    /** After commands of a client were done at `now` (the rig's time): deadlines may have moved. */
    void (*settle)(void *ctx, dg_ns now);
    void *ctx;
};

struct lx_server;

/**
 * Listen at an address of a plan (port 0: any). A socket left behind by a dead
 * process is replaced, one of a living process is not.
 * @return NULL with one line in `error`
 */
struct lx_server *lx_server_open(const struct dg_plan_control *at,
                                 const struct lx_server_setup *setup, struct lx_error *error);

/** A shaft or the clock has changed, or something was written to an EEPROM file: what clients wait
 * for may come sooner; NULL is fine. */
void lx_server_wake(struct lx_server *self);

/** A line on stderr when others than this machine reach it; NULL is fine. */
void lx_server_warn(const struct lx_server *self);

/** Where it listens, with the real port, and the token's file: what a client takes. */
const char *lx_server_address(const struct lx_server *self);

/** Close all connections, remove the socket; NULL is fine. */
void lx_server_close(struct lx_server *self);

/**
 * The default address for `name`: unix:$RUNTIME_DIRECTORY/NAME.sock in a systemd service that has
 * one (the first, if there are several), else unix:$XDG_RUNTIME_DIR/drehgeber/NAME.sock, without
 * either unix:$TMPDIR/drehgeber-UID/NAME.sock (/tmp without that one, too); the folder is made,
 * mode 0700, and must be the user's own.
 * @return 0, or -1 with one line in `error`
 */
int lx_server_default(const char *name, char *to, size_t size, struct lx_error *error);

/** The folder of the default addresses, as above; not made. */
int lx_server_folder(char *to, size_t size);

#endif

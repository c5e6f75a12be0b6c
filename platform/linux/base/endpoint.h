/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Addresses of byte streams, unix:PATH and tcp:HOST:PORT, and sockets that listen at them or lead
 * there.
 */
#ifndef DREHGEBER_LINUX_ENDPOINT_H
#define DREHGEBER_LINUX_ENDPOINT_H

#include <stdbool.h>
#include <stddef.h>
#include <systemd/sd-event.h>

#include "say.h"

/** A host and a port, apart. */
struct lx_host_port {
    char host[256];
    char port[8];
};

/** Take "host:port" or "[host]:port" apart. @return false: it is neither */
bool lx_host_port_split(const char *text, struct lx_host_port *out);

/** HOST:PORT as it is written, an IPv6 address in brackets. */
void lx_host_port_print(const struct lx_host_port *self, char *to, size_t size);

/** Fill in the port that a socket really has: of port 0 the kernel has chosen one. */
void lx_host_port_real(struct lx_host_port *self, int fd);

/** Who may reach a TCP port. */
enum lx_endpoint_reach {
    LX_ENDPOINT_LOOPBACK, /**< addresses of this machine's loopback only; others are refused */
    LX_ENDPOINT_ANY
};

/** A socket that listens there, without blocking. @return the descriptor, or -1 with errno; EPERM:
 * beyond loopback, and not meant to be */
int lx_tcp_listen(const struct lx_host_port *where, enum lx_endpoint_reach reach);

/** What would be right when one cannot listen at a port for this errno; NULL: that is not known. */
const char *lx_port_right(int reason);

/** Let a TCP client whose machine is gone be noticed after 90 seconds. */
void lx_endpoint_keep_alive(int fd);

/** Whether a socket is bound to an address that only this machine reaches (unix: yes). */
bool lx_endpoint_is_loopback(int fd);

/**
 * A socket that listens at `where`, without blocking; unix: mode 0600. A socket that nobody listens
 * at any more is replaced, anything else is not.
 * @param address where it really is, with the port that the kernel has chosen for port 0
 * @return the descriptor, or -1 with one line in `error`
 */
int lx_endpoint_listen(const char *where, enum lx_endpoint_reach reach, char *address, size_t size,
                       struct lx_error *error);

/** Be told of connections. One that cannot be accepted for want of descriptors stays where it is:
 * it does not keep the loop busy. @return 0 or a negative errno */
int lx_endpoint_watch(int listener, sd_event *event, sd_event_source **io,
                      sd_event_io_handler_t connected, void *ctx);

/** A connection to `where`, which blocks. @return the descriptor, or -1 with `error` */
int lx_endpoint_connect(const char *where, struct lx_error *error);

#endif

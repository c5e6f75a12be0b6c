/* SPDX-License-Identifier: MIT */
/*
 * Who may come in, looked at before anything is done. Pages of other sites can make a browser send
 * requests to any port of this machine, also under a name of theirs that leads to it (DNS
 * rebinding); what they cannot choose is what it says of the page's origin and of the name.
 */
#ifndef DREHGEBER_WEB_GATE_H
#define DREHGEBER_WEB_GATE_H

#include <stdbool.h>
#include <stddef.h>

/* Longest Host header. */
#define GATE_HOST_MAX 280u

/* Whether a Host header is a name of this machine that no other site can have: localhost, an
   address, or, beyond loopback, what the machine calls itself. The port is not looked at: a tunnel
   has another. `at`: the host that was asked for with --listen */
bool gate_host(const char *host, const char *at, bool open);

/* Whether the Origin header is that of the page which was served under this Host. */
bool gate_origin(const char *origin, const char *host);

/* Whether a line is one of SCPI as a page sends it: printable ASCII, no end of line. */
bool gate_line(const char *line, size_t n);

/* Whether it leaves the rig as it is: queries only, and which encoder they are about. The queries
   of a simulated wire's master (BISS:) are clocks on it. */
bool gate_watches(const char *line);

#endif

/* SPDX-License-Identifier: MIT */
/* Lines to and from the control plane. After the first connection nothing waits for the other
   side. */
#ifndef DREHGEBER_TOOL_RIG_LINK_H
#define DREHGEBER_TOOL_RIG_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>

#include "access.h"
#include "say.h"

#define RIG_OUTPUT_MAX (64u * 1024u)
#define RIG_INPUT_FIRST ((size_t)64 * 1024)
#define RIG_INPUT_MAX ((size_t)4 * 1024 * 1024) /* the longest line: names of 100 000 encoders */

struct rig_link {
    struct sockaddr_storage peer; /* where it went the first time */
    socklen_t peer_size;
    char greeting[LX_ACCESS_GREETING_MAX]; /* every connection begins with it */
    int fd;                                /* -1: no connection */
    size_t taken;                          /* of the input: lines that were handed out */
    size_t input_length;
    size_t output_length;
    char *input; /* owned */
    size_t input_size;
    char output[RIG_OUTPUT_MAX];
};

/* The first connection; waits. @return 0, or -1 with one line in `error` */
int rig_link_open(struct rig_link *self, const char *where, struct lx_error *error);

/* Begin a connection to the same place. @return 0 or a negative errno */
int rig_link_again(struct rig_link *self);

/* Have a line sent. @return false: there is no room for it */
bool rig_link_say(struct rig_link *self, const char *line);

/* What to wait for, as EPOLLIN, EPOLLOUT. */
uint32_t rig_link_events(const struct rig_link *self);

/* Send and receive what is possible at once. @return 0 or a negative errno: the connection broke */
int rig_link_serve(struct rig_link *self);

/* The next line that has come in, good until rig_link_serve(). NULL: none */
char *rig_link_line(struct rig_link *self);

/* Close it; what was on its way is forgotten. */
void rig_link_close(struct rig_link *self);

/* The same for good: lines that were handed out are gone, too. */
void rig_link_end(struct rig_link *self);

#endif

/* SPDX-License-Identifier: MIT */
/* Lines to and from the control plane. After the first connection nothing waits for the other
   side. */
#ifndef DREHGEBER_TOOL_TOP_LINK_H
#define DREHGEBER_TOOL_TOP_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>

#include "access.h"
#include "say.h"

#define TOP_OUTPUT_MAX (64u * 1024u)
#define TOP_INPUT_FIRST ((size_t)64 * 1024)
#define TOP_INPUT_MAX ((size_t)4 * 1024 * 1024) /* the longest line: names of 100 000 encoders */

struct top_link {
    struct sockaddr_storage peer; /* where it went the first time */
    socklen_t peer_size;
    char greeting[LX_ACCESS_GREETING_MAX]; /* every connection begins with it */
    int fd;                                /* -1: no connection */
    size_t taken;                          /* of the input: lines that were handed out */
    size_t input_length;
    size_t output_length;
    char *input; /* owned */
    size_t input_size;
    char output[TOP_OUTPUT_MAX];
};

/* The first connection; waits. @return 0, or -1 with one line in `error` */
int top_link_open(struct top_link *self, const char *where, struct lx_error *error);

/* Begin a connection to the same place. @return 0 or a negative errno */
int top_link_again(struct top_link *self);

/* Have a line sent. @return false: there is no room for it */
bool top_link_say(struct top_link *self, const char *line);

/* What to wait for, as EPOLLIN, EPOLLOUT. */
uint32_t top_link_events(const struct top_link *self);

/* Send and receive what is possible at once. @return 0 or a negative errno: the connection broke */
int top_link_serve(struct top_link *self);

/* The next line that has come in, good until top_link_serve(). NULL: none */
char *top_link_line(struct top_link *self);

/* Close it; what was on its way is forgotten. */
void top_link_close(struct top_link *self);

/* The same for good: lines that were handed out are gone, too. */
void top_link_end(struct top_link *self);

#endif

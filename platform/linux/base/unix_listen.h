/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Sockets in the file system.
 */
#ifndef DREHGEBER_LINUX_UNIX_LISTEN_H
#define DREHGEBER_LINUX_UNIX_LISTEN_H

#include <sys/un.h>

#include "say.h"

/** Room for a path, with its zero. */
#define LX_UNIX_PATH_SIZE sizeof(((struct sockaddr_un *)0)->sun_path)

/** What binds or leads to `path`, which fits. */
struct sockaddr_un lx_unix_address(const char *path);

/** A socket that listens at `path`, without blocking, mode 0600. A socket that nobody listens at
 * any more is replaced, anything else is not. @return the descriptor, or -1 with one line in
 * `error` */
int lx_unix_listen(const char *path, struct lx_error *error);

#endif

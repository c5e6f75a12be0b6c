/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "unix_listen.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define BACKLOG 16
#define OWNER_ONLY 0177

struct sockaddr_un lx_unix_address(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    (void)snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    return address;
}

/* A socket left behind by a process that is gone refuses connections. */
static int clear_stale(const char *path, const struct sockaddr_un *address, struct lx_error *error)
{
    struct stat info;
    if (lstat(path, &info) != 0) {
        return 0;
    }
    if (!S_ISSOCK(info.st_mode)) {
        return lx_fail(error, "unix:%s: exists and is no socket; remove it or give another name",
                       path);
    }
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) {
        return lx_fail(error, "unix:%s: cannot find out which process listens there: %s", path,
                       strerror(errno));
    }
    const bool dead = connect(fd, (const struct sockaddr *)address, sizeof *address) != 0 &&
                      errno == ECONNREFUSED;
    (void)close(fd);
    if (!dead) {
        return lx_fail(error, "unix:%s: in use already; give another name", path);
    }
    (void)unlink(path);
    return 0;
}

int lx_unix_listen(const char *path, struct lx_error *error)
{
    const struct sockaddr_un address = lx_unix_address(path);
    if (clear_stale(path, &address, error) != 0) {
        return -1;
    }
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const mode_t before = umask(OWNER_ONLY);
    const bool bound = fd >= 0 && bind(fd, (const struct sockaddr *)&address, sizeof address) == 0;
    (void)umask(before);
    if (bound && listen(fd, BACKLOG) == 0) {
        return fd;
    }
    (void)lx_fail(error, "unix:%s: cannot listen there: %s", path, strerror(errno));
    if (bound) {
        (void)unlink(path);
    }
    if (fd >= 0) {
        (void)close(fd);
    }
    return -1;
}

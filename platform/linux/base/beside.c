/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "beside.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "file.h"

int lx_file_write(int fd, const void *bytes, size_t n, off_t at)
{
    const char *from = bytes;
    while (n > 0) {
        const ssize_t done = pwrite(fd, from, n, at);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done <= 0) {
            return done < 0 ? errno : ENOSPC;
        }
        from += done;
        at += done;
        n -= (size_t)done;
    }
    return 0;
}

/* The folder of `path`, and a name for mkostemp() in it. */
static bool name_beside(struct lx_beside *out, const char *path)
{
    const char *slash = strrchr(path, '/');
    const int n = slash == NULL ? 0 : (int)(slash - path) + 1;
    const char *base = slash == NULL ? path : slash + 1;
    const int folder =
        snprintf(out->folder, sizeof out->folder, "%.*s", n == 0 ? 1 : n, n == 0 ? "." : path);
    const int name = snprintf(out->name, sizeof out->name, "%.*s.%s.XXXXXX", n, path, base);
    return folder > 0 && (size_t)folder < sizeof out->folder && name > 0 &&
           (size_t)name < sizeof out->name;
}

int lx_beside_make(struct lx_beside *self, const char *path, const void *bytes, size_t n)
{
    self->fd = -1;
    if (!name_beside(self, path)) {
        return ENAMETOOLONG;
    }
    self->fd = mkostemp(self->name, O_CLOEXEC);
    if (self->fd < 0) {
        return errno;
    }
    const int reason = lx_file_write(self->fd, bytes, n, 0);
    return reason == 0 && fsync(self->fd) != 0 ? errno : reason;
}

void lx_beside_remove(struct lx_beside *self)
{
    if (self->fd >= 0) {
        (void)unlink(self->name);
        (void)close(self->fd);
    }
    self->fd = -1;
}

/* The new name is durable when its folder is; a file system that cannot sync folders says EINVAL,
   and does what it does. */
int lx_beside_sync(const struct lx_beside *self)
{
    const int fd = open(self->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) {
        return errno;
    }
    const int reason = fsync(fd) == 0 ? 0 : errno;
    (void)close(fd);
    return reason == EINVAL ? 0 : reason;
}

/* Where the file is, or will be, and its mode; a link to nothing is no such place. 0 or an errno.
 */
static int find_target(const char *path, char target[PATH_MAX], mode_t *mode)
{
    struct stat info;
    if (realpath(path, target) == NULL) {
        const int reason = errno;
        if (reason != ENOENT || *mode == 0 || lstat(path, &info) == 0) {
            return reason;
        }
        return snprintf(target, PATH_MAX, "%s", path) < PATH_MAX ? 0 : ENAMETOOLONG;
    }
    if (stat(target, &info) != 0) {
        return errno;
    }
    *mode = info.st_mode & 07777;
    return 0;
}

int lx_file_replace(const char *path, const void *bytes, size_t n, mode_t mode, int *fd)
{
    char target[PATH_MAX];
    struct lx_beside beside = {.fd = -1};
    int reason = find_target(path, target, &mode);
    if (reason == 0) {
        reason = lx_beside_make(&beside, target, bytes, n);
    }
    if (reason == 0 && fd != NULL) {
        reason = lx_file_hold(beside.fd);
    }
    if (reason == 0 && (fchmod(beside.fd, mode) != 0 || rename(beside.name, target) != 0)) {
        reason = errno;
    }
    if (reason != 0) {
        lx_beside_remove(&beside);
        return reason;
    }
    if (fd == NULL) {
        (void)close(beside.fd);
    } else {
        *fd = beside.fd;
    }
    return lx_beside_sync(&beside);
}

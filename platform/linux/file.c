/* SPDX-License-Identifier: MIT */
/*
 * The lock belongs to the open file, not to the process: two of one process exclude each other, and
 * it does not end when another descriptor of the file is closed. The kernel does not say whose such
 * a lock is, so its length does: it is the process. All begin at the same place.
 */
#define _GNU_SOURCE
#include "file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILE_MODE 0666

static struct flock lock_of(pid_t owner)
{
    return (struct flock){.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_len = owner};
}

int lx_file_hold(int fd)
{
    struct flock lock = lock_of(getpid());
    if (fcntl(fd, F_OFD_SETLK, &lock) == 0) {
        return 0;
    }
    return errno == EACCES ? EAGAIN : errno;
}

/* A lock of the other kind, which belongs to a process, has its ID. */
pid_t lx_file_holder(int fd)
{
    struct flock lock = lock_of(1);
    if (fcntl(fd, F_OFD_GETLK, &lock) != 0 || lock.l_type == F_UNLCK) {
        return 0;
    }
    return lock.l_pid > 0 ? lock.l_pid : (pid_t)lock.l_len;
}

/* Emptied when nobody else has it, not before. A file system that cannot lock is no reason to do
   without a trace. */
static int empty(int fd, const char *path, struct lx_error *error)
{
    struct stat info;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        return 0;
    }
    if (lx_file_hold(fd) == EAGAIN) {
        return lx_fail(error, "%s: in use already; another file is right", path);
    }
    return ftruncate(fd, 0) == 0 ? 0
                                 : lx_fail(error, "%s: cannot write: %s", path, strerror(errno));
}

static FILE *stream(int fd, const char *path, const char *mode, struct lx_error *error)
{
    FILE *file = fdopen(fd, mode);
    if (file == NULL) {
        (void)lx_fail(error, "%s: cannot open: %s", path, strerror(errno));
        (void)close(fd);
    }
    return file;
}

FILE *lx_file_create(const char *path, struct lx_error *error)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, FILE_MODE);
    if (fd < 0) {
        (void)lx_fail(error, "%s: cannot open: %s", path, strerror(errno));
        return NULL;
    }
    if (empty(fd, path, error) != 0) {
        (void)close(fd);
        return NULL;
    }
    return stream(fd, path, "w", error);
}

FILE *lx_file_read(const char *path, struct lx_error *error)
{
    struct stat info;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) {
        (void)lx_fail(error, "%s: cannot open: %s", path, strerror(errno));
        return NULL;
    }
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        (void)lx_fail(error, "%s: not a regular file; one is right", path);
        (void)close(fd);
        return NULL;
    }
    return stream(fd, path, "r", error);
}

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
#include <linux/openat2.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#define FILE_MODE 0666

static struct flock file_lock_of(pid_t owner)
{
    return (struct flock){.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_len = owner};
}

int lx_file_hold(int fd)
{
    struct flock lock = file_lock_of(getpid());
    if (fcntl(fd, F_OFD_SETLK, &lock) == 0) {
        return 0;
    }
    return errno == EACCES ? EAGAIN : errno;
}

/* A lock of the other kind, which belongs to a process, has its ID. */
pid_t lx_file_holder(int fd)
{
    struct flock lock = file_lock_of(1);
    if (fcntl(fd, F_OFD_GETLK, &lock) != 0 || lock.l_type == F_UNLCK) {
        return 0;
    }
    return lock.l_pid > 0 ? lock.l_pid : (pid_t)lock.l_len;
}

/* --- the folder of clients --- */

int lx_folder_open(struct lx_folder *self, const char *path, struct lx_error *error)
{
    *self = LX_FOLDER_NONE;
    self->fd = open(path, O_PATH | O_DIRECTORY | O_CLOEXEC);
    self->path = self->fd < 0 ? NULL : strdup(path);
    self->real = self->path == NULL ? NULL : realpath(path, NULL);
    if (self->real != NULL) {
        return 0;
    }
    const int reason = errno;
    lx_folder_close(self);
    return lx_fail(error, "%s: not a folder for files: %s", path, strerror(reason));
}

void lx_folder_close(struct lx_folder *self)
{
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    free(self->path);
    free(self->real);
    *self = LX_FOLDER_NONE;
}

/* What of an absolute name lies behind the folder's, which may end in slashes or be the root; NULL:
   it lies elsewhere. */
static const char *skip_folder(const char *path, const char *folder)
{
    size_t n = strlen(folder);
    while (n > 0 && folder[n - 1] == '/') {
        n--;
    }
    const bool inside = folder[0] == '/' && strncmp(path, folder, n) == 0 && path[n] == '/';
    return inside ? path + n + strspn(path + n, "/") : NULL;
}

/* The kernel sees to it that the name stays below the folder, whatever links there are, and
   whoever changes them meanwhile. glibc has no function for it. */
static int open_below(const struct lx_folder *folder, const char *path, uint64_t flags)
{
    const struct open_how how = {
        .flags = flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY,
        .mode = (flags & O_CREAT) != 0 ? FILE_MODE : 0,
        .resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS,
    };
    const char *name = path[0] == '/' ? NULL : path;
    if (folder->fd >= 0 && name == NULL) {
        name = skip_folder(path, folder->real);
        name = name == NULL ? skip_folder(path, folder->path) : name;
    }
    if (folder->fd < 0 || name == NULL || name[0] == '\0') {
        errno = EXDEV;
        return -1;
    }
    return (int)syscall(SYS_openat2, folder->fd, name, &how, sizeof how);
}

/* Short, as an answer of the control plane has 95 characters for it. */
static int refuse_below(const struct lx_folder *folder, const char *path, int reason,
                        struct lx_error *error)
{
    if (folder->fd < 0) {
        return lx_fail(error, "no files for clients of TCP; set files = DIR in [rig], or --files");
    }
    if (reason == EXDEV || reason == ELOOP) {
        return lx_fail(error, "%.36s: not in the folder for files; expected a name below it", path);
    }
    return lx_fail(error, "%.48s: %s", path, strerror(reason));
}

/* A file that was there: this program's own of this kind, or an empty one? */
static bool replaceable(int fd, const struct lx_file_mark *mark)
{
    char found[LX_FILE_MARK_MAX];
    struct stat info;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode) || info.st_nlink != 1) {
        return false; /* by another name it may be somebody else's */
    }
    return info.st_size == 0 ||
           (mark != NULL && pread(fd, found, mark->n, (off_t)mark->at) == (ssize_t)mark->n &&
            memcmp(found, mark->bytes, mark->n) == 0);
}

/* --- files that are written --- */

struct lx_file {
    int fd;
    bool held;
    bool for_nothing; /* made by this process at `path`: removed unless something is written */
    char *bytes;      /* what waits; owned */
    size_t length;
    char path[];
};

/* 0 or an errno. */
static int open_below_to_write(struct lx_file *self, const struct lx_file_wanted *wanted)
{
    self->fd = open_below(wanted->folder, wanted->path, O_WRONLY | O_CREAT | O_EXCL);
    if (self->fd >= 0 || errno != EEXIST) {
        return self->fd >= 0 ? 0 : errno;
    }
    self->fd = open_below(wanted->folder, wanted->path, O_RDWR);
    if (self->fd < 0) {
        return errno;
    }
    return replaceable(self->fd, wanted->mark) ? 0 : EEXIST;
}

static int open_to_write(struct lx_file *self, const char *path)
{
    const int flags = O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
    self->fd = open(path, flags | O_CREAT | O_EXCL, FILE_MODE);
    self->for_nothing = self->fd >= 0;
    if (self->fd < 0 && errno == EEXIST) {
        self->fd = open(path, flags | O_CREAT, FILE_MODE); /* a link to nothing is followed */
    }
    return self->fd >= 0 ? 0 : errno;
}

/* A file system that cannot lock is no reason to do without a trace. */
static int keep_off(int fd, const char *path, struct lx_error *error)
{
    struct stat info;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode) || lx_file_hold(fd) != EAGAIN) {
        return 0;
    }
    return lx_fail(error, "%s: in use already; expected another file", path);
}

static int open_wanted(struct lx_file *self, const struct lx_file_wanted *wanted,
                       struct lx_error *error)
{
    const char *path = wanted->path;
    const int reason =
        wanted->folder == NULL ? open_to_write(self, path) : open_below_to_write(self, wanted);
    if (reason == 0) {
        return keep_off(self->fd, path, error);
    }
    if (wanted->folder == NULL) {
        return lx_fail(error, "%s: cannot open: %s", path, strerror(reason));
    }
    return reason != EEXIST
               ? refuse_below(wanted->folder, path, reason, error)
               : lx_fail(error, "%.36s: exists, and is not to be replaced; expected a new name",
                         path);
}

static int close_file(void *cookie)
{
    struct lx_file *self = cookie;
    if (self->held && self->for_nothing) {
        (void)unlink(self->path);
    }
    const int result = self->fd >= 0 ? close(self->fd) : 0;
    free(self->bytes);
    free(self);
    return result;
}

/* @return how much is written; less than `n`: errno says why */
static size_t write_all(int fd, const char *bytes, size_t n)
{
    size_t done = 0;
    while (done < n) {
        const ssize_t now = write(fd, bytes + done, n - done);
        if (now == 0 || (now < 0 && errno != EINTR)) {
            break;
        }
        done += now > 0 ? (size_t)now : 0u;
    }
    return done;
}

/* As fopencookie() has it: less than `n` is an error. */
static ssize_t write_file(void *cookie, const char *bytes, size_t n)
{
    struct lx_file *self = cookie;
    if (!self->held) {
        return (ssize_t)write_all(self->fd, bytes, n);
    }
    char *more = realloc(self->bytes, self->length + n);
    if (more == NULL) {
        return 0;
    }
    memcpy(more + self->length, bytes, n);
    self->bytes = more;
    self->length += n;
    return (ssize_t)n;
}

static struct lx_file *make_file(const struct lx_file_wanted *wanted, struct lx_error *error)
{
    const size_t size = strlen(wanted->path) + 1;
    struct lx_file *self = calloc(1, sizeof *self + size);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory", wanted->path);
        return NULL;
    }
    memcpy(self->path, wanted->path, size);
    self->held = true;
    if (open_wanted(self, wanted, error) != 0) {
        (void)close_file(self);
        return NULL;
    }
    return self;
}

FILE *lx_file_create(const struct lx_file_wanted *wanted, struct lx_file **held,
                     struct lx_error *error)
{
    const cookie_io_functions_t operations = {.write = write_file, .close = close_file};
    struct lx_file *self = make_file(wanted, error);
    if (self == NULL) {
        return NULL;
    }
    const int reason = held == NULL ? lx_file_release(self) : 0;
    FILE *stream = reason == 0 ? fopencookie(self, "w", operations) : NULL;
    if (stream == NULL) {
        (void)lx_fail(error, "%s: cannot write: %s", wanted->path,
                      strerror(reason != 0 ? reason : errno));
        (void)close_file(self);
        return NULL;
    }
    if (held != NULL) {
        *held = self;
    }
    return stream;
}

int lx_file_release(struct lx_file *self)
{
    struct stat info;
    if (fstat(self->fd, &info) == 0 && S_ISREG(info.st_mode) && ftruncate(self->fd, 0) != 0) {
        return errno;
    }
    if (write_all(self->fd, self->bytes, self->length) != self->length) {
        return errno;
    }
    self->held = false;
    free(self->bytes);
    self->bytes = NULL;
    self->length = 0;
    return 0;
}

/* --- files that are read --- */

FILE *lx_file_read(const struct lx_folder *folder, const char *path, struct lx_error *error)
{
    struct stat info;
    const int fd = folder != NULL ? open_below(folder, path, O_RDONLY)
                                  : open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) {
        (void)(folder != NULL ? refuse_below(folder, path, errno, error)
                              : lx_fail(error, "%s: cannot open: %s", path, strerror(errno)));
        return NULL;
    }
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        (void)lx_fail(error, "%s: expected a regular file", path);
        (void)close(fd);
        return NULL;
    }
    FILE *file = fdopen(fd, "r");
    if (file == NULL) {
        (void)lx_fail(error, "%s: cannot open: %s", path, strerror(errno));
        (void)close(fd);
    }
    return file;
}

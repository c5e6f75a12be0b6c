/* SPDX-License-Identifier: MIT */
/*
 * Two promises: what a sync acknowledged is on the disk, under the name the next start looks for,
 * and a file is either complete or not there. The lock is the kernel's, so it ends with the process
 * however that ends.
 */
#define _GNU_SOURCE
#include "nvm_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "beside.h"
#include "file.h"
#include "nvm_memory.h"

/* --- the memory operations --- */

/* What the file does not have reads FFh, as an erased EEPROM. 0 or an errno. */
static int read_bytes(int fd, uint8_t *to, size_t n, off_t at)
{
    while (n > 0) {
        const ssize_t done = pread(fd, to, n, at);
        if (done < 0 && errno == EINTR) {
            continue;
        }
        if (done < 0) {
            return errno;
        }
        if (done == 0) {
            memset(to, 0xFF, n);
            return 0;
        }
        to += done;
        at += done;
        n -= (size_t)done;
    }
    return 0;
}

/* One line when it starts to fail, one when it works again. A sync ends the trouble, not a write:
   only then the bytes are known to be there. */
static int report_trouble(struct lx_nvm_file *self, const char *trouble, bool synced)
{
    if (trouble != NULL && !self->failing) {
        self->failing = true;
        lx_complain("%s: %s; %s until it works again", self->path, trouble, self->answer);
    } else if (trouble == NULL && synced && self->failing) {
        self->failing = false;
        lx_complain("%s: works again", self->path);
    }
    return trouble == NULL ? DG_OK : DG_ERR_IO;
}

static int read_file(void *ctx, uint32_t address, void *to, size_t n)
{
    const struct lx_nvm_file *self = ctx;
    return lx_nvm_read(self->bytes, self->size, address, to, n);
}

/* What has been done to the name of the file, in words: the next start would not find what is
   written now. NULL: nothing, or it cannot be seen. */
static const char *lost(const struct lx_nvm_file *self, const struct stat *own)
{
    struct stat named;
    if (stat(self->path, &named) == 0) {
        const bool same = named.st_ino == own->st_ino && named.st_dev == own->st_dev;
        return same ? NULL : "replaced while in use (a restart takes the other one)";
    }
    if (own->st_nlink == 0) {
        return "deleted while in use (a restart makes a new one)";
    }
    return errno == ENOENT || errno == ENOTDIR ? "moved while in use (move it back)" : NULL;
}

/* Nobody else may write a file that is locked, but whoever does not ask can cut it off. */
static void look_at_length(struct lx_nvm_file *self, const struct stat *own)
{
    if (own->st_size < (off_t)self->length && !self->suspect) {
        self->suspect = true;
        lx_complain("%s: truncated to %lld bytes while in use; the whole file is written again",
                    self->path, (long long)own->st_size);
    }
}

/* Whether it is still there and whole. @return NULL, or what is wrong, in words */
static const char *inspect_file(struct lx_nvm_file *self)
{
    struct stat own;
    if (fstat(self->fd, &own) != 0) {
        return strerror(errno);
    }
    look_at_length(self, &own);
    return lost(self, &own);
}

/* A write beyond the end of a cut-off file would leave zeros before it. */
static int fill_gap(struct lx_nvm_file *self, uint32_t address)
{
    const uint8_t erased = 0xFF;
    int reason = 0;
    while (reason == 0 && self->length < address) {
        reason = lx_file_write(self->fd, &erased, 1, (off_t)self->length);
        self->length += reason == 0 ? 1u : 0u;
    }
    return reason;
}

/* What fails halfway is made good by the next sync. 0 or an errno. */
static int write_bytes(struct lx_nvm_file *self, uint32_t address, const void *from, size_t n)
{
    int reason = fill_gap(self, address);
    if (reason == 0) {
        reason = lx_file_write(self->fd, from, n, (off_t)address);
    }
    if (reason != 0) {
        self->suspect = true;
        return reason;
    }
    memcpy(self->bytes + address, from, n);
    const uint32_t end = address + (uint32_t)n;
    self->length = self->length < end ? end : self->length;
    return 0;
}

static int write_file(void *ctx, uint32_t address, const void *from, size_t n)
{
    struct lx_nvm_file *self = ctx;
    if (!lx_nvm_inside(self->size, address, n)) {
        return DG_ERR_IO;
    }
    const char *trouble = inspect_file(self);
    const int reason = trouble != NULL ? 0 : write_bytes(self, address, from, n);
    return report_trouble(self, reason != 0 ? strerror(reason) : trouble, false);
}

/* After a sync that failed Linux calls pages clean that never reached the medium, and the next sync
   succeeds without them: then only what is written again is known to be there. 0 or an errno. */
static int flush_file(struct lx_nvm_file *self)
{
    int reason = 0;
    if (self->suspect) {
        reason = lx_file_write(self->fd, self->bytes, self->length, 0);
    }
    if (reason == 0 && fdatasync(self->fd) != 0) {
        reason = errno;
    }
    self->suspect = reason != 0;
    return reason;
}

static int sync_file(void *ctx)
{
    struct lx_nvm_file *self = ctx;
    const char *trouble = inspect_file(self);
    const int reason = trouble != NULL ? 0 : flush_file(self);
    return report_trouble(self, reason != 0 ? strerror(reason) : trouble, true);
}

static const struct dg_nvm_ops file_ops = {
    .read = read_file,
    .write = write_file,
    .sync = sync_file,
};

/* --- opening --- */

static int refuse_held_file(const struct lx_nvm_file *self, pid_t holder, struct lx_error *error)
{
    if (holder == 0) {
        return lx_fail(error, "%s: in use by another process; try again", self->path);
    }
    if (holder == getpid()) {
        return lx_fail(error,
                       "%s: in use by another encoder, trace or recording; give every encoder a "
                       "file of its own",
                       self->path);
    }
    return lx_fail(error, "%s: in use by process %ld; give every encoder a file of its own",
                   self->path, (long)holder);
}

/* A file that has lost its name meanwhile has been replaced by another, see below. */
static int lock_file(const struct lx_nvm_file *self, struct lx_error *error)
{
    const int reason = lx_file_hold(self->fd);
    struct stat info;
    if (reason == 0) {
        const bool named = fstat(self->fd, &info) == 0 && info.st_nlink > 0;
        return named ? 0 : refuse_held_file(self, 0, error);
    }
    /* Anything but this is a file system that cannot lock: then nobody is safe. */
    return reason == EAGAIN ? refuse_held_file(self, lx_file_holder(self->fd), error)
                            : lx_fail(error, "%s: cannot lock: %s", self->path, strerror(reason));
}

/* An empty file is refused with the ones that are too long: whoever made it meant something else.
   A short one may be an image whose end is lost; the caller looks. */
static int check_file_kind(struct lx_nvm_file *self, struct lx_error *error)
{
    struct stat info;
    if (fstat(self->fd, &info) != 0) {
        return lx_fail(error, "%s: %s", self->path, strerror(errno));
    }
    if (!S_ISREG(info.st_mode)) {
        return lx_fail(error, "%s: not a regular file; give the name of a new one", self->path);
    }
    if (info.st_size == 0 || info.st_size > (off_t)self->size) {
        return lx_fail(error,
                       "%s: %lld bytes, an image of this encoder has %lu; give a file made "
                       "by drehgeber, or the name of a new one",
                       self->path, (long long)info.st_size, (unsigned long)self->size);
    }
    self->length = (uint32_t)info.st_size;
    return 0;
}

/* Once the file is ours. */
static int claim_file(struct lx_nvm_file *self, struct lx_error *error)
{
    const int reason = read_bytes(self->fd, self->bytes, self->size, 0);
    return reason == 0 ? 0 : lx_fail(error, "%s: cannot read: %s", self->path, strerror(reason));
}

static int open_existing(struct lx_nvm_file *self, struct lx_error *error)
{
    /* Neither a FIFO nor a terminal may hold up or take over the process before it is refused. */
    self->fd = open(self->path, O_RDWR | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (self->fd < 0) {
        return lx_refuse(error, lx_more_of(errno), "%s: cannot open: %s", self->path,
                         strerror(errno));
    }
    return check_file_kind(self, error) != 0 || lock_file(self, error) != 0
               ? -1
               : claim_file(self, error);
}

/* Give a file its name if nobody has it, in one step that needs no hard links. Network and user
   space file systems that cannot do that may be able to link. 0 or an errno; EOPNOTSUPP: neither.
 */
static int name_file(const char *from, const char *to)
{
    if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0) {
        return 0;
    }
    if (errno != EINVAL && errno != ENOSYS && errno != EOPNOTSUPP) {
        return errno;
    }
    if (link(from, to) != 0) {
        const bool none = errno == EPERM || errno == ENOSYS || errno == EINVAL;
        return none ? EOPNOTSUPP : errno;
    }
    (void)unlink(from);
    return 0;
}

/* Of two processes that create it one wins. Locked before it gets its name: a lock on a private
   file cannot be refused by others. 0 or an errno. */
static int create_file(struct lx_nvm_file *self, const struct lx_nvm_image *image)
{
    struct lx_beside beside;
    int reason = lx_beside_make(&beside, self->path, image->bytes, image->size);
    if (reason == 0) {
        reason = lx_file_hold(beside.fd);
    }
    if (reason == 0) {
        reason = name_file(beside.name, self->path);
    }
    if (reason != 0) {
        lx_beside_remove(&beside);
        return reason;
    }
    self->fd = beside.fd;
    self->created = true;
    return lx_beside_sync(&beside);
}

static int refuse_creation(const struct lx_nvm_file *self, int reason, struct lx_error *error)
{
    if (reason != EOPNOTSUPP) {
        return lx_refuse(error, lx_more_of(reason), "%s: cannot create: %s", self->path,
                         strerror(reason));
    }
    return lx_fail(error,
                   "%s: cannot create: this file system has neither hard links nor a rename that "
                   "keeps an existing file; make the file on another one and copy it here",
                   self->path);
}

static int open_or_create(struct lx_nvm_file *self, const struct lx_nvm_image *image,
                          struct lx_error *error)
{
    if (access(self->path, F_OK) == 0) {
        return open_existing(self, error);
    }
    const int reason = create_file(self, image);
    if (reason == EEXIST) { /* somebody else was faster, or it is a dangling link */
        return open_existing(self, error);
    }
    if (reason != 0) {
        return refuse_creation(self, reason, error);
    }
    self->length = image->size;
    memcpy(self->bytes, image->bytes, image->size);
    return 0;
}

int lx_nvm_file_open(struct lx_nvm_file *self, const char *path, const struct lx_nvm_image *image,
                     struct lx_error *error)
{
    *self =
        (struct lx_nvm_file){.path = path, .answer = image->answer, .fd = -1, .size = image->size};
    self->bytes = malloc(image->size);
    const int result = self->bytes == NULL ? lx_fail(error, "%s: no memory", path)
                                           : open_or_create(self, image, error);
    if (result != 0) {
        lx_nvm_file_unmake(self);
        lx_nvm_file_close(self);
    }
    return result;
}

void lx_nvm_file_unmake(struct lx_nvm_file *self)
{
    struct stat own;
    struct stat named;
    if (self->created && fstat(self->fd, &own) == 0 && lstat(self->path, &named) == 0 &&
        named.st_ino == own.st_ino && named.st_dev == own.st_dev) {
        (void)unlink(self->path);
    }
    self->created = false;
}

int lx_nvm_file_replace(struct lx_nvm_file *self, const uint8_t *bytes, struct lx_error *error)
{
    int fd = -1;
    const int reason = lx_file_replace(self->path, bytes, self->size, 0, &fd);
    if (reason != 0) {
        if (fd >= 0) {
            (void)close(fd);
        }
        return lx_fail(error, "%s: cannot write it again: %s", self->path, strerror(reason));
    }
    (void)close(self->fd);
    self->fd = fd;
    self->length = self->size;
    self->suspect = false;
    memcpy(self->bytes, bytes, self->size);
    return 0;
}

void lx_nvm_file_tell(const struct lx_nvm_file *self, uint32_t image, const struct lx_say *say)
{
    if (self->length < image) {
        lx_note(say, "%s: truncated, %lu of %lu bytes; missing bytes read FFh", self->path,
                (unsigned long)self->length, (unsigned long)image);
    }
    if (image < self->size) {
        lx_note(
            say,
            "%s: from an earlier release, which can no longer open it: grows from %lu to %lu bytes",
            self->path, (unsigned long)image, (unsigned long)self->size);
    }
}

void lx_nvm_file_close(struct lx_nvm_file *self)
{
    if (self->fd >= 0) {
        (void)close(self->fd);
    }
    self->fd = -1;
    free(self->bytes);
    self->bytes = NULL;
}

struct dg_nvm lx_nvm_file_port(struct lx_nvm_file *self)
{
    return (struct dg_nvm){&file_ops, self};
}

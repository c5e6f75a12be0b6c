/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Files that are complete before they have their name: whoever opens one sees all of it, or what
 * was there before.
 */
#ifndef DREHGEBER_LINUX_BESIDE_H
#define DREHGEBER_LINUX_BESIDE_H

#include <limits.h>
#include <stddef.h>
#include <sys/types.h>

/** A file in the folder of the one that it is to become. */
struct lx_beside {
    char folder[PATH_MAX];
    char name[PATH_MAX]; /**< its own, for now */
    int fd;              /**< -1: none was made */
};

/** Write all of `n` bytes at `at`. @return 0 or an errno */
int lx_file_write(int fd, const void *bytes, size_t n, off_t at);

/** Make a durable file with all of its content beside `path`, mode 0600. The caller gives it its
 * name, or removes it. @return 0 or an errno; to be removed then, too */
int lx_beside_make(struct lx_beside *self, const char *path, const void *bytes, size_t n);

/** Remove and close it, if there is one. */
void lx_beside_remove(struct lx_beside *self);

/** Make the name of what is in the folder durable, too. @return 0 or an errno */
int lx_beside_sync(const struct lx_beside *self);

/**
 * Let a regular file have this content instead of its own, or make it; where `path` is a link, the
 * file that it leads to.
 * @param mode of a file that is made; one that is there keeps its own; 0: one has to be there
 * @param fd NULL, or where the caller gets the open file, held (file.h)
 * @return 0; or an errno: what was there is as it was, unless only its folder cannot be synced
 */
int lx_file_replace(const char *path, const void *bytes, size_t n, mode_t mode, int *fd);

#endif

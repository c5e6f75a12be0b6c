/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "slow_disk.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmocka.h>

static pthread_mutex_t disk = PTHREAD_MUTEX_INITIALIZER;
static bool taken; /* by the test's own thread, which alone looks at it */

/* In the place of the C library's: it waits for whoever has the disk. */
int fdatasync(int fd)
{
    (void)pthread_mutex_lock(&disk);
    (void)pthread_mutex_unlock(&disk);
    return (int)syscall(SYS_fdatasync, fd);
}

void slow_disk_take(void)
{
    (void)pthread_mutex_lock(&disk);
    taken = true;
}

void slow_disk_give(void)
{
    if (taken) {
        (void)pthread_mutex_unlock(&disk);
    }
    taken = false;
}

void slow_disk_make_folder(char folder[SLOW_DISK_FOLDER], char key[SLOW_DISK_KEY])
{
    (void)strcpy(folder, "/tmp/slow_disk.XXXXXX");
    assert_non_null(mkdtemp(folder));
    (void)snprintf(key, SLOW_DISK_KEY, "nvm = %s/a", folder);
}

void slow_disk_remove_folder(const char *folder)
{
    char path[SLOW_DISK_FOLDER + 2];

    if (folder[0] != '\0') {
        (void)snprintf(path, sizeof path, "%s/a", folder);
        (void)unlink(path);
        (void)rmdir(folder);
    }
}

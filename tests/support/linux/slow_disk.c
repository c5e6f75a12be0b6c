/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "slow_disk.h"

#include <pthread.h>
#include <stdbool.h>
#include <sys/syscall.h>
#include <unistd.h>

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

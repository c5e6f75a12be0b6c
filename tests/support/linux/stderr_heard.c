/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "stderr_heard.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmocka.h>

void stderr_hear(struct stderr_heard *self)
{
    self->fd = memfd_create("stderr", MFD_CLOEXEC);
    self->old = dup(STDERR_FILENO);
    assert_true(self->fd >= 0 && self->old >= 0 && dup2(self->fd, STDERR_FILENO) >= 0);
}

void stderr_heard(struct stderr_heard *self, char *text, size_t size)
{
    assert_true(dup2(self->old, STDERR_FILENO) >= 0);
    const ssize_t n = pread(self->fd, text, size - 1, 0);
    assert_true(n >= 0);
    text[n] = '\0';
    (void)close(self->fd);
    (void)close(self->old);
}

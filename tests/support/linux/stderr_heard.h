/* SPDX-License-Identifier: MIT */
/** What this process says on stderr, for a while. */
#ifndef SUPPORT_STDERR_HEARD_H
#define SUPPORT_STDERR_HEARD_H

#include <stddef.h>

/** The while. */
struct stderr_heard {
    int fd;  /**< a file of no name */
    int old; /**< stderr as it was */
};

/** From now on it goes to `self`. */
void stderr_hear(struct stderr_heard *self);

/** No longer. @param text  what was said, as far as there is room */
void stderr_heard(struct stderr_heard *self, char *text, size_t size);

#endif

/* SPDX-License-Identifier: MIT */
#include "descriptors.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static unsigned noted;

/* The folder's own is one of them each time. */
unsigned descriptors_open(void)
{
    unsigned count = 0;
    DIR *folder = opendir("/proc/self/fd");
    assert_non_null(folder);
    while (readdir(folder) != NULL) {
        count++;
    }
    (void)closedir(folder);
    return count;
}

int descriptors_note(void **state)
{
    (void)state;
    noted = descriptors_open();
    return 0;
}

void no_descriptor_is_left(void **state)
{
    (void)state;
    assert_int_equal(descriptors_open(), noted);
}

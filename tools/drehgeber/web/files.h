/* SPDX-License-Identifier: MIT */
/* The page: files of platform/web that the build has put into this program. */
#ifndef DREHGEBER_WEB_FILES_H
#define DREHGEBER_WEB_FILES_H

#include <stddef.h>

struct web_file {
    const char *path; /* "/" is the page itself */
    const char *type;
    const unsigned char *bytes;
    size_t size;
};

extern const struct web_file web_files[];
extern const size_t web_file_count;

#endif

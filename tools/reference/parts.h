/* SPDX-License-Identifier: MIT */
/* Programs that print parts of pages, which ../reference/update puts into them. */
#ifndef TOOLS_REFERENCE_PARTS_H
#define TOOLS_REFERENCE_PARTS_H

#include <stdio.h>
#include <string.h>

/* A part that is asked for by its name. */
struct part {
    const char *name;
    int (*print)(void); /* @return the exit status */
};

/* What argv asks for. @return the exit status: 2 when there is no such part */
static inline int print_one(int argc, char **argv, const struct part *parts, size_t count)
{
    for (size_t i = 0; argc == 2 && i < count; i++) {
        if (strcmp(argv[1], parts[i].name) == 0) {
            return parts[i].print();
        }
    }
    (void)fprintf(stderr, "usage: %s", argv[0]);
    for (size_t i = 0; i < count; i++) {
        (void)fprintf(stderr, "%c%s", i == 0 ? ' ' : '|', parts[i].name);
    }
    (void)fputc('\n', stderr);
    return 2;
}

#endif

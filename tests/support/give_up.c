/* SPDX-License-Identifier: MIT */
#include "give_up.h"

#include <stdio.h>
#include <stdlib.h>

noreturn void give_up(const char *what, const char *which)
{
    (void)fprintf(stderr, "%s: %s\n", which, what);
    exit(1);
}

/* SPDX-License-Identifier: MIT */
#include "control_private.h"

static char folded(char c)
{
    if (c == '-') {
        return '_';
    }
    return dg_text_upper(c);
}

bool dg_control_same(const char *a, const char *b)
{
    return dg_text_same(a, b, SIZE_MAX, folded);
}

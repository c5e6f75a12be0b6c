/* SPDX-License-Identifier: MIT */
#include "columns.h"

#include <stdio.h>
#include <string.h>

/* How much of `text` goes into a line of `width` columns: up to a blank, if there is one. */
static int line_length(const char *text, int width)
{
    int length = (int)strlen(text);
    if (length <= width) {
        return length;
    }
    for (length = width; length > 0 && text[length] != ' '; length--) {
    }
    return length > 0 ? length : width;
}

void columns_put(const char *text, int column, int at, int width)
{
    while (*text != '\0') {
        const int length = line_length(text, width - at);
        (void)printf("%*s%.*s\n", at - column, "", length, text);
        text += length + (text[length] == ' ' ? 1 : 0);
        column = 0;
    }
}

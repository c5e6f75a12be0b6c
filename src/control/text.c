/* SPDX-License-Identifier: MIT */
#include "control_private.h"

struct control_text control_text_in(char *to, size_t size)
{
    to[0] = '\0';
    return (struct control_text){.to = to, .size = size};
}

void control_append(struct control_text *self, const char *text)
{
    for (; *text != '\0' && self->length + 1u < self->size; text++) {
        self->to[self->length++] = *text;
    }
    self->to[self->length] = '\0';
}

static char folded(char c)
{
    if (c == '-') {
        return '_';
    }
    if (c >= 'A' && c <= 'Z') {
        return (char)(c - 'A' + 'a');
    }
    return c;
}

bool control_same(const char *a, const char *b)
{
    while (*a != '\0' && folded(*a) == folded(*b)) {
        a++;
        b++;
    }
    return *a == *b;
}

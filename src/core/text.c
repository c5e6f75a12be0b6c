/* SPDX-License-Identifier: MIT */
#include "drehgeber/text.h"

struct dg_text dg_text_in(char *to, size_t size)
{
    to[0] = '\0';
    return (struct dg_text){.to = to, .size = size};
}

void dg_text_add(struct dg_text *self, const char *text)
{
    dg_text_add_n(self, text, self->size);
}

void dg_text_add_n(struct dg_text *self, const char *text, size_t n)
{
    for (size_t i = 0; i < n && text[i] != '\0' && self->length + 1u < self->size; i++) {
        self->to[self->length++] = text[i];
    }
    self->to[self->length] = '\0';
}

char dg_text_upper(char c)
{
    if (c >= 'a' && c <= 'z') {
        return (char)(c - 'a' + 'A');
    }
    return c;
}

static char itself(char c)
{
    return c;
}

bool dg_text_same(const char *a, const char *b, size_t n, dg_text_fold *fold)
{
    dg_text_fold *const as = fold == NULL ? itself : fold;

    for (size_t i = 0; i < n; i++) {
        if (as(a[i]) != as(b[i])) {
            return false;
        }
        if (a[i] == '\0') {
            return true;
        }
    }
    return true;
}

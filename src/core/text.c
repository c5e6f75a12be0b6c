/* SPDX-License-Identifier: MIT */
#include "drehgeber/text.h"

#include <stdint.h>

struct dg_text dg_text_in(char *to, size_t size)
{
    to[0] = '\0';
    return (struct dg_text){.to = to, .size = size};
}

/* With a limit: of a loop without one a compiler makes strlen(), which is not there. */
size_t dg_text_length(const char *text, size_t max)
{
    size_t n = 0;

    while (n < max && text[n] != '\0') {
        n++;
    }
    return n;
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

static bool is_small(char c)
{
    return dg_text_upper(c) != c;
}

static bool same_letter(char a, char b)
{
    return dg_text_upper(a) == dg_text_upper(b);
}

static unsigned smaller(unsigned a, unsigned b)
{
    return a < b ? a : b;
}

/* A line of the table for each character of the word, the last three of them: here[i] is what the
   word up to there makes of the first `i` characters. */
unsigned dg_text_edits(const char *word, size_t length, const char *text, size_t n, bool brief)
{
    uint16_t lines[3][DG_TEXT_EDITS_MAX + 1u];
    uint16_t *here = lines[0];
    uint16_t *above = lines[1];
    uint16_t *before = lines[2]; /* the line above that */

    if (n > DG_TEXT_EDITS_MAX) {
        return ~0u;
    }
    for (size_t i = 0; i <= n; i++) {
        here[i] = (uint16_t)i;
    }
    for (size_t k = 0; k < length; k++) {
        const unsigned left_out = brief && is_small(word[k]) ? 0u : 1u;
        uint16_t *const oldest = before;
        before = above;
        above = here;
        here = oldest;
        here[0] = (uint16_t)(above[0] + left_out);
        for (size_t i = 1; i <= n; i++) {
            const unsigned other = same_letter(word[k], text[i - 1u]) ? 0u : 1u;
            unsigned least = smaller(above[i] + left_out, here[i - 1u] + 1u);
            least = smaller(least, above[i - 1u] + other);
            if (k > 0 && i > 1u && same_letter(word[k - 1u], text[i - 1u]) &&
                same_letter(word[k], text[i - 2u])) {
                least = smaller(least, before[i - 2u] + 1u);
            }
            here[i] = (uint16_t)least;
        }
    }
    return here[n];
}

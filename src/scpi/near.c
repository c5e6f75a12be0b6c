/* SPDX-License-Identifier: MIT */
/*
 * What would be right: for headers that are none, words that are not among those of a command.
 */
#include "scpi_private.h"

/* So many characters of a keyword have to agree. */
#define AGREED 4u

static bool is_between(char c)
{
    return c == ':' || c == '[' || c == ']';
}

static size_t keyword_length(const char *keyword)
{
    size_t n = 0;

    while (keyword[n] != '\0' && !is_between(keyword[n])) {
        n++;
    }
    return n;
}

/* Whether the `n` characters are a form of the keyword, or begin as it does. */
static bool is_near(const char *keyword, const char *text, size_t n)
{
    const size_t length = keyword_length(keyword);

    return scpi_is_form(keyword, length, text, n) ||
           (n >= AGREED && length >= AGREED && dg_text_same(keyword, text, AGREED, dg_text_upper));
}

static bool has_keyword(const char *pattern, const char *text, size_t n)
{
    bool begins = true;

    for (; *pattern != '\0'; pattern++) {
        if (begins && !is_between(*pattern) && is_near(pattern, text, n)) {
            return true;
        }
        begins = is_between(*pattern);
    }
    return false;
}

static const struct dg_scpi_command *row_near(const struct dg_scpi *self, const char *text,
                                              size_t n)
{
    const struct dg_scpi_commands *list;

    for (size_t i = 0; n > 0 && (list = scpi_commands(self, i)) != NULL; i++) {
        for (size_t j = 0; j < list->count; j++) {
            if (has_keyword(list->rows[j].header, text, n)) {
                return &list->rows[j];
            }
        }
    }
    return NULL;
}

/* The last keyword says most of what is meant. */
static const struct dg_scpi_command *nearest(const struct dg_scpi *self, const char *header,
                                             size_t n)
{
    const struct dg_scpi_command *found = NULL;

    while (n > 0 && found == NULL) {
        size_t begin = n;
        while (begin > 0 && header[begin - 1u] != ':') {
            begin--;
        }
        found = row_near(self, &header[begin], n - begin);
        n = begin > 0 ? begin - 1u : 0;
    }
    return found;
}

static void add_usage(struct dg_text *detail, const struct dg_scpi_command *row, bool query)
{
    const char *pieces[SCPI_USAGE];

    scpi_usage(row, query, pieces);
    for (size_t i = 0; i < SCPI_USAGE; i++) {
        dg_text_add(detail, pieces[i]);
    }
}

void scpi_refuse_header(struct dg_scpi *self, const char *header, size_t n, bool query)
{
    const size_t bare = n - (query ? 1u : 0u);
    const struct dg_scpi_command *other = scpi_find(self, header, bare, !query);
    const struct dg_scpi_command *near = other == NULL ? nearest(self, header, bare) : other;
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    dg_text_add_n(&detail, header, n);
    if (near == NULL) {
        dg_text_add(&detail, n == 0 ? "SYSTem:HELP? has all" : "; SYSTem:HELP? has all");
    } else {
        dg_text_add(&detail, other != NULL ? "; right is " : "; near is ");
        add_usage(&detail, near, near->set == NULL || (query && near->query != NULL && !other));
    }
    dg_scpi_raise(self, DG_SCPI_UNDEFINED, detail.to);
}

void scpi_refuse_word(struct dg_scpi *self, int code, const char *const *words, size_t count)
{
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    dg_text_add_n(&detail, &self->line[self->at], scpi_token(self));
    for (size_t i = 0; i < count; i++) {
        dg_text_add(&detail, i == 0 ? "; " : i + 1u == count ? " or " : ", ");
        dg_text_add(&detail, words[i]);
    }
    dg_text_add(&detail, " is right");
    dg_scpi_raise(self, code, detail.to);
}

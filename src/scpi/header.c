/* SPDX-License-Identifier: MIT */
/*
 * Headers and words in long and short form (SCPI-99 volume 1, 6.2.1): the short form is what stands
 * in front of the first small letter.
 */
#include "scpi_private.h"

/* Of a text that a host hands over. */
#define TEXT_MAX UINT16_MAX

/* Bounded, so that no compiler takes the loop for strlen() and calls that. */
size_t dg_scpi_length(const char *text)
{
    size_t n = 0;

    while (n < TEXT_MAX && text[n] != '\0') {
        n++;
    }
    return n;
}

bool dg_scpi_is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_small(char c)
{
    return c >= 'a' && c <= 'z';
}

bool dg_scpi_is_form(const char *name, size_t name_length, const char *text, size_t n)
{
    size_t brief = 0;

    while (brief < name_length && !is_small(name[brief])) {
        brief++;
    }
    return (n == brief || n == name_length) && dg_text_same(name, text, n, dg_text_upper);
}

static bool is_between(char c)
{
    return c == ':' || c == '[' || c == ']';
}

const char *dg_scpi_next_node(const char *pattern, struct scpi_node *out)
{
    out->optional = false;
    while (is_between(*pattern)) {
        out->optional = out->optional || *pattern == '[';
        pattern++;
    }
    out->name = pattern;
    while (*pattern != '\0' && !is_between(*pattern)) {
        pattern++;
    }
    out->n = (size_t)(pattern - out->name);
    return pattern;
}

bool dg_scpi_matches(const char *pattern, const char *header, size_t n)
{
    const char *const end = header + n;
    struct scpi_node node;
    bool open = true; /* a node of the header is to come, if only an empty one */

    for (pattern = dg_scpi_next_node(pattern, &node); node.n > 0;
         pattern = dg_scpi_next_node(pattern, &node)) {
        const char *stop = header;
        while (stop < end && *stop != ':') {
            stop++;
        }
        if (open && dg_scpi_is_form(node.name, node.n, header, (size_t)(stop - header))) {
            open = stop < end;
            header = open ? stop + 1 : stop;
        } else if (!node.optional) {
            return false;
        }
    }
    return !open;
}

const struct dg_scpi_commands *dg_scpi_command_list(const struct dg_scpi *self, size_t index)
{
    return index == 0 ? &dg_scpi_own : self->setup.ops->commands(self, index - 1u);
}

static const struct dg_scpi_command *find_in(const struct dg_scpi_commands *list,
                                             const char *header, size_t n, bool query)
{
    for (size_t i = 0; i < list->count; i++) {
        const struct dg_scpi_command *row = &list->rows[i];
        if ((query ? row->query : row->set) != NULL && dg_scpi_matches(row->header, header, n)) {
            return row;
        }
    }
    return NULL;
}

const struct dg_scpi_command *dg_scpi_find(const struct dg_scpi *self, const char *header, size_t n,
                                           bool query)
{
    const struct dg_scpi_command *found = NULL;
    const struct dg_scpi_commands *list;

    for (size_t i = 0; found == NULL && (list = dg_scpi_command_list(self, i)) != NULL; i++) {
        found = find_in(list, header, n, query);
    }
    return found;
}

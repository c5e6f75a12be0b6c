/* SPDX-License-Identifier: MIT */
/*
 * What would be right: for headers that are none, words that are not among those of a command.
 */
#include "scpi_private.h"

/*
 * The nearest row is the one with the smallest sum of what differs, node by node; what differs by
 * more than LIMIT is not near.
 */
#define SKIP 4u       /* a node is missing, is misspelt, or called as what follows it */
#define EXTRA 5u      /* a node is too many: most who write one mean it */
#define ONE_MORE 1u   /* each further character of a misspelt node */
#define OTHER_FORM 5u /* a query was asked of what has none, or the other way round */
#define LIMIT 7u
#define FAR 100u
#define NODES_MAX 6u
/* So many characters of what a command takes are enough: VOLT, SPEED. */
#define TAKEN_MIN 4u

/* A header, taken apart; no node: nothing is near. */
struct header {
    const char *node[NODES_MAX];
    size_t length[NODES_MAX];
    size_t count;
};

static unsigned smaller(unsigned a, unsigned b)
{
    return a < b ? a : b;
}

/* Two of five characters may be wrong, and one of two. */
static unsigned node_cost(const struct dg_scpi_command *row, const struct scpi_node *keyword,
                          const char *text, size_t n)
{
    const unsigned edits = dg_text_edits(keyword->name, keyword->n, text, n, true);

    if (edits == 0) {
        return 0;
    }
    if (n >= TAKEN_MIN && dg_text_same(row->parameters, text, n, dg_text_upper)) {
        return SKIP;
    }
    return edits > (2u * n + 1u) / 5u ? FAR : SKIP + ONE_MORE * (edits - 1u);
}

static unsigned row_cost(const struct dg_scpi_command *row, const struct header *header)
{
    unsigned cost[NODES_MAX + 1u];
    struct scpi_node keyword;

    for (unsigned i = 0; i <= header->count; i++) {
        cost[i] = EXTRA * i;
    }
    for (const char *rest = dg_scpi_next_node(row->header, &keyword); keyword.n > 0;
         rest = dg_scpi_next_node(rest, &keyword)) {
        const unsigned left_out = keyword.optional ? 0u : SKIP;
        unsigned before = cost[0];
        cost[0] += left_out;
        for (size_t i = 0; i < header->count; i++) {
            const unsigned changed =
                before + node_cost(row, &keyword, header->node[i], header->length[i]);
            before = cost[i + 1u];
            cost[i + 1u] = smaller(changed, smaller(cost[i + 1u] + left_out, cost[i] + EXTRA));
        }
    }
    return cost[header->count];
}

static bool is_of_header(char c)
{
    return dg_text_upper(c) != c || (c >= 'A' && c <= 'Z') || dg_scpi_is_digit(c) || c == ':' ||
           c == '_' || c == '*';
}

/* Up to what no header has; an empty node at the end is none. */
static struct header split_header(const char *text, size_t n)
{
    struct header header = {.count = 0};
    size_t end = 0;
    size_t begin = 0;

    while (end < n && is_of_header(text[end])) {
        end++;
    }
    while (end > 0 && text[end - 1u] == ':') {
        end--;
    }
    for (size_t i = 0; i <= end && end > 0; i++) {
        if (i < end && text[i] != ':') {
            continue;
        }
        if (header.count == NODES_MAX) {
            return (struct header){.count = 0};
        }
        header.node[header.count] = &text[begin];
        header.length[header.count++] = i - begin;
        begin = i + 1u;
    }
    return header;
}

static bool has_form(const struct dg_scpi_command *row, bool query)
{
    return (query ? row->query : row->set) != NULL;
}

/* @return the nearest row, the first of several; NULL: none is near */
static const struct dg_scpi_command *
nearest(const struct dg_scpi *self, const struct header *header, bool query, unsigned *cost)
{
    const struct dg_scpi_command *found = NULL;
    const struct dg_scpi_commands *list;

    *cost = LIMIT + 1u;
    for (size_t i = 0; header->count > 0 && (list = dg_scpi_command_list(self, i)) != NULL; i++) {
        for (size_t j = 0; j < list->count; j++) {
            const struct dg_scpi_command *row = &list->rows[j];
            const unsigned its = row_cost(row, header) + (has_form(row, query) ? 0u : OTHER_FORM);
            found = its < *cost ? row : found;
            *cost = smaller(its, *cost);
        }
    }
    return found;
}

void dg_scpi_refuse_header(struct dg_scpi *self, const char *header, size_t n, bool query)
{
    const struct header apart = split_header(header, n);
    unsigned cost;
    const struct dg_scpi_command *near = nearest(self, &apart, query, &cost);
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    dg_text_add_n(&detail, header, n);
    if (near == NULL) {
        dg_text_add(&detail, n == 0 ? "SYSTem:HELP? has all" : "; SYSTem:HELP? has all");
    } else {
        const bool fits = has_form(near, query);
        dg_text_add(&detail, !fits && cost == OTHER_FORM ? "; expected " : "; closest is ");
        dg_scpi_add_usage(&detail, near, fits ? query : !query);
    }
    dg_scpi_raise(self, DG_SCPI_UNDEFINED, detail.to);
}

void dg_scpi_refuse_word(struct dg_scpi *self, int code, const char *const *words, size_t count)
{
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    dg_text_add_n(&detail, &self->line[self->at], dg_scpi_token(self));
    for (size_t i = 0; i < count; i++) {
        dg_text_add(&detail, i == 0 ? "; expected " : i + 1u == count ? " or " : ", ");
        dg_text_add(&detail, words[i]);
    }
    dg_scpi_raise(self, code, detail.to);
}

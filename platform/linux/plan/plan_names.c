/* SPDX-License-Identifier: MIT */
/* The C library's balanced tree does the work. */
#define _GNU_SOURCE
#include "plan_names.h"

#include <ctype.h>
#include <search.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

struct row {
    struct lx_plan_name name; /* first: what is looked for is one without the rest */
    int index;
};

static int folded(char c)
{
    return c == '-' ? '_' : tolower((unsigned char)c);
}

static int compare_aliases(const char *a, const char *b)
{
    while (*a != '\0' && folded(*a) == folded(*b)) {
        a++;
        b++;
    }
    return folded(*a) - folded(*b);
}

static int compare_texts(enum lx_plan_list list, const char *a, const char *b)
{
    if (list == LX_PLAN_ALIAS) {
        return compare_aliases(a, b);
    }
    return list <= LX_PLAN_ENCODER ? strcasecmp(a, b) : strcmp(a, b);
}

static int compare(const void *a, const void *b)
{
    const struct lx_plan_name *left = a;
    const struct lx_plan_name *right = b;
    if (left->list != right->list) {
        return left->list < right->list ? -1 : 1;
    }
    if (left->scope != right->scope) {
        return left->scope < right->scope ? -1 : 1;
    }
    return compare_texts(left->list, left->text, right->text);
}

int lx_plan_names_find(const struct lx_plan_names *self, const struct lx_plan_name *name)
{
    struct row *const *found = tfind(name, &self->root, compare);
    return found == NULL ? -1 : (*found)->index;
}

int lx_plan_names_add(struct lx_plan_names *self, const struct lx_plan_name *name, int index)
{
    struct row *row = malloc(sizeof *row);
    if (row == NULL) {
        return -1;
    }
    *row = (struct row){.name = *name, .index = index};
    struct row *const *there = tsearch(row, &self->root, compare);
    if (there == NULL || *there != row) {
        free(row);
    }
    return there == NULL ? -1 : 0;
}

void lx_plan_names_free(struct lx_plan_names *self)
{
    tdestroy(self->root, free);
    self->root = NULL;
}

/* SPDX-License-Identifier: MIT */
/*
 * [encoder NAME] of a rig file, or many of them: with node = FIRST..LAST, or another protocol's key
 * of its addresses, the section stands for one for each number, NAME-FIRST to NAME-LAST. What else
 * counts, counts up.
 */
#define _GNU_SOURCE
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "figure.h"
#include "plan_section.h"
#include "stacks.h"

#define BETWEEN ".."
/* A line of a rig file is shorter. */
#define LINE_MAX_CHARS 256u

/* The numbers of a section. */
struct range {
    const struct lx_plan_setting *word; /* FIRST..LAST; NULL: the section is one encoder */
    const struct lx_stack *stack;
    int first;
    int last;
};

static const struct lx_plan_setting *find_range(const struct lx_plan_section *self)
{
    for (size_t i = 0; i < self->words.count; i++) {
        const struct lx_plan_setting *word = &self->words.list[i];
        if (lx_is_address_key(word->key) && strstr(word->value, BETWEEN) != NULL) {
            return word;
        }
    }
    return NULL;
}

static int refuse(const struct lx_plan *plan, const struct range *self, struct lx_error *error)
{
    struct lx_words right = lx_stack_address_right(self->stack);
    lx_words_add(&right, ", or FIRST" BETWEEN "LAST, is right");
    (void)lx_refuse(error, right.text, "%s", "");
    (void)lx_about(error, LX_ABOUT_KEY, self->word->key, self->word->value);
    return lx_plan_refuse_key(plan, self->word->key, self->word->line, error);
}

/* @return 0, or -1 with `error` */
static int take_numbers(const struct lx_plan *plan, struct range *self, struct lx_error *error)
{
    const char *text = self->word->value;
    const char *between = strstr(text, BETWEEN);
    char first[16] = "";
    const size_t n = (size_t)(between - text);
    struct lx_error ignored; /* what is right is both of them */
    if (n >= sizeof first) {
        return refuse(plan, self, error);
    }
    memcpy(first, text, n);
    self->first = lx_stack_address(self->stack, first, &ignored);
    self->last = lx_stack_address(self->stack, between + strlen(BETWEEN), &ignored);
    return self->first < 0 || self->last < self->first ? refuse(plan, self, error) : 0;
}

/* Number `i` of the section, as it would be written by itself. */
struct one {
    struct lx_plan_section section;
    char number[16];
    char serial[24];
    char nvm[LINE_MAX_CHARS + 32u];
};

/* What counts has a value of its own; everything else is that of the section. */
static char *value_of(struct one *self, const struct range *range,
                      const struct lx_plan_setting *row, int at)
{
    uint64_t serial = 0;
    if (row == range->word) {
        return self->number;
    }
    if (strcmp(row->key, "serial") == 0 && lx_unsigned_parse(row->value, &serial)) {
        (void)snprintf(self->serial, sizeof self->serial, "%" PRIu64,
                       serial + (uint64_t)(at - range->first));
        return self->serial;
    }
    if (strcmp(row->key, "nvm") == 0) {
        (void)snprintf(self->nvm, sizeof self->nvm, "%.*s.%s", (int)LINE_MAX_CHARS, row->value,
                       self->number);
        return self->nvm;
    }
    return row->value;
}

static int take_one(struct lx_plan *plan, const struct lx_plan_section *all,
                    const struct range *range, int at, struct one *self, struct lx_error *error)
{
    const struct lx_plan_settings *words = &all->words;
    const bool hex = range->stack->address.hex;
    (void)snprintf(self->number, sizeof self->number, hex ? "0x%02X" : "%d", (unsigned)at);
    for (size_t i = 0; i < words->count; i++) {
        self->section.words.list[i].value = value_of(self, range, &words->list[i], at);
    }
    char name[sizeof all->name + sizeof self->number];
    (void)snprintf(name, sizeof name, "%s-%s", all->name, self->number);
    if (!lx_plan_name_fits(name)) {
        return lx_plan_wrong_section(plan, all, error, "a shorter name is right",
                                     "%s is too long for a name", name);
    }
    memcpy(self->section.name, name, strlen(name) + 1u);
    return lx_plan_take_encoder(plan, &self->section, error);
}

static int take_all(struct lx_plan *plan, const struct lx_plan_section *all,
                    const struct range *range, struct lx_error *error)
{
    struct one *one = malloc(sizeof *one);
    struct lx_plan_setting *list = calloc(all->words.count, sizeof *list);
    if (one == NULL || list == NULL) {
        free(list);
        free(one);
        return lx_plan_no_room(plan, all, error);
    }
    int result = 0;
    memcpy(list, all->words.list, all->words.count * sizeof *list);
    one->section = *all;
    one->section.words.list = list;
    for (int at = range->first; result == 0 && at <= range->last; at++) {
        result = take_one(plan, all, range, at, one, error);
    }
    free(list);
    free(one);
    return result;
}

int lx_plan_take_encoders(struct lx_plan *plan, const struct lx_plan_section *self,
                          struct lx_error *error)
{
    const struct lx_plan_setting *model = lx_plan_word(self, "model");
    const struct dg_device *device = model == NULL ? NULL : dg_device_find(model->value);
    struct range range = {.word = find_range(self)};
    if (range.word == NULL || device == NULL) {
        return lx_plan_take_encoder(plan, self, error);
    }
    range.stack = lx_stack_of(device);
    if (range.stack->core->address_key == NULL ||
        strcmp(range.stack->core->address_key, range.word->key) != 0) {
        return lx_plan_take_encoder(plan, self, error); /* which says that it has none */
    }
    const struct lx_plan_setting *wire = lx_plan_word(self, "wire");
    if (wire != NULL) {
        return lx_plan_wrong_word(plan, wire, error, "bus = NAME of a [bus] above is right",
                                  "several encoders have no wire of their own");
    }
    return take_numbers(plan, &range, error) == 0 ? take_all(plan, self, &range, error) : -1;
}

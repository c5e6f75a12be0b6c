/* SPDX-License-Identifier: MIT */
/*
 * Texts for messages, and what the reader asks of texts.
 */
#include "rig_private.h"

#include <string.h>

#define DELETE 0x7F

struct rig_number dg_plan_signed(int64_t value)
{
    struct rig_number number = {.text = ""};
    struct dg_text text = dg_text_in(number.text, sizeof number.text);

    dg_text_add_number(&text, value);
    return number;
}

struct rig_number dg_plan_number(size_t value)
{
    return dg_plan_signed((int64_t)value);
}

struct rig_cut dg_plan_cut(const char *text, size_t n)
{
    struct rig_cut cut = {.text = ""};
    struct dg_text to = dg_text_in(cut.text, sizeof cut.text);

    dg_text_add_n(&to, text, n);
    return cut;
}

void dg_plan_add(struct dg_text *to, rig_parts parts)
{
    for (; parts != NULL && *parts != NULL; parts++) {
        dg_text_add(to, *parts);
    }
}

void dg_plan_list_begin(struct rig_list *self)
{
    self->text = dg_text_in(self->room, sizeof self->room);
}

void dg_plan_list_item(struct rig_list *self, const char *word, size_t index, size_t count)
{
    if (index > 0) {
        dg_text_add(&self->text, index + 1u == count ? " or " : ", ");
    }
    dg_text_add(&self->text, word);
}

size_t dg_plan_length(const char *text)
{
    return dg_text_length(text, RIG_TEXT_MAX);
}

bool dg_plan_same(const char *a, const char *b)
{
    return dg_text_same(a, b, RIG_TEXT_MAX, NULL);
}

bool dg_plan_same_word(const char *a, const char *b)
{
    return dg_text_same(a, b, RIG_TEXT_MAX, dg_text_upper);
}

size_t dg_plan_span(const char *text, char c)
{
    size_t n = 0;

    while (text[n] != '\0' && text[n] != c) {
        n++;
    }
    return n;
}

bool dg_plan_begins(const char *text, const char *word)
{
    return dg_text_same(text, word, dg_plan_length(word), NULL);
}

bool dg_plan_ends(const char *text, size_t n, const char *end)
{
    const size_t length = dg_plan_length(end);

    return n > length && dg_text_same(text + n - length, end, length, dg_text_upper);
}

const char *dg_plan_find(const char *text, const char *what)
{
    for (; *text != '\0'; text++) {
        if (dg_plan_begins(text, what)) {
            return text;
        }
    }
    return NULL;
}

/* ---------------------------------------------------------------- errors */

/* What is quoted may be anything: it shall neither be two lines nor move a cursor. */
static void keep_to_the_line(char *text)
{
    for (; *text != '\0'; text++) {
        if ((unsigned char)*text < ' ' || *text == DELETE) {
            *text = '?';
        }
    }
}

static void write_parts(char *to, size_t size, rig_parts parts)
{
    struct dg_text text = dg_text_in(to, size);

    dg_plan_add(&text, parts);
    keep_to_the_line(to);
}

int dg_plan_refuse(struct dg_plan_error *error, rig_parts right, rig_parts what)
{
    memset(error, 0, sizeof *error);
    write_parts(error->what, sizeof error->what, what);
    write_parts(error->right, sizeof error->right, right);
    return -1;
}

int dg_plan_about(struct dg_plan_error *error, const char *key, const char *value)
{
    if (error->key[0] == '\0') {
        error->valued = value != NULL ? DG_PLAN_KEY_VALUE : DG_PLAN_UNVALUED;
        write_parts(error->key, sizeof error->key, RIG_SAY(key));
        write_parts(error->value, sizeof error->value, RIG_SAY(value));
    }
    return -1;
}

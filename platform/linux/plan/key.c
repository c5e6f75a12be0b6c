/* SPDX-License-Identifier: MIT */
#include "key.h"

#include <string.h>

#include "drehgeber/figure.h"
#include "drehgeber/hal.h"

/* Digits, sign and point of a number. */
#define NUMBER_MAX 32u

static bool is_text(const struct dg_key *key)
{
    return key->type == DG_KEY_TEXT || key->type == DG_KEY_DIGITS;
}

static bool is_word(const struct dg_key *key)
{
    return key->type == DG_KEY_FLAG || key->type == DG_KEY_WORD;
}

struct lx_words lx_key_range(const struct dg_key *key)
{
    struct lx_words range = {""};
    struct dg_text text = dg_text_in(range.text, sizeof range.text);
    dg_key_say_range(key, &text);
    return range;
}

/* --- setting --- */

int lx_key_set(const struct dg_key *key, void *base, const char *value, struct lx_error *error)
{
    struct lx_words right = {""};
    struct dg_text text = dg_text_in(right.text, sizeof right.text);
    if (dg_key_set(key, base, value) == DG_OK) {
        return 0;
    }
    dg_key_say_right(key, &text);
    return lx_refuse(error, right.text, "%s", "");
}

/* --- lists --- */

const struct dg_key *lx_keys_row(const struct lx_keys *self, size_t n)
{
    if (n >= self->count || (self->without >> n & 1u) != 0) {
        return NULL;
    }
    const struct dg_key *row = &self->rows[n];
    return self->instead != NULL && strcmp(self->instead->name, row->name) == 0 ? self->instead
                                                                                : row;
}

static const struct dg_key *find(const struct lx_keys *self, const char *name)
{
    for (size_t i = 0; i < self->count; i++) {
        const struct dg_key *row = lx_keys_row(self, i);
        if (row != NULL && strcmp(row->name, name) == 0) {
            return row;
        }
    }
    return NULL;
}

const struct dg_key *lx_keys_find(const struct lx_keys *lists, size_t n, const char *name,
                                  void **base)
{
    for (size_t i = 0; i < n; i++) {
        const struct dg_key *row = find(&lists[i], name);
        if (row != NULL && base != NULL) {
            *base = lists[i].base;
        }
        if (row != NULL) {
            return row;
        }
    }
    return NULL;
}

void lx_keys_name(const struct lx_keys *lists, size_t n, struct lx_words *to)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < lists[i].count; j++) {
            const struct dg_key *row = lx_keys_row(&lists[i], j);
            if (row != NULL) {
                lx_words_add(to, " %s", row->name);
            }
        }
    }
}

/* What could not be set stands for 'none'. */
static bool has_default(const struct dg_key *key, const char *text)
{
    struct dg_decimal number;
    if (is_word(key)) {
        return true;
    }
    return dg_decimal_parse(text, strlen(text), key->places, &number) && number.value >= key->min &&
           number.value <= key->max;
}

struct lx_words lx_key_value(const struct dg_key *key, const void *base)
{
    struct lx_words value = {""};
    char text[NUMBER_MAX];
    if (!is_text(key) && dg_key_get(key, base, text, sizeof text) > 0 && has_default(key, text)) {
        lx_words_add(&value, "%.*s", (int)strcspn(text, "."), text);
    }
    return value;
}

void lx_keys_help(const struct lx_keys *keys, FILE *to)
{
    for (size_t i = 0; i < keys->count; i++) {
        const struct dg_key *key = lx_keys_row(keys, i);
        if (key == NULL) {
            continue;
        }
        (void)fprintf(to, "  %-23s %s (%s", key->name, key->help, lx_key_range(key).text);
        struct lx_words value = {""};
        if (keys->base != NULL) {
            value = lx_key_value(key, keys->base);
        }
        (void)fprintf(to, "%s%s", value.text[0] == '\0' ? "" : ", default ", value.text);
        (void)fputs(")\n", to);
    }
}

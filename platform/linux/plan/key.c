/* SPDX-License-Identifier: MIT */
#include "key.h"

#include <string.h>

#include "drehgeber/figure.h"
#include "drehgeber/hal.h"

/* Digits, sign and point of a number. */
#define NUMBER_MAX 32u

static bool is_text_key(const struct dg_key *key)
{
    return key->type == DG_KEY_TEXT || key->type == DG_KEY_DIGITS;
}

static bool is_word_key(const struct dg_key *key)
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

/* What could not be set stands for 'none'. */
static bool has_default(const struct dg_key *key, const char *text)
{
    struct dg_decimal number;
    if (is_word_key(key)) {
        return true;
    }
    return dg_decimal_parse(text, strlen(text), key->places, &number) && number.value >= key->min &&
           number.value <= key->max;
}

struct lx_words lx_key_value(const struct dg_key *key, const void *base)
{
    struct lx_words value = {""};
    char text[NUMBER_MAX];
    if (!is_text_key(key) && dg_key_get(key, base, text, sizeof text) > 0 &&
        has_default(key, text)) {
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

/* SPDX-License-Identifier: MIT */
/*
 * What values a setting takes, in words: apart from setting it, which machines without a user do,
 * too.
 */
#include "drehgeber/figure.h"
#include "drehgeber/key.h"

static bool is_text_key(const struct dg_key *key)
{
    return key->type == DG_KEY_TEXT || key->type == DG_KEY_DIGITS;
}

static bool is_word_key(const struct dg_key *key)
{
    return key->type == DG_KEY_FLAG || key->type == DG_KEY_WORD;
}

/* "none, even or odd" */
static void say_words(const struct dg_key *key, struct dg_text *to)
{
    for (int64_t i = 0; i <= key->max; i++) {
        const char *last = i == key->max ? " or " : ", ";
        dg_text_add(to, i == 0 ? "" : last);
        dg_text_add(to, key->words[i]);
    }
}

/* "0..24", "4 to 8", "8" */
static void say_limits(const struct dg_key *key, struct dg_text *to)
{
    const int64_t one = dg_power_of_ten(key->places);

    dg_text_add_number(to, key->min / one);
    if (!is_text_key(key) || key->min != key->max) {
        dg_text_add(to, is_text_key(key) ? " to " : "..");
        dg_text_add_number(to, key->max / one);
    }
}

void dg_key_say_range(const struct dg_key *self, struct dg_text *to)
{
    static const char *const characters[] = {"characters", "digits"};
    const char *unit = is_text_key(self) ? characters[self->type == DG_KEY_DIGITS] : self->unit;

    if (is_word_key(self)) {
        say_words(self, to);
        return;
    }
    say_limits(self, to);
    dg_text_add(to, unit[0] == '\0' ? "" : " ");
    dg_text_add(to, unit);
}

void dg_key_say_right(const struct dg_key *self, struct dg_text *to)
{
    const bool number = !is_text_key(self) && !is_word_key(self);

    dg_text_add(to, number ? "expected a number in " : "expected ");
    dg_key_say_range(self, to);
    if (number && self->places > 0) {
        dg_text_add(to, " with at most ");
        dg_text_add_number(to, self->places);
        dg_text_add(to, " decimals");
    }
}

/* SPDX-License-Identifier: MIT */
#include "complain.h"

#include <string.h>

#include "say.h"
#include "wire.h"

/* Words of a plan that are called otherwise here. */
static const char *option_word_of(const char *key)
{
    return strcmp(key, "motion") == 0 ? "shaft" : key;
}

/* What may be left out stands behind '='. */
static const char *between(const char *kind)
{
    const struct dg_plan_wire_kind *wire = dg_plan_find_kind(kind, strlen(kind));
    return wire != NULL && lx_wire_is_optional(wire) ? "=" : " ";
}

struct lx_words complaint(const struct lx_error *error)
{
    const struct lx_where *where = &error->where;
    const struct lx_words reason = lx_error_reason(error);
    struct lx_words line = {""};
    if (where->line != 0) {
        return lx_error_line(error);
    }
    switch (where->about) {
    case LX_ABOUT_SETTING:
        lx_words_add(&line, "--set %s%s%s: ", where->key, where->valued ? "=" : "", where->value);
        break;
    case LX_ABOUT_WIRE:
        lx_words_add(&line, "--%s%s%s: ", where->key, where->valued ? between(where->key) : "",
                     where->value);
        break;
    case LX_ABOUT_KEY: /* a text that is about one without a value begins with the value */
        lx_words_add(&line, "--%s %s%s", option_word_of(where->key), where->value,
                     where->valued ? ": " : "");
        break;
    case LX_ABOUT_NOTHING:
    case LX_ABOUT_ITSELF:
    case LX_ABOUT_COUNT:
        break;
    }
    lx_words_add(&line, "%s", reason.text);
    return line;
}

int complain(const struct lx_error *error, int status)
{
    lx_complain("%s", complaint(error).text);
    return status;
}

/* SPDX-License-Identifier: MIT */
#include "error.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DELETE 0x7F

/* What is quoted may be anything: it shall neither be two lines nor move a cursor. */
static void keep_to_the_line(char *text)
{
    for (; *text != '\0'; text++) {
        if ((unsigned char)*text < ' ' || *text == DELETE) {
            *text = '?';
        }
    }
}

void lx_words_add(struct lx_words *self, const char *format, ...)
{
    const size_t used = strlen(self->text);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(self->text + used, sizeof self->text - used, format, arguments);
    va_end(arguments);
}

void lx_words_item(struct lx_words *self, const char *word, size_t index, size_t count,
                   const char *last)
{
    const char *between = index + 1 == count ? last : ", ";
    lx_words_add(self, "%s%s", index == 0 ? "" : between, word);
}

__attribute__((format(printf, 3, 0))) static int refuse_v(struct lx_error *error, const char *right,
                                                          const char *format, va_list arguments)
{
    struct lx_error made = {.right = ""};
    (void)vsnprintf(made.what, sizeof made.what, format, arguments);
    (void)snprintf(made.right, sizeof made.right, "%s", right == NULL ? "" : right);
    keep_to_the_line(made.what);
    keep_to_the_line(made.right);
    *error = made;
    return -1;
}

const char *lx_more_of(int reason)
{
    if (reason == EMFILE) {
        return "raise the limit of open files: ulimit -Hn, or LimitNOFILE= of a service";
    }
    return reason == ENFILE ? "raise fs.file-max" : NULL;
}

int lx_fail(struct lx_error *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int result = refuse_v(error, NULL, format, arguments);
    va_end(arguments);
    return result;
}

int lx_refuse(struct lx_error *error, const char *right, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int result = refuse_v(error, right, format, arguments);
    va_end(arguments);
    return result;
}

void *lx_allocate(size_t size, const char *what, struct lx_error *error)
{
    void *memory = calloc(1, size);
    if (memory == NULL) {
        (void)lx_fail(error, "no memory for %s", what);
    }
    return memory;
}

int lx_about(struct lx_error *error, enum lx_about about, const char *key, const char *value)
{
    struct lx_where *where = &error->where;
    if (where->about == LX_ABOUT_NOTHING) {
        where->about = about;
        where->valued = value != NULL;
        (void)snprintf(where->key, sizeof where->key, "%s", key);
        (void)snprintf(where->value, sizeof where->value, "%s", value == NULL ? "" : value);
        keep_to_the_line(where->key);
        keep_to_the_line(where->value);
    }
    return -1;
}

int lx_error_take(struct lx_error *error, const struct dg_plan_error *from)
{
    (void)lx_refuse(error, from->right, "%s", from->what);
    if (from->key[0] != '\0') {
        (void)lx_about(error, from->valued == DG_PLAN_SETTING ? LX_ABOUT_SETTING : LX_ABOUT_KEY,
                       from->key, from->valued != DG_PLAN_UNVALUED ? from->value : NULL);
    }
    memcpy(error->where.included, from->included, sizeof from->included);
    return lx_stands(error, from->file, from->line);
}

int lx_stands(struct lx_error *error, const char *file, unsigned line)
{
    struct lx_where *where = &error->where;
    if (where->line == 0 && file != NULL) {
        where->file = file;
        where->line = line;
    }
    return -1;
}

struct lx_words lx_error_reason(const struct lx_error *error)
{
    struct lx_words line = {""};
    const bool both = error->what[0] != '\0' && error->right[0] != '\0';
    lx_words_add(&line, "%s%s%s", error->what, both ? "; " : "", error->right);
    return line;
}

struct lx_words lx_error_line(const struct lx_error *error)
{
    static const char *const between[LX_ABOUT_COUNT] = {
        [LX_ABOUT_KEY] = " ", [LX_ABOUT_SETTING] = "=", [LX_ABOUT_WIRE] = ":"};
    const struct lx_where *where = &error->where;
    const struct lx_words reason = lx_error_reason(error);
    struct lx_words line = {""};
    if (where->file != NULL && where->line != 0) {
        const char *file = where->included[0] == '\0' ? where->file : where->included;
        lx_words_add(&line, "%.*s:%u: ", (int)LX_ERROR_VALUE_MAX, file, where->line);
    }
    if (where->about != LX_ABOUT_NOTHING && where->about != LX_ABOUT_ITSELF) {
        lx_words_add(&line, "%s%s%s: ", where->key, where->valued ? between[where->about] : "",
                     where->value);
    }
    lx_words_add(&line, "%s", reason.text);
    return line;
}

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Errors on their way to whoever tells the user: what was wrong, where it stands, what would be
 * right. Each part is added by who knows it, and they become one line at the top: with FILE:LINE
 * for a rig file, by lx_error_line(), with options for a command line, which knows them.
 */
#ifndef DREHGEBER_LINUX_ERROR_H
#define DREHGEBER_LINUX_ERROR_H

#include <stdbool.h>
#include <stddef.h>

#include "drehgeber/rig.h"

/** Longest key and value that an error names, with their zeros; what is longer is cut off. */
#define LX_ERROR_KEY_MAX 64u
#define LX_ERROR_VALUE_MAX 256u

/** What an error is about. */
enum lx_about {
    LX_ABOUT_NOTHING, /**< its text says */
    LX_ABOUT_KEY,     /**< a word of the plan: serial, nvm, motion, trace, control ... */
    LX_ABOUT_SETTING, /**< a setting of an encoder or of its wire */
    LX_ABOUT_WIRE,    /**< the address of a wire; the key is the kind of wire */
    LX_ABOUT_ITSELF,  /**< its text says, and whoever adds something later shall not */
    LX_ABOUT_COUNT
};

/** Where it stands. */
struct lx_where {
    enum lx_about about;
    char key[LX_ERROR_KEY_MAX];
    char value[LX_ERROR_VALUE_MAX];    /**< as it was given */
    bool valued;                       /**< it is to be told */
    const char *file;                  /**< borrowed from the plan; NULL: the command line */
    char included[LX_ERROR_VALUE_MAX]; /**< "": `line` is of `file`; else of one that it includes:
                                            "bench.ini:2: shafts.ini" */
    unsigned line;                     /**< of `file`; 0: unknown */
};

/** An error. */
struct lx_error {
    struct lx_where where;
    char what[400];  /**< what was wrong; "": that is clear from what would be right */
    char right[512]; /**< what would be right; "": `what` says it */
};

/** A text that grows; what does not fit is cut off. */
struct lx_words {
    char text[1024];
};

/** Append, printf style. */
void lx_words_add(struct lx_words *self, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/** Append `word`, item `index` of a list of `count`: "a, b and c" with `last` " and ". */
void lx_words_item(struct lx_words *self, const char *word, size_t index, size_t count,
                   const char *last);

/** Make `error` what was wrong, printf style, about nothing and nowhere. Control characters become
 * '?'. Always returns -1, for `return lx_fail(...)`; likewise all below. Arguments may be texts of
 * the same error. */
int lx_fail(struct lx_error *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** The same, with what would be right; NULL: nothing. */
int lx_refuse(struct lx_error *error, const char *right, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** What would be right after a call that gave this errno, where more of something is; else NULL. */
const char *lx_more_of(int reason);

/** Zeroed memory for `what`, e.g. "a pty"; the caller's, for free(). @return NULL with `error` */
void *lx_allocate(size_t size, const char *what, struct lx_error *error);

/** Say what it is about, unless that was said nearer to it. `value` NULL: not to be told. */
int lx_about(struct lx_error *error, enum lx_about about, const char *key, const char *value);

/** Make `error` what the library says of a plan. */
int lx_error_take(struct lx_error *error, const struct dg_plan_error *from);

/** Say where it stands, unless that was said nearer to it. `file` NULL or `line` 0: unknown. */
int lx_stands(struct lx_error *error, const char *file, unsigned line);

/** One line: "FILE:LINE: KEY=VALUE: what; right", without what is unknown. */
struct lx_words lx_error_line(const struct lx_error *error);

/** "what; right" */
struct lx_words lx_error_reason(const struct lx_error *error);

#endif

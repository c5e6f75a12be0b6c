/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Settings: everything about an encoder, its world and its wire that can be set from outside. A
 * row for each key; --set, rig files, help and error messages all work from the rows, so a new
 * setting is a row and the member it points to.
 */
#ifndef DREHGEBER_LINUX_KEY_H
#define DREHGEBER_LINUX_KEY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "drehgeber/quantity.h"
#include "error.h"

/** How a value lies in memory. */
enum lx_key_type {
    LX_KEY_U8,     /**< uint8_t; likewise the next ones */
    LX_KEY_U16,    /**< */
    LX_KEY_U32,    /**< */
    LX_KEY_I16,    /**< */
    LX_KEY_I32,    /**< */
    LX_KEY_NS,     /**< dg_ns; the number is in units of `factor` */
    LX_KEY_FLAG,   /**< bool: the first or the second of `words` */
    LX_KEY_WORD,   /**< uint8_t: which one of `words`, whose last one is number max */
    LX_KEY_TEXT,   /**< char[max + 1]: min to max characters; the rest of it is cleared */
    LX_KEY_DIGITS, /**< char[max + 1]: min to max digits, zeros in front */
    LX_KEY_TYPE_COUNT
};

/** A row. */
struct lx_key {
    const char *name;
    const char *unit;         /**< "" without */
    size_t offset;            /**< in what lx_keys.base points to */
    uint8_t type;             /**< enum lx_key_type */
    uint8_t places;           /**< decimals; min, max and what is stored count the last one */
    uint32_t factor;          /**< LX_KEY_NS: nanoseconds */
    int64_t min;              /**< smallest number, fewest characters */
    int64_t max;              /**< largest number, most characters */
    const char *const *words; /**< LX_KEY_FLAG, LX_KEY_WORD: 0 and 1 and so on in its own words */
    const char *help;
};

/** "0" and "1". */
extern const char *const lx_no_yes[2];

/** The world of every encoder; offsets count from its struct dg_world. */
extern const struct lx_key lx_world_keys[DG_QUANTITY_COUNT];

/** Rows, and what they set. */
struct lx_keys {
    const struct lx_key *rows;
    size_t count;
    void *base;
    uint32_t without; /**< bit n: this one has not row n */
};

/** Apply `value` to what `key` says of `base`. @return 0, or -1 with `error` */
int lx_key_set(const struct lx_key *key, void *base, const char *value, struct lx_error *error);

/** The row called `name` in one of the `n` lists, or NULL. @param base what it sets; may be NULL */
const struct lx_key *lx_keys_find(const struct lx_keys *lists, size_t n, const char *name,
                                  void **base);

/** Append all names, with a blank in front of each. */
void lx_keys_name(const struct lx_keys *lists, size_t n, struct lx_words *to);

/** Print a line for each: name, what it is, range, and the value that `base` has for default (NULL:
 * none is told). */
void lx_keys_help(const struct lx_keys *keys, FILE *to);

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Settings, as a port sees them: lists of the rows that the core has of encoders and their world,
 * and that ports have of wires. --set, rig files, help and error messages all work from the rows.
 */
#ifndef DREHGEBER_LINUX_KEY_H
#define DREHGEBER_LINUX_KEY_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "drehgeber/key.h"
#include "error.h"

/** Rows, and what they set. */
struct lx_keys {
    const struct dg_key *rows;
    size_t count;
    void *base;
    uint32_t without;             /**< bit n: this one has not row n */
    const struct dg_key *instead; /**< stands for the row of its name; NULL: none does */
};

/** Row n, or NULL: it is none, or this one has it not. */
const struct dg_key *lx_keys_row(const struct lx_keys *self, size_t n);

/** dg_key_set(), which says what would be right. @return 0, or -1 with `error` */
int lx_key_set(const struct dg_key *key, void *base, const char *value, struct lx_error *error);

/** What is right: "0..250000 us", "8 characters", "own or early", "none, even or odd". */
struct lx_words lx_key_range(const struct dg_key *key);

/** The row called `name` in one of the `n` lists, or NULL. @param base what it sets; may be NULL */
const struct dg_key *lx_keys_find(const struct lx_keys *lists, size_t n, const char *name,
                                  void **base);

/** What lies there, as text; "" of what is not told: texts, which are factory figures, and what
 * stands for 'none'. */
struct lx_words lx_key_value(const struct dg_key *key, const void *base);

/** Append all names, with a blank in front of each. */
void lx_keys_name(const struct lx_keys *lists, size_t n, struct lx_words *to);

/** Print a line for each: name, what it is, range, and the value that `base` has for default (NULL:
 * none is told). */
void lx_keys_help(const struct lx_keys *keys, FILE *to);

#endif

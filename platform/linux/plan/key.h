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

/** Rows, and what is told of them. */
struct lx_keys {
    const struct dg_key *rows;
    size_t count;
    const void *base;             /**< of defaults; NULL: none is told */
    uint32_t without;             /**< bit n: this one has not row n */
    const struct dg_key *instead; /**< stands for the row of its name; NULL: none does */
};

/** Row n, or NULL: it is none, or this one has it not. */
const struct dg_key *lx_keys_row(const struct lx_keys *self, size_t n);

/** What is right: "0..250000 us", "8 characters", "own or early", "none, even or odd". */
struct lx_words lx_key_range(const struct dg_key *key);

/** What lies there, as text; "" of what is not told: texts, which are factory figures, and what
 * stands for 'none'. */
struct lx_words lx_key_value(const struct dg_key *key, const void *base);

/** Print a line for each: name, what it is, range, and the value that `base` has for default (NULL:
 * none is told). */
void lx_keys_help(const struct lx_keys *keys, FILE *to);

#endif

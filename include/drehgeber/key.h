/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Settings by rows: everything about an encoder and its world that can be set from outside, by
 * text. A new setting is a row and the member it points to. Rows and engine are objects of their
 * own, so that an image which takes no settings carries none of their text.
 */
#ifndef DREHGEBER_KEY_H
#define DREHGEBER_KEY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "drehgeber/api.h"
#include "drehgeber/quantity.h"
#include "drehgeber/text.h"

#ifdef __cplusplus
extern "C" {
#endif

/** How a value lies in memory. */
enum dg_key_type {
    DG_KEY_U8,     /**< uint8_t; likewise the next ones */
    DG_KEY_U16,    /**< uint16_t */
    DG_KEY_U32,    /**< uint32_t */
    DG_KEY_I16,    /**< int16_t */
    DG_KEY_I32,    /**< int32_t */
    DG_KEY_NS,     /**< dg_ns; the number is in units of `factor` */
    DG_KEY_FLAG,   /**< bool: the first or the second of `words` */
    DG_KEY_WORD,   /**< uint8_t: which one of `words`, whose last one is number max */
    DG_KEY_TEXT,   /**< char[max + 1]: min to max characters; the rest of it is cleared */
    DG_KEY_DIGITS, /**< char[max + 1]: min to max digits, zeros in front */
    DG_KEY_TYPE_COUNT
};

/** A row. */
struct dg_key {
    const char *name;
    const char *unit;         /**< "" without */
    size_t offset;            /**< in what the rows are about */
    uint8_t type;             /**< enum dg_key_type */
    uint8_t places;           /**< decimals; min, max and what is stored count the last one */
    uint32_t factor;          /**< DG_KEY_NS: nanoseconds */
    int64_t min;              /**< smallest number, fewest characters */
    int64_t max;              /**< largest number, most characters */
    const char *const *words; /**< DG_KEY_FLAG, DG_KEY_WORD: 0 and 1 and so on in its own words */
    const char *help;
};

/** Rows about the same struct. */
struct dg_keys {
    const struct dg_key *rows;
    size_t count;
};

/** "0" and "1". */
DG_API extern const char *const dg_key_no_yes[2];

/** The world of every encoder: struct dg_world, in the order of enum dg_quantity_id. */
DG_API extern const struct dg_keys dg_world_keys;

/** The row called `name`, or NULL. */
DG_API const struct dg_key *dg_keys_find(const struct dg_keys *self, const char *name);

/** Set what `self` says of `base`. Numbers are decimal with at most `places` decimals, or without
 * any also 0x27 or 27h. @return 0 or DG_ERR_ARGUMENT */
DG_API int dg_key_set(const struct dg_key *self, void *base, const char *value);

/** Whether what lies there, at any address, is something that dg_key_set() can have put there. */
DG_API bool dg_key_holds(const struct dg_key *self, const void *base);

/** What it is, as dg_key_set() takes it. @return its characters, behind which there is a zero, or
 * DG_ERR_SPACE */
DG_API int dg_key_get(const struct dg_key *self, const void *base, char *to, size_t size);

/** Append the values it takes: "0..24", "4 to 8 characters", "none, even or odd". */
DG_API void dg_key_say_range(const struct dg_key *self, struct dg_text *to);
/** Append what was expected in place of a value that is refused: "expected a number in 0..24". */
DG_API void dg_key_say_right(const struct dg_key *self, struct dg_text *to);

#ifdef __cplusplus
}
#endif

#endif

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the reader of EDS files: the text becomes entries (co_read.c), entries become rows
 * (co_rows.c) of a device (co_file.c), some of which only store (co_cells.c).
 */
#ifndef DREHGEBER_CO_FILE_H
#define DREHGEBER_CO_FILE_H

#include "co_od.h"
#include "drehgeber/eds.h"

/** A piece of the text. */
struct eds_span {
    const char *at;
    size_t n;
};

/** Where something stands; n 0: nowhere in particular. */
struct eds_place {
    unsigned line;
    struct eds_span section;
    struct eds_span key;
    struct eds_span value;
    bool lacks; /**< of a note: the file promises what the node does not do */
};

/** What an entry comes from; of those with one key the first is the object, if it is one. */
enum eds_rank {
    EDS_SUB,     /**< [1018sub1] */
    EDS_COMPACT, /**< a sub-index that CompactSubObj stands for */
    EDS_OBJECT,  /**< [1018] */
    EDS_VALUE,   /**< a line of [2000Value]: a default, and no object */
};

/** What the text says of a sub-index. */
struct eds_entry {
    uint32_t key; /**< DG_CO_KEY() */
    unsigned line;
    struct eds_span initial; /**< DefaultValue, or ParameterValue; n 0: none, likewise the next */
    struct eds_span low;
    struct eds_span high;
    uint16_t type;   /**< DataType; 0: not said */
    uint8_t rank;    /**< enum eds_rank */
    uint8_t object;  /**< ObjectType; 0: not said */
    uint8_t compact; /**< CompactSubObj */
    uint8_t access;  /**< DG_CO_R, DG_CO_W, DG_CO_CONST; 0: not said */
    bool map;        /**< PDOMapping */
    bool configured; /**< `initial` is ParameterValue */
};

/** What the text says beside its objects. */
struct eds_info {
    struct eds_span product;
    struct eds_span vendor;
    uint32_t vendor_id;
    uint32_t product_code;
    uint32_t revision;
    uint16_t rates;  /**< bit n: the n-th of dg_co_eds_kbaud is supported */
    uint16_t kbaud;  /**< of a DCF; 0: none */
    uint8_t node_id; /**< likewise */
    uint16_t listed; /**< objects in lists */
};

/** A text being read, and the memory that it is given. */
struct eds_reader {
    const struct dg_eds_setup *setup;
    struct dg_eds_note *error;
    uint8_t *front;            /**< what stays grows from here */
    uint8_t *back;             /**< entries grow down from the end to here */
    struct eds_entry *entries; /**< at `back` */
    size_t count;
    uint16_t objects;
    struct eds_info info;
    bool out; /**< there was not enough memory */
};

/** A number of CiA 306 as it was written. */
struct eds_number {
    uint32_t value; /**< negative ones as two's complement */
    bool follows;   /**< $NODEID stands in it */
    bool valid;
};

/** Bit rates by the bits of eds_info.rates. */
#define EDS_RATES 9u
extern const uint16_t dg_co_eds_kbaud[EDS_RATES];

/** Zeroed bytes that stay, aligned for pointers. @return NULL with reader->out */
void *dg_co_keep_bytes(struct eds_reader *self, size_t n);
/** One more entry; all zero but for its key, rank and line. @return NULL with reader->out */
struct eds_entry *dg_co_add_entry(struct eds_reader *self, uint32_t key, enum eds_rank rank,
                                  unsigned line);
/** Note `what` about a place. */
void dg_co_note_place(struct eds_reader *self, const struct eds_place *place, const char *what,
                      const char *right);
/** Note `what` about a key of an entry; "": about all of it. */
void dg_co_note_entry(struct eds_reader *self, const struct eds_entry *entry, const char *key,
                      const char *what, const char *right);
/** The same of what the file promises and the node does not do. */
void dg_co_note_lack(struct eds_reader *self, const struct eds_entry *entry, const char *key,
                     const char *what, const char *right);
/** What is wrong with the text; line 0: with all of it. @return DG_ERR_ARGUMENT */
int dg_co_refuse_text(struct eds_reader *self, unsigned line, const char *what, const char *right);

/** Whether a text is `word`, case aside. */
bool dg_co_is_word(struct eds_span text, const char *word);
/** A text as a number; comments behind it are left out. */
struct eds_number dg_co_take_number(struct eds_span text);

/** The whole text to entries, sorted by key, rank and line. @return 0, DG_ERR_SPACE, or
 * DG_ERR_ARGUMENT with the error */
int dg_co_scan_text(struct eds_reader *self);

/** Places in tables that rows name by 4 and 8 bits. */
#define EDS_LIMITS_MAX 16u
#define EDS_HOOKS_MAX 64u

/** A file being made. */
struct eds_maker {
    struct eds_reader in;
    const struct dg_co_ground *ground;
    struct dg_co_file *to;
    struct dg_co_row *rows;
    struct dg_co_cell *cells;
    struct dg_co_limits *limits;
    dg_co_hook **hooks;
    const char **strings;
    uint32_t string_count;
    uint8_t limit_count;
    uint8_t hook_count;
};

/** A copy of at most `most` characters, terminated. */
const char *dg_co_keep_text(struct eds_reader *in, struct eds_span text, size_t most);
/** Rows of all entries, and the dictionary's count of them. */
void dg_co_make_rows(struct eds_maker *self);
/** Rows for the values of `base`, which stand in front of the file's; `to` NULL: they are only
 * counted. @return how many */
uint16_t dg_co_hide_rows(const struct dg_co_device *base, struct dg_co_row *to);

/** Hooks of rows that are no object of the base: a cell, and what follows the node-ID; "save" with
 * the cells. */
dg_co_hook dg_co_hook_cell, dg_co_hook_follows, dg_co_hook_keep;
/** dg_co_device.reset of a file: cells, then the base's own. */
bool dg_co_reset_file(struct dg_co_node *node, bool application);
/** Cells in a region of the store. */
#define EDS_CELLS_A_REGION (DG_STORE_CHECKED_MAX / 4u)

/** Whether a cell may have this value, sign-extended where its type is signed. */
static inline bool eds_is_inside(const struct dg_co_cell *cell, uint32_t value)
{
    const struct dg_co_limits *range = &cell->limits;

    return cell->type <= DG_CO_I32
               ? (int32_t)value >= (int32_t)range->min && (int32_t)value <= (int32_t)range->max
               : value >= range->min && value <= range->max;
}

/** What the region "objects", in front of those of the cells, tells of the file: words of 32 bits,
 * one for each cell behind these. It is written by the first "save". */
enum eds_word {
    EDS_WORD_TAG,
    EDS_WORD_BASE, /**< id of the base's layout */
    EDS_WORD_TYPE,
    EDS_WORD_VENDOR,
    EDS_WORD_PRODUCT,
    EDS_WORD_REVISION,
    EDS_WORD_KEPT,
    EDS_WORD_CELLS, /**< key, and its type in the last byte */
};
/** Word `n` of a file. */
uint32_t dg_co_file_word(const struct dg_co_file *self, uint32_t n);
/** Write them all, as far as they are not there. */
void dg_co_write_words(const struct dg_co_file *self, struct dg_store *store);
/** Cells in region `n` of them, of so many. */
static inline uint16_t eds_cells_in(uint16_t kept, uint32_t n)
{
    const uint32_t left = kept - n * EDS_CELLS_A_REGION;

    return (uint16_t)(left < EDS_CELLS_A_REGION ? left : EDS_CELLS_A_REGION);
}

#endif

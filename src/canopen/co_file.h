/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Inside of the reader of EDS files: the text becomes entries (co_read.c), entries become rows
 * (co_rows.c, co_long_rows.c) of a device (co_file.c), some of which only store (co_cells.c,
 * co_long.c).
 */
#ifndef DREHGEBER_CO_FILE_H
#define DREHGEBER_CO_FILE_H

#include "co_od.h"
#include "drehgeber/eds.h"
#include "drehgeber/eds_rows.h"

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
    uint32_t compact_pdo; /**< bit n: PDOs have sub-index n + 1, without sections for them */
    uint32_t rpdos;       /**< so many then */
    uint32_t tpdos;
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
    uint64_t wide;  /**< negative ones as two's complement, likewise the next */
    uint32_t value; /**< 0 where 32 bits do not hold it */
    bool follows;   /**< $NODEID stands in it */
    bool valid;     /**< 32 bits hold it */
    bool valid_wide;
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

/** Add entries of what has no sections (co_compact.c). */
void dg_co_expand_entries(struct eds_reader *self);
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
    struct dg_co_long *longs;
    uint32_t string_count;
    uint16_t text_count; /**< of `longs`: texts that may be written */
    bool forgets;        /**< 1010h does not keep all of `longs` */
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

/** What the base has at the key of an entry. A memory has one object for each of its parts: all of
 * them are what the first one is. */
bool dg_co_find_base(const struct eds_maker *self, const struct eds_entry *entry,
                     struct dg_co_object *object);
/** @return the number of a hook in the table; 0: NULL. Devices have fewer than the table. */
uint8_t dg_co_keep_hook(struct eds_maker *self, dg_co_hook *hook);
/** Hooks of rows that are no object of the base: a cell, what follows the node-ID, 64 bits;
 * "save" with the cells. */
dg_co_hook dg_co_hook_cell, dg_co_hook_follows, dg_co_hook_wide, dg_co_hook_keep;
/** Cells in a region of the store. */
#define EDS_CELLS_A_REGION (DG_STORE_CHECKED_MAX / 4u)

/** Texts and domains of a file that may be written, as each takes DG_EDS_LONG_MAX bytes. */
#define EDS_TEXTS_MAX 64u
/** Whether 32 bits and the text of a row do not hold the value of an entry (co_long_rows.c). */
bool dg_co_is_long(const struct eds_entry *entry);
/** dg_co_row.slot of the upper 32 of 64 bits; their row has none. */
#define EDS_HIGH 1u
/** Make its value, and its row, which the SDO server refuses, or two. @return how many */
uint16_t dg_co_make_long(struct eds_maker *self, struct eds_entry *entry, struct dg_co_row *row);
/** Of what 1010h keeps: as much as an EEPROM of 16 kB has room for, twice. */
#define EDS_LONGS_KEPT 4096u
/** Whether it has a place of its own in the memory of a node. */
static inline bool eds_is_placed(const struct dg_co_long *self)
{
    return (self->access & DG_CO_W) != 0 && self->bound.row == NULL;
}
/** In front of each that has one. */
#define EDS_LENGTH_SIZE 2u
/** In front of each copy of what is kept. */
#define EDS_COPY_HEAD 4u
/** Give those that may be written a place. @param kept bytes of those that 1010h keeps, which stand
 * in front @return bytes from `longs_at` on */
size_t dg_co_place_longs(struct dg_co_long *longs, uint16_t count, uint16_t *kept);
/** The first of them: what dg_co_long.at counts from. */
uint8_t *dg_co_long_bytes(const struct dg_co_node *node);
/** Whether a value may have these bytes. */
bool dg_co_long_is_inside(const struct dg_co_long *self, const uint8_t *bytes);
/** The file of a node's device: a device that was read is the first member of its file. */
static inline const struct dg_co_file *co_file_of(const struct dg_co_node *node)
{
    return (const struct dg_co_file *)(const void *)node->setup.device;
}
/** The value of this key, or NULL. */
const struct dg_co_long *dg_co_find_long(const struct dg_co_file *self, uint32_t key);
/** As delivered. */
void dg_co_reset_longs(const struct dg_co_node *node);
/** dg_co_device.refused of a file that has such values. */
void dg_co_serve_long(struct dg_co_node *node, const uint8_t *data, enum dg_co_abort abort);

/** The two copies of what is kept, in a region of a store (co_long_kept.c). */
struct dg_co_copies {
    struct dg_store *store;
    uint8_t region;
    uint8_t newest;  /**< the copy in force, if there is one */
    bool found;      /**< there is */
    uint16_t number; /**< of it */
    uint16_t size;   /**< bytes of a copy */
};
struct dg_co_copies dg_co_open_copies(struct dg_store *store, uint8_t region, uint16_t size);
/** Read from the copy in force. @return false: there is none */
bool dg_co_read_copy(struct dg_co_copies *self, uint32_t at, uint8_t *to, uint16_t n);
/** Write the other one, and with the sum (dg_crc16() from 0) of all of it put it in force.
 * @return as dg_store_put() */
int dg_co_write_copy(struct dg_co_copies *self, uint32_t at, const uint8_t *from, uint16_t n);
int dg_co_end_copy(struct dg_co_copies *self, uint16_t sum);
/** A value of an image, by its words (EDS_WORD_CELLS) and its place in a copy. */
struct dg_co_kept {
    uint32_t key;
    uint32_t at;
    uint16_t least;
    uint16_t most;
    uint8_t kind; /**< enum dg_co_long_kind */
};
/** Convert what is kept: as dg_co_convert(), which has mounted both. `from` has `count` values,
 * told by the words of region `words` from word `first` on. @param to NULL: nothing is copied
 * @param saved whether anything was ever saved in `from` */
struct dg_co_convert_longs {
    const struct dg_co_file *file;
    struct dg_store *from;
    struct dg_store *to;
    void (*tell)(void *ctx, uint32_t key, enum dg_co_misfit why);
    void *ctx;
    uint32_t first;
    uint16_t count;
    uint16_t size; /**< bytes of a copy in `from` */
    uint8_t words;
    bool saved;
};
int dg_co_convert_longs(const struct dg_co_convert_longs *self);
/** Of a node. */
void dg_co_save_longs(struct dg_co_node *node);
void dg_co_load_longs(struct dg_co_node *node);

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
    EDS_WORD_KEPT,  /**< cells, and values of more than 32 bits in the upper half */
    EDS_WORD_CELLS, /**< key, and its type in the last byte; then two for each of the others: key
                       and kind, bytes: most, and least in the upper half */
};
/** How many words there are; 0: nothing is kept. */
static inline uint32_t eds_word_count(uint16_t kept, uint16_t longs)
{
    return kept == 0 && longs == 0 ? 0 : EDS_WORD_CELLS + kept + 2u * longs;
}
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

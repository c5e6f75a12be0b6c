/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The reader's own: plan_lines.c takes lines apart into sections and words, the row of a section's
 * kind (plan_section.c) makes it a part of the plan. What a section refers to stands above it, so
 * that each is checked when it ends, with all that it may clash with.
 *
 * Functions that return an int and take a reader give 0, or -1 with `error`; also -1 when the
 * memory is full, which plan->out says.
 */
#ifndef DREHGEBER_RIG_PRIVATE_H
#define DREHGEBER_RIG_PRIVATE_H

#include "drehgeber/rig.h"

/** The sections there are, for messages. */
#define RIG_SECTIONS "[rig], [model NAME], [shaft NAME], [bus NAME] or [encoder NAME]"

/** Longest text anybody hands over. */
#define RIG_TEXT_MAX 65536u

/* ---------------------------------------------------------------- texts */

/** Texts that are one behind each other, NULL behind the last. */
typedef const char *const *rig_parts;
#define RIG_SAY(...) ((const char *const[]){__VA_ARGS__, NULL})

/** A number in decimal, as a part. */
struct rig_number {
    char text[DG_TEXT_DIGITS_MAX + 1u];
};
struct rig_number dg_plan_number(size_t value);
struct rig_number dg_plan_signed(int64_t value);

/** The beginning of a word, as a part: its first `n` characters. */
struct rig_cut {
    char text[sizeof((struct dg_plan_error *)0)->what];
};
struct rig_cut dg_plan_cut(const char *text, size_t n);

/** A line that is read already, as a part: "12", "12 of shafts.ini". */
struct rig_line {
    char text[96];
};
/** `here`: the line that is complained about. */
struct rig_line dg_plan_line_text(const struct dg_plan *plan, dg_plan_line line, dg_plan_line here);

/** A long list in words. */
struct rig_list {
    char room[512];
    struct dg_text text;
};
/** Empty; not to be moved. */
void dg_plan_list_begin(struct rig_list *self);
/** Append item `index` of `count`, as in "a, b and c". */
void dg_plan_list_item(struct rig_list *self, const char *word, size_t index, size_t count);

/** Append all parts. */
void dg_plan_add(struct dg_text *to, rig_parts parts);

/** Whether two texts are the same. */
bool dg_plan_same(const char *a, const char *b);
/** The same, case aside. */
bool dg_plan_same_word(const char *a, const char *b);
/** Characters of a text. */
size_t dg_plan_length(const char *text);
/** Characters before the first `c`, or all. */
size_t dg_plan_span(const char *text, char c);
/** Whether `text` begins with `word`. */
bool dg_plan_begins(const char *text, const char *word);
/** Whether the text of `n` characters is more than `end`, and ends so, case aside. */
bool dg_plan_ends(const char *text, size_t n, const char *end);
/** Where `what` begins in `text`; NULL: nowhere. */
const char *dg_plan_find(const char *text, const char *what);

/* ---------------------------------------------------------------- errors */

/** Make `error` what was wrong, about nothing and nowhere. Control characters become '?'. Either
 * may be NULL: nothing. @return -1, likewise all below */
int dg_plan_refuse(struct dg_plan_error *error, rig_parts right, rig_parts what);
/** Say what it is about, unless that was said nearer to it. `value` NULL: not to be told. */
int dg_plan_about(struct dg_plan_error *error, const char *key, const char *value);
/** Say where it stands, unless that was said nearer to it. */
int dg_plan_stand(const struct dg_plan *plan, dg_plan_line line, struct dg_plan_error *error);

/* ---------------------------------------------------------------- memory, names */

/** Zeroed memory of the plan for an object. @return NULL: it is full */
void *dg_plan_reserve(struct dg_plan *self, size_t size);
/** Room for one more behind `count` rows: the capacity is the next power of two.
 * @return where the rows are now, or NULL with the old ones in place: the memory is full */
void *dg_plan_grow(struct dg_plan *self, void *list, size_t count, size_t size);
/** A copy of `n` characters. @return NULL: the memory is full */
char *dg_plan_keep(struct dg_plan *self, const char *text, size_t n);

/** Lists of names; in each a name stands once. */
enum rig_names {
    RIG_SHAFT,   /**< not case sensitive, likewise the next two */
    RIG_WIRE,    /**< wires */
    RIG_ENCODER, /**< encoders */
    RIG_ALIAS,   /**< likewise, where '-' and '_' are the same */
    RIG_PLACE,   /**< addresses of wires, those of a `scope` */
    RIG_MODEL,   /**< models of the plan */
    RIG_FILE,    /**< files that are models */
    RIG_NUMBER,  /**< numbers of encoders on the wire `scope` */
    RIG_MEMORY,  /**< EEPROM files */
    RIG_TRACE,   /**< trace files */
};

/** A name. */
struct dg_plan_name {
    const char *text; /**< borrowed from the plan; NULL: this row is free */
    uint32_t scope;   /**< names of different scopes are different ones */
    int index;        /**< of what is called so */
    uint8_t list;     /**< enum rig_names */
};

/** @return the index, or -1 */
int dg_plan_names_find(const struct dg_plan *self, const struct dg_plan_name *name);
/** Remember a name; one that is there keeps its index. @return 0, or -1: the memory is full */
int dg_plan_names_add(struct dg_plan *self, const struct dg_plan_name *name);

/* ---------------------------------------------------------------- files, sections */

/** A file. Number 0 is the first one. */
struct dg_plan_source {
    const char *file;
    size_t parent;     /**< that includes it */
    dg_plan_line line; /**< of the word that does */
};

/** Lines in a row of one file. */
struct dg_plan_piece {
    dg_plan_line first;
    unsigned first_in_file;
    size_t source;
};

struct rig_section;
struct rig_reader;

/** A key of a section: its name for the reader, the rest for docs/rigs.md, which is generated. */
struct rig_key {
    const char *name;
    const char *takes; /**< what a value looks like: "NAME", "FILE" */
    const char *usual; /**< what holds without it; NULL: it has to be there */
    const char *help;
};

/** A kind of section. */
struct rig_kind {
    const char *name;
    bool named;          /**< [KIND NAME] */
    bool open;           /**< takes settings beside its keys */
    bool numbered;       /**< the addresses of all stacks are keys of it, too */
    const char *repeats; /**< the key that may stand several times; NULL: none */
    const char *at_once; /**< the key that is a file to be read, then and there; NULL: none */
    const struct rig_key *keys; /**< name NULL behind the last */
    int (*take)(struct rig_reader *in, const struct rig_section *self);
};

/** A section. */
struct rig_section {
    const struct rig_kind *kind; /**< NULL: none has begun */
    char name[DG_PLAN_NAME_MAX + 1u];
    struct dg_plan_setting *words; /**< the first lies below this, and so on downwards */
    size_t count;
    dg_plan_line line;
};

/** A file that is being read. */
struct rig_file {
    struct dg_plan_text text;
    size_t at;                  /**< in it */
    unsigned line;              /**< of it */
    size_t source;              /**< its number */
    struct rig_section section; /**< the one that is being read */
};

/** The reader. */
struct rig_reader {
    struct dg_plan *plan;
    const struct dg_plan_setup *setup;
    struct dg_plan_error *error;
    dg_plan_line line;
    size_t included;                          /**< bytes so far */
    size_t modelled;                          /**< likewise, of files that are models */
    size_t depth;                             /**< files that are open */
    struct rig_file files[DG_PLAN_DEPTH_MAX]; /**< each includes the next */
};

/** All lines of the setup's text, and of all that it includes. */
int dg_plan_read_lines(struct rig_reader *self);

/** The kind called `name`, or NULL. */
const struct rig_kind *dg_plan_kind_find(const char *name);
/** All of a section is there: check it, and put it into the plan. */
int dg_plan_section_take(struct rig_reader *in, const struct rig_section *self);

/** Word `index` of a section. */
struct dg_plan_setting *dg_plan_word_at(const struct rig_section *self, size_t index);
/** The word with this key, or NULL. */
const struct dg_plan_setting *dg_plan_word(const struct rig_section *self, const char *key);
/** Append a word. */
int dg_plan_word_add(struct rig_reader *in, struct rig_section *self,
                     const struct dg_plan_setting *word);
/** Whether `key` is one of the kind's own. */
bool dg_plan_kind_has(const struct rig_kind *kind, const char *key);

/** Settings of the section that are not keys of its kind, those of its wire or all others. */
int dg_plan_take_settings(struct rig_reader *in, const struct rig_section *self,
                          const struct dg_plan_wire_kind *wire, bool of_wire,
                          struct dg_plan_settings *to);

/** What they make of a section. */
int dg_plan_take_model(struct rig_reader *in, const struct rig_section *self);
int dg_plan_take_shaft(struct rig_reader *in, const struct rig_section *self);
int dg_plan_take_bus(struct rig_reader *in, const struct rig_section *self);
int dg_plan_take_encoders(struct rig_reader *in, const struct rig_section *self);
/** An [encoder NAME] that is one. */
int dg_plan_take_encoder(struct rig_reader *in, const struct rig_section *self);

/** What is wrong with a word, with a section, with a line. */
int dg_plan_wrong_word(struct rig_reader *in, const struct dg_plan_setting *word, rig_parts right,
                       rig_parts what);
int dg_plan_wrong_section(struct rig_reader *in, const struct rig_section *section, rig_parts right,
                          rig_parts what);
int dg_plan_wrong_line(struct rig_reader *in, dg_plan_line line, rig_parts right, rig_parts what);
/** The error is about the word `key` in `line`, unless it says so nearer. */
int dg_plan_refuse_key(struct rig_reader *in, const char *key, dg_plan_line line);
/** The line `by` has the name already. */
int dg_plan_taken(struct rig_reader *in, const struct rig_section *section, dg_plan_line by);

/** A file name of the word in `line`, relative to the folder of its file. NULL: the memory is full.
 */
const char *dg_plan_path(struct rig_reader *in, const char *path, dg_plan_line line);

/** A wire's address as the user wrote it, and where. */
struct rig_where {
    const char *text;                   /**< NULL: none */
    const char *key;                    /**< that gives it, or would */
    const struct dg_plan_setting *word; /**< that gives it; NULL: none */
};
/** The kind of wire that the first `n` characters of the value name. @return NULL with `error` */
const struct dg_plan_wire_kind *dg_plan_take_kind(struct rig_reader *in,
                                                  const struct dg_plan_setting *word, size_t n);
/** A wire with the name of the section. @return its index or -1 */
int dg_plan_take_wire(struct rig_reader *in, const struct rig_section *self,
                      const struct dg_plan_wire_kind *kind, const struct rig_where *where);
/** What is written of a wire, and where to; `word` NULL: nothing. */
int dg_plan_take_trace(struct rig_reader *in, const struct dg_plan_setting *word, int wire);

/** Check that the value of a word names a file in the folder of its own file, or below that. */
int dg_plan_check_below(struct rig_reader *in, const struct dg_plan_setting *word);
/** The text of the file `path`, which a word names, from the host. */
int dg_plan_fetch_text(struct rig_reader *in, const struct dg_plan_setting *word, const char *path,
                       struct dg_plan_text *to);
/** The model that the value of a word names, built in, above or a file, which is read once; NULL:
 * none, likewise without a word. */
int dg_plan_take_name(struct rig_reader *in, const struct dg_plan_setting *word,
                      const struct dg_device **to);

/** No model is called as the word `key` of this section says, or there is no such word: NULL. */
int dg_plan_refuse_model(struct rig_reader *in, const struct rig_section *section, const char *key,
                         const struct dg_plan_setting *word);

/** Whether `key` is that of the addresses of any stack. */
bool dg_plan_is_address_key(const char *key);
/** An address of the model's encoders; it has a row of them. @return it, or -1 */
int dg_plan_address(const struct dg_device *model, const char *text);
/** Write it as the model's are written. */
struct rig_number dg_plan_address_text(const struct dg_device *model, int address);

#endif

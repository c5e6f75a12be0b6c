/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A list of clauses of a manual, and rows that prove them: read, and run.
 *
 * Clauses file, one per line:        Rows file:
 *   5.1.2.1-3 | text                   [5.1.2.1-3 R6a] title
 *                                        step
 *                                        repeat 4
 *                                        step
 *                                        end
 * `#` starts a comment line. A clause that cannot hold, since the manual contradicts itself or
 * leaves no choice but to deviate, keeps its words and names the row of the device page that says
 * so: 5.1.2.15-2 | text | listed 28          the page has to have a row `| 28 | ...`; no row cites
 * it What a step means is the device's business (struct cf_device); this part knows only rows,
 * clauses, `repeat` and which clause is covered by which row.
 */
#ifndef DREHGEBER_VERIFY_ROWS_H
#define DREHGEBER_VERIFY_ROWS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define CF_CLAUSES_MAX 4000u
#define CF_ROWS_MAX 4000u
#define CF_LINES_MAX 8000u
#define CF_CITED_MAX 8u
#define CF_WORDS_MAX 300u

/** Why a row failed. */
struct cf_report {
    char text[3000];
};

/** What a step needs beside the wire when the encoder is a real one; bits. */
enum cf_need {
    CF_SHAFT = 1u << 0,   /**< a shaft that is turned, as far and as fast as the step says */
    CF_INSIDE = 1u << 1,  /**< somebody who changes, or sees, what no wire leads to */
    CF_EXACT = 1u << 2,   /**< times on the wire that are exact to a bit time */
    CF_POWER = 1u << 3,   /**< a supply that can be cut */
    CF_ALONE = 1u << 4,   /**< nobody else on the wire whom a request reaches */
    CF_WRITE = 1u << 5,   /**< that the encoder may be changed, and changed back */
    CF_ONE_WAY = 1u << 6, /**< that it may be changed for good */
    CF_RING = 1u << 7     /**< other encoders on its wire, or a wire that is cut */
};

/** A kind of step. The first one of a device's table begins every row. */
struct cf_step {
    const char *verb;
    /** Do it; words[0] is the verb. @return false after cf_fail() */
    bool (*run)(void *ctx, char **words, size_t n, struct cf_report *report);
    bool expects;   /**< it can fail because of the device */
    unsigned needs; /**< always, whatever its words; bits of enum cf_need */
};

/** Bytes of a line (`id` is 0), or a frame of a bus. */
struct cf_unit {
    uint16_t id;
    bool rtr;
    const uint8_t *bytes;
    size_t n;
};

/** What a row makes of an answer that it does not know byte for byte. */
enum cf_verdict {
    CF_AGREES,
    CF_DIFFERS,
    CF_UNKNOWN /**< it says nothing about the clause: the encoder is in another state */
};

/** A relation that an answer has to be in, whatever the model says. */
struct cf_relation {
    enum cf_verdict (*judge)(const void *ctx, const struct cf_unit *came);
    const void *ctx;
    const char *text; /**< what is expected, in words */
};

/** What a row expects to be answered, and what the model has answered. */
struct cf_answer {
    struct cf_unit want;
    struct cf_unit got;                 /**< bytes NULL: nothing */
    uint64_t earliest_ns;               /**< behind what was sent last; 0: the row does not say */
    uint64_t latest_ns;                 /**< likewise */
    bool timed;                         /**< the row says when */
    const struct cf_relation *relation; /**< in place of `want`; NULL: bytes are expected */
};

/**
 * What does all that a row does beside the model: a real encoder on its wire, or somebody who wants
 * to know what the row would do. It judges the answers in place of the steps. Every operation
 * returns false after cf_fail().
 */
struct cf_beside_ops {
    bool (*sent)(void *ctx, const struct cf_unit *request, struct cf_report *report);
    bool (*answered)(void *ctx, const struct cf_answer *answer, struct cf_report *report);
    /** Nothing may come within `ns`; 0: for as long as any answer can take; 1: by now. The model
     * has kept silent. */
    bool (*silent)(void *ctx, uint64_t ns, struct cf_report *report);
    bool (*waited)(void *ctx, uint64_t ns, struct cf_report *report);
    bool (*powered)(void *ctx, bool on, struct cf_report *report);
    /** A step does what only bits of enum cf_need allow. */
    bool (*needs)(void *ctx, unsigned needs, struct cf_report *report);
};

struct cf_beside {
    const struct cf_beside_ops *ops;
    void *ctx;
};

/** What runs the steps of a row. */
struct cf_device {
    void *ctx;
    void (*begin)(void *ctx); /**< before the first step of each row */
    const struct cf_step *steps;
    size_t step_count;
    bool (*finish)(void *ctx, struct cf_report *report); /**< after the last step */
};

struct cf_clause {
    char *id;
    char *listed; /**< row of the device page that says why it does not hold; NULL: it holds */
    int line;
    bool covered;
};

struct cf_line {
    char *text;
    int number;
};

struct cf_row {
    char *title;
    char *cited[CF_CITED_MAX + 1u]; /**< room to notice one too many */
    size_t cited_count;
    size_t first_line; /**< index of its first step in cf_suite.lines */
    size_t line_count;
    int line;
};

struct cf_suite {
    const char *clauses_name;
    const char *rows_name;
    char *texts[2]; /**< content of the two files; everything else points into them */
    char *page;     /**< content of the device page, or NULL */
    struct cf_clause clauses[CF_CLAUSES_MAX];
    size_t clause_count;
    struct cf_row rows[CF_ROWS_MAX];
    size_t row_count;
    struct cf_line lines[CF_LINES_MAX];
    size_t line_count;
};

/** Print into `report` and return false. */
bool cf_fail(struct cf_report *report, const char *format, ...);

/** Split `text` at blanks, in place. @return number of words, at most `max` */
size_t cf_split(char *text, char **words, size_t max);

/** Join words[from..end) to one text, as much as `size` bytes have room for. */
void cf_join(char *to, size_t size, char **words, size_t from, size_t end);

/** Where `=` stands behind the verb, or `n`. */
size_t cf_find_equals(char **words, size_t n);

/** The kind of step that `text` begins with, or NULL. */
const struct cf_step *cf_find_step(const struct cf_device *device, const char *text);

/** The clause of this ID, or NULL. */
struct cf_clause *cf_find_clause(struct cf_suite *suite, const char *id);

/** Read the files; `page_name` may be NULL. @return false after saying on stderr what is wrong */
bool cf_load(struct cf_suite *suite, const char *clauses_name, const char *rows_name,
             const char *page_name);
/** The same of texts that are no files, and are the suite's from now on. NULL: there was no memory for
 * one. */
bool cf_load_texts(struct cf_suite *suite, const char *name, char *clauses, char *rows);
void cf_unload(struct cf_suite *suite);

/** Run one row. @return false with the reason, file and line in `report` */
bool cf_run(const struct cf_suite *suite, const struct cf_row *row, const struct cf_device *device,
            struct cf_report *report);

/** The steps of an S36 with RS485 (hiperface_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_hiperface(void);

/** The steps of an S36 with BiSS (biss_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_biss(void);

/** The steps of an encoder with SSI (ssi_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_ssi(void);

/** The steps of an F36x8 on CAN (canopen_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_canopen(void);

/** The steps of an OCD with INTERBUS (interbus_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_interbus(void);

#endif

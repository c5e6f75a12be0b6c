/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Conformance runner: a list of clauses of a manual, and rows that prove them.
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
#ifndef TESTS_CONFORMANCE_CONFORMANCE_H
#define TESTS_CONFORMANCE_CONFORMANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define CF_CLAUSES_MAX 800u
#define CF_ROWS_MAX 800u
#define CF_LINES_MAX 8000u
#define CF_CITED_MAX 8u
#define CF_WORDS_MAX 300u

/** Why a row failed. */
struct cf_report {
    char text[3000];
};

/** A kind of step. The first one of a device's table begins every row. */
struct cf_step {
    const char *verb;
    /** Do it; words[0] is the verb. @return false after cf_fail() */
    bool (*run)(void *ctx, char **words, size_t n, struct cf_report *report);
    bool expects; /**< it can fail because of the device */
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

/** What an audit finds, by kind. */
struct cf_audit {
    unsigned duplicate;   /**< IDs that stand twice */
    unsigned unknown;     /**< citations of an ID that does not exist */
    unsigned uncovered;   /**< clauses without a row */
    unsigned expectless;  /**< rows that cannot fail */
    unsigned clauseless;  /**< rows that cite nothing */
    unsigned same_titled; /**< rows with the title of another row */
    unsigned unlisted;    /**< listed clauses that the page does not have, or that a row cites */
};

/** Print into `report` and return false. */
bool cf_fail(struct cf_report *report, const char *format, ...);

/** Split `text` at blanks, in place. @return number of words, at most `max` */
size_t cf_split(char *text, char **words, size_t max);

/** Read the files; `page_name` may be NULL. @return false after saying on stderr what is wrong */
bool cf_load(struct cf_suite *suite, const char *clauses_name, const char *rows_name,
             const char *page_name);
void cf_unload(struct cf_suite *suite);

/** Check that clauses and rows fit each other; says every finding on `to`. */
struct cf_audit cf_audit(struct cf_suite *suite, const struct cf_device *device, FILE *to);

/** Clauses covered per chapter, on `to`. Call after cf_audit(). */
void cf_summary(const struct cf_suite *suite, FILE *to);

/** Run one row. @return false with the reason, file and line in `report` */
bool cf_run(const struct cf_suite *suite, const struct cf_row *row, const struct cf_device *device,
            struct cf_report *report);

/** The steps of an S36 with RS485 (hiperface_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_hiperface(void);

/** The steps of an S36 with BiSS (biss_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_biss(void);

/** The steps of an F36x8 on CAN (canopen_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_canopen(void);

/** The steps of an OCD with INTERBUS (interbus_steps.c). One bench: not for two at a time. */
const struct cf_device *cf_interbus(void);

#endif

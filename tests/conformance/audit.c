/* SPDX-License-Identifier: MIT */
/* Clauses and rows: whether they fit each other. Knows no device. */
#include "audit.h"

#include <string.h>

static bool has_expectation(const struct cf_suite *suite, const struct cf_row *row,
                            const struct cf_device *device)
{
    for (size_t i = 0; i < row->line_count; i++) {
        const struct cf_step *step = cf_find_step(device, suite->lines[row->first_line + i].text);

        if (step != NULL && step->expects) {
            return true;
        }
    }
    return false;
}

static unsigned finding(FILE *to, const char *name, int line, const char *what, const char *which)
{
    (void)fprintf(to, "%s:%d: %s: %s\n", name, line, what, which);
    return 1;
}

static void audit_row(struct cf_suite *suite, size_t index, const struct cf_device *device,
                      struct cf_audit *audit, FILE *to)
{
    const struct cf_row *row = &suite->rows[index];

    for (size_t i = 0; i < row->cited_count; i++) {
        struct cf_clause *clause = cf_find_clause(suite, row->cited[i]);

        if (clause == NULL) {
            audit->unknown +=
                finding(to, suite->rows_name, row->line, "no such clause", row->cited[i]);
        } else {
            clause->covered = true;
        }
    }
    for (size_t i = 0; i < index; i++) {
        if (strcmp(suite->rows[i].title, row->title) == 0) {
            audit->same_titled +=
                finding(to, suite->rows_name, row->line, "title stands twice", row->title);
        }
    }
    if (row->cited_count == 0) {
        audit->clauseless +=
            finding(to, suite->rows_name, row->line, "row cites no clause", row->title);
    }
    if (!has_expectation(suite, row, device)) {
        audit->expectless +=
            finding(to, suite->rows_name, row->line, "row expects nothing", row->title);
    }
}

/* Whether the device page has a row `| key |`. */
static bool page_has(const struct cf_suite *suite, const char *key)
{
    const size_t n = strlen(key);

    for (const char *at = suite->page; at != NULL && (at = strstr(at, "\n| ")) != NULL; at++) {
        if (strncmp(at + 3, key, n) == 0 && strncmp(at + 3 + n, " |", 2) == 0) {
            return true;
        }
    }
    return false;
}

static void audit_listed(const struct cf_suite *suite, const struct cf_clause *clause,
                         struct cf_audit *audit, FILE *to)
{
    if (!page_has(suite, clause->listed)) {
        audit->unlisted += finding(to, suite->clauses_name, clause->line,
                                   "the device page has no such row", clause->listed);
    }
    if (clause->covered) {
        audit->unlisted += finding(to, suite->clauses_name, clause->line,
                                   "does not hold, and a row cites it", clause->id);
    }
}

struct cf_audit cf_audit(struct cf_suite *suite, const struct cf_device *device, FILE *to)
{
    struct cf_audit audit = {0};

    for (size_t i = 0; i < suite->row_count; i++) {
        audit_row(suite, i, device, &audit, to);
    }
    for (size_t i = 0; i < suite->clause_count; i++) {
        const struct cf_clause *clause = &suite->clauses[i];

        if (cf_find_clause(suite, clause->id) != clause) {
            audit.duplicate +=
                finding(to, suite->clauses_name, clause->line, "ID stands twice", clause->id);
        } else if (clause->listed != NULL) {
            audit_listed(suite, clause, &audit, to);
        } else if (!clause->covered) {
            audit.uncovered +=
                finding(to, suite->clauses_name, clause->line, "no row proves", clause->id);
        }
    }
    return audit;
}

/* 5.1.2.1-3 belongs to 5.1.2; R8-2 to R; D-led to D. */
static size_t chapter_length(const char *id)
{
    size_t n = 0;
    unsigned dots = 0;

    if (id[0] < '0' || id[0] > '9') {
        return 1;
    }
    while (id[n] != '\0' && id[n] != '-' && (id[n] != '.' || ++dots < 3)) {
        n++;
    }
    return n;
}

void cf_summary(const struct cf_suite *suite, FILE *to)
{
    size_t covered = 0;
    size_t all_listed = 0;

    for (size_t i = 0; i < suite->clause_count; i++) {
        const char *id = suite->clauses[i].id;
        size_t n = chapter_length(id);
        size_t total = 0;
        size_t proved = 0;
        size_t listed = 0;
        bool first = true;

        for (size_t k = 0; k < suite->clause_count; k++) {
            const char *other = suite->clauses[k].id;

            if (chapter_length(other) == n && strncmp(id, other, n) == 0) {
                first = first && k >= i;
                total++;
                proved += suite->clauses[k].covered ? 1u : 0u;
                listed += suite->clauses[k].listed != NULL ? 1u : 0u;
            }
        }
        if (first) {
            (void)fprintf(to, "%-8.*s %4zu of %zu%s\n", (int)n, id, proved, total - listed,
                          listed > 0 ? ", others listed in the device page" : "");
        }
        covered += suite->clauses[i].covered ? 1u : 0u;
        all_listed += suite->clauses[i].listed != NULL ? 1u : 0u;
    }
    (void)fprintf(to,
                  "%-8s %4zu of %zu clauses, %zu rows; %zu clauses do not hold, and are listed\n",
                  "all", covered, suite->clause_count - all_listed, suite->row_count, all_listed);
}

/* SPDX-License-Identifier: MIT */
/* Lists of clauses and their rows: where they are, and what became of a clause. */
#define _GNU_SOURCE
#include <libgen.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "verify.h"
#include "verify_parts.h"

#define BESIDE "share/drehgeber/clauses"

/* Beside the program in a build tree, else where they are installed. */
static int find_folder(char *to, size_t size, struct lx_error *error)
{
    const char *own = getenv(VERIFY_FOLDER);
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    self[n < 0 ? 0 : n] = '\0';
    const char *folder = dirname(self);
    if (own != NULL && own[0] != '\0') {
        (void)snprintf(to, size, "%s", own);
    } else {
        (void)snprintf(to, size, "%s/" BESIDE, folder);
        if (access(to, X_OK) != 0) {
            (void)snprintf(to, size, "%s/" DREHGEBER_CLAUSES_FOLDER, folder);
        }
    }
    return access(to, X_OK) == 0
               ? 0
               : lx_fail(error, "no clauses at %s; $" VERIFY_FOLDER " names their folder", to);
}

static int load_files(struct cf_suite *to, const char *name, struct lx_error *error)
{
    char folder[PATH_MAX];
    char clauses[PATH_MAX + 64];
    char rows[PATH_MAX + 64];
    if (find_folder(folder, sizeof folder, error) != 0) {
        return -1;
    }
    (void)snprintf(clauses, sizeof clauses, "%s/%s.clauses", folder, name);
    (void)snprintf(rows, sizeof rows, "%s/%s.rows", folder, name);
    return cf_load(to, clauses, rows, NULL)
               ? 0
               : lx_fail(error, "%s: these clauses cannot be read", folder);
}

int verify_load_suites(struct verify_result *self, const struct verify_protocol *protocol,
                       const struct options *options, struct lx_error *error)
{
    for (size_t i = 0; i < VERIFY_SUITES_MAX && protocol->suites[i] != NULL; i++) {
        struct verify_suite *suite = &self->suites[i];
        suite->name = protocol->suites[i];
        suite->rows = calloc(1, sizeof *suite->rows);
        if (suite->rows == NULL) {
            return lx_fail(error, "no memory");
        }
        if ((protocol->load != NULL ? protocol->load(options, suite->rows, error)
                                    : load_files(suite->rows, suite->name, error)) != 0) {
            return -1;
        }
        suite->rows->rows_name = suite->name;
        suite->results = calloc(suite->rows->row_count + 1u, sizeof *suite->results);
        if (suite->results == NULL) {
            return lx_fail(error, "no memory");
        }
        self->suite_count++;
    }
    return 0;
}

void verify_unload_suites(struct verify_result *self)
{
    for (size_t i = 0; i < VERIFY_SUITES_MAX; i++) {
        struct verify_suite *suite = &self->suites[i];
        for (size_t k = 0; suite->results != NULL && k < suite->rows->row_count; k++) {
            free(suite->results[k].text);
        }
        if (suite->rows != NULL) {
            cf_unload(suite->rows);
        }
        free(suite->results);
        free(suite->rows);
    }
}

bool verify_asked(const struct verify_result *result, const char *clause)
{
    bool asked = result->word_count == 0;
    for (size_t i = 0; i < result->word_count; i++) {
        asked = asked || strncmp(clause, result->words[i], strlen(result->words[i])) == 0;
    }
    return asked;
}

enum verify_outcome verify_clause(const struct verify_suite *suite, const struct cf_clause *clause,
                                  const struct verify_row **because)
{
    enum verify_outcome outcome = VERIFY_NOT_SEEN;
    *because = NULL;
    for (size_t i = 0; i < suite->rows->row_count; i++) {
        const struct cf_row *row = &suite->rows->rows[i];
        const struct verify_row *result = &suite->results[i];
        bool cites = false;
        for (size_t k = 0; k < row->cited_count; k++) {
            cites = cites || strcmp(row->cited[k], clause->id) == 0;
        }
        const bool weightier = *because == NULL ||
                               (result->outcome == VERIFY_DIFFERS && outcome != VERIFY_DIFFERS) ||
                               (result->outcome == VERIFY_AGREES && outcome == VERIFY_NOT_SEEN);
        if (cites && weightier) {
            *because = result;
            outcome = result->outcome;
        }
    }
    return outcome;
}

/* SPDX-License-Identifier: MIT */
/* What was found out: as lines, for programs, for CI, for people. */
#include <string.h>

#include "drehgeber/version.h"
#include "verify_parts.h"

static const char *const words[] = {
    [VERIFY_AGREES] = "agrees",
    [VERIFY_DIFFERS] = "differs",
    [VERIFY_NOT_SEEN] = "not seen",
    [VERIFY_LOST] = "lost",
};

/* A clause, and what became of it. */
struct finding {
    const struct cf_clause *clause;
    enum verify_outcome outcome;
    const char *text; /* why; "": it agrees */
};

static struct finding find_clause(const struct verify_suite *suite, size_t index)
{
    const struct verify_row *because;
    struct finding found = {.clause = &suite->rows->clauses[index]};
    found.outcome = verify_clause(suite, found.clause, &because);
    found.text = because != NULL && because->text != NULL ? because->text : "";
    if (found.clause->listed != NULL) {
        found.text = "the manual contradicts itself; see 'Inaccuracies and choices'";
    }
    return found;
}

static void count(const struct verify_result *result, size_t counts[VERIFY_LOST + 1u])
{
    memset(counts, 0, (VERIFY_LOST + 1u) * sizeof counts[0]);
    for (size_t i = 0; i < result->suite_count; i++) {
        for (size_t k = 0; k < result->suites[i].rows->clause_count; k++) {
            const struct finding found = find_clause(&result->suites[i], k);
            counts[found.outcome] += verify_asked(result, found.clause->id) ? 1u : 0u;
        }
    }
}

static void print_sum(const struct verify_result *result, FILE *to)
{
    size_t counts[VERIFY_LOST + 1u];
    count(result, counts);
    (void)fprintf(to, "%zu clauses agree, %zu differ, %zu were not seen\n", counts[VERIFY_AGREES],
                  counts[VERIFY_DIFFERS], counts[VERIFY_NOT_SEEN]);
    if (result->lost[0] != '\0') {
        (void)fprintf(to, "it ended early: %s\n", result->lost);
    }
}

void verify_print_lines(const struct verify_result *result, FILE *to)
{
    (void)fprintf(to, "%s: %s\n", result->model, result->encoder->identity);
    for (size_t i = 0; i < result->suite_count; i++) {
        const struct verify_suite *suite = &result->suites[i];
        for (size_t k = 0; k < suite->rows->clause_count; k++) {
            const struct finding found = find_clause(suite, k);
            if (!verify_asked(result, found.clause->id)) {
                continue;
            }
            (void)fprintf(to, "%-8s %s%s%s\n", words[found.outcome], found.clause->id,
                          found.text[0] == '\0' ? "" : ": ", found.text);
        }
    }
    print_sum(result, to);
}

/* With what JSON, or XML, wants escaped. */
static void print_escaped(const char *text, bool xml, FILE *to)
{
    for (; *text != '\0'; text++) {
        const unsigned char c = (unsigned char)*text;
        if (xml && strchr("<>&\"", c) != NULL) {
            (void)fprintf(to, "&#%u;", (unsigned)c);
        } else if (c < ' ') {
            (void)fprintf(to, xml ? " " : "\\u%04x", (unsigned)c);
        } else {
            (void)fprintf(to, !xml && (c == '"' || c == '\\') ? "\\%c" : "%c", c);
        }
    }
}

static void print_member(const char *name, const char *text, const char *behind, FILE *to)
{
    (void)fprintf(to, "\"%s\": \"", name);
    print_escaped(text, false, to);
    (void)fprintf(to, "\"%s", behind);
}

void verify_print_json(const struct verify_result *result, FILE *to)
{
    const char *between = "[\n";
    for (size_t i = 0; i < result->suite_count; i++) {
        const struct verify_suite *suite = &result->suites[i];
        for (size_t k = 0; k < suite->rows->clause_count; k++) {
            const struct finding found = find_clause(suite, k);
            if (!verify_asked(result, found.clause->id)) {
                continue;
            }
            (void)fprintf(to, "%s  {", between);
            print_member("suite", suite->name, ", ", to);
            print_member("clause", found.clause->id, ", ", to);
            print_member("result", words[found.outcome], ", ", to);
            print_member("why", found.text, "}", to);
            between = ",\n";
        }
    }
    (void)fputs("\n]\n", to);
}

static void print_case(const struct verify_suite *suite, const struct finding *found, FILE *to)
{
    (void)fprintf(to, "  <testcase classname=\"%s\" name=\"", suite->name);
    print_escaped(found->clause->id, true, to);
    if (found->outcome == VERIFY_AGREES) {
        (void)fputs("\"/>\n", to);
        return;
    }
    (void)fprintf(to, "\"><%s message=\"",
                  found->outcome == VERIFY_NOT_SEEN ? "skipped" : "failure");
    print_escaped(found->text, true, to);
    (void)fputs("\"/></testcase>\n", to);
}

void verify_print_junit(const struct verify_result *result, FILE *to)
{
    size_t counts[VERIFY_LOST + 1u];
    count(result, counts);
    (void)fprintf(to,
                  "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"%s\" "
                  "tests=\"%zu\" failures=\"%zu\" skipped=\"%zu\">\n",
                  result->model,
                  counts[VERIFY_AGREES] + counts[VERIFY_DIFFERS] + counts[VERIFY_NOT_SEEN],
                  counts[VERIFY_DIFFERS], counts[VERIFY_NOT_SEEN]);
    for (size_t i = 0; i < result->suite_count; i++) {
        for (size_t k = 0; k < result->suites[i].rows->clause_count; k++) {
            const struct finding found = find_clause(&result->suites[i], k);
            if (verify_asked(result, found.clause->id)) {
                print_case(&result->suites[i], &found, to);
            }
        }
    }
    (void)fputs("</testsuite>\n", to);
}

/* Decisions have a letter before a number: R6a-2, C33-1, D-led; clauses of a manual begin with a
   digit, or with another letter, or with CIA. */
static bool is_choice(const struct verify_result *result, const char *id)
{
    return strchr(result->encoder->protocol->choices, id[0]) != NULL && strncmp(id, "CIA", 3) != 0;
}

static void print_found(const struct verify_result *result, bool choices, FILE *to)
{
    size_t n = 0;
    for (size_t i = 0; i < result->suite_count; i++) {
        const struct verify_suite *suite = &result->suites[i];
        for (size_t k = 0; k < suite->rows->clause_count; k++) {
            const struct finding found = find_clause(suite, k);
            if (!verify_asked(result, found.clause->id)) {
                continue;
            }
            const bool told =
                choices ? is_choice(result, found.clause->id) && found.outcome != VERIFY_NOT_SEEN
                        : found.outcome == VERIFY_DIFFERS;
            if (told) {
                (void)fprintf(to, "- %s %s: %s%s%s\n", suite->name, found.clause->id,
                              words[found.outcome], found.text[0] == '\0' ? "" : ": ", found.text);
                n++;
            }
        }
    }
    (void)fputs(n == 0 ? "- none\n" : "", to);
}

void verify_print_report(const struct verify_result *result, FILE *to)
{
    (void)fprintf(to, "Model: %s\nThe encoder says: %s\ndrehgeber: %s\n\n", result->model,
                  result->encoder->identity, DG_VERSION);
    print_sum(result, to);
    (void)fputs("\nDifferences\n\n", to);
    print_found(result, false, to);
    (void)fputs("\nChoices that this encoder settles\n\n", to);
    print_found(result, true, to);
}

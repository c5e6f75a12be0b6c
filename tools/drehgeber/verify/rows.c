/* SPDX-License-Identifier: MIT */
/* Clauses and rows: reading, running. Knows no device. */
#include "rows.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

bool cf_fail(struct cf_report *report, const char *format, ...)
{
    va_list args;

    va_start(args, format);
    (void)vsnprintf(report->text, sizeof report->text, format, args);
    va_end(args);
    return false;
}

size_t cf_split(char *text, char **words, size_t max)
{
    size_t n = 0;

    for (char *word = strtok(text, " \t"); word != NULL && n < max; word = strtok(NULL, " \t")) {
        words[n++] = word;
    }
    return n;
}

void cf_join(char *to, size_t size, char **words, size_t from, size_t end)
{
    size_t at = 0;

    for (size_t i = from; i < end; i++) {
        for (const char *c = words[i]; *c != '\0' && at + 1u < size; c++) {
            to[at++] = *c;
        }
    }
    to[at] = '\0';
}

size_t cf_find_equals(char **words, size_t n)
{
    size_t i = 1;

    while (i < n && strcmp(words[i], "=") != 0) {
        i++;
    }
    return i;
}

/* --- reading ------------------------------------------------------------------------------- */

static char *read_file(const char *name)
{
    FILE *file = fopen(name, "rb");
    char *text = NULL;
    long size = -1;

    if (file != NULL && fseek(file, 0, SEEK_END) == 0) {
        size = ftell(file);
        rewind(file);
    }
    if (size >= 0) {
        text = calloc(1, (size_t)size + 1);
    }
    if (text != NULL && fread(text, 1, (size_t)size, file) != (size_t)size) {
        free(text);
        text = NULL;
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    if (text == NULL) {
        (void)fprintf(stderr, "%s: cannot be read\n", name);
    }
    return text;
}

static bool complain_of_line(const char *name, int line, const char *what)
{
    (void)fprintf(stderr, "%s:%d: %s\n", name, line, what);
    return false;
}

/* Cuts blanks off both ends. */
static char *trim_blanks(char *text)
{
    size_t n;

    text += strspn(text, " \t\r");
    for (n = strlen(text); n > 0 && strchr(" \t\r", text[n - 1]) != NULL; n--) {
        text[n - 1] = '\0';
    }
    return text;
}

/* Before the key of a row of the device page. */
#define LISTED "listed "

static bool parse_clause(struct cf_suite *suite, char *text, int line)
{
    char *bar = strchr(text, '|');

    if (bar == NULL || suite->clause_count == CF_CLAUSES_MAX) {
        return complain_of_line(suite->clauses_name, line, "not `ID | text`, or too many clauses");
    }
    *bar = '\0';
    char *listed = strchr(bar + 1, '|');
    if (listed != NULL) {
        *listed = '\0';
        listed = trim_blanks(listed + 1);
        if (strncmp(listed, LISTED, strlen(LISTED)) != 0 || listed[strlen(LISTED)] == '\0') {
            return complain_of_line(suite->clauses_name, line, "not `ID | text | listed KEY`");
        }
        listed += strlen(LISTED);
    }
    if (*trim_blanks(text) == '\0' || *trim_blanks(bar + 1) == '\0') {
        return complain_of_line(suite->clauses_name, line, "ID or text is missing");
    }
    suite->clauses[suite->clause_count++] =
        (struct cf_clause){.id = trim_blanks(text), .listed = listed, .line = line};
    return true;
}

static bool parse_head(struct cf_suite *suite, char *text, int line)
{
    char *close = strchr(text, ']');
    struct cf_row *row = &suite->rows[suite->row_count];

    if (close == NULL || suite->row_count == CF_ROWS_MAX || *trim_blanks(close + 1) == '\0') {
        return complain_of_line(suite->rows_name, line, "not `[IDs] title`, or too many rows");
    }
    *close = '\0';
    *row = (struct cf_row){
        .title = trim_blanks(close + 1), .first_line = suite->line_count, .line = line};
    row->cited_count = cf_split(text + 1, row->cited, CF_CITED_MAX + 1u);
    if (row->cited_count > CF_CITED_MAX) {
        return complain_of_line(suite->rows_name, line, "row cites too many clauses to prove each");
    }
    suite->row_count++;
    return true;
}

static bool parse_row_line(struct cf_suite *suite, char *text, int line)
{
    if (text[0] == '[') {
        return parse_head(suite, text, line);
    }
    if (suite->row_count == 0 || suite->line_count == CF_LINES_MAX) {
        return complain_of_line(suite->rows_name, line,
                                "step before the first row, or too many steps");
    }
    suite->lines[suite->line_count++] = (struct cf_line){.text = text, .number = line};
    suite->rows[suite->row_count - 1].line_count++;
    return true;
}

static bool parse_lines(struct cf_suite *suite, char *text,
                        bool (*parse_line)(struct cf_suite *, char *, int))
{
    bool good = text != NULL;
    int line = 1;

    while (good && *text != '\0') {
        size_t n = strcspn(text, "\n");
        bool last = text[n] == '\0';
        char *body;

        text[n] = '\0';
        body = trim_blanks(text);
        if (*body != '\0' && *body != '#') {
            good = parse_line(suite, body, line);
        }
        text += last ? n : n + 1;
        line++;
    }
    return good;
}

bool cf_load(struct cf_suite *suite, const char *clauses_name, const char *rows_name,
             const char *page_name)
{
    memset(suite, 0, sizeof *suite);
    suite->clauses_name = clauses_name;
    suite->rows_name = rows_name;
    suite->texts[0] = read_file(clauses_name);
    suite->texts[1] = read_file(rows_name);
    suite->page = page_name == NULL ? NULL : read_file(page_name);
    return (page_name == NULL || suite->page != NULL) &&
           parse_lines(suite, suite->texts[0], parse_clause) &&
           parse_lines(suite, suite->texts[1], parse_row_line);
}

bool cf_load_texts(struct cf_suite *suite, const char *name, char *clauses, char *rows)
{
    memset(suite, 0, sizeof *suite);
    suite->clauses_name = name;
    suite->rows_name = name;
    suite->texts[0] = clauses;
    suite->texts[1] = rows;
    return parse_lines(suite, clauses, parse_clause) && parse_lines(suite, rows, parse_row_line);
}

void cf_unload(struct cf_suite *suite)
{
    free(suite->texts[0]);
    free(suite->texts[1]);
    free(suite->page);
}

/* --- finding ------------------------------------------------------------------------------- */

struct cf_clause *cf_find_clause(struct cf_suite *suite, const char *id)
{
    for (size_t i = 0; i < suite->clause_count; i++) {
        if (strcmp(suite->clauses[i].id, id) == 0) {
            return &suite->clauses[i];
        }
    }
    return NULL;
}

/* Whether the first word of `text` is `verb`. */
static bool begins(const char *text, const char *verb)
{
    const size_t n = strcspn(text, " \t");

    return strlen(verb) == n && strncmp(text, verb, n) == 0;
}

const struct cf_step *cf_find_step(const struct cf_device *device, const char *text)
{
    for (size_t i = 0; i < device->step_count; i++) {
        if (begins(text, device->steps[i].verb)) {
            return &device->steps[i];
        }
    }
    return NULL;
}

/* --- running ------------------------------------------------------------------------------- */

static bool run_line(const struct cf_suite *suite, const struct cf_line *line,
                     const struct cf_device *device, struct cf_report *report)
{
    struct cf_report reason;
    char text[1024];
    char *words[CF_WORDS_MAX] = {""};
    size_t n;

    (void)snprintf(text, sizeof text, "%s", line->text);
    n = cf_split(text, words, CF_WORDS_MAX);
    const struct cf_step *step = cf_find_step(device, words[0]);
    if (step == NULL) {
        return cf_fail(report, "%s:%d: unknown step: %s", suite->rows_name, line->number, words[0]);
    }
    if (!step->run(device->ctx, words, n, &reason)) {
        return cf_fail(report, "%s:%d: %s", suite->rows_name, line->number, reason.text);
    }
    return true;
}

/* A block `repeat N` .. `end` that starts at line `at`; returns the index behind it, 0 on failure.
 */
static size_t run_block(const struct cf_suite *suite, size_t at, size_t end,
                        const struct cf_device *device, struct cf_report *report)
{
    const struct cf_line *head = &suite->lines[at];
    unsigned long times = strtoul(head->text + strlen("repeat"), NULL, 10);
    size_t last = at + 1;

    while (last < end && strcmp(suite->lines[last].text, "end") != 0) {
        last++;
    }
    if (last == end || times == 0) {
        (void)cf_fail(report, "%s:%d: repeat without count or end", suite->rows_name, head->number);
        return 0;
    }
    for (; times > 0; times--) {
        for (size_t i = at + 1; i < last; i++) {
            if (!run_line(suite, &suite->lines[i], device, report)) {
                return 0;
            }
        }
    }
    return last + 1;
}

bool cf_run(const struct cf_suite *suite, const struct cf_row *row, const struct cf_device *device,
            struct cf_report *report)
{
    size_t end = row->first_line + row->line_count;
    size_t at = row->first_line;
    struct cf_report reason;

    device->begin(device->ctx);
    if (at < end && !begins(suite->lines[at].text, device->steps[0].verb)) {
        return cf_fail(report, "%s:%d: a row starts with `%s`", suite->rows_name, row->line,
                       device->steps[0].verb);
    }
    while (at < end) {
        if (strncmp(suite->lines[at].text, "repeat ", 7) == 0) {
            at = run_block(suite, at, end, device, report);
            if (at == 0) {
                return false;
            }
        } else if (run_line(suite, &suite->lines[at], device, report)) {
            at++;
        } else {
            return false;
        }
    }
    if (!device->finish(device->ctx, &reason)) {
        return cf_fail(report, "%s:%d: at the end: %s", suite->rows_name, row->line, reason.text);
    }
    return true;
}

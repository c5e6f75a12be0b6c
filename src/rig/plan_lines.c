/* SPDX-License-Identifier: MIT */
/*
 * Lines of a rig file: sections, and words with the line that each stands in. What a line may look
 * like is what the inih library takes, one line at a time: an indented line is one of its own.
 */
#include "rig_private.h"

#include <string.h>

/* The start of a line, for a message. */
#define QUOTED 40u
/* More keys than any section has: each is compared with all before it. */
#define WORDS_MAX 256u
/* Empty ones count nothing otherwise, and cost their host some memory each. */
#define INCLUDES_MAX 4096u

/* A line that is being taken apart, with its end and a zero. */
struct line {
    char text[DG_PLAN_LINE_MAX + 2u];
    char quoted[QUOTED + 1u];
};

static struct rig_file *top_of(struct rig_reader *self)
{
    return &self->files[self->depth - 1u];
}

static bool is_rig_blank(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static char *skip_blanks(char *text)
{
    while (is_rig_blank(*text)) {
        text++;
    }
    return text;
}

/* Blanks at the end become zeros. */
static char *trim_end(char *text)
{
    for (size_t n = dg_plan_length(text); n > 0 && is_rig_blank(text[n - 1u]); n--) {
        text[n - 1u] = '\0';
    }
    return text;
}

static bool is_comment(char c)
{
    return c == ';' || c == '#';
}

/* ---------------------------------------------------------------- sections */

/* Its words lie at the back of the memory, those of an open one of a file in front of them. */
static void forget_section(struct rig_reader *self, struct rig_file *file)
{
    if (file->section.kind != NULL) {
        self->plan->end = (unsigned char *)file->section.words;
    }
    file->section = (struct rig_section){.kind = NULL};
}

static int end_section(struct rig_reader *self)
{
    struct rig_file *file = top_of(self);
    const int result = file->section.kind == NULL ? 0 : dg_plan_section_take(self, &file->section);

    forget_section(self, file);
    return result;
}

/* The next word of a section's line; "" behind the last. */
static const char *next_word(char **text)
{
    char *found = skip_blanks(*text);
    char *end = found;

    while (*end != '\0' && !is_rig_blank(*end)) {
        end++;
    }
    *text = *end == '\0' ? end : end + 1;
    *end = '\0';
    return found;
}

/* The section's own brackets are what the error is about. */
static int refuse_section_name(struct rig_reader *self, const char *kind, const char *name,
                               const char *more)
{
    char section[DG_PLAN_LINE_MAX + 8u];
    struct dg_text text = dg_text_in(section, sizeof section);

    dg_plan_add(&text, RIG_SAY("[", kind, *name == '\0' ? "" : " ", name, more, "]"));
    (void)dg_plan_refuse(self->error,
                         RIG_SAY("expected a name of 1 to ", dg_plan_number(DG_PLAN_NAME_MAX).text,
                                 " letters, digits, _ and -, as in [", kind, " a1]"),
                         NULL);
    return dg_plan_refuse_key(self, section, self->line);
}

/* What stands between the brackets: "KIND" or "KIND NAME". */
static int name_section(struct rig_reader *self, char *text)
{
    const char *kind = next_word(&text);
    const char *name = next_word(&text);
    const char *more = next_word(&text);
    const struct rig_kind *found = dg_plan_kind_find(kind);

    if (found == NULL) {
        return dg_plan_wrong_line(self, self->line, RIG_SAY("expected " RIG_SECTIONS),
                                  RIG_SAY("[", kind, "]: no such section"));
    }
    if (!found->named && *name != '\0') {
        return dg_plan_wrong_line(self, self->line, RIG_SAY("expected [", kind, "]"),
                                  RIG_SAY("[", kind, " ", name, "]: has no name"));
    }
    if (found->named && (*more != '\0' || !dg_plan_name_fits(name))) {
        return refuse_section_name(self, kind, name, *more == '\0' ? "" : " ...");
    }
    struct rig_section *section = &top_of(self)->section;
    section->kind = found;
    section->line = self->line;
    section->words = (struct dg_plan_setting *)(void *)self->plan->end;
    memcpy(section->name, name, dg_plan_length(name) + 1u);
    return 0;
}

/* A line that begins with '['. Behind the ']' a comment may stand. */
static int begin_section(struct rig_reader *self, struct line *line)
{
    const size_t n = dg_plan_span(line->text, ']');
    char *behind = line->text[n] == '\0' ? NULL : skip_blanks(line->text + n + 1u);

    if (end_section(self) != 0) {
        return -1;
    }
    if (behind == NULL || (*behind != '\0' && !is_comment(*behind))) {
        return dg_plan_wrong_line(self, self->line,
                                  RIG_SAY("expected [KIND NAME] on a separate line"),
                                  RIG_SAY("'", line->quoted, "' is no section"));
    }
    line->text[n] = '\0';
    return name_section(self, line->text + 1);
}

/* ---------------------------------------------------------------- files */

/* Lines from the next one on are of file `source`, whose line `next` that is. */
static int begin_piece(struct rig_reader *self, size_t source, unsigned next)
{
    struct dg_plan *plan = self->plan;
    struct dg_plan_piece *list = dg_plan_grow(plan, plan->pieces, plan->piece_count, sizeof *list);

    if (list == NULL) {
        return -1;
    }
    plan->pieces = list;
    list[plan->piece_count++] = (struct dg_plan_piece){self->line + 1u, next, source};
    return 0;
}

static int add_source(struct rig_reader *self, const struct dg_plan_source *source)
{
    struct dg_plan *plan = self->plan;
    struct dg_plan_source *list =
        dg_plan_grow(plan, plan->sources, plan->source_count, sizeof *list);

    if (list == NULL) {
        return -1;
    }
    plan->sources = list;
    list[plan->source_count++] = *source;
    return 0;
}

/* The first file gets its row when another one comes. */
static int begin_sources(struct rig_reader *self)
{
    const struct dg_plan_source first = {.file = self->plan->file};

    if (self->plan->source_count > 0) {
        return 0;
    }
    if (add_source(self, &first) != 0 || begin_piece(self, 0, 1) != 0) {
        return -1;
    }
    self->plan->pieces[0].first = 1;
    return 0;
}

static int check_include(struct rig_reader *self, const struct dg_plan_setting *word)
{
    if (dg_plan_check_below(self, word) != 0) {
        return -1;
    }
    if (self->plan->source_count > INCLUDES_MAX) { /* the first one is no included file */
        return dg_plan_wrong_word(
            self, word, RIG_SAY("expected fewer"),
            RIG_SAY("one more than ", dg_plan_number(INCLUDES_MAX).text, " included files"));
    }
    return self->depth < DG_PLAN_DEPTH_MAX
               ? 0
               : dg_plan_wrong_word(self, word, RIG_SAY("expected fewer"),
                                    RIG_SAY(dg_plan_number(DG_PLAN_DEPTH_MAX).text,
                                            " files include each other already"));
}

/* The words of a file take the place of the word that includes it. */
static int include_file(struct rig_reader *self, const struct dg_plan_setting *word)
{
    struct rig_file next = {.source =
                                self->plan->source_count == 0 ? 1u : self->plan->source_count};
    if (check_include(self, word) != 0) {
        return -1;
    }
    const struct dg_plan_source source = {
        .file = dg_plan_path(self, word->value, self->line),
        .parent = top_of(self)->source,
        .line = self->line,
    };
    if (source.file == NULL || begin_sources(self) != 0) {
        return -1;
    }
    if (dg_plan_fetch_text(self, word, source.file, &next.text) != 0) {
        return -1;
    }
    if (next.text.n > DG_PLAN_INCLUDED_MAX - self->included) {
        return dg_plan_wrong_word(self, word, RIG_SAY("expected less"),
                                  RIG_SAY("more than ", dg_plan_number(DG_PLAN_INCLUDED_MAX).text,
                                          " bytes in all included files"));
    }
    self->included += next.text.n;
    self->files[self->depth++] = next;
    return add_source(self, &source) == 0 ? begin_piece(self, next.source, 1) : -1;
}

/* The last line of the file was read. */
static int end_file(struct rig_reader *self)
{
    if (end_section(self) != 0) {
        return -1;
    }
    self->depth--;
    return self->depth == 0 ? 0 : begin_piece(self, top_of(self)->source, top_of(self)->line + 1u);
}

/* ---------------------------------------------------------------- words */

static int take_word(struct rig_reader *self, const char *key, const char *value)
{
    struct rig_section *section = &top_of(self)->section;
    const struct rig_kind *kind = section->kind;
    const struct dg_plan_setting word = {key, value, self->line};
    const struct dg_plan_setting *before = kind == NULL ? NULL : dg_plan_word(section, key);

    if (*key == '\0') {
        return dg_plan_wrong_line(self, self->line, RIG_SAY("expected KEY = VALUE"),
                                  RIG_SAY("no key in front of '= ", value, "'"));
    }
    if (kind == NULL) {
        return dg_plan_wrong_word(self, &word, RIG_SAY("expected " RIG_SECTIONS),
                                  RIG_SAY("stands before the first section"));
    }
    if (kind->at_once != NULL && dg_plan_same(kind->at_once, key)) {
        return include_file(self, &word);
    }
    if (before != NULL && (kind->repeats == NULL || !dg_plan_same(kind->repeats, key))) {
        return dg_plan_wrong_word(
            self, &word, RIG_SAY("expected one of them"),
            RIG_SAY("given in line ", dg_plan_line_text(self->plan, before->line, self->line).text,
                    " already"));
    }
    return section->count < WORDS_MAX
               ? dg_plan_word_add(self, section, &word)
               : dg_plan_wrong_word(
                     self, &word, RIG_SAY("expected fewer"),
                     RIG_SAY("one more than ", dg_plan_number(WORDS_MAX).text, " in a section"));
}

/* Where the key ends, or a comment begins, which has a blank in front. With `keys` at the first of
   '=' and ':', too. */
static char *find_end(char *text, bool keys)
{
    bool blank = false;

    while (*text != '\0' && !(keys && (*text == '=' || *text == ':')) && !(blank && *text == ';')) {
        blank = is_rig_blank(*text);
        text++;
    }
    return text;
}

static int take_assignment(struct rig_reader *self, struct line *line)
{
    char *key = trim_end(line->text);
    char *equals = find_end(key, true);

    if (*equals != '=' && *equals != ':') {
        return dg_plan_wrong_line(
            self, self->line, RIG_SAY("expected one of them"),
            RIG_SAY("'", line->quoted, "' is neither [SECTION] nor KEY = VALUE"));
    }
    *equals = '\0';
    *find_end(equals + 1, false) = '\0';
    return take_word(self, trim_end(key), trim_end(skip_blanks(equals + 1)));
}

/* ---------------------------------------------------------------- lines */

/* Blanks in front are no part of it. A byte order mark opens many files. */
static void trim_start(struct line *line, bool first)
{
    static const char mark[] = "\xEF\xBB\xBF";
    char *text = skip_blanks(line->text + (first && dg_plan_begins(line->text, mark) ? 3u : 0u));
    size_t n = 0;

    memmove(line->text, text, dg_plan_length(text) + 1u);
    while (n < QUOTED && line->text[n] != '\r' && line->text[n] != '\n' && line->text[n] != '\0') {
        n++;
    }
    memcpy(line->quoted, line->text, n);
    line->quoted[n] = '\0';
}

/* The next line with its end. A last line without one may have a zero in it, which ends it.
   @return false: it is too long, or no text at all */
static bool fetch_line(struct rig_file *file, struct line *line)
{
    const char *from = file->text.text + file->at;
    const size_t left = file->text.n - file->at;
    size_t n = 0;

    while (n < left && n < sizeof line->text - 1u && from[n] != '\n' && from[n] != '\0') {
        n++;
    }
    const bool ended = n < left && n < sizeof line->text - 1u && from[n] == '\n';
    size_t rest = n;
    while (rest < left && rest < sizeof line->text - 1u && from[rest] != '\n') {
        rest++;
    }
    n += ended ? 1u : 0u;
    memcpy(line->text, from, n);
    line->text[n] = '\0';
    file->at += ended ? n : rest;
    return ended || (rest == left && rest < sizeof line->text - 1u);
}

static int take_rig_line(struct rig_reader *self)
{
    struct rig_file *file = top_of(self);
    struct line line = {.text = ""};

    self->line++;
    file->line++;
    if (!fetch_line(file, &line)) {
        return dg_plan_wrong_line(self, self->line, RIG_SAY("expected a shorter line of text"),
                                  RIG_SAY("more than ", dg_plan_number(DG_PLAN_LINE_MAX).text,
                                          " characters, or no text at all"));
    }
    trim_start(&line, file->line == 1u);
    if (line.text[0] == '[') {
        return begin_section(self, &line);
    }
    return line.text[0] == '\0' || is_comment(line.text[0]) ? 0 : take_assignment(self, &line);
}

int dg_plan_read_lines(struct rig_reader *self)
{
    int result = 0;

    self->depth = 1;
    self->files[0].text = self->setup->text;
    while (result == 0 && self->depth > 0) {
        const struct rig_file *file = top_of(self);
        result = file->at < file->text.n ? take_rig_line(self) : end_file(self);
    }
    return result;
}

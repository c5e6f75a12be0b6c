/* SPDX-License-Identifier: MIT */
/*
 * What the reader of rig files says about the files of a release and about mutants of them: taken,
 * or the line and the words of the refusal. Compares that with the record, writes the record
 * anew, or writes the mutants for those who read them otherwise.
 *
 * The record (rigs/verdicts.record) has the name of a file in brackets, then a line for each
 * mutant: its seed, and "taken" or the refusal; seed 0 is the file itself. What would be right is
 * the same in many refusals: it stands once, below [right], and "@3" means the third of these.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "give_up.h"
#include "memory_file.h"
#include "plan.h"
#include "record.h"

#define MUTANTS 5000u
#define RIGHTS_MAX 1000u
#define TEXT_MAX 16384u
#define SHOWN_MAX 10u
#define ROUNDS_MAX 2u
#define COUNT(array) ((uint32_t)(sizeof(array) / sizeof(array)[0]))

/* A rig file, or a mutant of it. */
struct text {
    size_t length;
    char bytes[TEXT_MAX];
};

/* The rig files, and what is said about them. */
struct book {
    const char *folder;
    struct dirent **files;
    int count;
    char *rights[RIGHTS_MAX]; /* in the order of their first use */
    size_t right_count;
    unsigned shown; /* differences */
    FILE *out;
};

/* --- mutants --- */

/* xorshift32: the same numbers on every machine. */
static uint32_t draw_number(uint32_t *random, uint32_t below)
{
    *random ^= *random << 13;
    *random ^= *random >> 17;
    *random ^= *random << 5;
    return below == 0 ? 0 : *random % below;
}

/* `length` bytes at `at` become `with`; what has no room stays as it was. */
static void replace_bytes(struct text *self, size_t at, size_t length, const char *with,
                          size_t size)
{
    if (self->length - length + size > sizeof self->bytes) {
        return;
    }
    memmove(self->bytes + at + size, self->bytes + at + length, self->length - at - length);
    memcpy(self->bytes + at, with, size);
    self->length += size - length;
}

static size_t start_of_line(const struct text *self, size_t at)
{
    while (at > 0 && self->bytes[at - 1] != '\n') {
        at--;
    }
    return at;
}

/* With its line end. */
static size_t length_of_line(const struct text *self, size_t start)
{
    const char *end = memchr(self->bytes + start, '\n', self->length - start);
    return end == NULL ? self->length - start : (size_t)(end - self->bytes) + 1 - start;
}

/* A place in the text; the words of a short line are met as often as those of a long one. */
static size_t draw_line(const struct text *self, uint32_t *random)
{
    uint32_t lines = 1;
    for (size_t i = 0; i + 1 < self->length; i++) {
        lines += self->bytes[i] == '\n';
    }
    size_t start = 0;
    for (uint32_t left = draw_number(random, lines); left > 0; left--) {
        start += length_of_line(self, start);
    }
    return start;
}

static size_t draw_place(const struct text *self, uint32_t *random)
{
    const size_t start = draw_line(self, random);
    return start + draw_number(random, (uint32_t)length_of_line(self, start));
}

static void change_byte(struct text *self, uint32_t *random)
{
    static const char bytes[] = "=:;#[].,-_ \t\n\r\"'%0123456789abxyzABZ\\/\x01\x7F\xC3\xFF";
    const size_t at = draw_place(self, random);
    const size_t length = draw_number(random, 2);
    replace_bytes(self, at, length, &bytes[draw_number(random, COUNT(bytes))], 1);
}

static void remove_bytes(struct text *self, uint32_t *random)
{
    const size_t at = draw_place(self, random);
    const size_t length = 1 + draw_number(random, 3);
    replace_bytes(self, at, length < self->length - at ? length : self->length - at, "", 0);
}

static void remove_line(struct text *self, uint32_t *random)
{
    const size_t start = draw_line(self, random);
    replace_bytes(self, start, length_of_line(self, start), "", 0);
}

/* A line again, somewhere else: a key twice, a section twice, a key of another section. */
static void copy_line(struct text *self, uint32_t *random)
{
    const struct text before = *self;
    const size_t from = draw_line(self, random);
    replace_bytes(self, draw_line(self, random), 0, before.bytes + from,
                  length_of_line(&before, from));
}

/* The value of one line for that of another one. */
static void copy_value(struct text *self, uint32_t *random)
{
    const struct text before = *self;
    const size_t from = draw_place(self, random);
    const size_t to = draw_place(self, random);
    const size_t line = start_of_line(self, from);
    const char *value = memchr(self->bytes + line, '=', length_of_line(self, line));
    const size_t start = start_of_line(self, to);
    const size_t length = length_of_line(self, start);
    const char *equals = memchr(self->bytes + start, '=', length);
    if (value != NULL && equals != NULL) {
        const size_t at = (size_t)(equals - self->bytes);
        const size_t first = (size_t)(value - self->bytes);
        replace_bytes(self, at, start + length - at, before.bytes + first,
                      line + length_of_line(&before, line) - first);
    }
}

static void add_words(struct text *self, uint32_t *random)
{
    /* clang-format off */
    static const char *const words[] = {
        "[rig]\n", "[shaft a]\n", "[bus b]\n", "[encoder c]\n", "name = x\n", "control = tcp\n",
        "files = .\n", "motion = 60RPM\n", "driver = main\n", "ratio = 1:0\n", "wire = pty\n",
        "wire = sim\n", "wire = slcan:x\n", "wire = rope\n", "address = x\n", "address = 0x41\n",
        "node = 128\n", "node = 5..3\n", "node = 7\n", "pace = 2\n", "cycle = 0\n",
        "trace = x.vcd\n", "nvm = x\n", "serial = \n", "model = f3668\n", "model = s36\n",
        "bus = line\n", "shaft = none\n", "colour = red\n", "temperature = 85\n", " ; more\n",
        "= \n", "\xEF\xBB\xBF", "99999999999", "1e3", "motion = a.csv\n",
        "temperature = a.csv,LOOP\n", "[", "]", "\n", "0x", "..",
    };
    /* clang-format on */
    const char *word = words[draw_number(random, COUNT(words))];
    const bool whole = strchr(word, '\n') != NULL;
    const size_t at = whole ? draw_line(self, random) : draw_place(self, random);
    replace_bytes(self, at, 0, word, strlen(word));
}

static void cut_off(struct text *self, uint32_t *random)
{
    self->length = draw_place(self, random);
}

static void mutate_text(struct text *self, uint32_t seed)
{
    static void (*const ways[])(struct text *, uint32_t *) = {
        change_byte, change_byte, remove_bytes, remove_line, copy_line,
        copy_value,  copy_value,  add_words,    add_words,   cut_off,
    };
    uint32_t random = seed * 2654435761u + 1u;
    for (uint32_t rounds = 1 + draw_number(&random, ROUNDS_MAX); rounds > 0; rounds--) {
        ways[draw_number(&random, COUNT(ways))](self, &random);
    }
}

/* --- verdicts --- */

/* Printable, and without the name of the file. */
static void put_words(FILE *out, const char *words, size_t n, const char *file)
{
    const size_t name = strlen(file);
    for (size_t i = 0; i < n; i++) {
        const uint8_t byte = (uint8_t)words[i];
        if (n - i >= name && memcmp(words + i, file, name) == 0) {
            i += name - 1;
        } else if (byte < ' ' || byte > '~') {
            (void)fprintf(out, "\\x%02X", byte);
        } else {
            (void)fputc(byte, out);
        }
    }
}

/* @return its number */
static size_t find_right(struct book *self, const char *right)
{
    size_t i = 0;
    for (; i < self->right_count && strcmp(self->rights[i], right) != 0; i++) {
    }
    if (i == RIGHTS_MAX) {
        give_up("more different refusals than there is room for", self->folder);
    }
    if (i == self->right_count) {
        self->rights[self->right_count++] = strdup(right);
    }
    return i + 1;
}

static void put_refusal(struct book *self, const struct lx_error *error, const char *file)
{
    const struct lx_words line = lx_error_line(error);
    const size_t n = strlen(line.text);
    const size_t right = strlen(error->right);
    const bool apart = right > 0 && n >= right && strcmp(line.text + n - right, error->right) == 0;
    put_words(self->out, line.text, apart ? n - right : n, file);
    if (apart) {
        (void)fprintf(self->out, "@%zu", find_right(self, error->right));
    }
}

static void judge_text(struct book *self, const struct text *text)
{
    const char *file = memory_file_write((const uint8_t *)text->bytes, text->length);
    struct lx_error error = {.right = ""};
    struct dg_plan plan;
    if (lx_plan_read(&plan, file, &error) == 0) {
        (void)fputs("taken", self->out);
        lx_plan_free(&plan);
    } else {
        put_refusal(self, &error, file);
    }
}

static void read_rig(const struct book *self, const char *name, struct text *text)
{
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/%s", self->folder, name);
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        give_up("cannot open", path);
    }
    text->length = fread(text->bytes, 1, sizeof text->bytes, file);
    (void)fclose(file);
    if (text->length == 0 || text->length == sizeof text->bytes) {
        give_up("empty, or longer than there is room for", path);
    }
}

/* Each file with its mutants, handed over one by one. */
static void judge_all(struct book *self, void (*judge)(struct book *, const struct text *))
{
    static struct text rig;
    static struct text mutant;
    for (int i = 0; i < self->count; i++) {
        const char *name = self->files[i]->d_name;
        read_rig(self, name, &rig);
        (void)fprintf(self->out, "[%s]\n", name);
        for (uint32_t seed = 0; seed <= MUTANTS / (uint32_t)self->count; seed++) {
            mutant = rig;
            if (seed > 0) {
                mutate_text(&mutant, seed);
            }
            (void)fprintf(self->out, "%u ", seed);
            judge(self, &mutant);
            (void)fputc('\n', self->out);
        }
    }
}

static void put_rights(struct book *self)
{
    (void)fputs("[right]\n", self->out);
    for (size_t i = 0; i < self->right_count; i++) {
        (void)fprintf(self->out, "@%zu ", i + 1);
        put_words(self->out, self->rights[i], strlen(self->rights[i]), "\n");
        (void)fputc('\n', self->out);
        free(self->rights[i]);
    }
}

/* For readers of other languages: its length, and the bytes. */
static void put_text(struct book *self, const struct text *text)
{
    (void)fprintf(self->out, "%zu\n", text->length);
    (void)fwrite(text->bytes, 1, text->length, self->out);
}

/* --- the record --- */

/* The text of line `said` of the section of a file. */
static void show_mutant(const struct book *self, const char *section, const char *said)
{
    static struct text text;
    const uint32_t seed = (uint32_t)strtoul(said, NULL, 10);
    char name[256];
    (void)snprintf(name, sizeof name, "%.*s", (int)strlen(section) - 2, section + 1);
    read_rig(self, name, &text);
    if (seed > 0) {
        mutate_text(&text, seed);
    }
    (void)printf("  the mutant:\n%.*s\n", (int)text.length, text.bytes);
}

static void show_verdict(void *ctx, const char *section, const char *was, const char *is)
{
    struct book *self = ctx;
    if (++self->shown > SHOWN_MAX) {
        return;
    }
    (void)printf("%s\n  before: %s\n  now:    %s\n", section, was == NULL ? "-" : was,
                 is == NULL ? "-" : is);
    if (is != NULL && *is != '[' && strcmp(section, "[right]") != 0) {
        show_mutant(self, section, is);
    }
}

static int is_rig(const struct dirent *entry)
{
    const char *dot = strrchr(entry->d_name, '.');
    return dot != NULL && strcmp(dot, ".ini") == 0;
}

static unsigned settle_record(struct book *book, bool update)
{
    char path[4096];
    char *now = NULL;
    size_t size = 0;
    book->out = open_memstream(&now, &size);
    judge_all(book, judge_text);
    put_rights(book);
    (void)fclose(book->out);
    (void)snprintf(path, sizeof path, "%s/verdicts.record", book->folder);
    const unsigned differences = record_settle(path, now, update, show_verdict, book);
    (void)printf("%u of %u verdicts differ\n", differences, MUTANTS);
    free(now);
    return differences;
}

int main(int argc, char **argv)
{
    struct book book = {.folder = argv[argc - 1], .out = stdout};
    const bool update = argc == 3 && strcmp(argv[1], "--update") == 0;
    const bool texts = argc == 3 && strcmp(argv[1], "--texts") == 0;
    unsigned differences = 0;
    if (argc != 2 && !update && !texts) {
        (void)fprintf(stderr, "usage: %s [--update|--texts] FOLDER\n", argv[0]);
        return 2;
    }
    book.count = scandir(book.folder, &book.files, is_rig, alphasort);
    if (book.count <= 0) {
        give_up("no rig files", book.folder);
    }
    if (texts) {
        judge_all(&book, put_text);
    } else {
        differences = settle_record(&book, update);
    }
    for (int i = 0; i < book.count; i++) {
        free(book.files[i]);
    }
    free(book.files);
    return differences == 0 ? 0 : 1;
}

/* SPDX-License-Identifier: MIT */
/*
 * The text of an EDS file (CiA 306) is read here once more, by another reader than that of the
 * encoders which are made of such files: what it says is compared with what a device does.
 * Of each sub-index there are up to four clauses:
 *
 *   1018:1         it is there, or, if it can only be written, it is refused
 *   1018:1-type    its value has as many bytes as its type
 *   1018:1-limits  its value lies between them
 *   1018:1-value   its value is the default: of a constant always, of others until it is written
 */
#include "verify_eds.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "drehgeber/bits.h"
#include "drehgeber/cia406.h"
#include "drehgeber/devices.h"
#include "eds_file.h"

#define NODE_USUAL 63u
#define WORD_MAX 64u
/* Numbers that one upload brings. */
#define NUMBER_MAX 4u

enum access { UNKNOWN, CONSTANT, READ, WRITE, BOTH };

/* A section of the file that has an object. */
struct section {
    unsigned index; /* 0: it has none */
    unsigned sub;
    unsigned kind; /* ObjectType */
    unsigned type; /* DataType */
    enum access access;
    char name[WORD_MAX];
    char initial[WORD_MAX]; /* "": none; likewise the next two */
    char low[WORD_MAX];
    char high[WORD_MAX];
};

struct writing {
    const struct options *options;
    const char *model; /* that the rows name */
    uint8_t node;
    FILE *clauses;
    FILE *rows;
    size_t count; /* of clauses */
};

/* Bytes of a value by its type (CiA 301), 0: as many as it likes. */
static size_t size_of_type(unsigned type)
{
    static const uint8_t sizes[0x1C] = {
        [0x01] = 1, [0x02] = 1, [0x03] = 2, [0x04] = 4, [0x05] = 1, [0x06] = 2, [0x07] = 4,
        [0x08] = 4, [0x10] = 3, [0x11] = 8, [0x12] = 5, [0x13] = 6, [0x14] = 7, [0x15] = 8,
        [0x16] = 3, [0x18] = 5, [0x19] = 6, [0x1A] = 7, [0x1B] = 8,
    };
    return type < sizeof sizes ? sizes[type] : 0;
}

static bool is_signed_type(unsigned type)
{
    return (type >= 0x02 && type <= 0x04) || type == 0x10;
}

static bool is_number_type(unsigned type)
{
    const size_t size = size_of_type(type);
    return type != 0x08 && size >= 1 && size <= NUMBER_MAX;
}

/* --- reading --- */

/* "1018sub1", "6004": an object or a sub-index of one. */
static bool parse_section(const char *text, struct section *to)
{
    static const char digits[] = "0123456789abcdefABCDEF";
    *to = (struct section){.kind = 7};
    if (strspn(text, digits) != 4) {
        return false;
    }
    const unsigned index = (unsigned)strtoul(text, NULL, 16);
    const char *rest = text + 4;
    if (*rest != '\0') {
        const size_t n = strncasecmp(rest, "sub", 3) == 0 ? strspn(rest + 3, digits) : 0;
        if (n < 1 || n > 2 || rest[3 + n] != '\0') {
            return false;
        }
        to->sub = (unsigned)strtoul(rest + 3, NULL, 16);
    }
    to->index = index >= 0x1000u ? index : 0; /* those below are types */
    return true;
}

static enum access parse_access(const char *text)
{
    static const struct {
        const char *word;
        enum access access;
    } words[] = {{"const", CONSTANT}, {"ro", READ},  {"wo", WRITE},
                 {"rw", BOTH},        {"rwr", BOTH}, {"rww", BOTH}};
    for (size_t i = 0; i < DG_COUNT(words); i++) {
        if (strcasecmp(words[i].word, text) == 0) {
            return words[i].access;
        }
    }
    return UNKNOWN;
}

static void take_key(struct section *section, const char *key, const char *value)
{
    const struct {
        const char *key;
        char *to;
    } texts[] = {{"ParameterName", section->name},
                 {"DefaultValue", section->initial},
                 {"LowLimit", section->low},
                 {"HighLimit", section->high}};
    for (size_t i = 0; i < DG_COUNT(texts); i++) {
        if (strcasecmp(texts[i].key, key) == 0) {
            (void)snprintf(texts[i].to, WORD_MAX, "%s", value);
        }
    }
    if (strcasecmp(key, "ObjectType") == 0) {
        section->kind = (unsigned)strtoul(value, NULL, 0);
    } else if (strcasecmp(key, "DataType") == 0) {
        section->type = (unsigned)strtoul(value, NULL, 0);
    } else if (strcasecmp(key, "AccessType") == 0) {
        section->access = parse_access(value);
    }
}

/* What is neither blank nor a control character, nor has a meaning in a list of clauses. */
static char *tidy_text(char *text)
{
    while (isspace((unsigned char)*text)) {
        text++;
    }
    for (size_t n = strlen(text); n > 0 && isspace((unsigned char)text[n - 1u]); n--) {
        text[n - 1u] = '\0';
    }
    for (char *at = text; *at != '\0'; at++) {
        if (iscntrl((unsigned char)*at) || *at == '|' || *at == ']') {
            *at = '?';
        }
    }
    return text;
}

/* "0x180+$NODEID", "-5", "017". @return false: it is no number */
static bool parse_number(const struct writing *self, const char *text, uint64_t *value)
{
    static const char node[] = "$NODEID";
    char rest[WORD_MAX];
    char *end;
    (void)snprintf(rest, sizeof rest, "%s", text);
    *value = 0;
    for (char *at = rest; *at != '\0'; at++) {
        if (strncasecmp(at, node, sizeof node - 1u) == 0) {
            *value = self->node;
            memset(at, ' ', sizeof node - 1u);
        }
        if (*at == '+') {
            *at = ' ';
        }
    }
    char *number = tidy_text(rest);
    *value += number[0] == '-' ? (uint64_t)strtoll(number, &end, 0) : strtoull(number, &end, 0);
    return text[0] != '\0' && *end == '\0';
}

/* --- writing --- */

static bool is_asked(const struct writing *self, const char *id)
{
    const struct options *options = self->options;
    bool asked = options->word_count == 0;
    for (size_t i = 0; i < options->word_count; i++) {
        asked = asked || strncmp(id, options->words[i], strlen(options->words[i])) == 0;
    }
    return asked;
}

/* A clause and its row. `relation` are the words of the step. */
static void write_clause(struct writing *self, const struct section *section, const char *aspect,
                         const char *text, const char *relation)
{
    char id[32];
    (void)snprintf(id, sizeof id, "%04X:%X%s", section->index, section->sub, aspect);
    if (!is_asked(self, id)) {
        return;
    }
    self->count++;
    (void)fprintf(self->clauses, "%s | %s %s\n", id, section->name, text);
    (void)fprintf(self->rows, "[%s] %s %s\n  given %s\n  upload %04X:%X %s\n", id, section->name,
                  text, self->model, section->index, section->sub, relation);
}

/* Objects that say which device it is, whatever a file calls their access (CiA 301). */
static bool is_identity(const struct section *section)
{
    return section->index == 0x1000u ||
           (section->index == 0x1018u && section->sub >= 1 && section->sub <= 3);
}

static unsigned long cut_to_size(uint64_t value, size_t size)
{
    return (unsigned long)(value & ((UINT64_C(1) << 8u * size) - 1u));
}

static void write_value(struct writing *self, const struct section *section)
{
    const size_t size = size_of_type(section->type);
    const int digits = (int)(2u * (size & 7u)); /* a compiler sees that it fits */
    uint64_t initial;
    uint64_t low;
    uint64_t high;
    char relation[WORD_MAX];
    if (!is_number_type(section->type)) {
        return;
    }
    if (parse_number(self, section->low, &low) && parse_number(self, section->high, &high)) {
        (void)snprintf(relation, sizeof relation, "within %0*lX %0*lX%s", digits,
                       cut_to_size(low, size), digits, cut_to_size(high, size),
                       is_signed_type(section->type) ? " signed" : "");
        write_clause(self, section, "-limits", "is within its limits", relation);
    }
    if (parse_number(self, section->initial, &initial)) {
        const bool fixed = section->access == CONSTANT || is_identity(section);
        (void)snprintf(relation, sizeof relation, "%s %0*lX", fixed ? "is" : "delivered", digits,
                       cut_to_size(initial, size));
        write_clause(self, section, "-value", fixed ? "is constant" : "has its default", relation);
    }
}

/* An array or a record has no value of its own, and a section without type or access is none. */
static void write_section(struct writing *self, struct section *section)
{
    char relation[WORD_MAX];
    const size_t size = size_of_type(section->type);
    const bool value = section->kind == 7u || section->kind == 2u;
    if (section->index == 0 || !value || section->access == UNKNOWN) {
        return;
    }
    if (section->access == WRITE) {
        write_clause(self, section, "", "can only be written", "write-only");
        return;
    }
    write_clause(self, section, "", "is there", "there");
    if (size > 0) {
        (void)snprintf(relation, sizeof relation, "size %zu", size);
        write_clause(self, section, "-type", "has the bytes of its type", relation);
    }
    write_value(self, section);
}

/* Go through the text, line for line. */
static void write_sections(struct writing *self, char *text)
{
    struct section section = {.index = 0};
    for (char *rest = text, *line = strsep(&rest, "\n"); line != NULL; line = strsep(&rest, "\n")) {
        char *close = strchr(line, ']');
        char *equals = strchr(line, '=');
        if (line[0] == '[' && close != NULL) {
            write_section(self, &section);
            *close = '\0';
            (void)parse_section(line + 1, &section);
        } else if (line[0] != ';' && equals != NULL) {
            *equals = '\0';
            take_key(&section, tidy_text(line), tidy_text(equals + 1));
        }
    }
    write_section(self, &section);
}

/* --- loading --- */

int verify_eds_node(const char *node, uint8_t *id, struct lx_error *error)
{
    char *end = NULL;
    const unsigned long value = node == NULL ? NODE_USUAL : strtoul(node, &end, 10);
    if ((node != NULL && (end == node || *end != '\0')) || value < 1 || value > 127) {
        return lx_refuse(error, "expected 1..127", "--node %s", node);
    }
    *id = (uint8_t)value;
    return 0;
}

/* Rows name a model: any of the protocol, since nothing is compared with it. */
static const char *name_of_any(void)
{
    for (size_t i = 0; i < dg_device_count; i++) {
        if (dg_devices[i]->stack == &dg_cia406_stack) {
            return dg_devices[i]->name;
        }
    }
    return "";
}

static int load_written(const struct writing *self, char *texts[2], struct cf_suite *suite,
                        struct lx_error *error)
{
    const char *path = self->options->eds->path;
    if (self->count == 0) {
        return lx_refuse(error, "expected a clause or its beginning, such as 1018",
                         "%s: no such clause", path);
    }
    if (self->count > CF_CLAUSES_MAX || 2u * self->count > CF_LINES_MAX) {
        return lx_refuse(error, "expected the beginning of fewer, such as 60",
                         "%s: %zu clauses are too many", path, self->count);
    }
    const bool loaded = cf_load_texts(suite, "eds", texts[0], texts[1]);
    texts[0] = NULL; /* they are the suite's */
    texts[1] = NULL;
    return loaded ? 0 : lx_fail(error, "%s: its clauses cannot be read", path);
}

int verify_eds_load(const struct options *options, struct cf_suite *suite, struct lx_error *error)
{
    struct writing self = {.options = options, .model = name_of_any()};
    char *texts[2] = {NULL, NULL};
    size_t sizes[2];
    if (verify_eds_node(options->node, &self.node, error) != 0) {
        return -1;
    }
    char *copy = strndup(options->eds->text, options->eds->length);
    self.clauses = open_memstream(&texts[0], &sizes[0]);
    self.rows = open_memstream(&texts[1], &sizes[1]);
    bool written = copy != NULL && self.clauses != NULL && self.rows != NULL;
    if (written) {
        write_sections(&self, copy);
    }
    written = (self.clauses == NULL || fclose(self.clauses) == 0) && written;
    written = (self.rows == NULL || fclose(self.rows) == 0) && written;
    const int result = written ? load_written(&self, texts, suite, error)
                               : lx_fail(error, "no memory for %s", options->eds->path);
    free(copy);
    free(texts[0]);
    free(texts[1]);
    return result;
}

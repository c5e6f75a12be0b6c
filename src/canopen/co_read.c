/* SPDX-License-Identifier: MIT */
/*
 * The text of an EDS or DCF file to entries (CiA 306). What the readers of the field tolerate is
 * tolerated and noted: comments behind values, $NODEID anywhere, numbers that are none, sections
 * that no list names.
 */
#include <string.h>

#include "co_file.h"

#define BOM "\xEF\xBB\xBF"
#define DIGITS_MAX 20u

const uint16_t dg_co_eds_kbaud[EDS_RATES] = {10, 20, 50, 100, 125, 250, 500, 800, 1000};

/* Where a line belongs. */
enum place {
    PLACE_NOWHERE,
    PLACE_OBJECT, /* `current` */
    PLACE_VALUES, /* [2000Value], of `index` */
    PLACE_LIST,
    PLACE_INFO,
    PLACE_COMMISSIONING,
};

/* A line being read. */
struct line {
    struct eds_reader *in;
    unsigned number;
    enum place place;
    uint32_t index;
    struct eds_entry *current;
    struct eds_span section;
    struct eds_span key;
    struct eds_span value;
};

/* ------------------------------------------------------------ characters */

static char small(char c)
{
    return (char)(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
}

static bool is_eds_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

/* @return 0..15, or 16: none */
static uint32_t hex_digit_of(char c)
{
    const char low = small(c);

    if (low >= '0' && low <= '9') {
        return (uint32_t)(low - '0');
    }
    return low >= 'a' && low <= 'f' ? (uint32_t)(low - 'a') + 10u : 16u;
}

static struct eds_span trim_blanks(struct eds_span text)
{
    while (text.n > 0 && is_eds_blank(text.at[0])) {
        text.at++;
        text.n--;
    }
    while (text.n > 0 && is_eds_blank(text.at[text.n - 1u])) {
        text.n--;
    }
    return text;
}

/* @return where the first `c` is, or the length */
static size_t find_character(struct eds_span text, char c)
{
    size_t n = 0;

    while (n < text.n && text.at[n] != c) {
        n++;
    }
    return n;
}

/* @return characters of `word`, or 0: the text begins otherwise */
static size_t begins_with(struct eds_span text, const char *word)
{
    size_t n = 0;

    while (n < text.n && word[n] != '\0' && small(text.at[n]) == small(word[n])) {
        n++;
    }
    return word[n] == '\0' ? n : 0;
}

/* The first word of a text. */
static bool is_first(struct eds_span text, const char *word)
{
    const size_t n = begins_with(text, word);

    return n > 0 &&
           (n == text.n || is_eds_blank(text.at[n]) || text.at[n] == ';' || text.at[n] == '#');
}

static struct eds_span skip_characters(struct eds_span text, size_t n)
{
    return (struct eds_span){text.at + n, text.n - n};
}

bool dg_co_is_word(struct eds_span text, const char *word)
{
    return text.n > 0 && begins_with(text, word) == text.n;
}

/* ------------------------------------------------------------ numbers */

/* Without blanks, quotes, a plus, $NODEID, and what stands behind ';' or '#'. */
static size_t condense_number(struct eds_span text, char to[DIGITS_MAX], bool *follows)
{
    size_t n = 0;

    while (text.n > 0 && text.at[0] != ';' && text.at[0] != '#') {
        const char c = text.at[0];
        if (begins_with(text, "$NODEID") > 0) {
            *follows = true;
            text = skip_characters(text, 7);
            continue;
        }
        if (!is_eds_blank(c) && c != '"' && c != '+') {
            if (n == DIGITS_MAX) {
                return n + 1u;
            }
            to[n++] = c;
        }
        text = skip_characters(text, 1);
    }
    return n;
}

/* All digits of a base, at most 2^64 - 1. */
static bool convert_digits(const char *digits, size_t n, uint32_t base, uint64_t *to)
{
    uint64_t value = 0;

    for (size_t i = 0; i < n; i++) {
        const uint32_t digit = hex_digit_of(digits[i]);
        if (digit >= base || value > (UINT64_MAX - digit) / base) {
            return false;
        }
        value = value * base + digit;
    }
    *to = value;
    return n > 0;
}

/* 12, 0x12, 12h; 012 is octal, as CiA 306 has it, unless it cannot be. */
static bool convert_number(const char *digits, size_t n, uint64_t *to)
{
    if (n > 2 && digits[0] == '0' && small(digits[1]) == 'x') {
        return convert_digits(digits + 2, n - 2u, 16, to);
    }
    if (n > 1 && small(digits[n - 1u]) == 'h') {
        return convert_digits(digits, n - 1u, 16, to);
    }
    return (n > 1 && digits[0] == '0' && convert_digits(digits + 1, n - 1u, 8, to)) ||
           convert_digits(digits, n, 10, to);
}

struct eds_number dg_co_take_number(struct eds_span text)
{
    struct eds_number number = {.follows = false};
    char digits[DIGITS_MAX];
    const size_t n = condense_number(text, digits, &number.follows);

    if (n > DIGITS_MAX) {
        return number;
    }
    const bool minus = n > 0 && digits[0] == '-';
    uint64_t value = 0;
    number.valid_wide =
        n == 0 ? number.follows
               : convert_number(digits + (minus ? 1 : 0), n - (minus ? 1u : 0u), &value);
    number.valid = number.valid_wide && value <= UINT32_MAX;
    number.wide = minus ? 0u - value : value;
    number.value = number.valid ? (uint32_t)number.wide : 0;
    return number;
}

/* ------------------------------------------------------------ notes, memory */

static void copy_span(char *to, size_t size, struct eds_span from)
{
    size_t n = 0;

    while (n < from.n && n + 1u < size) {
        const char c = from.at[n];
        to[n++] = (char)(c >= ' ' && c <= '~' ? c : '?');
    }
    to[n] = '\0';
}

void dg_co_note_place(struct eds_reader *self, const struct eds_place *place, const char *what,
                      const char *right)
{
    struct dg_eds_note note = {
        .line = place->line, .what = what, .right = right, .lacks = place->lacks};

    copy_span(note.section, sizeof note.section, place->section);
    copy_span(note.key, sizeof note.key, place->key);
    copy_span(note.value, sizeof note.value, place->value);
    if (self->setup->note != NULL) {
        self->setup->note(self->setup->ctx, &note);
    }
}

int dg_co_refuse_text(struct eds_reader *self, unsigned line, const char *what, const char *right)
{
    if (self->error != NULL) {
        *self->error = (struct dg_eds_note){.line = line, .what = what, .right = right};
    }
    return DG_ERR_ARGUMENT;
}

void *dg_co_keep_bytes(struct eds_reader *self, size_t n)
{
    const size_t size = (n + sizeof(uint64_t) - 1u) / sizeof(uint64_t) * sizeof(uint64_t);
    uint8_t *at = self->front;

    if (self->out || size > (size_t)(self->back - self->front)) {
        self->out = true;
        return NULL;
    }
    self->front += size;
    memset(at, 0, size);
    return at;
}

struct eds_entry *dg_co_add_entry(struct eds_reader *self, uint32_t key, enum eds_rank rank,
                                  unsigned line)
{
    if (self->out || sizeof *self->entries > (size_t)(self->back - self->front)) {
        self->out = true;
        return NULL;
    }
    self->back -= sizeof *self->entries;
    self->entries = (struct eds_entry *)(void *)self->back;
    *self->entries = (struct eds_entry){.key = key, .rank = (uint8_t)rank, .line = line};
    self->count++;
    return self->entries;
}

/* ------------------------------------------------------------ sections */

static void note_line(const struct line *line, const char *what, const char *right)
{
    const struct eds_place place = {
        .line = line->number, .section = line->section, .key = line->key, .value = line->value};

    dg_co_note_place(line->in, &place, what, right);
}

/* Digits at the beginning, at most `most`. @return how many */
static size_t read_digits(struct eds_span text, uint32_t base, size_t most, uint32_t *to)
{
    uint64_t value = 0;
    size_t n = 0;

    while (n < text.n && n < most && hex_digit_of(text.at[n]) < base) {
        n++;
    }
    if (!convert_digits(text.at, n, base, &value)) {
        return 0;
    }
    *to = (uint32_t)value;
    return n;
}

static const char no_object[] = "is no section of an object, and left out";
static const char one_object[] = "[1018], [1018sub1] or [1018Value]";

static bool is_list(struct eds_span name)
{
    return dg_co_is_word(name, "MandatoryObjects") || dg_co_is_word(name, "OptionalObjects") ||
           dg_co_is_word(name, "ManufacturerObjects");
}

/* Sections of an object that have no values. */
static bool is_beside(struct eds_span rest)
{
    return dg_co_is_word(rest, "Name") || dg_co_is_word(rest, "Denotation") ||
           dg_co_is_word(rest, "ObjectLinks");
}

/* [1018], [1018sub1], [2000Value] */
static void begin_object(struct line *line, uint32_t index, struct eds_span rest)
{
    struct eds_reader *in = line->in;
    uint32_t sub = 0;

    line->index = index;
    if (rest.n == 0) {
        in->objects++;
        line->current = dg_co_add_entry(in, DG_CO_KEY(index, 0), EDS_OBJECT, line->number);
        line->place = PLACE_OBJECT;
    } else if (begins_with(rest, "sub") > 0 && rest.n > 3u &&
               read_digits(skip_characters(rest, 3), 16, 3, &sub) == rest.n - 3u &&
               sub <= UINT8_MAX) {
        line->current = dg_co_add_entry(in, DG_CO_KEY(index, sub), EDS_SUB, line->number);
        line->place = PLACE_OBJECT;
    } else if (dg_co_is_word(rest, "Value")) {
        line->place = PLACE_VALUES;
    } else if (!is_beside(rest)) {
        note_line(line, no_object, one_object);
    }
}

static void begin_eds_section(struct line *line, struct eds_span name)
{
    uint32_t index = 0;
    const size_t n = read_digits(name, 16, 4, &index);

    line->section = name;
    line->place = PLACE_NOWHERE;
    line->current = NULL;
    if (is_list(name)) {
        line->place = PLACE_LIST;
    } else if (dg_co_is_word(name, "DeviceInfo")) {
        line->place = PLACE_INFO;
    } else if (dg_co_is_word(name, "DeviceComissioning") ||
               dg_co_is_word(name, "DeviceCommissioning")) {
        line->place = PLACE_COMMISSIONING; /* CiA 306 spells it so */
    } else if (n == 4) {
        begin_object(line, index, skip_characters(name, n));
    } else if (n > 0 && (n == name.n || hex_digit_of(name.at[0]) < 10)) {
        note_line(line, no_object, one_object);
    }
}

/* ------------------------------------------------------------ keys of objects */

static void take_eds_number(const struct line *line, uint32_t most, uint32_t *to)
{
    const struct eds_number number = dg_co_take_number(line->value);

    if (number.valid && number.value <= most) {
        *to = number.value;
    } else if (line->value.n > 0) {
        note_line(line, "is no number here, and left out", "a number, as 7 or 0x0007");
    }
}

static void take_access(const struct line *line, struct eds_entry *to)
{
    static const struct {
        const char *word;
        uint8_t access;
    } words[] = {
        {"ro", DG_CO_R},   {"wo", DG_CO_W},  {"rwr", DG_CO_RW},
        {"rww", DG_CO_RW}, {"rw", DG_CO_RW}, {"const", DG_CO_R | DG_CO_CONST},
    };

    for (size_t i = 0; i < DG_COUNT(words); i++) {
        if (is_first(line->value, words[i].word)) {
            to->access = words[i].access;
            return;
        }
    }
    note_line(line, "no access: read only", "ro, wo, rw, rwr, rww or const");
}

enum object_key {
    KEY_OBJECT_TYPE,
    KEY_DATA_TYPE,
    KEY_COMPACT,
    KEY_MAPPING, /* numbers up to here */
    KEY_ACCESS,
    KEY_LOW,
    KEY_HIGH,
    KEY_DEFAULT,
    KEY_PARAMETER,
    KEY_COUNT
};

static enum object_key object_key_of(struct eds_span key)
{
    static const char *const words[KEY_COUNT] = {
        [KEY_OBJECT_TYPE] = "ObjectType",   [KEY_DATA_TYPE] = "DataType",
        [KEY_COMPACT] = "CompactSubObj",    [KEY_MAPPING] = "PDOMapping",
        [KEY_ACCESS] = "AccessType",        [KEY_LOW] = "LowLimit",
        [KEY_HIGH] = "HighLimit",           [KEY_DEFAULT] = "DefaultValue",
        [KEY_PARAMETER] = "ParameterValue",
    };
    uint32_t i = 0;

    while (i < KEY_COUNT && !dg_co_is_word(key, words[i])) {
        i++;
    }
    return (enum object_key)i;
}

/* ParameterValue of a DCF wins, wherever it stands. */
static void take_initial(const struct line *line, struct eds_entry *to, bool configured)
{
    if (line->value.n > 0 && (configured || !to->configured)) {
        to->initial = line->value;
        to->configured = configured;
    }
}

/* Keys whose value is a small number. */
static void take_small_number(const struct line *line, struct eds_entry *to, enum object_key key)
{
    uint32_t number = 0;

    take_eds_number(line, key == KEY_DATA_TYPE ? UINT16_MAX : UINT8_MAX, &number);
    if (key == KEY_OBJECT_TYPE) {
        to->object = (uint8_t)number;
    } else if (key == KEY_DATA_TYPE) {
        to->type = (uint16_t)number;
    } else if (key == KEY_COMPACT) {
        to->compact = (uint8_t)number;
    } else {
        to->map = number != 0;
    }
}

/* Names, units, and what tools add, are left alone. */
static void take_object(const struct line *line)
{
    struct eds_entry *to = line->current;
    const enum object_key key = object_key_of(line->key);

    if (key <= KEY_MAPPING) {
        take_small_number(line, to, key);
    } else if (key == KEY_ACCESS) {
        take_access(line, to);
    } else if (key == KEY_LOW) {
        to->low = line->value;
    } else if (key == KEY_HIGH) {
        to->high = line->value;
    } else if (key != KEY_COUNT) {
        take_initial(line, to, key == KEY_PARAMETER);
    }
}

/* "3=0x12": a default of sub-index 3, in decimal. */
static void take_value(const struct line *line)
{
    uint32_t sub = 0;

    if (read_digits(line->key, 10, 3, &sub) != line->key.n || sub > UINT8_MAX) {
        return; /* NrOfEntries */
    }
    struct eds_entry *entry =
        dg_co_add_entry(line->in, DG_CO_KEY(line->index, sub), EDS_VALUE, line->number);
    if (entry != NULL) {
        entry->initial = line->value;
    }
}

/* ------------------------------------------------------------ keys of the rest */

static void take_rate(const struct line *line, struct eds_info *info)
{
    uint32_t kbaud = 0;
    uint32_t there = 0;

    if (read_digits(skip_characters(line->key, 9), 10, 4, &kbaud) != line->key.n - 9u) {
        return;
    }
    take_eds_number(line, UINT8_MAX, &there);
    for (size_t i = 0; i < EDS_RATES; i++) {
        if (dg_co_eds_kbaud[i] == kbaud && there != 0) {
            info->rates |= (uint16_t)(1u << i);
        }
    }
}

static void take_info(const struct line *line)
{
    struct eds_info *info = &line->in->info;
    const struct {
        const char *word;
        uint32_t *to;
    } numbers[] = {
        {"VendorNumber", &info->vendor_id},  {"ProductNumber", &info->product_code},
        {"RevisionNumber", &info->revision}, {"CompactPDO", &info->compact_pdo},
        {"NrOfRXPDO", &info->rpdos},         {"NrOfTXPDO", &info->tpdos},
    };

    for (size_t i = 0; i < DG_COUNT(numbers); i++) {
        if (dg_co_is_word(line->key, numbers[i].word)) {
            take_eds_number(line, UINT32_MAX, numbers[i].to);
        }
    }
    if (dg_co_is_word(line->key, "ProductName")) {
        info->product = line->value;
    } else if (dg_co_is_word(line->key, "VendorName")) {
        info->vendor = line->value;
    } else if (begins_with(line->key, "BaudRate_") > 0) {
        take_rate(line, info);
    }
}

/* NodeID=255 is none yet. */
static void take_commissioning(const struct line *line)
{
    struct eds_info *info = &line->in->info;
    uint32_t number = 0;

    if (dg_co_is_word(line->key, "NodeID")) {
        take_eds_number(line, UINT8_MAX, &number);
        info->node_id = number <= 127 ? (uint8_t)number : 0;
    } else if (dg_co_is_word(line->key, "Baudrate")) {
        take_eds_number(line, 1000, &number);
        info->kbaud = (uint16_t)number;
    }
}

static void take_eds_line(const struct line *line)
{
    uint32_t number = 0;

    switch (line->place) {
    case PLACE_OBJECT:
        if (line->current != NULL) {
            take_object(line);
        }
        break;
    case PLACE_VALUES:
        take_value(line);
        break;
    case PLACE_LIST:
        if (line->key.n > 0 && read_digits(line->key, 10, 5, &number) == line->key.n) {
            line->in->info.listed++;
        }
        break;
    case PLACE_INFO:
        take_info(line);
        break;
    case PLACE_COMMISSIONING:
        take_commissioning(line);
        break;
    case PLACE_NOWHERE:
        break;
    }
}

/* ------------------------------------------------------------ lines */

static void read_line(struct line *line, struct eds_span text)
{
    text = trim_blanks(text);
    line->key = (struct eds_span){"", 0};
    line->value = line->key;
    if (text.n == 0 || text.at[0] == ';' || text.at[0] == '#') {
        return;
    }
    if (text.at[0] == '[') {
        text = skip_characters(text, 1);
        const size_t end = find_character(text, ']');
        begin_eds_section(line, trim_blanks((struct eds_span){text.at, end}));
        if (end == text.n) {
            note_line(line, "has no ']'", NULL);
        }
        return;
    }
    const size_t n = find_character(text, '=');
    line->key = trim_blanks((struct eds_span){text.at, n});
    if (n == text.n) {
        note_line(line, "is left out", "KEY=VALUE or [SECTION]");
        return;
    }
    line->value = trim_blanks(skip_characters(text, n + 1u));
    take_eds_line(line);
}

static bool is_behind(const struct eds_entry *a, const struct eds_entry *b)
{
    if (a->key != b->key) {
        return a->key > b->key;
    }
    return a->rank != b->rank ? a->rank > b->rank : a->line > b->line;
}

static void sift_down(struct eds_entry *list, size_t at, size_t count)
{
    while (2u * at + 1u < count) {
        size_t child = 2u * at + 1u;
        if (child + 1u < count && is_behind(&list[child + 1u], &list[child])) {
            child++;
        }
        if (!is_behind(&list[child], &list[at])) {
            return;
        }
        const struct eds_entry held = list[at];
        list[at] = list[child];
        list[child] = held;
        at = child;
    }
}

/* A heap: as many steps for any text. */
static void sort_entries(struct eds_entry *list, size_t count)
{
    for (size_t i = count / 2u; i-- > 0;) {
        sift_down(list, i, count);
    }
    for (size_t end = count; end-- > 1;) {
        const struct eds_entry held = list[0];
        list[0] = list[end];
        list[end] = held;
        sift_down(list, 0, end);
    }
}

static int check_size(struct eds_reader *self, unsigned line)
{
    if (self->objects > DG_EDS_OBJECTS_MAX || self->count > DG_EDS_ROWS_MAX) {
        return dg_co_refuse_text(self, line, "too many objects",
                                 "at most 4000 objects, 16384 sub-indices");
    }
    return self->out ? DG_ERR_SPACE : DG_OK;
}

int dg_co_scan_text(struct eds_reader *self)
{
    struct eds_span rest = {self->setup->text, self->setup->n};
    struct line line = {.in = self, .section = {"", 0}};

    if (rest.n > DG_EDS_BYTES_MAX) {
        return dg_co_refuse_text(self, 0, "too long", "at most 1 MB");
    }
    rest = skip_characters(rest, begins_with(rest, BOM));
    while (rest.n > 0 && check_size(self, line.number) == DG_OK) {
        const size_t n = find_character(rest, '\n');
        line.number++;
        read_line(&line, (struct eds_span){rest.at, n});
        rest = skip_characters(rest, n < rest.n ? n + 1u : n);
    }
    dg_co_expand_entries(self);
    const int result = check_size(self, line.number);
    if (result != DG_OK) {
        return result;
    }
    if (self->objects == 0) {
        return dg_co_refuse_text(self, 0, "no object",
                                 "an EDS or DCF file, with sections as [1000]");
    }
    sort_entries(self->entries, self->count);
    return DG_OK;
}

unsigned dg_co_find_object(const struct dg_eds_setup *setup, uint16_t index)
{
    struct eds_span rest = {setup->text, setup->n};
    unsigned line = 0;

    while (rest.n > 0) {
        const size_t n = find_character(rest, '\n');
        const struct eds_span text = trim_blanks((struct eds_span){rest.at, n});
        uint32_t found = 0;
        line++;
        if (text.n > 5 && text.at[0] == '[' && text.at[5] == ']' &&
            read_digits(skip_characters(text, 1), 16, 4, &found) == 4 && found == index) {
            return line;
        }
        rest = skip_characters(rest, n < rest.n ? n + 1u : n);
    }
    return 0;
}

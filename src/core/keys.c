/* SPDX-License-Identifier: MIT */
/*
 * Rows point into structs by offset and are copied with memcpy(): the rows know sizes, not types.
 */
#include "drehgeber/key.h"

#include <stddef.h>
#include <string.h>

#include "drehgeber/hal.h"
#include "drehgeber/text.h"

#define DECIMAL 10u
#define HEX 16u
/* Of a number, with sign and point. */
#define CHARACTERS_MAX 24u

const char *const dg_key_no_yes[2] = {"0", "1"};

/* Longer texts than any row takes. */
#define TEXT_MAX 256u

static bool is_same_text(const char *a, const char *b)
{
    const size_t n = dg_text_length(a, TEXT_MAX);

    return n == dg_text_length(b, TEXT_MAX) && memcmp(a, b, n) == 0;
}

const struct dg_key *dg_keys_find(const struct dg_keys *self, const char *name)
{
    for (size_t i = 0; i < self->count; i++) {
        if (is_same_text(self->rows[i].name, name)) {
            return &self->rows[i];
        }
    }
    return NULL;
}

static bool is_text_key(const struct dg_key *key)
{
    return key->type == DG_KEY_TEXT || key->type == DG_KEY_DIGITS;
}

static bool is_word_key(const struct dg_key *key)
{
    return key->type == DG_KEY_FLAG || key->type == DG_KEY_WORD;
}

/* ------------------------------------------------------------ values */

/* The value has been checked against the row's range, so it fits the type. */
static void store_value(const struct dg_key *key, uint8_t *to, int64_t value)
{
    const struct values {
        uint64_t u64;
        uint32_t u32;
        uint16_t u16;
        uint8_t u8;
        bool flag;
    } values = {(uint64_t)value * key->factor, (uint32_t)value, (uint16_t)value, (uint8_t)value,
                value != 0};
    static const struct {
        uint8_t offset;
        uint8_t size;
    } rows[DG_KEY_TYPE_COUNT] = {
        [DG_KEY_U8] = {offsetof(struct values, u8), sizeof values.u8},
        [DG_KEY_U16] = {offsetof(struct values, u16), sizeof values.u16},
        [DG_KEY_U32] = {offsetof(struct values, u32), sizeof values.u32},
        [DG_KEY_I16] = {offsetof(struct values, u16), sizeof values.u16}, /* the same bytes */
        [DG_KEY_I32] = {offsetof(struct values, u32), sizeof values.u32},
        [DG_KEY_NS] = {offsetof(struct values, u64), sizeof values.u64},
        [DG_KEY_FLAG] = {offsetof(struct values, flag), sizeof values.flag},
        [DG_KEY_WORD] = {offsetof(struct values, u8), sizeof values.u8},
    };

    memcpy(to, (const uint8_t *)&values + rows[key->type].offset, rows[key->type].size);
}

static int64_t load_16(const uint8_t *from, bool negative)
{
    uint16_t u16;

    memcpy(&u16, from, sizeof u16);
    return negative ? (int16_t)u16 : (int64_t)u16;
}

static int64_t load_32(const uint8_t *from, bool negative)
{
    uint32_t u32;

    memcpy(&u32, from, sizeof u32);
    return negative ? (int32_t)u32 : (int64_t)u32;
}

/* What store_value() has put there. */
static int64_t load_value(const struct dg_key *key, const uint8_t *from)
{
    uint64_t u64;

    switch ((enum dg_key_type)key->type) {
    case DG_KEY_U16:
    case DG_KEY_I16:
        return load_16(from, key->type == DG_KEY_I16);
    case DG_KEY_U32:
    case DG_KEY_I32:
        return load_32(from, key->type == DG_KEY_I32);
    case DG_KEY_NS:
        memcpy(&u64, from, sizeof u64);
        return (int64_t)(u64 / key->factor);
    case DG_KEY_U8:
    case DG_KEY_FLAG:
    case DG_KEY_WORD:
    case DG_KEY_TEXT:
    case DG_KEY_DIGITS:
    case DG_KEY_TYPE_COUNT:
        break;
    }
    return *from;
}

/* ------------------------------------------------------------ numbers */

/* @return 0..15, or HEX */
static unsigned digit_of(char c)
{
    if (c >= '0' && c <= '9') {
        return (unsigned)(c - '0');
    }
    const char lower = (char)(c | 0x20);
    return lower >= 'a' && lower <= 'f' ? (unsigned)(lower - 'a') + DECIMAL : HEX;
}

/* 27h and 0x27. */
static bool parse_hex(const char *text, int64_t *value)
{
    const size_t n = dg_text_length(text, TEXT_MAX);
    const bool prefixed = n > 2 && text[0] == '0' && (text[1] | 0x20) == 'x';
    const bool suffixed = n > 1 && (text[n - 1] | 0x20) == 'h';
    const size_t end = suffixed && !prefixed ? n - 1 : n;
    uint64_t sum = 0;

    for (size_t i = prefixed ? 2 : 0; i < end; i++) {
        const unsigned digit = digit_of(text[i]);
        if (digit == HEX || sum > UINT32_MAX / HEX) {
            return false;
        }
        sum = sum * HEX + digit;
    }
    *value = (int64_t)sum;
    return prefixed || suffixed;
}

/* A decimal on its way: `behind` digits of it stood behind the point. */
struct decimal {
    int64_t sum;
    unsigned digits;
    unsigned behind;
    bool point;
};

#define SUM_MAX ((INT64_MAX - (int64_t)DECIMAL) / (int64_t)DECIMAL)

/* Digits beyond `places` have to be 0. @return false: no such number */
static bool take_digit(struct decimal *self, unsigned digit, unsigned places)
{
    if (digit >= DECIMAL || self->sum > SUM_MAX) {
        return false;
    }
    self->digits++;
    if (self->point && self->behind == places) {
        return digit == 0;
    }
    self->sum = self->sum * (int64_t)DECIMAL + (int64_t)digit;
    self->behind += self->point ? 1u : 0u;
    return true;
}

/* [+-]digits[.digits] in units of 10^-places */
static bool parse_decimal(const char *text, unsigned places, int64_t *value)
{
    const bool negative = *text == '-';
    struct decimal number = {.sum = 0};
    bool good = true;

    for (text += negative || *text == '+' ? 1 : 0; good && *text != '\0'; text++) {
        if (*text == '.') {
            good = !number.point;
            number.point = true;
        } else {
            good = take_digit(&number, digit_of(*text), places);
        }
    }
    const bool any = number.digits > 0;
    number.point = true;
    while (good && number.behind < places) {
        good = take_digit(&number, 0, places);
    }
    *value = negative ? -number.sum : number.sum;
    return good && any;
}

static int set_number(const struct dg_key *key, uint8_t *to, const char *value)
{
    int64_t number = 0;
    const bool valid = parse_decimal(value, key->places, &number) ||
                       (key->places == 0 && parse_hex(value, &number));

    if (!valid || number < key->min || number > key->max) {
        return DG_ERR_ARGUMENT;
    }
    store_value(key, to, number);
    return DG_OK;
}

static int set_word(const struct dg_key *key, uint8_t *to, const char *value)
{
    for (int64_t i = 0; i <= key->max; i++) {
        if (is_same_text(value, key->words[i])) {
            store_value(key, to, i);
            return DG_OK;
        }
    }
    return DG_ERR_ARGUMENT;
}

static bool all_digits(const char *text)
{
    while (digit_of(*text) < DECIMAL) {
        text++;
    }
    return *text == '\0';
}

/* The rest of the field is cleared: it goes to the EEPROM as a whole. */
static int set_text(const struct dg_key *key, uint8_t *to, const char *value)
{
    const size_t n = dg_text_length(value, TEXT_MAX);
    const bool digits = key->type == DG_KEY_DIGITS;

    if (n < (size_t)key->min || n > (size_t)key->max || (digits && !all_digits(value))) {
        return DG_ERR_ARGUMENT;
    }
    const size_t ahead = digits ? (size_t)key->max - n : 0;
    memset(to, 0, (size_t)key->max + 1);
    memset(to, '0', ahead);
    memcpy(to + ahead, value, n);
    return DG_OK;
}

int dg_key_set(const struct dg_key *self, void *base, const char *value)
{
    uint8_t *to = (uint8_t *)base + self->offset;

    if (is_word_key(self)) {
        return set_word(self, to, value);
    }
    return is_text_key(self) ? set_text(self, to, value) : set_number(self, to, value);
}

/* ------------------------------------------------------------ text */

static bool ends(const uint8_t *text, size_t max)
{
    size_t n = 0;

    while (n <= max && text[n] != '\0') {
        n++;
    }
    return n <= max;
}

bool dg_key_holds(const struct dg_key *self, const void *base)
{
    const uint8_t *at = (const uint8_t *)base + self->offset;

    if (is_text_key(self)) {
        return ends(at, (size_t)self->max);
    }
    const int64_t value = load_value(self, at);
    return value >= self->min && value <= self->max;
}

/* From the right. @return the first character, the zero is behind the last one */
static const char *format_number(char text[CHARACTERS_MAX], int64_t value, unsigned places)
{
    uint64_t rest = value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
    char *at = &text[CHARACTERS_MAX - 1u];
    unsigned digits = 0;

    *at = '\0';
    do {
        if (digits == places && places > 0) {
            *--at = '.';
        }
        *--at = (char)('0' + rest % DECIMAL);
        rest /= DECIMAL;
        digits++;
    } while (rest > 0 || digits <= places);
    if (value < 0) {
        *--at = '-';
    }
    return at;
}

int dg_key_get(const struct dg_key *self, const void *base, char *to, size_t size)
{
    const uint8_t *from = (const uint8_t *)base + self->offset;
    char number[CHARACTERS_MAX];
    const char *text = (const char *)from;

    if (is_word_key(self)) {
        text = self->words[load_value(self, from)];
    } else if (!is_text_key(self)) {
        text = format_number(number, load_value(self, from), self->places);
    }
    const size_t n = dg_text_length(text, TEXT_MAX);
    if (n >= size) {
        return DG_ERR_SPACE;
    }
    memcpy(to, text, n + 1);
    return (int)n;
}

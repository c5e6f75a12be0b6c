/* SPDX-License-Identifier: MIT */
/*
 * Rows point into structs by offset and are copied with memcpy(): the rows know sizes, not types.
 */
#include "key.h"

#include <string.h>

#include "figure.h"

const char *const lx_no_yes[2] = {"0", "1"};

/* --- the world --- */

/* How a quantity of a unit is written, and how it lies there. */
#define UNIT_MDEGC "degC"
#define UNIT_UA "uA"
#define UNIT_MV "mV"
#define UNIT_PERMILLE "permille"
#define UNIT_STATE ""
#define PLACES_MDEGC 3
#define PLACES_UA 0
#define PLACES_MV 0
#define PLACES_PERMILLE 0
#define PLACES_STATE 0
#define TYPE_OF(member)                                                                            \
    _Generic(((struct dg_world *)0)->member, bool                                                  \
             : LX_KEY_FLAG, int16_t                                                                \
             : LX_KEY_I16, uint16_t                                                                \
             : LX_KEY_U16, int32_t                                                                 \
             : LX_KEY_I32, uint32_t                                                                \
             : LX_KEY_U32)
#define QUANTITY(id, member, name, header, unit, healthy, min, max, multiturn, help)               \
    {name,                                                                                         \
     UNIT_##unit,                                                                                  \
     offsetof(struct dg_world, member),                                                            \
     TYPE_OF(member),                                                                              \
     PLACES_##unit,                                                                                \
     1,                                                                                            \
     min,                                                                                          \
     max,                                                                                          \
     lx_no_yes,                                                                                    \
     help},

const struct lx_key lx_world_keys[DG_QUANTITY_COUNT] = {DG_QUANTITIES(QUANTITY)};

/* --- values --- */

/* The value has been checked against the row's range, so it fits the type. */
static void store(const struct lx_key *key, uint8_t *to, int64_t value)
{
    const uint8_t u8 = (uint8_t)value;
    const uint16_t u16 = (uint16_t)value;
    const uint32_t u32 = (uint32_t)value;
    const uint64_t u64 = (uint64_t)value * key->factor;
    const bool flag = value != 0;
    const struct {
        const void *from;
        size_t size;
    } rows[LX_KEY_TYPE_COUNT] = {
        [LX_KEY_U8] = {&u8, sizeof u8},
        [LX_KEY_U16] = {&u16, sizeof u16},
        [LX_KEY_U32] = {&u32, sizeof u32},
        [LX_KEY_I16] = {&u16, sizeof u16}, /* the same bytes */
        [LX_KEY_I32] = {&u32, sizeof u32},
        [LX_KEY_NS] = {&u64, sizeof u64},
        [LX_KEY_FLAG] = {&flag, sizeof flag},
        [LX_KEY_WORD] = {&u8, sizeof u8},
    };
    memcpy(to, rows[key->type].from, rows[key->type].size);
}

/* What store() has put there. */
static int64_t load(const struct lx_key *key, const uint8_t *from)
{
    uint16_t u16 = 0;
    uint32_t u32 = 0;
    uint64_t u64 = 0;
    switch ((enum lx_key_type)key->type) {
    case LX_KEY_U16:
    case LX_KEY_I16:
        memcpy(&u16, from, sizeof u16);
        return key->type == LX_KEY_I16 ? (int16_t)u16 : (int64_t)u16;
    case LX_KEY_U32:
    case LX_KEY_I32:
        memcpy(&u32, from, sizeof u32);
        return key->type == LX_KEY_I32 ? (int32_t)u32 : (int64_t)u32;
    case LX_KEY_NS:
        memcpy(&u64, from, sizeof u64);
        return (int64_t)(u64 / key->factor);
    case LX_KEY_U8:
    case LX_KEY_FLAG:
    case LX_KEY_WORD:
    case LX_KEY_TEXT:
    case LX_KEY_DIGITS:
    case LX_KEY_TYPE_COUNT:
        break;
    }
    return *from;
}

static bool is_text(const struct lx_key *key)
{
    return key->type == LX_KEY_TEXT || key->type == LX_KEY_DIGITS;
}

static bool is_word(const struct lx_key *key)
{
    return key->type == LX_KEY_FLAG || key->type == LX_KEY_WORD;
}

/* "0..250000 us", "8 characters", "own or early", "none, even or odd" */
static struct lx_words range_of(const struct lx_key *key)
{
    static const char *const kinds[] = {"characters", "digits"};
    const long long one = (long long)lx_power_of_ten(key->places);
    const long long min = (long long)key->min / one;
    const long long max = (long long)key->max / one;
    struct lx_words range = {""};
    if (is_word(key)) {
        for (size_t i = 0; i <= (size_t)max; i++) {
            lx_words_item(&range, key->words[i], i, (size_t)max + 1u, " or ");
        }
        return range;
    }
    lx_words_add(&range, is_text(key) ? "%lld to %lld" : "%lld..%lld", min, max);
    const char *unit = is_text(key) ? kinds[key->type == LX_KEY_DIGITS] : key->unit;
    lx_words_add(&range, "%s%s", unit[0] == '\0' ? "" : " ", unit);
    return range;
}

/* --- setting --- */

static int set_number(const struct lx_key *key, uint8_t *to, const char *value,
                      struct lx_error *error)
{
    struct lx_decimal number;
    uint64_t hex = 0;
    struct lx_words right = {""};
    /* Codes are written as the manual writes them, 27h, as well as decimal. */
    bool valid = lx_decimal_parse(value, strlen(value), key->places, &number);
    if (!valid && lx_unsigned_parse(value, &hex) && hex <= UINT32_MAX && key->places == 0) {
        number = (struct lx_decimal){(int64_t)hex, false};
        valid = true;
    }
    if (valid && !number.cut && number.value >= key->min && number.value <= key->max) {
        store(key, to, number.value);
        return 0;
    }
    lx_words_add(&right, "a number in %s", range_of(key).text);
    if (key->places > 0) {
        lx_words_add(&right, " with at most %u decimals", key->places);
    }
    lx_words_add(&right, " is right");
    return lx_refuse(error, right.text, "%s", "");
}

static int set_word(const struct lx_key *key, uint8_t *to, const char *value,
                    struct lx_error *error)
{
    struct lx_words right = range_of(key);
    for (int64_t i = 0; i <= key->max; i++) {
        if (strcmp(value, key->words[i]) == 0) {
            store(key, to, i);
            return 0;
        }
    }
    lx_words_add(&right, " is right");
    return lx_refuse(error, right.text, "%s", "");
}

/* The rest of the field is cleared: it goes to the EEPROM as a whole. */
static int set_text(const struct lx_key *key, uint8_t *to, const char *value,
                    struct lx_error *error)
{
    const size_t n = strlen(value);
    const bool digits = key->type == LX_KEY_DIGITS;
    const size_t ahead = digits ? (size_t)key->max - n : 0;
    struct lx_words right = range_of(key);
    if (n < (size_t)key->min || n > (size_t)key->max ||
        (digits && strspn(value, "0123456789") != n)) {
        lx_words_add(&right, " are right");
        return lx_refuse(error, right.text, "%s", "");
    }
    memset(to, 0, (size_t)key->max + 1);
    memset(to, '0', ahead);
    memcpy(to + ahead, value, n);
    return 0;
}

int lx_key_set(const struct lx_key *key, void *base, const char *value, struct lx_error *error)
{
    uint8_t *to = (uint8_t *)base + key->offset;
    if (is_word(key)) {
        return set_word(key, to, value, error);
    }
    return is_text(key) ? set_text(key, to, value, error) : set_number(key, to, value, error);
}

/* --- lists --- */

static bool has(const struct lx_keys *keys, size_t row)
{
    return (keys->without >> row & 1u) == 0;
}

const struct lx_key *lx_keys_find(const struct lx_keys *lists, size_t n, const char *name,
                                  void **base)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < lists[i].count; j++) {
            if (has(&lists[i], j) && strcmp(lists[i].rows[j].name, name) == 0) {
                if (base != NULL) {
                    *base = lists[i].base;
                }
                return &lists[i].rows[j];
            }
        }
    }
    return NULL;
}

void lx_keys_name(const struct lx_keys *lists, size_t n, struct lx_words *to)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < lists[i].count; j++) {
            if (has(&lists[i], j)) {
                lx_words_add(to, " %s", lists[i].rows[j].name);
            }
        }
    }
}

/* Of a text nothing is told: it is a factory figure. */
static void print_default(const struct lx_key *key, const uint8_t *base, FILE *to)
{
    const int64_t now = load(key, base + key->offset);
    if (is_word(key)) {
        (void)fprintf(to, ", default %s", key->words[now]);
    } else if (!is_text(key)) {
        (void)fprintf(to, ", default %lld", (long long)(now / lx_power_of_ten(key->places)));
    }
}

void lx_keys_help(const struct lx_keys *keys, FILE *to)
{
    for (size_t i = 0; i < keys->count; i++) {
        const struct lx_key *key = &keys->rows[i];
        if (!has(keys, i)) {
            continue;
        }
        (void)fprintf(to, "  %-23s %s (%s", key->name, key->help, range_of(key).text);
        if (keys->base != NULL) {
            print_default(key, keys->base, to);
        }
        (void)fputs(")\n", to);
    }
}

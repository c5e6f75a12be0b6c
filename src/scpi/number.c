/* SPDX-License-Identifier: MIT */
/*
 * Numbers, exactly: digits, point and exponent are never turned into anything binary before they
 * are multiplied with the unit. A number is `whole` and a fraction; the fraction is multiplied
 * digit by digit from the right, where floor((d * f + floor(x)) / 10) = floor((d * f + x) / 10).
 */
#include "scpi_private.h"

#include "drehgeber/angle.h"

#define DECIMAL 10u
#define PLACES_MAX 9u
/* A line has 512 digits at most: a larger exponent gives nothing but 0 or too much, too. */
#define EXPONENT_MAX 2000
/* Ranges of angles are shown in 0.000001 degrees. */
#define MICRODEGREES_PER_TURN UINT64_C(360000000)

/* A suffix: 1 of it is factor / per of the base unit. The first of a unit goes without saying. */
struct suffix {
    uint64_t factor;
    uint16_t per;
    uint8_t unit;
    char name[6];
};

/* clang-format off */
static const struct suffix suffixes[] = {
    {1,                   1, DG_SCPI_PLAIN,        ""}, /* 10^places, as the range says */
    {(uint64_t)DG_TURN, 360, DG_SCPI_ANGLE,        "DEG"},
    {(uint64_t)DG_TURN,   1, DG_SCPI_ANGLE,        "REV"},
    {1000,                1, DG_SCPI_SPEED,        "RPM"},
    {1000,                1, DG_SCPI_ACCELERATION, "RPM/S"},
    {1000000,             1, DG_SCPI_TIME,         "MS"},
    {1000000000,          1, DG_SCPI_TIME,         "S"},
    {1000,                1, DG_SCPI_TIME,         "US"},
    {1,                   1, DG_SCPI_TIME,         "NS"},
    {1000,                1, DG_SCPI_TEMPERATURE,  "DEGC"},
    {1000,                1, DG_SCPI_TEMPERATURE,  "CEL"},
    {1,                   1, DG_SCPI_VOLTAGE,      "MV"},
    {1000,                1, DG_SCPI_VOLTAGE,      "V"},
    {1,                   1, DG_SCPI_CURRENT,      "UA"},
    {1000,                1, DG_SCPI_CURRENT,      "MA"},
};

/* Places behind the point that the base unit has in the first suffix, for ranges; voltage and
   current have none, a plain number those of its range. */
static const uint8_t unit_places[DG_SCPI_UNIT_COUNT] = {
    [DG_SCPI_ANGLE] = 6,       [DG_SCPI_SPEED] = 3,       [DG_SCPI_ACCELERATION] = 3,
    [DG_SCPI_TIME] = 6,        [DG_SCPI_TEMPERATURE] = 3, [DG_SCPI_VOLTAGE] = 0,
    [DG_SCPI_CURRENT] = 0,
};
/* clang-format on */
#define SUFFIX_COUNT DG_COUNT(suffixes)

static const uint32_t powers[PLACES_MAX + 1u] = {
    1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000, 1000000000,
};

/* A decimal number as it stands in the line. */
struct decimal {
    const char *begin; /* of digits and point */
    const char *end;
    int32_t count; /* digits */
    int32_t point; /* digits in front of the point, exponent added; may be beyond all of them */
    bool negative;
};

/* Its value. */
struct value {
    uint64_t magnitude;
    bool negative;
    bool too_large;
};

static bool is_sign(char c)
{
    return c == '+' || c == '-';
}

/* @return whether the number has a digit */
static bool read_mantissa(struct dg_scpi *self, struct decimal *out)
{
    const char *at = &self->line[self->at];
    bool point = false;

    out->negative = *at == '-';
    at += is_sign(*at) ? 1 : 0;
    out->begin = at;
    out->count = 0;
    out->point = 0;
    for (; dg_scpi_is_digit(*at) || (*at == '.' && !point); at++) {
        point = point || *at == '.';
        out->count += *at != '.' ? 1 : 0;
        out->point += point ? 0 : 1;
    }
    out->end = at;
    if (out->count == 0) {
        return false;
    }
    self->at = (uint16_t)(at - self->line);
    return true;
}

/* 'E' and digits, blanks around it; other letters, and an 'E' alone, are a suffix. */
static void read_exponent(struct dg_scpi *self, struct decimal *out)
{
    const uint16_t before = self->at;
    int32_t exponent = 0;

    dg_scpi_skip_blanks(self);
    const bool marked = dg_text_upper(self->line[self->at]) == 'E';
    self->at = (uint16_t)(self->at + (marked ? 1u : 0u));
    dg_scpi_skip_blanks(self);
    const bool negative = self->line[self->at] == '-';
    self->at = (uint16_t)(self->at + (is_sign(self->line[self->at]) ? 1u : 0u));
    if (!marked || !dg_scpi_is_digit(self->line[self->at])) {
        self->at = before;
        return;
    }
    for (; dg_scpi_is_digit(self->line[self->at]); self->at++) {
        exponent = exponent * (int32_t)DECIMAL + (self->line[self->at] - '0');
        exponent = exponent < EXPONENT_MAX ? exponent : EXPONENT_MAX;
    }
    out->point += negative ? -exponent : exponent;
}

static uint64_t digit_value_of(char c)
{
    return (uint64_t)(c - '0');
}

/* The digits in front of the point. @return false: more than 64 bits */
static bool whole_of(const struct decimal *number, uint64_t *whole)
{
    const char *at = number->begin;
    uint64_t sum = 0;

    for (int32_t i = 0; i < number->point && (i < number->count || sum > 0); i++) {
        at += at < number->end && *at == '.' ? 1 : 0;
        if (sum > (UINT64_MAX - (DECIMAL - 1u)) / DECIMAL) {
            return false;
        }
        sum = sum * DECIMAL + (at < number->end ? digit_value_of(*at) : 0u);
        at += at < number->end ? 1 : 0;
    }
    *whole = sum;
    return true;
}

/* floor(fraction * factor), below `factor`; `rest` when that is not all of it. */
static uint64_t fraction_of(const struct decimal *number, uint64_t factor, bool *rest)
{
    uint64_t x = 0;
    int32_t i = number->count;

    for (const char *at = number->end; i > 0 && i > number->point;) {
        at--;
        if (*at != '.') {
            x += digit_value_of(*at) * factor;
            *rest = *rest || x % DECIMAL != 0;
            x /= DECIMAL;
            i--;
        }
    }
    for (i = number->point; i < 0 && x > 0; i++) { /* zeros between the point and the digits */
        *rest = *rest || x % DECIMAL != 0;
        x /= DECIMAL;
    }
    return x;
}

/* whole = turns * per + part: part * factor is below 2^32 * 360, whatever the number is. */
static struct value evaluate_number(const struct decimal *number, const struct suffix *suffix)
{
    struct value value = {.negative = number->negative, .too_large = true};
    bool rest = false;
    uint64_t whole;

    if (!whole_of(number, &whole) || whole / suffix->per > UINT64_MAX / suffix->factor - 1u) {
        return value;
    }
    const uint64_t part =
        whole % suffix->per * suffix->factor + fraction_of(number, suffix->factor, &rest);
    value.magnitude = whole / suffix->per * suffix->factor + part / suffix->per;
    rest = rest || part % suffix->per != 0;
    if (suffix->unit == DG_SCPI_ANGLE && rest && !number->negative) {
        value.magnitude++; /* upwards, so that the angle of a step is in the step */
    }
    value.too_large = false;
    return value;
}

static int digit_in(char c, unsigned base)
{
    const char upper = dg_text_upper(c);
    int digit = dg_scpi_is_digit(c) ? c - '0' : -1;

    if (upper >= 'A' && upper <= 'F') {
        digit = upper - 'A' + (int)DECIMAL;
    }
    return digit < (int)base ? digit : -1;
}

/* #H, #Q, #B and 0x. @return 0: no such number begins here */
static unsigned base_of(const char *text)
{
    static const struct {
        char prefix[3];
        uint8_t base;
    } rows[] = {{"#H", 16}, {"#Q", 8}, {"#B", 2}, {"0X", 16}};

    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        if (dg_text_same(rows[i].prefix, text, sizeof rows[i].prefix - 1u, dg_text_upper)) {
            return rows[i].base;
        }
    }
    return 0;
}

static const char *const a_number[] = {"a number"};

/* @return false: an error was raised */
static bool read_based(struct dg_scpi *self, unsigned base, struct value *out)
{
    const char *at = &self->line[self->at + 2u];

    *out = (struct value){.magnitude = 0};
    if (digit_in(*at, base) < 0) {
        dg_scpi_refuse_word(self, DG_SCPI_DATA_TYPE, a_number, 1);
        return false;
    }
    for (; digit_in(*at, base) >= 0; at++) {
        out->too_large = out->too_large || out->magnitude > UINT64_MAX / base;
        out->magnitude = out->magnitude * base + (uint64_t)digit_in(*at, base);
    }
    self->at = (uint16_t)(at - self->line);
    return dg_scpi_close(self, DG_SCPI_DATA_TYPE);
}

/* The first of a unit is the one that goes without saying; each unit has one. */
static const struct suffix *usual_suffix(enum dg_scpi_unit unit)
{
    size_t i = 0;

    while (i + 1u < SUFFIX_COUNT && suffixes[i].unit != (uint8_t)unit) {
        i++;
    }
    return &suffixes[i];
}

/* Without a name the usual one. */
static const struct suffix *find_suffix(enum dg_scpi_unit unit, const char *name, size_t n)
{
    if (n == 0) {
        return usual_suffix(unit);
    }
    for (size_t i = 0; i < SUFFIX_COUNT; i++) {
        if (suffixes[i].unit == (uint8_t)unit && dg_scpi_length(suffixes[i].name) == n &&
            dg_text_same(suffixes[i].name, name, n, dg_text_upper)) {
            return &suffixes[i];
        }
    }
    return NULL;
}

/* A number that takes none has no list of them. */
static void refuse_suffix(struct dg_scpi *self, enum dg_scpi_unit unit)
{
    const char *names[SUFFIX_COUNT];
    size_t count = 0;

    for (size_t i = 0; i < SUFFIX_COUNT; i++) {
        if (suffixes[i].unit == (uint8_t)unit) {
            names[count++] = unit == DG_SCPI_PLAIN ? "a number alone" : suffixes[i].name;
        }
    }
    dg_scpi_refuse_word(self, DG_SCPI_SUFFIX, names, count);
}

/* Whose suffixes it takes. */
static enum dg_scpi_unit unit_of(const struct dg_scpi_range *range)
{
    return range->unit == DG_SCPI_DURATION ? DG_SCPI_TIME : range->unit;
}

/* Whether the number in front of the place is the whole parameter. */
static bool is_bare(const struct dg_scpi *self)
{
    const char *at = &self->line[self->at];

    while (*at == ' ' || *at == '\t') {
        at++;
    }
    return *at == ',' || dg_scpi_is_end(*at);
}

/* @return false: an error was raised */
static bool read_suffix(struct dg_scpi *self, const struct dg_scpi_range *range, struct suffix *out)
{
    const uint16_t before = self->at;

    dg_scpi_skip_blanks(self);
    const size_t n = dg_scpi_token(self);
    const struct suffix *found = find_suffix(unit_of(range), &self->line[self->at], n);

    if (found == NULL && dg_scpi_is_digit(self->line[self->at])) { /* the next number */
        self->at = before;
        (void)dg_scpi_close(self, DG_SCPI_SUFFIX);
        return false;
    }
    if (found == NULL) {
        refuse_suffix(self, unit_of(range));
        return false;
    }
    *out = *found;
    if (range->unit == DG_SCPI_PLAIN) {
        out->factor = powers[range->places];
    }
    self->at = (uint16_t)(self->at + n);
    return dg_scpi_close(self, DG_SCPI_SUFFIX);
}

/* A limit in the unit that goes without saying, without zeros at its end. */
static void add_limit(struct dg_text *detail, const struct dg_scpi_range *range, int64_t limit)
{
    const bool plain = range->unit == DG_SCPI_PLAIN;
    unsigned places = plain ? range->places : unit_places[unit_of(range)];
    uint64_t magnitude = dg_scpi_magnitude(limit);
    char text[DG_TEXT_DIGITS_MAX];

    if (range->unit == DG_SCPI_ANGLE) { /* to the nearest */
        magnitude = (dg_muldiv(magnitude, 2u * MICRODEGREES_PER_TURN, (uint64_t)DG_TURN) + 1u) / 2u;
    }
    while (places > 0 && magnitude % DECIMAL == 0) {
        magnitude /= DECIMAL;
        places--;
    }
    dg_text_add_n(detail, text, dg_text_digits(text, magnitude, limit < 0, places));
}

static void raise_range(struct dg_scpi *self, const struct dg_scpi_range *range)
{
    const char *const name = usual_suffix(unit_of(range))->name;
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    add_limit(&detail, range, range->min);
    dg_text_add(&detail, "..");
    add_limit(&detail, range, range->max);
    if (name[0] != '\0') {
        dg_text_add(&detail, " ");
        dg_text_add(&detail, name);
    }
    dg_scpi_raise(self, DG_SCPI_RANGE, detail.to);
}

/* @return false: out of the range */
static bool fit_into_range(const struct value *value, const struct dg_scpi_range *range,
                           int64_t *out)
{
    const uint64_t most = (uint64_t)INT64_MAX + (value->negative ? 1u : 0u);

    if (value->too_large || value->magnitude > most) {
        return false;
    }
    *out = (int64_t)(value->negative ? 0u - value->magnitude : value->magnitude);
    return *out >= range->min && *out <= range->max;
}

/* A duration without a unit: the number stands in front of the place, from `begin` on. What is out
   of the range with a unit, too, is no advice. */
static void refuse_bare(struct dg_scpi *self, uint16_t begin, const struct decimal *number,
                        const struct dg_scpi_range *range)
{
    const size_t n = (size_t)self->at - begin;
    const struct suffix *const units = usual_suffix(DG_SCPI_TIME); /* milliseconds, seconds */
    const char *between = "; expected ";
    int64_t ignored;
    char room[SCPI_DETAIL_SIZE];
    struct dg_text detail = dg_text_in(room, sizeof room);

    dg_text_add_n(&detail, &self->line[begin], n);
    for (size_t i = 0; i < 2u; i++) {
        const struct value value = evaluate_number(number, &units[i]);
        if (fit_into_range(&value, range, &ignored)) {
            dg_text_add(&detail, between);
            dg_text_add_n(&detail, &self->line[begin], n);
            dg_text_add(&detail, units[i].name);
            between = " or ";
        }
    }
    if (between[0] == ';') {
        raise_range(self, range);
        return;
    }
    dg_scpi_raise(self, DG_SCPI_NO_SUFFIX, detail.to);
}

/* @return false: an error was raised */
static bool read_decimal(struct dg_scpi *self, const struct dg_scpi_range *range, struct value *out)
{
    const uint16_t begin = self->at;
    struct decimal number;
    struct suffix suffix;

    if (!read_mantissa(self, &number)) {
        dg_scpi_refuse_word(self, DG_SCPI_DATA_TYPE, a_number, 1);
        return false;
    }
    read_exponent(self, &number);
    if (range->unit == DG_SCPI_DURATION && is_bare(self)) {
        refuse_bare(self, begin, &number, range);
        return false;
    }
    if (!read_suffix(self, range, &suffix)) {
        return false;
    }
    *out = evaluate_number(&number, &suffix);
    return true;
}

/* @return whether it is MIN or MAX */
static bool read_limit(struct dg_scpi *self, const struct dg_scpi_range *range, int64_t *value)
{
    static const char minimum[] = "MINimum";
    static const char maximum[] = "MAXimum";
    const char *const text = &self->line[self->at];
    const size_t n = dg_scpi_token(self);

    if (dg_scpi_is_form(minimum, sizeof minimum - 1u, text, n)) {
        *value = range->min;
    } else if (dg_scpi_is_form(maximum, sizeof maximum - 1u, text, n)) {
        *value = range->max;
    } else {
        return false;
    }
    self->at = (uint16_t)(self->at + n);
    return true;
}

bool dg_scpi_number(struct dg_scpi *self, const struct dg_scpi_range *range, int64_t *value)
{
    int64_t result = 0;
    struct value read = {.magnitude = 0};

    if (!dg_scpi_next(self)) {
        return false;
    }
    if (read_limit(self, range, &result)) {
        if (!dg_scpi_close(self, DG_SCPI_SYNTAX)) {
            return false;
        }
        *value = result;
        return true;
    }
    const bool whole = range->unit == DG_SCPI_PLAIN && range->places == 0;
    const unsigned base = whole ? base_of(&self->line[self->at]) : 0;
    if (!(base != 0 ? read_based(self, base, &read) : read_decimal(self, range, &read))) {
        return false;
    }
    if (!fit_into_range(&read, range, &result)) {
        raise_range(self, range);
        return false;
    }
    *value = result;
    return true;
}

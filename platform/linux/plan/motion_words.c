/* SPDX-License-Identifier: MIT */
/*
 * Words to a motion. Every number goes from its decimal text to the unit of the core in integers:
 * what the user wrote is what the shaft does, on every machine and in every locale.
 */
#define _GNU_SOURCE
#include "motion_words.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "csv.h"
#include "drehgeber/hal.h"
#include "figure.h"
#include "file.h"

#define FORMS "0, 90DEG, 2.5REV, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S[,HOLD] or FILE.csv"
const char lx_shaft_forms[] = FORMS;

/* What a unit measures. */
enum dimension { ANGLE, SPEED, TIME, DIMENSION_COUNT };

/* A unit: a number is kept with `places` decimals, then multiplied by `factor`. Limits are in
   whole units. Angles are converted from degrees in their own way. */
struct unit {
    const char *name;
    enum dimension dimension;
    unsigned places;
    int64_t factor;
    int64_t min;
    int64_t max;
};

/* clang-format off */
static const struct unit units[] = {
    /* name  what   places factor       min          max */
    {"DEG",  ANGLE, 9,          1, -6000000000,  6000000000},
    {"REV",  ANGLE, 9,        360,   -16000000,    16000000},
    {"RPM",  SPEED, 3,          1,    -1000000,     1000000},
    {"MS",   TIME,  6,          1,           0,    86400000}, /* before S: it ends in S, too */
    {"S",    TIME,  9,          1,           0,       86400},
};
static const char *const examples[] = {
    [ANGLE] = "an angle such as 90DEG or 2.5REV",
    [SPEED] = "a speed such as 60RPM",
    [TIME]  = "a time such as 2S or 500MS",
};
/* clang-format on */
_Static_assert(DG_COUNT(examples) == DIMENSION_COUNT, "an example for each");
#define UNIT_COUNT DG_COUNT(units)

/* A number with its unit: 2^-32 turns, 0.001 rpm or nanoseconds. */
struct quantity {
    enum dimension dimension;
    int64_t value;
};

static const struct unit *find_unit(const char *text, size_t n)
{
    for (size_t i = 0; i < UNIT_COUNT; i++) {
        const size_t length = strlen(units[i].name);
        if (n > length && strncasecmp(text + n - length, units[i].name, length) == 0) {
            return &units[i];
        }
    }
    return NULL;
}

/* Whole turns and the rest are converted apart: 360 * 10^9 * turns would not fit 64 bits. */
static dg_angle angle_of(const struct unit *unit, int64_t value)
{
    if (unit->factor == 1) {
        return lx_angle_of_degrees(value, unit->places);
    }
    const int64_t one = lx_power_of_ten(unit->places);
    const int64_t turns = value / one;
    return turns * DG_TURN + lx_angle_of_degrees(value % one * unit->factor, unit->places);
}

static int parse_quantity(struct quantity *out, const char *text, size_t n, struct lx_error *error)
{
    const struct unit *unit = find_unit(text, n);
    struct lx_decimal number;
    if (unit == NULL || !lx_decimal_parse(text, n - strlen(unit->name), unit->places, &number)) {
        return lx_fail(error, "'%.*s' is not a number with a unit (DEG REV RPM S MS)", (int)n,
                       text);
    }
    if (number.cut) {
        return lx_fail(error, "'%.*s' has more than %u decimals", (int)n, text, unit->places);
    }
    const int64_t one = lx_power_of_ten(unit->places);
    if (number.value < unit->min * one || number.value > unit->max * one) {
        return lx_fail(error, "'%.*s' is outside %lld..%lld %s", (int)n, text, (long long)unit->min,
                       (long long)unit->max, unit->name);
    }
    out->dimension = unit->dimension;
    out->value = unit->dimension == ANGLE ? angle_of(unit, number.value) : number.value;
    return 0;
}

/* Whether it is a number without a unit. */
static bool is_bare(const char *text, size_t n)
{
    struct lx_decimal number;
    return lx_decimal_parse(text, n, 0, &number);
}

/* The next of comma-separated quantities; `rest` moves behind it, to NULL after the last. */
static int next_quantity(const char **rest, enum dimension wanted, int64_t *value,
                         struct lx_error *error)
{
    if (*rest == NULL) {
        return lx_fail(error, "%s is missing", examples[wanted]);
    }
    const char *comma = strchr(*rest, ',');
    const size_t n = comma == NULL ? strlen(*rest) : (size_t)(comma - *rest);
    struct quantity quantity = {.value = 0};
    if (is_bare(*rest, n)) {
        struct lx_words right = {""};
        lx_words_add(&right, "%s is right", examples[wanted]);
        return lx_refuse(error, right.text, "'%.*s' has no unit", (int)n, *rest);
    }
    if (parse_quantity(&quantity, *rest, n, error) != 0) {
        return -1;
    }
    if (quantity.dimension != wanted) {
        return lx_fail(error, "'%.*s' stands where %s belongs", (int)n, *rest, examples[wanted]);
    }
    *value = quantity.value;
    *rest = comma == NULL ? NULL : comma + 1;
    return 0;
}

static int parse_sine(struct dg_motion *motion, const char *rest, struct lx_error *error)
{
    int64_t period = 0;
    if (next_quantity(&rest, ANGLE, &motion->amplitude, error) != 0 ||
        next_quantity(&rest, TIME, &period, error) != 0) {
        return -1;
    }
    if (rest != NULL) {
        return lx_fail(error, "'%s' is too much; a sine is sine:AMPLITUDE,PERIOD", rest);
    }
    motion->kind = DG_MOTION_SINE;
    motion->period = (dg_ns)period;
    return 0;
}

/* Without HOLD it stays at its speed. */
static int parse_ramp(struct dg_motion *motion, const char *rest, struct lx_error *error)
{
    int64_t speed_mrpm = 0;
    int64_t accel = 0;
    int64_t hold = 0;
    if (next_quantity(&rest, SPEED, &speed_mrpm, error) != 0 ||
        next_quantity(&rest, TIME, &accel, error) != 0) {
        return -1;
    }
    const bool held = rest != NULL;
    if (held && next_quantity(&rest, TIME, &hold, error) != 0) {
        return -1;
    }
    if (rest != NULL) {
        return lx_fail(error, "'%s' is too much; a ramp is ramp:SPEED,TIME[,HOLD]", rest);
    }
    motion->kind = DG_MOTION_RAMP;
    motion->mrpm = (int32_t)speed_mrpm;
    motion->accel = (dg_ns)accel;
    motion->hold = held ? (dg_ns)hold : DG_NEVER;
    return 0;
}

struct lx_shaft_file {
    FILE *file;
    struct lx_csv *lines;
};

struct lx_shaft_file *lx_shaft_file_open(const char *text, const struct lx_folder *folder,
                                         struct lx_error *error)
{
    struct lx_shaft_file *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)lx_fail(error, "%s: no memory for its lines", text);
        return NULL;
    }
    self->file = lx_file_read(folder, text, error);
    if (self->file != NULL) {
        self->lines = lx_csv_open(self->file, text, &lx_csv_motion,
                                  folder == NULL ? SIZE_MAX : LX_CSV_CLIENT_MAX);
    }
    if (self->file != NULL && self->lines == NULL) {
        (void)lx_fail(error, "%s: no memory for its lines", text);
    }
    if (self->lines == NULL) {
        lx_shaft_file_close(self);
        return NULL;
    }
    return self;
}

int lx_shaft_file_read(struct lx_shaft_file *self, struct lx_shaft *to, struct lx_error *error)
{
    const int result = lx_csv_read_on(self->lines, LX_CSV_SLICE, error);
    if (result != 0) {
        return result < 0 ? LX_SHAFT_FILE : result;
    }
    const struct lx_csv_points recording = lx_csv_take(self->lines);
    *to = (struct lx_shaft){
        .motion = {.kind = DG_MOTION_REPLAY,
                   .points = recording.points,
                   .point_count = recording.count},
        .points = recording.points,
    };
    return 0;
}

void lx_shaft_file_close(struct lx_shaft_file *self)
{
    if (self == NULL) {
        return;
    }
    lx_csv_close(self->lines);
    if (self->file != NULL) {
        (void)fclose(self->file);
    }
    free(self);
}

static int parse_file(struct lx_shaft *self, const char *name, const struct lx_folder *folder,
                      struct lx_error *error)
{
    struct lx_shaft_file *file = lx_shaft_file_open(name, folder, error);
    int result = file == NULL ? -1 : 1;
    while (result > 0) {
        result = lx_shaft_file_read(file, self, error);
    }
    lx_shaft_file_close(file);
    return result;
}

/* An angle stands still, a speed turns for good; 0 needs no unit. */
static int parse_simple(struct dg_motion *motion, const char *text, struct lx_error *error)
{
    struct lx_decimal zero;
    if (lx_decimal_parse(text, strlen(text), 0, &zero) && zero.value == 0 && !zero.cut) {
        return 0;
    }
    if (is_bare(text, strlen(text))) {
        struct lx_words right = {""};
        lx_words_add(&right, "%sDEG or %sRPM, for one, is right", text, text);
        return lx_refuse(error, right.text, "'%s' has no unit", text);
    }
    struct quantity quantity = {.value = 0};
    if (parse_quantity(&quantity, text, strlen(text), error) != 0) {
        return -1;
    }
    if (quantity.dimension == TIME) {
        return lx_fail(error, "'%s' is a time", text);
    }
    if (quantity.dimension == ANGLE) {
        motion->from = quantity.value;
    } else {
        motion->kind = DG_MOTION_SPEED;
        motion->mrpm = (int32_t)quantity.value;
    }
    return 0;
}

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text);
    const size_t length = strlen(end);
    return n > length && strcasecmp(text + n - length, end) == 0;
}

/* Every form but a file's contents. The caller adds the list of forms to the error; what a kind
   of motion allows is dg_motion_set()'s to check. */
static int parse_words(struct dg_motion *motion, const char *text, struct lx_error *error)
{
    if (strncasecmp(text, "sine:", 5) == 0) {
        return parse_sine(motion, text + 5, error);
    }
    if (strncasecmp(text, "ramp:", 5) == 0) {
        return parse_ramp(motion, text + 5, error);
    }
    return parse_simple(motion, text, error);
}

bool lx_shaft_is_file(const char *text)
{
    return ends_with(text, ".csv");
}

/* The list of them, behind what is wrong. */
static const char forms[] = "valid: " FORMS;

int lx_shaft_parse(struct lx_shaft *self, const char *text, const struct lx_folder *folder,
                   struct lx_error *error)
{
    *self = (struct lx_shaft){.motion = {.kind = DG_MOTION_STANDSTILL}};
    if (lx_shaft_is_file(text)) {
        return parse_file(self, text, folder, error) == 0 ? 0 : LX_SHAFT_FILE;
    }
    if (parse_words(&self->motion, text, error) != 0) {
        if (error->right[0] == '\0') {
            const struct lx_error reason = *error;
            (void)lx_refuse(error, forms, "%s", reason.what);
        }
        (void)lx_about(error, LX_ABOUT_KEY, "motion", text);
        return LX_SHAFT_WORDS;
    }
    const struct dg_motion wanted = self->motion;
    if (dg_motion_set(&self->motion, &wanted) != DG_OK) {
        (void)lx_refuse(error,
                        "a ramp takes above 0 to 3600S, a sine has up to 256REV and above 0 to "
                        "86400S",
                        "out of range");
        (void)lx_about(error, LX_ABOUT_KEY, "motion", text);
        return LX_SHAFT_WORDS;
    }
    return 0;
}

void lx_shaft_free(struct lx_shaft *self)
{
    free(self->points);
    self->points = NULL;
}

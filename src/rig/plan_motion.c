/* SPDX-License-Identifier: MIT */
/*
 * Words to a motion. Every number goes from its decimal text to the unit of the core in integers:
 * what the user wrote is what the shaft does, on every machine.
 */
#include "drehgeber/figure.h"
#include "drehgeber/hal.h"
#include "rig_private.h"

#define FORMS "0, 90DEG, 2.5REV, 60RPM, sine:90DEG,2S, ramp:3000RPM,1S[,HOLD] or FILE.csv"
const char dg_motion_forms[] = FORMS;

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

static int refuse_motion(struct dg_plan_error *error, rig_parts what)
{
    return dg_plan_refuse(error, RIG_SAY("valid: " FORMS), what);
}

static const struct unit *find_unit(const char *text, size_t n)
{
    for (size_t i = 0; i < UNIT_COUNT; i++) {
        const size_t length = dg_plan_length(units[i].name);
        if (n > length && dg_text_same(text + n - length, units[i].name, length, dg_text_upper)) {
            return &units[i];
        }
    }
    return NULL;
}

/* Whole turns and the rest are converted apart: 360 * 10^9 * turns would not fit 64 bits. */
static dg_angle angle_of(const struct unit *unit, int64_t value)
{
    if (unit->factor == 1) {
        return dg_angle_of_degrees(value, unit->places);
    }
    const int64_t one = dg_power_of_ten(unit->places);
    const int64_t turns = value / one;
    return turns * DG_TURN + dg_angle_of_degrees(value % one * unit->factor, unit->places);
}

static int parse_quantity(struct quantity *out, const char *text, size_t n,
                          struct dg_plan_error *error)
{
    const struct unit *unit = find_unit(text, n);
    struct dg_decimal number;
    if (unit == NULL ||
        !dg_decimal_parse(text, n - dg_plan_length(unit->name), unit->places, &number)) {
        return refuse_motion(error, RIG_SAY("'", dg_plan_cut(text, n).text,
                                            "' is not a number with a unit (DEG REV RPM S MS)"));
    }
    if (number.cut) {
        return refuse_motion(error, RIG_SAY("'", dg_plan_cut(text, n).text, "' has more than ",
                                            dg_plan_number(unit->places).text, " decimals"));
    }
    const int64_t one = dg_power_of_ten(unit->places);
    if (number.value < unit->min * one || number.value > unit->max * one) {
        return refuse_motion(error, RIG_SAY("'", dg_plan_cut(text, n).text, "' is outside ",
                                            dg_plan_signed(unit->min).text, "..",
                                            dg_plan_signed(unit->max).text, " ", unit->name));
    }
    out->dimension = unit->dimension;
    out->value = unit->dimension == ANGLE ? angle_of(unit, number.value) : number.value;
    return 0;
}

/* Whether it is a number without a unit. */
static bool is_bare_number(const char *text, size_t n)
{
    struct dg_decimal number;
    return dg_decimal_parse(text, n, 0, &number);
}

/* The next of comma-separated quantities; `rest` moves behind it, to NULL after the last. */
static int next_quantity(const char **rest, enum dimension wanted, int64_t *value,
                         struct dg_plan_error *error)
{
    if (*rest == NULL) {
        return refuse_motion(error, RIG_SAY(examples[wanted], " is missing"));
    }
    const size_t n = dg_plan_span(*rest, ',');
    struct quantity quantity = {.value = 0};
    if (is_bare_number(*rest, n)) {
        return dg_plan_refuse(error, RIG_SAY("expected ", examples[wanted]),
                              RIG_SAY("'", dg_plan_cut(*rest, n).text, "' has no unit"));
    }
    if (parse_quantity(&quantity, *rest, n, error) != 0) {
        return -1;
    }
    if (quantity.dimension != wanted) {
        return refuse_motion(error, RIG_SAY("'", dg_plan_cut(*rest, n).text, "' stands where ",
                                            examples[wanted], " belongs"));
    }
    *value = quantity.value;
    *rest = (*rest)[n] == '\0' ? NULL : *rest + n + 1u;
    return 0;
}

static int parse_sine(struct dg_motion *motion, const char *rest, struct dg_plan_error *error)
{
    int64_t period = 0;
    if (next_quantity(&rest, ANGLE, &motion->amplitude, error) != 0 ||
        next_quantity(&rest, TIME, &period, error) != 0) {
        return -1;
    }
    if (rest != NULL) {
        return refuse_motion(error,
                             RIG_SAY("'", rest, "' is too much; a sine is sine:AMPLITUDE,PERIOD"));
    }
    motion->kind = DG_MOTION_SINE;
    motion->period = (dg_ns)period;
    return 0;
}

/* Without HOLD it stays at its speed. */
static int parse_ramp(struct dg_motion *motion, const char *rest, struct dg_plan_error *error)
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
        return refuse_motion(error,
                             RIG_SAY("'", rest, "' is too much; a ramp is ramp:SPEED,TIME[,HOLD]"));
    }
    motion->kind = DG_MOTION_RAMP;
    motion->mrpm = (int32_t)speed_mrpm;
    motion->accel = (dg_ns)accel;
    motion->hold = held ? (dg_ns)hold : DG_NEVER;
    return 0;
}

/* An angle stands still, a speed turns for good; 0 needs no unit. */
static int parse_simple(struct dg_motion *motion, const char *text, struct dg_plan_error *error)
{
    struct dg_decimal zero;
    if (dg_decimal_parse(text, dg_plan_length(text), 0, &zero) && zero.value == 0 && !zero.cut) {
        return 0;
    }
    if (is_bare_number(text, dg_plan_length(text))) {
        return dg_plan_refuse(error,
                              RIG_SAY("expected ", text, "DEG or ", text, "RPM, for example"),
                              RIG_SAY("'", text, "' has no unit"));
    }
    struct quantity quantity = {.value = 0};
    if (parse_quantity(&quantity, text, dg_plan_length(text), error) != 0) {
        return -1;
    }
    if (quantity.dimension == TIME) {
        return refuse_motion(error, RIG_SAY("'", text, "' is a time"));
    }
    if (quantity.dimension == ANGLE) {
        motion->from = quantity.value;
    } else {
        motion->kind = DG_MOTION_SPEED;
        motion->mrpm = (int32_t)quantity.value;
    }
    return 0;
}

/* Every form but a file's contents. The caller adds the list of forms to the error; what a kind
   of motion allows is dg_motion_set()'s to check. */
static int parse_words(struct dg_motion *motion, const char *text, struct dg_plan_error *error)
{
    if (dg_text_same(text, "sine:", 5, dg_text_upper)) {
        return parse_sine(motion, text + 5, error);
    }
    if (dg_text_same(text, "ramp:", 5, dg_text_upper)) {
        return parse_ramp(motion, text + 5, error);
    }
    return parse_simple(motion, text, error);
}

bool dg_motion_is_file(const char *text)
{
    return dg_plan_ends(text, dg_plan_length(text), ".csv");
}

int dg_motion_read(struct dg_motion *to, const char *text, struct dg_plan_error *error)
{
    *to = (struct dg_motion){.kind = DG_MOTION_STANDSTILL};
    int result = parse_words(to, text, error);
    const struct dg_motion wanted = *to;

    if (result == 0 && dg_motion_set(to, &wanted) != DG_OK) {
        result =
            dg_plan_refuse(error,
                           RIG_SAY("a ramp takes above 0 to 3600S, a sine has up to 256REV and "
                                   "above 0 to 86400S"),
                           RIG_SAY("out of range"));
    }
    if (result != 0) {
        (void)dg_plan_about(error, "motion", text);
        return DG_ERR_ARGUMENT;
    }
    return DG_OK;
}

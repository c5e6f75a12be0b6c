/* SPDX-License-Identifier: MIT */
/*
 * Value change dump (IEEE 1364) with the two signals of a wire. Other signals are left alone.
 */
#include <inttypes.h>
#include <string.h>

#include "explain_levels.h"

#define ID_MAX 16u

struct vcd {
    struct explain_source source;
    uint64_t step; /* in units of 1 ps */
    bool over;
    char ids[EXPLAIN_SIDES][ID_MAX]; /* "": not found yet */
    struct explain_levels levels;
};

static bool begins(const uint8_t *bytes, size_t n)
{
    size_t i = 0;
    while (i < n && (bytes[i] == ' ' || bytes[i] == '\n' || bytes[i] == '\r')) {
        i++;
    }
    return i < n && bytes[i] == '$';
}

static bool is_word(const char *token, size_t n, const char *word)
{
    return strlen(word) == n && strncmp(token, word, n) == 0;
}

static int refuse_vcd(const struct vcd *self, const char *at, const char *what, const char *right,
                      struct lx_error *error)
{
    return explain_text_refuse(&self->source.text, at, what, right, error);
}

/* The next word, over the ends of lines. @return 1; 0: the file is over; -1 */
static int take_token(struct vcd *self, const char **token, size_t *n, struct lx_error *error)
{
    struct explain_text *text = &self->source.text;
    *n = text->line == NULL ? 0 : explain_text_token(text, token);
    while (*n == 0) {
        const int found = explain_text_next(text, error);
        if (found != 1) {
            return found;
        }
        *n = explain_text_token(text, token);
    }
    return 1;
}

/* --- the header --- */

/* "10 ns", also without a blank. */
static int take_step(struct vcd *self, const char *token, size_t n, struct lx_error *error)
{
    static const struct {
        const char *name;
        uint64_t ps;
    } units[] = {
        {"s", 1000000000000}, {"ms", 1000000000}, {"us", 1000000}, {"ns", 1000}, {"ps", 1}};
    uint64_t value;
    const size_t digits = explain_number(token, n, &value);
    token += digits;
    n -= digits;
    if (n == 0 && take_token(self, &token, &n, error) != 1) {
        token = self->source.text.token;
        n = 0;
    }
    for (size_t i = 0; i < DG_COUNT(units); i++) {
        if (is_word(token, n, units[i].name) && (value == 1 || value == 10 || value == 100)) {
            self->step = value * units[i].ps;
            return 0;
        }
    }
    return refuse_vcd(self, token, "no timescale", "expected 1, 10 or 100 s, ms, us, ns or ps",
                      error);
}

static void take_signal_name(struct vcd *self, const char *id, const char *name, size_t length)
{
    const enum explain_side side = explain_levels_find(&self->levels, name, length);
    if (side != EXPLAIN_SIDES) {
        (void)snprintf(self->ids[side], sizeof self->ids[side], "%s", id);
    }
}

/* "wire 1 ! MA", behind $var */
static int take_variable(struct vcd *self, struct lx_error *error)
{
    const char *token;
    char id[ID_MAX] = "";
    size_t id_length = 0;
    bool one = false;
    for (unsigned i = 0; i < 4u; i++) {
        size_t n = 0;
        if (take_token(self, &token, &n, error) != 1 || is_word(token, n, "$end")) {
            return refuse_vcd(self, self->source.text.token, "no variable",
                              "expected $var TYPE WIDTH ID NAME $end", error);
        }
        if (i == 1u) {
            one = is_word(token, n, "1");
        } else if (i == 2u) {
            id_length = n < sizeof id ? n : 0; /* no signal of a wire has a longer one */
            memcpy(id, token, id_length);
        } else if (i == 3u && one && id_length > 0) {
            take_signal_name(self, id, token, n);
        }
    }
    return 0;
}

/* Everything up to $end. */
static int skip_section(struct vcd *self, struct lx_error *error)
{
    const char *token;
    size_t n;
    int found;
    while ((found = take_token(self, &token, &n, error)) == 1) {
        if (is_word(token, n, "$end")) {
            return 0;
        }
    }
    return found < 0 ? -1
                     : refuse_vcd(self, self->source.text.token, "the file ends here",
                                  "expected $end", error);
}

/* A section of the header. @return 1; 0: it was the last one; -1 */
static int take_section(struct vcd *self, struct lx_error *error)
{
    const char *token;
    size_t n = 0;
    const int found = take_token(self, &token, &n, error);
    if (found < 0) {
        return -1;
    }
    if (found == 0 || token[0] != '$') {
        return refuse_vcd(self, found == 0 ? self->source.text.token : token, "no header",
                          "expected $enddefinitions", error);
    }
    const bool last = is_word(token, n, "$enddefinitions");
    int result = 0;
    if (is_word(token, n, "$timescale")) {
        const int got = take_token(self, &token, &n, error);
        result = got == 1 ? take_step(self, token, n, error) : got;
    } else if (is_word(token, n, "$var")) {
        result = take_variable(self, error);
    }
    return result != 0 || skip_section(self, error) != 0 ? -1 : !last;
}

static int open_vcd(struct explain_source *source, struct lx_error *error)
{
    struct vcd *self = (struct vcd *)source;
    int found;
    self->step = 1000;
    source->sided = true;
    while ((found = take_section(self, error)) == 1) {
    }
    if (found == 0 && !explain_levels_whole(&self->levels)) {
        return refuse_vcd(self, self->source.text.token, "no wire", explain_levels_right, error);
    }
    return found;
}

/* --- what changes --- */

/* "#4711" */
static int take_vcd_time(struct vcd *self, const char *token, size_t n, struct lx_error *error)
{
    uint64_t value;
    const uint64_t most =
        DG_S(UINT64_C(10000000000)) / (self->step < 1000u ? 1u : self->step / 1000u);
    if (n < 2u || explain_number(token + 1, n - 1u, &value) != n - 1u || value > most) {
        return refuse_vcd(self, token, "no time", "expected # and a number that fits the timescale",
                          error);
    }
    const dg_ns at =
        self->step < 1000u ? value / (1000u / self->step) : value * (self->step / 1000u);
    if (at < self->levels.now) {
        return refuse_vcd(self, token, "a time before the last one", "expected a later time",
                          error);
    }
    if (at > self->levels.now) {
        explain_levels_advance(&self->levels, &self->source.uart, at);
    }
    self->levels.now = at;
    return 0;
}

static void take_level(struct vcd *self, const char *id, size_t n, bool level)
{
    for (unsigned side = 0; side < EXPLAIN_SIDES; side++) {
        if (is_word(id, n, self->ids[side])) {
            explain_levels_change(&self->levels, (enum explain_side)side, level);
        }
    }
}

/* "1!", "b0101 !", "r2.5 !", "stext !". @return 0, or -1 */
static int take_change(struct vcd *self, const char *token, size_t n, struct lx_error *error)
{
    const char first = token[0];
    if (first != '\0' && strchr("01xXzZ", first) != NULL && n > 1u) {
        take_level(self, token + 1, n - 1u, first != '0');
        return 0;
    }
    if (first == '\0' || strchr("bBrRs", first) == NULL) {
        return refuse_vcd(self, token, "no change of a signal",
                          "expected #TIME, 0ID, 1ID, bBITS ID, rNUMBER ID or sTEXT ID", error);
    }
    const char level = token[n - 1u];
    const int found = take_token(self, &token, &n, error);
    if (found != 1) {
        return found < 0 ? -1
                         : refuse_vcd(self, self->source.text.token, "the file ends here",
                                      "expected the ID of a signal", error);
    }
    if (first == 'b' || first == 'B') {
        take_level(self, token, n, level != '0');
    }
    return 0;
}

static bool is_block(const char *token, size_t n)
{
    return is_word(token, n, "$dumpvars") || is_word(token, n, "$dumpall") ||
           is_word(token, n, "$dumpon") || is_word(token, n, "$dumpoff") ||
           is_word(token, n, "$end");
}

/* @return 1; 0: the file is over; -1 */
static int take_command(struct vcd *self, struct lx_error *error)
{
    const char *token;
    size_t n = 0;
    const int found = take_token(self, &token, &n, error);
    if (found != 1) {
        return found;
    }
    int result;
    if (token[0] == '#') {
        result = take_vcd_time(self, token, n, error);
    } else if (token[0] == '$') {
        result = is_block(token, n) ? 0 : skip_section(self, error);
    } else {
        result = take_change(self, token, n, error);
    }
    return result == 0 ? 1 : -1;
}

static int next(struct explain_source *source, struct dg_tap_event *to, struct lx_error *error)
{
    struct vcd *self = (struct vcd *)source;
    while (!explain_levels_take(&self->levels, to)) {
        const int found = self->over ? 0 : take_command(self, error);
        if (found < 0 || self->over) {
            return found;
        }
        if (found == 0) {
            explain_levels_advance(&self->levels, &self->source.uart, DG_NEVER);
            self->over = true;
        }
    }
    explain_source_stamp(source, to->at, to);
    return 1;
}

const struct explain_format explain_vcd = {
    .name = "VCD",
    .begins = begins,
    .size = sizeof(struct vcd),
    .open = open_vcd,
    .next = next,
};

/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A section of a rig file: plan_file.c reads it, the row of its kind in plan_section.c makes it a
 * part of the plan. What a section refers to stands above it, so that each is checked when it ends,
 * with all that it may clash with. Functions that return an int give -1 with one line in `error`.
 */
#ifndef DREHGEBER_LINUX_PLAN_SECTION_H
#define DREHGEBER_LINUX_PLAN_SECTION_H

#include <stdbool.h>

#include "plan.h"

/** Longest name of a shaft, bus or encoder. */
#define LX_PLAN_NAME_MAX 32u

/** The sections there are, for messages. */
#define LX_PLAN_SECTIONS "[rig], [shaft NAME], [bus NAME] and [encoder NAME]"

struct lx_plan_section;

/** A kind of section. */
struct lx_plan_section_kind {
    const char *name;
    bool named;              /**< [KIND NAME] */
    bool open;               /**< takes settings beside its keys */
    bool numbered;           /**< the addresses of all stacks are keys of it, too */
    const char *repeats;     /**< the key that may stand several times; NULL: none */
    const char *const *keys; /**< NULL behind the last */
    int (*take)(struct lx_plan *plan, const struct lx_plan_section *self, struct lx_error *error);
};

/** A section. */
struct lx_plan_section {
    const struct lx_plan_section_kind *kind; /**< NULL: none has begun */
    char name[LX_PLAN_NAME_MAX + 1u];
    struct lx_plan_settings words;
    lx_line_number line;
};

/** The kind called `name`, or NULL. */
const struct lx_plan_section_kind *lx_plan_section_find(const char *name);

/** All of a section is there: check it, and put it into the plan.
 * @return 0, or -1 with one line in `error` */
int lx_plan_section_take(struct lx_plan *plan, const struct lx_plan_section *self,
                         struct lx_error *error);

/** Whether `name` can be one: 1 to LX_PLAN_NAME_MAX letters, digits, '_', '-'. */
bool lx_plan_name_fits(const char *name);

/* ---------------------------------------------------------------- for the kinds */

/** What they make of a section; 0 or -1. */
int lx_plan_take_shaft(struct lx_plan *plan, const struct lx_plan_section *self,
                       struct lx_error *error);
int lx_plan_take_bus(struct lx_plan *plan, const struct lx_plan_section *self,
                     struct lx_error *error);
int lx_plan_take_encoders(struct lx_plan *plan, const struct lx_plan_section *self,
                          struct lx_error *error);

/** An [encoder NAME] that is one. @return 0 or -1 */
int lx_plan_take_encoder(struct lx_plan *plan, const struct lx_plan_section *self,
                         struct lx_error *error);

/** The line with this key, or NULL. */
const struct lx_plan_setting *lx_plan_word(const struct lx_plan_section *section, const char *key);

/** Whether `key` is one of the kind's own. */
bool lx_plan_section_has(const struct lx_plan_section_kind *kind, const char *key);

/** A copy of the value in `to`. @return 0 or -1 */
int lx_plan_take_text(const struct lx_plan_setting *row, char **to, struct lx_error *error);

/** A file name, relative to the folder of the rig file, in `to`. @return 0 or -1 */
int lx_plan_take_path(const struct lx_plan *plan, const char *path, char **to,
                      struct lx_error *error);

/** Errors about a word, about a section, about a line of a rig file, printf style; `right` is what
 * would be right, NULL: the text says it. Always -1 */
int lx_plan_wrong_word(const struct lx_plan *plan, const struct lx_plan_setting *row,
                       struct lx_error *error, const char *right, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
int lx_plan_wrong_section(const struct lx_plan *plan, const struct lx_plan_section *section,
                          struct lx_error *error, const char *right, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
int lx_plan_wrong_line(const struct lx_plan *plan, lx_line_number line, struct lx_error *error,
                       const char *right, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/** Errors: there is no memory for more; line `by` has the name already. @return -1 */
int lx_plan_no_room(const struct lx_plan *plan, const struct lx_plan_section *section,
                    struct lx_error *error);
int lx_plan_taken(const struct lx_plan *plan, const struct lx_plan_section *section,
                  lx_line_number by, struct lx_error *error);

/** Index of what is called so, not case sensitive; -1: nothing so far. */
int lx_plan_find_shaft(const struct lx_plan *plan, const char *name);
int lx_plan_find_wire(const struct lx_plan *plan, const char *name);

/** A wire's address as the user wrote it, and where. */
struct lx_plan_where {
    const char *text;                   /**< NULL: none */
    const char *key;                    /**< that gives it, or would */
    const struct lx_plan_setting *word; /**< that gives it; NULL: none */
};

/** The kind of wire that the first `n` characters of the value name. @return NULL with `error` */
const struct lx_wire *lx_plan_take_kind(const struct lx_plan *plan,
                                        const struct lx_plan_setting *row, size_t n,
                                        struct lx_error *error);

/** A wire with the name of the section. @return its index or -1 */
int lx_plan_take_wire(struct lx_plan *plan, const struct lx_plan_section *self,
                      const struct lx_wire *kind, const struct lx_plan_where *where,
                      struct lx_error *error);

/** What is written of a wire, and where to; `row` NULL: nothing. @return 0 or -1 */
int lx_plan_take_trace(struct lx_plan *plan, const struct lx_plan_setting *row, int wire,
                       struct lx_error *error);

#endif

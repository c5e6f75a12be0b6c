/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a rig is to be (drehgeber/rig.h), of a file on this machine or of a command line: its file
 * is opened here, and what is wrong with it told as this port tells things. lx_rig_open() makes the
 * rig.
 */
#ifndef DREHGEBER_LINUX_PLAN_H
#define DREHGEBER_LINUX_PLAN_H

#include <stddef.h>

#include "drehgeber/rig.h"
#include "error.h"

/**
 * Read a rig file and all that it includes. `file` must outlive the plan and `error`.
 * @return 0, or -1 with `error`: file, line, key, what is wrong, what would be right
 */
int lx_plan_read(struct dg_plan *self, const char *file, struct lx_error *error);

/** Models besides those that are built in and those of the file. */
struct lx_plan_shelf {
    /** The one called `name`, for as long as the plan is used; NULL: there is none. */
    const struct dg_device *(*find_model)(void *ctx, const char *name);
    /** A text that was read, called `name` from the folder of the first file, which comes first; the
     * same may come again, and is gone behind the call. NULL: nobody keeps them. */
    void (*keep)(void *ctx, const char *name, const struct dg_plan_text *text);
    void *ctx;
};

/** The same of a file that may name them. */
int lx_plan_read_with(struct dg_plan *self, const char *file, const struct lx_plan_shelf *shelf,
                      struct lx_error *error);

/** An empty plan with memory for what a command line says. @return 0, or -1 with `error` */
int lx_plan_make(struct dg_plan *self, struct lx_error *error);

/** Give everything back; all zero afterwards. */
void lx_plan_free(struct dg_plan *self);

/** Append "KEY=VALUE" to a list of its own, which is not in the memory of a plan.
 * @return 0, or -1 with `error` */
int lx_plan_add_assignment(struct dg_plan_settings *self, const char *assignment, dg_plan_line line,
                           struct lx_error *error);
/** Give such a list back. */
void lx_plan_free_settings(struct dg_plan_settings *self);

/** A file name that stands in `line`, relative to the folder of its file; the caller's.
 * @return NULL with `error` */
char *lx_plan_path(const struct dg_plan *self, const char *path, dg_plan_line line,
                   struct lx_error *error);

/** Say where it stands, unless that was said nearer to it. Always -1, likewise all below. */
int lx_plan_stands(const struct dg_plan *self, dg_plan_line line, struct lx_error *error);

/** `error` is about this setting. */
int lx_plan_refuse_setting(const struct dg_plan *self, const struct dg_plan_setting *setting,
                           struct lx_error *error);

/** `error` is about the word `key` in `line`. */
int lx_plan_refuse_key(const struct dg_plan *self, const char *key, dg_plan_line line,
                       struct lx_error *error);

/** `error` is about the address of `wire`. */
int lx_plan_refuse_wire(const struct dg_plan *self, const struct dg_plan_wire *wire,
                        struct lx_error *error);

#endif

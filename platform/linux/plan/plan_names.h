/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a plan has already, by name: shafts, wires, encoders, and what no two of them may share.
 * Found without walking the plan, however much is in it.
 */
#ifndef DREHGEBER_LINUX_PLAN_NAMES_H
#define DREHGEBER_LINUX_PLAN_NAMES_H

#include <stddef.h>

/** Lists of names; in each a name stands once. */
enum lx_plan_list {
    LX_PLAN_SHAFT,   /**< not case sensitive, likewise the next two */
    LX_PLAN_WIRE,    /**< wires */
    LX_PLAN_ENCODER, /**< encoders */
    LX_PLAN_ALIAS,   /**< likewise, where '-' and '_' are the same */
    LX_PLAN_PLACE,   /**< addresses of wires, those of a `scope` */
    LX_PLAN_NUMBER,  /**< numbers of encoders on the wire `scope` */
    LX_PLAN_MEMORY,  /**< EEPROM files */
    LX_PLAN_TRACE,   /**< trace files */
};

/** A name. */
struct lx_plan_name {
    enum lx_plan_list list;
    size_t scope;     /**< names of different scopes are different ones */
    const char *text; /**< borrowed: as long as it is in use */
};

/** Names with an index each; all zero has none. */
struct lx_plan_names {
    void *root; /**< owned: of a tree of search.h */
};

/** @return the index, or -1 */
int lx_plan_names_find(const struct lx_plan_names *self, const struct lx_plan_name *name);

/** Remember a name; one that is there keeps its index. @return 0, or -1 without memory */
int lx_plan_names_add(struct lx_plan_names *self, const struct lx_plan_name *name, int index);

/** Forget them all. */
void lx_plan_names_free(struct lx_plan_names *self);

#endif

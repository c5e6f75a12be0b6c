/* SPDX-License-Identifier: MIT */
/*
 * What a plan has already, by name: a hash table in the memory of the plan. It is at most three
 * quarters full, and a search ends at a free row; when it doubles, the memory of the old one is
 * lost.
 */
#include "rig_private.h"

#define ROOM_MIN 64u
/* FNV-1a */
#define HASH_BASE UINT32_C(2166136261)
#define HASH_FACTOR UINT32_C(16777619)

static char fold_alias(char c)
{
    if (c == '-') {
        return '_';
    }
    return dg_text_upper(c);
}

static char itself(char c)
{
    return c;
}

static dg_text_fold *fold_of(uint8_t list)
{
    if (list == RIG_ALIAS) {
        return fold_alias;
    }
    return list <= RIG_ENCODER ? dg_text_upper : itself;
}

static bool same_name(const struct dg_plan_name *a, const struct dg_plan_name *b)
{
    return a->list == b->list && a->scope == b->scope &&
           dg_text_same(a->text, b->text, RIG_TEXT_MAX, fold_of(a->list));
}

static uint32_t mix_hash(uint32_t hash, uint32_t value)
{
    return (hash ^ value) * HASH_FACTOR;
}

static size_t hash_of(const struct dg_plan_name *name)
{
    dg_text_fold *const fold = fold_of(name->list);
    uint32_t hash = mix_hash(mix_hash(HASH_BASE, name->list), name->scope);

    for (const char *at = name->text; *at != '\0'; at++) {
        hash = mix_hash(hash, (unsigned char)fold(*at));
    }
    return hash ^ hash >> 15;
}

/* The row that has the name, or the free one where it belongs. */
static struct dg_plan_name *find_hashed(const struct dg_plan *self, const struct dg_plan_name *name)
{
    size_t at = hash_of(name) & (self->name_room - 1u);

    while (self->names[at].text != NULL && !same_name(&self->names[at], name)) {
        at = (at + 1u) & (self->name_room - 1u);
    }
    return &self->names[at];
}

int dg_plan_names_find(const struct dg_plan *self, const struct dg_plan_name *name)
{
    const struct dg_plan_name *row = self->name_room == 0 ? NULL : find_hashed(self, name);

    return row == NULL || row->text == NULL ? -1 : row->index;
}

static int make_name_room(struct dg_plan *self)
{
    const struct dg_plan_name *before = self->names;
    const size_t count = self->name_room;
    const size_t room = count == 0 ? ROOM_MIN : 2u * count;

    if (4u * self->name_count < 3u * count) {
        return 0;
    }
    struct dg_plan_name *rows = dg_plan_reserve(self, room * sizeof *rows);
    if (rows == NULL) {
        return -1;
    }
    self->names = rows;
    self->name_room = room;
    for (size_t i = 0; i < count; i++) {
        if (before[i].text != NULL) {
            *find_hashed(self, &before[i]) = before[i];
        }
    }
    return 0;
}

int dg_plan_names_add(struct dg_plan *self, const struct dg_plan_name *name)
{
    if (make_name_room(self) != 0) {
        return -1;
    }
    struct dg_plan_name *row = find_hashed(self, name);
    if (row->text == NULL) {
        *row = *name;
        self->name_count++;
    }
    return 0;
}

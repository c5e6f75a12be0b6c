/* SPDX-License-Identifier: MIT */
#include "wire.h"

#include <string.h>

const struct lx_wire *lx_wire_find(const char *name, size_t n)
{
    for (size_t i = 0; i < lx_wire_count; i++) {
        if (strlen(lx_wires[i].kind.name) == n && memcmp(lx_wires[i].kind.name, name, n) == 0) {
            return &lx_wires[i];
        }
    }
    return NULL;
}

/* Kinds of plans stand at the beginning of these. */
const struct lx_wire *lx_wire_of(const struct dg_plan_wire_kind *kind)
{
    return (const struct lx_wire *)(const void *)kind;
}

bool lx_wire_is_optional(const struct lx_wire *self)
{
    return self->kind.where != NULL && !self->kind.where_needed && self->kind.usual == NULL;
}

bool lx_wire_carries(const struct lx_wire *self, const struct lx_stack *stack)
{
    return dg_plan_carries(&self->kind, stack->core);
}

bool lx_wire_has(const struct lx_wire *self, const char *key)
{
    return self->kind.keys != NULL && dg_keys_find(self->kind.keys, key) != NULL;
}

/* Keys of its own, or of the port for what it carries. */
static bool offers(const struct lx_wire *self, const char *key)
{
    bool found = lx_wire_has(self, key);
    for (size_t i = 0; i < lx_stack_count; i++) {
        const struct lx_stack *stack = lx_stacks[i];
        found = found || (lx_wire_carries(self, stack) && dg_keys_find(&stack->own, key) != NULL);
    }
    return found;
}

size_t lx_wires_with(const char *key, struct lx_words *names)
{
    size_t count = 0;
    size_t own = 0;
    for (size_t i = 0; i < lx_wire_count; i++) {
        own += lx_wire_has(&lx_wires[i], key) ? 1u : 0u;
        count += offers(&lx_wires[i], key) ? 1u : 0u;
    }
    for (size_t i = 0, n = 0; own > 0 && i < lx_wire_count; i++) {
        if (offers(&lx_wires[i], key)) {
            lx_words_item(names, lx_wires[i].kind.name, n++, count, " and ");
        }
    }
    return own > 0 ? count : 0;
}

/* Which keys it has was asked when they were given to it. */
int lx_wire_settings(const struct dg_keys *keys, const struct dg_plan *plan,
                     const struct dg_plan_wire *wire, void *base, struct lx_error *error)
{
    for (size_t i = 0; i < wire->settings.count; i++) {
        const struct dg_plan_setting *setting = &wire->settings.list[i];
        const struct dg_key *key = dg_keys_find(keys, setting->key);
        if (key == NULL) {
            (void)lx_refuse(error, "leave it out", "the wire has no such key");
        }
        if (key == NULL || lx_key_set(key, base, setting->value, error) != 0) {
            return lx_plan_refuse_setting(plan, setting, error);
        }
    }
    return 0;
}

/* SPDX-License-Identifier: MIT */
#include "wire.h"

#include <string.h>

const struct lx_wire *lx_wire_of(const struct dg_plan_wire_kind *kind)
{
    size_t i = 0;
    while (strcmp(lx_wires[i].name, kind->name) != 0) {
        i++; /* each has a row; a test looks */
    }
    return &lx_wires[i];
}

bool lx_wire_is_optional(const struct dg_plan_wire_kind *kind)
{
    return kind->where != NULL && !kind->where_needed && kind->usual == NULL;
}

/* Keys of its own, or of the port for what it carries. */
static bool offers(const struct dg_plan_wire_kind *kind, const char *key)
{
    bool found = dg_plan_wire_has(kind, key);
    for (size_t i = 0; i < lx_stack_count; i++) {
        const struct lx_stack *stack = lx_stacks[i];
        found =
            found || (dg_plan_carries(kind, stack->core) && dg_keys_find(&stack->own, key) != NULL);
    }
    return found;
}

size_t lx_wires_with(const char *key, struct lx_words *names)
{
    size_t count = 0;
    size_t own = 0;
    for (size_t i = 0; i < dg_plan_wire_count; i++) {
        own += dg_plan_wire_has(&dg_plan_wires[i], key) ? 1u : 0u;
        count += offers(&dg_plan_wires[i], key) ? 1u : 0u;
    }
    for (size_t i = 0, n = 0; own > 0 && i < dg_plan_wire_count; i++) {
        if (offers(&dg_plan_wires[i], key)) {
            lx_words_item(names, dg_plan_wires[i].name, n++, count, " and ");
        }
    }
    return own > 0 ? count : 0;
}

/* Which keys it has was asked when they were given to it. */
int lx_wire_settings(const struct dg_plan *plan, const struct dg_plan_wire *wire, void *base,
                     struct lx_error *error)
{
    for (size_t i = 0; i < wire->settings.count; i++) {
        const struct dg_plan_setting *setting = &wire->settings.list[i];
        const struct dg_key *key = dg_keys_find(wire->kind->keys, setting->key);
        if (key == NULL) {
            (void)lx_refuse(error, "leave it out", "the wire has no such key");
        }
        if (key == NULL || lx_key_set(key, base, setting->value, error) != 0) {
            return lx_plan_refuse_setting(plan, setting, error);
        }
    }
    return 0;
}

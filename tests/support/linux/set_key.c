/* SPDX-License-Identifier: MIT */
#include "set_key.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

int set_key(const struct dg_device *device, void *settings, struct dg_world *world,
            const char *assignment, struct lx_error *error)
{
    struct lx_keys lists[LX_STACK_LISTS];
    char name[64] = "";
    void *base = NULL;
    const size_t n = strcspn(assignment, "=");
    (void)snprintf(name, sizeof name, "%.*s", (int)n, assignment);
    assert_int_equal(assignment[n], '=');
    lx_stack_keys(lx_stack_of(device), device, settings, world, lists);
    const struct dg_key *key = lx_keys_find(lists, LX_STACK_LISTS, name, &base);
    assert_non_null(key);
    return lx_key_set(key, base, assignment + n + 1, error);
}

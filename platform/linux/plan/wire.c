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

/* SPDX-License-Identifier: MIT */
#include "wire_list.h"

#include <stdio.h>
#include <string.h>

#include "drehgeber/rig.h"

#define KINDS_MAX 64u

const char *list_wires(unsigned media, const char *between)
{
    static char list[16u * KINDS_MAX];
    const char *names[KINDS_MAX];
    size_t count = 0;
    size_t n = 0;

    for (size_t i = 0; i < dg_plan_wire_count && count < KINDS_MAX; i++) {
        if ((dg_plan_wires[i].media & media) != 0) {
            names[count++] = dg_plan_wires[i].name;
        }
    }
    for (size_t i = 0; i < count && n < sizeof list; i++) {
        const char *before = i + 1u == count ? " or " : between;
        n += (size_t)snprintf(list + n, sizeof list - n, "%s%s", i == 0 ? "" : before, names[i]);
    }
    return list;
}

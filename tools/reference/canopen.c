/* SPDX-License-Identifier: MIT */
/*
 * Prints the object tables of src/canopen/README.md and src/cia406/README.md from the rows of the
 * dictionary itself.
 */
#include <stdio.h>
#include <string.h>

#include "../../src/cia406/cia406_private.h"
#include "co_od.h"

struct row {
    unsigned index, sub;
    const char *type;
    unsigned access;
    unsigned long initial;
    const char *name;
};

/* The short names of objects.def; slots and regions do not matter here. */
enum {
    R = DG_CO_R,
    W = DG_CO_W,
    M = DG_CO_MAP,
    I = DG_CO_ID,
    S = DG_CO_SAVE,
    V = DG_CO_SLOT,
    C = DG_CO_CONST,
    G = DG_CO_GAP,
    E = DG_CO_EVENT,
    X = DG_CO_ACTION,
    L = DG_CO_LIVE,
};

#define DG_CO_PARENT(index, kind, name) {index, 0x100, #kind, 0, 0, name},
#define DG_CO_OBJECT(index, sub, type, access, slot, region, initial, min, max, hook, name)        \
    {index, sub, #type, access, initial, name},

/* Figures of the f3668. */
#define TURN_BITS 12
#define TURNS 4096
#define RANGE 0x10000000u
#define LAST 0x0FFFFFFFu

static const struct row communication[] = {
#include "../../src/canopen/co_objects.def"
};

static const struct row encoder[] = {
#include "../../src/cia406/objects.def"
};

static void print_row(const struct row *row)
{
    static const char *const accesses[] = {"", "ro", "wo", "rw"};

    if (row->sub == 0x100) {
        printf("| %04Xh | | %s | | | | | %s |\n", row->index, row->type, row->name);
        return;
    }
    char initial[32] = "";

    if ((row->access & I) != 0 && row->initial == 0) {
        (void)snprintf(initial, sizeof initial, "node-ID");
    } else if ((row->access & L) == 0) {
        (void)snprintf(initial, sizeof initial, "%s%lXh",
                       (row->access & I) != 0 ? "node-ID + " : "", row->initial);
    }
    printf("| %04Xh | %u | %s | %s | %s | %s | %s | %s |\n", row->index, row->sub, row->type,
           (row->access & C) != 0 ? "const" : accesses[row->access & DG_CO_RW],
           (row->access & M) != 0 ? "yes" : "", (row->access & S) != 0 ? "yes" : "", initial,
           row->name);
}

int main(int argc, char **argv)
{
    const char *what = argc == 2 ? argv[1] : "";
    const bool is_encoder = strcmp(what, "encoder") == 0;
    const struct row *rows = is_encoder ? encoder : communication;
    const size_t count = is_encoder ? sizeof encoder / sizeof encoder[0]
                                    : sizeof communication / sizeof communication[0];

    if (!is_encoder && strcmp(what, "communication") != 0) {
        (void)fprintf(stderr, "usage: reference-canopen communication|encoder\n");
        return 2;
    }
    puts("| index | sub | type | access | mappable | saved | default | name |");
    puts("|---|---|---|---|---|---|---|---|");
    for (size_t i = 0; i < count; i++) {
        print_row(&rows[i]);
    }
    return 0;
}

/* SPDX-License-Identifier: MIT */
/*
 * Prints the object tables of src/canopen/README.md and src/cia406/README.md from the rows of the
 * dictionary itself. Defaults of the encoder's table are those of the f3668; `delivered` are those
 * that it has in the stack's table.
 */
#include <stdio.h>
#include <string.h>

#include "../../src/cia406/cia406_private.h"
#include "co_od.h"

struct row {
    unsigned index, sub;
    const char *type; /* NULL: as the row above, which it is alike */
    unsigned access;
    unsigned long initial;
    const char *name;
};

/* The short names of objects.def; slots, limits and hooks do not matter here. */
enum { DG_CO_SHORT_FLAGS };

#define DG_CO_PARENT(index, kind, name) {index, 0x100, #kind, 0, 0, name},
#define DG_CO_OBJECT(index, sub, more, type, access, slot, initial, limits, hook, name)            \
    {index, sub, #type, access, initial, name},
#define DG_CO_MORE(index, sub, name) {index, sub, NULL, 0, 0, name},
#define DG_CO_REPEATED(...) __VA_ARGS__

static const struct row communication[] = {
#include "../../src/canopen/co_objects.def"
};

static const struct row encoder[] = {
#include "../../src/cia406/objects.def"
};

#define COMMUNICATION DG_COUNT(communication)
#define ENCODER DG_COUNT(encoder)

/* The model's; NULL: the row's own. */
static const struct dg_co_figure *figure_of(const struct row *row)
{
    const struct dg_co_device *model = &dg_cia406_multiturn;
    const uint8_t count = row->sub <= 0xFF ? model->figure_count : 0;

    for (uint8_t i = 0; i < count; i++) {
        if (model->figures[i].key == DG_CO_KEY(row->index, row->sub)) {
            return &model->figures[i];
        }
    }
    return NULL;
}

static void print_delivered(void)
{
    puts("| index | sub | default | name |");
    puts("|---|---|---|---|");
    for (size_t i = 0; i < COMMUNICATION; i++) {
        const struct row *row = &communication[i];
        const struct dg_co_figure *figure = figure_of(row);
        if (figure != NULL) {
            printf("| %04Xh | %u | %lXh | %s |\n", row->index, row->sub,
                   (unsigned long)figure->initial, row->name);
        }
    }
}

static void print_row(const struct row *row, unsigned long value)
{
    static const char *const accesses[] = {"", "ro", "wo", "rw"};

    if (row->sub == 0x100) {
        printf("| %04Xh | | %s | | | | | %s |\n", row->index, row->type, row->name);
        return;
    }
    char initial[32] = "";

    if ((row->access & I) != 0 && value == 0) {
        (void)snprintf(initial, sizeof initial, "node-ID");
    } else if ((row->access & L) == 0) {
        (void)snprintf(initial, sizeof initial, "%s%lXh",
                       (row->access & I) != 0 ? "node-ID + " : "", value);
    }
    printf("| %04Xh | %u | %s | %s | %s | %s | %s | %s |\n", row->index, row->sub, row->type,
           (row->access & C) != 0 ? "const" : accesses[row->access & DG_CO_RW],
           (row->access & M) != 0 ? "yes" : "", (row->access & S) != 0 ? "yes" : "", initial,
           row->name);
}

static void print_objects(const struct row *rows, size_t count)
{
    struct row row = {0};

    puts("| index | sub | type | access | mappable | saved | default | name |");
    puts("|---|---|---|---|---|---|---|---|");
    for (size_t i = 0; i < count; i++) {
        const struct dg_co_figure *figure = rows == encoder ? figure_of(&rows[i]) : NULL;
        if (rows[i].type != NULL) {
            row = rows[i];
        }
        row.sub = rows[i].sub;
        row.name = rows[i].name;
        print_row(&row, figure != NULL ? figure->initial : row.initial);
    }
}

int main(int argc, char **argv)
{
    const char *what = argc == 2 ? argv[1] : "";

    if (strcmp(what, "communication") == 0) {
        print_objects(communication, COMMUNICATION);
    } else if (strcmp(what, "encoder") == 0) {
        print_objects(encoder, ENCODER);
    } else if (strcmp(what, "delivered") == 0) {
        print_delivered();
    } else {
        (void)fprintf(stderr, "usage: reference-canopen communication|encoder|delivered\n");
        return 2;
    }
    return 0;
}

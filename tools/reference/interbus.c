/* SPDX-License-Identifier: MIT */
/*
 * Prints the generated part of src/interbus/README.md from the device's own tables.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "drehgeber/interbus.h"
#include "parts.h"

#define DOC_P 1
#define DOC_C 2
enum { P = DOC_P, C = DOC_C };

struct row {
    unsigned modes;
    bool at_once;
    const char *pattern;
    const char *name;
    const char *answer;
    const char *errors;
};

#define DG_IB_COMMAND(mask, value, modes, at_once, pattern, name, handler, answer, errors)         \
    {modes, at_once, pattern, name, answer, errors},

static const struct row rows[] = {
#include "commands.def"
};

static int print_commands(void)
{
    static const char *const modes[] = {"", "position, speed", "cam", "all"};

    puts("| OUT | command | modes | answered after | answer | own errors |");
    puts("|---|---|---|---|---|---|");
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct row *row = &rows[i];
        printf("| `%s` | %s | %s | %s | %s%s%s | %s |\n", row->pattern, row->name,
               modes[row->modes], row->at_once ? "1 cycle" : "t_param", row->at_once ? "" : "`",
               row->answer, row->at_once ? "" : "`", row->errors);
    }
    return 0;
}

static int print_regions(void)
{
    puts("| region | bytes | damage at start-up | address |");
    puts("|---|---|---|---|");
    for (unsigned i = 0; i < dg_ib_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_ib_layout.regions[i];
        printf("| %s | %u | %s | %04Xh |\n", region->name, region->size,
               region->startup_code != 0 ? "86000000h" : "starts at 0",
               (unsigned)dg_store_address(&dg_ib_layout, (uint8_t)i));
    }
    return 0;
}

int main(int argc, char **argv)
{
    static const struct part parts[] = {
        {"commands", print_commands},
        {"regions", print_regions},
    };
    return print_one(argc, argv, parts, DG_COUNT(parts));
}

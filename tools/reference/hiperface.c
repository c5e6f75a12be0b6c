/* SPDX-License-Identifier: MIT */
/*
 * Prints the generated part of src/hiperface/README.md from the device's own tables.
 */
#include <stdio.h>

#include "hiperface_private.h"
#include "parts.h"

#define DOC_C 1
/* Of the flags only Code 0 has a column; the locks show in the error conditions. */
enum { C = DOC_C, P = 0, D = 0, U = 0, K = 0, W = 0, E = 0, S = 0 };

struct row {
    unsigned code;
    const char *name;
    unsigned min, max, reply, reaction_ms, flags;
    const char *errors;
};

#define DG_HF_COMMAND(code, name, min, max, reply, reaction_ms, flags, handler, errors)            \
    {code, name, min, max, reply, reaction_ms, flags, errors},

static const struct row rows[] = {
#include "commands.def"
};

static void print_length(char *to, size_t size, unsigned min, unsigned max)
{
    if (min == max) {
        (void)snprintf(to, size, "%u", min);
    } else {
        (void)snprintf(to, size, "%u-%u", min, max);
    }
}

static int print_commands(void)
{
    puts("| code | command | request | reply | reaction max | Code 0 | own errors |");
    puts("|---|---|---|---|---|---|---|");
    for (size_t i = 0; i < DG_COUNT(rows); i++) {
        const struct row *row = &rows[i];
        char request[16];
        char reaction[16];
        print_length(request, sizeof request, row->min, row->max);
        (void)snprintf(reaction, sizeof reaction, "%u ms", row->reaction_ms);
        printf("| %02Xh | %s | %s | %s%u | %s | %s | %s |\n", row->code, row->name, request,
               row->code == 0x4A ? "4-" : "", row->reply,
               row->reaction_ms == 0 ? "no reply" : reaction, (row->flags & DOC_C) ? "yes" : "",
               row->errors);
    }
    return 0;
}

static int print_regions(void)
{
    puts("| region | bytes | checked | damage at start-up | address |");
    puts("|---|---|---|---|---|");
    for (unsigned i = 0; i < dg_hf_layout.region_count; i++) {
        const struct dg_store_region *region = &dg_hf_layout.regions[i];
        char code[16] = "";
        if (region->startup_code != 0) {
            (void)snprintf(code, sizeof code, "%02Xh, 06h", region->startup_code);
        }
        printf("| %s | %u | %s | %s | %04Xh |\n", region->name, region->size,
               region->check == DG_STORE_CHECKED ? "yes" : "no", code,
               (unsigned)dg_store_address(&dg_hf_layout, (uint8_t)i));
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

/* SPDX-License-Identifier: MIT */
/*
 * Prints the generated part of src/control/README.md from the command table and the catalogue.
 */
#include <stdio.h>
#include <string.h>

#include "drehgeber/biss.h"
#include "drehgeber/cia406.h"
#include "drehgeber/control.h"
#include "drehgeber/hiperface.h"
#include "drehgeber/interbus.h"

static void print_commands(void)
{
    puts("| command | parameters | query | what |");
    puts("|---|---|---|---|");
    for (size_t i = 0; i < dg_control_command_count; i++) {
        const struct dg_scpi_command *row = &dg_control_commands[i];
        const char *quote = row->parameters[0] != '\0' ? "`" : "";
        char parameters[80] = "";
        /* A bar would end the column. */
        for (size_t n = 0, k = 0; row->parameters[k] != '\0' && n + 3 < sizeof parameters; k++) {
            if (row->parameters[k] == '|') {
                parameters[n++] = '\\';
            }
            parameters[n++] = row->parameters[k];
            parameters[n] = '\0';
        }
        printf("| `%s` | %s%s%s | %s | %s |\n", row->header, quote, parameters, quote,
               row->query == NULL ? ""
               : row->set == NULL ? "only"
                                  : "yes",
               row->help);
    }
}

static const char *kind_of(enum dg_fault_kind kind)
{
    static const char *const names[] = {
        [DG_FAULT_WORLD] = "world",
        [DG_FAULT_MEMORY] = "memory",
        [DG_FAULT_WIRE] = "wire",
    };

    return names[kind];
}

static void print_faults(const struct dg_stack *stack, const struct dg_store_layout *layout)
{
    const struct dg_fault_target target = {.stack = stack, .layout = layout};
    struct dg_fault_entry entry;

    puts("| name | kind | cause | what the device does | source |");
    puts("|---|---|---|---|---|");
    for (size_t i = 0; dg_fault_entry(&target, i, &entry); i++) {
        printf("| `%s` | %s | %s | %s | %s |\n", entry.name, kind_of(entry.kind), entry.cause,
               entry.effect, entry.chapter);
    }
}

int main(int argc, char **argv)
{
    const struct {
        const char *name;
        const struct dg_stack *stack;
        const struct dg_store_layout *layout;
    } stacks[] = {
        {"hiperface", &dg_hf_stack, &dg_hf_layout},
        {"biss", &dg_biss_stack, &dg_biss_layout},
        {"canopen", &dg_cia406_stack, dg_cia406_multiturn.layout},
        {"interbus", &dg_ib_stack, &dg_ib_layout},
    };

    if (argc == 2 && strcmp(argv[1], "commands") == 0) {
        print_commands();
        return 0;
    }
    for (size_t i = 0; argc == 2 && i < sizeof stacks / sizeof stacks[0]; i++) {
        if (strcmp(argv[1], stacks[i].name) == 0) {
            print_faults(stacks[i].stack, stacks[i].layout);
            return 0;
        }
    }
    (void)fprintf(stderr, "usage: reference-control commands|hiperface|biss|canopen|interbus\n");
    return 2;
}
